//! `afterimage preview`: frames of a shot in a local web page, which follows the shot file while it is edited.
//!
//! A worker loads the shot, renders the frames that the page asks for, and loads it again when a file of it changes. Threads that
//! answer the page talk to it over a [`Board`](board::Board) alone.

mod board;
mod http;
mod watch;
mod worker;

use std::net::{Ipv4Addr, TcpListener};
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;

use clap::Args;

use super::bare_model::{UpArg, turntable_options};
use super::failure::Failure;
use super::shot_args::{self, size, threads};
use super::terminal::Terminal;
use crate::settings::{MOST_PATHS, MOST_SAMPLES};
use board::Board;
use worker::Worker;

/// As typed.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  afterimage preview walk.toml
      prints the address of a page on this machine; edit walk.toml and watch the page
  afterimage preview statue.obj --size 960x540 --samples 2
      a model on a turntable, in better quality

Keys in the page: left and right step, space plays, Home and End go to the first and the last frame. Nothing is
written. The page is served to this machine alone (127.0.0.1), until Ctrl-C.")]
pub struct PreviewArgs {
    /// A shot (TOML), or a model (OBJ), shown on a turntable
    #[arg(value_name = "SHOT.toml|MODEL.obj")]
    shot: PathBuf,

    /// Port of the page's address; 0: any that is free
    #[arg(long, value_name = "N", default_value_t = 0)]
    port: u16,

    /// Size of the pictures in pixels [default: the shot's, made smaller to fit into 640x640]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<(u32, u32)>,

    /// N, for N x N samples a pixel
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_SAMPLES)))]
    samples: u32,

    /// Paths by which each sample gathers light, at most: no more than the shot's
    #[arg(long, value_name = "PATHS", default_value_t = 8, value_parser = clap::value_parser!(u32).range(0..=i64::from(MOST_PATHS)))]
    paths: u32,

    /// Of a bare model: the axis of its file that points up [default: guessed from what the model stands on]
    #[arg(long, value_enum, value_name = "AXIS")]
    up: Option<UpArg>,

    /// Number of rendering threads [default: one per core]
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<NonZeroUsize>,
}

impl PreviewArgs {
    /// Serves the page until the program is ended.
    pub fn execute(self, terminal: &mut Terminal) -> Result<(), Failure> {
        // what makes no sense whatever the files say
        turntable_options(&self.shot, self.up, self.size)?;
        let pool = shot_args::pool(self.threads)?;
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, self.port)).map_err(|error| {
            let port = self.port;
            Failure::Failed(format!(
                "cannot listen on port {port}: {error}; choose another --port, or 0 for any"
            ))
        })?;
        let address = listener.local_addr().map_err(Failure::of)?;
        let board = Arc::new(Board::new(&self.shot));
        let worker = Worker { args: self, board: board.clone() };
        let thread = thread::Builder::new().name("afterimage-preview".to_owned());
        let cannot_start = |error| Failure::Failed(format!("cannot start a thread: {error}"));
        thread.spawn(move || pool.install(|| worker.work())).map_err(cannot_start)?;
        terminal.result(&format!("preview at http://{address}/ (Ctrl-C ends it)"));
        http::serve(&listener, &board);
        Ok(())
    }
}
