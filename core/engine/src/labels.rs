//! Texts of vector layers, where a view shows them.

use std::collections::HashMap;
use std::sync::Arc;

use core::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};
use parking_lot::Mutex;
use relievo_planet::MapPoint;
use relievo_project::{Label as LabelStyle, Layer, LayerId, LayerKind};
use relievo_vector::Features;
use relievo_vector::labels::{Label, labels};

use crate::masses::making::body_height_m;
use crate::sources::SourceState;
use crate::{Engine, View};

/// Texts that a picture shows at most.
const MOST: usize = 400;

/// Labels that are looked at for one picture at most, over all layers, the important ones first.
const LOOKED_AT: usize = 100_000;

/// Room around a text in heights of its letters.
const MARGIN: f64 = 0.35;

/// Mean width of a letter in heights of letters, with which texts are kept apart before a front-end
/// that knows its letters draws them.
const LETTER: f64 = 0.56;

/// Metres of a pixel on a map of scale 1 : 1, at 96 dots per inch.
const PIXEL_M: f64 = 0.0254 / 96.0;

/// A text on the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedLabel {
    /// The layer that it belongs to.
    pub layer: LayerId,
    /// The text, one line.
    pub text: String,
    /// The place that it names.
    pub at: MapPoint,
    /// Middle of the text in pixels from the picture's upper left corner.
    pub centre_px: DVec2,
    /// Height of the letters in pixels.
    pub size_px: f64,
    /// Colour of the letters.
    pub colour: [u8; 3],
    /// Colour around the letters.
    pub halo: Option<[u8; 3]>,
}

/// All labels of a file.
type Found = Arc<Vec<Label>>;

/// Labels of files, by file and property, as long as they are open.
#[derive(Default)]
pub(crate) struct LabelCache {
    known: Mutex<HashMap<(usize, String), Found>>,
}

/// A text that may be shown.
struct Candidate<'a> {
    layer: &'a LayerId,
    style: &'a LabelStyle,
    label: &'a Label,
    /// Height over the ground at its place, metres, without exaggeration: that of a body's roof.
    above_m: f64,
    /// Position in the order of layers, the top one first.
    rank: usize,
}

impl Engine {
    /// The texts of visible vector layers that a view shows: those in front of the ground, that do
    /// not overlap each other. Upper layers win over lower ones, within a layer the important over
    /// the others, and equals by the file's order: the same view gives the same texts.
    ///
    /// Files that are still being opened have none yet. Call it from the thread that drains.
    pub fn labels(&self, view: &View) -> Vec<PlacedLabel> {
        let mut used = Vec::new();
        let mut of_layers: Vec<(&Layer, Arc<Features>, &LabelStyle, Found)> = Vec::new();
        let frame = Picture::new(self, view);
        let project = self.project();
        let layers = project.layers_in(project.scenario.as_ref());
        for layer in layers.iter().rev() {
            let LayerKind::Vector(vector) = &layer.kind else {
                continue;
            };
            let Some(style) = &vector.style.label else {
                continue;
            };
            let hidden = !layer.visible || layer.is_superseded(&layers, project.date);
            if hidden || layer.opacity <= 0.0 {
                continue;
            }
            let Some(SourceState::Features(open)) =
                self.sources().state(&layer.kind, self.folder())
            else {
                continue;
            };
            let scale = frame.middle_sample_m / PIXEL_M;
            if vector.style.min_scale.is_some_and(|min| scale < min)
                || vector.style.max_scale.is_some_and(|max| scale > max)
            {
                continue;
            }
            let key = (Arc::as_ptr(&open.features).addr(), style.property.clone());
            let mut known = self.label_cache.known.lock();
            let found = known
                .entry(key.clone())
                .or_insert_with(|| Arc::new(labels(&open.features, &style.property)));
            of_layers.push((layer, Arc::clone(&open.features), style, Arc::clone(found)));
            used.push(key);
        }
        self.label_cache
            .known
            .lock()
            .retain(|key, _| used.contains(key));
        let candidates = of_layers
            .iter()
            .enumerate()
            .flat_map(|(rank, (layer, features, style, labels))| {
                labels.iter().map(move |label| Candidate {
                    layer: &layer.id,
                    style,
                    label,
                    above_m: roof_m(layer, features, label.feature),
                    rank,
                })
            })
            .take(LOOKED_AT);
        frame.place(candidates)
    }
}

/// How high a feature's roof is above the ground, metres; 0 where it lies flat.
fn roof_m(layer: &Layer, features: &Features, feature: u32) -> f64 {
    let LayerKind::Vector(vector) = &layer.kind else {
        return 0.0;
    };
    let extrude = vector.style.extrude.as_ref();
    extrude
        .and_then(|e| body_height_m(e, features, feature as usize))
        .unwrap_or(0.0)
}

