//! Making things on a device that may have no room for them.

/// The device has no room; nothing was made, and what was there is as it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the graphics device has no room for {} MiB more", .bytes >> 20)]
pub struct OutOfMemory {
    /// How much was asked for.
    pub bytes: u64,
}

/// Makes something of so many bytes on a device, or says that there is no room.
pub(crate) fn reserve<T>(
    device: &wgpu::Device,
    bytes: u64,
    make: impl FnOnce() -> T,
) -> Result<T, OutOfMemory> {
    let scope = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let made = make();
    match pollster::block_on(scope.pop()) {
        None => Ok(made),
        Some(error) => {
            tracing::warn!("{bytes} bytes of graphics memory were refused: {error}");
            Err(OutOfMemory { bytes })
        }
    }
}
