//! Pictures of sweeps: the figures in them, and any names.

use super::{
    NumberColumn, SweepColumns, effect_chart, front, main_effect, page, parallel_coordinates,
};

/// Numbers that look random, from 0 to 1.
fn noise(count: usize, seed: u64) -> Vec<f64> {
    let mut state = seed;
    let mut next = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..count).map(|_| next()).collect()
}

fn sweep(count: usize) -> SweepColumns {
    let [x, y] = [noise(count, 1), noise(count, 2)];
    let column = |name: &str, unit: &str, values: Vec<f64>| NumberColumn {
        name: name.to_owned(),
        unit: unit.to_owned(),
        values,
    };
    let error = x.iter().zip(&y).map(|(x, y)| 1.0 + 2.0 * x + 0.1 * y).collect();
    let angle = x.iter().map(|x| 2.0 - x).collect();
    SweepColumns {
        title: "a <b> & \"c\"".to_owned(),
        rows: (0..count as u64).collect(),
        parameters: vec![column("tool.x", "mm", x), column("weight", "", y)],
        figures: vec![column("position_rms", "mm", error), column("angle_rms", "deg", angle)],
    }
}

#[test]
fn the_front_has_the_rows_that_none_beats() {
    let [a, b] = [noise(300, 3), noise(300, 4)];
    let found = front(&a, &b);
    let beats = |i: usize, j: usize| a[i] <= a[j] && b[i] <= b[j] && (a[i] < a[j] || b[i] < b[j]);
    let expected: Vec<usize> = {
        let mut rows: Vec<usize> = (0..300).filter(|&j| !(0..300).any(|i| beats(i, j))).collect();
        rows.sort_by(|&i, &j| a[i].total_cmp(&a[j]));
        rows
    };
    assert_eq!(found, expected);
    assert!(found.len() > 2);
    assert_eq!(front(&[1.0, 1.0, f64::NAN], &[2.0, 2.0, 0.0]), [0]);
    assert_eq!(front(&[], &[]), Vec::<usize>::new());
}

#[test]
fn effects_are_means_with_their_intervals() {
    let number = [1.0, 1.0, 1.0, 5.0, 5.0, 9.0, f64::NAN];
    let figure = [2.0, 4.0, 6.0, 1.0, 3.0, 7.0, 100.0];
    let found = main_effect(&number, &figure);
    assert_eq!(
        found.iter().map(|e| (e.at, e.mean, e.rows)).collect::<Vec<_>>(),
        [(1.0, 4.0, 3), (5.0, 2.0, 2), (9.0, 7.0, 1)]
    );
    // Student's 0.975 quantile of two degrees of freedom is 4.303, the standard deviation is 2.
    let half = found[0].interval[1] - 4.0;
    assert!((half - 4.302_652_7 * 2.0 / 3.0_f64.sqrt()).abs() < 1e-6, "{half}");
    assert_eq!(found[2].interval, [7.0, 7.0]);
    assert!(main_effect(&[], &[]).is_empty());
}

#[test]
fn intervals_of_independent_rows_hold() {
    let count = 2400;
    let mut held = 0;
    for seed in 10..30 {
        let [x, y] = [noise(count, seed), noise(count, seed + 100)];
        let figure: Vec<f64> = y.iter().map(|y| 3.0 + y).collect();
        let effects = main_effect(&x, &figure);
        assert_eq!(effects.len(), 12);
        held += effects.iter().filter(|e| e.interval[0] <= 3.5 && 3.5 <= e.interval[1]).count();
    }
    // 240 intervals of 95 %: 228 expected, standard deviation 3.4.
    assert!((214..=240).contains(&held), "{held}");
}

#[test]
fn every_drawn_row_is_one_line_within_the_picture() {
    let sweep = sweep(400);
    let svg = parallel_coordinates(&sweep, (800, 400));
    let lines: Vec<&str> = svg.matches("stroke-width=\"1\"").collect();
    // One a row and one an axis.
    assert_eq!(lines.len(), 400 + 4);
    for points in svg.split("points=\"").skip(1) {
        for pair in points.split('"').next().unwrap().split(' ') {
            let (x, y) = pair.split_once(',').unwrap();
            let (x, y): (i32, i32) = (x.parse().unwrap(), y.parse().unwrap());
            assert!((0..=800).contains(&x) && (0..=400).contains(&y));
        }
    }
    assert!(
        svg.contains(
            "a &lt;b&gt; &amp; &quot;c&quot;: 400 of 400 rows, coloured by position_rms, mm"
        ),
        "{}",
        &svg[..600]
    );
    let many = parallel_coordinates(&super::tests::sweep(20_000), (800, 400));
    assert!(many.contains("600 of 20,000 rows"));
}

#[test]
fn a_page_has_each_picture_and_any_rows() {
    let mut sweep = sweep(50);
    let text = page(&sweep);
    assert_eq!(text.matches("<svg").count(), 1 + 2 + 1);
    assert!(!text.contains("<b>"));
    let chart = effect_chart(&sweep, &sweep.parameters[0], &sweep.figures[0]);
    assert_eq!(chart.series[1].points.len(), 2 * chart.series[0].points.len());
    for column in sweep.parameters.iter_mut().chain(&mut sweep.figures) {
        column.values.fill(f64::NAN);
    }
    assert!(page(&sweep).contains("50 of them without figures"));
    sweep.rows.clear();
    sweep.parameters.clear();
    sweep.figures.truncate(1);
    sweep.figures[0].values.clear();
    assert!(page(&sweep).contains("0 rows"));
}
