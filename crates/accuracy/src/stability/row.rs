//! One line of the battery: an error beside the bound that it has to keep.

use super::methods::Methods;
use serde::Serialize;

/// What is measured, and what its bound is made of: `constant · condition · epsilon · scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    pub name: &'static str,
    /// At most 100. Of the order of the number of roundings that a value passes through.
    pub constant: f64,
    /// What the condition number is of.
    pub condition: &'static str,
    /// What the error is relative to.
    pub scale: &'static str,
}

/// Behaviour instead of a number: one where it is not what it must be, and nothing allowed.
pub const BEHAVIOUR: Quantity = Quantity {
    name: "behaviour",
    constant: 0.0,
    condition: "1",
    scale: "violations are counted; none is allowed",
};

/// One error and its bound. `error` and `bound` are in the quantity's unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    #[serde(skip)]
    pub family: &'static str,
    pub case: String,
    pub quantity: &'static str,
    pub condition: f64,
    pub error: f64,
    pub bound: f64,
    pub holds: bool,
}

impl Quantity {
    /// A row; an error that is not a number does not hold.
    pub fn row(&self, case: &str, condition: f64, error: f64, scale: f64) -> Row {
        self.row_with_bound(
            case,
            condition,
            error,
            self.constant * condition * f64::EPSILON * scale,
        )
    }

    fn row_with_bound(&self, case: &str, condition: f64, error: f64, bound: f64) -> Row {
        Row {
            family: "",
            case: case.to_owned(),
            quantity: self.name,
            condition,
            error,
            bound,
            holds: error <= bound && bound.is_finite(),
        }
    }

    /// Of several errors with their scales, the one that comes nearest to its bound.
    pub fn worst(&self, case: &str, condition: f64, errors: &[(f64, f64)]) -> Row {
        let rows = errors.iter().map(|&(error, scale)| self.row(case, condition, error, scale));
        Row::worst_of(rows.collect()).unwrap_or_else(|| self.row(case, condition, f64::NAN, 0.0))
    }
}

impl Row {
    /// What must happen, and whether it did.
    pub fn behaviour(case: &str, must: &'static str, did: bool) -> Self {
        let quantity = Quantity { name: must, ..BEHAVIOUR };
        quantity.row(case, 1.0, if did { 0.0 } else { 1.0 }, 0.0)
    }

    /// Of several rows, the one that comes nearest to its bound or is furthest beyond it.
    pub fn worst_of(rows: Vec<Self>) -> Option<Self> {
        rows.into_iter().reduce(|a, b| if b.badness() > a.badness() { b } else { a })
    }

    /// Error over bound; one at the bound, infinite where nothing is allowed and something is.
    pub fn badness(&self) -> f64 {
        if self.error == 0.0 {
            0.0
        } else if self.error.is_nan() || self.bound.is_nan() {
            f64::INFINITY
        } else {
            self.error / self.bound
        }
    }
}

/// What a case computes with.
type Run = Box<dyn Fn(&dyn Methods) -> Vec<Row> + Send + Sync>;

/// One input and all that is measured on it.
pub struct Case {
    pub name: String,
    run: Run,
}

impl Case {
    pub fn new(
        name: impl Into<String>,
        run: impl Fn(&dyn Methods, &str) -> Vec<Row> + Send + Sync + 'static,
    ) -> Self {
        let name = name.into();
        let own_name = name.clone();
        Self { name, run: Box::new(move |methods| run(methods, &own_name)) }
    }

    /// The rows; a panic is one that does not hold.
    pub fn rows(&self, methods: &dyn Methods) -> Vec<Row> {
        let attempt = std::panic::AssertUnwindSafe(|| (self.run)(methods));
        std::panic::catch_unwind(attempt)
            .unwrap_or_else(|_| vec![Row::behaviour(&self.name, "does not panic", false)])
    }
}

/// Cases that belong together.
pub struct Family {
    pub name: &'static str,
    /// What is compared with what, in a sentence or two.
    pub about: &'static str,
    pub quantities: Vec<Quantity>,
    pub cases: Vec<Case>,
}
