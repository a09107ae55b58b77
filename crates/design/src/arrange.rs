//! Arranging sensors: copies, mirror images, rows, and how an axis is turned.

use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};
use std::collections::HashSet;
use trackwright_geometry::number;
use trackwright_geometry::rotation::{axis_rotation, exp_vector};
use trackwright_simulation::body::{Sensor, SensorOrientation};

/// Most sensors of one row, the one it begins with included. A tracker has ports for a few dozen
/// at most; a count typed with too many zeros would take the memory.
pub const MAX_ARRAY: usize = 1000;

/// A sensor this close to a mirror plane lies on it: less than any part is made to, more than the
/// round-off of a place that was computed.
const ON_PLANE_MM: f64 = 1e-6;

/// An axis turned by less than this is the same: 1e-6 mm at the end of a part 100 mm long.
const SAME_AXIS_RAD: f64 = 1e-8;

/// Something done to sensors of one body. Lengths in millimetres, directions in the body frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arrangement {
    /// A copy of each sensor in the same place, to be moved from there.
    Duplicate,
    /// Each sensor goes to its mirror image; see [`mirrored`]. One at least must be another then.
    Mirror(MirrorPlane),
    /// Each sensor stays, and a copy goes to its mirror image; none may lie on the plane, where
    /// both would be in one place.
    MirrorCopy(MirrorPlane),
    /// Each sensor becomes the first of `count` in a row.
    Array {
        count: usize,
        /// From one to the next; below zero against the direction.
        spacing_mm: f64,
        /// Of any length.
        direction_in_body: Vector3<f64>,
    },
    /// What is left of a sensor is its position.
    MakeMarker,
    /// What is left of a 6-DOF sensor is its z axis; a marker gets the body's.
    MakeFiveDof,
    /// A 5-DOF sensor gets the rotation that it is drawn with, its axis as z; a marker is turned
    /// like the body.
    MakeSixDof,
    /// Each axis, a 6-DOF sensor's z, is turned along a direction of any length, such as a
    /// surface's normal. A 6-DOF sensor is turned no further than that takes, and a marker has
    /// none.
    Align { direction_in_body: Vector3<f64> },
}

/// A plane through a body's origin, named by the coordinate that is zero on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MirrorPlane {
    X,
    Y,
    Z,
}

/// Why sensors could not be arranged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ArrangeError {
    #[error("there is no sensor {index}, the body has {count}")]
    NoSuchSensor { index: usize, count: usize },
    #[error("the row has {count} sensors, expected 2 to {MAX_ARRAY}")]
    ArrayCount { count: usize },
    #[error("the spacing is {spacing_mm} mm, expected a finite number other than zero")]
    Spacing { spacing_mm: f64 },
    #[error("the direction is ({}, {}, {}), expected one with a length", direction.x, direction.y, direction.z)]
    NoDirection { direction: Vector3<f64> },
    #[error(
        "sensor {name} lies on the plane {plane}: its mirror copy would be in the same place, so \
         nothing was copied"
    )]
    OnMirrorPlane { name: String, plane: MirrorPlane },
    #[error("sensor {name} is its own mirror image in the plane {plane}, so nothing was changed")]
    OwnImage { name: String, plane: MirrorPlane },
    #[error(
        "each of the {count} sensors is its own mirror image in the plane {plane}, so nothing was changed"
    )]
    OwnImages { count: usize, plane: MirrorPlane },
}

impl MirrorPlane {
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// The coordinate that changes its sign.
    fn index(self) -> usize {
        self as usize
    }
}

impl std::fmt::Display for MirrorPlane {
    /// `x = 0`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(["x = 0", "y = 0", "z = 0"][self.index()])
    }
}

