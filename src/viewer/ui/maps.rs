//! The map viewer: one map flat, tiled, by channel, with the value under the pointer.

use std::sync::Arc;

use eframe::egui::{
    Align, Align2, Color32, ColorImage, ComboBox, FontId, Layout, Rect, RichText, Sense, TextureHandle,
    TextureOptions, Ui, Vec2, pos2, vec2,
};

use super::theme;
use crate::base::MapKind;
use crate::maps::{MapImage, TextureSet};
use crate::viewer::map_picture::{self, Channel};

/// What is shown of which map, and how near.
pub(super) struct Maps {
    kind: MapKind,
    channel: Channel,
    /// Tiles along each side.
    tiles: usize,
    /// Points of the screen for a whole tile's height, over what fits; and where the middle of the view is, in points.
    zoom: f32,
    shift: Vec2,
    texture: Option<(Key, TextureHandle)>,
}

/// What a texture shows.
#[derive(Clone)]
struct Key {
    set: Arc<TextureSet>,
    kind: MapKind,
    channel: Channel,
}

impl Maps {
    /// The colour map, one tile.
    pub(super) fn new() -> Self {
        Self {
            kind: MapKind::Color,
            channel: Channel::All,
            tiles: 1,
            zoom: 1.0,
            shift: Vec2::ZERO,
            texture: None,
        }
    }

    /// The map that is to be made.
    pub(super) fn kind(&self) -> MapKind {
        self.kind
    }

    /// Choices above the map; true if another map is wanted.
    pub(super) fn choices(&mut self, ui: &mut Ui, set: Option<&TextureSet>) -> bool {
        let before = self.kind;
        ui.label(RichText::new("Map").color(theme::WEAK));
        ComboBox::from_id_salt("map").width(150.0).selected_text(words(self.kind)).show_ui(ui, |ui| {
            for kind in MapKind::ALL {
                ui.selectable_value(&mut self.kind, kind, words(kind));
            }
        });
        ui.add_space(8.0);
        ui.label(RichText::new("Tile").color(theme::WEAK));
        for (tiles, text) in [(1, "1 × 1"), (2, "2 × 2")] {
            ui.selectable_value(&mut self.tiles, tiles, text);
        }
        let names = map_picture::channel_names(self.kind);
        if !names.is_empty() {
            ui.add_space(8.0);
            ui.label(RichText::new("Channel").color(theme::WEAK));
            ui.selectable_value(&mut self.channel, Channel::All, "All");
            for (i, name) in names.iter().enumerate() {
                ui.selectable_value(&mut self.channel, Channel::One(i), *name);
            }
        }
        ui.add_space(8.0);
        if ui.button("Fit").on_hover_text("The whole map. A double click does it, too.").clicked() {
            self.fit();
        }
        if let Some(map) = set.and_then(|set| set.maps.get(&self.kind)) {
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let text = legend(map, self.channel);
                ui.label(RichText::new(text).color(theme::WEAK));
            });
        }
        if before != self.kind {
            self.channel = Channel::All;
        }
        before != self.kind
    }

    fn fit(&mut self) {
        (self.zoom, self.shift) = (1.0, Vec2::ZERO);
    }

    /// The map.
    pub(super) fn show(&mut self, ui: &mut Ui, set: Option<&Arc<TextureSet>>, busy: bool) {
        let rect = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 0.0, theme::BACK);
        let map = set.and_then(|set| Some((set, set.maps.get(&self.kind)?)));
        let Some((set, map)) = map else {
            let text = if busy { "Making the map…" } else { "This preset has no such map" };
            painter.text(rect.center(), Align2::CENTER_CENTER, text, FontId::proportional(15.0), theme::WEAK);
            return;
        };
        let key = Key { set: set.clone(), kind: self.kind, channel: self.channel };
        if !self.texture.as_ref().is_some_and(|(k, _)| k.is(&key)) {
            let [width, height] = [set.domain.width, set.domain.height];
            let (shown, size) = fitting(&map_picture::pixels(map, self.channel), [width, height], ui);
            let image = ColorImage::from_rgb(size, &shown);
            let texture = ui.ctx().load_texture("map", image, TextureOptions::LINEAR);
            self.texture = Some((key, texture));
        }
        // Tiles as large as fit, then nearer.
        let tile_mm = vec2(set.domain.girth_mm, set.domain.length_mm);
        let all = tile_mm * self.tiles as f32;
        let fit = ((rect.width() - 48.0) / all.x).min((rect.height() - 48.0) / all.y).max(1e-6);
        if response.hovered() {
            let scroll = ui.input(|i| (i.smooth_scroll_delta.y * 0.004).exp() * i.zoom_delta());
            let zoom = (self.zoom * scroll).clamp(0.2, 200.0);
            if let Some(pointer) = response.hover_pos() {
                // What is under the pointer stays there.
                let from = pointer - rect.center();
                self.shift = from - (from - self.shift) * (zoom / self.zoom);
            }
            self.zoom = zoom;
        }
        self.shift += response.drag_delta();
        if response.double_clicked() {
            self.fit();
        }
        let tile = tile_mm * (fit * self.zoom);
        let corner = rect.center() + self.shift - tile * (0.5 * self.tiles as f32);
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        if let Some((_, texture)) = &self.texture {
            for i in 0..self.tiles * self.tiles {
                let at = vec2((i % self.tiles) as f32, (i / self.tiles) as f32);
                let tile = Rect::from_min_size(corner + at * tile, tile);
                painter.image(texture.id(), tile, whole, Color32::WHITE);
            }
        }
        if let Some(pointer) = response.hover_pos() {
            let at = (pointer - corner) / tile;
            if at.min_elem() >= 0.0 && at.max_elem() < self.tiles as f32 {
                readout(ui, rect, map, set, at);
            }
        }
    }
}

