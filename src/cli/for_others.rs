//! Descriptions of the command line and of shot files for other programs: completions for shells, man pages,
//! and a JSON schema.

use std::path::PathBuf;

use clap::{Args, Command};
use clap_complete::Shell;
use clap_mangen::Man;

use super::failure::Failure;
use super::say::terminal::Terminal;
use crate::{output, scene};

/// Arguments as typed.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  afterimage completions bash > ~/.local/share/bash-completion/completions/afterimage
  afterimage completions zsh > ~/.zfunc/_afterimage           (with ~/.zfunc in fpath)
  afterimage completions fish > ~/.config/fish/completions/afterimage.fish")]
pub struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

impl CompletionsArgs {
    /// Prints them.
    pub fn execute(&self, mut program: Command, terminal: &mut Terminal) -> Result<(), Failure> {
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut program, "afterimage", &mut text);
        terminal.raw(&text);
        Ok(())
    }
}

/// Arguments as typed.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  afterimage man | man -l -
  afterimage man -o ~/.local/share/man/man1     afterimage.1, afterimage-render.1, ...")]
pub struct ManArgs {
    /// Write the pages of the program and of all its commands into this folder
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

impl ManArgs {
    /// Prints or writes them.
    pub fn execute(&self, program: Command, terminal: &mut Terminal) -> Result<(), Failure> {
        let Some(folder) = &self.output else {
            let text = page(program.disable_help_subcommand(true)).map_err(Failure::of)?;
            terminal.raw(&text);
            return Ok(());
        };
        for command in commands(program) {
            let name = command.get_display_name().unwrap_or(command.get_name());
            let path = folder.join(format!("{name}.1"));
            let text = page(command).map_err(Failure::of)?;
            output::ensure_writable(&path).map_err(Failure::of)?;
            output::write_bytes(&path, &text).map_err(Failure::of)?;
            terminal.result(&path.display().to_string());
        }
        Ok(())
    }
}

fn page(command: Command) -> std::io::Result<Vec<u8>> {
    let mut text = Vec::new();
    Man::new(command).render(&mut text)?;
    Ok(text)
}

/// Commands: the program, and each of its commands, with the names of their pages set.
fn commands(program: Command) -> Vec<Command> {
    let mut program = program.disable_help_subcommand(true);
    program.build();
    let commands: Vec<Command> = program.get_subcommands().cloned().collect();
    std::iter::once(program).chain(commands).collect()
}

/// Arguments as typed.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Example:
  afterimage schema > afterimage.schema.json
and, as the first line of a shot file, for editors with Taplo or Even Better TOML:
  #:schema ./afterimage.schema.json")]
pub struct SchemaArgs {}

impl SchemaArgs {
    /// Prints it.
    pub fn execute(&self, terminal: &mut Terminal) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(&scene::schema()).map_err(Failure::of)?;
        terminal.raw(format!("{text}\n").as_bytes());
        Ok(())
    }
}
