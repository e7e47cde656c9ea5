//! Movies, which the program ffmpeg writes.

use super::gaps;
use crate::failure::{FAILED, Failure};
use crate::files::OverwriteOptions;
use crate::{interrupt, remedies};
use std::io::{ErrorKind, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::time::Duration;
use trochoid::io::write_by;
use trochoid::{Form, GENERATOR, VERSION, quoted_path};

/// The program.
const FFMPEG: &str = "ffmpeg";

/// Pause before the program is asked again whether it has ended.
const PAUSE: Duration = Duration::from_millis(20);

/// A movie of frames that stay as long as the document's frames that they stand for.
pub(super) struct Movie<'a> {
    /// Width and height, which are even.
    pub(super) size: [u32; 2],
    pub(super) quality: u8,
    /// Rate of the document.
    pub(super) fps: f64,
    pub(super) frames: &'a [i64],
}

/// Returns the failure of a missing program.
pub(super) fn missing(out: &Path) -> Option<Failure> {
    let mut asked = Command::new(FFMPEG);
    asked.arg("-version").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let error = asked.status().err()?;
    let found = match error.kind() {
        ErrorKind::NotFound => format!("no program {FFMPEG} on this machine"),
        _ => format!("a program {FFMPEG} that does not start ({error})"),
    };
    let message = format!("--out {}: found {found}; expected it: it writes MP4", quoted_path(out));
    Some(Failure { code: FAILED, ..Failure::usage(message, instead(out, &format!("install {FFMPEG}"))) })
}

/// Returns a remedy: `first`, or another form of file.
fn instead(out: &Path, first: &str) -> String {
    let [webp, png] = ["webp", "####.png"].map(|ending| quoted_path(&out.with_extension(ending)));
    format!("{first}, or write an animation, --out {webp}, or a sequence, --out {png}")
}

/// A running program, which is ended when this is dropped.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Movie<'_> {
    /// Writes the movie, whole or not at all; `next` returns the interleaved bytes of a frame.
    ///
    /// # Errors
    /// A frame cannot be made, the program fails, or the file cannot be written.
    pub(super) fn write(
        &self,
        out: &Path,
        over: OverwriteOptions,
        next: &mut dyn FnMut(usize) -> Result<Vec<u8>, Failure>,
    ) -> Result<(), Failure> {
        let mark = format!("{GENERATOR}{VERSION}");
        // A box that players skip: its length, its type, and the mark.
        let end = [&(mark.len() as u32 + 8).to_be_bytes()[..], b"free", mark.as_bytes()].concat();
        write_by(over.target(out, Form::Mp4), &end, |unfinished| self.encode(out, unfinished, next).map_err(Fault::Run))
            .map_err(|fault| match fault {
                Fault::Run(failure) => failure,
                Fault::Write(error) => Failure::new(FAILED, remedies::written(&error)),
            })
    }

    fn encode(
        &self,
        out: &Path,
        unfinished: &Path,
        next: &mut dyn FnMut(usize) -> Result<Vec<u8>, Failure>,
    ) -> Result<(), Failure> {
        let cannot = |error: std::io::Error| Failure::new(FAILED, format!("{}: {FFMPEG}: {error}", out.display()));
        let mut running = Running(self.command(unfinished).spawn().map_err(cannot)?);
        let input = running.0.stdin.take();
        let errors = running.0.stderr.take();
        // Read meanwhile, so that the program never waits for a full pipe.
        let said = std::thread::spawn(move || {
            let mut said = String::new();
            errors.map(|mut errors| errors.read_to_string(&mut said));
            said
        });
        let fed = input.map_or(Ok(true), |input| self.feed(input, next))?;
        let ended = loop {
            if interrupt::asked() {
                return Err(Failure::interrupted());
            }
            match running.0.try_wait().map_err(cannot)? {
                Some(ended) => break ended,
                None => std::thread::sleep(PAUSE),
            }
        };
        if fed && ended.success() {
            return Ok(());
        }
        let said = said.join().unwrap_or_default();
        let lines: Vec<&str> = said.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        let said = lines[lines.len().saturating_sub(3)..].join("; ");
        let message = format!("{}: {FFMPEG} failed ({ended}): {said}; nothing was written", out.display());
        let remedy = instead(out, &format!("correct that (MP4 needs an {FFMPEG} with libx264)"));
        Err(Failure { code: FAILED, ..Failure::usage(message, remedy) })
    }

    /// Writes all frames; returns false if the program took no more.
    fn feed(
        &self,
        mut input: ChildStdin,
        next: &mut dyn FnMut(usize) -> Result<Vec<u8>, Failure>,
    ) -> Result<bool, Failure> {
        for (index, times) in self.times().into_iter().enumerate() {
            let frame = next(index)?;
            for _ in 0..times {
                if input.write_all(&frame).is_err() {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// Returns how often each frame is repeated.
    fn times(&self) -> Vec<u64> {
        let step = self.step();
        gaps(self.frames).into_iter().map(|gap| gap / step).collect()
    }

    /// Returns for how many frames of the document a frame of the movie stands.
    fn step(&self) -> u64 {
        gaps(self.frames).into_iter().fold(0, common)
    }

    fn command(&self, to: &Path) -> Command {
        let [width, height] = self.size;
        let rate = self.fps / self.step() as f64;
        // From 10, visually without loss, to 43.
        let crf = 43 - u32::from(self.quality) / 3;
        let mut command = Command::new(FFMPEG);
        command.args(["-hide_banner", "-loglevel", "error", "-nostdin", "-y"]);
        command.args(["-f", "rawvideo", "-pixel_format", "rgb24", "-video_size", &format!("{width}x{height}")]);
        command.args(["-framerate", &rate.to_string(), "-i", "pipe:0", "-an"]);
        // The movie says how its colors are stored, as players assume it of unmarked movies, too.
        let stored = "setparams=range=tv:colorspace=bt709:color_primaries=bt709:color_trc=iec61966-2-1";
        let filter = format!("scale=out_color_matrix=bt709:out_range=tv,format=yuv420p,{stored}");
        command.args(["-vf", &filter]);
        command.args(["-c:v", "libx264", "-preset", "medium", "-crf", &crf.to_string()]);
        command.args(["-movflags", "+faststart", "-f", "mp4"]).arg(to);
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        // An interruption is for this program, which then ends the other.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        command
    }
}

/// Returns the greatest common divisor.
fn common(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { common(b, a % b) }
}

/// Why a movie is not written.
enum Fault {
    Run(Failure),
    Write(trochoid::io::Error),
}

impl From<trochoid::io::Error> for Fault {
    fn from(error: trochoid::io::Error) -> Self {
        Self::Write(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_stay_for_those_that_are_skipped() {
        let movie = |frames| Movie { size: [2, 2], quality: 80, fps: 24.0, frames };
        assert_eq!((movie(&[1, 3, 5]).step(), movie(&[1, 3, 5]).times()), (2, vec![1, 1, 1]));
        assert_eq!((movie(&[1, 3, 4]).step(), movie(&[1, 3, 4]).times()), (1, vec![2, 1, 1]));
        assert_eq!((movie(&[7]).step(), movie(&[7]).times()), (1, vec![1]));
        assert_eq!((movie(&[9, 5, 3]).step(), movie(&[9, 5, 3]).times()), (2, vec![2, 1, 1]));
    }
}
