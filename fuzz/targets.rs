//! What is done with hostile bytes: one function per reader. The programs of `fuzz_targets/` feed
//! them with what libfuzzer makes up, and a test of `core/engine` feeds them, on the stable
//! compiler, with every file of `seeds/` and `regressions/`.
//!
//! A function that returns has found nothing wrong. Beyond not panicking, every refusal must be one
//! line that names the file, and what is read must keep the promises of the reader.

#![allow(
    dead_code,
    unreachable_pub,
    reason = "each program uses one target, a test uses all"
)]

use std::path::{Path, PathBuf};
use std::str::FromStr;

use relievo_engine::planet::{Camera, Grid, LevelKey, MapPoint, Planet, SampleRect};
use relievo_engine::project::{Edit, LayerKind, Project};
use relievo_engine::raster::crs::Crs;
use relievo_engine::raster::open::{OpenOptions, open};
use relievo_engine::raster::{Bands, Block, Cancel, PixelRect, RasterFile, worldfile};
use relievo_engine::{Engine, EngineOptions, View, vector};

/// A target's name and what it does.
pub type Target = (&'static str, fn(&[u8]));

/// All targets, by the names of their folders of seeds.
pub const ALL: &[Target] = &[
    ("geotiff", geotiff),
    ("tiff_chunk", tiff_chunk),
    ("picture", picture),
    ("raster", raster),
    ("exr", exr),
    ("ascii_grid", ascii_grid),
    ("mbtiles", mbtiles),
    ("pmtiles", pmtiles),
    ("geojson", geojson),
    ("flatgeobuf", flatgeobuf),
    ("shapefile", shapefile),
    ("world_file", world_file),
    ("crs", crs),
    ("project", project),
    ("scene", scene),
    ("edits", edits),
    ("camera", camera),
];

/// Side of the largest rectangle that is read at once.
const SIDE: u32 = 96;
/// Pyramids are made for images of so many pixels at most: larger ones cost time and find nothing.
const PYRAMID_AREA: u64 = 1 << 18;

/// A TIFF file of any kind.
pub fn geotiff(bytes: &[u8]) {
    if matches!(bytes.first_chunk(), Some(b"II" | b"MM")) {
        read_file("hostile.tif", bytes);
    }
}

/// JPEG, PNG, WebP.
pub fn picture(bytes: &[u8]) {
    let name = match bytes {
        [0xff, 0xd8, ..] => "hostile.jpg",
        [0x89, b'P', ..] => "hostile.png",
        [b'R', b'I', b'F', b'F', ..] => "hostile.webp",
        _ => return,
    };
    read_file(name, bytes);
}

/// Whatever the content says.
pub fn raster(bytes: &[u8]) {
    read_file("hostile.bin", bytes);
}

/// OpenEXR.
pub fn exr(bytes: &[u8]) {
    if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        read_file("hostile.exr", bytes);
    }
}

/// An ESRI ASCII grid.
pub fn ascii_grid(bytes: &[u8]) {
    let first = bytes.trim_ascii_start().first();
    if first.is_some_and(u8::is_ascii_alphabetic) {
        read_file("hostile.asc", bytes);
    }
}

/// An MBTiles database.
pub fn mbtiles(bytes: &[u8]) {
    if bytes.starts_with(b"SQLite format 3\0") {
        read_file("hostile.mbtiles", bytes);
    }
}

/// A PMTiles archive.
pub fn pmtiles(bytes: &[u8]) {
    if bytes.starts_with(b"PMTiles") {
        read_file("hostile.pmtiles", bytes);
    }
}

/// GeoJSON.
pub fn geojson(bytes: &[u8]) {
    if bytes.trim_ascii_start().first() == Some(&b'{') {
        read_features("hostile.geojson", bytes);
    }
}

/// FlatGeobuf.
pub fn flatgeobuf(bytes: &[u8]) {
    if bytes.starts_with(b"fgb\x03") {
        read_features("hostile.fgb", bytes);
    }
}

/// The shapes of a Shapefile, without the files beside them.
pub fn shapefile(bytes: &[u8]) {
    if bytes.starts_with(&9994_u32.to_be_bytes()) {
        read_features("hostile.shp", bytes);
    }
}

