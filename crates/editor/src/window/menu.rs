//! The commands of a menu: with their keys, and ticks on what is switched on.

use crate::actions::Action;
use crate::commands::{Command, commands};
use crate::editor::Editor;
use egui::{AtomExt as _, Button, TextStyle, Ui, WidgetInfo, WidgetType, vec2};

/// Width of the column of ticks, in points.
const TICKS: f32 = 12.0;

/// Draws the commands of a menu. Those that arrange the panels are in the list of layouts.
pub(super) fn commands_ui(editor: &Editor, ui: &mut Ui, menu: &str, actions: &mut Vec<Action>) {
    let own = commands().filter(|command| command.menu == menu);
    let own = own.map(|command| (command, (command.action)(&editor.state)));
    let own = own.filter(|(_, action)| !matches!(action, Action::Layout(_) | Action::NameLayout));
    let entries: Vec<(&Command, Action, Option<bool>)> = own
        .map(|(command, action)| {
            let on = is_on(editor, &action);
            (command, action, on)
        })
        .collect();
    let has_ticks = entries.iter().any(|(.., on)| on.is_some());
    let tick_size = vec2(TICKS, ui.text_style_height(&TextStyle::Body));
    for (command, action, on) in entries {
        if command.begins {
            ui.separator();
        }
        let tick = if on == Some(true) { "✔" } else { "" };
        let button = match has_ticks {
            true => Button::new((tick.atom_size(tick_size), command.name)),
            false => Button::new(command.name),
        };
        let enabled = (command.enabled)(&editor.state);
        let row = ui.add_enabled(enabled, button.shortcut_text(command.written_keys(ui.ctx())));
        row.widget_info(|| WidgetInfo {
            selected: on,
            ..WidgetInfo::labeled(WidgetType::Button, enabled, command.name)
        });
        if row.on_hover_text(command.whole_help()).clicked() {
            actions.push(action);
        }
    }
}

/// Returns whether what an action switches is on; `None` if it only does something.
fn is_on(editor: &Editor, action: &Action) -> Option<bool> {
    let state = &editor.state;
    match action {
        Action::Viewer(switch) => editor.panels.viewer.is_on(*switch, state),
        Action::Onion(next) => Some(!next),
        Action::Proxy(proxy) => Some(*proxy == state.look.proxy),
        Action::Disable => {
            let mut chosen = state.selection.iter().filter_map(|name| state.sheet().node(name)).peekable();
            Some(chosen.peek().is_some() && chosen.all(|node| node.disabled))
        }
        _ => None,
    }
}
