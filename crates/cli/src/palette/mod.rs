//! `trochoid palette`: few colors whose hull encloses every pixel of pictures.
//!
//! The JSON output has `pictures`; `pixels`; `distinct`, the number of different colors, rounded to 8 bits; `corners`,
//! of their hull; `brighter`, the number of pixels with a channel beyond white, which count as white there;
//! `transparent`, the number of pixels with alpha 0, which are left out; `ignored`, the number of pixels left out by
//! --ignore; `outside` and `outside_largest`, how many pixels lie outside of the palette, and by how many steps of 8
//! bits at most; `prior`, the number of colors from --prior, which are the first of each palette; `enclosing`, a list of
//! `{colors, names, units, volume, distances, outside, largest, usual}`, palettes that enclose every pixel, or leave
//! `outside` of them no farther outside than --within allows, by `largest` at most: displayed colors from 0 to 1, parts
//! into which their grid divides a step of 8 bits, the volume of their hull relative to that of the hull of the pixels
//! and the prior colors, and the distance of each color from the nearest pixel in steps of 8 bits; `short`, a list of
//! `{colors, outside, largest, rms}`, palettes of fewer colors: the share of the pixels outside of their hull, and
//! distances from it in steps of 8 bits; `palette`, the palette that is written.

mod args;
pub(crate) mod named;
mod regions;
mod report;
pub(crate) mod source;
mod text;
pub(crate) mod write;

use crate::failure::{FAILED, Failure, MISSED};
use crate::files;
use crate::interrupt;
use crate::progress::Progress;
use crate::shell;
pub(crate) use args::Args;
use regions::RegionTones;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use trochoid::{Form, WorkingSpace};
use trochoid_palette::{Asked, Cloud, Extraction, MOST_COLORS, Palette, extract};

/// What was found in pictures.
struct Found {
    pictures: Vec<PathBuf>,
    cloud: Cloud,
    /// Number of pixels that are brighter than white.
    brighter: u64,
    /// Number of pixels that are transparent.
    transparent: u64,
    /// Number of pixels that no palette has to enclose.
    ignored: u64,
    /// Number of prior colors.
    prior: usize,
    palettes: Extraction,
    /// The first picture, if a page is written.
    preview: Option<report::Preview>,
    /// The palette that is written.
    chosen: Palette,
}

/// Finds palettes of pictures, and prints or writes them.
///
/// # Errors
/// All problems that can be found in advance, together; a picture cannot be read; no palette has as many colors as were
/// asked for; or a file cannot be written.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let pictures = source::files(&args.pictures, args.frames.as_deref())?;
    let inputs: Vec<&Path> = pictures.iter().chain(&args.prior).map(PathBuf::as_path).collect();
    let mut faults: Vec<Failure> = Vec::new();
    let mut writes = |path: &Path, form: Form| {
        let is_input = inputs.iter().any(|input| trochoid::resolved(input) == trochoid::resolved(path));
        faults.extend(is_input.then(|| files::written_over(path)));
        let cannot = || trochoid::check_destination(path).err().map(Failure::from);
        faults.extend(args.files.over.foreign(path, form).or_else(cannot));
    };
    args.out.iter().filter_map(|out| Some((out, write::form(out)?))).for_each(|(out, form)| writes(out, form));
    args.report.iter().for_each(|page| writes(page, Form::Page));
    faults.extend(args.report.iter().filter_map(|page| files::ending("--report", page, "html")));
    faults.extend(args.out.iter().filter(|out| write::form(out).is_none()).map(|out| write::no_form(out)));
    faults.extend(RegionTones::twice(&args.region).map(|name| {
        let message = format!("--region {name}=…: found two regions of this name; expected one");
        Failure::usage(message, "give each a name of its own")
    }));
    Failure::all(faults)?;
    let prior = args.prior.as_deref().map(prior).transpose()?.unwrap_or_default();
    interrupt::watch()?;
    let found = find(args, pictures, prior)?;
    Failure::all(args.out.iter().filter_map(|out| write::unfit(out, &found.chosen)))?;
    for out in &args.out {
        write::write(out, &found.chosen, &args.files.over)?;
    }
    if let Some(page) = &args.report {
        report::write(page, &found, args.files.over.overwrite)?;
    }
    if args.json {
        return shell::print_json(&as_json(&found));
    }
    if args.quiet { Ok(()) } else { shell::print(&text::text(&found)) }
}

/// Reads the colors that are to be kept.
///
/// # Errors
/// The file cannot be read, is no palette, or has colors that cannot be displayed, or too many.
fn prior(path: &Path) -> Result<Vec<(String, [f64; 3])>, Failure> {
    let named::Named { names, colors } = named::read(path, WorkingSpace::Srgb)?;
    if names.len() > MOST_COLORS {
        let message = format!("{}: found {} colors; expected at most {MOST_COLORS}", path.display(), names.len());
        return Err(Failure::usage(message, "leave colors out that need not be kept"));
    }
    let prior: Vec<(String, [f64; 3])> = names.into_iter().zip(colors).collect();
    let beyond = prior.iter().filter(|(_, color)| color.iter().any(|v| !(0.0..=1.0).contains(v)));
    Failure::all(beyond.map(|(name, color)| {
        let message = format!("{}: {name}: found {color:?}; expected what can be displayed, 0 to 1", path.display());
        Failure::usage(message, "correct the color, or leave it out")
    }))?;
    Ok(prior)
}

