//! Edits, their inverses and the history.

#![allow(clippy::unwrap_used, reason = "a test may stop")]

use std::path::Path;

use proptest::prelude::*;
use relievo_project::{
    Adjust, Affects, Aim, Aspect, Blend, CameraSettings, ClearColour, ColourDetail, ContoursLayer,
    CurvePoint, Dated, Detail, DetailBy, DetailLayer, DetailMethod, Edit, Extra, Georeference,
    HeightEncoding, HeightLayer, History, ImageryLayer, Layer, LayerId, LayerKind, Mask, MaskRange,
    Noise, NoiseLayer, PlanetSettings, Project, Quality, Resampling, SlopeLayer, SlopeStop, Source,
    Stretch, Sun, TileRows, Tint, TintInterpolation, TintStop, ToneCurves, parse_date,
};

const EVERYTHING: &str = include_str!("data/everything.relievo");

fn everything() -> Project {
    Project::from_json(EVERYTHING, Path::new("p.relievo")).unwrap()
}

/// Canonical text without the camera, whose moves are not undone.
fn without_camera(project: &Project) -> String {
    Project {
        camera: CameraSettings::default(),
        ..project.clone()
    }
    .to_json()
}

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

/// Any edit, many of which do not fit.
#[expect(clippy::too_many_lines, reason = "one arm for each edit")]
fn edit() -> impl Strategy<Value = Edit> {
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

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(100) })]

    #[test]
    fn undoing_all_edits_restores_the_same_bytes(edits in prop::collection::vec(edit(), 0..30)) {
        let mut project = everything();
        let mut inverses = Vec::new();
        for edit in edits {
            let before = project.to_json();
            if let Ok(inverse) = project.apply(edit) {
                inverses.push(inverse);
            } else {
                prop_assert_eq!(project.to_json(), before, "a refused edit changed something");
            }
            // Every state that edits reach can be saved and opened.
            let opened = Project::from_json(&project.to_json(), Path::new("p")).unwrap();
            prop_assert_eq!(&opened, &project);
        }
        for inverse in inverses.into_iter().rev() {
            project.apply(inverse).unwrap();
        }
        prop_assert_eq!(project.to_json(), EVERYTHING);
    }

    #[test]
    fn undo_all_and_redo_all_lead_to_the_same_ends(
        edits in prop::collection::vec((edit(), any::<bool>()), 0..30),
    ) {
        let mut project = everything();
        let mut history = History::default();
        for (edit, toggles_drag) in edits {
            if toggles_drag && history.is_dragging() {
                history.end_drag(&project);
            } else if toggles_drag {
                history.begin_drag(&project);
            }
            drop(history.apply(&mut project, edit));
        }
        history.end_drag(&project);
        let end = without_camera(&project);
        while history.undo(&mut project).unwrap().is_some() {}
        prop_assert_eq!(without_camera(&project), without_camera(&everything()));
        while history.redo(&mut project).unwrap().is_some() {}
        prop_assert_eq!(without_camera(&project), end);
    }

    #[test]
    fn edits_read_back_from_json(edit in edit()) {
        let text = Edit::list_to_json(std::slice::from_ref(&edit));
        if let Ok(read) = Edit::list_from_json(&text, Path::new("e")) {
            prop_assert_eq!(&read[0], &edit);
        }
    }
}

fn opacity(opacity: f64) -> Edit {
    Edit::SetOpacity {
        id: "blue-marble".into(),
        opacity,
    }
}

#[test]
fn a_whole_drag_is_one_step_back_to_where_it_began() {
    let (mut project, mut history) = (everything(), History::default());
    history.begin_drag(&project);
    for i in 0..100 {
        history
            .apply(&mut project, opacity(f64::from(i) / 100.0))
            .unwrap();
    }
    history.end_drag(&project);
    assert_eq!(history.undo_label(), Some("Opacity of Blue Marble"));
    assert_eq!(history.undo(&mut project).unwrap(), Some(opacity(0.75)));
    assert_eq!(project.to_json(), EVERYTHING);
    assert_eq!(history.undo_label(), None);
    history.redo(&mut project).unwrap();
    assert_eq!(project.layers[0].opacity, 0.99);
}

#[test]
fn a_cancelled_drag_leaves_no_trace() {
    let (mut project, mut history) = (everything(), History::default());
    history.begin_drag(&project);
    history.apply(&mut project, opacity(0.1)).unwrap();
    assert_eq!(history.cancel_drag(&mut project), Some(opacity(0.75)));
    assert_eq!(project.to_json(), EVERYTHING);
    assert_eq!(history.undo_label(), None);
}

