//! The toolbar above the picture: subject and display settings.

use super::Viewer;
use super::compare::Mode;
use crate::actions::Action;
use crate::document::Sheet;
use crate::evaluate::{Channel, Display, Result, shown};
use crate::field::Number;
use crate::state::State;
use crate::transform::Transform;
use egui::containers::menu::{MenuButton, MenuConfig};
use egui::{Button, ComboBox, PopupCloseBehavior, Ui, WidgetInfo, WidgetType};
use trochoid::Kind;

/// Returns the kind of the viewed result.
fn kind(state: &State) -> Option<Kind> {
    state.evaluated.result.as_ref().map(|result| result.picture.kind)
}

/// Draws the toolbar.
pub(super) fn toolbar_ui(viewer: &mut Viewer, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        subject_ui(ui, state, actions);
        if viewer.is_second {
            ui.toggle_value(&mut viewer.is_locked, "Lock").on_hover_text("Pan and zoom both viewers together");
        }
        ui.separator();
        let display = &state.look.display;
        let mut next = display.clone();
        channels_ui(ui, kind(state), &mut next);
        let exposure = shown_as(next.exposure).fixed(1).speed(0.02).range(-16.0, 16.0).suffix(" EV");
        number_ui(ui, exposure, &mut next.exposure, 0.0, "Exposure in stops. Double-click to reset to 0.");
        let gamma = shown_as(next.gamma).fixed(2).speed(0.005).range(0.1, 8.0).prefix("γ ");
        number_ui(ui, gamma, &mut next.gamma, 1.0, "Gamma. Double-click to reset to 1.");
        // Settings for anything shown as gray.
        if !matches!(kind(state), Some(Kind::Color) | None) || next.channel != Channel::All {
            field_ui(ui, state, &mut next);
        }
        if next != *display {
            actions.push(Action::Display(next));
        }
        groups_ui(viewer, ui, state, actions);
    });
}

/// Groups that move into a menu, last first, if the toolbar is too narrow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Group {
    Transform,
    Part,
    Compare,
    Space,
}

impl Group {
    const ALL: [Self; 4] = [Self::Transform, Self::Part, Self::Compare, Self::Space];

    /// Returns whether there is anything in the group.
    fn is_there(self, viewer: &Viewer, state: &State) -> bool {
        let is_color = matches!(kind(state), Some(Kind::Color) | None);
        let is_shown = is_color && (viewer.is_second || state.look.display.transform != Transform::Srgb);
        self != Self::Transform || is_shown
    }

    /// Returns the names of what is on in the group.
    fn is_on(self, viewer: &Viewer, state: &State) -> Vec<String> {
        let (look, transform) = (&state.look, &state.look.display.transform);
        let on = |is_on: bool, name: &str| is_on.then(|| name.to_string());
        let all = match self {
            Self::Transform => vec![on(*transform != Transform::Srgb, &transform.name())],
            Self::Part => vec![
                on(look.proxy != 1, &format!("1:{}", look.proxy)),
                on(viewer.frames_region || look.region.is_some(), "Region"),
            ],
            Self::Compare => vec![on(viewer.compare.held.is_some(), "Hold A")],
            Self::Space => vec![
                on(viewer.scene.steers(), "Orbit"),
                on(viewer.space.shown, "Hull"),
                on(viewer.near.shown, "Near"),
                on(viewer.scopes.shown, "Scopes"),
            ],
        };
        all.into_iter().flatten().collect()
    }

    /// Returns an index for the group's set of widgets, which determines its width.
    fn stage(self, viewer: &Viewer) -> u8 {
        match (self, &viewer.compare.held) {
            (Self::Transform | Self::Part, _) | (Self::Compare, None) => 0,
            (Self::Compare, Some(held)) => {
                if held.mode == Mode::Difference {
                    2
                } else {
                    1
                }
            }
            (Self::Space, _) => u8::from(viewer.near.shown),
        }
    }

