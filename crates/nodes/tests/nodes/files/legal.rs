//! Tests of the repair of values that are not legal.

use super::read::{exr, read, value};

#[test]
fn repair_takes_the_nearest_legal_value() {
    let folder = tempfile::tempdir().unwrap();
    for (key, cases) in [
        ("color", &[(f32::NAN, 0.0), (-0.5, 0.0), (f32::INFINITY, f32::MAX), (f32::NEG_INFINITY, 0.0), (7.5, 7.5)][..]),
        ("weights", &[(1.25, 1.0), (-1e-9, 0.0), (f32::NAN, 0.0)]),
        ("field", &[(f32::NAN, 0.0), (f32::NEG_INFINITY, f32::NEG_INFINITY)]),
    ] {
        let mut samples = [0.0; 12];
        samples.iter_mut().zip(cases).for_each(|(sample, (found, _))| *sample = *found);
        exr(folder.path(), &[("R", samples)], None);
        let frame = read(folder.path(), key, &format!(r#""as": "{key}", "channels": ["R"], "repair": true"#)).unwrap();
        for (index, (found, legal)) in cases.iter().enumerate() {
            let value = value(&frame, index % 4, index / 4);
            assert_eq!(value.last(), Some(legal), "{found} as {key}");
        }
    }
}
