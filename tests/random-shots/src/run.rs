//! Tries many shots at once, and counts.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use std::{fs, io, thread};

use afterimage::trace::BackendKind;

use crate::check::{Counts, Failure, Outcome, Pools, check};
use crate::fairness::Fairness;
use crate::features::features;
use crate::shrink::shrink;
use crate::trial::{AHEAD, Trial, Variation};

/// What came out.
#[derive(Debug, Default)]
pub struct Tally {
    pub passed: u64,
    pub counts: Counts,
    /// Whether shots are as bright as in full.
    pub fairness: Fairness,
    /// By reason, without what changes from shot to shot.
    pub refused: BTreeMap<String, u64>,
    /// By seed.
    pub failed: BTreeMap<u64, Failure>,
    /// Trials in which a feature took part.
    pub with: BTreeMap<String, u64>,
    /// The same of two features, in the order of their names.
    pub with_both: BTreeMap<(String, String), u64>,
}

/// Shots between two lines that tell how far a run is.
const TELL_EVERY: u64 = 2000;

/// How trials are run.
#[derive(Debug, Clone)]
pub struct Options {
    /// Trials at once.
    pub workers: usize,
    /// No further ones are begun when so many have failed.
    pub most_failures: usize,
    /// Nor after so long.
    pub time: Duration,
    /// [Features] that a shot must have, all of them; others are passed over.
    ///
    /// [Features]: crate::features
    pub having: Vec<String>,
}

impl Options {
    fn wants(&self, trial: &Trial) -> bool {
        let wanted = &self.having;
        wanted.is_empty() || {
            let found = features(trial);
            wanted.iter().all(|name| found.contains(name))
        }
    }
}

/// Tries the shots of `seeds`. `said` is called for each that fails.
///
/// # Errors
/// If there is no folder for temporary files.
pub fn run(seeds: Range<u64>, options: &Options, said: impl Fn(u64, &Failure) + Sync) -> io::Result<Tally> {
    let (next, tally, start) = (AtomicU64::new(seeds.start), Mutex::new(Tally::default()), Instant::now());
    let folders = (0..options.workers).map(|_| folder()).collect::<io::Result<Vec<_>>>()?;
    thread::scope(|scope| {
        for folder in &folders {
            scope.spawn(|| {
                let pools = Pools::new();
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    let is_enough =
                        tally.lock().is_ok_and(|tally| tally.failed.len() >= options.most_failures);
                    if seed >= seeds.end || is_enough || start.elapsed() > options.time {
                        break;
                    }
                    let done = seed - seeds.start;
                    if done > 0 && done % TELL_EVERY == 0 {
                        eprintln!("{done} shots, {} seconds", start.elapsed().as_secs());
                    }
                    let trial = Trial::of_seed(seed);
                    if !options.wants(&trial) {
                        continue;
                    }
                    let outcome = check(&trial, folder.path(), &pools);
                    if let Outcome::Failed(failure) = &outcome {
                        said(seed, failure);
                    }
                    if let Ok(mut tally) = tally.lock() {
                        tally.add(seed, &trial, outcome);
                    }
                }
            });
        }
    });
    Ok(tally.into_inner().unwrap_or_default())
}

/// Tries each shot file in `kept`, in every way. `told` is called with how each trial ended. How many were tried.
///
/// # Errors
/// If a file cannot be read.
pub fn run_kept(
    kept: &Path,
    mut told: impl FnMut(&Path, &Trial, &Outcome),
) -> Result<usize, Box<dyn std::error::Error>> {
    let (folder, pools) = (folder()?, Pools::new());
    let mut paths = kept.read_dir()?.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<_>>>()?;
    paths.sort();
    let mut count = 0;
    for path in paths {
        let text = fs::read_to_string(&path)?;
        for backend in [BackendKind::Embree, BackendKind::Rust] {
            for (variation, ahead) in Variation::ALL.into_iter().zip(AHEAD.into_iter().cycle()) {
                let trial = Trial { variation, backend, ahead, ..Trial::of_text(&text)? };
                told(&path, &trial, &check(&trial, folder.path(), &pools));
                count += 1;
            }
        }
    }
    Ok(count)
}

/// The trial of `seed` with a shot that is as small as can be found and fails in the same way.
///
/// # Errors
/// If there is no folder for temporary files.
pub fn smallest(seed: u64, failure: &Failure, most: usize) -> io::Result<Trial> {
    let (folder, pools, trial) = (folder()?, Pools::new(), Trial::of_seed(seed));
    let shot = shrink(&trial.shot, most, |shot| {
        let smaller = Trial { shot: shot.clone(), ..trial.clone() };
        matches!(check(&smaller, folder.path(), &pools), Outcome::Failed(found) if found.kind == failure.kind)
    });
    Ok(Trial { shot, ..trial })
}

/// In memory where there is a file system for that: shots are many, small and soon gone.
fn folder() -> io::Result<tempfile::TempDir> {
    let in_memory = Path::new("/dev/shm");
    if in_memory.is_dir() { tempfile::tempdir_in(in_memory) } else { tempfile::tempdir() }
}

impl Tally {
    fn add(&mut self, seed: u64, trial: &Trial, outcome: Outcome) {
        match outcome {
            Outcome::Passed(counts) => {
                self.passed += 1;
                self.counts.add(&counts);
                self.fairness.add(counts.brighter);
            }
            Outcome::Refused(reason) => {
                *self.refused.entry(without_numbers(&reason)).or_default() += 1;
                return;
            }
            Outcome::Failed(failure) => drop(self.failed.insert(seed, failure)),
        }
        let features: BTreeSet<String> = features(trial);
        for feature in &features {
            *self.with.entry(feature.clone()).or_default() += 1;
            for other in features.range(feature.clone()..).skip(1) {
                *self.with_both.entry((feature.clone(), other.clone())).or_default() += 1;
            }
        }
    }

    /// Pairs of features that met in fewest trials, the rarest first, and how often; pairs that cannot meet among them.
    pub fn rarest(&self) -> Vec<(u64, &str, &str)> {
        let mut pairs: Vec<(u64, &str, &str)> = vec![];
        for (first, feature) in self.with.keys().enumerate() {
            for other in self.with.keys().skip(first + 1) {
                let count = self.with_both.get(&(feature.clone(), other.clone())).copied().unwrap_or(0);
                pairs.push((count, feature, other));
            }
        }
        pairs.sort_unstable();
        pairs
    }
}

/// A message without its place and its numbers.
fn without_numbers(text: &str) -> String {
    let after = text.split_once("shot.toml").map_or(text, |(_, after)| after);
    after.chars().filter(|character| !character.is_ascii_digit()).take(100).collect()
}
