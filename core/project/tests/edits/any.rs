//! Edits of all kinds, by chance.

use proptest::prelude::*;
use relievo_project::{
    Adjust, Aim, Blend, CameraSettings, ColourDetail, ContoursLayer, Dated, Detail, DetailBy,
    DetailLayer, DetailMethod, Edit, Extra, Georeference, HeightEncoding, HeightLayer,
    ImageryLayer, Layer, LayerId, LayerKind, Lens, LensShape, Mask, MaskRange, Noise, NoiseLayer,
    PlanetSettings, Quality, Resampling, SlopeLayer, SlopeStop, Source, Stretch, Sun, TileRows,
    Tint, TintInterpolation, TintStop, parse_date,
};

fn id() -> impl Strategy<Value = LayerId> {
    prop::sample::select(vec![
        "blue-marble",
        "wasatch",
        "detail",
        "tint",
        "roads",
        "steep",
        "lines",
        "finer",
        "new-1",
        "new-2",
    ])
    .prop_map(LayerId::from)
}

fn layer() -> impl Strategy<Value = Layer> {
    let kind = prop_oneof![
        Just(LayerKind::Imagery(ImageryLayer::new(Source::new("x.tif")))),
        Just(LayerKind::Height(HeightLayer::new(Source::new("../y.tif")))),
        Just(LayerKind::Noise(NoiseLayer {
            noise: Noise::default()
        })),
        Just(LayerKind::Detail(DetailLayer {
            detail: Detail::default()
        })),
        Just(LayerKind::Unknown {
            kind: "planning".into()
        }),
    ];
    (id(), "[a-zé ]{0,8}", kind).prop_map(|(id, name, kind)| Layer::new(id, name, kind))
}

/// A circle or a polygon; beyond 0.9 one whose corners are out of range.
fn lens(from: f64) -> Lens {
    let corner_m = if from > 0.9 { 2e7 } else { 1e3 * from };
    Lens {
        lon_deg: 100.0 * from,
        lat_deg: 10.0,
        fade_m: 1.0,
        shape: if from < 0.7 {
            LensShape::Circle { radius_m: from }
        } else {
            LensShape::Polygon {
                corners_m: vec![[0.0, 0.0], [corner_m, 0.0], [0.5, corner_m]],
            }
        },
        extra: Extra::new(),
    }
}

