//! The view: camera, viewport and how much a picture may cost.

use relievo_planet::Camera;
use relievo_planet::clipmap::Layout;

/// What the front-end shows the planet through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The viewer.
    pub camera: Camera,
    /// Width and height of the picture in pixels, at least 1.
    pub viewport_px: [u32; 2],
    /// How clip levels lie around their focus.
    pub layout: Layout,
    /// Side of the colour and normal windows in samples: a power of two, 256 to 4096.
    pub colour_window: u32,
    /// Smallest size of a colour sample on the screen in pixels.
    pub colour_texel_px: f64,
    /// Smallest size of a height sample on the screen in pixels.
    pub height_texel_px: f64,
    /// Most taps with which the front-end filters along a colour footprint, at least 1.
    pub max_taps: u32,
}
