//! A farm by simulation: 10,000 frames over 200 nodes that fail, divided and scheduled by the code that renders.
//!
//! `cargo bench --bench farm [-- --nodes N --frames N --inferred SHARE --mtbf HOURS]` prints a table: docs/farms.md has it, and says
//! what follows. Seconds are simulated. What a frame costs is given, not measured: see `Model`.
#![allow(clippy::unwrap_used, reason = "a benchmark may stop at the first surprise")]

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap, HashSet, VecDeque};

use afterimage::scene::frames::{Frames, Run};
use afterimage::schedule::{self, Ancestry, Origin, Rule, Saved, Step};
use afterimage::settings::BasePlace;

/// What a farm and a shot are like.
#[derive(Debug, Clone)]
struct Model {
    frames: i32,
    nodes: usize,
    /// Seconds of a base frame.
    base: f64,
    /// Seconds of an inferred frame, of those of a base frame.
    inferred: f64,
    /// Standard deviation of what frames cost, of their mean.
    spread: f64,
    /// Seconds until a task has its scene.
    load: f64,
    /// Mean hours until a node fails, or is taken away.
    mtbf: f64,
    /// Seconds until the engine gives its task to another node.
    detection: f64,
    /// Seconds until the node is back.
    repair: f64,
    /// Bytes of a sample store, and how many of them a second are moved.
    store: f64,
    bandwidth: f64,
}

const USUAL: Model = Model {
    frames: 10_000,
    nodes: 200,
    base: 120.0,
    inferred: 0.35,
    spread: 0.25,
    load: 30.0,
    mtbf: 24.0,
    detection: 120.0,
    repair: 900.0,
    // 1920 x 1080 pixels of 2 x 2 samples of 70 bytes
    store: 1920.0 * 1080.0 * 4.0 * 70.0,
    bandwidth: 200e6,
};

/// How a shot is divided.
#[derive(Debug, Clone, Copy)]
struct Division {
    base_every: u32,
    /// Frames of a chunk; 0: chunks are segments.
    chunk: i32,
    /// Frames from one checkpoint to the next; 0: none.
    checkpoint: usize,
    /// True if chunks hand on their samples.
    handoff: bool,
}

/// A chunk, and how far it is.
struct Task {
    runs: Vec<Run>,
    finished: HashSet<i32>,
    checkpoint: Option<i32>,
}

#[derive(Debug, Default)]
struct Outcome {
    chunks: usize,
    makespan: f64,
    busy: f64,
    run_up: f64,
    failures: usize,
    /// Bytes of checkpoints written and read.
    moved: f64,
}

/// Pseudo-random numbers from 0 to 1, the same in each run (splitmix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

impl Model {
    /// Seconds of a step. What a frame costs is the frame's, whoever renders it.
    fn seconds(&self, step: Step) -> f64 {
        let mean = if step.origin == Origin::Nothing { self.base } else { self.base * self.inferred };
        let mut random = Random(step.frame as u64);
        let sum: f64 = (0..12).map(|_| random.next()).sum();
        mean * (1.0 + self.spread * (sum - 6.0)).max(0.2)
    }

