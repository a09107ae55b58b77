//! A generator with metal bodies around it: the disturbance of every coil's field anywhere outside, and
//! the poses that a tracker reports there.

mod placed;

pub use placed::PlacedBody;

use crate::body::MetalShape;
use crate::exchange::{Answer, CoilField, ExchangeError, ExchangeReport, coupling_size, exchange};
use faer::Mat;
use nalgebra::{Point3, Unit, Vector3};
use rayon::prelude::*;
use std::sync::Arc;
use trackwright_field::generator::determination::DeterminationError;
use trackwright_field::generator::reading::{
    AxisReading, PoseReading, ReadingError, read_axis, read_pose,
};
use trackwright_field::generator::{Coil, Generator, GeneratorError};
use trackwright_geometry::bounds::BoundsError;
use trackwright_geometry::limits::position_problem;
use trackwright_geometry::pose::{Pose, is_finite};
use trackwright_geometry::rotation::perpendicular;
use trackwright_geometry::volume::Volume;
use trackwright_task::{Cancelled, Task};

/// Most numbers of all couplings together, 512 MB: seven bodies of 1,000 triangles.
pub const MAX_COUPLING_NUMBERS: usize = 64 << 20;

/// Points of a square loop's side at which it is looked whether metal is there.
const POINTS_A_SIDE: usize = 16;

/// The field of a generator among metal bodies, solved.
#[derive(Clone, Debug)]
pub struct MetalRoom {
    generator: Generator,
    volume: Option<Volume>,
    wires_mm: Vec<Vec<Point3<f64>>>,
    bodies: Vec<PlacedBody>,
    answers: Vec<Arc<Answer>>,
    normal_fields: Vec<Arc<Mat<f64>>>,
    couplings: Vec<Vec<Option<Arc<Mat<f64>>>>>,
    /// Of each body, what its field is of.
    sources: Vec<Mat<f64>>,
    exchange: ExchangeReport,
}

/// How near a point is to a meshed body. One panel size away a field is good to about 1 %, a fifth of
/// that away to 3 %: nearer, more triangles are needed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearSurface {
    pub body: usize,
    pub distance_mm: f64,
    /// Size of the nearest panel: from its middle to the farthest corner.
    pub panel_mm: f64,
}

