//! One parameter as a row: its name, a slider, its value.

use eframe::egui::{
    Align, Align2, Button, ComboBox, Context, DragValue, FontId, Id, Layout, Popup, Rect, Response, RichText,
    Sense, Slider, Stroke, TextStyle, Ui, UiBuilder, pos2, vec2,
};

use super::theme;
use crate::base::Srgb8;
use crate::viewer::fields::{Field, Kind};
use crate::viewer::session::Session;
use crate::viewer::setting::Setting;

/// Share of a row that the name takes.
const NAME: f32 = 0.36;
/// Width of a value.
const VALUE: f32 = 74.0;
/// Room for the dot of a changed value, left of the name.
const DOT: f32 = 14.0;

/// Show a field at a path, and change it in the session where its user does.
pub(super) fn show(ui: &mut Ui, session: &mut Session, field: &Field, path: &str) {
    let value = session.value(path).or_else(|| field.default.clone());
    let (whole, _) = ui.allocate_exact_size(vec2(ui.available_width(), theme::ROW), Sense::hover());
    if !ui.is_rect_visible(whole) {
        return;
    }
    let split = whole.left() + DOT + (whole.width() - DOT) * NAME;
    name(ui, session, field, path, Rect::from_min_max(whole.min, pos2(split, whole.bottom())));
    let rest = Rect::from_min_max(pos2(split + 6.0, whole.top()), whole.max);
    let mut row = ui.new_child(
        UiBuilder::new().id_salt(path).max_rect(rest).layout(Layout::left_to_right(Align::Center)),
    );
    let row = &mut row;
    match (&field.kind, value) {
        (Kind::Number { min, max, whole }, value) => {
            number(row, session, field, path, value.as_ref(), (*min, *max, *whole));
        }
        (Kind::Color, value) => color(row, session, field, path, value.as_ref()),
        (Kind::Choice(words), value) => choice(row, session, field, path, value.as_ref(), words),
        (Kind::Flag, value) => {
            let mut on = value == Some(Setting::Flag(true));
            if row.checkbox(&mut on, "").changed() {
                session.set(path, Setting::Flag(on), field.default.as_ref());
                session.settle();
            }
        }
    }
}

/// The name, with a dot where the value was changed; a click on the dot takes that back.
fn name(ui: &mut Ui, session: &mut Session, field: &Field, path: &str, rect: Rect) {
    let changed = session.is_changed(path);
    let font = TextStyle::Body.resolve(ui.style());
    let color = if changed { theme::TEXT } else { ui.visuals().widgets.inactive.fg_stroke.color };
    let text = fitted(ui, &field.label, &font, rect.width() - DOT);
    ui.painter().text(rect.left_center() + vec2(DOT, 0.0), Align2::LEFT_CENTER, text, font, color);
    let response = ui.interact(rect, ui.scope_id().with((path, "name")), Sense::click());
    let response = response.on_hover_ui(|ui| tooltip(ui, session, field, path));
    if changed {
        let center = rect.left_center() + vec2(5.0, 0.0);
        ui.painter().circle_filled(center, if response.hovered() { 4.5 } else { 3.0 }, theme::ACCENT);
        if response.clicked() {
            session.reset(path);
        }
    }
}

/// A text cut to a width.
fn fitted(ui: &Ui, text: &str, font: &FontId, width: f32) -> String {
    let wide =
        |text: &str| ui.painter().layout_no_wrap(text.to_owned(), font.clone(), theme::TEXT).size().x > width;
    if !wide(text) {
        return text.to_owned();
    }
    let mut short: Vec<char> = text.chars().collect();
    while !short.is_empty() && wide(&format!("{}…", short.iter().collect::<String>())) {
        short.pop();
    }
    format!("{}…", short.iter().collect::<String>().trim_end())
}

/// What a field does, its range, and what it was.
fn tooltip(ui: &mut Ui, session: &Session, field: &Field, path: &str) {
    ui.label(field.doc.replace('`', ""));
    let unit = if field.unit.is_empty() { String::new() } else { format!(" {}", field.unit) };
    let mut facts = vec![path.to_owned()];
    if let Kind::Number { min, max, .. } = field.kind {
        facts.push(format!("{min} to {max}{unit}"));
    }
    if let Some(default) = &field.default {
        facts.push(format!("usually {}", plain(default)));
    }
    ui.label(RichText::new(facts.join("   ·   ")).small().color(theme::WEAK));
    if session.is_changed(path) {
        let own = session.own(path).or_else(|| field.default.clone());
        let own = own.map_or("not set".to_owned(), |own| plain(&own));
        ui.label(RichText::new(format!("Click: back to {own}")).small().color(theme::ACCENT));
    }
}

/// A setting for people.
fn plain(setting: &Setting) -> String {
    match setting {
        Setting::Text(text) => text.clone(),
        Setting::Number(x) => format!("{x}"),
        other => other.to_toml(),
    }
}

