//! Sweeps through the command line: interrupted, shared, refused, and read by others.

use crate::support::golden::{list, number};
use crate::support::peers::{read_sweep, sweep_rows};
use crate::support::program::{Scratch, assert_has, end_within, signal};
use crate::support::wire::{rest, until};
use std::fs;
use std::path::PathBuf;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Rows of one design in its own room and another one.
fn plan(samples: u64, options: &str) -> String {
    format!(
        r#"(
            version: 1,
            designs: ["pointer-on-head"],
            rooms: ["operating-table.env.ron", "room.env.ron"],
            vary: [LatinHypercube(count: {samples}, ranges: [
                (path: "tool.body.sensors[\"shaft\"].position.z", from: 40, to: 90),
                (path: "tool.body.sensors[\"grip\"].position.z", from: 90, to: 130),
                (path: "tool.body.sensors[\"housing\"].position.y", from: -5, to: 5),
            ])],
            motions: [Single],
            figures: ["position_rms", "angle_rms"],
            {options}
        )"#
    )
}

fn scratch(samples: u64, options: &str) -> Scratch {
    let scratch = Scratch::new();
    scratch.fit("room.env.ron", "--order 2 --no-support");
    scratch.write("plan.sweep.ron", plan(samples, options));
    scratch
}

fn merged(scratch: &Scratch, folder: &str) -> Vec<u8> {
    scratch.succeed(format!("sweep merge {folder} -o rows.parquet --overwrite"));
    fs::read(scratch.path("rows.parquet")).unwrap()
}

fn shards(scratch: &Scratch, folder: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(scratch.path(folder)).unwrap().map(|entry| entry.unwrap().path());
    entries.filter(|path| path.extension().is_some_and(|ending| ending == "parquet")).collect()
}

#[test]
fn a_sweeps_rows_are_what_simulate_prints() {
    let scratch = scratch(6, "room_field: true,");
    let report = scratch.json("sweep plan.sweep.ron -o out");
    assert_eq!((number(&report["computed"]), number(&report["rows"])), (12.0, 12.0));
    scratch.succeed_with("sweep status out", &["12 of 12"]);
    let rows = sweep_rows(&scratch.path("out"));
    for row in [&rows[0], &rows[7]] {
        let room = row["room"].as_str().unwrap();
        let z = |name: &str| number(&row[format!("tool.body.sensors[\"{name}\"].position.z")]);
        let y = number(&row["tool.body.sensors[\"housing\"].position.y"]);
        // The design as a person would write it.
        let root = env!("CARGO_MANIFEST_DIR");
        let body = fs::read_to_string(format!("{root}/assets/bodies/pointer.body.ron")).unwrap();
        let body = body
            .replace("position: (0.0, 0.0, 72.0)", &format!("position: (0.0, 0.0, {})", z("shaft")))
            .replace("position: (0.0, 0.0, 112.0)", &format!("position: (0.0, 0.0, {})", z("grip")))
            .replace("position: (0.0, 5.0, 148.0)", &format!("position: (0.0, {y}, 148.0)"));
        scratch.write("pointer.body.ron", body);
        scratch.copy_built_in(
            "pointer-on-head",
            "mine.design.ron",
            "../assets/bodies/pointer.body.ron",
            &scratch.arg("pointer.body.ron"),
        );
        if room == "room.env.ron" {
            let own = format!("{root}/assets/environments/operating-table.env.ron");
            scratch.replace("mine.design.ron", &own, &scratch.arg("room.env.ron"));
        }
        let found = scratch.json("simulate mine.design.ron --mode single");
        for (column, part) in [("position_rms", "position_mm"), ("angle_rms", "angle_deg")] {
            let figure = &found["figures"][part]["rms"];
            let own = &found["room_field"][part]["rms"];
            for (ending, expected) in [
                ("", &figure["value"]),
                ("_low", &figure["low"]),
                ("_high", &figure["high"]),
                ("_room_field", own),
            ] {
                // A room without its measurements has no intervals.
                assert!(expected.is_number() || room == "room.env.ron", "{column}{ending}");
                let cell = &row[format!("{column}{ending}")];
                let [cell, expected] = [cell, expected].map(|v| v.as_f64().map(f64::to_bits));
                assert_eq!(cell, expected, "{column}{ending} in {room}");
            }
        }
    }
}

