//! Back-end nodes that average colors and combine masks, formulas, and masks of the picture's coordinates.

use super::camera::{Place, point};
use super::document::{list, number};
use super::evaluate::Evaluator;
use super::formula;
use serde_json::Value as Json;

/// Returns Σ wᵢ·vᵢ, number by number.
pub(super) fn sum(terms: impl IntoIterator<Item = (f64, Vec<f64>)>) -> Vec<f64> {
    let mut sum = Vec::new();
    for (weight, value) in terms {
        sum.resize(value.len(), 0.0);
        sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += weight * value);
    }
    sum
}

fn eased(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

/// Two shares are a mask, the second one.
fn weights(mut shares: Vec<f64>) -> Vec<f64> {
    if shares.len() == 2 { shares.split_off(1) } else { shares }
}

impl Evaluator<'_> {
    /// Returns a node's value.
    pub(super) fn mixed(&self, node: &Json, place: Place) -> Vec<f64> {
        let scalar = |key: &str| self.scalar(&node[key], place);
        let all = |key: &str| list(node, key).iter().map(|source| self.scalar(source, place)).collect::<Vec<_>>();
        match node["type"].as_str().unwrap() {
            "ScreenX" => vec![self.across(point(self.document, place)[0], self.document.width)],
            "ScreenY" => vec![self.across(point(self.document, place)[1], self.document.height)],
            "Constant" => self.document.literal(&node["color"]),
            "Switch" => {
                let which = node["which"].as_u64().unwrap_or(0) as usize;
                self.value(&list(node, "inputs")[which], place)
            }
            "Mix" => {
                let t = scalar("weight");
                sum([(1.0 - t, self.value(&node["a"], place)), (t, self.value(&node["b"], place))])
            }
            "Invert" => vec![1.0 - scalar("weight")],
            "Multiply" => vec![all("weights").into_iter().product()],
            "Screen" => vec![1.0 - all("weights").into_iter().map(|t| 1.0 - t).product::<f64>()],
            "Stack" => weights(stacked(&all("weights"))),
            "Clamp" => {
                let t = self.clamped(scalar("field"), number(node, "min", 0.0), number(node, "max", 1.0));
                let t = if node["smooth"] == true { eased(t) } else { t };
                vec![t.powf(number(node, "power", 1.0))]
            }
            "Bands" => {
                let (x, width) = (scalar("field"), number(node, "width", 0.0));
                let masks: Vec<f64> = list(node, "thresholds")
                    .iter()
                    .rev()
                    .map(|threshold| threshold.as_f64().unwrap())
                    .map(|threshold| self.clamped(x, threshold - width / 2.0, threshold + width / 2.0))
                    .collect();
                weights(stacked(&masks).into_iter().rev().collect())
            }
            "Normalize" => {
                let values: Vec<f64> = all("fields").into_iter().map(|value| value.max(0.0)).collect();
                let total: f64 = values.iter().sum();
                let divisor = total.max(number(node, "floor", 0.001));
                weights(values.iter().map(|value| value / divisor).chain([1.0 - total / divisor]).collect())
            }
            "Blend" => {
                let mut shares = self.value(&node["weights"], place);
                if let [t] = shares[..] {
                    shares = vec![1.0 - t, t];
                }
                sum(shares.into_iter().zip(list(node, "colors").iter().map(|color| self.value(color, place))))
            }
            "Ramp" => self.gradient(node, scalar("weight"), place),
            "Patch" => {
                let (u, v, colors) = (scalar("u"), scalar("v"), list(node, "colors"));
                let bernstein = |t: f64| {
                    let s = 1.0 - t;
                    if colors.len() == 4 {
                        vec![s, t]
                    } else {
                        vec![s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
                    }
                };
                let (across, down) = (bernstein(u), bernstein(v));
                let shares = down.iter().flat_map(|b| across.iter().map(move |a| a * b));
                sum(shares.zip(colors.iter().map(|color| self.value(color, place))))
            }
            "FieldMath" => {
                let inputs = ["a", "b", "c", "d"]
                    .map(|key| if node[key].is_null() { Vec::new() } else { self.value(&node[key], place) });
                formula::value(node["expression"].as_str().unwrap(), &inputs)
            }
            other => panic!("the evaluator does not know {other}"),
        }
    }

    /// (x − ½)/(side − 1), limited to [0, 1]; ½ on a side of one pixel.
    fn across(&self, x: f64, side: i64) -> f64 {
        if side == 1 { 0.5 } else { ((x - 0.5) / (side - 1) as f64).clamp(0.0, 1.0) }
    }

    /// 0 below `min`, 1 from `max` on, linear between.
    fn clamped(&self, x: f64, min: f64, max: f64) -> f64 {
        if max - min < 1e-9 {
            self.threshold(x - max);
        }
        if x >= max {
            1.0
        } else if x >= min {
            (x - min) / (max - min)
        } else {
            0.0
        }
    }

    fn gradient(&self, node: &Json, t: f64, place: Place) -> Vec<f64> {
        let stops = list(node, "stops");
        let at = |index: usize| stops[index]["at"].as_f64().unwrap();
        let color = |index: usize| self.value(&stops[index]["color"], place);
        for index in 0..stops.len() {
            // A step, by its kind or between two stops at one position.
            let is_step = node["interpolation"] == "step" || (index > 0 && at(index) == at(index - 1));
            if is_step {
                self.threshold(t - at(index));
            }
        }
        let Some(last) = (0..stops.len()).rev().find(|index| at(*index) <= t) else { return color(0) };
        if last + 1 == stops.len() || node["interpolation"] == "step" {
            return color(last);
        }
        let u = (t - at(last)) / (at(last + 1) - at(last));
        let u = if node["interpolation"] == "smooth" { eased(u) } else { u };
        sum([(1.0 - u, color(last)), (u, color(last + 1))])
    }
}

/// The weights of layers, the first on top, and the remainder.
fn stacked(masks: &[f64]) -> Vec<f64> {
    let mut left = 1.0;
    let mut weights: Vec<f64> = Vec::new();
    for mask in masks {
        weights.push(mask * left);
        left *= 1.0 - mask;
    }
    weights.push(left);
    weights
}
