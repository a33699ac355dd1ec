//! Tests of the Gray-Scott solver: closed forms, the look of named reactions, refusals, threads.

use super::*;

/// Share of the field above one half, and the number of connected marks on the torus.
fn marks(field: &Field) -> (f64, usize) {
    let (w, h) = (field.width, field.height);
    let on: Vec<bool> = field.values().iter().map(|&v| v > 0.5).collect();
    let mut seen = vec![false; on.len()];
    let mut count = 0;
    for start in 0..on.len() {
        if !on[start] || seen[start] {
            continue;
        }
        count += 1;
        let mut stack = vec![start];
        seen[start] = true;
        while let Some(at) = stack.pop() {
            let (x, y) = (at % w, at / w);
            for (nx, ny) in [((x + 1) % w, y), ((x + w - 1) % w, y), (x, (y + 1) % h), (x, (y + h - 1) % h)] {
                let n = ny * w + nx;
                if on[n] && !seen[n] {
                    seen[n] = true;
                    stack.push(n);
                }
            }
        }
    }
    (on.iter().filter(|&&b| b).count() as f64 / on.len() as f64, count)
}

fn solve(reaction: Reaction, texels: usize, seed: u32) -> Field {
    let (feed, kill) = reaction.rates().expect("a named reaction");
    let mut solver = Solver::new(texels, texels, (feed, kill), PERIOD.0, GrayScott::STEP);
    solver.seed(seed, PERIOD.0);
    solver.settle(MAX_STEPS);
    solver.field()
}

/// The period of a pattern of lines in all directions with this density of outlines (Buffon), texels.
fn period(field: &Field) -> f64 {
    let (w, h, values) = (field.width, field.height, field.values());
    let on = |x: usize, y: usize| values[(y % h) * w + x % w] > 0.5;
    let mut crossings = 0;
    for y in 0..h {
        for x in 0..w {
            crossings += usize::from(on(x, y) != on(x + 1, y)) + usize::from(on(x, y) != on(x, y + 1));
        }
    }
    4.0 / std::f64::consts::PI / (crossings as f64 / (2 * w * h) as f64)
}

const NAMED: [Reaction; 12] = [
    Reaction::Spots,
    Reaction::EvenSpots,
    Reaction::SparseSpots,
    Reaction::Maze,
    Reaction::Fingerprint,
    Reaction::Net,
    Reaction::Rings,
    Reaction::Worms,
    Reaction::Dashes,
    Reaction::InverseSpots,
    Reaction::InverseBeans,
    Reaction::Chains,
];

/// A cosine is an eigenfunction of the nine-point Laplacian on the torus, with a known eigenvalue.
#[test]
fn without_reaction_a_cosine_decays_as_its_eigenvalue_says_and_the_mean_stays() {
    let (w, h, steps) = (40, 24, 20);
    let mut solver = Solver::new(w, h, (0.0, 0.0), PERIOD.0, GrayScott::STEP);
    solver.rates.reaction = 0.0;
    let turn = |k: f64, x: usize, n: usize| std::f64::consts::TAU * k * x as f64 / n as f64;
    let mode = |x: usize, y: usize| turn(2.0, x, w).cos() * turn(3.0, y, h).cos();
    for y in 0..h {
        for x in 0..w {
            solver.u[y * (w + 2) + x + 1] = (0.5 + 0.4 * mode(x, y)) as f32;
        }
        wrap(&mut solver.u[y * (w + 2)..(y + 1) * (w + 2)]);
    }
    for _ in 0..steps {
        solver.step();
    }
    let (cx, cy) = (turn(2.0, 1, w).cos(), turn(3.0, 1, h).cos());
    let eigenvalue = 0.4 * (cx + cy) + 0.2 * cx * cy - 1.0;
    let left = 0.4 * (1.0 + f64::from(solver.rates.du) * eigenvalue).powi(steps);
    assert!((1e-6..0.3).contains(&left), "the test sees a decay: {left}");
    for y in 0..h {
        for x in 0..w {
            let u = f64::from(solver.u[y * (w + 2) + x + 1]);
            assert!((u - 0.5 - left * mode(x, y)).abs() < 1e-5, "({x}, {y}): {u}");
        }
    }
}

#[test]
fn spots_are_isolated_and_cover_a_quarter() {
    let field = solve(Reaction::Spots, 72, 3);
    let (share, count) = marks(&field);
    assert!((0.22..0.29).contains(&share), "{share}");
    // Hexagons of one period: 72^2 / (0.866 * 12^2) = 42.
    assert!((36..=48).contains(&count), "{count}");
}

#[test]
fn fingerprints_are_long_lines_of_about_the_stated_period() {
    let field = solve(Reaction::Fingerprint, 72, 3);
    let (share, count) = marks(&field);
    assert!((0.42..0.54).contains(&share), "{share}");
    assert!(count <= 6, "{count}");
    assert!((period(&field) / f64::from(PERIOD.0) - 1.0).abs() < 0.2, "{}", period(&field));
}

#[test]
fn every_named_reaction_comes_to_rest() {
    for reaction in NAMED {
        let (feed, kill) = reaction.rates().expect("a named reaction");
        assert_eq!(trial(feed, kill), Outcome::Rests, "{reaction:?}");
    }
}

#[test]
fn rates_that_move_or_die_are_refused_with_the_reason() {
    let custom = |feed, kill| GrayScott { reaction: Reaction::Custom, feed, kill, ..GrayScott::default() };
    for (feed, kill, why) in RESTLESS {
        let errors = custom(feed, kill).check();
        assert!(errors[0].message.contains(why), "{errors:?}");
    }
    // Not in the list: found by trial.
    assert!(custom(0.02, 0.069).check()[0].message.contains("dies"));
    assert!(custom(0.020, 0.052).check()[0].message.contains("rest"));
    assert!(custom(0.0367, 0.0649).check().is_empty());
}

#[test]
fn threads_change_nothing() {
    let with = |n| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("a pool of threads");
        pool.install(|| {
            let mut solver = Solver::new(150, 130, (0.03, 0.062), 12.0, GrayScott::STEP);
            solver.seed(7, 12.0);
            solver.settle(300);
            solver.field()
        })
    };
    assert_eq!(with(1), with(2));
}

#[test]
fn no_rate_makes_it_leave_its_range() {
    for (feed, kill) in
        [(0.0, 0.0), (1.0, 1.0), (1e30, -1e30), (-5.0, 3.0), (f32::MAX, f32::MAX), (0.5, -0.5)]
    {
        for (w, h) in [(16, 16), (4, 31)] {
            let mut solver = Solver::new(w, h, (feed, kill), 12.0, GrayScott::STEP);
            solver.seed(1, 12.0);
            solver.settle(500);
            for v in solver.field().values().iter().chain(&solver.u).chain(&solver.v) {
                assert!((0.0..=1.0).contains(v), "{feed} {kill}: {v}");
            }
        }
    }
}

#[test]
fn two_map_sizes_show_the_same_pattern() {
    let node = GrayScott { cells: 3, ..GrayScott::default() };
    let run = |size| {
        let out =
            crate::eval::run_node(&node, &crate::base::Domain::square(size), 1, &[], &Default::default(), 9);
        out.into_iter().next().expect("one output")
    };
    let (coarse, fine) = (run(64), run(128).halved());
    for (a, b) in coarse.data().iter().zip(fine.data()) {
        assert!((a - b).abs() < 0.02, "{a} {b}");
    }
    let (lo, hi) = num::min_max(coarse.data());
    assert!(lo >= 0.0 && hi <= 1.0 && hi - lo > 0.7, "{lo} {hi}");
}