#[test]
fn others_read_rows_with_types_and_units() {
    let scratch = scratch(5, "");
    scratch.succeed("sweep plan.sweep.ron -o out");
    scratch.succeed("sweep merge out -o rows.parquet");
    let read = |with: &str| read_sweep(&scratch.path("rows.parquet"), with);
    let pandas = read("pandas");
    assert_eq!(pandas["units"]["position_rms_low"], "mm");
    assert_eq!(pandas["units"]["angle_rms"], "deg");
    assert_eq!(pandas["types"]["row"], "uint64");
    assert_eq!(list(&pandas, "rows").len(), 10);
    for with in ["polars", "duckdb"] {
        let other = read(with);
        assert_eq!(other["rows"], pandas["rows"], "{with}");
        assert_eq!(other["units"], pandas["units"], "{with}");
    }
}

#[test]
fn plans_that_cannot_be_have_one_clear_error() {
    let scratch = scratch(5, "expected: false,");
    scratch.write("huge.sweep.ron", plan(500_000_000_000, ""));
    scratch.fail_with(
        "sweep huge.sweep.ron -o out",
        &["huge.sweep.ron", "rows is 1e12", "at most 1e9"],
    );
    assert!(!scratch.has("out"));
    scratch.fail_with("sweep no.sweep.ron -o out", &["no.sweep.ron"]);
    scratch.fail_with("sweep plan.sweep.ron -o room.env.ron", &["room.env.ron"]);
    scratch.refused("sweep plan.sweep.ron -o out --shard 4/3", &["4/3", "K from 1 to N"]);
    scratch.refused("sweep plan.sweep.ron", &["--output"]);
    scratch.fail_with("sweep merge . -o rows.parquet", &["found no sweep"]);
    scratch.succeed("sweep plan.sweep.ron -o out --shard 1/2");
    scratch.fail_with("sweep merge out -o rows.parquet", &["rows 5 to 9 are missing"]);
    scratch.write("other.sweep.ron", plan(5, "seed: 2,"));
    scratch.fail_with("sweep other.sweep.ron -o out", &["the rows of another plan"]);
    // A room that was fitted anew is another plan too.
    scratch.succeed(
        "fit own:room-a/room-a-fit.csv -o room.env.ron --order 1 --no-support --overwrite",
    );
    scratch.fail_with("sweep plan.sweep.ron -o out", &["the rows of another plan"]);
}

#[test]
fn unknown_numbers_are_warned_of_and_counted() {
    let scratch = Scratch::new();
    let text = plan(4, "").replace(r#"rooms: ["operating-table.env.ron", "room.env.ron"],"#, "");
    scratch.write("plan.sweep.ron", text.replace("housing", "handle"));
    let (report, notes) = scratch.json_and_notes("sweep plan.sweep.ron -o out");
    assert_has(
        &notes,
        &["warning: pointer-on-head", "no item named \"handle\"", "housing"],
        "the note",
    );
    assert_eq!((number(&report["computed"]), number(&report["problems"])), (4.0, 4.0));
    scratch.succeed_with(
        "sweep numbers pointer-on-head",
        &["tool.body.sensors[0].position.z", "crf.pose.position.x", "mm", "motion.rx.step"],
    );
}

#[test]
fn a_full_disk_is_reported_and_loses_nothing() {
    let scratch = scratch(30_000, "shard_seconds: 0.5,");
    let script = "mount -t tmpfs -o size=300k tmpfs out && exec \"$0\" sweep plan.sweep.ron -o out";
    fs::create_dir(scratch.path("out")).unwrap();
    // A small disk of the test's own.
    let output = std::process::Command::new("unshare")
        .args(["--map-root-user", "--mount", "sh", "-c"])
        .arg(format!("{script}; status=$?; ls -A out > list; exit $status").replace("exec ", ""))
        .arg(env!("CARGO_BIN_EXE_trackwright"))
        .current_dir(scratch.path("."))
        .output()
        .unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert_has(&message, &["No space left", "the shards that are written stay"], "the error");
    let files = scratch.read("list");
    assert!(!files.contains(".tmp"), "{files}");
}

#[test]
fn a_cancelled_sweep_ends_as_a_shell_expects() {
    let scratch = scratch(200_000, "expected: false,");
    let command = scratch.command("sweep plan.sweep.ron -o out");
    // What is begun in the background ignores some signals, and hands that on.
    let mut child = std::process::Command::new("env")
        .arg("--default-signal")
        .arg(command.get_program())
        .args(command.get_args())
        .current_dir(scratch.path("."))
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let is_begun = || {
        let files = fs::read_dir(scratch.path("out")).into_iter().flatten().flatten();
        files.into_iter().any(|file| file.file_name().to_string_lossy().starts_with(".part-"))
    };
    until("a shard is begun", is_begun);
    signal(&child, "-INT");
    end_within(&mut child, Duration::from_secs(120));
    let output = child.wait_with_output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(130), "{message}");
    assert_eq!(message, "cancelled: the rows that are computed are written\n");
}

