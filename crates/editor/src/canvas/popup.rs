//! The popup that explains why a wire was refused and offers a node that makes the connection possible.

use super::Canvas;
use super::plan::Plan;
use crate::actions::Action;
use crate::theme;
use egui::{Area, Frame, Key, Order, RichText, Ui, vec2};

impl Canvas {
    /// Shows why the last wire was refused, until dismissed.
    pub(super) fn refusal_ui(&mut self, plan: &Plan, ui: &Ui, actions: &mut Vec<Action>) {
        let Some((refusal, at)) = self.refusal.take() else { return };
        let (mut bridged, mut closed) = (false, false);
        let area = Area::new(ui.id().with("refusal")).order(Order::Foreground).fixed_pos(at + vec2(12.0, 12.0));
        let shown = area.constrain_to(self.view.rect).show(ui.ctx(), |ui| {
            Frame::popup(ui.style()).show(ui, |ui| {
                ui.set_max_width(300.0);
                ui.label(RichText::new(&refusal.title).strong().color(theme::error(ui.visuals())));
                ui.label(refusal.why.to_string());
                ui.add_space(4.0);
                ui.horizontal(|ui| {
                    if let Some(bridge) = &refusal.bridge {
                        bridged = ui.button(format!("Insert {}", with_article(bridge.ty))).clicked();
                    }
                    closed = ui.button("Cancel").clicked();
                });
            });
        });
        let escape = ui.input(|input| input.key_pressed(Key::Escape));
        // The release that opened the popup does not count as a click elsewhere.
        let elsewhere = ui.input(|input| input.pointer.any_pressed()) && !shown.response.contains_pointer();
        match refusal.bridge {
            Some(bridge) if bridged => {
                actions.push(Action::Edit(plan.freezing(bridge.edit)));
                actions.push(Action::Seal);
                actions.push(Action::Select([bridge.name].into()));
            }
            _ if closed || escape || elsewhere => {}
            _ => self.refusal = Some((refusal, at)),
        }
    }
}

/// Prepends the indefinite article: `a Clamp`, `an Invert`.
fn with_article(name: &str) -> String {
    let vowel = name.starts_with(['A', 'E', 'I', 'O', 'U']);
    format!("{} {name}", if vowel { "an" } else { "a" })
}
