//! The whole way of a pixel: sample projects from their files to a picture.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

/// Needs an adapter; software Vulkan is one.
mod on_device {
    use std::time::Duration;

    use relievo_engine::planet::Camera;
    use relievo_engine::{Engine, EngineOptions, View};
    use relievo_gpu::{Gpu, Picture, Quality, Renderer};
    use relievo_tests::workspace;

    const WIDTH: u32 = 320;
    const HEIGHT: u32 = 240;

    /// A converged picture of a sample project.
    fn picture(project: &str, camera: Camera, threads: usize) -> Picture {
        let path = workspace().join("projects").join(project);
        let options = EngineOptions {
            threads: Some(threads),
            cache_folder: None,
            ..EngineOptions::default()
        };
        let (mut engine, _) = Engine::open(&path, options).unwrap();
        let gpu = Gpu::headless().unwrap();
        let quality = Quality {
            colour_window: 512,
            ..Quality::for_adapter(gpu.class)
        };
        let mut renderer = Renderer::new(&gpu, wgpu::TextureFormat::Rgba8Unorm, quality).unwrap();
        engine.set_view(View {
            camera,
            viewport_px: [WIDTH, HEIGHT],
            layout: quality.layout,
            colour_window: quality.colour_window,
            colour_texel_px: 1.0,
            height_texel_px: 2.0,
            max_taps: 4,
        });
        let mut uploads = Vec::new();
        for _ in 0..5000 {
            let mut frame = engine.drain(f32::INFINITY).unwrap();
            uploads.append(&mut frame.uploads);
            if frame.is_converged() {
                frame.uploads = uploads;
                let mut encoder = gpu
                    .device
                    .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                renderer.render(&frame, &mut encoder).unwrap();
                gpu.queue.submit([encoder.finish()]);
                assert_eq!(engine.messages(), []);
                return renderer.read_back().unwrap();
            }
            engine.wait(Duration::from_millis(100));
        }
        panic!("{project} does not converge: {:?}", engine.stats());
    }

    fn camera(lon: f64, lat: f64, altitude_m: f64, heading: f64, pitch: f64) -> Camera {
        Camera::from_degrees(lon, lat, altitude_m, heading, pitch, 60.0).unwrap()
    }

    /// Mean colour of 9 × 9 pixels.
    fn mean(picture: &Picture, x: u32, y: u32) -> [i32; 3] {
        let mut sum = [0; 3];
        for (dx, dy) in (0..81).map(|i| (i % 9, i / 9)) {
            let pixel = picture.pixel(x + dx - 4, y + dy - 4);
            for (s, c) in sum.iter_mut().zip(pixel) {
                *s += i32::from(c);
            }
        }
        sum.map(|s| s / 81)
    }

    #[test]
    fn the_earth_is_blue_over_the_pacific_and_tan_over_the_sahara() {
        let [r, _, b] = mean(
            &picture("earth.relievo", camera(-150.0, 5.0, 8e6, 0.0, -90.0), 1),
            160,
            120,
        );
        assert!(b > r + 30, "the Pacific is blue: {r} {b}");
        let [r, _, b] = mean(
            &picture("earth.relievo", camera(15.0, 22.0, 8e6, 0.0, -90.0), 1),
            160,
            120,
        );
        assert!(r > b + 10, "the Sahara is tan: {r} {b}");
    }

    #[test]
    fn the_same_project_gives_the_same_bytes_for_any_number_of_threads() {
        for (project, view) in [
            ("earth.relievo", camera(-111.8, 40.1, 6000.0, 30.0, -12.0)),
            (
                "synthetic.relievo",
                camera(10.0, 88.0, 400_000.0, 200.0, -40.0),
            ),
        ] {
            let one = picture(project, view, 1);
            assert!(
                one == picture(project, view, 3),
                "{project} differs between 1 and 3 threads"
            );
        }
    }

    #[test]
    fn every_pixel_of_the_disc_is_planet() {
        // From 3 radii above a pole, which all columns of the map meet at.
        let picture = picture("mars.relievo", camera(0.0, 90.0, 1e7, 0.0, -90.0), 2);
        let [cx, cy] = [f64::from(WIDTH) / 2.0, f64::from(HEIGHT) / 2.0];
        let mut dark = 0;
        for y in 0..HEIGHT {
            for x in 0..WIDTH {
                let from_centre = (f64::from(x) + 0.5 - cx).hypot(f64::from(y) + 0.5 - cy);
                let [r, g, b, _] = picture.pixel(x, y);
                if from_centre < 40.0 {
                    dark += u32::from(u32::from(r) + u32::from(g) + u32::from(b) < 12);
                }
            }
        }
        assert_eq!(dark, 0, "no hole shows the black behind");
    }
}