/// Reads pictures, and finds their palettes.
///
/// # Errors
/// A picture cannot be read, or no palette has as many colors as were asked for.
fn find(args: &Args, pictures: Vec<PathBuf>, prior: Vec<(String, [f64; 3])>) -> Result<Found, Failure> {
    let mut progress = Progress::new(pictures.len(), args.quiet);
    let (mut cloud, mut tones) = (Cloud::new(), RegionTones::new(&args.region));
    let (mut brighter, mut transparent, mut preview) = (0, 0, None);
    for (index, picture) in pictures.iter().enumerate() {
        progress.begin(index, index as i64 + 1);
        let pixels = source::pixels(picture, &progress)?;
        let (window, before) = (pixels.window, cloud.pixels());
        let size = [window.width(), window.height()];
        if args.report.is_some() && index == 0 {
            preview = Some(report::Preview::of(&pixels));
        }
        let mut seen = 0;
        for (place, color) in pixels.seen() {
            seen += 1;
            if !args.region.is_empty() && !args.region.iter().any(|region| region.contains(place, size)) {
                continue;
            }
            let color = color.map(f64::from);
            if args.by_region {
                tones.add(place, size, color);
            }
            let color = color.map(|channel| 255.0 * channel);
            brighter += u64::from(color.iter().any(|channel| *channel > 255.0 + 1e-4));
            cloud.add_between(color);
        }
        transparent += (pixels.colors.len() - seen) as u64;
        if cloud.pixels() == before && !args.region.is_empty() {
            let (name, [width, height]) = (picture.display(), size);
            let seen = if seen < width * height { " that are not transparent" } else { "" };
            let message = format!("{name}: found {width} × {height} pixels, none of them in a --region{seen}");
            return Err(Failure::usage(message, "correct the region: x and y are of its upper left corner, in pixels"));
        }
    }
    progress.finish();
    if cloud.pixels() == 0 {
        return Err(Failure::usage(
            "found no pixel that is not transparent; expected a picture",
            "give one with alpha above 0",
        ));
    }
    let kept = args.ignore.map(|share| cloud.without(share));
    let ignored = kept.as_ref().map_or(0, |kept| cloud.pixels() - kept.pixels());
    let count = prior.len();
    let asked = Asked { within: args.within.unwrap_or(0.0), prior };
    let (palettes, chosen) = if args.by_region {
        (Extraction::default(), tones.palette())
    } else {
        let palettes = extract(kept.as_ref().unwrap_or(&cloud), &asked);
        let chosen = choose(args, &palettes)?;
        (palettes, chosen)
    };
    Ok(Found { pictures, cloud, brighter, transparent, ignored, prior: count, palettes, preview, chosen })
}

/// Returns the palette that is asked for.
fn choose(args: &Args, found: &Extraction) -> Result<Palette, Failure> {
    let missed = |message: String, remedy: &str| Failure::new(MISSED, format!("{message}\n  remedy: {remedy}"));
    let fewest = args.within.is_some() || args.prior.is_some();
    let chosen = match args.colors.map(usize::from) {
        None if fewest => found.fewest().ok_or_else(|| Failure::new(FAILED, "found no palette; expected one"))?,
        None => found.usual().ok_or_else(|| Failure::new(FAILED, "found no palette; expected one"))?,
        Some(count) => found.of(count).ok_or_else(|| {
            let counts: Vec<String> = found.enclosing.iter().map(|found| found.count().to_string()).collect();
            missed(
                format!(
                    "found no palette of {count} colors that encloses every pixel; expected one of {} colors",
                    counts.join(", ")
                ),
                "ask for one of these numbers with --colors, or for a part of the picture with --region",
            )
        })?,
    };
    Ok(chosen.palette.clone())
}

fn as_json(found: &Found) -> Value {
    let Found { cloud, palettes, chosen, .. } = found;
    let outside = chosen.outside(cloud);
    let enclosing = palettes.enclosing.iter().map(|own| {
        json!({
            "colors": own.palette.colors,
            "names": own.palette.names,
            "units": own.palette.units,
            "volume": own.volume,
            "distances": own.distances,
            "outside": own.outside.pixels,
            "largest": own.outside.largest,
            "usual": palettes.usual() == Some(own),
        })
    });
    let short = palettes.short.iter().map(|short| {
        json!({
            "colors": short.colors,
            "outside": short.share,
            "largest": short.outside.largest,
            "rms": short.outside.rms,
        })
    });
    json!({
        "pictures": found.pictures.iter().map(|picture| picture.display().to_string()).collect::<Vec<_>>(),
        "pixels": cloud.pixels(),
        "distinct": palettes.distinct,
        "corners": palettes.corners,
        "brighter": found.brighter,
        "transparent": found.transparent,
        "ignored": found.ignored,
        "outside": outside.pixels,
        "outside_largest": outside.largest,
        "prior": found.prior,
        "enclosing": enclosing.collect::<Vec<_>>(),
        "short": short.collect::<Vec<_>>(),
        "palette": write::colors(chosen),
    })
}
