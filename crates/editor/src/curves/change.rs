//! Changes of curves: edits of the document.

use super::{Curves, Picked};
use crate::actions::Action;
use crate::document::change::style;
use crate::document::curve::{Curve, Pick};
use crate::document::keyed::Channel;
use crate::document::{Edit, Op, Path, edit};
use trochoid::WorkingSpace;

/// Keyed values with their new curves; `None` if no key is left.
pub(super) type NewCurves = Vec<(Path, Option<Curve>)>;

/// Where changes of curves are asked for.
pub(super) struct Change<'c> {
    /// The keyed values as they are.
    pub(super) channels: &'c [Channel],
    /// The space in which colors are interpolated.
    pub(super) space: WorkingSpace,
    /// The current frame.
    pub(super) frame: i64,
    /// Field that shows why a change is refused.
    pub(super) field: egui::Id,
    pub(super) actions: &'c mut Vec<Action>,
}

impl Change<'_> {
    /// Returns the edit that gives some keyed values new curves; `None` if they have them. Without a key, a value stays as it
    /// is at the current frame.
    pub(super) fn edit(&self, label: String, curves: &[(Path, Option<Curve>)]) -> Option<Edit> {
        let ops = curves.iter().filter_map(|(path, curve)| {
            let old = &self.channels.iter().find(|channel| channel.path == *path)?.curve;
            let text = match curve {
                Some(curve) if curve == old => return None,
                Some(curve) => style(&curve.write()),
                None => style(&old.at(self.frame as f64)),
            };
            Some(Op::Set(path.clone(), text))
        });
        let ops: Vec<Op> = ops.collect();
        (!ops.is_empty()).then(|| Edit::new(label, ops))
    }

    /// Asks for new curves, as one step of undo.
    pub(super) fn make(&mut self, label: String, curves: &[(Path, Option<Curve>)]) {
        if let Some(edit) = self.edit(label, curves) {
            self.actions.extend([Action::Seal, Action::Give(edit, self.field), Action::Seal]);
        }
    }

    /// Asks for a change of all picked keys, or, if none is picked, of all keys of the shown values.
    pub(super) fn each(&mut self, panel: &Curves, label: &str, change: impl Fn(&Curve, &[f64]) -> Option<Curve>) {
        let picked = panel.picked(self.channels);
        let targets: Vec<(&Channel, Vec<f64>)> = match picked.is_empty() {
            false => picked.into_iter().map(|(channel, picks)| (channel, frames_of(&picks))).collect(),
            true => {
                let all = |channel: &Channel| channel.curve.keys.iter().map(|key| key.frame).collect();
                panel.shown(self.channels).into_iter().map(|channel| (channel, all(channel))).collect()
            }
        };
        let count = targets.iter().map(|(_, frames)| frames.len()).sum();
        let new = targets.iter().map(|(channel, frames)| (channel.path.clone(), change(&channel.curve, frames)));
        let new: Vec<_> = new.collect();
        self.make(format!("{label} {}", edit::count(count, "key")), &new);
    }
}

/// Returns the frames of picks, each once.
pub(super) fn frames_of(picks: &[Pick]) -> Vec<f64> {
    let mut frames: Vec<f64> = picks.iter().map(|pick| pick.frame).collect();
    frames.sort_by(f64::total_cmp);
    frames.dedup();
    frames
}

/// Returns how many keys are picked.
pub(super) fn key_count(picks: &[Picked]) -> usize {
    let mut keys: Vec<(&Path, u64)> = picks.iter().map(|picked| (&picked.path, picked.pick.frame.to_bits())).collect();
    keys.sort_unstable();
    keys.dedup();
    keys.len()
}