/// Opens a file of vectors, and draws what it holds where it lies, from afar and from near by.
fn read_features(name: &str, bytes: &[u8]) {
    let path = scratch(name);
    std::fs::write(&path, bytes).expect("the scratch folder can be written");
    let options = vector::OpenOptions {
        limits: vector::Limits {
            vertices: 100_000,
            ..vector::Limits::default()
        },
        ..vector::OpenOptions::default()
    };
    let features = match vector::open(&path, &options) {
        Ok((features, _)) => features,
        Err(error) => return check_named(&error.to_string(), &path),
    };
    assert!(features.vertices() <= 100_000, "no more than is allowed");
    let Some(bounds) = features.bounds() else {
        return;
    };
    let style = vector::Style {
        fill: Some([1.0; 4]),
        stroke: Some([0.0, 0.0, 0.0, 1.0]),
        stroke_width: Some(vector::style::Length::Pixels(2.0)),
        ..vector::Style::default()
    };
    let drawing = vector::Drawing::new(features.into(), style, Planet::EARTH);
    let at = bounds.centre();
    let place = MapPoint::new(at.x, core::f64::consts::FRAC_PI_2 - at.y).normalised();
    for n in [0, 8, 20] {
        let level = LevelKey::new(n, n);
        let s = level.sample_from_map(place).as_i64vec2();
        let rect = SampleRect::at(s.x - 16, s.y - 16, 32, 32);
        let grid = Grid::new(level.lattice().into(), rect);
        let mut out = Block::new(Bands::Colour, 32, 32);
        let drawn = drawing.render(&grid, &mut out, &Cancel::default());
        drawn.expect("a map can be drawn");
        assert!(out.samples().iter().all(|v| v.is_finite()));
        let empty = out.plane(3).iter().all(|a| *a == 0.0);
        assert!(empty || drawing.reaches(&grid), "what is drawn reaches");
    }
}

/// A TIFF whose directory is sound and whose strips and tiles are not: see [`tiff_of`].
pub fn tiff_chunk(bytes: &[u8]) {
    if let Some(file) = tiff_of(bytes) {
        read_file("hostile.tif", &file);
    }
}

/// The text of a world file.
pub fn world_file(bytes: &[u8]) {
    let Ok(text) = str::from_utf8(bytes) else {
        return;
    };
    match worldfile::parse(text) {
        Ok(affine) => check_affine(&affine),
        Err(line) => check_line(&line),
    }
}

/// A coordinate system's definition, and transforms with it.
pub fn crs(bytes: &[u8]) {
    let Ok(text) = str::from_utf8(bytes) else {
        return;
    };
    match Crs::parse(text) {
        Ok(crs) => transform(&crs),
        Err(error) => check_line(&error.to_string()),
    }
}

fn transform(crs: &Crs) {
    let (a_m, b_m) = crs.radii_m();
    assert!(a_m.is_finite() && b_m.is_finite() && a_m > 0.0 && b_m > 0.0);
    assert!(crs.metres_per_unit().is_finite());
    let numbers = [0.0, 1.0, -1e7, 5e5, f64::MAX, f64::MIN_POSITIVE, f64::NAN];
    for x in numbers {
        for y in numbers {
            if let Ok((lon, lat)) = crs.to_lonlat(x, y) {
                assert!(lon.is_finite() && lat.abs() <= core::f64::consts::FRAC_PI_2 + 1e-9);
                if let Ok((x, y)) = crs.from_lonlat(lon, lat) {
                    assert!(x.is_finite() && y.is_finite());
                }
            }
        }
    }
    for lon in [-3.2, 0.0, 1.0, 3.2] {
        for lat in [-1.571, -1.0, 0.0, 0.5, 1.571] {
            if let Ok((x, y)) = crs.from_lonlat(lon, lat) {
                assert!(x.is_finite() && y.is_finite());
            }
        }
    }
}

/// The text of a project. What is read survives writing and reading again.
pub fn project(bytes: &[u8]) {
    let Ok(text) = str::from_utf8(bytes) else {
        return;
    };
    let path = Path::new("hostile.relievo");
    match Project::from_json(text, path) {
        Ok(project) => {
            let written = project.to_json();
            let again = Project::from_json(&written, path).expect("what is written can be read");
            assert_eq!(
                again.to_json(),
                written,
                "the second writing equals the first"
            );
            let camera = project.camera.to_camera();
            assert!(camera.altitude_m.is_finite() && camera.lat_rad.is_finite());
            let figure = project.planet.body.figure();
            assert!(figure.radius_m.is_finite() && figure.radius_m > 0.0);
        }
        Err(error) => check_named(&error.to_string(), path),
    }
}