/// Any edit, many of which do not fit.
#[expect(clippy::too_many_lines, reason = "one arm for each edit")]
pub(crate) fn edit() -> impl Strategy<Value = Edit> {
    let value = -0.2..1.2_f64;
    let single = prop_oneof![
        (prop::option::of(0..8_usize), layer()).prop_map(|(index, l)| Edit::AddLayer {
            index,
            layer: Box::new(l)
        }),
        id().prop_map(|id| Edit::RemoveLayer { id }),
        (id(), 0..8_usize).prop_map(|(id, index)| Edit::MoveLayer { id, index }),
        (id(), ".{0,8}").prop_map(|(id, name)| Edit::SetName { id, name }),
        (id(), any::<bool>()).prop_map(|(id, visible)| Edit::SetVisible { id, visible }),
        (id(), any::<bool>()).prop_map(|(id, locked)| Edit::SetLocked { id, locked }),
        (id(), value.clone()).prop_map(|(id, opacity)| Edit::SetOpacity { id, opacity }),
        id().prop_map(|id| Edit::SetBlend {
            id,
            blend: Blend::Screen
        }),
        (id(), prop::option::of(0..3_usize)).prop_map(|(id, day)| Edit::SetDated {
            id,
            dated: day.map(|day| Dated {
                series: ["a", "b", ""][day].to_owned(),
                date: parse_date(["2010-06-29", "2015-09-26", "2012-02-29"][day]).unwrap(),
                extra: Extra::new(),
            }),
        }),
        prop::option::of(Just("2012-01-01")).prop_map(|day| Edit::ShowDate {
            date: day.and_then(parse_date),
        }),
        (id(), prop::option::of(value.clone())).prop_map(|(id, from)| Edit::SetMask {
            id,
            mask: from.map(|from| Box::new(Mask {
                heights: Some(MaskRange {
                    from,
                    to: 0.5,
                    fade: 0.1,
                    extra: Extra::new()
                }),
                invert: from > 0.3,
                lens: (from > 0.6).then(|| lens(from)),
                ..Mask::default()
            })),
        }),
        (id(), value.clone()).prop_map(|(id, gamma)| Edit::SetAdjust {
            id,
            adjust: Adjust {
                gamma,
                ..Adjust::default()
            }
        }),
        id().prop_map(|id| Edit::SetResampling {
            id,
            resampling: Resampling::Bilinear
        }),
        (id(), value.clone()).prop_map(|(id, edge_fade_m)| Edit::SetEdgeFade { id, edge_fade_m }),
        (id(), value.clone())
            .prop_map(|(id, seam_blend_m)| Edit::SetSeamBlend { id, seam_blend_m }),
        (id(), any::<Option<[u8; 3]>>()).prop_map(|(id, missing)| Edit::SetMissing { id, missing }),
        (id(), prop::collection::vec((id(), value.clone()), 0..18)).prop_map(|(of, all)| {
            let detail = |(id, strength): (LayerId, f64)| ColourDetail {
                strength,
                areas: (strength > 0.5).then(|| id.clone()),
                ..ColourDetail::new(if strength < 0.3 {
                    DetailBy::Noise
                } else {
                    let layers = vec![id; usize::from(strength < 1.0)];
                    let tolerance = strength;
                    DetailBy::Examples { layers, tolerance }
                })
            };
            let detail = all.into_iter().map(detail).collect();
            Edit::SetColourDetail { id: of, detail }
        }),
        (id(), "[a-z/.]{0,9}").prop_map(|(id, path)| Edit::SetPath { id, path }),
        (id(), any::<bool>()).prop_map(|(id, given)| {
            let crs = Some("EPSG:4326".to_owned());
            let georeference = Georeference {
                crs,
                extent: None,
                extra: Extra::new(),
            };
            Edit::SetGeoreference {
                id,
                georeference: given.then_some(georeference),
            }
        }),
        (id(), prop::option::of(any::<f64>()))
            .prop_map(|(id, nodata)| Edit::SetNodata { id, nodata }),
        (id(), any::<bool>(), any::<bool>()).prop_map(|(id, encoded, south)| Edit::SetTiles {
            id,
            encoding: encoded.then_some(HeightEncoding::Terrarium),
            tile_rows: south.then_some(TileRows::Tms),
        }),
        (id(), 0..5_u8, -50.0..150.0_f64, -50.0..150.0_f64).prop_map(|(id, kind, low, high)| {
            let stretch = match kind {
                0 => Stretch::Auto,
                1 => Stretch::Full,
                2 => Stretch::MinMax,
                3 => Stretch::Percentile { low, high },
                _ => Stretch::Range {
                    black: low,
                    white: high,
                },
            };
            Edit::SetStretch { id, stretch }
        }),
        (
            id(),
            prop::option::of(prop::collection::vec(0..5_u16, 1..4))
        )
            .prop_map(|(id, bands)| Edit::SetBands { id, bands }),
        (id(), value.clone()).prop_map(|(id, x)| Edit::SetHeightScale {
            id,
            vertical_scale: x,
            offset_m: x
        }),
        (id(), value.clone()).prop_map(|(id, slope)| Edit::SetDetail {
            id,
            detail: Detail {
                slope,
                method: DetailMethod::Spectral,
                highest_m: Some(slope),
                ..Detail::default()
            }
        }),
        (id(), value.clone()).prop_map(|(id, gain)| Edit::SetNoise {
            id,
            noise: Noise {
                gain,
                ..Noise::default()
            }
        }),
        (
            id(),
            prop::collection::vec((-9.0..9.0_f64, any::<[u8; 3]>()), 0..3)
        )
            .prop_map(|(id, stops)| {
                let stops = stops
                    .into_iter()
                    .map(|(h, colour)| TintStop::new(h, colour))
                    .collect();
                Edit::SetTint {
                    id,
                    tint: Tint {
                        stops,
                        interpolation: TintInterpolation::Smooth,
                    },
                }
            }),
        (id(), prop::collection::vec(-9.0..99.0_f64, 0..3)).prop_map(|(id, slopes_deg)| {
            let stops = slopes_deg.into_iter();
            Edit::SetSlope {
                id,
                slope: SlopeLayer {
                    stops: stops.map(|deg| SlopeStop::new(deg, [9; 3])).collect(),
                    ..SlopeLayer::default()
                },
            }
        }),
        (id(), prop::option::of(value.clone())).prop_map(|(id, interval_m)| Edit::SetContours {
            id,
            contours: ContoursLayer {
                interval_m,
                ..ContoursLayer::default()
            },
        }),
    ];
    let whole = prop_oneof![
        Just(Edit::SetPlanet {
            planet: PlanetSettings::default()
        }),
        value
            .clone()
            .prop_map(|vertical_exaggeration| Edit::SetExaggeration {
                vertical_exaggeration
            }),
        value.clone().prop_map(|lon_deg| Edit::SetCamera {
            camera: CameraSettings {
                lon_deg,
                ..Default::default()
            }
        }),
        value.clone().prop_map(|ambient| Edit::SetSun {
            sun: Sun {
                ambient,
                ..Sun::default()
            }
        }),
        (0..3_usize, value).prop_map(|(aim, number)| Edit::SetQuality {
            quality: Quality {
                aim: [Aim::Adapter, Aim::Error, Aim::FrameTime][aim],
                error_px: number,
                texel_px: number,
                ..Quality::default()
            }
        }),
    ];
    prop_oneof![4 => single, 1 => whole].prop_recursive(2, 8, 3, |inner| {
        prop::collection::vec(inner, 0..4).prop_map(|edits| Edit::Batch {
            label: String::new(),
            edits,
        })
    })
}
