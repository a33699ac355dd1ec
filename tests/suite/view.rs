//! The window, driven by keys and a mouse on a screen of its own (Xvfb, xdotool, ImageMagick's import).
//!
//! Where these are not installed the test prints SKIPPED and why; with OPHIDIAN_REQUIRE_DISPLAY=1 that fails.
//! OPHIDIAN_SCREENSHOTS=DIR keeps every screenshot.

use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::cli::ophidian;

/// Width and height of the screen and the window.
const SIZE: [u32; 2] = [1360, 860];

/// Longest wait for anything that is to be seen.
const PATIENCE: Duration = Duration::from_secs(240);

const PRESET: &str = "\
# My snake.
include = \"python_regius.toml\"

[scales]
rows = 57   # counted
";

/// A process that ends with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A screen with the window on it.
struct Screen {
    display: String,
    /// The window's number.
    id: String,
    dir: tempfile::TempDir,
    window: Running,
    _server: Running,
}

/// One picture of the whole screen.
struct Shot(image::RgbImage);

impl Shot {
    /// Pixels of a part (left, top, right, bottom) that are about of this colour.
    fn count(&self, [left, top, right, bottom]: [u32; 4], color: [u8; 3]) -> usize {
        let near = |p: &image::Rgb<u8>| p.0.iter().zip(color).all(|(a, b)| a.abs_diff(b) < 14);
        let all = (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y)));
        all.filter(|(x, y)| near(self.0.get_pixel(*x, *y))).count()
    }

    /// Share of the pixels of a part that are another colour in another picture.
    fn differs(&self, other: &Self, [left, top, right, bottom]: [u32; 4]) -> f64 {
        let all = (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y)));
        let other = |(x, y): &(u32, u32)| {
            let (a, b) = (self.0.get_pixel(*x, *y), other.0.get_pixel(*x, *y));
            a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 8)
        };
        all.filter(other).count() as f64 / f64::from((right - left) * (bottom - top))
    }

    /// How many colours a part has.
    fn colors(&self, [left, top, right, bottom]: [u32; 4]) -> usize {
        let all = (top..bottom).flat_map(|y| (left..right).map(move |x| self.0.get_pixel(x, y).0));
        all.collect::<std::collections::BTreeSet<_>>().len()
    }
}

/// The picture's part of the window, the panel's, and where problems are told.
const PICTURE: [u32; 4] = [380, 110, 1340, 560];
const PROBLEMS: [u32; 4] = [360, 560, 1340, 820];
/// Left of a map, and what is there.
const MARGIN: [u32; 4] = [354, 110, 372, 800];
const BACK: [u8; 3] = [0x10, 0x12, 0x13];
/// Of an error's text.
const ERROR: [u8; 3] = [0xe8, 0x74, 0x5c];

