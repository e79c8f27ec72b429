//! Which commands the keys ask for.

use eframe::egui::{Context, Id, Key, KeyboardShortcut};

use super::{Command, TABLE};

/// Where the widget is kept that uses plain keys itself.
#[derive(Clone, Copy, Debug, PartialEq)]
struct UsesKeys(Id);

/// While a widget has the focus, plain keys (Delete, arrows) are its own.
pub fn uses_keys(ctx: &Context, widget: Id) {
    ctx.data_mut(|d| d.insert_temp(Id::NULL, UsesKeys(widget)));
}

/// The commands whose keys are pressed, which are then used up. While a text is being edited, or a widget
/// has the focus that [uses plain keys](uses_keys), only keys with Ctrl count.
pub fn pressed(ctx: &Context) -> Vec<Command> {
    let focused = ctx.memory(eframe::egui::Memory::focused);
    let used = ctx.data(|d| d.get_temp::<UsesKeys>(Id::NULL));
    let in_use = focused.is_some_and(|id| used == Some(UsesKeys(id)));
    let typing = ctx.text_edit_focused();
    let mut all: Vec<(&KeyboardShortcut, Command)> = TABLE
        .iter()
        .flat_map(|e| e.shortcuts.iter().map(|s| (s, e.command)))
        .collect();
    // Ctrl+Shift+S is also Ctrl+S to who looks at Ctrl only.
    all.sort_by_key(|(s, _)| core::cmp::Reverse(modifiers(**s)));
    let allowed = |s: &KeyboardShortcut| {
        let undoes = matches!(s.logical_key, Key::Z | Key::Y);
        match (typing, in_use) {
            (false, false) => true,
            (false, true) => s.modifiers.command,
            // Texts have an undo of their own.
            (true, _) => s.modifiers.command && !undoes,
        }
    };
    ctx.input_mut(|input| {
        all.into_iter()
            .filter(|(s, _)| allowed(s))
            .filter(|(s, _)| input.consume_shortcut(s))
            .map(|(_, c)| c)
            .collect()
    })
}

fn modifiers(shortcut: KeyboardShortcut) -> u8 {
    let m = shortcut.modifiers;
    u8::from(m.command) + u8::from(m.shift) + u8::from(m.alt)
}
