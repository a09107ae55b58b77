//! The words of names, comments and pages, the names of tests, and the links between pages.

use crate::arrows::{files, root};
use std::fs;
use std::path::PathBuf;

/// Names and phrases for which a plainer one is used, each with that one.
const WORDS: &[(&str, &str)] = &[
    ("told_to", "with_progress"),
    ("take_in", "import_body"),
    ("mesh_shelf", "mesh_cache"),
    ("MeshShelf", "MeshCache"),
    ("stand_in", "placeholder"),
    ("StandIn", "Placeholder"),
    ("few_marks", "axis_ticks"),
    ("unreachable_squares", "residual_sum_of_squares"),
    ("fn look(", "simulate_pose"),
    ("fn stretch(", "subtask"),
    ("fn turns(", "solve_rotations"),
    ("fn shifts(", "solve_translations"),
    ("fn fold(", "qr_update"),
    ("fn beside(", "off_diagonal"),
    ("weighed:", "weights"),
    ("Desk", "State"),
    ("struct Hand ", "DragState"),
    ("struct Hand<", "Params"),
    ("Asked", "Requests"),
    ("struct Place ", "Position or Pose"),
    ("enum Place ", "Position or Pose"),
    ("Standing", "StepStatus"),
    ("Grounds", "DecisionBasis"),
    ("hangs on", "depends on"),
    ("hang on", "depend on"),
    ("led astray", "biased by"),
    ("leads astray", "biases"),
    ("be believed", "model validity"),
    ("what it is worth", "model validity"),
    ("hear", "receive"),
    ("heard", "received"),
    ("tells", "reports"),
    ("told", "reported"),
    ("says", "states or shows"),
    ("said", "reported"),
    ("say", "report"),
    ("asks", "requests"),
    ("asked", "requested"),
    ("ask", "request"),
    ("worth", "fit quality"),
    ("believed", "reported"),
    ("desk", "state"),
];

/// A value in files, which stays.
const FILE_VALUE: &str = "\"not_told\"";

/// A word or a phrase in a line, not as a part of a longer word.
fn has(line: &str, word: &str) -> bool {
    let is_letter = |c: char| c.is_ascii_lowercase();
    let inside = |at: usize| {
        let begins = word.starts_with(is_letter) && line[..at].ends_with(char::is_alphabetic);
        let ends = word.ends_with(is_letter) && line[at + word.len()..].starts_with(is_letter);
        begins || ends
    };
    line.match_indices(word).any(|(at, _)| !inside(at))
}

/// What people read and write: source, manifests and pages.
fn written(endings: &[&str]) -> Vec<PathBuf> {
    let folders = ["crates", "src", "python", "tests", "benches", "docs", "fuzz", "assets"];
    let mut found: Vec<_> =
        folders.iter().flat_map(|folder| files(&root().join(folder), endings)).collect();
    found.extend(["README.md", "Cargo.toml"].map(|name| root().join(name)));
    found.retain(|path| {
        !path.ends_with("tests/structure/words.rs") && !path.ends_with("rebuild.md")
    });
    found
}

#[test]
fn names_and_texts_use_plain_words() {
    let mut left: Vec<Vec<String>> = vec![Vec::new(); WORDS.len()];
    for path in written(&[".rs", ".md", ".toml"]) {
        let text = fs::read_to_string(&path).unwrap();
        let path = path.strip_prefix(root()).unwrap().display();
        for (number, line) in text.lines().enumerate() {
            for (left, (word, _)) in left.iter_mut().zip(WORDS) {
                if has(line, word) && !line.contains(FILE_VALUE) {
                    left.push(format!("  {path}:{} {}", number + 1, line.trim()));
                }
            }
        }
    }
    let mut wrong = Vec::new();
    for (left, (word, better)) in left.iter().zip(WORDS) {
        if !left.is_empty() {
            wrong.push(format!("{word:?}, rather {better}: {}\n{}", left.len(), left.join("\n")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The length of a test's name, at most.
const TEST_NAME: usize = 50;

#[test]
fn names_of_tests_are_short() {
    let mut longer = Vec::new();
    for path in written(&[".rs"]) {
        let text = fs::read_to_string(&path).unwrap();
        for after in text.split("#[test]").skip(1) {
            let name = after.split("fn ").nth(1).and_then(|after| after.split('(').next());
            longer.extend(name.filter(|name| name.len() > TEST_NAME).map(str::to_owned));
        }
    }
    assert!(longer.is_empty(), "{}:\n{}", longer.len(), longer.join("\n"));
}

/// The targets of `[text](target)` in a page.
fn links(page: &str) -> impl Iterator<Item = &str> {
    page.split("](").skip(1).filter_map(|after| after.split([')', ' ']).next())
}

#[test]
fn relative_links_lead_to_files() {
    let mut broken = Vec::new();
    for path in written(&[".md"]).iter().filter(|path| path.extension().unwrap() == "md") {
        let text = fs::read_to_string(path).unwrap();
        for link in links(&text).filter(|link| !link.contains("://") && !link.starts_with('#')) {
            let file = path.parent().unwrap().join(link.split('#').next().unwrap());
            if !file.exists() {
                broken.push(format!("{}: {link}", path.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// Documents of the project's makers, which the repository does not have.
const ELSEWHERE: &[&str] = &["FORMATS.md", "MATH.md", "MATH", "DOMAIN", "PHYSICS.md", "STYLE.md"];

#[test]
fn texts_name_documents_that_are_here() {
    let mut missing = Vec::new();
    for path in written(&[".rs", ".toml"]) {
        let text = fs::read_to_string(&path).unwrap();
        let is_path = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
        for (at, ending) in text.match_indices(".md") {
            let start = text[..at].rfind(|c| !is_path(c)).map_or(0, |before| before + 1);
            let name = &text[start..at + ending.len()];
            if name.contains('/') && !root().join(name).exists() {
                missing.push(format!("{}: {name}", path.display()));
            }
        }
        let elsewhere = ELSEWHERE.iter().filter(|name| text.contains(**name));
        missing.extend(elsewhere.map(|name| format!("{}: {name}", path.display())));
    }
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}
