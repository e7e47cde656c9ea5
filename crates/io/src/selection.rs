use std::path::Path;

use crate::error::printable;
use crate::{ChannelInfo, Entry, Error, PartInfo, names};

/// Part of a file, selected by its number from 0 or by its name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PartName {
    /// Number of the part, from 0.
    Index(usize),
    /// Name of the part; if no part has this name and it is a number, the number of the part.
    Name(String),
}

impl From<usize> for PartName {
    fn from(index: usize) -> Self {
        Self::Index(index)
    }
}

impl From<&str> for PartName {
    fn from(name: &str) -> Self {
        Self::Name(name.into())
    }
}

/// Selection of a part, a layer and channels of a file; the default is the main picture of the file.
///
/// - `layer` is a full layer name (`Ocean.Combined`), one without its first components (`Combined`), or the name of a
///   part. Without it, the unnamed layer is selected, else the only one, else the one named rgba, beauty, combined or
///   composite.
/// - `channels` are base names of that layer (`R`, ignoring case if only one matches) or full names
///   (`Ocean.Combined.R`). Without them, all channels of the layer are selected.
///
/// ```
/// use trochoid_io::Selection;
/// let normals = Selection::layer("Normal").with_channels(["X", "Y", "Z"]);
/// let second = Selection::default().with_part(1);
/// assert_ne!(normals, second);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Part; any if absent.
    pub part: Option<PartName>,
    /// Name of the layer; the main layer if absent.
    pub layer: Option<String>,
    /// Names of the channels, in the requested order; all channels of the layer if absent.
    pub channels: Vec<String>,
}

impl Selection {
    /// Selects all channels of a layer.
    pub fn layer(name: impl Into<String>) -> Self {
        Self { layer: Some(name.into()), ..Self::default() }
    }

    /// Selects channels by base or full name, in this order.
    pub fn channels<N: Into<String>>(names: impl IntoIterator<Item = N>) -> Self {
        Self::default().with_channels(names)
    }

    /// Restricts the selection to this part.
    #[must_use]
    pub fn with_part(self, part: impl Into<PartName>) -> Self {
        Self { part: Some(part.into()), ..self }
    }

    /// Restricts the selection to these channels.
    #[must_use]
    pub fn with_channels<N: Into<String>>(self, names: impl IntoIterator<Item = N>) -> Self {
        Self { channels: names.into_iter().map(Into::into).collect(), ..self }
    }

    /// Finds the part and its channels.
    pub(crate) fn resolve(&self, path: &Path, parts: &[PartInfo]) -> Result<Resolved, Error> {
        let found = Resolver { path, parts, allowed: self.part_range(path, parts)? };
        if self.channels.is_empty() {
            let (part, layer) = found.layer(self.layer.as_deref())?;
            let mut channels = found.channels_of(part, layer);
            names::sort(&mut channels, &parts[part].channels);
            return Ok(Resolved { part, channels });
        }
        // Full names need no layer, so they work in files without a main layer.
        let layer = match &self.layer {
            Some(name) => Some(found.layer(Some(name))?),
            None => found.layer(None).ok(),
        };
        let chosen: Vec<(usize, usize)> = self
            .channels
            .iter()
            .map(|name| found.channel(name, layer, self.layer.is_some()))
            .collect::<Result<_, _>>()?;
        let part = chosen[0].0;
        if let Some(&(other, _)) = chosen.iter().find(|(other, _)| *other != part) {
            return Err(Error::Ambiguous {
                path: path.into(),
                what: format!("the selection {:?}", self.channels),
                existing: vec![parts[part].place(part), parts[other].place(other)],
                remedy: "a single read covers the channels of one part; read the others separately",
            });
        }
        Ok(Resolved { part, channels: chosen.into_iter().map(|(_, channel)| channel).collect() })
    }

