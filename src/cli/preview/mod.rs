//! `afterimage preview`: frames of a shot in a local web page, which follows the shot file while it is edited.
//!
//! A worker loads the shot, renders what the page asks for, and loads it again when a file of it changes: frames of the shot, and
//! [views] of cameras that the page leads around. Threads that answer the page talk to it over a [`Board`] alone.

mod answer;
mod args;
mod board;
mod camera;
mod http;
mod needless;
mod request;
mod response;
mod token;
#[cfg(fuzzing)]
pub mod unserved;
mod views;
mod watch;
mod worker;

use std::net::{Ipv4Addr, TcpListener};
use std::sync::Arc;
use std::thread;

use super::args::pool;
use super::failure::Failure;
use super::say::terminal::Terminal;
pub use args::PreviewArgs;
use board::Board;
use request::Door;
use token::Token;
use worker::Worker;

impl PreviewArgs {
    /// Serves the page until the program is ended.
    pub fn execute(self, terminal: &mut Terminal) -> Result<(), Failure> {
        // what makes no sense whatever the files say
        self.bare.options(&self.shot, self.size)?;
        let pool = pool(self.threads)?;
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, self.port)).map_err(|error| {
            let port = self.port;
            Failure::Failed(format!(
                "cannot listen on port {port}: {error}; choose another --port, or 0 for any"
            ))
        })?;
        let address = listener.local_addr().map_err(Failure::of)?;
        let token = Token::random()
            .map_err(|error| Failure::Failed(format!("no random numbers for the page's address: {error}")))?;
        terminal.result(&format!("preview at http://{address}/{token}/ (Ctrl-C ends it)"));
        // nobody could find it
        terminal.printed()?;
        let board = Arc::new(Board::new(&self.shot));
        let worker = Worker { args: self, board: board.clone() };
        let thread = thread::Builder::new().name("afterimage-preview".to_owned());
        let cannot_start = |error| Failure::Failed(format!("cannot start a thread: {error}"));
        thread.spawn(move || pool.install(|| worker.work())).map_err(cannot_start)?;
        http::serve(&listener, Door { port: address.port(), token }, board);
        Ok(())
    }
}
