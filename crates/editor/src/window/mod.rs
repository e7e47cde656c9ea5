//! The window: menus at the top, panels in the middle, timeline and status bar at the bottom, and the open prompt over
//! all of them.

mod allowed;
mod find;
mod leave;
mod menu;
mod modal;
mod name;
mod palette;
mod questions;
mod recover;
mod welcome;

use crate::actions::{Action, Layout as LayoutChoice, Pane};
use crate::commands::MENUS;
use crate::document::VersionStatus;
use crate::editor::{Editor, Panels};
use crate::state::State;
use egui::{Align, Layout, MenuBar, Panel, RichText, Ui, WidgetText};
use egui_tiles::{SimplificationOptions, TileId, Tiles, UiResponse};

impl Editor {
    /// Draws the window and performs the requested actions.
    pub fn ui(&mut self, ui: &mut Ui) {
        let context = ui.ctx().clone();
        let mut actions = self.before(&context);
        let typing = context.text_edit_focused();
        window_ui(self, ui, &mut actions);
        self.after(actions, typing, &context);
    }
}

/// Draws the whole window.
fn window_ui(editor: &mut Editor, ui: &mut Ui, actions: &mut Vec<Action>) {
    Panel::top("menus").show(ui, |ui| menus_ui(editor, ui, actions));
    unreadable_ui(&editor.state, ui, actions);
    version_ui(&editor.state, ui, actions);
    Panel::bottom("status").show(ui, |ui| status_ui(&editor.state, ui, actions));
    Panel::bottom("timeline").show(ui, |ui| {
        crate::timeline::timeline_ui(&mut editor.panels.timeline, ui, &editor.state, actions);
    });
    let filled = egui::Frame::new().fill(ui.visuals().panel_fill);
    egui::CentralPanel::no_frame().frame(filled).show(ui, |ui| {
        let mut panes = Panes { state: &mut editor.state, panels: &mut editor.panels, actions };
        editor.tree.ui(&mut panes, ui);
    });
    let context = ui.ctx().clone();
    questions::prompts_ui(editor, &context, actions);
    editor.notices.show(&context);
    hovered_ui(&context);
    crate::follow::held_ui(&context);
}

/// Says what can be dropped while files are held over the window.
fn hovered_ui(context: &egui::Context) {
    if context.input(|input| input.raw.hovered_files.is_empty()) {
        return;
    }
    let area = egui::Area::new("hovered files".into()).order(egui::Order::Tooltip).interactable(false);
    area.anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO).show(context, |ui| {
        egui::Frame::popup(ui.style()).inner_margin(16).show(ui, |ui| {
            ui.label(RichText::new("Drop to open a document, or to add a picture, a model or a palette").heading());
        });
    });
}

/// Draws the contents of the panels.
struct Panes<'e> {
    state: &'e mut State,
    panels: &'e mut Panels,
    actions: &'e mut Vec<Action>,
}

impl egui_tiles::Behavior<Pane> for Panes<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _: TileId, pane: &mut Pane) -> UiResponse {
        let (panels, state, actions) = (&mut *self.panels, &mut *self.state, &mut *self.actions);
        let framed = egui::Frame::new().inner_margin(if *pane == Pane::Canvas { 0 } else { 6 });
        framed.show(ui, |ui| match pane {
            Pane::Viewer => crate::viewer::viewer_ui(&mut panels.viewer, ui, state, actions),
            Pane::Second => crate::viewer::second_ui(&mut panels.viewer, &mut panels.second, ui, state, actions),
            Pane::Canvas => crate::canvas::canvas_ui(&mut panels.canvas, ui, state, actions),
            Pane::Properties => crate::properties::properties_ui(&mut panels.properties, ui, state, actions),
            Pane::Palette => crate::palette::palette_ui(&mut panels.palette, ui, state, actions),
            Pane::Curves => crate::curves::curves_ui(&mut panels.curves, ui, state, actions),
            Pane::Waves => crate::waves::waves_ui(&mut panels.waves, ui, state, actions),
            Pane::Report => crate::report::report_ui(&mut panels.report, ui, state, actions),
            Pane::Help => crate::help::help_ui(&mut panels.help, ui, state, actions),
            Pane::Text => crate::text_panel::text_panel_ui(&mut panels.text, ui, state, actions),
        });
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> WidgetText {
        pane.title().into()
    }

    fn is_tab_closable(&self, tiles: &Tiles<Pane>, tile: TileId) -> bool {
        tiles.get_pane(&tile) == Some(&Pane::Second)
    }

    /// The second viewer stays where it is, for the next time that it is shown.
    fn on_tab_close(&mut self, tiles: &mut Tiles<Pane>, tile: TileId) -> bool {
        tiles.set_visible(tile, false);
        false
    }

    fn simplification_options(&self) -> SimplificationOptions {
        // Joined, the viewers would share their width with what stands beside them.
        SimplificationOptions {
            all_panes_must_have_tabs: true,
            join_nested_linear_containers: false,
            ..SimplificationOptions::default()
        }
    }
}

fn menus_ui(editor: &mut Editor, ui: &mut Ui, actions: &mut Vec<Action>) {
    MenuBar::new().ui(ui, |ui| {
        for menu in MENUS {
            ui.menu_button(menu, |ui| {
                menu::commands_ui(editor, ui, menu, actions);
                if menu == "Viewer" {
                    ui.separator();
                    editor.panels.viewer.transform_menu(ui, &editor.state, actions);
                }
                if menu == "Window" {
                    ui.separator();
                    layouts_ui(editor, ui, actions);
                }
                if menu == "File" && !editor.recent.is_empty() {
                    ui.separator();
                    ui.menu_button("Open recent", |ui| {
                        for file in editor.recent.iter().filter(|file| file.is_file()) {
                            let name = file.file_name().unwrap_or_default().to_string_lossy();
                            if ui.button(name).on_hover_text(file.display().to_string()).clicked() {
                                actions.push(Action::OpenFile(file.clone()));
                            }
                        }
                    });
                }
            });
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.weak(editor.title());
        });
    });
}

