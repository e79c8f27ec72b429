//! Well-Known Binary geometries, as GeoPackages hold them: OGC 06-103r4 with Z and M in both the
//! ISO and the extended form.

use crate::error::{Fault, damaged, unsupported};
use crate::features::{Builder, Shape};

/// Collections within collections at most.
const MAX_DEPTH: u32 = 16;

/// Adds a geometry to the builder's current feature.
pub(super) fn add(builder: &mut Builder, wkb: &[u8]) -> Result<(), Fault> {
    let mut reader = Reader { rest: wkb };
    reader.geometry(builder, 0)
}

struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], Fault> {
        match self.rest.split_at_checked(count) {
            Some((taken, rest)) => {
                self.rest = rest;
                Ok(taken)
            }
            None => damaged(format!(
                "expected {count} more bytes of geometry, found {}",
                self.rest.len()
            )),
        }
    }

    fn u32(&mut self, little: bool) -> Result<u32, Fault> {
        let mut bytes = [0; 4];
        bytes.copy_from_slice(self.take(4)?);
        Ok(if little {
            u32::from_le_bytes(bytes)
        } else {
            u32::from_be_bytes(bytes)
        })
    }

    fn geometry(&mut self, builder: &mut Builder, depth: u32) -> Result<(), Fault> {
        let little = match self.take(1)?[0] {
            0 => false,
            1 => true,
            other => return damaged(format!("expected byte order 0 or 1, found {other}")),
        };
        let code = self.u32(little)?;
        if code & 0x2000_0000 != 0 {
            self.take(4)?;
        }
        let mut dimensions = 2;
        dimensions += usize::from(code & 0x8000_0000 != 0) + usize::from(code & 0x4000_0000 != 0);
        let code = code & 0x0FFF_FFFF;
        dimensions += match code / 1000 {
            0 => 0,
            1 | 2 => 1,
            3 => 2,
            _ => return unsupported(format!("expected a known geometry, found code {code}")),
        };
        match code % 1000 {
            1 => {
                let xy = self.positions(1, dimensions, little)?;
                // An empty point has NaN coordinates.
                builder.add(
                    Shape::Points,
                    xy.filter(|[x, y]| !(x.is_nan() || y.is_nan())),
                )
            }
            2 => {
                let count = self.u32(little)?;
                let xy = self.positions(count, dimensions, little)?;
                builder.add(Shape::Line, xy)
            }
            3 => {
                for ring in 0..self.u32(little)? {
                    let count = self.u32(little)?;
                    let xy = self.positions(count, dimensions, little)?;
                    builder.add(if ring == 0 { Shape::Outer } else { Shape::Hole }, xy)?;
                }
                Ok(())
            }
            4..=7 if depth < MAX_DEPTH => {
                for _ in 0..self.u32(little)? {
                    self.geometry(builder, depth + 1)?;
                }
                Ok(())
            }
            4..=7 => damaged("expected collections at most 16 deep, found more"),
            other => unsupported(format!(
                "expected points, lines and polygons, found geometry type {other} (curves are not read)"
            )),
        }
    }

    fn positions(
        &mut self,
        count: u32,
        dimensions: usize,
        little: bool,
    ) -> Result<impl Iterator<Item = [f64; 2]> + use<'a>, Fault> {
        let bytes = (count as usize).checked_mul(8 * dimensions);
        let bytes = self.take(bytes.unwrap_or(usize::MAX))?;
        let number = move |bytes: &[u8]| {
            let mut raw = [0; 8];
            raw.copy_from_slice(&bytes[..8]);
            if little {
                f64::from_le_bytes(raw)
            } else {
                f64::from_be_bytes(raw)
            }
        };
        Ok(bytes
            .chunks_exact(8 * dimensions)
            .map(move |p| [number(p), number(&p[8..])]))
    }
}
