//! Lists of frames such as `1-10,20-40x2`, in the forms that other programs write, too.

use crate::failure::Failure;
use std::collections::HashSet;
use trochoid::CheckedGraph;

/// Maximum number of frames in one run.
const MOST: usize = 1_000_000;
/// Largest magnitude of a frame number: frames are numbered from −10⁷ to 10⁷.
const RANGE: i64 = 10_000_000;

/// Error in a list of frames.
#[derive(Debug, thiserror::Error)]
pub(crate) enum FrameFault {
    /// A piece that names no frames.
    #[error("--frames: found \"{0}\"; expected {1}")]
    Piece(String, PieceFault),
    /// Too many frames up to this piece.
    #[error("--frames: found more than {MOST} frames up to \"{0}\"; expected at most {MOST}")]
    TooMany(String),
}

/// Expected form of a piece of the list.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PieceFault {
    #[error("a frame, a range first-last, or first-lastxstep")]
    Form,
    #[error("a smaller step")]
    LargeStep,
    #[error("a step of 1 or more")]
    NoStep,
    #[error("frames from -{RANGE} to {RANGE}")]
    Beyond,
    #[error("first ≤ last, such as {last}-{first}")]
    Backwards { first: i64, last: i64 },
}

/// Returns the frames that a list names, each once, in list order.
///
/// A piece is a frame (`7`, `-3`), a range (`1-10`, `-5--1`), or every nth frame of a range (`20-40x2`). Render farms write
/// the step as `20-40:2`, Blender a range as `1..10`, and Nuke spaces for commas.
///
/// # Errors
/// Returns a message for every piece that has none of these forms, or that names too many frames.
pub(crate) fn parse(list: &str) -> Result<Vec<i64>, Vec<FrameFault>> {
    let mut faults = Vec::new();
    let mut seen = HashSet::new();
    let mut frames = Vec::new();
    for piece in list.split(',').flat_map(pieces) {
        let named = match range(piece) {
            Ok((first, last, step)) => (first..=last).step_by(step),
            Err(fault) => {
                faults.push(FrameFault::Piece(piece.into(), fault));
                continue;
            }
        };
        frames.extend(named.filter(|frame| seen.insert(*frame)).take(MOST + 1));
        if frames.len() > MOST {
            faults.push(FrameFault::TooMany(piece.into()));
            break;
        }
    }
    if faults.is_empty() { Ok(frames) } else { Err(faults) }
}

/// Splits a text between commas at its spaces.
fn pieces(text: &str) -> Vec<&str> {
    let pieces: Vec<&str> = text.split_whitespace().collect();
    if pieces.is_empty() { vec![""] } else { pieces }
}

/// Returns all frames of the document; only the first if a list was `given`, which then could not be read.
pub(crate) fn all(graph: &CheckedGraph, given: bool, faults: &mut Vec<Failure>) -> Vec<i64> {
    let (first, last) = graph.frames();
    if given {
        return vec![first];
    }
    if last - first >= MOST as i64 {
        let message = format!("found the document's {} frames; expected at most 1000000 in one run", last - first + 1);
        faults.push(Failure::usage(message, "choose some of them with --frames"));
        return vec![first];
    }
    (first..=last).collect()
}

/// Returns a note on frames beyond those of a document that moves.
pub(crate) fn beyond(graph: &CheckedGraph, frames: &[i64]) -> Option<String> {
    let (first, last) = graph.frames();
    let beyond: Vec<i64> = frames.iter().copied().filter(|frame| !(first..=last).contains(frame)).collect();
    let found = match beyond[..] {
        _ if first == last => return None,
        [] => return None,
        [frame] => format!("frame {frame} is"),
        _ => format!("{} frames, {} and others, are", beyond.len(), beyond[0]),
    };
    Some(format!(
        "note: --frames: {found} outside of the document's frames, {first} to {last}; keyed values stay as at its ends\n  \
         remedy: if they are meant, change the document's \"frames\""
    ))
}

