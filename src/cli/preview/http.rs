//! As much of HTTP/1.1 (RFC 9112) as one page on this machine needs: GET, a connection a request.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use super::board::Board;

/// The page itself.
const PAGE: &str = include_str!("page.html");

/// Bytes of a request's head, at most.
const MOST_BYTES: u64 = 16 << 10;
/// Connections at once, at most: others are closed.
const MOST_CONNECTIONS: usize = 32;
/// How long a client may take to send its request or to take its answer.
const PATIENCE: Duration = Duration::from_secs(10);
/// How long a request waits for a frame. The page asks again.
const FRAME_PATIENCE: Duration = Duration::from_secs(25);

/// What is answered.
#[derive(Debug, PartialEq, Eq)]
struct Answer {
    /// Code and reason.
    status: &'static str,
    kind: &'static str,
    /// One more header line, if any.
    header: String,
    body: Vec<u8>,
}

impl Answer {
    fn text(status: &'static str, text: &str) -> Self {
        Self { status, kind: "text/plain; charset=utf-8", header: String::new(), body: text.into() }
    }
}

/// Answers for as long as the program runs.
pub fn serve(listener: &TcpListener, board: &Arc<Board>) {
    let connections = Arc::new(AtomicUsize::new(0));
    for stream in listener.incoming() {
        // a client that left before it was seen is nobody's error; if there are too many files, some will be closed
        let Ok(stream) = stream else {
            thread::sleep(Duration::from_millis(50));
            continue;
        };
        let (board, connections) = (board.clone(), connections.clone());
        if connections.load(Ordering::Relaxed) >= MOST_CONNECTIONS {
            continue;
        }
        connections.fetch_add(1, Ordering::Relaxed);
        let counted = connections.clone();
        let thread = thread::Builder::new().name("afterimage-http".to_owned()).spawn(move || {
            // whoever does not wait for the answer does not want it
            let _ = converse(&stream, &board);
            connections.fetch_sub(1, Ordering::Relaxed);
        });
        if thread.is_err() {
            counted.fetch_sub(1, Ordering::Relaxed);
        }
    }
}

fn converse(mut stream: &TcpStream, board: &Board) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut lines = BufReader::new(stream.take(MOST_BYTES)).lines();
    let request = lines.next().transpose()?.unwrap_or_default();
    let mut host = None;
    for line in lines {
        let line = line?;
        if line.is_empty() {
            break;
        }
        let header = line.split_once(':').filter(|(name, _)| name.eq_ignore_ascii_case("host"));
        host = header.map(|(_, value)| value.trim().to_owned()).or(host);
    }
    let Answer { status, kind, header, body } = answer(&request, host.as_deref(), board);
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-store\r\n\
         X-Content-Type-Options: nosniff\r\nContent-Security-Policy: default-src 'self' 'unsafe-inline'; img-src 'self' \
         blob:\r\n{header}Connection: close\r\n\r\n",
        body.len()
    )?;
    stream.write_all(&body)?;
    stream.flush()
}

fn answer(request: &str, host: Option<&str>, board: &Board) -> Answer {
    // pages from elsewhere may lead their own name to this machine: they send that name
    let name = host.map(|host| host.rsplit_once(':').map_or(host, |(name, _)| name));
    if !matches!(name, Some("127.0.0.1" | "localhost")) {
        return Answer::text("403 Forbidden", "this page is for 127.0.0.1 and localhost alone\n");
    }
    let mut words = request.split(' ');
    let (Some(method), Some(target)) = (words.next(), words.next()) else {
        return Answer::text("400 Bad Request", "this is no request\n");
    };
    if method != "GET" {
        return Answer::text("405 Method Not Allowed", "nothing but GET is answered\n");
    }
    let parts: Vec<&str> = target.split('/').skip(1).collect();
    match parts[..] {
        [""] => Answer { kind: "text/html; charset=utf-8", ..Answer::text("200 OK", PAGE) },
        ["state"] => Answer { kind: "application/json", ..Answer::text("200 OK", &board.told().to_string()) },
        ["frame", version, frame] => {
            let (Ok(version), Ok(frame)) = (version.parse(), frame.parse()) else {
                return Answer::text("400 Bad Request", "write /frame/VERSION/NUMBER\n");
            };
            match board.picture(version, frame, FRAME_PATIENCE) {
                Some(shown) => Answer {
                    status: "200 OK",
                    kind: "image/png",
                    header: format!("X-Seconds: {:.3}\r\n", shown.seconds),
                    body: shown.png.to_vec(),
                },
                None => Answer::text("404 Not Found", "this frame is not there (any more, or yet)\n"),
            }
        }
        _ => Answer::text("404 Not Found", "there is nothing here\n"),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn status(request: &str, host: Option<&str>) -> &'static str {
        answer(request, host, &Board::new(Path::new("a.toml"))).status
    }

    #[test]
    fn only_this_machine_is_answered() {
        for host in ["127.0.0.1:80", "localhost:8080", "localhost"] {
            assert_eq!(status("GET / HTTP/1.1", Some(host)), "200 OK", "{host}");
        }
        for host in [Some("evil.example:80"), Some(""), Some("127.0.0.1.evil.example"), None] {
            assert_eq!(status("GET / HTTP/1.1", host), "403 Forbidden", "{host:?}");
        }
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        for (request, code) in [
            ("", "400"),
            ("GET", "400"),
            ("POST / HTTP/1.1", "405"),
            ("GET /../etc/passwd HTTP/1.1", "404"),
            ("GET /frame/1 HTTP/1.1", "404"),
            ("GET /frame/x/1 HTTP/1.1", "400"),
            ("GET /frame/7/1 HTTP/1.1", "404"),
        ] {
            let status = status(request, Some("localhost"));
            assert!(status.starts_with(code), "{request}: {status}");
        }
    }
}