/// Draws the menu of layouts.
fn layouts_ui(editor: &Editor, ui: &mut Ui, actions: &mut Vec<Action>) {
    ui.menu_button("Layout", |ui| {
        for layout in LayoutChoice::ALL {
            if ui.button(layout.name()).clicked() {
                actions.push(Action::Layout(layout));
            }
        }
        let own = editor.layouts.names();
        if !own.is_empty() {
            ui.separator();
        }
        for name in &own {
            if ui.button(name).clicked() {
                actions.push(Action::OwnLayout(name.clone()));
            }
        }
        ui.separator();
        if ui.button("Save layout …").clicked() {
            actions.push(Action::NameLayout);
        }
        if !own.is_empty() {
            ui.menu_button("Delete layout", |ui| {
                for name in own {
                    if ui.button(&name).clicked() {
                        actions.push(Action::ForgetLayout(name));
                    }
                }
            });
        }
    });
}

/// Shows the parse error of a text that is not JSON, above the panels.
fn unreadable_ui(state: &State, ui: &mut Ui, actions: &mut Vec<Action>) {
    let meaning = state.session.meaning();
    let Some(fault) = meaning.errors().next().filter(|_| !meaning.readable) else { return };
    Panel::top("unreadable").show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            let place =
                if fault.line > 0 { format!("Line {}, column {}: ", fault.line, fault.column) } else { String::new() };
            let stays = if state.sheet().value.is_null() {
                "Nothing else can be shown until the text is corrected."
            } else {
                "The panels show the previous state, and cannot be edited until the text is corrected."
            };
            let text = format!("{place}found {}; expected {}. {stays}", fault.found, fault.expected);
            ui.label(RichText::new(text).color(crate::theme::error(ui.visuals())));
            if ui.button("Show the text").clicked() {
                actions.push(Action::Panel(Pane::Text));
            }
            let undo = egui::Button::new("Undo");
            if ui.add_enabled(state.session.history().undoes().is_some(), undo).clicked() {
                actions.push(Action::Undo);
            }
        });
    });
}

/// Shows the message about an unsupported format version.
fn version_ui(state: &State, ui: &mut Ui, actions: &mut Vec<Action>) {
    let standing = VersionStatus::of(&state.sheet().value);
    let Some(notice) = standing.notice() else { return };
    Panel::top("version").show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new(notice).color(ui.visuals().warn_fg_color));
            if let Some(edit) = standing.remedy()
                && ui.button("Set the format version").on_hover_text("Changes nothing else; can be undone").clicked()
            {
                actions.push(Action::Edit(edit));
            }
        });
    });
}

fn status_ui(state: &State, ui: &mut Ui, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        let meaning = state.session.meaning();
        let broken = state.broken();
        let told = meaning.errors().count();
        let errors = told + usize::from(broken.is_some());
        let is_warning = |fault: &&trochoid::Diagnostic| {
            fault.severity == trochoid::Severity::Warning && !crate::faults::is_note(fault)
        };
        let warnings: Vec<String> = meaning.diagnostics.iter().filter(is_warning).map(ToString::to_string).collect();
        if errors > 0 {
            let text = crate::document::edit::count(errors, "error");
            let mut label = ui.button(RichText::new(text).color(crate::theme::error(ui.visuals())));
            for fault in meaning.errors().take(6) {
                label = label.on_hover_text(fault.to_string());
            }
            if let Some((_, failed)) = broken {
                label = label.on_hover_text(failed);
            }
            // Clicking goes to the node at fault.
            let culprit = meaning.errors().find_map(|fault| fault.node.clone());
            let culprit = culprit.or_else(|| broken.and_then(|(node, _)| node.map(String::from)));
            if label.clicked() {
                match culprit {
                    Some(node) => actions.push(Action::Visit(node)),
                    None if told == 0 => actions.push(Action::Panel(Pane::Viewer)),
                    None => actions.push(Action::Panel(Pane::Text)),
                }
            }
        } else {
            ui.weak("No errors");
        }
        if !warnings.is_empty() {
            let label = ui.weak(crate::document::edit::count(warnings.len(), "warning"));
            label.on_hover_text(warnings[..warnings.len().min(6)].join("\n\n"));
        }
        if !state.selection.is_empty() {
            ui.weak(format!("{} selected", crate::document::edit::count(state.selection.len(), "node")));
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if let Some(render) = &state.render {
                if ui.button("Stop").clicked() {
                    actions.push(Action::CancelRender);
                }
                let (done, total) = render.done;
                let share = (done as f32 + render.share) / total.max(1) as f32;
                let text = format!("Rendering {} of {total}", (done + 1).min(total));
                ui.add(egui::ProgressBar::new(share).desired_width(180.0).text(text));
            }
            if let Some(share) = state.evaluated.progress {
                ui.add(egui::ProgressBar::new(share).desired_width(100.0));
                ui.weak("Evaluating");
            } else if let Some(result) = state.evaluated.result.as_deref().filter(|result| result.finished) {
                // Only the time of the picture shown.
                ui.weak(crate::format::seconds(result.seconds.1));
                if result.picture.guarantee.is_some() {
                    let exits = result.picture.audit.hull_exits;
                    let text = format!("{} outside the palette", crate::format::thousands(exits));
                    ui.weak(text).on_hover_text(
                        "Pixels of the finished picture that are not a convex mix of the control colors",
                    );
                }
            }
        });
    });
}
