//! URIs in glTF files: data within them, or files beside them.

use std::path::{Component, Path};

/// Place of a URI's data.
#[derive(Debug, PartialEq)]
pub enum Uri {
    /// Bytes of a data URI.
    Data(Vec<u8>),
    /// Name of a file, relative to the folder of the glTF file, and within it.
    File(String),
}

impl Uri {
    /// Reads a URI. The error is the end of a sentence.
    pub fn read(text: &str) -> Result<Self, String> {
        if let Some(data) = text.strip_prefix("data:") {
            let (head, body) = data.split_once(',').ok_or("is a data URI without data")?;
            if !head.ends_with(";base64") {
                return Err(String::from("is a data URI that is not base64: embed it as base64"));
            }
            return base64(body).map(Self::Data).ok_or_else(|| String::from("is not base64"));
        }
        let decoded = percent_decoded(text);
        let shown = || text.chars().take(80).collect::<String>();
        let Some(name) = decoded else {
            return Err(format!("`{}` is not UTF-8: rename the file", shown()));
        };
        let is_remote = name.split_once(':').is_some_and(|(scheme, _)| {
            !scheme.is_empty()
                && scheme.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"+-.".contains(&byte))
        });
        if is_remote {
            return Err(format!("`{}` is no file beside it: fetch it, and name the file", shown()));
        }
        let slashed = name.replace('\\', "/");
        let stays = Path::new(&slashed)
            .components()
            .all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        if !stays || slashed.is_empty() {
            let message =
                "leads out of its folder: put all files into one folder, and name them without `..`";
            return Err(format!("`{}` {message}", shown()));
        }
        Ok(Self::File(slashed))
    }
}

/// Replaces `%20` and the like. `None` if the outcome is not UTF-8.
fn percent_decoded(text: &str) -> Option<String> {
    let bytes = text.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let digits = bytes.get(at + 1..at + 3).filter(|_| bytes[at] == b'%');
        let code = digits.and_then(|digits| std::str::from_utf8(digits).ok());
        match code.and_then(|code| u8::from_str_radix(code, 16).ok()) {
            Some(byte) => {
                decoded.push(byte);
                at += 3;
            }
            None => {
                decoded.push(bytes[at]);
                at += 1;
            }
        }
    }
    String::from_utf8(decoded).ok()
}

/// Decodes base64 (RFC 4648) with or without padding. `None` for anything else.
fn base64(text: &str) -> Option<Vec<u8>> {
    let digits = text.trim_end_matches('=').as_bytes();
    let mut bytes = Vec::with_capacity(digits.len() / 4 * 3 + 3);
    for four in digits.chunks(4) {
        let mut bits: u32 = 0;
        for digit in four {
            let value = match digit {
                b'A'..=b'Z' => digit - b'A',
                b'a'..=b'z' => digit - b'a' + 26,
                b'0'..=b'9' => digit - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                _ => return None,
            };
            bits = bits << 6 | u32::from(value);
        }
        if four.len() == 1 {
            return None;
        }
        bits <<= 6 * (4 - four.len());
        bytes.extend_from_slice(&bits.to_be_bytes()[1..four.len()]);
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_is_decoded() {
        for (text, bytes) in [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYmE", "fooba")]
        {
            let uri = format!("data:application/octet-stream;base64,{text}");
            assert_eq!(Uri::read(&uri), Ok(Uri::Data(bytes.into())), "{text}");
        }
        assert!(Uri::read("data:;base64,Zm9*").is_err() && Uri::read("data:;base64,Zm9vY").is_err());
        assert!(Uri::read("data:text/plain,abc").is_err() && Uri::read("data:").is_err());
    }

    #[test]
    fn files_stay_in_their_folder() {
        assert_eq!(Uri::read("maps/my%20wood.png"), Ok(Uri::File("maps/my wood.png".into())));
        assert_eq!(Uri::read("50%.bin"), Ok(Uri::File("50%.bin".into())));
        for text in
            ["../a.bin", "/etc/passwd", "a/%2e%2e/b", "..\\a", "", "C:/a.bin", "http://a/b", "file:///a"]
        {
            assert!(Uri::read(text).is_err(), "{text}");
        }
    }
}
