//! Heights continued beyond their sources' own resolution, and where that is seen.

use std::sync::Arc;

use relievo_graph::NodeIndex;
use relievo_graph::nodes::{
    self, Constant, DetailMethod, DetailParams, OverlayHeights, Stop, Tint,
};
use relievo_project::{DetailMethod as ProjectMethod, Layer, LayerKind, NoiseMode, Project};
use relievo_raster::SampleType;

use super::{Compiler, Ground, level_of_step};
use crate::scene::Detail;

impl Compiler<'_> {
    /// The height layers that take part, from the bottom up, each with the detail layer that continues it:
    /// the nearest one above.
    pub(super) fn height_layers<'p>(
        &mut self,
        project: &'p Project,
    ) -> Vec<(&'p Layer, Option<&'p Layer>)> {
        let gives = |layer: &&Layer| {
            matches!(
                layer.kind,
                LayerKind::Height(_) | LayerKind::Noise(_) | LayerKind::Detail(_)
            )
        };
        let layers: Vec<&Layer> = project
            .layers
            .iter()
            .filter(gives)
            .filter(|layer| self.takes_part(project, layer))
            .collect();
        let is_detail = |layer: &&&Layer| matches!(layer.kind, LayerKind::Detail(_));
        let above = |i: usize| layers[i + 1..].iter().find(is_detail).copied();
        let mut continues_none = true;
        let mut all = Vec::new();
        for (i, layer) in layers.iter().enumerate() {
            if matches!(layer.kind, LayerKind::Detail(_)) {
                if continues_none {
                    let reason = "no heights to continue below";
                    self.left_out.push((layer.id.clone(), reason));
                }
                continues_none = true;
                continue;
            }
            continues_none &= !matches!(layer.kind, LayerKind::Height(_));
            all.push((*layer, above(i)));
        }
        all
    }

    /// The heights of a source with samples so many metres apart, continued.
    pub(super) fn continued(
        &mut self,
        detail: Option<&Layer>,
        source: NodeIndex,
        spacing_m: f64,
    ) -> NodeIndex {
        let made = detail.and_then(|layer| Some((layer, self.detail_node(layer, spacing_m)?)));
        let Some((layer, node)) = made else {
            return source;
        };
        let (Some(shortest_m), below_m) = (node.shortest_m(), node.synthesised_below_m()) else {
            return source;
        };
        let name = format!("{:?} {:?}", node.params(), self.planet);
        let node = self.same(name, || node);
        let index = self.add(layer, node, &[source]);
        self.builder.cut(index, SampleType::Height);
        let finest = level_of_step(shortest_m / (4.0 * self.planet.radius_m));
        self.details.push(Detail {
            synthesised_below_m: below_m,
            ..Detail::everywhere(index, finest)
        });
        index
    }

    fn detail_node(&self, layer: &Layer, spacing_m: f64) -> Option<nodes::Detail> {
        let LayerKind::Detail(detail) = &layer.kind else {
            return None;
        };
        let detail = &detail.detail;
        let params = DetailParams {
            seed: u64::from(detail.seed),
            strength: detail.strength * layer.opacity,
            method: match detail.method {
                ProjectMethod::Simplex => DetailMethod::Simplex,
                ProjectMethod::Spectral => DetailMethod::Spectral,
            },
            slope: detail.slope,
            heights_m: [
                detail.lowest_m.unwrap_or(f64::NEG_INFINITY),
                detail.highest_m.unwrap_or(f64::INFINITY),
            ],
            fade_m: detail.fade_m,
            shortest_m: detail.shortest_m,
            spacing_m,
        };
        Some(nodes::Detail::new(self.planet, &params))
    }

    /// Colours over `below` where heights are synthesised, the stronger the higher what was added.
    pub(super) fn synthesised(
        &mut self,
        project: &Project,
        ground: Ground,
        below: Option<NodeIndex>,
    ) -> Option<NodeIndex> {
        let (said, left_out) = (self.problems.len(), self.left_out.len());
        let layers = self.layers.clone();
        let mut amount = self.builder.add(Arc::new(Constant::height(0.0)), &[]);
        for (layer, detail) in self.height_layers(project) {
            amount = self.amount_with(layer, detail, amount).unwrap_or(amount);
        }
        let colours = self.synthesised_colours(project, ground);
        // Whatever is odd about a layer was told where it is shown.
        self.problems.truncate(said);
        self.left_out.truncate(left_out);
        // These nodes say something of layers and are no part of them.
        self.layers = layers;
        let mut below = below;
        for (amount, stops) in [(colours, &COLOURS[..]), (Some(amount), &heights()[..])] {
            // Stops that are written down here rise.
            let tint = Tint::new(stops, true).ok();
            if let (Some(amount), Some(tint)) = (amount, tint) {
                let tinted = self.builder.add(Arc::new(tint), &[amount]);
                below = Some(self.lay_over_shown(below, tinted));
            }
        }
        below
    }

    /// How high synthesised detail is once a layer lies over what is below it.
    fn amount_with(
        &mut self,
        layer: &Layer,
        detail: Option<&Layer>,
        below: NodeIndex,
    ) -> Option<NodeIndex> {
        let opacity = layer.opacity as f32;
        if let LayerKind::Height(height) = &layer.kind {
            let file = self.open(layer)?;
            let spacing_rad = self.warp(layer, &file, &height.source)?.finest_step_rad();
            let spacing_m = spacing_rad * self.planet.radius_m;
            let scale = (height.vertical_scale, height.offset_m);
            let source = self.file_node(layer, &file, &height.source, scale)?;
            self.builder.cut(source, SampleType::Height);
            // What is not continued is no amount, and covers what is.
            let none = || {
                let params = DetailParams {
                    seed: 0,
                    strength: 0.0,
                    method: DetailMethod::Simplex,
                    slope: 0.0,
                    heights_m: [f64::NEG_INFINITY, f64::INFINITY],
                    fade_m: 0.0,
                    shortest_m: 1.0,
                    spacing_m,
                };
                nodes::Detail::new(self.planet, &params)
            };
            let node = detail.and_then(|layer| self.detail_node(layer, spacing_m));
            let node = node.unwrap_or_else(none).amount();
            let top = self.builder.add(Arc::new(node), &[source]);
            let inputs = self.with_fade(layer, &file, &height.source, below, top)?;
            let masked = inputs.len() == 3;
            let overlay = OverlayHeights::new(opacity, masked);
            return Some(self.builder.add(Arc::new(overlay), &inputs));
        }
        let replaces = matches!(&layer.kind, LayerKind::Noise(noise) if noise.noise.mode == NoiseMode::Replace);
        if !replaces {
            return None;
        }
        let none = self.builder.add(Arc::new(Constant::height(0.0)), &[]);
        let overlay = OverlayHeights::new(opacity, false);
        Some(self.builder.add(Arc::new(overlay), &[below, none]))
    }
}

