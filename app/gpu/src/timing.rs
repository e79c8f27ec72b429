//! GPU time of a frame by timestamp queries, read without ever waiting.
//!
//! A measurement goes round: recorded into a frame's commands, mapped when the next frame begins
//! (the commands are submitted by then), read when the device says it is ready.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

const IDLE: u8 = 0;
const RECORDED: u8 = 1;
const MAPPING: u8 = 2;
const READY: u8 = 3;
const FAILED: u8 = 4;

/// Measures one frame at a time.
#[derive(Debug)]
pub struct FrameTimer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readable: wgpu::Buffer,
    period_ns: f64,
    state: Arc<AtomicU8>,
    /// Pixels of the frame that is being measured.
    pixels: u64,
    latest: Option<FrameTime>,
}

/// What a frame took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameTime {
    /// Milliseconds on the device.
    pub gpu_ms: f64,
    /// Pixels of its picture.
    pub pixels: u64,
    /// How many frames had been measured before, by which a new measurement is told from an old one.
    pub number: u64,
}

impl FrameTimer {
    /// A timer, where the device has timestamps.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Option<Self> {
        if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        let buffer = |label, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: 16,
                usage,
                mapped_at_creation: false,
            })
        };
        Some(Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timing/queries"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: buffer(
                "timing/resolved",
                wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            ),
            readable: buffer(
                "timing/readable",
                wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            ),
            period_ns: f64::from(queue.get_timestamp_period()),
            state: Arc::new(AtomicU8::new(IDLE)),
            pixels: 0,
            latest: None,
        })
    }

    /// Moves a measurement on; call once at the beginning of a frame.
    pub fn advance(&mut self) {
        match self.state.load(Ordering::Acquire) {
            RECORDED => {
                self.state.store(MAPPING, Ordering::Release);
                let state = Arc::clone(&self.state);
                self.readable
                    .map_async(wgpu::MapMode::Read, .., move |result| {
                        state.store(
                            if result.is_ok() { READY } else { FAILED },
                            Ordering::Release,
                        );
                    });
            }
            READY => {
                if let Ok(bytes) = self.readable.get_mapped_range(..) {
                    let ticks: &[u64] = bytemuck::cast_slice(&bytes);
                    let elapsed = ticks[1].saturating_sub(ticks[0]);
                    self.latest = Some(FrameTime {
                        gpu_ms: elapsed as f64 * self.period_ns / 1e6,
                        pixels: self.pixels,
                        number: self.latest.map_or(0, |before| before.number + 1),
                    });
                }
                self.readable.unmap();
                self.state.store(IDLE, Ordering::Release);
            }
            _ => {}
        }
    }

    /// The queries, if this frame is to be measured: 0 for the beginning, 1 for the end.
    pub fn queries(&self) -> Option<&wgpu::QuerySet> {
        (self.state.load(Ordering::Acquire) == IDLE).then_some(&self.queries)
    }

    /// Ends the measurement of a frame of so many pixels whose passes wrote [`Self::queries`].
    pub fn record(&mut self, encoder: &mut wgpu::CommandEncoder, pixels: u64) {
        self.pixels = pixels;
        encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.readable, 0, 16);
        self.state.store(RECORDED, Ordering::Release);
    }

    /// The latest measured frame.
    pub fn latest(&self) -> Option<FrameTime> {
        self.latest
    }
}