/// The text of a project whose numbers are used: places are asked for, a frame is planned.
pub fn scene(bytes: &[u8]) {
    let Ok(text) = str::from_utf8(bytes) else {
        return;
    };
    let Ok(mut project) = Project::from_json(text, Path::new("hostile.relievo")) else {
        return;
    };
    project
        .layers
        .retain(|l| matches!(l.kind, LayerKind::Noise(_) | LayerKind::Tint(_)));
    project.layers.truncate(4);
    let view = View {
        camera: project.camera.to_camera(),
        viewport_px: [64, 48],
        layout: relievo_engine::Layout::STANDARD,
        colour_window: 256,
        colour_texel_px: project.quality.texel_px,
        height_texel_px: 2.0 * project.quality.texel_px,
        max_taps: 4,
    };
    let options = EngineOptions {
        threads: Some(1),
        cache_folder: None,
        ..EngineOptions::default()
    };
    let mut engine = Engine::new(project, Path::new("."), options).expect("threads can start");
    let questions = engine.questions();
    for (lon_deg, lat_deg) in [(0.0, 90.0), (-180.0, -90.0), (12.3, 45.6), (179.999, 0.0)] {
        let place = MapPoint::from_degrees(lon_deg, lat_deg);
        let answer = questions
            .place(place, &Cancel::default())
            .expect("noise needs no file");
        assert!(answer.height_m.is_finite(), "{answer:?}");
        assert!(answer.slope_deg.is_none_or(f64::is_finite), "{answer:?}");
    }
    engine.set_view(view);
    let frame = engine.drain(0.016).expect("a view was set");
    assert!(frame.pending < 1 << 20, "a plan is bounded");
}

/// The text of a list of edits, applied to a project and taken back.
pub fn edits(bytes: &[u8]) {
    let Ok(text) = str::from_utf8(bytes) else {
        return;
    };
    let path = Path::new("hostile.json");
    let edits = match Edit::list_from_json(text, path) {
        Ok(edits) => edits,
        Err(error) => return check_named(&error.to_string(), path),
    };
    let written = Edit::list_to_json(&edits);
    let again = Edit::list_from_json(&written, path).expect("what is written can be read");
    assert_eq!(Edit::list_to_json(&again), written);
    let start = Project::from_json(BASE, path).expect("the base is a project");
    let mut project = start.clone();
    let before = project.to_json();
    let mut inverses = Vec::new();
    for edit in edits {
        let label = edit.label(&project);
        assert!(!label.contains('\n') || written.contains("\\n"));
        match project.apply(edit) {
            Ok(inverse) => inverses.push(inverse),
            Err(error) => check_line(&error.to_string()),
        }
    }
    let after = project.to_json();
    let read = Project::from_json(&after, path).expect("an edited project can be read");
    assert_eq!(read.to_json(), after);
    while let Some(inverse) = inverses.pop() {
        project.apply(inverse).expect("an inverse applies");
    }
    assert_eq!(project.to_json(), before, "edits taken back leave nothing");
}

/// A project with a layer of each kind.
const BASE: &str = r##"{"version": 1, "layers": [
    {"id": "a", "kind": "imagery", "path": "a.tif"},
    {"id": "b", "kind": "height", "path": "b.tif"},
    {"id": "c", "kind": "noise", "amplitude_m": 10.0, "wavelength_m": 1000.0},
    {"id": "d", "kind": "tint", "stops": [{"height_m": 0.0, "colour": "#112233"}]}]}"##;

/// A camera as the command line takes it.
pub fn camera(bytes: &[u8]) {
    let Ok(text) = str::from_utf8(bytes) else {
        return;
    };
    match Camera::from_str(text) {
        Ok(c) => {
            let numbers = [
                c.lon_rad,
                c.lat_rad,
                c.altitude_m,
                c.heading_rad,
                c.pitch_rad,
                c.fov_y_rad,
            ];
            assert!(numbers.iter().all(|v| v.is_finite()));
        }
        Err(error) => check_line(&error.to_string()),
    }
}

/// Opens a file of the given content in all ways and reads from its finest and coarsest level.
fn read_file(name: &str, bytes: &[u8]) {
    let path = scratch(name);
    std::fs::write(&path, bytes).expect("the scratch folder can be written");
    for as_bands in [None, Some(Bands::Height), Some(Bands::Colour)] {
        let options = OpenOptions {
            make_pyramid: false,
            as_bands,
            ..OpenOptions::default()
        };
        match open(&path, &options) {
            Ok(file) => {
                read_some(&*file);
                let size = file.info().overviews[0];
                if as_bands.is_none()
                    && u64::from(size.width) * u64::from(size.height) < PYRAMID_AREA
                {
                    drop(file);
                    with_pyramid(&path);
                }
            }
            Err(error) => check_named(&error.to_string(), &path),
        }
    }
}

