//! The texture arrays behind the clipmaps: one layer a level, written piece by piece.
//!
//! Invariant: a texel holds the last sample written to it however the array has grown since.
//! Absent: which samples belong where; the engine says so with every [`Upload`].

use relievo_engine::planet::TILE_SAMPLES;
use relievo_engine::raster::{Sample, SampleType};
use relievo_engine::{ClipKind, Upload};

use crate::memory::{self, OutOfMemory};

/// Why an upload cannot be stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UploadError {
    /// The tile holds another kind of samples.
    #[error("a {clipmap:?} clipmap takes {expected:?} samples, the tile holds {found:?}")]
    SampleType {
        /// Which clipmap.
        clipmap: ClipKind,
        /// What it stores.
        expected: SampleType,
        /// What came.
        found: SampleType,
    },
    /// The rectangle does not fit the tile, the window or the array.
    #[error("an upload to the {clipmap:?} clipmap, layer {layer}, lies outside its tile or window")]
    Outside {
        /// Which clipmap.
        clipmap: ClipKind,
        /// The array layer.
        layer: u32,
    },
}

/// One texture array.
#[derive(Debug)]
pub struct ClipmapTexture {
    kind: ClipKind,
    window: u32,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
}

impl ClipmapTexture {
    /// An array of `layers` layers of `window`² zeros.
    pub fn new(device: &wgpu::Device, kind: ClipKind, window: u32, layers: u32) -> Self {
        let texture = create(device, kind, window, layers);
        let view = array_view(&texture);
        Self {
            kind,
            window,
            texture,
            view,
        }
    }

    /// All layers.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// N: texels along a side.
    pub fn window(&self) -> u32 {
        self.window
    }

    /// Memory it takes in bytes.
    pub fn memory(&self) -> u64 {
        u64::from(self.window).pow(2) * u64::from(self.texture.depth_or_array_layers()) * 4
    }

