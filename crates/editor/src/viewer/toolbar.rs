//! The line above the picture: what is shown, and how.

use super::Viewer;
use super::compare::Mode;
use crate::actions::Action;
use crate::evaluate::{Channel, Display, Result, shown};
use crate::field::Number;
use crate::state::State;
use egui::containers::menu::{MenuButton, MenuConfig};
use egui::{Button, ComboBox, PopupCloseBehavior, Ui, WidgetInfo, WidgetType};
use trochoid::Kind;

/// The kind of what is shown.
fn kind(state: &State) -> Option<Kind> {
    state.evaluated.result.as_ref().map(|result| result.picture.kind)
}

/// Draws the line.
pub(super) fn toolbar_ui(viewer: &mut Viewer, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        subject_ui(ui, state, actions);
        ui.separator();
        let display = &state.look.display;
        let mut next = *display;
        channels_ui(ui, kind(state), &mut next);
        let exposure = shown_as(next.exposure).fixed(1).speed(0.02).range(-16.0, 16.0).suffix(" EV");
        number_ui(ui, exposure, &mut next.exposure, 0.0, "Exposure in stops. Double-click for 0.");
        let gamma = shown_as(next.gamma).fixed(2).speed(0.005).range(0.1, 8.0).prefix("γ ");
        number_ui(ui, gamma, &mut next.gamma, 1.0, "Gamma. Double-click for 1.");
        // Whatever is shown as gray.
        if !matches!(kind(state), Some(Kind::Color) | None) || next.channel != Channel::All {
            field_ui(ui, state, &mut next);
        }
        if next != *display {
            actions.push(Action::Display(next));
        }
        groups_ui(viewer, ui, state, actions);
    });
}

/// What goes into a menu where the line is too short, the last first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Group {
    Part,
    Compare,
    Space,
}

impl Group {
    const ALL: [Self; 3] = [Self::Part, Self::Compare, Self::Space];

    /// How many widgets of it there are: what its width depends on.
    fn stage(self, viewer: &Viewer) -> u8 {
        match (self, &viewer.compare.held) {
            (Self::Part, _) | (Self::Compare, None) => 0,
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
            Self::Part => {
                proxy_ui(ui, state, actions);
                region_ui(viewer, ui, state, actions);
            }
            Self::Compare => compare_ui(viewer, ui, state),
            Self::Space => space_ui(viewer, ui),
        }
    }
}

/// Width of the menu's button and the line before it.
const MORE: f32 = 58.0;
/// About how wide a group is that has not been drawn yet.
const GROUP: f32 = 110.0;

/// As many groups as there is room for, the others in a menu.
fn groups_ui(viewer: &mut Viewer, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let widths = Group::ALL.map(|group| {
        let known = viewer.widths.get(&(group, group.stage(viewer)));
        known.copied().unwrap_or(GROUP)
    });
    let room = ui.available_size_before_wrap().x;
    let fits = |count: usize| {
        let more = if count < Group::ALL.len() { MORE } else { 0.0 };
        widths[..count].iter().sum::<f32>() + more <= room
    };
    let count = (0..=Group::ALL.len()).rev().find(|count| fits(*count)).unwrap_or(0);
    for group in &Group::ALL[..count] {
        let (stage, start) = (group.stage(viewer), ui.cursor().left());
        ui.separator();
        group.ui(viewer, ui, state, actions);
        viewer.widths.insert((*group, stage), ui.cursor().left() - start);
    }
    if count == Group::ALL.len() {
        return;
    }
    ui.separator();
    let stays = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    let (button, _) = MenuButton::new("More").config(stays).ui(ui, |ui| {
        for group in &Group::ALL[count..] {
            ui.horizontal(|ui| group.ui(viewer, ui, state, actions));
        }
    });
    button.on_hover_text("What the line has no room for.");
}

fn region_ui(viewer: &mut Viewer, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let mut region = viewer.frames_region || state.look.region.is_some();
    let toggle = ui.toggle_value(&mut region, "Region");
    let help = "Evaluates a part: drag a rectangle in the picture, also with Shift at any time. Shift+W for all of it.";
    if toggle.on_hover_text(help).clicked() {
        viewer.frames_region = region;
        if state.look.region.is_some() {
            actions.push(Action::Region(None));
        }
    }
}

fn space_ui(viewer: &mut Viewer, ui: &mut Ui) {
    ui.toggle_value(&mut viewer.space.shown, "Hull")
        .on_hover_text("The colors of the picture within the hull of its control colors (H).");
    let mut shown = viewer.near.shown;
    let near = ui.toggle_value(&mut shown, "Near").on_hover_text("Marks pixels near the hull's faces (N).");
    if near.clicked() {
        viewer.near.toggle();
    }
    if viewer.near.shown {
        let distance = &mut viewer.near.distance;
        let number = shown_as(*distance).speed(0.0005).range(0.0005, 1.0);
        number_ui(ui, number, distance, 0.02, "How near: a distance in the working space. Double-click for 0.02.");
    }
}

/// A number as it is written: 0.1 is no 0.10000000149.
fn shown_as(value: f32) -> Number<'static> {
    Number::new(value.to_string().parse().unwrap_or(f64::from(value)))
}