fn with_pyramid(path: &Path) {
    match open(path, &OpenOptions::default()) {
        Ok(file) => {
            let levels = &file.info().overviews;
            let last = levels[levels.len() - 1];
            assert!(
                last.width.max(last.height) <= 256,
                "the last level is small"
            );
            read_some(&*file);
        }
        Err(error) => check_named(&error.to_string(), path),
    }
}

fn read_some(file: &dyn RasterFile) {
    let info = file.info();
    assert!(!info.overviews.is_empty());
    if let Some(place) = &info.georeference {
        check_affine(&place.plane_from_pixel);
        match Crs::parse(&place.crs) {
            Ok(crs) => transform(&crs),
            Err(error) => check_line(&error.to_string()),
        }
    }
    for level in [0, info.overviews.len() - 1] {
        let size = info.overviews[level];
        assert!(size.width > 0 && size.height > 0, "no level is empty");
        let (width, height) = (size.width.min(SIDE), size.height.min(SIDE));
        let corners = [(0, 0), (size.width - width, size.height - height)];
        for (x, y) in corners {
            let rect = PixelRect {
                x,
                y,
                width,
                height,
            };
            let mut block = Block::new(info.bands, 0, 0);
            match file.read(level, rect, &mut block, &Cancel::default()) {
                Ok(()) => check_samples(&block, rect, info.may_have_holes),
                Err(error) => check_named(&error.to_string(), &info.path),
            }
        }
    }
}

fn check_samples(block: &Block, rect: PixelRect, may_have_holes: bool) {
    let size = (rect.width as usize, rect.height as usize);
    assert_eq!((block.width(), block.height()), size);
    let planes = block.bands().planes();
    for plane in 0..planes {
        for v in block.plane(plane) {
            if block.bands() == Bands::Height {
                assert!(!v.is_infinite(), "heights are finite or holes");
            } else {
                assert!(v.is_finite(), "colours are finite");
            }
        }
    }
    let last = block.plane(planes - 1);
    if block.bands() == Bands::Colour {
        assert!(
            last.iter().all(|a| (0.0..=1.0).contains(a)),
            "alpha is a share"
        );
    }
    let hole = |v: &f32| v.is_nan() || (block.bands() == Bands::Colour && *v < 1.0);
    assert!(
        may_have_holes || !last.iter().any(hole),
        "no hole where none was told of"
    );
}

fn check_affine(affine: &[f64; 6]) {
    assert!(affine.iter().all(|v| v.is_finite()));
    assert!(affine[1] * affine[5] - affine[2] * affine[4] != 0.0);
}

/// A refusal is one line, and not an endless one.
fn check_line(line: &str) {
    assert!(
        !line.is_empty() && !line.contains('\n'),
        "one line: {line:?}"
    );
    assert!(line.len() < 8192, "a line of {} bytes", line.len());
}

/// A refusal about a file names it.
fn check_named(line: &str, path: &Path) {
    check_line(line);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    assert!(line.contains(&*name), "{name} in {line:?}");
}

