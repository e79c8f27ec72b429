//! FlatGeobuf.

use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use flatgeobuf::geozero::error::Result as ZeroResult;
use flatgeobuf::geozero::{ColumnValue, FeatureProperties, PropertyProcessor};
use flatgeobuf::{FallibleStreamingIterator, FgbReader, Geometry, GeometryType};
use relievo_raster::crs::from_wkt;

use crate::error::{Fault, damaged, unsupported};
use crate::features::{Builder, Features, Shape};
use crate::open::{OpenOptions, Summary, system};
use crate::value::Value;

/// Bytes of a node of the file's own index.
const NODE_BYTES: u64 = 40;

/// Collections within collections at most.
const MAX_DEPTH: u32 = 16;

pub(crate) fn read(path: &Path, options: &OpenOptions) -> Result<(Features, Summary), Fault> {
    check(path)?;
    let file = std::fs::File::open(path)?;
    let reader = FgbReader::open(BufReader::new(file)).map_err(library)?;
    let header = reader.header();
    let of_all = header.geometry_type();
    let own = header.crs().and_then(|crs| {
        let authority = crs.org().unwrap_or("EPSG").to_ascii_uppercase();
        if crs.code() > 0 {
            Some(format!("{authority}:{}", crs.code()))
        } else {
            crs.wkt().and_then(from_wkt)
        }
    });
    let mut remarks = Vec::new();
    let (crs, name) = system(options, own, &mut remarks)?;
    let mut builder = Builder::new(crs, options.limits, options.cancel.clone());
    let mut features = reader.select_all_seq().map_err(library)?;
    while let Some(feature) = features.next().map_err(library)? {
        if let Some(geometry) = feature.geometry() {
            add(&mut builder, &geometry, of_all, 0)?;
        }
        let mut properties = Properties {
            builder: &mut builder,
            fault: None,
        };
        let read = feature.process_properties(&mut properties);
        if let Some(fault) = properties.fault {
            return Err(fault);
        }
        read.map_err(|e| Fault::Damaged(e.to_string()))?;
        builder.end_feature()?;
    }
    let summary = Summary {
        format: "FlatGeobuf",
        crs: name,
        layers: Vec::new(),
        remarks,
    };
    Ok((builder.end()?, summary))
}

/// By value, as `map_err` hands it over.
#[expect(
    clippy::needless_pass_by_value,
    reason = "the shape that map_err asks for"
)]
fn library(error: flatgeobuf::Error) -> Fault {
    Fault::Damaged(error.to_string())
}

/// Walks over the sizes of all parts of the file before the library believes them: it makes room for
/// what a size claims.
fn check(path: &Path) -> Result<(), Fault> {
    let mut file = BufReader::new(std::fs::File::open(path)?);
    let length = file.seek(SeekFrom::End(0))?;
    let mut size = [0; 4];
    file.seek(SeekFrom::Start(8))?;
    file.read_exact(&mut size)?;
    let header = u64::from(u32::from_le_bytes(size));
    if 12 + header > length {
        return damaged(format!(
            "expected a header of {header} bytes, found the end of the file"
        ));
    }
    file.rewind()?;
    let reader = FgbReader::open(&mut file).map_err(library)?;
    let (count, node) = (
        reader.header().features_count(),
        u64::from(reader.header().index_node_size()),
    );
    drop(reader);
    let mut at = 12 + header;
    if node > 0 && count > 0 {
        if node < 2 || count > length {
            return damaged(format!(
                "expected an index of at most {length} features with nodes of 2 or more, found {count} and {node}"
            ));
        }
        let (mut nodes, mut level) = (count, count);
        while level > 1 {
            level = level.div_ceil(node);
            nodes += level;
        }
        // One feature alone still has a root above it.
        nodes += u64::from(count == 1);
        at += nodes * NODE_BYTES;
    }
    let mut found = 0;
    while at < length {
        file.seek(SeekFrom::Start(at))?;
        file.read_exact(&mut size)?;
        let feature = u64::from(u32::from_le_bytes(size));
        at += 4 + feature;
        if at > length || feature < 8 {
            return damaged(format!(
                "expected a feature of {feature} bytes, found the end of the file"
            ));
        }
        found += 1;
    }
    if at > length || (count > 0 && found != count) {
        return damaged(format!("expected {count} features, found {found}"));
    }
    Ok(())
}

