//! What is wrong, each with the line of text that it is about.

use eframe::egui::text::LayoutJob;
use eframe::egui::{
    CornerRadius, FontId, Frame, Margin, Panel, RichText, ScrollArea, Stroke, TextFormat, Ui, vec2,
};

use super::theme;
use crate::viewer::problem::{Place, Problem};

/// Problems that are shown; the rest is counted.
const SHOWN: usize = 12;

/// Height of a problem with its line and its help.
const CARD: f32 = 84.0;

/// Show problems below the picture; nothing where there are none.
pub(super) fn show(ui: &mut Ui, problems: &[Problem]) {
    if problems.is_empty() {
        return;
    }
    Panel::bottom("problems")
        .resizable(false)
        .exact_size((44.0 + CARD * problems.len() as f32).min(240.0))
        .show_separator_line(false)
        .frame(theme::panel(vec2(12.0, 8.0)))
        .show(ui, |ui| {
            if problems.iter().any(|p| p.error) {
                let text = "The last good skin is shown until this is mended.";
                ui.label(RichText::new(text).small().color(theme::WEAK));
            }
            ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
                for problem in problems.iter().take(SHOWN) {
                    card(ui, problem);
                }
                if problems.len() > SHOWN {
                    ui.label(format!("and {} more", problems.len() - SHOWN));
                }
            });
        });
}

fn card(ui: &mut Ui, problem: &Problem) {
    let color = if problem.error { theme::ERROR } else { theme::ACCENT };
    Frame::NONE
        .fill(theme::CARD)
        .corner_radius(CornerRadius::same(6))
        .stroke(Stroke::new(1.0, theme::LINE))
        .inner_margin(Margin::symmetric(12, 8))
        .show(ui, |ui| {
            ui.set_min_width(ui.available_width());
            ui.horizontal_wrapped(|ui| {
                ui.label(RichText::new(&problem.message).color(color).strong());
                if let Some(place) = &problem.place {
                    ui.label(RichText::new(whereabouts(place)).small().color(theme::WEAK));
                }
            });
            if let Some(place) = &problem.place {
                ui.label(line(place, color));
            }
            if !problem.help.is_empty() {
                ui.label(RichText::new(&problem.help).color(theme::WEAK));
            }
        });
}

fn whereabouts(place: &Place) -> String {
    match place.file.as_str() {
        "" => "changed in this window".into(),
        file => format!("{file}, line {}, column {}", place.line, place.column),
    }
}

/// The line with the place underlined.
fn line(place: &Place, color: eframe::egui::Color32) -> LayoutJob {
    let mut job = LayoutJob::default();
    let font = FontId::monospace(12.5);
    let plain = TextFormat { font_id: font.clone(), color: theme::TEXT, ..Default::default() };
    let marked = TextFormat { color, underline: Stroke::new(1.5, color), ..plain.clone() };
    let weak = TextFormat { color: theme::WEAK, ..plain.clone() };
    let [before, at, after] = &place.text;
    if !place.file.is_empty() {
        job.append(&format!("{:>4}  ", place.line), 0.0, weak);
    }
    job.append(before, 0.0, plain.clone());
    // A place between two letters is shown as a gap.
    job.append(if at.is_empty() { " " } else { at }, 0.0, marked);
    job.append(after, 0.0, plain);
    job
}
