//! Making features, vertex by vertex, as readers meet them.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use core::f64::consts::{PI, TAU};
use glam::DVec2;
use relievo_raster::Cancel;
use relievo_raster::crs::Crs;

use super::index::Index;
use super::ring::{ring, unwrap};
use super::{Bounds, Feature, Features, Part, Shape, chunks};
use crate::Value;
use crate::error::{Fault, unsupported};

/// How much of a file is taken in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Features at most.
    pub features: usize,
    /// Vertices of all features at most; each takes about 20 bytes.
    pub vertices: usize,
    /// Bytes of all texts in properties at most.
    pub text_bytes: usize,
    /// Bytes of a file at most.
    pub file_bytes: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            features: 5_000_000,
            vertices: 100_000_000,
            text_bytes: 1 << 30,
            file_bytes: 4 << 30,
        }
    }
}

/// A piece of a feature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outline<'a> {
    /// What it is.
    pub shape: Shape,
    /// The pole that a ring goes around: 1 north, −1 south, 0 none. Its inside reaches to that pole.
    pub pole: i8,
    /// Longitudes and latitudes in radians. Rings are closed; outer ones run counterclockwise.
    pub lonlat_rad: &'a [DVec2],
}

/// Collects features. Coordinates are those of a coordinate system; longitudes and latitudes in
/// degrees where there is none.
pub struct Builder {
    crs: Option<Crs>,
    limits: Limits,
    cancel: Cancel,
    features: Features,
    boxes: Vec<Bounds>,
    columns: HashMap<Arc<str>, u16>,
    texts: HashSet<Arc<str>>,
    text_bytes: usize,
    properties: Vec<(u16, Value)>,
    first_part: usize,
    /// Middle of the latest outer ring: its holes lie on the same turn.
    outer_lon: Option<f64>,
    hasher: blake3::Hasher,
}

/// Texts up to this length are kept once however often they come.
const INTERNED: usize = 64;

impl Builder {
    /// A builder for features in degrees of longitude and latitude.
    pub fn degrees() -> Self {
        Self::new(None, Limits::default(), Cancel::default())
    }

    /// A builder for features in a coordinate system.
    pub fn new(crs: Option<Crs>, limits: Limits, cancel: Cancel) -> Self {
        // Degrees need no transform where the datum is that of the globe.
        let plain = |crs: &Crs| Crs::parse("EPSG:4326").is_ok_and(|wgs84| wgs84.same_as(crs));
        Self {
            crs: crs.filter(|crs| !plain(crs)),
            limits,
            cancel,
            features: Features {
                vertices: Vec::new(),
                parts: Vec::new(),
                all: Vec::new(),
                columns: Vec::new(),
                chunks: Vec::new(),
                index: Index::default(),
                hash: [0; 32],
                lost: 0,
            },
            boxes: Vec::new(),
            columns: HashMap::new(),
            texts: HashSet::new(),
            text_bytes: 0,
            properties: Vec::new(),
            first_part: 0,
            outer_lon: None,
            hasher: blake3::Hasher::new(),
        }
    }

    /// Adds points of the current feature.
    ///
    /// # Errors
    /// One line where the features exceed the limits.
    pub fn points(&mut self, xy: impl IntoIterator<Item = [f64; 2]>) -> Result<(), String> {
        self.add(Shape::Points, xy).map_err(|e| e.to_string())
    }

    /// Adds a line of the current feature.
    ///
    /// # Errors
    /// One line where the features exceed the limits.
    pub fn line(&mut self, xy: impl IntoIterator<Item = [f64; 2]>) -> Result<(), String> {
        self.add(Shape::Line, xy).map_err(|e| e.to_string())
    }

    /// Adds a ring of the current feature: an outer one, then its holes. In any direction, closed
    /// or not.
    ///
    /// # Errors
    /// One line where the features exceed the limits.
    pub fn ring(
        &mut self,
        xy: impl IntoIterator<Item = [f64; 2]>,
        is_hole: bool,
    ) -> Result<(), String> {
        let shape = if is_hole { Shape::Hole } else { Shape::Outer };
        self.add(shape, xy).map_err(|e| e.to_string())
    }

    /// Adds a property of the current feature.
    ///
    /// # Errors
    /// One line where the features exceed the limits.
    pub fn property(&mut self, name: &str, value: Value) -> Result<(), String> {
        self.add_property(name, value).map_err(|e| e.to_string())
    }

    /// Ends the current feature, with or without geometry.
    ///
    /// # Errors
    /// One line where the features exceed the limits.
    pub fn feature(&mut self) -> Result<(), String> {
        self.end_feature().map_err(|e| e.to_string())
    }

