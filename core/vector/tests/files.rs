//! Files of vectors: what GDAL wrote is read as it means it, and no damage does harm.
#![expect(clippy::unwrap_used, reason = "tests")]

use std::path::{Path, PathBuf};

use relievo_vector::write::{Feature, Geometry, Position, write_geojson, write_geopackage};
use relievo_vector::{Features, OpenOptions, Shape, Value, VectorError, is_vector, open};

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data")
        .join(name)
}

fn read(name: &str) -> Features {
    open(&data(name), &OpenOptions::default()).unwrap().0
}

fn layer(name: &str) -> Features {
    let options = OpenOptions {
        layer: Some(name.to_owned()),
        ..OpenOptions::default()
    };
    open(&data("all.gpkg"), &options).unwrap().0
}

/// Features are the same: shapes, vertices within a millimetre, properties.
fn assert_same(found: &Features, expected: &Features, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for f in 0..expected.len() {
        // FlatGeobuf sorts features by place: match them by name.
        let name = expected.property(f, "name");
        let g = (0..found.len()).find(|g| found.property(*g, "name") == name);
        let g = g.unwrap_or_else(|| panic!("{what}: no {name}"));
        let (a, b): (Vec<_>, Vec<_>) =
            (found.outlines(g).collect(), expected.outlines(f).collect());
        assert_eq!(a.len(), b.len(), "{what}: parts of {name}");
        for (a, b) in a.iter().zip(&b) {
            assert_eq!(
                (a.shape, a.lonlat_rad.len()),
                (b.shape, b.lonlat_rad.len()),
                "{what}"
            );
            let same = |i: usize| {
                // Rings may begin anywhere.
                let closest = b.lonlat_rad.iter().map(|v| v.distance(a.lonlat_rad[i]));
                closest.fold(f64::INFINITY, f64::min) < 1.5e-10
            };
            assert!((0..a.lonlat_rad.len()).all(same), "{what}: {name}");
        }
        for (property, value) in expected.properties(f) {
            let found = found.property(g, property);
            let yes = matches!((found, value), (Value::Int(1), Value::Bool(true)));
            let no = matches!((found, value), (Value::Int(0), Value::Bool(false)));
            assert!(
                found.means(value) || yes || no,
                "{what}: {property} is {found:?}"
            );
        }
    }
}

#[test]
fn all_formats_hold_what_the_geojson_holds() {
    for name in ["parcels", "ways", "stops"] {
        let expected = read(&format!("{name}.geojson"));
        for ending in ["fgb", "shp"] {
            let file = format!("{name}.{ending}");
            assert!(is_vector(&data(&file)));
            assert_same(&read(&file), &expected, &file);
        }
        assert_same(&layer(name), &expected, name);
    }
}

#[test]
fn a_geopackage_says_which_tables_it_holds() {
    let (features, summary) = open(&data("all.gpkg"), &OpenOptions::default()).unwrap();
    assert_eq!(summary.layers, ["parcels", "ways", "stops"]);
    assert!(summary.remarks[0].contains("3 tables"), "{summary:?}");
    assert_eq!((features.len(), &*summary.crs), (2, "EPSG:26912"));
    let options = OpenOptions {
        layer: Some("roads".into()),
        ..OpenOptions::default()
    };
    let error = open(&data("all.gpkg"), &options).unwrap_err().to_string();
    assert!(
        error.contains("\"roads\"") && error.contains("parcels, ways, stops"),
        "{error}"
    );
}

#[test]
fn properties_of_a_table_are_text_in_utf_8() {
    assert_eq!(
        read("parcels.shp").property(0, "name"),
        &Value::from("Großes Feld")
    );
}

/// Opens damaged bytes: any result but a panic will do; an error is one line.
fn harmless(folder: &Path, name: &str, bytes: &[u8]) -> Result<(), VectorError> {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    match open(&path, &OpenOptions::default()) {
        Ok(_) => Ok(()),
        Err(error) => {
            let line = error.to_string();
            assert!(!line.contains('\n') && line.contains(name), "{line}");
            assert!(!line.contains("panic"), "{line}");
            Err(error)
        }
    }
}

#[test]
fn a_file_cut_short_anywhere_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    for name in [
        "parcels.geojson",
        "parcels.fgb",
        "ways.fgb",
        "parcels.shp",
        "ways.shp",
        "stops.shp",
    ] {
        let bytes = std::fs::read(data(name)).unwrap();
        let end = bytes.trim_ascii_end().len();
        for length in 0..end {
            let read = harmless(folder.path(), name, &bytes[..length]);
            assert!(read.is_err(), "{name} cut to {length} bytes");
        }
    }
    let bytes = std::fs::read(data("all.gpkg")).unwrap();
    for length in (0..bytes.len()).step_by(4099) {
        let read = harmless(folder.path(), "all.gpkg", &bytes[..length]);
        assert!(read.is_err() || length > bytes.len() / 2, "cut to {length}");
    }
}

