//! Files of tables as Adobe, IRIDAS and Resolve define `.cube`.
//!
//! Sources: *Cube LUT Specification 1.0*, Adobe, 2013; *DaVinci Resolve, About LUTs*, Blackmagic Design, which adds files
//! with curves and a lattice, and ranges of both.

use super::cube::{Cube, Table};

/// Maximum size of a file, in bytes: a lattice of 129 entries a side takes about 60 MB.
pub(super) const MOST_BYTES: u64 = 128 << 20;
/// Maximum number of entries of curves, and of entries along a side of a lattice.
const MOST: [usize; 2] = [65_536, 129];

/// Reason why a file is no table.
#[derive(Debug, thiserror::Error)]
pub enum NoCube {
    /// It cannot be read.
    #[error(transparent)]
    File(#[from] trochoid::io::Error),
    /// A line is not as expected.
    #[error("line {line}: found {found}; expected {expected}\n  remedy: {REMEDY}")]
    Line {
        /// Number of the line, from 1.
        line: usize,
        /// What was found.
        found: CubeFault,
        /// What was expected.
        expected: String,
    },
}

const REMEDY: &str = "export the table again as .cube, of a 1D or 3D LUT";

/// What a line of a file has.
#[derive(Debug, thiserror::Error)]
pub enum CubeFault {
    /// Some text.
    #[error("{0}")]
    Text(String),
    /// No further line.
    #[error("the end of the file after {0} of {1} colors")]
    End(usize, usize),
    /// A color that is too many.
    #[error("one color more than the {0} that the sizes call for")]
    Surplus(usize),
    /// A second line with this word.
    #[error("a second {0}")]
    Again(&'static str),
}

/// What precedes the colors.
#[derive(Default)]
struct Head {
    sizes: [Option<usize>; 2],
    /// Ends of the domain, from `DOMAIN_MIN` and `DOMAIN_MAX`.
    ends: [Option<[f32; 3]>; 2],
    /// Ranges of curves and of the lattice.
    ranges: [Option<[f32; 2]>; 2],
}

const SIZES: [&str; 2] = ["LUT_1D_SIZE", "LUT_3D_SIZE"];
const ENDS: [&str; 2] = ["DOMAIN_MIN", "DOMAIN_MAX"];
const RANGES: [&str; 2] = ["LUT_1D_INPUT_RANGE", "LUT_3D_INPUT_RANGE"];

fn fault<T>(line: usize, found: impl Into<String>, expected: impl Into<String>) -> Result<T, NoCube> {
    Err(NoCube::Line { line, found: CubeFault::Text(found.into()), expected: expected.into() })
}

/// Reads numbers that f32 holds.
fn numbers<const N: usize>(line: usize, text: &str, what: &str) -> Result<[f32; N], NoCube> {
    let mut all = [0.0; N];
    let mut words = text.split_whitespace();
    for value in &mut all {
        let word = words.next().unwrap_or_default();
        match word.parse::<f32>() {
            Ok(number) if number.is_finite() => *value = number,
            _ if word.is_empty() => return fault(line, crate::refusal::quoted(text), what),
            _ => return fault(line, crate::refusal::quoted(word), what),
        }
    }
    match words.next() {
        Some(more) => fault(line, format!("{} after them", crate::refusal::quoted(more)), what),
        None => Ok(all),
    }
}

impl Head {
    /// Takes a line that begins with a word.
    fn take(&mut self, line: usize, word: &str, rest: &str) -> Result<(), NoCube> {
        let is_new = |is_known: bool, word: &'static str| match is_known {
            true => Err(NoCube::Line { line, found: CubeFault::Again(word), expected: "one such line".into() }),
            false => Ok(()),
        };
        for at in 0..2 {
            if word == SIZES[at] {
                is_new(self.sizes[at].is_some(), SIZES[at])?;
                let legal = 2..=MOST[at];
                return match rest.trim().parse::<usize>() {
                    Ok(size) if legal.contains(&size) => {
                        self.sizes[at] = Some(size);
                        Ok(())
                    }
                    _ => fault(line, crate::refusal::quoted(rest), format!("a whole number from 2 to {}", MOST[at])),
                };
            } else if word == ENDS[at] {
                is_new(self.ends[at].is_some(), ENDS[at])?;
                self.ends[at] = Some(numbers(line, rest, "three numbers")?);
                return self.ordered(line);
            } else if word == RANGES[at] {
                is_new(self.ranges[at].is_some(), RANGES[at])?;
                self.ranges[at] = Some(numbers(line, rest, "two numbers")?);
                return self.ordered(line);
            }
        }
        if word == "TITLE" {
            return Ok(());
        }
        let known = [SIZES, ENDS, RANGES].concat().join(", ");
        fault(line, crate::refusal::quoted(word), format!("three numbers, or one of TITLE, {known}"))
    }

