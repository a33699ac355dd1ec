//! What is seen of the window: the one place that knows egui.

mod bar;
mod canvas;
mod dialog;
mod maps;
mod parameters;
mod problems;
mod row;
mod status;
mod theme;

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use eframe::egui::{
    CentralPanel, Context, Frame, Key, Modifiers, Panel, RichText, Ui, ViewportCommand, vec2,
};

use self::bar::{Light, Mode, Wish};
use self::canvas::{Canvas, Subject};
use self::dialog::{Answer, Dialog};
use self::maps::Maps;
use self::parameters::Parameters;
use self::status::Status;
use super::desk::{Desk, Opened};
use super::latest::Latest;
use super::problem::Problem;
use super::reload::{self, Reloaded};
use super::session::Session;
use super::skin::{self, SkinNews, SkinRequest, WORN};
use super::{Start, ViewerError};
use crate::base::{MapKind, hash};
use crate::eval::Control;
use crate::maps::TextureSet;
use crate::preview::Gpu;

/// Texels of the longer side of the first draft, and of the next.
const DRAFTS: [usize; 2] = [256, 768];

/// Open the window, and come back once it is closed.
///
/// # Errors
/// If there is no display, or the window's driver fails.
pub(super) fn run(start: Start, gpu: Gpu, desk: Arc<dyn Desk>) -> Result<(), ViewerError> {
    let options = eframe::NativeOptions {
        viewport: eframe::egui::ViewportBuilder::default()
            .with_title("Ophidian")
            .with_app_id("ophidian")
            .with_inner_size(start.size.map(|n| n as f32))
            .with_min_inner_size([820.0, 520.0]),
        ..Default::default()
    };
    let create: eframe::AppCreator<'_> =
        Box::new(|cc| Ok(Box::new(App::new(start, gpu, desk, &cc.egui_ctx)?)));
    eframe::run_native("ophidian", options, create).map_err(|e| ViewerError::Window(one_line(&e.to_string())))
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A thread that serves requests, and what it tells.
struct Worker<R, N> {
    requests: Arc<Latest<R>>,
    news: Receiver<N>,
}

impl<R: Send + 'static, N: Send + 'static> Worker<R, N> {
    fn new(
        name: &str,
        ctx: &Context,
        serve: impl FnOnce(&Latest<R>, &Sender<N>, &dyn Fn()) + Send + 'static,
    ) -> std::io::Result<Self> {
        let requests = Arc::new(Latest::new());
        let (send, news) = channel();
        let (served, ctx) = (requests.clone(), ctx.clone());
        std::thread::Builder::new()
            .name(name.into())
            .spawn(move || serve(&served, &send, &|| ctx.request_repaint()))?;
        Ok(Self { requests, news })
    }
}

impl<R, N> Drop for Worker<R, N> {
    fn drop(&mut self) {
        self.requests.close();
    }
}

/// The window.
struct App {
    desk: Arc<dyn Desk>,
    session: Session,
    skins: Worker<SkinRequest, SkinNews>,
    files: Worker<Arc<Opened>, Reloaded>,
    canvas: Canvas,
    parameters: Parameters,
    light: Light,
    maps: Maps,
    status: Status,
    mode: Mode,
    kept: Option<Arc<TextureSet>>,
    dialog: Option<Dialog>,
    /// What came of an export, once it is done.
    export: Option<Receiver<Result<String, String>>>,
    map_size: usize,
    dice: u64,
}

impl App {
    fn new(start: Start, gpu: Gpu, desk: Arc<dyn Desk>, ctx: &Context) -> std::io::Result<Self> {
        theme::set(ctx);
        let status = Status::new(gpu.info.name.clone());
        let (for_skins, for_files) = (desk.clone(), desk.clone());
        let app = Self {
            skins: Worker::new("skin", ctx, move |r, n, wake| skin::serve(r, &*for_skins, n, wake))?,
            files: Worker::new("files", ctx, move |r, n, wake| reload::serve(r, &*for_files, n, wake))?,
            canvas: Canvas::new(gpu, ctx)?,
            parameters: Parameters::new(),
            light: Light::new(start.scene_word, start.scene),
            maps: Maps::new(),
            status,
            mode: Mode::Snake,
            kept: None,
            dialog: None,
            export: None,
            map_size: start.map_size,
            // Dice fall another way each time.
            dice: std::time::UNIX_EPOCH.elapsed().map_or(1, |t| t.as_nanos() as u64),
            session: Session::new(start.opened, start.changes),
            desk,
        };
        app.files.requests.put(app.session.opened().clone());
        Ok(app)
    }

    /// What threads have to tell.
    fn take_news(&mut self, ctx: &Context) {
        while let Ok(news) = self.skins.news.try_recv() {
            self.session.take(news);
        }
        while let Ok(read) = self.files.news.try_recv() {
            if read.is_ok() {
                self.status.tell("The file changed and was read anew", true);
            }
            self.session.reloaded(read);
        }
        let status = &mut self.status;
        self.canvas.take_news(ctx, &mut |drawn| status.drawn(drawn));
        if let Some(done) = self.export.as_ref().and_then(|export| export.try_recv().ok()) {
            self.export = None;
            match done {
                Ok(told) => self.status.tell(told, true),
                Err(told) => self.status.tell(told, false),
            }
        }
    }

    /// Ask for maps if something changed.
    fn ask(&mut self) {
        let shown = (self.mode == Mode::Maps).then(|| self.maps.kind());
        let maps: Vec<MapKind> = WORN.into_iter().chain(shown.filter(|kind| !WORN.contains(kind))).collect();
        let sizes: Vec<usize> =
            DRAFTS.into_iter().filter(|n| *n < self.map_size).chain([self.map_size]).collect();
        if let Some(request) = self.session.request(&maps, &sizes) {
            self.skins.requests.put(request);
        }
    }

    fn fulfil(&mut self, wish: Wish, ctx: &Context) {
        match wish {
            Wish::Open(word) => match self.desk.open(word) {
                Ok(opened) => self.open(opened),
                Err(problems) => self.session.reloaded(Err(problems)),
            },
            Wish::Dice => {
                let salt = hash::hash2(self.dice as u32, (self.dice >> 32) as u32, 1);
                self.dice = self.dice.wrapping_add(1);
                self.session.settle();
                self.session.set_seed(u64::from(salt % 100_000));
                self.session.settle();
            }
            Wish::Undo => self.session.undo(),
            Wish::Redo => self.session.redo(),
            Wish::Keep => {
                self.kept = self.session.made().map(|made| made.set.clone());
                self.status.tell("Kept: what you change now is beside it", true);
            }
            Wish::Save => self.dialog = Some(Dialog::save(&self.session)),
            Wish::Export => self.dialog = Some(Dialog::export(&self.session)),
            Wish::Home => self.canvas.home(),
            Wish::Quit => ctx.send_viewport_cmd(ViewportCommand::Close),
        }
        ctx.request_repaint();
    }

    fn open(&mut self, opened: Opened) {
        self.session.open(opened);
        self.files.requests.put(self.session.opened().clone());
    }

    fn answered(&mut self, answer: Answer, ctx: &Context) {
        match answer {
            Answer::Save(path) => match self.session.save(&*self.desk, &path) {
                Ok(()) => {
                    self.files.requests.put(self.session.opened().clone());
                    self.status.tell(format!("Saved as {path}"), true);
                }
                Err(error) => self.status.tell(error, false),
            },
            Answer::Export(folder, size) => {
                let (send, done) = channel();
                let (desk, opened) = (self.desk.clone(), self.session.opened().clone());
                let (changes, ctx) = (self.session.changes().clone(), ctx.clone());
                let work = move || {
                    let first = |problems: Vec<Problem>| {
                        problems.first().map_or_else(String::new, |p| p.message.clone())
                    };
                    let made = skin::graph(&opened, &changes, &*desk)
                        .and_then(|(graph, _)| {
                            skin::evaluate(&graph, &[], size, desk.memory(), Control::default())
                        })
                        .map_err(first);
                    let written = made.and_then(|set| match set {
                        Some(set) => desk.export(&set, &folder),
                        None => Err("the export was stopped".into()),
                    });
                    // A window that is closed hears nothing.
                    let _ = send.send(written);
                    ctx.request_repaint();
                };
                match std::thread::Builder::new().name("export".into()).spawn(work) {
                    Ok(_) => self.export = Some(done),
                    Err(error) => self.status.tell(format!("no thread can be started: {error}"), false),
                }
            }
        }
    }

    /// Keys that are pressed while nothing is typed.
    fn keys(&mut self, ctx: &Context) -> Option<Wish> {
        if self.dialog.is_some() || ctx.text_edit_focused() {
            return None;
        }
        let mut wish = None;
        let keys = [
            (Modifiers::COMMAND | Modifiers::SHIFT, Key::Z, Wish::Redo),
            (Modifiers::COMMAND, Key::Z, Wish::Undo),
            (Modifiers::COMMAND, Key::Y, Wish::Redo),
            (Modifiers::COMMAND, Key::S, Wish::Save),
            (Modifiers::COMMAND, Key::E, Wish::Export),
            (Modifiers::COMMAND, Key::Q, Wish::Quit),
            (Modifiers::NONE, Key::R, Wish::Dice),
            (Modifiers::NONE, Key::F, Wish::Home),
            (Modifiers::NONE, Key::K, Wish::Keep),
        ];
        ctx.input_mut(|input| {
            for (modifiers, key, what) in keys {
                if input.consume_key(modifiers, key) {
                    wish = Some(what);
                }
            }
            for (key, (mode, ..)) in [Key::Num1, Key::Num2, Key::Num3].into_iter().zip(Mode::ALL) {
                if input.consume_key(Modifiers::NONE, key) {
                    self.mode = mode;
                }
            }
        });
        let savable = !self.session.changes().is_empty();
        wish.filter(|wish| match wish {
            Wish::Save => savable,
            Wish::Export | Wish::Keep => self.session.made().is_some(),
            _ => true,
        })
    }

    /// The row above the picture.
    fn tools(&mut self, ui: &mut Ui) -> Option<Wish> {
        let mut wish = None;
        Panel::top("tools")
            .exact_size(42.0)
            .show_separator_line(false)
            .frame(theme::panel(vec2(12.0, 8.0)))
            .show(ui, |ui| {
                ui.horizontal_centered(|ui| {
                    if self.mode == Mode::Maps {
                        let set = self.session.made().map(|made| made.set.clone());
                        if self.maps.choices(ui, set.as_deref()) {
                            self.session.ask_again();
                        }
                        return;
                    }
                    match self.light.choices(ui, &*self.desk) {
                        Ok(true) => self.canvas.home(),
                        Ok(false) => {}
                        Err(error) => self.status.tell(error, false),
                    }
                    let home = ui.button("Home").on_hover_text(
                        "The scene's own camera (F). Drag to turn, Shift-drag to move, scroll to come nearer.",
                    );
                    if home.clicked() {
                        wish = Some(Wish::Home);
                    }
                    if self.mode == Mode::Compare {
                        let keep = ui.button("Keep as A").on_hover_text(
                            "Keep the skin as it is now, to see beside it what you change (K)",
                        );
                        if keep.clicked() {
                            wish = Some(Wish::Keep);
                        }
                        if self.is_kept() {
                            ui.label(RichText::new("A is kept: change something").color(theme::ACCENT));
                        }
                    }
                });
            });
        wish
    }

    /// Whether the skin at work is the one that was kept.
    fn is_kept(&self) -> bool {
        match (&self.kept, self.session.made()) {
            (Some(kept), Some(made)) => Arc::ptr_eq(kept, &made.set),
            _ => false,
        }
    }

    fn subject(&mut self) -> Option<Subject> {
        let now = self.session.made().map(|made| made.set.clone())?;
        // Until something is changed the kept one gets sharper, too.
        let same = |kept: &Arc<TextureSet>| (kept.preset_hash, kept.seed) == (now.preset_hash, now.seed);
        if self.mode == Mode::Compare && self.kept.as_ref().is_none_or(same) {
            self.kept = Some(now.clone());
        }
        // Beside itself there is nothing to see.
        let kept = self.kept.clone().filter(|kept| self.mode == Mode::Compare && !Arc::ptr_eq(kept, &now));
        Some(Subject {
            stage: self.light.stage.clone(),
            skins: [kept, Some(now)],
            tone: self.light.tone,
            exposure_ev: self.light.exposure_ev,
        })
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        self.take_news(&ctx);
        let before = self.mode;
        let pressed = self.keys(&ctx);
        let clicked = bar::preset(ui, &mut self.session, &mut self.mode);
        self.status.show(ui, &self.session, self.export.is_some());
        self.parameters.show(ui, &mut self.session);
        let tool = self.tools(ui);
        let mut problems: Vec<Problem> = self.session.problems().cloned().collect();
        problems.extend(self.canvas.fault().map(|fault| Problem::plain(fault, "")));
        problems::show(ui, &problems);
        // A map that the snake does not wear is made only once it is looked at.
        let lacks = |set: &TextureSet| !set.maps.contains_key(&self.maps.kind());
        if before != self.mode
            && self.mode == Mode::Maps
            && self.session.made().is_some_and(|made| lacks(&made.set))
        {
            self.session.ask_again();
        }
        CentralPanel::default().frame(Frame::NONE.fill(theme::BACK)).show(ui, |ui| {
            if self.mode == Mode::Maps {
                let set = self.session.made().map(|made| made.set.clone());
                self.maps.show(ui, set.as_ref(), self.session.is_busy());
            } else {
                let subject = self.subject();
                self.canvas.show(ui, subject.as_ref());
            }
        });
        for wish in [pressed, clicked, tool].into_iter().flatten() {
            self.fulfil(wish, &ctx);
        }
        if let Some(answer) = dialog::show(&ctx, &mut self.dialog) {
            self.answered(answer, &ctx);
        }
        self.ask();
    }
}
