//! Single changes of certificates: none passes with its digest, and few pass with a digest made to fit.

use super::*;
use crate::certificate::level::BoundMap;
use crate::certificate::map::PixelMap;

/// Collects all single changes of a JSON value: of numbers, texts, Booleans, items and fields.
fn mutations(value: &Value, place: &str, all: &mut Vec<(String, Value)>) {
    let mut other = |value: Value| all.push((place.to_string(), value));
    match value {
        Value::Null => other(1.into()),
        Value::Bool(is) => other((!is).into()),
        Value::Number(number) => {
            let number = number.as_f64().expect("a number");
            other(if number == number.trunc() && number.abs() < 1e15 {
                (number as i64 + 1).into()
            } else {
                (number * 1.001).into()
            });
            other(Value::Null);
        }
        Value::String(text) => {
            let last = if text.ends_with('0') { "1" } else { "0" };
            let kept = text.char_indices().next_back().map_or("", |(at, _)| &text[..at]);
            other(format!("{kept}{last}").into());
        }
        Value::Array(items) => {
            let with = |change: &dyn Fn(&mut Vec<Value>)| {
                let mut items = items.clone();
                change(&mut items);
                Value::Array(items)
            };
            other(with(&|items| items.push(items.first().cloned().unwrap_or(0.into()))));
            if !items.is_empty() {
                other(with(&|items| drop(items.remove(0))));
            }
            for (index, item) in items.iter().enumerate() {
                let mut own = Vec::new();
                mutations(item, &format!("{place}[]"), &mut own);
                all.extend(own.into_iter().map(|(at, item)| (at, with(&|items| items[index] = item.clone()))));
            }
        }
        Value::Object(fields) => {
            let mut more = fields.clone();
            more.insert("more".into(), 1.into());
            other(Value::Object(more));
            for (name, value) in fields {
                let mut fewer = fields.clone();
                fewer.remove(name);
                all.push((format!("{place}.{name}"), Value::Object(fewer)));
                let mut own = Vec::new();
                mutations(value, &format!("{place}.{name}"), &mut own);
                for (at, value) in own {
                    let mut fields = fields.clone();
                    fields.insert(name.clone(), value);
                    all.push((at, Value::Object(fields)));
                }
            }
        }
    }
}

/// Returns all single changes of a certificate, as places and texts.
fn changed(certificate: &Path) -> Vec<(String, String)> {
    let text = std::fs::read_to_string(certificate).expect("there");
    let value: Value = serde_json::from_str(&text).expect("JSON");
    let mut all = Vec::new();
    mutations(&value, "", &mut all);
    all.into_iter().map(|(place, value)| (place, format!("{value:#}"))).collect()
}

#[test]
fn no_single_change_of_a_certificate_passes() {
    let studio = Studio::of_space("linear-srgb");
    studio.make(1);
    let (image, certificate) = (studio.path("beauty.0001.exr"), studio.path("beauty.0001.certificate.json"));
    let forged = studio.path("forged.json");
    let changed = changed(&certificate);
    let places: BTreeSet<&str> = changed.iter().map(|(place, _)| place.as_str()).collect();
    for place in [
        ".outputs[].error.channels[].all.max.bound",
        ".outputs[].error.channels[].map",
        ".document.canonical.nodes.ramp.stops[].at",
        ".image.blocks[]",
    ] {
        assert!(places.contains(place), "{place} is not among {places:?}");
    }
    assert!(changed.len() > 300, "{}", changed.len());
    for (place, text) in changed {
        std::fs::write(&forged, &text).expect("written");
        if let Ok(found) = check(&forged, &image, Choice::Some(1)) {
            assert!(!found.holds(), "{place}: {text}");
        }
    }
    // A duplicate field, of which readers take the first or the last; another spelling of the same number.
    let text = std::fs::read_to_string(&certificate).expect("there");
    for (from, to) in [("\"frame\": 1", "\"frame\": 2,\n  \"frame\": 1"), ("\"frame\": 1", "\"frame\": 1.0")] {
        std::fs::write(&forged, text.replacen(from, to, 1)).expect("written");
        assert!(!check(&forged, &image, Choice::Some(1)).is_ok_and(|found| found.holds()), "{to}");
    }
    std::fs::write(&forged, text.replace("\n", "\r\n")).expect("written");
    assert!(check(&forged, &image, Choice::Some(1)).expect("readable").holds(), "white space says nothing");
    for text in ["", "{}", "[1]", "{\"digest\": 5}"] {
        std::fs::write(&forged, text).expect("written");
        let error = check(&forged, &image, Choice::All).expect_err("no certificate");
        assert!(matches!(error, CertificateError::NoCertificate { .. }), "{error}");
    }
}

/// Changes that the check does not detect if the digest is recomputed: names that lead to files, which need not be
/// those of the files that are checked, and the version that a certificate gives for its maker.
const BEYOND_CHECKING: &[&str] = &[".document.folder", ".image.file", ".trochoid"];

/// Decodes the maps of the first output. A map has several texts: bits after the end of deflated bytes mean nothing.
fn maps(certificate: &Certificate) -> (Vec<Option<BoundMap>>, Option<PixelMap>) {
    const PIXELS: usize = 70 * 66;
    let error = &certificate.outputs[0].error;
    let bounds = error.channels.iter().map(|channel| BoundMap::decode(channel.base, &channel.map, PIXELS).ok());
    (bounds.collect(), PixelMap::decode(&error.ambiguous.map, PIXELS).ok())
}

#[test]
fn what_changes_is_found_even_where_the_digest_fits() {
    let studio = Studio::of_space("linear-srgb");
    studio.make(1);
    let (image, certificate) = (studio.path("beauty.0001.exr"), studio.path("beauty.0001.certificate.json"));
    let forged = studio.path("forged.json");
    let honest = Certificate::read(&certificate).expect("read").expect("sealed");
    let said = |certificate: &Certificate| serde_json::to_value(certificate).expect("JSON");
    let mut passed = BTreeSet::new();
    for (place, text) in changed(&certificate) {
        let Ok(read) = serde_json::from_str::<Certificate>(&text) else { continue };
        // A missing field reads the same as `null`. Changes of the document change its hash, so one of them is enough.
        let is_map = place.ends_with(".map");
        let same = said(&read) == said(&honest) || is_map && maps(&read) == maps(&honest);
        if same || place == ".digest" || (place.starts_with(".document.canonical") && !place.contains("stops[].at")) {
            continue;
        }
        read.write(&forged, None).expect("written");
        // A map may differ in one pixel alone.
        let choice = if is_map { Choice::All } else { Choice::Some(4) };
        if check(&forged, &image, choice).is_ok_and(|found| found.holds()) {
            passed.insert(place);
        }
    }
    let unknown: Vec<&String> = passed.iter().filter(|place| !BEYOND_CHECKING.contains(&place.as_str())).collect();
    assert!(unknown.is_empty(), "{unknown:#?}");
}
