//! Tests of tables: against OpenColorIO, against a reference in f64, and on hostile files.

use super::cube::{Cube, Table};
use super::parse::parse;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// Tables that OpenColorIO 2.6 has baked from its configuration, and what it makes of colors by them.
const BAKED: [[&str; 2]; 2] = [
    [include_str!("samples/shaped.cube"), include_str!("samples/shaped.txt")],
    [include_str!("samples/plain.cube"), include_str!("samples/plain.txt")],
];

#[test]
fn colors_are_those_of_opencolorio() {
    for [table, colors] in BAKED {
        let cube = parse(table).unwrap();
        assert!(cube.lattice.is_some());
        let mut count = 0;
        for line in colors.lines() {
            let values: Vec<f32> = line.split_whitespace().map(|word| word.parse().unwrap()).collect();
            let found = cube.of([values[0], values[1], values[2]]);
            for (found, expected) in found.iter().zip(&values[3..6]) {
                assert!((found - expected).abs() <= 2e-5, "{line}: {found}");
            }
            count += 1;
        }
        assert_eq!(count, 60);
    }
    assert!(parse(BAKED[0][0]).unwrap().curves.is_some(), "curves come before the lattice");
}

/// Returns the color by the six tetrahedra of a cell, written out, in f64.
fn reference(table: &Table, color: [f32; 3]) -> [f64; 3] {
    let mut base = [0; 3];
    let mut f = [0.0; 3];
    for channel in 0..3 {
        let [low, high] = table.domain[channel].map(f64::from);
        let at = (f64::from(color[channel]).clamp(low, high) - low) / (high - low) * (table.size - 1) as f64;
        base[channel] = (at.floor() as usize).min(table.size - 2);
        f[channel] = at - base[channel] as f64;
    }
    let v = |r: usize, g: usize, b: usize| {
        let index = base[0] + r + table.size * (base[1] + g + table.size * (base[2] + b));
        table.entries[index].map(f64::from)
    };
    let mix = |parts: [(f64, [f64; 3]); 4]| {
        std::array::from_fn(|channel| parts.iter().map(|(weight, color)| weight * color[channel]).sum())
    };
    let [r, g, b] = f;
    let (black, white) = (v(0, 0, 0), v(1, 1, 1));
    if r >= g && g >= b {
        mix([(1.0 - r, black), (r - g, v(1, 0, 0)), (g - b, v(1, 1, 0)), (b, white)])
    } else if r >= b && b >= g {
        mix([(1.0 - r, black), (r - b, v(1, 0, 0)), (b - g, v(1, 0, 1)), (g, white)])
    } else if b >= r && r >= g {
        mix([(1.0 - b, black), (b - r, v(0, 0, 1)), (r - g, v(1, 0, 1)), (g, white)])
    } else if g >= r && r >= b {
        mix([(1.0 - g, black), (g - r, v(0, 1, 0)), (r - b, v(1, 1, 0)), (b, white)])
    } else if g >= b && b >= r {
        mix([(1.0 - g, black), (g - b, v(0, 1, 0)), (b - r, v(0, 1, 1)), (r, white)])
    } else {
        mix([(1.0 - b, black), (b - g, v(0, 0, 1)), (g - r, v(0, 1, 1)), (r, white)])
    }
}

#[test]
fn random_lattices_agree_with_the_reference() {
    let mut random = Pcg64Mcg::new(0x5eed);
    for size in [2, 3, 4, 7, 17] {
        let domain = std::array::from_fn(|_| {
            let low = random.random_range(-2.0_f32..1.0);
            [low, low + random.random_range(0.1_f32..9.0)]
        });
        let entries = (0..size * size * size).map(|_| [(); 3].map(|()| random.random_range(-1.0_f32..2.0))).collect();
        let table = Table { size, domain, entries };
        let cube = Cube { curves: None, lattice: Some(table.clone()) };
        for round in 0..2000 {
            let mut color = [(); 3].map(|()| random.random_range(-4.0_f32..12.0));
            // Equal values, ends of the domain, and entries themselves.
            match round % 5 {
                0 => color[1] = color[0],
                1 => color = std::array::from_fn(|channel| domain[channel][usize::from(random.random::<bool>())]),
                2 => {
                    color = domain.map(|[low, high]| {
                        low + (high - low) * random.random_range(0..size) as f32 / (size - 1) as f32
                    });
                }
                _ => {}
            }
            let (found, expected) = (cube.of(color), reference(&table, color));
            for channel in 0..3 {
                let far = (f64::from(found[channel]) - expected[channel]).abs();
                assert!(far < 1e-4, "{size}: {color:?}: {found:?} {expected:?}");
            }
        }
    }
}

