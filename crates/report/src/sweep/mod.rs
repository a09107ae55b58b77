//! What a sweep found, as pictures: each design a line through all its numbers, what each number does to a
//! figure, and which designs no other one beats.

mod effects;
mod front;
mod page;
mod parallel;
#[cfg(test)]
mod tests;

pub use effects::{Effect, effect_chart, main_effect};
pub use front::{front, front_chart};
pub use page::page;
pub use parallel::parallel_coordinates;

/// Rows that a picture shows of many: more would only hide each other.
const MOST_DRAWN: usize = 600;

/// Four digits, for a person.
fn significant(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let decimals = (3 - value.abs().log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// A column of numbers, NaN where a row has none.
#[derive(Clone, Debug, PartialEq)]
pub struct NumberColumn {
    pub name: String,
    /// Nothing of what has none.
    pub unit: String,
    pub values: Vec<f64>,
}

/// The rows of a sweep: what varied, and what came out.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepColumns {
    pub title: String,
    /// What the rows are called by, of the same length as every column.
    pub rows: Vec<u64>,
    pub parameters: Vec<NumberColumn>,
    /// At least one; smaller is better.
    pub figures: Vec<NumberColumn>,
}

impl NumberColumn {
    /// Name and unit, for an axis.
    pub fn label(&self) -> String {
        match self.unit.as_str() {
            "" => self.name.clone(),
            unit => format!("{}, {unit}", self.name),
        }
    }

    /// The smallest and the largest number; `None` without any.
    pub fn range(&self) -> Option<[f64; 2]> {
        let finite = self.values.iter().copied().filter(|value| value.is_finite());
        finite.fold(None, |range, value| {
            let [low, high] = range.unwrap_or([value; 2]);
            Some([low.min(value), high.max(value)])
        })
    }
}

impl SweepColumns {
    /// Some of the rows, spread over all of them, that have every number.
    fn drawn(&self) -> Vec<usize> {
        let columns = || self.parameters.iter().chain(&self.figures);
        let is_whole = |row: &usize| columns().all(|column| column.values[*row].is_finite());
        let whole: Vec<usize> = (0..self.rows.len()).filter(is_whole).collect();
        let count = whole.len().min(MOST_DRAWN);
        (0..count).map(|k| whole[k * whole.len() / count]).collect()
    }
}
