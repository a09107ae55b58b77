//! A measurement table as a person judges it before anything is fitted to it.

use super::error::StoreError;
use super::files::Files;
use super::samples::SampleReading;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use trackwright_calibration::doubts::Suspicion;
use trackwright_calibration::fit_quality::{ErrorSummary, measured_errors};
use trackwright_field::samples::SampleSet;
use trackwright_formats::groups::GroupColumn;
use trackwright_geometry::bounds::Bounds;
use trackwright_task::Task;

/// A table that was read, with everything that is said of it.
#[derive(Debug)]
pub struct MeasurementTable {
    pub file: PathBuf,
    pub reading: SampleReading,
    pub samples: SampleSet,
    /// What the table may be instead of what it is read as.
    pub suspicions: Vec<Suspicion>,
    /// Their errors as they were measured.
    pub measured: ErrorSummary,
    /// Of the samples' positions.
    pub bounds: Option<Bounds>,
    /// The column that says which rows belong together. A column that cannot be used is no reason
    /// not to fit the rows, but one not to choose a model by them.
    pub groups: Result<Option<TableGroups>, StoreError>,
}

/// A column of groups, and how many there are.
#[derive(Clone, Debug, PartialEq)]
pub struct TableGroups {
    pub column: GroupColumn,
    pub count: usize,
}

impl MeasurementTable {
    /// The file's name without its folder.
    pub fn name(&self) -> String {
        self.file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
    }

    /// Whether no tracker's table is like this; commands take one only with `--as-is`.
    pub fn is_beyond_doubt(&self) -> bool {
        self.suspicions.iter().any(Suspicion::is_beyond_doubt)
    }

    /// Edge of the cube that each sample would have to itself, mm; `None` for samples in a plane.
    pub fn spacing_mm(&self) -> Option<f64> {
        let volume_mm3 = self.bounds?.size_mm().product();
        let spacing_mm = (volume_mm3 / self.samples.samples.len() as f64).cbrt();
        (spacing_mm > 0.0).then_some(spacing_mm)
    }
}

impl Files {
    /// Reads a table with its groups.
    ///
    /// # Errors
    /// Those of [`read_samples`](Self::read_samples).
    pub fn read_table(
        &self,
        file: &Path,
        reading: SampleReading,
        task: &Task,
    ) -> Result<MeasurementTable, StoreError> {
        let found = self.read_samples(file, reading, task)?;
        let (suspicions, samples) = (found.suspicions.clone(), found.as_it_stands());
        let groups = self.read_groups(file, None).map(|column| {
            column.map(|column| TableGroups {
                count: column.labels.iter().collect::<HashSet<_>>().len(),
                column,
            })
        });
        Ok(MeasurementTable {
            file: file.to_owned(),
            reading,
            bounds: Bounds::around(samples.samples.iter().map(|s| s.position_mm)),
            measured: measured_errors(&samples),
            samples,
            suspicions,
            groups,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_field::samples::MapKind;

    fn table(text: &str) -> MeasurementTable {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        let reading = SampleReading { has_rolls: false, map: MapKind::Distortion };
        Files::default().read_table(file.path(), reading, &Task::default()).unwrap()
    }

    const HEAD: &str = "ideal_x,ideal_y,ideal_z,measured_x,measured_y,measured_z,cluster\n";

    #[test]
    fn groups_are_counted_and_a_column_that_cannot_be_used_leaves_the_rows() {
        let good = table(&format!("{HEAD}0,0,0,0,0,0,a\n8,0,0,8,0,0,b\n0,2,4,0,2,4,a\n"));
        let groups = good.groups.as_ref().unwrap().as_ref().unwrap();
        assert_eq!((groups.count, groups.column.name.as_str()), (2, "cluster"));
        assert!((good.spacing_mm().unwrap() - (64.0_f64 / 3.0).cbrt()).abs() < 1e-12);
        let bad = table(&format!("{HEAD}0,0,0,0,0,0,a\n8,0,0,8,0,0,\n"));
        assert_eq!(bad.samples.samples.len(), 2);
        assert_eq!(bad.spacing_mm(), None);
        let problem = bad.groups.unwrap_err().to_string();
        assert!(problem.contains("cluster is empty"), "{problem}");
    }
}
