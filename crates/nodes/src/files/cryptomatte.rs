//! Cryptomattes: their layers in a file, the manifest in its header, and the IDs of names.

use super::limits;
use std::collections::BTreeMap;
use std::path::Path;
use trochoid_graph::{BadData, FrameContext, ItemName, NodeError, nearest};
use trochoid_io::{ChannelInfo, PartInfo, SampleType};

/// Number of names that a message lists.
const LISTED: usize = 8;

/// A cryptomatte in a file: its layers in the order of ranks, and what the header says of it.
pub(crate) struct Cryptomatte {
    /// Name of its layers without their numbers, such as `Ocean.CryptoObject`.
    pub(crate) name: String,
    pub(crate) ranks: Vec<Rank>,
    header: Header,
}

/// An ID and its coverage, by the channels that hold them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Rank {
    pub(crate) part: usize,
    /// Full names of the channels of the ID and of its coverage.
    pub(crate) channels: [String; 2],
}

/// Attributes of a cryptomatte in the header of a file.
#[derive(Clone, Debug, Default)]
struct Header {
    /// Number of the part that has them.
    part: usize,
    /// Key between the slashes of their names.
    key: String,
    name: String,
    hash: Option<String>,
    conversion: Option<String>,
    manifest: Option<String>,
    manif_file: Option<String>,
}

/// Names that a knob asks for, and the knobs themselves, for messages.
pub(crate) struct Asked<'a> {
    pub(crate) file: ItemName,
    pub(crate) layer: (ItemName, Option<&'a str>),
    pub(crate) names: (ItemName, &'a [String]),
}

/// A layer whose name ends in a number of two digits, by its channels.
struct Numbered<'a> {
    part: usize,
    channels: Vec<&'a ChannelInfo>,
}

impl Cryptomatte {
    /// Finds the cryptomatte that a knob names, or the only one.
    ///
    /// # Errors
    /// The file cannot be read; it has no such cryptomatte, or several; its channels are not those of one.
    pub(crate) fn find(frame: &FrameContext, path: &Path, asked: &Asked<'_>) -> Result<Self, NodeError> {
        let info = trochoid_io::info(path, &limits(frame))?;
        let headers = headers(&info.parts);
        let mut layers = numbered(&info.parts);
        let (knob, wanted) = asked.layer;
        let of_type = |name: &str| headers.iter().find(|header| is_same(&header.name, name));
        let is_one = |name: &str| of_type(name).is_some() || last(name).to_lowercase().starts_with("crypto");
        let known: Vec<&str> = layers.keys().map(String::as_str).filter(|name| is_one(name)).collect();
        let name = match wanted {
            None if known.is_empty() => {
                let expected = "a cryptomatte, such as the layers CryptoObject00 and CryptoObject01";
                let remedy = "let the renderer write one, or name its layers without their numbers in \"layer\"";
                let bad = BadData::new("a file without a cryptomatte", expected, remedy);
                return Err(bad.of_item(asked.file).in_file(path).into());
            }
            None if known.len() == 1 => known[0].to_owned(),
            None => {
                let found = format_args!("{} cryptomattes: {}", known.len(), listed(&known));
                let bad = BadData::new(found, "one", format!("name one of them in \"{knob}\""));
                return Err(bad.of_item(knob).in_file(path).into());
            }
            Some(wanted) => {
                let all: Vec<&str> = layers.keys().map(String::as_str).collect();
                let by = |same: &dyn Fn(&str) -> bool| all.iter().copied().find(|name| same(name));
                let found = by(&|name| name == wanted)
                    .or_else(|| by(&|name| is_same(name, wanted)))
                    .or_else(|| by(&|name| is_same(&name.to_lowercase(), &wanted.to_lowercase())));
                let Some(found) = found else {
                    let expected = match &known[..] {
                        [] => "a layer with the channels of a cryptomatte; the file has none".into(),
                        known => format!("one of {}", listed(known)),
                    };
                    let bad = BadData::new(format_args!("no cryptomatte \"{wanted}\""), expected, "");
                    return Err(bad.of_item(knob).in_file(path).into());
                };
                found.to_owned()
            }
        };
        let header = of_type(&name).cloned().unwrap_or_default();
        let ranks = layers.remove(&name).map(|layers| ranks(path, layers)).transpose()?.unwrap_or_default();
        Ok(Self { name, ranks, header })
    }

