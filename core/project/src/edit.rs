//! Edits: the only way to change a project.

use std::sync::Arc;

use crate::{
    Adjust, Blend, Bookmark, CameraSettings, Change, ColourDetail, ContoursLayer, Date, Dated,
    Detail, Element, ElementId, ElementStyle, Georeference, HeightEncoding, Layer, LayerId,
    LayerOverride, Mask, Noise, PlanetSettings, Quality, Resampling, Scenario, ScenarioId,
    SlopeLayer, Stretch, Sun, TileRows, Tint, VectorStyle,
};

/// One change of a project. Values replace the old ones as a whole.
#[derive(Clone, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "few edits are held at once, and undo counts their bytes"
)]
pub enum Edit {
    /// Adds a layer at a position counted from the bottom; `None`: on top.
    AddLayer {
        /// Position, at most the number of layers.
        index: Option<usize>,
        /// The layer, its id not in use.
        layer: Box<Layer>,
    },
    /// Removes a layer.
    RemoveLayer {
        /// Which.
        id: LayerId,
    },
    /// Moves a layer to a position counted from the bottom, the layer itself taken out first.
    MoveLayer {
        /// Which.
        id: LayerId,
        /// New position, below the number of layers.
        index: usize,
    },
    /// Changes what people call a layer.
    SetName {
        /// Which.
        id: LayerId,
        /// The new name.
        name: String,
    },
    /// Shows or hides a layer.
    SetVisible {
        /// Which.
        id: LayerId,
        /// Whether it takes part.
        visible: bool,
    },
    /// Changes a layer's opacity.
    SetOpacity {
        /// Which.
        id: LayerId,
        /// 0 to 1.
        opacity: f64,
    },
    /// Locks or unlocks a layer.
    SetLocked {
        /// Which.
        id: LayerId,
        /// Whether edits in the window are refused.
        locked: bool,
    },
    /// Changes how an imagery, tint, slope or contours layer meets the layers below.
    SetBlend {
        /// Which.
        id: LayerId,
        /// The mode.
        blend: Blend,
    },
    /// Gives a layer its place in a series of pictures of one ground at different times.
    SetDated {
        /// Which.
        id: LayerId,
        /// `None`: in no series.
        dated: Option<Dated>,
    },
    /// Chooses the day that series of layers are shown at.
    ShowDate {
        /// `None`: the latest of each.
        date: Option<Date>,
    },
    /// Changes where an imagery, tint, slope, contours or vector layer shows.
    SetMask {
        /// Which.
        id: LayerId,
        /// `None`: everywhere.
        mask: Option<Box<Mask>>,
    },
    /// Changes the colour adjustment of an imagery or tint layer.
    SetAdjust {
        /// Which.
        id: LayerId,
        /// All adjustments.
        adjust: Adjust,
    },
    /// Changes how samples between a file's pixels are made.
    SetResampling {
        /// Which imagery or height layer.
        id: LayerId,
        /// The kernel.
        resampling: Resampling,
    },
    /// Changes the width over which a file's edge fades.
    SetEdgeFade {
        /// Which imagery or height layer.
        id: LayerId,
        /// Metres.
        edge_fade_m: f64,
    },
    /// Changes how far from the edge of its data an imagery layer bends to the colours below.
    SetSeamBlend {
        /// Which.
        id: LayerId,
        /// Metres.
        seam_blend_m: f64,
    },
    /// Changes what an imagery layer shows where its file has no data.
    SetMissing {
        /// Which.
        id: LayerId,
        /// sRGB; `None`: what lies below.
        missing: Option<[u8; 3]>,
    },
    /// Changes how an imagery layer goes on beyond its file's resolution.
    SetColourDetail {
        /// Which.
        id: LayerId,
        /// All of its detail, the first at the bottom.
        detail: Vec<ColourDetail>,
    },
    /// Links an imagery or height layer to another file.
    SetPath {
        /// Which.
        id: LayerId,
        /// Relative to the project's folder, or absolute.
        path: String,
    },
    /// Places an imagery or height layer's file.
    SetGeoreference {
        /// Which.
        id: LayerId,
        /// `None`: as the file says.
        georeference: Option<Georeference>,
    },
    /// Changes the value that means "no data".
    SetNodata {
        /// Which imagery or height layer.
        id: LayerId,
        /// `None`: as the file says.
        nodata: Option<f64>,
    },
    /// Changes how a set of tiles is read.
    SetTiles {
        /// Which imagery or height layer; only height layers have encodings.
        id: LayerId,
        /// `None`: as the set's metadata say.
        encoding: Option<HeightEncoding>,
        /// `None`: as the set's metadata or its kind say.
        tile_rows: Option<TileRows>,
    },
    /// Changes how stored numbers become colours.
    SetStretch {
        /// Which imagery layer.
        id: LayerId,
        /// The new way.
        stretch: Stretch,
    },
    /// Chooses bands: one, three or four for imagery, one for heights.
    SetBands {
        /// Which imagery or height layer.
        id: LayerId,
        /// Counted from 1; `None`: as the file says.
        bands: Option<Vec<u16>>,
    },
    /// Changes how a height layer's values become metres.
    SetHeightScale {
        /// Which height layer.
        id: LayerId,
        /// Metres per unit of the file.
        vertical_scale: f64,
        /// Metres added after scaling.
        offset_m: f64,
    },
    /// Changes a noise layer.
    SetNoise {
        /// Which.
        id: LayerId,
        /// All parameters.
        noise: Noise,
    },
    /// Changes a detail layer.
    SetDetail {
        /// Which.
        id: LayerId,
        /// All parameters.
        detail: Detail,
    },
    /// Changes a tint layer's colours.
    SetTint {
        /// Which.
        id: LayerId,
        /// All stops.
        tint: Tint,
    },
    /// Changes a slope layer's colours.
    SetSlope {
        /// Which.
        id: LayerId,
        /// All of it.
        slope: SlopeLayer,
    },
    /// Changes a layer of contour lines.
    SetContours {
        /// Which.
        id: LayerId,
        /// All of it.
        contours: ContoursLayer,
    },
    /// Changes the planet and the exaggeration.
    SetPlanet {
        /// The planet.
        planet: PlanetSettings,
    },
    /// Changes the exaggeration alone.
    SetExaggeration {
        /// Factor, 0 to 100.
        vertical_exaggeration: f64,
    },
    /// Moves the viewer. Not part of the undo history.
    SetCamera {
        /// Where to.
        camera: CameraSettings,
    },
    /// Changes the light.
    SetSun {
        /// The light.
        sun: Sun,
    },
    /// Changes how fine the picture is drawn.
    SetQuality {
        /// The quality.
        quality: Quality,
    },
    /// Changes how a vector layer's features are drawn.
    SetVectorStyle {
        /// Which vector layer.
        id: LayerId,
        /// The whole style.
        style: Box<VectorStyle>,
    },
    /// Changes how a vector layer's file is read.
    SetVectorSource {
        /// Which vector layer.
        id: LayerId,
        /// Which layer of the file. `None`: the first.
        source_layer: Option<String>,
        /// The coordinate system. `None`: the file's own.
        crs: Option<String>,
    },
    /// Adds a planning element.
    AddElement {
        /// Where: `None` is the base; of a scenario only its delta changes.
        scenario: Option<ScenarioId>,
        /// Position from the bottom. `None`: on top.
        index: Option<usize>,
        /// The element, its id not in use there.
        element: Arc<Element>,
    },
    /// Removes a planning element.
    RemoveElement {
        /// Where: `None` is the base.
        scenario: Option<ScenarioId>,
        /// Which.
        id: ElementId,
    },
    /// Puts a planning element in the place of the one with its id: geometry, surface, side slopes,
    /// or all of it.
    ReplaceElement {
        /// Where: `None` is the base.
        scenario: Option<ScenarioId>,
        /// The element.
        element: Arc<Element>,
    },
    /// Moves a planning element to a position counted from the bottom, itself taken out first.
    MoveElement {
        /// Where: `None` is the base.
        scenario: Option<ScenarioId>,
        /// Which.
        id: ElementId,
        /// New position, below the number of elements there.
        index: usize,
    },
    /// Changes what people call a planning element.
    SetElementName {
        /// Where: `None` is the base.
        scenario: Option<ScenarioId>,
        /// Which.
        id: ElementId,
        /// The new name.
        name: String,
    },
    /// Shows or hides a planning element.
    SetElementVisible {
        /// Where: `None` is the base.
        scenario: Option<ScenarioId>,
        /// Which.
        id: ElementId,
        /// Whether it takes part.
        visible: bool,
    },
    /// Locks or unlocks a planning element.
    SetElementLocked {
        /// Where: `None` is the base.
        scenario: Option<ScenarioId>,
        /// Which.
        id: ElementId,
        /// Whether edits in the window are refused.
        locked: bool,
    },
    /// Changes a planning element's colours.
    SetElementStyle {
        /// Where: `None` is the base.
        scenario: Option<ScenarioId>,
        /// Which.
        id: ElementId,
        /// All colours.
        style: ElementStyle,
    },
    /// Sets what a scenario changes about one element. The element edits come down to this in a
    /// scenario, and so do their inverses; without `change` the element is as in the parent again.
    SetChange {
        /// Which scenario.
        scenario: ScenarioId,
        /// Which element.
        id: ElementId,
        /// Position among the scenario's changes, a change of this element taken out first. `None`:
        /// where that was, else at the end.
        index: Option<usize>,
        /// The change, of a known kind. `None`: as in the parent.
        change: Option<Change>,
    },
    /// Sets everything that a scenario changes: where an element's order concerns others.
    SetChanges {
        /// Which scenario.
        scenario: ScenarioId,
        /// The changes, each element at most once.
        changes: Vec<Change>,
    },
    /// Adds a scenario.
    AddScenario {
        /// Position in the list. `None`: at the end.
        index: Option<usize>,
        /// The scenario, its id not in use, its parent there.
        scenario: Box<Scenario>,
    },
    /// Removes a scenario that no other is based on. Where it is shown, its parent is shown instead.
    RemoveScenario {
        /// Which.
        id: ScenarioId,
    },
    /// Changes what people call a scenario.
    RenameScenario {
        /// Which.
        id: ScenarioId,
        /// The new name.
        name: String,
    },
    /// Makes a copy of a scenario, behind it in the list and with the same parent.
    DuplicateScenario {
        /// Which.
        id: ScenarioId,
        /// The copy's id, not in use.
        new_id: ScenarioId,
        /// The copy's name.
        name: String,
    },
    /// Makes the changes of a scenario in its parent (the base where it has none) and removes the
    /// scenario; those that were based on it are then based on its parent. Nothing of what it and
    /// they show changes.
    MergeScenario {
        /// Which.
        id: ScenarioId,
    },
    /// Bases a scenario on another.
    SetScenarioParent {
        /// Which.
        id: ScenarioId,
        /// On which, not itself nor one that is based on it. `None`: the base.
        parent: Option<ScenarioId>,
    },
    /// Sets how a scenario shows one layer.
    SetScenarioLayer {
        /// Which scenario.
        scenario: ScenarioId,
        /// Which layer.
        id: LayerId,
        /// Position among the scenario's layers, that of this layer taken out first. `None`: where
        /// that was, else at the end.
        index: Option<usize>,
        /// How; its id is `id`. `None`: as in the parent.
        layer: Option<LayerOverride>,
    },
    /// Shows a scenario.
    ShowScenario {
        /// Which. `None`: the base.
        id: Option<ScenarioId>,
    },
    /// Adds a place to go back to.
    AddBookmark {
        /// Position in the list. `None`: at the end.
        index: Option<usize>,
        /// The place.
        bookmark: Bookmark,
    },
    /// Removes a bookmark.
    RemoveBookmark {
        /// Position in the list.
        index: usize,
    },
    /// Puts a bookmark in the place of another: renamed, or somewhere else.
    ReplaceBookmark {
        /// Position in the list.
        index: usize,
        /// The place.
        bookmark: Bookmark,
    },
    /// Several edits, in order, as one: all or none take effect.
    Batch {
        /// What people call it, for the undo menu; empty: the first edit's label.
        label: String,
        /// The edits; nested at most 8 deep.
        edits: Vec<Edit>,
    },
}

