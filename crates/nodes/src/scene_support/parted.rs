//! What models say of figures that they refuse, in the parts that a diagnostic has.

use trochoid_graph::Item;

/// A refusal: the knob, where it names one; what was found and expected, and what to do.
pub(crate) struct Parted {
    pub(crate) item: Option<&'static str>,
    pub(crate) found: String,
    pub(crate) expected: String,
    pub(crate) remedy: String,
}

/// Parts "FIGURE VALUE; expected RANGE; REMEDY".
pub(crate) fn parted(error: &str, items: &'static [Item]) -> Parted {
    let (found, rest) = error.split_once("; expected ").unwrap_or((error, "another value"));
    let (expected, remedy) = rest.split_once("; ").unwrap_or((rest, "change it"));
    let name = found.split([' ', ',']).next().unwrap_or_default();
    let item = items.iter().map(Item::name).find(|known| *known == name);
    Parted { item, found: found.into(), expected: expected.into(), remedy: remedy.into() }
}