impl Screen {
    /// Start a server and the window on it; `None` if this machine has no such tools or no adapter.
    fn start() -> Option<Self> {
        let skip = |why: &str| {
            assert!(std::env::var_os("OPHIDIAN_REQUIRE_DISPLAY").is_none_or(|v| v != "1"), "{why}");
            println!("SKIPPED: {why}");
        };
        for tool in ["Xvfb", "xdotool", "import"] {
            let there =
                Command::new(tool).arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status();
            if there.is_err() {
                skip(&format!("{tool} is not installed"));
                return None;
            }
        }
        if let Err(error) = ophidian::preview::Gpu::new(None) {
            skip(&error.to_string());
            return None;
        }
        let dir = tempfile::tempdir().expect("a directory");
        std::fs::write(dir.path().join("mine.toml"), PRESET).expect("a file");
        let [width, height] = SIZE;
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-nolisten", "tcp", "-screen", "0", &format!("{width}x{height}x24")])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb starts");
        let mut line = String::new();
        let out = server.stdout.take().expect("its output");
        BufReader::new(out).read_line(&mut line).expect("the number of its display");
        let display = format!(":{}", line.trim());
        let server = Running(server);
        let window = Command::new(env!("CARGO_BIN_EXE_ophidian"))
            .args(["view", "mine.toml", "--map-size", "512", "--size", &format!("{width}x{height}")])
            .current_dir(dir.path())
            .env("DISPLAY", &display)
            .env("XDG_RUNTIME_DIR", dir.path())
            .env_remove("WAYLAND_DISPLAY")
            .spawn()
            .expect("the command starts");
        let mut screen = Self { display, id: String::new(), dir, window: Running(window), _server: server };
        let start = Instant::now();
        loop {
            let found = screen.xdotool(&["search", "--name", "^Ophidian$"]);
            if let Some(id) = found.lines().next() {
                screen.xdotool(&["windowmove", id, "0", "0"]);
                screen.id = id.to_owned();
                return Some(screen);
            }
            assert!(start.elapsed() < PATIENCE, "no window came up");
            std::thread::sleep(Duration::from_millis(200));
        }
    }

    fn xdotool(&self, args: &[&str]) -> String {
        let output = Command::new("xdotool").args(args).env("DISPLAY", &self.display).output();
        String::from_utf8_lossy(&output.expect("xdotool runs").stdout).into_owned()
    }

    /// Press a key; without a window manager keys go where someone says.
    fn key(&self, key: &str) {
        self.xdotool(&["windowfocus", &self.id]);
        std::thread::sleep(Duration::from_millis(300));
        self.xdotool(&["key", key]);
    }

    /// Drag from a place to another, as a hand does: in steps.
    fn drag(&self, [x, y]: [i32; 2], [to_x, to_y]: [i32; 2]) {
        self.xdotool(&["mousemove", &x.to_string(), &y.to_string()]);
        // What comes within one frame of a slow machine is a click, not a drag.
        let pause = || std::thread::sleep(Duration::from_millis(400));
        pause();
        self.xdotool(&["mousedown", "1"]);
        for step in 0..=4 {
            let at = |a: i32, b: i32| (a + (b - a) * step / 4).to_string();
            self.xdotool(&["mousemove", &at(x, to_x), &at(y, to_y)]);
            pause();
        }
        self.xdotool(&["mouseup", "1"]);
    }

    fn shot(&self) -> Shot {
        let path = self.dir.path().join("shot.png");
        let status = Command::new("import")
            .args(["-window", "root"])
            .arg(&path)
            .env("DISPLAY", &self.display)
            .status()
            .expect("import runs");
        assert!(status.success());
        Shot(image::open(&path).expect("a picture").into_rgb8())
    }

    /// Wait until the screen shows something, and keep the picture of it under a name.
    fn until(&self, name: &str, seen: impl Fn(&Shot) -> bool) -> Shot {
        let start = Instant::now();
        loop {
            std::thread::sleep(Duration::from_millis(250));
            let shot = self.shot();
            let late = start.elapsed() > PATIENCE;
            if seen(&shot) || late {
                if let Some(dir) = std::env::var_os("OPHIDIAN_SCREENSHOTS") {
                    let path = PathBuf::from(dir).join(format!("{name}.png"));
                    std::fs::copy(self.dir.path().join("shot.png"), path).expect("a file to write");
                }
                assert!(!late, "never seen: {name}");
                return shot;
            }
        }
    }

    /// Wait until nothing moves any more.
    fn still(&self, name: &str) -> Shot {
        let last = std::cell::RefCell::new(self.shot());
        self.until(name, |shot| {
            let same = shot.differs(&last.borrow(), PICTURE) == 0.0;
            *last.borrow_mut() = Shot(shot.0.clone());
            same && shot.colors(PICTURE) > 2000
        })
    }

    fn text(&self) -> String {
        std::fs::read_to_string(self.file()).expect("the preset")
    }

    fn file(&self) -> PathBuf {
        Path::new(self.dir.path()).join("mine.toml")
    }
}

