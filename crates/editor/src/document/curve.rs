//! Curves: values keyed over frames, as documents have them, and what can be done with their keys.

use serde_json::{Map, Value, json};
use trochoid::{Animated, CurveHandle, CurveKey, Interpolation, Segment};

/// A key of a curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Its frame.
    pub frame: f64,
    /// Its value as it is written.
    pub value: Value,
    /// Handles before and after the key.
    pub handles: [Option<CurveHandle>; 2],
    /// Interpolation from this key to the next, if it is not that of the curve.
    pub interpolation: Option<Interpolation>,
}

/// A keyed value.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The keys; frames ascend.
    pub keys: Vec<Key>,
    /// Interpolation of keys that have none of their own.
    pub interpolation: Interpolation,
}

/// A key that is picked, by its frame and one component of its value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// Frame of the key.
    pub frame: f64,
    /// Component of its value.
    pub component: usize,
}

/// What moves keys: their frames, and their values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shift {
    /// Frame and value that scaling leaves in place.
    pub about: [f64; 2],
    /// Factors of frames and values; above 0.
    pub scale: [f64; 2],
    /// Frames and values to add.
    pub by: [f64; 2],
}

impl Shift {
    /// Returns the shift that only adds.
    pub fn by(frames: f64, value: f64) -> Self {
        Self { about: [0.0; 2], scale: [1.0; 2], by: [frames, value] }
    }

    fn moved(&self, axis: usize, number: f64) -> f64 {
        match self.scale[axis] == 1.0 {
            true => number + self.by[axis],
            false => self.about[axis] + (number - self.about[axis]) * self.scale[axis] + self.by[axis],
        }
    }

    /// Returns a frame after the shift: whole, unless it stays.
    pub fn frame(&self, frame: f64) -> f64 {
        let moved = self.moved(0, frame);
        if moved == frame { frame } else { moved.round() }
    }
}

/// Rounds a number as it is written; −0 becomes 0.
fn neat(number: f64) -> f64 {
    crate::field::rounded(number) + 0.0
}

fn neat_handle(handle: CurveHandle) -> CurveHandle {
    CurveHandle { frames: neat(handle.frames), change: handle.change.into_iter().map(neat).collect() }
}

/// Largest distance of a frame from 0.
const FAR: f64 = 1e7;

impl Key {
    fn read(key: &Value) -> Option<Self> {
        let (frame, value, more) = match key.as_array()?.as_slice() {
            [frame, value] => (frame, value, None),
            [frame, value, more] => (frame, value, Some(more.as_object()?)),
            _ => return None,
        };
        let handle = |side: &str| match more.and_then(|more| more.get(side)) {
            None => Some(None),
            Some(handle) => {
                let [frames, change] = handle.as_array()?.as_slice() else { return None };
                let numbers = match change {
                    Value::Array(items) => items.iter().map(Value::as_f64).collect::<Option<Vec<_>>>()?,
                    number => vec![number.as_f64()?],
                };
                Some(Some(CurveHandle { frames: frames.as_f64()?.abs(), change: numbers }))
            }
        };
        let word = more.and_then(|more| more.get("interpolation")).and_then(Value::as_str);
        Some(Self {
            frame: frame.as_f64()?,
            value: value.clone(),
            handles: [handle("in")?, handle("out")?],
            interpolation: word.and_then(Interpolation::from_name),
        })
    }

    pub(super) fn write(&self) -> Value {
        let mut more = Map::new();
        for (side, handle) in ["in", "out"].into_iter().zip(&self.handles) {
            let Some(CurveHandle { frames, change }) = handle else { continue };
            let frames = if side == "in" { 0.0 - frames } else { *frames };
            let change = match change.as_slice() {
                [number] => json!(number),
                numbers => json!(numbers),
            };
            more.insert(side.into(), json!([frames, change]));
        }
        if let Some(word) = self.interpolation {
            more.insert("interpolation".into(), word.name().into());
        }
        if more.is_empty() { json!([self.frame, self.value]) } else { json!([self.frame, self.value, more]) }
    }

    /// Returns the components of its value; of a color, red, green and blue in sRGB.
    pub fn numbers(&self) -> Vec<f64> {
        match &self.value {
            Value::Array(items) => items.iter().filter_map(Value::as_f64).collect(),
            Value::String(text) => super::color::rgb(text).map_or(Vec::new(), |rgb| rgb.map(f64::from).into()),
            other => other.as_f64().into_iter().collect(),
        }
    }

