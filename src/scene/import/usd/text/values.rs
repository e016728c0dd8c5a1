//! Values of a text layer: numbers, texts and paths, lists and dictionaries of them.

use super::Writer;
use super::fault::Step;
use super::token::What;
use super::types::{Kind, Type};

/// Most brackets within each other in a value, and most dictionaries: the library calls itself for each.
const MOST_BRACKETS: usize = 32;

impl Writer<'_> {
    /// Takes a time and writes it, at the rate that is asked for.
    pub fn put_time(&mut self) -> Step {
        let token = self.peek()?;
        let time = token.spelled().parse::<f64>().ok().filter(|_| token.what == What::Number);
        let Some(time) = time else { return Err(self.tokens.wrong(&token, "a time")) };
        match self.to_rate {
            Some([own, rate]) => self.put_as(&format!("{:?}", time * rate / own)),
            None => self.put().map(|_| ()),
        }
    }

    /// Writes a value.
    pub fn value(&mut self, of: Type, depth: usize) -> Step {
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
        while !self.closes('}')? {
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
        Ok(())
    }

    /// Takes a value of any kind, and writes nothing.
    pub fn leave_out(&mut self) -> Step {
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