    fn part_range(&self, path: &Path, parts: &[PartInfo]) -> Result<std::ops::Range<usize>, Error> {
        let index = match &self.part {
            None => return Ok(0..parts.len()),
            Some(PartName::Index(index)) => Some(*index),
            Some(PartName::Name(name)) => {
                let by = |same: &dyn Fn(&str) -> bool| parts.iter().position(|p| p.name.as_deref().is_some_and(same));
                by(&|other| other == name)
                    .or_else(|| by(&|other| other.eq_ignore_ascii_case(name)))
                    .or_else(|| name.parse().ok())
            }
        };
        match index {
            Some(index) if index < parts.len() => Ok(index..index + 1),
            _ => {
                let wanted = match &self.part {
                    Some(PartName::Name(name)) => name.clone(),
                    _ => index.unwrap_or_default().to_string(),
                };
                let known = parts.iter().enumerate().map(|(i, p)| p.name.clone().unwrap_or_else(|| i.to_string()));
                Err(not_found(path, Entry::Part, &wanted, String::new(), known.collect()))
            }
        }
    }
}

/// Part and indices of its channels in the requested order, at least one.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Resolved {
    pub(crate) part: usize,
    pub(crate) channels: Vec<usize>,
}

struct Resolver<'a> {
    path: &'a Path,
    parts: &'a [PartInfo],
    allowed: std::ops::Range<usize>,
}

impl<'a> Resolver<'a> {
    /// Returns the part and the canonical name of the requested layer.
    fn layer(&self, wanted: Option<&str>) -> Result<(usize, &'a str), Error> {
        let Some(wanted) = wanted else {
            let first = self.allowed.start;
            return self.main_layer(first).map(|layer| (first, layer));
        };
        if let Some(found) = self.fitting(wanted, |text| text.into())? {
            return Ok(found);
        }
        if let Some(found) = self.fitting(&wanted.to_lowercase(), str::to_lowercase)? {
            return Ok(found);
        }
        let known = self.layers().map(|(_, layer)| layer.to_string()).filter(|layer| !layer.is_empty());
        let parts = self.allowed.clone().filter_map(|part| self.parts[part].name.clone());
        Err(not_found(self.path, Entry::Layer, wanted, self.place(), known.chain(parts).collect()))
    }

    /// Returns the layer that matches best; names are compared after `fold`.
    fn fitting(&self, wanted: &str, fold: impl Fn(&str) -> String) -> Result<Option<(usize, &'a str)>, Error> {
        let mut best: Vec<(usize, &'a str)> = Vec::new();
        let mut best_fit = u8::MAX;
        for (part, layer) in self.layers() {
            let name = self.parts[part].name.as_deref().map(&fold);
            let Some(fit) = names::fit(wanted, name.as_deref(), &fold(layer)) else { continue };
            if fit < best_fit {
                best.clear();
                best_fit = fit;
            }
            if fit == best_fit {
                best.push((part, layer));
            }
        }
        // A part with this name has priority over layers that only end with it.
        if best_fit >= 2 {
            let named = |part: &usize| self.parts[*part].name.as_deref().is_some_and(|name| fold(name) == wanted);
            if let Some(part) = self.allowed.clone().find(named) {
                return self.main_layer(part).map(|layer| Some((part, layer)));
            }
        }
        match best[..] {
            [] => Ok(None),
            [only] => Ok(Some(only)),
            _ => Err(Error::Ambiguous {
                path: self.path.into(),
                what: format!("layer \"{wanted}\""),
                existing: best
                    .iter()
                    .map(|&(part, layer)| format!("{} of {}", printable(layer), self.parts[part].place(part)))
                    .collect(),
                remedy: "give the full layer name, or the part as well",
            }),
        }
    }

    /// Returns the main layer of a part, for selections without a layer.
    fn main_layer(&self, part: usize) -> Result<&'a str, Error> {
        let layers = &self.parts[part].layers;
        if let Some(unnamed) = layers.iter().find(|layer| layer.is_empty()) {
            return Ok(unnamed);
        }
        if let [only] = &layers[..] {
            return Ok(only);
        }
        let main = |layer: &&String| {
            let tail = layer.rsplit('.').next().unwrap_or(layer).to_ascii_lowercase();
            ["rgba", "beauty", "combined", "composite"].contains(&tail.as_str())
        };
        let mut mains = layers.iter().filter(main);
        match (mains.next(), mains.next()) {
            (Some(only), None) => Ok(only),
            _ => Err(Error::Ambiguous {
                path: self.path.into(),
                what: format!("{} without a layer", self.parts[part].place(part)),
                existing: layers.iter().map(|layer| printable(layer)).collect(),
                remedy: "name the layer",
            }),
        }
    }

