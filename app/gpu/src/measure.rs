//! Evaluates the shaders' map transform and choice of levels on the device, to measure its error
//! and to compare them with their twins.

use glam::{DVec2, Vec2};
use relievo_engine::planet::MapPoint;
use relievo_engine::planet::clipmap::choose::{LevelChoice, LevelView};
use relievo_engine::planet::clipmap::rings::KAPPA;
use relievo_engine::planet::transform::{FocusFrame, RingVertex, map_delta_f64};
use relievo_shaders::Entry;
use relievo_shaders::layout::{LEVEL_SLOTS, LevelUniform, MAX_LEVELS, MeasureInput};
use wgpu::util::DeviceExt;

use crate::bind;
use crate::device::Gpu;
use crate::readback::{self, ReadError};

/// The measuring pipelines. Immutable.
#[derive(Debug)]
pub struct TransformMeter {
    measure: wgpu::ComputePipeline,
    choose: wgpu::ComputePipeline,
}

/// A place and the size it is seen at, for which levels are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChoiceQuery {
    /// Δφ, Δθ from the focus, radians.
    pub delta_rad: Vec2,
    /// Footprint of the fragment, radians.
    pub footprint_rad: f32,
    /// Index of the ring's level minus the vertex's rim weight.
    pub level_minus_rim: f32,
}

impl TransformMeter {
    /// The meter on a device.
    pub fn new(device: &wgpu::Device) -> Self {
        let module = bind::module(device, Entry::Measure);
        let pipeline = |entry| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("measure/pipeline"),
                layout: None,
                module: &module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        Self {
            measure: pipeline("measure"),
            choose: pipeline("choose"),
        }
    }

    /// (Δφ, Δθ) in radians of vertices (u, v, 1 − w) around a focus, as the device computes them.
    ///
    /// # Errors
    /// If the device is lost.
    ///
    /// # Panics
    /// With more than a million vertices.
    pub fn map_deltas(
        &self,
        gpu: &Gpu,
        vertices: &[[f32; 3]],
        sin_cos_colat: Vec2,
    ) -> Result<Vec<Vec2>, ReadError> {
        let queries: Vec<[f32; 4]> = vertices.iter().map(|[u, v, w]| [*u, *v, *w, 0.0]).collect();
        let input = MeasureInput {
            sin_cos_colat: sin_cos_colat.to_array(),
            ..MeasureInput::default()
        };
        let results = evaluate(gpu, &self.measure, input, &queries, 1, None)?;
        Ok(results
            .into_iter()
            .map(|[lon, colat, ..]| Vec2::new(lon, colat))
            .collect())
    }

    /// The levels that the device chooses, for a colour and for a height.
    ///
    /// # Errors
    /// If the device is lost.
    ///
    /// # Panics
    /// With more than a million queries or too many levels.
    pub fn choices(
        &self,
        gpu: &Gpu,
        levels: &[LevelView],
        queries: &[ChoiceQuery],
    ) -> Result<Vec<[Option<LevelChoice>; 2]>, ReadError> {
        assert!(levels.len() <= MAX_LEVELS, "at most {MAX_LEVELS} levels");
        let mut slots = vec![LevelUniform::default(); LEVEL_SLOTS];
        for (slot, level) in slots.iter_mut().zip(levels) {
            *slot = LevelUniform::new(level, [256; 2], 0);
        }
        let queries: Vec<[f32; 4]> = queries
            .iter()
            .map(|q| {
                [
                    q.delta_rad.x,
                    q.delta_rad.y,
                    q.footprint_rad,
                    q.level_minus_rim,
                ]
            })
            .collect();
        let input = MeasureInput {
            levels: levels.len() as u32,
            ..MeasureInput::default()
        };
        let results = evaluate(gpu, &self.choose, input, &queries, 2, Some(&slots))?;
        let choice = |[fine, coarse, coarse_weight, some]: [f32; 4]| {
            (some > 0.0).then_some(LevelChoice {
                fine: fine as usize,
                coarse: coarse as usize,
                coarse_weight,
            })
        };
        Ok(results
            .chunks_exact(2)
            .map(|pair| [choice(pair[0]), choice(pair[1])])
            .collect())
    }