/// Colours where those of imagery are made up: teal.
const COLOURS: [Stop; 2] = [
    Stop {
        height_m: 0.0,
        rgba: [0.0, 0.6, 0.6, 0.0],
    },
    Stop {
        height_m: 1.0,
        rgba: [0.0, 0.6, 0.6, 0.4],
    },
];

/// Colours by metres of detail: nothing without, violet as it grows.
fn heights() -> [Stop; 5] {
    [
        (0.0, 0.0),
        (0.02, 0.3),
        (1.0, 0.45),
        (30.0, 0.6),
        (500.0, 0.75),
    ]
    .map(|(height_m, alpha)| Stop {
        height_m,
        rgba: [0.55, 0.2, 0.75, alpha],
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use relievo_planet::{Grid, LevelKey, MapPoint, SampleRect};
    use relievo_project::{Detail, DetailLayer, HeightLayer, Layer, LayerId, Source};
    use relievo_raster::Cancel;

    use crate::compile::{NodeCache, Wish, compile};
    use crate::{Engine, EngineOptions};

    use super::*;

    /// Alphas of the colours over a project with heights and detail, some samples at a place of a level.
    fn alphas(detail: Detail, synthesised: bool, level: LevelKey) -> Option<Vec<f32>> {
        let source = Source::new("wasatch-dem.tif");
        let heights = LayerKind::Height(HeightLayer::new(source));
        let layer = |id: &str, kind| Layer::new(LayerId::from(id), id, kind);
        let project = Project {
            layers: vec![
                layer("heights", heights),
                layer("detail", LayerKind::Detail(DetailLayer { detail })),
            ],
            ..Project::default()
        };
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../projects/data");
        let options = EngineOptions {
            threads: Some(1),
            cache_folder: None,
            ..EngineOptions::default()
        };
        let mut engine = Engine::new(project, &folder, options).unwrap();
        engine.wait_for_sources();
        let wish = Wish {
            synthesised,
            ..Wish::default()
        };
        let nodes = NodeCache::default();
        let compiled = compile(engine.project(), &folder, engine.sources(), &nodes, &wish);
        assert!(compiled.problems.is_empty() && compiled.left_out.is_empty());
        let at = level.sample_from_map(MapPoint::from_degrees(-111.6, 40.3));
        let first = at.floor().as_i64vec2();
        let rect = SampleRect::at(first.x, first.y, 24, 24);
        let grid = Grid::new(Arc::new(level.lattice()), rect);
        let colours = compiled
            .graph
            .evaluate(compiled.roots.colour?, &grid, &Cancel::default());
        Some(colours.unwrap().plane(3).to_vec())
    }

    #[test]
    fn synthesised_ground_is_coloured_where_it_is_seen_and_wanted() {
        let fine = LevelKey::new(15, 14);
        assert_eq!(alphas(Detail::default(), false, fine), None);
        let seen = alphas(Detail::default(), true, fine).unwrap();
        assert!(seen.iter().all(|a| (0.2..0.9).contains(a)), "{seen:?}");
        // A coarse level shows none of it, and ground above the range of heights gets none.
        let coarse = alphas(Detail::default(), true, LevelKey::new(6, 5)).unwrap();
        assert!(coarse.iter().all(|a| *a == 0.0));
        let low = Detail {
            highest_m: Some(0.0),
            ..Detail::default()
        };
        let none = alphas(low, true, fine).unwrap();
        assert!(none.iter().all(|a| *a == 0.0));
    }
}
