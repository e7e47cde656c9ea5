//! Search for a node type by name, to add or replace a node.

use super::Canvas;
use super::connect::{self, NewNodeLink};
use super::place;
use super::plan::Plan;
use crate::actions::{Action, HelpPage};
use crate::choice::{matches, moved};
use crate::document::edit;
use crate::presets::Presets;
use crate::shipped;
use crate::state::State;
use crate::theme;
use egui::{Area, Button, Color32, Frame, Id, Key, Order, Pos2, Rect, RichText, ScrollArea, TextEdit, Ui};
use egui::{WidgetInfo, WidgetType, vec2};
use trochoid::{Declaration, registry};

/// The open search.
pub(super) struct Search {
    /// Place on the screen where the new node goes.
    at: Pos2,
    text: String,
    chosen: usize,
    purpose: Purpose,
    /// Whether it has not been drawn yet: the click that opened it must not close it.
    fresh: bool,
}

enum Purpose {
    /// Add a node, connected this way.
    Add(NewNodeLink),
    /// Replace the type of the node with this name.
    Replace(String),
}

/// What can be chosen: a type, or a preset of one.
#[derive(Clone)]
struct Found {
    known: &'static Declaration,
    preset: Option<String>,
}

impl Found {
    fn name(&self) -> String {
        match &self.preset {
            Some(preset) => format!("{}: {preset}", self.known.name),
            None => self.known.name.into(),
        }
    }
}

impl Search {
    fn new(at: Pos2, purpose: Purpose) -> Self {
        Self { at, text: String::new(), chosen: 0, purpose, fresh: true }
    }

    /// Creates a search for another type for a node.
    pub(super) fn replacing(name: &str, at: Pos2) -> Self {
        Self::new(at, Purpose::Replace(name.into()))
    }

    /// Returns the matching types and presets, best first.
    fn found(&self, plan: &Plan, presets: &Presets) -> Vec<Found> {
        let library = &plan.sheet.library;
        // Groups are used like types.
        // A group cannot contain itself.
        let around = plan.sheet.within.as_ref().map_or(&[][..], |within| &within.uses);
        let groups = library.names().filter(|name| !around.iter().any(|(_, group)| group == *name));
        let groups = groups.filter_map(|name| library.face(name));
        let all = registry().iter().map(|ty| ty.declaration()).chain(groups);
        let all: Vec<&'static Declaration> = match &self.purpose {
            Purpose::Add(wanted) => {
                let all = all.chain(shipped::offered(&plan.sheet));
                all.filter(|known| connect::suits(&plan.sheet, known, wanted)).collect()
            }
            Purpose::Replace(name) => {
                let own = plan.sheet.node(name).map(|node| node.ty.as_str());
                all.filter(|known| Some(known.name) != own).collect()
            }
        };
        // Those that take the output themselves come first.
        let mut all = all;
        all.sort_by_key(|known| self.conversion(plan, known).is_some());
        let all: Vec<Found> = all.into_iter().flat_map(|known| self.with_presets(known, presets)).collect();
        let names: Vec<String> = all.iter().map(Found::name).collect();
        let names = names.iter().enumerate().map(|(index, name)| (index, name.as_str()));
        matches(&self.text, names).into_iter().map(|index| all[index].clone()).collect()
    }

    /// Returns a type, and its presets if a node is added.
    fn with_presets(&self, known: &'static Declaration, presets: &Presets) -> Vec<Found> {
        let own = presets.get(known.name).filter(|_| matches!(self.purpose, Purpose::Add(_)));
        let own = own.into_iter().flatten().map(|name| Found { known, preset: Some(name.clone()) });
        std::iter::once(Found { known, preset: None }).chain(own).collect()
    }

    /// Returns the conversion that a node of this type would get before it.
    fn conversion(&self, plan: &Plan, declaration: &Declaration) -> Option<&'static Declaration> {
        match &self.purpose {
            Purpose::Add(wanted) => connect::conversion(&plan.sheet, declaration, wanted),
            Purpose::Replace(_) => None,
        }
    }

    fn title(&self) -> String {
        match &self.purpose {
            Purpose::Add(NewNodeLink::Takes(name, _)) => format!("Add node after {name} …"),
            Purpose::Add(NewNodeLink::Feeds(name, _)) => format!("Add node before {name} …"),
            Purpose::Add(_) => "Add node …".into(),
            Purpose::Replace(name) => format!("Replace {name} with …"),
        }
    }
}

impl Canvas {
    /// Opens the search for a node to add at a place on the screen.
    pub(super) fn open_search(&mut self, at: Pos2, wanted: NewNodeLink) {
        self.search = Some(Search::new(at, Purpose::Add(wanted)));
    }

    /// Draws the search, and adds or replaces the node on a choice.
    pub(super) fn search_ui(&mut self, plan: &Plan, ui: &Ui, state: &State, actions: &mut Vec<Action>) {
        let Some(mut search) = self.search.take() else { return };
        let mut taken = None;
        let area = Area::new(ui.id().with("search")).order(Order::Foreground).fixed_pos(search.at);
        let shown = area.constrain_to(ui.ctx().content_rect()).show(ui.ctx(), |ui| {
            Frame::popup(ui.style()).show(ui, |ui| {
                ui.set_width(240.0);
                taken = list_ui(&mut search, plan, &self.presets, ui, actions);
            });
        });
        let (escape, pressed) = ui.input(|input| (input.key_pressed(Key::Escape), input.pointer.any_pressed()));
        match taken {
            Some(Found { known, preset }) => {
                self.take(&search, plan, state, known, actions);
                actions.extend(preset.map(Action::Preset));
            }
            None if std::mem::take(&mut search.fresh) => {
                self.search = Some(search);
                ui.ctx().request_repaint();
            }
            None if escape || pressed && !shown.response.contains_pointer() => {}
            None => self.search = Some(search),
        }
    }