#[test]
fn an_adjustment_is_called_by_the_slider_that_moved() {
    let (mut project, mut history) = (everything(), History::default());
    let LayerKind::Imagery(imagery) = &project.layers[0].kind else {
        panic!("an imagery layer")
    };
    let adjust = Adjust {
        brightness: 0.5,
        ..imagery.adjust.clone()
    };
    history
        .apply(
            &mut project,
            Edit::SetAdjust {
                id: "blue-marble".into(),
                adjust,
            },
        )
        .unwrap();
    assert_eq!(history.undo_label(), Some("Brightness of Blue Marble"));
}

#[test]
fn a_camera_move_is_not_undone_and_keeps_what_can_be_redone() {
    let (mut project, mut history) = (everything(), History::default());
    history.apply(&mut project, opacity(0.1)).unwrap();
    history.undo(&mut project).unwrap();
    history
        .apply(
            &mut project,
            Edit::SetCamera {
                camera: CameraSettings::default(),
            },
        )
        .unwrap();
    assert_eq!(history.undo_label(), None);
    assert_eq!(history.redo_label(), Some("Opacity of Blue Marble"));
}

#[test]
fn the_history_drops_its_oldest_steps_beyond_its_memory() {
    let mut project = everything();
    let mut history = History::new(20_000);
    for i in 0..1000 {
        history
            .apply(&mut project, opacity(f64::from(i) / 1000.0))
            .unwrap();
        assert!(history.bytes() <= 20_000);
    }
    let mut steps = 0;
    while history.undo(&mut project).unwrap().is_some() {
        steps += 1;
    }
    assert!((10..1000).contains(&steps), "{steps}");
}

#[test]
fn an_id_that_an_undo_would_bring_back_is_not_given_again() {
    let (mut project, mut history) = (everything(), History::default());
    history
        .apply(&mut project, Edit::RemoveLayer { id: "tint".into() })
        .unwrap();
    assert_eq!(
        history.fresh_layer_id(&project, "Tint"),
        LayerId::from("tint-2")
    );
}

#[test]
fn a_batch_that_fails_half_way_changes_nothing() {
    let mut project = everything();
    let edits = vec![
        opacity(0.1),
        Edit::RemoveLayer {
            id: "nobody".into(),
        },
    ];
    let error = project
        .apply(Edit::Batch {
            label: String::new(),
            edits,
        })
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "edit 1 of the batch: expected the id of a layer, found \"nobody\""
    );
    assert_eq!(project.to_json(), EVERYTHING);
}

#[test]
fn values_that_no_file_can_hold_are_refused() {
    let mut project = everything();
    for wrong in [f64::NAN, f64::INFINITY, -0.1, 1.1] {
        project.apply(opacity(wrong)).unwrap_err();
    }
    let nodata = Some(f64::NAN);
    project
        .apply(Edit::SetNodata {
            id: "wasatch".into(),
            nodata,
        })
        .unwrap_err();
    let adjust = Adjust {
        brightness: f64::NAN,
        ..Adjust::default()
    };
    project
        .apply(Edit::SetAdjust {
            id: "blue-marble".into(),
            adjust,
        })
        .unwrap_err();
    assert_eq!(project.to_json(), EVERYTHING);
}

#[test]
fn adjustments_beyond_their_ranges_or_without_sense_are_refused_by_member() {
    let point = |input, output| CurvePoint {
        input,
        output,
        extra: Extra::new(),
    };
    let curves = |points: &[CurvePoint]| ToneCurves {
        channels: [Vec::new(), points.to_vec(), Vec::new()],
        ..ToneCurves::default()
    };
    let clear = |from, to| ClearColour {
        colour: [0, 255, 0],
        from,
        to,
        extra: Extra::new(),
    };
    let mut project = everything();
    let mut refused = |change: &dyn Fn(&mut Adjust), member: &str| {
        let mut adjust = Adjust::default();
        change(&mut adjust);
        let edit = Edit::SetAdjust {
            id: "blue-marble".into(),
            adjust,
        };
        let line = project.apply(edit).unwrap_err().to_string();
        assert!(line.contains(member), "{member}: {line}");
    };
    refused(&|a| a.temperature_k = 900.0, "temperature_k");
    refused(&|a| a.tint = f64::NAN, "tint");
    refused(&|a| a.mix[1][2] = 17.0, "mix_green/2");
    refused(&|a| a.strength = 1.1, "strength");
    refused(
        &|a| a.curves = curves(&[point(0.5, 0.1), point(0.5, 0.2)]),
        "curves/green/1/input",
    );
    refused(
        &|a| a.curves = curves(&[point(0.5, 1.1)]),
        "curves/green/0/output",
    );
    refused(
        &|a| a.curves = curves(&vec![point(0.0, 0.0); 300]),
        "at most 256 points",
    );
    refused(&|a| a.clear = Some(clear(0.5, 0.5)), "clear/to");
    assert_eq!(project.to_json(), EVERYTHING);
}

