//! Metadata of a text layer, in parentheses: that which has an effect is kept.

use super::Writer;
use super::fault::Step;
use super::token::{EDITS, What};
use super::types::{Kind, OF_LAYERS, OF_PRIMS, Type};

/// Metadata of references and sublayers that is kept.
const OF_ARCS: [&str; 2] = ["offset", "scale"];

/// Copies of a point instancer that are not there: by all of their numbers, or by more of them, or fewer, than weaker layers have.
pub const INACTIVE: &str = "inactiveIds";
pub const INACTIVE_AS_WELL: &str = "inactiveIdsAsWell";
pub const ACTIVE_AGAIN: &str = "inactiveIdsNoMore";

impl Writer<'_> {
    /// Metadata, if they are next. Returns true if they were.
    pub fn metadata_if_any(&mut self, kept: &[&str]) -> Step<bool> {
        let is_there = self.is_next('(')?;
        if is_there {
            self.metadata(kept)?;
        }
        Ok(is_there)
    }

    /// All between the parentheses of a layer, prim or property: that of these names is kept.
    pub(super) fn metadata(&mut self, kept: &[&str]) -> Step {
        self.expect('(', "a name")?;
        if let Some([_, rate]) = self.to_rate.filter(|_| kept == OF_LAYERS) {
            self.out.push_str(&format!("timeCodesPerSecond = {rate} "));
        }
        while !self.closes(')')? {
            let mark = self.out.len();
            let token = self.peek()?;
            match token.what {
                // a comment
                What::Text => {
                    self.skip()?;
                    continue;
                }
                What::Word => {}
                _ => return Err(self.tokens.wrong(&token, "the name of metadata or `)`")),
            }
            let is_edit = EDITS.contains(&token.text) && !self.tokens.is_assigned();
            if is_edit {
                self.put()?;
            }
            let name = self.expect_word("the name of metadata")?.text;
            let is_of_copies = name == INACTIVE && kept == OF_PRIMS;
            if is_edit && is_of_copies {
                // the library reads no edits of what it does not know
                self.blank(mark);
                self.out.push_str(if token.text == "delete" { ACTIVE_AGAIN } else { INACTIVE_AS_WELL });
            }
            self.expect('=', "the name of metadata")?;
            let is_rate = matches!(name, "timeCodesPerSecond" | "framesPerSecond");
            if is_rate && kept == OF_LAYERS {
                let rate = self.peek()?.spelled().parse::<f64>().ok().filter(|rate| *rate > 0.0);
                let of = if name == "framesPerSecond" { &mut self.frames } else { &mut self.codes };
                *of = rate;
            }
            let is_replaced = is_rate && self.to_rate.is_some();
            if !is_replaced
                && (kept.contains(&name)
                    || name == "variants" && kept == OF_PRIMS
                    || is_of_copies && token.text != "reorder")
            {
                self.entry(name)?;
                self.out.push(' ');
            } else {
                self.leave_out()?;
                self.blank(mark);
            }
        }
        Ok(())
    }

    /// Value of metadata that is kept.
    fn entry(&mut self, name: &str) -> Step {
        match name {
            "active" | "instanceable" => self.value(Type::plain(Kind::Bool), 0),
            "subLayers" | "references" | "payload" => self.arcs(),
            "relocates" => self.relocates(),
            "inherits" | "specializes" => self.value(Type::plain(Kind::Path), 0),
            "offset" => self.put_time(),
            _ => self.value(Type::plain(Kind::Any), 0),
        }
    }

    /// Layers and prims that are brought in, one or a list.
    fn arcs(&mut self) -> Step {
        if self.is_word("None")? {
            self.put()?;
            return Ok(());
        }
        let is_list = self.is_next('[')?;
        if is_list {
            self.put()?;
        }
        loop {
            self.separators()?;
            if is_list && self.is_next(']')? {
                self.put()?;
                return Ok(());
            }
            let token = self.peek()?;
            if !matches!(token.what, What::Asset | What::Path) {
                return Err(self.tokens.wrong(&token, "a layer between @, or a path between < and >"));
            }
            self.put()?;
            let path = self.peek()?;
            if token.what == What::Asset && path.what == What::Path {
                if path.text == "<>" {
                    self.skip()?
                } else {
                    self.put()?
                };
            }
            self.metadata_if_any(&OF_ARCS)?;
            if !is_list {
                return Ok(());
            }
            self.out.push(' ');
        }
    }

    /// Paths that are moved: `{ <from>: <to>, ... }`.
    fn relocates(&mut self) -> Step {
        self.expect('{', "`relocates =`")?;
        while !self.closes('}')? {
            for after in [Some("a path"), None] {
                let token = self.peek()?;
                if token.what != What::Path {
                    return Err(self.tokens.wrong(&token, "a path between < and >"));
                }
                self.put()?;
                if let Some(after) = after {
                    self.expect(':', after)?;
                }
            }
            self.out.push(' ');
        }
        Ok(())
    }
}