/// What a text is placed on.
struct Picture<'a> {
    engine: &'a Engine,
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    size_px: DVec2,
    /// Pixels to a unit of distance at distance 1.
    focal_px: f64,
    radius_m: f64,
    exaggeration: f64,
    /// Metres of a pixel in the middle of the picture.
    middle_sample_m: f64,
}

impl<'a> Picture<'a> {
    fn new(engine: &'a Engine, view: &View) -> Self {
        let planet = engine.project().planet.body.figure();
        let camera = &view.camera;
        let basis = camera.basis(&planet);
        let size_px = DVec2::new(
            f64::from(view.viewport_px[0]),
            f64::from(view.viewport_px[1]),
        );
        let focal_px = 0.5 * size_px.y / libm::tan(0.5 * camera.fov_y_rad);
        let eye = camera.eye(&planet);
        let distance_m = match engine.cast(eye, basis.forward) {
            Some((at, height_m)) => {
                let exaggeration = engine.exaggeration();
                planet.position(at, height_m * exaggeration).distance(eye)
            }
            None => camera.altitude_m.max(1.0),
        };
        Self {
            engine,
            eye,
            right: basis.right,
            up: basis.up,
            forward: basis.forward,
            size_px,
            focal_px,
            radius_m: planet.radius_m,
            exaggeration: engine.exaggeration(),
            middle_sample_m: distance_m / focal_px,
        }
    }

    /// Where the picture shows a place so high above the ground; `None` where it is outside or hidden.
    fn pixel(&self, at: MapPoint, above_m: f64) -> Option<DVec2> {
        let up = at.to_unit();
        // What lies below the horizon of the bare ball, mountains' share included.
        let highest_m = 10_000.0 * self.exaggeration;
        let eye_m = self.eye.length();
        let cos_between = up.dot(self.eye) / eye_m;
        let horizon = libm::acos((self.radius_m / eye_m).min(1.0))
            + libm::acos(self.radius_m / (self.radius_m + highest_m));
        if cos_between < libm::cos(horizon.min(core::f64::consts::PI)) {
            return None;
        }
        let height_m = (self.engine.ground_m(at) + above_m) * self.exaggeration;
        let place = up * (self.radius_m + height_m);
        let v = place - self.eye;
        let depth = v.dot(self.forward);
        if depth <= 0.0 {
            return None;
        }
        let scale = self.focal_px / depth;
        let px = 0.5 * self.size_px + DVec2::new(v.dot(self.right), -v.dot(self.up)) * scale;
        (px.cmpge(DVec2::ZERO).all() && px.cmple(self.size_px).all()).then_some(px)
    }

    /// Whether the ground hides a place that the picture would show.
    fn is_hidden(&self, at: MapPoint, above_m: f64) -> bool {
        let height_m = (self.engine.ground_m(at) + above_m) * self.exaggeration;
        let v = at.to_unit() * (self.radius_m + height_m) - self.eye;
        let distance_m = v.length();
        let Some((met, height_m)) = self.engine.cast(self.eye, v / distance_m) else {
            return false;
        };
        let met = met.to_unit() * (self.radius_m + height_m * self.exaggeration);
        // A place on a slope may lie a little behind its own ground.
        met.distance(self.eye) < distance_m * 0.98 - 2.0 * self.middle_sample_m
    }

    fn place<'c>(&self, candidates: impl Iterator<Item = Candidate<'c>>) -> Vec<PlacedLabel> {
        let mut placed: Vec<PlacedLabel> = Vec::new();
        let mut boxes: Vec<[DVec2; 2]> = Vec::new();
        let mut rank = 0;
        for candidate in candidates {
            if placed.len() >= MOST {
                break;
            }
            debug_assert!(candidate.rank >= rank, "upper layers first");
            rank = candidate.rank;
            let lonlat = candidate.label.lonlat_rad;
            let at = MapPoint::new(lonlat.x, FRAC_PI_2 - lonlat.y).normalised();
            let Some(px) = self.pixel(at, candidate.above_m) else {
                continue;
            };
            let size_px = candidate.style.size_px;
            let letters = candidate.label.text.chars().count() as f64;
            let half = 0.5
                * DVec2::new(
                    letters * LETTER * size_px + 2.0 * MARGIN * size_px,
                    size_px * (1.0 + 2.0 * MARGIN),
                );
            let own = [px - half, px + half];
            let meets = |b: &[DVec2; 2]| own[0].cmplt(b[1]).all() && b[0].cmplt(own[1]).all();
            if boxes.iter().any(meets) || self.is_hidden(at, candidate.above_m) {
                continue;
            }
            boxes.push(own);
            placed.push(PlacedLabel {
                layer: candidate.layer.clone(),
                text: candidate.label.text.clone(),
                at,
                centre_px: px,
                size_px,
                colour: candidate.style.colour,
                halo: candidate.style.halo,
            });
        }
        placed
    }
}
