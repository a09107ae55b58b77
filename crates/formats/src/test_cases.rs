//! Tables of what a parser refuses: changes of a good text, and the error of each.

use proptest::prelude::*;
use std::ops::Range;

/// Makes each change in a good text and compares the parser's error with the table.
///
/// A case is `old => new | message`, or a whole text in the place of the change. The message may stand
/// in lines of its own that begin with `|`; `…` at its beginning or end stands for anything. `\n`, `\t`
/// and `\\` mean what they mean in Rust.
pub(crate) fn assert_refused(good: &str, cases: &str, refusal: impl Fn(&str) -> String) {
    let mut all: Vec<(&str, String)> = Vec::new();
    for line in cases.lines().map(str::trim).filter(|line| !line.is_empty()) {
        match (line.strip_prefix('|'), all.last_mut()) {
            (Some(more), Some((_, message))) => *message = format!("{message} {}", more.trim()),
            _ => {
                let (change, message) = line.split_once(" | ").unwrap_or((line, ""));
                all.push((change, message.to_owned()));
            }
        }
    }
    assert!(!all.is_empty());
    for (change, expected) in all {
        let text = match change.split_once("=>") {
            None => unescaped(change),
            Some((old, new)) => {
                let [old, new] = [old, new].map(|part| unescaped(part.trim()));
                assert!(good.contains(&old), "{old}");
                good.replacen(&old, &new, 1)
            }
        };
        let (found, expected) = (refusal(&text), expected.trim());
        let begins = expected.strip_suffix('…').unwrap_or(expected);
        let part = begins.strip_prefix('…').unwrap_or(begins);
        let is_it = match (expected.starts_with('…'), expected.ends_with('…')) {
            (false, false) => found == part,
            (false, true) => found.starts_with(part),
            (true, false) => found.ends_with(part),
            (true, true) => found.contains(part),
        };
        assert!(is_it, "{change}: {found:?}, expected {expected:?}");
    }
}

/// Text of any characters, so many of them.
pub(crate) fn any_text(length: Range<usize>) -> impl Strategy<Value = String> {
    prop::collection::vec(any::<char>(), length).prop_map(String::from_iter)
}

fn unescaped(text: &str) -> String {
    let parts = text.split("\\\\").map(|part| part.replace("\\n", "\n").replace("\\t", "\t"));
    parts.collect::<Vec<_>>().join("\\")
}
