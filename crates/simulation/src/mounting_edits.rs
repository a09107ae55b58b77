//! What a person does to mounting regions: brush strokes, drawn channels, seats, axis rules.

use super::body::Sensor;
use super::mounting::{BoxPlace, Mounting, MountingAxis, MountingRegion, RegionKind};
use nalgebra::{Point3, Unit, Vector3};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::box_union::{add_box, remove_box};
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::pose::MIN_NORM;
use trackwright_geometry::surface::{Surface, SurfacePoint};

/// Edge of a forbidden box before it has a size of its own.
const NEW_BOX_MM: f64 = 10.0;

/// A patch with more boxes was painted: handles on all of them would hide it.
const FEW_BOXES: usize = 3;

impl Mounting {
    /// The patch that a brush adds to: the chosen one, else the last; `None` where there is none.
    pub fn patch_to_paint(&self, chosen: Option<usize>) -> Option<usize> {
        let patches = self.regions.iter().enumerate();
        let mut patches = patches
            .filter(|(_, own)| matches!(own, MountingRegion::Surface { .. }))
            .map(|(index, _)| index);
        let last = patches.clone().next_back();
        patches.find(|index| Some(*index) == chosen).or(last)
    }

    /// Adds boxes to a patch, which is a new one where the region is no patch. The region's number.
    ///
    /// A patch without boxes is the whole surface: its first box makes it a part.
    ///
    /// ```
    /// use nalgebra::Point3;
    /// use trackwright_geometry::box_union::stroke;
    /// use trackwright_simulation::Mounting;
    ///
    /// let mut mounting = Mounting::default();
    /// let at = Point3::origin();
    /// let patch = mounting.paint(None, stroke(&at, &at, 5.0));
    /// // Again over the same place.
    /// assert_eq!(mounting.paint(Some(patch), stroke(&at, &at, 5.0)), patch);
    /// assert_eq!((mounting.regions.len(), mounting.check()), (1, Ok(())));
    /// ```
    pub fn paint(
        &mut self,
        region: Option<usize>,
        cubes: impl IntoIterator<Item = Bounds>,
    ) -> usize {
        let is_patch = |index: &usize| {
            matches!(self.regions.get(*index), Some(MountingRegion::Surface { .. }))
        };
        let index = region.filter(is_patch).unwrap_or(self.regions.len());
        if index == self.regions.len() {
            self.regions.push(MountingRegion::whole_surface());
        }
        if let MountingRegion::Surface { boxes, .. } = &mut self.regions[index] {
            cubes.into_iter().for_each(|cube| add_box(boxes, cube));
        }
        index
    }

    /// Takes boxes out of a patch. One without boxes, the whole surface, becomes the rest of `whole`,
    /// a box around the body; so does a body without regions. The patch's number; `None` where there
    /// is none, or where nothing is left of it and it is removed.
    ///
    /// ```
    /// use nalgebra::Point3;
    /// use trackwright_geometry::bounds::Bounds;
    /// use trackwright_geometry::box_union::stroke;
    /// use trackwright_simulation::Mounting;
    ///
    /// let mut mounting = Mounting::default();
    /// let (at, whole) = (Point3::origin(), Bounds::from(([-9.0; 3], [9.0; 3])));
    /// assert_eq!(mounting.erase(None, stroke(&at, &at, 5.0), &whole), Some(0));
    /// assert_eq!(mounting.check(), Ok(()));
    /// ```
    pub fn erase(
        &mut self,
        region: Option<usize>,
        cubes: impl IntoIterator<Item = Bounds>,
        whole: &Bounds,
    ) -> Option<usize> {
        if self.regions.is_empty() {
            self.regions.push(MountingRegion::whole_surface());
        }
        let index = self.patch_to_paint(region)?;
        let MountingRegion::Surface { boxes, .. } = &mut self.regions[index] else {
            return None;
        };
        if boxes.is_empty() {
            boxes.push(*whole);
        }
        // What a stroke covers is fewer boxes than it has cubes.
        let mut covered = Vec::new();
        cubes.into_iter().for_each(|cube| add_box(&mut covered, cube));
        covered.iter().for_each(|removed| remove_box(boxes, removed));
        if boxes.is_empty() {
            // Without boxes it would be the whole surface.
            self.regions.remove(index);
            return None;
        }
        Some(index)
    }

