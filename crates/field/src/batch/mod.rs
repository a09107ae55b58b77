//! Many evaluations of one model at scattered poses, grouped by spherical triangle.
//!
//! Poses that share a triangle share their coefficients. So poses are sorted by triangle, by
//! counting, and each group runs through `kernel` with as many poses at a time as the
//! machine has lanes. What a pose gets does not depend on the poses beside it.

#[cfg(test)]
mod tests;

use super::computed::{ComputedBatch, ComputedField};
use super::evaluation::{Coefficient, Evaluation, OutsidePolicy};
use super::field_point::FieldPoint;
use super::kernel::{
    Basis, Block, LaneBounds, MAX_TERMS, Values, basis, contract, weighted, weights,
};
use super::model::DistortionModel;
use super::samples::PoseError;
use nalgebra::{Point3, Unit, Vector3};
use pulp::bytemuck::{Pod, cast_slice};
use pulp::{Arch, Simd, WithSimd};
use trackwright_geometry::directions::{DirectionSet, Sphere, TriangleShape, Weighting};

/// Poses sorted at a time. Many, so that few lanes stay empty at the ends of the groups (the set
/// of 42 has 80 triangles); few enough that all of their buffers stay in the second-level cache.
const CHUNK: usize = 4096;

/// Most pose vectors that share a load of a coefficient. Each takes six sums: three are 18 of the
/// 32 registers of AVX-512, and 5 % faster than two; AVX2 has 16 registers and room for two.
const MAX_WIDTH: usize = 3;

/// What an empty slot holds for a pose: a number beyond all poses of a chunk.
const NO_POSE: u32 = u32::MAX;

/// Lanes of the widest vectors.
const MAX_LANES: usize = 8;

/// Which instructions a batch uses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Instructions {
    /// AVX-512 or AVX2 with FMA where the machine has them.
    #[default]
    Best,
    /// AVX2 with FMA, or portable where the machine has them not.
    Avx2,
    /// What every machine has.
    Portable,
}

impl Instructions {
    pub(super) fn run<Op: WithSimd>(self, op: Op) -> Op::Output {
        match self {
            Self::Best => Arch::new().dispatch(op),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Avx2 => match pulp::x86::V3::try_new() {
                Some(simd) => Arch::V3(simd).dispatch(op),
                None => op.with_simd(pulp::Scalar::new()),
            },
            #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
            Self::Avx2 => op.with_simd(pulp::Scalar::new()),
            Self::Portable => op.with_simd(pulp::Scalar::new()),
        }
    }
}

/// Reusable buffers for many evaluations of one model at scattered poses.
#[derive(Clone, Debug, Default)]
pub struct Batch {
    instructions: Instructions,
    triangle_of: Vec<u8>,
    /// First slot of each triangle's group, and after the last.
    starts: Vec<usize>,
    /// Pose of each slot. Groups begin at whole vectors, so some slots have none.
    pose_of: Vec<u32>,
    /// Position and axis of each slot's pose, component by component.
    components: [Vec<f64>; 6],
    computed: ComputedBatch,
}

impl Batch {
    /// Buffers that use certain instructions; the results agree to a few units in the last place.
    pub fn with_instructions(instructions: Instructions) -> Self {
        Self { instructions, ..Self::default() }
    }

    /// What [`DistortionModel::evaluate`] gives at each pose, to a few units in the last place of
    /// the largest coefficient.
    ///
    /// ```
    /// use trackwright_field::random_models::{random_model, room};
    /// use trackwright_field::{Batch, OutsidePolicy};
    /// use trackwright_geometry::directions::{DirectionSet, Weighting};
    ///
    /// let model = random_model(3, DirectionSet::Fourteen, Weighting::Area, [1.0, 0.01], 7);
    /// let (positions, axes) = (vec![room().center_mm(); 9], vec![nalgebra::Vector3::z_axis(); 9]);
    /// let mut out = Vec::new();
    /// Batch::default().evaluate(&model, &positions, &axes, OutsidePolicy::Clamp, &mut out);
    /// let one = model.evaluate(&positions[0], &axes[0], OutsidePolicy::Clamp);
    /// assert!((out[8].error.position_mm - one.error.position_mm).norm() < 1e-13);
    /// ```
    ///
    /// # Panics
    /// Where there are not as many axes as positions.
    pub fn evaluate(
        &mut self,
        model: &DistortionModel,
        positions_mm: &[Point3<f64>],
        axes: &[Unit<Vector3<f64>>],
        outside: OutsidePolicy,
        out: &mut Vec<Evaluation>,
    ) {
        assert_eq!(positions_mm.len(), axes.len(), "one axis a position");
        self.run(model, positions_mm, Some(axes), outside, out);
    }

