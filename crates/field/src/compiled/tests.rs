//! Compiled fields against what they were compiled from.

use super::*;

fn room() -> Bounds {
    Bounds::from(([-250.0, -200.0, -550.0], [250.0, 250.0, -50.0]))
}

/// A smooth field with an axis part of every even degree up to 4.
fn given(p: &Point3<f64>) -> Vec<Coefficient> {
    (0..functions(4))
        .map(|f| {
            std::array::from_fn(|c| {
                let phase = (3 * f + c) as f64;
                let size = if c < 3 { 1.0 } else { 0.01 };
                size * (p.x / 150.0 + phase).sin() * (p.y / 190.0 - p.z / 170.0 + 2.0 * phase).cos()
            })
        })
        .collect()
}

fn field(cell_mm: f64) -> CompiledField {
    CompiledField::new(room(), cell_mm, 4, |nodes| nodes.iter().map(given).collect())
}

fn places() -> impl Iterator<Item = (Vector3<f64>, Unit<Vector3<f64>>)> {
    (0..400).map(|i| {
        let t = f64::from(i);
        let unit = Vector3::new((0.37 * t).sin(), (0.73 * t).cos(), (1.1 * t).sin());
        let axis = Vector3::new((1.7 * t).cos(), (0.9 * t).sin(), (0.31 * t).cos() + 0.1);
        (unit.map(|u| 0.5 + 0.5 * u), Unit::new_normalize(axis))
    })
}

fn exact(unit: &Vector3<f64>, axis: &Vector3<f64>) -> Coefficient {
    let p = room().min_mm + room().size_mm().component_mul(unit);
    let mut by_axis = [0.0; MAX_FUNCTIONS];
    even_harmonics::values(4, axis, &mut by_axis);
    let mut sum = [0.0; 6];
    for (values, factor) in given(&p).iter().zip(by_axis) {
        for (sum, v) in sum.iter_mut().zip(values) {
            *sum += factor * v;
        }
    }
    sum
}

fn largest_difference(field: &CompiledField) -> f64 {
    places()
        .map(|(unit, axis)| {
            let (found, expected) = (field.evaluate(&unit, &axis), exact(&unit, &axis));
            (0..3).map(|c| (found[c] - expected[c]).abs()).fold(0.0, f64::max)
        })
        .fold(0.0, f64::max)
}

#[test]
fn compiled_error_falls_with_the_fourth_power() {
    let (coarse, fine) = (largest_difference(&field(60.0)), largest_difference(&field(30.0)));
    assert!(fine < 1e-3, "{fine}");
    assert!(fine < coarse / 10.0 && fine > coarse / 30.0, "{coarse} {fine}");
}

#[test]
fn at_axis_is_the_field_or_the_mean_over_axes() {
    let field = field(80.0);
    let (unit, axis) = places().nth(17).unwrap();
    let own = field.at_axis(Some(&axis));
    let mean = field.at_axis(None);
    let (expected, found) = (field.evaluate(&unit, &axis), own.evaluate(&unit, &Vector3::x_axis()));
    // The vertices of an icosahedron average degrees 2 and 4 away.
    let twelve = trackwright_geometry::directions::DirectionSet::Twelve.directions();
    for c in 0..6 {
        assert!((expected[c] - found[c]).abs() < 1e-13);
        let over = twelve.iter().map(|n| field.evaluate(&unit, n)[c]);
        let over = over.sum::<f64>() / twelve.len() as f64;
        assert!((over - mean.evaluate(&unit, &axis)[c]).abs() < 1e-12);
    }
}

#[test]
fn slopes_are_differences_within_the_bounds() {
    let field = field(70.0);
    let size_mm = room().size_mm();
    let whole = field.bounds_over([[0.0, 1.0]; 3]);
    let mut largest = [0.0_f64; 4];
    for (unit, axis) in places() {
        let at = field.evaluate_with_slopes(&unit, &axis);
        let direct = field.evaluate(&unit, &axis);
        for (whole, alone) in at.value.iter().zip(&direct) {
            assert!((whole - alone).abs() < 1e-13);
        }
        let h = 1e-6;
        for k in 0..3 {
            let step = Vector3::ith(k, h);
            let ahead = field.evaluate_with_slopes(&(unit + step), &axis).value;
            let behind = field.evaluate_with_slopes(&(unit - step), &axis).value;
            for c in 0..6 {
                let difference = (ahead[c] - behind[c]) / (2.0 * h);
                assert!((difference - at.by_unit[(c, k)]).abs() < 1e-6);
            }
        }
        let tangent = axis.cross(&Vector3::new(0.3, -0.5, 0.81)).normalize();
        let turned = |by: f64| Unit::new_normalize(axis.as_ref() + tangent * by);
        let (ahead, behind) =
            (field.evaluate(&unit, &turned(h)), field.evaluate(&unit, &turned(-h)));
        for c in 0..6 {
            let difference = (ahead[c] - behind[c]) / (2.0 * h);
            assert!((difference - (at.by_axis * tangent)[c]).abs() < 1e-6);
        }
        let norm = |m: &SMatrix<f64, 6, 3>, half: usize| {
            m.fixed_rows::<3>(half).into_owned().singular_values().max()
        };
        let mut per_mm = at.by_unit;
        for k in 0..3 {
            per_mm.column_mut(k).unscale_mut(size_mm[k]);
        }
        let found =
            [norm(&per_mm, 0), norm(&per_mm, 3), norm(&at.by_axis, 0), norm(&at.by_axis, 3)];
        for (most, found) in largest.iter_mut().zip(found) {
            *most = most.max(found);
        }
        for c in 0..3 {
            assert!(at.value[c] >= whole.least_mm[c] && at.value[c] <= whole.largest_mm[c]);
        }
    }
    let bounds = [whole.by_position[0], whole.by_position[1], whole.by_axis[0], whole.by_axis[1]];
    for (found, bound) in largest.into_iter().zip(bounds) {
        // And it is no idle bound.
        assert!(found <= bound && bound < 8.0 * found, "{found} {bound}");
    }
}

#[test]
fn a_flat_box_has_the_field_of_its_plane() {
    let flat = Bounds::from(([-250.0, 30.0, -550.0], [250.0, 30.0, -50.0]));
    let field = CompiledField::new(flat, 40.0, 4, |nodes| nodes.iter().map(given).collect());
    let p = Point3::new(10.0, 30.0, -200.0);
    let axis = Unit::new_normalize(Vector3::new(0.1, 0.5, 0.4));
    let found = field.evaluate(&flat.to_unit(&p), &axis);
    let expected = exact(&room().to_unit(&p), &axis);
    for c in 0..6 {
        assert!((found[c] - expected[c]).abs() < 1e-3);
    }
}

#[test]
fn places_of_one_cell_get_what_each_gets_alone() {
    let field = field(120.0);
    let (units, axes): (Vec<_>, Vec<_>) = places().unzip();
    let mut together = vec![[0.0; 6]; units.len()];
    field.evaluate_all(&units, &axes, &mut together);
    for ((unit, axis), found) in units.iter().zip(&axes).zip(together) {
        assert_eq!(found, field.evaluate(unit, axis));
    }
}
