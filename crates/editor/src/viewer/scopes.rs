//! Scopes of the shown picture: histogram, waveform and vectorscope.

use crate::document::swatches::{Swatch, SwatchKey};
use crate::evaluate::Screen;
use crate::state::State;
use egui::{
    Align2, Color32, ColorImage, Context, FontId, Painter, Pos2, Rect, Sense, Stroke, StrokeKind, TextureHandle,
    TextureOptions, Ui, WidgetInfo, WidgetType, pos2, vec2,
};
use std::sync::Arc;

/// Width of the strip of scopes, in points.
pub(super) const WIDTH: f32 = 190.0;
/// Most pixels that are counted; of larger pictures, those of a regular grid.
const SAMPLES: usize = 1 << 18;
/// Levels of an 8-bit channel.
const LEVELS: usize = 256;
/// Rows of a histogram.
const BARS: usize = 96;
/// Columns and rows of a waveform, and side of a vectorscope.
const WAVE: [usize; 2] = [256, 128];
const SIDE: usize = 192;
/// Luma weights of Rec. 709, for encoded values.
const LUMA: [f32; 3] = [0.2126, 0.7152, 0.0722];
/// Color of the three channels.
const CHANNELS: [[u8; 3]; 3] = [[0xff, 0x50, 0x48], [0x50, 0xe0, 0x60], [0x58, 0x90, 0xff]];

/// The scopes of the viewer.
#[derive(Default)]
pub(super) struct Scopes {
    pub(super) shown: bool,
    made: Option<(Arc<Screen>, Drawn)>,
}

/// The scopes of a picture.
struct Drawn {
    bars: TextureHandle,
    wave: TextureHandle,
    vectors: TextureHandle,
}

/// Pixels of a picture, counted.
#[derive(Debug, PartialEq)]
struct Counts {
    /// Pixels of each level, by channel.
    levels: [[u32; LEVELS]; 3],
    /// Pixels of each column and level of the waveform, from the top, by channel.
    wave: Vec<[u32; 3]>,
    /// Pixels of each place of the vectorscope, from the top.
    vectors: Vec<u32>,
}

impl Counts {
    fn of(screen: &Screen) -> Self {
        let mut counts =
            Self { levels: [[0; LEVELS]; 3], wave: vec![[0; 3]; WAVE[0] * WAVE[1]], vectors: vec![0; SIDE * SIDE] };
        let [width, height] = screen.size;
        let step = (1..).find(|step| width.div_ceil(*step) * height.div_ceil(*step) <= SAMPLES).unwrap_or(1);
        for y in (0..height).step_by(step) {
            let row = &screen.pixels[4 * y * width..4 * (y + 1) * width];
            for (x, pixel) in row.chunks_exact(4).enumerate().step_by(step) {
                // A pixel of a small picture, such as a coarse one, is as wide as several columns.
                let column = x * WAVE[0] / width;
                let columns = column..((x + step) * WAVE[0] / width).clamp(column + 1, WAVE[0]);
                for (channel, level) in pixel[..3].iter().enumerate() {
                    counts.levels[channel][usize::from(*level)] += 1;
                    let row = row_of(*level) * WAVE[0];
                    counts.wave[row + columns.start..row + columns.end].iter_mut().for_each(|cell| cell[channel] += 1);
                }
                let at = vector([0, 1, 2].map(|channel| f32::from(pixel[channel]) / 255.0));
                let cell = |share: f32| ((share * SIDE as f32) as usize).min(SIDE - 1);
                counts.vectors[cell(at.y) * SIDE + cell(at.x)] += 1;
            }
        }
        counts
    }
}

/// Returns the row of the waveform that a level is in: 255 is at the top.
fn row_of(level: u8) -> usize {
    (255 - usize::from(level)) * WAVE[1] / LEVELS
}

/// Returns the place of a color in the vectorscope, in fractions of its area: the color differences of Rec. 709, blue to
/// the right and red up. Grays are in the middle.
fn vector(color: [f32; 3]) -> Pos2 {
    let luma: f32 = color.iter().zip(LUMA).map(|(value, share)| value * share).sum();
    let (blue, red) = ((color[2] - luma) / (2.0 * (1.0 - LUMA[2])), (color[0] - luma) / (2.0 * (1.0 - LUMA[0])));
    pos2(0.5 + blue, 0.5 - red)
}