#[test]
fn a_wrong_byte_anywhere_does_no_harm() {
    let folder = tempfile::tempdir().unwrap();
    for name in [
        "parcels.geojson",
        "parcels.fgb",
        "stops.shp",
        "parcels.shp",
        "all.gpkg",
    ] {
        let bytes = std::fs::read(data(name)).unwrap();
        let step = (bytes.len() / 250).max(1);
        for at in (0..bytes.len()).step_by(step) {
            for value in [0x00, 0x7F, 0xFF] {
                let mut bytes = bytes.clone();
                bytes[at] = value;
                let _told = harmless(folder.path(), name, &bytes);
            }
        }
    }
    // The table beside the shapes.
    std::fs::copy(data("parcels.shp"), folder.path().join("parcels.shp")).unwrap();
    let table = std::fs::read(data("parcels.dbf")).unwrap();
    for at in (0..table.len()).step_by(2) {
        for value in [0x00, 0x7F, 0xFF] {
            let mut bytes = table.clone();
            bytes[at] = value;
            std::fs::write(folder.path().join("parcels.dbf"), bytes).unwrap();
            let _told = open(&folder.path().join("parcels.shp"), &OpenOptions::default());
        }
    }
}

#[test]
fn what_is_no_vector_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (text, expected) in [
        ("", "found something else"),
        ("hello", "found something else"),
        ("{}", "found none"),
        ("{\"type\":\"Topology\"}", "Topology"),
        (
            "{\"type\":\"FeatureCollection\",\"features\":[{\"type\":\"Feature\",\"geometry\":{\"type\":\"Point\",\"coordinates\":[500000,4000000]},\"properties\":{}}]}",
            "is the system right",
        ),
    ] {
        let error = harmless(folder.path(), "file.json", text.as_bytes()).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
    let deep = "{\"type\":\"GeometryCollection\",\"geometries\":[".repeat(10_000);
    harmless(folder.path(), "deep.json", deep.as_bytes()).unwrap_err();
}

#[test]
fn an_older_geojson_names_its_system() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("utm.geojson");
    let text = r#"{"type":"FeatureCollection","features":[{"type":"Feature","id":"a7","properties":null,
      "geometry":{"type":"Point","coordinates":[440422.649305824,4450190.55924689]}}],
      "crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::26912"}}}"#;
    std::fs::write(&path, text).unwrap();
    let (features, summary) = open(&path, &OpenOptions::default()).unwrap();
    assert_eq!(&*summary.crs, "EPSG:26912");
    let at = features.outlines(0).next().unwrap().lonlat_rad[0];
    assert!((at.x.to_degrees() + 111.7).abs() < 1e-9 && (at.y.to_degrees() - 40.2).abs() < 1e-9);
    assert_eq!(features.property(0, "id"), &Value::from("a7"));
}

fn features() -> Vec<Feature> {
    let p = |lon_deg, lat_deg, height_m| Position {
        lon_deg,
        lat_deg,
        height_m,
    };
    vec![
        Feature {
            geometry: Geometry::Polygons(vec![vec![
                vec![
                    p(8.0, 47.0, Some(400.0)),
                    p(8.0, 47.1, Some(410.0)),
                    p(8.1, 47.0, Some(1.5)),
                ],
                vec![
                    p(8.01, 47.01, None),
                    p(8.02, 47.01, None),
                    p(8.01, 47.02, None),
                ],
            ]]),
            properties: vec![
                ("name".into(), Value::from("Damm \"A\"")),
                ("fid".into(), Value::Int(7)),
                ("volume_m3".into(), Value::Float(12.25)),
            ],
        },
        Feature {
            geometry: Geometry::Lines(vec![vec![p(8.0, 47.0, None), p(8.5, 47.5, None)]]),
            properties: vec![
                ("name".into(), Value::from("line")),
                ("volume_m3".into(), Value::Null),
            ],
        },
        Feature {
            geometry: Geometry::Points(vec![p(8.0, 47.0, None), p(8.5, 47.5, None)]),
            properties: vec![("name".into(), Value::from("points"))],
        },
    ]
}

#[test]
fn what_is_written_is_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let (json, package) = (
        folder.path().join("a.geojson"),
        folder.path().join("a.gpkg"),
    );
    write_geojson(&json, &features()).unwrap();
    write_geopackage(&package, "my \"table\"", &features()).unwrap();
    for path in [&json, &package] {
        let (found, _) = open(path, &OpenOptions::default()).unwrap();
        assert_eq!(found.len(), 3);
        assert_eq!(found.property(0, "name"), &Value::from("Damm \"A\""));
        assert_eq!(found.property(0, "volume_m3"), &Value::Float(12.25));
        assert_eq!(found.property(1, "volume_m3"), &Value::Null);
        let vertices = |feature: usize, shape: Shape| -> usize {
            let outlines = found.outlines(feature).filter(|o| o.shape == shape);
            outlines.map(|o| o.lonlat_rad.len()).sum()
        };
        assert_eq!(vertices(0, Shape::Outer), 4);
        assert_eq!(vertices(0, Shape::Hole), 4);
        assert_eq!(vertices(1, Shape::Line), 2);
        assert_eq!(vertices(2, Shape::Points), 2);
    }
    let once = std::fs::read(&package).unwrap();
    write_geopackage(&package, "my \"table\"", &features()).unwrap();
    assert_eq!(once, std::fs::read(&package).unwrap(), "the same bytes");
}

#[test]
fn nothing_is_left_of_a_file_that_cannot_be_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.geojson");
    let mut features = features();
    features[1].geometry = Geometry::Points(vec![Position::new(f64::NAN, 0.0)]);
    let error = write_geojson(&path, &features).unwrap_err().to_string();
    assert!(error.contains("feature 1"), "{error}");
    write_geopackage(&path, "t", &features).unwrap_err();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
