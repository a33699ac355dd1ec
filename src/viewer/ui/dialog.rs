//! Save and export: where to.

use eframe::egui::{Align, ComboBox, Context, Id, Key, Layout, Modal, RichText, TextEdit, Ui, vec2};

use super::theme;
use crate::viewer::session::Session;

/// A question to the user.
pub(super) enum Dialog {
    /// Where to save the preset to.
    Save {
        /// The file.
        path: String,
        /// What it will hold, or why it cannot be saved.
        text: Result<String, String>,
    },
    /// Where to write the maps to.
    Export {
        /// The folder.
        folder: String,
        /// Texels of the longer side.
        size: usize,
    },
}

/// What the user decided.
pub(super) enum Answer {
    /// Save to this file.
    Save(String),
    /// Write all maps of this size to this folder.
    Export(String, usize),
}

/// Sizes of maps to choose from, texels of the longer side.
const SIZES: [usize; 5] = [512, 1024, 2048, 4096, 8192];

impl Dialog {
    /// Ask where to save.
    pub(super) fn save(session: &Session) -> Self {
        Self::Save { path: session.save_path(), text: session.save_text().map_err(|e| e.to_string()) }
    }

    /// Ask where to export to.
    pub(super) fn export(session: &Session) -> Self {
        let name = session.save_path();
        let stem = name.rsplit(['/', '\\']).next().unwrap_or(&name).trim_end_matches(".toml");
        Self::Export { folder: format!("{stem}_maps"), size: 2048 }
    }
}

/// Show the question, if there is one; it goes away once it is answered.
pub(super) fn show(ctx: &Context, dialog: &mut Option<Dialog>) -> Option<Answer> {
    let shown = dialog.as_mut()?;
    let mut answer = None;
    let mut close = false;
    let response = Modal::new(Id::unique("dialog")).show(ctx, |ui| {
        ui.set_width(460.0);
        ui.spacing_mut().item_spacing.y = 8.0;
        let entered = ui.input(|i| i.key_pressed(Key::Enter));
        match shown {
            Dialog::Save { path, text } => {
                ui.heading("Save the preset");
                ui.label(
                    RichText::new("Only what you changed is written; comments stay.").color(theme::WEAK),
                );
                line(ui, path);
                match text {
                    Ok(text) => excerpt(ui, text),
                    Err(error) => drop(ui.label(RichText::new(error.as_str()).color(theme::ERROR))),
                }
                let (yes, no) = buttons(ui, "Save", text.is_ok());
                if text.is_ok() && (yes || entered) {
                    answer = Some(Answer::Save(path.clone()));
                }
                close = no;
            }
            Dialog::Export { folder, size } => {
                ui.heading("Export the maps");
                let hint = "All maps as PNG with a manifest, as `generate` writes them, into a folder:";
                ui.label(RichText::new(hint).color(theme::WEAK));
                line(ui, folder);
                ui.horizontal(|ui| {
                    ui.label("Longer side");
                    ComboBox::from_id_salt("size").selected_text(format!("{size} texels")).show_ui(
                        ui,
                        |ui| {
                            for choice in SIZES {
                                ui.selectable_value(size, choice, format!("{choice} texels"));
                            }
                        },
                    );
                });
                let (yes, no) = buttons(ui, "Export", !folder.trim().is_empty());
                if yes || (entered && !folder.trim().is_empty()) {
                    answer = Some(Answer::Export(folder.clone(), *size));
                }
                close = no;
            }
        }
    });
    if answer.is_some() || close || response.should_close() {
        *dialog = None;
    }
    answer
}

/// A line to edit.
fn line(ui: &mut Ui, text: &mut String) {
    ui.add(TextEdit::singleline(text).desired_width(f32::INFINITY).margin(vec2(8.0, 5.0)));
}

/// The end of a text, where most changes stand.
fn excerpt(ui: &mut Ui, text: &str) {
    let lines: Vec<&str> = text.trim_end().lines().collect();
    let first = lines.len().saturating_sub(10);
    let mut shown = lines[first..].join("\n");
    if first > 0 {
        shown.insert_str(0, "…\n");
    }
    eframe::egui::Frame::NONE.fill(theme::BACK).corner_radius(5).inner_margin(10).show(ui, |ui| {
        ui.set_min_width(ui.available_width());
        ui.label(RichText::new(shown).monospace().color(theme::WEAK));
    });
}

/// Yes and no, at the right.
fn buttons(ui: &mut Ui, yes: &str, can: bool) -> (bool, bool) {
    ui.add_space(4.0);
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        let button = |text: RichText| eframe::egui::Button::new(text).min_size(vec2(92.0, 28.0));
        let yes = RichText::new(yes).color(theme::TEXT).strong();
        let yes = ui.add_enabled(can, button(yes).fill(theme::ACCENT_DEEP)).clicked();
        (yes, ui.add(button("Cancel".into())).clicked())
    })
    .inner
}
