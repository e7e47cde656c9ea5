//! Tests of FieldMath.

use crate::testing::{frame, refused};

#[test]
fn nan_is_repaired_and_counted_once() {
    let frame = frame("field", r#""out": { "type": "FieldMath", "expression": "sqrt(-1)", "nan": 7 }"#);
    let id = frame.graph.find("out").unwrap();
    for at in [[0.5, 0.5], [0.5, 0.5], [3.5, 2.5], [0.25, 0.5], [-0.5, 0.5]] {
        assert_eq!(frame.filled(id, 0, 0, at), 7.0);
    }
    assert_eq!(frame.truth([0.5, 0.5]), [7.0]);
    assert_eq!(frame.node("out").repaired(), 3);
}

#[test]
fn faults_of_formulas_are_told_with_their_place() {
    let of = |nodes: &str| refused("field", nodes);
    let faults = of(r#""out": { "type": "FieldMath", "expression": "1 + $" }"#);
    assert!(faults.contains("'$' at column 5"), "{faults}");
    let faults = of(r#""out": { "type": "FieldMath", "expression": "[1, 2, 3]" }"#);
    assert!(faults.contains("set \\\"components\\\" to 3"), "{faults}");
    let faults = of(r#""out": { "type": "FieldMath", "expression": "a + b", "a": 1 }"#);
    assert!(faults.contains("the unconnected input b"), "{faults}");
    of(r#""out": { "type": "FieldMath" }"#);
}
