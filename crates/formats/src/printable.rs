//! Names and texts that others wrote, made safe to show: characters that cannot be seen, or that
//! change what is seen around them, are escaped.

use std::borrow::Cow;

/// The text with control characters, bidirectional controls, zero-width characters and separators of
/// lines and paragraphs written as `\u{..}`. All else stays as it is.
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.chars().any(is_hidden) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        if is_hidden(c) {
            shown.extend(c.escape_unicode());
        } else {
            shown.push(c);
        }
    }
    Cow::Owned(shown)
}

fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{061c}'
                | '\u{200b}'..='\u{200f}'
                | '\u{2028}'..='\u{202e}'
                | '\u{2066}'..='\u{2069}'
                | '\u{feff}'
        )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hidden_characters_are_escaped() {
        for (text, shown) in [
            ("a\u{202e}b", r"a\u{202e}b"),
            ("\u{1b}[31mred", r"\u{1b}[31mred"),
            ("a\nb\0", r"a\u{a}b\u{0}"),
            ("\u{9b}", r"\u{9b}"),
            ("\u{61c}\u{200e}\u{2069}", r"\u{61c}\u{200e}\u{2069}"),
            ("\u{200b}\u{feff}\u{2028}", r"\u{200b}\u{feff}\u{2028}"),
        ] {
            assert_eq!(printable(text), shown);
        }
    }

    #[test]
    fn other_text_is_not_changed() {
        for text in ["", "Stylus 3", "Nadel_ÄÖ", "針", "שלום", r"a\u{202e}"] {
            assert!(matches!(printable(text), Cow::Borrowed(same) if same == text));
        }
    }
}