#[test]
fn extreme_values_stay_within_the_table() {
    let text = "LUT_3D_SIZE 2\nDOMAIN_MIN -3e38 -3e38 -3e38\nDOMAIN_MAX 3e38 3e38 3e38\n";
    let colors = (0..8).map(|at: u32| format!("{} {} {}\n", at & 1, (at >> 1) & 1, at >> 2)).collect::<String>();
    let cube = parse(&format!("{text}{colors}")).unwrap();
    for value in [f32::MIN, f32::MAX, f32::INFINITY, f32::NEG_INFINITY, -0.0, f32::MIN_POSITIVE] {
        let found = cube.of([value, 0.0, -value]);
        assert!(found.iter().all(|value| (0.0..=1.0).contains(value)), "{value}: {found:?}");
    }
    assert_eq!(cube.of([f32::INFINITY, f32::NEG_INFINITY, 0.0]), [1.0, 0.0, 0.5]);
}

#[test]
fn curves_have_a_domain_for_each_channel() {
    let text =
        "TITLE \"steep\"\n# a comment\nLUT_1D_SIZE 3\nDOMAIN_MIN 0 0 -1\nDOMAIN_MAX 1 2 1\n\n0 0 0\n.5 1e0 5\n1 2 10\n";
    let cube = parse(text).unwrap();
    assert_eq!(cube.of([0.25, 1.0, -0.5]), [0.25, 1.0, 2.5]);
    assert_eq!(cube.of([-7.0, 9.0, 1.0]), [0.0, 2.0, 10.0]);
}

#[test]
fn what_is_no_table_is_refused_with_its_line() {
    let cases = [
        ("", "line 1: found the end of the file; expected LUT_1D_SIZE or LUT_3D_SIZE"),
        ("0 0 0", "line 1: found \"0 0 0\"; expected LUT_1D_SIZE or LUT_3D_SIZE before the first color"),
        ("LUT_3D_SIZE 1", "line 1: found \"1\"; expected a whole number from 2 to 129"),
        ("LUT_3D_SIZE 4294967296", "expected a whole number from 2 to 129"),
        ("#\n\nLUT_1D_SIZE 70000", "line 3: found \"70000\"; expected a whole number from 2 to 65536"),
        ("LUT_3D_SIZE", "line 1: found \"\"; expected a whole number from 2 to 129"),
        ("LUT_1D_SIZE 2\nLUT_1D_SIZE 2", "line 2: found a second LUT_1D_SIZE; expected one such line"),
        ("LUT_1D_SIZE 2\n0 0\n", "line 2: found \"0 0\"; expected a color of three numbers"),
        ("LUT_1D_SIZE 2\n0 0 zero\n", "line 2: found \"zero\"; expected a color of three numbers"),
        ("LUT_1D_SIZE 2\n0 0 nan\n", "line 2: found \"nan\"; expected a color of three numbers"),
        ("LUT_1D_SIZE 2\n0 0 1e39\n", "line 2: found \"1e39\"; expected a color of three numbers"),
        ("LUT_1D_SIZE 2\n0 0 0 0\n", "line 2: found \"0\" after them; expected a color of three numbers"),
        ("LUT_1D_SIZE 2\n0 0 0\n", "line 3: found the end of the file after 1 of 2 colors"),
        ("LUT_1D_SIZE 2\n0 0 0\n1 1 1\n1 1 1", "line 4: found one color more than the 2 that the sizes call for"),
        (
            "LUT_1D_SIZE 2\n0 0 0\nTITLE \"late\"",
            "line 3: found \"TITLE\"; expected colors alone after the first color",
        ),
        ("LUT_1D_SIZE 2\nGAMMA 2", "line 2: found \"GAMMA\"; expected three numbers, or one of TITLE"),
        ("DOMAIN_MIN 0 2 0\nDOMAIN_MAX 1 1 1", "line 2: found a range from 2 to 1; expected the smaller end first"),
        ("DOMAIN_MIN 0 2 0\nLUT_1D_SIZE 2\n0 0 0", "line 3: found colors for a range from 2 to 1"),
        ("LUT_3D_INPUT_RANGE 1 1", "line 1: found a range from 1 to 1; expected the smaller end first"),
        ("{ \"trochoid\": 1 }", "line 1: found \"{"),
    ];
    for (text, expected) in cases {
        let found = parse(text).unwrap_err().to_string();
        assert!(found.contains(expected), "{text:?}: {found}");
        assert!(found.contains("remedy: "), "{found}");
    }
}

#[test]
fn a_damaged_table_is_refused_or_read_but_never_trusted() {
    let mut random = Pcg64Mcg::new(0xdead);
    for _ in 0..3000 {
        let mut text: Vec<char> = BAKED[random.random_range(0..2)][0].chars().take(900).collect();
        for _ in 0..random.random_range(1..4) {
            let at = random.random_range(0..text.len());
            let letters = ['0', '9', '-', '.', 'e', ' ', '\n', '#', 'L', 'n', '\u{feff}'];
            text[at] = letters[random.random_range(0..letters.len())];
        }
        // Cut off, so that nothing but an error can follow.
        let text: String = text.into_iter().collect();
        assert!(parse(&text).is_err());
    }
}
