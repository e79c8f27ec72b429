//! Detail of imagery.

use super::layer::layer_id;
use super::{Twin, unless_default};
use crate::stored::colour_detail as stored;
use crate::stored::fault::{At, Fault};
use crate::stored::range;
use crate::stored::value::With;
use crate::{ColourDetail, DetailBy, LayerId};

impl Twin for ColourDetail {
    type Stored = With<stored::ColourDetail>;

    fn from_stored(stored: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = stored;
        let by = match stored::ByName::from(fields.by) {
            stored::ByName::Noise => {
                if fields.layers.is_some() {
                    let at = At::Member(at, "layers");
                    return Err(at.fault("no layers for noise", "some".to_owned()));
                }
                if fields.tolerance.is_some() {
                    let at = At::Member(at, "tolerance");
                    return Err(at.fault("no tolerance for noise", "one".to_owned()));
                }
                DetailBy::Noise
            }
            stored::ByName::Examples => DetailBy::Examples {
                layers: examples(fields.layers.unwrap_or_default(), &At::Member(at, "layers"))?,
                tolerance: fields.tolerance.unwrap_or(DetailBy::TOLERANCE),
            },
        };
        let areas = fields
            .areas
            .map(|id| layer_id(id, &At::Member(at, "areas")));
        Ok(Self {
            by,
            areas: areas.transpose()?,
            strength: fields.strength.unwrap_or(1.0),
            seed: fields.seed.unwrap_or(0),
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        let (by, layers, tolerance) = match &self.by {
            DetailBy::Noise => (stored::ByName::Noise, None, None),
            DetailBy::Examples { layers, tolerance } => (
                stored::ByName::Examples,
                Some(layers.iter().map(|id| id.0.clone()).collect()),
                unless_default(*tolerance, &DetailBy::TOLERANCE),
            ),
        };
        With {
            fields: stored::ColourDetail {
                by: by.into(),
                layers,
                tolerance,
                areas: self.areas.as_ref().map(|id| id.0.clone()),
                strength: unless_default(self.strength, &1.0),
                seed: unless_default(self.seed, &0),
            },
            extra: self.extra.clone(),
        }
    }
}

fn examples(ids: Vec<String>, at: &At<'_>) -> Result<Vec<LayerId>, Fault> {
    if ids.is_empty() || ids.len() > range::MOST_EXAMPLES {
        let expected = format!("1 to {} ids of imagery layers", range::MOST_EXAMPLES);
        return Err(at.fault(expected, ids.len().to_string()));
    }
    let read = ids.into_iter().enumerate();
    read.map(|(i, id)| layer_id(id, &At::Element(at, i)))
        .collect()
}

/// All of a layer's detail, the first at the bottom.
pub(crate) fn details(
    stored: Vec<With<stored::ColourDetail>>,
    at: &At<'_>,
) -> Result<Vec<ColourDetail>, Fault> {
    if stored.len() > range::MOST_DETAILS {
        let expected = format!("at most {} kinds of detail", range::MOST_DETAILS);
        return Err(at.fault(expected, stored.len().to_string()));
    }
    let read = stored.into_iter().enumerate();
    read.map(|(i, detail)| ColourDetail::from_stored(detail, &At::Element(at, i)))
        .collect()
}
