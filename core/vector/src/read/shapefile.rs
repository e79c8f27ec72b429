//! Shapefiles: shapes, their `.dbf` of properties and their `.prj`.

use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use dbase::FieldValue;
use relievo_raster::crs::from_prj_beside;
use shapefile::record::polygon::GenericPolygon;
use shapefile::{Patch, PolygonRing, Shape as Record};

use crate::error::{Fault, damaged, unsupported};
use crate::features::{Builder, Features, Shape};
use crate::open::{OpenOptions, Summary, system};
use crate::value::Value;

pub(crate) fn read(path: &Path, options: &OpenOptions) -> Result<(Features, Summary), Fault> {
    check(path)?;
    let mut remarks = Vec::new();
    let (crs, name) = system(options, from_prj_beside(path), &mut remarks)?;
    let mut builder = Builder::new(crs, options.limits, options.cancel.clone());
    let mut table = match companion(path, "dbf") {
        None => {
            remarks.push("has no .dbf beside it: features have no properties".into());
            None
        }
        Some(dbf) => {
            let file = BufReader::new(std::fs::File::open(dbf)?);
            Some(dbase::Reader::new(file).map_err(|e| of_table(&e))?)
        }
    };
    let names: Vec<String> = table
        .iter()
        .flat_map(|t| t.fields().iter().map(|f| f.name().to_owned()))
        .collect();
    let mut records = table.as_mut().map(dbase::Reader::iter_records);
    // The order in the file, which the index beside it may not change.
    let file = BufReader::new(std::fs::File::open(path)?);
    let mut shapes =
        shapefile::ShapeReader::new(file).map_err(|e| Fault::Damaged(e.to_string()))?;
    for shape in shapes.iter_shapes() {
        let shape = shape.map_err(|e| Fault::Damaged(e.to_string()))?;
        add(&mut builder, &shape)?;
        if let Some(record) = records.as_mut().and_then(Iterator::next) {
            let mut record = record.map_err(|e| of_table(&e))?;
            for name in &names {
                if let Some(field) = record.remove(name) {
                    builder.add_property(name, value(field))?;
                }
            }
        }
        builder.end_feature()?;
    }
    let summary = Summary {
        format: "Shapefile",
        crs: name,
        layers: Vec::new(),
        remarks,
    };
    Ok((builder.end()?, summary))
}

fn of_table(error: &dbase::Error) -> Fault {
    Fault::Damaged(format!("its .dbf: {error}"))
}

/// A file of the same name with another ending, in either case.
fn companion(path: &Path, ending: &str) -> Option<PathBuf> {
    [ending.to_owned(), ending.to_uppercase()]
        .into_iter()
        .map(|ending| path.with_extension(ending))
        .find(|p| p.is_file())
}

/// Walks over all records before the library believes them: it makes room for as many points as a
/// record claims.
fn check(path: &Path) -> Result<(), Fault> {
    let mut file = BufReader::new(std::fs::File::open(path)?);
    let length = file.seek(SeekFrom::End(0))?;
    let mut at = 100;
    if length < at {
        return damaged(format!("expected a header of 100 bytes, found {length}"));
    }
    let mut head = [0; 12];
    file.seek(SeekFrom::Start(24))?;
    file.read_exact(&mut head[..4])?;
    let claimed = 2 * u64::from(u32::from_be_bytes([head[0], head[1], head[2], head[3]]));
    if claimed > length {
        return damaged(format!(
            "expected {claimed} bytes as the header says, found {length}"
        ));
    }
    let int = |b: &[u8]| u64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    while at < claimed {
        file.seek(SeekFrom::Start(at))?;
        if at + 12 > claimed {
            return damaged(format!(
                "expected a record at byte {at}, found the file's end"
            ));
        }
        file.read_exact(&mut head)?;
        let content = 2 * u64::from(u32::from_be_bytes([head[4], head[5], head[6], head[7]]));
        if content < 4 || at + 8 + content > claimed {
            return damaged(format!(
                "expected a record of {content} bytes at byte {at}, found the file's end"
            ));
        }
        // Type, box of 32 bytes, then counts: of points, or of parts and points.
        let counts = match int(&head[8..]) {
            3 | 5 | 13 | 15 | 23 | 25 | 31 => 2,
            8 | 18 | 28 => 1,
            _ => 0,
        };
        if counts > 0 {
            if content < 36 + 4 * counts {
                return damaged(format!("expected counts in the record at byte {at}"));
            }
            let mut numbers = [0; 8];
            let numbers = &mut numbers[..4 * counts as usize];
            file.seek(SeekFrom::Start(at + 8 + 36))?;
            file.read_exact(numbers)?;
            let points = int(&numbers[numbers.len() - 4..]);
            let parts = if counts == 2 { int(numbers) } else { 0 };
            if 16 * points + 4 * parts > content {
                return damaged(format!(
                    "expected {points} points in {parts} parts, found a record of {content} bytes at byte {at}"
                ));
            }
        }
        at += 8 + content;
    }
    Ok(())
}