    /// The same at poses of sensors that may be of 6-DOF.
    pub fn evaluate_points(
        &mut self,
        model: &DistortionModel,
        points: &[FieldPoint],
        outside: OutsidePolicy,
        out: &mut Vec<Evaluation>,
    ) {
        if let Some(rolled) = model.computed().and_then(|of| of.evaluate_rolled(points)) {
            *out = rolled;
            return;
        }
        let positions_mm: Vec<_> = points.iter().map(|point| point.position_mm).collect();
        let axes: Vec<_> = points.iter().map(|point| point.axis).collect();
        self.evaluate(model, &positions_mm, &axes, outside, out);
    }

    /// Positions alone, for a model with one orientation.
    pub(super) fn evaluate_positions(
        &mut self,
        model: &DistortionModel,
        positions_mm: &[Point3<f64>],
        outside: OutsidePolicy,
        out: &mut Vec<Evaluation>,
    ) {
        debug_assert_eq!(model.directions(), DirectionSet::One, "no axes needed");
        self.run(model, positions_mm, None, outside, out);
    }

    fn run(
        &mut self,
        model: &DistortionModel,
        positions_mm: &[Point3<f64>],
        axes: Option<&[Unit<Vector3<f64>>]>,
        outside: OutsidePolicy,
        out: &mut Vec<Evaluation>,
    ) {
        let nothing = Evaluation { error: PoseError::default(), is_inside: false };
        out.resize(positions_mm.len(), nothing);
        if let Some(computed) = model.computed() {
            self.run_computed(computed, positions_mm, axes, out);
            return;
        }
        if model.order() == 0 {
            for (evaluation, position_mm) in out.iter_mut().zip(positions_mm) {
                *evaluation =
                    Evaluation { is_inside: model.bounds().contains(position_mm), ..nothing };
            }
            return;
        }
        self.instructions.run(Chunks {
            batch: self,
            model,
            positions_mm,
            // Nothing depends on the axes of the set of one.
            axes: axes.filter(|_| model.directions() != DirectionSet::One),
            clamp: outside != OutsidePolicy::Extrapolate,
            out,
        });
    }

    /// Evaluates a field that is no polynomial; where there are no axes it does not depend on them.
    fn run_computed(
        &mut self,
        field: &ComputedField,
        positions_mm: &[Point3<f64>],
        axes: Option<&[Unit<Vector3<f64>>]>,
        out: &mut [Evaluation],
    ) {
        let no_axes = vec![Vector3::z_axis(); if axes.is_some() { 0 } else { CHUNK }];
        let chunks = positions_mm.chunks(CHUNK).zip(out.chunks_mut(CHUNK));
        for (chunk, (positions_mm, out)) in chunks.enumerate() {
            let axes = match axes {
                Some(axes) => &axes[chunk * CHUNK..][..positions_mm.len()],
                None => &no_axes[..positions_mm.len()],
            };
            field.evaluate_all(&mut self.computed, positions_mm, axes, out);
        }
    }

    /// Makes one group of the positions of a chunk.
    #[inline(always)]
    fn line_up<S: Simd>(&mut self, positions_mm: &[Point3<f64>]) {
        let count = positions_mm.len();
        let end = count.next_multiple_of(S::F64_LANES);
        self.make_room(end);
        self.starts.clear();
        self.starts.extend([0, end]);
        for (slot, (pose, p)) in (0_u32..).zip(positions_mm).enumerate() {
            self.pose_of[slot] = pose;
            for k in 0..3 {
                self.components[k][slot] = p[k];
            }
        }
        self.pose_of[count..end].fill(NO_POSE);
    }

