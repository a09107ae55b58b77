//! Error against run time, for every way that the program can compute the same thing.
//!
//! One file a family: each measures the time of its methods and their error against a reference
//! of higher precision or resolution, for one scenario. Errors are the same each time; times are
//! the machine's.

mod field;
mod fit;
mod heatmap;
mod interpolated;
mod inverse;
mod machine;
mod metal;
mod motion;
pub mod page;
mod polynomial_room;
mod sampling;
mod single;
#[cfg(test)]
mod testing;
mod timing;
mod uncertainty;

#[cfg(test)]
pub(crate) use inverse::fixed_point;
pub use machine::Machine;
pub use timing::Timing;

use serde::Serialize;
use trackwright_field::DistortionModel;
use trackwright_field::computed::ModelKind;
use trackwright_simulation::Scenario;
use trackwright_task::{Cancelled, Task};

/// Why a family is left out in a room of another kind.
const NOT_POLYNOMIALS: &str = "the design's room is not of Bernstein polynomials, the only field that is known to higher precision";

/// What is computed in several ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum What {
    Field,
    Fit,
    Inverse,
    Uncertainty,
    Motion,
    Heatmap,
    Metal,
}

impl What {
    /// All of them, in the order of the page.
    pub const ALL: [Self; 7] = [
        Self::Field,
        Self::Fit,
        Self::Inverse,
        Self::Uncertainty,
        Self::Motion,
        Self::Heatmap,
        Self::Metal,
    ];

    /// Its name in JSON and of files, the heading of its part of the page, and what measures it.
    fn parts(self) -> (&'static str, &'static str, Measure) {
        match self {
            Self::Field => ("field", "Field", field::measure),
            Self::Fit => ("fit", "Fit", fit::measure),
            Self::Inverse => ("inverse", "Inverse", inverse::measure),
            Self::Uncertainty => ("uncertainty", "Uncertainty", uncertainty::measure),
            Self::Motion => ("motion", "Study", motion::measure),
            Self::Heatmap => ("heatmap", "Slice", heatmap::measure),
            Self::Metal => ("metal", "Metal", metal::measure),
        }
    }

    /// As it is called in JSON, and names files by.
    pub fn name(self) -> &'static str {
        self.parts().0
    }

    /// Heading of its part of the page.
    pub fn title(self) -> &'static str {
        self.parts().1
    }
}

/// Measures the rows of a family.
type Measure = fn(&mut Bench) -> Result<(), Stop>;

/// One way of computing something: what it costs, and how far off it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    pub what: What,
    pub method: String,
    pub order: usize,
    pub directions: usize,
    /// Poses, samples, trials or points: what the time is for.
    pub size: usize,
    pub seconds: f64,
    /// Largest difference from the reference, or as the family states.
    pub error: f64,
    pub error_unit: &'static str,
    /// Not beaten in both time and error by another answer to the same problem.
    pub on_front: bool,
    /// What the program does by default.
    pub is_default: bool,
    /// The requested quantity: rows of one problem can stand for each other, others cannot.
    pub problem: String,
    /// The chart's series that the row is a point of; none where it is not charted.
    #[serde(skip)]
    pub series: String,
    /// Whether the row is one of a sequence, finer and finer: its series is a line.
    #[serde(skip)]
    pub is_step: bool,
}

impl Row {
    /// A way of computing something in a room: charted under its own name, neither the default nor
    /// one of a sequence, its error in millimetres.
    fn new(what: What, room: &DistortionModel, problem: &str, method: &str) -> Self {
        Self {
            what,
            method: method.to_owned(),
            order: room.order(),
            directions: room.directions().len(),
            size: 0,
            seconds: 0.0,
            error: 0.0,
            error_unit: "mm",
            on_front: false,
            is_default: false,
            problem: problem.to_owned(),
            series: method.to_owned(),
            is_step: false,
        }
    }

    /// With what was measured.
    fn measured(self, size: usize, seconds: f64, error: f64) -> Self {
        Self { size, seconds, error, ..self }
    }

    /// What the program does, where it is.
    fn default_if(self, is_default: bool) -> Self {
        Self { is_default, ..self }
    }

    /// In a series of the chart.
    fn charted(self, series: &str) -> Self {
        Self { series: series.to_owned(), ..self }
    }

    /// One of a sequence, finer and finer.
    fn step_of(self, series: &str) -> Self {
        Self { is_step: true, ..self.charted(series) }
    }

    /// In the tables alone.
    fn uncharted(self) -> Self {
        self.charted("")
    }
}

/// All ways of computing one thing.
#[derive(Clone, Debug, PartialEq)]
pub struct Family {
    pub what: What,
    /// What is computed, and what the error is a difference from.
    pub about: String,
    pub rows: Vec<Row>,
    /// Problem whose front the chart draws.
    pub charted: String,
    /// Why there are no rows, where there are none.
    pub left_out: Option<String>,
}

/// What to measure, and how patiently.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    pub timing: Timing,
    /// Poses that the field is evaluated at.
    pub poses: usize,
    /// Samples that are fitted.
    pub samples: usize,
    /// Highest order that is fitted and evaluated.
    pub max_order: usize,
    /// Points along the side of the slice that others are held against.
    pub slice_reference: usize,
    /// Poses that the range of motion is held against.
    pub motion_reference: usize,
    /// Samples of the largest Monte Carlo, and of the one that it is held against.
    pub monte_carlo_samples: usize,
    pub monte_carlo_reference: usize,
    /// Triangles of the metal that coarser metal is held against.
    pub metal_reference: usize,
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            timing: Timing::default(),
            poses: 4096,
            samples: 4000,
            max_order: 6,
            slice_reference: 641,
            motion_reference: 131_072,
            monte_carlo_samples: 1_000_000,
            monte_carlo_reference: 2_000_000,
            metal_reference: 4000,
            seed: 1,
        }
    }
}