impl Arrangement {
    /// All sensors of a body after this was done to some of them: changed ones stay at their
    /// places in the list, new ones follow at its end, each with a name of its own.
    ///
    /// `indices` is a set; its order and repetitions mean nothing.
    ///
    /// # Errors
    /// See [`ArrangeError`].
    pub fn arranged(
        &self,
        sensors: &[Sensor],
        indices: &[usize],
    ) -> Result<Vec<Sensor>, ArrangeError> {
        let mut arranged = sensors.to_vec();
        let mut names: HashSet<String> = sensors.iter().map(|s| s.name.clone()).collect();
        let indices = as_set(indices);
        for &index in &indices {
            let count = sensors.len();
            let sensor = sensors.get(index).ok_or(ArrangeError::NoSuchSensor { index, count })?;
            match self {
                Self::Duplicate => arranged.push(sensor.clone()),
                Self::Mirror(plane) => arranged[index] = mirrored(sensor, *plane),
                Self::MirrorCopy(plane) => {
                    if sensor.position_in_body[plane.index()].abs() <= ON_PLANE_MM {
                        let name = sensor.name.clone();
                        return Err(ArrangeError::OnMirrorPlane { name, plane: *plane });
                    }
                    arranged.push(mirrored(sensor, *plane));
                }
                Self::Array { count, spacing_mm, direction_in_body } => {
                    arranged.extend(row(sensor, *count, *spacing_mm, direction_in_body)?);
                }
                Self::MakeMarker => arranged[index] = as_marker(sensor),
                Self::MakeFiveDof => arranged[index].orientation = five_dof(&sensor.orientation),
                Self::MakeSixDof => arranged[index].orientation = six_dof(&sensor.orientation),
                Self::Align { direction_in_body } => {
                    let axis = direction(direction_in_body)?;
                    arranged[index].orientation = aligned(&sensor.orientation, axis);
                }
            }
        }
        if let Self::Mirror(plane) = *self
            && indices.iter().all(|&index| is_same(&sensors[index], &arranged[index]))
        {
            match indices[..] {
                [] => {}
                [only] => {
                    let name = sensors[only].name.clone();
                    return Err(ArrangeError::OwnImage { name, plane });
                }
                _ => return Err(ArrangeError::OwnImages { count: indices.len(), plane }),
            }
        }
        for sensor in &mut arranged[sensors.len()..] {
            sensor.name = fresh_name(&sensor.name, &names);
            names.insert(sensor.name.clone());
        }
        Ok(arranged)
    }

    /// What undo calls it; `name` is the sensor's where it is a single one of `sensors`.
    pub(super) fn label(&self, sensors: usize, name: Option<&str>) -> String {
        let whom = match name {
            Some(name) if sensors == 1 => format!("sensor {name}"),
            _ if sensors == 1 => "sensor".to_owned(),
            _ => format!("{sensors} sensors"),
        };
        match self {
            Self::Duplicate => format!("Duplicate {whom}"),
            Self::Mirror(_) => format!("Mirror {whom}"),
            Self::MirrorCopy(_) => format!("Mirror copy of {whom}"),
            Self::Array { count, .. } => {
                format!("Array of {} sensors", count.saturating_mul(sensors))
            }
            Self::MakeMarker if sensors == 1 => format!("Make {whom} a marker"),
            Self::MakeMarker => format!("Make {whom} markers"),
            Self::MakeFiveDof => format!("Make {whom} 5-DOF"),
            Self::MakeSixDof => format!("Make {whom} 6-DOF"),
            Self::Align { .. } => format!("Align {whom}"),
        }
    }
}

/// Indices in order, each once.
pub(super) fn as_set(indices: &[usize]) -> Vec<usize> {
    let mut set = indices.to_vec();
    set.sort_unstable();
    set.dedup();
    set
}

/// `shaft 2`, or the first number that is free; a number that the name ends in is counted on
/// from its beginning, so that a copy of `shaft 2` is no `shaft 2 2`.
///
/// ```
/// let taken = ["shaft 2".to_owned()].into();
/// assert_eq!(trackwright_design::fresh_name("shaft 2", &taken), "shaft 3");
/// ```
pub fn fresh_name(name: &str, taken: &HashSet<String>) -> String {
    let stem = match name.rsplit_once(' ') {
        Some((stem, number))
            if !stem.trim().is_empty()
                && !number.is_empty()
                && number.bytes().all(|b| b.is_ascii_digit()) =>
        {
            stem
        }
        _ => name,
    };
    let mut number = 2_u64;
    loop {
        let fresh = format!("{stem} {number}");
        if !taken.contains(&fresh) {
            return fresh;
        }
        number += 1;
    }
}

