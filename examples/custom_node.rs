//! An operation of one's own: checkers, with everything that the library asks of a node.
//!
//! ```text
//! cargo run --release --example custom_node -- checkers.png
//! ```
//!
//! [`Draft::add`](ophidian::node::draft::Draft::add) takes it, too (see the example `custom_graph`). Presets know only
//! the operations of the registry.

use std::ops::Range;

use ophidian::base::Domain;
use ophidian::eval::{Input, run_node};
use ophidian::node::spec::OFFSETS;
use ophidian::node::{Assets, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, ParamError, Spec};

/// Squares of two values, a whole number of them in the tile.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Checkers {
    /// Squares around the body; even numbers tile.
    #[schemars(range(min = 2, max = 4096))]
    squares_u: u32,
    /// Squares along the body; even numbers tile.
    #[schemars(range(min = 2, max = 4096))]
    squares_v: u32,
}

impl Default for Checkers {
    fn default() -> Self {
        Self { squares_u: 8, squares_v: 8 }
    }
}

impl Operation for Checkers {
    const SPEC: Spec = Spec {
        name: "checkers",
        summary: "Squares of two values.",
        inputs: &[
            InputSpec::drive("dark", 0.0, (0.0, 1.0), "", "Value of every other square."),
            InputSpec::drive("light", 1.0, (0.0, 1.0), "", "Value of the squares between."),
            OFFSETS[0],
            OFFSETS[1],
        ],
        outputs: &[OutputSpec::scalar("value", "", "The squares.")],
        ..Spec::GENERATOR
    };

    // What no single range can tell; the message carries the key of the setting.
    fn check(&self) -> Vec<ParamError> {
        let odd = |count: u32| count % 2 == 1;
        if odd(self.squares_u) || odd(self.squares_v) {
            let help = "take even numbers: equal squares would meet at the seam";
            return vec![ParamError::new("squares_u", "an odd number of squares does not tile", help)];
        }
        Vec::new()
    }

    fn cost_ns(&self) -> f32 {
        1.0
    }

    // Called for bands of rows, from any thread; it never sees a neighbour of what it writes.
    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let square = |t: f32, count: u32| ((t - t.floor()) * count as f32) as u32;
        for y in rows {
            let [dark, light, du, dv] = [0, 1, 2, 3].map(|input| ins.row(input, y));
            for (x, out) in outs.only(y).iter_mut().enumerate() {
                let column = square(cx.domain.u(x) + du[x], self.squares_u);
                let row = square(cx.domain.v(y) + dv[x], self.squares_v);
                *out = if (column + row) % 2 == 0 { dark[x] } else { light[x] };
            }
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).unwrap_or_else(|| "checkers.png".into());
    let domain = Domain::square(256);
    let inputs = [Input::Value(0.2), Input::Value(0.8)];
    let node = Checkers { squares_u: 6, ..Checkers::default() };
    assert_eq!(node.check(), [], "the settings tile");
    let planes = run_node(&node, &domain, 1, &inputs, &Assets::new(), 16);
    let samples = planes[0].data().iter().map(|v| (v * 255.0 + 0.5) as u8).collect();
    image::GrayImage::from_raw(256, 256, samples).ok_or("one sample per texel")?.save(&file)?;
    println!("{file}");
    Ok(())
}
