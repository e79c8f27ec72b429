//! Tests on a device: software Vulkan will do. Without any adapter they fail and say so.

mod masses;
mod picture;
mod scene;
mod survival;
mod twins;
