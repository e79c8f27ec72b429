//! Layers that change nothing of a picture: for the tests here and for the report on the same.

use relievo_engine::project::{
    Adjust, Blend, ContoursLayer, Layer, LayerId, LayerKind, Noise, NoiseLayer, NoiseMode, Project,
    SlopeLayer, Tint, TintInterpolation, TintLayer, TintStop, VectorLayer, VectorStyle,
};

/// A way of changing nothing.
#[derive(Clone, Copy)]
pub(crate) struct Kind {
    pub(crate) name: &'static str,
    /// What becomes of them in a part of the picture that they could be in; `None` where they do not
    /// even get into the graph.
    pub(crate) unseen: Option<&'static str>,
    /// Adds so many of them to a scene.
    pub(crate) add: fn(&mut Project, usize),
}

pub(crate) const KINDS: [Kind; 4] = [
    Kind {
        name: "hidden",
        unseen: None,
        add: |project, count| {
            project.layers.extend((0..count).map(|k| {
                let kind = if k % 2 == 0 {
                    tint()
                } else {
                    noise(50.0, NoiseMode::Replace)
                };
                let mut hidden = layer(&format!("hidden-{k}"), kind);
                hidden.visible = false;
                hidden
            }));
        },
    },
    Kind {
        name: "without effect",
        unseen: None,
        add: |project, count| {
            // Among the others, below and above.
            for k in 0..count {
                let at = k * project.layers.len() / count;
                project.layers.insert(at, inert(k));
            }
        },
    },
    Kind {
        name: "covered",
        unseen: Some("covered"),
        add: |project, count| {
            let covered = (0..count).map(|k| {
                let kind = match k % 3 {
                    0 => LayerKind::Slope(SlopeLayer::default()),
                    1 => LayerKind::Contours(ContoursLayer::default()),
                    _ => tint(),
                };
                layer(&format!("covered-{k}"), kind)
            });
            // Above the hills, below the tint.
            project.layers.splice(1..1, covered);
        },
    },
    Kind {
        name: "off the screen",
        unseen: Some("off the screen"),
        add: |project, count| project.layers.extend((0..count).map(far_away)),
    },
];

/// Hills in the colours of their heights.
pub(crate) fn plain() -> Project {
    Project {
        layers: vec![
            layer("hills", noise(200.0, NoiseMode::Add)),
            layer("tint", tint()),
        ],
        ..Project::default()
    }
}

pub(crate) fn layer(id: &str, kind: LayerKind) -> Layer {
    Layer::new(LayerId::from(id), id, kind)
}

pub(crate) fn noise(amplitude_m: f64, mode: NoiseMode) -> LayerKind {
    let noise = Noise {
        amplitude_m,
        mode,
        octaves: 3,
        wavelength_m: 3000.0,
        ..Noise::default()
    };
    LayerKind::Noise(NoiseLayer { noise })
}

pub(crate) fn tint() -> LayerKind {
    let stops = vec![
        TintStop::new(-300.0, [20, 60, 20]),
        TintStop::new(300.0, [200, 200, 180]),
    ];
    let tint = Tint {
        stops,
        interpolation: TintInterpolation::Smooth,
    };
    LayerKind::Tint(TintLayer {
        tint,
        blend: Blend::Normal,
        adjust: Adjust::default(),
    })
}

fn inert(k: usize) -> Layer {
    let id = format!("inert-{k}");
    match k % 4 {
        0 => {
            let mut faint = layer(&id, tint());
            faint.opacity = 0.0;
            faint
        }
        1 => layer(&id, noise(0.0, NoiseMode::Add)),
        2 => {
            let mut slope = SlopeLayer::default();
            slope.stops.iter_mut().for_each(|s| s.opacity = 0.0);
            layer(&id, LayerKind::Slope(slope))
        }
        _ => {
            let lines = ContoursLayer {
                width_px: 0.0,
                index_width_px: 0.0,
                ..ContoursLayer::default()
            };
            layer(&id, LayerKind::Contours(lines))
        }
    }
}

/// File of the layers on the other side of the planet.
pub(crate) const FAR: &str = "far.geojson";

/// What is in it.
pub(crate) const FAR_FEATURE: &str = r#"{"type":"Feature","properties":{},"geometry":{"type":"Polygon",
    "coordinates":[[[-150,-40],[-149,-40],[-149,-39],[-150,-40]]]}}"#;

fn far_away(k: usize) -> Layer {
    let mut vector = VectorLayer::new(FAR);
    vector.style = VectorStyle {
        fill: Some([0, 128, 255]),
        ..VectorStyle::default()
    };
    layer(&format!("far-{k}"), LayerKind::Vector(Box::new(vector)))
}