impl Settings {
    /// A first look within seconds: few poses and samples, one run each.
    pub fn quick() -> Self {
        Self {
            timing: Timing::ONCE,
            poses: 256,
            samples: 800,
            max_order: 4,
            slice_reference: 321,
            motion_reference: 8192,
            monte_carlo_samples: 1000,
            monte_carlo_reference: 5000,
            metal_reference: 1000,
            ..Self::default()
        }
    }
}

/// All families, and the machine that they were measured on.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    pub machine: Machine,
    /// The room's, beside the scenario's own design.
    pub room: String,
    pub families: Vec<Family>,
}

impl Report {
    /// The rows of all families.
    pub fn rows(&self) -> impl Iterator<Item = &Row> {
        self.families.iter().flat_map(|f| &f.rows)
    }
}

/// Measures all families, and shows each as soon as it is there.
///
/// # Errors
/// [`Cancelled`]. What cannot be measured for a scenario is left out with a reason.
pub fn run_each(
    scenario: &Scenario,
    settings: &Settings,
    task: &Task,
    mut show: impl FnMut(&Family),
) -> Result<Report, Cancelled> {
    let scenario = &polynomial_room::in_polynomials(scenario, &task.cancel);
    let mut families = Vec::new();
    for (number, what) in What::ALL.into_iter().enumerate() {
        task.step(number, What::ALL.len())?;
        let family = measure(what, number, scenario, settings, task)?;
        show(&family);
        families.push(family);
    }
    task.step(1, 1)?;
    Ok(Report { machine: Machine::this(), room: scenario.environment.name.clone(), families })
}

/// One family, a number in the order of the page.
fn measure(
    what: What,
    number: usize,
    scenario: &Scenario,
    settings: &Settings,
    task: &Task,
) -> Result<Family, Cancelled> {
    let (about, charted) = (String::new(), String::new());
    let family = Family { what, about, rows: Vec::new(), charted, left_out: None };
    let mut bench = Bench { scenario, settings, task, family, number, done: 0, steps: 1 };
    let measured = what.parts().2(&mut bench);
    let mut family = bench.family;
    match measured {
        Ok(()) => mark_fronts(&mut family.rows),
        Err(Stop::Cancelled) => return Err(Cancelled),
        Err(Stop::LeftOut(why)) => {
            family.rows.clear();
            family.left_out = Some(why);
        }
    }
    Ok(family)
}

/// A family while it is measured: its rows so far, and how far it is within the whole.
struct Bench<'a> {
    scenario: &'a Scenario,
    settings: &'a Settings,
    task: &'a Task,
    family: Family,
    number: usize,
    done: usize,
    /// Steps of this family.
    steps: usize,
}

/// Why a family ends before all of its rows are there.
#[derive(Debug)]
enum Stop {
    Cancelled,
    LeftOut(String),
}

impl From<Cancelled> for Stop {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl<'a> Bench<'a> {
    /// The room's field.
    fn room(&self) -> &'a DistortionModel {
        &self.scenario.environment.model
    }

    /// A task without progress of its own, cancelled with the whole.
    fn own_task(&self) -> Task {
        Task::cancelled_by(self.task.cancel.clone())
    }

    /// A row of a way to answer the problem that is charted.
    fn row(&self, method: &str) -> Row {
        Row::new(self.family.what, self.room(), &self.family.charted, method)
    }

    /// A row that is measured, which is a step.
    fn add(&mut self, row: Row) -> Result<(), Cancelled> {
        self.family.rows.push(row);
        self.next()
    }

    /// One more step is done.
    fn next(&mut self) -> Result<(), Cancelled> {
        self.done += 1;
        let done = self.number * self.steps + self.done.min(self.steps);
        self.task.step(done, What::ALL.len() * self.steps)
    }

    /// Stops for an error, which may be that of a task that was cancelled.
    fn stop(&self, error: impl ToString) -> Stop {
        if self.task.cancel.is_cancelled() {
            return Stop::Cancelled;
        }
        Stop::LeftOut(error.to_string())
    }

    /// Leaves the family out in a room whose field cannot be compared with an exact one; `ideal` is
    /// why in one without distortion.
    fn need_field(&self, ideal: &str) -> Result<(), Stop> {
        if self.room().kind() != ModelKind::Bernstein {
            return Err(self.stop(NOT_POLYNOMIALS));
        }
        if self.room().is_zero() {
            return Err(self.stop(format!("the design's room is ideal: {ideal}")));
        }
        Ok(())
    }
}

/// Marks the Pareto front of each problem: the rows that no other row is at least as good as in both
/// time and error and better in one. Equals stand on it together; what is not a number never does.
fn mark_fronts(rows: &mut [Row]) {
    let point = |row: &Row| (row.seconds, row.error);
    let beats = |a: (f64, f64), b: (f64, f64)| a.0 <= b.0 && a.1 <= b.1 && a != b;
    let is_on_front = |row: &Row| {
        let mut same = rows.iter().filter(|other| other.problem == row.problem);
        let own = point(row);
        !own.0.is_nan() && !own.1.is_nan() && !same.any(|other| beats(point(other), own))
    };
    let flags: Vec<bool> = rows.iter().map(is_on_front).collect();
    for (row, on_front) in rows.iter_mut().zip(flags) {
        row.on_front = on_front;
    }
}

#[cfg(test)]
mod tests;
