//! Answers, and their transmission.

use std::io::{self, Write};
use std::sync::Arc;

use super::board::ViewedPicture;

/// Headers of all answers. Nothing is kept, embedded, or handed on; and the page runs nothing but its own.
const HEADERS: &str = "Cache-Control: no-store\r\n\
    X-Content-Type-Options: nosniff\r\n\
    Cross-Origin-Resource-Policy: same-origin\r\n\
    Cross-Origin-Opener-Policy: same-origin\r\n\
    Referrer-Policy: no-referrer\r\n\
    X-Frame-Options: DENY\r\n\
    Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; \
    connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n\
    Connection: close\r\n";

/// An answer to a request.
#[derive(Debug, PartialEq, Eq)]
pub struct Answer {
    /// Code and reason.
    pub status: &'static str,
    kind: &'static str,
    /// One more header line, if any.
    header: String,
    body: Body,
}

/// Body of an answer.
#[derive(Debug, PartialEq, Eq)]
enum Body {
    Text(String),
    Picture(Arc<Vec<u8>>),
}

impl Answer {
    /// Creates an answer of one sentence for people.
    pub fn text(status: &'static str, text: impl Into<String>) -> Self {
        Self::of_kind("text/plain; charset=utf-8", status, text)
    }

    pub fn of_kind(kind: &'static str, status: &'static str, text: impl Into<String>) -> Self {
        Self { status, kind, header: String::new(), body: Body::Text(text.into()) }
    }

    /// Adds a header line.
    pub fn with_header(self, header: String) -> Self {
        Self { header, ..self }
    }

    /// Creates a redirection to `target`.
    pub fn moved(target: String) -> Self {
        let header = format!("Location: {target}\r\n");
        Self::text("308 Permanent Redirect", "").with_header(header)
    }

    pub fn picture(shown: ViewedPicture) -> Self {
        let header = format!("X-Seconds: {:.3}\r\n", shown.seconds);
        Self { status: "200 OK", kind: "image/png", header, body: Body::Picture(shown.png) }
    }

    /// Writes the whole answer as it is sent.
    pub fn write(&self, mut out: impl Write) -> io::Result<()> {
        let Self { status, kind, header, body } = self;
        let body = match body {
            Body::Text(text) => text.as_bytes(),
            Body::Picture(png) => png,
        };
        let length = body.len();
        let head = format!(
            "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n{HEADERS}{header}\r\n"
        );
        out.write_all(head.as_bytes())?;
        out.write_all(body)?;
        out.flush()
    }
}
