//! Every row holds, and naive methods are found out.

use super::case::{Case, Extent, Found, Methods, Quantity, Row};
use super::{families, naive, page, run};
use std::collections::BTreeSet;
use trackwright_task::Task;

fn rows(methods: &Methods, family: &str) -> Vec<Row> {
    let families: Vec<_> =
        families(Extent::Reduced).into_iter().filter(|f| f.name == family).collect();
    assert!(!families.is_empty(), "no family {family}");
    run(&families, methods, &Task::default()).unwrap()
}

/// Quantities of a family that a method breaks the bound of.
fn broken(methods: &Methods, family: &str) -> BTreeSet<&'static str> {
    let rows = rows(methods, family);
    rows.iter().filter(|r| !r.holds).map(|r| r.quantity).collect()
}

macro_rules! every_row_holds {
    ($($name:ident: $family:literal,)*) => {
        $(
            #[test]
            fn $name() {
                let rows = rows(&Methods::OWN, $family);
                assert!(rows.iter().all(|r| r.holds), "{}", page::text(&rows));
            }
        )*

        #[test]
        fn no_family_is_left_out_here() {
            let all: Vec<_> = families(Extent::Reduced).iter().map(|f| f.name).collect();
            assert_eq!(all, [$($family),*]);
        }
    };
}

every_row_holds! {
    every_row_of_evaluation_holds: "evaluation",
    every_row_of_derivatives_holds: "derivatives",
    every_row_of_inverse_holds: "inverse",
    every_row_of_weights_holds: "weights",
    every_row_of_rotations_holds: "rotations",
    every_row_of_least_squares_holds: "least squares",
    every_row_of_fits_holds: "fits",
    every_row_of_high_orders_holds: "high orders",
    every_row_of_singular_values_holds: "singular values",
    every_row_of_frames_holds: "frames",
    every_row_of_uncertainty_holds: "uncertainty and tip error",
    every_row_of_statistics_holds: "statistics",
    every_row_of_spheres_holds: "spheres",
    every_row_of_readings_holds: "readings",
    every_row_of_metal_holds: "metal",
    every_row_of_what_is_not_a_number_holds: "not a number",
}

#[test]
fn naive_methods_are_found_out() {
    let (values, solution) =
        (&["position error, mm", "rotation error, rad"][..], "solution, mm or rad");
    let cases: [(&Methods, &str, &[&str]); 14] = [
        (&naive::NORMAL_EQUATIONS, "least squares", &[solution, "condition number, relative"]),
        (&naive::NORMAL_EQUATIONS, "fits", &[solution]),
        (
            &naive::ARCCOSINE_LOGARITHM,
            "rotations",
            &[
                "logarithm of a matrix, rad",
                "logarithm of a quaternion, rad",
                "angle of a quaternion, rad",
                "smallest rotation between axes, rad",
            ],
        ),
        (&naive::NO_DETERMINANT_SIGN, "frames", &["rotation, rad", "fitted tip, mm"]),
        (&naive::MONOMIALS, "evaluation", values),
        (&naive::SINGLE_PRECISION, "evaluation", values),
        (
            &naive::DIFFERENCES,
            "derivatives",
            &[
                "derivatives by position, mm or rad a mm",
                "derivatives by the axis, mm or rad a rad",
            ],
        ),
        (
            &naive::FIXED_POINT,
            "inverse",
            &["position behind a reading, mm", "what is not flagged is the pose"],
        ),
        (&naive::ANGLES_SUM, "weights", &["weights"]),
        (&naive::SQUARED_SINGULAR_VALUES, "singular values", &["singular values"]),
        (&naive::TEXTBOOK_VARIANCE, "statistics", &["standard deviation"]),
        (
            &naive::MOMENTS_ABOUT_ORIGIN,
            "uncertainty and tip error",
            &["covariance of the tip, mm²", "angle error, rad"],
        ),
        (&naive::COTANGENT, "spheres", &["real part of the factor"]),
        (&naive::NAN_IGNORED, "not a number", &["all figures are not numbers"]),
    ];
    for (methods, family, quantities) in cases {
        let found = broken(methods, family);
        for quantity in quantities {
            assert!(found.contains(quantity), "{family}: {quantity}: broken are {found:?}");
        }
    }
}

#[test]
fn constants_are_at_most_100_and_argued() {
    for family in families(Extent::Full) {
        for q in &family.quantities {
            assert!(q.constant > 0.0 && q.constant <= 100.0, "{q:?}");
            assert!(!q.condition.is_empty() && !q.scale.is_empty(), "{q:?}");
        }
    }
}

const LENGTH: Quantity = Quantity::new("length", 10.0, "1", "itself");

/// The rows of a case with these.
fn of_case(name: &str, found: impl Fn() -> Found + Send + Sync + 'static) -> Vec<Row> {
    Case::new(name, move |_| found()).rows(&Methods::OWN)
}

#[test]
fn errors_beyond_bounds_do_not_hold() {
    let bound = 10.0 * 4.0 * f64::EPSILON * 3.0;
    for (condition, error, holds) in [
        (4.0, bound, true),
        (4.0, 1.01 * bound, false),
        (4.0, f64::NAN, false),
        (f64::INFINITY, 1.0, false),
        (f64::NAN, 0.0, false),
    ] {
        assert_eq!(LENGTH.row(condition, error, 3.0).holds, holds, "{condition} {error}");
    }
}

#[test]
fn the_error_nearest_to_its_bound_is_shown() {
    let errors = [(1.0, 1.0), (1e-20, 1.0), (0.5, 1e-3)];
    assert_eq!(LENGTH.worst(1.0, &errors).error, 0.5);
    let rows = of_case("case", move || {
        Ok(errors.map(|(error, scale)| LENGTH.row(1.0, error, scale)).to_vec())
    });
    assert_eq!((rows.len(), rows[0].error, rows[0].holds), (1, 0.5, false));
}

#[test]
fn a_case_that_fails_is_a_row_that_does_not_hold() {
    let failed = of_case("case", || Err("is solved"));
    assert_eq!(failed, [Row::behaviour("case", "is solved", false)]);
}

#[test]
fn the_table_states_what_is_broken() {
    let row = |error: f64| move || Ok(vec![LENGTH.row(1.0, error, 1.0)]);
    let rows = [of_case("a good case", row(0.0)), of_case("a bad case", row(1.0))].concat();
    let text = page::text(&rows);
    assert!(text.contains("1 of 2 rows do not hold:\n  a bad case: length"), "{text}");
    assert_eq!(page::verdict(&rows[..1]), "all 1 rows hold");
}

#[test]
fn json_has_the_six_names_and_no_other() {
    let value = serde_json::to_value(LENGTH.row(1.0, 0.0, 1.0)).unwrap();
    let names: BTreeSet<_> = value.as_object().unwrap().keys().map(String::as_str).collect();
    let expected = ["case", "quantity", "condition", "error", "bound", "holds"];
    assert_eq!(names, BTreeSet::from(expected));
}