/// What an edit touches, so that the engine makes again only what depends on it.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Affects {
    /// One aspect of one layer.
    Layer {
        /// Which.
        id: LayerId,
        /// What of it.
        aspect: Aspect,
    },
    /// One aspect of one planning element.
    Element {
        /// In which scenario; `None` is the base.
        scenario: Option<ScenarioId>,
        /// Which.
        id: ElementId,
        /// What of it.
        aspect: Aspect,
    },
    /// A scenario: its place in the tree or how it shows layers. Which one is shown may change too.
    Scenario {
        /// Which.
        id: ScenarioId,
    },
    /// Any elements and layers of the base, and so of every scenario.
    Base,
    /// A scenario's name: no pixel changes.
    ScenarioName,
    /// Which scenario is shown, or what day.
    Shown,
    /// The bookmarks: no pixel changes.
    Bookmarks,
    /// The planet's figure.
    Planet,
    /// The exaggeration only.
    Exaggeration,
    /// The camera.
    Camera,
    /// The light.
    Sun,
    /// The quality of the picture.
    Quality,
}

/// What of a layer an edit touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Aspect {
    /// The layer was added or removed.
    Presence,
    /// Its position in the stack.
    Order,
    /// Its name: no pixel changes.
    Name,
    /// Whether it takes part.
    Visibility,
    /// Its opacity.
    Opacity,
    /// Its lock: no pixel changes.
    Lock,
    /// Its blend mode.
    Blend,
    /// Where it shows.
    Mask,
    /// Its colour adjustment.
    Adjust,
    /// Its file or how the file is read: path, place, nodata, bands, encoding of tiles.
    Source,
    /// Its resampling kernel.
    Resampling,
    /// Its edge fade, or how it bends to what lies below.
    EdgeFade,
    /// Its vertical scale and offset.
    HeightScale,
    /// Its noise, or the detail that it adds: to heights or to its colours.
    Noise,
    /// Its tint.
    Tint,
    /// An element's geometry, heights or side slopes.
    Shape,
    /// Its colours: of an element, of a vector layer's features, of slopes or contour lines.
    Style,
}

impl Aspect {
    /// Whether the aspect can change a pixel or a height.
    pub fn is_visible(self) -> bool {
        !matches!(self, Self::Name | Self::Lock)
    }
}
