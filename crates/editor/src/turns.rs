//! Splits events over several frames. All events that occur while a frame is drawn arrive together with the next frame.
//! A key that moves the focus must not take earlier typing along to the next field, nor leave later typing in the old
//! one, so such events are delivered in frames of their own, with an empty frame after them in which what they open takes
//! the focus. A button of the pointer counts where it is pressed or let go, so movements after it wait for the next frame.

use egui::{Context, Event, Key, Plugin, RawInput};
use std::collections::VecDeque;

/// Installs the plugin.
pub(crate) fn install(context: &Context) {
    context.add_plugin(Turns::default());
}

#[derive(Debug, Default)]
struct Turns {
    waiting: VecDeque<Event>,
    /// Whether the last frame had a key that may move the focus.
    rests: bool,
}

impl Turns {
    /// Takes further events, and returns those of one frame.
    fn deliver(&mut self, events: &mut Vec<Event>) {
        self.waiting.extend(events.drain(..));
        let count = if self.rests { 0 } else { turn(self.waiting.iter()) };
        events.extend(self.waiting.drain(..count));
        self.rests = events.iter().any(|event| role(event) == Role::Turn);
    }
}

/// Effect of an event on keyboard input.
#[derive(Clone, Copy, PartialEq)]
enum Role {
    /// Goes to the focused field.
    Typed,
    /// May move the focus, or use the typed text.
    Turn,
    /// May move the focus; the two ends of a click belong together.
    Press,
    Neither,
}

fn role(event: &Event) -> Role {
    match event {
        Event::Key { pressed: true, key, modifiers, .. } => match key {
            Key::Tab | Key::Enter | Key::Escape => Role::Turn,
            _ if modifiers.command => Role::Turn,
            _ => Role::Typed,
        },
        Event::Text(_) | Event::Paste(_) | Event::Copy | Event::Cut | Event::Ime(_) => Role::Typed,
        Event::PointerButton { .. } => Role::Press,
        _ => Role::Neither,
    }
}

/// Returns how many of the pending events belong in one frame.
fn turn<'e>(events: impl Iterator<Item = &'e Event>) -> usize {
    let (mut before, mut count) = (None, 0);
    for event in events {
        let role = role(event);
        if before == Some(Role::Press) && matches!(event, Event::PointerMoved(_) | Event::PointerGone) {
            break;
        }
        let fits = match (before, role) {
            (_, Role::Neither) | (None, _) => true,
            (Some(Role::Typed), Role::Typed) | (Some(Role::Press), Role::Press) => true,
            (Some(_), _) => false,
        };
        if !fits {
            break;
        }
        if role != Role::Neither {
            before = Some(role);
        }
        count += 1;
    }
    count
}

impl Plugin for Turns {
    fn debug_name(&self) -> &'static str {
        "turns"
    }

    fn input_hook(&mut self, context: &Context, input: &mut RawInput) {
        self.deliver(&mut input.events);
        if !self.waiting.is_empty() {
            context.request_repaint();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::Modifiers;

    fn key(key: Key) -> Event {
        Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE }
    }

    fn text(text: &str) -> Event {
        Event::Text(text.into())
    }

    #[test]
    fn typing_and_keys_that_move_the_focus_take_turns() {
        let mut all = vec![key(Key::Num5), text("5"), key(Key::Tab), key(Key::Tab), text("7"), key(Key::Enter)];
        let mut turns = Vec::new();
        while !all.is_empty() {
            let count = turn(all.iter());
            turns.push(count);
            all.drain(..count);
        }
        assert_eq!(turns, [2, 1, 1, 1, 1]);
    }

    #[test]
    fn what_a_key_opens_takes_the_focus_before_letters_arrive() {
        let mut turns = Turns::default();
        let mut frame = |mut events: Vec<Event>| {
            turns.deliver(&mut events);
            events
        };
        let open =
            Event::Key { modifiers: Modifiers::COMMAND, pressed: true, repeat: false, physical_key: None, key: Key::P };
        assert_eq!(frame(vec![open.clone(), key(Key::S), text("s")]), std::slice::from_ref(&open));
        assert_eq!(frame(vec![key(Key::H)]), [], "the list opens");
        assert_eq!(frame(Vec::new()), [key(Key::S), text("s"), key(Key::H)]);
        assert_eq!(frame(vec![open.clone()]), [open]);
        assert_eq!(frame(Vec::new()), [], "nothing waits");
        assert_eq!(frame(vec![text("h")]), [text("h")]);
    }

    #[test]
    fn the_ends_of_a_click_belong_together() {
        let press = |pressed| Event::PointerButton {
            pos: egui::Pos2::ZERO,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        assert_eq!(turn([key(Key::A), press(true)].iter()), 1);
        assert_eq!(turn([press(true), press(false), press(true), press(false)].iter()), 4, "a double click");
        assert_eq!(turn([press(true), press(false), text("a")].iter()), 2);
    }

    #[test]
    fn buttons_count_where_they_are_pressed_and_let_go() {
        let at = |x: f32| egui::pos2(x, 0.0);
        let moved = |x: f32| Event::PointerMoved(at(x));
        let press = |x: f32, pressed| Event::PointerButton {
            pos: at(x),
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        let mut all =
            vec![moved(1.0), moved(2.0), press(2.0, true), moved(3.0), moved(9.0), press(9.0, false), moved(0.0)];
        let mut turns = Vec::new();
        while !all.is_empty() {
            let count = turn(all.iter());
            turns.push(count);
            all.drain(..count);
        }
        assert_eq!(turns, [3, 3, 1]);
    }
}