    fn rule(&self, base_every: u32) -> Rule<'static> {
        let (shot_first, shot_last, base_place) = (1, Some(self.frames), BasePlace::First);
        Rule { shot_first, shot_last, base_every, base_place, cuts: &[], full: false }
    }

    /// Seconds of all nodes if they shared one chain of inferred frames without a loss: no farm is faster.
    fn ideal(&self) -> f64 {
        let steps =
            schedule::schedule(Frames::between(1, self.frames).runs(), &self.rule(0), None, |_| false);
        steps.unwrap().iter().map(|step| self.seconds(*step)).sum::<f64>() / self.nodes as f64
    }

    /// Tasks of the chunks, those with the least run-up first, as `farm` orders them.
    fn tasks(&self, Division { base_every, chunk, .. }: Division) -> VecDeque<Task> {
        let rule = self.rule(base_every);
        let mut parts: Vec<Vec<Run>> = match chunk {
            0 => schedule::segments(Frames::between(1, self.frames).runs(), &rule).unwrap(),
            _ => (1..=self.frames)
                .step_by(chunk as usize)
                .map(|first| vec![Run { first, last: (first + chunk - 1).min(self.frames), step: 1 }])
                .collect(),
        };
        parts.sort_by_cached_key(|runs| {
            let steps = schedule::schedule(runs, &rule, None, |_| false).unwrap();
            steps.iter().filter(|step| !step.write).count()
        });
        parts.into_iter().map(|runs| Task { runs, finished: HashSet::new(), checkpoint: None }).collect()
    }

    /// Simulates a farm.
    fn simulate(&self, division: Division) -> Outcome {
        let mut tasks = self.tasks(division);
        let mut handoffs = BTreeMap::new();
        let mut outcome = Outcome { chunks: tasks.len(), ..Outcome::default() };
        let mut random = Random(0xfa12);
        let mut life = || -self.mtbf * 3600.0 * (1.0 - random.next()).ln();
        let mut dies: Vec<f64> = (0..self.nodes).map(|_| life()).collect();
        // events in microseconds: a node is free, or a task comes back
        let at = |seconds: f64| (seconds * 1e6) as u64;
        let mut events: BinaryHeap<Reverse<(u64, usize)>> =
            (0..self.nodes).map(|node| Reverse((0, node))).collect();
        let mut back: Vec<(f64, Task)> = Vec::new();
        let mut idle: Vec<usize> = Vec::new();
        while let Some(Reverse((now, node))) = events.pop() {
            let seconds = now as f64 / 1e6;
            let (ready, later) = back.into_iter().partition::<Vec<_>, _>(|(when, _)| at(*when) <= now);
            back = later;
            tasks.extend(ready.into_iter().map(|(_, task)| task));
            if node < self.nodes {
                idle.push(node);
            }
            while let (Some(node), true) = (idle.last().copied(), !tasks.is_empty()) {
                idle.pop();
                let mut task = tasks.pop_front().unwrap();
                // it may have failed while it was idle
                while dies[node] <= seconds {
                    dies[node] += self.repair + life();
                }
                let when = (seconds, dies[node]);
                let end = self.work(&mut task, division, when, &mut handoffs, &mut outcome);
                if end < dies[node] {
                    events.push(Reverse((at(end), node)));
                    outcome.makespan = outcome.makespan.max(end);
                    continue;
                }
                outcome.failures += 1;
                let when = dies[node] + self.detection;
                back.push((when, task));
                events.push(Reverse((at(when), self.nodes)));
                events.push(Reverse((at(dies[node] + self.repair), node)));
                dies[node] += self.repair + life();
            }
        }
        assert!(tasks.is_empty() && back.is_empty(), "all is rendered");
        outcome
    }

    /// Works on a task from `start` on until it is done or the node `dies`. Returns when. `handoffs`: when the samples of a frame
    /// were handed on. Tasks come in the order in which they start.
    fn work(
        &self,
        task: &mut Task,
        division: Division,
        (start, dies): (f64, f64),
        handoffs: &mut BTreeMap<i32, f64>,
        outcome: &mut Outcome,
    ) -> f64 {
        let rule = &self.rule(division.base_every);
        let mut now = start + self.load;
        let ancestry = |frame: i32| {
            schedule::ancestries(&[Run { first: frame, last: frame, step: 1 }], rule).unwrap()[&frame]
        };
        let first = task.runs[0].first;
        let handed_on =
            handoffs.range(..first).rev().find(|(_, when)| **when <= now).map(|(frame, _)| *frame);
        let handed_on = handed_on.filter(|frame| ancestry(*frame) == ancestry(first));
        let saved = task.checkpoint.or(handed_on).map(|frame| Saved { frame, ancestry: ancestry(frame) });
        let steps =
            schedule::schedule(&task.runs, rule, saved, |frame| task.finished.contains(&frame)).unwrap();
        let mut since = 0;
        for (number, step) in steps.iter().enumerate() {
            let mut seconds = self.seconds(*step);
            since += 1;
            let goes_on = steps.get(number + 1).is_some_and(|next| next.origin == Origin::Before);
            let is_due = division.checkpoint > 0 && since >= division.checkpoint && goes_on && step.write;
            let leaves = division.handoff
                && number + 1 == steps.len()
                && !rule.followers(step.frame, 1).ways[0].is_empty();
            let moves = [is_due, leaves, step.origin == Origin::Saved].map(u8::from).iter().sum::<u8>();
            let moves = f64::from(moves);
            seconds += moves * self.store / self.bandwidth;
            if now + seconds > dies {
                outcome.busy += dies - start;
                return dies;
            }
            now += seconds;
            outcome.moved += moves * self.store;
            if is_due {
                (task.checkpoint, since) = (Some(step.frame), 0);
            }
            if leaves {
                handoffs.insert(step.frame, now);
            }
            if step.write {
                task.finished.insert(step.frame);
            } else {
                outcome.run_up += seconds;
            }
        }
        outcome.busy += now - start;
        now
    }
}