/// Why there is no such room. Bodies and coils are counted from 0.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RoomError {
    #[error(transparent)]
    Generator(#[from] GeneratorError),
    #[error("the pose of body {0} is not finite or farther than 1e6 mm")]
    Pose(usize),
    #[error(
        "body {body} is at {frequency_hz} Hz, body 0 at {first_hz} Hz: a room has one frequency"
    )]
    Frequencies { body: usize, frequency_hz: f64, first_hz: f64 },
    #[error("the measurement volume: {0}")]
    Volume(#[from] BoundsError),
    #[error(transparent)]
    Determination(#[from] DeterminationError),
    #[error("coil {0} is in the measurement volume")]
    CoilInVolume(usize),
    #[error("body {body} cuts coil {coil} of the generator")]
    MetalCutsGenerator { body: usize, coil: usize },
    #[error("body {0} is in the middle of the measurement volume")]
    MetalInVolumeCenter(usize),
    #[error("bodies {first} and {second} touch or cut each other")]
    BodiesTouch { first: usize, second: usize },
    #[error("body {other} is in a hole of body {body}: the flux through it is not known then")]
    BodyInHole { body: usize, other: usize },
    #[error("coil {coil} is in a hole of body {body}: the flux through it is not known then")]
    CoilInHole { body: usize, coil: usize },
    #[error(
        "the bodies' triangles make {found} numbers between them, expected at most {MAX_COUPLING_NUMBERS}: coarsen them"
    )]
    TooManyTriangles { found: usize },
    #[error(transparent)]
    Exchange(#[from] ExchangeError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Why there is no field at a point, or no pose.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PointError {
    #[error("the point is not finite or farther than 1e6 mm")]
    Position,
    #[error("the point is in the metal of body {0}")]
    InMetal(usize),
    #[error(transparent)]
    Reading(#[from] ReadingError),
}

impl MetalRoom {
    /// Solves for what all bodies answer to all coils, and to each other.
    ///
    /// Without bodies the room is empty. With a volume, coils in it, coils that do not determine the poses
    /// in it, and metal in its middle are refused.
    ///
    /// # Errors
    /// See [`RoomError`].
    pub fn new(
        generator: Generator,
        volume: Option<Volume>,
        bodies: Vec<PlacedBody>,
        task: &Task,
    ) -> Result<Self, RoomError> {
        if let Some(problem) = generator.problem() {
            return Err(problem.into());
        }
        let wires_mm: Vec<_> = generator.coils.iter().map(wire_mm).collect();
        if let Some(volume) = &volume {
            volume.bounds().check()?;
            let is_in = |wire: &Vec<Point3<f64>>| wire.iter().any(|p| volume.contains(p));
            if let Some(coil) = wires_mm.iter().position(is_in) {
                return Err(RoomError::CoilInVolume(coil));
            }
            generator.check_determines(volume)?;
        }
        Self::solved(generator, volume, wires_mm, bodies, None, task)
    }

    /// The room with one body elsewhere. What knows only the other bodies and their relative poses is
    /// used again; the result is the same to the bit as that of [`MetalRoom::new`].
    ///
    /// # Errors
    /// See [`RoomError`].
    ///
    /// # Panics
    /// If there is no body of that number.
    pub fn with_pose(
        &self,
        body: usize,
        tracker_from_body: Pose,
        task: &Task,
    ) -> Result<Self, RoomError> {
        let mut bodies = self.bodies.clone();
        bodies[body].tracker_from_body = tracker_from_body;
        self.with_bodies(bodies, task)
    }

    /// The room with other bodies, or the same elsewhere, as many. What has not changed is used again; the
    /// result is the same to the bit as that of [`MetalRoom::new`].
    ///
    /// # Errors
    /// See [`RoomError`].
    pub fn with_bodies(&self, bodies: Vec<PlacedBody>, task: &Task) -> Result<Self, RoomError> {
        let (generator, wires_mm) = (self.generator.clone(), self.wires_mm.clone());
        let before = (bodies.len() == self.bodies.len()).then_some(self);
        Self::solved(generator, self.volume, wires_mm, bodies, before, task)
    }

    fn solved(
        generator: Generator,
        volume: Option<Volume>,
        wires_mm: Vec<Vec<Point3<f64>>>,
        bodies: Vec<PlacedBody>,
        before: Option<&Self>,
        task: &Task,
    ) -> Result<Self, RoomError> {
        check_bodies(&bodies)?;
        check_clearance(&bodies, &wires_mm, volume.as_ref())?;
        let coils = CoilField { generator: &generator, wires_mm: &wires_mm };
        let is_same = |i: usize| {
            before.filter(|room| {
                let (old, new) = (&room.bodies[i], &bodies[i]);
                old.tracker_from_body == new.tracker_from_body && Arc::ptr_eq(&old.body, &new.body)
            })
        };
        let answers: Vec<Arc<Answer>> = (0..bodies.len())
            .map(|i| {
                let nearest_mm = nearest_source_mm(&bodies, i, &coils);
                Arc::new(Answer::new(bodies[i].body.solver(), nearest_mm))
            })
            .collect();
        // A sphere's degree may change where another body moves.
        let answers: Vec<Arc<Answer>> = answers
            .into_iter()
            .enumerate()
            .map(|(i, answer)| match before {
                Some(room) if room.answers[i].is_alike(&answer) => Arc::clone(&room.answers[i]),
                _ => answer,
            })
            .collect();
        let normal_fields = (0..bodies.len())
            .map(|i| match is_same(i) {
                Some(room) if Arc::ptr_eq(&room.answers[i], &answers[i]) => {
                    Ok(Arc::clone(&room.normal_fields[i]))
                }
                _ => answers[i]
                    .normal_field(&bodies[i].tracker_from_body, &coils, task)
                    .map(Arc::new),
            })
            .collect::<Result<Vec<_>, Cancelled>>()?;
        let pairs = || {
            let all = 0..bodies.len();
            all.clone().flat_map(move |i| all.clone().map(move |j| (i, j))).filter(|(i, j)| i != j)
        };
        let found = pairs().map(|(i, j)| coupling_size(&answers[i], &answers[j])).sum();
        if found > MAX_COUPLING_NUMBERS {
            return Err(RoomError::TooManyTriangles { found });
        }
        let mut couplings = vec![vec![None; bodies.len()]; bodies.len()];
        let all = bodies.len() * bodies.len();
        for (done, (i, j)) in pairs().enumerate() {
            task.step(done, all)?;
            if coupling_size(&answers[i], &answers[j]) == 0 {
                continue;
            }
            let kept = is_same(i)
                .and(is_same(j))
                .filter(|room| [i, j].iter().all(|&k| Arc::ptr_eq(&room.answers[k], &answers[k])));
            couplings[i][j] = match kept {
                Some(room) => room.couplings[i][j].clone(),
                None => {
                    let body_from_source =
                        bodies[i].tracker_from_body.inv_mul(&bodies[j].tracker_from_body);
                    Some(Arc::new(answers[i].coupling(&answers[j], &body_from_source, task)?))
                }
            };
        }
        let (unknowns, exchange) = exchange(&answers, &normal_fields, &couplings, task)?;
        let each = answers.iter().zip(unknowns);
        let sources = each.map(|(answer, unknowns)| answer.sources(unknowns)).collect();
        task.step(1, 1)?;
        Ok(Self {
            generator,
            volume,
            wires_mm,
            bodies,
            answers,
            normal_fields,
            couplings,
            sources,
            exchange,
        })
    }

    pub fn generator(&self) -> &Generator {
        &self.generator
    }

    /// The measurement volume that metal must leave free.
    pub fn volume(&self) -> Option<&Volume> {
        self.volume.as_ref()
    }

    pub fn bodies(&self) -> &[PlacedBody] {
        &self.bodies
    }

    /// How the exchange of fields between bodies ended.
    pub fn exchange(&self) -> ExchangeReport {
        self.exchange
    }

    /// What the metal adds to the field of every coil at a point of the tracker frame, in mm⁻³.
    ///
    /// # Errors
    /// [`PointError::Position`] and [`PointError::InMetal`].
    ///
    /// # Panics
    /// If `disturbance` has another length than the coils.
    pub fn disturbance(
        &self,
        p: &Point3<f64>,
        disturbance: &mut [Vector3<f64>],
    ) -> Result<(), PointError> {
        self.disturbance_of(0..self.bodies.len(), p, disturbance)
    }

    /// [`Self::disturbance`] by some of the bodies.
    pub(crate) fn disturbance_of(
        &self,
        bodies: impl IntoIterator<Item = usize>,
        p: &Point3<f64>,
        disturbance: &mut [Vector3<f64>],
    ) -> Result<(), PointError> {
        assert_eq!(disturbance.len(), self.generator.coils.len(), "one disturbance a coil");
        if position_problem(&p.coords).is_some() {
            return Err(PointError::Position);
        }
        disturbance.fill(Vector3::zeros());
        let mut fields = vec![Vector3::zeros(); disturbance.len()];
        for index in bodies {
            let placed = &self.bodies[index];
            let in_body = placed.tracker_from_body.inverse_transform_point(p);
            if placed.contains_in_body(&in_body) {
                return Err(PointError::InMetal(index));
            }
            fields.fill(Vector3::zeros());
            self.answers[index].add_fields(&self.sources[index], &in_body, &mut fields);
            for (sum, field) in disturbance.iter_mut().zip(&fields) {
                *sum += placed.tracker_from_body.rotation * field;
            }
        }
        Ok(())
    }

    /// The meshed body that is nearest to a point of the tracker frame, and how near; `None` where all
    /// bodies are spheres.
    pub fn nearest_surface(&self, p: &Point3<f64>) -> Option<NearSurface> {
        let of_body = |(body, placed): (usize, &PlacedBody)| match placed.body.shape() {
            MetalShape::Sphere { .. } => None,
            MetalShape::Surface(shape) => {
                let in_body = placed.tracker_from_body.inverse_transform_point(p);
                let (distance_mm, panel_mm) = shape.surface().nearest(&in_body);
                Some(NearSurface { body, distance_mm, panel_mm })
            }
        };
        let all = self.bodies.iter().enumerate().filter_map(of_body);
        all.min_by(|a, b| a.distance_mm.total_cmp(&b.distance_mm))
    }

    /// Distance of a point of the tracker frame from a body's surface; 0 within it.
    ///
    /// # Panics
    /// If there is no body of that number.
    pub fn body_distance_mm(&self, body: usize, p: &Point3<f64>) -> f64 {
        let placed = &self.bodies[body];
        let in_body = placed.tracker_from_body.inverse_transform_point(p);
        match placed.body.shape() {
            MetalShape::Sphere { radius_mm } => (in_body.coords.norm() - radius_mm).max(0.0),
            MetalShape::Surface(shape) => {
                let surface = shape.surface();
                if surface.contains(&in_body) { 0.0 } else { surface.nearest(&in_body).0 }
            }
        }
    }

    /// [`MetalRoom::disturbance`] of many points, on all threads.
    pub fn disturbances(
        &self,
        points: &[Point3<f64>],
    ) -> Vec<Result<Vec<Vector3<f64>>, PointError>> {
        let of_point = |p: &Point3<f64>| {
            let mut disturbance = vec![Vector3::zeros(); self.generator.coils.len()];
            self.disturbance(p, &mut disturbance).map(|()| disturbance)
        };
        points.par_iter().map(of_point).collect()
    }

    /// What a tracker that knows of no metal reports of a sensor with one axis.
    ///
    /// # Errors
    /// A sensor in metal, and signals that determine no pose.
    pub fn read_axis(
        &self,
        position_mm: &Point3<f64>,
        axis: &Unit<Vector3<f64>>,
    ) -> Result<AxisReading, PointError> {
        let mut disturbance = vec![Vector3::zeros(); self.generator.coils.len()];
        self.disturbance(position_mm, &mut disturbance)?;
        Ok(read_axis(&self.generator, position_mm, axis, &disturbance)?)
    }

    /// What a tracker that knows of no metal reports of a sensor with three axes.
    ///
    /// # Errors
    /// A sensor in metal, and signals that determine no pose.
    pub fn read_pose(&self, tracker_from_sensor: &Pose) -> Result<PoseReading, PointError> {
        let mut disturbance = vec![Vector3::zeros(); self.generator.coils.len()];
        self.disturbance(&tracker_from_sensor.translation.vector.into(), &mut disturbance)?;
        Ok(read_pose(&self.generator, tracker_from_sensor, &disturbance)?)
    }
}

fn check_bodies(bodies: &[PlacedBody]) -> Result<(), RoomError> {
    for (body, placed) in bodies.iter().enumerate() {
        let position = &placed.tracker_from_body.translation.vector;
        if !is_finite(&placed.tracker_from_body) || position_problem(position).is_some() {
            return Err(RoomError::Pose(body));
        }
        let (frequency_hz, first_hz) = (placed.body.frequency_hz(), bodies[0].body.frequency_hz());
        if frequency_hz != first_hz {
            return Err(RoomError::Frequencies { body, frequency_hz, first_hz });
        }
    }
    Ok(())
}

fn check_clearance(
    bodies: &[PlacedBody],
    wires_mm: &[Vec<Point3<f64>>],
    volume: Option<&Volume>,
) -> Result<(), RoomError> {
    let center = volume.map(|volume| volume.bounds().center_mm());
    // The first coil that has a side which is somewhere.
    let coil_with = |is_there: &dyn Fn(&Point3<f64>, &Point3<f64>) -> bool| {
        wires_mm.iter().position(|wire| {
            let ends = wire.iter().zip(wire.iter().cycle().skip(1));
            ends.into_iter().any(|(from, to)| is_there(from, to))
        })
    };
    for (body, placed) in bodies.iter().enumerate() {
        if let Some(coil) = coil_with(&|from, to| placed.meets_segment(from, to)) {
            return Err(RoomError::MetalCutsGenerator { body, coil });
        }
        if center.is_some_and(|center| placed.contains(&center)) {
            return Err(RoomError::MetalInVolumeCenter(body));
        }
        if let Some(coil) = coil_with(&|from, to| placed.is_spanned(from, to)) {
            return Err(RoomError::CoilInHole { body, coil });
        }
        let others = (0..bodies.len()).filter(|&other| other != body);
        if let Some(other) = others.into_iter().find(|&other| placed.holds(&bodies[other])) {
            return Err(RoomError::BodyInHole { body, other });
        }
    }
    let pairs = (0..bodies.len()).flat_map(|second| (0..second).map(move |first| (first, second)));
    let cut = pairs.into_iter().find(|&(first, second)| {
        bodies[first].cuts(&bodies[second]) || bodies[second].cuts(&bodies[first])
    });
    match cut {
        Some((first, second)) => Err(RoomError::BodiesTouch { first, second }),
        None => Ok(()),
    }
}

/// Distance from a body's middle to the nearest wire or other body, which a sphere's degree follows.
fn nearest_source_mm(bodies: &[PlacedBody], body: usize, coils: &CoilField<'_>) -> f64 {
    if !matches!(bodies[body].body.shape(), MetalShape::Sphere { .. }) {
        return f64::INFINITY;
    }
    let middle = bodies[body].tracker_from_body.translation.vector.into();
    let others = bodies.iter().enumerate().filter(|(other, _)| *other != body);
    let nearest = others.map(|(_, placed)| placed.distance_mm(&middle));
    nearest.fold(coils.distance_mm(&middle), f64::min)
}

/// Points of a coil's wire.
fn wire_mm(coil: &Coil) -> Vec<Point3<f64>> {
    match coil {
        Coil::Dipole { at_mm, .. } => vec![*at_mm],
        Coil::SquareLoop { center_mm, normal, side_mm } => {
            let u = perpendicular(normal).into_inner() * (0.5 * side_mm);
            let v = normal.cross(&u);
            let corners = [u + v, v - u, -u - v, u - v].map(|corner| center_mm + corner);
            let along = |side: usize, k: usize| {
                let part = k as f64 / POINTS_A_SIDE as f64;
                corners[side] + (corners[(side + 1) % 4] - corners[side]) * part
            };
            (0..4).flat_map(|side| (0..POINTS_A_SIDE).map(move |k| along(side, k))).collect()
        }
    }
}

#[cfg(test)]
mod published;
#[cfg(test)]
mod tests;
