//! Answers to requests.

use std::time::Duration;

use super::board::{Board, Detail, View, ViewedPicture};
use super::camera::{FreeCamera, ShotCamera};
use super::request::{Door, Request};
use super::response::Answer;
use crate::scene::CameraTrack;

/// Files of the page: itself, its style, its scripts, and its icon.
const PAGE: [(&str, &str, &str); 5] = [
    ("", "text/html; charset=utf-8", include_str!("page.html")),
    ("page.css", "text/css; charset=utf-8", include_str!("page.css")),
    ("camera.js", "text/javascript; charset=utf-8", include_str!("camera.js")),
    ("page.js", "text/javascript; charset=utf-8", include_str!("page.js")),
    ("icon.svg", "image/svg+xml", include_str!("icon.svg")),
];

/// Maximum time that a request waits for a picture. The page asks again. (Nobody makes pictures for `fuzz/`.)
const PATIENCE: Duration = if cfg!(fuzzing) { Duration::ZERO } else { Duration::from_secs(25) };

/// Answer to the request with this `head`.
pub fn answer(head: &[u8], door: &Door, board: &Board) -> Answer {
    let Some(request) = Request::parse(head) else {
        return Answer::text("400 Bad Request", "this is no request of HTTP/1.1\n");
    };
    match door.admit(&request) {
        Ok(_) if request.method != "GET" => {
            let header = String::from("Allow: GET\r\n");
            Answer::text("405 Method Not Allowed", "nothing but GET is answered\n").with_header(header)
        }
        Ok(path) => answer_path(path, board),
        Err(refusal) => refusal,
    }
}

/// Answer for `path`, behind the token.
fn answer_path(path: &str, board: &Board) -> Answer {
    if let Some((_, kind, text)) = PAGE.iter().find(|(name, _, _)| *name == path) {
        return Answer::of_kind(kind, "200 OK", *text);
    }
    let parts: Vec<&str> = path.split('/').collect();
    match parts[..] {
        ["state"] => Answer::of_kind("application/json", "200 OK", board.told().to_string()),
        ["frame", version, frame] => {
            let (Ok(version), Ok(frame)) = (version.parse(), frame.parse()) else {
                return Answer::text("400 Bad Request", "write frame/VERSION/NUMBER\n");
            };
            or_missing(board.picture(version, frame, PATIENCE))
        }
        ["camera", version, frame] => of_camera(board, [version, frame], |camera, frame| {
            Ok(Answer::of_kind("application/json", "200 OK", camera.told(frame).to_string()))
        }),
        ["key", version, frame, free] => of_camera(board, [version, frame], |camera, frame| {
            let key = camera.key(&free_camera(free, camera, frame)?.0, frame);
            Ok(Answer::text("200 OK", key))
        }),
        ["view", version, frame, page, detail, free] => {
            of_camera(board, [version, frame], |camera, frame| {
                let detail = match detail {
                    "coarse" => Detail::Coarse,
                    "full" => Detail::Full,
                    _ => return Err("write view/VERSION/FRAME/PAGE/coarse or full/CAMERA\n"),
                };
                let (_, camera) = free_camera(free, camera, frame)?;
                let view = View { frame, camera, detail };
                let numbers = (version.parse(), page.parse());
                let (Ok(version), Ok(page)) = numbers else { return Err("PAGE is a number\n") };
                Ok(match board.view(version, page, view, PATIENCE).transpose() {
                    Ok(shown) => or_missing(shown),
                    Err(error) => Answer::text("500 Internal Server Error", error),
                })
            })
        }
        _ => Answer::text("404 Not Found", "there is nothing here\n"),
    }
}

/// Answer of `answer` for the shot's camera at a frame, if that can be shown; an error is a bad request.
fn of_camera(
    board: &Board,
    [version, frame]: [&str; 2],
    answer: impl FnOnce(&ShotCamera, i32) -> Result<Answer, &'static str>,
) -> Answer {
    let (Ok(version), Ok(frame)) = (version.parse(), frame.parse()) else {
        return Answer::text("400 Bad Request", "VERSION and FRAME are numbers\n");
    };
    match board.camera(version, frame) {
        Some(camera) => answer(&camera, frame).unwrap_or_else(|error| Answer::text("400 Bad Request", error)),
        None => Answer::text("404 Not Found", "there is no such version, or no such frame in it\n"),
    }
}

/// The camera that `text` says, and what the renderer makes of it.
fn free_camera(
    text: &str,
    of_shot: &ShotCamera,
    frame: i32,
) -> Result<(FreeCamera, CameraTrack), &'static str> {
    let free = FreeCamera::parse(text);
    let both = free.and_then(|free| Some((free, of_shot.track(&free, frame)?)));
    both.ok_or("a camera is eight numbers between commas: eye, target elsewhere, roll, fov or height\n")
}

fn or_missing(shown: Option<ViewedPicture>) -> Answer {
    let missing = || Answer::text("404 Not Found", "this picture is not there (any more, or yet)\n");
    shown.map_or_else(missing, Answer::picture)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::cli::preview::token::Token;

    #[test]
    fn what_makes_no_sense_is_refused() {
        let door = Door { port: 8080, token: Token::random().expect("random numbers") };
        let board = Board::new(Path::new("a.toml"));
        for (request, code) in [
            ("GET TOKEN/ HTTP/1.1", "200"),
            ("GET TOKEN/page.js HTTP/1.1", "200"),
            ("GET TOKEN/state HTTP/1.1", "200"),
            ("", "400"),
            ("GET", "400"),
            ("POST TOKEN/ HTTP/1.1", "405"),
            ("POST / HTTP/1.1", "403"),
            ("GET TOKEN/../etc/passwd HTTP/1.1", "404"),
            ("GET TOKEN/page.css/ HTTP/1.1", "404"),
            ("GET TOKEN/frame/1 HTTP/1.1", "404"),
            ("GET TOKEN/frame/x/1 HTTP/1.1", "400"),
            ("GET TOKEN/frame/7/1 HTTP/1.1", "404"),
            ("GET TOKEN/camera/7/1 HTTP/1.1", "404"),
            ("GET TOKEN/camera/7/x HTTP/1.1", "400"),
            ("GET TOKEN/key/7/1/0,0,8,0,0,0,0,40 HTTP/1.1", "404"),
            ("GET TOKEN/view/7/1/1/full/0,0,8,0,0,0,0,40 HTTP/1.1", "404"),
        ] {
            let request = request.replace("TOKEN", &format!("/{}", door.token));
            let head = format!("{request}\r\nHost: localhost:8080\r\n\r\n");
            let status = answer(head.as_bytes(), &door, &board).status;
            assert!(status.starts_with(code), "{request}: {status}");
        }
    }
}
