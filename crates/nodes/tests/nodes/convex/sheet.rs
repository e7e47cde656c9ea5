//! Tests of Sheet.

use crate::testing::{agrees, frame, refused};

fn sheet(columns: usize, rows: usize, more: &str) -> String {
    let color = |i: usize| format!("[{}, {}, {}]", i as f64 / 32.0, ((i * 7) % 5) as f64 / 5.0, (i * i) % 3);
    let colors: Vec<String> = (0..columns * rows).map(color).collect();
    format!(
        r#""x": {{ "type": "ScreenX" }}, "y": {{ "type": "ScreenY" }},
        "out": {{ "type": "Sheet", "u": "x", "v": "y", "columns": {columns}, {more} "colors": [{}] }}"#,
        colors.join(", ")
    )
}

#[test]
fn laying_over_is_the_sum_of_hats() {
    for more in ["", r#""interpolation": "smooth", "#] {
        for (columns, rows) in [(1, 1), (1, 4), (6, 1), (2, 2), (6, 5), (3, 7)] {
            agrees("color", &sheet(columns, rows, more));
        }
    }
    let places = r#""columns_at": [0.1, 0.4, 0.4, 1], "rows_at": [0, 0.3, 0.7], "interpolation": "smooth", "#;
    agrees("color", &sheet(4, 3, places));
}

#[test]
fn crossings_show_their_color() {
    let at = |x: u32, y: u32| [f64::from(x) + 0.5, f64::from(y) + 0.5];
    for more in ["", r#""interpolation": "smooth", "#] {
        let frame = frame("color", &sheet(4, 3, more));
        for (x, y) in (0..3).flat_map(|y| (0..4).map(move |x| (x, y))) {
            assert_eq!(frame.lowered(at(x, y))[0], (y * 4 + x) as f32 / 32.0, "{x}, {y}");
        }
    }
    // At a position shared by two columns, the later column shows.
    let frame = frame("color", &sheet(4, 1, r#""columns_at": [0, 0.5, 0.5, 1], "#));
    assert_eq!(frame.lowered([2.0, 1.5])[0], 2.0 / 32.0);
}

#[test]
fn grids_without_whole_rows_or_places_are_refused() {
    assert!(refused("color", &sheet(3, 2, "").replace("\"columns\": 3", "\"columns\": 4")).contains("6 colors"));
    assert!(refused("color", &sheet(3, 2, r#""rows_at": [0, 0.5, 1], "#)).contains("3 positions"));
    assert!(refused("color", &sheet(3, 2, r#""rows_at": [0.5, 0.25], "#)).contains("0.25 after 0.5"));
    assert!(refused("color", &sheet(3, 2, r#""rows_at": [0.5, 1.25], "#)).contains("1.25"));
}
