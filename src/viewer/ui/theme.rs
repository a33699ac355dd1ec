//! Colours, sizes and type of the window.

use eframe::egui::{
    Color32, Context, CornerRadius, FontFamily, FontId, Frame, Margin, Stroke, Style, TextStyle, Theme, Vec2,
    Visuals, style::HandleShape, vec2,
};

/// Behind pictures.
pub(super) const BACK: Color32 = Color32::from_rgb(0x10, 0x12, 0x13);
/// Panels.
pub(super) const PANEL: Color32 = Color32::from_rgb(0x1a, 0x1c, 0x1e);
/// What lies on panels.
pub(super) const CARD: Color32 = Color32::from_rgb(0x23, 0x26, 0x29);
/// Fields and buttons.
pub(super) const FIELD: Color32 = Color32::from_rgb(0x2d, 0x31, 0x35);
/// The same under the pointer.
pub(super) const FIELD_HOVERED: Color32 = Color32::from_rgb(0x3a, 0x3f, 0x44);
/// Lines between things.
pub(super) const LINE: Color32 = Color32::from_rgb(0x2f, 0x33, 0x37);
/// Text.
pub(super) const TEXT: Color32 = Color32::from_rgb(0xe6, 0xe2, 0xd9);
/// Text that is looked up, not read.
pub(super) const WEAK: Color32 = Color32::from_rgb(0x9c, 0x98, 0x8e);
/// What was changed, chosen or pulled.
pub(super) const ACCENT: Color32 = Color32::from_rgb(0xd9, 0xa4, 0x4e);
/// The accent as a ground for text.
pub(super) const ACCENT_DEEP: Color32 = Color32::from_rgb(0x5c, 0x45, 0x21);
/// The part of a rail that a slider has left behind.
pub(super) const FILLED: Color32 = Color32::from_rgb(0x5e, 0x5b, 0x54);
/// Errors.
pub(super) const ERROR: Color32 = Color32::from_rgb(0xe8, 0x74, 0x5c);

/// Height of a row of a panel.
pub(super) const ROW: f32 = 25.0;
/// Width of the panel of parameters.
pub(super) const PARAMETERS: f32 = 352.0;

/// Dress the window.
pub(super) fn set(ctx: &Context) {
    ctx.set_theme(Theme::Dark);
    ctx.all_styles_mut(style);
}

fn style(style: &mut Style) {
    let size = |points| FontId::new(points, FontFamily::Proportional);
    style.text_styles = [
        (TextStyle::Small, size(11.0)),
        (TextStyle::Body, size(13.0)),
        (TextStyle::Button, size(13.0)),
        (TextStyle::Heading, size(16.0)),
        (TextStyle::Monospace, FontId::new(12.0, FontFamily::Monospace)),
    ]
    .into();
    style.drag_value_text_style = TextStyle::Body;
    style.animation_time = 0.08;
    let spacing = &mut style.spacing;
    spacing.item_spacing = vec2(8.0, 4.0);
    spacing.button_padding = vec2(9.0, 4.0);
    spacing.interact_size = vec2(32.0, 24.0);
    spacing.slider_rail_height = 4.0;
    spacing.combo_height = 420.0;
    spacing.menu_margin = Margin::same(6);
    spacing.window_margin = Margin::same(18);
    spacing.tooltip_width = 340.0;
    spacing.scroll.floating = true;
    style.interaction.selectable_labels = false;
    style.interaction.tooltip_delay = 0.35;
    style.visuals = visuals();
}

fn visuals() -> Visuals {
    let mut visuals = Visuals::dark();
    let radius = CornerRadius::same(5);
    visuals.panel_fill = PANEL;
    visuals.window_fill = CARD;
    visuals.window_stroke = Stroke::new(1.0, LINE);
    visuals.window_corner_radius = CornerRadius::same(9);
    visuals.menu_corner_radius = CornerRadius::same(7);
    visuals.extreme_bg_color = Color32::from_rgb(0x13, 0x15, 0x16);
    visuals.faint_bg_color = CARD;
    visuals.code_bg_color = BACK;
    visuals.warn_fg_color = ACCENT;
    visuals.error_fg_color = ERROR;
    visuals.hyperlink_color = ACCENT;
    visuals.weak_text_color = Some(WEAK);
    visuals.slider_trailing_fill = true;
    visuals.handle_shape = HandleShape::Circle;
    visuals.selection.bg_fill = ACCENT_DEEP;
    visuals.selection.stroke = Stroke::new(1.0, TEXT);
    let widgets = &mut visuals.widgets;
    for (widget, fill) in [
        (&mut widgets.noninteractive, CARD),
        (&mut widgets.inactive, FIELD),
        (&mut widgets.hovered, FIELD_HOVERED),
        (&mut widgets.active, FIELD_HOVERED),
        (&mut widgets.open, FIELD_HOVERED),
    ] {
        widget.bg_fill = fill;
        widget.weak_bg_fill = fill;
        widget.bg_stroke = Stroke::NONE;
        widget.corner_radius = radius;
        widget.expansion = 0.0;
        widget.fg_stroke = Stroke::new(1.0, TEXT);
    }
    widgets.noninteractive.bg_stroke = Stroke::new(1.0, LINE);
    widgets.inactive.fg_stroke = Stroke::new(1.0, Color32::from_rgb(0xc9, 0xc5, 0xbb));
    visuals
}

/// A bar or a panel: its ground, and how far what is in it keeps from the edge.
pub(super) fn panel(margin: Vec2) -> Frame {
    Frame::NONE.fill(PANEL).inner_margin(Margin::symmetric(margin.x as i8, margin.y as i8))
}
