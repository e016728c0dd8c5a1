//! Words, numbers and signs of a text layer.

use std::borrow::Cow;

use super::fault::{Fault, Step};

/// Words before a property that edit a list.
pub const EDITS: [&str; 5] = ["add", "append", "delete", "prepend", "reorder"];

/// Kinds of tokens.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// A name, which may have colons in it.
    Word,
    Number,
    /// In quotes.
    Text,
    /// A file, between @.
    Asset,
    /// Between < and >.
    Path,
    Sign(char),
    /// The end of the layer.
    End,
}

/// A token.
#[derive(Debug, Clone, Copy)]
pub struct Token<'a> {
    pub what: What,
    /// As it is written.
    pub text: &'a str,
    /// White space and comments before it.
    pub gap: &'a str,
    /// Where it begins, in bytes.
    at: usize,
}

/// Tokens of a layer, one after the other.
pub struct Tokens<'a> {
    text: &'a str,
    at: usize,
    peeked: Option<Token<'a>>,
}

fn is_letter(letter: char) -> bool {
    letter.is_alphanumeric() || letter == '_' || letter == ':'
}

impl<'a> Tokens<'a> {
    pub fn new(text: &'a str) -> Self {
        Self { text, at: 0, peeked: None }
    }

    /// Takes the first line.
    ///
    /// # Errors If it is not that of a text layer.
    pub fn header(&mut self) -> Step {
        let line = self.text.lines().next().unwrap_or_default();
        if !line.starts_with("#usda 1.") {
            let message =
                String::from("its first line is not `#usda 1.0`: it is no text layer, or a newer one");
            return Err(Fault { line: Some(1), message });
        }
        self.at = line.len();
        Ok(())
    }

    pub fn peek(&mut self) -> Step<Token<'a>> {
        if let Some(token) = self.peeked {
            return Ok(token);
        }
        let token = self.read()?;
        self.peeked = Some(token);
        Ok(token)
    }

    /// Takes what is before the next token, so that it is there no more.
    pub fn take_gap(&mut self) -> Step<&'a str> {
        let token = self.peek()?;
        self.peeked = Some(Token { gap: "", ..token });
        Ok(token.gap)
    }

    pub fn next(&mut self) -> Step<Token<'a>> {
        let token = self.peek()?;
        self.peeked = None;
        Ok(token)
    }

    /// A fault at a token.
    pub fn fault(&self, token: &Token<'_>, message: String) -> Fault {
        self.fault_at(token.at, message)
    }

    /// A fault: something else is expected than this token.
    pub fn wrong(&self, token: &Token<'_>, expected: &str) -> Fault {
        let is: String = token.text.chars().take_while(|letter| *letter != '\n').take(40).collect();
        let is =
            if token.what == What::End { String::from("the file ends") } else { format!("`{is}` is there") };
        self.fault(token, format!("{is}, where {expected} is expected"))
    }

    fn fault_at(&self, at: usize, message: String) -> Fault {
        let line = 1 + self.text[..at].bytes().filter(|byte| *byte == b'\n').count();
        Fault { line: Some(line), message }
    }

    /// True if the word after the next one names what is ordered.
    pub fn is_order(&self) -> bool {
        let after = self.text[self.at..].trim_start();
        ["nameChildren", "properties", "rootPrims"].iter().any(|word| after.starts_with(word))
    }

    /// True if `=` follows after the next token.
    pub fn is_assigned(&self) -> bool {
        self.text[self.at..].trim_start().starts_with('=')
    }

    fn read(&mut self) -> Step<Token<'a>> {
        let begin = self.at;
        self.white()?;
        let (gap, at) = (&self.text[begin..self.at], self.at);
        let rest = &self.text[at..];
        let Some(first) = rest.chars().next() else {
            return Ok(Token { what: What::End, text: "", gap, at });
        };
        let second = rest.as_bytes().get(1).copied().unwrap_or_default();
        let (what, length) = match first {
            '"' | '\'' => (What::Text, self.quoted(first)?),
            '@' => (What::Asset, self.asset()?),
            '<' => (What::Path, self.until('>', rest)?),
            '0'..='9' => (What::Number, number(rest)),
            '.' if second.is_ascii_digit() => (What::Number, number(rest)),
            '-' | '+' if second.is_ascii_digit() || second == b'.' => (What::Number, 1 + number(&rest[1..])),
            '-' | '+' if rest[1..].starts_with("inf") || rest[1..].starts_with("nan") => (What::Number, 4),
            '=' | ',' | ';' | ':' | '.' | '&' | '(' | ')' | '[' | ']' | '{' | '}' => (What::Sign(first), 1),
            letter if is_letter(letter) => {
                (What::Word, rest.find(|letter| !is_letter(letter)).unwrap_or(rest.len()))
            }
            other => {
                let message = format!("`{}` has no meaning there", other.escape_default());
                return Err(self.fault_at(at, message));
            }
        };
        self.at = at + length;
        Ok(Token { what, text: &rest[..length], gap, at })
    }

    /// Goes past white space and comments.
    fn white(&mut self) -> Step {
        loop {
            let rest = &self.text[self.at..];
            let length = match rest.as_bytes() {
                [byte, ..] if byte.is_ascii_whitespace() => 1,
                [b'#', ..] | [b'/', b'/', ..] => rest.find('\n').unwrap_or(rest.len()),
                [b'/', b'*', ..] => match rest.find("*/") {
                    Some(end) => end + 2,
                    None => return Err(self.fault_at(self.at, String::from("a comment has no end"))),
                },
                _ => return Ok(()),
            };
            self.at += length;
        }
    }

    /// Length of a text in quotes: single ones, or three.
    fn quoted(&self, quote: char) -> Step<usize> {
        let bytes = &self.text.as_bytes()[self.at..];
        let mark = [quote as u8; 3];
        let ends: &[u8] = if bytes.starts_with(&mark) { &mark } else { &mark[..1] };
        let mut at = ends.len();
        while at < bytes.len() {
            match bytes[at] {
                b'\\' => at += 2,
                b'\n' if ends.len() == 1 => break,
                _ if bytes[at..].starts_with(ends) => return Ok(at + ends.len()),
                _ => at += 1,
            }
        }
        Err(self.fault_at(self.at, String::from("a text has no end in its line: close its quotes")))
    }

    fn asset(&self) -> Step<usize> {
        let rest = &self.text[self.at..];
        if !rest.starts_with("@@@") {
            return self.until('@', rest);
        }
        let mut at = 3;
        while let Some(end) = rest.get(at..).and_then(|rest| rest.find("@@@")).map(|end| at + end) {
            if !rest[..end].ends_with('\\') {
                // a name may end with @
                let more = rest[end + 3..].bytes().take(2).take_while(|byte| *byte == b'@').count();
                return Ok(end + 3 + more);
            }
            at = end + 3;
        }
        Err(self.fault_at(self.at, String::from("the name of a file has no end: close it with @@@")))
    }

    /// Length of something that ends with a sign, in its line.
    fn until(&self, end: char, rest: &str) -> Step<usize> {
        let line = &rest[1..];
        match line.find([end, '\n']) {
            Some(length) if line[length..].starts_with(end) => Ok(length + 2),
            _ => Err(self.fault_at(self.at, format!("there is no end in its line: close it with {end}"))),
        }
    }
}

