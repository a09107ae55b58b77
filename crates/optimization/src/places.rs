//! The places of a body: a grid of those that are allowed, and ways from one to the next.

use crate::channel::Channel;
use crate::constraint::{Constraint, own_fault};
use crate::covering::{Putting, SurfaceRegion};
use crate::problem::MountedBody;
use nalgebra::{Point3, Unit, Vector3};
use rayon::prelude::*;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::spread::{Position, farthest_first};
use trackwright_geometry::surface::SurfacePoint;
use trackwright_simulation::placement::along_surface;
use trackwright_simulation::{MountingAxis, MountingRegion, Sensor};

/// Turn of a free axis, rad, that counts as much as a millimetre: what moves the end of a coil of
/// 9 mm by half as much as the step.
const TURN_PER_MM: f64 = 0.1;

/// Places of a surface that are tried for one that is taken: some do not hold the coil.
const TRIED_PER_PLACE: usize = 2;

/// Where the sensors of one body may be.
pub(crate) struct Places<'a> {
    pub body: &'a MountedBody,
    tip_in_body: Option<Point3<f64>>,
    regions: Vec<Region>,
}

/// A mounting region, ready to be searched.
enum Region {
    Surface { axis: MountingAxis, boxes: Vec<Bounds> },
    Channel { axis: MountingAxis, channel: Channel },
    Seat { position_mm: Point3<f64>, axis: Option<Unit<Vector3<f64>>> },
}

/// A sensor at a place of a region.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlacedSensor {
    pub sensor: Sensor,
    region: usize,
    /// Way along a channel.
    along_mm: f64,
}

/// Allowed places.
#[derive(Clone, Debug, Default)]
pub(crate) struct Grid {
    pub places: Vec<PlacedSensor>,
    /// Places that were looked at.
    pub tried: usize,
    /// What stands in the way at most of those that are not allowed.
    pub most_common: Option<Constraint>,
}

impl<'a> Places<'a> {
    pub fn new(body: &'a MountedBody, tip_in_body: Option<Point3<f64>>) -> Self {
        let whole = [MountingRegion::Surface { axis: MountingAxis::AsItIs, boxes: Vec::new() }];
        let regions = match body.mounting.regions.is_empty() {
            true => &whole[..],
            false => &body.mounting.regions,
        };
        let regions = regions.iter().map(|region| match region {
            MountingRegion::Surface { axis, boxes } => {
                Region::Surface { axis: *axis, boxes: boxes.clone() }
            }
            MountingRegion::Channel { points_mm, radius_mm, axis } => {
                Region::Channel { axis: *axis, channel: Channel::new(points_mm, *radius_mm) }
            }
            MountingRegion::Seat { position_mm, axis } => {
                Region::Seat { position_mm: *position_mm, axis: *axis }
            }
        });
        Self { body, tip_in_body, regions: regions.collect() }
    }

    /// About as many allowed places of a sensor, spread over all regions alike. The result does not
    /// depend on the number of threads.
    pub fn grid(&self, sensor: &Sensor, count: usize) -> Grid {
        let seats = self.regions.iter().filter(|r| matches!(r, Region::Seat { .. })).count();
        let others = (self.regions.len() - seats).max(1);
        let each = (count.saturating_sub(seats) / others).max(2);
        let mut grid = Grid::default();
        let mut faults: Vec<Constraint> = Vec::new();
        for number in 0..self.regions.len() {
            let tried = self.tried(number, sensor, each);
            let checked: Vec<Result<PlacedSensor, Constraint>> = tried
                .into_par_iter()
                .map(|place| match self.fault(&place) {
                    None => Ok(place),
                    Some(fault) => Err(fault),
                })
                .collect();
            grid.tried += checked.len();
            let mut taken = 0;
            for place in checked {
                match place {
                    Ok(place) if taken < each => {
                        grid.places.push(place);
                        taken += 1;
                    }
                    Ok(_) => {}
                    Err(fault) => faults.push(fault),
                }
            }
        }
        grid.most_common = most_common(faults);
        grid
    }

    /// No allowed place of a sensor is farther from one of these in its region, `others` of the body
    /// standing still; `None` where axes are free, of which there is no grid that fine, and where a
    /// region without one of these is not shown to have no allowed place.
    pub fn spacing_mm(
        &self,
        sensor: &Sensor,
        others: &[&Sensor],
        places: &[PlacedSensor],
    ) -> Option<f64> {
        let (body, tip_in_body) = (self.body, self.tip_in_body);
        let putting = Putting { body, tip_in_body, sensor, others };
        let each = (0..self.regions.len()).map(|number| {
            let own = || places.iter().filter(|place| place.region == number);
            match &self.regions[number] {
                Region::Seat { .. } => Some(0.0),
                Region::Surface { axis: MountingAxis::Free, .. }
                | Region::Channel { axis: MountingAxis::Free, .. } => None,
                Region::Surface { axis, boxes } => {
                    let region = SurfaceRegion { putting: &putting, boxes, axis: *axis };
                    let places: Vec<_> = own().map(|own| own.sensor.position_in_body).collect();
                    Some(region.covering_mm(&places))
                }
                Region::Channel { channel, .. } => {
                    let along_mm: Vec<f64> = own().map(|own| own.along_mm).collect();
                    let at = |way_mm| self.in_channel(number, sensor, way_mm, &None).sensor;
                    Some(putting.channel_covering_mm(channel, &along_mm, at))
                }
            }
        });
        let most_mm = each.collect::<Option<Vec<f64>>>()?.into_iter().fold(0.0, f64::max);
        most_mm.is_finite().then_some(most_mm)
    }

