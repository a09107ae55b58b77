//! Text of several lines, made safe to print: the last net under what a command or a page shows.
//!
//! Names are kept as their files have them, and a command that prints one need not think of what is
//! in it: all that goes to a terminal or into a page goes through here.

use super::printable::printable;
use std::borrow::Cow;
use std::fmt::Write;

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