    /// Sets a component of a value that is written as numbers.
    pub fn set(&mut self, component: usize, number: f64) {
        let number = json!(neat(number));
        match &mut self.value {
            Value::Array(items) if component < items.len() => items[component] = number,
            value @ Value::Number(_) => *value = number,
            _ => {}
        }
    }

    /// Returns whether both handles lie on one line, so that moving one turns the other.
    pub fn is_smooth(&self) -> bool {
        let [Some(before), Some(after)] = &self.handles else { return true };
        before.change.iter().zip(&after.change).all(|(back, on)| {
            let (a, b) = (-back * after.frames, on * before.frames);
            (a - b).abs() <= 1e-3 * a.abs().max(b.abs())
        })
    }
}

impl Curve {
    /// Reads a keyed value; `None` if the value has no keys, or some that cannot be read.
    pub fn read(value: &Value) -> Option<Self> {
        let keys: Vec<Key> = value.get("keys")?.as_array()?.iter().map(Key::read).collect::<Option<_>>()?;
        let interpolation = value.get("interpolation").and_then(Value::as_str).and_then(Interpolation::from_name);
        Some(Self { keys, interpolation: interpolation.unwrap_or_default() })
    }

    /// Returns the value in the form documents store.
    pub fn write(&self) -> Value {
        let keys: Vec<Value> = self.keys.iter().map(Key::write).collect();
        match self.interpolation {
            Interpolation::Linear => json!({ "keys": keys }),
            word => json!({ "keys": keys, "interpolation": word.name() }),
        }
    }

    /// Returns the numbers of the curve; `None` if its values are none, or of different sizes.
    pub fn animated(&self) -> Option<Animated> {
        self.animated_by(|key| Some(key.numbers()))
    }

    /// Returns the numbers of the curve, as a function reads them from keys.
    pub fn animated_by(&self, numbers: impl Fn(&Key) -> Option<Vec<f64>>) -> Option<Animated> {
        let key = |key: &Key| {
            let plain = CurveKey::plain(key.frame, numbers(key)?);
            Some(CurveKey { handles: key.handles.clone(), interpolation: key.interpolation, ..plain })
        };
        Animated::keyed(self.keys.iter().map(key).collect::<Option<_>>()?, self.interpolation)
    }

    /// Returns the interpolated value at a frame, in the same JSON form as the keys.
    pub fn at(&self, frame: f64) -> Value {
        let Some(first) = self.keys.first() else { return Value::Null };
        if let Some(index) = self.find(frame) {
            return self.keys[index].value.clone();
        }
        let Some(animated) = self.animated() else { return first.value.clone() };
        let values = animated.at(frame);
        match (&first.value, values.as_slice()) {
            (Value::String(_), [r, g, b]) => super::color::hex([*r, *g, *b].map(|value| value as f32)).into(),
            (Value::Array(_), values) => json!(values),
            (Value::Number(_), [value]) => json!(value),
            _ => first.value.clone(),
        }
    }

    /// Returns the index of the key at a frame.
    pub fn find(&self, frame: f64) -> Option<usize> {
        self.keys.iter().position(|key| key.frame == frame)
    }

    /// Returns the curve with a key of a value at a frame.
    #[must_use]
    pub fn with(&self, frame: f64, value: &Value) -> Self {
        let mut curve = self.clone();
        match curve.keys.binary_search_by(|key| key.frame.total_cmp(&frame)) {
            Ok(at) => curve.keys[at].value = value.clone(),
            Err(at) => {
                let key = Key { frame, value: value.clone(), handles: [None, None], interpolation: None };
                curve.keys.insert(at, key);
            }
        }
        curve.tidied()
    }

    /// Returns the curve with a key at a frame that leaves its shape as it is.
    #[must_use]
    pub fn inserted(&self, frame: f64) -> Self {
        if self.find(frame).is_some() {
            return self.clone();
        }
        let mut curve = self.with(frame, &self.at(frame));
        let at = curve.keys.partition_point(|key| key.frame < frame);
        let Some(before) = at.checked_sub(1).filter(|_| at + 1 < curve.keys.len()) else { return curve };
        curve.keys[at].interpolation = curve.keys[before].interpolation;
        let is_bent = self.keys[before].handles[1].is_some() || self.keys[at].handles[0].is_some();
        let segment = self.animated().filter(|_| is_bent).and_then(|animated| animated.segment(before));
        if let Some(segment) = segment {
            let parts = segment.split(frame);
            for (part, key) in parts.iter().zip(before..) {
                let [out, back] = handles_of(part).map(neat_handle);
                curve.keys[key].handles[1] = Some(out);
                curve.keys[key + 1].handles[0] = Some(back);
            }
        }
        curve.tidied()
    }

