//! A file that cannot be opened is reported in the words of the command line, and costs nothing.

use super::harness::Window;
use crate::copied::Copied;
use crate::support::program::{fail, text};
use std::path::Path;

fn open_with_keys(window: &mut Window, file: &Path) {
    window.key("ctrl+o");
    assert_eq!(window.last("dialog"), Some("open"));
    window.key("ctrl+a");
    window.write(&text(file));
    window.key("Return");
}

#[test]
fn a_broken_file_leaves_the_document() {
    let copy = Copied::new("pointer-on-head");
    let sound = std::fs::read_to_string(&copy.design).unwrap();
    let broken = |name: &str, bytes: &[u8]| {
        let file = copy.path(&format!("designs/{name}.design.ron"));
        std::fs::write(&file, bytes).unwrap();
        file
    };
    let files = [
        copy.path("designs/missing.design.ron"),
        broken("truncated", &sound.as_bytes()[..sound.len() / 2]),
        broken("binary", &[0, 159, 146, 150, 0, 255]),
        broken("version", sound.replace("version: 1", "version: 99").as_bytes()),
        broken("room", sound.replace("operating-table", "no-such-room").as_bytes()),
    ];
    let mut window = Window::open(&copy.design);
    let kept = |window: &Window| {
        let document = window.last("document").map(str::to_owned);
        (document, window.figures(), window.title())
    };
    let before = kept(&window);
    for file in files {
        open_with_keys(&mut window, &file);
        let error = fail(&["simulate", &text(&file), "--mode", "single"]);
        let error = error.trim_end().strip_prefix("error: ").unwrap();
        let shown = window.last("dialog").unwrap();
        assert_eq!(shown, format!("error The design cannot be opened: {error}"));
        assert_eq!(kept(&window), before);
        window.key("Return");
        assert_eq!(window.last("dialog"), Some("none"));
        assert_eq!(kept(&window), before);
    }
}
