//! Names and texts that others wrote, made safe to show: characters that cannot be seen, or that
//! change what is seen around them, are escaped.
//!
//! Names are kept as their files have them. All that goes to a terminal or into a page goes through
//! here, so that a command that prints a name need not think of what is in it.

use std::borrow::Cow;

/// The text with control characters, bidirectional controls, zero-width characters and separators of
/// lines and paragraphs written as `\u{..}`. All else stays as it is.
///
/// ```
/// use trackwright_formats::printable::printable;
///
/// assert_eq!(printable("a\u{202e}b"), r"a\u{202e}b");
/// ```
pub fn printable(text: &str) -> Cow<'_, str> {
    escaped(text, is_hidden, |c| c.escape_unicode().to_string())
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
    let is_unsafe = |c: char| is_hidden(c) && !matches!(c, '\n' | '\t');
    escaped(text, is_unsafe, |c| c.escape_unicode().to_string())
}

/// JSON with such characters as JSON escapes them: a program reads the same strings as before.
pub fn printable_json(json: &str) -> Cow<'_, str> {
    let is_unsafe = |c: char| is_hidden(c) && c != '\n';
    // They can stand within strings only. None of them needs more than four digits.
    escaped(json, is_unsafe, |c| format!("\\u{:04x}", u32::from(c)))
}

/// The text with some of its characters written by `escape`.
fn escaped(
    text: &str,
    is_unsafe: impl Fn(char) -> bool,
    escape: impl Fn(char) -> String,
) -> Cow<'_, str> {
    if !text.contains(&is_unsafe) {
        return Cow::Borrowed(text);
    }
    let shown = text.chars().map(|c| if is_unsafe(c) { escape(c) } else { c.to_string() });
    Cow::Owned(shown.collect())
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
