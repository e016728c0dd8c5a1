//! The secret word in the address of the page.

use std::hint::black_box;
use std::{fmt, io};

/// Bytes of a token: too many to guess.
const BYTES: usize = 16;

/// A word of the address that differs in each run. Only readers of the program's output know it: other users
/// of the machine, and pages from elsewhere, do not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Token(String);

impl Token {
    /// A new one.
    ///
    /// # Errors
    /// The system gives no random numbers.
    pub fn random() -> io::Result<Self> {
        let mut bytes = [0; BYTES];
        getrandom::fill(&mut bytes)?;
        Ok(Self(bytes.iter().map(|byte| format!("{byte:02x}")).collect()))
    }

    /// Returns true if `word` is the token. It takes as long for every word of its length.
    pub fn is(&self, word: &str) -> bool {
        let differing = self.0.bytes().zip(word.bytes()).fold(0, |all, (a, b)| black_box(all | (a ^ b)));
        self.0.len() == word.len() && differing == 0
    }
}

impl fmt::Display for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_is_another_and_only_itself() {
        let [one, other] = [(); 2].map(|()| Token::random().expect("random numbers"));
        assert_ne!(one, other);
        let word = one.to_string();
        assert!(word.len() == 2 * BYTES && word.bytes().all(|byte| byte.is_ascii_hexdigit()), "{word}");
        assert!(one.is(&word) && !other.is(&word));
        for wrong in
            ["", &word[1..], &format!("{word}0"), &word.to_uppercase().replace(char::is_numeric, "x")]
        {
            assert!(!one.is(wrong), "{wrong}");
        }
    }
}
