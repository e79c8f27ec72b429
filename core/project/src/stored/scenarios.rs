//! Scenarios and bookmarks of version 1.

use super::elements::Element;
use super::range;
use super::settings::Camera;
use super::value::With;

fields! {
    /// A named delta on the base or on another scenario.
    Scenario {
        /// Stable id, unique among the scenarios: letters, digits, `-`, `_` and `.`.
        #[schemars(regex(pattern = r"^[A-Za-z0-9._-]{1,64}$"))]
        id: String,
        /// What people call it; the id where left out.
        #[schemars(length(max = range::LONGEST_NAME))]
        name: Option<String>,
        /// Id of the scenario on which it is based; the base where left out.
        parent: Option<String>,
        /// What it changes, each element at most once.
        #[schemars(length(max = range::MOST_ELEMENTS))]
        changes: Option<Vec<Change>>,
        /// Layers that it shows otherwise, each at most once.
        #[schemars(length(max = range::MOST_LAYERS))]
        layers: Option<Vec<With<LayerOverride>>>,
    }
}

tagged! {
    /// Changes of a scenario.
    Change of Changes by "change", "What a scenario changes about one element; other kinds are kept and have no effect." {
        /// Adds an element.
        AddChange(AddChange) = "add" {
            /// Position from the bottom; on top where left out.
            index: Option<u32>,
            /// The element.
            element: Element,
        }
        /// Puts an element in the place of the one with its id.
        ReplaceChange(ReplaceChange) = "replace" {
            /// New position from the bottom; where the old one was where left out.
            index: Option<u32>,
            /// The element.
            element: Element,
        }
        /// Takes an element away.
        RemoveChange(RemoveChange) = "remove" {
            /// Which.
            id: String,
        }
    }
}

fields! {
    /// How a scenario shows a layer.
    LayerOverride {
        /// Which layer.
        id: String,
        /// Whether it takes part; as in the parent where left out.
        visible: Option<bool>,
        /// Its opacity; as in the parent where left out.
        opacity: Option<f64> = range::SHARE,
    }
}

fields! {
    /// A named place of the viewer.
    Bookmark {
        /// What people call it.
        #[schemars(length(max = range::LONGEST_NAME))]
        name: String,
        /// Where the viewer is.
        camera: With<Camera>,
    }
}
