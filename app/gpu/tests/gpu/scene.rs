//! A synthetic planet: hills and colours from formulas, planned and tiled as the engine does it.

use std::sync::{Arc, OnceLock};

use glam::{DVec2, DVec3, I64Vec2};
use relievo_engine::planet::clipmap::choose::LevelView as ShaderView;
use relievo_engine::planet::clipmap::valid::{COLOUR_FILTER_MARGIN, HEIGHT_FILTER_MARGIN};
use relievo_engine::planet::clipmap::{
    HeightRange, LevelPlan, PlanInput, Planner, Quality as PlanQuality, valid_rect,
};
use relievo_engine::planet::{Camera, MapPoint, Planet, TILE_SAMPLES, TileKey};
use relievo_engine::raster::{Bands, Block, SampleType, Tile, normal};
use relievo_engine::{ClipKind, Frame, LevelView, Sun, Upload};
use relievo_gpu::{FrameStats, Gpu, Picture, Quality, Renderer};

/// The device of all tests.
pub(crate) fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| {
        Gpu::headless().expect("these tests need a graphics adapter; a software one will do")
    })
}

/// A planet made of formulas over the unit vector of a place.
#[derive(Clone, Copy)]
pub(crate) struct World {
    pub(crate) planet: Planet,
    /// Heights in metres.
    pub(crate) height: fn(DVec3) -> f64,
    /// sRGB encoded colour, 0 to 1; `None` for no colour source.
    pub(crate) colour: Option<fn(DVec3) -> [f32; 3]>,
    /// Whether the ground is lit.
    pub(crate) lit: bool,
    /// Bounds of the heights.
    pub(crate) range: HeightRange,
}

/// A camera over a place in degrees, heading and pitch in degrees.
pub(crate) fn camera(lon: f64, lat: f64, altitude_m: f64, heading: f64, pitch: f64) -> Camera {
    Camera {
        lon_rad: lon.to_radians(),
        lat_rad: lat.to_radians(),
        altitude_m,
        heading_rad: heading.to_radians(),
        pitch_rad: pitch.to_radians(),
        fov_y_rad: 60.0_f64.to_radians(),
    }
}

/// The quality that tests draw with.
pub(crate) fn quality() -> Quality {
    Quality::for_adapter(relievo_gpu::AdapterClass::Software)
}

/// A frame of the world with everything uploaded that the view wants.
pub(crate) fn frame(world: &World, camera: Camera, viewport_px: [u32; 2], sun: Sun) -> Frame {
    let quality = quality();
    let ground_m = (world.height)(camera.map_point().to_unit());
    let plan = Planner::new().plan(&PlanInput {
        camera,
        planet: world.planet,
        viewport_px,
        ground_m,
        terrain: &world.range,
        exaggeration: 1.0,
        quality: PlanQuality {
            layout: quality.layout,
            colour_samples: quality.colour_window,
            ..PlanQuality::default()
        },
    });
    let mut frame = Frame {
        revision: 1,
        planet: world.planet,
        exaggeration: 1.0,
        camera,
        viewport_px,
        near_m: (plan.clearance_m * 0.25).max(0.05),
        height_window: quality.layout.height_window,
        colour_window: quality.colour_window,
        heights: Vec::new(),
        colours: Vec::new(),
        normals: Vec::new(),
        sun,
        masses: Vec::new(),
        uploads: Vec::new(),
        air: 1.0,
        pending: 0,
        plan: Arc::new(plan),
    };
    let plan = Arc::clone(&frame.plan);
    let mut uploads = Vec::new();
    frame.heights = stack(
        world,
        ClipKind::Height,
        &plan.heights,
        HEIGHT_FILTER_MARGIN,
        &mut uploads,
    );
    if world.colour.is_some() {
        frame.colours = stack(
            world,
            ClipKind::Colour,
            &plan.colours,
            COLOUR_FILTER_MARGIN,
            &mut uploads,
        );
    }
    if world.lit {
        frame.normals = stack(
            world,
            ClipKind::Normal,
            &plan.colours,
            COLOUR_FILTER_MARGIN,
            &mut uploads,
        );
    }
    frame.uploads = uploads;
    frame
}

fn stack(
    world: &World,
    kind: ClipKind,
    plans: &[LevelPlan],
    margin: f64,
    uploads: &mut Vec<Upload>,
) -> Vec<LevelView> {
    let mut levels = Vec::new();
    for (layer, plan) in plans.iter().enumerate() {
        let wanted = plan.wanted_tiles();
        for key in &wanted {
            let tile = Arc::new(tile(world, kind, *key));
            for piece in plan.window.upload_pieces(*key, &plan.window.rect) {
                uploads.push(Upload {
                    clipmap: kind,
                    layer: layer as u32,
                    storage: piece.storage.as_uvec2().to_array(),
                    tile: Arc::clone(&tile),
                    source: piece.in_tile.min.as_uvec2().to_array(),
                    size: [piece.in_tile.width() as u32, piece.in_tile.height() as u32],
                });
            }
        }
        let valid = valid_rect(plan, |key| wanted.contains(&key));
        levels.push(LevelView {
            layer: layer as u32,
            window: plan.window,
            view: ShaderView::new(plan, &valid, Some(&valid), 1.0, margin),
        });
    }
    levels
}

