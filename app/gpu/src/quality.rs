//! How much is spent on a picture, decided by the adapter unless the user decides.

pub mod front;

use relievo_engine::planet::clipmap::Layout;

/// How fast an adapter is, roughly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum AdapterClass {
    /// The processor draws.
    Software,
    /// A GPU that shares the processor's memory, or one of unknown kind.
    Integrated,
    /// A GPU with memory of its own.
    Discrete,
}

impl AdapterClass {
    /// The class of an adapter.
    pub fn of(info: &wgpu::AdapterInfo) -> Self {
        let name = info.name.to_ascii_lowercase();
        let software = ["llvmpipe", "softpipe", "swiftshader", "lavapipe"];
        match info.device_type {
            wgpu::DeviceType::Cpu => Self::Software,
            // OpenGL drivers do not tell the kind.
            _ if software.iter().any(|s| name.contains(s)) => Self::Software,
            wgpu::DeviceType::DiscreteGpu => Self::Discrete,
            wgpu::DeviceType::IntegratedGpu
            | wgpu::DeviceType::VirtualGpu
            | wgpu::DeviceType::Other => Self::Integrated,
        }
    }
}

/// What the front-end itself decides; window sizes are hints to whoever plans the levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Quality {
    /// How levels lie around the focus: the mesh blends its heights so.
    pub layout: Layout,
    /// N of the colour and normal windows in samples: a power of two, at least 256.
    pub colour_window: u32,
    /// Vertices around a ring: a multiple of the number of sectors.
    pub azimuth_steps: u32,
    /// Rows of quads from a ring's outer to its inner rim.
    pub radial_steps: u32,
    /// Most taps along the major axis of a fragment's footprint, 1 to 16.
    pub max_taps: u32,
    /// Whether a fragment between two levels reads and mixes both while the picture moves; else it
    /// reads one of them, by chance in proportion.
    pub blends_levels: bool,
}

impl Quality {
    /// The default for an adapter. On software a triangle costs about 0.15 µs: at most 80,000 of
    /// them are drawn in any view.
    pub const fn for_adapter(class: AdapterClass) -> Self {
        match class {
            AdapterClass::Software => Self {
                layout: Layout::STANDARD,
                colour_window: 1024,
                azimuth_steps: 192,
                radial_steps: 20,
                max_taps: 4,
                blends_levels: false,
            },
            AdapterClass::Integrated => Self {
                layout: Layout::STANDARD,
                colour_window: 2048,
                azimuth_steps: 384,
                radial_steps: 32,
                max_taps: 8,
                blends_levels: true,
            },
            AdapterClass::Discrete => Self {
                layout: Layout::STANDARD,
                colour_window: 4096,
                azimuth_steps: 512,
                radial_steps: 40,
                max_taps: 8,
                blends_levels: true,
            },
        }
    }
}

/// How the air and light look: not part of a project's data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// How much of the air's effect is shown, 0 (none, black sky) to 8; 1 is clear air as it is, less
    /// lets the terrain speak.
    pub haze: f32,
}

impl Default for Look {
    fn default() -> Self {
        Self { haze: 0.5 }
    }
}
