//! Maps of a preset, made in a thread of their own: small at first, then sharper; the newest request wins.

use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::Instant;

use super::desk::{Desk, Opened};
use super::latest::Latest;
use super::problem::Problem;
use super::setting::{Changes, changed};
use crate::base::{Domain, MapKind};
use crate::eval::{self, Control};
use crate::graph::{self, Graph};
use crate::maps::{SetId, TextureSet, assemble};
use crate::plan::Plan;

/// Maps that the snake wears.
pub(super) const WORN: [MapKind; 4] =
    [MapKind::Color, MapKind::Normal, MapKind::Roughness, MapKind::Iridescence];

/// What is wanted.
#[derive(Clone, Debug)]
pub(super) struct SkinRequest {
    /// Grows with each request.
    pub(super) number: u64,
    /// Of which preset.
    pub(super) opened: Arc<Opened>,
    /// Laid over it.
    pub(super) changes: Changes,
    /// Which maps, of those that it has; all if empty.
    pub(super) maps: Vec<MapKind>,
    /// Texels of the longer side, one set after the other.
    pub(super) sizes: Vec<usize>,
}

/// What came of a request.
#[derive(Debug)]
pub(super) enum SkinNews {
    /// Maps; there may be sharper ones to come.
    Made(Made),
    /// No maps: why.
    Failed {
        /// Of which request.
        number: u64,
        /// What is wrong, at least one thing.
        problems: Vec<Problem>,
    },
}

/// Maps that were made.
#[derive(Clone, Debug)]
pub(super) struct Made {
    /// Of which request.
    pub(super) number: u64,
    /// The maps.
    pub(super) set: Arc<TextureSet>,
    /// How long they took.
    pub(super) milliseconds: f64,
    /// Whether no sharper ones come.
    pub(super) last: bool,
    /// What may be meant otherwise.
    pub(super) warnings: Vec<Problem>,
}

/// Serve requests until nobody asks any more. `wake` is called after each news.
pub(super) fn serve(
    requests: &Latest<SkinRequest>,
    desk: &dyn Desk,
    news: &Sender<SkinNews>,
    wake: &dyn Fn(),
) {
    while let Some(request) = requests.take() {
        let told = |told: SkinNews| {
            // Who does not listen any more closes the requests, too.
            let _ = news.send(told);
            wake();
        };
        if let Err(problems) = make(&request, requests, desk, &told) {
            told(SkinNews::Failed { number: request.number, problems });
        }
    }
}

/// The graph of a preset with changes over it, its images read; and what may be meant otherwise.
pub(super) fn graph(
    opened: &Opened,
    changes: &Changes,
    desk: &dyn Desk,
) -> Result<(Graph, Vec<Problem>), Vec<Problem>> {
    let of_error = |error| Problem::of_error(&error);
    let document = changed(&opened.document, changes).map_err(of_error)?;
    let (mut graph, warnings) = graph::build(&document).map_err(of_error)?;
    let opened = Opened { document, ..opened.clone() };
    desk.images(&opened, &mut graph).map_err(of_error)?;
    Ok((graph, Problem::all(&warnings, &opened.document.sources)))
}

/// Maps of a graph; `None` if they are not wanted any more.
pub(super) fn evaluate(
    graph: &Graph,
    maps: &[MapKind],
    longer: usize,
    memory: Option<u64>,
    control: Control<'_>,
) -> Result<Option<TextureSet>, Vec<Problem>> {
    let has = |kind: &MapKind| graph.maps.contains_key(kind);
    let maps: Vec<MapKind> = match maps {
        [] => graph.maps.keys().copied().collect(),
        wanted => wanted.iter().copied().filter(has).collect(),
    };
    let domain = Domain::from_longer_side(longer, graph.girth_mm, graph.length_mm);
    let plan = Plan::new(graph, &maps, domain, memory)
        .map_err(|e| vec![Problem::plain(e.to_string(), "choose smaller maps")])?;
    let Ok(evaluation) = eval::run(&plan, control) else { return Ok(None) };
    Ok(Some(assemble(evaluation, SetId::new(graph, domain))))
}

fn make(
    request: &SkinRequest,
    requests: &Latest<SkinRequest>,
    desk: &dyn Desk,
    told: &dyn Fn(SkinNews),
) -> Result<(), Vec<Problem>> {
    let (graph, warnings) = graph(&request.opened, &request.changes, desk)?;
    for (i, &size) in request.sizes.iter().enumerate() {
        // The draft is always finished: while a slider is dragged, no other would ever be.
        let cancel = (i > 0).then_some(requests.stale());
        let control = Control { cancel, ..Control::default() };
        let start = Instant::now();
        let Some(set) = evaluate(&graph, &request.maps, size, desk.memory(), control)? else { return Ok(()) };
        told(SkinNews::Made(Made {
            number: request.number,
            set: Arc::new(set),
            milliseconds: start.elapsed().as_secs_f64() * 1e3,
            last: i + 1 == request.sizes.len(),
            warnings: warnings.clone(),
        }));
        if requests.is_stale() {
            break;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::setting::Setting;
    use crate::viewer::testing::Table;
    use std::sync::mpsc;

    fn request(number: u64, sizes: &[usize], changes: &[(&str, Setting)]) -> SkinRequest {
        SkinRequest {
            number,
            opened: Arc::new(Table.open("python_regius").expect("a built-in preset")),
            changes: changes.iter().map(|(path, setting)| ((*path).to_owned(), setting.clone())).collect(),
            maps: WORN.into(),
            sizes: sizes.into(),
        }
    }

    /// What comes of requests that all wait when the thread starts.
    fn news(asked: Vec<SkinRequest>) -> Vec<SkinNews> {
        let requests = Latest::new();
        let (send, receive) = mpsc::channel();
        asked.into_iter().for_each(|r| requests.put(r));
        std::thread::scope(|scope| {
            scope.spawn(|| serve(&requests, &Table, &send, &|| ()));
            let mut all = Vec::new();
            while let Ok(news) = receive.recv() {
                let last = matches!(&news, SkinNews::Failed { .. } | SkinNews::Made(Made { last: true, .. }));
                all.push(news);
                if last {
                    break;
                }
            }
            requests.close();
            all
        })
    }

    #[test]
    fn a_draft_comes_before_the_sharp_maps_and_only_of_the_newest_request() {
        let news = news(vec![request(1, &[32, 64], &[]), request(2, &[32, 64], &[])]);
        let made: Vec<_> = news
            .iter()
            .map(|n| match n {
                SkinNews::Made(m) => (m.number, m.set.domain.height.max(m.set.domain.width), m.last),
                SkinNews::Failed { .. } => panic!("{n:?}"),
            })
            .collect();
        assert_eq!(made, [(2, 32, false), (2, 64, true)]);
    }

    #[test]
    fn changes_change_the_maps_and_bad_ones_are_told() {
        let color = |changes: &[(&str, Setting)]| match news(vec![request(1, &[32], changes)]).remove(0) {
            SkinNews::Made(made) => Ok(made.set.maps[&MapKind::Color].planes[0].data().to_vec()),
            SkinNews::Failed { problems, .. } => Err(problems),
        };
        let own = color(&[]).expect("sound");
        assert_eq!(color(&[]).expect("sound"), own);
        assert_ne!(color(&[("seed", Setting::Whole(8))]).expect("sound"), own);
        assert_ne!(color(&[("color.base", Setting::Text("#FF0000".into()))]).expect("sound"), own);
        let problems = color(&[("scales.rows", Setting::Whole(0))]).expect_err("no snake has none");
        assert!(problems[0].message.contains("out of range"), "{problems:?}");
    }
}