    /// Sorts the poses of a chunk by triangle.
    #[inline(always)]
    fn sort<S: Simd>(
        &mut self,
        simd: S,
        set: DirectionSet,
        positions_mm: &[Point3<f64>],
        axes: &[Unit<Vector3<f64>>],
    ) {
        self.triangle_of.resize(axes.len(), 0);
        set.sphere().find_all(simd, axes, &mut self.triangle_of);
        let mut cursors = [0_usize; 256];
        for &triangle in &self.triangle_of {
            cursors[usize::from(triangle)] += 1;
        }
        // From counts to first slots.
        self.starts.clear();
        let mut slots = 0;
        for cursor in cursors.iter_mut().take(set.triangles().len()) {
            let count = std::mem::replace(cursor, slots);
            self.starts.push(slots);
            let end = slots + count.next_multiple_of(S::F64_LANES);
            self.make_room(end);
            self.pose_of[slots + count..end].fill(NO_POSE);
            slots = end;
        }
        self.starts.push(slots);
        let [px, py, pz, ax, ay, az] = &mut self.components;
        let poses = (0_u32..).zip(positions_mm).zip(axes);
        for (((pose, p), a), &triangle) in poses.zip(&self.triangle_of) {
            let cursor = &mut cursors[usize::from(triangle)];
            let slot = *cursor;
            *cursor += 1;
            self.pose_of[slot] = pose;
            px[slot] = p.x;
            py[slot] = p.y;
            pz[slot] = p.z;
            ax[slot] = a.x;
            ay[slot] = a.y;
            az[slot] = a.z;
        }
    }

    /// Slots are written over one by one. Those between the groups keep numbers of earlier poses,
    /// which cost nothing and go nowhere.
    fn make_room(&mut self, slots: usize) {
        if self.pose_of.len() < slots {
            self.pose_of.resize(slots, NO_POSE);
            for component in &mut self.components {
                component.resize(slots, 0.0);
            }
        }
    }
}

/// The work of [`Batch::evaluate`].
struct Chunks<'a> {
    batch: &'a mut Batch,
    model: &'a DistortionModel,
    positions_mm: &'a [Point3<f64>],
    axes: Option<&'a [Unit<Vector3<f64>>]>,
    clamp: bool,
    out: &'a mut [Evaluation],
}

impl WithSimd for Chunks<'_> {
    type Output = ();

    /// Low orders have loops of known length, which are unrolled; unrolling longer ones was slower
    /// for want of registers.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match self.model.order() {
            1 => self.evaluate::<S, 2>(simd, 1),
            2 => self.evaluate::<S, 3>(simd, 2),
            order @ 3..=6 => self.evaluate::<S, 7>(simd, order),
            order => self.evaluate::<S, MAX_TERMS>(simd, order),
        }
    }
}

impl Chunks<'_> {
    #[inline(always)]
    fn evaluate<S: Simd, const T: usize>(self, simd: S, order: usize) {
        let set = self.model.directions();
        let bounds = LaneBounds::new(simd, self.model.bounds());
        let chunks = self.positions_mm.chunks(CHUNK).enumerate();
        for ((chunk, positions_mm), out) in chunks.zip(self.out.chunks_mut(CHUNK)) {
            match self.axes {
                Some(axes) => {
                    let axes = &axes[chunk * CHUNK..][..positions_mm.len()];
                    self.batch.sort(simd, set, positions_mm, axes);
                }
                None => self.batch.line_up::<S>(positions_mm),
            }
            let [px, py, pz, ax, ay, az] = &self.batch.components;
            let components = [
                S::as_simd_f64s(px).0,
                S::as_simd_f64s(py).0,
                S::as_simd_f64s(pz).0,
                S::as_simd_f64s(ax).0,
                S::as_simd_f64s(ay).0,
                S::as_simd_f64s(az).0,
            ];
            for (triangle, ends) in self.batch.starts.windows(2).enumerate() {
                if ends[0] == ends[1] {
                    continue;
                }
                let group = Group {
                    order,
                    weighting: self.model.weighting(),
                    bounds: &bounds,
                    shape: Shape::new(self.model, set.sphere(), triangle),
                    clamp: self.clamp,
                    pose_of: &self.batch.pose_of,
                    components,
                };
                let (mut vector, end) = (ends[0] / S::F64_LANES, ends[1] / S::F64_LANES);
                while vector < end {
                    vector += match end - vector {
                        3.. if S::REGISTER_COUNT >= 32 => {
                            group.evaluate::<S, 3, T>(simd, vector, out)
                        }
                        2.. => group.evaluate::<S, 2, T>(simd, vector, out),
                        _ => group.evaluate::<S, 1, T>(simd, vector, out),
                    };
                }
            }
        }
    }
}