#[test]
fn a_merge_replaces_its_own_table_alone() {
    let scratch = scratch(4, "expected: false,");
    scratch.succeed("sweep plan.sweep.ron -o out");
    for _ in 0..2 {
        scratch.succeed("sweep merge out -o rows.parquet");
        scratch.succeed("sweep merge out -o rows.parquet --overwrite");
    }
    let own = ["plan.sweep.ron", "rows-000000000000-000000000008.parquet", "locks/commit"];
    for file in own {
        let before = fs::read(scratch.path(&format!("out/{file}"))).unwrap();
        let line = format!("sweep merge out -o out/{file} --overwrite");
        scratch.fail_with(&line, &["is a file of the sweep itself"]);
        assert_eq!(fs::read(scratch.path(&format!("out/{file}"))).unwrap(), before);
    }
    // A bit of the table is another: the file is nobody's any more, and no reader takes it.
    let mut rows = fs::read(scratch.path("rows.parquet")).unwrap();
    let middle = rows.len() / 2;
    rows[middle] ^= 1;
    fs::write(scratch.path("rows.parquet"), rows).unwrap();
    scratch.fail_with("sweep merge out -o rows.parquet", &["--overwrite to replace it"]);
    scratch.fail_with("sweep plot rows.parquet -o pictures", &["rows.parquet: is damaged"]);
}

#[test]
fn a_merge_is_an_output_like_any_other() {
    let scratch = scratch(3, "");
    scratch.succeed("sweep plan.sweep.ron -o out");
    let expected = merged(&scratch, "out");
    // What the sweep reads stays, by any name and whatever is requested.
    std::os::unix::fs::symlink(scratch.path("room.env.ron"), scratch.path("link")).unwrap();
    let room = scratch.read("room.env.ron");
    for target in ["room.env.ron", "./room.env.ron", "link"] {
        for option in ["", "--overwrite"] {
            let error = scratch.fail(format!("sweep merge out -o {target} {option}"));
            assert_has(&error, &["found a file that is read here"], target);
        }
    }
    assert_eq!(scratch.read("room.env.ron"), room);
    // A pipe gets the rows and stays a pipe.
    let made = std::process::Command::new("mkfifo").arg(scratch.path("pipe")).status();
    assert!(made.unwrap().success());
    let pipe = scratch.path("pipe");
    let reader = std::thread::spawn(move || fs::read(pipe).unwrap());
    scratch.succeed("sweep merge out -o pipe");
    assert_eq!(reader.join().unwrap(), expected);
    assert!(!fs::metadata(scratch.path("pipe")).unwrap().is_file());
    // What a dead process left of a plan goes.
    scratch.write("out/.plan-x.tmp", "(vers");
    scratch.succeed("sweep merge out -o rows.parquet --overwrite");
    assert!(!scratch.has("out/.plan-x.tmp"));
    let shard = &shards(&scratch, "out")[0];
    let whole = fs::read(shard).unwrap();
    fs::write(shard, &whole[..whole.len() - 9]).unwrap();
    let error = scratch.fail("sweep merge out -o rows.parquet --overwrite");
    let name = shard.file_name().unwrap().to_string_lossy().into_owned();
    assert_has(&error, &[&name, "is damaged"], "merge");
}

#[test]
fn a_plot_does_not_replace_its_table() {
    let scratch = scratch(3, "");
    scratch.succeed("sweep plan.sweep.ron -o out");
    let expected = merged(&scratch, "out");
    fs::create_dir(scratch.path("plots")).unwrap();
    let link = scratch.path("plots/sweep.html");
    std::os::unix::fs::symlink(scratch.path("rows.parquet"), link).unwrap();
    scratch.fail_with("sweep plot rows.parquet -o plots", &["found a file that is read here"]);
    assert_eq!(fs::read(scratch.path("rows.parquet")).unwrap(), expected);
}