/// Returns the first frame, the last frame and the step of a piece; the error says what was expected.
fn range(piece: &str) -> Result<(i64, i64, usize), PieceFault> {
    let (first, rest) = number(piece).ok_or(PieceFault::Form)?;
    let (last, step) = match rest.strip_prefix('-').or_else(|| rest.strip_prefix("..")) {
        None if rest.is_empty() => (first, 1),
        None => return Err(PieceFault::Form),
        Some(rest) => {
            let (last, rest) = number(rest).ok_or(PieceFault::Form)?;
            match rest.strip_prefix(['x', ':']) {
                None if rest.is_empty() => (last, 1),
                Some(step) if step.bytes().all(|b| b.is_ascii_digit()) && !step.is_empty() => {
                    (last, step.parse().map_err(|_| PieceFault::LargeStep)?)
                }
                _ => return Err(PieceFault::Form),
            }
        }
    };
    if step == 0 {
        return Err(PieceFault::NoStep);
    }
    if first.abs() > RANGE || last.abs() > RANGE {
        return Err(PieceFault::Beyond);
    }
    if last < first {
        return Err(PieceFault::Backwards { first, last });
    }
    Ok((first, last, step))
}

/// Splits a text into the integer at its start and the rest.
fn number(text: &str) -> Option<(i64, &str)> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    let length = text.len() - digits.len() + digits.bytes().take_while(u8::is_ascii_digit).count();
    // A number that does not fit in an i64 is out of range anyway, and so is the largest i64.
    let sign = if digits.len() < text.len() { -1 } else { 1 };
    let magnitude = text[..length].trim_start_matches('-');
    if magnitude.is_empty() {
        return None;
    }
    Some((sign * magnitude.parse().unwrap_or(i64::MAX), &text[length..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_read_in_their_order_and_every_frame_once() {
        let cases: [(&str, &[i64]); 15] = [
            ("7", &[7]),
            ("1-4", &[1, 2, 3, 4]),
            ("20-25x2", &[20, 22, 24]),
            ("1-10:3,20", &[1, 4, 7, 10, 20]),
            ("-5--3", &[-5, -4, -3]),
            ("-2-1", &[-2, -1, 0, 1]),
            ("-3", &[-3]),
            ("5,1-6x2, 2", &[5, 1, 3, 2]),
            ("3-3x9", &[3]),
            ("4,4,4-5", &[4, 5]),
            ("1..3", &[1, 2, 3]),
            ("-3..-1,5", &[-3, -2, -1, 5]),
            ("1..7x3", &[1, 4, 7]),
            ("1 3 5", &[1, 3, 5]),
            ("1-2  8-9x1, 4", &[1, 2, 8, 9, 4]),
        ];
        for (list, frames) in cases {
            assert_eq!(parse(list).unwrap(), frames, "{list}");
        }
    }

    #[test]
    fn every_faulty_piece_is_named() {
        for piece in [
            "",
            "a",
            "1-",
            "-",
            "--",
            "1...3",
            "1..",
            "1.3",
            "1-3x",
            "1-3:",
            "1-3x2:2",
            "1:2",
            "1-3x0",
            "1-3x-1",
            "1x2",
            "9-1",
            "1-2-3",
            "1.5",
            "20000000",
            "99999999999999999999",
            "-99999999999999999999",
            "1-3x99999999999999999999999",
            "+3",
            "1-3y2",
            "١",
        ] {
            let faults = parse(&format!("1,{piece},2")).expect_err(piece);
            assert_eq!(faults.len(), 1);
            assert!(faults[0].to_string().contains(&format!("\"{piece}\"")), "{}", faults[0]);
        }
        assert_eq!(parse("a,1,b").unwrap_err().len(), 2);
        assert!(parse("9-1").unwrap_err()[0].to_string().contains("1-9"));
    }

    #[test]
    fn there_are_at_most_a_million() {
        assert_eq!(parse("1-1000000,5-10").unwrap().len(), 1_000_000);
        assert!(parse("1-1000001").unwrap_err()[0].to_string().contains("1-1000001"));
        assert!(parse("-10000000-10000000").is_err());
    }
}
