//! Whole sweeps: any sharding gives the same rows, whatever is torn or killed.

use super::shard::ShardWriter;
use super::{
    Cell, Coverage, Direction, Folder, MergeReport, Part, Row, RowFigures, Sweep, SweepError,
    SweepTable, is_merge_of, merge, run,
};
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use trackwright_formats::sweep_plan;
use trackwright_project::Files;
use trackwright_simulation::motion::{AxisRange, Motion};
use trackwright_simulation::{CancelToken, Metric, Mode};
use trackwright_task::Task;

const PLAN: &str = r#"(
    version: 1,
    designs: ["pointer-on-head"],
    vary: [
        LatinHypercube(count: 40, ranges: [
            (path: "tool.body.sensors[0].position.z", from: 40, to: 90),
            (path: "tool.body.sensors[1].position.z", from: 90, to: 130),
        ]),
        Grid([(path: "orientation_weight", values: List([50, 100]))]),
    ],
    motions: [Single, Range((x: (min: 0, max: 10, step: 5)))],
    figures: ["position_rms", "angle_rms"],
    expected: false,
)"#;

pub(super) fn sweep(text: &str) -> Sweep {
    Sweep::of_plan(sweep_plan::parse(text.as_bytes()).unwrap(), Path::new("/nowhere")).unwrap()
}

pub(super) fn compute(sweep: &Sweep, folder: &Folder, part: &str) -> super::RunReport {
    run(sweep, folder, part.parse().unwrap(), &Task::default(), &|_| ()).unwrap()
}

pub(super) fn opened(dir: &TempDir, name: &str, sweep: &Sweep) -> Folder {
    Folder::open(&dir.path().join(name), sweep).unwrap()
}

/// Over whatever is there.
pub(super) fn merge_to(
    sweep: &Sweep,
    folder: &Folder,
    file: &Path,
) -> Result<MergeReport, SweepError> {
    let files = Files::overwriting(true);
    merge(sweep, folder, &files.output(file)?, &Task::default())
}

fn merged(dir: &TempDir, sweep: &Sweep, folder: &Folder) -> Vec<u8> {
    let file = dir.path().join("merged.parquet");
    merge_to(sweep, folder, &file).unwrap();
    fs::read(file).unwrap()
}

fn shards(folder: &Folder) -> Vec<PathBuf> {
    folder.coverage().unwrap().shards.into_iter().map(|(_, file)| file).collect()
}

#[test]
fn any_sharding_merges_to_the_same_bytes() {
    let (dir, sweep) = (tempfile::tempdir().unwrap(), sweep(PLAN));
    assert_eq!(sweep.rows(), 160);
    let whole = opened(&dir, "whole", &sweep);
    assert_eq!(compute(&sweep, &whole, "1/1").computed, 160);
    let expected = merged(&dir, &sweep, &whole);
    for of in [7, 64] {
        let folder = opened(&dir, &of.to_string(), &sweep);
        // Any order.
        for number in (1..=of).rev() {
            compute(&sweep, &folder, &format!("{number}/{of}"));
        }
        assert_eq!(folder.coverage().unwrap().shards.len(), of as usize);
        assert_eq!(merged(&dir, &sweep, &folder), expected, "{of}");
    }
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let folder = opened(&dir, "thread", &sweep);
    one.install(|| compute(&sweep, &folder, "1/1"));
    assert_eq!(merged(&dir, &sweep, &folder), expected);
}

#[test]
fn a_row_has_the_figures_of_its_own_design() {
    let sweep = sweep(PLAN);
    for row in [0, 3, 77, 159] {
        let found = sweep.row(row, &CancelToken::default()).unwrap();
        let (design, room) = sweep.design(row).unwrap();
        assert_eq!(design.tool.body.rigid.sensors[0].position_in_body.z, found.numbers[0]);
        assert_eq!(design.orientation_weight_mm, Some(found.numbers[2]));
        assert_eq!((found.key.room, found.key.motion), (None, (row % 2) as usize));
        let mut scenario = trackwright_project::resolve(&design, &room);
        let range = AxisRange { min: 0.0, max: 10.0, step: 5.0 };
        scenario.motion = Some(Motion { x: Some(range), ..Motion::default() });
        let mode = if row % 2 == 0 { Mode::Single } else { Mode::Motion };
        let outcome = trackwright_simulation::run(&scenario, &mode, &CancelToken::default(), None);
        let figures = outcome.unwrap().room_field;
        let study = found.study.unwrap();
        let own = study.room_field.unwrap()[Metric::TIP_RMS.index()];
        assert_eq!(own.to_bits(), figures.position_mm.rms().to_bits());
        assert!(study.known.is_none());
        assert_eq!(study.trials, 1 + 2 * (row % 2));
    }
}

