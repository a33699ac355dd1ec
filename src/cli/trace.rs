//! `--trace` and `--stats`: where the time of a run went. The clock is here; no output depends on it.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use serde_json::{Value, json};

use crate::base::watch::{Watch, Work};
use crate::io::{IoError, ManifestEntry, write_text};
use crate::plan::{Home, Plan};

/// A piece of work that was done.
#[derive(Clone, Debug, PartialEq)]
struct Span {
    /// Thread of the pool, from 1; 0 for any other.
    thread: usize,
    work: Work,
    name: String,
    /// Nanoseconds since the recorder began.
    begin: u64,
    end: u64,
}

/// Notes every piece of work.
#[derive(Debug)]
pub(super) struct Recorder {
    start: Instant,
    /// Of the set at work.
    spans: Mutex<Vec<Span>>,
}

impl Watch for Recorder {
    fn begin(&self) -> u64 {
        self.start.elapsed().as_nanos() as u64
    }

    fn end(&self, begin: u64, work: Work, name: &str) {
        let end = self.start.elapsed().as_nanos() as u64;
        let thread = rayon::current_thread_index().map_or(0, |i| i + 1);
        let span = Span { thread, work, name: name.to_owned(), begin, end };
        self.spans.lock().unwrap_or_else(PoisonError::into_inner).push(span);
    }
}

impl Recorder {
    /// The clock starts.
    pub(super) fn new() -> Self {
        Self { start: Instant::now(), spans: Mutex::default() }
    }

    /// What a set took, from `begin` until now; the next set starts anew.
    pub(super) fn set(&self, name: String, begin: u64) -> SetTimes {
        let end = self.begin();
        let mut spans = std::mem::take(&mut *self.spans.lock().unwrap_or_else(PoisonError::into_inner));
        spans.sort_by_key(|s| (s.thread, s.begin, std::cmp::Reverse(s.end)));
        SetTimes { name, begin, end, spans }
    }
}

/// Where the time of one set went.
#[derive(Debug)]
pub(super) struct SetTimes {
    name: String,
    begin: u64,
    end: u64,
    /// By thread, in time; what lies in another comes behind it.
    spans: Vec<Span>,
}

impl SetTimes {
    /// Nanoseconds of each piece less those of the pieces in it: a thread that waits takes up other work.
    fn own_nanos(&self) -> Vec<u64> {
        let mut own: Vec<u64> = self.spans.iter().map(|s| s.end - s.begin).collect();
        let mut open: Vec<usize> = Vec::new();
        for (i, span) in self.spans.iter().enumerate() {
            while open
                .last()
                .is_some_and(|&o| self.spans[o].thread != span.thread || self.spans[o].end <= span.begin)
            {
                open.pop();
            }
            if let Some(&outer) = open.last() {
                own[outer] = own[outer].saturating_sub(span.end - span.begin);
            }
            open.push(i);
        }
        own
    }

    /// Thread time by kind of work and name, ms.
    fn thread_ms(&self) -> BTreeMap<(Work, &str), f64> {
        let mut sums = BTreeMap::new();
        for (span, nanos) in self.spans.iter().zip(self.own_nanos()) {
            *sums.entry((span.work, span.name.as_str())).or_default() += nanos as f64 * 1e-6;
        }
        sums
    }

    /// Times by node, by file, and in total, of what `plan` made and `files` hold.
    pub(super) fn stats(&self, plan: &Plan, files: &[ManifestEntry]) -> Stats {
        let sums = self.thread_ms();
        let of = |work, name: &str| sums.get(&(work, name)).copied().unwrap_or(0.0);
        let texels = plan.domain.texels() as f64;
        let mut nodes: Vec<NodeTimes> = plan
            .steps
            .iter()
            .map(|step| {
                let lanes = step.passes.iter().flat_map(|p| &p.outputs).flatten();
                let planes = lanes.filter(|&&lane| plan.homes[lane] == Home::Plane).count() as u64;
                let ms = of(Work::Node, &step.name);
                NodeTimes {
                    node: step.name.clone(),
                    op: step.node.spec().name,
                    ms,
                    ns_per_texel: ms * 1e6 / texels,
                    bytes: planes * 4 * plan.domain.texels() as u64,
                }
            })
            .collect();
        nodes.sort_by(|a, b| b.ms.total_cmp(&a.ms));
        let files: Vec<FileTimes> = files
            .iter()
            .map(|file| FileTimes {
                file: file.file.clone(),
                encode_ms: of(Work::Encode, &file.file),
                write_ms: of(Work::Write, &file.file),
                bytes: file.bytes,
            })
            .collect();
        Stats { nodes, files, thread_ms: sums.values().sum(), wall_ms: (self.end - self.begin) as f64 * 1e-6 }
    }

    /// Events of Chrome's trace format.
    fn events(&self) -> impl Iterator<Item = Value> + '_ {
        let event = |name: &str, kind: &str, thread: usize, begin: u64, end: u64| {
            let (us, long) = (begin as f64 * 1e-3, (end - begin) as f64 * 1e-3);
            json!({ "name": name, "cat": kind, "ph": "X", "ts": us, "dur": long, "pid": 1, "tid": thread })
        };
        let spans = self.spans.iter().map(move |s| event(&s.name, kind(s.work), s.thread, s.begin, s.end));
        std::iter::once(event(&self.name, "set", 0, self.begin, self.end)).chain(spans)
    }
}

fn kind(work: Work) -> &'static str {
    match work {
        Work::Node => "node",
        Work::Encode => "encode",
        Work::Write => "write",
    }
}