impl Key {
    fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.set, &other.set) && (self.kind, self.channel) == (other.kind, other.channel)
    }
}

/// The value and the place under the pointer; `at` is in tiles.
fn readout(ui: &Ui, rect: Rect, map: &MapImage, set: &TextureSet, at: Vec2) {
    let (u, v) = (at.x.fract(), at.y.fract());
    let texel = |t: f32, n: usize| ((t * n as f32) as usize).min(n - 1);
    let (x, y) = (texel(u, set.domain.width), texel(v, set.domain.height));
    let value = map_picture::told(map, x, y);
    let place = format!("{:.2}, {:.2} mm", u * set.domain.girth_mm, v * set.domain.length_mm);
    let painter = ui.painter_at(rect);
    let value = painter.layout_no_wrap(value, FontId::monospace(14.0), theme::TEXT);
    let place =
        painter.layout_no_wrap(format!("{place}   texel {x}, {y}"), FontId::proportional(11.5), theme::WEAK);
    let size = vec2(value.size().x.max(place.size().x), value.size().y + place.size().y + 2.0);
    let ground =
        Rect::from_min_size(rect.left_bottom() + vec2(14.0, -size.y - 30.0), size + vec2(22.0, 14.0));
    painter.rect_filled(ground, 6.0, Color32::from_black_alpha(0xd0));
    let height = value.size().y;
    painter.galley(ground.min + vec2(11.0, 7.0), value, theme::TEXT);
    painter.galley(ground.min + vec2(11.0, 9.0 + height), place, theme::WEAK);
}

/// What black and white mean, and how large the map is.
fn legend(map: &MapImage, channel: Channel) -> String {
    let size = format!("{} × {}", map.planes[0].width(), map.planes[0].height());
    let grey = match channel {
        Channel::One(c) => Some(c),
        Channel::All if map.planes.len() == 1 && map.kind != MapKind::ScaleId => Some(0),
        Channel::All => None,
    };
    let Some(c) = grey else { return size };
    let [low, high] = map_picture::shown_range(map, c);
    let unit = map.kind.unit();
    format!("black {low:.3}   white {high:.3} {unit}   ·   {size}")
}

/// A map's name in words.
fn words(kind: MapKind) -> String {
    let mut letters = kind.name().chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}", letters.as_str().replace('_', " "))
}

/// Pixels that the window's adapter can hold: every second, third, … of a larger map.
fn fitting(pixels: &[u8], [width, height]: [usize; 2], ui: &Ui) -> (Vec<u8>, [usize; 2]) {
    let most = ui.input(|i| i.max_texture_side).max(1);
    let step = width.max(height).div_ceil(most).max(1);
    let size = [width.div_ceil(step), height.div_ceil(step)];
    if step == 1 {
        return (pixels.to_vec(), size);
    }
    let mut out = Vec::with_capacity(3 * size[0] * size[1]);
    for y in (0..height).step_by(step) {
        for x in (0..width).step_by(step) {
            out.extend_from_slice(&pixels[3 * (y * width + x)..][..3]);
        }
    }
    (out, size)
}