    /// Makes room for `layers` layers of `window`² texels and says whether the texture, and so its
    /// view, is another one now. Growing keeps what is there; another window size starts from zeros.
    ///
    /// # Errors
    /// When the device has no room; what was there stays.
    pub fn reserve(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        window: u32,
        layers: u32,
    ) -> Result<bool, OutOfMemory> {
        let has = self.texture.depth_or_array_layers();
        if window == self.window && layers <= has {
            return Ok(false);
        }
        let same_window = window == self.window;
        // A few to spare, since levels come one at a time.
        let most = device.limits().max_texture_array_layers;
        let layers = if same_window {
            layers.next_multiple_of(4).min(most).max(layers)
        } else {
            layers
        };
        let bytes = u64::from(window).pow(2) * u64::from(layers) * 4;
        let grown = memory::reserve(device, bytes, || create(device, self.kind, window, layers))?;
        if same_window {
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor {
                label: Some("clipmap_textures/grow"),
            });
            encoder.copy_texture_to_texture(
                self.texture.as_image_copy(),
                grown.as_image_copy(),
                self.texture.size(),
            );
            // At once, so that writes queued from now on land after the copy.
            queue.submit([encoder.finish()]);
        }
        *self = Self {
            kind: self.kind,
            window,
            view: array_view(&grown),
            texture: grown,
        };
        Ok(true)
    }

    /// Stores the samples of an upload; returns the bytes sent.
    ///
    /// - `columns_around`: after how many texels columns repeat (at most N). Where that is less
    ///   than N, the columns on both sides of the seam are stored once more beyond it, so that a
    ///   repeating, filtering sampler reads across it.
    ///
    /// # Errors
    /// If the tile holds other samples or the rectangle does not fit; nothing is written then.
    pub fn upload(
        &self,
        queue: &wgpu::Queue,
        upload: &Upload,
        columns_around: u32,
    ) -> Result<u64, UploadError> {
        let expected = sample_type(self.kind);
        let found = upload.tile.sample_type();
        if found != expected {
            return Err(UploadError::SampleType {
                clipmap: self.kind,
                expected,
                found,
            });
        }
        let fits = |start: u32, size: u32, whole: u32| {
            start.checked_add(size).is_some_and(|end| end <= whole)
        };
        let inside = (0..2).all(|k| {
            fits(upload.source[k], upload.size[k], TILE_SAMPLES as u32)
                && fits(upload.storage[k], upload.size[k], self.window)
        });
        if !inside || upload.layer >= self.texture.depth_or_array_layers() {
            return Err(UploadError::Outside {
                clipmap: self.kind,
                layer: upload.layer,
            });
        }
        if upload.size.contains(&0) {
            return Ok(0);
        }
        let mut sent = self.write(queue, upload, upload.storage, upload.source, upload.size);
        if columns_around < self.window {
            let last = columns_around - 1;
            let [x, y] = upload.storage;
            if x == 0 {
                sent += self.write(
                    queue,
                    upload,
                    [columns_around, y],
                    upload.source,
                    [1, upload.size[1]],
                );
            }
            if (x..x + upload.size[0]).contains(&last) {
                let source = [upload.source[0] + last - x, upload.source[1]];
                sent += self.write(
                    queue,
                    upload,
                    [self.window - 1, y],
                    source,
                    [1, upload.size[1]],
                );
            }
        }
        Ok(sent)
    }

    /// Writes a rectangle that is known to fit.
    fn write(
        &self,
        queue: &wgpu::Queue,
        upload: &Upload,
        to: [u32; 2],
        from: [u32; 2],
        size: [u32; 2],
    ) -> u64 {
        const BYTES: u32 = 4;
        let filled;
        let (bytes, row_bytes) = if let Some(bytes) = upload.tile.bytes() {
            let side = TILE_SAMPLES as u32;
            (
                &bytes[((from[1] * side + from[0]) * BYTES) as usize..],
                side * BYTES,
            )
        } else {
            let sample = upload.tile.as_uniform().map_or([0; 4], stored);
            filled = sample.repeat((size[0] * size[1]) as usize);
            (&filled[..], size[0] * BYTES)
        };
        queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &self.texture,
                mip_level: 0,
                origin: wgpu::Origin3d {
                    x: to[0],
                    y: to[1],
                    z: upload.layer,
                },
                aspect: wgpu::TextureAspect::All,
            },
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row_bytes),
                rows_per_image: None,
            },
            wgpu::Extent3d {
                width: size[0],
                height: size[1],
                depth_or_array_layers: 1,
            },
        );
        u64::from(size[0]) * u64::from(size[1]) * u64::from(BYTES)
    }
}

/// Samples that a clipmap stores.
const fn sample_type(kind: ClipKind) -> SampleType {
    match kind {
        ClipKind::Height => SampleType::Height,
        ClipKind::Colour => SampleType::Rgba8,
        ClipKind::Normal => SampleType::Normal,
    }
}

/// Four bytes of a uniform tile's sample.
fn stored(sample: Sample) -> [u8; 4] {
    match sample {
        Sample::Height(height_m) => height_m.to_ne_bytes(),
        Sample::Rgba8(rgba) => rgba,
        Sample::Normal([east, north]) => {
            let ([a, b], [c, d]) = (east.to_ne_bytes(), north.to_ne_bytes());
            [a, b, c, d]
        }
        // No clipmap stores these: `upload` has refused them.
        Sample::Rgba16F(_) | Sample::Rgba32F(_) | Sample::Mask(_) | Sample::Mask32F(_) => [0; 4],
    }
}

fn create(device: &wgpu::Device, kind: ClipKind, window: u32, layers: u32) -> wgpu::Texture {
    let (label, format) = match kind {
        ClipKind::Height => ("clipmap_textures/heights", wgpu::TextureFormat::R32Float),
        ClipKind::Colour => (
            "clipmap_textures/colours",
            wgpu::TextureFormat::Rgba8UnormSrgb,
        ),
        ClipKind::Normal => ("clipmap_textures/normals", wgpu::TextureFormat::Rg16Float),
    };
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d {
            width: window,
            height: window,
            depth_or_array_layers: layers.max(1),
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_DST
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

fn array_view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        label: Some("clipmap_textures/view"),
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    })
}