/// Write sets as a trace that Perfetto and chrome://tracing open.
pub(super) fn write(path: &Path, sets: &[SetTimes]) -> Result<(), IoError> {
    let mut threads: Vec<usize> = sets.iter().flat_map(|s| &s.spans).map(|s| s.thread).chain([0]).collect();
    threads.sort_unstable();
    threads.dedup();
    let names = threads.into_iter().map(|thread| {
        let name = if thread == 0 { "sets".to_owned() } else { format!("thread {thread}") };
        json!({ "name": "thread_name", "ph": "M", "pid": 1, "tid": thread, "args": { "name": name } })
    });
    let mut text = String::from("{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n");
    for (i, event) in names.chain(sets.iter().flat_map(SetTimes::events)).enumerate() {
        // Writing into a string does not fail.
        let _ = write!(text, "{}{event}", if i > 0 { ",\n" } else { "" });
    }
    text.push_str("\n]}\n");
    write_text(path, &text)
}

/// Times of one set.
#[derive(Clone, Debug, serde::Serialize)]
pub(super) struct Stats {
    /// By node, the longest first.
    nodes: Vec<NodeTimes>,
    /// By file.
    files: Vec<FileTimes>,
    /// Sum over threads, ms.
    thread_ms: f64,
    /// From start to end, ms.
    wall_ms: f64,
}

#[derive(Clone, Debug, serde::Serialize)]
struct NodeTimes {
    node: String,
    op: &'static str,
    /// Thread time.
    ms: f64,
    ns_per_texel: f64,
    /// Of the planes it fills; 0 where its values never leave the cache.
    bytes: u64,
}

#[derive(Clone, Debug, serde::Serialize)]
struct FileTimes {
    file: String,
    /// Thread time.
    encode_ms: f64,
    /// Thread time.
    write_ms: f64,
    bytes: u64,
}

impl std::fmt::Display for Stats {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let wide = |names: &mut dyn Iterator<Item = usize>| names.max().unwrap_or(0).max(4);
        let node = wide(&mut self.nodes.iter().map(|n| n.node.len()));
        let op = wide(&mut self.nodes.iter().map(|n| n.op.len()));
        writeln!(f, "{:node$}  {:op$} {:>10} {:>10} {:>10}", "node", "op", "ms", "ns/texel", "MB")?;
        for n in &self.nodes {
            let mb = n.bytes as f64 * 1e-6;
            writeln!(f, "{:node$}  {:op$} {:>10.2} {:>10.3} {mb:>10.1}", n.node, n.op, n.ms, n.ns_per_texel)?;
        }
        let file = wide(&mut self.files.iter().map(|n| n.file.len()));
        writeln!(f, "\n{:file$} {:>10} {:>10} {:>10}", "file", "encode ms", "write ms", "MB")?;
        for n in &self.files {
            let mb = n.bytes as f64 * 1e-6;
            writeln!(f, "{:file$} {:>10.2} {:>10.2} {mb:>10.2}", n.file, n.encode_ms, n.write_ms)?;
        }
        writeln!(f, "\nthread time {:.1} ms, wall time {:.1} ms", self.thread_ms, self.wall_ms)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::watch::Watched;

    fn span(thread: usize, work: Work, begin: u64, end: u64) -> Span {
        Span { thread, work, name: format!("{work:?}"), begin, end }
    }

    #[test]
    fn time_is_counted_once_where_a_waiting_thread_takes_up_other_work() {
        let mut spans = vec![
            span(1, Work::Node, 0, 10_000_000),
            span(1, Work::Encode, 2_000_000, 5_000_000),
            span(1, Work::Write, 3_000_000, 4_000_000),
            span(1, Work::Encode, 6_000_000, 7_000_000),
            span(2, Work::Node, 1_000_000, 3_000_000),
        ];
        spans.sort_by_key(|s| (s.thread, s.begin, std::cmp::Reverse(s.end)));
        let times = SetTimes { name: "boa".into(), begin: 0, end: 10_000_000, spans };
        let sums = times.thread_ms();
        assert_eq!(sums[&(Work::Node, "Node")], 6.0 + 2.0);
        assert_eq!(sums[&(Work::Encode, "Encode")], 2.0 + 1.0);
        assert_eq!(sums[&(Work::Write, "Write")], 1.0);
    }

    #[test]
    fn a_trace_is_json_with_a_span_for_each_piece_of_work() {
        let recorder = Recorder::new();
        let begin = recorder.begin();
        Watched { name: "a \"node\"", by: Some(&recorder) }.piece(Work::Node, || ());
        let sets = [recorder.set("boa".into(), begin)];
        let dir = tempfile::tempdir().expect("a directory");
        let path = dir.path().join("trace.json");
        write(&path, &sets).expect("a trace");
        let text = std::fs::read_to_string(&path).expect("the trace");
        let trace: Value = serde_json::from_str(&text).expect("JSON");
        let events = trace["traceEvents"].as_array().expect("a list");
        let spans: Vec<&Value> = events.iter().filter(|e| e["ph"] == "X").collect();
        let names: Vec<&Value> = spans.iter().map(|e| &e["name"]).collect();
        assert_eq!(names, ["boa", "a \"node\""]);
        assert!(spans.iter().all(|e| e["dur"].as_f64() >= Some(0.0) && e["ts"].is_number()));
        assert!(recorder.set("next".into(), 0).spans.is_empty(), "each set starts anew");
    }
}
