//! Pictures of outputs as a screen shows them, evaluated at their own size.

use crate::failure::{FAILED, Failure};
use crate::interrupt;
use crate::progress::Progress;
use trochoid::{
    Buffers, Cache, CheckedGraph, EvalError, Kind, MemoryConsumer, OutputSpec, Picture, Pictures, Plan, Settings,
};

/// A picture that can be shown.
pub(crate) struct Shown {
    /// Red, green and blue: encoded for display, or the values of a Field.
    channels: [Vec<f32>; 3],
    /// Smallest and largest finite value of a Field.
    range: Option<[f32; 2]>,
}

impl Shown {
    /// Returns the values from black to white, if they depend on the picture.
    pub(crate) fn range(&self) -> Option<[f32; 2]> {
        self.range
    }

    /// Returns the picture with these values of a Field as black and white.
    pub(crate) fn within(&self, range: Option<[f32; 2]>) -> [Vec<f32>; 3] {
        match range {
            None => self.channels.clone(),
            // All values are the same.
            Some([low, high]) if low >= high => self.channels.each_ref().map(|channel| vec![0.5; channel.len()]),
            Some([low, high]) => {
                let gain = 1.0 / (f64::from(high) - f64::from(low));
                let shown = |value: &f32| ((f64::from(*value) - f64::from(low)) * gain) as f32;
                self.channels.each_ref().map(|channel| channel.iter().map(shown).collect())
            }
        }
    }
}

/// Returns interleaved R, G and B of 8 bits each.
pub(crate) fn bytes([r, g, b]: &[Vec<f32>; 3]) -> Vec<u8> {
    let pixels = r.iter().zip(g).zip(b).flat_map(|((r, g), b)| [*r, *g, *b]);
    pixels.map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8).collect()
}

/// Returns the union of two ranges.
pub(crate) fn joined(a: Option<[f32; 2]>, b: Option<[f32; 2]>) -> Option<[f32; 2]> {
    match (a, b) {
        (Some([a, b]), Some([c, d])) => Some([a.min(c), b.max(d)]),
        (a, b) => a.or(b),
    }
}

/// Says which values of a Field are black and white, after a comma.
pub(crate) fn told(range: Option<[f32; 2]>) -> String {
    match range {
        Some([low, high]) if low >= high => format!(", all values {low}"),
        Some([low, high]) => format!(", from {low} (black) to {high} (white)"),
        None => String::new(),
    }
}

/// Returns why an output cannot be shown.
pub(crate) fn refused(spec: &OutputSpec) -> Option<Failure> {
    if !spec.is_recipe && matches!(spec.kind, Kind::Color | Kind::Weights(2) | Kind::Field(_)) {
        return None;
    }
    let kind = if spec.is_recipe { "recipe".into() } else { spec.kind.to_string() };
    let message = format!("output \"{}\" is a {kind}; expected a Color, a mask or a Field", spec.name);
    Some(Failure::usage(message, "choose another with --output or --view, or write it as EXR: trochoid render"))
}

/// Evaluates an output of a graph at a frame.
///
/// # Errors
/// The frame takes too much memory, cannot be evaluated, or the user has interrupted.
pub(crate) fn show(
    graph: &CheckedGraph,
    output: usize,
    frame: i64,
    cache: &mut Cache,
    progress: &Progress,
) -> Result<Shown, Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::new(FAILED, format!("frame {frame}: {error}"));
    if interrupt::asked() {
        return Err(Failure::interrupted());
    }
    let name = graph.outputs()[output].name.as_str();
    let plan = Plan::new(graph, &[name], frame, &[], &Settings::default()).map_err(|error| failed(&error))?;
    let account = plan.memory(Pictures::Files);
    plan.check_memory(&account).map_err(|mut error| {
        if let EvalError::TooMuchMemory { remedy, .. } = &mut error
            && let Some((MemoryConsumer::Pictures | MemoryConsumer::Writing, ..)) = account.consumers.first()
        {
            // The remedy of writing EXR does not apply to what is shown.
            *remedy = "make a smaller picture";
        }
        Failure::evaluated(&format!("frame {frame}: "), &error)
    })?;
    let evaluated = plan.evaluate(&Buffers::new(), cache, progress).map_err(|error| match error {
        EvalError::Cancelled => Failure::interrupted(),
        error => Failure::evaluated(&format!("frame {frame}: "), &error),
    })?;
    let picture = evaluated.pictures.first().ok_or_else(|| failed(&"no picture was made"))?;
    cache.forget_unused();
    Ok(shown(graph, picture))
}

fn shown(graph: &CheckedGraph, picture: &Picture) -> Shown {
    let planes: Vec<&[f32]> = picture.planes.iter().map(trochoid::Plane::samples).collect();
    if let (Kind::Color, [r, g, b]) = (picture.kind, &planes[..]) {
        let mut channels: [Vec<f32>; 3] = Default::default();
        for ((r, g), b) in r.iter().zip(*g).zip(*b) {
            let color = graph.space().to_display([*r, *g, *b].map(f64::from));
            channels.iter_mut().zip(color).for_each(|(channel, value)| channel.push(value as f32));
        }
        return Shown { channels, range: None };
    }
    // Two components are red and green.
    let count = planes.len().min(3);
    let pixels = planes.first().map_or(0, |plane| plane.len());
    let channels = [0, 1, 2].map(|channel| match count {
        1 => planes[0].to_vec(),
        count if channel < count => planes[channel].to_vec(),
        _ => vec![0.0; pixels],
    });
    let values = planes.iter().take(count).flat_map(|plane| plane.iter()).filter(|value| value.is_finite());
    let ends = values.fold(None, |ends: Option<[f32; 2]>, value| joined(ends, Some([*value; 2])));
    let range = if matches!(picture.kind, Kind::Field(_)) { Some(ends.unwrap_or([0.0, 1.0])) } else { None };
    Shown { channels, range }
}