fn tile(world: &World, kind: ClipKind, key: TileKey) -> Tile {
    let side = TILE_SAMPLES as usize;
    let (lattice, rect) = (key.level.lattice(), key.rect());
    let bands = match kind {
        ClipKind::Height => (Bands::Height, SampleType::Height),
        ClipKind::Colour => (Bands::Colour, SampleType::Rgba8),
        ClipKind::Normal => (Bands::Normal, SampleType::Normal),
    };
    let mut block = Block::new(bands.0, side, side);
    for j in 0..side {
        for i in 0..side {
            let point = lattice.map_point(rect.min + I64Vec2::new(i as i64, j as i64));
            let mut put = |plane: usize, value: f32| block.plane_mut(plane)[j * side + i] = value;
            match kind {
                ClipKind::Height => put(0, (world.height)(point.to_unit()) as f32),
                ClipKind::Colour => {
                    let rgb = world.colour.expect("a world with colours")(point.to_unit());
                    for (plane, value) in rgb.into_iter().enumerate() {
                        put(plane, value);
                    }
                    put(3, 1.0);
                }
                ClipKind::Normal => {
                    let normal = normal(world, point, key.level.step_rad().y);
                    put(0, normal[0]);
                    put(1, normal[1]);
                }
            }
        }
    }
    Tile::from_block(&block, bands.1)
}

/// Coordinates of the normal by differences over one sample.
fn normal(world: &World, point: MapPoint, step_rad: f64) -> [f32; 2] {
    let at = relievo_engine::planet::clipmap::view::FocusFrame::at(point);
    let height = |d: DVec3| (world.height)((at.up + d * step_rad).normalize());
    let run_m = 2.0 * step_rad * world.planet.radius_m;
    let slope = DVec2::new(
        height(at.east) - height(-at.east),
        height(-at.south) - height(at.south),
    ) / run_m;
    normal::coordinates((-slope).extend(1.0))
}

/// Draws a frame with a renderer and waits for the picture.
pub(crate) fn draw(renderer: &mut Renderer, frame: &Frame) -> (Picture, FrameStats) {
    let mut encoder = gpu()
        .device
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let stats = renderer
        .render(frame, &mut encoder)
        .expect("a good frame is drawn");
    gpu().queue.submit([encoder.finish()]);
    (renderer.read_back().expect("the device is there"), stats)
}

/// A fresh renderer.
pub(crate) fn renderer() -> Renderer {
    Renderer::new(gpu(), wgpu::TextureFormat::Rgba8Unorm, quality())
        .expect("a mesh of whole sectors")
}

/// A sun at an azimuth and elevation in degrees over the camera.
pub(crate) fn sun(camera: &Camera, azimuth: f64, elevation: f64) -> Sun {
    let at = relievo_engine::planet::clipmap::view::FocusFrame::at(camera.map_point());
    let (sin_az, cos_az) = azimuth.to_radians().sin_cos();
    let (sin_el, cos_el) = elevation.to_radians().sin_cos();
    let direction_in_world = (at.east * sin_az - at.south * cos_az) * cos_el + at.up * sin_el;
    Sun {
        direction_in_world,
        ambient: 0.35,
    }
}

/// Hills that are smooth at every scale: waves of 500 km and 60 km on a sphere of Earth's size.
pub(crate) fn smooth_hills(p: DVec3) -> f64 {
    let wide = (p.x * 80.0).sin() * (p.y * 70.0 + 1.0).sin() + (p.z * 90.0).cos();
    let near = (p.x * 610.0 + 2.0).sin() * (p.y * 640.0).cos() * (p.z * 590.0 + 0.5).cos();
    900.0 * wide + 350.0 * near
}

/// Bounds of [`smooth_hills`].
pub(crate) const SMOOTH_RANGE: HeightRange = HeightRange {
    min_m: -2150.0,
    max_m: 2150.0,
};

/// Colours without any edge.
pub(crate) fn smooth_colour(p: DVec3) -> [f32; 3] {
    [
        0.5 + 0.3 * (p.x * 9.0).sin(),
        0.5 + 0.3 * (p.y * 8.0).cos(),
        0.5 + 0.3 * (p.z * 10.0 + 1.0).sin(),
    ]
    .map(|c: f64| c as f32)
}
