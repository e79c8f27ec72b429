//! Applying an edit: the one place where a project changes.

mod elements;
mod layers;
mod scenarios;

use core::mem;

use self::layers::wrong_kind;
use crate::stored::edits;
use crate::stored::fault::At;
use crate::{Edit, Fault, LayerKind, Project};

/// Deepest nesting of batches.
const DEEPEST_BATCH: usize = 8;

/// Why an edit cannot be applied. The project is as it was.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EditError {
    /// No layer has this id.
    #[error("expected the id of a layer, found {id:?}")]
    NoSuchLayer {
        /// The id.
        id: String,
    },
    /// The edit does not fit the kind of the layer.
    #[error("expected {expected} to set its {what}, found a layer of kind {kind}: {id:?}")]
    WrongKind {
        /// The layer.
        id: String,
        /// What the edit sets.
        what: &'static str,
        /// Kinds of layers that have it.
        expected: &'static str,
        /// The layer's kind.
        kind: String,
    },
    /// The id of a layer to add is in use.
    #[error("expected an id that is not in use, found {id:?}")]
    IdInUse {
        /// The id.
        id: String,
    },
    /// A position outside the stack.
    #[error("expected a position from 0 to {last}, found {index}")]
    Position {
        /// Last position that fits.
        last: usize,
        /// The position.
        index: usize,
    },
    /// The project would have more layers than a file may hold.
    #[error("expected at most {most} layers, found one more")]
    TooManyLayers {
        /// The limit.
        most: usize,
    },
    /// No planning element has this id there.
    #[error("expected the id of an element of {place}, found {id:?}")]
    NoSuchElement {
        /// The id.
        id: String,
        /// The base or a scenario.
        place: String,
    },
    /// No scenario has this id.
    #[error("expected the id of a scenario, found {id:?}")]
    NoSuchScenario {
        /// The id.
        id: String,
    },
    /// A scenario that others are based on cannot go.
    #[error("expected a scenario that no other is based on, found {child:?} based on {id:?}")]
    HasChildren {
        /// The scenario.
        id: String,
        /// One that is based on it.
        child: String,
    },
    /// Parents of scenarios would go round in a circle.
    #[error("expected a tree of scenarios, found {parent:?} based on {id:?} already")]
    Cycle {
        /// The scenario.
        id: String,
        /// The parent it was to have.
        parent: String,
    },
    /// No bookmark has this position.
    #[error("expected the position of one of {count} bookmarks, found {index}")]
    NoSuchBookmark {
        /// How many there are.
        count: usize,
        /// The position.
        index: usize,
    },
    /// The project would have more of something than a file may hold.
    #[error("expected at most {most} {what}, found one more")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// The limit.
        most: usize,
    },
    /// A value is out of its range or not well formed.
    #[error("{0}")]
    Invalid(#[from] Fault),
    /// An edit of a batch cannot be applied.
    #[error("edit {index} of the batch: {source}")]
    InBatch {
        /// Which, from 0.
        index: usize,
        /// Why.
        source: Box<EditError>,
    },
    /// Batches within batches, too deep.
    #[error("expected batches nested at most 8 deep, found deeper ones")]
    TooDeep,
}

impl Project {
    /// Changes the project and gives the edit that changes it back, to the byte.
    ///
    /// # Errors
    /// Where a value, an id or a position does not fit; the project is then unchanged.
    pub fn apply(&mut self, edit: Edit) -> Result<Edit, EditError> {
        if depth(&edit) > DEEPEST_BATCH {
            return Err(EditError::TooDeep);
        }
        edits::check(&edit, &At::Root)?;
        self.apply_checked(edit)
    }