    /// Returns the part and the index of a requested channel. If the selection names a layer, a base name refers only
    /// to channels of that layer.
    fn channel(&self, wanted: &str, layer: Option<(usize, &str)>, named: bool) -> Result<(usize, usize), Error> {
        type Name = fn(&ChannelInfo) -> &str;
        let base: Name = |channel| &channel.base;
        let full: Name = |channel| &channel.full_name;
        let in_layer: Vec<(usize, usize)> = layer
            .map(|(part, layer)| self.channels_of(part, layer).into_iter().map(|index| (part, index)).collect())
            .unwrap_or_default();
        let elsewhere = self.allowed.clone().filter(|_| !named || wanted.contains('.'));
        let everywhere: Vec<(usize, usize)> =
            elsewhere.flat_map(|part| (0..self.parts[part].channels.len()).map(move |index| (part, index))).collect();
        for (candidates, name) in [(&in_layer, base), (&in_layer, full), (&everywhere, full)] {
            let info = |&(part, index): &(usize, usize)| name(&self.parts[part].channels[index]);
            let same = |fold: bool| {
                let fits = |at: &&(usize, usize)| {
                    if fold { info(at).eq_ignore_ascii_case(wanted) } else { info(at) == wanted }
                };
                candidates.iter().filter(fits).copied().collect::<Vec<_>>()
            };
            for fold in [false, true] {
                match same(fold)[..] {
                    [] => {}
                    [only] => return Ok(only),
                    ref several => {
                        return Err(Error::Ambiguous {
                            path: self.path.into(),
                            what: format!("channel \"{wanted}\""),
                            existing: several
                                .iter()
                                .map(|&(part, index)| {
                                    let channel = &self.parts[part].channels[index].full_name;
                                    format!("{} of {}", printable(channel), self.parts[part].place(part))
                                })
                                .collect(),
                            remedy: "give its exact name, and the part as well",
                        });
                    }
                }
            }
        }
        let (place, known) = match layer {
            Some((_, layer)) if !in_layer.is_empty() && !wanted.contains('.') => {
                let bases = in_layer.iter().map(|&(part, index)| self.parts[part].channels[index].base.clone());
                (if layer.is_empty() { self.place() } else { format!("layer \"{layer}\"") }, bases.collect())
            }
            _ => {
                let all = everywhere.iter().map(|&(part, index)| self.parts[part].channels[index].full_name.clone());
                (self.place(), all.collect())
            }
        };
        Err(not_found(self.path, Entry::Channel, wanted, place, known))
    }

    fn layers(&self) -> impl Iterator<Item = (usize, &'a str)> {
        let parts = self.parts;
        self.allowed.clone().flat_map(move |part| parts[part].layers.iter().map(move |layer| (part, layer.as_str())))
    }

    fn channels_of(&self, part: usize, layer: &str) -> Vec<usize> {
        let channels = self.parts[part].channels.iter().enumerate();
        channels.filter(|(_, channel)| channel.layer == layer).map(|(index, _)| index).collect()
    }

    fn place(&self) -> String {
        if self.allowed.len() == 1 && self.parts.len() > 1 {
            self.parts[self.allowed.start].place(self.allowed.start)
        } else {
            String::new()
        }
    }
}

fn not_found(path: &Path, kind: Entry, wanted: &str, place: String, known: Vec<String>) -> Error {
    let existing = names::nearest(wanted, known).iter().map(|name| printable(name)).collect();
    Error::NotFound { path: path.into(), kind, name: printable(wanted), place, existing }
}

#[cfg(test)]
#[path = "selection_tests.rs"]
mod tests;
