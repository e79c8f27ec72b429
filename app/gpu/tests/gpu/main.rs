//! Tests on a device: software Vulkan will do. Without any adapter they fail and say so.

mod picture;
mod scene;
mod survival;
mod twins;
