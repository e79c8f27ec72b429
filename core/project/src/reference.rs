//! Layers that layers name: areas of masks and of detail, examples of fine ground.

use crate::{ImageryLayer, Layer, LayerId, LayerKind, Project, quote};

/// A layer names another that is not what is wanted there.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected {expected} {id} {purpose}, found {found}")]
pub struct WrongReference {
    /// What is wanted.
    expected: &'static str,
    /// The name, quoted.
    id: String,
    /// For what: `for the mask`.
    purpose: &'static str,
    /// What bears it.
    found: String,
}

impl Project {
    /// The vector layer, hidden or not, whose areas a layer names `for the mask` or another purpose.
    ///
    /// # Errors
    /// [`WrongReference`] where there is none, or one of another kind.
    pub fn named_areas(
        &self,
        id: &LayerId,
        purpose: &'static str,
    ) -> Result<&Layer, WrongReference> {
        let layer = self.layer(id);
        let found = layer.filter(|layer| matches!(layer.kind, LayerKind::Vector(_)));
        found.ok_or_else(|| wrong(("a vector layer", purpose), id, layer.map(kind_of)))
    }

    /// The imagery, hidden or not, that `of` names as an example.
    ///
    /// # Errors
    /// [`WrongReference`] where there is none, one of another kind, or `of` itself.
    pub fn named_example(
        &self,
        of: &LayerId,
        id: &LayerId,
    ) -> Result<(&Layer, &ImageryLayer), WrongReference> {
        let layer = self.layer(id);
        let imagery = layer.filter(|layer| layer.id != *of).and_then(|layer| {
            if let LayerKind::Imagery(imagery) = &layer.kind {
                Some((layer, imagery))
            } else {
                None
            }
        });
        imagery.ok_or_else(|| {
            let found = layer.map(|layer| {
                if layer.id == *of {
                    "the layer itself".to_owned()
                } else {
                    kind_of(layer)
                }
            });
            wrong(("an imagery layer", "as an example"), id, found)
        })
    }
}

fn kind_of(layer: &Layer) -> String {
    format!("one of kind {}", layer.kind.name())
}

fn wrong(
    (expected, purpose): (&'static str, &'static str),
    id: &LayerId,
    found: Option<String>,
) -> WrongReference {
    WrongReference {
        expected,
        id: quote(&id.0),
        purpose,
        found: found.unwrap_or_else(|| "none".to_owned()),
    }
}
