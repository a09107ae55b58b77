//! The channel of a needle or a rod as a mounting region, found on its mesh.

use super::mounting::{MountingAxis, MountingRegion};
use nalgebra::Vector3;
use trackwright_geometry::surface::Surface;

/// The bore along a body's axis of revolution, or the solid's middle where it has none; its first point
/// is at the end that `long_axis` points away from. `None` where the body has no long round part.
///
/// ```
/// use nalgebra::{Point3, Vector3};
/// use trackwright_geometry::placeholder::placeholder;
/// use trackwright_geometry::surface::Surface;
/// use trackwright_simulation::{Mounting, channel_of};
///
/// // A rod of 1.5 mm from the origin along z.
/// let mesh = placeholder(&Point3::origin(), &[Point3::new(0.0, 0.0, 100.0)]);
/// let surface = Surface::new(&mesh).unwrap();
/// let region = channel_of(&surface, &mesh.long_axis()).unwrap();
/// let mounting = Mounting { regions: vec![region], ..Mounting::default() };
/// assert_eq!(mounting.check(), Ok(()));
/// ```
pub fn channel_of(surface: &Surface, long_axis: &Vector3<f64>) -> Option<MountingRegion> {
    let found = surface.axis_channel(long_axis)?;
    Some(MountingRegion::Channel {
        points_mm: vec![found.start_mm, found.end_mm],
        radius_mm: Some(found.radius_mm),
        axis: MountingAxis::Along,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{Coil, Sensor};
    use crate::coil_fit::sticks_out_mm;
    use nalgebra::Point3;
    use trackwright_geometry::mesh::{MeshPart, SurfaceMesh};
    use trackwright_geometry::solid::Solid;

    #[test]
    fn a_coil_fits_all_along_the_channel_found() {
        // 1.4 mm across with a bore of 0.9 mm.
        let outline = [[0.45, 0.0], [0.7, 0.0], [0.7, 120.0], [0.45, 120.0], [0.45, 0.0]];
        let Solid { positions_mm, normals, triangles } = Solid::turned(&outline);
        let part = MeshPart { positions_mm, normals, triangles, ..MeshPart::default() };
        let mesh = SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() };
        let surface = Surface::new(&mesh).unwrap();
        let region = channel_of(&surface, &mesh.long_axis());
        let Some(MountingRegion::Channel { points_mm, radius_mm, axis }) = region else {
            panic!("{region:?}")
        };
        assert_eq!(axis, MountingAxis::Along);
        let coil = Coil { diameter_mm: 0.8, length_mm: 9.0 };
        assert!(radius_mm.is_some_and(|radius_mm| radius_mm >= coil.diameter_mm / 2.0));
        let [start, end] = points_mm[..] else { panic!("{points_mm:?}") };
        let half = Vector3::z() * (coil.length_mm / 2.0);
        let [first, last] = [start + half, end - half];
        for part in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let place = Point3::from(first.coords.lerp(&last.coords, part));
            let mut sensor = Sensor::five_dof("a", place, Vector3::z_axis());
            sensor.coil = Some(coil);
            assert_eq!(sticks_out_mm(&sensor, &surface), None, "{place}");
        }
    }
}
