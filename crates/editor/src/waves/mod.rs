//! The waves panel: the knobs of a sea, a profile of its surface, the lengths, heights and directions of its waves, and
//! whether crests fold or waves grow.

mod histogram;
mod knobs;
mod live;
mod profile;
mod sea;
mod spectrum;
mod stability;

use crate::actions::Action;
use crate::state::State;
use egui::{ComboBox, RichText, ScrollArea, Spinner, Ui};
use histogram::Counted;
use live::Live;
use profile::Section;
use sea::{Held, LastSea, Sea};
use stability::Analysis;
use std::sync::Arc;
use trochoid::{CheckedGraph, FrameTimes, Profile, ProfileLine, Reached, Spectrum};

/// State of the panel that no other panel shares.
#[derive(Default)]
pub(crate) struct Waves {
    last: LastSea,
    section: Section,
    counted: Counted,
    spectrum: Live<Held, Option<Spectrum>>,
    profile: Live<(Held, f64, ProfileLine), Option<Profile>>,
    reached: Live<(Held, FrameTimes), Option<Reached>>,
    stability: Analysis,
}

/// Draws the panel for the selected sea, or the one that what is selected or viewed depends on, or the first.
pub(crate) fn waves_ui(waves: &mut Waves, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let Some(sea) = sea::chosen(&mut waves.last, state) else {
        ui.weak("The document has no sea. Add a GerstnerSea or a ToonSea (Tab in the graph).");
        return;
    };
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        title_ui(ui, state, &sea, actions);
        let width = ui.available_width();
        knobs::knobs_ui(ui, state, &sea, actions);
        // Sliders wider than the panel must not widen the content below.
        ui.set_max_width(width);
        match (&state.session.meaning().graph, &sea.settled) {
            (Some(graph), Some(settled)) => plots_ui(waves, ui, state, &sea, settled, graph, actions),
            _ => drop(ui.weak("The document has errors: correct them to see its waves.")),
        }
    });
}

/// Names the sea, and offers the others.
fn title_ui(ui: &mut Ui, state: &State, sea: &Sea<'_>, actions: &mut Vec<Action>) {
    let all = sea::names(state);
    ui.horizontal_wrapped(|ui| {
        if ui.link(RichText::new(&sea.name).heading()).on_hover_text("Select this node").clicked() {
            actions.push(Action::Visit(sea.name.clone()));
        }
        ui.weak(sea.declaration.name);
        if all.len() > 1 {
            ComboBox::from_id_salt("seas").selected_text("Other seas").show_ui(ui, |ui| {
                for name in all {
                    if ui.selectable_label(name == sea.name, &name).clicked() {
                        actions.push(Action::Visit(name));
                    }
                }
            });
        }
    });
    if sea.node.is_none() {
        let inside = sea.name.rsplit_once('/').map_or("", |(path, _)| path);
        ui.horizontal_wrapped(|ui| {
            let help = "Show the inside of the group, where the knobs can be changed";
            if ui.button("Enter").on_hover_text(help).clicked() {
                actions.push(Action::Visit(sea.name.clone()));
            }
            let place = if inside.is_empty() { "the document".into() } else { format!("{inside}, a group") };
            ui.weak(format!("This sea is inside of {place}."));
        });
    }
}

fn plots_ui(
    waves: &mut Waves,
    ui: &mut Ui,
    state: &State,
    sea: &Sea<'_>,
    settled: &Held,
    graph: &Arc<CheckedGraph>,
    actions: &mut Vec<Action>,
) {
    let context = ui.ctx().clone();
    let own = || settled.clone();
    let (made, times) = (own(), graph.times());
    let (spectrum, _) =
        waves.spectrum.get(own(), &context, move || made.node().dynamics().and_then(|sea| sea.spectrum()));
    let time = graph.frame_context(state.frame, u64::MAX).time;
    let direction = knobs::direction(settled, sea.declaration);
    let line = waves.section.line(direction.unwrap_or_default());
    let title = if direction.is_some() { "Profile along the direction of travel" } else { "Profile along X" };
    let (made, is_late) = (own(), waves.profile.is_late());
    let (profile, _) = waves
        .profile
        .get((own(), time, line), &context, move || made.node().dynamics().and_then(|sea| sea.profile(&line, time)));
    ui.separator();
    match profile {
        Some(Some(profile)) => profile::profile_ui(&mut waves.section, ui, profile, title, is_late),
        Some(None) => drop(ui.weak("It takes seconds to run this sea up to this frame: no profile is drawn.")),
        // What is below moves little when the profile comes.
        None => drop(ui.add_sized([ui.available_width(), profile::HEIGHT], Spinner::new())),
    }
    match spectrum {
        Some(Some(spectrum)) => {
            spectrum::folding_ui(ui, spectrum);
            ui.separator();
            histogram::histogram_ui(&mut waves.counted, ui, spectrum);
            ui.separator();
            spectrum::spectrum_ui(ui, spectrum, state.sheet(), sea);
        }
        Some(None) => {
            let made = own();
            let (reached, _) = waves.reached.get((own(), times), &context, move || {
                made.node().dynamics().and_then(|sea| sea.reached(times, &|| false))
            });
            if let Some(Some(reached)) = reached {
                stability::reached_ui(ui, reached, times);
            }
            ui.separator();
            stability::stability_ui(&mut waves.stability, ui, state, sea, graph, actions);
        }
        None => {}
    }
}
