//! The keys of RON documents and their pages.

use crate::arrows::{files, root};
use std::fs;

/// Crates whose types a document is read into.
const READ_INTO: [&str; 5] = ["formats", "field", "geometry", "metal", "design"];

/// Begins a type of a document: its fields are all keys, as it refuses any other.
const OF_A_DOCUMENT: &str = "deny_unknown_fields";

/// The keys of the first struct in a text that follows such an attribute.
fn keys(after: &str) -> Vec<String> {
    let Some(body) = after.split_once('{').filter(|(head, _)| head.contains("struct ")) else {
        return Vec::new();
    };
    let body = body.1.split_once("\n}").map_or("", |(body, _)| body);
    let (mut renamed, mut skipped) = (None, false);
    let mut keys = Vec::new();
    for line in body.lines().map(str::trim) {
        if let Some((_, name)) = line.split_once("rename = \"") {
            renamed = name.split('"').next().map(str::to_owned);
        }
        let is_skipped = std::mem::take(&mut skipped);
        skipped = line == "#[serde(skip)]" || (is_skipped && line.starts_with("//"));
        let Some((name, _)) = line.split_once(':').filter(|_| !line.starts_with(['/', '#'])) else {
            continue;
        };
        let name = name.rsplit([' ', '#']).next().unwrap_or(name);
        if !is_skipped {
            keys.push(renamed.take().unwrap_or_else(|| name.to_owned()));
        }
    }
    keys
}

/// Whether a page has a key in code: by itself, in a path of keys, or before its value.
fn has(page: &str, key: &str) -> bool {
    page.match_indices(key).any(|(at, _)| {
        let (before, after) = (&page[..at], &page[at + key.len()..]);
        before.ends_with(['`', ' ', '(', '.']) && after.starts_with(['`', ':', '.'])
    })
}

#[test]
fn each_key_of_a_document_is_on_a_page() {
    let pages = files(&root().join("docs/reference"), &[".md"]);
    let pages: Vec<_> = pages.iter().map(|page| fs::read_to_string(page).unwrap()).collect();
    let (mut found, mut missing) = (0, Vec::new());
    for file in READ_INTO.iter().flat_map(|name| files(&root().join("crates").join(name), &[".rs"]))
    {
        let text = fs::read_to_string(&file).unwrap();
        for after in text.split(OF_A_DOCUMENT).skip(1) {
            for key in keys(after) {
                found += 1;
                if !pages.iter().any(|page| has(page, &key)) {
                    let file = file.strip_prefix(root()).unwrap().display();
                    missing.push(format!("  {key} of {file}"));
                }
            }
        }
    }
    assert!(found > 150, "found {found} keys");
    assert!(missing.is_empty(), "no page of docs/reference has\n{}", missing.join("\n"));
}
