//! Colours of a vector layer by a property of its features.

use eframe::egui::{self, Color32, ComboBox, DragValue, RichText, ScrollArea, Ui, WidgetInfo};
use relievo_engine::project::{LayerId, StyleClass, VectorStyle};
use relievo_engine::vector::Features;

use super::Set;
use crate::window::action::Action;
use crate::window::classes::{Method, Recipe, title};
use crate::window::controls;

/// Ranges at first, and how many may be asked for.
const RANGES: usize = 5;
const MOST_RANGES: usize = 24;

/// Height of a row in points, and rows that are seen at once.
const ROW: f32 = 22.0;
const ROWS: f32 = 9.0;

/// Draws the choice of a property, how classes are made and the classes. Without features, as long as
/// the file is not open, classes are only shown.
pub(super) fn show(
    ui: &mut Ui,
    id: &LayerId,
    style: &VectorStyle,
    features: Option<&Features>,
    set: &Set<'_>,
    actions: &mut Vec<Action>,
) {
    let key = egui::Id::unique(("classes", &id.0));
    let (mut method, mut count) = ui
        .data(|d| d.get_temp::<(Method, usize)>(key))
        .unwrap_or((Method::default(), RANGES));
    let before = (method, count);
    let now = style.by.as_ref().map(|by| by.property.clone());
    let mut property = now.clone();
    ui.horizontal(|ui| {
        let label = controls::name(ui, "Colour by", now.is_some());
        let hint = "The property of the file whose values decide the colour";
        let shown = now.as_deref().unwrap_or("All alike");
        let combo = ComboBox::from_id_salt("colour by")
            .selected_text(shown)
            .width(ui.available_width() - 8.0);
        let combo = combo.show_ui(ui, |ui| {
            ui.selectable_value(&mut property, None, "All alike");
            for column in features.into_iter().flat_map(Features::columns) {
                let name = column.to_string();
                ui.selectable_value(&mut property, Some(name.clone()), name);
            }
        });
        combo.response.labelled_by(label.id).on_hover_text(hint);
    });
    let chosen = property != now;
    if chosen && property.is_none() {
        actions.push(Action::Edit(set(&|s| s.by = None)));
        return;
    }
    let Some(property) = property else { return };
    ui.horizontal(|ui| {
        let label = controls::name(ui, "Classes", false);
        let hint = "How classes are made: one for each value, or ranges of numbers";
        let shown = Method::ALL.iter().find(|(m, _)| *m == method);
        let combo = ComboBox::from_id_salt("classes by")
            .selected_text(shown.map_or("", |(_, text)| text))
            .width(110.0);
        let combo = combo.show_ui(ui, |ui| {
            for (option, text) in Method::ALL {
                ui.selectable_value(&mut method, option, text);
            }
        });
        combo.response.labelled_by(label.id).on_hover_text(hint);
        if method != Method::Unique {
            let field = DragValue::new(&mut count).range(1..=MOST_RANGES);
            let field = ui.add(field.update_while_editing(false));
            field.widget_info(|| WidgetInfo {
                label: Some("Number of classes".to_owned()),
                ..WidgetInfo::drag_value(true, count as f64)
            });
            field.on_hover_text(format!("Number of classes, 1 to {MOST_RANGES}"));
        }
        let again = ui.add_enabled(features.is_some(), egui::Button::new("Make"));
        let hint = "Make the classes anew; colours that were chosen are lost";
        if again.on_hover_text(hint).clicked() || chosen || (method, count) != before {
            let recipe = Recipe {
                property: property.clone(),
                method,
                count,
                fills: style.fill.is_some() || style.stroke.is_none() || style.point.is_some(),
            };
            actions.push(Action::Classify(id.clone(), recipe));
        }
    });
    ui.data_mut(|d| d.insert_temp(key, (method, count)));
    let Some(by) = &style.by else { return };
    let classes = &by.classes;
    ScrollArea::vertical()
        .id_salt("classes")
        .max_height(ROW * ROWS)
        .show_rows(ui, ROW, classes.len(), |ui, rows| {
            for at in rows {
                ui.push_id(at, |ui| {
                    ui.horizontal(|ui| row(ui, &classes[at], at, set, actions));
                });
            }
        });
    ui.label(
        RichText::new("Features in no class have the colours above.")
            .small()
            .weak(),
    );
}

fn row(ui: &mut Ui, class: &StyleClass, at: usize, set: &Set<'_>, actions: &mut Vec<Action>) {
    let title = title(&class.matches);
    let change = |change: &dyn Fn(&mut StyleClass)| {
        Action::Edit(set(&|s| {
            let classes = s.by.as_mut().map(|by| &mut by.classes);
            if let Some(class) = classes.and_then(|classes| classes.get_mut(at)) {
                change(class);
            }
        }))
    };
    let well = |ui: &mut Ui, part: &str, value: Option<[u8; 3]>| -> Option<[u8; 3]> {
        let old = value?;
        let mut new = old;
        let button = ui.color_edit_button_srgb(&mut new);
        let label = format!("{part} of {title}");
        button.widget_info(|| WidgetInfo::labeled(egui::Role::ColorWell, true, &label));
        (new != old).then_some(new)
    };
    let fill = well(ui, "Fill", class.fill);
    let stroke = well(ui, "Line", class.stroke);
    if let Some(new) = fill {
        actions.push(change(&|c| c.fill = Some(new)));
    }
    if let Some(new) = stroke {
        actions.push(change(&|c| c.stroke = Some(new)));
    }
    if class.fill.is_none() && class.stroke.is_none() {
        ui.colored_label(Color32::GRAY, "–");
    }
    let remove = ui.small_button("×");
    let label = format!("Remove class {title}");
    remove.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, &label));
    if remove
        .on_hover_text("Its features get the layer's own colours")
        .clicked()
    {
        actions.push(Action::Edit(set(&|s| {
            if let Some(by) = &mut s.by
                && at < by.classes.len()
            {
                by.classes.remove(at);
            }
        })));
    }
    ui.add(egui::Label::new(&title).truncate())
        .on_hover_text(&title);
}
