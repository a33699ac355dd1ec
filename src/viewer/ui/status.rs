//! The bar at the bottom: what is made and drawn, and how long frames took.

use std::collections::VecDeque;
use std::time::Instant;

use eframe::egui::{Align, Layout, Panel, RichText, Sense, Stroke, Ui, pos2, vec2};

use super::theme;
use crate::viewer::picture::Drawn;
use crate::viewer::session::Session;

/// Frames that are kept.
const FRAMES: usize = 120;

/// Seconds that a message stays.
const MESSAGE_S: f32 = 8.0;

/// What the bar tells.
pub(super) struct Status {
    /// Of each picture, ms.
    frames: VecDeque<f32>,
    /// Of the last picture: columns and rows.
    size: [usize; 2],
    /// How long laying the last skin on the subject took, ms.
    dress_ms: f64,
    adapter: String,
    message: Option<(String, bool, Instant)>,
}

impl Status {
    /// Nothing was drawn yet; pictures come from this adapter.
    pub(super) fn new(adapter: String) -> Self {
        Self { frames: VecDeque::new(), size: [0, 0], dress_ms: 0.0, adapter, message: None }
    }

    /// A picture was drawn.
    pub(super) fn drawn(&mut self, drawn: &Drawn) {
        // A skin that is worn already takes no time.
        if drawn.dress_ms > 1.0 {
            self.dress_ms = drawn.dress_ms;
        }
        // None was drawn where only the tone curve changed.
        if drawn.milliseconds > 0.0 {
            self.frames.push_back(drawn.milliseconds as f32);
            if self.frames.len() > FRAMES {
                self.frames.pop_front();
            }
        }
        self.size = drawn.size;
    }

    /// Tell something for some seconds.
    pub(super) fn tell(&mut self, message: impl Into<String>, good: bool) {
        self.message = Some((message.into(), good, Instant::now()));
    }

    /// Show the bar.
    pub(super) fn show(&mut self, ui: &mut Ui, session: &Session, exporting: bool) {
        Panel::bottom("status")
            .exact_size(34.0)
            .show_separator_line(false)
            .frame(theme::panel(vec2(14.0, 5.0)))
            .show(ui, |ui| {
                ui.horizontal_centered(|ui| {
                    if session.is_busy() || exporting {
                        ui.add(eframe::egui::Spinner::new().size(14.0).color(theme::ACCENT));
                    }
                    ui.label(RichText::new(made(session)).color(theme::WEAK));
                    self.message(ui);
                    ui.with_layout(Layout::right_to_left(Align::Center), |ui| self.times(ui));
                });
            });
    }

    fn message(&mut self, ui: &mut Ui) {
        let old = |(_, _, since): &(String, bool, Instant)| since.elapsed().as_secs_f32() > MESSAGE_S;
        if self.message.as_ref().is_some_and(old) {
            self.message = None;
        }
        if let Some((text, good, _)) = &self.message {
            ui.add_space(10.0);
            ui.label(RichText::new(text).color(if *good { theme::ACCENT } else { theme::ERROR }));
            ui.ctx().request_repaint_after(std::time::Duration::from_secs(1));
        }
    }

    /// The graph of frame times, and the last one.
    fn times(&self, ui: &mut Ui) {
        let (rect, response) = ui.allocate_exact_size(vec2(130.0, 22.0), Sense::hover());
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 3.0, theme::BACK);
        let most = self.frames.iter().copied().fold(33.4_f32, f32::max);
        let bar = rect.width() / FRAMES as f32;
        for (i, ms) in self.frames.iter().rev().enumerate() {
            let x = rect.right() - (i as f32 + 0.5) * bar;
            let top = rect.bottom() - (ms / most) * (rect.height() - 2.0);
            let color = if i == 0 { theme::TEXT } else { theme::ACCENT };
            painter.line_segment([pos2(x, rect.bottom()), pos2(x, top)], Stroke::new(bar.max(1.0), color));
        }
        let (least, median) = spread(&self.frames);
        let [width, height] = self.size;
        response.on_hover_ui(|ui| {
            ui.label(format!("Frames by {}", self.adapter));
            let text = format!(
                "the last {}: least {least:.1} ms, median {median:.1} ms, most {:.1} ms; the last one {width} × {height}",
                self.frames.len(),
                self.frames.iter().copied().fold(0.0, f32::max),
            );
            ui.label(RichText::new(text).small().color(theme::WEAK));
            let text = format!("laying the last skin on the subject took {:.0} ms", self.dress_ms);
            ui.label(RichText::new(text).small().color(theme::WEAK));
        });
        if let Some(last) = self.frames.back() {
            ui.label(RichText::new(format!("{last:.0} ms a frame")).color(theme::WEAK));
        }
    }
}

/// The least and the median.
fn spread(frames: &VecDeque<f32>) -> (f32, f32) {
    let mut sorted: Vec<f32> = frames.iter().copied().collect();
    sorted.sort_by(f32::total_cmp);
    (sorted.first().copied().unwrap_or(0.0), sorted.get(sorted.len() / 2).copied().unwrap_or(0.0))
}

/// What maps there are.
fn made(session: &Session) -> String {
    let Some(made) = session.made() else { return "Making maps".into() };
    let domain = made.set.domain;
    let seconds = made.milliseconds * 1e-3;
    format!("Maps {} × {} in {seconds:.2} s   ·   seed {}", domain.width, domain.height, made.set.seed)
}
