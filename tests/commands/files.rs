//! What commands write over: nothing that they read, and nothing that a person made or changed.

use crate::support::program::{Scratch, text};
use crate::support::table::POSE;
use crate::support::wire::rest;
use std::fs;
use std::path::Path;
use std::process::Stdio;

/// A command with `OUT` for what it writes, the files that it reads, and what the output's name ends in.
type Writer = (&'static str, &'static [&'static str], &'static str);

const DESIGN_FILES: &[&str] =
    &["d/pointer-on-head.design.ron", "d/room.env.ron", "d/tool.body.ron", "d/crf.body.ron"];

/// Every option that names an output, with all of its command's inputs.
const WRITERS: &[Writer] = &[
    (
        "fit room.csv --holdout holdout.csv --order 1 --directions 6 -o OUT",
        &["room.csv", "holdout.csv"],
        "a.env.ron",
    ),
    ("select room.csv --orders 1 --directions 1,6 --ridges 0 -o OUT", &["room.csv"], "a.env.ron"),
    ("select room.csv --orders 1 --directions 1,6 --ridges 0 --plot OUT", &["room.csv"], "a.svg"),
    ("generator learn room.csv --rows 150 --degree 1 -o OUT", &["room.csv"], "a.generator.ron"),
    ("distort d/room.env.ron poses.csv -o OUT", &["d/room.env.ron", "poses.csv"], "a.csv"),
    ("compensate d/room.env.ron poses.csv -o OUT", &["d/room.env.ron", "poses.csv"], "a.csv"),
    ("simulate d/pointer-on-head.design.ron --mode motion --log OUT", DESIGN_FILES, "a.csv"),
    (
        "simulate d/pointer-on-head.design.ron --mode input --input d/input.csv --log OUT",
        &["d/input.csv", "d/tool.body.ron"],
        "a.csv",
    ),
    ("compare d/pointer-on-head.design.ron d/other.design.ron --csv OUT", DESIGN_FILES, "a.csv"),
    ("tolerances d/pointer-on-head.design.ron --csv OUT", DESIGN_FILES, "a.csv"),
    ("report d/pointer-on-head.design.ron -o OUT", DESIGN_FILES, "a.html"),
    ("export field d/room.env.ron --spacing 100 -o OUT", &["d/room.env.ron"], "a.csv"),
    ("export field d/room.env.ron --spacing 100 -o OUT", &["d/room.env.ron"], "a.vti"),
    ("export field d/room.env.ron --spacing 100 -o OUT", &["d/room.env.ron"], "a.nrrd"),
    ("export poses poses.csv -o OUT", &["poses.csv"], "a.csv"),
    ("export poses poses.csv -o OUT", &["poses.csv"], "a.mrk.json"),
    ("export poses poses.csv --row 1 -o OUT", &["poses.csv"], "a.tfm"),
    ("export tips d/pointer-on-head.design.ron -o OUT", DESIGN_FILES, "a.csv"),
    ("export scene d/pointer-on-head.design.ron --layers none -o OUT", DESIGN_FILES, "a.glb"),
    ("register a.csv b.csv --at c.csv -o OUT", &["a.csv", "b.csv", "c.csv"], "a.csv"),
    ("register a.csv b.csv --transform OUT", &["a.csv", "b.csv"], "a.csv"),
    ("convert d/tool.body.ron OUT", &["d/tool.body.ron"], "a.body.ron"),
    ("pivot pivot.csv --tips poses.csv -o OUT", &["pivot.csv"], "a.csv"),
    (
        "verify d/pointer-on-head.design.ron recorded.csv --log OUT",
        &["recorded.csv", "d/room.env.ron"],
        "a.csv",
    ),
    (
        "verify d/pointer-on-head.design.ron recorded.csv --chart OUT",
        &["recorded.csv", "d/room.env.ron"],
        "a.svg",
    ),
    ("import jhu-cis calbody.txt calreadings.txt -o OUT", &["calbody.txt"], "a.csv"),
    ("characterize --em em.csv --reference reference.csv -o OUT", &["em.csv"], "a.csv"),
    (
        "characterize --em em.csv --reference reference.csv --hold-out 1/2 -o x.csv --held-out OUT",
        &["em.csv"],
        "a.csv",
    ),
];

/// Whether the files of [`folder`] are enough for a command to end well.
fn can_run(args: &str) -> bool {
    let unreadable = ["pivot", "verify", "import", "characterize"];
    !unreadable.iter().any(|name| args.starts_with(name))
}

/// A folder in which all writers find what they read.
fn folder() -> Scratch {
    let scratch = Scratch::new();
    scratch.copy_own("golden/pointer-on-head", "d");
    scratch.copy_own("room-a/room-a-fit.csv", "room.csv");
    scratch.copy_own("room-a/room-a-holdout.csv", "holdout.csv");
    scratch.copy("d/pointer-on-head.design.ron", "d/other.design.ron");
    let points = "x,y,z\n0,0,0\n100,0,0\n0,80,0\n0,0,60\n50,50,50\n";
    for name in ["a.csv", "b.csv", "c.csv"] {
        scratch.write(name, points);
    }
    let poses = format!("{POSE}\n0,0,-250,1,0,0,0\n10,0,-250,1,0,0,0\n0,10,-240,1,0,0,0\n");
    for name in ["poses.csv", "pivot.csv", "recorded.csv", "em.csv", "reference.csv"] {
        scratch.write(name, &poses);
    }
    for name in ["calbody.txt", "calreadings.txt"] {
        scratch.write(name, "1, 1, 1, x\n0, 0, 0\n");
    }
    scratch.fit("d/room.env.ron", "--order 1 --directions 6");
    scratch
}

/// What a command prints that ends with exit status 2.
#[track_caller]
fn refused(scratch: &Scratch, line: &str) -> String {
    let output = scratch.command(line).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{line}: {message}");
    message
}

#[test]
fn no_command_writes_over_its_input() {
    let scratch = folder();
    let mut tried = 0;
    for (args, inputs, _) in WRITERS {
        for input in *inputs {
            let file = scratch.path(input);
            let before = fs::read(&file).unwrap();
            let folder = Path::new(input).parent().unwrap();
            let [link, hard] = ["link", "hard"].map(|name| text(&folder.join(name)));
            #[cfg(unix)]
            std::os::unix::fs::symlink(&file, scratch.path(&link)).unwrap();
            fs::hard_link(&file, scratch.path(&hard)).unwrap();
            for name in [input, &*link, &*hard, &*format!("./{input}")] {
                let line = args.replace("OUT", name) + " --overwrite";
                let message = refused(&scratch, &line);
                // Names that determine the format are checked first.
                let is_other_format = ["expected a name", "expected one in", "cannot be written"]
                    .iter()
                    .any(|words| message.contains(words));
                let is_refused = message.contains("a file that is read here");
                assert!(is_refused || is_other_format, "{line}: {message}");
                assert_eq!(fs::read(&file).unwrap(), before, "{line}");
                tried += 1;
            }
            fs::remove_file(scratch.path(&link)).unwrap();
            fs::remove_file(scratch.path(&hard)).unwrap();
        }
    }
    assert!(tried > 4 * WRITERS.len(), "{tried}");
}

#[test]
fn what_a_person_made_or_changed_stays() {
    let scratch = folder();
    let design = fs::read(scratch.path("d/other.design.ron")).unwrap();
    for (args, _, ending) in WRITERS.iter().filter(|(args, ..)| can_run(args)) {
        let out = format!("out/{ending}");
        fs::create_dir_all(scratch.path("out")).unwrap();
        for content in [b"notes of mine\n".as_slice(), &design] {
            scratch.write(&out, content);
            let message = refused(&scratch, &args.replace("OUT", &out));
            assert!(message.contains("--overwrite"), "{args}: {message}");
            assert_eq!(fs::read(scratch.path(&out)).unwrap(), content);
        }
        for overwriting in [" --overwrite", ""] {
            scratch.succeed(args.replace("OUT", &out) + overwriting);
        }
        // One of its own that a person has changed since.
        let mut changed = fs::read(scratch.path(&out)).unwrap();
        changed.push(b'\n');
        scratch.write(&out, &changed);
        let message = refused(&scratch, &args.replace("OUT", &out));
        assert!(message.contains("somebody has changed since"), "{args}: {message}");
        assert_eq!(fs::read(scratch.path(&out)).unwrap(), changed);
        fs::remove_dir_all(scratch.path("out")).unwrap();
    }
}

#[test]
fn refused_outputs_start_no_long_work() {
    let scratch = folder();
    scratch.write("notes.ron", "notes of mine\n");
    for work in ["fit", "select", "generator learn"] {
        // A missing table is reported later.
        scratch.refused(format!("{work} none.csv -o notes.ron"), &["--overwrite"]);
    }
}

#[test]
fn an_impossible_folder_fails_before_the_work() {
    let scratch = Scratch::new();
    scratch.write("file", "");
    scratch.fail_with("precision -o file", &["cannot make the folder"]);
    scratch.fail_with("stability -o file/folder", &["file/folder"]);
}

#[test]
fn two_outputs_are_two_files() {
    let scratch = folder();
    let select = "select room.csv --orders 1 --directions 1 --ridges 0";
    scratch.refused(format!("{select} -o a.env.ron --plot a.env.ron"), &["expected two files"]);
}

/// A shell's file at the standard output has all that comes there.
#[test]
fn standard_output_is_written_on() {
    let scratch = folder();
    let line = "simulate d/pointer-on-head.design.ron --mode single --log /dev/stdout";
    let program = scratch.command(line);
    let (path, args) = (program.get_program(), program.get_args());
    let quoted: Vec<String> = std::iter::once(path)
        .chain(args)
        .map(|word| format!("'{}'", word.to_string_lossy()))
        .collect();
    let script = format!("echo before; {} ; echo after", quoted.join(" "));
    let mut shell = std::process::Command::new("sh");
    shell.current_dir(scratch.path("")).arg("-c").arg(format!("({script}) > all.txt"));
    for (name, value) in program.get_envs() {
        if let Some(value) = value {
            shell.env(name, value);
        }
    }
    assert!(shell.status().unwrap().success());
    let all = scratch.read("all.txt");
    let lines: Vec<&str> = all.lines().collect();
    assert_eq!((lines[0], lines[lines.len() - 1]), ("before", "after"));
    assert!(lines[1].starts_with("true_x,") && all.contains("\ntrials  "), "{all}");
}

#[test]
fn a_link_to_no_file_makes_that_file() {
    let scratch = folder();
    let link = |to: &str, name: &str| std::os::unix::fs::symlink(to, scratch.path(name)).unwrap();
    link("d/new.csv", "link");
    scratch.succeed("distort d/room.env.ron poses.csv -o link");
    assert!(fs::symlink_metadata(scratch.path("link")).unwrap().is_symlink());
    assert!(scratch.read("d/new.csv").starts_with(POSE));
    link("ring", "ring");
    scratch.fail_with("distort d/room.env.ron poses.csv -o ring", &["ring", "leads to itself"]);
}

#[test]
fn numbers_beyond_all_bounds_are_no_table() {
    let scratch = folder();
    let table = scratch.read("room.csv");
    let (head, rows) = table.split_once('\n').unwrap();
    let (_, rest) = rows.split_once(',').unwrap();
    scratch.write("far.csv", format!("{head}\n1e25,{rest}"));
    let fit = "fit far.csv --as-is --order 0 -o far.env.ron";
    scratch.refused(fit, &["far.csv", "ideal_x", "1e25", "up to 1e12"]);
    assert!(!scratch.has("far.env.ron"));
}

/// How often each writer is interrupted; more with `TRACKWRIGHT_RUNS`.
#[cfg(unix)]
fn runs() -> u32 {
    let runs = std::env::var("TRACKWRIGHT_RUNS");
    runs.map_or(2, |runs| runs.parse().unwrap())
}

#[cfg(unix)]
#[test]
#[ignore = "long: every writer is killed twice"]
fn long_interrupted_commands_leave_the_old_file() {
    let scratch = folder();
    let out_folder = scratch.path("out");
    fs::create_dir(&out_folder).unwrap();
    let leftovers = || {
        let entries = fs::read_dir(&out_folder).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name());
        let is_left = |name: &std::ffi::OsString| name.to_string_lossy().starts_with('.');
        names.filter(is_left).count()
    };
    let (mut interrupted, mut written) = (0, 0);
    for (index, (args, _, ending)) in WRITERS.iter().enumerate() {
        if !can_run(args) {
            continue;
        }
        let out = format!("out/{ending}");
        let args = args.replace("OUT", &out) + " --overwrite";
        let started = std::time::Instant::now();
        scratch.succeed(&args);
        let whole = (fs::read(scratch.path(&out)).unwrap(), started.elapsed());
        for run_number in 0..runs() {
            scratch.write(&out, "old");
            let mut child = (scratch.command(&args).stdout(Stdio::null()))
                .stderr(Stdio::null())
                .spawn()
                .unwrap();
            // Spread over the time that the command takes, and a little beyond.
            let part = f64::from((run_number * 37 + index as u32 * 61) % 101) / 90.0;
            rest(whole.1.mul_f64(part));
            let signal = ["KILL", "TERM", "INT"][run_number as usize % 3];
            let pid = child.id().to_string();
            let killed = std::process::Command::new("kill").args(["-s", signal, &pid]).output();
            interrupted += u32::from(killed.unwrap().status.success());
            child.wait().unwrap();
            let found = fs::read(scratch.path(&out)).unwrap();
            let is_new = found == whole.0;
            assert!(is_new || found == b"old", "{args} was torn by SIG{signal}");
            written += u32::from(is_new);
        }
        scratch.succeed(&args);
        assert_eq!(leftovers(), 0, "{args}");
        assert_eq!(fs::read(scratch.path(&out)).unwrap(), whole.0, "{args}");
    }
    assert!(interrupted > 0, "{written} had written");
}
