//! Reads values that may be keyed over frames.

use super::values::value_text;
use super::{Checker, FaultLocation};
use crate::spanned::{Json, Spanned, number_text};
use crate::{Animated, CurveHandle, CurveKey, Interpolation};

/// Range of the channels of colors.
pub(super) const COLOR: [f64; 2] = [0.0, f32::MAX as f64];
/// Range of numbers that kernels, which work in f32, can hold.
pub(super) const FINITE: [f64; 2] = [-f32::MAX as f64, f32::MAX as f64];

/// Keys of a keyed value.
const KEYS: [&str; 2] = ["keys", "interpolation"];
/// Keys of the third item of a key.
const KEY_KEYS: [&str; 3] = ["in", "out", "interpolation"];
/// How a key with handles is written.
const HANDLES: &str = "{ \"in\": [frames, change], \"out\": [frames, change], \"interpolation\": a word }";

impl<'a> Checker<'a> {
    /// Reads a constant, or a keyed value `{"keys": [[frame, value], …], "interpolation": …}`. At every frame, components
    /// must be within a range; `read` checks only those that are written.
    pub(super) fn animated(
        &mut self,
        value: &'a Spanned,
        range: [f64; 2],
        place: FaultLocation<'_>,
        mut read: impl FnMut(&mut Self, &'a Spanned, FaultLocation<'_>) -> Option<Vec<f64>>,
    ) -> Option<Animated> {
        if let Json::Array(items) = &value.json
            && let [first, ..] = &items[..]
            && items.iter().all(|item| matches!(&item.json, Json::Array(pair) if pair.len() == 2))
        {
            let remedy = format!("write {{ \"keys\": [{}, …] }}: each key is [frame, value]", pair_text(first));
            self.error(place, "a list of pairs", "one value or a keyed value", remedy);
            return None;
        }
        if !matches!(value.json, Json::Object(_)) {
            return read(self, value, place).map(Animated::constant);
        }
        let entries = self.object(value, place, "a keyed value")?;
        let mut interpolation = Interpolation::default();
        let mut keys = None;
        for entry in entries {
            match (entry.key.as_str(), &entry.value.json) {
                ("keys", Json::Array(items)) if !items.is_empty() => {
                    let mut list = Vec::with_capacity(items.len());
                    for item in items {
                        list.push(self.curve_key(item, place.at(item.offset), &mut read)?);
                    }
                    keys = Some(list);
                }
                ("interpolation", _) => interpolation = self.interpolation(&entry.value, place)?,
                ("keys", _) => {
                    let expected = "\"keys\": [[frame, value], …], \"interpolation\": a word";
                    self.error(place.at(entry.value.offset), entry.value.brief(), expected, "correct the keyed value");
                    return None;
                }
                (key, _) => self.unknown_key(place.at(entry.offset), key, &KEYS),
            }
        }
        let Some(keys) = keys else {
            self.error(place, "a keyed value without \"keys\"", "\"keys\": [[frame, value], …]", "add the keys");
            return None;
        };
        if let Some([before, after]) = keys.windows(2).map(|pair| [pair[0].frame, pair[1].frame]).find(|[a, b]| a >= b)
        {
            let found = format!("keys out of order: frame {after} after frame {before}");
            self.error(
                place,
                found,
                "frames in ascending order, each once",
                "sort the keys by frame; each is [frame, value]",
            );
            return None;
        }
        let animated = Animated::keyed(keys, interpolation);
        let Some(animated) = animated else {
            self.error(
                place,
                "keys of different sizes",
                "values of one size",
                "give each key the same number of values",
            );
            return None;
        };
        self.handles_fit(&animated, range, place).then_some(animated)
    }

    fn interpolation(&mut self, value: &Spanned, place: FaultLocation<'_>) -> Option<Interpolation> {
        let known = if let Json::String(name) = &value.json { Interpolation::from_name(name) } else { None };
        if known.is_none() {
            let expected = format!("one of {}", Interpolation::NAMES.join(", "));
            self.error(place.at(value.offset), value.brief(), expected, "choose one of them");
        }
        known
    }