fn value(field: FieldValue) -> Value {
    let text = |text: String| Value::from(text.as_str());
    match field {
        FieldValue::Character(v) => v.map_or(Value::Null, text),
        FieldValue::Numeric(v) => v.map_or(Value::Null, number),
        FieldValue::Logical(v) => v.map_or(Value::Null, Value::Bool),
        FieldValue::Date(v) => v.map_or(Value::Null, |date| {
            text(format!(
                "{:04}-{:02}-{:02}",
                date.year(),
                date.month(),
                date.day()
            ))
        }),
        FieldValue::Float(v) => v.map_or(Value::Null, |v| Value::Float(f64::from(v))),
        FieldValue::Integer(v) => Value::Int(i64::from(v)),
        FieldValue::Currency(v) | FieldValue::Double(v) => Value::Float(v),
        FieldValue::DateTime(v) => text(format!("{v:?}")),
        FieldValue::Memo(v) => text(v),
    }
}

/// dBase has one type for all numbers: whole ones stay whole.
fn number(v: f64) -> Value {
    if v == libm::trunc(v) && v.abs() < 9e15 {
        Value::Int(v as i64)
    } else {
        Value::Float(v)
    }
}

fn add(builder: &mut Builder, record: &Record) -> Result<(), Fault> {
    /// Points of any kind as pairs.
    macro_rules! pairs {
        ($points:expr) => {
            $points.iter().map(|p| [p.x, p.y])
        };
    }
    /// Lines of any kind.
    macro_rules! lines {
        ($line:expr) => {
            $line
                .parts()
                .iter()
                .try_for_each(|part| builder.add(Shape::Line, pairs!(part)))
        };
    }
    match record {
        Record::NullShape => Ok(()),
        Record::Point(p) => builder.add(Shape::Points, [[p.x, p.y]]),
        Record::PointM(p) => builder.add(Shape::Points, [[p.x, p.y]]),
        Record::PointZ(p) => builder.add(Shape::Points, [[p.x, p.y]]),
        Record::Multipoint(m) => builder.add(Shape::Points, pairs!(m.points())),
        Record::MultipointM(m) => builder.add(Shape::Points, pairs!(m.points())),
        Record::MultipointZ(m) => builder.add(Shape::Points, pairs!(m.points())),
        Record::Polyline(l) => lines!(l),
        Record::PolylineM(l) => lines!(l),
        Record::PolylineZ(l) => lines!(l),
        Record::Polygon(p) => rings(builder, p, |p| [p.x, p.y]),
        Record::PolygonM(p) => rings(builder, p, |p| [p.x, p.y]),
        Record::PolygonZ(p) => rings(builder, p, |p| [p.x, p.y]),
        Record::Multipatch(m) => {
            // Seen from above; strips and fans of triangles have no outline to fill.
            for patch in m.patches() {
                match patch {
                    Patch::OuterRing(ring) | Patch::FirstRing(ring) | Patch::Ring(ring) => {
                        builder.add(Shape::Outer, pairs!(ring))?;
                    }
                    Patch::InnerRing(ring) => builder.add(Shape::Hole, pairs!(ring))?,
                    Patch::TriangleStrip(_) | Patch::TriangleFan(_) => {
                        return unsupported("expected rings in a multipatch, found triangles");
                    }
                }
            }
            Ok(())
        }
    }
}

/// Rings, of which the library knows by their direction which are holes.
fn rings<P>(
    builder: &mut Builder,
    polygon: &GenericPolygon<P>,
    pair: impl Fn(&P) -> [f64; 2],
) -> Result<(), Fault> {
    polygon.rings().iter().try_for_each(|ring| match ring {
        PolygonRing::Outer(points) => builder.add(Shape::Outer, points.iter().map(&pair)),
        PolygonRing::Inner(points) => builder.add(Shape::Hole, points.iter().map(&pair)),
    })
}
