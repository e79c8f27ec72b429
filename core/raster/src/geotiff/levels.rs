//! The images of a TIFF and of the files beside it: full size, overviews, masks.

use std::path::Path;
use std::sync::Arc;

use super::bytes::Bytes;
use super::companions::Companions;
use super::fault::{Fault, damaged};
use super::ifd::{Ifd, TiffBytes, tag};
use super::layout::{Layout, SampleFormat, photometric};

/// Bit of NewSubfileType: a smaller version of another image.
const REDUCED: u64 = 1;
/// Bit of NewSubfileType: a mask of another image.
const MASK: u64 = 4;

/// One image and the file that holds it.
#[derive(Clone, Debug)]
pub(super) struct Image {
    pub(super) file: Arc<TiffBytes>,
    pub(super) layout: Layout,
}

/// One level of the pyramid.
#[derive(Debug)]
pub(super) struct Level {
    pub(super) image: Image,
    pub(super) mask: Option<Image>,
}

impl Level {
    /// Whether some chunk may be left out.
    pub(super) fn may_be_sparse(&self) -> bool {
        self.image.layout.may_be_sparse(&self.image.file)
    }
}

/// Images found so far.
struct Found {
    levels: Vec<Level>,
    masks: Vec<Image>,
}

/// The full image, its overviews from fine to coarse, and their masks.
pub(super) fn read(
    file: &Arc<TiffBytes>,
    directories: &[Ifd],
    beside: &Companions,
) -> Result<Vec<Level>, Fault> {
    let full = Image {
        file: Arc::clone(file),
        layout: Layout::read(file, &directories[0])?,
    };
    let mut found = Found {
        levels: vec![Level {
            image: full,
            mask: None,
        }],
        masks: Vec::new(),
    };
    for ifd in &directories[1..] {
        let kind = file.unsigned(ifd, tag::NEW_SUBFILE_TYPE)?.unwrap_or(0);
        if kind & MASK != 0 {
            found.mask(file, ifd)?;
        } else if kind & REDUCED != 0 {
            found.overview(file, ifd)?;
        }
    }
    if let Some(path) = &beside.overviews
        && let Err(fault) = found.overviews_of(path)
    {
        // Overviews can be made again.
        tracing::warn!(?path, %fault, "overviews beside a file are left out");
    }
    for path in &beside.masks {
        // What a mask hides must not show because the mask is damaged.
        found.masks_of(path).map_err(|fault| {
            let said = |reason: String| format!("{reason}, in the mask {}", path.display());
            match fault {
                Fault::Io(error) => {
                    Fault::Io(std::io::Error::new(error.kind(), said(error.to_string())))
                }
                Fault::Damaged(reason) => Fault::Damaged(said(reason)),
                Fault::Unsupported(reason) => Fault::Unsupported(said(reason)),
            }
        })?;
    }
    Ok(found.matched())
}

impl Found {
    fn overview(&mut self, file: &Arc<TiffBytes>, ifd: &Ifd) -> Result<(), Fault> {
        match Layout::read(file, ifd) {
            Ok(layout) if is_overview(&layout, &self.levels) => {
                let image = Image {
                    file: Arc::clone(file),
                    layout,
                };
                self.levels.push(Level { image, mask: None });
                Ok(())
            }
            // Thumbnails and overviews that nothing here reads can be made again.
            Ok(_) | Err(Fault::Unsupported(_)) => Ok(()),
            Err(fault) => Err(fault),
        }
    }

    fn mask(&mut self, file: &Arc<TiffBytes>, ifd: &Ifd) -> Result<(), Fault> {
        let layout = Layout::read(file, ifd)?;
        if layout.samples != 1 || layout.format != SampleFormat::Unsigned {
            return damaged("expected a mask of one unsigned band");
        }
        self.masks.push(Image {
            file: Arc::clone(file),
            layout,
        });
        Ok(())
    }

    /// Overviews, and masks of overviews, from a file of their own.
    fn overviews_of(&mut self, path: &Path) -> Result<(), Fault> {
        let (file, directories) = TiffBytes::open(Bytes::open(path)?)?;
        let file = Arc::new(file);
        for ifd in &directories {
            let kind = file.unsigned(ifd, tag::NEW_SUBFILE_TYPE)?.unwrap_or(0);
            if kind & MASK != 0 {
                self.mask(&file, ifd)?;
            } else {
                self.overview(&file, ifd)?;
            }
        }
        Ok(())
    }

    fn masks_of(&mut self, path: &Path) -> Result<(), Fault> {
        let (file, directories) = TiffBytes::open(Bytes::open(path)?)?;
        let file = Arc::new(file);
        directories.iter().try_for_each(|ifd| self.mask(&file, ifd))
    }

    /// Levels in order, each with its mask.
    fn matched(self) -> Vec<Level> {
        let Self { mut levels, masks } = self;
        let size = |image: &Image| (image.layout.width, image.layout.height);
        levels[1..].sort_by_key(|level| {
            let (width, height) = size(&level.image);
            core::cmp::Reverse(u64::from(width) * u64::from(height))
        });
        for mask in masks {
            let of = levels.iter_mut().find(|l| size(&l.image) == size(&mask));
            if let Some(level) = of {
                level.mask.get_or_insert(mask);
            }
        }
        // Masks of overviews may be missing where the image itself has one: without it the overview
        // would show what the mask hides.
        if levels[0].mask.is_some() {
            let masked = levels.iter().take_while(|l| l.mask.is_some()).count();
            levels.truncate(masked);
        }
        levels
    }
}

/// Whether an image is a plausible overview: the same bands, smaller, the same shape.
fn is_overview(image: &Layout, levels: &[Level]) -> bool {
    let full = &levels[0].image.layout;
    let known = levels
        .iter()
        .any(|l| (l.image.layout.width, l.image.layout.height) == (image.width, image.height));
    if known
        || image.width > full.width
        || image.height > full.height
        || image.samples != full.samples
    {
        return false;
    }
    if (
        image.format,
        image.bits,
        image.photometric == photometric::PALETTE,
    ) != (
        full.format,
        full.bits,
        full.photometric == photometric::PALETTE,
    ) {
        return false;
    }
    let ratio = |a: u32, b: u32| f64::from(a) / f64::from(b);
    // Rounding of sides up or down to whole pixels, by any writer, moves a side by a pixel or two.
    let expected = f64::from(full.height) / ratio(full.width, image.width);
    let expected_width = f64::from(full.width) / ratio(full.height, image.height);
    (expected - f64::from(image.height)).abs() <= 2.0
        || (expected_width - f64::from(image.width)).abs() <= 2.0
}
