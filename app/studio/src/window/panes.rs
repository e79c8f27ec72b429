//! The panes of the window and where they lie: a tree of rows, columns and tabs that is kept from
//! one run to the next.
//!
//! Invariant: every pane is in the tree once. What is hidden keeps its place.

mod pane;

use std::collections::BTreeSet;

use eframe::egui::Id;
use egui_tiles::{Linear, LinearDir, Tile, TileId, Tiles, Tree};
use serde::Deserialize as _;
use serde_json::Value;

use pane::Home;
pub use pane::Pane;

/// Shares of the width that the panes at the left, the view and the panes at the right take at first.
const WIDTHS: [f32; 3] = [0.21, 0.53, 0.26];

/// Shares of the height that the panes below take at first.
const HEIGHTS: [f32; 2] = [0.76, 0.24];

/// Where the panes lie.
pub(crate) struct Layout {
    tree: Tree<Pane>,
    changed: bool,
}

impl Default for Layout {
    fn default() -> Self {
        Self {
            tree: first(),
            changed: false,
        }
    }
}

impl Layout {
    /// A layout that was kept; the first one where it is damaged or of another version.
    pub(crate) fn of(kept: Option<&Value>) -> Self {
        let tree = kept.and_then(|value| Tree::deserialize(value).ok());
        match tree.filter(is_sound) {
            Some(mut tree) => {
                add_missing(&mut tree);
                Self {
                    tree,
                    changed: false,
                }
            }
            None => Self::default(),
        }
    }

    /// What to keep.
    pub(crate) fn to_value(&self) -> Option<Value> {
        serde_json::to_value(&self.tree).ok()
    }

    /// Takes the tree out to draw it; [`Self::put_back`] follows.
    pub(crate) fn take(&mut self) -> Tree<Pane> {
        std::mem::replace(&mut self.tree, Tree::empty(id()))
    }

    /// Puts the tree back; `changed`: somebody moved something.
    pub(crate) fn put_back(&mut self, tree: Tree<Pane>, changed: bool) {
        self.tree = tree;
        self.changed |= changed;
    }

    /// Whether something changed since the last call.
    pub(crate) fn take_changed(&mut self) -> bool {
        std::mem::take(&mut self.changed)
    }

    /// Whether a pane is shown, be it behind another tab.
    pub(crate) fn is_open(&self, pane: Pane) -> bool {
        let tile = self.tree.tiles.find_pane(&pane);
        tile.is_some_and(|tile| self.tree.tiles.is_visible(tile))
    }

    /// Whether a pane is shown and no other tab lies before it.
    pub(crate) fn is_in_front(&self, pane: Pane) -> bool {
        let tiles = &self.tree.tiles;
        tiles
            .find_pane(&pane)
            .filter(|tile| tiles.is_visible(*tile))
            .is_some_and(|tile| self.tree.active_tiles().contains(&tile))
    }

    /// Shows a pane before all others of its tabs.
    pub(crate) fn open(&mut self, pane: Pane) {
        if let Some(tile) = self.tree.tiles.find_pane(&pane) {
            self.tree.set_visible(tile, true);
            self.tree.make_active(|_, tile| *tile == Tile::Pane(pane));
            self.changed = true;
        }
    }

    /// Hides a pane; the view stays.
    pub(crate) fn hide(&mut self, pane: Pane) {
        if let Some(tile) = self.tree.tiles.find_pane(&pane)
            && pane != Pane::View
        {
            self.tree.set_visible(tile, false);
            self.changed = true;
        }
    }

    /// Hides a pane that is in front, shows any other.
    pub(crate) fn toggle(&mut self, pane: Pane) {
        if self.is_in_front(pane) {
            self.hide(pane);
        } else {
            self.open(pane);
        }
    }

    /// Everything where it was at first.
    pub(crate) fn reset(&mut self) {
        *self = Self {
            tree: first(),
            changed: true,
        };
    }
}

fn id() -> Id {
    Id::unique("relievo panes")
}

/// Layers at the left, settings at the right, the view between them, the rest below and hidden.
fn first() -> Tree<Pane> {
    let mut tiles = Tiles::default();
    let mut group = |home: Home| {
        let panes = Pane::ALL.into_iter().filter(|p| p.home() == home);
        let children: Vec<TileId> = panes
            .map(|pane| {
                let tile = tiles.insert_pane(pane);
                tiles.set_visible(tile, pane.is_open_at_first());
                tile
            })
            .collect();
        tiles.insert_tab_tile(children)
    };
    let [upper, lower, middle, right, below] = [
        Home::Left,
        Home::LowerLeft,
        Home::Middle,
        Home::Right,
        Home::Below,
    ]
    .map(&mut group);
    let left = tiles.insert_vertical_tile(vec![upper, lower]);
    let mut row = Linear::new(LinearDir::Horizontal, vec![left, middle, right]);
    for (tile, share) in [left, middle, right].into_iter().zip(WIDTHS) {
        row.shares.set_share(tile, share);
    }
    let row = tiles.insert_container(row);
    let mut column = Linear::new(LinearDir::Vertical, vec![row, below]);
    for (tile, share) in [row, below].into_iter().zip(HEIGHTS) {
        column.shares.set_share(tile, share);
    }
    let root = tiles.insert_container(column);
    Tree::new(id(), root, tiles)
}

