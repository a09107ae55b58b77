//! What a chart promises whoever reads it.

use super::*;

fn axis(label: &str, scale: Scale) -> Axis {
    Axis { label: label.to_owned(), scale }
}

fn series(name: &str, style: SeriesStyle, points: &[(f64, f64)]) -> Series {
    Series { name: name.to_owned(), points: points.to_vec(), style }
}

fn chart(scale: Scale, series: Vec<Series>) -> Chart {
    Chart {
        title: "Error against run time".to_owned(),
        x: axis("time (s)", scale),
        y: axis("error (mm)", scale),
        series,
    }
}

const SIZE: (u32, u32) = (900, 600);

#[test]
fn title_labels_and_names_are_in_the_picture() {
    let points = [(1e-6, 1e-3), (1e-5, 1e-9)];
    let svg = chart(
        Scale::Logarithmic,
        vec![
            series("orders < 4 & more", SeriesStyle::Points, &points),
            series("default", SeriesStyle::Marked, &points[..1]),
        ],
    )
    .to_svg(SIZE);
    for text in [
        "Error against run time",
        "time (s)",
        "error (mm)",
        "orders &lt; 4 &amp; more",
        "default",
        "10⁻⁶",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    assert!(!svg.contains("not shown"));
}

#[test]
fn points_off_a_logarithmic_axis_are_counted() {
    let points = [(1.0, 0.0), (2.0, 1.0), (-1.0, 2.0), (f64::NAN, 1.0)];
    let svg =
        chart(Scale::Logarithmic, vec![series("a", SeriesStyle::Points, &points)]).to_svg(SIZE);
    assert!(svg.contains("3 points of 4 are not shown"));
}

#[test]
fn a_missing_point_is_a_gap_in_its_line() {
    let whole = [(1.0, 1.0), (2.0, 2.0), (3.0, 3.0), (4.0, 4.0)];
    let mut broken = whole.to_vec();
    broken.insert(2, (2.5, f64::NAN));
    let lines = |points: &[(f64, f64)]| {
        chart(Scale::Linear, vec![series("", SeriesStyle::Line, points)])
            .to_svg(SIZE)
            .matches("stroke-width=\"2\"")
            .count()
    };
    assert_eq!((lines(&whole), lines(&broken)), (1, 2));
}

#[test]
fn an_empty_plot_shows_a_note() {
    for scale in [Scale::Linear, Scale::Logarithmic] {
        for given in [vec![], vec![series("empty", SeriesStyle::Line, &[])]] {
            let svg = chart(scale, given).to_svg(SIZE);
            assert!(svg.contains("No points to show"));
        }
    }
}

#[test]
fn extreme_sizes_and_values_make_a_picture() {
    let points =
        [(f64::MIN_POSITIVE, f64::MAX), (-f64::MAX, f64::MAX), (f64::INFINITY, 0.0), (0.0, -0.0)];
    for style in [SeriesStyle::Line, SeriesStyle::Points, SeriesStyle::Marked, SeriesStyle::Front] {
        for scale in [Scale::Linear, Scale::Logarithmic] {
            for size in [(1, 1), (200, 100), SIZE] {
                let svg = chart(scale, vec![series("name", style, &points)]).to_svg(size);
                assert!(svg.trim_end().ends_with("</svg>"));
                assert!(!svg.contains("NaN") && !svg.contains("inf"));
            }
        }
    }
}

#[test]
fn two_series_differ_in_colour_and_in_shape() {
    let a = series("a", SeriesStyle::Points, &[(1.0, 1.0)]);
    let b = series("b", SeriesStyle::Points, &[(2.0, 2.0)]);
    let svg = chart(Scale::Linear, vec![a, b]).to_svg(SIZE);
    assert!(svg.contains("#0072B2") && svg.contains("#D55E00"));
    assert!(svg.contains("<circle") && svg.contains("<polygon"));
}

#[test]
fn forty_series_differ_in_colour_or_shape() {
    let colors = super::super::palette::SERIES.len();
    let looks: std::collections::HashSet<_> =
        (0..40).map(|number| (number % colors, draw::shape(number))).collect();
    assert_eq!(looks.len(), 40);
}
