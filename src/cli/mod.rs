//! The command line: the only room that prints.
//!
//! Arguments are parsed as typed (`…Args`), then turned into options that make sense; only those reach
//! the rest of the program. Results go to stdout, everything else to stderr.

pub mod args;
pub mod bare_model;
mod coarse;
pub mod compare;
mod denoising;
pub mod diff;
pub mod failure;
pub mod farm;
pub mod for_others;
pub mod frames;
pub mod info;
pub mod init;
pub mod preview;
pub mod render;
pub mod say;
pub mod stop;
pub mod usd_args;
pub mod verify;

use std::ffi::{OsStr, OsString};
use std::io::ErrorKind;
use std::process::ExitCode;
use std::sync::Arc;

use clap::{CommandFactory, Parser, Subcommand};

use crate::report::versions::AFTERIMAGE;
use crate::trace::embree;
use crate::visible::visible;
use failure::Failure;
use say::terminal::{ProgressKind, Terminal, unprinted};

/// A ray tracer for animations that reuses the previous frame's samples, exactly.
///
/// The first frame of a shot is traced in full. Later frames project the previous frame's samples to the new
/// camera, verify them with rays, and trace only what is new. Frames are multi-layer EXR files; `--audit`
/// proves that no sample is wrong.
#[derive(Debug, Parser)]
#[command(name = "afterimage", version = AFTERIMAGE, arg_required_else_help = true, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render frames of a shot, or of a model on a turntable, to EXR files
    Render(Box<render::RenderArgs>),
    /// Render frames with reuse and in full, with each backend, and compare rays, seconds and pictures
    Compare(Box<compare::CompareArgs>),
    /// Compare two EXR files, or two sequences of them, layer by layer
    Diff(diff::DiffArgs),
    /// Describe a shot, a model or an EXR; without a file: versions and CPU
    Info(info::InfoArgs),
    /// Write a commented shot file for a model, to start from
    Init(init::InitArgs),
    /// Tell whether all frames of a shot are there, whole, and of one run
    Verify(verify::VerifyArgs),
    /// Write what a farm's engine needs to render a shot in chunks
    Farm(Box<farm::FarmArgs>),
    /// Show frames of a shot in a local web page that follows the shot file while it is edited
    Preview(preview::PreviewArgs),
    /// Print completions of the command line for a shell
    Completions(for_others::CompletionsArgs),
    /// Print the man page, or write those of all commands
    Man(for_others::ManArgs),
    /// Print a JSON schema of shot files, for editors
    Schema(for_others::SchemaArgs),
}

/// Runs the program. `words` starts with the program's name.
///
/// The exit code is 0 only if everything that was asked for was done, 1 if something failed, 2 if the
/// command line makes no sense. That of `diff` is 1 if the files differ, and 2 if something failed.
pub fn run(words: impl IntoIterator<Item = OsString>) -> ExitCode {
    let_writing_fail();
    let words: Vec<OsString> = words.into_iter().collect();
    let cli = match Cli::try_parse_from(&words) {
        Ok(cli) => cli,
        Err(error) => {
            // help and version are results and end with 0; a closed pipe is no error
            let error = harmless(error, &words);
            let printed = error.print();
            return match printed {
                Err(why) if !error.use_stderr() && why.kind() != ErrorKind::BrokenPipe => {
                    fail(&unprinted(&why))
                }
                _ => ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2)),
            };
        }
    };
    if let Err(error) = embree::check_config() {
        return fail(&Failure::Usage(error.0));
    }
    match cli.command {
        Command::Render(args) => {
            let mut terminal = args.terminal();
            let outcome = args.execute(&mut terminal);
            conclude(outcome, &terminal)
        }
        Command::Compare(args) => {
            let mut terminal = args.terminal();
            let outcome = args.execute(command_line(&words), &mut terminal);
            conclude(outcome, &terminal)
        }
        Command::Diff(args) => {
            let mut terminal = args.terminal();
            match args.execute(&mut terminal).and_then(|differs| terminal.printed().map(|()| differs)) {
                Ok(differs) => ExitCode::from(u8::from(differs)),
                Err(failure) => {
                    terminal.error(&failure.to_string());
                    ExitCode::from(2)
                }
            }
        }
        Command::Info(args) => quietly(|terminal| args.execute(terminal)),
        Command::Init(args) => quietly(|terminal| args.execute(terminal)),
        Command::Verify(args) => quietly(|terminal| args.execute(terminal)),
        Command::Farm(args) => quietly(|terminal| args.execute(terminal)),
        Command::Preview(args) => quietly(|terminal| args.execute(terminal)),
        Command::Completions(args) => quietly(|terminal| args.execute(Cli::command(), terminal)),
        Command::Man(args) => quietly(|terminal| args.execute(Cli::command(), terminal)),
        Command::Schema(args) => quietly(|terminal| args.execute(terminal)),
    }
}

/// Makes a file that grows beyond the limit on files (`ulimit -f`) an error of the one who writes it. Otherwise the system ends the
/// program there, which could neither say so nor remove what is not whole. (Programs that it starts do not inherit this.)
fn let_writing_fail() {
    // the flag is never read; if the signal cannot be registered, everything is as before
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
}

/// Runs a command without progress.
fn quietly(execute: impl FnOnce(&mut Terminal) -> Result<(), Failure>) -> ExitCode {
    let mut terminal = Terminal::new(ProgressKind::None, false);
    let outcome = execute(&mut terminal);
    conclude(outcome, &terminal)
}

/// Rebuilds the error for words that are safe to show: clap prints them among its own colours, where they can
/// no longer be told apart.
fn harmless(error: clap::Error, words: &[OsString]) -> clap::Error {
    let words = words.iter().map(|word| visible(&word.to_string_lossy()).into_owned());
    Cli::try_parse_from(words).err().unwrap_or(error)
}

/// The command line as a shell takes it, with the program's bare name.
fn command_line(words: &[OsString]) -> String {
    let mut text = String::from("afterimage");
    for word in words.iter().skip(1) {
        text.push(' ');
        text.push_str(&quoted(word));
    }
    text
}

/// A word as a shell takes it.
pub(crate) fn quoted(word: &OsStr) -> String {
    let word = word.to_string_lossy();
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:=+%@".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.into_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

fn conclude(outcome: Result<(), Failure>, terminal: &Terminal) -> ExitCode {
    // who fails otherwise has a better reason
    match outcome.and_then(|()| terminal.printed()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            terminal.error(&failure.to_string());
            failure.exit_code()
        }
    }
}

/// Ends with a failure before any command has begun.
fn fail(failure: &Failure) -> ExitCode {
    Terminal::new(ProgressKind::None, false).error(&failure.to_string());
    failure.exit_code()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definitions_hold_together() {
        Cli::command().debug_assert();
    }

    #[test]
    fn the_command_line_can_be_pasted_into_a_shell() {
        let words =
            ["/x/afterimage", "compare", "a b.toml", "-o", "x.####.exr", "it's", ""].map(OsString::from);
        assert_eq!(command_line(&words), r"afterimage compare 'a b.toml' -o 'x.####.exr' 'it'\''s' ''");
    }
}