/// Whether what was read is a tree: everything is reached from the root once, nothing is missing, no
/// pane is there twice, the view is shown.
fn is_sound(tree: &Tree<Pane>) -> bool {
    let (mut seen, mut panes) = (BTreeSet::new(), BTreeSet::new());
    let mut open: Vec<TileId> = tree.root().into_iter().collect();
    while let Some(tile) = open.pop() {
        if !seen.insert(tile.0) {
            return false;
        }
        match tree.tiles.get(tile) {
            Some(Tile::Pane(pane)) => {
                if !panes.insert(*pane) {
                    return false;
                }
            }
            Some(Tile::Container(container)) => open.extend(container.children()),
            None => return false,
        }
    }
    let shown = tree.tiles.find_pane(&Pane::View);
    tree.id() == id()
        && seen.len() == tree.tiles.len()
        && shown.is_some_and(|tile| tree.tiles.is_visible(tile))
}

/// Adds panes that the layout does not know yet, hidden, beside others of their home.
fn add_missing(tree: &mut Tree<Pane>) {
    for pane in Pane::ALL {
        if tree.tiles.find_pane(&pane).is_some() {
            continue;
        }
        let beside = Pane::ALL
            .into_iter()
            .filter(|p| p.home() == pane.home())
            .find_map(|p| tree.tiles.find_pane(&p));
        let tabs = beside
            .and_then(|tile| tree.tiles.parent_of(tile))
            .or(tree.root());
        let tile = tree.tiles.insert_pane(pane);
        tree.set_visible(tile, false);
        match tabs.and_then(|tabs| tree.tiles.get_mut(tabs)) {
            Some(Tile::Container(container)) => container.add_child(tile),
            Some(Tile::Pane(_)) | None => *tree = first(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(layout: &Layout) -> Value {
        let text = layout.to_value().unwrap().to_string();
        serde_json::from_str(&text).unwrap()
    }

    #[test]
    fn a_layout_comes_back_as_it_was() {
        let mut layout = Layout::default();
        layout.open(Pane::Graph);
        layout.hide(Pane::Layers);
        let back = Layout::of(Some(&kept(&layout)));
        for pane in Pane::ALL {
            assert_eq!(back.is_open(pane), layout.is_open(pane), "{pane:?}");
        }
        assert!(back.is_open(Pane::Graph) && !back.is_open(Pane::Layers));
        assert!(back.tree == layout.tree);
    }

    #[test]
    fn toggling_brings_to_the_front_before_it_hides_and_never_hides_the_view() {
        let mut layout = Layout::default();
        layout.toggle(Pane::Messages);
        layout.toggle(Pane::Graph);
        assert!(layout.is_open(Pane::Messages) && !layout.is_in_front(Pane::Messages));
        layout.toggle(Pane::Messages);
        assert!(layout.is_in_front(Pane::Messages));
        layout.toggle(Pane::Messages);
        assert!(!layout.is_open(Pane::Messages));
        layout.hide(Pane::View);
        assert!(layout.is_open(Pane::View));
        layout.reset();
        assert!(!layout.is_open(Pane::Graph));
    }

    #[test]
    fn a_damaged_layout_is_the_first_one() {
        let good = kept(&Layout::default());
        let mut cyclic = good.clone();
        let root = good["root"].clone();
        let tiles = cyclic["tiles"]["tiles"].as_object_mut().unwrap();
        for tile in tiles.values_mut() {
            if let Some(tabs) = tile.pointer_mut("/Container/Tabs/children") {
                tabs.as_array_mut().unwrap().push(root.clone());
            }
        }
        let mut empty = good.clone();
        empty["root"] = Value::Null;
        let mut dangling = good.clone();
        dangling["tiles"]["tiles"].as_object_mut().unwrap().clear();
        let text = good.to_string().replacen("\"history\"", "\"layers\"", 1);
        let twice = serde_json::from_str(&text).unwrap();
        for damaged in [
            cyclic,
            empty,
            dangling,
            twice,
            Value::Null,
            good["root"].clone(),
        ] {
            assert!(
                Layout::of(Some(&damaged)).tree == Layout::default().tree,
                "{damaged}"
            );
        }
    }

    #[test]
    fn a_pane_of_a_later_version_is_added_hidden() {
        let mut tree = first();
        let tile = tree.tiles.find_pane(&Pane::History).unwrap();
        tree.remove_recursively(tile);
        let layout = Layout {
            tree,
            changed: false,
        };
        let back = Layout::of(Some(&kept(&layout)));
        assert!(back.tree.tiles.find_pane(&Pane::History).is_some());
        assert!(!back.is_open(Pane::History));
    }
}
