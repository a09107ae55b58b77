//! The structure of the source: which crate, layer and file uses which other.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Files of one circle, at most.
const LARGEST_CIRCLE: usize = 2;

/// The layers of the editor from the ground up; a file uses only its own layer and lower ones.
const EDITOR_LAYERS: &[&[&str]] = &[
    &["palette"],
    &["widgets"],
    &["convert", "schedule"],
    &["shell", "document", "runner"],
    &["viewport", "scene", "layers"],
    &["workspaces"],
    &["app", "lib"],
];

/// Calls of `init_resource` for ten types, at most: each plugin initialises its own.
const CALLS_FOR_TEN_TYPES: usize = 12;

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All files of a folder with an ending, in order, without build folders and data.
pub fn files(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap();
            if path.is_dir() {
                if !["target", "found", "corpus", "data"].contains(&name) && !name.starts_with('.')
                {
                    folders.push(path);
                }
            } else if endings.iter().any(|ending| name.ends_with(ending)) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Source without comments, text in quotes and modules of tests; lines stay where they are.
fn code(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(next) = rest.chars().next() {
        let skipped = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("r#\"") {
            rest.find("\"#").map_or(rest.len(), |end| end + 2)
        } else if next == '"' {
            quoted(rest)
        } else if rest.starts_with("'\"'") || rest.starts_with("'\\") {
            rest[2..].find('\'').map_or(rest.len(), |end| end + 3)
        } else {
            out.push(next);
            rest = &rest[next.len_utf8()..];
            continue;
        };
        out.extend(rest[..skipped].matches('\n'));
        rest = &rest[skipped..];
    }
    while let Some(start) = out.find("#[cfg(test)]") {
        let body = out[start..].find(['{', ';']).map_or(out.len(), |at| start + at);
        let end = if out[body..].starts_with('{') { body + braced(&out[body..]) } else { body };
        out.replace_range(start..end, "");
    }
    out
}

fn quoted(text: &str) -> usize {
    let mut is_escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if is_escaped => is_escaped = false,
            '\\' => is_escaped = true,
            '"' => return at + 1,
            _ => {}
        }
    }
    text.len()
}

fn braced(text: &str) -> usize {
    let mut depth = 0;
    for (at, c) in text.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 1 => return at + 1,
            '}' => depth -= 1,
            _ => {}
        }
    }
    text.len()
}

/// The modules of a crate: path of names to its code. `lib.rs` has the empty path.
fn modules(src: &Path) -> BTreeMap<Vec<String>, String> {
    let mut found = BTreeMap::new();
    for file in files(src, &[".rs"]) {
        let path = file.strip_prefix(src).unwrap().with_extension("");
        let mut names: Vec<String> =
            path.iter().map(|name| name.to_str().unwrap().to_owned()).collect();
        if names.last().is_some_and(|last| ["mod", "lib", "main"].contains(&last.as_str())) {
            names.pop();
        }
        if !names.iter().any(|name| name.contains("test")) {
            found.insert(names, code(&fs::read_to_string(&file).unwrap()));
        }
    }
    found
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The paths of all `use`s, their braces taken apart.
fn used(code: &str) -> BTreeSet<Vec<String>> {
    let mut found = BTreeSet::new();
    for (at, _) in code.match_indices("use ").filter(|(at, _)| !code[..*at].ends_with(is_name)) {
        let end = code[at..].find(';').map_or(code.len(), |end| at + end);
        spread(&[], &code[at + 4..end], &mut found);
    }
    found
}

/// The paths that code uses itself: those of a `pub use` are for others.
fn paths(code: &str) -> BTreeSet<Vec<String>> {
    let mut own = String::new();
    let mut rest = code;
    while let Some((start, end)) = passed_on(rest) {
        own.push_str(&rest[..start]);
        rest = &rest[end..];
    }
    own.push_str(rest);
    let mut found = used(&own);
    for start in ["crate::", "super::", "self::"] {
        for (at, _) in own.match_indices(start) {
            let end = own[at..].find(|c| !is_name(c) && c != ':').map_or(own.len(), |n| at + n);
            if !own[..at].ends_with(|c| is_name(c) || c == ':') && !own[..end].ends_with(':') {
                found.insert(own[at..end].split("::").map(str::to_owned).collect());
            }
        }
    }
    found
}

/// Where the first `pub use` or `pub(…) use` of code begins and ends.
fn passed_on(code: &str) -> Option<(usize, usize)> {
    code.match_indices("pub").find_map(|(start, _)| {
        let after = code[start + 3..].trim_start();
        let after =
            after.strip_prefix('(').map_or(after, |of| of.split_once(')').map_or("", |c| c.1));
        after.trim_start().starts_with("use ").then_some(())?;
        Some((start, start + code[start..].find(';')?))
    })
}

/// Adds the paths of a tree such as `a::{b, c::{d, e}}` below a path.
fn spread(above: &[String], tree: &str, found: &mut BTreeSet<Vec<String>>) {
    let tree = tree.trim();
    let (head, inside) = match tree.find('{') {
        Some(brace) => (&tree[..brace], Some(tree[brace + 1..].trim_end_matches('}'))),
        None => (tree.split(" as ").next().unwrap(), None),
    };
    let names = head.split("::").map(str::trim).filter(|name| !name.is_empty());
    let path: Vec<String> = above.iter().cloned().chain(names.map(str::to_owned)).collect();
    let Some(inside) = inside else {
        found.insert(path);
        return;
    };
    let (mut depth, mut from) = (0, 0);
    let inside = if inside.matches('{').count() > inside.matches('}').count() {
        format!("{inside}}}")
    } else {
        inside.to_owned()
    };
    for (at, c) in inside.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                spread(&path, &inside[from..at], found);
                from = at + 1;
            }
            _ => {}
        }
    }
    if !inside[from..].trim().is_empty() {
        spread(&path, &inside[from..], found);
    }
}

