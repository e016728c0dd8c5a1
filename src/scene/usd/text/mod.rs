//! Rewrites text layers (`.usda`) into spellings that the library reads, line by line.
//!
//! The library's grammar is narrower than that of the format: it knows no `.5`, no `//`, no arrays of unsigned numbers, and stops at metadata
//! that nobody here asks for. So a layer is read here first. What has another spelling gets it, what has no effect is left out, and each line
//! stays where it is, so that whatever is wrong has the number of its line.

mod fault;
mod metadata;
mod token;
mod types;

pub use fault::Fault;
use fault::Step;
use token::{EDITS, Token, Tokens, What};
use types::{Kind, OF_LAYERS, OF_PRIMS, OF_PROPERTIES, Type};

/// Most prims above one another, as for all files.
pub const MOST_LEVELS: usize = 256;

/// Most brackets within each other in a value, and most dictionaries: the library calls itself for each.
const MOST_BRACKETS: usize = 32;

/// A layer as the library reads it.
pub struct Rewritten {
    pub text: String,
    /// True if splines were left out.
    pub has_splines: bool,
}

/// Time codes in a second where a layer says nothing.
const DEFAULT_RATE: f64 = 24.0;

/// Time codes in a second of a layer.
///
/// # Errors A line that is no USD.
pub fn rate(text: &str) -> Step<f64> {
    let mut writer = Writer::new(text);
    writer.tokens.header()?;
    if writer.is_next('(')? {
        writer.metadata(&OF_LAYERS)?;
    }
    Ok(writer.codes.or(writer.frames).unwrap_or(DEFAULT_RATE))
}

/// Rewrites a layer. `rate`: time codes in a second that its times are to have, if it has others. (The library converts times of layers
/// within a layer, and does so twice where these refer to their own prims.)
///
/// # Errors A line that is no USD.
pub fn rewrite(text: &str, rate: Option<f64>) -> Step<Rewritten> {
    let mut writer = Writer::new(text);
    // clips have times as well, and values may be times: these stay as they are
    let is_converted = !["clips", "timecode"].iter().any(|word| text.contains(word));
    if let Some(rate) = rate.filter(|_| is_converted) {
        let own = self::rate(text)?;
        writer.to_rate = (own != rate).then_some([own, rate]);
    }
    writer.layer()?;
    Ok(Rewritten { text: writer.out, has_splines: writer.has_splines })
}

/// Reads a layer and writes it.
struct Writer<'a> {
    tokens: Tokens<'a>,
    out: String,
    has_splines: bool,
    /// Time codes and frames in a second, as the layer says.
    codes: Option<f64>,
    frames: Option<f64>,
    /// Time codes in a second as it has them, and as it is to have them.
    to_rate: Option<[f64; 2]>,
}

impl<'a> Writer<'a> {
    fn new(text: &'a str) -> Self {
        let out = String::with_capacity(text.len() + 16);
        Self { tokens: Tokens::new(text), out, has_splines: false, codes: None, frames: None, to_rate: None }
    }

    // tokens

