//! Text from files and names, made safe to show.

use std::borrow::Cow;

/// Escapes all characters of `text`, as `\u{1b}`, that a terminal or a browser would obey instead of showing:
/// control characters (C0, DEL, C1), but for line feeds, and those that change the direction of the text, so
/// that it does not read as it stands ("Trojan Source", CVE-2021-42574; the same that rustc warns of).
pub(crate) fn visible(text: &str) -> Cow<'_, str> {
    if !text.contains(is_obeyed) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        if is_obeyed(character) {
            shown.extend(character.escape_default());
        } else {
            shown.push(character);
        }
    }
    Cow::Owned(shown)
}

fn is_obeyed(character: char) -> bool {
    let turns_text = matches!(character, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns_text || (character.is_control() && character != '\n')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_be_obeyed_is_shown() {
        for (text, shown) in [
            ("\u{1b}]0;title\u{7}", r"\u{1b}]0;title\u{7}"),
            ("\u{9b}31m \u{7f}\0", r"\u{9b}31m \u{7f}\u{0}"),
            ("a\tb\rc", r"a\tb\rc"),
            ("a\u{202e}txt.jbo\u{2066}", r"a\u{202e}txt.jbo\u{2066}"),
        ] {
            assert_eq!(visible(text), shown);
        }
    }

    #[test]
    fn text_stays_as_it_is() {
        let text = "Ä city: 1×1 \\ 'q'\n  two lines, שלום \u{fffd}";
        assert!(matches!(visible(text), Cow::Borrowed(same) if same == text));
    }
}
