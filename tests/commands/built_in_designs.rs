//! Built-in designs by their names, where a command takes a design.

use crate::support::program::Scratch;

#[test]
fn a_name_stands_for_the_built_in_design() {
    let scratch = Scratch::new();
    for (command, name) in [
        ("simulate --mode single", "pointer-on-head"),
        ("simulate --mode single --body crf", "pointer-on-head"),
        ("procedure", "endoscope"),
    ] {
        let of_name = scratch.succeed(format!("{command} {name}"));
        let of_file = scratch.succeed(format!("{command} designs/{name}.design.ron"));
        assert_eq!(of_name, of_file, "{command} {name}");
    }
}

#[test]
fn a_file_of_that_name_comes_first() {
    let scratch = Scratch::new();
    scratch.write("endoscope", "no design");
    scratch.refused("simulate --mode single endoscope", &["endoscope: line 1"]);
}