    pub(crate) fn add_property(&mut self, name: &str, value: Value) -> Result<(), Fault> {
        if value == Value::Null {
            return Ok(());
        }
        let column = if let Some(column) = self.columns.get(name) {
            *column
        } else {
            let Ok(column) = u16::try_from(self.columns.len()) else {
                return unsupported("expected at most 65536 different properties, found more");
            };
            self.spend_text(name.len())?;
            let name: Arc<str> = name.into();
            self.features.columns.push(Arc::clone(&name));
            self.columns.insert(name, column);
            column
        };
        let value = match value {
            Value::Text(text) => Value::Text(self.intern(text)?),
            other @ (Value::Null | Value::Bool(_) | Value::Int(_) | Value::Float(_)) => other,
        };
        self.properties.push((column, value));
        Ok(())
    }

    fn intern(&mut self, text: Arc<str>) -> Result<Arc<str>, Fault> {
        if let Some(known) = self.texts.get(&text) {
            return Ok(Arc::clone(known));
        }
        self.spend_text(text.len())?;
        if text.len() <= INTERNED {
            self.texts.insert(Arc::clone(&text));
        }
        Ok(text)
    }

    fn spend_text(&mut self, bytes: usize) -> Result<(), Fault> {
        // What a text costs besides its bytes.
        self.text_bytes += bytes + 32;
        if self.text_bytes > self.limits.text_bytes {
            return unsupported(format!(
                "expected at most {} bytes of text in properties, found more",
                self.limits.text_bytes
            ));
        }
        Ok(())
    }

    pub(crate) fn end_feature(&mut self) -> Result<(), Fault> {
        if self.features.all.len() >= self.limits.features {
            return unsupported(format!(
                "expected at most {} features, found more",
                self.limits.features
            ));
        }
        if self.features.all.len().is_multiple_of(256) && self.cancel.is_cancelled() {
            return Err(Fault::Cancelled);
        }
        let parts = &self.features.parts[self.first_part..];
        let mut geometry = blake3::Hasher::new();
        for part in parts {
            geometry.update(&[part.shape as u8, part.pole as u8]);
            geometry.update(&u64::from(part.length).to_le_bytes());
            for v in self.features.vertices_of(part) {
                geometry.update(&v.x.to_bits().to_le_bytes());
                geometry.update(&v.y.to_bits().to_le_bytes());
            }
        }
        let full = geometry.finalize();
        self.hasher.update(full.as_bytes());
        for (column, value) in &self.properties {
            let text = format!("{value:?}");
            self.hasher.update(&column.to_le_bytes());
            self.hasher.update(&(text.len() as u64).to_le_bytes());
            self.hasher.update(text.as_bytes());
        }
        let mut hash = [0; 16];
        hash.copy_from_slice(&full.as_bytes()[..16]);
        self.features.all.push(Feature {
            first_part: self.first_part as u32,
            parts: parts.len() as u32,
            hash,
            properties: std::mem::take(&mut self.properties).into_boxed_slice(),
        });
        self.first_part = self.features.parts.len();
        self.outer_lon = None;
        Ok(())
    }

    /// Adds a part of the current feature.
    pub(crate) fn add(
        &mut self,
        shape: Shape,
        xy: impl IntoIterator<Item = [f64; 2]>,
    ) -> Result<(), Fault> {
        let room = self.limits.vertices - self.features.vertices.len().min(self.limits.vertices);
        let mut raw = Vec::new();
        let mut vertices = Vec::new();
        for (i, [x, y]) in xy.into_iter().enumerate() {
            if i >= room {
                return unsupported(format!(
                    "expected at most {} vertices, found more",
                    self.limits.vertices
                ));
            }
            if i.is_multiple_of(4096) && self.cancel.is_cancelled() {
                return Err(Fault::Cancelled);
            }
            match self.place(x, y) {
                Some(place) => vertices.push(place),
                None => self.features.lost += 1,
            }
            if self.crs.is_some() && matches!(shape, Shape::Outer | Shape::Hole) {
                raw.push(DVec2::new(x, y));
            }
        }
        let mut pole = 0;
        match shape {
            Shape::Points => {
                for v in &mut vertices {
                    v.x = wrap(v.x);
                }
            }
            Shape::Line => {
                vertices.dedup();
                unwrap(&mut vertices);
            }
            Shape::Outer | Shape::Hole => {
                let north = self.encloses_north(&raw);
                match ring(vertices, shape == Shape::Hole, north) {
                    Some(found) => (vertices, pole) = (found.vertices, found.pole),
                    None => return Ok(()),
                }
            }
        }
        self.keep(shape, pole, &vertices)
    }

