//! What GDAL writes beside the samples: nodata, scale, offset and unit of each band.
//!
//! Source: GDAL's GeoTIFF driver documentation, tags 42112 (`GDAL_METADATA`, XML) and 42113
//! (`GDAL_NODATA`, text).

/// Scale, offset and unit of one band.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct BandMetadata {
    /// Factor on stored values.
    pub(crate) scale: Option<f64>,
    /// Added to scaled values.
    pub(crate) offset: Option<f64>,
    /// Unit of scaled values, as written.
    pub(crate) unit: Option<String>,
}

impl BandMetadata {
    /// Reads `<Item … sample="band" role="scale">value</Item>` and its siblings from the XML text;
    /// what it does not understand it passes over.
    pub(crate) fn of_band(xml: &str, band: u16) -> Self {
        let mut found = Self::default();
        let mut rest = xml;
        while let Some(start) = rest.find("<Item") {
            rest = &rest[start + 5..];
            let Some((attributes, after)) = element_head(rest) else {
                break;
            };
            let Some(end) = after.find("</Item>") else {
                break;
            };
            let (value, role) = (after[..end].trim(), attribute(attributes, "role"));
            rest = &after[end..];
            let sample = attribute(attributes, "sample").and_then(|s| s.trim().parse::<u16>().ok());
            if sample.unwrap_or(0) != band {
                continue;
            }
            let number = || value.parse::<f64>().ok().filter(|v| v.is_finite());
            match role {
                Some("scale") => found.scale = number().filter(|s| *s != 0.0),
                Some("offset") => found.offset = number(),
                Some("unittype") => found.unit = Some(value.to_owned()),
                _ => {}
            }
        }
        found
    }

    /// Metres in a unit of height; 1 where the unit is unknown.
    pub(crate) fn metres(&self) -> f64 {
        match self.unit.as_deref().map(str::trim) {
            Some("ft" | "foot" | "feet" | "international foot") => 0.3048,
            Some("US survey foot" | "ftUS" | "us-ft" | "sfeet") => 1200.0 / 3937.0,
            Some("km" | "kilometre" | "kilometer") => 1000.0,
            Some("cm" | "centimetre" | "centimeter") => 0.01,
            _ => 1.0,
        }
    }
}

/// Splits at the end of an element's head: attributes, then what follows; `None` for an element
/// without content or without end. A `>` within quotes does not end it.
pub(crate) fn element_head(text: &str) -> Option<(&str, &str)> {
    let mut quote = None;
    for (i, c) in text.char_indices() {
        match (quote, c) {
            (None, '"' | '\'') => quote = Some(c),
            (Some(q), c) if q == c => quote = None,
            (None, '>') => return Some((&text[..i], &text[i + 1..])),
            _ => {}
        }
    }
    None
}

/// Value of an attribute.
pub(crate) fn attribute<'a>(head: &'a str, name: &str) -> Option<&'a str> {
    let mut rest = head;
    while let Some((key, after)) = rest.split_once('=') {
        let after = after.trim_start();
        let quote = after.chars().next().filter(|c| matches!(c, '"' | '\''))?;
        let (value, following) = after[1..].split_once(quote)?;
        if key.trim() == name {
            return Some(value);
        }
        rest = following;
    }
    None
}

/// The nodata value of GDAL's tag; `None` if it is no number.
pub(crate) fn nodata(text: &str) -> Option<f64> {
    let text = text.trim();
    // Windows runtimes of old wrote infinities and NaN in their own way.
    match text.to_ascii_lowercase().as_str() {
        "" => None,
        "-1.#ind" | "1.#qnan" | "-nan" => Some(f64::NAN),
        "1.#inf" => Some(f64::INFINITY),
        "-1.#inf" => Some(f64::NEG_INFINITY),
        other => other.parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_and_offset_belong_to_their_band_whatever_the_order_of_attributes() {
        let xml = "<GDALMetadata>\n <Item name=\"a>b\">9</Item>\
                   <Item name=\"OFFSET\" sample=\"0\" role=\"offset\">1000</Item>\
                   <Item role='scale' sample='0' name='SCALE'> 0.0001 </Item>\
                   <Item name=\"SCALE\" sample=\"1\" role=\"scale\">0.001</Item></GDALMetadata>";
        let first = BandMetadata::of_band(xml, 0);
        assert_eq!((first.scale, first.offset), (Some(0.0001), Some(1000.0)));
        assert_eq!(BandMetadata::of_band(xml, 1).scale, Some(0.001));
        assert_eq!(
            BandMetadata::of_band("<Item name=\"", 0),
            BandMetadata::default()
        );
    }

    #[test]
    fn nodata_reads_numbers_and_all_spellings_of_nan() {
        assert_eq!(nodata(" -3.4e+38 "), Some(-3.4e38));
        assert!(
            nodata("nan").is_some_and(f64::is_nan) && nodata("-1.#IND").is_some_and(f64::is_nan)
        );
        assert_eq!(nodata("none"), None);
    }
}