/// A file of this process: in memory where the system offers that.
pub fn scratch(name: &str) -> PathBuf {
    let memory = Path::new("/dev/shm");
    let root = if memory.is_dir() {
        memory.to_owned()
    } else {
        std::env::temp_dir()
    };
    let folder = root.join(format!("relievo-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a scratch folder can be made");
    folder.join(name)
}

/// A sound TIFF around hostile strips or tiles. The first 12 bytes choose the layout:
/// compression, bits, sample format, samples, predictor, photometric interpretation, planes, width,
/// height, side of chunks, extra samples, byte order; what follows is cut into as many parts as
/// there are chunks.
#[expect(
    clippy::too_many_lines,
    reason = "the fields of a TIFF, one after the other"
)]
pub fn tiff_of(bytes: &[u8]) -> Option<Vec<u8>> {
    let (&[c, b, f, s, p, ph, planar, w, h, side, extra, order], data) =
        bytes.split_first_chunk::<12>()?;
    let pick = |list: &[u32], i: u8| list[usize::from(i) % list.len()];
    let compression = pick(&[1, 5, 7, 8, 32773, 50000, 34887, 50001, 32946], c);
    let bits = pick(&[8, 16, 32, 64, 1, 2, 4], b);
    let format = pick(&[1, 2, 3], f);
    let samples = u32::from(s % 5) + 1;
    let predictor = pick(&[1, 2, 3], p);
    let photometric = pick(&[1, 2, 6, 3, 0], ph);
    let planes = if planar % 2 == 1 { samples } else { 1 };
    let (width, height) = (u32::from(w) + 1, u32::from(h) + 1);
    let tiled = side % 2 == 1;
    let side = (u32::from(side) / 2 % 8 + 1) * 16;
    let chunks = if tiled {
        width.div_ceil(side) * height.div_ceil(side)
    } else {
        height.div_ceil(side)
    } * planes;
    let big = order % 2 == 1;
    let mut entries: Vec<(u16, u16, Vec<u32>)> = vec![
        (256, 4, vec![width]),
        (257, 4, vec![height]),
        (258, 3, vec![bits; samples as usize]),
        (259, 3, vec![compression]),
        (262, 3, vec![photometric]),
        (277, 3, vec![samples]),
        (284, 3, vec![if planes > 1 { 2 } else { 1 }]),
        (317, 3, vec![predictor]),
        (339, 3, vec![format; samples as usize]),
    ];
    if extra % 4 > 0 && samples > 1 {
        entries.push((338, 3, vec![u32::from(extra % 4) - 1]));
    }
    if photometric == 3 {
        entries.push((
            320,
            3,
            (0..3 << bits.min(8)).map(|i| i * 97 % 65536).collect(),
        ));
    }
    if compression == 34887 {
        entries.push((50674, 4, vec![4, u32::from(extra / 4 % 3)]));
    }
    if compression == 7 && extra > 127 {
        // Tables that GDAL's writers share among tiles are part of the data here.
        entries.push((
            347,
            7,
            data.iter().take(600).map(|b| u32::from(*b)).collect(),
        ));
    }
    let (offset_tag, count_tag) = if tiled {
        entries.push((322, 4, vec![side]));
        entries.push((323, 4, vec![side]));
        (324, 325)
    } else {
        entries.push((278, 4, vec![side]));
        (273, 279)
    };
    let part = (data.len() as u32 / chunks).max(1);
    entries.push((offset_tag, 4, vec![0; chunks as usize]));
    entries.push((count_tag, 4, vec![part; chunks as usize]));
    entries.sort_by_key(|e| e.0);
    let size = |kind: u16| match kind {
        3 => 2,
        4 => 4,
        _ => 1,
    };
    let table = 8 + 2 + 12 * entries.len() as u32 + 4;
    let far = |e: &(u16, u16, Vec<u32>)| {
        let n = size(e.1) * e.2.len() as u32;
        if n > 4 { n.next_multiple_of(2) } else { 0 }
    };
    let data_at = table + entries.iter().map(far).sum::<u32>();
    for entry in &mut entries {
        if entry.0 == offset_tag {
            entry.2 = (0..chunks).map(|i| data_at + i * part).collect();
        }
    }
    let put = |out: &mut Vec<u8>, kind: u16, v: u32| match (size(kind), big) {
        (1, _) => out.push(v as u8),
        (2, true) => out.extend((v as u16).to_be_bytes()),
        (2, false) => out.extend((v as u16).to_le_bytes()),
        (_, true) => out.extend(v.to_be_bytes()),
        (_, false) => out.extend(v.to_le_bytes()),
    };
    let mut out = if big { b"MM".to_vec() } else { b"II".to_vec() };
    put(&mut out, 3, 42);
    put(&mut out, 4, 8);
    put(&mut out, 3, entries.len() as u32);
    let mut values = Vec::new();
    for entry in &entries {
        put(&mut out, 3, entry.0.into());
        put(&mut out, 3, entry.1.into());
        put(&mut out, 4, entry.2.len() as u32);
        let mut raw = Vec::new();
        for v in &entry.2 {
            put(&mut raw, entry.1, *v);
        }
        if raw.len() <= 4 {
            raw.resize(4, 0);
            out.extend(raw);
        } else {
            put(&mut out, 4, table + values.len() as u32);
            raw.resize(raw.len().next_multiple_of(2), 0);
            values.extend(raw);
        }
    }
    put(&mut out, 4, 0);
    out.extend(values);
    out.extend_from_slice(data);
    Some(out)
}