/// A sensor's mirror image in a plane of its body.
///
/// The position and the 5-DOF axis are mirrored as an arrow drawn on the part is: the end of the
/// coil that its axis points to goes to the mirror image of that place, `n' = M n`. (A coil's
/// magnetic moment is an axial vector and would turn into `-M n`; but the axis states how a part is
/// put in, and the part that is put in on the other side is the same, not one wound the other way.)
///
/// A rotation mirrored as it is, `M R`, would be left-handed. x and z are mirrored as arrows and y
/// follows from them, `R' = M R diag(1, -1, 1)`: z, because it is the axis that is left when the
/// sensor is made 5-DOF, and x, because the two coils of an Aurora 6-DOF sensor lie in its x-z
/// plane, so that each goes to its own mirror image. As `M = -Rot(e_k, π)`, that is
/// `q' = e_k q e_y` in quaternions: components change place and sign, and nothing is rounded.
/// Mirrored twice is as before, to the bit.
pub fn mirrored(sensor: &Sensor, plane: MirrorPlane) -> Sensor {
    let mut image = sensor.clone();
    let k = plane.index();
    image.position_in_body[k] = minus(image.position_in_body[k]);
    image.orientation = match &sensor.orientation {
        SensorOrientation::Marker => SensorOrientation::Marker,
        SensorOrientation::FiveDof(axis) => {
            let mut axis = axis.into_inner();
            axis[k] = minus(axis[k]);
            SensorOrientation::FiveDof(Unit::new_unchecked(axis))
        }
        SensorOrientation::SixDof(rotation) => {
            let (w, i, j, k) = (rotation.w, rotation.i, rotation.j, rotation.k);
            SensorOrientation::SixDof(Unit::new_unchecked(match plane {
                MirrorPlane::X => Quaternion::new(k, minus(j), minus(i), w),
                MirrorPlane::Y => Quaternion::new(minus(w), i, minus(j), k),
                MirrorPlane::Z => Quaternion::new(minus(i), minus(w), minus(k), minus(j)),
            }))
        }
    };
    image
}

/// Whether a sensor and its mirror image are in one place and point the same way.
fn is_same(sensor: &Sensor, image: &Sensor) -> bool {
    let moved_mm = (image.position_in_body - sensor.position_in_body).norm();
    let is_turned = match (&sensor.orientation, &image.orientation) {
        (SensorOrientation::FiveDof(before), SensorOrientation::FiveDof(after)) => {
            (after.into_inner() - before.into_inner()).norm() > SAME_AXIS_RAD
        }
        // A quaternion and its negative are one rotation. Half the angle is compared, by its sine.
        (SensorOrientation::SixDof(before), SensorOrientation::SixDof(after)) => {
            (before.inverse() * after).imag().norm() > SAME_AXIS_RAD / 2.0
        }
        _ => false,
    };
    // An image is twice as far from its sensor as the plane.
    moved_mm <= 2.0 * ON_PLANE_MM && !is_turned
}

/// The negative, and zero for zero: nobody wants to read `-0` in a file.
fn minus(value: f64) -> f64 {
    0.0 - value
}

/// The others of a row that begins with `first`. Each is placed from the first, so that rounding
/// does not add up along the row.
fn row(
    first: &Sensor,
    count: usize,
    spacing_mm: f64,
    direction_in_body: &Vector3<f64>,
) -> Result<impl Iterator<Item = Sensor>, ArrangeError> {
    if !(2..=MAX_ARRAY).contains(&count) {
        return Err(ArrangeError::ArrayCount { count });
    }
    if spacing_mm == 0.0 || !spacing_mm.is_finite() {
        return Err(ArrangeError::Spacing { spacing_mm });
    }
    let direction = direction(direction_in_body)?;
    Ok((1..count).map(move |k| {
        let mut sensor = first.clone();
        sensor.position_in_body += *direction * (k as f64 * spacing_mm);
        sensor
    }))
}

fn direction(vector: &Vector3<f64>) -> Result<Unit<Vector3<f64>>, ArrangeError> {
    number::direction((*vector).into()).ok_or(ArrangeError::NoDirection { direction: *vector })
}

/// A marker has no coil.
fn as_marker(sensor: &Sensor) -> Sensor {
    Sensor { orientation: SensorOrientation::Marker, coil: None, ..sensor.clone() }
}

fn five_dof(orientation: &SensorOrientation) -> SensorOrientation {
    SensorOrientation::FiveDof(match orientation {
        SensorOrientation::Marker => Vector3::z_axis(),
        SensorOrientation::FiveDof(axis) => *axis,
        SensorOrientation::SixDof(rotation) => Unit::new_normalize(rotation * Vector3::z()),
    })
}