    fn ui(self, viewer: &mut Viewer, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
        match self {
            Self::Transform => super::transform::combo_ui(&mut viewer.opening, ui, state, actions),
            Self::Part => {
                proxy_ui(ui, state, actions);
                region_ui(viewer, ui, state, actions);
            }
            Self::Compare => compare_ui(viewer, ui, state),
            Self::Space => space_ui(viewer, ui),
        }
    }
}

/// Width of the menu button and the separator before it.
const MORE: f32 = 66.0;
/// Estimated width of a group that has not been drawn yet.
const GROUP: f32 = 110.0;

/// Draws as many groups as there is room for, and the rest in a menu.
fn groups_ui(viewer: &mut Viewer, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let groups: Vec<Group> = Group::ALL.into_iter().filter(|group| group.is_there(viewer, state)).collect();
    let width = |group: &Group| viewer.widths.get(&(*group, group.stage(viewer))).copied().unwrap_or(GROUP);
    let widths: Vec<f32> = groups.iter().map(width).collect();
    let room = ui.available_size_before_wrap().x;
    let fits = |count: usize| {
        let more = if count < groups.len() { MORE } else { 0.0 };
        widths[..count].iter().sum::<f32>() + more <= room
    };
    let count = (0..=groups.len()).rev().find(|count| fits(*count)).unwrap_or(0);
    for group in &groups[..count] {
        let (stage, start) = (group.stage(viewer), ui.cursor().left());
        // Not wrapped within, because the width of a group in two lines would be wrong.
        ui.horizontal(|ui| {
            ui.separator();
            group.ui(viewer, ui, state, actions);
        });
        viewer.widths.insert((*group, stage), ui.cursor().left() - start);
    }
    if count == groups.len() {
        return;
    }
    ui.separator();
    // What is on in the menu is marked and named, so that it is not forgotten.
    let on: Vec<String> = groups[count..].iter().flat_map(|group| group.is_on(viewer, state)).collect();
    let (mark, told) = match on.is_empty() {
        true => ("", "More tools".into()),
        false => (" •", format!("More tools. On: {}", on.join(", "))),
    };
    let stays = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    let more = Button::new(format!("More{mark}")).selected(!on.is_empty());
    let (button, _) = MenuButton::from_button(more).config(stays).ui(ui, |ui| {
        for group in &groups[count..] {
            ui.horizontal(|ui| group.ui(viewer, ui, state, actions));
        }
    });
    button.on_hover_text(told);
}

fn region_ui(viewer: &mut Viewer, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let mut region = viewer.frames_region || state.look.region.is_some();
    let toggle = ui.toggle_value(&mut region, "Region");
    let help = "Evaluate only a region: drag a rectangle in the picture (or Shift+drag). Shift+W clears it.";
    if toggle.on_hover_text(help).clicked() {
        viewer.frames_region = region;
        if state.look.region.is_some() {
            actions.push(Action::Region(None));
        }
    }
}

fn space_ui(viewer: &mut Viewer, ui: &mut Ui) {
    let mut steers = viewer.scene.steers();
    let camera = ui
        .toggle_value(&mut steers, "Orbit")
        .on_hover_text("Orbit, pan and dolly the camera by dragging in the picture (C)");
    if camera.clicked() {
        viewer.orbit(steers);
    }
    let mut shown = viewer.space.shown;
    let hull = ui.toggle_value(&mut shown, "Hull");
    if hull.on_hover_text("Show the picture's colors inside the convex hull of the controls (H)").clicked() {
        viewer.show_space(shown);
    }
    let mut shown = viewer.near.shown;
    let near = ui.toggle_value(&mut shown, "Near").on_hover_text("Mark pixels near the hull's faces (N)");
    if near.clicked() {
        viewer.near.toggle();
    }
    ui.toggle_value(&mut viewer.scopes.shown, "Scopes").on_hover_text("Show histogram, waveform and vectorscope (S)");
    if viewer.near.shown {
        let distance = &mut viewer.near.distance;
        let number = shown_as(*distance).speed(0.0005).range(0.0005, 1.0);
        number_ui(
            ui,
            number,
            distance,
            0.02,
            "Maximum distance to a face, in the working space. Double-click to reset to 0.02.",
        );
    }
}