    /// Adds the node that was asked for elsewhere.
    pub(super) fn add_wanted(&mut self, plan: &Plan, state: &State, actions: &mut Vec<Action>) {
        let Some(name) = self.wants_type.take() else { return };
        let known = registry().get(&name).map(|ty| ty.declaration()).or_else(|| plan.sheet.library.face(&name));
        if let Some(declaration) = known {
            let search = Search::new(self.view.rect.center(), Purpose::Add(NewNodeLink::Nothing));
            self.take(&search, plan, state, declaration, actions);
        }
    }

    fn take(
        &self,
        search: &Search,
        plan: &Plan,
        state: &State,
        declaration: &'static Declaration,
        actions: &mut Vec<Action>,
    ) {
        match &search.purpose {
            Purpose::Replace(name) => {
                actions.push(Action::Edit(plan.freezing(edit::retyped(&plan.sheet, name, declaration))));
                actions.push(Action::Seal);
            }
            Purpose::Add(wanted) => {
                let below = NewNodeLink::Below(state.chosen().unwrap_or_default().into(), 0);
                let wanted = if *wanted == NewNodeLink::Nothing && state.chosen().is_some() { &below } else { wanted };
                // The pointer ends up in the middle of the new node's head.
                let at = self.view.canvas(search.at) - vec2(place::WIDTH / 2.0, place::HEAD / 2.0);
                let below = match wanted {
                    NewNodeLink::Below(name, _) => plan.sheet.find(name).map(|node| plan.boxes[node]),
                    _ => None,
                };
                let at = below.map_or(at, |own| own.center_bottom() + vec2(-place::WIDTH / 2.0, 40.0));
                let mut size = place::most_size(declaration);
                if connect::conversion(&plan.sheet, declaration, wanted).is_some() {
                    // It stands above the new node.
                    size.y += place::HEAD + place::PICTURE + 40.0;
                }
                let at = place::nearest(Rect::from_min_size(at, size), &plan.boxes).min;
                let (edit, name) = connect::added(state, declaration, at.into(), wanted);
                actions.push(Action::Edit(plan.freezing(edit)));
                actions.extend([Action::Seal, Action::Select([name].into())]);
            }
        }
    }
}

fn list_ui(
    search: &mut Search,
    plan: &Plan,
    presets: &Presets,
    ui: &mut Ui,
    actions: &mut Vec<Action>,
) -> Option<Found> {
    let id = Id::new("node search");
    // Read the arrow keys before the text field sees them.
    let found = search.found(plan, presets);
    search.chosen = moved(ui, search.chosen, found.len());
    let title = search.title();
    let field = TextEdit::singleline(&mut search.text).id(id).hint_text(title.as_str()).desired_width(f32::INFINITY);
    let field = ui.add(field);
    field.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, "Node type"));
    let enter = ui.input(|input| input.key_pressed(Key::Enter));
    field.request_focus();
    let found = if field.changed() {
        search.chosen = 0;
        search.found(plan, presets)
    } else {
        found
    };
    let mut taken = None;
    ScrollArea::vertical().max_height(260.0).auto_shrink([false, true]).show(ui, |ui| {
        for (index, own) in found.iter().enumerate() {
            let (known, name) = (own.known, own.name());
            let kind = known.outputs.first().map(|output| output.kind);
            let mut button = Button::selectable(index == search.chosen, format!("    {name}"));
            if let Some(ty) = search.conversion(plan, known) {
                button = button.shortcut_text(format!("with {}", ty.name));
            } else if shipped::is_offered(&plan.sheet, known.name) {
                button = button.shortcut_text("group of the library");
            }
            let row = ui.add(button.min_size(vec2(ui.available_width(), 0.0)));
            ui.painter().circle_filled(row.rect.left_center() + vec2(9.0, 0.0), 3.5, theme::kind(kind));
            row.widget_info(|| WidgetInfo::selected(WidgetType::Button, true, index == search.chosen, &name));
            if index == search.chosen && (field.changed() || moving(ui)) {
                row.scroll_to_me(None);
            }
            if row.clicked() {
                taken = Some(own.clone());
            }
            row.on_hover_text(known.summary);
        }
    });
    match found.get(search.chosen) {
        Some(own) => {
            ui.separator();
            ui.label(RichText::new(own.known.summary).small());
            let help = ui.small_button("Help").on_hover_text("Explain this type in the Help panel (F1)");
            if help.clicked() || ui.input(|input| input.key_pressed(Key::F1)) {
                actions.push(Action::Help(HelpPage::Node(own.known.name.into())));
            }
            if enter {
                taken = Some(own.clone());
            }
        }
        None => drop(ui.colored_label(Color32::GRAY, "No node type matches.")),
    }
    taken
}

fn moving(ui: &Ui) -> bool {
    ui.input(|input| input.key_pressed(Key::ArrowDown) || input.key_pressed(Key::ArrowUp))
}