    fn peek(&mut self) -> Step<Token<'a>> {
        self.tokens.peek()
    }

    fn is_next(&mut self, sign: char) -> Step<bool> {
        Ok(self.peek()?.what == What::Sign(sign))
    }

    /// True if the next token is this word.
    fn is_word(&mut self, word: &str) -> Step<bool> {
        let token = self.peek()?;
        Ok(token.what == What::Word && token.text == word)
    }

    /// Takes the next token without writing it, but for its line ends.
    fn skip(&mut self) -> Step<Token<'a>> {
        let token = self.tokens.next()?;
        self.gap(&token);
        self.lines(token.text);
        Ok(token)
    }

    /// Takes the next token and writes it.
    fn put(&mut self) -> Step<Token<'a>> {
        let token = self.tokens.next()?;
        self.gap(&token);
        self.out.push_str(&token.spelled());
        Ok(token)
    }

    /// Takes the next token and writes something else for it, without line ends.
    fn put_as(&mut self, text: &str) -> Step {
        let token = self.tokens.next()?;
        self.gap(&token);
        self.out.push_str(text);
        self.lines(token.text);
        Ok(())
    }

    /// Writes what is before a token: a comment is left out.
    fn gap(&mut self, token: &Token<'a>) {
        if token.gap.bytes().all(|byte| byte.is_ascii_whitespace()) {
            self.out.push_str(token.gap);
        } else {
            // no space before the line's end: the first line has none
            self.lines(token.gap);
            self.out.push(' ');
        }
    }

    fn lines(&mut self, text: &str) {
        self.out.extend(text.bytes().filter(|byte| *byte == b'\n').map(char::from));
    }

    /// Leaves out what was written since `mark`, but for its line ends.
    fn blank(&mut self, mark: usize) {
        let ends = self.out[mark..].bytes().filter(|byte| *byte == b'\n').count();
        self.out.truncate(mark);
        self.out.push(' ');
        self.out.extend(std::iter::repeat_n('\n', ends));
    }

    /// Takes commas and semicolons, which the library does not need between statements.
    fn separators(&mut self) -> Step {
        while self.is_next(',')? || self.is_next(';')? {
            self.skip()?;
        }
        Ok(())
    }

    fn expect(&mut self, sign: char, after: &str) -> Step {
        if self.is_next(sign)? {
            self.put()?;
            return Ok(());
        }
        let token = self.peek()?;
        Err(self.tokens.wrong(&token, &format!("`{sign}` after {after}")))
    }

    fn expect_word(&mut self, what: &str) -> Step<Token<'a>> {
        let token = self.peek()?;
        match token.what {
            What::Word => self.put(),
            _ => Err(self.tokens.wrong(&token, what)),
        }
    }

    fn expect_text(&mut self, what: &str) -> Step {
        let token = self.peek()?;
        match token.what {
            What::Text => self.put().map(|_| ()),
            _ => Err(self.tokens.wrong(&token, what)),
        }
    }

    // prims

    fn layer(&mut self) -> Step {
        self.tokens.header()?;
        self.out.push_str("#usda 1.0");
        if self.is_next('(')? {
            self.metadata(&OF_LAYERS)?;
        } else if let Some([_, rate]) = self.to_rate {
            let gap = self.tokens.take_gap()?;
            self.out.push_str(gap);
            self.out.push_str(&format!("(timeCodesPerSecond = {rate}) "));
        }
        loop {
            self.separators()?;
            let token = self.peek()?;
            match (token.what, token.text) {
                (What::End, _) => {
                    self.gap(&token);
                    return Ok(());
                }
                (What::Word, "reorder") => self.order()?,
                _ => self.prim(1)?,
            }
        }
    }

    /// `reorder nameChildren = [...]`: an order of what is below.
    fn order(&mut self) -> Step {
        self.put()?;
        self.expect_word("what is ordered")?;
        self.expect('=', "what is ordered")?;
        self.value(Type::plain(Kind::Text), 0)
    }

    fn prim(&mut self, level: usize) -> Step {
        let token = self.peek()?;
        if level > MOST_LEVELS {
            let message = format!("its prims are nested more than {MOST_LEVELS} deep: flatten it");
            return Err(self.tokens.fault(&token, message));
        }
        if !matches!((token.what, token.text), (What::Word, "def" | "over" | "class")) {
            return Err(self.tokens.wrong(&token, "`def`, `over` or `class`"));
        }
        self.put()?;
        if self.peek()?.what == What::Word {
            self.put()?;
            // of a plug-in: nothing that is known here
            while self.is_next('.')? {
                self.skip()?;
                self.skip()?;
            }
        }
        self.expect_text("the name of a prim in quotes")?;
        if self.is_next('(')? {
            self.metadata(&OF_PRIMS)?;
        }
        self.body(level)
    }

    /// All between the braces of a prim or a variant.
    fn body(&mut self, level: usize) -> Step {
        self.expect('{', "the name of a prim")?;
        loop {
            self.separators()?;
            if self.is_next('}')? {
                self.put()?;
                return Ok(());
            }
            let token = self.peek()?;
            match (token.what, token.text) {
                (What::Word, "def" | "over" | "class") => self.prim(level + 1)?,
                (What::Word, "variantSet") => self.variants(level)?,
                (What::Word, "reorder") if self.tokens.is_order() => self.order()?,
                (What::Word, _) => self.property()?,
                (What::End, _) => return Err(self.tokens.wrong(&token, "`}`")),
                _ => return Err(self.tokens.wrong(&token, "a property, a prim or `}`")),
            }
        }
    }

    fn variants(&mut self, level: usize) -> Step {
        if level > MOST_LEVELS {
            let token = self.peek()?;
            let message = format!("its variants are nested more than {MOST_LEVELS} deep: flatten it");
            return Err(self.tokens.fault(&token, message));
        }
        self.put()?;
        self.expect_text("the name of a set of variants in quotes")?;
        self.expect('=', "a set of variants")?;
        self.expect('{', "a set of variants")?;
        loop {
            self.separators()?;
            if self.is_next('}')? {
                self.put()?;
                return Ok(());
            }
            self.expect_text("the name of a variant in quotes")?;
            if self.is_next('(')? {
                self.metadata(&OF_PRIMS)?;
            }
            self.body(level + 1)?;
        }
    }

    // properties

    fn property(&mut self) -> Step {
        let mark = self.out.len();
        let (mut edit, mut is_custom, mut is_uniform) = (None, false, false);
        loop {
            let token = self.peek()?;
            match (token.what, token.text) {
                (What::Word, word) if EDITS.contains(&word) => edit = Some(word),
                (What::Word, "custom") => is_custom = true,
                (What::Word, "uniform") => is_uniform = true,
                (What::Word, "varying" | "config") => {}
                _ => break,
            }
            self.skip()?;
        }
        for (word, is_there) in
            [(edit.unwrap_or_default(), edit.is_some()), ("custom", is_custom), ("uniform", is_uniform)]
        {
            // relationships are uniform by themselves
            if is_there && !(word == "uniform" && self.is_word("rel")?) {
                self.out.push(' ');
                self.out.push_str(word);
            }
        }
        self.out.push(' ');
        if self.is_word("rel")? {
            return self.relationship(mark, edit);
        }
        self.attribute(mark, edit)
    }

    fn relationship(&mut self, mark: usize, edit: Option<&str>) -> Step {
        self.put()?;
        self.expect_word("the name of a relationship")?;
        let suffix = self.suffix()?;
        if self.is_next('(')? {
            self.metadata(&OF_PROPERTIES)?;
        }
        if self.is_next('=')? {
            self.put()?;
            if EDITS.contains(&self.peek()?.text) {
                self.put()?;
            }
            self.value(Type::plain(Kind::Path), 0)?;
        }
        if self.is_next('(')? {
            self.metadata(&OF_PROPERTIES)?;
        }
        // what is where nothing is targeted, and an order of targets
        if suffix.is_some() || edit == Some("reorder") {
            self.blank(mark);
        }
        Ok(())
    }

    /// `.connect`, `.timeSamples` and the like after a name.
    fn suffix(&mut self) -> Step<Option<&'a str>> {
        if !self.is_next('.')? {
            return Ok(None);
        }
        self.put()?;
        Ok(Some(self.expect_word("`connect` or `timeSamples`")?.text))
    }

    fn attribute(&mut self, mark: usize, edit: Option<&str>) -> Step {
        let name = self.peek()?;
        if name.what != What::Word {
            return Err(self.tokens.wrong(&name, "the type of an attribute"));
        }
        self.skip()?;
        let of_type = self.out.len();
        let mut is_array = false;
        if self.is_next('[')? {
            self.skip()?;
            let token = self.peek()?;
            if token.what != What::Sign(']') {
                return Err(self.tokens.wrong(&token, "`]`"));
            }
            self.skip()?;
            is_array = true;
        }
        let mut of_values = Type { is_array, ..Type::named(name.text) };
        let is_primvar = self.expect_word("the name of an attribute")?.text.starts_with("primvars:");
        let suffix = self.suffix()?;
        let is_timed = suffix == Some("timeSamples");
        if is_timed && of_values.kind == Kind::Asset {
            // samples of one file are no values there: lists of one are
            of_values.is_array = true;
        }
        self.out.insert_str(of_type, &of_values.spelled(name.text));
        if self.is_next('(')? {
            self.metadata(&OF_PROPERTIES)?;
        }
        if self.is_next('=')? {
            self.put()?;
            match suffix {
                Some("connect") => {
                    if EDITS.contains(&self.peek()?.text) {
                        self.put()?;
                    }
                    self.value(Type::plain(Kind::Path), 0)?;
                }
                Some("timeSamples") => self.samples(of_values, is_array)?,
                Some("spline") => self.leave_out()?,
                // what ends what is inherited, which the library does not tell from nothing
                None if is_primvar && is_array && self.is_word("None")? => self.put_as("[]")?,
                _ => self.value(of_values, 0)?,
            }
        }
        let is_metadata = self.is_next('(')?;
        if is_metadata {
            let before = self.out.len();
            self.metadata(&OF_PROPERTIES)?;
            if suffix.is_some() {
                self.blank(before);
            }
        }
        let is_unknown = of_values.kind == Kind::Unknown && !matches!(suffix, Some("connect"));
        if edit == Some("reorder") || is_unknown || !matches!(suffix, None | Some("connect" | "timeSamples"))
        {
            self.has_splines |= suffix == Some("spline");
            self.blank(mark);
        }
        Ok(())
    }

    /// Values by their times. `is_array`: as the file says.
    fn samples(&mut self, of_values: Type, is_array: bool) -> Step {
        self.expect('{', "`timeSamples =`")?;
        loop {
            self.separators()?;
            if self.is_next('}')? {
                self.put()?;
                return Ok(());
            }
            let token = self.peek()?;
            if token.what != What::Number {
                return Err(self.tokens.wrong(&token, "a time"));
            }
            self.put_time()?;
            self.expect(':', "a time")?;
            let is_none = matches!(self.peek()?.text, "None" | "AnimationBlock");
            if of_values.is_array && !is_array && !is_none {
                self.out.push_str(" [");
                self.value(of_values, 0)?;
                self.out.push(']');
            } else {
                self.value(of_values, 0)?;
            }
            self.out.push(' ');
        }
    }

    // values

    /// Takes a time and writes it, at the rate that is asked for.
    fn put_time(&mut self) -> Step {
        let token = self.peek()?;
        let time = token.spelled().parse::<f64>().ok().filter(|_| token.what == What::Number);
        let Some(time) = time else { return Err(self.tokens.wrong(&token, "a time")) };
        match self.to_rate {
            Some([own, rate]) => self.put_as(&format!("{:?}", time * rate / own)),
            None => self.put().map(|_| ()),
        }
    }

    /// Writes a value.
    fn value(&mut self, of: Type, depth: usize) -> Step {
        let token = self.peek()?;
        if depth > MOST_BRACKETS {
            let message = format!("it has more than {MOST_BRACKETS} brackets within each other");
            return Err(self.tokens.fault(&token, message));
        }
        match (token.what, token.text) {
            (What::Sign('{'), _) => return self.dictionary(depth),
            (What::Sign(open @ ('(' | '[')), _) => {
                let close = if open == '(' { ')' } else { ']' };
                self.put()?;
                while !self.is_next(close)? {
                    if self.is_next(',')? || self.is_next(';')? {
                        self.put_as(",")?;
                        continue;
                    }
                    self.value(of, depth + 1)?;
                }
                self.put()?;
            }
            (What::Word, "None") => drop(self.put()?),
            (What::Word, "AnimationBlock") => self.put_as("None")?,
            (What::Sign(_) | What::End, _) => return Err(self.tokens.wrong(&token, "a value")),
            _ => match of.value(&token) {
                Some(text) if text == token.text => drop(self.put()?),
                Some(text) => self.put_as(&text)?,
                None => return Err(self.tokens.wrong(&token, of.expected())),
            },
        }
        Ok(())
    }

    fn dictionary(&mut self, depth: usize) -> Step {
        self.expect('{', "a name")?;
        loop {
            self.separators()?;
            if self.is_next('}')? {
                self.put()?;
                return Ok(());
            }
            let mark = self.out.len();
            let first = self.peek()?;
            let of = match first.what {
                What::Word => {
                    self.skip()?;
                    let of_type = self.out.len();
                    let is_array = self.is_next('[')?;
                    if is_array {
                        self.skip()?;
                        self.skip()?;
                    }
                    let of = Type { is_array, ..Type::named(first.text) };
                    self.out.insert_str(of_type, &of.spelled(first.text));
                    of
                }
                What::Text => Type::plain(Kind::Any),
                _ => return Err(self.tokens.wrong(&first, "a type or a name in quotes")),
            };
            let name = self.peek()?;
            if !matches!(name.what, What::Word | What::Text) {
                return Err(self.tokens.wrong(&name, "a name"));
            }
            self.put()?;
            self.expect('=', "a name")?;
            self.value(of, depth + 1)?;
            if of.kind == Kind::Unknown {
                self.blank(mark);
            }
            self.out.push(' ');
        }
    }

    /// Takes a value of any kind, and writes nothing.
    fn leave_out(&mut self) -> Step {
        let mut open = 0_usize;
        loop {
            let token = self.peek()?;
            match token.what {
                What::End => return Err(self.tokens.wrong(&token, "the end of a value")),
                What::Sign(')' | ';') if open == 0 => return Ok(()),
                What::Sign('(' | '[' | '{') => open += 1,
                What::Sign(')' | ']' | '}') => open = open.saturating_sub(1),
                _ => {}
            }
            self.skip()?;
            if open > 0 {
                continue;
            }
            // a layer may have a path behind it, and both may have an offset
            let is_layer = matches!(token.what, What::Asset | What::Path);
            let after = self.peek()?.what;
            if !(is_layer && (after == What::Path && token.what == What::Asset || after == What::Sign('('))) {
                return Ok(());
            }
        }
    }
}

#[cfg(test)]
mod tests;
