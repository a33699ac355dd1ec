//! The bars above the picture: the preset and what is done with it; the scene, its light and the tone curve.

use std::sync::Arc;

use eframe::egui::{Align, Button, ComboBox, DragValue, Layout, Panel, RichText, Ui, WidgetText, vec2};

use super::theme;
use crate::graph;
use crate::preset::builtin;
use crate::scene::builtin as scenes;
use crate::scene::tone::ToneMap;
use crate::viewer::desk::{Desk, OpenedScene};
use crate::viewer::session::Session;
use crate::viewer::stage::{Lighting, Stage};

/// What fills the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Mode {
    /// The snake.
    #[default]
    Snake,
    /// One map.
    Maps,
    /// The snake before and after.
    Compare,
}

impl Mode {
    /// Every one, with its name and what it shows.
    pub(super) const ALL: [(Self, &'static str, &'static str); 3] = [
        (Self::Snake, "Snake", "The skin on a snake (1)"),
        (Self::Maps, "Maps", "Each map flat (2)"),
        (Self::Compare, "Compare", "The skin that was kept beside the one at work (3)"),
    ];
}

/// What the user asked for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Wish {
    /// Another preset.
    Open(&'static str),
    /// Another individual.
    Dice,
    /// A step back.
    Undo,
    /// A step forward.
    Redo,
    /// Keep the skin, to compare with.
    Keep,
    /// Save the preset.
    Save,
    /// Write the maps.
    Export,
    /// The scene's own camera.
    Home,
    /// Close the window.
    Quit,
}

/// The upper bar.
pub(super) fn preset(ui: &mut Ui, session: &mut Session, mode: &mut Mode) -> Option<Wish> {
    let mut wish = None;
    Panel::top("preset")
        .exact_size(50.0)
        .show_separator_line(false)
        .frame(theme::panel(vec2(14.0, 9.0)))
        .show(ui, |ui| {
            ui.horizontal_centered(|ui| {
                species(ui, session, &mut wish);
                ui.add_space(10.0);
                for (choice, name, doc) in Mode::ALL {
                    let chosen = *mode == choice;
                    let color = if chosen { theme::TEXT } else { theme::WEAK };
                    let button = Button::new(RichText::new(name).color(color))
                        .fill(if chosen { theme::ACCENT_DEEP } else { theme::PANEL })
                        .min_size(vec2(74.0, 28.0));
                    if ui.add(button).on_hover_text(doc).clicked() {
                        *mode = choice;
                    }
                }
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    let mut say = |ui: &mut Ui, can: bool, text: WidgetText, doc: &str, what: Wish| {
                        let button = Button::new(text).min_size(vec2(0.0, 28.0));
                        if ui.add_enabled(can, button).on_hover_text(doc).clicked() {
                            wish = Some(what);
                        }
                    };
                    let made = session.made().is_some();
                    say(ui, made, "Export maps".into(), "All maps as files (Ctrl+E)", Wish::Export);
                    let changed = !session.changes().is_empty();
                    let save = RichText::new("Save").color(if changed { theme::ACCENT } else { theme::WEAK });
                    say(ui, changed, save.into(), "The preset, with only what changed (Ctrl+S)", Wish::Save);
                    ui.add_space(8.0);
                    let [undo, redo] = session.can_undo_redo();
                    say(ui, redo, "Redo".into(), "Ctrl+Shift+Z", Wish::Redo);
                    say(ui, undo, "Undo".into(), "Ctrl+Z", Wish::Undo);
                    ui.add_space(8.0);
                    say(ui, true, "Dice".into(), "Another individual of the species (R)", Wish::Dice);
                    seed(ui, session);
                });
            });
        });
    wish
}

/// The preset's name, and all others to choose from.
fn species(ui: &mut Ui, session: &Session, wish: &mut Option<Wish>) {
    let opened = session.opened();
    let name = graph::about(&opened.document, "common_name").map(str::to_owned);
    let name = name.unwrap_or_else(|| opened.word.clone());
    let title = RichText::new(name).size(16.0).color(theme::TEXT).strong();
    ComboBox::from_id_salt("species").width(theme::PARAMETERS - 34.0).selected_text(title).show_ui(
        ui,
        |ui| {
            for (word, text) in builtin::BUILTIN {
                let chosen = opened.word == *word;
                let common = common_name(text);
                let label = ui.selectable_label(chosen, format!("{common}   {}", word.replace('_', " ")));
                if label.clicked() && !chosen {
                    *wish = Some(Wish::Open(word));
                }
            }
        },
    );
}

