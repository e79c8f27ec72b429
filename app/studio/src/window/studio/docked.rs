//! Drawing the panes.

use eframe::egui::{
    self, CentralPanel, CursorIcon, Frame, Margin, Panel, ScrollArea, Stroke, Ui, Visuals,
};
use egui_tiles::{
    Behavior, EditAction, ResizeState, SimplificationOptions, TabState, Tabs, TileId, Tiles,
    UiResponse,
};

use super::Studio;
use crate::commands::Command;
use crate::window::action::Action;
use crate::window::inspector::element::Shown;
use crate::window::panes::Pane;
use crate::window::{elements, history, layers, messages, place, scene, statistics, status, theme};

/// Smallest side of a pane, points.
const LEAST: f32 = 70.0;

impl Studio {
    /// Menu, panes and status bar.
    pub(super) fn panels(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        Panel::top("menu").show(ui, |ui| self.menus(ui, actions));
        Panel::bottom("status").exact_size(26.0).show(ui, |ui| {
            status::show(ui, &self.status, &mut self.notation, actions);
        });
        let bare = Frame::new().inner_margin(Margin::ZERO);
        CentralPanel::default().frame(bare).show(ui, |ui| {
            let mut tree = self.layout.take();
            let mut docked = Docked {
                view: tree.tiles.find_pane(&Pane::View),
                studio: self,
                actions,
                changed: false,
            };
            tree.ui(&mut docked, ui);
            let changed = docked.changed;
            self.layout.put_back(tree, changed);
        });
    }

    fn pane(&mut self, ui: &mut Ui, pane: Pane, actions: &mut Vec<Action>) {
        let engine = self.document.engine();
        let measures = matches!(
            pane,
            Pane::Profile | Pane::Volumes | Pane::Viewshed | Pane::Flood | Pane::Contours
        );
        if measures && let Some(sentence) = engine.left_out_of_measures() {
            ui.weak(sentence);
        }
        match pane {
            Pane::View => self.viewport(ui, actions),
            Pane::Layers => {
                // One thing at a time is what keys and the inspector mean.
                let selected = self.selected.as_ref();
                let selected = selected.filter(|_| self.selected_element.is_none());
                layers::show(ui, engine, selected, actions);
            }
            Pane::Elements => {
                let (scenario, shown) = (self.scenario(), self.elements());
                let selected = self.selected_element.as_ref();
                elements::show(ui, scenario.as_ref(), &shown, selected, actions);
            }
            Pane::Scenarios => {
                let compared = self.compare.as_ref().map(|c| (c.other.clone(), c.mode));
                self.scenarios
                    .show(ui, engine.project(), compared.as_ref(), actions);
            }
            Pane::Bookmarks => {
                let camera = *self.navigation.camera();
                self.bookmarks.show(ui, engine.project(), &camera, actions);
            }
            Pane::Inspector => self.inspect(ui, actions),
            Pane::Scene => scene::show(ui, engine.project(), &self.governor, actions),
            Pane::History => history::show(ui, engine, actions),
            Pane::Messages => messages::show(ui, engine, &mut self.log, actions),
            Pane::Place => {
                let answer = self.probe.last().and_then(|last| last.answer);
                place::show(ui, engine.project(), self.notation, answer.as_ref());
            }
            Pane::Histogram => self.histogram_pane(ui, actions),
            Pane::Match => self.match_pane(ui, actions),
            Pane::Profile => self.profile_pane(ui),
            Pane::Volumes => self.volumes_pane(ui, actions),
            Pane::Viewshed => self.viewshed_pane(ui, actions),
            Pane::Flood => self.flood_pane(ui, actions),
            Pane::Contours => self.contours_pane(ui, actions),
            Pane::Graph => self.graph.show(ui, engine),
            Pane::Statistics => {
                let frame = self.stage.as_ref().and_then(|s| s.stats());
                statistics::show(ui, engine, frame, &self.status);
            }
        }
    }
}