impl Scopes {
    /// Draws the scopes of a picture into a strip.
    pub(super) fn ui(&mut self, ui: &mut Ui, strip: Rect, state: &State, screen: &Arc<Screen>) {
        ui.painter().rect_filled(strip, 0.0, ui.visuals().panel_fill);
        let drawn = match self.made.take().filter(|(of, _)| Arc::ptr_eq(of, screen)) {
            Some((_, drawn)) => drawn,
            None => Drawn::new(ui.ctx(), screen),
        };
        let room = strip.shrink2(vec2(6.0, 2.0));
        let gap = 18.0;
        let height = (room.height() / 3.0 - gap).max(24.0);
        let areas = [0, 1, 2].map(|place| {
            let top = room.top() + gap + place as f32 * (height + gap);
            Rect::from_min_size(pos2(room.left(), top), vec2(room.width(), height))
        });
        let names = ["Histogram", "Waveform", "Vectorscope"];
        let helps = [
            "How many pixels each channel has at each level, from black to white",
            "The levels of each channel, from black below to white above, for each column of the picture",
            "Hue around the middle, and saturation outwards; rings are the colors of the palette",
        ];
        for ((area, name), help) in areas.into_iter().zip(names).zip(helps) {
            let font = FontId::proportional(11.0);
            let color = ui.visuals().weak_text_color();
            ui.painter().text(area.left_top() - vec2(0.0, 2.0), Align2::LEFT_BOTTOM, name, font, color);
            ui.painter().rect_filled(area, 2.0, Color32::from_gray(0x12));
            let response = ui.interact(area, ui.id().with(name), Sense::hover());
            response.widget_info(|| WidgetInfo::labeled(WidgetType::Image, true, name));
            response.on_hover_text(help);
        }
        image_ui(&ui.painter().with_clip_rect(areas[0]), areas[0], &drawn.bars);
        wave_ui(&ui.painter().with_clip_rect(areas[1]), areas[1], &drawn.wave);
        vectors_ui(&ui.painter().with_clip_rect(areas[2]), areas[2], &drawn.vectors, &state.swatches());
        self.made = Some((screen.clone(), drawn));
    }
}

impl Drawn {
    fn new(context: &Context, screen: &Screen) -> Self {
        let counts = Counts::of(screen);
        // The brightness of a place grows with the logarithm of its count, so that few pixels are seen, too.
        let strength = |count: u32, most: u32| match count {
            0 => 0.0,
            count => 0.25 + 0.75 * (count as f32).ln_1p() / (most.max(1) as f32).ln_1p(),
        };
        let bars = context.load_texture("histogram", histogram(&counts), TextureOptions::LINEAR);
        let most = counts.wave.iter().flatten().copied().max().unwrap_or(1);
        // Where all channels are, the sum is not yet white.
        let pixel = |cell: &[u32; 3]| additive(cell.map(|count| 0.6 * strength(count, most)));
        let wave = ColorImage::new(WAVE, counts.wave.iter().map(pixel).collect());
        let most = counts.vectors.iter().copied().max().unwrap_or(1);
        let gray = |count: &u32| Color32::from_white_alpha((255.0 * strength(*count, most)) as u8);
        let vectors = ColorImage::new([SIDE, SIDE], counts.vectors.iter().map(gray).collect());
        Self {
            wave: context.load_texture("waveform", wave, TextureOptions::LINEAR),
            vectors: context.load_texture("vectorscope", vectors, TextureOptions::LINEAR),
            bars,
        }
    }
}

/// Draws the bars of all channels over each other.
fn histogram(counts: &Counts) -> ColorImage {
    // The highest bar is not that of black or white alone, which flat parts of pictures fill.
    let inner = counts.levels.iter().flat_map(|levels| &levels[1..LEVELS - 1]).copied().max().unwrap_or(0);
    let most = if inner > 0 { inner } else { counts.levels.iter().flatten().copied().max().unwrap_or(1) };
    let share = |count: u32| (count as f32 / most.max(1) as f32).min(1.0).sqrt();
    let pixel = |at: usize| {
        let (level, above) = (at % LEVELS, 1.0 - (at / LEVELS) as f32 / BARS as f32);
        let filled = |channel: usize| if share(counts.levels[channel][level]) >= above { 1.0 } else { 0.0 };
        additive([0, 1, 2].map(|channel| 0.5 * filled(channel)))
    };
    ColorImage::new([LEVELS, BARS], (0..LEVELS * BARS).map(pixel).collect())
}

/// Returns the light of the three channels in these strengths.
fn additive(strengths: [f32; 3]) -> Color32 {
    let mut sum = [0.0_f32; 3];
    for (strength, color) in strengths.into_iter().zip(CHANNELS) {
        sum.iter_mut().zip(color).for_each(|(sum, value)| *sum += strength * f32::from(value));
    }
    let [r, g, b] = sum.map(|value| value.min(255.0) as u8);
    Color32::from_rgb_additive(r, g, b)
}

fn image_ui(painter: &Painter, area: Rect, texture: &TextureHandle) {
    painter.image(texture.id(), area, Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0)), Color32::WHITE);
}

