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
        Some(Kind::View) => Color32::from_rgb(0xd8, 0x80, 0xb4),
        None => Color32::from_gray(0x80),
    }
}

/// Makes a color legible as text: darker in the light theme.
pub(crate) fn ink(color: Color32, visuals: &Visuals) -> Color32 {
    if visuals.dark_mode { color } else { color.lerp_to_gamma(Color32::BLACK, 0.5) }
}

/// Returns a color for lines on the ground of plots, which may be nearer to it than text.
pub(crate) fn line(color: Color32, visuals: &Visuals) -> Color32 {
    if visuals.dark_mode { color } else { color.lerp_to_gamma(Color32::BLACK, 0.3) }
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

/// Returns the ground of the timeline's range.
pub(crate) fn range(visuals: &Visuals) -> Color32 {
    Color32::from_gray(if visuals.dark_mode { 0x36 } else { 0xdc })
}

/// Sets the colors and spacing of both themes.
pub(crate) fn install(context: &Context) {
    context.style_mut_of(Theme::Dark, |style| {
        let visuals = &mut style.visuals;
        visuals.panel_fill = Color32::from_gray(0x26);
        visuals.window_fill = Color32::from_gray(0x2b);
        visuals.extreme_bg_color = Color32::from_gray(0x17);
        visuals.faint_bg_color = Color32::from_gray(0x2c);
        visuals.weak_text_color = Some(Color32::from_gray(0xa8));
        visuals.widgets.noninteractive.fg_stroke = Stroke::new(1.0, Color32::from_gray(0xd0));
        visuals.widgets.inactive.fg_stroke = Stroke::new(1.0, Color32::from_gray(0xd8));
        // Tracks and fields: their edges must be seen beside the ground of panels and of windows.
        visuals.widgets.inactive.bg_fill = Color32::from_gray(0x4c);
        visuals.widgets.inactive.bg_stroke = Stroke::new(1.0, Color32::from_gray(0x4c));
        visuals.selection.bg_fill = Color32::from_rgb(0x2d, 0x5d, 0x86);
        visuals.error_fg_color = Color32::from_rgb(0xf0, 0x76, 0x6a);
    });
    context.style_mut_of(Theme::Light, |style| {
        let visuals = &mut style.visuals;
        visuals.panel_fill = Color32::from_gray(0xec);
        visuals.window_fill = Color32::from_gray(0xf6);
        visuals.extreme_bg_color = Color32::from_gray(0xfc);
        visuals.faint_bg_color = Color32::from_gray(0xe4);
        visuals.weak_text_color = Some(Color32::from_gray(0x5c));
        visuals.widgets.noninteractive.fg_stroke = Stroke::new(1.0, Color32::from_gray(0x38));
        visuals.widgets.inactive.fg_stroke = Stroke::new(1.0, Color32::from_gray(0x30));
        visuals.widgets.inactive.weak_bg_fill = Color32::from_gray(0xd8);
        visuals.widgets.inactive.bg_fill = Color32::from_gray(0xbe);
        visuals.widgets.inactive.bg_stroke = Stroke::new(1.0, Color32::from_gray(0xbe));
        visuals.widgets.hovered.weak_bg_fill = Color32::from_gray(0xca);
        visuals.widgets.hovered.bg_fill = Color32::from_gray(0xb2);
        visuals.selection.bg_fill = Color32::from_rgb(0xa9, 0xcc, 0xea);
        visuals.hyperlink_color = Color32::from_rgb(0x00, 0x5c, 0xa8);
        visuals.warn_fg_color = Color32::from_rgb(0xa0, 0x46, 0x00);
        visuals.error_fg_color = Color32::from_rgb(0xb0, 0x28, 0x20);
    });
    context.all_styles_mut(|style| {
        style.spacing.item_spacing = vec2(6.0, 4.0);
        style.spacing.slider_width = 120.0;
        style.interaction.tooltip_delay = 0.4;
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the contrast of two opaque colors as WCAG 2 defines it, from 1 to 21.
    fn contrast(a: Color32, b: Color32) -> f32 {
        let luminance = |color: Color32| {
            let [r, g, b, a] = egui::Rgba::from(color).to_array();
            assert_eq!(a, 1.0, "{color:?} has no contrast of its own");
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let (a, b) = (luminance(a) + 0.05, luminance(b) + 0.05);
        a.max(b) / a.min(b)
    }

    fn installed(theme: Theme) -> Visuals {
        let context = Context::default();
        install(&context);
        context.style_of(theme).visuals.clone()
    }

    #[test]
    fn every_text_can_be_read_on_every_ground() {
        assert!((contrast(Color32::BLACK, Color32::WHITE) - 21.0).abs() < 1e-3);
        for theme in [Theme::Dark, Theme::Light] {
            let visuals = installed(theme);
            let widgets = &visuals.widgets;
            let grounds = [visuals.panel_fill, visuals.window_fill, visuals.extreme_bg_color, visuals.faint_bg_color];
            let kinds = [Kind::Color, Kind::MASK, Kind::Field(1), Kind::Surface, Kind::Camera, Kind::Light, Kind::View];
            let texts = [
                visuals.text_color(),
                visuals.weak_text_color(),
                visuals.strong_text_color(),
                visuals.hyperlink_color,
                visuals.warn_fg_color,
                error(&visuals),
                widgets.inactive.text_color(),
                widgets.hovered.text_color(),
            ];
            let inks = kinds.map(|of| ink(kind(Some(of)), &visuals));
            let on_grounds = texts.iter().chain(&inks).flat_map(|text| grounds.map(|ground| (*text, ground)));
            let on_widgets = [
                (widgets.inactive.text_color(), widgets.inactive.weak_bg_fill),
                (visuals.weak_text_color(), widgets.inactive.weak_bg_fill),
                (widgets.hovered.text_color(), widgets.hovered.weak_bg_fill),
                (visuals.selection.stroke.color, visuals.selection.bg_fill),
                (visuals.text_color(), range(&visuals)),
            ];
            for (text, ground) in on_grounds.chain(on_widgets) {
                let found = contrast(text, ground);
                assert!(found >= 4.5, "{theme:?}: {text:?} on {ground:?} is {found:.2}");
            }
        }
    }

    #[test]
    fn fields_and_tracks_stand_out_from_panels() {
        for theme in [Theme::Dark, Theme::Light] {
            let visuals = installed(theme);
            let widgets = &visuals.widgets;
            for ground in [visuals.panel_fill, visuals.window_fill] {
                for line in [widgets.inactive.bg_stroke.color, widgets.inactive.bg_fill] {
                    let found = contrast(line, ground);
                    assert!(found >= 1.5, "{theme:?}: {line:?} on {ground:?} is {found:.2}");
                }
            }
            let found = contrast(range(&visuals), visuals.extreme_bg_color);
            assert!(found >= 1.3, "{theme:?}: the range of the timeline is {found:.2}");
        }
    }
}