#[test]
fn rows_are_kept_and_torn_files_made_anew() {
    let (dir, sweep) = (tempfile::tempdir().unwrap(), sweep(PLAN));
    let folder = opened(&dir, "out", &sweep);
    for number in 1..=4 {
        compute(&sweep, &folder, &format!("{number}/4"));
    }
    let expected = merged(&dir, &sweep, &folder);
    let again = compute(&sweep, &folder, "1/1");
    assert_eq!((again.kept, again.computed), (160, 0));
    let files = shards(&folder);
    // Cut short at any place, emptied, removed, or with one bit that is another.
    let bytes = fs::read(&files[1]).unwrap();
    let lengths = [0, 1, 4, bytes.len() / 2, bytes.len() - 1];
    let cut = lengths.map(|length| bytes[..length].to_vec()).into_iter();
    let flipped = (0..bytes.len()).step_by(bytes.len() / 7).map(|at| {
        let mut bytes = bytes.clone();
        bytes[at] ^= 1 << (at % 8);
        bytes
    });
    for (case, damaged) in cut.chain(flipped).enumerate() {
        fs::write(&files[1], damaged).unwrap();
        let coverage = folder.coverage().unwrap();
        assert_eq!((coverage.torn.len(), coverage.rows()), (1, 120), "{case}");
        let report = compute(&sweep, &folder, "1/1");
        assert_eq!((report.torn, report.computed), (1, 40));
        assert_eq!(merged(&dir, &sweep, &folder), expected);
    }
    // The rows of another name.
    fs::copy(&files[0], &files[1]).unwrap();
    assert_eq!(compute(&sweep, &folder, "1/1").torn, 1);
    assert_eq!(merged(&dir, &sweep, &folder), expected);
    fs::remove_file(&files[3]).unwrap();
    let gap = merge_to(&sweep, &folder, &dir.path().join("no.parquet"));
    assert!(matches!(gap, Err(SweepError::Gap { from: 120, to: 160 })), "{gap:?}");
    assert!(!dir.path().join("no.parquet").exists());
    compute(&sweep, &folder, "4/4");
    assert_eq!(merged(&dir, &sweep, &folder), expected);
}

#[test]
fn another_plan_has_no_rows_here() {
    let (dir, sweep_a) = (tempfile::tempdir().unwrap(), sweep(PLAN));
    let folder = opened(&dir, "out", &sweep_a);
    compute(&sweep_a, &folder, "1/2");
    let other = sweep(&PLAN.replace("List([50, 100])", "List([50, 101])"));
    let refused = Folder::open(folder.path(), &other);
    assert!(matches!(refused, Err(SweepError::OtherPlan { .. })), "{refused:?}");
    // How long a shard takes is in no row.
    let slower = sweep(&PLAN.replace("motions", "shard_seconds: 5, motions"));
    assert_eq!(slower.hash(), sweep_a.hash());
    // A shard of another plan among those of this one.
    let elsewhere = opened(&dir, "other", &other);
    compute(&other, &elsewhere, "2/2");
    let stray = &shards(&elsewhere)[0];
    fs::copy(stray, folder.path().join(stray.file_name().unwrap())).unwrap();
    assert!(matches!(folder.coverage(), Err(SweepError::OtherPlan { .. })));
}

#[test]
fn a_part_is_computed_by_one_worker_at_a_time() {
    let (dir, sweep) = (tempfile::tempdir().unwrap(), sweep(PLAN));
    let folder = opened(&dir, "out", &sweep);
    let held = folder.hold(Part { number: 2, of: 4 }).unwrap();
    let refused = run(&sweep, &folder, "2/4".parse().unwrap(), &Task::default(), &|_| ());
    let message = refused.unwrap_err().to_string();
    assert_eq!(message, "part 2 of 4 of this sweep is being computed by another worker");
    compute(&sweep, &folder, "1/4");
    drop(held);
    compute(&sweep, &folder, "2/4");
    // Workers of other parts with some of the same rows at once: no row is there twice.
    std::thread::scope(|scope| {
        for part in ["1/1", "1/3", "2/3", "3/3", "4/4"] {
            let (sweep, folder) = (&sweep, &folder);
            scope.spawn(move || compute(sweep, folder, part));
        }
    });
    let Coverage { shards, .. } = folder.coverage().unwrap();
    let overlaps = shards.windows(2).any(|pair| pair[1].0.start < pair[0].0.end);
    assert!(!overlaps, "{shards:?}");
    compute(&sweep, &folder, "1/1");
    merged(&dir, &sweep, &folder);
}

