//! The clipmap front-end: textures, displacement, terrain, bodies, sky, on wgpu.
//!
//! ```text
//! Engine::drain -> Frame --Renderer::render--> clipmap textures -> displaced rings -> picture
//!                                              Renderer::blit -> window   Renderer::read_back -> file
//! ```
//!
//! Invariant: nothing here sees a project; all it knows of the world is a `Frame` ([`Still`] drains an
//! engine for them, and asks it nothing else).
//! A device that is lost is replaced: [`Gpu`] anew, [`Renderer::rebuilt`], all uploads again. One
//! without room for what is asked of it says so ([`RenderError::OutOfMemory`]) and goes on.

mod bind;
pub mod blit;
pub mod clipmap_textures;
pub mod device;
pub mod displace;
pub mod forms;
pub mod frame_group;
pub mod masses;
pub mod measure;
pub mod memory;
pub mod mesh;
pub mod quality;
pub mod readback;
pub mod renderer;
pub mod sky;
pub mod stats;
pub mod still;
pub mod targets;
pub mod terrain;
pub mod timing;
pub mod uniforms;

pub use clipmap_textures::UploadError;
pub use device::{Gpu, GpuError, LossWatch, device_descriptor};
pub use memory::OutOfMemory;
pub use quality::front::{Front, FrontError, FrontPoint, Setting};
pub use quality::{AdapterClass, Look, Quality};
pub use readback::{Picture, ReadError};
pub use renderer::{PickedPoint, RenderError, Renderer};
pub use stats::FrameStats;
pub use still::{Still, StillError};
pub use terrain::TerrainKey;
pub use timing::FrameTime;
