//! Layers and what they are made of.

use super::adjust::adjust;
use super::colour_detail::details;
use super::{Twin, filled, text, unless_default};
use crate::stored::colour::StoredColour;
use crate::stored::fault::{At, Fault, quote};
use crate::stored::stretch::StoredStretch;
use crate::stored::value::{Stored as _, With};
use crate::stored::{noise, range, rasters, v1};
use crate::{
    Adjust, Blend, ContoursLayer, Dated, Detail, DetailLayer, Extent, Georeference, HeightLayer,
    ImageryLayer, Layer, LayerId, LayerKind, Mask, Noise, NoiseLayer, Resampling, SlopeLayer,
    Source, Stretch, TintLayer, VectorLayer,
};

/// A valid id.
pub(crate) fn layer_id(id: String, at: &At<'_>) -> Result<LayerId, Fault> {
    if LayerId::is_valid(&id) {
        Ok(LayerId(id))
    } else {
        Err(at.fault("1 to 64 letters, digits, '-', '_' or '.'", quote(&id)))
    }
}

/// A valid name.
pub(crate) fn layer_name(name: String, at: &At<'_>) -> Result<String, Fault> {
    text(name, range::LONGEST_NAME, at)
}

/// A valid path.
pub(crate) fn source_path(path: String, at: &At<'_>) -> Result<String, Fault> {
    filled(path, range::LONGEST_PATH, at)
}

/// Bands of an imagery layer.
pub(crate) fn bands(bands: &[u32], at: &At<'_>) -> Result<Vec<u16>, Fault> {
    if !matches!(bands.len(), 1 | 3 | 4) {
        return Err(at.fault("one, three or four bands", bands.len().to_string()));
    }
    bands
        .iter()
        .enumerate()
        .map(|(i, &number)| band(number, &At::Element(at, i)))
        .collect()
}

/// A band's number.
pub(crate) fn band(number: u32, at: &At<'_>) -> Result<u16, Fault> {
    u16::try_from(number).map_err(|_too_large| at.fault("1 to 65535", number.to_string()))
}

impl Twin for Layer {
    type Stored = v1::Layer;