#[test]
fn only_drafts_of_dead_workers_are_removed() {
    let (dir, sweep) = (tempfile::tempdir().unwrap(), sweep(PLAN));
    let folder = opened(&dir, "out", &sweep);
    let held = folder.hold(Part { number: 2, of: 4 }).unwrap();
    let names = [".part-2-of-4-a.tmp", ".part-3-of-8-b.tmp", ".part-1-of-1-c.tmp", ".part-x-d.tmp"];
    names.iter().for_each(|name| fs::write(folder.path().join(name), "").unwrap());
    let there = || names.map(|name| folder.path().join(name).exists());
    compute(&sweep, &folder, "1/1");
    assert_eq!(there(), [true, false, false, true]);
    drop(held);
    merged(&dir, &sweep, &folder);
    assert_eq!(there(), [false, false, false, true]);
}

#[test]
fn merged_rows_replace_no_file_of_a_sweep() {
    let (dir, sweep) = (tempfile::tempdir().unwrap(), sweep(PLAN));
    let folder = opened(&dir, "out", &sweep);
    compute(&sweep, &folder, "1/2");
    compute(&sweep, &folder, "2/2");
    fs::create_dir(folder.path().join("slurm")).unwrap();
    fs::write(folder.path().join("slurm/array.sh"), "x").unwrap();
    std::os::unix::fs::symlink(folder.path().join("locks"), dir.path().join("link")).unwrap();
    let own = folder.path();
    let mut targets = shards(&folder);
    targets.extend(
        ["plan.sweep.ron", "locks/commit", "locks/new", "slurm/array.sh"].map(|f| own.join(f)),
    );
    targets
        .extend(["link/commit", "out/../out/locks/x", "my.sweep.ron"].map(|f| dir.path().join(f)));
    for target in &targets {
        let before = fs::read(target).ok();
        let refused = merge_to(&sweep, &folder, target);
        assert!(matches!(refused, Err(SweepError::Own { .. })), "{target:?} {refused:?}");
        assert_eq!(fs::read(target).ok(), before);
    }
    // Beside the shards is where a cluster merges to.
    for target in [own.join("rows.parquet"), dir.path().join("rows.parquet")] {
        assert!(!is_merge_of(&sweep, &target));
        merge_to(&sweep, &folder, &target).unwrap();
        assert!(is_merge_of(&sweep, &target));
    }
    assert!(!is_merge_of(&sweep, &shards(&folder)[0]));
}

#[test]
fn rows_that_are_there_twice_are_refused() {
    let (dir, sweep) = (tempfile::tempdir().unwrap(), sweep(PLAN));
    let (halves, thirds) = (opened(&dir, "a", &sweep), opened(&dir, "b", &sweep));
    for part in ["1/2", "2/2"] {
        compute(&sweep, &halves, part);
    }
    compute(&sweep, &thirds, "2/3");
    let stray = &shards(&thirds)[0];
    fs::copy(stray, halves.path().join(stray.file_name().unwrap())).unwrap();
    let refused = merge_to(&sweep, &halves, &dir.path().join("no.parquet"));
    assert!(matches!(refused, Err(SweepError::Twice { row: 53, .. })), "{refused:?}");
}

#[test]
fn invalid_rows_state_why_and_others_go_on() {
    let text = r#"(
        version: 1,
        designs: ["pointer-on-head", "endoscope"],
        vary: [Grid([
            (path: "tool.body.sensors[2].position.y", values: List([5, 1e12])),
            (path: "motion.x.step", values: List([20, -1])),
        ])],
        motions: [Single],
        figures: ["position_rms"],
    )"#;
    let (dir, sweep) = (tempfile::tempdir().unwrap(), sweep(text));
    let folder = opened(&dir, "out", &sweep);
    let report = compute(&sweep, &folder, "1/1");
    assert_eq!(report.computed, 8);
    let table = SweepTable::open(folder.path()).unwrap();
    let problems = &table.texts(&["problem"], 0..8).unwrap()[0];
    assert_eq!(problems[0], "");
    assert_eq!(problems[1], "motion.x: step is -1, expected zero or more");
    assert!(problems[2].starts_with("tool.body: sensors[2]"), "{}", problems[2]);
    assert_eq!(problems.iter().filter(|text| !text.is_empty()).count() as u64, report.problems);
    // The endoscope has another number of sensors, or another motion.
    assert_eq!(sweep.problems().len(), usize::from(!problems[4].is_empty()));
    let figures = table.numbers("position_rms").unwrap();
    for (figure, problem) in figures.iter().zip(problems) {
        assert_eq!(figure.is_nan(), !problem.is_empty());
    }
}