type Graph = BTreeMap<Vec<String>, BTreeSet<Vec<String>>>;

/// A crate's modules and what the `use`s of each make known in it.
struct Source {
    modules: BTreeMap<Vec<String>, String>,
    uses: BTreeMap<Vec<String>, BTreeSet<Vec<String>>>,
}

impl Source {
    fn read(src: &Path) -> Self {
        let modules = modules(src);
        let uses = modules.iter().map(|(at, code)| (at.clone(), used(code))).collect();
        Self { modules, uses }
    }

    /// The module in which what a path names is defined, seen from another: what a module only
    /// passes on is followed to where it comes from.
    fn home(&self, from: &[String], path: &[String], steps: usize) -> Option<Vec<String>> {
        let mut at = from.to_vec();
        let mut names = path.iter().peekable();
        let mut is_inside = true;
        match path[0].as_str() {
            "crate" => at.clear(),
            "self" => {}
            "super" => drop(at.pop()),
            _ => is_inside = false,
        }
        if is_inside {
            names.next();
        }
        while names.next_if(|name| *name == "super").is_some() {
            at.pop();
        }
        for name in names {
            let inner = [&at[..], std::slice::from_ref(name)].concat();
            if self.modules.contains_key(&inner) {
                (at, is_inside) = (inner, true);
                continue;
            }
            let passed_on = self.uses.get(&at)?.iter().find(|used| used.last() == Some(name));
            let further = passed_on.filter(|_| is_inside && steps > 0);
            return match further.map(|used| self.home(&at, used, steps - 1)) {
                Some(home) => home,
                None => is_inside.then_some(at),
            };
        }
        is_inside.then_some(at)
    }

    /// Which module names what of which other in its code.
    fn graph(&self) -> Graph {
        let arrows = |(from, code): (&Vec<String>, &String)| {
            let to = paths(code).into_iter().filter_map(|path| self.home(from, &path, 4));
            (from.clone(), to.filter(|to| to != from && self.modules.contains_key(to)).collect())
        };
        self.modules.iter().map(arrows).collect()
    }
}

fn graph(src: &Path) -> Graph {
    Source::read(src).graph()
}

fn reached<'a>(graph: &'a Graph, from: &'a Vec<String>) -> BTreeSet<&'a Vec<String>> {
    let mut found = BTreeSet::new();
    let mut open = vec![from];
    while let Some(at) = open.pop() {
        open.extend(graph[at].iter().filter(|to| found.insert(*to)));
    }
    found
}

