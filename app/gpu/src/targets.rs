//! The picture and its depth, of one size.

/// Format of the picture: sRGB encoded by the shaders, so that a window shows it as it is.
pub const COLOUR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Format of the depth: reversed, near plane / distance along the view direction.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Depth state of a pipeline that draws into [`Targets`].
pub(crate) fn depth_state(write: bool, compare: wgpu::CompareFunction) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH_FORMAT,
        depth_write_enabled: Some(write),
        depth_compare: Some(compare),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    }
}

/// A picture and its depth.
#[derive(Debug)]
pub struct Targets {
    size_px: [u32; 2],
    colour: wgpu::Texture,
    depth: wgpu::Texture,
    colour_view: wgpu::TextureView,
    depth_view: wgpu::TextureView,
}

impl Targets {
    /// Targets of `size_px` pixels, at least 1 by 1 and at most what the device allows.
    pub fn new(device: &wgpu::Device, size_px: [u32; 2]) -> Self {
        let most = device.limits().max_texture_dimension_2d;
        let [width, height] = size_px.map(|s| s.clamp(1, most));
        let texture = |label, format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d {
                    width,
                    height,
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage
                    | wgpu::TextureUsages::RENDER_ATTACHMENT
                    | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            })
        };
        let colour = texture(
            "targets/colour",
            COLOUR_FORMAT,
            wgpu::TextureUsages::TEXTURE_BINDING,
        );
        let depth = texture("targets/depth", DEPTH_FORMAT, wgpu::TextureUsages::empty());
        Self {
            size_px: [width, height],
            colour_view: colour.create_view(&wgpu::TextureViewDescriptor::default()),
            depth_view: depth.create_view(&wgpu::TextureViewDescriptor::default()),
            colour,
            depth,
        }
    }

    /// Width and height in pixels.
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// The picture.
    pub fn colour(&self) -> &wgpu::Texture {
        &self.colour
    }

    /// A view of the picture.
    pub fn colour_view(&self) -> &wgpu::TextureView {
        &self.colour_view
    }

    /// The depth.
    pub fn depth(&self) -> &wgpu::Texture {
        &self.depth
    }

    /// Begins the pass that draws a picture.
    pub fn begin<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        timestamps: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) -> wgpu::RenderPass<'e> {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("targets/pass"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.colour_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth_view,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: timestamps,
            ..Default::default()
        })
    }
}
