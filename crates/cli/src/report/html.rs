//! `report.html`: one page that needs no other files, no network, and no scripts.

use super::data::{Report, certified};
use super::escape::escape;
use super::numbers::{count, place, short};
use super::plots::{self, Outcome};
use super::{pictures, tables};
use std::fmt::Write as _;
use trochoid::accuracy::Rung;
use trochoid::{GENERATOR, VERSION};

/// Returns the whole page.
///
/// # Errors
/// A plot cannot be laid out, or a picture cannot be encoded.
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
        "<p class=\"facts\">Output “{}”, frame {}, {} × {} pixels of {}, {}. Errors are in {}; intervals, \
         in brackets, contain the true figure with a confidence of 95 %.</p>",
        escape(&ladder.output),
        ladder.frame,
        format.width(),
        format.height(),
        count(format.samples() as usize, "sample"),
        count(ladder.threads, "thread"),
        report.unit(),
    );
    let pixels = report.at_pixels();
    let _ = writeln!(page, "<div class=\"summary\">");
    for sentence in report.summary() {
        let _ = writeln!(page, "<p>{}</p>", escape(&sentence));
    }
    let _ = writeln!(page, "</div>");
    section(
        &mut page,
        "Error against time",
        &format!(
            "The cost of each of the settings, and how far its pixels can be (certified) and are (measured){pixels} from \
             the f64 reference, where no sample is ambiguous; lower and farther left is better. Lines across reach from \
             the shortest to the longest of all runs. Lines up and down are intervals of the error that 90 % of all \
             pixels do not exceed, with ambiguous samples."
        ),
        &plot(report, plots::time(report)?, "Error against time"),
    );
    if let Some(svg) = plots::times(report)? {
        section(
            &mut page,
            "Rendering and certifying",
            "Time of rendering a frame, and of certifying all of its pixels.",
            &figure(&svg, "Time of rendering and certifying"),
        );
    }
    section(
        &mut page,
        "Certified against measured",
        "A bound holds if its point lies on or above the line; the farther above, the more conservative the bound.",
        &plot(report, plots::measured_and_certified(report)?, "Certified against measured errors"),
    );
    section(
        &mut page,
        "Tolerance requested and achieved",
        &format!(
            "Each tolerance of displayed values, as the error that it allows in the working space, against the certified \
             error{pixels} of the fastest method that meets it; if a tolerance is refused, against the smallest certified \
             error. Methods are the settings that <code>trochoid plan</code> chooses from; coarser and finer meshes are not \
             among them, because they change which samples are ambiguous. <code>plan</code> itself certifies each sample of \
             the whole picture."
        ),
        &plot(report, plots::asked(report)?, "Tolerance requested against error achieved"),
    );
    if let Some(svg) = plots::passes(report)? {
        section(
            &mut page,
            "Error by pass",
            &format!(
                "The share of each pass: how much the bound falls, averaged over a few pixels without ambiguous samples, \
                 if only this pass has no errors of its own. Sums are in units of {}.",
                report.space.name()
            ),
            &figure(&svg, "Error by pass"),
        );
    }
    let work = match plots::scalings(report)? {
        Some(svg) => figure(&svg, "Run time by knobs"),
        None if report.ladder.costly == 0 => {
            "<p>No node that this output needs has a knob that increases its work.</p>".into()
        }
        None => {
            let knobs = count(report.ladder.costly, "knob");
            format!("<p>Left to <code>--whole</code>: the time over the values of {knobs}.</p>")
        }
    };
    section(
        &mut page,
        "Cost against waves and grid",
        "Time per frame over the knobs that increase work, each varied alone from a quarter of its value to twice its \
         value.",
        &work,
    );
    section(
        &mut page,
        "Picture and error",
        "The picture and its certified error in display values: the largest bound of each pixel's channels, which holds for \
         ambiguous samples, too.",
        &maps(report)?,
    );
    section(
        &mut page,
        "Left out",
        "Nodes, or parts of their work, that this output does not need, and the time that they would take if not left \
         out.",
        &tables::savings(report),
    );
    section(
        &mut page,
        "All settings",
        "All figures by settings, coarsest first. In color: no other settings are certified to a smaller error in a time \
         that is no longer beyond the spread. In italics: coarser and finer meshes, which <code>trochoid plan</code> does not choose from.",
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

/// Returns a plot, or the reason that there is none.
fn plot(report: &Report<'_>, svg: Option<String>, name: &str) -> String {
    match svg {
        Some(svg) => figure(&svg, name),
        None => {
            let why = report.uncertain().unwrap_or_else(|| "No settings have errors above 0 to draw.".into());
            format!("<p>{}</p>", escape(&why))
        }
    }
}

/// Returns the picture and, if the whole picture is certified, the error maps of all methods on one scale.
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
        None => "<p>Left to <code>--whole</code>: the bounds of all pixels with their map.</p>".into(),
    };
    Ok(format!("<div class=\"pictures\">\n{all}</div>\n{below}"))
}

fn worst(rung: &Rung) -> String {
    certified(rung).map_or_else(String::new, |at| {
        format!(": at most {} where not ambiguous, at {}", short(at.size.display), place(at.pixel))
    })
}

fn picture(data: &str, name: &str) -> String {
    let name = escape(name);
    format!("<figure><img src=\"{data}\" alt=\"{name}\"><figcaption>{name}</figcaption></figure>\n")
}