/// Value of an option.
fn option<T: std::str::FromStr>(name: &str, usual: T) -> T {
    let words: Vec<String> = std::env::args().collect();
    let value = words.windows(2).find(|pair| pair[0] == name).map(|pair| pair[1].parse());
    value.map_or(usual, |value| value.unwrap_or_else(|_| panic!("{name} takes a number")))
}

fn main() {
    let model = Model {
        nodes: option("--nodes", USUAL.nodes),
        frames: option("--frames", USUAL.frames),
        inferred: option("--inferred", USUAL.inferred),
        mtbf: option("--mtbf", USUAL.mtbf),
        ..USUAL
    };
    assert!(matches!(Saved { frame: 1, ancestry: Ancestry::Base }.holds(&model.rule(0)), Ok(true)));
    let ideal = model.ideal();
    println!(
        "{} frames, {} nodes, base frames {} s, inferred ones {} of that, {} h between failures of a node; ideal {:.2} h",
        model.frames,
        model.nodes,
        model.base,
        model.inferred,
        model.mtbf,
        ideal / 3600.0
    );
    println!(
        "| `base_every` | chunk | checkpoint | handoff | chunks | failures | makespan, h | of ideal | nodes busy | run-up | stores moved, GB |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    let rows = [6, 12, 24, 48, 96, 192]
        .map(|every| [(every, 0, 0, false), (every, 0, (every as usize / 4).max(1), false)])
        .concat();
    let others = [(48, 12), (48, 24), (192, 48)]
        .map(|(every, chunk)| [(every, chunk, 0, false), (every, chunk, 0, true)])
        .concat();
    for (base_every, chunk, checkpoint, handoff) in
        rows.into_iter().chain([(48, 96, 12, false)]).chain(others)
    {
        let outcome = model.simulate(Division { base_every, chunk, checkpoint, handoff });
        println!(
            "| {base_every} | {} | {} | {} | {} | {} | {:.2} | {:.2} | {:.0} % | {:.1} % | {:.0} |",
            if chunk == 0 { String::from("segment") } else { chunk.to_string() },
            if checkpoint == 0 { String::from("none") } else { checkpoint.to_string() },
            if handoff { "yes" } else { "no" },
            outcome.chunks,
            outcome.failures,
            outcome.makespan / 3600.0,
            outcome.makespan / ideal,
            100.0 * outcome.busy / (outcome.makespan * model.nodes as f64),
            100.0 * outcome.run_up / outcome.busy,
            outcome.moved / 1e9,
        );
    }
}
