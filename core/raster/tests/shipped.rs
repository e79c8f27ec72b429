//! The files that come with the program open, lie where they should and look as they should.

use std::path::{Path, PathBuf};

use relievo_raster::crs::Crs;
use relievo_raster::open::{OpenOptions, open};
use relievo_raster::{Bands, Block, Cancel, PixelRect};

/// A file, as GDAL sees it: size, system, where pixel (100, 100) begins, and three pixels.
struct Shipped {
    name: &'static str,
    size: (u32, u32),
    bands: Bands,
    band_count: u16,
    crs: &'static str,
    corner: [f64; 2],
    pixels: [&'static [f32]; 3],
}

const PLACES: [(u32, u32); 3] = [(100, 100), (500, 200), (37, 229)];

const FILES: [Shipped; 7] = [
    Shipped {
        name: "blue-marble.tif",
        size: (5400, 2700),
        bands: Bands::Colour,
        band_count: 3,
        crs: "EPSG:4326",
        corner: [-173.333_333_333_333, 83.333_333_333_333_3],
        pixels: [
            &[24.0, 56.0, 105.0],
            &[8.0, 23.0, 56.0],
            &[15.0, 47.0, 86.0],
        ],
    },
    Shipped {
        name: "earth-etopo5.tif",
        size: (4320, 2160),
        bands: Bands::Height,
        band_count: 1,
        crs: "EPSG:4326",
        corner: [-171.666_666_666_667, 81.666_666_666_666_7],
        pixels: [&[-3347.0], &[-3145.0], &[-39.0]],
    },
    Shipped {
        name: "mars-mola.tif",
        size: (1440, 720),
        bands: Bands::Height,
        band_count: 1,
        crs: "ESRI:104971",
        corner: [-155.0, 65.0],
        pixels: [&[-4185.0], &[-1871.0], &[-3928.0]],
    },
    Shipped {
        name: "natural-earth-2.tif",
        size: (4000, 2000),
        bands: Bands::Colour,
        band_count: 3,
        crs: "EPSG:4326",
        corner: [-171.0, 81.0],
        pixels: [
            &[103.0, 158.0, 199.0],
            &[119.0, 177.0, 215.0],
            &[111.0, 170.0, 212.0],
        ],
    },
    Shipped {
        name: "provo-aerial.tif",
        size: (539, 232),
        bands: Bands::Colour,
        band_count: 4,
        crs: "EPSG:26912",
        corner: [445_048.0, 4_448_995.0],
        pixels: [
            &[141.0, 140.0, 138.0],
            &[140.0, 148.0, 133.0],
            &[140.0, 148.0, 137.0],
        ],
    },
    Shipped {
        name: "shaded-relief.tif",
        size: (8192, 4096),
        bands: Bands::Colour,
        band_count: 3,
        crs: "EPSG:4326",
        corner: [-175.605_468_75, 85.605_468_75],
        pixels: [
            &[122.0, 170.0, 208.0],
            &[123.0, 168.0, 207.0],
            &[140.0, 180.0, 215.0],
        ],
    },
    Shipped {
        name: "wasatch-dem.tif",
        size: (1048, 1369),
        bands: Bands::Height,
        band_count: 1,
        crs: "EPSG:26912",
        corner: [422_692.770_000_473, 4_531_179.028_65],
        pixels: [&[1_288.904_8], &[2_132.876], &[1_282.983_6]],
    },
];

#[test]
fn every_file_has_the_size_place_and_samples_that_gdal_finds() {
    let folder: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../projects/data");
    for shipped in FILES {
        let name = shipped.name;
        let options = OpenOptions {
            make_pyramid: false,
            ..OpenOptions::default()
        };
        let file = open(&folder.join(name), &options).unwrap_or_else(|e| panic!("{name}: {e}"));
        let info = file.info();
        let full = info.overviews[0];
        assert_eq!((full.width, full.height), shipped.size, "{name}");
        assert_eq!(
            (info.bands, info.band_count),
            (shipped.bands, shipped.band_count),
            "{name}"
        );
        assert!(info.overviews.len() >= 3, "{name}");
        let place = info.georeference.clone().expect("a georeference");
        let (found, expected) = (
            Crs::parse(&place.crs).unwrap(),
            Crs::parse(shipped.crs).unwrap(),
        );
        assert!(found.same_as(&expected), "{name}: {}", place.crs);
        let [x0, dx, rx, y0, ry, dy] = place.plane_from_pixel;
        assert_eq!((rx, ry), (0.0, 0.0), "{name}");
        let corner = [x0 + 100.0 * dx, y0 + 100.0 * dy];
        for (f, e) in corner.iter().zip(shipped.corner) {
            assert!(
                (f - e).abs() < 1e-9 * e.abs().max(1.0),
                "{name}: {corner:?}"
            );
        }
        for ((x, y), expected) in PLACES.into_iter().zip(shipped.pixels) {
            let rect = PixelRect {
                x,
                y,
                width: 1,
                height: 1,
            };
            let mut block = Block::new(shipped.bands, 0, 0);
            file.read(0, rect, &mut block, &Cancel::default()).unwrap();
            let is_colour = shipped.bands == Bands::Colour;
            // JPEG decoders differ by a few levels.
            let (unit, tolerance) = if is_colour { (255.0, 4.0) } else { (1.0, 1e-3) };
            for (f, e) in block.samples().iter().zip(expected) {
                assert!(
                    (f * unit - e).abs() <= tolerance,
                    "{name} at ({x}, {y}): expected {expected:?}, found {:?}",
                    block.samples()
                );
            }
            assert!(!is_colour || block.samples()[3] == 1.0, "{name}: opaque");
        }
        let holes = matches!(name, "provo-aerial.tif" | "wasatch-dem.tif");
        assert_eq!(info.may_have_holes, holes, "{name}");
    }
}