impl Studio {
    /// Settings of the selected element, or else of the selected layer.
    fn inspect(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        let Some(element) = self.selected_element() else {
            let engine = self.document.engine();
            self.inspector
                .show(ui, engine, self.selected.as_ref(), actions);
            return;
        };
        let vertex = self.tools.vertex.as_ref();
        let shown = Shown {
            scenario: self.scenario(),
            element: &element,
            vertex: vertex
                .filter(|(id, _)| *id == element.id)
                .map(|(_, spot)| *spot),
        };
        ScrollArea::vertical()
            .auto_shrink([false, false])
            .show(ui, |ui| {
                self.element_form.show(ui, &shown, actions);
                ui.add_space(8.0);
            });
    }
}

/// How the tree of panes looks and what its panes show.
struct Docked<'a> {
    studio: &'a mut Studio,
    actions: &'a mut Vec<Action>,
    /// The tile of the view.
    view: Option<TileId>,
    changed: bool,
}

impl Behavior<Pane> for Docked<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _tile: TileId, pane: &mut Pane) -> UiResponse {
        if *pane == Pane::View {
            self.studio.viewport(ui, self.actions);
            return UiResponse::None;
        }
        let fill = ui.visuals().panel_fill;
        let frame = Frame::new()
            .fill(fill)
            .inner_margin(Margin::symmetric(8, 6));
        frame.show(ui, |ui| {
            ui.set_min_size(ui.available_size());
            ui.push_id(pane.title(), |ui| self.studio.pane(ui, *pane, self.actions));
        });
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> egui::WidgetText {
        pane.title().into()
    }

    fn tab_hover_cursor_icon(&self) -> CursorIcon {
        CursorIcon::PointingHand
    }

    fn on_tab_button(
        &mut self,
        tiles: &mut Tiles<Pane>,
        tile: TileId,
        response: egui::Response,
    ) -> egui::Response {
        let Some(pane) = tiles.get_pane(&tile).copied() else {
            return response;
        };
        if response.middle_clicked() {
            self.actions.push(Action::Hide(pane));
        }
        response.context_menu(|ui| {
            if ui.button(format!("Hide {}", pane.title())).clicked() {
                self.actions.push(Action::Hide(pane));
                ui.close();
            }
            if ui.button("Reset panes").clicked() {
                self.actions.push(Action::Run(Command::ResetPanes));
                ui.close();
            }
        });
        response.on_hover_text("Drag to move this pane")
    }

    fn top_bar_right_ui(
        &mut self,
        tiles: &Tiles<Pane>,
        ui: &mut Ui,
        _tile: TileId,
        tabs: &Tabs,
        _scroll: &mut f32,
    ) {
        let Some(pane) = tabs.active.and_then(|tile| tiles.get_pane(&tile)) else {
            return;
        };
        ui.add_space(4.0);
        let name = format!("Hide {}", pane.title());
        let button = ui.add(egui::Button::new("×").frame(false));
        button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
        if button.on_hover_text(name).clicked() {
            self.actions.push(Action::Hide(*pane));
        }
    }

    fn is_tab_bar_visible(&self, _tile: TileId, tabs: &Tabs) -> bool {
        // The view needs no title, unless other panes share its place.
        tabs.children.iter().any(|child| Some(*child) != self.view)
    }

    fn tab_bar_height(&self, _style: &egui::Style) -> f32 {
        26.0
    }

    fn gap_width(&self, _style: &egui::Style) -> f32 {
        2.0
    }

    fn min_size(&self) -> f32 {
        LEAST
    }

    fn simplification_options(&self) -> SimplificationOptions {
        SimplificationOptions {
            all_panes_must_have_tabs: true,
            ..SimplificationOptions::default()
        }
    }

    fn tab_bar_color(&self, visuals: &Visuals) -> egui::Color32 {
        theme::behind_tabs(visuals)
    }

    fn tab_outline_stroke(
        &self,
        _visuals: &Visuals,
        _tiles: &Tiles<Pane>,
        _tile: TileId,
        _state: &TabState,
    ) -> Stroke {
        Stroke::NONE
    }

    fn resize_stroke(&self, style: &egui::Style, state: ResizeState) -> Stroke {
        match state {
            ResizeState::Idle => style.visuals.widgets.noninteractive.bg_stroke,
            ResizeState::Hovering => style.visuals.widgets.hovered.fg_stroke,
            ResizeState::Dragging => Stroke::new(2.0, style.visuals.selection.bg_fill),
        }
    }

    fn on_edit(&mut self, _action: EditAction) {
        self.changed = true;
    }
}
