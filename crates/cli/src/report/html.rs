//! `report.html`: one page that needs no other file, no network and no script.

use super::data::Report;
use super::escape::escape;
use super::numbers::{count, short};
use super::plots::{self, Outcome};
use super::{pictures, tables};
use std::fmt::Write as _;
use trochoid::accuracy::Rung;
use trochoid::{GENERATOR, VERSION};

/// Everything.
///
/// # Errors
/// A plot cannot be laid out, or a picture not be encoded.
pub(super) fn page(report: &Report<'_>) -> Outcome<String> {
    let ladder = report.ladder;
    let format = ladder.format;
    let title = escape(&format!("{}: error against run time", report.scene));
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"generator\" content=\"{GENERATOR}{VERSION}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <style>\n{}</style>\n</head>\n<body>\n<h1>{title}</h1>\n",
        include_str!("style.css")
    );
    let _ = writeln!(
        page,
        "<p class=\"facts\">Output “{}”, frame {}, {} × {} pixels of {}, {}. Errors are in units of {}, where colors \
         reach from 0 to 1.</p>",
        escape(&ladder.output),
        ladder.frame,
        format.width(),
        format.height(),
        count(format.samples() as usize, "sample"),
        count(ladder.threads, "thread"),
        report.space.name(),
    );
    let strips = report.on_strips();
    let _ = writeln!(page, "<p class=\"summary\">{}</p>", escape(&report.summary().join(" ")));
    section(
        &mut page,
        "Error against time",
        &format!(
            "What each of the settings costs, and how far its pixels may lie (certified) and do lie (measured){strips} from the f64 \
             reference; down and to the left is better."
        ),
        &plot(report, plots::time(report)?, "Error against time"),
    );
    section(
        &mut page,
        "Certified against measured",
        "A bound holds if its point lies on the line or above; the higher above, the more cautious it is.",
        &plot(report, plots::measured(report)?, "Certified against measured errors"),
    );
    section(
        &mut page,
        "Tolerance asked, and achieved",
        &format!(
            "Each tolerance of displayed values, at the error that it allows in the working space, and what the fastest method \
             that meets it is certified to{strips}; or, of a refused one, the best that can be had. Methods are those among which \
             <code>trochoid plan</code> chooses: a coarser or finer mesh is none, because it changes what is ambiguous."
        ),
        &plot(report, plots::asked(report)?, "Tolerance asked against error achieved"),
    );
    if let Some(svg) = plots::passes(report)? {
        section(
            &mut page,
            "Error by pass",
            "Each pass's share: by how much the bound falls, on average over pixels in no doubt, if this pass alone has no \
             errors of its own.",
            &figure(&svg, "Error by pass"),
        );
    }
    let work = match plots::scalings(report)? {
        Some(svg) => figure(&svg, "Run time by knobs"),
        None => "<p>No node that this output needs has a knob with which work grows.</p>".into(),
    };
    section(
        &mut page,
        "Cost against waves and grid",
        "Time of a frame over knobs with which work grows, one varied at a time from a quarter of its value to twice it.",
        &work,
    );
    section(
        &mut page,
        "Picture and error",
        "The picture beside what is certain of it: of each pixel, the largest bound of its channels, which holds in doubt as well.",
        &maps(report)?,
    );
    section(
        &mut page,
        "Left out",
        "Nodes, or parts of their work, that this output does not need, and what they would take if they were not left out.",
        &tables::savings(report),
    );
    section(
        &mut page,
        "All settings",
        "Every figure by settings, the coarsest first; in color those than which no others are both faster and certified to less. \
         In italics coarser and finer meshes, among which <code>trochoid plan</code> does not choose.",
        &tables::rungs(report),
    );
    let _ = writeln!(page, "<footer>Trochoid {VERSION}</footer>\n</body>\n</html>");
    Ok(page)
}

fn section(page: &mut String, title: &str, caption: &str, content: &str) {
    let _ = writeln!(page, "<section>\n<h2>{title}</h2>\n<p class=\"caption\">{caption}</p>\n{content}\n</section>");
}

fn figure(svg: &str, name: &str) -> String {
    let named = svg.replacen("<svg ", &format!("<svg role=\"img\" aria-label=\"{name}\" "), 1);
    format!("<figure>\n{named}</figure>")
}

/// A plot, or why there is none.
fn plot(report: &Report<'_>, svg: Option<String>, name: &str) -> String {
    match svg {
        Some(svg) => figure(&svg, name),
        None => {
            let why = report.uncertain().unwrap_or_else(|| "No settings have errors above 0 to be drawn.".into());
            format!("<p>{}</p>", escape(&why))
        }
    }
}

/// The picture, and where all is certified the maps of all methods on one scale.
fn maps(report: &Report<'_>) -> Outcome<String> {
    let methods: Vec<_> = report.rungs().filter(|(rung, _)| rung.is_method).collect();
    let Some((best, label)) = methods.last() else { return Ok(String::new()) };
    let mut all = picture(&pictures::shown(&best.picture, report.space)?, &format!("The picture, {label}"));
    let mapped = || methods.iter().filter(|(rung, _)| !rung.map.is_empty());
    let scale = pictures::scale(mapped().map(|(rung, _)| *rung));
    if let Some(scale) = &scale {
        for (rung, label) in mapped() {
            all.push_str(&picture(&pictures::map(rung, scale)?, &format!("Certified error, {label}{}", worst(rung))));
        }
    }
    let below = match &scale {
        Some(scale) => figure(&plots::bar(scale)?, "Scale of errors"),
        None if mapped().next().is_some() => "<p>All bounds are 0.</p>".into(),
        None => {
            "<p>Only strips, an eighth of the picture together, were certified: <code>--whole</code> certifies all of \
                 it, and maps the errors here.</p>"
                .into()
        }
    };
    Ok(format!("<div class=\"pictures\">\n{all}</div>\n{below}"))
}

fn worst(rung: &Rung) -> String {
    format!(": at most {} where it is in no doubt", short(rung.certified.max))
}

fn picture(data: &str, name: &str) -> String {
    let name = escape(name);
    format!("<figure><img src=\"{data}\" alt=\"{name}\"><figcaption>{name}</figcaption></figure>\n")
}
