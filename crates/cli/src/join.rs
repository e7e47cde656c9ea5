//! `trochoid join`: makes one picture of the tiles that `render --region` wrote.

use crate::failure::{FAILED, Failure, INVALID};
use crate::files::OverwriteOptions;
use crate::progress::{Form as ProgressForm, Progress};
use crate::{interrupt, shell};
use serde_json::json;
use std::path::PathBuf;
use trochoid::{Form, JoinError, Joined, check_destination, join};

/// Options of `trochoid join`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The picture is byte for byte the file that rendering it as a whole would have written, so `render --resume` takes it for
up to date. EXR is joined band by band, in little memory; a PNG is joined in memory.

Examples:
  trochoid render storm.json --frames 36 --region 0,0,960,1080 --out left.exr
  trochoid render storm.json --frames 36 --region 960,0,960,1080 --out right.exr
  trochoid join left.exr right.exr -o storm.exr")]
pub(crate) struct Args {
    /// The tiles, in any order: EXR or PNG files of `trochoid render --region`, which together have every pixel once
    #[arg(required = true, value_name = "TILE")]
    tiles: Vec<PathBuf>,
    /// The picture to write, EXR or PNG as the tiles are
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    over: OverwriteOptions,
    /// Form of progress
    #[arg(long, value_name = "FORM", value_enum, default_value_t)]
    progress: ProgressForm,
    /// Print nothing on stdout, and show no progress
    #[arg(long, conflicts_with_all = ["json", "progress"])]
    quiet: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Joins tiles.
///
/// # Errors
/// The tiles are not those of one picture, or a file cannot be read or written.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    if let Some(tile) = args.tiles.iter().find(|tile| trochoid::resolved(tile) == trochoid::resolved(&args.out)) {
        let message = format!("{}: is a tile and would be overwritten", tile.display());
        return Err(Failure::usage(message, "give the picture another name"));
    }
    let is_png = args.out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    args.over.foreign(&args.out, if is_png { Form::Png } else { Form::Exr }).map_or(Ok(()), Err)?;
    check_destination(&args.out)?;
    interrupt::watch()?;
    let progress = Progress::of(args.progress, 1, args.quiet);
    let Joined { window, tiles } = join(&args.tiles, &args.out, args.over.overwrite, &progress)?;
    progress.finish();
    if args.json {
        let path = args.out.display().to_string();
        let line = json!({ "path": path, "tiles": tiles, "width": window.width(), "height": window.height() });
        return shell::print(&format!("{line}\n"));
    }
    if args.quiet {
        return Ok(());
    }
    let out = shell::printable(&args.out.display().to_string());
    shell::print(&format!("{tiles} tiles → {out}  {} × {}\n", window.width(), window.height()))
}

impl From<JoinError> for Failure {
    fn from(error: JoinError) -> Self {
        let code = match error {
            JoinError::Write(error) => return error.into(),
            JoinError::Cancelled => return Self::interrupted(),
            JoinError::Tile { .. } | JoinError::Tiles { .. } => INVALID,
            _ => FAILED,
        };
        Self::new(code, error)
    }
}
