//! Graphs at another size, with lengths in pixels scaled.

use crate::{Animated, CheckedGraph, Item, KnobType, Record, Setting};
use trochoid_image::Format;

impl CheckedGraph {
    /// Sets another format, for proxies and previews, and scales knobs in pixels, such as the width of a line, with
    /// the width of the picture. Knobs that are in pixels of a picture of some height stay those of this one.
    pub fn with_scaled_format(mut self, format: Format) -> Self {
        let scale = f64::from(format.width()) / f64::from(self.format.width());
        let height = f64::from(self.format.height());
        for node in &mut self.nodes {
            shrink(node.ty.declaration().items, &mut node.record, scale, height);
        }
        self.with_format(format)
    }
}

fn shrink(items: &[Item], record: &mut Record, scale: f64, height: f64) {
    for item in items {
        let Item::Knob(knob) = item else { continue };
        if !knob.in_pixels && !knob.picture_height {
            continue;
        }
        let range = |value: f64| match knob.takes {
            KnobType::Number { min, max } => value.clamp(min, max),
            KnobType::Integer { min, max } => value.round().clamp(min as f64, max as f64),
            _ => value,
        };
        let settings = record.knobs.iter_mut().filter(|(name, _)| *name == knob.name);
        for (_, setting) in settings {
            if knob.picture_height {
                if *setting == Setting::Unset {
                    *setting = Setting::Numeric(Animated::constant(vec![height]));
                }
            } else if let Setting::Numeric(animated) = setting {
                *animated = animated.map(|values| values.iter().map(|value| range(value * scale)).collect());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{Animated, Items, Record, Setting};

    #[derive(Clone, Items)]
    struct Line {
        /// A line's width.
        #[knob(default = 4.0, range = 0.5..=64.0, in_pixels)]
        width: f64,
        /// A reach.
        #[knob(default = 4, range = 1..=64, in_pixels)]
        reach: i64,
        /// A wave's height.
        #[knob(default = 4.0, range = 0.0..=64.0, unit = "m")]
        height: f64,
        /// The height of the picture that is meant.
        #[knob(range = 1..=4096, picture_height)]
        meant: Option<i64>,
    }

    #[test]
    fn pixels_shrink_within_their_range_and_meters_do_not() {
        let setting = |name: &'static str| (name, Setting::Numeric(Animated::constant(vec![4.0])));
        let mut record =
            Record { knobs: vec![setting("width"), setting("reach"), setting("height")], ..Record::default() };
        let meant = record.knobs.len();
        record.knobs.push(("meant", Setting::Unset));
        super::shrink(Line::ITEMS, &mut record, 1.0 / 16.0, 1080.0);
        let line = Line::read(&mut crate::Reader::new(&record.settle(1.0)));
        assert_eq!((line.width, line.reach, line.height, line.meant), (0.5, 1, 4.0, Some(1080)));
        record.knobs[meant] = setting("meant");
        super::shrink(Line::ITEMS, &mut record, 1.0 / 16.0, 1080.0);
        assert_eq!(Line::read(&mut crate::Reader::new(&record.settle(1.0))).meant, Some(4), "as it was set");
    }
}
