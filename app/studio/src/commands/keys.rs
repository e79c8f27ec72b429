//! Which commands the keys ask for.

use eframe::egui::{Context, Key, KeyboardShortcut};

use super::{Command, TABLE};

/// The commands whose keys are pressed, which are then used up. While a text is being edited only
/// keys with Ctrl count.
pub fn pressed(ctx: &Context) -> Vec<Command> {
    let typing = ctx.text_edit_focused();
    let mut all: Vec<(&KeyboardShortcut, Command)> = TABLE
        .iter()
        .flat_map(|e| e.shortcuts.iter().map(|s| (s, e.command)))
        .collect();
    // Ctrl+Shift+S is also Ctrl+S to who looks at Ctrl only.
    all.sort_by_key(|(s, _)| core::cmp::Reverse(modifiers(**s)));
    let allowed = |s: &KeyboardShortcut| {
        !typing || (s.modifiers.command && s.logical_key != Key::Z && s.logical_key != Key::Y)
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