    /// Boxes whose faces are dragged: the forbidden ones, and those of patches that have few.
    pub fn boxes_to_drag(&self) -> impl Iterator<Item = (BoxPlace, &Bounds)> {
        let patches = self.regions.iter().enumerate().flat_map(|(region, own)| {
            let boxes: &[Bounds] = match own {
                MountingRegion::Surface { boxes, .. } if boxes.len() <= FEW_BOXES => boxes,
                _ => &[],
            };
            let place = move |index| BoxPlace::Surface { region, index };
            boxes.iter().enumerate().map(move |(index, own)| (place(index), own))
        });
        let keep_out = self.keep_out.iter().enumerate();
        patches.chain(keep_out.map(|(index, own)| (BoxPlace::KeepOut { index }, own)))
    }
}

impl MountingRegion {
    /// All of the body's surface, axes as they are: what counts where nothing is stated.
    pub fn whole_surface() -> Self {
        Self::Surface { axis: MountingAxis::default(), boxes: Vec::new() }
    }

    /// A channel through points, of unknown radius; `None` with fewer than two that differ.
    pub fn channel(points_mm: &[Point3<f64>]) -> Option<Self> {
        let mut points_mm = points_mm.to_vec();
        points_mm.dedup_by(|next, last| (*next - *last).norm() <= MIN_NORM);
        let axis = MountingAxis::Along;
        (points_mm.len() >= 2).then_some(Self::Channel { points_mm, radius_mm: None, axis })
    }

    /// The place of a sensor with its axis, where it has one.
    pub fn seat_of(sensor: &Sensor) -> Self {
        Self::Seat { position_mm: sensor.position_in_body, axis: sensor.axis_in_body() }
    }

    /// The kind of a region in which an axis may follow the place; `None` for a seat.
    pub fn kind(&self) -> Option<RegionKind> {
        match self {
            Self::Surface { .. } => Some(RegionKind::Surface),
            Self::Channel { .. } => Some(RegionKind::Channel),
            Self::Seat { .. } => None,
        }
    }

    /// How a sensor may be turned; `None` for a seat, which has one axis.
    pub fn axis(&self) -> Option<MountingAxis> {
        match self {
            Self::Surface { axis, .. } | Self::Channel { axis, .. } => Some(*axis),
            Self::Seat { .. } => None,
        }
    }

    /// The same with another axis rule; a seat has none.
    #[must_use]
    pub fn with_axis(&self, rule: MountingAxis) -> Self {
        let mut region = self.clone();
        if let Self::Surface { axis, .. } | Self::Channel { axis, .. } = &mut region {
            *axis = rule;
        }
        region
    }

    /// How long a channel is along its middle line; zero for what is none.
    pub fn channel_length_mm(&self) -> f64 {
        match self {
            Self::Channel { points_mm, .. } => {
                points_mm.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
            }
            _ => 0.0,
        }
    }
}

/// A point of a channel below a point of the surface: in the middle of the body, or of its bore.
pub fn channel_point(
    surface: &Surface,
    at: &SurfacePoint,
    long_axis: &Vector3<f64>,
) -> Option<Point3<f64>> {
    let axis = Unit::try_new(*long_axis, MIN_NORM).unwrap_or_else(Vector3::z_axis);
    surface.middle_below(at, &axis)
}