#[test]
fn a_plan_without_rows_may_change() {
    let scratch = scratch(3, "");
    scratch.succeed("sweep plan.sweep.ron -o out");
    let old = scratch.read("out/plan.sweep.ron");
    scratch.write("plan.sweep.ron", plan(4, ""));
    fs::remove_dir_all(scratch.path("out")).unwrap();
    fs::create_dir_all(scratch.path("out/locks")).unwrap();
    scratch.write("out/plan.sweep.ron", old);
    scratch.succeed("sweep plan.sweep.ron -o out");
    scratch.succeed_with("sweep status out", &["8 of 8"]);
    merged(&scratch, "out");
}

#[test]
fn a_cluster_that_is_not_there_or_refuses_is_reported() {
    let scratch = scratch(5, "expected: false,");
    fs::create_dir(scratch.path("bin")).unwrap();
    let submit = |tool: Option<&str>| {
        if let Some(text) = tool {
            scratch.write("bin/sbatch", text);
            let executable = std::os::unix::fs::PermissionsExt::from_mode(0o755);
            fs::set_permissions(scratch.path("bin/sbatch"), executable).unwrap();
        }
        let mut command = scratch.command("sweep plan.sweep.ron -o out --submit slurm --tasks 3");
        let output = command.env("PATH", scratch.path("bin")).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8(output.stderr).unwrap()
    };
    assert_has(&submit(None), &["sbatch cannot be started", "Slurm cluster"], "the error");
    let refusing = "#!/bin/sh\necho 'sbatch: error: invalid partition specified: x' >&2\nexit 1\n";
    let message = submit(Some(refusing));
    assert_has(
        &message,
        &["the cluster refuses the job", "invalid partition specified: x"],
        "the error",
    );
}

/// Rows of the largest test, in each of two rooms.
fn many() -> u64 {
    let rows = std::env::var("TRACKWRIGHT_SWEEP_DESIGNS");
    rows.map_or(20_000, |rows| rows.parse().unwrap())
}

#[test]
#[ignore = "long: 20,000 designs in two rooms, six times"]
fn long_sharding_and_kills_change_no_byte() {
    let scratch = scratch(many(), "shard_seconds: 0.5,");
    scratch.succeed("sweep plan.sweep.ron -o whole");
    let expected = merged(&scratch, "whole");
    for parts in [7, 64] {
        for part in 1..=parts {
            scratch.succeed(format!("sweep plan.sweep.ron -o in{parts} --shard {part}/{parts}"));
        }
        assert_eq!(merged(&scratch, &format!("in{parts}")), expected, "{parts} shards");
    }
    let mut one = scratch.command("sweep plan.sweep.ron -o one");
    assert!(one.env("RAYON_NUM_THREADS", "1").stdout(Stdio::null()).status().unwrap().success());
    assert_eq!(merged(&scratch, "one"), expected, "one thread");
    // Killed twenty times, at any moment of what a whole run takes.
    let mut kills = 0;
    for run in 0..20 {
        let before = shards(&scratch, "whole").len();
        let mut child = scratch
            .command("sweep plan.sweep.ron -o killed")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let started = Instant::now();
        rest(Duration::from_millis(300 + (run * 617) % 900));
        if child.try_wait().unwrap().is_none() {
            signal(&child, "-KILL");
            kills += 1;
        }
        child.wait().unwrap();
        // What had a name stays; at most one shard of half a second was under way.
        assert!(started.elapsed() < Duration::from_secs(30) && before > 0);
        for file in scratch
            .path("killed")
            .exists()
            .then(|| shards(&scratch, "killed"))
            .into_iter()
            .flatten()
        {
            assert!(fs::metadata(&file).unwrap().len() > 0);
        }
    }
    assert!(kills >= 5, "killed {kills} times");
    scratch.succeed("sweep plan.sweep.ron -o killed");
    assert_eq!(merged(&scratch, "killed"), expected, "killed {kills} times");
    let leftovers = fs::read_dir(scratch.path("killed")).unwrap();
    let names = leftovers.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned());
    assert_eq!(names.filter(|name| name.ends_with(".tmp")).count(), 0);
}