#[test]
fn a_cancelled_worker_writes_what_it_has() {
    let (dir, sweep) = (tempfile::tempdir().unwrap(), sweep(PLAN));
    let folder = opened(&dir, "out", &sweep);
    let cancel = CancelToken::default();
    let stopping = cancel.clone();
    let mut task = Task::with_progress(move |part| {
        if part > 0.3 {
            stopping.cancel();
        }
    });
    task.cancel = cancel;
    let stopped = run(&sweep, &folder, Part::WHOLE, &task, &|_| ());
    assert!(matches!(stopped, Err(SweepError::Cancelled(_))), "{stopped:?}");
    let rows = folder.coverage().unwrap().rows();
    assert!((48..160).contains(&rows), "{rows}");
    let report = compute(&sweep, &folder, "1/1");
    assert_eq!((report.kept, report.computed), (rows, 160 - rows));
}

#[test]
fn columns_have_the_units_of_their_numbers() {
    let rooms = r#"rooms: ["operating-table.env.ron", "operating-theatre.env.ron"],
        motions: [Single], figures"#;
    let whole = PLAN.replace("motions: [Single, Range((x: (min: 0, max: 10, step: 5)))],", "");
    let in_both_rooms =
        whole.replace("figures", rooms).replace("expected: false", "room_field: true");
    let (dir, sweep) = (tempfile::tempdir().unwrap(), sweep(&in_both_rooms));
    let folder = opened(&dir, "out", &sweep);
    compute(&sweep, &folder, "1/16");
    let table = SweepTable::open(folder.path()).unwrap();
    let units: Vec<(String, String)> = table
        .columns()
        .into_iter()
        .filter(|column| !column.unit.is_empty())
        .map(|column| (column.name, column.unit))
        .collect();
    let expected = [
        ("tool.body.sensors[0].position.z", "mm"),
        ("tool.body.sensors[1].position.z", "mm"),
        ("orientation_weight", "mm"),
        ("position_rms", "mm"),
        ("position_rms_low", "mm"),
        ("position_rms_high", "mm"),
        ("position_rms_room_field", "mm"),
        ("angle_rms", "deg"),
        ("angle_rms_low", "deg"),
        ("angle_rms_high", "deg"),
        ("angle_rms_room_field", "deg"),
    ];
    assert_eq!(units, expected.map(|(name, unit)| (name.to_owned(), unit.to_owned())));
    // What a name does not tell of itself is stated: of all but what the rows are of and the figures.
    let own = ["row", "design", "room", "motion", "problem", "position_rms", "angle_rms"];
    let own: Vec<String> = own.map(str::to_owned).into();
    let named = [own, table.parameters()].concat();
    for column in table.columns() {
        assert_eq!(column.about.is_empty(), named.contains(&column.name), "{}", column.name);
    }
    let read = |name| table.numbers(name).unwrap();
    let [value, low, high] = ["position_rms", "position_rms_low", "position_rms_high"].map(read);
    // The room that was measured has intervals, and the computed one has.
    for k in 0..value.len() {
        assert!(low[k] < value[k] && value[k] < high[k], "{k}");
    }
    let bases = table.texts(&["basis"], 0..2).unwrap();
    assert_eq!(bases[0], ["measured", "simulated"]);
}

#[test]
fn rows_are_read_in_any_pieces() {
    let (dir, sweep) = (tempfile::tempdir().unwrap(), sweep(PLAN));
    let folder = opened(&dir, "out", &sweep);
    for number in 1..=5 {
        compute(&sweep, &folder, &format!("{number}/5"));
    }
    let table = SweepTable::open(folder.path()).unwrap();
    let all = table.texts(&["row", "room", "position_rms_room_field"], 0..160).unwrap();
    assert_eq!(all[0], (0..160).map(|row| row.to_string()).collect::<Vec<_>>());
    for rows in [0..1, 30..34, 31..130, 159..160, 160..160] {
        let some = table.texts(&["row", "room", "position_rms_room_field"], rows.clone()).unwrap();
        let range = rows.start as usize..rows.end as usize;
        for (some, all) in some.iter().zip(&all) {
            assert_eq!(some, &all[range.clone()]);
        }
    }
    let unknown = table.numbers("tip").unwrap_err().to_string();
    assert!(unknown.contains("found no column tip, expected one of row, design"), "{unknown}");
    assert!(matches!(SweepTable::open(dir.path()), Err(SweepError::NoSweep { .. })));
}

