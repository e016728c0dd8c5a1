//! Rewrites text layers (`.usda`) into spellings that the library reads, line by line.
//!
//! The library's grammar is narrower than that of the format: it knows no `.5`, no `//`, no arrays of unsigned numbers, and stops at metadata
//! that nobody here asks for. So a layer is read here first. What has another spelling gets it, what has no effect is left out, and each line
//! stays where it is, so that whatever is wrong has the number of its line.

mod fault;
mod metadata;
mod token;
mod types;
mod values;

pub use fault::Fault;
use fault::Step;
pub use metadata::{ACTIVE_AGAIN, INACTIVE, INACTIVE_AS_WELL};
use token::{EDITS, Token, Tokens, What};
use types::{Kind, OF_LAYERS, OF_PRIMS, OF_PROPERTIES, Type};

/// Most prims above one another, as for all files.
pub const MOST_LEVELS: usize = 256;

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

    /// Takes the sign that ends a list of statements, if it is next.
    fn closes(&mut self, end: char) -> Step<bool> {
        self.separators()?;
        let is_end = self.is_next(end)?;
        if is_end {
            self.put()?;
        }
        Ok(is_end)
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
        self.check_level(level, "prims")?;
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
        self.metadata_if_any(&OF_PRIMS)?;
        self.body(level)
    }

    fn check_level(&mut self, level: usize, what: &str) -> Step {
        if level <= MOST_LEVELS {
            return Ok(());
        }
        let token = self.peek()?;
        let message = format!("its {what} are nested more than {MOST_LEVELS} deep: flatten it");
        Err(self.tokens.fault(&token, message))
    }

    /// All between the braces of a prim or a variant.
    fn body(&mut self, level: usize) -> Step {
        self.expect('{', "the name of a prim")?;
        while !self.closes('}')? {
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
        Ok(())
    }

    fn variants(&mut self, level: usize) -> Step {
        self.check_level(level, "variants")?;
        self.put()?;
        self.expect_text("the name of a set of variants in quotes")?;
        self.expect('=', "a set of variants")?;
        self.expect('{', "a set of variants")?;
        while !self.closes('}')? {
            self.expect_text("the name of a variant in quotes")?;
            self.metadata_if_any(&OF_PRIMS)?;
            self.body(level + 1)?;
        }
        Ok(())
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
        self.metadata_if_any(&OF_PROPERTIES)?;
        if self.is_next('=')? {
            self.put()?;
            self.targets()?;
        }
        self.metadata_if_any(&OF_PROPERTIES)?;
        // what is where nothing is targeted, and an order of targets
        if suffix.is_some() || edit == Some("reorder") {
            self.blank(mark);
        }
        Ok(())
    }

    /// Paths that a relationship or a connection names.
    fn targets(&mut self) -> Step {
        if EDITS.contains(&self.peek()?.text) {
            self.put()?;
        }
        self.value(Type::plain(Kind::Path), 0)
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
        self.metadata_if_any(&OF_PROPERTIES)?;
        if self.is_next('=')? {
            self.put()?;
            match suffix {
                Some("connect") => self.targets()?,
                Some("timeSamples") => self.samples(of_values, is_array)?,
                Some("spline") => self.leave_out()?,
                // what ends what is inherited, which the library does not tell from nothing
                None if is_primvar && is_array && self.is_word("None")? => self.put_as("[]")?,
                _ => self.value(of_values, 0)?,
            }
        }
        let before = self.out.len();
        if self.metadata_if_any(&OF_PROPERTIES)? && suffix.is_some() {
            self.blank(before);
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
        while !self.closes('}')? {
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
        Ok(())
    }
}

#[cfg(test)]
mod tests;
