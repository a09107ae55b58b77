//! The words, numbers and signs of a RON text, and where they stand: for what has to be known of a
//! file before, or whatever, its content is.

use std::ops::Range;

/// Largest number in any document, either way. What is larger is nothing that was measured or
/// computed, and its powers and products would be infinite.
pub(super) const MAX_NUMBER: f64 = 1e30;

/// What a piece of text is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Token {
    /// A name: of a field, a struct, a variant; also `inf` and `NaN`.
    Word,
    Number,
    /// Between quotes, with them.
    Quoted,
    Sign(char),
    /// Only with [`Tokens::with_comments`].
    Comment,
}

/// The tokens of a text. Any text has some, whether it is RON or not.
pub(super) struct Tokens<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Tokens<'a> {
    /// All but comments.
    pub(super) fn of(text: &'a str) -> impl Iterator<Item = (Token, Range<usize>)> + use<'a> {
        Self::with_comments(text).filter(|(token, _)| *token != Token::Comment)
    }

    /// All of them.
    pub(super) fn with_comments(text: &'a str) -> Self {
        Self { text, at: 0 }
    }
}

impl Iterator for Tokens<'_> {
    type Item = (Token, Range<usize>);

    fn next(&mut self) -> Option<Self::Item> {
        let rest = self.text[self.at..].trim_start();
        let first = rest.chars().next()?;
        let (token, length) = match first {
            '/' if rest.starts_with("//") => {
                (Token::Comment, rest.find('\n').unwrap_or(rest.len()))
            }
            '/' if rest.starts_with("/*") => (Token::Comment, block_comment(rest)),
            '"' => (Token::Quoted, quoted(rest, '"')),
            '\'' => (Token::Quoted, quoted(rest, '\'')),
            _ if is_number(rest) => (Token::Number, number(rest)),
            _ if is_of_word(first) => match raw_string(rest) {
                Some(length) => (Token::Quoted, length),
                None => (Token::Word, word(rest)),
            },
            sign => (Token::Sign(sign), sign.len_utf8()),
        };
        let start = self.text.len() - rest.len();
        self.at = start + length;
        Some((token, start..self.at))
    }
}

/// The version that a document states, before anything else is read of it: it need be no whole
/// document, nor one whose fields are known.
pub(super) fn stated_version(text: &str) -> Option<u64> {
    let mut depth = 0_usize;
    let mut last = [""; 2];
    for (token, range) in Tokens::of(text) {
        let token_text = &text[range];
        match token {
            Token::Sign('(' | '[' | '{') => depth += 1,
            Token::Sign(')' | ']' | '}') => depth = depth.saturating_sub(1),
            Token::Number if depth == 1 && last == ["version", ":"] => {
                return token_text.parse().ok();
            }
            _ => {}
        }
        last = [last[1], token_text];
    }
    None
}

/// Where a number stands that is larger than [`MAX_NUMBER`].
pub(super) fn too_large_number(text: &str) -> Option<Range<usize>> {
    let mut numbers = Tokens::of(text).filter(|(token, _)| *token == Token::Number);
    let is_too_large = |range: &Range<usize>| {
        let digits = text[range.clone()].replace('_', "");
        digits.parse().is_ok_and(|v: f64| v.abs() > MAX_NUMBER)
    };
    numbers.find_map(|(_, range)| is_too_large(&range).then_some(range))
}

/// Line and column of a place, in characters from 1.
pub(super) fn place(text: &str, at: usize) -> (usize, usize) {
    let before = &text[..at];
    let start = before.rfind('\n').map_or(0, |end| end + 1);
    let line = 1 + before.bytes().filter(|&b| b == b'\n').count();
    (line, 1 + before[start..].chars().count())
}

fn is_of_word(c: char) -> bool {
    c == '_' || c.is_alphanumeric()
}

fn word(text: &str) -> usize {
    text.find(|c| !is_of_word(c)).unwrap_or(text.len())
}

fn is_number(text: &str) -> bool {
    let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
    let digits = digits.strip_prefix('.').unwrap_or(digits);
    digits.starts_with(|c: char| c.is_ascii_digit())
}

/// A sign, digits, and what may stand among them; a second sign behind an `e` only.
fn number(text: &str) -> usize {
    let mut before = 'e';
    let end = text.find(|c: char| {
        let is_sign = matches!(c, '+' | '-') && matches!(before, 'e' | 'E');
        before = c;
        !(is_sign || c == '.' || is_of_word(c))
    });
    end.unwrap_or(text.len())
}

