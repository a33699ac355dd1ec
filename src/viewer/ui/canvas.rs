//! The picture: the snake from a camera that the mouse moves, alone or beside the one that was kept.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::thread::JoinHandle;

use eframe::egui::{
    Align2, Color32, ColorImage, Context, CursorIcon, FontId, PointerButton, Rect, Response, Sense, Stroke,
    TextureHandle, TextureOptions, Ui, Vec2, pos2, vec2,
};

use super::theme;
use crate::maps::TextureSet;
use crate::preview::Gpu;
use crate::scene::tone::ToneMap;
use crate::viewer::latest::Latest;
use crate::viewer::orbit::Orbit;
use crate::viewer::picture::{self, Drawn, PictureNews, PictureRequest};
use crate::viewer::stage::Stage;

/// A camera that stood still for so many seconds stands still.
const STILL_S: f64 = 0.18;

/// Largest side of a picture, pixels.
const MOST_PIXELS: f32 = 4096.0;

/// What is to be seen.
#[derive(Clone, Debug)]
pub(super) struct Subject {
    /// Where the snake lies, and in which light.
    pub(super) stage: Arc<Stage>,
    /// What it wears: the kept one, and the one at work.
    pub(super) skins: [Option<Arc<TextureSet>>; 2],
    /// The tone curve.
    pub(super) tone: ToneMap,
    /// Added to the scene's exposure.
    pub(super) exposure_ev: f32,
}

/// The picture and the camera.
pub(super) struct Canvas {
    requests: Arc<Latest<PictureRequest>>,
    news: Receiver<PictureNews>,
    thread: Option<JoinHandle<()>>,
    asked: Option<PictureRequest>,
    orbit: Option<Orbit>,
    /// Seconds of the window's clock at which the camera last moved.
    moved: f64,
    textures: [Option<TextureHandle>; 2],
    /// Where the kept one ends and the one at work begins, as a share of the width.
    split: f32,
    /// Why there is no picture.
    fault: Option<String>,
}

impl Canvas {
    /// Draw by a device, in a thread that wakes the window.
    ///
    /// # Errors
    /// If no thread can be started.
    pub(super) fn new(gpu: Gpu, ctx: &Context) -> std::io::Result<Self> {
        let requests = Arc::new(Latest::new());
        let (send, news) = channel();
        let (served, ctx) = (requests.clone(), ctx.clone());
        let thread = std::thread::Builder::new()
            .name("picture".into())
            .spawn(move || picture::serve(&served, gpu, &send, &|| ctx.request_repaint()))?;
        Ok(Self {
            requests,
            news,
            thread: Some(thread),
            asked: None,
            orbit: None,
            moved: f64::NEG_INFINITY,
            textures: [None, None],
            split: 0.5,
            fault: None,
        })
    }

    /// The scene's own camera, from the next picture on.
    pub(super) fn home(&mut self) {
        self.orbit = None;
    }

