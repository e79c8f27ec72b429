//! Writing a region as OpenEXR.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use parking_lot::Mutex;
use relievo_graph::RenderError;
use relievo_raster::write::{ExrLayout, ExrSamples, write_exr};
use relievo_raster::{Block, Cancel, PixelRect};

use super::{BLOCK, Bake, BakeError, Output, Plan};
use crate::query::Questions;

/// Blocks made ahead for each thread, so that none waits for the slowest of a few.
const AHEAD: usize = 4;

impl Questions {
    /// Writes tiles as they are made; some blocks a thread are made ahead, whatever the width.
    pub(super) fn bake_exr(
        &self,
        bake: &Bake,
        plan: &Plan,
        path: &Path,
        threads: usize,
        progress: &mut dyn FnMut(f64),
        cancel: &Cancel,
    ) -> Result<(), BakeError> {
        let layout = ExrLayout {
            width: plan.width,
            height: plan.height,
            samples: match bake.output {
                Output::Height => ExrSamples::Height,
                Output::Colour => ExrSamples::Colour,
                Output::Normal => ExrSamples::Normal,
            },
            tile: BLOCK,
            georeference: Some(plan.georeference.clone()),
        };
        let threads = threads.max(1);
        let mut ready: Vec<(PixelRect, Block)> = Vec::new();
        let mut source = |rect: PixelRect, out: &mut Block| {
            if !ready.iter().any(|(r, _)| *r == rect) {
                let columns = (plan.width - rect.x).div_ceil(BLOCK) as usize;
                let rects: Vec<PixelRect> = (0..columns.min(threads * AHEAD) as u32)
                    .map(|n| {
                        let x = rect.x + n * BLOCK;
                        PixelRect {
                            x,
                            width: BLOCK.min(plan.width - x),
                            ..rect
                        }
                    })
                    .collect();
                ready = self.blocks(plan, &rects, threads, cancel)?;
            }
            if let Some(at) = ready.iter().position(|(r, _)| *r == rect) {
                *out = ready.swap_remove(at).1;
            }
            Ok(())
        };
        Ok(write_exr(path, &layout, &mut source, progress, cancel)?)
    }

    /// Blocks of some rectangles, made on several threads.
    fn blocks(
        &self,
        plan: &Plan,
        rects: &[PixelRect],
        threads: usize,
        cancel: &Cancel,
    ) -> Result<Vec<(PixelRect, Block)>, RenderError> {
        type Made = Vec<Option<Result<Block, RenderError>>>;
        let made: Mutex<Made> = Mutex::new(rects.iter().map(|_| None).collect());
        let next = AtomicUsize::new(0);
        let work = || {
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let Some(rect) = rects.get(index) else {
                    return;
                };
                let block = self.block(plan, *rect, cancel);
                made.lock()[index] = Some(block);
            }
        };
        std::thread::scope(|scope| {
            for n in 1..threads.min(rects.len()) {
                let name = format!("relievo-bake-{n}");
                // With fewer threads than asked for the work takes longer; nothing else changes.
                if let Err(error) = std::thread::Builder::new()
                    .name(name)
                    .spawn_scoped(scope, work)
                {
                    tracing::warn!("bakes on fewer threads: {error}");
                }
            }
            work();
        });
        rects
            .iter()
            .zip(made.into_inner())
            .map(|(rect, block)| Ok((*rect, block.unwrap_or(Err(RenderError::Cancelled))?)))
            .collect()
    }
}
