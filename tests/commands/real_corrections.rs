//! Corrections of real 6-DOF readings that the fit has not seen, and the bounds that they state.

use crate::support::data::{aurora_pairs, third_party};
use crate::support::program::Scratch;
use crate::support::table::{POSE, Table};
use nalgebra::Point3;

/// What a correction leaves of readings left out.
#[derive(Default)]
struct LeftOut {
    rows: f64,
    raw_squares: f64,
    squares: f64,
    within_mm: f64,
    within_deg: f64,
}

impl LeftOut {
    fn rms_mm(&self) -> f64 {
        (self.squares / self.rows).sqrt()
    }

    fn raw_rms_mm(&self) -> f64 {
        (self.raw_squares / self.rows).sqrt()
    }

    /// Parts of the positions and of the orientations that are within their 95 % bounds.
    fn within(&self) -> [f64; 2] {
        [self.within_mm, self.within_deg].map(|count| count / self.rows)
    }

    /// Fits a correction to some rows of a table and applies it to others.
    fn add(&mut self, scratch: &Scratch, table: &Table, is_out: impl Fn(usize) -> bool) {
        let part = |wanted: bool| Table {
            columns: table.columns.clone(),
            rows: (0..table.rows.len())
                .filter(|row| is_out(*row) == wanted)
                .map(|row| table.rows[row].clone())
                .collect(),
        };
        let (known, left_out) = (part(false), part(true));
        scratch.write("known.csv", known.to_text());
        scratch
            .succeed("fit known.csv --map correction --sensors 6dof -o room.env.ron --overwrite");
        let poses = |side: &str| -> Vec<String> {
            let columns = POSE.split(',').map(|name| left_out.column(&format!("{side}_{name}")));
            let columns: Vec<usize> = columns.collect();
            let line =
                |row: &Vec<String>| columns.iter().map(|c| row[*c].clone()).collect::<Vec<_>>();
            left_out.rows.iter().map(|row| line(row).join(",") + "\n").collect()
        };
        for side in ["ideal", "measured"] {
            scratch.write(&format!("{side}.csv"), format!("{POSE}\n{}", poses(side).concat()));
        }
        let line =
            "compensate room.env.ron measured.csv --support -o found.csv --overwrite --as-is";
        scratch.succeed(line);
        let stated = scratch.table("found.csv");
        let [ideal, measured, found] =
            ["ideal.csv", "measured.csv", "found.csv"].map(|name| scratch.poses(name));
        for (row, (ideal, found)) in ideal.iter().zip(&found).enumerate() {
            let place = Point3::from(ideal.translation.vector);
            let off_mm = (found.translation.vector - place.coords).norm();
            let off_deg = ideal.rotation.angle_to(&found.rotation).to_degrees();
            self.rows += 1.0;
            self.squares += off_mm * off_mm;
            self.raw_squares += (measured[row].translation.vector - place.coords).norm_squared();
            self.within_mm += f64::from(off_mm <= stated.number(row, "within95_mm"));
            self.within_deg += f64::from(off_deg <= stated.number(row, "within95_deg"));
        }
    }
}

/// The texts of a column, each once.
fn texts(table: &Table, column: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for row in 0..table.rows.len() {
        let text = table.cell(row, column);
        if !found.iter().any(|known| known == text) {
            found.push(text.to_owned());
        }
    }
    found
}

/// Each group of rows left out in turn.
fn left_out(scratch: &Scratch, table: &Table, column: &str, groups: &[Vec<String>]) -> LeftOut {
    let mut sum = LeftOut::default();
    for group in groups {
        sum.add(scratch, table, |row| group.iter().any(|text| text == table.cell(row, column)));
    }
    sum
}

fn each(texts: Vec<String>) -> Vec<Vec<String>> {
    texts.into_iter().map(|text| vec![text]).collect()
}

#[test]
fn other_poses_and_sensors_are_within_the_bounds() {
    let Some(folder) = third_party("aurora-polaris/static") else { return };
    let scratch = Scratch::new();
    scratch.succeed(format!("characterize {} -o room.csv", aurora_pairs(&folder, 0, 1)));
    let table = scratch.table("room.csv");
    let poses = texts(&table, "pose");
    let folds = (0..5).map(|fold| poses.iter().skip(fold).step_by(5).cloned().collect());
    let folds: Vec<Vec<String>> = folds.collect();
    // 4.77 mm as read. Without the second axis 2.1 and 3.5 mm are left.
    let by_pose = left_out(&scratch, &table, "pose", &folds);
    assert!(by_pose.rms_mm() < 1.8, "{} of {}", by_pose.rms_mm(), by_pose.raw_rms_mm());
    let by_sensor = left_out(&scratch, &table, "sensor", &each(texts(&table, "sensor")));
    assert!(by_sensor.rms_mm() < 2.7, "{} of {}", by_sensor.rms_mm(), by_sensor.raw_rms_mm());
    for held in [by_pose, by_sensor] {
        assert!(held.within().iter().all(|part| *part >= 0.89), "{:?}", held.within());
    }
}

#[test]
fn other_paths_are_within_the_bounds() {
    let Some(folder) = third_party("aurora-polaris/paths") else { return };
    let scratch = Scratch::new();
    scratch.succeed(format!("characterize {} -o paths.csv", aurora_pairs(&folder, 0, 1)));
    let mut table = scratch.table("paths.csv");
    table.rows = table.rows.into_iter().step_by(5).collect();
    let held = left_out(&scratch, &table, "pair", &each(texts(&table, "pair")));
    // One path determines little of another, and the bounds state that.
    assert!(held.rms_mm() < 1.2 * held.raw_rms_mm(), "{} {}", held.rms_mm(), held.raw_rms_mm());
    assert!(held.within().iter().all(|part| *part >= 0.89), "{:?}", held.within());
}