/// Orientations that a group's poses blend.
enum Shape<'a> {
    /// The set of one.
    One(&'a [Coefficient]),
    Triangle(&'a TriangleShape, [&'a [Coefficient]; 3]),
}

impl<'a> Shape<'a> {
    fn new(model: &'a DistortionModel, sphere: &'a Sphere, triangle: usize) -> Self {
        match model.directions() {
            DirectionSet::One => Self::One(model.of_direction(0)),
            set => Self::Triangle(
                sphere.shape(triangle),
                set.triangles()[triangle].map(|d| model.of_direction(d)),
            ),
        }
    }
}

/// The poses of one triangle.
struct Group<'a, V> {
    order: usize,
    weighting: Weighting,
    bounds: &'a LaneBounds<V>,
    shape: Shape<'a>,
    clamp: bool,
    pose_of: &'a [u32],
    components: [&'a [V]; 6],
}

impl<V: Pod> Group<'_, V> {
    /// Evaluates `P` vectors of poses from the given one on; gives `P`.
    #[inline(always)]
    fn evaluate<S: Simd<f64s = V>, const P: usize, const T: usize>(
        &self,
        simd: S,
        vector: usize,
        out: &mut [Evaluation],
    ) -> usize {
        let zero = simd.splat_f64s(0.0);
        let mut unit = [[zero; P]; 3];
        let mut inside = [zero; P];
        let mut axis_weights = [[zero; P]; 3];
        for p in 0..P {
            let [px, py, pz, ax, ay, az] = self.components;
            let at = [px[vector + p], py[vector + p], pz[vector + p]];
            inside[p] = self.bounds.contains(simd, at);
            let at = self.bounds.to_unit(simd, at, self.clamp);
            for k in 0..3 {
                unit[k][p] = at[k];
            }
            if let Shape::Triangle(shape, _) = &self.shape {
                let axis = [ax[vector + p], ay[vector + p], az[vector + p]];
                let w = weights(simd, shape, self.weighting, axis);
                for k in 0..3 {
                    axis_weights[k][p] = w[k];
                }
            }
        }
        let order = self.order;
        let bx: Basis<V, P, T> = basis(simd, order, unit[0]);
        let by: Basis<V, P, T> = basis(simd, order, unit[1]);
        let bz: Basis<V, P, T> = basis(simd, order, unit[2]);
        let values = match &self.shape {
            Shape::One(coefficients) => contract(simd, order, [*coefficients], &bx, &by, &[bz]),
            Shape::Triangle(_, coefficients) => {
                let bz = weighted(simd, order, &bz, axis_weights);
                contract(simd, order, *coefficients, &bx, &by, &bz)
            }
        };
        self.scatter::<S, P>(vector, values, inside, out);
        P
    }

    /// Hands the poses their values.
    #[inline(always)]
    fn scatter<S: Simd<f64s = V>, const P: usize>(
        &self,
        vector: usize,
        values: Values<V, P>,
        inside: Block<V, P>,
        out: &mut [Evaluation],
    ) {
        let mut lanes = [[0.0; MAX_WIDTH * MAX_LANES]; 7];
        let count = P * S::F64_LANES;
        for (lanes, values) in lanes.iter_mut().zip(values.iter().chain([&inside])) {
            lanes[..count].copy_from_slice(cast_slice::<S::f64s, f64>(values));
        }
        let poses = &self.pose_of[vector * S::F64_LANES..][..count];
        let [x, y, z, rx, ry, rz, inside] = &lanes;
        for (lane, &pose) in poses.iter().enumerate() {
            // Not so for an empty slot.
            if let Some(out) = out.get_mut(pose as usize) {
                *out = Evaluation {
                    error: PoseError {
                        position_mm: Vector3::new(x[lane], y[lane], z[lane]),
                        rotation_rad: Vector3::new(rx[lane], ry[lane], rz[lane]),
                    },
                    is_inside: inside[lane] != 0.0,
                };
            }
        }
    }
}
