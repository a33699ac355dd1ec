//! `view`: a preset in a window.

use clap::Args;

use super::Set;
use super::size::PixelsArg;
use crate::cli::exit::Exit;

const VIEW_EXAMPLES: &str = "Examples:
  ophidian view \"milk snake\"
  ophidian view my_snake.toml --scene studio        the file is watched: save it in your editor, and see

In the window: drag turns, Shift-drag moves, the wheel comes nearer, a double click goes home. Keys: 1 snake, 2 maps,
3 compare, R another individual, K keep for comparison, F home, Ctrl+Z, Ctrl+Shift+Z, Ctrl+S save, Ctrl+E export.

It needs a build with the feature `viewer`, a display and a graphics adapter (software Vulkan is one); without any of
them one line says so, and the exit code is 2.";

/// `view`
#[derive(Debug, Args)]
#[command(after_help = format!("{VIEW_EXAMPLES}\n\n{}", Exit::TABLE))]
pub(in crate::cli) struct View {
    /// A built-in preset by name, or a preset file.
    pub(in crate::cli) preset: String,
    /// A built-in scene (coil, s, straight, loop, studio, macro, thesis, sphere, plane, cylinder) or a scene file.
    #[arg(long, default_value = "coil")]
    pub(in crate::cli) scene: String,
    /// Texels on the longer side of the maps once they are sharp.
    #[arg(long, value_name = "N", default_value_t = 2048, value_parser = clap::value_parser!(u16).range(16..=8192))]
    pub(in crate::cli) map_size: u16,
    /// Width and height of the window.
    #[arg(long, value_name = "WxH", default_value = "1360x860")]
    pub(in crate::cli) size: PixelsArg,
    /// The individual; the preset's own unless set.
    #[arg(long)]
    pub(in crate::cli) seed: Option<u64>,
    #[command(flatten)]
    pub(in crate::cli) set: Set,
    /// Threads; all cores unless set.
    #[arg(long, env = "OPHIDIAN_THREADS", value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(in crate::cli) threads: Option<u16>,
}