    #[expect(clippy::too_many_lines, reason = "one arm for each edit")]
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "the others have their arms in apply_planning"
    )]
    fn apply_checked(&mut self, edit: Edit) -> Result<Edit, EditError> {
        Ok(match edit {
            Edit::AddLayer { index, layer } => self.add_layer(index, *layer)?,
            Edit::RemoveLayer { id } => {
                let index = self.index(&id)?;
                let layer = self.layers.remove(index);
                Edit::AddLayer {
                    index: Some(index),
                    layer: Box::new(layer),
                }
            }
            Edit::MoveLayer { id, index } => {
                let before = self.index(&id)?;
                let last = self.layers.len() - 1;
                if index > last {
                    return Err(EditError::Position { last, index });
                }
                let layer = self.layers.remove(before);
                self.layers.insert(index, layer);
                Edit::MoveLayer { id, index: before }
            }
            Edit::SetName { id, name } => {
                let name = mem::replace(&mut self.layer_mut(&id)?.name, name);
                Edit::SetName { id, name }
            }
            Edit::SetVisible { id, visible } => {
                let visible = mem::replace(&mut self.layer_mut(&id)?.visible, visible);
                Edit::SetVisible { id, visible }
            }
            Edit::SetOpacity { id, opacity } => {
                let opacity = mem::replace(&mut self.layer_mut(&id)?.opacity, opacity);
                Edit::SetOpacity { id, opacity }
            }
            Edit::SetLocked { id, locked } => {
                let locked = mem::replace(&mut self.layer_mut(&id)?.locked, locked);
                Edit::SetLocked { id, locked }
            }
            Edit::SetBlend { id, blend } => {
                let blend = mem::replace(self.blend_mut(&id)?, blend);
                Edit::SetBlend { id, blend }
            }
            Edit::SetDated { id, dated } => {
                let dated = mem::replace(&mut self.layer_mut(&id)?.dated, dated);
                Edit::SetDated { id, dated }
            }
            Edit::ShowDate { date } => Edit::ShowDate {
                date: mem::replace(&mut self.date, date),
            },
            Edit::SetMask { id, mask } => {
                let slot = self.mask_mut(&id)?;
                let before = mem::replace(slot, mask.map(|mask| *mask));
                let mask = before.map(Box::new);
                Edit::SetMask { id, mask }
            }
            Edit::SetAdjust { id, adjust } => {
                let adjust = mem::replace(self.adjust_mut(&id)?, adjust);
                Edit::SetAdjust { id, adjust }
            }
            Edit::SetResampling { id, resampling } => {
                let resampling = mem::replace(
                    &mut self.source_mut(&id, "resampling")?.resampling,
                    resampling,
                );
                Edit::SetResampling { id, resampling }
            }
            Edit::SetEdgeFade { id, edge_fade_m } => {
                let edge_fade_m = mem::replace(
                    &mut self.source_mut(&id, "edge fade")?.edge_fade_m,
                    edge_fade_m,
                );
                Edit::SetEdgeFade { id, edge_fade_m }
            }
            Edit::SetSeamBlend { id, seam_blend_m } => {
                let seam_blend_m = self.set_imagery(
                    &id,
                    "seams",
                    |imagery| &mut imagery.seam_blend_m,
                    seam_blend_m,
                )?;
                Edit::SetSeamBlend { id, seam_blend_m }
            }
            Edit::SetMissing { id, missing } => {
                let missing = self.set_imagery(
                    &id,
                    "colour of holes",
                    |imagery| &mut imagery.missing,
                    missing,
                )?;
                Edit::SetMissing { id, missing }
            }
            Edit::SetColourDetail { id, detail } => {
                let detail =
                    self.set_imagery(&id, "detail", |imagery| &mut imagery.detail, detail)?;
                Edit::SetColourDetail { id, detail }
            }
            Edit::SetPath { id, path } => {
                let slot = match &mut self.layer_mut(&id)?.kind {
                    LayerKind::Vector(vector) => &mut vector.path,
                    LayerKind::Imagery(_)
                    | LayerKind::Height(_)
                    | LayerKind::Noise(_)
                    | LayerKind::Detail(_)
                    | LayerKind::Tint(_)
                    | LayerKind::Slope(_)
                    | LayerKind::Contours(_)
                    | LayerKind::Unknown { .. } => &mut self.source_mut(&id, "file")?.path,
                };
                let path = mem::replace(slot, path);
                Edit::SetPath { id, path }
            }
            Edit::SetGeoreference { id, georeference } => {
                let slot = &mut self.source_mut(&id, "georeference")?.georeference;
                let georeference = mem::replace(slot, georeference);
                Edit::SetGeoreference { id, georeference }
            }
            Edit::SetNodata { id, nodata } => {
                let nodata =
                    mem::replace(&mut self.source_mut(&id, "nodata value")?.nodata, nodata);
                Edit::SetNodata { id, nodata }
            }
            Edit::SetTiles {
                id,
                encoding,
                tile_rows,
            } => {
                let layer = self.layer_mut(&id)?;
                if encoding.is_some() && !matches!(layer.kind, LayerKind::Height(_)) {
                    return Err(wrong_kind(layer, "encoding of heights", "a height layer"));
                }
                let source = self.source_mut(&id, "set of tiles")?;
                Edit::SetTiles {
                    encoding: mem::replace(&mut source.encoding, encoding),
                    tile_rows: mem::replace(&mut source.tile_rows, tile_rows),
                    id,
                }
            }
            Edit::SetStretch { id, stretch } => {
                let stretch =
                    self.set_imagery(&id, "stretch", |imagery| &mut imagery.stretch, stretch)?;
                Edit::SetStretch { id, stretch }
            }
            Edit::SetBands { id, bands } => self.set_bands(id, bands)?,
            Edit::SetHeightScale {
                id,
                vertical_scale,
                offset_m,
            } => {
                let layer = self.layer_mut(&id)?;
                let LayerKind::Height(height) = &mut layer.kind else {
                    return Err(wrong_kind(layer, "vertical scale", "a height layer"));
                };
                let vertical_scale = mem::replace(&mut height.vertical_scale, vertical_scale);
                let offset_m = mem::replace(&mut height.offset_m, offset_m);
                Edit::SetHeightScale {
                    id,
                    vertical_scale,
                    offset_m,
                }
            }
            Edit::SetNoise { id, noise } => {
                let layer = self.layer_mut(&id)?;
                let LayerKind::Noise(slot) = &mut layer.kind else {
                    return Err(wrong_kind(layer, "noise", "a noise layer"));
                };
                let noise = mem::replace(&mut slot.noise, noise);
                Edit::SetNoise { id, noise }
            }
            Edit::SetDetail { id, detail } => {
                let layer = self.layer_mut(&id)?;
                let LayerKind::Detail(slot) = &mut layer.kind else {
                    return Err(wrong_kind(layer, "detail", "a detail layer"));
                };
                let detail = mem::replace(&mut slot.detail, detail);
                Edit::SetDetail { id, detail }
            }
            Edit::SetTint { id, tint } => {
                let layer = self.layer_mut(&id)?;
                let LayerKind::Tint(slot) = &mut layer.kind else {
                    return Err(wrong_kind(layer, "tint", "a tint layer"));
                };
                let tint = mem::replace(&mut slot.tint, tint);
                Edit::SetTint { id, tint }
            }
            Edit::SetSlope { id, slope } => {
                let layer = self.layer_mut(&id)?;
                let LayerKind::Slope(slot) = &mut layer.kind else {
                    return Err(wrong_kind(layer, "slope colours", "a slope layer"));
                };
                let slope = mem::replace(slot, slope);
                Edit::SetSlope { id, slope }
            }
            Edit::SetContours { id, contours } => {
                let layer = self.layer_mut(&id)?;
                let LayerKind::Contours(slot) = &mut layer.kind else {
                    return Err(wrong_kind(layer, "contour lines", "a contours layer"));
                };
                let contours = mem::replace(slot, contours);
                Edit::SetContours { id, contours }
            }
            Edit::SetPlanet { planet } => Edit::SetPlanet {
                planet: mem::replace(&mut self.planet, planet),
            },
            Edit::SetExaggeration {
                vertical_exaggeration,
            } => {
                let slot = &mut self.planet.vertical_exaggeration;
                Edit::SetExaggeration {
                    vertical_exaggeration: mem::replace(slot, vertical_exaggeration),
                }
            }
            Edit::SetCamera { camera } => Edit::SetCamera {
                camera: mem::replace(&mut self.camera, camera),
            },
            Edit::SetSun { sun } => Edit::SetSun {
                sun: mem::replace(&mut self.sun, sun),
            },
            Edit::SetQuality { quality } => Edit::SetQuality {
                quality: mem::replace(&mut self.quality, quality),
            },
            Edit::SetVectorStyle { id, style } => {
                let style = mem::replace(&mut self.vector_mut(&id, "style")?.style, *style);
                let style = Box::new(style);
                Edit::SetVectorStyle { id, style }
            }
            Edit::SetVectorSource {
                id,
                source_layer,
                crs,
            } => {
                let vector = self.vector_mut(&id, "source layer")?;
                Edit::SetVectorSource {
                    source_layer: mem::replace(&mut vector.source_layer, source_layer),
                    crs: mem::replace(&mut vector.crs, crs),
                    id,
                }
            }
            Edit::Batch { label, edits } => self.apply_batch(label, edits)?,
            other => self.apply_planning(other)?,
        })
    }

    /// Edits of elements, scenarios and bookmarks.
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "the caller has the arms of the others"
    )]
    fn apply_planning(&mut self, edit: Edit) -> Result<Edit, EditError> {
        match edit {
            Edit::AddElement {
                scenario,
                index,
                element,
            } => self.add_element(scenario, index, element),
            Edit::RemoveElement { scenario, id } => self.remove_element(scenario, id),
            Edit::ReplaceElement { scenario, element } => self.replace_element(scenario, element),
            Edit::MoveElement {
                scenario,
                id,
                index,
            } => self.move_element(scenario, id, index),
            Edit::SetElementName { scenario, id, name } => {
                self.edit_element(scenario, id, |element, id| Edit::SetElementName {
                    scenario: None,
                    id,
                    name: mem::replace(&mut element.name, name),
                })
            }
            Edit::SetElementVisible {
                scenario,
                id,
                visible,
            } => self.edit_element(scenario, id, |element, id| Edit::SetElementVisible {
                scenario: None,
                id,
                visible: mem::replace(&mut element.visible, visible),
            }),
            Edit::SetElementLocked {
                scenario,
                id,
                locked,
            } => self.edit_element(scenario, id, |element, id| Edit::SetElementLocked {
                scenario: None,
                id,
                locked: mem::replace(&mut element.locked, locked),
            }),
            Edit::SetElementStyle {
                scenario,
                id,
                style,
            } => self.edit_element(scenario, id, |element, id| Edit::SetElementStyle {
                scenario: None,
                id,
                style: mem::replace(&mut element.style, style),
            }),
            Edit::SetChange {
                scenario,
                id,
                index,
                change,
            } => self.set_change(scenario, id, index, change),
            Edit::SetChanges { scenario, changes } => self.set_changes(scenario, changes),
            Edit::AddScenario { index, scenario } => self.add_scenario(index, *scenario),
            Edit::RemoveScenario { id } => self.remove_scenario(&id),
            Edit::RenameScenario { id, name } => {
                let name = mem::replace(&mut self.scenario_mut(&id)?.name, name);
                Ok(Edit::RenameScenario { id, name })
            }
            Edit::DuplicateScenario { id, new_id, name } => {
                self.duplicate_scenario(&id, new_id, name)
            }
            Edit::MergeScenario { id } => self.merge_scenario(&id),
            Edit::SetScenarioParent { id, parent } => self.set_scenario_parent(id, parent),
            Edit::SetScenarioLayer {
                scenario,
                id,
                index,
                layer,
            } => self.set_scenario_layer(scenario, id, index, layer),
            Edit::ShowScenario { id } => self.show_scenario(id),
            Edit::AddBookmark { index, bookmark } => self.add_bookmark(index, bookmark),
            Edit::RemoveBookmark { index } => {
                self.expect_bookmark(index)?;
                Ok(Edit::AddBookmark {
                    index: Some(index),
                    bookmark: self.bookmarks.remove(index),
                })
            }
            Edit::ReplaceBookmark { index, bookmark } => Ok(Edit::ReplaceBookmark {
                index,
                bookmark: mem::replace(self.expect_bookmark(index)?, bookmark),
            }),
            _layers_and_settings => unreachable!("applied by the caller"),
        }
    }

    fn apply_batch(&mut self, label: String, edits: Vec<Edit>) -> Result<Edit, EditError> {
        let mut inverses = Vec::with_capacity(edits.len());
        for (index, edit) in edits.into_iter().enumerate() {
            match self.apply_checked(edit) {
                Ok(inverse) => inverses.push(inverse),
                Err(source) => {
                    for inverse in inverses.into_iter().rev() {
                        self.apply_checked(inverse)
                            .expect("an inverse fits the project that its edit left");
                    }
                    return Err(EditError::InBatch {
                        index,
                        source: Box::new(source),
                    });
                }
            }
        }
        inverses.reverse();
        Ok(Edit::Batch {
            label,
            edits: inverses,
        })
    }
}

/// Depth of nested batches, counted no further than one beyond the limit.
fn depth(edit: &Edit) -> usize {
    fn below(edit: &Edit, left: usize) -> usize {
        // Their inverses may be batches.
        if matches!(
            edit,
            Edit::RemoveScenario { .. } | Edit::MergeScenario { .. }
        ) {
            return 1;
        }
        if let (Edit::Batch { edits, .. }, 1..) = (edit, left) {
            1 + edits
                .iter()
                .map(|edit| below(edit, left - 1))
                .max()
                .unwrap_or(0)
        } else {
            0
        }
    }
    below(edit, DEEPEST_BATCH + 1)
}