fn number(
    ui: &mut Ui,
    session: &mut Session,
    field: &Field,
    path: &str,
    value: Option<&Setting>,
    (min, max, whole): (f32, f32, bool),
) {
    let Some(now) = value.and_then(Setting::number) else {
        if add(ui) {
            let start = field.default.as_ref().and_then(Setting::number).unwrap_or(min.max(1.0).min(max));
            put_number(session, field, path, f64::from(start), whole);
            session.settle();
        }
        return;
    };
    // Typed by people: 0.28, not what f32 makes of it.
    let mut x: f64 = now.to_string().parse().unwrap_or(f64::from(now));
    let (low, high): (f64, f64) =
        (min.to_string().parse().unwrap_or(0.0), max.to_string().parse().unwrap_or(1.0));
    ui.spacing_mut().slider_width = (ui.available_width() - VALUE - 8.0).max(20.0);
    let usual = field.default.as_ref().and_then(Setting::number).unwrap_or(1.0).abs().max(0.5);
    let long = min >= 0.0 && max > 12.0 * usual;
    let slider = Slider::new(&mut x, low..=high)
        .show_value(false)
        .logarithmic(long)
        .smallest_positive(f64::from((max * 1e-4).max(min).max(1e-4)))
        .max_decimals(if whole { 0 } else { 3 });
    let slider = if whole { slider.integer() } else { slider };
    let changed = session.is_changed(path);
    let slid = ui.scope(|ui| {
        // What was changed stands out.
        let (handle, fill) =
            if changed { (theme::ACCENT, theme::ACCENT) } else { (theme::WEAK, theme::FILLED) };
        let visuals = ui.visuals_mut();
        visuals.selection.bg_fill = fill;
        visuals.widgets.inactive.fg_stroke = Stroke::new(2.0, handle);
        visuals.widgets.hovered.fg_stroke = Stroke::new(2.0, theme::TEXT);
        visuals.widgets.active.fg_stroke = Stroke::new(2.0, theme::ACCENT);
        // The handle's size follows.
        ui.spacing_mut().interact_size.y = 16.0;
        ui.add(slider)
    });
    let slid = slid.inner;
    let speed = if whole { 0.2 } else { f64::from(now.abs().max(0.05 * usual)) * 0.01 };
    let suffix = match field.unit.as_str() {
        "degrees" => "°".to_owned(),
        unit if unit.len() <= 2 && !unit.is_empty() => format!(" {unit}"),
        _ => String::new(),
    };
    let value = DragValue::new(&mut x)
        .range(low..=high)
        .speed(speed)
        .max_decimals(if whole { 0 } else { 4 })
        .custom_formatter(|x, _| short(x))
        .suffix(suffix)
        .update_while_editing(false);
    let typed = ui.add_sized(vec2(VALUE, 21.0), value);
    if slid.changed() || typed.changed() {
        put_number(session, field, path, x, whole);
    }
    if ended(&slid) || ended(&typed) {
        session.settle();
    }
}

/// A number with up to four digits after the point, none of them idle.
fn short(x: f64) -> String {
    let text = format!("{x:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

fn ended(response: &Response) -> bool {
    response.drag_stopped() || response.lost_focus()
}

fn put_number(session: &mut Session, field: &Field, path: &str, x: f64, whole: bool) {
    let setting = if whole { Setting::Whole(x.round() as i64) } else { Setting::Number(x as f32) };
    session.set(path, setting, field.default.as_ref());
}

/// A key that is left out: a button that sets it.
fn add(ui: &mut Ui) -> bool {
    ui.add_sized(vec2(52.0, 21.0), Button::new(RichText::new("Set").color(theme::WEAK))).clicked()
}

fn color(ui: &mut Ui, session: &mut Session, field: &Field, path: &str, value: Option<&Setting>) {
    let Some(now) = value.and_then(Setting::color) else {
        if add(ui) {
            session.set(path, Setting::Text(Srgb8([0x80, 0x70, 0x60]).to_string()), field.default.as_ref());
            session.settle();
        }
        return;
    };
    let mut rgb = now.0;
    ui.spacing_mut().interact_size = vec2(ui.available_width() - VALUE - 8.0, 18.0);
    let response = ui.color_edit_button_srgb(&mut rgb);
    if response.changed() {
        session.set(path, Setting::Text(Srgb8(rgb).to_string()), field.default.as_ref());
    } else if rgb == now.0 && !popup_open(ui.ctx()) {
        settle_once(ui.ctx(), session, path);
    }
    if response.changed() {
        ui.ctx().data_mut(|d| d.insert_temp(moving_id(), path.to_owned()));
    }
    ui.label(RichText::new(now.to_string()).monospace().color(theme::WEAK));
}

fn moving_id() -> Id {
    Id::unique("colour at work")
}

fn popup_open(ctx: &Context) -> bool {
    Popup::is_any_open(ctx)
}

/// A colour that is chosen in its pop-up is one step, until that closes.
fn settle_once(ctx: &Context, session: &mut Session, path: &str) {
    let moving: Option<String> = ctx.data(|d| d.get_temp(moving_id()));
    if moving.as_deref() == Some(path) {
        ctx.data_mut(|d| d.remove::<String>(moving_id()));
        session.settle();
    }
}

fn choice(
    ui: &mut Ui,
    session: &mut Session,
    field: &Field,
    path: &str,
    value: Option<&Setting>,
    words: &[(String, String)],
) {
    let now = value.and_then(Setting::text).unwrap_or("not set").to_owned();
    let mut chosen = None;
    ComboBox::from_id_salt((path, "choice"))
        .width(ui.available_width() - 2.0)
        .selected_text(now.replace('_', " "))
        .show_ui(ui, |ui| {
            for (word, doc) in words {
                let label = ui.selectable_label(*word == now, word.replace('_', " "));
                let label = if doc.is_empty() { label } else { label.on_hover_text(doc.replace('`', "")) };
                if label.clicked() {
                    chosen = Some(word.clone());
                }
            }
        });
    if let Some(word) = chosen {
        session.settle();
        session.set(path, Setting::Text(word), field.default.as_ref());
        session.settle();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_short_as_they_can_be() {
        let all = [0.2, 1.0, 57.0, 0.12345, -0.00001, 1000.0, -1.5].map(short);
        assert_eq!(all, ["0.2", "1", "57", "0.1235", "0", "1000", "-1.5"]);
    }
}
