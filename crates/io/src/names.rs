//! Layers derived from channel names, for the conventions of different writers.
//!
//! Blender up to 4 keeps all layers in one unnamed part (`ViewLayer.Combined.R`); Blender 5 writes a part for every
//! layer and repeats its name in the channels (part `Ocean.Combined`, channel `Ocean.Combined.R`); others write parts
//! with bare channels (part `depth`, channel `Z`). All are split into a layer name and a base name.

use crate::{ChannelInfo, PartInfo};

/// Splits a channel's name at its last dot into layer and base; the layer may be empty.
pub(crate) fn split(full_name: &str) -> (&str, &str) {
    match full_name.rsplit_once('.') {
        Some((layer, base)) if !layer.is_empty() && !base.is_empty() => (layer, base),
        _ => ("", full_name),
    }
}

/// Fills in every channel's layer and base, and every part's list of layers.
pub(crate) fn resolve(parts: &mut [PartInfo]) {
    let several = parts.len() > 1;
    for part in parts {
        for channel in &mut part.channels {
            let (layer, base) = split(&channel.full_name);
            channel.base = base.into();
            channel.layer = match &part.name {
                Some(name) if layer.is_empty() && several => name.clone(),
                _ => layer.into(),
            };
        }
        part.layers = part.channels.iter().map(|channel| channel.layer.clone()).collect();
        // Channels are sorted by name, but layer `a` may come between channels of layer `""`.
        let mut seen = std::collections::HashSet::new();
        part.layers.retain(|layer| seen.insert(layer.clone()));
    }
}

/// Sorts channels for callers: R, G, B or luminance Y, then alpha; x, y, z, w; then the order of the file.
pub(crate) fn sort(indices: &mut [usize], channels: &[ChannelInfo]) {
    let base = |index: usize| channels[index].base.to_ascii_lowercase();
    let vector = indices.iter().any(|&index| base(index) == "x");
    let order = if vector { "rgbaxyzw" } else { "rgbyazw" };
    indices.sort_by_key(|&index| {
        let base = base(index);
        if base.chars().count() == 1 { order.find(&base).unwrap_or(order.len()) } else { order.len() }
    });
}

/// Returns how well `name` matches a layer: 0 is best, `None` is no match.
///
/// In order: the layer's full name; its name without the part's, or with it; its last components, such as `Combined`
/// of `Ocean.Combined`. The name of the part itself is left to the caller, since a part may have many layers.
pub(crate) fn fit(name: &str, part: Option<&str>, layer: &str) -> Option<u8> {
    if name == layer {
        return Some(0);
    }
    if let Some(part) = part {
        let without =
            |long: &str, short: &str| long.strip_prefix(part).and_then(|s| s.strip_prefix('.')) == Some(short);
        if without(layer, name) || without(name, layer) {
            return Some(1);
        }
    }
    let tail = layer.strip_suffix(name).is_some_and(|rest| rest.ends_with('.'));
    (tail && !name.is_empty()).then_some(2)
}

/// Returns names sorted by similarity to `wanted`, most similar first.
pub(crate) fn nearest(wanted: &str, mut names: Vec<String>) -> Vec<String> {
    names.sort_unstable();
    names.dedup();
    let wanted = wanted.to_lowercase();
    names.sort_by_cached_key(|name| {
        let name = name.to_lowercase();
        // `Dept` may mean `Ocean.Depth` as well as `Death`.
        distance(&wanted, &name).min(distance(&wanted, name.rsplit('.').next().unwrap_or(&name)))
    });
    names
}

/// Returns the number of insertions, deletions and substitutions between two names (Levenshtein), of their first
/// characters only.
fn distance(a: &str, b: &str) -> usize {
    const LENGTH: usize = 64;
    let b: Vec<char> = b.chars().take(LENGTH).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().take(LENGTH).enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &y) in b.iter().enumerate() {
            let changed = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_split_at_the_last_dot() {
        assert_eq!(split("ViewLayer.Combined.R"), ("ViewLayer.Combined", "R"));
        assert_eq!(split("Ocean.Diffuse Direct.B"), ("Ocean.Diffuse Direct", "B"));
        assert_eq!(split("Z"), ("", "Z"));
        assert_eq!(split(".R"), ("", ".R"));
        assert_eq!(split("R."), ("", "R."));
    }

    #[test]
    fn full_names_fit_before_tails() {
        assert_eq!(fit("Combined", None, "Combined"), Some(0));
        assert_eq!(fit("Combined", Some("Ocean"), "Ocean.Combined"), Some(1));
        assert_eq!(fit("Ocean.Combined", Some("Ocean"), "Combined"), Some(1));
        assert_eq!(fit("Combined", None, "Ocean.Combined"), Some(2));
        assert_eq!(fit("bined", None, "Ocean.Combined"), None);
        assert_eq!(fit("", None, "Ocean."), None);
    }

    #[test]
    fn the_nearest_name_comes_first() {
        let names = ["depth", "beauty", "Normal"].map(String::from).to_vec();
        assert_eq!(nearest("normals", names)[0], "Normal");
        let names = ["Ocean.UV", "Ocean.Combined", "Ocean.Depth"].map(String::from).to_vec();
        assert_eq!(nearest("Dept", names)[0], "Ocean.Depth");
        assert_eq!(distance("kitten", "sitting"), 3);
    }
}
