//! Context menus of the canvas.

use super::Canvas;
use super::follow::Dropped;
use super::plan::Plan;
use super::search::Search;
use crate::actions::{Action, HelpPage, Line, Pane};
use crate::document::sheet::Backdrop;
use crate::document::{Point, decor};
use crate::state::State;
use crate::theme::TINTS;
use egui::{
    Align, Color32, Layout, Popup, PopupKind, Pos2, Rect, Sense, TextWrapMode, Ui, WidgetInfo, WidgetType, vec2,
};

/// Item that was right-clicked.
#[derive(Clone, Debug)]
pub(super) enum MenuTarget {
    /// The selected nodes.
    Nodes,
    /// A backdrop.
    Backdrop(String),
    /// An output.
    Output(String),
    /// A knob that was dropped on a node.
    Follow(Dropped),
    /// The empty canvas.
    Empty,
}

/// A context menu at a place on the screen.
pub(super) struct Menu {
    at: Pos2,
    about: MenuTarget,
    /// Number of menus opened before, used in its id so that no menu inherits the size of another.
    serial: u64,
}

/// Returns the corners of aligned or distributed nodes.
pub(super) fn lined_up(boxes: &[Rect], line: Line) -> Vec<Point> {
    let all = boxes.iter().copied().fold(Rect::NOTHING, Rect::union);
    let mean = boxes.iter().map(|own| own.center().x).sum::<f32>() / boxes.len().max(1) as f32;
    let mut corners: Vec<Point> = boxes
        .iter()
        .map(|own| match line {
            Line::Left => [all.left(), own.top()],
            Line::Top => [own.left(), all.top()],
            Line::Centers => [mean - own.width() / 2.0, own.top()],
            Line::Distances => own.min.into(),
        })
        .collect();
    if line == Line::Distances && boxes.len() > 2 {
        let axis = usize::from(all.height() > all.width());
        let extent = |size: egui::Vec2| if axis == 0 { size.x } else { size.y };
        let mut order: Vec<usize> = (0..boxes.len()).collect();
        order.sort_by(|a, b| boxes[*a].center()[axis].total_cmp(&boxes[*b].center()[axis]));
        let taken: f32 = boxes.iter().map(|own| extent(own.size())).sum();
        let gap = (extent(all.size()) - taken) / (boxes.len() - 1) as f32;
        let mut next = all.min[axis];
        for index in order {
            corners[index][axis] = next;
            next += extent(boxes[index].size()) + gap;
        }
    }
    corners
}

impl Canvas {
    /// Opens a context menu at the pointer.
    pub(super) fn open_menu(&mut self, ui: &Ui, about: MenuTarget) {
        let at = ui.input(|input| input.pointer.latest_pos()).unwrap_or(self.view.rect.center());
        self.menus += 1;
        self.menu = Some(Menu { at, about, serial: self.menus });
    }

    /// Draws the open menu.
    pub(super) fn menu_ui(&mut self, plan: &Plan, ui: &Ui, state: &State, actions: &mut Vec<Action>) {
        let Some(menu) = self.menu.take() else { return };
        let mut open = true;
        let popup = Popup::new(ui.id().with(("menu", menu.serial)), ui.ctx().clone(), menu.at, ui.layer_id())
            .kind(PopupKind::Menu)
            .layout(Layout::top_down_justified(Align::Min))
            .style(egui::containers::menu::menu_style)
            .width(170.0)
            .open_bool(&mut open);
        popup.show(|ui| {
            ui.style_mut().wrap_mode = Some(TextWrapMode::Extend);
            match &menu.about {
                MenuTarget::Nodes => self.nodes_menu(plan, ui, state, actions, menu.at),
                MenuTarget::Backdrop(name) => self.backdrop_menu(plan, ui, name, actions),
                MenuTarget::Output(name) => self.output_menu(plan, ui, name, actions),
                MenuTarget::Follow(dropped) => self.follow_menu(ui, state, dropped, actions),
                MenuTarget::Empty => self.empty_menu(ui, actions, menu.at),
            }
        });
        if open {
            self.menu = Some(menu);
        }
    }

    fn empty_menu(&mut self, ui: &mut Ui, actions: &mut Vec<Action>, at: Pos2) {
        if ui.button("Add node …").clicked() {
            self.open_search(at, super::connect::NewNodeLink::Nothing);
        }
        for (name, action) in [
            ("Add note", Action::Note),
            ("Select all", Action::SelectAll),
            ("Arrange", Action::Arrange),
            ("Frame", Action::Frames),
        ] {
            if ui.button(name).clicked() {
                actions.push(action);
            }
        }
    }