#[test]
fn the_window_turns_changes_saves_and_reads_anew() {
    let Some(mut screen) = Screen::start() else { return };
    let first = screen.still("1 the snake");

    // The mouse turns the snake.
    screen.drag([860, 400], [1010, 380]);
    screen.until("2 turned", |shot| shot.differs(&first, PICTURE) > 0.2);
    let turned = screen.still("2 turned and sharp");

    // A key shows the maps, another one the snake again.
    screen.key("2");
    let dark = |shot: &Shot| shot.count(MARGIN, BACK) > 5000;
    assert!(!dark(&turned));
    screen.until("3 maps", |shot| dark(shot) && shot.colors(PICTURE) > 500);
    screen.key("1");
    screen.until("4 the snake", |shot| !dark(shot));
    let snake = screen.still("4 the snake again");

    // Another individual, which can be undone.
    screen.key("r");
    screen.until("5 another individual", |shot| shot.differs(&snake, PICTURE) > 0.05);
    screen.key("ctrl+z");
    let undone = screen.until("6 undone", |shot| shot.differs(&snake, PICTURE) < 0.002);
    screen.key("ctrl+shift+z");
    screen.until("7 done again", |shot| shot.differs(&undone, PICTURE) > 0.05);

    // A slider: the first of the open section, the rows.
    let before = screen.still("8 before the slider");
    screen.drag(ROWS_SLIDER, [ROWS_SLIDER[0] + 40, ROWS_SLIDER[1]]);
    screen.until("9 after the slider", |shot| shot.differs(&before, PICTURE) > 0.05);

    // Saved with only what changed, and with its comments.
    screen.key("ctrl+s");
    screen.until("10 the question", |shot| shot.differs(&before, PICTURE) > 0.5);
    screen.key("Return");
    let start = Instant::now();
    while screen.text() == PRESET {
        assert!(start.elapsed() < PATIENCE, "nothing was saved");
        std::thread::sleep(Duration::from_millis(100));
    }
    let saved = screen.text();
    assert!(saved.starts_with("# My snake.\ninclude = \"python_regius.toml\"\nseed = "), "{saved}");
    assert!(saved.contains("# counted") && !saved.contains("rows = 57"), "{saved}");
    let check = ophidian().arg("check").arg(screen.file()).output().expect("the command runs");
    assert!(check.status.success());

    // An error in the file is told at its line while the snake stays; mended, it is gone.
    let good = screen.still("11 saved");
    std::fs::write(screen.file(), saved.replace("[scales]", "[scales]\nrelief = deep")).expect("a file");
    let told = screen.until("12 an error", |shot| shot.count(PROBLEMS, ERROR) > 150);
    assert!(told.colors([380, 110, 1340, 500]) > 2000, "the last good skin stays");
    assert_eq!(good.count(PROBLEMS, ERROR), 0);
    std::fs::write(screen.file(), saved.replace("[scales]", "[scales]\nrelief = 0.2")).expect("a file");
    screen.until("13 mended", |shot| shot.count(PROBLEMS, ERROR) == 0 && shot.differs(&good, PICTURE) > 0.02);

    // It ends in order.
    screen.key("ctrl+q");
    let start = Instant::now();
    let code = loop {
        if let Some(status) = screen.window.0.try_wait().expect("a process") {
            break status.code();
        }
        assert!(start.elapsed() < PATIENCE, "the window stays open");
        std::thread::sleep(Duration::from_millis(100));
    };
    assert_eq!(code, Some(0));
}

/// The handle of the first slider.
const ROWS_SLIDER: [i32; 2] = [204, 178];

#[test]
fn no_display_is_one_line_and_a_code() {
    if ophidian::preview::Gpu::new(None).is_err() {
        println!("SKIPPED: no adapter");
        return;
    }
    let output = ophidian()
        .args(["view", "python_regius"])
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .expect("the command runs");
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("no window can be opened") && text.trim().lines().count() <= 4, "{text}");
}

#[test]
fn no_adapter_is_one_line_and_a_code() {
    let output = ophidian()
        .args(["view", "python_regius"])
        .env("WGPU_BACKEND", "dx12")
        .output()
        .expect("the command runs");
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("no graphics adapter") && text.contains("mesa-vulkan-drivers"), "{text}");
}
