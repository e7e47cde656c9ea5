//! Keyboard selection in searchable lists: fuzzy matching and the arrow keys.

use egui::{Key, Ui};

/// Returns the cost of matching the letters of `wanted`, in order, in `name` (less is better), or `None` if they do not
/// match.
pub(crate) fn fuzzy(wanted: &str, name: &str) -> Option<usize> {
    let name: Vec<char> = name.to_lowercase().chars().collect();
    let mut at = 0;
    let mut cost = 0;
    for c in wanted.to_lowercase().chars().filter(|c| !c.is_whitespace()) {
        let next = name[at..].iter().position(|known| *known == c)?;
        // The first letter costs its position; a letter that begins a word costs nothing.
        let begins = at + next == 0 || !name[at + next - 1].is_alphanumeric();
        cost += if begins { 0 } else { next + usize::from(at == 0) };
        at += next + 1;
    }
    Some(4 * cost + name.len())
}

/// Returns the indices of matching names, best first.
pub(crate) fn matches<'n>(wanted: &str, names: impl Iterator<Item = (usize, &'n str)>) -> Vec<usize> {
    let mut found: Vec<(usize, usize)> =
        names.filter_map(|(index, name)| Some((fuzzy(wanted, name)?, index))).collect();
    if !wanted.trim().is_empty() {
        found.sort_unstable();
    }
    found.into_iter().map(|(_, index)| index).collect()
}

/// Moves the selection in a list by the arrow keys.
pub(crate) fn moved(ui: &Ui, chosen: usize, count: usize) -> usize {
    let step = ui.input(|input| input.num_presses(Key::ArrowDown) as i64 - input.num_presses(Key::ArrowUp) as i64);
    (chosen as i64 + step).clamp(0, count.saturating_sub(1) as i64) as usize
}