    fn nodes_menu(&mut self, plan: &Plan, ui: &mut Ui, state: &State, actions: &mut Vec<Action>, at: Pos2) {
        let nodes: Vec<usize> = state.selection.iter().filter_map(|name| plan.sheet.find(name)).collect();
        if let [node] = nodes[..] {
            let name = &plan.sheet.nodes[node].name;
            if plan.sheet.nodes[node].is_use && ui.button("Enter group").clicked() {
                actions.push(Action::Enter(state.scope.iter().cloned().chain([name.clone()]).collect()));
            }
            if ui.button("View").clicked() {
                actions.push(Action::Look(state.whole_name(name), 0));
            }
            if ui.button("View in viewer 2").clicked() {
                let look = Action::Look(state.whole_name(name), 0);
                actions.extend([Action::Panel(Pane::Second), Action::Second(look.into())]);
            }
            ui.menu_button("Assign to viewer key", |ui| {
                for slot in 0..9 {
                    if ui.button(format!("{}", slot + 1)).clicked() {
                        actions.push(Action::Slot(slot));
                    }
                }
            });
            if ui.button("Make output").on_hover_text("Add an output that renders the selected node.").clicked() {
                actions.push(Action::MakeOutput);
            }
            if ui.button("Replace with …").clicked() {
                self.search = Some(Search::replacing(name, at));
            }
            if plan.sheet.nodes[node].is_use {
                let button = ui.button("Unpack").on_hover_text("Put the nodes of the group in the place of this use.");
                if button.clicked() {
                    actions.push(Action::Unpack);
                }
                if state.foreign().is_some() && ui.button("Make local").clicked() {
                    actions.push(Action::MakeLocal);
                }
            }
            if plan.sheet.nodes[node].side.is_none() && ui.button("Help").clicked() {
                actions.push(Action::Help(HelpPage::Node(plan.sheet.nodes[node].ty.clone())));
            }
        }
        if let Some(ty) = nodes.first().map(|node| plan.sheet.nodes[*node].ty.as_str())
            && nodes.iter().all(|node| plan.sheet.nodes[*node].ty == ty && plan.sheet.nodes[*node].side.is_none())
        {
            self.presets_menu(ui, ty, nodes.len() == 1, actions);
            ui.separator();
        }
        if nodes.len() > 1 {
            for line in Line::ALL {
                if ui.button(line.name()).clicked() {
                    actions.push(Action::Line(line));
                }
            }
            if ui.button("Arrange").clicked() {
                actions.push(Action::Arrange);
            }
            ui.separator();
        }
        if ui.button("Group").on_hover_text("Make a group of the selected nodes.").clicked() {
            actions.push(Action::Group);
        }
        if ui.button("Backdrop").clicked() {
            actions.push(Action::Backdrop);
        }
        let off = nodes.iter().any(|node| !plan.sheet.nodes[*node].disabled);
        if ui.button(if off { "Disable" } else { "Enable" }).clicked() {
            actions.push(Action::Disable);
        }
        if ui.button("Extract").on_hover_text("Connect wires past the nodes and leave the nodes unconnected.").clicked()
        {
            actions.push(Action::Extract);
        }
        ui.separator();
        for (name, action) in [("Copy", Action::Copy), ("Duplicate", Action::Duplicate), ("Delete", Action::Delete)] {
            if ui.button(name).clicked() {
                actions.push(action);
            }
        }
    }

    fn backdrop_menu(&mut self, plan: &Plan, ui: &mut Ui, name: &str, actions: &mut Vec<Action>) {
        let Some(body) = plan.sheet.backdrops.get(name) else { return };
        ui.horizontal(|ui| {
            for (tint, [r, g, b]) in TINTS.into_iter().enumerate() {
                let (place, response) = ui.allocate_exact_size(vec2(16.0, 16.0), Sense::click());
                response.widget_info(|| {
                    WidgetInfo::selected(WidgetType::Button, true, tint == body.tint, format!("Color {}", tint + 1))
                });
                ui.painter().rect_filled(place, 3.0, Color32::from_rgb(r, g, b));
                if response.clicked() {
                    let body = Backdrop { tint, ..body.clone() };
                    actions.push(Action::Edit(decor::reframed("Color a backdrop", &plan.sheet, name, &body)));
                    actions.push(Action::Seal);
                    ui.close();
                }
            }
        });
        if ui.button("Edit text …").clicked() {
            self.write(super::backdrop::Subject::Backdrop(name.into()), &body.text, false);
        }
        if ui.button("Select nodes").clicked() {
            let area = super::backdrop::area(body);
            let inside = plan.boxes.iter().enumerate().filter(|(_, own)| area.contains_rect(**own));
            actions.push(Action::Select(inside.map(|(node, _)| plan.sheet.nodes[node].name.clone()).collect()));
        }
        if ui.button("Delete backdrop").clicked() {
            actions.extend([Action::Edit(decor::unframed(name)), Action::Seal]);
        }
    }
}
