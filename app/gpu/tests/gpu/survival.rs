//! Lost devices and broken frames are errors, and work goes on after them.

use std::sync::Arc;

use relievo_engine::planet::Planet;
use relievo_engine::raster::{Sample, Tile};
use relievo_engine::{ClipKind, Upload};
use relievo_gpu::clipmap_textures::ClipmapTexture;
use relievo_gpu::{Gpu, Quality, ReadError, RenderError, Renderer, UploadError};

use crate::scene::{self, World, camera, gpu, sun};

const SIZE: [u32; 2] = [160, 120];

const WORLD: World = World {
    planet: Planet::EARTH,
    height: scene::smooth_hills,
    colour: Some(scene::smooth_colour),
    lit: true,
    range: scene::SMOOTH_RANGE,
};

#[test]
fn a_lost_device_is_reported_and_rebuilt() {
    let camera = camera(11.0, 47.0, 20_000.0, 200.0, -30.0);
    let frame = scene::frame(&WORLD, camera, SIZE, sun(&camera, 150.0, 50.0));
    let draw = |gpu: &Gpu, renderer: &mut Renderer| {
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        renderer.render(&frame, &mut encoder)?;
        gpu.queue.submit([encoder.finish()]);
        Ok::<_, RenderError>(())
    };
    let first = Gpu::headless().unwrap();
    let mut renderer =
        Renderer::new(&first, wgpu::TextureFormat::Rgba8Unorm, scene::quality()).unwrap();
    draw(&first, &mut renderer).unwrap();
    let before = renderer.read_back().unwrap();

    first.device.destroy();
    // The loss is told when the device is next polled, as any window does every frame.
    let _ignored = first.device.poll(wgpu::PollType::Poll);
    assert!(first.loss.is_lost());
    assert_eq!(draw(&first, &mut renderer), Err(RenderError::DeviceLost));
    assert_eq!(renderer.read_back(), Err(ReadError::DeviceLost));

    let second = Gpu::headless().unwrap();
    let mut renderer = renderer.rebuilt(&second).unwrap();
    draw(&second, &mut renderer).unwrap();
    assert!(
        renderer.read_back().unwrap() == before,
        "the same uploads give the same picture"
    );
}

#[test]
fn an_upload_that_does_not_fit_is_refused_and_the_next_frame_drawn() {
    let camera = camera(11.0, 47.0, 20_000.0, 200.0, -30.0);
    let good = scene::frame(&WORLD, camera, SIZE, sun(&camera, 150.0, 50.0));
    let mut renderer = scene::renderer();
    let mut render = |uploads: Vec<Upload>| {
        let mut frame = good.clone();
        frame.uploads.extend(uploads);
        let mut encoder = gpu()
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let result = renderer.render(&frame, &mut encoder);
        gpu().queue.submit([encoder.finish()]);
        result
    };
    let upload = |tile: Tile, storage, source, size| Upload {
        clipmap: ClipKind::Height,
        layer: 0,
        storage,
        tile: Arc::new(tile),
        source,
        size,
    };
    let height = || Tile::uniform(Sample::Height(1.0));
    let colour = Tile::uniform(Sample::Rgba8([1, 2, 3, 4]));
    let wrong = render(vec![upload(colour, [0, 0], [0, 0], [1, 1])]);
    assert!(matches!(
        wrong,
        Err(RenderError::Upload(UploadError::SampleType { .. }))
    ));
    for (storage, source, size) in [
        ([255, 0], [0, 0], [2, 1]),
        ([0, 0], [200, 0], [57, 1]),
        ([0, u32::MAX], [0, 0], [1, 2]),
    ] {
        let wrong = render(vec![upload(height(), storage, source, size)]);
        assert!(
            matches!(wrong, Err(RenderError::Upload(UploadError::Outside { .. }))),
            "{storage:?} {size:?}"
        );
    }
    let mut far = upload(height(), [0, 0], [0, 0], [1, 1]);
    far.layer = u32::MAX;
    assert!(render(vec![far]).is_err());
    assert!(render(vec![upload(height(), [0, 0], [0, 0], [0, 0])]).is_ok());
}

#[test]
fn a_device_without_room_says_so_and_goes_on_with_what_it_has() {
    let camera = camera(11.0, 47.0, 20_000.0, 200.0, -30.0);
    let frame = scene::frame(&WORLD, camera, SIZE, sun(&camera, 150.0, 50.0));
    let gpu = gpu();
    let mut renderer = scene::renderer();
    let draw = |renderer: &mut Renderer, frame: &relievo_engine::Frame| {
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        renderer.render(frame, &mut encoder)?;
        gpu.queue.submit([encoder.finish()]);
        Ok::<_, RenderError>(())
    };
    draw(&mut renderer, &frame).unwrap();
    let before = renderer.read_back().unwrap();
    // The largest array that the device can name: 256 GiB on most.
    let limits = gpu.device.limits();
    let (window, layers) = (
        limits.max_texture_dimension_2d,
        limits.max_texture_array_layers,
    );
    let mut texture = ClipmapTexture::new(&gpu.device, ClipKind::Colour, 256, 4);
    let refused = texture
        .reserve(&gpu.device, &gpu.queue, window, layers)
        .unwrap_err();
    assert_eq!(
        refused.bytes,
        4 * u64::from(window).pow(2) * u64::from(layers)
    );
    assert_eq!(
        (texture.window(), texture.memory()),
        (256, 4 * 4 * 256 * 256)
    );
    // The same by way of a frame.
    let mut greedy = frame.clone();
    greedy.colour_window = window;
    greedy.colours[0].layer = layers - 1;
    assert!(matches!(
        draw(&mut renderer, &greedy),
        Err(RenderError::OutOfMemory(_))
    ));
    assert!(!gpu.loss.is_lost());
    draw(&mut renderer, &frame).unwrap();
    assert!(renderer.read_back().unwrap() == before);
}

#[test]
fn a_renderer_of_changed_quality_draws_what_one_made_for_it_draws() {
    let camera = camera(11.0, 47.0, 20_000.0, 200.0, -30.0);
    let frame = scene::frame(&WORLD, camera, SIZE, sun(&camera, 150.0, 50.0));
    let without_uploads = {
        let mut frame = frame.clone();
        frame.uploads.clear();
        frame
    };
    let coarse = Quality {
        azimuth_steps: 64,
        radial_steps: 5,
        max_taps: 1,
        ..scene::quality()
    };
    let mut renderer = scene::renderer();
    let (fine, _) = scene::draw(&mut renderer, &frame);
    renderer.set_quality(coarse).unwrap();
    // Nothing is sent again.
    let (changed, drawn) = scene::draw(&mut renderer, &without_uploads);
    assert!(!drawn.reused);
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let mut made = Renderer::new(gpu(), format, coarse).unwrap();
    let (expected, _) = scene::draw(&mut made, &frame);
    assert!(changed.rgba == expected.rgba && changed.rgba != fine.rgba);
    // What cannot be cut into sectors is refused, and nothing has changed.
    let uneven = Quality {
        azimuth_steps: 65,
        ..coarse
    };
    renderer.set_quality(uneven).unwrap_err();
    assert_eq!(renderer.quality(), coarse);
    let (again, drawn) = scene::draw(&mut renderer, &without_uploads);
    assert!(drawn.reused && again.rgba == expected.rgba);
    renderer.set_quality(scene::quality()).unwrap();
    let (back, _) = scene::draw(&mut renderer, &without_uploads);
    assert!(back.rgba == fine.rgba);
}