struct Properties<'a> {
    builder: &'a mut Builder,
    fault: Option<Fault>,
}

impl PropertyProcessor for Properties<'_> {
    fn property(&mut self, _column: usize, name: &str, value: &ColumnValue) -> ZeroResult<bool> {
        let value = match value {
            ColumnValue::Byte(v) => Value::Int(i64::from(*v)),
            ColumnValue::UByte(v) => Value::Int(i64::from(*v)),
            ColumnValue::Bool(v) => Value::Bool(*v),
            ColumnValue::Short(v) => Value::Int(i64::from(*v)),
            ColumnValue::UShort(v) => Value::Int(i64::from(*v)),
            ColumnValue::Int(v) => Value::Int(i64::from(*v)),
            ColumnValue::UInt(v) => Value::Int(i64::from(*v)),
            ColumnValue::Long(v) => Value::Int(*v),
            ColumnValue::ULong(v) => i64::try_from(*v).map_or(Value::Float(*v as f64), Value::Int),
            ColumnValue::Float(v) => Value::Float(f64::from(*v)),
            ColumnValue::Double(v) => Value::Float(*v),
            ColumnValue::String(v) | ColumnValue::Json(v) | ColumnValue::DateTime(v) => {
                Value::from(*v)
            }
            ColumnValue::Binary(v) => Value::from(&*format!("{} bytes", v.len())),
        };
        if let Err(fault) = self.builder.add_property(name, value) {
            self.fault = Some(fault);
            return Ok(true);
        }
        Ok(false)
    }
}

fn add(
    builder: &mut Builder,
    geometry: &Geometry,
    of_all: GeometryType,
    depth: u32,
) -> Result<(), Fault> {
    let kind = if of_all == GeometryType::Unknown || depth > 0 {
        geometry.type_()
    } else {
        of_all
    };
    let parts = |builder: &mut Builder, kind: GeometryType| -> Result<(), Fault> {
        if depth >= MAX_DEPTH {
            return damaged("expected collections at most 16 deep, found more");
        }
        for part in geometry.parts().iter().flatten() {
            // Parts of a multi-polygon need not say that they are polygons.
            if kind == GeometryType::Polygon {
                polygon(builder, &part)?;
            } else {
                add(builder, &part, GeometryType::Unknown, depth + 1)?;
            }
        }
        Ok(())
    };
    match kind {
        GeometryType::Point | GeometryType::MultiPoint => {
            builder.add(Shape::Points, pieces(geometry)?.into_iter().flatten())
        }
        GeometryType::LineString | GeometryType::MultiLineString => pieces(geometry)?
            .into_iter()
            .try_for_each(|line| builder.add(Shape::Line, line)),
        GeometryType::Polygon => polygon(builder, geometry),
        GeometryType::MultiPolygon => parts(builder, GeometryType::Polygon),
        GeometryType::GeometryCollection => parts(builder, GeometryType::Unknown),
        other => unsupported(format!(
            "expected points, lines and polygons, found {other:?} (curves are not read)"
        )),
    }
}

fn polygon(builder: &mut Builder, geometry: &Geometry) -> Result<(), Fault> {
    for (i, ring) in pieces(geometry)?.into_iter().enumerate() {
        builder.add(if i == 0 { Shape::Outer } else { Shape::Hole }, ring)?;
    }
    Ok(())
}

/// Coordinates, split where the geometry says.
fn pieces(geometry: &Geometry) -> Result<Vec<Vec<[f64; 2]>>, Fault> {
    let numbers: Vec<f64> = geometry.xy().iter().flatten().collect();
    let xy: Vec<[f64; 2]> = numbers.chunks_exact(2).map(|p| [p[0], p[1]]).collect();
    let ends: Vec<usize> = geometry
        .ends()
        .iter()
        .flatten()
        .map(|e| e as usize)
        .collect();
    if ends.is_empty() {
        return Ok(vec![xy]);
    }
    let mut first = 0;
    let mut all = Vec::new();
    for end in ends {
        let Some(piece) = xy.get(first..end) else {
            return damaged(format!(
                "expected pieces within {} vertices, found one from {first} to {end}",
                xy.len()
            ));
        };
        all.push(piece.to_vec());
        first = end;
    }
    Ok(all)
}
