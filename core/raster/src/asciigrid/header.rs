//! The lines before the numbers.

use super::index::Tokens;
use crate::fault::{Fault, damaged};
use crate::geotiff::{Bytes, check_affine};

/// Keywords with values at most; six are usual.
const MAX_KEYWORDS: usize = 16;
/// Keywords that a grid may begin with.
const KEYWORDS: [&str; 10] = [
    "ncols",
    "nrows",
    "xllcorner",
    "xllcenter",
    "yllcorner",
    "yllcenter",
    "cellsize",
    "dx",
    "dy",
    "nodata_value",
];

/// What the header says.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Header {
    /// Columns.
    pub(super) width: u32,
    /// Rows.
    pub(super) height: u32,
    west: f64,
    south: f64,
    dx: f64,
    dy: f64,
    pub(super) nodata: Option<f64>,
    /// Where the numbers begin.
    pub(super) data_at: u64,
}

/// Whether a file begins as grids do.
pub(crate) fn is_one(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head).to_ascii_lowercase();
    let Some((word, _)) = text.split_once(char::is_whitespace) else {
        return false;
    };
    KEYWORDS.contains(&word)
}

/// A number as text: with a point or a comma, `nan` and infinities included.
pub(super) fn number<T: core::str::FromStr>(token: &[u8]) -> Option<T> {
    let text = core::str::from_utf8(token).ok()?;
    text.parse()
        .ok()
        .or_else(|| text.replace(',', ".").parse().ok())
}

impl Header {
    /// Reads keywords and values up to the first number that no keyword precedes.
    pub(super) fn read(bytes: &Bytes) -> Result<Self, Fault> {
        let mut values: [Option<f64>; KEYWORDS.len()] = [None; KEYWORDS.len()];
        let mut tokens = Tokens::new(bytes, 0);
        let mut data_at = 0;
        for _ in 0..=MAX_KEYWORDS {
            let token = tokens.next()?.to_vec();
            let word = String::from_utf8_lossy(&token).to_ascii_lowercase();
            let Some(which) = KEYWORDS.iter().position(|k| *k == word) else {
                let is_value = token == b"*" || number::<f64>(&token).is_some();
                if !is_value {
                    return damaged(format!("expected a keyword or a number, found {word:?}"));
                }
                data_at = tokens.start();
                break;
            };
            let value = tokens.next()?;
            let Some(value) = number::<f64>(value) else {
                return damaged(format!(
                    "expected a number after {word}, found {:?}",
                    String::from_utf8_lossy(value)
                ));
            };
            values[which] = Some(value);
        }
        if data_at == 0 {
            return damaged(format!(
                "expected at most {MAX_KEYWORDS} keywords, found more"
            ));
        }
        let [ncols, nrows, xc, xm, yc, ym, cell, dx, dy, nodata] = values;
        let side = |name: &str, value: Option<f64>| {
            let value = value.unwrap_or(f64::NAN);
            if value >= 1.0 && value <= f64::from(i32::MAX) && libm::floor(value) == value {
                Ok(value as u32)
            } else {
                damaged(format!("expected {name} of at least 1, found {value}"))
            }
        };
        let (width, height) = (side("ncols", ncols)?, side("nrows", nrows)?);
        let (Some(dx), Some(dy)) = (dx.or(cell), dy.or(cell)) else {
            return damaged("expected a cellsize, or dx and dy, found none");
        };
        // The centre of the first sample lies half a cell inside of its corner.
        let (west, south) = (
            xc.or(xm.map(|x| x - 0.5 * dx)),
            yc.or(ym.map(|y| y - 0.5 * dy)),
        );
        let (Some(west), Some(south)) = (west, south) else {
            return damaged("expected xllcorner or xllcenter and yllcorner or yllcenter");
        };
        let header = Self {
            width,
            height,
            west,
            south,
            dx,
            dy,
            nodata: nodata.filter(|v| !v.is_nan()),
            data_at,
        };
        check_affine(&header.plane_from_pixel()).map_err(Fault::Damaged)?;
        if dx < 0.0 || dy < 0.0 {
            return damaged(format!(
                "expected cells of positive size, found {dx} × {dy}"
            ));
        }
        // Each number takes a digit at least, and a blank from the next one.
        let least = header.samples() * 2 - 1;
        if bytes.length() - data_at < least {
            return damaged(format!(
                "expected {} numbers, found {} bytes",
                header.samples(),
                bytes.length() - data_at
            ));
        }
        Ok(header)
    }

    /// Numbers that the grid has.
    pub(super) fn samples(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Rows run from north.
    pub(super) fn plane_from_pixel(&self) -> [f64; 6] {
        let north = self.south + self.dy * f64::from(self.height);
        [self.west, self.dx, 0.0, north, 0.0, -self.dy]
    }
}