    /// Returns the IDs of the names that a knob asks for, in ascending order: those of the manifest, or without one,
    /// those that the specification computes from the names.
    ///
    /// # Errors
    /// The manifest is damaged or lacks a name, or the file says that its IDs are computed otherwise.
    pub(crate) fn ids(&self, path: &Path, asked: &Asked<'_>) -> Result<Vec<u32>, NodeError> {
        let (knob, names) = asked.names;
        let manifest = self.manifest(path)?;
        let mut ids = names
            .iter()
            .map(|name| match &manifest {
                None => Ok(id(name)),
                Some(manifest) => match manifest.get(name.as_str()) {
                    Some(id) => self.parsed(path, name, id),
                    None => {
                        let near = nearest(name, manifest.keys().map(String::as_str));
                        let known: Vec<&str> = manifest.keys().map(String::as_str).collect();
                        let remedy = near.map_or_else(String::new, |near| format!("did you mean \"{near}\"?"));
                        let expected = match &known[..] {
                            [] => "a name of its manifest, which is empty".into(),
                            known => format!("a name of its manifest: {}", listed(known)),
                        };
                        let bad = BadData::new(format_args!("\"{name}\", not in {}", self.name), expected, remedy);
                        Err(bad.of_item(knob).in_file(path).into())
                    }
                },
            })
            .collect::<Result<Vec<u32>, NodeError>>()?;
        ids.sort_unstable();
        ids.dedup();
        Ok(ids)
    }

    /// Returns what users should know of the names, in sentences.
    pub(crate) fn notes(&self) -> Vec<String> {
        if self.header.manifest.is_some() {
            return Vec::new();
        }
        let why = match &self.header.manif_file {
            Some(file) => format!("has its manifest in another file, \"{file}\", which is not read"),
            None => "has no manifest".into(),
        };
        vec![format!(
            "{} {why}: IDs are computed from the names, so that a misspelled name is an empty mask.",
            self.name
        )]
    }

    /// Returns the manifest, if the header has one: names, and IDs as they are written.
    fn manifest(&self, path: &Path) -> Result<Option<BTreeMap<String, String>>, NodeError> {
        for (field, found, expected) in
            [("hash", &self.header.hash, HASH), ("conversion", &self.header.conversion, CONVERSION)]
        {
            if let Some(found) = found.as_deref().filter(|found| *found != expected) {
                return Err(self.fault(path, field, format!("\"{found}\""), format!("\"{expected}\"")));
            }
        }
        let Some(text) = &self.header.manifest else { return Ok(None) };
        let manifest = serde_json::from_str(text).map_err(|error| {
            let expected = "a JSON object of names and IDs, such as {\"hull\":\"a65b7927\"}";
            self.fault(path, "manifest", format!("a manifest that cannot be read: {error}"), expected.into())
        })?;
        Ok(Some(manifest))
    }

    /// Returns the ID that a manifest states for a name.
    fn parsed(&self, path: &Path, name: &str, id: &str) -> Result<u32, NodeError> {
        let digits = id.len() == 8 && id.bytes().all(|digit| digit.is_ascii_hexdigit());
        u32::from_str_radix(id, 16).ok().filter(|_| digits).ok_or_else(|| {
            let expected = "8 hexadecimal digits".into();
            self.fault(path, "manifest", format!("the ID \"{id}\" of \"{name}\""), expected)
        })
    }

    fn fault(&self, path: &Path, field: &str, found: String, expected: String) -> NodeError {
        let attribute = format!("attribute cryptomatte/{}/{field}: {found}", self.header.key);
        let remedy = "let the renderer write the file again";
        BadData::new(attribute, expected, remedy).in_file(path).in_part(self.header.part).into()
    }
}

/// The only hash of names, and the only conversion of hashes to samples, that the specification has.
const HASH: &str = "MurmurHash3_32";
const CONVERSION: &str = "uint32_to_float32";

/// Returns the attributes of all cryptomattes of a file: those named `cryptomatte/KEY/FIELD`.
fn headers(parts: &[PartInfo]) -> Vec<Header> {
    let mut found: BTreeMap<(usize, &str), Header> = BTreeMap::new();
    for (part, info) in parts.iter().enumerate() {
        for (name, value) in &info.attributes {
            let Some((key, field)) = name.strip_prefix("cryptomatte/").and_then(|rest| rest.split_once('/')) else {
                continue;
            };
            let header = found.entry((part, key)).or_default();
            (header.part, header.key) = (part, key.into());
            let value = value.clone();
            match field {
                "name" => header.name = value,
                "hash" => header.hash = Some(value),
                "conversion" => header.conversion = Some(value),
                "manifest" => header.manifest = Some(value),
                "manif_file" => header.manif_file = Some(value),
                _ => {}
            }
        }
    }
    found.into_values().filter(|header| !header.name.is_empty()).collect()
}

