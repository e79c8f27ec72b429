//! Draws frames: uploads, displacement, terrain, bodies, sky, into a picture of its own.
//!
//! Invariant: a frame is drawn from one [`Frame`] only; what is on the device after it is a
//! function of all uploads so far. Absent: projects, tiles, windows; submission is the caller's.

use glam::{DVec2, DVec3};
use relievo_engine::planet::MapPoint;
use relievo_engine::planet::clipmap::rings::MeshStepsError;
use relievo_engine::planet::clipmap::view::View;
use relievo_engine::{ClipKind, Frame, LevelView};
use relievo_shaders::layout::{COLOUR_SLOT, FrameUniform};

use crate::blit::BlitPass;
use crate::clipmap_textures::{ClipmapTexture, UploadError};
use crate::device::{Gpu, LossWatch};
use crate::displace::{DisplaceGroup, DisplacePass};
use crate::frame_group::FrameGroup;
use crate::masses::MassPass;
use crate::memory::{self, OutOfMemory};
use crate::mesh::{MeshBuffers, MeshSelection};
use crate::quality::{Look, Quality};
use crate::readback::{self, Picture, ReadError};
use crate::sky::SkyPass;
use crate::stats::FrameStats;
use crate::targets::{self, Targets};
use crate::terrain::{TerrainKey, TerrainPass};
use crate::timing::FrameTimer;
use crate::uniforms::{LevelUniforms, frame_uniform, level_uniforms, shares_levels};

/// Why a frame is not drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RenderError {
    /// The device is gone. Open another, take [`Renderer::rebuilt`] on it and have everything
    /// uploaded again.
    #[error("the graphics device was lost")]
    DeviceLost,
    /// The device has no room for the frame's windows or its picture. Take a renderer of less
    /// quality and have everything uploaded again.
    #[error(transparent)]
    OutOfMemory(#[from] OutOfMemory),
    /// An upload breaks the contract of [`Frame`].
    #[error(transparent)]
    Upload(#[from] UploadError),
}

/// What a pixel shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PickedPoint {
    /// World position, metres.
    pub position_in_world: DVec3,
    /// The map point below it.
    pub point: MapPoint,
    /// Its height above the sphere as drawn (exaggerated), metres.
    pub height_m: f64,
}

/// What decided the picture that is on the targets now.
#[derive(Debug)]
struct Drawn {
    frame: FrameUniform,
    levels: Box<LevelUniforms>,
    selection: MeshSelection,
    view: View,
    near_m: f64,
    radius_m: f64,
    key: TerrainKey,
}

/// Everything that one view needs on a device.
#[derive(Debug)]
pub struct Renderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    loss: LossWatch,
    quality: Quality,
    look: Look,
    rests: bool,
    target_format: wgpu::TextureFormat,
    frame_group: FrameGroup,
    displace: DisplacePass,
    terrain: TerrainPass,
    masses: MassPass,
    sky: SkyPass,
    blit: BlitPass,
    mesh: MeshBuffers,
    heights: ClipmapTexture,
    colours: ClipmapTexture,
    normals: ClipmapTexture,
    displace_group: DisplaceGroup,
    terrain_group: wgpu::BindGroup,
    targets: Targets,
    blit_group: wgpu::BindGroup,
    timer: Option<FrameTimer>,
    drawn: Option<Drawn>,
}

impl Renderer {
    /// A renderer whose picture can be shown in targets of `target_format`.
    ///
    /// # Errors
    /// If the quality's mesh cannot be cut into sectors.
    pub fn new(
        gpu: &Gpu,
        target_format: wgpu::TextureFormat,
        quality: Quality,
    ) -> Result<Self, MeshStepsError> {
        let device = &gpu.device;
        let mesh = MeshBuffers::new(device, &quality)?;
        let frame_group = FrameGroup::new(device);
        let displace = DisplacePass::new(device, frame_group.layout());
        let terrain = TerrainPass::new(device, frame_group.layout());
        let masses = MassPass::new(device, frame_group.layout());
        let sky = SkyPass::new(device, frame_group.layout());
        let blit = BlitPass::new(device, target_format);
        // Bound while a scene has none of a kind; the first levels replace them.
        let empty = |kind| ClipmapTexture::new(device, kind, 1, 1);
        let [heights, colours, normals] =
            [ClipKind::Height, ClipKind::Colour, ClipKind::Normal].map(empty);
        let targets = Targets::new(device, [1, 1]);
        Ok(Self {
            displace_group: displace.bind(device, heights.view(), &mesh),
            terrain_group: terrain.bind(device, colours.view(), normals.view()),
            blit_group: blit.bind(device, targets.colour_view()),
            timer: FrameTimer::new(device, &gpu.queue),
            device: device.clone(),
            queue: gpu.queue.clone(),
            loss: gpu.loss.clone(),
            quality,
            look: Look::default(),
            rests: true,
            target_format,
            frame_group,
            displace,
            terrain,
            masses,
            sky,
            blit,
            mesh,
            heights,
            colours,
            normals,
            targets,
            drawn: None,
        })
    }