/// Creates a number field from an `f32`, converted by its decimal text: 0.1 becomes 0.1, not 0.10000000149.
fn shown_as(value: f32) -> Number<'static> {
    Number::new(value.to_string().parse().unwrap_or(f64::from(value)))
}

/// Draws a number field; a double-click resets the value to `usual`.
fn number_ui(ui: &mut Ui, number: Number<'_>, value: &mut f32, usual: f32, help: &str) {
    let told = number.ui(ui);
    let response = told.response.clone().on_hover_text(help);
    if response.double_clicked() {
        // The first of the two clicks has started text editing.
        response.surrender_focus();
        *value = usual;
    } else if let Some(given) = told.value() {
        *value = given as f32;
    }
}

/// Draws the menu of results to view: outputs of the node, and of the document.
fn subject_ui(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let root = state.session.sheet();
    let looked = state.looked();
    let sheet = looked.map_or(root, |(sheet, ..)| sheet);
    let whole = |sheet: &Sheet, node: usize| format!("{}{}", sheet.prefix(), sheet.nodes[node].name);
    let named = |node: usize, output: usize| format!("{}{}", sheet.prefix(), sheet.reference(node, output));
    let shown = looked.map(|(_, node, output)| (node, output));
    let text = shown.map_or_else(|| "nothing".into(), |(node, output)| named(node, output));
    let mut chosen = None;
    let combo = ComboBox::from_id_salt("shown").selected_text(text).width(96.0).truncate();
    let response = combo.show_ui(ui, |ui| {
        if let Some((node, _)) = shown {
            let makes = &sheet.nodes[node].makes;
            for output in 0..makes.len() {
                if ui.selectable_label(shown == Some((node, output)), named(node, output)).clicked() {
                    chosen = Some((whole(sheet, node), output));
                }
            }
            ui.separator();
        }
        ui.weak("Outputs");
        for output in &root.outputs {
            let Some(source) = root.source(&output.source) else { continue };
            let is_shown = sheet.within.is_none() && shown == Some(source);
            if ui.selectable_label(is_shown, &output.name).clicked() {
                chosen = Some((whole(root, source.0), source.1));
            }
        }
    });
    response.response.on_hover_text("Viewed result. Double-click a node in the graph or press 1 to 9 to change it.");
    if let Some((node, output)) = chosen {
        actions.push(Action::Look(node, output));
    }
}

/// Returns the names of a kind's channels, if it has several.
fn components(kind: Option<Kind>) -> Vec<String> {
    match kind {
        Some(Kind::Color) | None => ["R", "G", "B"].map(String::from).into(),
        Some(Kind::Field(n @ 2..=4)) => ["x", "y", "z", "w"].iter().take(n).map(|name| (*name).into()).collect(),
        Some(Kind::Field(n) | Kind::Weights(n)) if n > 2 => (1..=n).map(|index| index.to_string()).collect(),
        _ => Vec::new(),
    }
}