/// A forbidden box in the middle of a body, to be given its place and size; about the origin of one
/// without a mesh.
pub fn new_forbidden_box(mesh: Option<&SurfaceMesh>) -> Bounds {
    let bounds = mesh.and_then(SurfaceMesh::body_bounds);
    let middle = bounds.map_or_else(Point3::origin, |bounds| bounds.center_mm());
    let half = Vector3::repeat(NEW_BOX_MM / 2.0);
    Bounds { min_mm: middle - half, max_mm: middle + half }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_geometry::box_union::stroke;
    use trackwright_geometry::placeholder::placeholder;

    fn cubes(x_mm: f64) -> impl Iterator<Item = Bounds> {
        let at = Point3::new(x_mm, 0.0, 0.0);
        stroke(&at, &at, 2.0)
    }

    #[test]
    fn paint_goes_to_the_patch_it_names() {
        let channel = MountingRegion::channel(&[Point3::origin(), Point3::new(0.0, 0.0, 9.0)]);
        let regions = vec![channel.unwrap(), MountingRegion::whole_surface()];
        let before = Mounting { regions, ..Mounting::default() };
        for (region, expected) in [(Some(1), 1), (Some(0), 2), (Some(7), 2), (None, 2)] {
            let mut mounting = before.clone();
            assert_eq!(mounting.paint(region, cubes(0.0).chain(cubes(50.0))), expected);
            let MountingRegion::Surface { boxes, .. } = &mounting.regions[expected] else {
                panic!("{mounting:?}")
            };
            assert_eq!((boxes.len(), mounting.check()), (2, Ok(())));
            assert_eq!(mounting.regions[0], before.regions[0]);
        }
    }

    #[test]
    fn an_eraser_takes_out_what_it_covers() {
        let whole = Bounds::from(([-9.0; 3], [9.0; 3]));
        let boxes = |mounting: &Mounting, region: usize| match &mounting.regions[region] {
            MountingRegion::Surface { boxes, .. } => boxes.clone(),
            other => panic!("{other:?}"),
        };
        let has = |boxes: &[Bounds], x: f64| {
            boxes.iter().any(|own| own.contains(&Point3::new(x, 0.0, 0.0)))
        };
        // Nothing stated, and the whole surface as a patch.
        let stated = vec![MountingRegion::whole_surface().with_axis(MountingAxis::Normal)];
        for regions in [Vec::new(), stated] {
            let axis = regions.first().and_then(MountingRegion::axis).unwrap_or_default();
            let mut mounting = Mounting { regions, ..Mounting::default() };
            assert_eq!(mounting.erase(None, cubes(4.0), &whole), Some(0));
            let left = boxes(&mounting, 0);
            assert!(!has(&left, 4.0) && !has(&left, 4.9) && has(&left, 5.1) && has(&left, 2.9));
            assert_eq!((mounting.regions[0].axis(), mounting.check()), (Some(axis), Ok(())));
        }
        // A painted patch: a part of it, then the rest.
        let mut mounting = Mounting::default();
        let seat = MountingRegion::Seat { position_mm: Point3::origin(), axis: None };
        mounting.regions.push(seat.clone());
        assert_eq!(mounting.paint(None, cubes(0.0).chain(cubes(6.0))), 1);
        assert_eq!(mounting.erase(Some(1), cubes(6.0), &whole), Some(1));
        let left = boxes(&mounting, 1);
        assert!(has(&left, 0.9) && !has(&left, 6.0));
        assert_eq!(mounting.erase(Some(1), cubes(0.0), &whole), None);
        assert_eq!(mounting.regions, std::slice::from_ref(&seat));
        // A seat is nothing that a brush paints.
        assert_eq!(mounting.erase(Some(0), cubes(0.0), &whole), None);
        assert_eq!(mounting.regions, [seat]);
    }

    #[test]
    fn boxes_are_dragged_where_they_are_few() {
        let boxes: Vec<Bounds> =
            [0.0, 10.0, 20.0, 30.0].into_iter().filter_map(|x| cubes(x).next()).collect();
        let patch = |boxes: &[Bounds]| MountingRegion::Surface {
            axis: MountingAxis::Normal,
            boxes: boxes.to_vec(),
        };
        let regions = vec![patch(&boxes), MountingRegion::whole_surface(), patch(&boxes[..1])];
        let mut mounting =
            Mounting { regions, keep_out: boxes[2..].to_vec(), ..Mounting::default() };
        let found: Vec<(BoxPlace, Bounds)> =
            mounting.boxes_to_drag().map(|(place, own)| (place, *own)).collect();
        let expected = [
            (BoxPlace::Surface { region: 2, index: 0 }, boxes[0]),
            (BoxPlace::KeepOut { index: 0 }, boxes[2]),
            (BoxPlace::KeepOut { index: 1 }, boxes[3]),
        ];
        assert_eq!(found, expected);
        for (place, own) in expected {
            assert_eq!(mounting.stated_box(place), Some(&own));
            assert_eq!(mounting.stated_box_mut(place), Some(&mut own.clone()));
        }
        let none = BoxPlace::Surface { region: 1, index: 0 };
        assert_eq!(mounting.stated_box(none), None);
        assert_eq!(mounting.stated_box_mut(none), None);
    }

    #[test]
    fn a_brush_paints_the_chosen_patch_or_the_last() {
        let seat = MountingRegion::Seat { position_mm: Point3::origin(), axis: None };
        let patch = MountingRegion::whole_surface;
        let regions = vec![patch(), seat.clone(), patch(), seat];
        let mounting = Mounting { regions, ..Mounting::default() };
        for (chosen, expected) in
            [(Some(0), 0), (Some(1), 2), (Some(2), 2), (Some(9), 2), (None, 2)]
        {
            assert_eq!(mounting.patch_to_paint(chosen), Some(expected), "{chosen:?}");
        }
        assert_eq!(Mounting::default().patch_to_paint(Some(0)), None);
    }

    #[test]
    fn a_channel_needs_two_places() {
        let [a, b] = [Point3::origin(), Point3::new(3.0, 4.0, 0.0)];
        for none in [vec![], vec![a], vec![a, a]] {
            assert_eq!(MountingRegion::channel(&none), None);
        }
        let channel = MountingRegion::channel(&[a, b, b]).unwrap();
        assert_eq!(channel.channel_length_mm(), 5.0);
        let mounting = Mounting { regions: vec![channel], ..Mounting::default() };
        assert_eq!(mounting.check(), Ok(()));
    }

    #[test]
    fn every_kind_takes_the_axes_it_lists() {
        let whole = MountingRegion::whole_surface();
        let channel = MountingRegion::channel(&[Point3::origin(), Point3::new(0.0, 0.0, 9.0)]);
        for region in [whole, channel.unwrap()] {
            for rule in region.kind().unwrap().axes() {
                let with = region.with_axis(*rule);
                assert_eq!(with.axis(), Some(*rule));
                let mounting = Mounting { regions: vec![with], ..Mounting::default() };
                assert_eq!(mounting.check(), Ok(()));
            }
        }
        let sensor = Sensor::five_dof("a", Point3::new(1.0, 2.0, 3.0), Vector3::y_axis());
        let seat = MountingRegion::seat_of(&sensor);
        assert_eq!((seat.kind(), seat.with_axis(MountingAxis::Free)), (None, seat.clone()));
        let axis = Some(Vector3::y_axis());
        assert_eq!(seat, MountingRegion::Seat { position_mm: Point3::new(1.0, 2.0, 3.0), axis });
    }

    #[test]
    fn a_new_forbidden_box_is_in_the_middle() {
        assert_eq!(new_forbidden_box(None).center_mm(), Point3::origin());
        let rod = placeholder(&Point3::origin(), &[Point3::new(0.0, 0.0, 100.0)]);
        let own = new_forbidden_box(Some(&rod));
        assert_eq!(own.center_mm(), rod.body_bounds().unwrap().center_mm());
        let mounting = Mounting { keep_out: vec![own], ..Mounting::default() };
        assert_eq!(mounting.check(), Ok(()));
    }

    #[test]
    fn a_clicked_channel_runs_through_a_rod() {
        let rod = placeholder(&Point3::origin(), &[Point3::new(0.0, 0.0, 100.0)]);
        let surface = Surface::new(&rod).unwrap();
        for z_mm in [20.0, 60.0] {
            let at = surface.closest(&Point3::new(5.0, 0.0, z_mm));
            let found = channel_point(&surface, &at, &rod.long_axis()).unwrap();
            assert!((found - Point3::new(0.0, 0.0, z_mm)).norm() < 0.05, "{found}");
        }
    }
}
