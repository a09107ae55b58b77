//! Names and texts that others wrote, made safe to show: characters that cannot be seen, or that
//! change what is seen around them, are escaped.
//!
//! Names are kept as their files have them. All that goes to a terminal or into a page goes through
//! here, so that a command that prints a name need not think of what is in it.

use std::borrow::Cow;
use std::fmt::Write;

/// The text with control characters, bidirectional controls, zero-width characters and separators of
/// lines and paragraphs written as `\u{..}`. All else stays as it is.
///
/// ```
/// use trackwright_formats::printable::printable;
///
/// assert_eq!(printable("a\u{202e}b"), r"a\u{202e}b");
/// ```
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

/// As [`printable`], but line ends and tabs stay what they are.
pub fn printable_lines(text: &str) -> Cow<'_, str> {
    let is_kept = |c: char| matches!(c, '\n' | '\t');
    if text.split(is_kept).all(is_safe) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 8);
    for piece in text.split_inclusive(is_kept) {
        let content = piece.trim_end_matches(is_kept);
        shown.push_str(&printable(content));
        shown.push_str(&piece[content.len()..]);
    }
    Cow::Owned(shown)
}

/// JSON with such characters as JSON escapes them: a program reads the same strings as before.
pub fn printable_json(json: &str) -> Cow<'_, str> {
    if json.split('\n').all(is_safe) {
        return Cow::Borrowed(json);
    }
    let mut shown = String::with_capacity(json.len() + 8);
    for c in json.chars() {
        // They can stand within strings only. None of them needs more than four digits.
        match c == '\n' || is_safe(c.encode_utf8(&mut [0; 4])) {
            true => shown.push(c),
            // Writing to a string cannot fail.
            false => drop(write!(shown, "\\u{:04x}", u32::from(c))),
        }
    }
    Cow::Owned(shown)
}

fn is_safe(text: &str) -> bool {
    matches!(printable(text), Cow::Borrowed(_))
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

    const NAME: &str = "a\u{1b}[31m\u{202e}b\u{9b}\u{2028}c";

    #[test]
    fn lines_stay_and_what_is_in_them_is_escaped() {
        let text = format!("{NAME}\n\tx\r\n");
        let expected = "a\\u{1b}[31m\\u{202e}b\\u{9b}\\u{2028}c\n\tx\\u{d}\n";
        assert_eq!(printable_lines(&text), expected);
        let plain = "Länge\t1\n針\n\n";
        assert!(matches!(printable_lines(plain), Cow::Borrowed(_)));
        assert_eq!(printable_lines(plain), plain);
    }

    #[test]
    fn json_has_the_same_strings_as_before() {
        let value = serde_json::json!({"name": NAME, "list": [1, "\n\t"]});
        let json = serde_json::to_string_pretty(&value).unwrap();
        let shown = printable_json(&json);
        assert!(shown.contains("\\u202eb\\u009b\\u2028c"), "{shown}");
        assert_eq!(printable_lines(&shown), shown);
        let back: serde_json::Value = serde_json::from_str(&shown).unwrap();
        assert_eq!(back, value);
    }
}
