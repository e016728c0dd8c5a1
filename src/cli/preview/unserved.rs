//! Answers without a server, for `fuzz/`: with a shot whose pictures nobody makes.

use std::path::Path;

use super::answer::answer;
use super::board::{Board, Loaded};
use super::camera::ShotCamera;
use super::request::Door;
use super::token::Token;
use crate::scene::Shot;

/// Stands for the token in a request, which differs from run to run.
const TOKEN: &str = "TOKEN";

/// Page of a shot that nobody serves. Its port is 8080.
pub struct Unserved {
    door: Door,
    board: Board,
}

impl Unserved {
    /// Creates the page of `shot`.
    ///
    /// # Errors
    /// The system gives no random numbers.
    pub fn new(shot: &Shot) -> std::io::Result<Self> {
        let board = Board::new(Path::new("s.toml"));
        board.loaded(Loaded {
            title: "",
            frames: &shot.frames,
            rate: shot.rate,
            notes: Vec::new(),
            camera: ShotCamera::new(shot),
            size: [shot.settings.width, shot.settings.height],
        });
        Ok(Self { door: Door { port: 8080, token: Token::random()? }, board })
    }

    /// Status of the answer to the request with this `head`, in which `TOKEN` stands for the token. The first version of the shot is 1.
    pub fn status(&self, head: &[u8]) -> &'static str {
        let head = match std::str::from_utf8(head) {
            Ok(text) => text.replace(TOKEN, &self.door.token.to_string()).into_bytes(),
            Err(_) => head.to_vec(),
        };
        answer(&head, &self.door, &self.board).status
    }
}
