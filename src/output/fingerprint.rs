//! Short digests of everything a frame was made from. They stand in the frame's header, and in its preview,
//! so that a later run can tell whether the frame is the one that it would make.

use std::fmt;
use std::str::FromStr;

use crate::digest::Digest;

/// Key of the fingerprint in headers.
pub const KEY: &str = "fingerprint";

/// Key of the fingerprint that all frames of a run have in common: without the ancestry of each.
pub const RUN_KEY: &str = "runFingerprint";

/// Fingerprint of a frame, and of its run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MadeFrom {
    /// Fingerprint of the frame: its settings hold the frame's ancestry.
    pub frame: Fingerprint,
    /// Fingerprint of the run: tells whether frames belong together, without the shot.
    pub run: Fingerprint,
}

/// Digests of all that decides a frame's pixels. As text: `version 16-digits shot ... inputs ... settings ...`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fingerprint {
    /// Digest of the program's version, of the tracer's, and of the arithmetic of the machine.
    pub version: Digest,
    /// Digest of the shot file's statements, without those that count as settings.
    pub shot: Digest,
    /// Digest of the content of models, materials, textures and maps.
    pub inputs: Digest,
    /// Digest of the run's settings, as far as they change pixels.
    pub settings: Digest,
}

/// Kinds of things that may have changed, in the order of the text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "the fields of a fingerprint say it")]
pub enum Kind {
    Version,
    Shot,
    Inputs,
    Settings,
}

impl Kind {
    const ALL: [Self; 4] = [Self::Version, Self::Shot, Self::Inputs, Self::Settings];

    fn name(self) -> &'static str {
        match self {
            Self::Version => "version",
            Self::Shot => "shot",
            Self::Inputs => "inputs",
            Self::Settings => "settings",
        }
    }

    /// Words for the changed thing that an existing frame was made with.
    pub fn other(self) -> &'static str {
        match self {
            Self::Version => "another version of the program or of Embree, or another kind of processor",
            Self::Shot => "another shot file",
            Self::Inputs => "other models, materials, textures or maps",
            Self::Settings => "other settings",
        }
    }
}

impl Fingerprint {
    fn digests(&self) -> [Digest; 4] {
        [self.version, self.shot, self.inputs, self.settings]
    }

    /// Kinds in which it differs from `other`.
    pub fn changes(&self, other: &Self) -> Vec<Kind> {
        let pairs = self.digests().into_iter().zip(other.digests());
        Kind::ALL
            .into_iter()
            .zip(pairs)
            .filter(|(_, (own, other))| own != other)
            .map(|(kind, _)| kind)
            .collect()
    }
}

impl fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = Kind::ALL.into_iter().zip(self.digests());
        let words: Vec<String> = words.map(|(kind, digest)| format!("{} {digest}", kind.name())).collect();
        f.write_str(&words.join(" "))
    }
}

impl FromStr for Fingerprint {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        let words: Vec<&str> = text.split(' ').collect();
        let mut digests = [Digest::default(); 4];
        if words.len() != 2 * digests.len() {
            return Err(());
        }
        for ((digest, kind), pair) in digests.iter_mut().zip(Kind::ALL).zip(words.chunks(2)) {
            if pair[0] != kind.name() {
                return Err(());
            }
            *digest = pair[1].parse()?;
        }
        let [version, shot, inputs, settings] = digests;
        Ok(Self { version, shot, inputs, settings })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some() -> Fingerprint {
        let [version, shot, inputs, settings] = [&b"v"[..], b"s", b"i", b"o"].map(Digest::new);
        Fingerprint { version, shot, inputs, settings }
    }

    #[test]
    fn text_comes_back_and_nothing_else_is_taken() {
        let text = some().to_string();
        assert_eq!(text.parse(), Ok(some()));
        let changed =
            [text.replace("shot", "shut"), text[..text.len() - 1].to_owned(), format!("{text} more 1")];
        for bad in changed.iter().map(String::as_str).chain(["", "version"]) {
            assert_eq!(bad.parse::<Fingerprint>(), Err(()), "{bad}");
        }
    }

    #[test]
    fn what_changed_is_told_by_kind() {
        let other = Fingerprint { shot: Digest::new(b"x"), settings: Digest::new(b"y"), ..some() };
        assert_eq!(some().changes(&some()), []);
        assert_eq!(some().changes(&other), [Kind::Shot, Kind::Settings]);
    }
}