    /// Returns the curve with a key of a value at a frame, where handles bend the curve without a corner.
    #[must_use]
    pub fn keyed(&self, frame: f64, value: &Value) -> Self {
        // Handles of colors are in the working space, which is not known here.
        let mut curve = if value.is_string() { self.with(frame, value) } else { self.inserted(frame) };
        let Some(at) = curve.find(frame) else { return curve };
        curve.keys[at].value = value.clone();
        if self.find(frame).is_none() && self.keys.len() > 1 && !value.is_string() {
            match at {
                0 => curve.continue_from(1, 0),
                at if at == self.keys.len() => curve.continue_from(at - 1, 1),
                _ => {}
            }
        }
        curve.tidied()
    }

    /// Lets the curve go on from the handle of a key that was an end to the next key at a side: 0 before it, 1 after it.
    fn continue_from(&mut self, key: usize, side: usize) {
        let next = if side == 0 { key - 1 } else { key + 1 };
        let Some(back) = self.keys[key].handles[1 - side].clone().filter(|back| back.frames > 0.0) else { return };
        let frames = (self.keys[next].frame - self.keys[key].frame).abs() / 3.0;
        let numbers = [key, next].map(|index| self.keys[index].numbers());
        if numbers.iter().any(|numbers| numbers.len() != back.change.len()) {
            return;
        }
        // The handle goes on in its line, and the next key's points to its end.
        let on: Vec<f64> = back.change.iter().map(|change| -change * frames / back.frames).collect();
        let toward =
            numbers[0].iter().zip(&on).zip(&numbers[1]).map(|((from, on), to)| 0.5 * (from + on - to)).collect();
        self.keys[key].handles[side] = Some(neat_handle(CurveHandle { frames, change: on }));
        self.keys[next].handles[1 - side] = Some(neat_handle(CurveHandle { frames, change: toward }));
    }

    /// Returns the curve without the keys at some frames; `None` if none is left.
    #[must_use]
    pub fn without(&self, frames: &[f64]) -> Option<Self> {
        let mut curve = self.clone();
        curve.keys.retain(|key| !frames.contains(&key.frame));
        (!curve.keys.is_empty()).then(|| curve.tidied())
    }

    /// Returns the curve with picked keys moved; `None` if two keys would be at one frame, or one beyond all frames.
    #[must_use]
    pub fn moved(&self, picks: &[Pick], shift: &Shift) -> Option<Self> {
        let mut curve = self.clone();
        for key in &mut curve.keys {
            let frame = key.frame;
            let mut picked = picks.iter().filter(|pick| pick.frame == frame).peekable();
            if picked.peek().is_none() {
                continue;
            }
            let numbers = key.numbers();
            for pick in picked {
                let Some(number) = numbers.get(pick.component) else { continue };
                let moved = shift.moved(1, *number);
                if moved != *number {
                    key.set(pick.component, moved);
                }
                for handle in key.handles.iter_mut().flatten() {
                    if let Some(change) = handle.change.get_mut(pick.component) {
                        *change *= shift.scale[1];
                    }
                }
            }
            key.handles.iter_mut().flatten().for_each(|handle| handle.frames *= shift.scale[0]);
            key.frame = shift.frame(key.frame);
        }
        curve.keys.sort_by(|a, b| a.frame.total_cmp(&b.frame));
        let is_apart = curve.keys.windows(2).all(|pair| pair[0].frame < pair[1].frame);
        let is_near = curve.keys.iter().all(|key| key.frame.abs() <= FAR);
        (is_apart && is_near).then(|| curve.tidied())
    }

    /// Returns the handles beside a key as they act, written or not: of each side the frames and changes as seen from the key;
    /// `None` at the ends, and where the value holds.
    pub fn acting(&self, key: usize) -> [Option<CurveHandle>; 2] {
        let Some(animated) = self.animated() else { return [None, None] };
        let before = key.checked_sub(1).and_then(|before| animated.segment(before));
        let after = animated.segment(key);
        [before.map(|segment| handles_of(&segment)[1].clone()), after.map(|segment| handles_of(&segment)[0].clone())]
    }