fn channels_ui(ui: &mut Ui, kind: Option<Kind>, display: &mut Display) {
    let names = components(kind);
    let is_color = matches!(kind, Some(Kind::Color) | None);
    let shown = display.channel;
    let mut choice = |ui: &mut Ui, name: &str, channel: Channel, help: &str| {
        if ui.selectable_label(shown == channel, name).on_hover_text(help).clicked() {
            display.channel = channel;
        }
    };
    if is_color {
        choice(ui, "RGB", Channel::All, "All channels");
        for (index, name) in names.iter().enumerate() {
            choice(ui, name, Channel::One(index), &format!("Only this channel ({name})"));
        }
        choice(ui, "Y", Channel::Luminance, "Luminance (Y)");
    } else if names.len() <= 4 {
        for (index, name) in names.iter().enumerate() {
            let is_first = index == 0 && shown == Channel::All;
            let channel = if is_first { Channel::All } else { Channel::One(index) };
            choice(ui, name, channel, "Only this component");
        }
    } else {
        let index = if let Channel::One(index) = shown { index } else { 0 };
        let text = names.get(index).cloned().unwrap_or_default();
        ComboBox::from_id_salt("component").selected_text(text).width(40.0).show_ui(ui, |ui| {
            for (index, name) in names.iter().enumerate() {
                choice(ui, name, Channel::One(index), "Only this component");
            }
        });
    }
}

/// Draws the settings that map numbers to gray: value range, and false colors.
fn field_ui(ui: &mut Ui, state: &State, display: &mut Display) {
    ui.toggle_value(&mut display.false_color, "Colors").on_hover_text("Show false colors instead of gray");
    if matches!(kind(state), Some(Kind::Color) | None) {
        // A single color channel is light, like the color: it has an exposure, but no range.
        return;
    }
    let mut fixed = display.range.is_some();
    let result = state.evaluated.result.as_deref();
    let toggle = ui
        .toggle_value(&mut fixed, "Range")
        .on_hover_text("Set the values shown as black and white; otherwise the range of all values");
    if toggle.clicked() {
        display.range =
            fixed.then(|| result.map_or([0.0, 1.0], |result: &Result| shown::range(&result.picture, display)));
    }
    if let Some([low, high]) = &mut display.range {
        let speed = f64::from((*high - *low).abs().max(1e-3)) * 0.01;
        for (end, help) in [(low, "Value shown as black"), (high, "Value shown as white")] {
            let told = shown_as(*end).decimals(3).speed(speed).ui(ui);
            told.response.clone().on_hover_text(help);
            *end = told.value().map_or(*end, |value| value as f32);
        }
    }
}

fn proxy_ui(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let proxy = state.look.proxy;
    let text = |proxy: u32| if proxy == 1 { "1:1".to_string() } else { format!("1:{proxy}") };
    let combo = ComboBox::from_id_salt("proxy").selected_text(text(proxy)).width(44.0);
    let response = combo.show_ui(ui, |ui| {
        for choice in [1, 2, 4] {
            if ui.selectable_label(choice == proxy, text(choice)).clicked() && choice != proxy {
                actions.push(Action::Proxy(choice));
            }
        }
    });
    response.response.on_hover_text("Resolution of the evaluated picture relative to the document's");
}

fn compare_ui(viewer: &mut Viewer, ui: &mut Ui, state: &State) {
    let hold = ui.add_enabled(state.evaluated.result.is_some(), Button::new("Hold A"));
    let help = match &viewer.compare.held {
        Some(held) => format!("Hold the current picture instead of {}", held.name),
        None => "Hold the current picture, to compare others with it".into(),
    };
    if hold.on_hover_text(help).clicked() {
        viewer.hold(state);
    }
    let compare = &mut viewer.compare;
    let Some(held) = &mut compare.held else { return };
    for (mode, text, help) in [
        (Mode::Wipe, "Wipe", "A to the left of the line, the current picture to the right"),
        (Mode::Difference, "Diff", "Difference between the current picture and A"),
    ] {
        ui.selectable_value(&mut held.mode, mode, text).on_hover_text(help);
    }
    if held.mode == Mode::Difference {
        let gain = shown_as(compare.gain).fixed(0).speed(0.1).range(1.0, 256.0).prefix("× ");
        number_ui(ui, gain, &mut compare.gain, 4.0, "Gain of the difference. Double-click to reset to 4.");
    }
    let drop = ui.button("×");
    drop.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, "Release A"));
    if drop.on_hover_text("Release A").clicked() {
        compare.held = None;
    }
}
