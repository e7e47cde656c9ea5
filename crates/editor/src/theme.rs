//! Colors of the interface, by kind of value and by state.

use egui::{Color32, Context, Stroke, Theme, Visuals, vec2};
use trochoid::{Accepts, Kind};

/// Returns the color of a kind.
pub(crate) fn kind(kind: Option<Kind>) -> Color32 {
    match kind {
        Some(Kind::Color | Kind::Layers(_)) => Color32::from_rgb(0xe8, 0xb0, 0x4a),
        Some(Kind::Weights(_)) => Color32::from_rgb(0x5f, 0xb8, 0x72),
        Some(Kind::Field(_)) => Color32::from_rgb(0x5c, 0x9d, 0xdc),
        Some(Kind::Surface) => Color32::from_rgb(0x3f, 0xb5, 0xb0),
        Some(Kind::Camera) => Color32::from_rgb(0xb0, 0x86, 0xd8),
        Some(Kind::Light) => Color32::from_rgb(0xe8, 0x8a, 0x63),
        Some(Kind::View) => Color32::from_rgb(0xcf, 0x6f, 0xa8),
        None => Color32::from_gray(0x80),
    }
}

/// Makes a color legible as text: darker in the light theme.
pub(crate) fn ink(color: Color32, visuals: &Visuals) -> Color32 {
    if visuals.dark_mode { color } else { color.lerp_to_gamma(Color32::BLACK, 0.5) }
}

/// Returns the color of a pin by the kinds it accepts.
pub(crate) fn accepts(accepts: Accepts) -> Color32 {
    kind(match accepts {
        Accepts::Color | Accepts::Image => Some(Kind::Color),
        Accepts::Mask | Accepts::Weights => Some(Kind::MASK),
        Accepts::Scalar | Accepts::Field | Accepts::Direction => Some(Kind::Field(1)),
        Accepts::Surface => Some(Kind::Surface),
        Accepts::Camera => Some(Kind::Camera),
        Accepts::Light => Some(Kind::Light),
        Accepts::View => Some(Kind::View),
    })
}

/// Returns the color of errors.
pub(crate) fn error(visuals: &Visuals) -> Color32 {
    visuals.error_fg_color
}

/// Colors of backdrops.
pub(crate) const TINTS: [[u8; 3]; 8] = [
    [0x4a, 0x62, 0x78],
    [0x4c, 0x6b, 0x55],
    [0x7a, 0x5c, 0x45],
    [0x6c, 0x4f, 0x74],
    [0x7b, 0x4b, 0x50],
    [0x3f, 0x6d, 0x70],
    [0x70, 0x6b, 0x42],
    [0x58, 0x58, 0x5e],
];

/// Sets the colors and spacing of both themes.
pub(crate) fn install(context: &Context) {
    context.style_mut_of(Theme::Dark, |style| {
        let visuals = &mut style.visuals;
        visuals.panel_fill = Color32::from_gray(0x26);
        visuals.window_fill = Color32::from_gray(0x2b);
        visuals.extreme_bg_color = Color32::from_gray(0x17);
        visuals.faint_bg_color = Color32::from_gray(0x2c);
        visuals.widgets.noninteractive.fg_stroke = Stroke::new(1.0, Color32::from_gray(0xc4));
        visuals.widgets.inactive.fg_stroke = Stroke::new(1.0, Color32::from_gray(0xd0));
        visuals.selection.bg_fill = Color32::from_rgb(0x2d, 0x5d, 0x86);
        visuals.error_fg_color = Color32::from_rgb(0xec, 0x6a, 0x5e);
    });
    context.style_mut_of(Theme::Light, |style| {
        let visuals = &mut style.visuals;
        visuals.panel_fill = Color32::from_gray(0xec);
        visuals.window_fill = Color32::from_gray(0xf6);
        visuals.extreme_bg_color = Color32::from_gray(0xfc);
        visuals.selection.bg_fill = Color32::from_rgb(0xa9, 0xcc, 0xea);
        visuals.error_fg_color = Color32::from_rgb(0xb8, 0x2c, 0x22);
    });
    context.all_styles_mut(|style| {
        style.spacing.item_spacing = vec2(6.0, 4.0);
        style.spacing.slider_width = 120.0;
        style.interaction.tooltip_delay = 0.4;
    });
}