    /// A renderer whose pictures no window shows.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn offscreen(gpu: &Gpu, quality: Quality) -> Result<Self, MeshStepsError> {
        Self::new(gpu, targets::COLOUR_FORMAT, quality)
    }

    /// As [`Self::render`], submitted at once.
    ///
    /// # Errors
    /// As [`Self::render`].
    pub fn render_now(&mut self, frame: &Frame) -> Result<FrameStats, RenderError> {
        let label = Some("renderer/now");
        let mut encoder = self
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor { label });
        let drawn = self.render(frame, &mut encoder)?;
        self.queue.submit([encoder.finish()]);
        Ok(drawn)
    }

    /// The same renderer on another device, after the loss of its own. It holds no samples: the
    /// engine has to send everything again.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn rebuilt(&self, gpu: &Gpu) -> Result<Self, MeshStepsError> {
        let mut renderer = Self::new(gpu, self.target_format, self.quality)?;
        renderer.look = self.look;
        Ok(renderer)
    }

    /// The quality it draws with.
    pub fn quality(&self) -> Quality {
        self.quality
    }

    /// Changes what is spent, from the next frame on. Samples on the device stay; windows change as
    /// frames do. A mesh of other steps is made at once, on the calling thread.
    ///
    /// # Errors
    /// As [`Self::new`]; everything stays as it was.
    pub fn set_quality(&mut self, quality: Quality) -> Result<(), MeshStepsError> {
        let mesh = |q: &Quality| (q.azimuth_steps, q.radial_steps, q.layout);
        if mesh(&quality) != mesh(&self.quality) {
            self.mesh = MeshBuffers::new(&self.device, &quality)?;
            self.displace_group = self
                .displace
                .bind(&self.device, self.heights.view(), &self.mesh);
            self.drawn = None;
        }
        self.quality = quality;
        Ok(())
    }

    /// How air and light look.
    pub fn look(&self) -> Look {
        self.look
    }

    /// Changes how air and light look, from the next frame on.
    pub fn set_look(&mut self, look: Look) {
        self.look = look;
    }

    /// Says whether the picture rests, from the next frame on: a quality that spares the blending of
    /// levels does so in motion only. It rests at first.
    pub fn set_rests(&mut self, rests: bool) {
        self.rests = rests;
    }

    /// Stores a frame's uploads and draws it into the renderer's own picture. The commands take
    /// effect when the caller submits `encoder`, which must be before the next call.
    ///
    /// # Errors
    /// If the device is lost, or an upload does not fit; the picture then stays as it was.
    pub fn render(
        &mut self,
        frame: &Frame,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<FrameStats, RenderError> {
        if self.loss.is_lost() {
            return Err(RenderError::DeviceLost);
        }
        if let Some(timer) = &mut self.timer {
            timer.advance();
        }
        let stored = self.store(frame);
        if stored.is_err() {
            // What came before the error is on the device already.
            self.drawn = None;
        }
        let uploaded_bytes = stored?;
        let resized = self.resize(frame.viewport_px)?;
        let masses_changed = self.masses.follow(&self.device, &self.queue, frame);
        let uniform = frame_uniform(frame, self.targets.size_px(), self.look);
        let levels = Box::new(level_uniforms(frame));
        let selection = self.mesh.select(&frame.plan);
        let key = TerrainKey {
            colour: uniform.colour_levels > 0,
            normals: uniform.normal_levels > 0,
            haze: uniform.haze > 0.0,
            shared_levels: shares_levels(frame),
            blends_levels: self.quality.blends_levels || self.rests,
            max_taps: self.quality.max_taps.clamp(1, 16),
        };
        let heights_came = frame.uploads.iter().any(|u| u.clipmap == ClipKind::Height);
        let (same_vertices, same_picture) = self.drawn.as_ref().map_or((false, false), |drawn| {
            let same_frame = drawn.frame == uniform && drawn.selection == selection;
            let same_heights =
                drawn.levels[..COLOUR_SLOT] == levels[..COLOUR_SLOT] && !heights_came;
            let same_levels = drawn.levels == levels && frame.uploads.is_empty();
            (
                same_frame && same_heights,
                same_frame && same_levels && !resized && !masses_changed && drawn.key == key,
            )
        });
        let mut stats = FrameStats {
            reused: same_picture,
            triangles: selection.triangles,
            mass_triangles: self.masses.triangles(),
            triangles_without_culling: selection.triangles_without_culling,
            draws: selection.draws.len() as u32,
            displaced_vertices: 0,
            uploads: frame.uploads.len() as u32,
            uploaded_bytes,
            pipeline: key,
            gpu_memory: self.gpu_memory(),
            measured: self.timer.as_ref().and_then(FrameTimer::latest),
        };
        if same_picture {
            return Ok(stats);
        }
        self.frame_group.write(&self.queue, &uniform, &levels);
        if !same_vertices {
            stats.displaced_vertices = selection
                .vertices
                .iter()
                .map(|r| u64::from(r.end - r.start))
                .sum();
        }
        self.encode(encoder, &selection, key, !same_vertices);
        self.drawn = Some(Drawn {
            frame: uniform,
            levels,
            selection,
            view: View::new(&frame.camera, &frame.planet, self.targets.size_px()),
            near_m: frame.near_m,
            radius_m: frame.planet.radius_m,
            key,
        });
        Ok(stats)
    }

    /// Records the passes.
    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        selection: &MeshSelection,
        key: TerrainKey,
        displace: bool,
    ) {
        let Self {
            device,
            queue,
            frame_group,
            mesh,
            timer,
            ..
        } = self;
        let queries = timer.as_ref().and_then(FrameTimer::queries);
        if displace {
            let timestamps = queries.map(|query_set| wgpu::ComputePassTimestampWrites {
                query_set,
                beginning_of_pass_write_index: Some(0),
                end_of_pass_write_index: None,
            });
            let (group, runs) = (frame_group.group(), &selection.vertices);
            self.displace.run(
                queue,
                encoder,
                group,
                &self.displace_group,
                runs,
                timestamps,
            );
        }
        let timestamps = queries.map(|query_set| wgpu::RenderPassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: (!displace).then_some(0),
            end_of_pass_write_index: Some(1),
        });
        let mut pass = self.targets.begin(encoder, timestamps);
        pass.set_bind_group(0, frame_group.group(), &[]);
        self.terrain
            .draw(device, &mut pass, key, &self.terrain_group, mesh, selection);
        self.masses.draw(device, &mut pass, key.haze);
        self.sky.draw(&mut pass, key.haze);
        drop(pass);
        let measures = queries.is_some();
        if let Some(timer) = timer.as_mut().filter(|_| measures) {
            let [width, height] = self.targets.size_px().map(u64::from);
            timer.record(encoder, width * height);
        }
    }

    /// Makes room for a frame's levels and stores its uploads; returns the bytes sent.
    fn store(&mut self, frame: &Frame) -> Result<u64, RenderError> {
        let stacks = [
            (
                &mut self.heights,
                ClipKind::Height,
                &frame.heights,
                frame.height_window,
            ),
            (
                &mut self.colours,
                ClipKind::Colour,
                &frame.colours,
                frame.colour_window,
            ),
            (
                &mut self.normals,
                ClipKind::Normal,
                &frame.normals,
                frame.colour_window,
            ),
        ];
        let most = self.device.limits().max_texture_array_layers;
        let (mut replaced, mut full) = ([false; 3], None);
        for ((texture, kind, levels, window), replaced) in stacks.into_iter().zip(&mut replaced) {
            let uploaded = frame
                .uploads
                .iter()
                .filter(|u| u.clipmap == kind)
                .map(|u| u.layer);
            // Layers beyond the device's are refused below, one by one.
            let layers = levels
                .iter()
                .map(|l| l.layer)
                .chain(uploaded)
                .filter(|layer| *layer < most);
            if let Some(last) = layers.max() {
                match texture.reserve(&self.device, &self.queue, window, last + 1) {
                    Ok(is_new) => *replaced = is_new,
                    Err(error) => {
                        full = Some(error);
                        break;
                    }
                }
            }
        }
        if replaced[0] {
            self.displace_group = self
                .displace
                .bind(&self.device, self.heights.view(), &self.mesh);
        }
        if replaced[1] || replaced[2] {
            self.terrain_group =
                self.terrain
                    .bind(&self.device, self.colours.view(), self.normals.view());
        }
        if replaced.contains(&true) {
            self.drawn = None;
        }
        if let Some(error) = full {
            return Err(error.into());
        }
        let mut sent = 0;
        for upload in &frame.uploads {
            let (texture, levels) = match upload.clipmap {
                ClipKind::Height => (&self.heights, &frame.heights),
                ClipKind::Colour => (&self.colours, &frame.colours),
                ClipKind::Normal => (&self.normals, &frame.normals),
            };
            let around = columns_around(levels, upload.layer, texture.window());
            sent += texture.upload(&self.queue, upload, around)?;
        }
        Ok(sent)
    }

    /// Makes targets of the frame's size; returns whether they are new.
    fn resize(&mut self, size_px: [u32; 2]) -> Result<bool, OutOfMemory> {
        let most = self.device.limits().max_texture_dimension_2d;
        let size_px = size_px.map(|s| s.clamp(1, most));
        if self.targets.size_px() == size_px {
            return Ok(false);
        }
        let bytes = 8 * u64::from(size_px[0]) * u64::from(size_px[1]);
        let device = &self.device;
        self.targets = memory::reserve(device, bytes, || Targets::new(device, size_px))?;
        self.drawn = None;
        self.blit_group = self.blit.bind(&self.device, self.targets.colour_view());
        Ok(true)
    }

    /// Memory of textures, mesh and targets, bytes.
    fn gpu_memory(&self) -> u64 {
        let [width, height] = self.targets.size_px().map(u64::from);
        let textures = self.heights.memory() + self.colours.memory() + self.normals.memory();
        textures + self.mesh.memory() + self.masses.memory() + 8 * width * height
    }

    /// Shows the latest picture in a pass of the target format; it fills the viewport.
    pub fn blit(&self, pass: &mut wgpu::RenderPass<'_>) {
        self.blit.draw(pass, &self.blit_group);
    }

    /// The latest picture's texture, sRGB encoded in a format without sRGB.
    pub fn picture(&self) -> &wgpu::TextureView {
        self.targets.colour_view()
    }

    /// Specialised pipelines made so far.
    pub fn pipeline_keys(&self) -> Vec<TerrainKey> {
        self.terrain.pipeline_keys()
    }

    /// Copies the latest submitted picture into memory, waiting for it.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn read_back(&self) -> Result<Picture, ReadError> {
        if self.loss.is_lost() {
            return Err(ReadError::DeviceLost);
        }
        let rgba = readback::texels(
            &self.device,
            &self.queue,
            self.targets.colour(),
            wgpu::TextureAspect::All,
        )?;
        let [width, height] = self.targets.size_px();
        Ok(Picture {
            width,
            height,
            rgba,
        })
    }

    /// The displaced vertices of the latest submitted frame: metres from the eye along the focus'
    /// axes, and height. Parts that were not visible keep older values. For tests and diagnosis.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn read_displaced(&self) -> Result<Vec<[f32; 4]>, ReadError> {
        if self.loss.is_lost() {
            return Err(ReadError::DeviceLost);
        }
        let bytes = readback::contents(&self.device, &self.queue, self.mesh.displaced())?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    /// Distances of the latest submitted picture along the direction of view in metres, row by row
    /// from the top; infinite for the sky. Waits for the device.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn read_distances(&self) -> Result<Vec<f32>, ReadError> {
        if self.loss.is_lost() {
            return Err(ReadError::DeviceLost);
        }
        let near_m = self.drawn.as_ref().map_or(0.0, |drawn| drawn.near_m) as f32;
        let depth = wgpu::TextureAspect::DepthOnly;
        let bytes = readback::texels(&self.device, &self.queue, self.targets.depth(), depth)?;
        let depths: Vec<f32> = bytemuck::pod_collect_to_vec(&bytes);
        Ok(depths
            .into_iter()
            .map(|depth| {
                if depth > 0.0 {
                    near_m / depth
                } else {
                    f32::INFINITY
                }
            })
            .collect())
    }

    /// What the pixel (x, y) of the latest submitted picture shows; `None` for sky and outside.
    /// Waits for the device and copies the whole depth.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn pick(&self, x: u32, y: u32) -> Result<Option<PickedPoint>, ReadError> {
        let [width, height] = self.targets.size_px();
        let Some(drawn) = self.drawn.as_ref().filter(|_| x < width && y < height) else {
            return Ok(None);
        };
        let distance_m = self.read_distances()?[y as usize * width as usize + x as usize];
        if !distance_m.is_finite() {
            return Ok(None);
        }
        let place = DVec2::new(
            (f64::from(x) + 0.5) / f64::from(width) * 2.0 - 1.0,
            1.0 - (f64::from(y) + 0.5) / f64::from(height) * 2.0,
        );
        let position_in_world = drawn.view.eye + drawn.view.ray(place) * f64::from(distance_m);
        Ok(Some(PickedPoint {
            position_in_world,
            point: MapPoint::from_direction(position_in_world),
            height_m: position_in_world.length() - drawn.radius_m,
        }))
    }
}

/// After how many texels the columns of a layer repeat.
fn columns_around(levels: &[LevelView], layer: u32, window: u32) -> u32 {
    let period = levels
        .iter()
        .find(|l| l.layer == layer)
        .map(|l| l.window.period().x as u32);
    period.unwrap_or(window).clamp(1, window)
}