/// The arrows of each set of modules that reach each other, where it is larger than allowed.
fn large_circles(graph: &Graph) -> Vec<String> {
    let reach: BTreeMap<_, _> = graph.keys().map(|from| (from, reached(graph, from))).collect();
    let circle = |at: &Vec<String>| -> BTreeSet<Vec<String>> {
        reach[at].iter().filter(|to| reach[**to].contains(at)).map(|to| (*to).clone()).collect()
    };
    let all: BTreeSet<_> = graph.keys().map(circle).collect();
    let arrows = |circle: BTreeSet<Vec<String>>| {
        let of = |from: &Vec<String>| {
            let to = graph[from].intersection(&circle).map(|to| to.join("/"));
            format!("  {} uses {}", from.join("/"), to.collect::<Vec<_>>().join(", "))
        };
        format!("{} files\n{}", circle.len(), circle.iter().map(of).collect::<Vec<_>>().join("\n"))
    };
    all.into_iter().filter(|circle| circle.len() > LARGEST_CIRCLE).map(arrows).collect()
}

fn crates() -> Vec<String> {
    let folders = fs::read_dir(root().join("crates")).unwrap();
    let mut names: Vec<_> =
        folders.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    // It has no code.
    names.retain(|name| name != "workspace-hack");
    names.sort();
    names
}

#[test]
fn files_of_a_crate_form_no_large_circles() {
    let mut wrong = Vec::new();
    let mut sources: Vec<_> =
        crates().into_iter().map(|name| (format!("crates/{name}/src"), name)).collect();
    sources.push(("src".to_owned(), "trackwright".to_owned()));
    sources.push(("python/src".to_owned(), "python".to_owned()));
    for (folder, name) in sources {
        let circles = large_circles(&graph(&root().join(folder)));
        if !circles.is_empty() {
            wrong.push(format!("{name}: {} circles, {}", circles.len(), circles.join("\n")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn crates_use_only_those_above_them() {
    let page = fs::read_to_string(root().join("docs/ARCHITECTURE.md")).unwrap();
    let order: Vec<&str> = page
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split_once("` |"))
        .map(|(name, _)| name)
        .collect();
    for name in crates() {
        let place = order.iter().position(|o| *o == name).expect("every crate is in ARCHITECTURE");
        let manifest = root().join("crates").join(&name).join("Cargo.toml");
        for line in fs::read_to_string(manifest).unwrap().lines() {
            let Some(used) = line.strip_prefix("trackwright-") else { continue };
            let used = used.split(['.', ' ', '=']).next().unwrap();
            assert!(order[..place].contains(&used), "{name} uses {used}");
        }
    }
}

#[test]
fn the_editor_uses_only_lower_layers() {
    let graph = graph(&root().join("crates/editor/src"));
    let layer = |path: &[String]| {
        let name = path.first().map_or("lib", String::as_str);
        EDITOR_LAYERS.iter().position(|layer| layer.contains(&name))
    };
    let mut wrong = Vec::new();
    for (from, to) in &graph {
        let Some(height) = layer(from) else {
            wrong.push(format!("{} is in no layer", from.join("/")));
            continue;
        };
        let higher = to.iter().filter(|to| layer(to).is_none_or(|other| other > height));
        wrong.extend(higher.map(|to| format!("{} uses {}", from.join("/"), to.join("/"))));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn each_plugin_initialises_its_own_resources() {
    let sources = modules(&root().join("crates/editor/src"));
    let mut calls: BTreeMap<&str, usize> = BTreeMap::new();
    for code in sources.values() {
        for (at, start) in code.match_indices("init_resource::<") {
            let name = code[at + start.len()..].split(">()").next().unwrap();
            *calls.entry(name.rsplit("::").next().unwrap()).or_default() += 1;
        }
    }
    let (all, types) = (calls.values().sum::<usize>(), calls.len());
    calls.retain(|_, count| *count > 1);
    assert!(all * 10 <= types * CALLS_FOR_TEN_TYPES, "{all} for {types}: {calls:?}");
}
