//! GDAL's notes beside a file (`.aux.xml`): nodata, scale, offset and unit of bands.
//!
//! They count where the file itself says nothing. Statistics, histograms and everything else in
//! them are passed over: what is shown is measured on the samples.
//! Source: GDAL's `GDALPamDataset`, as its files show it.

use super::metadata::{self, BandMetadata, attribute, element_head};

/// Notes on the bands of a file.
#[derive(Debug, Default)]
pub(super) struct Pam {
    bands: Vec<(u16, Option<f64>, BandMetadata)>,
}

impl Pam {
    /// Reads what it understands and passes over the rest.
    pub(super) fn parse(xml: &str) -> Self {
        let mut bands = Vec::new();
        let mut rest = xml;
        while let Some(start) = rest.find("<PAMRasterBand") {
            rest = &rest[start + "<PAMRasterBand".len()..];
            let Some((attributes, after)) = element_head(rest) else {
                break;
            };
            let Some(end) = after.find("</PAMRasterBand>") else {
                break;
            };
            let (inside, number) = (&after[..end], attribute(attributes, "band"));
            rest = &after[end..];
            // Bands count from 1 here.
            let Some(band) = number.and_then(|n| n.trim().parse::<u16>().ok()?.checked_sub(1))
            else {
                continue;
            };
            let value = |name| content(inside, name);
            let number = |name| {
                value(name)
                    .and_then(|v| v.parse::<f64>().ok())
                    .filter(|v| v.is_finite())
            };
            let notes = BandMetadata {
                scale: number("<Scale").filter(|s| *s != 0.0),
                offset: number("<Offset"),
                unit: value("<UnitType").map(str::to_owned),
            };
            bands.push((
                band,
                value("<NoDataValue").and_then(metadata::nodata),
                notes,
            ));
        }
        Self { bands }
    }

    /// The nodata value of a band.
    pub(super) fn nodata(&self, band: u16) -> Option<f64> {
        self.bands.iter().find(|b| b.0 == band)?.1
    }

    /// What the file says of a band, with the notes where it says nothing.
    pub(super) fn complete(&self, band: u16, own: BandMetadata) -> BandMetadata {
        let Some((_, _, notes)) = self.bands.iter().find(|b| b.0 == band) else {
            return own;
        };
        BandMetadata {
            scale: own.scale.or(notes.scale),
            offset: own.offset.or(notes.offset),
            unit: own.unit.or_else(|| notes.unit.clone()),
        }
    }
}

/// Text of the first element whose head begins so.
fn content<'a>(xml: &'a str, head: &str) -> Option<&'a str> {
    let mut rest = xml;
    loop {
        rest = &rest[rest.find(head)? + head.len()..];
        // `<Scale` begins `<ScaleOffset` too.
        if rest.starts_with(['>', ' ']) {
            let (_, after) = element_head(rest)?;
            return Some(after[..after.find("</")?].trim());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_fill_in_what_the_file_leaves_open_and_nothing_else() {
        let pam = Pam::parse(
            "<PAMDataset><Metadata><MDI key=\"a\">1</MDI></Metadata>\
             <PAMRasterBand band=\"2\"><Description>x</Description>\
             <NoDataValue le_hex_endian=\"1\">-9999</NoDataValue><UnitType>ft</UnitType><Scaled>9</Scaled>\
             <Scale>0.5</Scale><Offset>nan</Offset>\
             <Metadata><MDI key=\"STATISTICS_MAXIMUM\">4</MDI></Metadata></PAMRasterBand></PAMDataset>",
        );
        assert_eq!((pam.nodata(1), pam.nodata(0)), (Some(-9999.0), None));
        let own = BandMetadata {
            scale: Some(2.0),
            ..BandMetadata::default()
        };
        let both = pam.complete(1, own.clone());
        assert_eq!(
            (both.scale, both.offset, both.unit.as_deref()),
            (Some(2.0), None, Some("ft"))
        );
        assert_eq!(pam.complete(1, BandMetadata::default()).scale, Some(0.5));
        assert_eq!(pam.complete(0, own.clone()), own);
        for broken in [
            "",
            "<PAMRasterBand",
            "<PAMRasterBand band=\"1\"><NoDataValue>",
            "<PAMRasterBand band=\"0\"></PAMRasterBand>",
        ] {
            assert_eq!(Pam::parse(broken).nodata(0), None, "{broken}");
        }
    }
}
