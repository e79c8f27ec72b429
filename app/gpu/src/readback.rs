//! From textures to memory, waiting until the device is done: for stills, picking and tests.

/// Why pixels cannot be read back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReadError {
    /// The device is gone; open another and draw again.
    #[error("the graphics device was lost before the picture could be read")]
    DeviceLost,
}

/// A picture in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// RGBA, 8 bits, sRGB encoded, row by row from the top.
    pub rgba: Vec<u8>,
}

impl Picture {
    /// The pixel at (x, y), both inside.
    ///
    /// # Panics
    /// If it lies outside.
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        assert!(x < self.width && y < self.height, "a pixel of the picture");
        let i = 4 * (y as usize * self.width as usize + x as usize);
        [
            self.rgba[i],
            self.rgba[i + 1],
            self.rgba[i + 2],
            self.rgba[i + 3],
        ]
    }
}

/// All texels of a two-dimensional texture of four bytes a texel, row by row without padding.
///
/// # Errors
/// If the device is lost.
pub fn texels(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    aspect: wgpu::TextureAspect,
) -> Result<Vec<u8>, ReadError> {
    let row = texture.width() * 4;
    let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = staging(device, u64::from(padded) * u64::from(texture.height()));
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor {
        label: Some("readback/texels"),
    });
    encoder.copy_texture_to_buffer(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: wgpu::Origin3d::ZERO,
            aspect,
        },
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(padded),
                rows_per_image: None,
            },
        },
        texture.size(),
    );
    queue.submit([encoder.finish()]);
    let bytes = mapped(device, &buffer)?;
    Ok(bytes
        .chunks(padded as usize)
        .flat_map(|line| &line[..row as usize])
        .copied()
        .collect())
}

/// The contents of a buffer that may be copied from.
///
/// # Errors
/// If the device is lost.
pub fn contents(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    source: &wgpu::Buffer,
) -> Result<Vec<u8>, ReadError> {
    let buffer = staging(device, source.size());
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor {
        label: Some("readback/contents"),
    });
    encoder.copy_buffer_to_buffer(source, 0, &buffer, 0, source.size());
    queue.submit([encoder.finish()]);
    mapped(device, &buffer)
}

fn staging(device: &wgpu::Device, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback/staging"),
        size,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    })
}

/// Waits until all that was submitted is done.
pub(crate) fn wait(device: &wgpu::Device) -> Result<(), ReadError> {
    let done = device.poll(wgpu::PollType::wait_indefinitely());
    // The only other reason, a time that ran out, was not given.
    done.map(|_| ()).or(Err(ReadError::DeviceLost))
}

/// Waits for a buffer and copies it.
fn mapped(device: &wgpu::Device, buffer: &wgpu::Buffer) -> Result<Vec<u8>, ReadError> {
    // A buffer that cannot be mapped says so below.
    buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    wait(device)?;
    let Ok(bytes) = buffer.get_mapped_range(..) else {
        return Err(ReadError::DeviceLost);
    };
    let copy = bytes.to_vec();
    drop(bytes);
    buffer.unmap();
    Ok(copy)
}