#[test]
fn cells_are_those_of_the_wanted_rows() {
    let (dir, sweep) = (tempfile::tempdir().unwrap(), sweep(PLAN));
    let folder = opened(&dir, "out", &sweep);
    for number in 1..=5 {
        compute(&sweep, &folder, &format!("{number}/5"));
    }
    // The plan's file in the folder stands for it.
    let table = SweepTable::open(&Folder::plan_of(folder.path())).unwrap();
    let cancel = CancelToken::default();
    let names = ["row", "design", "room", "position_rms_room_field"];
    let rms = table.numbers("position_rms_room_field").unwrap();
    for rows in [vec![], vec![0], vec![159, 3, 4, 5, 3], (31..97).rev().collect()] {
        let cells = table.cells(&names, &rows, &cancel).unwrap();
        for (k, row) in rows.iter().enumerate() {
            assert_eq!(cells[0][k], Cell::Number(*row as f64));
            assert_eq!(cells[1][k], Cell::Text("pointer-on-head".to_owned()));
            assert_eq!(cells[2][k], Cell::Nothing);
            assert_eq!(cells[3][k], Cell::Number(rms[*row as usize]));
        }
    }
    let sorted =
        table.sorted_rows("position_rms_room_field", Direction::Descending, &cancel).unwrap();
    let sorted: Vec<f64> = sorted.into_iter().map(|row| rms[row as usize]).collect();
    assert_eq!(sorted.len(), 160);
    assert!(sorted.is_sorted_by(|a, b| a >= b));
    let by_motion = table.sorted_rows("motion", Direction::Ascending, &cancel).unwrap();
    assert_eq!(
        by_motion,
        (0..80).map(|k| 2 * k + 1).chain((0..80).map(|k| 2 * k)).collect::<Vec<_>>()
    );
    cancel.cancel();
    let cancelled = table.cells(&names, &[0], &cancel);
    assert!(matches!(cancelled, Err(SweepError::Cancelled(_))));
    let cancelled = table.sorted_rows("row", Direction::Ascending, &cancel);
    assert!(matches!(cancelled, Err(SweepError::Cancelled(_))));
}

/// Written without being computed.
#[test]
#[ignore = "writes a hundred megabytes"]
fn long_a_million_rows_are_sorted() {
    let (dir, sweep) =
        (tempfile::tempdir().unwrap(), sweep(&PLAN.replace("count: 40", "count: 250000")));
    assert_eq!(sweep.rows(), 1_000_000);
    let folder = opened(&dir, "out", &sweep);
    for shard in 0..10 {
        let first = shard * 100_000;
        let mut writer = ShardWriter::new(&sweep, &folder, Part::WHOLE, first).unwrap();
        for start in (first..first + 100_000).step_by(10_000) {
            let rows: Vec<Row> = (start..start + 10_000).map(|row| made_up(&sweep, row)).collect();
            writer.add(&rows).unwrap();
        }
        assert!(writer.finish().unwrap());
    }
    let file = dir.path().join("merged.parquet");
    merge_to(&sweep, &folder, &file).unwrap();
    let cancel = CancelToken::default();
    let figure = |row: u64| {
        made_up(&sweep, row).study.map(|figures| figures.room_field.unwrap()[0]).unwrap()
    };
    let mut expected: Vec<u64> = (0..1_000_000).collect();
    expected.sort_by(|a, b| figure(*a).total_cmp(&figure(*b)));
    for path in [folder.path(), &file] {
        let table = SweepTable::open(path).unwrap();
        let rows =
            table.sorted_rows("position_rms_room_field", Direction::Ascending, &cancel).unwrap();
        assert!(rows == expected, "{path:?}");
        let places = &rows[500_000..500_060];
        let cells = table.cells(&["row", "position_rms_room_field"], places, &cancel).unwrap();
        for (at, row) in places.iter().enumerate() {
            assert_eq!(cells[0][at], Cell::Number(*row as f64));
            assert_eq!(cells[1][at], Cell::Number(figure(*row)));
        }
    }
}

fn made_up(sweep: &Sweep, row: u64) -> Row {
    // In no order, with as many digits as computed ones.
    let value =
        |k: u64| (row.wrapping_add(k).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11) as f64 * 1e-16;
    let numbers = (1..=3).map(value).collect();
    let room_field = std::array::from_fn(|k| value(10 + k as u64));
    let figures = RowFigures {
        trials: 3,
        outside: 0,
        out_of_volume: 0,
        known: None,
        room_field: Some(room_field),
    };
    Row { key: sweep.key(row), numbers, study: Ok(figures) }
}
