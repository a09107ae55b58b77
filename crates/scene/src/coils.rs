//! The coils of a field generator as lines: dipoles as arrows along their moments, loops as their wire.

use nalgebra::{Point3, Unit, Vector3};
use trackwright_field::generator::{Coil, Generator};
use trackwright_geometry::rotation::perpendicular;

/// Length of the strongest dipole's arrow: a third of what is between the coils of a planar
/// generator, so that arrows do not overlap.
const ARROW_MM: f64 = 40.0;

/// Of an arrow's length: its head, and how wide that is to one side.
const HEAD: f64 = 0.25;
const HEAD_WIDTH: f64 = 0.1;

/// Lines through the points of each coil, tracker frame. A dipole's arrow begins at the dipole; its length
/// is in proportion to the moment.
pub fn coil_lines(generator: &Generator) -> Vec<Vec<Point3<f64>>> {
    let moment = |coil: &Coil| match coil {
        Coil::Dipole { moment, .. } => moment.norm(),
        Coil::SquareLoop { .. } => 0.0,
    };
    let strongest = generator.coils.iter().map(moment).fold(0.0, f64::max);
    let lines = generator.coils.iter().flat_map(|coil| match coil {
        Coil::Dipole { at_mm, moment } => arrow(at_mm, &(moment * (ARROW_MM / strongest))),
        Coil::SquareLoop { .. } => coil.corners_mm().map(closed).into_iter().collect(),
    });
    lines.collect()
}

/// A shaft, and a head that is seen from every side.
fn arrow(from: &Point3<f64>, along_mm: &Vector3<f64>) -> Vec<Vec<Point3<f64>>> {
    let to = from + along_mm;
    let neck = from + along_mm * (1.0 - HEAD);
    let across = perpendicular(&Unit::new_normalize(*along_mm)).into_inner();
    let width_mm = HEAD_WIDTH * along_mm.norm();
    let across = [across, along_mm.normalize().cross(&across)].map(|side| side * width_mm);
    let heads = across.map(|side| vec![neck + side, to, neck - side]);
    [vec![*from, to]].into_iter().chain(heads).collect()
}

fn closed(corners: [Point3<f64>; 4]) -> Vec<Point3<f64>> {
    let [first, ..] = corners;
    corners.into_iter().chain([first]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dipoles_are_arrows_along_their_moments() {
        let generator = Generator::planar_nine();
        let lines = coil_lines(&generator);
        assert_eq!(lines.len(), 3 * generator.coils.len());
        for (lines, coil) in lines.chunks(3).zip(&generator.coils) {
            let Coil::Dipole { at_mm, moment } = coil else { panic!("{coil:?}") };
            let [from, to] = lines[0][..] else { panic!("{lines:?}") };
            // Unit moments: all are as long as the strongest.
            assert!((from - at_mm).norm() < 1e-9);
            assert!(((to - from) - moment * ARROW_MM).norm() < 1e-6 * ARROW_MM);
            assert!(lines[1..].iter().all(|head| head.len() == 3 && head[1] == to));
        }
    }

    #[test]
    fn loops_are_their_wire() {
        let generator = Generator::anser();
        let lines = coil_lines(&generator);
        assert_eq!(lines.len(), generator.coils.len());
        for (line, coil) in lines.iter().zip(&generator.coils) {
            let Coil::SquareLoop { center_mm, normal, side_mm } = coil else { panic!("{coil:?}") };
            assert!(line.len() == 5 && line[0] == line[4]);
            for pair in line.windows(2) {
                assert!(((pair[1] - pair[0]).norm() - side_mm).abs() < 1e-9);
                assert!((pair[0] - center_mm).dot(normal).abs() < 1e-9);
            }
        }
    }
}
