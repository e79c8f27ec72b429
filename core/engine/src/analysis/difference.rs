//! How the heights of two versions differ, as a raster file.

use std::path::Path;
use std::sync::Arc;

use relievo_raster::write::{CogLayout, CogSamples, CogWork, write_cog};
use relievo_raster::{Cancel, PixelRect};

use super::compare::Comparison;
use crate::bake::{BLOCK, Bake, BakeError, Output};
use crate::query::Questions;

impl Comparison {
    /// Writes the second version's heights minus the first one's to a GeoTIFF (`.tif`, Cloud
    /// Optimised, any size), noise included; `bake.output` does not count. Made on `threads` threads;
    /// the file is the same for any number.
    ///
    /// # Errors
    /// [`BakeError`]; a file that was there before is untouched then.
    pub fn bake_difference(
        &self,
        bake: &Bake,
        path: &Path,
        threads: usize,
        progress: &mut dyn FnMut(f64),
        cancel: &Cancel,
    ) -> Result<(), BakeError> {
        let extension = path.extension().and_then(|e| e.to_str());
        let known = extension
            .is_some_and(|e| e.eq_ignore_ascii_case("tif") || e.eq_ignore_ascii_case("tiff"));
        if !known {
            return Err(BakeError::Region(format!(
                "expected a name that ends in .tif, found \"{}\"",
                path.display()
            )));
        }
        let bake = Bake {
            output: Output::Height,
            ..bake.clone()
        };
        let [a, b] = [0, 1].map(|version| Questions {
            scene: Arc::clone(&self.shown[version]),
            surveyed: Arc::clone(&self.measured[version]),
            planet: self.planet,
        });
        let (before, after) = (a.plan(&bake)?, b.plan(&bake)?);
        let layout = CogLayout {
            width: after.width,
            height: after.height,
            samples: CogSamples::Height { nodata: -32767.0 },
            tile: BLOCK,
            georeference: Some(after.georeference.clone()),
            largest_classic_bytes: CogLayout::LARGEST_CLASSIC_BYTES,
        };
        let source = |rect: PixelRect| {
            let mut block = b.block(&after, rect, cancel)?;
            let base = a.block(&before, rect, cancel)?;
            for (height, base) in block.plane_mut(0).iter_mut().zip(base.plane(0)) {
                *height -= base;
            }
            Ok(block)
        };
        let work = CogWork {
            threads,
            resume: None,
            cancel,
        };
        Ok(write_cog(path, &layout, &source, &work, progress)?)
    }
}