    /// Reads a key: `[frame, value]`, or with handles `[frame, value, {"in": …, "out": …, "interpolation": …}]`.
    fn curve_key(
        &mut self,
        item: &'a Spanned,
        place: FaultLocation<'_>,
        read: &mut impl FnMut(&mut Self, &'a Spanned, FaultLocation<'_>) -> Option<Vec<f64>>,
    ) -> Option<CurveKey> {
        let (frame, value, more) = match &item.json {
            Json::Array(items) => match &items[..] {
                [frame, value] => (frame, value, None),
                [frame, value, more] => (frame, value, Some(more)),
                _ => (item, item, None),
            },
            _ => (item, item, None),
        };
        if std::ptr::eq(frame, item) {
            self.error(place, item.brief(), "a key: [frame, value]", "write [frame, value]");
            return None;
        }
        let frame = self.number(frame, -1e7, 1e7, place.at(frame.offset))?;
        let mut key = CurveKey::plain(frame, read(self, value, place.at(value.offset))?);
        let Some(more) = more else { return Some(key) };
        let place = place.at(more.offset);
        if !matches!(more.json, Json::Object(_)) {
            let found = format!("{} as the third item of a key", more.brief());
            self.error(place, found, HANDLES, "write [frame, value], or add handles");
            return None;
        }
        for entry in self.object(more, place, HANDLES)? {
            let side = ["in", "out"].iter().position(|word| *word == entry.key);
            match (side, entry.key.as_str()) {
                (Some(side), _) => key.handles[side] = Some(self.handle(side, &entry.value, key.value.len(), place)?),
                (None, "interpolation") => key.interpolation = Some(self.interpolation(&entry.value, place)?),
                (None, unknown) => self.unknown_key(place.at(entry.offset), unknown, &KEY_KEYS),
            }
        }
        Some(key)
    }

    /// Reads a handle, `[frames, change]`: before the key if `side` is 0, else after it.
    fn handle(
        &mut self,
        side: usize,
        value: &'a Spanned,
        count: usize,
        place: FaultLocation<'_>,
    ) -> Option<CurveHandle> {
        let place = place.at(value.offset);
        let Json::Array(items) = &value.json else { return self.no_handle(value, count, place) };
        let [frames, change] = &items[..] else { return self.no_handle(value, count, place) };
        let (low, high) = if side == 0 { (-1e7, 0.0) } else { (0.0, 1e7) };
        let frames = self.number(frames, low, high, place.at(frames.offset))?.abs();
        let numbers = match &change.json {
            Json::Number(_) => std::slice::from_ref(change),
            Json::Array(items) => items,
            _ => &[],
        };
        if numbers.len() != count || count > 1 && matches!(change.json, Json::Number(_)) {
            return self.no_handle(value, count, place);
        }
        let limit = f64::from(f32::MAX);
        let numbers = numbers.iter().map(|number| self.number(number, -limit, limit, place.at(number.offset)));
        Some(CurveHandle { frames, change: numbers.collect::<Option<_>>()? })
    }

    fn no_handle<T>(&mut self, value: &Spanned, count: usize, place: FaultLocation<'_>) -> Option<T> {
        let change = if count == 1 { "a number".into() } else { format!("a list of {count} numbers") };
        let remedy = "write both as seen from the key: frames before it are negative";
        self.error(place, value.brief(), format!("a handle: [frames, change], the change {change}"), remedy);
        None
    }

    /// Reports handles without effect, and curves that leave a range between their keys.
    fn handles_fit(&mut self, animated: &Animated, [low, high]: [f64; 2], place: FaultLocation<'_>) -> bool {
        if let Some(frame) = animated.idle_handles().next() {
            let remedy = "remove the handle, or choose another interpolation";
            self.error(
                place,
                format!("a handle of the key at frame {frame}, where the value holds"),
                "handles only where the value moves from key to key",
                remedy,
            );
            return false;
        }
        let Some((frame, value)) = animated.turns().into_iter().find(|(_, value)| !(low..=high).contains(value)) else {
            return true;
        };
        let (limit, bound) = if value < low { ("at least", low) } else { ("at most", high) };
        let [frame, value] = [frame, value].map(|number| number_text((number * 1e4).round() / 1e4));
        self.error(
            place,
            format!("{value} at frame {frame}, between keys"),
            format!("{limit} {} at every frame", number_text(bound)),
            "shorten the handles beside that frame, or turn them: the curve then stays closer to its keys",
        );
        false
    }
}

/// Formats a pair as it was written.
fn pair_text(value: &Spanned) -> String {
    if let Json::Array(items) = &value.json { value_text(items) } else { value.brief() }
}