/// Lets a number be changed; a double click brings it back to `usual`.
fn number_ui(ui: &mut Ui, number: Number<'_>, value: &mut f32, usual: f32, help: &str) {
    let told = number.ui(ui);
    let response = told.response.clone().on_hover_text(help);
    if response.double_clicked() {
        // The first of the clicks has begun to ask for a number.
        response.surrender_focus();
        *value = usual;
    } else if let Some(given) = told.value() {
        *value = given as f32;
    }
}

/// What is looked at: outputs of the node, and of the document.
fn subject_ui(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let sheet = state.sheet();
    let named = |node: usize, output: usize| sheet.reference(node, output);
    let shown = state.look.node.as_ref().and_then(|(name, output)| Some((sheet.find(name)?, *output)));
    let text = shown.map_or_else(|| "nothing".into(), |(node, output)| named(node, output));
    let mut chosen = None;
    let combo = ComboBox::from_id_salt("shown").selected_text(text).width(96.0).truncate();
    let response = combo.show_ui(ui, |ui| {
        if let Some((node, _)) = shown {
            let makes = &sheet.nodes[node].makes;
            for output in 0..makes.len() {
                if ui.selectable_label(shown == Some((node, output)), named(node, output)).clicked() {
                    chosen = Some((node, output));
                }
            }
            ui.separator();
        }
        ui.weak("Outputs");
        for output in &sheet.outputs {
            let Some(source) = sheet.source(&output.source) else { continue };
            if ui.selectable_label(shown == Some(source), &output.name).clicked() {
                chosen = Some(source);
            }
        }
    });
    response.response.on_hover_text("What is shown: double-click a node in the graph, or press 1 to 9.");
    if let Some((node, output)) = chosen {
        actions.push(Action::Look(sheet.nodes[node].name.clone(), output));
    }
}

/// What the channels of a kind are called, where there are several.
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
        choice(ui, "RGB", Channel::All, "All channels.");
        for (index, name) in names.iter().enumerate() {
            choice(ui, name, Channel::One(index), &format!("This channel alone ({name})."));
        }
        choice(ui, "Y", Channel::Luminance, "Luminance (Y).");
    } else if names.len() <= 4 {
        for (index, name) in names.iter().enumerate() {
            let is_first = index == 0 && shown == Channel::All;
            let channel = if is_first { Channel::All } else { Channel::One(index) };
            choice(ui, name, channel, "This component alone.");
        }
    } else {
        let index = if let Channel::One(index) = shown { index } else { 0 };
        let text = names.get(index).cloned().unwrap_or_default();
        ComboBox::from_id_salt("component").selected_text(text).width(40.0).show_ui(ui, |ui| {
            for (index, name) in names.iter().enumerate() {
                choice(ui, name, Channel::One(index), "This component alone.");
            }
        });
    }
}

/// How numbers become gray: from where to where, and in which colors.
fn field_ui(ui: &mut Ui, state: &State, display: &mut Display) {
    ui.toggle_value(&mut display.false_color, "Colors").on_hover_text("False colors in place of gray.");
    if matches!(kind(state), Some(Kind::Color) | None) {
        // A channel of a color is light, as the color is: it has an exposure, and no range.
        return;
    }
    let mut fixed = display.range.is_some();
    let result = state.evaluated.result.as_deref();
    let toggle =
        ui.toggle_value(&mut fixed, "Range").on_hover_text("What is black and what is white; of all values otherwise.");
    if toggle.clicked() {
        display.range =
            fixed.then(|| result.map_or([0.0, 1.0], |result: &Result| shown::range(&result.picture, display)));
    }
    if let Some([low, high]) = &mut display.range {
        let speed = f64::from((*high - *low).abs().max(1e-3)) * 0.01;
        for (end, help) in [(low, "What is black."), (high, "What is white.")] {
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
    response.response.on_hover_text("By how much the picture that is evaluated is smaller than the document's.");
}

fn compare_ui(viewer: &mut Viewer, ui: &mut Ui, state: &State) {
    let hold = ui.add_enabled(state.evaluated.result.is_some(), Button::new("Hold A"));
    let help = match &viewer.compare.held {
        Some(held) => format!("Holds the present picture in place of {}.", held.name),
        None => "Holds the present picture to compare others with it.".into(),
    };
    if hold.on_hover_text(help).clicked() {
        viewer.hold(state);
    }
    let compare = &mut viewer.compare;
    let Some(held) = &mut compare.held else { return };
    for (mode, text, help) in [
        (Mode::Wipe, "Wipe", "A at the left of the line, the present picture at its right."),
        (Mode::Difference, "Diff", "By how much the present picture differs from A."),
    ] {
        ui.selectable_value(&mut held.mode, mode, text).on_hover_text(help);
    }
    if held.mode == Mode::Difference {
        let gain = shown_as(compare.gain).fixed(0).speed(0.1).range(1.0, 256.0).prefix("× ");
        number_ui(ui, gain, &mut compare.gain, 4.0, "By how much differences are multiplied. Double-click for 4.");
    }
    let drop = ui.button("×");
    drop.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, "Let go of A"));
    if drop.on_hover_text("Lets go of A.").clicked() {
        compare.held = None;
    }
}