    /// Places of one region, allowed or not, so that some of them are about as many as are required.
    fn tried(&self, number: usize, sensor: &Sensor, count: usize) -> Vec<PlacedSensor> {
        match &self.regions[number] {
            Region::Seat { position_mm, axis } => {
                let at = Sensor { position_in_body: *position_mm, ..sensor.clone() };
                let sensor = match axis {
                    Some(axis) => at.pointed_along(axis),
                    None => at,
                };
                vec![PlacedSensor { sensor, region: number, along_mm: 0.0 }]
            }
            Region::Channel { axis, channel } => {
                let Some([from, to]) = channel.range_mm(sensor.coil) else {
                    return Vec::new();
                };
                let axes = free_axes(*axis);
                let stations = (count / axes.len()).max(2);
                let step_mm = (to - from) / (stations - 1) as f64;
                let places = (0..stations).flat_map(|k| {
                    let along_mm = from + step_mm * k as f64;
                    axes.iter().map(move |free| self.in_channel(number, sensor, along_mm, free))
                });
                places.collect()
            }
            Region::Surface { axis, boxes } => {
                let inside = |point: &&SurfacePoint| is_in(boxes, &point.position_mm);
                let all: Vec<&SurfacePoint> = self.body.vertices.iter().filter(inside).collect();
                let position = |point: &&SurfacePoint| {
                    let [x, y, z] = point.position_mm.coords.into();
                    [x, y, z, 0.0, 0.0, 0.0, 0.0]
                };
                let positions: Vec<Position> = all.iter().map(position).collect();
                let axes = free_axes(*axis);
                let stations = (count * TRIED_PER_PLACE / axes.len()).max(2).min(all.len());
                let places = farthest_first(&positions, stations).into_iter().flat_map(|k| {
                    let at = *all[k];
                    axes.iter().map(move |free| on_surface(number, sensor, &at, *axis, free))
                });
                places.collect()
            }
        }
    }

    fn in_channel(
        &self,
        number: usize,
        sensor: &Sensor,
        along_mm: f64,
        free: &Option<Unit<Vector3<f64>>>,
    ) -> PlacedSensor {
        let Region::Channel { axis, channel } = &self.regions[number] else {
            return PlacedSensor { sensor: sensor.clone(), region: number, along_mm };
        };
        let (position_in_body, direction) = channel.at(along_mm);
        let at = Sensor { position_in_body, ..sensor.clone() };
        let sensor = match (axis, free) {
            (MountingAxis::Along, _) => {
                // Of either direction the one that turns it least.
                let own = at.axis_in_body();
                let is_backward = own.is_some_and(|own| own.dot(&direction) < 0.0);
                at.pointed_along(&if is_backward { -direction } else { direction })
            }
            (MountingAxis::Free, Some(axis)) => at.pointed_along(axis),
            _ => at,
        };
        PlacedSensor { sensor, region: number, along_mm }
    }

    /// What a sensor breaks at its place by itself.
    pub fn fault(&self, place: &PlacedSensor) -> Option<Constraint> {
        let sensor = &place.sensor;
        let tip = self.tip_in_body.as_ref();
        match &self.regions[place.region] {
            Region::Channel { channel, .. } => {
                let Some([from, to]) = channel.range_mm(sensor.coil) else {
                    return Some(Constraint::ChannelTooNarrow);
                };
                if !(from..=to).contains(&place.along_mm) {
                    return Some(Constraint::RegionEnd);
                }
                let axis = sensor.axis_in_body().zip(sensor.coil);
                let holds =
                    axis.is_none_or(|(a, coil)| channel.holds(&sensor.position_in_body, &a, coil));
                match holds {
                    true => own_fault(sensor, self.body, tip, true),
                    false => Some(Constraint::ChannelTooNarrow),
                }
            }
            Region::Surface { boxes, .. } if !is_in(boxes, &sensor.position_in_body) => {
                Some(Constraint::RegionEnd)
            }
            _ => own_fault(sensor, self.body, tip, false),
        }
    }

