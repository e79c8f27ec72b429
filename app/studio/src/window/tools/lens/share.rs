//! Layers that share a lens.

use relievo_engine::project::{Edit, LayerId, Lens, Mask, Project};

/// A layer's lens changed: for all unlocked layers that share it, so that a lens keeps its stack.
pub(in crate::window) fn with_lens(project: &Project, id: &LayerId, lens: &Lens) -> Edit {
    let lens_of = |mask: &Option<Mask>| mask.as_ref().and_then(|m| m.lens.clone());
    let before = project.layer(id).and_then(|layer| lens_of(&layer.mask));
    let shares = project.layers.iter().filter(|layer| {
        layer.id == *id || (before.is_some() && !layer.locked && lens_of(&layer.mask) == before)
    });
    let mut edits: Vec<Edit> = shares
        .map(|layer| {
            let mask = Mask {
                lens: Some(lens.clone()),
                ..layer.mask.clone().unwrap_or_default()
            };
            Edit::SetMask {
                id: layer.id.clone(),
                mask: Some(Box::new(mask)),
            }
        })
        .collect();
    match (edits.len(), edits.pop()) {
        (1, Some(only)) => only,
        (_, last) => {
            edits.extend(last);
            Edit::Batch {
                label: "Lens".to_owned(),
                edits,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use relievo_engine::project::{Extra, Layer, LayerKind, LensShape, SlopeLayer};

    use super::*;

    fn circle(lon_deg: f64) -> Lens {
        Lens {
            lon_deg,
            lat_deg: 0.0,
            fade_m: 0.0,
            shape: LensShape::Circle { radius_m: 1000.0 },
            extra: Extra::new(),
        }
    }

    fn triangle(lon_deg: f64) -> Lens {
        Lens {
            shape: LensShape::Polygon {
                corners_m: vec![[0.0, 0.0], [1000.0, 0.0], [0.0, 1000.0]],
            },
            ..circle(lon_deg)
        }
    }

    fn layer(id: &str, lens: Option<Lens>) -> Layer {
        let slopes = LayerKind::Slope(SlopeLayer::default());
        let mut layer = Layer::new(LayerId::from(id), id, slopes);
        layer.mask = lens.map(|lens| Mask {
            lens: Some(lens),
            ..Mask::default()
        });
        layer
    }

    fn lenses(project: &Project) -> Vec<Option<Lens>> {
        let masks = project.layers.iter().map(|l| l.mask.as_ref());
        masks.map(|m| m.and_then(|m| m.lens.clone())).collect()
    }

    #[test]
    fn a_lens_changes_with_all_that_it_shows_and_with_nothing_else() {
        let mut locked = layer("e", Some(circle(1.0)));
        locked.locked = true;
        let mut project = Project {
            layers: vec![
                layer("a", Some(circle(1.0))),
                layer("b", Some(circle(1.0))),
                layer("c", Some(circle(2.0))),
                layer("d", None),
                locked,
            ],
            ..Project::default()
        };
        let [one, two, five] = [1.0, 2.0, 5.0].map(|lon| Some(circle(lon)));
        let edit = with_lens(&project, &LayerId::from("b"), &circle(5.0));
        project.apply(edit).unwrap();
        let expected = [&five, &five, &two, &None, &one].map(Clone::clone);
        assert_eq!(lenses(&project), expected);
        // Also when it becomes a polygon.
        let edit = with_lens(&project, &LayerId::from("a"), &triangle(5.0));
        project.apply(edit).unwrap();
        let shape = Some(triangle(5.0));
        let expected = [&shape, &shape, &two, &None, &one].map(Clone::clone);
        assert_eq!(lenses(&project), expected);
        // A layer without a lens gets one alone.
        let edit = with_lens(&project, &LayerId::from("d"), &triangle(7.0));
        project.apply(edit).unwrap();
        let alone = Some(triangle(7.0));
        let expected = [&shape, &shape, &two, &alone, &one].map(Clone::clone);
        assert_eq!(lenses(&project), expected);
    }
}