    fn from_stored(stored: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let v1::Layer { base, kind, extra } = stored;
        let id = layer_id(base.id, &At::Member(at, "id"))?;
        let name = match base.name {
            Some(name) => layer_name(name, &At::Member(at, "name"))?,
            None => id.0.clone(),
        };
        let kind = match kind {
            v1::LayerKind::Imagery(imagery) => {
                LayerKind::Imagery(ImageryLayer::from_stored(*imagery, at)?)
            }
            v1::LayerKind::Height(height) => {
                LayerKind::Height(HeightLayer::from_stored(height, at)?)
            }
            v1::LayerKind::Noise(noise) => LayerKind::Noise(NoiseLayer {
                noise: Noise::from_stored(noise, at)?,
            }),
            v1::LayerKind::Detail(detail) => LayerKind::Detail(DetailLayer {
                detail: Detail::from_stored(detail, at)?,
            }),
            v1::LayerKind::Tint(tint) => LayerKind::Tint(TintLayer::from_stored(*tint, at)?),
            v1::LayerKind::Slope(slope) => LayerKind::Slope(SlopeLayer::from_stored(slope, at)?),
            v1::LayerKind::Contours(contours) => {
                LayerKind::Contours(ContoursLayer::from_stored(contours, at)?)
            }
            v1::LayerKind::Vector(vector) => {
                LayerKind::Vector(Box::new(VectorLayer::from_stored(*vector, at)?))
            }
            v1::LayerKind::Unknown => LayerKind::Unknown { kind: base.kind },
        };
        Ok(Self {
            id,
            name,
            visible: base.visible.unwrap_or(true),
            opacity: base.opacity.unwrap_or(1.0),
            locked: base.locked.unwrap_or(false),
            mask: mask(base.mask, &kind, at)?,
            dated: base
                .dated
                .map(|dated| Dated::from_stored(dated, &At::Member(at, "dated")))
                .transpose()?,
            kind,
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        v1::Layer {
            base: v1::LayerBase {
                id: self.id.0.clone(),
                name: unless_default(self.name.clone(), &self.id.0),
                kind: self.kind.name().to_owned(),
                visible: unless_default(self.visible, &true),
                opacity: unless_default(self.opacity, &1.0),
                locked: unless_default(self.locked, &false),
                mask: self.mask.as_ref().map(Twin::to_stored),
                dated: self.dated.as_ref().map(Twin::to_stored),
            },
            kind: match &self.kind {
                LayerKind::Imagery(imagery) => {
                    v1::LayerKind::Imagery(Box::new(imagery.to_stored()))
                }
                LayerKind::Height(height) => v1::LayerKind::Height(height.to_stored()),
                LayerKind::Noise(noise) => v1::LayerKind::Noise(noise.noise.to_stored()),
                LayerKind::Detail(detail) => v1::LayerKind::Detail(detail.detail.to_stored()),
                LayerKind::Tint(tint) => v1::LayerKind::Tint(Box::new(tint.to_stored())),
                LayerKind::Slope(slope) => v1::LayerKind::Slope(slope.to_stored()),
                LayerKind::Contours(contours) => v1::LayerKind::Contours(contours.to_stored()),
                LayerKind::Vector(vector) => v1::LayerKind::Vector(Box::new(vector.to_stored())),
                LayerKind::Unknown { .. } => v1::LayerKind::Unknown,
            },
            extra: self.extra.clone(),
        }
    }
}

/// A layer's mask; heights have none.
fn mask(
    stored: Option<With<crate::stored::mask::Mask>>,
    kind: &LayerKind,
    at: &At<'_>,
) -> Result<Option<Mask>, Fault> {
    let at = At::Member(at, "mask");
    match stored {
        Some(_) if !kind.may_be_masked() => Err(at.fault(
            "a mask of a layer with colours",
            format!("one of kind {}", quote(kind.name())),
        )),
        stored => stored.map(|mask| Mask::from_stored(mask, &at)).transpose(),
    }
}

impl Twin for ImageryLayer {
    type Stored = rasters::Imagery;

    fn from_stored(stored: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        Ok(Self {
            source: Source {
                path: source_path(stored.path, &At::Member(at, "path"))?,
                georeference: georeference(stored.georeference, at)?,
                nodata: stored.nodata,
                resampling: stored.resampling.map_or(Resampling::Bilinear, Into::into),
                edge_fade_m: stored.edge_fade_m.unwrap_or(0.0),
                encoding: None,
                tile_rows: stored.tile_rows.map(Into::into),
            },
            bands: stored
                .bands
                .map(|given| bands(&given, &At::Member(at, "bands")))
                .transpose()?,
            stretch: stored.stretch.map_or(Stretch::Auto, |s| s.0),
            seam_blend_m: stored.seam_blend_m.unwrap_or(0.0),
            missing: stored.missing.map(|colour| colour.0),
            detail: details(stored.detail.unwrap_or_default(), &At::Member(at, "detail"))?,
            blend: stored.blend.map_or(Blend::Normal, Into::into),
            adjust: adjust(stored.adjust, at)?,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        rasters::Imagery {
            path: self.source.path.clone(),
            georeference: self.source.georeference.as_ref().map(Twin::to_stored),
            nodata: self.source.nodata,
            tile_rows: self.source.tile_rows.map(Into::into),
            bands: self
                .bands
                .as_ref()
                .map(|bands| bands.iter().copied().map(u32::from).collect()),
            stretch: unless_default(self.stretch, &Stretch::Auto).map(StoredStretch),
            resampling: unless_default(self.source.resampling, &Resampling::Bilinear)
                .map(Into::into),
            edge_fade_m: unless_default(self.source.edge_fade_m, &0.0),
            seam_blend_m: unless_default(self.seam_blend_m, &0.0),
            missing: self.missing.map(StoredColour),
            detail: (!self.detail.is_empty())
                .then(|| self.detail.iter().map(Twin::to_stored).collect()),
            blend: unless_default(self.blend, &Blend::Normal).map(Into::into),
            adjust: unless_default(&self.adjust, &&Adjust::default()).map(Twin::to_stored),
        }
    }
}

impl Twin for HeightLayer {
    type Stored = rasters::Height;

    fn from_stored(stored: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        Ok(Self {
            source: Source {
                path: source_path(stored.path, &At::Member(at, "path"))?,
                georeference: georeference(stored.georeference, at)?,
                nodata: stored.nodata,
                resampling: stored.resampling.map_or(Resampling::Bilinear, Into::into),
                edge_fade_m: stored.edge_fade_m.unwrap_or(0.0),
                encoding: stored.encoding.map(Into::into),
                tile_rows: stored.tile_rows.map(Into::into),
            },
            band: stored
                .band
                .map(|number| band(number, &At::Member(at, "band")))
                .transpose()?,
            vertical_scale: stored.vertical_scale.unwrap_or(1.0),
            offset_m: stored.offset_m.unwrap_or(0.0),
        })
    }

    fn to_stored(&self) -> Self::Stored {
        rasters::Height {
            path: self.source.path.clone(),
            georeference: self.source.georeference.as_ref().map(Twin::to_stored),
            nodata: self.source.nodata,
            encoding: self.source.encoding.map(Into::into),
            tile_rows: self.source.tile_rows.map(Into::into),
            band: self.band.map(u32::from),
            resampling: unless_default(self.source.resampling, &Resampling::Bilinear)
                .map(Into::into),
            edge_fade_m: unless_default(self.source.edge_fade_m, &0.0),
            vertical_scale: unless_default(self.vertical_scale, &1.0),
            offset_m: unless_default(self.offset_m, &0.0),
        }
    }
}

impl Twin for Noise {
    type Stored = noise::Noise;

    fn from_stored(stored: Self::Stored, _: &At<'_>) -> Result<Self, Fault> {
        let default = Self::default();
        Ok(Self {
            seed: stored.seed.unwrap_or(default.seed),
            amplitude_m: stored.amplitude_m,
            wavelength_m: stored.wavelength_m,
            octaves: stored.octaves.unwrap_or(default.octaves),
            lacunarity: stored.lacunarity.unwrap_or(default.lacunarity),
            gain: stored.gain.unwrap_or(default.gain),
            ridged: stored.ridged.unwrap_or(default.ridged),
            offset_m: stored.offset_m.unwrap_or(default.offset_m),
            mode: stored.mode.map_or(default.mode, Into::into),
        })
    }

    fn to_stored(&self) -> Self::Stored {
        let default = Self::default();
        noise::Noise {
            seed: unless_default(self.seed, &default.seed),
            amplitude_m: self.amplitude_m,
            wavelength_m: self.wavelength_m,
            octaves: unless_default(self.octaves, &default.octaves),
            lacunarity: unless_default(self.lacunarity, &default.lacunarity),
            gain: unless_default(self.gain, &default.gain),
            ridged: unless_default(self.ridged, &default.ridged),
            offset_m: unless_default(self.offset_m, &default.offset_m),
            mode: unless_default(self.mode, &default.mode).map(Into::into),
        }
    }
}

impl Twin for Detail {
    type Stored = noise::Detail;

    fn from_stored(stored: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        if let (Some(lowest), Some(highest)) = (stored.lowest_m, stored.highest_m)
            && highest <= lowest
        {
            return Err(At::Member(at, "highest_m")
                .fault(format!("more than lowest_m, {lowest}"), highest.to_string()));
        }
        let default = Self::default();
        Ok(Self {
            seed: stored.seed.unwrap_or(default.seed),
            strength: stored.strength.unwrap_or(default.strength),
            method: stored.method.map_or(default.method, Into::into),
            slope: stored.slope.unwrap_or(default.slope),
            lowest_m: stored.lowest_m,
            highest_m: stored.highest_m,
            fade_m: stored.fade_m.unwrap_or(default.fade_m),
            shortest_m: stored.shortest_m.unwrap_or(default.shortest_m),
        })
    }

    fn to_stored(&self) -> Self::Stored {
        let default = Self::default();
        noise::Detail {
            seed: unless_default(self.seed, &default.seed),
            strength: unless_default(self.strength, &default.strength),
            method: unless_default(self.method, &default.method).map(Into::into),
            slope: unless_default(self.slope, &default.slope),
            lowest_m: self.lowest_m,
            highest_m: self.highest_m,
            fade_m: unless_default(self.fade_m, &default.fade_m),
            shortest_m: unless_default(self.shortest_m, &default.shortest_m),
        }
    }
}

impl Twin for Georeference {
    type Stored = With<rasters::Georeference>;

    fn from_stored(stored: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = stored;
        let extent = match (fields.west, fields.south, fields.east, fields.north) {
            (None, None, None, None) => None,
            (Some(west), Some(south), Some(east), Some(north)) => Some(Extent {
                west,
                south,
                east,
                north,
            }),
            _ => {
                return Err(at.fault(
                    "all of \"west\", \"south\", \"east\", \"north\", or none",
                    "some of them",
                ));
            }
        };
        if let Some(Extent {
            west,
            south,
            east,
            north,
        }) = extent
        {
            if east <= west {
                let expected = format!("more than west, {west} (add 360 across the antimeridian)");
                return Err(At::Member(at, "east").fault(expected, east.to_string()));
            }
            if north <= south {
                return Err(At::Member(at, "north")
                    .fault(format!("more than south, {south}"), north.to_string()));
            }
        }
        let crs = match fields.crs {
            Some(crs) => Some(filled(crs, range::LONGEST_PATH, &At::Member(at, "crs"))?),
            None if extent.is_none() => {
                return Err(at.fault("\"crs\", the four edges, or both", "neither"));
            }
            None => None,
        };
        Ok(Self { crs, extent, extra })
    }

    fn to_stored(&self) -> Self::Stored {
        With {
            fields: rasters::Georeference {
                crs: self.crs.clone(),
                west: self.extent.map(|e| e.west),
                south: self.extent.map(|e| e.south),
                east: self.extent.map(|e| e.east),
                north: self.extent.map(|e| e.north),
            },
            extra: self.extra.clone(),
        }
    }
}

/// The member `georeference` of the object at `at`.
fn georeference(
    stored: Option<With<rasters::Georeference>>,
    at: &At<'_>,
) -> Result<Option<Georeference>, Fault> {
    stored
        .map(|given| Georeference::from_stored(given, &At::Member(at, "georeference")))
        .transpose()
}

/// Whether a runtime layer of an unknown kind hides a known one, which could not be read back.
pub(crate) fn unknown_is_unknown(layer: &Layer) -> Result<(), Fault> {
    match &layer.kind {
        LayerKind::Unknown { kind } if v1::KINDS.contains(&kind.as_str()) => {
            Err(At::Root.fault("a kind that is not known", kind.write().to_string()))
        }
        LayerKind::Unknown { .. }
        | LayerKind::Imagery(_)
        | LayerKind::Height(_)
        | LayerKind::Noise(_)
        | LayerKind::Detail(_)
        | LayerKind::Tint(_)
        | LayerKind::Slope(_)
        | LayerKind::Contours(_)
        | LayerKind::Vector(_) => Ok(()),
    }
}
