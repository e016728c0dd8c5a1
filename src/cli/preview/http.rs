//! Connections: as much of HTTP/1.1 as one page on this machine needs, one request each.
//!
//! Any program on this machine may connect. A request has one deadline, however it is sent, and slow ones
//! make room for others.

use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use super::answer::answer;
use super::board::Board;
use super::request::Door;
use super::response::Answer;

/// Maximum size of a request's head, bytes.
const MOST_BYTES: usize = 16 << 10;
/// Maximum number of connections whose request is not complete yet: the oldest one makes room.
const MOST_WAITING: usize = 32;
/// Maximum number of requests that are answered at once.
const MOST_ANSWERED: usize = 64;
/// Time limit for receiving a whole request.
const REQUEST_PATIENCE: Duration = Duration::from_secs(5);
/// Time limit for sending a whole answer.
const ANSWER_PATIENCE: Duration = Duration::from_secs(10);
/// Time limit for a client to end a connection that was answered.
const LAST_PATIENCE: Duration = Duration::from_millis(500);

/// State that all connections share.
struct Server {
    door: Door,
    board: Arc<Board>,
    /// Connections whose requests are being read, oldest first.
    waiting: Mutex<VecDeque<Arc<TcpStream>>>,
    answered: AtomicUsize,
}

/// Answers for as long as the program runs.
pub fn serve(listener: &TcpListener, door: Door, board: Arc<Board>) {
    let server = Server { door, board, waiting: Mutex::default(), answered: AtomicUsize::new(0) };
    let server = Arc::new(server);
    for stream in listener.incoming() {
        // a client that left before it was seen is nobody's error; if there are too many files, some will be closed
        let Ok(stream) = stream else {
            thread::sleep(Duration::from_millis(50));
            continue;
        };
        let (stream, of_thread) = (Arc::new(stream), server.clone());
        server.enter(&stream);
        let of_stream = stream.clone();
        let thread = thread::Builder::new().name("afterimage-http".to_owned()).spawn(move || {
            // a client that does not wait for the answer does not want it
            let _ = of_thread.converse(&of_stream);
            of_thread.leave(&of_stream);
        });
        if thread.is_err() {
            server.leave(&stream);
        }
    }
}

impl Server {
    fn enter(&self, stream: &Arc<TcpStream>) {
        let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        if waiting.len() >= MOST_WAITING {
            // its thread finds that nothing more comes; an error is one of a connection that has ended
            waiting.pop_front().map(|oldest| oldest.shutdown(Shutdown::Both));
        }
        waiting.push_back(stream.clone());
    }

    fn leave(&self, stream: &Arc<TcpStream>) {
        let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        waiting.retain(|other| !Arc::ptr_eq(other, stream));
    }

    fn converse(&self, stream: &Arc<TcpStream>) -> io::Result<()> {
        let head = read_head(&mut Timed::new(stream, REQUEST_PATIENCE));
        self.leave(stream);
        let answer = match head {
            Ok(Some(head)) => self.answer(&head),
            Ok(None) => Answer::text("431 Request Header Fields Too Large", "a request has 16 KiB at most\n"),
            Err(error) if error.kind() == io::ErrorKind::TimedOut => {
                Answer::text("408 Request Timeout", "a request must be there within 5 seconds\n")
            }
            Err(error) => return Err(error),
        };
        answer.write(&mut Timed::new(stream, ANSWER_PATIENCE))?;
        // a connection that is closed while something is unread loses the answer
        stream.shutdown(Shutdown::Write)?;
        io::copy(&mut Timed::new(stream, LAST_PATIENCE).take(MOST_BYTES as u64), &mut io::sink())?;
        Ok(())
    }

    fn answer(&self, head: &[u8]) -> Answer {
        let others = self.answered.fetch_add(1, Ordering::Relaxed);
        let answer = if others < MOST_ANSWERED {
            answer(head, &self.door, &self.board)
        } else {
            Answer::text("503 Service Unavailable", "too many ask at once: ask again\n")
        };
        self.answered.fetch_sub(1, Ordering::Relaxed);
        answer
    }
}

/// Reads up to the empty line that ends a request's head; `None` if it is too long.
///
/// # Errors
/// It ends before, or takes too long.
fn read_head(stream: &mut impl Read) -> io::Result<Option<Vec<u8>>> {
    let (mut head, mut part) = (Vec::new(), [0; 4096]);
    while head.len() < MOST_BYTES {
        let length = stream.read(&mut part)?;
        if length == 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        // the end may have begun in the part before
        let known = head.len().saturating_sub(3);
        head.extend_from_slice(&part[..length]);
        let ends = |end: &[u8]| head[known..].windows(end.len()).any(|bytes| bytes == end);
        if ends(b"\r\n\r\n") || ends(b"\n\n") {
            return Ok(Some(head));
        }
    }
    Ok(None)
}

/// A connection on which everything must be done at a certain time, however small its steps are.
struct Timed<'a> {
    stream: &'a TcpStream,
    until: Instant,
}

impl<'a> Timed<'a> {
    fn new(stream: &'a TcpStream, patience: Duration) -> Self {
        Self { stream, until: Instant::now() + patience }
    }

    fn left(&self) -> io::Result<Option<Duration>> {
        let left = self.until.saturating_duration_since(Instant::now());
        if left.is_zero() { Err(io::ErrorKind::TimedOut.into()) } else { Ok(Some(left)) }
    }
}

/// The system says of a read or a write that took too long that it would block.
fn timed_out(error: io::Error) -> io::Error {
    if error.kind() == io::ErrorKind::WouldBlock { io::ErrorKind::TimedOut.into() } else { error }
}

impl Read for Timed<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.stream.set_read_timeout(self.left()?)?;
        self.stream.read(bytes).map_err(timed_out)
    }
}

impl Write for Timed<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.set_write_timeout(self.left()?)?;
        self.stream.write(bytes).map_err(timed_out)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reader that returns its bytes in parts of this length.
    struct Dripping<'a>(&'a [u8], usize);

    impl Read for Dripping<'_> {
        fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
            let (now, later) = self.0.split_at(self.1.min(self.0.len()).min(bytes.len()));
            bytes[..now.len()].copy_from_slice(now);
            self.0 = later;
            Ok(now.len())
        }
    }

    #[test]
    fn a_head_is_read_in_whatever_parts_it_comes() {
        for whole in ["GET / HTTP/1.1\r\nHost: a\r\n\r\n", "GET / HTTP/1.1\nHost: a\n\n"] {
            for part in [1, 2, 3, 100] {
                let head = read_head(&mut Dripping(whole.as_bytes(), part)).expect("it ends");
                assert_eq!(head.as_deref(), Some(whole.as_bytes()));
                let cut = &whole.as_bytes()[..whole.len() - 1];
                let error = read_head(&mut Dripping(cut, part)).expect_err("it does not");
                assert_eq!(error.kind(), io::ErrorKind::UnexpectedEof);
            }
        }
        let endless = vec![b'a'; 2 * MOST_BYTES];
        assert!(read_head(&mut Dripping(&endless, 1000)).expect("it comes").is_none());
    }
}