    /// Returns the curve with the end of a handle moved, `to` frames and value from its key. Unless it is moved `alone`, or the
    /// handles form a corner, the other handle keeps its length and turns with it.
    #[must_use]
    pub fn turned(&self, pick: Pick, side: usize, to: [f64; 2], alone: bool) -> Self {
        let mut curve = self.clone();
        let Some(index) = self.find(pick.frame) else { return curve };
        let acting = self.acting(index);
        let Some(old) = acting[side].clone() else { return curve };
        let sign = if side == 0 { -1.0 } else { 1.0 };
        let frames = neat((sign * to[0]).max(0.0));
        // Other components share the frames of the handle, and keep their slopes.
        let share = if old.frames > 0.0 { frames / old.frames } else { 1.0 };
        let mut change: Vec<f64> = old.change.iter().map(|change| neat(change * share)).collect();
        let Some(own) = change.get_mut(pick.component) else { return curve };
        *own = neat(to[1]);
        let slope = *own / (sign * frames);
        let key = &mut curve.keys[index];
        let is_smooth = key.is_smooth();
        key.handles[side] = Some(CurveHandle { frames, change });
        if let Some(mut other) = acting[1 - side].clone().filter(|_| is_smooth && !alone && slope.is_finite()) {
            other = neat_handle(other);
            other.change[pick.component] = neat(-sign * other.frames * slope);
            key.handles[1 - side] = Some(other);
        }
        curve.tidied()
    }

    /// Returns the curve with an interpolation from keys at some frames on; from all if they are all keys.
    #[must_use]
    pub fn interpolated(&self, frames: &[f64], word: Interpolation) -> Self {
        let mut curve = self.clone();
        if self.keys.iter().all(|key| frames.contains(&key.frame)) {
            curve.interpolation = word;
            curve.keys.iter_mut().for_each(|key| key.interpolation = None);
        }
        let default = curve.interpolation;
        for key in curve.keys.iter_mut().filter(|key| frames.contains(&key.frame)) {
            key.interpolation = Some(word).filter(|word| *word != default);
        }
        curve.tidied()
    }

    /// Returns the curve with the handles of keys at some frames written as they act: turned onto one line, or level.
    #[must_use]
    pub fn smoothed(&self, frames: &[f64], is_level: bool) -> Self {
        let mut curve = self.clone();
        for index in (0..self.keys.len()).filter(|index| frames.contains(&self.keys[*index].frame)) {
            // Handles of colors are in the working space, which is not known here.
            if self.keys[index].value.is_string() {
                continue;
            }
            let acting = self.acting(index);
            let count = self.keys[index].numbers().len();
            let slope = |component: usize| {
                let slopes = acting.iter().zip([-1.0, 1.0]).filter_map(|(handle, sign)| {
                    let handle = handle.as_ref().filter(|handle| handle.frames > 0.0)?;
                    Some(sign * handle.change[component] / handle.frames)
                });
                let slopes: Vec<f64> = slopes.collect();
                if is_level || slopes.is_empty() { 0.0 } else { slopes.iter().sum::<f64>() / slopes.len() as f64 }
            };
            for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
                let Some(handle) = &acting[side] else { continue };
                let frames = neat(handle.frames);
                let change = (0..count).map(|component| neat(sign * frames * slope(component)));
                curve.keys[index].handles[side] = Some(CurveHandle { frames, change: change.collect() });
            }
        }
        curve.tidied()
    }

    /// Returns the curve without handles of keys at some frames.
    #[must_use]
    pub fn bare(&self, frames: &[f64]) -> Self {
        let mut curve = self.clone();
        let keys = curve.keys.iter_mut().filter(|key| frames.contains(&key.frame));
        keys.for_each(|key| key.handles = [None, None]);
        curve
    }

    /// Returns the curve with the keys of another, moved by some frames, in place of those at their frames.
    #[must_use]
    pub fn joined(&self, other: &Self, by: f64) -> Self {
        let mut curve = self.clone();
        for key in &other.keys {
            let key = Key { frame: key.frame + by, ..key.clone() };
            match curve.keys.binary_search_by(|known| known.frame.total_cmp(&key.frame)) {
                Ok(at) => curve.keys[at] = key,
                Err(at) => curve.keys.insert(at, key),
            }
        }
        curve.tidied()
    }

    /// Removes handles where the value holds: there they would be errors.
    fn tidied(mut self) -> Self {
        for index in 1..self.keys.len() {
            let word = self.keys[index - 1].interpolation.unwrap_or(self.interpolation);
            if word == Interpolation::Hold {
                self.keys[index - 1].handles[1] = None;
                self.keys[index].handles[0] = None;
            }
        }
        self
    }
}

/// Returns the handle that leaves the first key of a segment, and the one that arrives at its second.
fn handles_of(segment: &Segment) -> [CurveHandle; 2] {
    let ([start, end], [out, back]) = (segment.frames, segment.reach);
    let change = |from: usize, to: usize| segment.values.iter().map(|values| values[to] - values[from]).collect();
    [
        CurveHandle { frames: out - start, change: change(0, 1) },
        CurveHandle { frames: end - back, change: change(3, 2) },
    ]
}
