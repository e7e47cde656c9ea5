//! Frames as lists of ranges.

/// Formats frames in ascending order as a list such as `1-10,20-40:2`, which `trochoid render` and Open Job Description
/// read alike.
pub(super) fn list(frames: &[i64]) -> String {
    let mut pieces = Vec::new();
    let mut rest = frames;
    while let Some(&first) = rest.first() {
        let step = rest.get(1).map_or(1, |next| next - first);
        let long = rest.windows(2).take_while(|pair| pair[1] - pair[0] == step).count() + 1;
        // Two frames with a gap are shorter one by one.
        let taken = if long == 2 && step > 1 { 1 } else { long };
        let last = rest[taken - 1];
        pieces.push(match (taken, step) {
            (1, _) => first.to_string(),
            (_, 1) => format!("{first}-{last}"),
            _ => format!("{first}-{last}:{step}"),
        });
        rest = &rest[taken..];
    }
    pieces.join(",")
}

/// Returns whether frames in ascending order have no gaps.
pub(super) fn is_contiguous(frames: &[i64]) -> bool {
    frames.windows(2).all(|pair| pair[1] - pair[0] == 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_short_and_are_read_as_the_same_frames() {
        let cases: [(&[i64], &str); 8] = [
            (&[7], "7"),
            (&[1, 2], "1-2"),
            (&[1, 2, 3, 4], "1-4"),
            (&[1, 4, 7, 10], "1-10:3"),
            (&[1, 5], "1,5"),
            (&[-5, -4, -3, 2], "-5--3,2"),
            (&[1, 2, 3, 10, 20, 30, 31], "1-3,10-30:10,31"),
            (&[-3, -1, 1, 3], "-3-3:2"),
        ];
        for (frames, text) in cases {
            assert_eq!(list(frames), text);
            assert_eq!(crate::frames::parse(text).unwrap(), frames, "{text}");
        }
        assert!(is_contiguous(&[3, 4, 5]) && is_contiguous(&[3]) && !is_contiguous(&[3, 5]));
    }
}
