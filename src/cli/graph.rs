//! `graph`: what a preset becomes, with what it takes.

use std::io::Write as _;

use super::args::{Graph, GraphFormat, MapsArg};
use super::exit::{Exit, Failure};
use super::generate;
use super::load::Preset;
use crate::base::MapKind;
use crate::graph;
use crate::plan::Plan;

/// Print the graph; the nodes that the maps need are marked, and the plan is summed up in a comment.
pub(super) fn run(args: &Graph) -> Result<Exit, Failure> {
    let preset = Preset::open(&args.preset, &args.set.settings)?;
    let mut graph = preset.graph()?;
    if let Some(seed) = args.seed {
        graph = graph.with_seed(seed);
    }
    let wanted: Vec<MapKind> = match &args.maps {
        MapsArg::All => graph.maps.keys().copied().collect(),
        MapsArg::List(list) => list.clone(),
    };
    let domain = args.size.domain(graph.girth_mm, graph.length_mm);
    let plan = generate::plan(&graph, &wanted, domain, None)?;
    let (sum, mut out) = (summary(&plan, &graph), anstream::stdout());
    match args.format {
        GraphFormat::Toml => write!(out, "# {sum}\n{}", graph::to_toml(&graph))?,
        GraphFormat::Dot => write!(out, "// {sum}\n{}", graph::to_dot(&graph, &wanted))?,
        GraphFormat::Mermaid => write!(out, "%% {sum}\n{}", graph::to_mermaid(&graph, &wanted))?,
        GraphFormat::Json => {
            let mut object = graph::to_json(&graph, &wanted);
            object["plan"] = serde_json::json!({
                "size": [domain.width, domain.height],
                "maps": wanted,
                "steps": plan.steps.len(),
                "stages": plan.stages.len(),
                "peak_bytes": plan.peak_bytes,
                "cost_ms": plan.cost_ms(),
            });
            writeln!(out, "{object:#}")?;
        }
    }
    Ok(Exit::Done)
}

fn summary(plan: &Plan, graph: &graph::Graph) -> String {
    format!(
        "at {} x {}: {} of {} nodes run, in {} passes; {:.0} MiB, about {:.0} ms on one thread",
        plan.domain.width,
        plan.domain.height,
        plan.steps.len(),
        graph.nodes.len(),
        plan.stages.len(),
        plan.peak_bytes as f64 / f64::from(1 << 20),
        plan.cost_ms()
    )
}
