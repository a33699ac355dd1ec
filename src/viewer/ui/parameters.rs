//! The panel of parameters: sections of the anatomy, layers of the pattern, the material.

use eframe::egui::{CollapsingHeader, CornerRadius, Margin, Panel, RichText, ScrollArea, TextEdit, Ui, vec2};

use super::{row, theme};
use crate::viewer::fields::{Field, Fields};
use crate::viewer::session::Session;
use crate::viewer::setting::tables;

/// The panel.
#[derive(Debug)]
pub(super) struct Parameters {
    fields: Fields,
    /// Only what holds this is shown.
    filter: String,
}

impl Parameters {
    /// Everything that the schema has.
    pub(super) fn new() -> Self {
        Self { fields: Fields::new(), filter: String::new() }
    }

    /// Show it, at the left of the window.
    pub(super) fn show(&mut self, ui: &mut Ui, session: &mut Session) {
        Panel::left("parameters")
            .exact_size(theme::PARAMETERS)
            .resizable(false)
            .show_separator_line(false)
            .frame(theme::panel(vec2(0.0, 0.0)))
            .show(ui, |ui| {
                self.head(ui, session);
                ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
                    eframe::egui::Frame::NONE
                        .inner_margin(Margin { left: 12, right: 14, top: 2, bottom: 24 })
                        .show(ui, |ui| self.sections(ui, session));
                });
            });
    }

    fn head(&mut self, ui: &mut Ui, session: &mut Session) {
        eframe::egui::Frame::NONE.inner_margin(Margin::symmetric(14, 10)).show(ui, |ui| {
            ui.horizontal(|ui| {
                let field = TextEdit::singleline(&mut self.filter)
                    .hint_text("Filter parameters")
                    .margin(Margin::symmetric(8, 4))
                    .desired_width(ui.available_width() - 108.0);
                ui.add(field);
                let count = session.changes().len();
                let text = match count {
                    0 => "No changes".to_owned(),
                    1 => "Reset 1".to_owned(),
                    n => format!("Reset {n}"),
                };
                let button = eframe::egui::Button::new(text).min_size(vec2(100.0, 24.0));
                let reset = ui.add_enabled(count > 0, button);
                if reset.on_hover_text("Take all changes back; undo brings them again").clicked() {
                    session.reset_all();
                }
            });
        });
    }

    fn sections(&mut self, ui: &mut Ui, session: &mut Session) {
        let filter = self.filter.trim().to_lowercase();
        let fits = |section: &str, field: &Field| {
            let text = format!("{section}.{} {} {}", field.key, field.label, field.doc).to_lowercase();
            filter.split_whitespace().all(|word| text.contains(word))
        };
        let mut any = false;
        for section in &self.fields.sections {
            let shown: Vec<&Field> = section.fields.iter().filter(|f| fits(section.key, f)).collect();
            let layers = if section.key == "pattern" { layers(session) } else { Vec::new() };
            let fits_layer = |field: &&Field, kind: &str| {
                fits("layer", field) && (field.only.is_empty() || field.only.iter().any(|k| k == kind))
            };
            let layer_fits = |(_, _, kind): &(usize, String, String)| {
                self.fields.layer.iter().any(|f| fits_layer(&f, kind))
            };
            if shown.is_empty() && !layers.iter().any(layer_fits) {
                continue;
            }
            any = true;
            let open = (!filter.is_empty()).then_some(true);
            group(ui, section.key, &title(section.key), &section.doc, open, section.key == "scales", |ui| {
                for field in shown {
                    row::show(ui, session, field, &format!("{}.{}", section.key, field.key));
                }
                for (i, name, kind) in &layers {
                    let fields: Vec<&Field> =
                        self.fields.layer.iter().filter(|f| fits_layer(f, kind)).collect();
                    if fields.is_empty() {
                        continue;
                    }
                    let title = format!("{name}   {}", kind.replace('_', " "));
                    let id = format!("layer {i}");
                    group(ui, &id, &title, "A layer of the pattern.", open, false, |ui| {
                        for field in fields {
                            row::show(ui, session, field, &format!("pattern.layers.{i}.{}", field.key));
                        }
                    });
                }
            });
        }
        if !any {
            ui.add_space(20.0);
            ui.vertical_centered(|ui| {
                ui.label(RichText::new("No parameter has this name").color(theme::WEAK))
            });
        }
    }
}

/// Layers: index, name, kind.
fn layers(session: &Session) -> Vec<(usize, String, String)> {
    let count = tables(&session.opened().document, "pattern.layers").len();
    let text = |i: usize, key: &str| {
        let value = session.value(&format!("pattern.layers.{i}.{key}"));
        value.and_then(|v| v.text().map(str::to_owned))
    };
    (0..count)
        .map(|i| {
            let name = text(i, "name").unwrap_or_else(|| format!("layer {}", i + 1)).replace('_', " ");
            (i, name, text(i, "kind").unwrap_or_else(|| "marks".into()))
        })
        .collect()
}

fn title(key: &str) -> String {
    let mut letters = key.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

/// A group that opens and closes; `open` overrides its user.
fn group(
    ui: &mut Ui,
    id: &str,
    title: &str,
    doc: &str,
    open: Option<bool>,
    open_at_first: bool,
    body: impl FnOnce(&mut Ui),
) {
    ui.add_space(2.0);
    let header = CollapsingHeader::new(RichText::new(title).size(13.5).color(theme::TEXT).strong())
        .id_salt(id)
        .default_open(open_at_first)
        .open(open)
        .show_unindented(ui, |ui| {
            eframe::egui::Frame::NONE
                .fill(theme::CARD)
                .corner_radius(CornerRadius::same(6))
                .inner_margin(Margin { left: 6, right: 8, top: 6, bottom: 6 })
                .show(ui, body);
        });
    header.header_response.on_hover_text(doc.replace('`', ""));
}
