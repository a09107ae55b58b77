//! Tables as commands write and read them.

use nalgebra::Point3;
use std::path::Path;
use trackwright_geometry::pose::{Pose, pose_to_array};

/// The columns of a table of poses.
pub const POSE: &str = "x,y,z,qw,qx,qy,qz";

/// The columns of a table of measured positions alone.
pub const POSITIONS: &str = "ideal_x,ideal_y,ideal_z,measured_x,measured_y,measured_z";

/// The columns of a table of measurements.
pub fn measurement_columns() -> String {
    let of = |side: &str| POSE.split(',').map(|name| format!("{side}_{name}")).collect::<Vec<_>>();
    [of("ideal"), of("measured")].concat().join(",")
}

/// A table of poses.
pub fn poses_table(poses: impl IntoIterator<Item = Pose>) -> String {
    let row = |pose| pose_to_array(&pose).map(|value| value.to_string()).join(",") + "\n";
    poses.into_iter().fold(format!("{POSE}\n"), |table, pose| table + &row(pose))
}

/// A table of points, without names of columns.
pub fn points_table(points: impl IntoIterator<Item = Point3<f64>>) -> String {
    points.into_iter().map(|p| format!("{},{},{}\n", p.x, p.y, p.z)).collect()
}

/// The cells of a file with commas, below the names of its columns.
#[derive(Debug)]
pub struct Table {
    pub columns: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Table {
    pub fn read(file: &Path) -> Self {
        let text = std::fs::read_to_string(file).unwrap();
        let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect());
        Self { columns: lines.next().unwrap(), rows: lines.collect() }
    }

    /// The columns behind the first ones.
    pub fn without_first(&self, count: usize) -> Self {
        let rest = |cells: &Vec<String>| cells[count..].to_vec();
        Self { columns: rest(&self.columns), rows: self.rows.iter().map(rest).collect() }
    }

    pub fn to_text(&self) -> String {
        let lines = std::iter::once(&self.columns).chain(&self.rows);
        lines.map(|cells| cells.join(",") + "\n").collect()
    }

    #[track_caller]
    pub fn column(&self, name: &str) -> usize {
        let place = self.columns.iter().position(|column| column == name);
        place.unwrap_or_else(|| panic!("{name} is not in {:?}", self.columns))
    }

    #[track_caller]
    pub fn cell(&self, row: usize, name: &str) -> &str {
        &self.rows[row][self.column(name)]
    }

    #[track_caller]
    pub fn number(&self, row: usize, name: &str) -> f64 {
        let cell = self.cell(row, name);
        cell.parse().unwrap_or_else(|_| panic!("{name} is {cell:?}"))
    }

    /// The numbers of a column.
    #[track_caller]
    pub fn numbers(&self, name: &str) -> Vec<f64> {
        (0..self.rows.len()).map(|row| self.number(row, name)).collect()
    }

    /// The first cells of each row.
    pub fn first<const N: usize>(&self) -> Vec<[f64; N]> {
        let of = |row: &Vec<String>| std::array::from_fn(|k| row[k].parse().unwrap());
        self.rows.iter().map(of).collect()
    }
}
