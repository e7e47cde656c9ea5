//! Human-readable formats for numbers, times, and sizes.

/// Formats a time with a suitable unit.
pub(crate) fn seconds(seconds: f64) -> String {
    match seconds {
        s if s < 0.000_95 => format!("{:.0} µs", s * 1e6),
        s if s < 0.0095 => format!("{:.1} ms", s * 1e3),
        s if s < 0.95 => format!("{:.0} ms", s * 1e3),
        s if s < 59.5 => format!("{s:.1} s"),
        s => format!("{:.0} min {:.0} s", (s / 60.0).floor(), s % 60.0),
    }
}

/// Formats a memory size.
pub(crate) fn bytes(bytes: usize) -> String {
    match bytes as f64 {
        b if b < 1e3 => format!("{b:.0} B"),
        b if b < 1e6 => format!("{:.0} kB", b / 1e3),
        b if b < 1e9 => format!("{:.0} MB", b / 1e6),
        b => format!("{:.1} GB", b / 1e9),
    }
}

/// Formats a number in groups of three digits.
pub(crate) fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Formats a number with its significant digits.
pub(crate) fn number(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    match value.abs() {
        a if !(1e-4..1e6).contains(&a) => format!("{value:.3e}"),
        a if a >= 100.0 => format!("{value:.1}"),
        a if a >= 1.0 => format!("{value:.3}"),
        _ => format!("{value:.4}"),
    }
}

/// Formats a measure with two decimals, or with its significant digits if it is small.
pub(crate) fn measure(value: f64) -> String {
    match value.abs() {
        a if a == 0.0 || (0.1..1e6).contains(&a) => format!("{value:.2}"),
        _ => number(value),
    }
}

/// Returns a unit of knobs as it follows a number.
pub(crate) fn unit(unit: &str) -> String {
    match unit {
        "" => String::new(),
        "degrees" => "°".into(),
        "pixels" => " px".into(),
        unit => format!(" {unit}"),
    }
}

/// Formats a fraction as a percentage.
pub(crate) fn percent(share: f64) -> String {
    match 100.0 * share {
        percent if percent > 0.0 && percent < 0.05 => "< 0.1 %".into(),
        percent => format!("{percent:.1} %"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_short_and_have_units() {
        assert_eq!(seconds(0.000_02), "20 µs");
        assert_eq!(seconds(0.0042), "4.2 ms");
        assert_eq!(seconds(0.25), "250 ms");
        assert_eq!(seconds(2.04), "2.0 s");
        assert_eq!(seconds(75.0), "1 min 15 s");
        assert_eq!(bytes(12_400_000), "12 MB");
        assert_eq!(thousands(2_073_600), "2,073,600");
        assert_eq!(thousands(12), "12");
        assert_eq!(number(0.25), "0.2500");
        assert_eq!(number(f64::INFINITY), "inf");
        assert_eq!([12.438, -0.4039, 0.0].map(measure), ["12.44", "-0.40", "0.00"]);
        assert_eq!([0.004, 1e9].map(measure), ["0.0040", "1.000e9"]);
    }
}