fn wave_ui(painter: &Painter, area: Rect, texture: &TextureHandle) {
    for share in [0.25, 0.5, 0.75] {
        painter.hline(area.x_range(), area.top() + share * area.height(), Stroke::new(1.0, Color32::from_gray(0x2c)));
    }
    image_ui(painter, area, texture);
}

fn vectors_ui(painter: &Painter, area: Rect, texture: &TextureHandle, swatches: &[Swatch]) {
    let side = area.size().min_elem();
    let area = Rect::from_center_size(area.center(), vec2(side, side));
    let place = |at: Pos2| area.min + at.to_vec2() * area.size();
    let lines = Stroke::new(1.0, Color32::from_gray(0x34));
    painter.circle_stroke(area.center(), 0.5 * side - 1.0, lines);
    painter.hline(area.x_range(), area.center().y, lines);
    painter.vline(area.center().x, area.y_range(), lines);
    for (name, color) in [
        ("R", [1.0, 0.0, 0.0]),
        ("Y", [1.0, 1.0, 0.0]),
        ("G", [0.0, 1.0, 0.0]),
        ("C", [0.0, 1.0, 1.0]),
        ("B", [0.0, 0.0, 1.0]),
        ("M", [1.0, 0.0, 1.0]),
    ] {
        let at = place(pos2(0.5, 0.5) + 0.86 * (vector(color) - pos2(0.5, 0.5)));
        painter.text(at, Align2::CENTER_CENTER, name, FontId::proportional(9.0), Color32::from_gray(0x70));
    }
    image_ui(painter, area, texture);
    let named = swatches.iter().filter(|swatch| matches!(swatch.key, SwatchKey::Named(_)));
    for color in named.filter_map(|swatch| swatch.color) {
        let [r, g, b] = color.map(|channel| (255.0 * channel).round() as u8);
        let mark = Rect::from_center_size(place(vector(color)), vec2(6.0, 6.0));
        painter.rect_stroke(mark.expand(1.0), 4.0, Stroke::new(1.0, Color32::BLACK), StrokeKind::Outside);
        painter.rect_stroke(mark, 4.0, Stroke::new(1.5, Color32::from_rgb(r, g, b)), StrokeKind::Outside);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn screen(size: [usize; 2], colors: &[[u8; 3]]) -> Screen {
        Screen { size, pixels: colors.iter().flat_map(|[r, g, b]| [*r, *g, *b, 255]).collect() }
    }

    #[test]
    fn pixels_are_counted_by_level_column_and_hue() {
        let counts = Counts::of(&screen([2, 2], &[[255, 0, 0], [10, 10, 10], [255, 0, 0], [20, 20, 20]]));
        assert_eq!((counts.levels[0][255], counts.levels[1][0], counts.levels[2][10]), (2, 2, 1));
        assert_eq!(counts.levels.iter().flatten().sum::<u32>(), 12);
        // Red is at the top of the left half, its other channels at the bottom.
        assert_eq!(counts.wave[0], [2, 0, 0]);
        assert_eq!(counts.wave[(WAVE[1] - 1) * WAVE[0]], [0, 2, 2]);
        assert_eq!(counts.wave[row_of(20) * WAVE[0] + WAVE[0] / 2], [1, 1, 1]);
        // Grays are in the middle, red is up and a little to the left.
        assert_eq!(counts.vectors[SIDE / 2 * SIDE + SIDE / 2], 2);
        let red = vector([1.0, 0.0, 0.0]);
        assert!(red.y < 1e-6 && red.x < 0.5 && red.x > 0.35, "{red:?}");
        assert_eq!(counts.vectors.iter().sum::<u32>(), 4);
    }

    #[test]
    fn large_pictures_are_counted_in_part_and_evenly() {
        let size = [1024, 600];
        let colors: Vec<[u8; 3]> =
            (0..size[0] * size[1]).map(|at| if at % size[0] < 512 { [0; 3] } else { [255; 3] }).collect();
        let counts = Counts::of(&screen(size, &colors));
        let all = counts.levels[0].iter().sum::<u32>() as usize;
        assert!(all <= SAMPLES && all > SAMPLES / 8, "{all}");
        assert_eq!(counts.levels[0][0], counts.levels[0][255]);
        // Each column has only its own level.
        assert!((0..WAVE[0]).all(|x| (counts.wave[x] == [0; 3]) == (x < WAVE[0] / 2)));
    }

    #[test]
    fn every_color_has_its_place_in_the_vectorscope() {
        for r in 0..=4 {
            for g in 0..=4 {
                for b in 0..=4 {
                    let at = vector([r, g, b].map(|level| level as f32 / 4.0));
                    assert!((0.0..=1.0).contains(&at.x) && (0.0..=1.0).contains(&at.y), "{at:?}");
                }
            }
        }
    }
}
