//! The page about a palette as HTML.

use super::super::Found;
use super::super::write::hex;
use super::{curve, shares, space};
use crate::report::escape::escape;
use crate::report::numbers::percent;
use std::error::Error;
use std::fmt::Write as _;
use trochoid::{GENERATOR, VERSION};
use trochoid_palette::Outside;

/// Returns the whole page.
///
/// # Errors
/// The picture cannot be encoded.
pub(super) fn page(found: &Found) -> Result<String, Box<dyn Error>> {
    let name = |path: &std::path::PathBuf| path.file_name().unwrap_or(path.as_os_str()).display().to_string();
    let names: Vec<String> = found.pictures.iter().map(name).collect();
    let title = match &names[..] {
        [] => "Palette".into(),
        [one] => format!("Palette of {one}"),
        [first, others @ ..] => format!("Palette of {first} and {} more", others.len()),
    };
    let title = escape(&title);
    let cells = space::cells(&found.cloud);
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"generator\" content=\"{GENERATOR}{VERSION}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <style>\n{}{}</style>\n</head>\n<body>\n<h1>{title}</h1>\n",
        include_str!("../../report/style.css"),
        include_str!("palette.css")
    );
    facts(&mut page, found);
    let outside = found.chosen.outside(&found.cloud);
    let _ = writeln!(page, "<div class=\"lead\">\n<div class=\"summary\"><p>{}</p></div>", verdict(found, &outside));
    if let Some(preview) = &found.preview {
        let alt = escape(names.first().map_or("", String::as_str));
        let _ = writeln!(page, "<figure><img src=\"{}\" alt=\"{alt}\"></figure>", preview.data_url()?);
    }
    page.push_str("</div>\n");
    swatches(&mut page, found, shares(&found.chosen, &cells).as_deref());
    hull(&mut page, found, &outside);
    if !found.palettes.enclosing.is_empty() {
        counts(&mut page, found);
    }
    let data = space::space(found, &cells).to_string().replace('<', "\\u003c");
    let _ = writeln!(
        page,
        "<footer>Trochoid {VERSION}</footer>\n<script type=\"application/json\" id=\"space\">{data}</script>\n\
         <script>\n{}</script>\n</body>\n</html>",
        include_str!("hull.js")
    );
    Ok(page)
}

fn facts(page: &mut String, found: &Found) {
    let cloud = &found.cloud;
    let counted = |count: u64, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    let mut facts = format!(
        "{} of {} in {}",
        counted(cloud.pixels(), "pixel"),
        counted(cloud.colors().count() as u64, "color"),
        counted(found.pictures.len() as u64, "picture")
    );
    let left_out =
        [(found.transparent, "transparent"), (found.ignored, "ignored"), (found.brighter, "brighter than white")];
    left_out.iter().filter(|(count, _)| *count > 0).for_each(|(count, what)| {
        let _ = write!(facts, "; {count} {what}");
    });
    let _ = writeln!(page, "<p class=\"facts\">{facts}.</p>");
}

/// Says whether the palette encloses the pixels.
fn verdict(found: &Found, outside: &Outside) -> String {
    let count = found.chosen.colors.len();
    let colors = if count == 1 { "1 color".into() } else { format!("{count} colors") };
    match outside.pixels {
        0 => format!("Every pixel is a mix of these {colors}: none lies outside of their hull."),
        pixels => format!(
            "{colors}. {} of the pixels lie outside of their hull, by {:.1} steps of 255 at most.",
            percent(pixels as f64 / found.cloud.pixels().max(1) as f64),
            outside.largest
        ),
    }
}

fn swatches(page: &mut String, found: &Found, shares: Option<&[f64]>) {
    let palette = &found.chosen;
    let measured = found.palettes.enclosing.iter().find(|own| own.palette == *palette);
    let inner = palette.inner();
    page.push_str("<ul class=\"swatches\">\n");
    for (index, (name, color)) in palette.names.iter().zip(&palette.colors).enumerate() {
        let value = match palette.units {
            1 => hex(*color),
            _ => color.map(|v| format!("{v:.4}")).join(", "),
        };
        let mut about = Vec::new();
        if let Some(shares) = shares {
            about.push(format!("{} of the picture", percent(shares[index])));
        }
        if let Some(measured) = measured {
            about.push(match measured.distances[index] {
                distance if distance < 0.5 => "a pixel has it".into(),
                distance if distance < 1.5 => "1 step from any pixel".into(),
                distance => format!("{distance:.0} steps from any pixel"),
            });
        }
        if index < found.prior {
            about.push("prior".into());
        }
        if inner.contains(&index) {
            about.push("within the hull".into());
        }
        let bar = shares.map_or(String::new(), |shares| {
            let share = 100.0 * shares[index];
            format!("<span class=\"share\" aria-hidden=\"true\"><i style=\"width:{share:.1}%\"></i></span>")
        });
        let _ = writeln!(
            page,
            "<li data-color=\"{index}\"><span class=\"color\" style=\"background:{}\"></span>\
             <b>{}</b><code>{value}</code>{bar}<small>{}</small></li>",
            hex(*color),
            // Long names break between their words.
            escape(name).replace('_', "_<wbr>"),
            about.join("<br>")
        );
    }
    page.push_str("</ul>\n");
}