    /// The place of a region that is nearest to where a sensor is, allowed or not.
    pub fn nearest(&self, sensor: &Sensor) -> Option<PlacedSensor> {
        let each = (0..self.regions.len()).filter_map(|number| {
            let at = &sensor.position_in_body;
            match &self.regions[number] {
                Region::Channel { channel, .. } => {
                    let [from, to] = channel.range_mm(sensor.coil)?;
                    let along_mm = channel.nearest_mm(at).clamp(from, to);
                    let own = sensor.axis_in_body();
                    Some(self.in_channel(number, sensor, along_mm, &own))
                }
                Region::Surface { axis, .. } => {
                    let on = self.body.surface.as_ref()?.closest(at);
                    Some(on_surface(number, sensor, &on, *axis, &sensor.axis_in_body()))
                }
                Region::Seat { .. } => self.tried(number, sensor, 1).into_iter().next(),
            }
        });
        let away =
            |place: &PlacedSensor| (place.sensor.position_in_body - sensor.position_in_body).norm();
        each.min_by(|a, b| away(a).total_cmp(&away(b)))
    }

    /// Numbers that move a sensor from a place: three on a surface, one in a channel, none in a seat,
    /// and three for an axis that is free.
    pub fn dimensions(&self, place: &PlacedSensor) -> usize {
        let axis = match &self.regions[place.region] {
            Region::Surface { axis, .. } | Region::Channel { axis, .. } => *axis,
            Region::Seat { .. } => MountingAxis::AsItIs,
        };
        self.way_dimensions(place) + if axis == MountingAxis::Free { 3 } else { 0 }
    }

    /// Those of them that move the sensor's place: the first ones.
    pub fn way_dimensions(&self, place: &PlacedSensor) -> usize {
        match &self.regions[place.region] {
            Region::Surface { .. } => 3,
            Region::Channel { .. } => 1,
            Region::Seat { .. } => 0,
        }
    }

    /// The place after a way of so many millimetres, allowed or not: along the channel, or to the
    /// point of the surface that is nearest to the displaced one.
    pub fn moved(&self, place: &PlacedSensor, way_mm: &[f64]) -> PlacedSensor {
        let turned = |axis: MountingAxis, way_mm: &[f64]| match (axis, place.sensor.axis_in_body())
        {
            (MountingAxis::Free, Some(own)) => {
                let tilt = Vector3::from_column_slice(&way_mm[..3]) * TURN_PER_MM;
                Some(Unit::try_new(own.into_inner() + tilt, 1e-9).unwrap_or(own))
            }
            (_, own) => own,
        };
        match &self.regions[place.region] {
            Region::Seat { .. } => place.clone(),
            Region::Channel { axis, .. } => {
                let free = turned(*axis, &way_mm[1..]);
                self.in_channel(place.region, &place.sensor, place.along_mm + way_mm[0], &free)
            }
            Region::Surface { axis, .. } => {
                let displaced =
                    place.sensor.position_in_body + Vector3::from_column_slice(&way_mm[..3]);
                let Some(surface) = &self.body.surface else {
                    return place.clone();
                };
                let free = turned(*axis, &way_mm[3..]);
                on_surface(place.region, &place.sensor, &surface.closest(&displaced), *axis, &free)
            }
        }
    }
}

/// A sensor on the surface, turned as the rule has it.
fn on_surface(
    region: usize,
    sensor: &Sensor,
    at: &SurfacePoint,
    axis: MountingAxis,
    free: &Option<Unit<Vector3<f64>>>,
) -> PlacedSensor {
    let placed = Sensor { position_in_body: at.position_mm, ..sensor.clone() };
    let sensor = match (axis, sensor.axis_in_body(), free) {
        (MountingAxis::Normal, _, _) => placed.pointed_along(&at.normal),
        (MountingAxis::Tangent, Some(own), _) => {
            placed.pointed_along(&along_surface(&own, &at.normal))
        }
        (MountingAxis::Free, _, Some(axis)) => placed.pointed_along(axis),
        _ => placed,
    };
    PlacedSensor { sensor, region, along_mm: 0.0 }
}

/// The axes that are tried at a place: one, or half of those that are spread over all directions, as a
/// coil measures the same either way round.
fn free_axes(axis: MountingAxis) -> Vec<Option<Unit<Vector3<f64>>>> {
    if axis != MountingAxis::Free {
        return vec![None];
    }
    let steps = [-1.0, 0.0, 1.0];
    let all = steps.iter().flat_map(|x| steps.iter().map(move |y| (*x, *y)));
    let all = all.flat_map(|(x, y)| steps.iter().map(move |z| Vector3::new(x, y, *z)));
    let half = all.filter(|v| (v.x, v.y, v.z) > (0.0, 0.0, 0.0));
    half.map(|v| Some(Unit::new_normalize(v))).collect()
}

fn is_in(boxes: &[Bounds], point: &Point3<f64>) -> bool {
    boxes.is_empty() || boxes.iter().any(|region| region.contains(point))
}

fn most_common(faults: Vec<Constraint>) -> Option<Constraint> {
    let count = |fault: &Constraint| faults.iter().filter(|other| *other == fault).count();
    // The first of those that are as common.
    faults.iter().rev().max_by_key(|fault| count(fault)).cloned()
}
