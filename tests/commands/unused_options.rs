//! Options that another option's choice would leave unused are refused, with what they belong to.

use crate::support::program::{Scratch, assert_has};

#[test]
fn a_table_of_poses_is_the_mode() {
    let scratch = Scratch::new();
    scratch.copy_design_with_room("golden/pointer-on-head", "--order 1 --directions 6");
    let (design, input) = ("d/pointer-on-head.design.ron", "d/input.csv");
    let stated = scratch.json(format!("simulate {design} --mode input --input {input}"));
    assert_eq!(scratch.json(format!("simulate {design} --input {input}")), stated);
    for args in [
        format!("simulate {design} --mode motion"),
        format!("simulate {design} --mode single"),
        format!("export tips {design} -o tips.csv --mode motion"),
        format!("report {design} -o tips.csv --mode single"),
    ] {
        scratch.refused(
            format!("{args} --input {input}"),
            &["input.csv: found another --mode, expected --mode input"],
        );
    }
    assert!(scratch.fail(format!("simulate {design}")).contains("--mode"));
}

#[test]
fn options_that_nothing_would_use_are_refused() {
    let scratch = Scratch::new();
    let (table, design) = ("own:room-a/room-a-fit.csv", "designs/endoscope.design.ron");
    let jitter = "--jitter-position-mm 0.1 --jitter-angle-deg 0.1";
    let fit = format!("fit {table} -o out.csv");
    for (args, word) in [
        (
            format!("simulate {design} --mode single {jitter} --uncertainty first-order --seed 1"),
            "--seed needs --uncertainty monte-carlo",
        ),
        (format!("{fit} --loss squares"), "--loss belongs to"),
        (
            format!("{fit} --model kriging --method joint"),
            "--method does not go with --model kriging",
        ),
        (format!("{fit} --model kriging --rcond 1e-8"), "--rcond does not go with --model kriging"),
        (format!("select {table} --models kriging --loss squares"), "no harmonic models"),
        (format!("select {table} --models kriging --orders 2"), "--orders belongs to Bernstein"),
        (format!("select {table} {jitter}"), "expected --output"),
        (format!("select {table} --volume aurora-cube"), "--output"),
        (format!("tolerances {design} --seed 1"), "--check"),
        (format!("pivot {table} --max-shaft-deg 1"), "--spin"),
        (format!("pivot --spin {table} --max-rms-mm 1"), "RECORDINGS"),
        (format!("export tips {design} -o out.csv --axes lps"), "is in the tracker's own axes"),
        (
            format!("export poses {table} --columns ideal -o out.csv --axes lps"),
            "is in the tracker's own axes",
        ),
    ] {
        scratch.refused(&args, &[word]);
    }
    assert!(!scratch.has("out.csv"));
}

#[test]
fn help_names_the_options_of_long_work() {
    let search = "--move --sensors --kind --metric --environment --rooms --generator-bounds --crf-bounds \
        --built-error --seconds --seed --format --overwrite";
    let words = |options: &'static str| options.split_whitespace().collect();
    let battery: Vec<&str> = vec!["--quick", "--output", "exit status 1"];
    for (command, words) in [("optimize", words(search)), ("stability", battery)] {
        // Lines are broken where the terminal ends.
        let help = Scratch::new().succeed(format!("{command} --help"));
        let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_has(&help, &words, command);
    }
}