/// The line `common_name = "…"` of a built-in preset: read each time the list is open, so it is not parsed.
fn common_name(text: &str) -> &str {
    let line = text.lines().find_map(|line| line.strip_prefix("common_name = \""));
    line.and_then(|line| line.split('"').next()).unwrap_or("")
}

fn seed(ui: &mut Ui, session: &mut Session) {
    let mut seed = session.seed();
    let value = DragValue::new(&mut seed).speed(1.0).prefix("seed ").update_while_editing(false);
    let response = ui.add_sized(vec2(110.0, 28.0), value).on_hover_text("The individual");
    if response.changed() {
        session.set_seed(seed);
    }
    if response.drag_stopped() || response.lost_focus() {
        session.settle();
    }
}

/// The scene, its light and the tone curve.
pub(super) struct Light {
    word: String,
    scene: OpenedScene,
    lighting: Lighting,
    turn_deg: f32,
    /// Changes with each of the above.
    pub(super) stage: Arc<Stage>,
    /// The tone curve.
    pub(super) tone: ToneMap,
    /// Added to the scene's exposure.
    pub(super) exposure_ev: f32,
}

impl Light {
    /// A scene as it is.
    pub(super) fn new(word: String, scene: OpenedScene) -> Self {
        let lighting = Lighting::Own;
        Self {
            stage: Arc::new(Stage::new(&scene, lighting, 0.0)),
            tone: scene.spec.render.tone,
            word,
            scene,
            lighting,
            turn_deg: 0.0,
            exposure_ev: 0.0,
        }
    }

    /// The choices; true if the camera is another scene's from now on.
    ///
    /// # Errors
    /// Why a scene cannot be taken.
    pub(super) fn choices(&mut self, ui: &mut Ui, desk: &dyn Desk) -> Result<bool, String> {
        let weak = |text: &str| RichText::new(text).color(theme::WEAK);
        let before = (self.lighting, self.turn_deg);
        let mut chosen = None;
        ui.label(weak("Scene"));
        ComboBox::from_id_salt("scene").width(104.0).selected_text(&self.word).show_ui(ui, |ui| {
            for (name, _) in scenes::BUILTIN {
                if ui.selectable_label(self.word == *name, *name).clicked() {
                    chosen = Some(*name);
                }
            }
        });
        ui.add_space(6.0);
        ui.label(weak("Light"));
        ComboBox::from_id_salt("light").width(116.0).selected_text(self.lighting.label()).show_ui(ui, |ui| {
            for lighting in Lighting::ALL {
                ui.selectable_value(&mut self.lighting, lighting, lighting.label());
            }
        });
        let turn =
            DragValue::new(&mut self.turn_deg).range(-180.0..=180.0).speed(1.0).max_decimals(0).suffix("°");
        ui.add_sized(vec2(54.0, 24.0), turn).on_hover_text("Turns all light around the vertical");
        ui.add_space(6.0);
        ui.label(weak("Tone"));
        ComboBox::from_id_salt("tone").width(92.0).selected_text(self.tone.name()).show_ui(ui, |ui| {
            for tone in ToneMap::ALL {
                ui.selectable_value(&mut self.tone, tone, tone.name());
            }
        });
        let exposure = DragValue::new(&mut self.exposure_ev)
            .range(-8.0..=8.0)
            .speed(0.02)
            .fixed_decimals(1)
            .suffix(" EV");
        ui.add_sized(vec2(64.0, 24.0), exposure).on_hover_text("Exposure, added to the scene's own");
        if let Some(word) = chosen.filter(|word| *word != self.word) {
            let scene = desk.scene(word).map_err(|problems| {
                problems.first().map_or_else(|| word.to_owned(), |p| p.message.clone())
            })?;
            let kept = (self.lighting, self.turn_deg, self.exposure_ev);
            *self = Self::new(word.to_owned(), scene);
            (self.lighting, self.turn_deg, self.exposure_ev) = kept;
            self.stage = Arc::new(Stage::new(&self.scene, self.lighting, self.turn_deg));
            return Ok(true);
        }
        if before != (self.lighting, self.turn_deg) {
            self.stage = Arc::new(Stage::new(&self.scene, self.lighting, self.turn_deg));
        }
        Ok(false)
    }
}