    /// Why there is no picture, if there is none.
    pub(super) fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
    }

    /// Take what was drawn; `told` gets each picture's times.
    pub(super) fn take_news(&mut self, ctx: &Context, told: &mut dyn FnMut(&Drawn)) {
        while let Ok(news) = self.news.try_recv() {
            match news {
                PictureNews::Drawn(drawn) => {
                    told(&drawn);
                    self.fault = None;
                    if self.orbit.is_none() {
                        self.orbit = Some(drawn.orbit);
                        if let Some(asked) = self.asked.as_mut().filter(|asked| asked.orbit.is_none()) {
                            asked.orbit = self.orbit;
                        }
                    }
                    for (texture, pixels) in self.textures.iter_mut().zip(&drawn.pixels) {
                        match pixels {
                            Some(pixels) => put(ctx, texture, ColorImage::from_rgb(drawn.size, pixels)),
                            None => *texture = None,
                        }
                    }
                }
                PictureNews::Failed(fault) => self.fault = Some(fault),
            }
        }
    }

    /// Show the picture, move the camera, and ask for another picture where that is needed.
    pub(super) fn show(&mut self, ui: &mut Ui, subject: Option<&Subject>) {
        let rect = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 0.0, theme::BACK);
        let both = self.textures.iter().all(Option::is_some);
        let middle = rect.left() + rect.width() * self.split;
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        for (i, texture) in self.textures.iter().enumerate() {
            let Some(texture) = texture else { continue };
            let part = match (both, i) {
                (false, _) => rect,
                (true, 0) => rect.with_max_x(middle),
                (true, _) => rect.with_min_x(middle),
            };
            painter.with_clip_rect(part).image(texture.id(), rect, whole, Color32::WHITE);
        }
        let divided = both && self.divide(ui, rect);
        if !divided {
            self.steer(ui, &response, rect.size());
        }
        if self.textures.iter().all(Option::is_none) {
            let text = if self.fault.is_some() { "No picture" } else { "Making the skin…" };
            painter.text(rect.center(), Align2::CENTER_CENTER, text, FontId::proportional(15.0), theme::WEAK);
        }
        if let Some(subject) = subject {
            self.ask(ui, subject, rect.size());
        }
    }

    /// The line between the kept one and the one at work; true while the pointer is on it.
    fn divide(&mut self, ui: &mut Ui, rect: Rect) -> bool {
        let x = rect.left() + rect.width() * self.split;
        let grip = Rect::from_center_size(pos2(x, rect.center().y), vec2(14.0, rect.height()));
        let id = ui.scope_id().with("divider");
        let response = ui.interact(grip, id, Sense::drag()).on_hover_cursor(CursorIcon::ResizeHorizontal);
        if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            self.split = ((pointer.x - rect.left()) / rect.width().max(1.0)).clamp(0.02, 0.98);
        }
        let painter = ui.painter_at(rect);
        let hot = response.hovered() || response.dragged();
        let color = if hot { theme::ACCENT } else { Color32::from_white_alpha(0xc0) };
        painter.vline(x, rect.y_range(), Stroke::new(if hot { 2.0 } else { 1.0 }, color));
        painter.circle_filled(pos2(x, rect.center().y), 6.0, color);
        for (side, text) in [(Align2::RIGHT_TOP, "A  kept"), (Align2::LEFT_TOP, "B  now")] {
            let shift = if side == Align2::RIGHT_TOP { -14.0 } else { 14.0 };
            let at = pos2(x + shift, rect.top() + 14.0);
            let text = painter.layout_no_wrap(text.into(), FontId::proportional(13.0), theme::TEXT);
            let ground = side.anchor_size(at, text.size());
            painter.rect_filled(ground.expand2(vec2(8.0, 4.0)), 5.0, Color32::from_black_alpha(0xb8));
            painter.galley(ground.min, text, theme::TEXT);
        }
        hot
    }

    /// Drags turn and move, the wheel comes nearer, a double click goes home.
    fn steer(&mut self, ui: &Ui, response: &Response, size: Vec2) {
        let Some(orbit) = &mut self.orbit else { return };
        let before = *orbit;
        let drag = response.drag_delta() / size.y.max(1.0);
        let shift = ui.input(|i| i.modifiers.shift);
        if response.dragged_by(PointerButton::Primary) && !shift {
            orbit.turn(drag.into());
        } else if response.dragged() {
            orbit.pan(drag.into());
        }
        if response.hovered() {
            let (scroll, pinch) = ui.input(|i| (i.smooth_scroll_delta.y, i.zoom_delta()));
            orbit.zoom(pinch * (scroll * 0.004).exp());
        }
        let moved = *orbit != before;
        if response.double_clicked() {
            self.orbit = None;
        }
        if moved {
            self.moved = ui.input(|i| i.time);
        }
    }

    fn ask(&mut self, ui: &Ui, subject: &Subject, size: Vec2) {
        let now = ui.input(|i| i.time);
        let moving = now - self.moved < STILL_S;
        if moving {
            ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(STILL_S));
        }
        let pixels = |points: f32| (points * ui.pixels_per_point()).clamp(1.0, MOST_PIXELS) as usize;
        let request = PictureRequest {
            stage: subject.stage.clone(),
            skins: subject.skins.clone(),
            orbit: self.orbit,
            size: [pixels(size.x), pixels(size.y)],
            moving,
            tone: subject.tone,
            exposure_ev: subject.exposure_ev,
        };
        if !self.asked.as_ref().is_some_and(|asked| asked.is_same(&request)) {
            self.asked = Some(request.clone());
            self.requests.put(request);
        }
    }
}

/// Put an image into a texture, a new one if there is none.
pub(super) fn put(ctx: &Context, texture: &mut Option<TextureHandle>, image: ColorImage) {
    match texture {
        Some(texture) => texture.set(image, TextureOptions::LINEAR),
        None => *texture = Some(ctx.load_texture("picture", image, TextureOptions::LINEAR)),
    }
}

impl Drop for Canvas {
    fn drop(&mut self) {
        self.requests.close();
        // The device must not be used after the window's driver is gone.
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