fn six_dof(orientation: &SensorOrientation) -> SensorOrientation {
    match orientation {
        SensorOrientation::Marker => SensorOrientation::SixDof(orientation.any_rotation()),
        SensorOrientation::SixDof(_) => *orientation,
        SensorOrientation::FiveDof(axis) => {
            // The frame that is drawn finds small angles by their cosine, good to 1e-8 rad. The
            // rest of the way to the axis is made up for.
            let drawn = SensorOrientation::SixDof(orientation.any_rotation());
            aligned(&drawn, *axis)
        }
    }
}

/// The orientation turned the shortest way until its axis is the given one; a marker stays one.
fn aligned(orientation: &SensorOrientation, axis: Unit<Vector3<f64>>) -> SensorOrientation {
    match orientation {
        SensorOrientation::Marker => SensorOrientation::Marker,
        SensorOrientation::FiveDof(_) => SensorOrientation::FiveDof(axis),
        SensorOrientation::SixDof(rotation) => {
            let own = rotation * Vector3::z_axis();
            let turn = exp_vector(&axis_rotation(&own, &axis).vector_rad);
            let turned = (turn * rotation).into_inner();
            SensorOrientation::SixDof(UnitQuaternion::new_normalize(turned))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Point3};
    use proptest::prelude::*;

    /// Of rotating a unit vector by a unit quaternion: some ten roundings.
    const ROUND_OFF: f64 = 16.0 * f64::EPSILON;

    fn sensor(name: &str, position: [f64; 3], orientation: SensorOrientation) -> Sensor {
        Sensor::new(name, position, orientation)
    }

    fn along_z(name: &str) -> Sensor {
        let axis = SensorOrientation::FiveDof(Vector3::z_axis());
        sensor(name, [1.0, 2.0, 3.0], axis)
    }

    fn any_sensor() -> impl Strategy<Value = Sensor> {
        let position = prop::array::uniform3(-500.0..500.0_f64);
        let turn = prop::array::uniform4(-1.0..1.0_f64);
        (any::<bool>(), position, turn).prop_filter_map("no turn", |(is_six, position, turn)| {
            let rotation = number::rotation(turn)?;
            let orientation = SensorOrientation::SixDof(rotation);
            let orientation = if is_six { orientation } else { five_dof(&orientation) };
            Some(sensor("a", position, orientation))
        })
    }

    fn plane() -> impl Strategy<Value = MirrorPlane> {
        prop::sample::select(&MirrorPlane::ALL[..])
    }

    fn mirror_matrix(plane: MirrorPlane) -> Matrix3<f64> {
        let mut matrix = Matrix3::identity();
        matrix[(plane as usize, plane as usize)] = -1.0;
        matrix
    }

    fn names(sensors: &[Sensor]) -> Vec<&str> {
        sensors.iter().map(|s| s.name.as_str()).collect()
    }

    proptest! {
        #[test]
        fn mirroring_twice_is_exact(s in any_sensor(), p in plane()) {
            prop_assert_eq!(mirrored(&mirrored(&s, p), p), s);
        }

        #[test]
        fn x_and_z_are_mirrored_as_arrows(
            s in any_sensor(),
            p in plane(),
        ) {
            let image = mirrored(&s, p);
            let mirror = mirror_matrix(p);
            prop_assert_eq!(image.position_in_body.coords, mirror * s.position_in_body.coords);
            let z = image.axis_in_body().unwrap().into_inner()
                - mirror * s.axis_in_body().unwrap().into_inner();
            prop_assert!(z.norm() <= ROUND_OFF, "{}", z);
            if let (SensorOrientation::SixDof(before), SensorOrientation::SixDof(after)) =
                (&s.orientation, &image.orientation)
            {
                let expected = mirror
                    * before.to_rotation_matrix().matrix()
                    * mirror_matrix(MirrorPlane::Y);
                let difference = after.to_rotation_matrix().into_inner() - expected;
                prop_assert!(difference.norm() <= ROUND_OFF, "{}", difference);
            }
        }

        #[test]
        fn mirroring_and_reducing_to_5_dof_commute(
            s in any_sensor(),
            p in plane(),
        ) {
            let reduced = |s: &Sensor| five_dof(&s.orientation).axis().unwrap();
            let mut first_reduced = s.clone();
            first_reduced.orientation = five_dof(&s.orientation);
            let gap = reduced(&mirrored(&s, p)).into_inner()
                - reduced(&mirrored(&first_reduced, p)).into_inner();
            prop_assert!(gap.norm() <= ROUND_OFF);
        }

        #[test]
        fn an_axis_survives_6_dof_and_back(
            s in any_sensor(),
            // Close to z and to -z, where angles found by their cosine are lost.
            squeeze in prop::sample::select(vec![1.0, 1e-4, 1e-8, 0.0]),
        ) {
            let own = s.axis_in_body().unwrap();
            let axis = own.into_inner().component_mul(&Vector3::new(squeeze, squeeze, 1.0));
            prop_assume!(axis.z.abs() > 1e-3);
            let five = SensorOrientation::FiveDof(Unit::new_normalize(axis));
            let six = six_dof(&five);
            prop_assert_eq!(six.degrees_of_freedom(), 6);
            let gap = five_dof(&six).axis().unwrap().into_inner()
                - five.axis().unwrap().into_inner();
            prop_assert!(gap.norm() <= ROUND_OFF, "{}", gap);
        }

        #[test]
        fn aligning_turns_no_more_than_needed(
            s in any_sensor(),
            direction in prop::array::uniform3(-9.0..9.0_f64),
        ) {
            prop_assume!(Vector3::from(direction).norm() > 1e-3);
            let align = Arrangement::Align { direction_in_body: direction.into() };
            let after = &align.arranged(std::slice::from_ref(&s), &[0]).unwrap()[0];
            let wanted = Vector3::from(direction).normalize();
            let gap = after.axis_in_body().unwrap().into_inner() - wanted;
            prop_assert!(gap.norm() <= ROUND_OFF, "{}", gap);
            if let (SensorOrientation::SixDof(a), SensorOrientation::SixDof(b)) =
                (&s.orientation, &after.orientation)
            {
                let needed = s.axis_in_body().unwrap().angle(&wanted);
                // An angle by its cosine is good to the root of round-off.
                prop_assert!((a.angle_to(b) - needed).abs() <= 1e-7);
            }
        }
    }

    #[test]
    fn copies_get_the_first_free_number() {
        let sensors = [along_z("shaft"), along_z("shaft 3"), along_z("tip")];
        let copies = Arrangement::Duplicate.arranged(&sensors, &[1, 0, 1, 2]).unwrap();
        assert_eq!(
            names(&copies[3..]),
            ["shaft 2", "shaft 4", "tip 2"],
            "a set, in the order of the body"
        );
        assert_eq!(copies[3].position_in_body, sensors[0].position_in_body);
        let taken = HashSet::new();
        assert_eq!(fresh_name("coil 99999999999999999999999", &taken), "coil 2");
        assert_eq!(fresh_name(" 7", &taken), " 7 2");
        assert_eq!(fresh_name("a ", &taken), "a  2");
    }

    #[test]
    fn no_sensor_is_copied_onto_itself() {
        let copy = Arrangement::MirrorCopy(MirrorPlane::X);
        let beside = along_z("beside");
        for x in [0.0, -0.0, 1e-12] {
            let mut on_plane = along_z("top");
            on_plane.position_in_body.x = x;
            let error = copy.arranged(&[beside.clone(), on_plane], &[0, 1]).unwrap_err();
            assert_eq!(
                error.to_string(),
                "sensor top lies on the plane x = 0: its mirror copy would be in the same place, so \
                 nothing was copied"
            );
        }
        assert_eq!(names(&copy.arranged(&[beside], &[0]).unwrap()), ["beside", "beside 2"]);
    }

    #[test]
    fn a_mirror_image_of_the_same_sensor_is_refused() {
        use SensorOrientation::{FiveDof, Marker, SixDof};
        let mirror = Arrangement::Mirror(MirrorPlane::X);
        let turn = |axis: Unit<Vector3<f64>>, angle_rad| {
            SixDof(UnitQuaternion::from_axis_angle(&axis, angle_rad))
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        // x and z are mirrored as arrows: only a frame with its y axis normal to the plane, where both
        // lie in it, is as before.
        let y_is_normal = turn(Vector3::z_axis(), quarter);
        let in_plane = Unit::new_normalize(Vector3::new(0.0, 3.0, -4.0));
        let nearly = Unit::new_normalize(Vector3::new(1e-12, 3.0, -4.0));
        let oblique = Unit::new_normalize(Vector3::new(1e-3, 3.0, -4.0));
        for (x_mm, orientation, is_changed) in [
            (0.0, Marker, false),
            (-0.0, FiveDof(in_plane), false),
            (1e-12, FiveDof(nearly), false),
            (0.0, y_is_normal, false),
            (0.0, turn(Vector3::z_axis(), -quarter), false),
            (1e-3, Marker, true),
            (1e-3, FiveDof(in_plane), true),
            (0.0, FiveDof(oblique), true),
            // It points the other way then.
            (0.0, FiveDof(Vector3::x_axis()), true),
            (0.0, turn(Vector3::x_axis(), quarter), true),
            (0.0, turn(Vector3::y_axis(), quarter), true),
            (1e-3, y_is_normal, true),
        ] {
            let top = sensor("top", [x_mm, 2.0, 3.0], orientation);
            let found = mirror.arranged(std::slice::from_ref(&top), &[0]);
            assert_eq!(found.is_ok(), is_changed, "{top:?}: {found:?}");
        }
    }

    #[test]
    fn mirroring_is_refused_only_where_none_changes() {
        let mirror = Arrangement::Mirror(MirrorPlane::Y);
        let at = |name: &str, y_mm: f64| {
            let mut sensor = along_z(name);
            sensor.position_in_body.y = y_mm;
            sensor
        };
        let sensors = [at("left", 0.0), at("right", 0.0), at("top", 5.0)];
        for (indices, expected) in [
            (
                &[1, 1][..],
                Err(
                    "sensor right is its own mirror image in the plane y = 0, so nothing was changed",
                ),
            ),
            (
                &[0, 1],
                Err(
                    "each of the 2 sensors is its own mirror image in the plane y = 0, so nothing \
                     was changed",
                ),
            ),
            (&[0, 1, 2], Ok(-5.0)),
        ] {
            let found = mirror.arranged(&sensors, indices);
            let top_y_mm = found.map(|sensors| sensors[2].position_in_body.y);
            let top_y_mm = top_y_mm.map_err(|error| error.to_string());
            assert_eq!(top_y_mm, expected.map_err(str::to_owned));
        }
    }

    #[test]
    fn a_row_is_evenly_spaced_from_its_first_sensor() {
        let row = Arrangement::Array {
            count: 4,
            spacing_mm: -2.5,
            direction_in_body: Vector3::new(0.0, 3.0, 0.0),
        };
        let sensors = row.arranged(&[along_z("shaft")], &[0]).unwrap();
        assert_eq!(names(&sensors), ["shaft", "shaft 2", "shaft 3", "shaft 4"]);
        let places: Vec<_> = sensors.iter().map(|s| s.position_in_body).collect();
        let expected = [2.0, -0.5, -3.0, -5.5].map(|y| Point3::new(1.0, y, 3.0));
        assert_eq!(places, expected);
    }

    #[test]
    fn impossible_rows_and_directions_are_refused() {
        let array = |count, spacing_mm, x| Arrangement::Array {
            count,
            spacing_mm,
            direction_in_body: Vector3::new(x, 0.0, 0.0),
        };
        let align = |x| Arrangement::Align { direction_in_body: Vector3::new(x, 0.0, 0.0) };
        for (arrangement, index, message) in [
            (array(1, 1.0, 1.0), 0, "the row has 1 sensors, expected 2 to 1000"),
            (
                array(usize::MAX, 1.0, 1.0),
                0,
                "the row has 18446744073709551615 sensors, expected 2 to 1000",
            ),
            (
                array(2, 0.0, 1.0),
                0,
                "the spacing is 0 mm, expected a finite number other than zero",
            ),
            (
                array(2, f64::NAN, 1.0),
                0,
                "the spacing is NaN mm, expected a finite number other than zero",
            ),
            (align(0.0), 0, "the direction is (0, 0, 0), expected one with a length"),
            (align(f64::INFINITY), 0, "the direction is (inf, 0, 0), expected one with a length"),
            (Arrangement::Duplicate, 1, "there is no sensor 1, the body has 1"),
        ] {
            let error = arrangement.arranged(&[along_z("a")], &[index]).unwrap_err();
            assert_eq!(error.to_string(), message);
        }
        // A direction too long to be squared is one still.
        assert!(align(1e300).arranged(&[along_z("a")], &[0]).is_ok());
    }
}
