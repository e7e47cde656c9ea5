//! Formatting of numbers for readers.

use trochoid::accuracy::Estimate;

/// Formats a number with two digits: `0.085`, `8.5×10⁻⁵`.
pub(super) fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return "–".into();
    }
    let scientific = format!("{value:.1e}");
    let Some((digits, exponent)) = scientific.split_once('e') else { return scientific };
    let digits = digits.strip_suffix(".0").unwrap_or(digits);
    match exponent.parse::<i32>() {
        Ok(-2) | Ok(-1) => format!("{value:.*}", if exponent == "-2" { 3 } else { 2 }),
        Ok(0) => digits.into(),
        Ok(1..=3) => format!("{value:.0}"),
        _ if digits == "1" => format!("10{}", raised(exponent)),
        _ => format!("{digits}×10{}", raised(exponent)),
    }
}

/// Formats an exponent as superscript.
fn raised(exponent: &str) -> String {
    let raise = |c: char| match c {
        '-' => '⁻',
        _ => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][c.to_digit(10).unwrap_or(0) as usize],
    };
    exponent.chars().map(raise).collect()
}

/// Formats a time: `31 ms`, `1.4 s`.
pub(super) fn seconds(value: f64) -> String {
    match value {
        value if !value.is_finite() => "–".into(),
        value if value.abs() < 0.000_95 => format!("{:.2} ms", value * 1e3),
        value if value.abs() < 0.009_5 => format!("{:.1} ms", value * 1e3),
        value if value.abs() < 0.095 => format!("{:.0} ms", value * 1e3),
        value if value.abs() < 0.95 => format!("{value:.2} s"),
        value if value.abs() < 9.5 => format!("{value:.1} s"),
        _ => format!("{value:.0} s"),
    }
}

/// Formats a share: `1.45 %`. Shares above 0 do not look like 0.
pub(crate) fn percent(share: f64) -> String {
    match 100.0 * share {
        part if !part.is_finite() => "–".into(),
        part if part > 0.0 && part < 0.005 => "< 0.01 %".into(),
        part if part < 10.0 => format!("{part:.2} %"),
        part => format!("{part:.1} %"),
    }
}

/// Formats a size: `12.3 MiB`.
pub(super) fn mebibytes(bytes: usize) -> String {
    format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
}

/// Formats the place of a pixel: `(12, 34)`.
pub(super) fn place([x, y]: [i64; 2]) -> String {
    format!("({x}, {y})")
}

/// Formats an estimate with its interval: `0.085 [0.071, 0.10]`; just the figure, if it is exact.
pub(super) fn interval(estimate: Option<Estimate>, format: fn(f64) -> String) -> String {
    let Some(Estimate { value, low, high }) = estimate else { return "–".into() };
    match low == high {
        true => format(value),
        false if high.is_infinite() => format!("{} [≥ {}]", format(value), format(low)),
        false => format!("{} [{}, {}]", format(value), format(low), format(high)),
    }
}

/// Formats a large count: `230 400`, with narrow spaces.
pub(super) fn thousands(number: usize) -> String {
    let digits = number.to_string();
    let group = |(index, digit): (usize, char)| {
        let is_first = index > 0 && (digits.len() - index).is_multiple_of(3) && digits.len() > 4;
        is_first.then_some('\u{202f}').into_iter().chain([digit])
    };
    digits.chars().enumerate().flat_map(group).collect()
}

/// Formats a count: "1 sample", "4 samples".
pub(super) fn count(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_two_digits() {
        for (value, text) in [
            (0.0, "0"),
            (0.5, "0.50"),
            (0.085, "0.085"),
            (0.0085, "8.5×10⁻³"),
            (1e-6, "10⁻⁶"),
            (1.0, "1"),
            (2.54, "2.5"),
            (37.2, "37"),
            (1.2e12, "1.2×10¹²"),
            (f64::NAN, "–"),
        ] {
            assert_eq!(short(value), text);
        }
        let all = [0.000_31, 0.0031, 0.031, 0.31, 3.1, 31.0].map(seconds);
        assert_eq!(all, ["0.31 ms", "3.1 ms", "31 ms", "0.31 s", "3.1 s", "31 s"]);
        assert_eq!([0.0, 1e-6, 0.0145, 0.9].map(percent), ["0.00 %", "< 0.01 %", "1.45 %", "90.0 %"]);
        assert_eq!(
            [7, 4096, 23_040, 1_234_567].map(thousands),
            ["7", "4096", "23\u{202f}040", "1\u{202f}234\u{202f}567"]
        );
        let estimate = |low: f64, high: f64| interval(Some(Estimate { value: 0.5, low, high }), short);
        assert_eq!([estimate(0.25, 1.0), estimate(0.5, 0.5)], ["0.50 [0.25, 1]", "0.50"]);
        assert_eq!([estimate(0.25, f64::INFINITY), interval(None, short)], ["0.50 [≥ 0.25]", "–"]);
    }
}