/// Length of a number without its sign.
fn number(rest: &str) -> usize {
    let bytes = rest.as_bytes();
    let digits = |from: usize| bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let mut at = digits(0);
    if bytes.get(at) == Some(&b'.') {
        at += 1;
        at += digits(at);
    }
    if let Some(b'e' | b'E') = bytes.get(at) {
        let sign = usize::from(matches!(bytes.get(at + 1), Some(b'+' | b'-')));
        let exponent = digits((at + 1 + sign).min(bytes.len()));
        if exponent > 0 {
            at += 1 + sign + exponent;
        }
    }
    at
}

impl<'a> Token<'a> {
    /// The token as the library reads it.
    pub fn spelled(&self) -> Cow<'a, str> {
        match self.what {
            What::Number => spelled_number(self.text),
            What::Word if !self.text.is_ascii() => Cow::Owned(ascii(self.text)),
            What::Path if !self.text.is_ascii() => match self.text.rfind('.') {
                Some(dot) => Cow::Owned(format!("{}{}", &self.text[..dot], ascii(&self.text[dot..]))),
                None => Cow::Borrowed(self.text),
            },
            What::Asset if self.text.contains("\\@@@") => Cow::Owned(self.text.replace("\\@@@", "@@")),
            What::Text if self.text.contains('\\') => Cow::Owned(spelled_text(self.content())),
            _ => Cow::Borrowed(self.text),
        }
    }

    /// What is within quotes or @.
    pub fn content(&self) -> &'a str {
        let marks = match self.text.as_bytes() {
            [a, b, c, .., d, e, f] if a == b && b == c && d == e && e == f && a == f => 3,
            _ => 1,
        };
        &self.text[marks..self.text.len() - marks]
    }
}

/// A number with digits on both sides of its point.
fn spelled_number(text: &str) -> Cow<'_, str> {
    let (sign, rest) = match text.as_bytes()[0] {
        b'-' => ("-", &text[1..]),
        b'+' => ("", &text[1..]),
        _ => ("", text),
    };
    if rest.starts_with("inf") {
        return Cow::Owned(format!("{sign}1e999"));
    }
    if rest.starts_with("nan") {
        return Cow::Borrowed("nan");
    }
    let Some(point) = rest.find('.') else { return Cow::Borrowed(text) };
    let (whole, part) = (&rest[..point], &rest[point + 1..]);
    let is_short = !part.starts_with(|digit: char| digit.is_ascii_digit());
    if !whole.is_empty() && !is_short {
        return Cow::Borrowed(text);
    }
    let whole = if whole.is_empty() { "0" } else { whole };
    Cow::Owned(format!("{sign}{whole}.{}{part}", if is_short { "0" } else { "" }))
}

/// A text without escapes, in quotes within which the library knows none.
fn spelled_text(content: &str) -> String {
    let mut plain = String::with_capacity(content.len());
    let mut letters = content.chars();
    while let Some(letter) = letters.next() {
        if letter != '\\' {
            plain.push(letter);
            continue;
        }
        match letters.next() {
            // a line end would move the lines below
            Some('n' | 'r' | 't') => plain.push(' '),
            Some(other) => plain.push(other),
            None => {}
        }
    }
    match plain.contains("'''") || plain.ends_with('\'') {
        true => format!("\"\"\"{}\"\"\"", plain.replace('"', "'")),
        false => format!("'''{plain}'''"),
    }
}

/// A name in the letters that names have there.
fn ascii(name: &str) -> String {
    let mut plain = String::with_capacity(name.len());
    for letter in name.chars() {
        match letter.is_ascii() {
            true => plain.push(letter),
            false => plain.push_str(&format!("_u{:04x}_", u32::from(letter))),
        }
    }
    plain
}