fn hull(page: &mut String, found: &Found, outside: &Outside) {
    let drawn = if outside.pixels > 0 { " Red rings are pixels outside, the farthest first." } else { "" };
    let _ = writeln!(
        page,
        "<section>\n<h2>The hull in color space</h2>\n<p class=\"caption\" id=\"hull-about\">Each dot is a color of the \
         pixels, larger where there are more; large discs are the palette, and lines the edges of its hull. Black is at the \
         bottom, white at the top.{drawn} Drag to turn, or use the arrow keys; + and − zoom.</p>\n\
         <canvas id=\"hull\" tabindex=\"0\" role=\"application\" aria-roledescription=\"view in three dimensions\" \
         aria-label=\"The palette’s hull with {} colors\" aria-describedby=\"hull-about\"></canvas>\n\
         <p class=\"controls\"><label><input type=\"checkbox\" id=\"show-pixels\" checked> Pixels</label> \
         <label><input type=\"checkbox\" id=\"show-names\" checked> Names</label> \
         <button type=\"button\" id=\"reset\">Reset view</button></p>\n\
         <noscript><p>The view needs JavaScript; the tables have all figures.</p></noscript>\n</section>",
        found.chosen.colors.len()
    );
}

/// Writes what each number of colors costs, as a plot and as a table.
fn counts(page: &mut String, found: &Found) {
    page.push_str(
        "<section>\n<h2>More or fewer colors</h2>\n<p class=\"caption\">With fewer colors, the hull is larger: the colors are \
         louder, and lie farther from the pixels. <code>--colors N</code> chooses.</p>\n",
    );
    if let Some(curve) = curve::curve(found) {
        let _ = writeln!(page, "<figure>{curve}</figure>");
    }
    page.push_str(
        "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Numbers of colors\"><table>\n<thead><tr><th>colors</th>\
         <th class=\"text\">palette</th><th>hull</th><th>farthest color</th><th>pixels outside</th><th>farthest pixel</th></tr></thead>\n\
         <tbody>\n",
    );
    let pixels = found.cloud.pixels().max(1) as f64;
    let chips = |colors: &[[f64; 3]]| -> String {
        let chip = |color: &[f64; 3]| format!("<i style=\"background:{0}\" title=\"{0}\"></i>", hex(*color));
        colors.iter().map(chip).collect()
    };
    let mut row = |class: &str, colors: &[[f64; 3]], cells: [String; 4]| {
        let [volume, color, share, pixel] = cells;
        let _ = writeln!(
            page,
            "<tr{class}><td>{}</td><td class=\"text chips\">{}</td><td>{volume}</td><td>{color}</td><td>{share}</td>\
             <td>{pixel}</td></tr>",
            colors.len(),
            chips(colors)
        );
    };
    let far = |outside: &Outside| if outside.pixels == 0 { "–".into() } else { format!("{:.1}", outside.largest) };
    for short in &found.palettes.short {
        let cells = ["–".into(), "–".into(), percent(short.share), far(&short.outside)];
        row(" class=\"mesh\"", &short.colors, cells);
    }
    for own in &found.palettes.enclosing {
        let farthest = own.distances.iter().copied().fold(0.0, f64::max);
        let share = if own.outside.pixels == 0 { "none".into() } else { percent(own.outside.pixels as f64 / pixels) };
        let cells = [format!("{:.2}", own.volume), format!("{farthest:.0}"), share, far(&own.outside)];
        let class = if own.palette == found.chosen { " class=\"best\"" } else { "" };
        row(class, &own.palette.colors, cells);
    }
    page.push_str(
        "</tbody></table></div>\n<p class=\"caption note\">hull: volume, relative to the pixels’ hull. farthest color: from the \
         nearest pixel, and farthest pixel: from the hull, in steps of 255. In italics: palettes that miss pixels.</p>\n</section>\n",
    );
}
