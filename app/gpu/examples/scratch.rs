//! scratch
use relievo_engine::*;
use relievo_gpu::*;
use std::io::Write;
use std::time::*;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let t = Instant::now();
    let (mut e, _) = Engine::open(
        args[1].as_ref(),
        EngineOptions {
            log: true,
            ..Default::default()
        },
    )
    .unwrap();
    let camera = e.project().camera.to_camera();
    let cam = args.get(3).map_or(camera, |c| c.parse().unwrap());
    let gpu = Gpu::headless().unwrap();
    let q = Quality::for_adapter(gpu.class);
    let mut r = Renderer::new(&gpu, wgpu::TextureFormat::Rgba8Unorm, q).unwrap();
    r.set_look(Look {
        haze: args.get(4).map_or(1.0, |h| h.parse().unwrap()),
        ..r.look()
    });
    println!("gpu {:?}", t.elapsed());
    e.set_view(View {
        camera: cam,
        viewport_px: [1280, 960],
        colour_window: q.colour_window,
        colour_texel_px: 1.0,
        height_texel_px: 2.0,
    });
    let mut uploads = Vec::new();
    loop {
        let mut f = e.drain(f32::INFINITY).unwrap();
        uploads.append(&mut f.uploads);
        if f.is_converged() {
            println!("converged {:?}", t.elapsed());
            f.uploads = std::mem::take(&mut uploads);
            let mut enc = gpu.device.create_command_encoder(&Default::default());
            let stats = r.render(&f, &mut enc).unwrap();
            gpu.queue.submit([enc.finish()]);
            println!("{stats:?} {:?}", t.elapsed());
            break;
        }
        e.wait(Duration::from_millis(100));
    }
    let mut cost = std::collections::BTreeMap::new();
    for l in &e.take_log() {
        let c = cost.entry((l.kind, l.node.0)).or_insert((
            0,
            Duration::ZERO,
            Duration::ZERO,
            String::new(),
        ));
        c.0 += 1;
        c.1 += l.cost;
        if l.cost > c.2 {
            c.2 = l.cost;
            c.3 = l.key.to_string();
        }
    }
    for c in cost {
        println!("  {c:?}");
    }
    let p = r.read_back().unwrap();
    let mut out = std::fs::File::create(&args[2]).unwrap();
    write!(out, "P6\n1280 960\n255\n").unwrap();
    let mut rgb = Vec::new();
    for y in 0..960 {
        for x in 0..1280 {
            rgb.extend(&p.pixel(x, y)[..3]);
        }
    }
    out.write_all(&rgb).unwrap();
    println!("{:?} {:?}", e.stats(), e.messages());
}