/// Up to the next quote that no backslash stands before.
fn quoted(text: &str, quote: char) -> usize {
    let mut is_escaped = false;
    let end = text.char_indices().skip(1).find(|(_, c)| {
        let is_end = *c == quote && !is_escaped;
        is_escaped = *c == '\\' && !is_escaped;
        is_end
    });
    end.map_or(text.len(), |(at, _)| at + 1)
}

/// `r"…"`, `r#"…"#`, `br"…"` and `b"…"`.
fn raw_string(text: &str) -> Option<usize> {
    let prefix = ["br", "r", "b"].into_iter().find(|p| text.starts_with(p))?;
    let rest = &text[prefix.len()..];
    if prefix == "b" {
        return rest.starts_with('"').then(|| 1 + quoted(rest, '"'));
    }
    let hashes = rest.len() - rest.trim_start_matches('#').len();
    let content = rest[hashes..].strip_prefix('"')?;
    let end = format!("\"{}", "#".repeat(hashes));
    let length = content.find(&end).map_or(content.len(), |at| at + end.len());
    Some(prefix.len() + hashes + 1 + length)
}

/// Block comments may be within each other.
fn block_comment(text: &str) -> usize {
    let mut depth = 0_usize;
    let mut at = 0;
    while at < text.len() {
        let rest = &text[at..];
        let step = if rest.starts_with("/*") {
            depth += 1;
            2
        } else if rest.starts_with("*/") {
            depth -= 1;
            2
        } else {
            rest.chars().next().map_or(1, char::len_utf8)
        };
        at += step;
        if depth == 0 {
            return at;
        }
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn tokens(text: &str) -> Vec<(Token, &str)> {
        let tokens = Tokens::of(text);
        tokens.map(|(token, range)| (token, &text[range])).collect()
    }

    #[test]
    fn tokens_are_distinguished() {
        use Token::{Number, Quoted, Sign, Word};
        let text = "Body(p95: -1.5e-3, // 1e308\n x: [.5, inf], n: \"a\\\"1e308\", r: r#\"\"1e308\"#, /* /* 1e308 */ */ c: '1')";
        let expected = [
            (Word, "Body"),
            (Sign('('), "("),
            (Word, "p95"),
            (Sign(':'), ":"),
            (Number, "-1.5e-3"),
            (Sign(','), ","),
            (Word, "x"),
            (Sign(':'), ":"),
            (Sign('['), "["),
            (Number, ".5"),
            (Sign(','), ","),
            (Word, "inf"),
            (Sign(']'), "]"),
            (Sign(','), ","),
            (Word, "n"),
            (Sign(':'), ":"),
            (Quoted, "\"a\\\"1e308\""),
            (Sign(','), ","),
            (Word, "r"),
            (Sign(':'), ":"),
            (Quoted, "r#\"\"1e308\"#"),
            (Sign(','), ","),
            (Word, "c"),
            (Sign(':'), ":"),
            (Quoted, "'1'"),
            (Sign(')'), ")"),
        ];
        assert_eq!(tokens(text), expected);
        assert_eq!(too_large_number(text), None);
    }

    #[test]
    fn a_number_that_is_too_large_is_found() {
        let found = |text: &str| too_large_number(text).map(|range| text[range].to_owned());
        assert_eq!(found("(a: 1e30, b: -1e30, c: 18446744073709551615)"), None);
        assert_eq!(found("(a: 1, b: -2e30)").as_deref(), Some("-2e30"));
        assert_eq!(found("(a: 1e999)").as_deref(), Some("1e999"));
        let digits = "1".repeat(40);
        assert_eq!(found(&format!("({digits})")), Some(digits));
    }

    #[test]
    fn a_version_is_found_in_what_is_no_document() {
        assert_eq!(stated_version("D(a: (version: 3), version: 9, b: (("), Some(9));
        assert_eq!(stated_version("(a: \"version: 9\", version: x)"), None);
        assert_eq!(stated_version("(version: 99999999999999999999)"), None);
    }

    proptest! {
        #[test]
        fn any_text_has_tokens_that_are_of_it(
            chars in prop::collection::vec(prop_oneof![
                prop::sample::select("()[]{}\"'\\/*#rb01.e+-_x:,\n ä".chars().collect::<Vec<_>>()),
                any::<char>(),
            ], 0..60),
        ) {
            let text = String::from_iter(chars);
            let mut end = 0;
            for (_, range) in Tokens::of(&text) {
                prop_assert!(range.start >= end && range.end > range.start);
                end = range.end;
                let _ = &text[range];
            }
            let _ = (stated_version(&text), too_large_number(&text));
        }
    }
}
