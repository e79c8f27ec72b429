//! The static concentric mesh.

/// Azimuth sectors into which every ring is cut for culling.
pub const SECTORS: u32 = 16;