#[test]
fn only_imagery_is_stretched_and_only_between_numbers_that_make_sense() {
    let mut project = everything();
    let set = |id: &str, stretch| Edit::SetStretch {
        id: id.into(),
        stretch,
    };
    let line = project
        .apply(set("wasatch", Stretch::Full))
        .unwrap_err()
        .to_string();
    assert!(line.contains("imagery layer"), "{line}");
    for nonsense in [
        Stretch::Percentile {
            low: 50.0,
            high: 50.0,
        },
        Stretch::Percentile {
            low: -1.0,
            high: 50.0,
        },
        Stretch::Percentile {
            low: 2.0,
            high: 101.0,
        },
        Stretch::Range {
            black: 7.0,
            white: 7.0,
        },
        Stretch::Range {
            black: f64::NAN,
            white: 7.0,
        },
        Stretch::Range {
            black: 0.0,
            white: f64::INFINITY,
        },
    ] {
        let line = project
            .apply(set("blue-marble", nonsense))
            .unwrap_err()
            .to_string();
        assert!(
            line.contains("percentile") && !line.contains('\n'),
            "{line}"
        );
    }
    assert_eq!(project.to_json(), EVERYTHING);
    project
        .apply(set(
            "blue-marble",
            Stretch::Range {
                black: 3000.0,
                white: 0.0,
            },
        ))
        .unwrap();
    assert!(project.to_json().contains("\"range\""));
}

#[test]
fn only_heights_have_an_encoding() {
    let mut project = everything();
    let wrong = Edit::SetTiles {
        id: "blue-marble".into(),
        encoding: Some(HeightEncoding::Terrarium),
        tile_rows: None,
    };
    let line = project.apply(wrong).unwrap_err().to_string();
    assert!(line.contains("height layer"), "{line}");
    assert_eq!(project.to_json(), EVERYTHING);
}

#[test]
fn an_edit_tells_which_layer_and_what_of_it() {
    let affects = Edit::Batch {
        label: String::new(),
        edits: vec![opacity(0.1), opacity(0.2)],
    }
    .affects();
    assert_eq!(
        affects,
        [Affects::Layer {
            id: "blue-marble".into(),
            aspect: Aspect::Opacity
        }]
    );
}

#[test]
fn a_slip_of_the_pen_in_a_script_is_named() {
    let text = "[\n {\"edit\": \"set_visible\", \"id\": \"a\", \"visible\": true, \"opcity\": 1}]";
    let message = Edit::list_from_json(text, Path::new("e.json"))
        .unwrap_err()
        .to_string();
    assert_eq!(
        message,
        "line 2, at /0/opcity: expected no such member in set_visible, found 1: \"e.json\""
    );
}

#[test]
fn masks_beyond_their_ranges_and_of_layers_without_colours_are_refused() {
    let refused = |kind: &str, mask: &str| {
        let edits = format!(
            r#"[{{"edit": "add_layer", "layer": {{"id": "a", "kind": {kind}, "mask": {mask}}}}}]"#
        );
        Edit::list_from_json(&edits, Path::new("edits.json"))
            .unwrap_err()
            .to_string()
    };
    let slope = r##""slope", "stops": [{"slope_deg": 0.0, "colour": "#000000"}]"##;
    let line = refused(slope, r#"{"heights": {"from_m": 10.0, "to_m": 5.0}}"#);
    assert!(
        line.contains("to_m") && line.contains("no less than from_m"),
        "{line}"
    );
    let line = refused(slope, r#"{"slopes": {"from_deg": -1.0, "to_deg": 5.0}}"#);
    assert!(line.contains("from_deg"), "{line}");
    let line = refused(
        slope,
        r#"{"circle": {"lon_deg": 0.0, "lat_deg": 91.0, "radius_m": 1.0}}"#,
    );
    assert!(line.contains("lat_deg"), "{line}");
    let line = refused(slope, r#"{"vector": "no layer's id"}"#);
    assert!(line.contains("vector"), "{line}");
    let line = refused(r#""noise", "amplitude_m": 1.0, "wavelength_m": 5.0"#, "{}");
    assert!(
        line.contains("layer with colours") && line.contains("noise"),
        "{line}"
    );
}
