//! Edits: the only way to change a project.

use crate::{
    Adjust, Blend, CameraSettings, Georeference, HeightEncoding, Layer, LayerId, Noise,
    PlanetSettings, Quality, Resampling, Stretch, Sun, TileRows, Tint,
};

/// One change of a project. Values replace the old ones as a whole.
#[derive(Clone, Debug, PartialEq)]
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
    /// Changes how an imagery or tint layer meets the layers below.
    SetBlend {
        /// Which.
        id: LayerId,
        /// The mode.
        blend: Blend,
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
    /// Changes a tint layer's colours.
    SetTint {
        /// Which.
        id: LayerId,
        /// All stops.
        tint: Tint,
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
    /// Its colour adjustment.
    Adjust,
    /// Its file or how the file is read: path, place, nodata, bands, encoding of tiles.
    Source,
    /// Its resampling kernel.
    Resampling,
    /// Its edge fade.
    EdgeFade,
    /// Its vertical scale and offset.
    HeightScale,
    /// Its noise.
    Noise,
    /// Its tint.
    Tint,
}

impl Aspect {
    /// Whether the aspect can change a pixel or a height.
    pub fn is_visible(self) -> bool {
        !matches!(self, Self::Name | Self::Lock)
    }
}