    /// Largest error on the ground of the transform on this device, as a part of the radius of
    /// ring `level`, over a polar grid of `azimuths` × `radii` vertices around a focus.
    ///
    /// The truth is computed in f64 from the very f32 vertices and the focus' exact colatitude.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn worst_error(
        &self,
        gpu: &Gpu,
        colat_rad: f64,
        level: u8,
        azimuths: u32,
        radii: u32,
    ) -> Result<f64, ReadError> {
        let frame = FocusFrame::new(MapPoint::new(0.0, colat_rad));
        let ring_rad = KAPPA * core::f64::consts::PI / f64::from(1_u32 << level);
        let vertices: Vec<[f32; 3]> = (0..radii)
            .flat_map(|j| (0..azimuths).map(move |k| (j, k)))
            .map(|(j, k)| {
                let angle = ring_rad * (1.0 - 0.5 * f64::from(j) / f64::from(radii));
                let azimuth = (f64::from(k) + 0.37) / f64::from(azimuths) * core::f64::consts::TAU;
                RingVertex::from_polar(angle, azimuth).to_f32()
            })
            .collect();
        let found = self.map_deltas(gpu, &vertices, frame.sin_cos_f32())?;
        let worst = vertices.iter().zip(found).map(|(vertex, found)| {
            let [u, v, one_minus_w] = vertex.map(f64::from);
            let truth = map_delta_f64(
                RingVertex { u, v, one_minus_w },
                frame.sin_colat,
                frame.cos_colat,
            );
            ground_distance(colat_rad, truth, found.as_dvec2())
        });
        Ok(worst.fold(0.0, f64::max) / ring_rad)
    }
}

/// Runs a pipeline over queries; `results` vectors come back for each.
fn evaluate(
    gpu: &Gpu,
    pipeline: &wgpu::ComputePipeline,
    input: MeasureInput,
    queries: &[[f32; 4]],
    results: u64,
    levels: Option<&[LevelUniform]>,
) -> Result<Vec<[f32; 4]>, ReadError> {
    assert!(
        queries.len() <= 1_000_000,
        "at most a million queries at once"
    );
    if queries.is_empty() {
        return Ok(Vec::new());
    }
    let device = &gpu.device;
    let buffer = |label, contents: &[u8], usage| {
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some(label),
            contents,
            usage,
        })
    };
    let input = MeasureInput {
        count: queries.len() as u32,
        ..input
    };
    let input = buffer(
        "measure/input",
        bytemuck::bytes_of(&input),
        wgpu::BufferUsages::UNIFORM,
    );
    let stored = buffer(
        "measure/queries",
        bytemuck::cast_slice(queries),
        wgpu::BufferUsages::STORAGE,
    );
    let levels = levels.map(|l| {
        buffer(
            "measure/levels",
            bytemuck::cast_slice(l),
            wgpu::BufferUsages::UNIFORM,
        )
    });
    let found = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("measure/results"),
        size: stored.size() * results,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let mut entries = vec![
        bind::whole(0, &input),
        bind::whole(1, &stored),
        bind::whole(2, &found),
    ];
    entries.extend(levels.as_ref().map(|levels| bind::whole(3, levels)));
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("measure/group"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor {
        label: Some("measure/encoder"),
    });
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups((queries.len() as u32).div_ceil(64), 1, 1);
    }
    gpu.queue.submit([encoder.finish()]);
    let bytes = readback::contents(device, &gpu.queue, &found)?;
    Ok(bytemuck::pod_collect_to_vec(&bytes))
}

/// Distance on the unit sphere between two places given relative to a focus.
fn ground_distance(colat_rad: f64, a: DVec2, b: DVec2) -> f64 {
    // For places this near the local metric is exact enough; at a pole longitudes do not count.
    let lon = relievo_engine::planet::map::wrap_longitude(a.x - b.x);
    let sin_colat = (colat_rad + a.y).sin();
    (lon * sin_colat).hypot(a.y - b.y)
}
