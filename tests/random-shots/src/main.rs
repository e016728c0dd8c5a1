//! Tries random shots, prints what fails, cut down, and a table of what took part.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::Parser;
use random_shots::check::{Failure, Outcome};
use random_shots::run::{Options, Tally, run, run_kept, smallest};
use random_shots::trial::Trial;

/// Tries random shots: audit, full tracing, threads, stores, chunks.
#[derive(Debug, Parser)]
struct Args {
    /// The first seed
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How many shots
    #[arg(long, default_value_t = 1000)]
    count: u64,
    /// Stop after so many failures
    #[arg(long, default_value_t = 10)]
    failures: usize,
    /// Begin no further shot after so many seconds
    #[arg(long, default_value_t = 86_400)]
    seconds: u64,
    /// Pass over shots without this feature, as --table names it; may be given several times
    #[arg(long, value_name = "FEATURE")]
    having: Vec<String>,
    /// Shots at once
    #[arg(long, default_value_t = std::thread::available_parallelism().map_or(1, usize::from))]
    workers: usize,
    /// Renderings that cutting a failure down may take; 0: it is told as it is
    #[arg(long, default_value_t = 600)]
    shrink: usize,
    /// Write shots that fail, with all files that they name, to folders in this one
    #[arg(long, value_name = "FOLDER")]
    keep: Option<PathBuf>,
    /// Try the shots in this folder alone, each in every way
    #[arg(long, value_name = "FOLDER")]
    kept: Option<PathBuf>,
    /// Print how often features took part, as a table in Markdown
    #[arg(long)]
    table: bool,
    /// Only print the shot of the first seed
    #[arg(long)]
    show: bool,
    /// With --show: this shot, of whose files it is to name generated ones alone, instead of a seed's
    #[arg(long, value_name = "FILE.toml")]
    shot: Option<PathBuf>,
}

fn main() -> ExitCode {
    let args = Args::parse();
    if args.show {
        return show(&args);
    }
    if let Some(folder) = &args.kept {
        return try_kept(folder);
    }
    let options = Options {
        workers: args.workers.max(1),
        most_failures: args.failures,
        time: Duration::from_secs(args.seconds),
        having: args.having.clone(),
    };
    let told = |seed: u64, failure: &Failure| eprintln!("seed {seed}: {failure}");
    let seeds = args.seed..args.seed.saturating_add(args.count);
    let tally = match run(seeds, &options, told) {
        Ok(tally) => tally,
        Err(error) => {
            eprintln!("error: no folder for temporary files: {error}");
            return ExitCode::FAILURE;
        }
    };
    for (seed, failure) in &tally.failed {
        tell(&args, *seed, failure);
    }
    summarize(&tally);
    if args.table {
        print_table(&tally);
    }
    if tally.failed.is_empty() && tally.fairness.is_fair() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn try_kept(folder: &Path) -> ExitCode {
    let mut failed = 0;
    let tried = run_kept(folder, |path, trial, outcome| {
        if let Outcome::Failed(failure) = outcome {
            eprintln!("{}: {failure} ({:?}, {:?})", path.display(), trial.variation, trial.backend);
            failed += 1;
        }
    });
    match tried {
        Ok(count) => {
            println!("{count} trials: {failed} failed");
            if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
        }
        Err(error) => {
            eprintln!("error: {}: {error}", folder.display());
            ExitCode::FAILURE
        }
    }
}

fn show(args: &Args) -> ExitCode {
    let read = |path: &PathBuf| {
        let text = fs::read_to_string(path).map_err(|error| error.to_string())?;
        Trial::of_text(&text).map_err(|error| error.to_string())
    };
    let trial = match args.shot.as_ref().map(|path| read(path).map_err(|error| (path, error))) {
        None => Trial::of_seed(args.seed),
        Some(Ok(trial)) => trial,
        Some(Err((path, error))) => {
            eprintln!("error: {}: {error}", path.display());
            return ExitCode::FAILURE;
        }
    };
    println!("{}", trial.text());
    if let Some(folder) = &args.keep {
        let written = fs::create_dir_all(folder).and_then(|()| trial.write(folder));
        if let Err(error) = written {
            eprintln!("error: {}: {error}", folder.display());
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

/// Prints a failure with the smallest shot that fails in the same way.
fn tell(args: &Args, seed: u64, failure: &Failure) {
    let trial = smallest(seed, failure, args.shrink).unwrap_or_else(|_| Trial::of_seed(seed));
    println!("# seed {seed}: {failure}");
    let Trial { variation, turn, ahead, .. } = &trial;
    println!("# {variation:?}, from step {turn}; proofs look {ahead} frames ahead; {}", trial.command());
    println!("{}", trial.text());
    if let Some(folder) = &args.keep {
        let folder = folder.join(format!("seed-{seed}"));
        let written = fs::create_dir_all(&folder).and_then(|()| trial.write(&folder));
        match written {
            Ok(()) => println!("# in {}", folder.display()),
            Err(error) => eprintln!("error: {}: {error}", folder.display()),
        }
    }
}

fn summarize(tally: &Tally) {
    let refused: u64 = tally.refused.values().sum();
    let failed = tally.failed.len() as u64;
    let all = tally.passed + refused + failed;
    println!("{all} shots: {} held, {refused} were refused, {failed} failed", tally.passed);
    let counts = tally.counts;
    println!(
        "{} inferred frames, {} samples audited ({} on an edge; {} targets on an edge; {} surfaces in mirrors)",
        counts.inferred, counts.audited, counts.on_edge, counts.coverage_on_edge, counts.mirrored
    );
    println!(
        "laid over frames in full: {} cells, of which {} show another surface where rounding decides; the light of {} surfaces; \
         {} samples and {} pixels that are the same",
        counts.cells, counts.elsewhere, counts.surfaces, counts.compared, counts.pixels
    );
    println!(
        "a shot is brighter than in full by {:+.5} in the mean, where {:.5} is chance",
        2.0 * tally.fairness.mean(),
        2.0 * tally.fairness.allowed()
    );
    for (reason, count) in &tally.refused {
        println!("refused {count} times: {reason}");
    }
}

fn print_table(tally: &Tally) {
    println!("\n| feature | shots |\n|---|---|");
    for (feature, count) in &tally.with {
        println!("| {feature} | {count} |");
    }
    let rarest = tally.rarest();
    println!("\n{} features, {} pairs. The rarest:", tally.with.len(), rarest.len());
    println!("\n| pair | shots |\n|---|---|");
    for (count, feature, other) in rarest.into_iter().take(60) {
        println!("| {feature} + {other} | {count} |");
    }
}