    fn keep(&mut self, shape: Shape, pole: i8, vertices: &[DVec2]) -> Result<(), Fault> {
        let Some(mut bounds) = Bounds::around(vertices.iter().copied()) else {
            return Ok(());
        };
        let middle = bounds.centre().x;
        let target = match (shape, self.outer_lon) {
            (Shape::Hole, Some(outer)) => outer + wrap(middle - outer),
            _ => wrap(middle),
        };
        let turns = libm::round((target - middle) / TAU);
        bounds = bounds.turned(turns as i32);
        if shape == Shape::Outer {
            self.outer_lon = Some(bounds.centre().x);
        }
        match pole {
            1 => bounds.max.y = core::f64::consts::FRAC_PI_2,
            -1 => bounds.min.y = -core::f64::consts::FRAC_PI_2,
            _ => {}
        }
        let features = &mut self.features;
        let first = features.vertices.len();
        let by = f64::from(turns as i32) * TAU;
        features
            .vertices
            .extend(vertices.iter().map(|v| DVec2::new(v.x + by, v.y)));
        let Ok(feature) = u32::try_from(features.all.len()) else {
            return unsupported("expected fewer features");
        };
        if u32::try_from(features.vertices.len()).is_err()
            || u32::try_from(features.parts.len()).is_err()
        {
            return unsupported("expected fewer than 2³² vertices, found more");
        }
        let at = features.chunks.len() as u32;
        chunks::append(&features.vertices[first..], &mut features.chunks);
        features.parts.push(Part {
            shape,
            pole,
            feature,
            first: first as u32,
            length: vertices.len() as u32,
            chunks: at,
            bounds,
        });
        self.boxes.push(bounds);
        Ok(())
    }

    /// Longitude and latitude of coordinates; `None` where there is no such place.
    fn place(&self, x: f64, y: f64) -> Option<DVec2> {
        if let Some(crs) = &self.crs {
            return crs.to_lonlat(x, y).ok().map(DVec2::from);
        }
        let fine = x.abs() <= 36_000.0 && y.abs() <= 90.0 + 1e-6;
        fine.then(|| DVec2::new(x.to_radians(), y.clamp(-90.0, 90.0).to_radians()))
    }

    /// Whether a ring that goes around the globe encloses the north pole, as its own plane shows it.
    fn encloses_north(&self, raw: &[DVec2]) -> Option<bool> {
        let crs = self.crs.as_ref().filter(|crs| !crs.is_geographic())?;
        let inside = |lat: f64| {
            let (x, y) = crs.from_lonlat(0.0, lat).ok()?;
            let p = DVec2::new(x, y);
            let mut odd = false;
            for (i, a) in raw.iter().enumerate() {
                let b = raw[(i + 1) % raw.len()];
                if (a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x
                {
                    odd = !odd;
                }
            }
            Some(odd)
        };
        let (north, south) = (
            inside(core::f64::consts::FRAC_PI_2),
            inside(-core::f64::consts::FRAC_PI_2),
        );
        match (north, south) {
            (Some(true), _) => Some(true),
            (_, Some(true)) => Some(false),
            _ => None,
        }
    }

    /// The features; `Err` with one line where no vertex of the file lies on the planet.
    ///
    /// # Errors
    /// One line that says what is wrong.
    pub fn finish(self) -> Result<Features, String> {
        self.end().map_err(|e| e.to_string())
    }

    pub(crate) fn end(mut self) -> Result<Features, Fault> {
        if self.first_part < self.features.parts.len() || !self.properties.is_empty() {
            self.end_feature()?;
        }
        let mut features = self.features;
        if features.lost > 0 && features.vertices.is_empty() {
            return unsupported(format!(
                "expected vertices on the planet, found all {} outside of the coordinate system's domain: is the system right?",
                features.lost
            ));
        }
        for column in &features.columns {
            self.hasher.update(column.as_bytes());
            self.hasher.update(&[0]);
        }
        features.hash = *self.hasher.finalize().as_bytes();
        features.vertices.shrink_to_fit();
        features.parts.shrink_to_fit();
        features.index = Index::new(self.boxes.into_iter());
        Ok(features)
    }
}

/// A longitude brought to −π ≤ x < π.
fn wrap(lon_rad: f64) -> f64 {
    if (-PI..PI).contains(&lon_rad) {
        lon_rad
    } else {
        relievo_planet::map::wrap_longitude(lon_rad)
    }
}
