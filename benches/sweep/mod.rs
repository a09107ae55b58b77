//! A sweep of a million designs: its rows, and what a window that shows them needs.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use std::path::Path;
use std::sync::LazyLock;
use tempfile::TempDir;
use trackwright_formats::sweep_plan;
use trackwright_sweep::{Direction, Folder, Part, Sweep, SweepTable, run};
use trackwright_task::{CancelToken, Task};

const ROWS: u64 = 1_000_000;
/// What a window of usual height shows.
const IN_VIEW: usize = 60;

/// Designs of the built-in pointer, its three coils somewhere on the shaft.
fn sweep(rows: u64) -> Sweep {
    let range =
        |sensor| format!(r#"(path: "tool.body.sensors[{sensor}].position.z", from: 40, to: 110)"#);
    let text = format!(
        r#"(version: 1, designs: ["pointer-on-head"], motions: [Single],
            figures: ["position_rms", "angle_rms"], expected: false, shard_seconds: 5,
            vary: [Sobol(count: {rows}, ranges: [{}, {}, {}])])"#,
        range(0),
        range(1),
        range(2)
    );
    let plan = sweep_plan::parse(text.as_bytes()).unwrap();
    Sweep::of_plan(plan, Path::new("")).unwrap()
}

fn computed(sweep: &Sweep) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let out = Folder::open(folder.path(), sweep).unwrap();
    run(sweep, &out, Part::WHOLE, &Task::default(), &|_| ()).unwrap();
    folder
}

static MILLION: LazyLock<TempDir> = LazyLock::new(|| computed(&sweep(ROWS)));

#[divan::bench(sample_count = 5, sample_size = 1, args = [20_000, 200_000])]
fn rows(bencher: Bencher, rows: u64) {
    let sweep = sweep(rows);
    bencher.counter(ItemsCount::new(rows)).bench_local(|| computed(&sweep));
}

fn page(table: &SweepTable, rows: &[u64]) {
    let names: Vec<String> = table.columns().into_iter().map(|column| column.name).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    black_box(table.cells(&names, rows, &CancelToken::default()).unwrap());
}

#[divan::bench(sample_size = 1)]
fn first_rows_of_a_million(bencher: Bencher) {
    let first: Vec<u64> = (0..IN_VIEW as u64).collect();
    let path = MILLION.path();
    bencher.bench_local(|| page(&SweepTable::open(path).unwrap(), &first));
}

fn by_figure(table: &SweepTable) -> Vec<u64> {
    table
        .sorted_rows("position_rms_room_field", Direction::Ascending, &CancelToken::default())
        .unwrap()
}

#[divan::bench(sample_count = 20, sample_size = 1)]
fn a_million_sorted(bencher: Bencher) {
    let table = SweepTable::open(MILLION.path()).unwrap();
    bencher.bench_local(|| by_figure(&table));
}

/// Rows that lie anywhere in the files.
#[divan::bench(sample_count = 20, sample_size = 1)]
fn a_page_of_sorted_rows(bencher: Bencher) {
    let table = SweepTable::open(MILLION.path()).unwrap();
    let order = by_figure(&table);
    let middle = order.len() / 2;
    bencher.bench_local(|| page(&table, &order[middle..middle + IN_VIEW]));
}