    /// Checks that ranges are none the wrong way around.
    fn ordered(&self, line: usize) -> Result<(), NoCube> {
        let is_wrong = |[low, high]: [f32; 2]| low >= high;
        let domain = self.domain(0);
        match domain.into_iter().chain(self.ranges.into_iter().flatten()).find(|range| is_wrong(*range)) {
            // The other end may still follow.
            Some(_)
                if self.ends.iter().flatten().count() == 1 && !self.ranges.iter().flatten().any(|r| is_wrong(*r)) =>
            {
                Ok(())
            }
            Some([low, high]) => fault(line, format!("a range from {low} to {high}"), "the smaller end first"),
            None => Ok(()),
        }
    }

    /// Returns the domain of curves (0) or of the lattice (1). Without a range of its own, the first table has that of the
    /// file, and a second one takes what the first one gives, from 0 to 1.
    fn domain(&self, table: usize) -> [[f32; 2]; 3] {
        let is_second = table == 1 && self.sizes[0].is_some();
        let [low, high] = [self.ends[0].unwrap_or([0.0; 3]), self.ends[1].unwrap_or([1.0; 3])];
        match self.ranges[table] {
            Some(range) => [range; 3],
            None if is_second => [[0.0, 1.0]; 3],
            None => std::array::from_fn(|channel| [low[channel], high[channel]]),
        }
    }

    /// Returns the number of colors of each table.
    fn counts(&self) -> [usize; 2] {
        [self.sizes[0].unwrap_or(0), self.sizes[1].map_or(0, |size| size.pow(3))]
    }
}

/// Reads a table from the text of a file.
pub(super) fn parse(text: &str) -> Result<Cube, NoCube> {
    let mut head = Head::default();
    let mut colors: Vec<[f32; 3]> = Vec::new();
    let mut last = 0;
    for (index, whole) in text.lines().enumerate() {
        let line = index + 1;
        let content = whole.trim_start_matches('\u{feff}').trim();
        if content.is_empty() || content.starts_with('#') {
            continue;
        }
        last = line;
        let (word, rest) = content.split_once(char::is_whitespace).unwrap_or((content, ""));
        let count: usize = head.counts().iter().sum();
        if word.starts_with(|c: char| c.is_ascii_alphabetic()) && word.parse::<f32>().is_err() {
            if !colors.is_empty() {
                return fault(line, crate::refusal::quoted(word), "colors alone after the first color");
            }
            head.take(line, word, rest)?;
            continue;
        }
        if colors.is_empty() {
            if count == 0 {
                return fault(
                    line,
                    crate::refusal::quoted(content),
                    "LUT_1D_SIZE or LUT_3D_SIZE before the first color",
                );
            }
            if let Some([low, high]) = head.domain(0).into_iter().find(|[low, high]| low >= high) {
                return fault(line, format!("colors for a range from {low} to {high}"), "the smaller end first");
            }
            // Not more memory than the file has colors, whatever it says: each takes at least six bytes.
            colors.reserve_exact(count.min(text.len() / 6 + 1));
        }
        if colors.len() == count {
            let found = CubeFault::Surplus(count);
            return Err(NoCube::Line { line, found, expected: "the end of the file".into() });
        }
        colors.push(numbers(line, content, "a color of three numbers")?);
    }
    let counts = head.counts();
    let count = counts.iter().sum();
    if count == 0 {
        return fault(last + 1, "the end of the file", "LUT_1D_SIZE or LUT_3D_SIZE");
    }
    if colors.len() < count {
        let found = CubeFault::End(colors.len(), count);
        return Err(NoCube::Line { line: last + 1, found, expected: "a color of three numbers".into() });
    }
    let nodes = colors.split_off(counts[0]);
    let table = |at: usize, entries| head.sizes[at].map(|size| Table { size, domain: head.domain(at), entries });
    Ok(Cube { curves: table(0, colors), lattice: table(1, nodes) })
}
