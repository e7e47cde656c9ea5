//! What the file of a whole picture says, by what its tiles say.

use super::{JoinError, Tile};
use crate::recipe::RecipeInfo;
use crate::resume::{FINGERPRINT, GUARANTEE, HELD, WHOLE};
use std::path::Path;
use trochoid_graph::Guarantee;

/// Keys that only tiles have.
const OF_TILES: [&str; 3] = [WHOLE, crate::stream::RESERVED, super::REGION];

/// Returns the metadata of the whole picture: those that all tiles share, with the fingerprint of the whole, the sum of
/// the pixels outside of the hull, and the weakest guarantee that was found.
pub(super) fn merged(tiles: &[Tile]) -> Result<Vec<(String, String)>, JoinError> {
    let mut whole: Vec<(String, String)> = own(&tiles[0]).cloned().collect();
    if let Some(entry) = whole.iter_mut().find(|(key, _)| key == FINGERPRINT) {
        entry.1 = fingerprint(&tiles[0])?.into();
    }
    for tile in &tiles[1..] {
        let there: Vec<&(String, String)> = own(tile).collect();
        let keys = |entries: &mut dyn Iterator<Item = &String>| entries.cloned().collect::<Vec<_>>().join(", ");
        let [found, expected] =
            [keys(&mut there.iter().map(|(key, _)| key)), keys(&mut whole.iter().map(|(key, _)| key))];
        if found != expected {
            return Err(tile.fault(format!("metadata {found}"), format!("those of {}, {expected}", name(&tiles[0]))));
        }
        for ((key, value), (_, other)) in whole.iter_mut().zip(there) {
            let other = if key == FINGERPRINT { fingerprint(tile)? } else { other };
            let joined = match key.as_str() {
                GUARANTEE => counted(value, other),
                HELD => Some(weaker(value, other)),
                key if key == crate::recipe::KEY => recipe(&tile.path, value, other),
                _ => (value == other).then(|| other.into()),
            };
            *value = joined.ok_or_else(|| {
                tile.fault(format!("{key} \"{other}\""), format!("\"{value}\", as in {}", name(&tiles[0])))
            })?;
        }
    }
    Ok(whole)
}

fn name(tile: &Tile) -> String {
    tile.path.display().to_string()
}

fn own(tile: &Tile) -> impl Iterator<Item = &(String, String)> {
    tile.metadata.iter().filter(|(key, _)| !OF_TILES.contains(&key.as_str()))
}

/// Returns the fingerprint of the whole picture.
fn fingerprint(tile: &Tile) -> Result<&str, JoinError> {
    tile.entry(WHOLE).ok_or_else(|| tile.fault("a picture that is no tile", "one of `trochoid render --region`"))
}

/// Adds the counts of texts such as `beauty: hull, 0 outside; mask: box, 3 outside`.
fn counted(a: &str, b: &str) -> Option<String> {
    if a == b && !a.contains(", ") {
        return Some(a.into());
    }
    let of = |text: &str| -> Option<Vec<(String, u64)>> {
        let each = text.split("; ").map(|output| {
            let (what, count) = output.strip_suffix(" outside")?.rsplit_once(", ")?;
            Some((what.to_owned(), count.parse().ok()?))
        });
        each.collect()
    };
    let (a, b) = (of(a)?, of(b)?);
    let same = a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| a.0 == b.0);
    let sums = a.iter().zip(&b).map(|((what, a), (_, b))| format!("{what}, {} outside", a + b));
    same.then(|| sums.collect::<Vec<_>>().join("; "))
}

fn weaker(a: &str, b: &str) -> String {
    if Guarantee::from_name(a) <= Guarantee::from_name(b) { a.into() } else { b.into() }
}

/// Returns the description of a recipe with the larger effects of rounding.
fn recipe(path: &Path, a: &str, b: &str) -> Option<String> {
    let read = |text: &str| RecipeInfo::read(path, &[(crate::recipe::KEY.into(), text.into())]).ok();
    let ((info, a), (other, b)) = (read(a)?, read(b)?);
    (info == other).then(|| info.metadata(a.max(b)).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_added_and_the_weakest_guarantee_stays() {
        let joined = counted("a: hull, 2 outside; b, c: box, 0 outside", "a: hull, 3 outside; b, c: box, 1 outside");
        assert_eq!(joined.as_deref(), Some("a: hull, 5 outside; b, c: box, 1 outside"));
        assert_eq!(counted("", "").as_deref(), Some(""));
        assert_eq!(counted("a: hull, 2 outside", "a: box, 2 outside"), None);
        assert_eq!(counted("a: hull, 2 outside", "a: hull, two outside"), None);
        assert_eq!([weaker("hull", "none"), weaker("box", "hull")], ["none", "box"]);
    }
}