/// Returns the layers whose names end in two digits, by the name before them and by number.
fn numbered(parts: &[PartInfo]) -> BTreeMap<String, BTreeMap<u8, Numbered<'_>>> {
    let mut found: BTreeMap<String, BTreeMap<u8, Numbered<'_>>> = BTreeMap::new();
    for (part, info) in parts.iter().enumerate() {
        for channel in &info.channels {
            let Some((name, number)) = channel.layer.split_at_checked(channel.layer.len().saturating_sub(2)) else {
                continue;
            };
            if name.is_empty() || !number.bytes().all(|digit| digit.is_ascii_digit()) {
                continue;
            }
            let Ok(number) = number.parse() else { continue };
            let layer = found.entry(name.into()).or_default().entry(number);
            let layer = layer.or_insert_with(|| Numbered { part, channels: Vec::new() });
            if layer.part == part {
                layer.channels.push(channel);
            }
        }
    }
    found
}

/// Returns the ranks in numbered layers: an ID in red with its coverage in green, and one in blue with alpha.
fn ranks(path: &Path, layers: BTreeMap<u8, Numbered<'_>>) -> Result<Vec<Rank>, NodeError> {
    let mut ranks = Vec::new();
    for Numbered { part, channels } in layers.into_values() {
        let find = |base: &str| channels.iter().find(|channel| channel.base.eq_ignore_ascii_case(base));
        let fault = |channel: &ChannelInfo, found: &str, expected: &str| -> NodeError {
            let remedy = "let the renderer write the file again, with 32-bit floats and all channels";
            let bad = BadData::new(found, expected, remedy);
            bad.in_file(path).in_part(part).in_channel(&*channel.full_name).into()
        };
        for [id, coverage] in [["r", "g"], ["b", "a"]] {
            let (id, coverage) = match (find(id), find(coverage)) {
                (None, None) => continue,
                (Some(id), Some(coverage)) => (id, coverage),
                (Some(id), None) => {
                    return Err(fault(id, "IDs without coverages", "a channel beside it that holds them"));
                }
                (None, Some(other)) => {
                    return Err(fault(other, "coverages without IDs", "a channel beside it that holds them"));
                }
            };
            if id.sample_type != SampleType::Float {
                let found = format!("IDs as {}", id.sample_type);
                return Err(fault(id, &found, "32-bit floats, because other types change IDs"));
            }
            ranks.push(Rank { part, channels: [id, coverage].map(|channel| channel.full_name.clone()) });
        }
    }
    Ok(ranks)
}

/// Whether two names of layers are the same, but for layers around one of them: `Ocean.CryptoObject`, `CryptoObject`.
fn is_same(a: &str, b: &str) -> bool {
    let ends = |long: &str, short: &str| long.strip_suffix(short).is_some_and(|rest| rest.ends_with('.'));
    a == b || (!a.is_empty() && !b.is_empty() && (ends(a, b) || ends(b, a)))
}

/// Returns the last component of a layer's name.
fn last(name: &str) -> &str {
    name.rsplit('.').next().unwrap_or(name)
}

fn listed(names: &[&str]) -> String {
    let mut listed: Vec<String> = names.iter().take(LISTED).map(|name| format!("\"{name}\"")).collect();
    if names.len() > LISTED {
        listed.push(format!("{} more", names.len() - LISTED));
    }
    listed.join(", ")
}

/// Returns the bits of the sample that stands for a name: its hash, with an exponent that is neither that of NaN and
/// infinity nor that of 0, which programs may change.
pub(crate) fn id(name: &str) -> u32 {
    const MANTISSA: u32 = (1 << 23) - 1;
    let hash = murmur3(name.as_bytes());
    let exponent = ((hash >> 23) & 0xff).clamp(1, 254);
    (hash & (1 << 31)) | (exponent << 23) | (hash & MANTISSA)
}

/// Returns the hash MurmurHash3_x86_32 of bytes, with the seed 0.
fn murmur3(bytes: &[u8]) -> u32 {
    let scrambled = |word: u32| word.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let words = bytes.chunks_exact(4);
    let rest = words.remainder();
    let mut hash = words.fold(0_u32, |hash, word| {
        let word = u32::from_le_bytes([word[0], word[1], word[2], word[3]]);
        (hash ^ scrambled(word)).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    let tail = rest.iter().rev().fold(0, |tail, byte| (tail << 8) | u32::from(*byte));
    hash ^= scrambled(tail);
    hash ^= bytes.len() as u32;
    hash = (hash ^ (hash >> 16)).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ (hash >> 13)).wrapping_mul(0xc2b2_ae35);
    hash ^ (hash >> 16)
}
