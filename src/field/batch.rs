//! Many evaluations of one model at scattered poses, grouped by spherical triangle.
//!
//! Poses that share a triangle share their coefficients. So poses are sorted by triangle, by
//! counting, and each group runs through [`super::kernel`] with as many poses at a time as the
//! machine has lanes. What a pose gets does not depend on the poses beside it.

use super::kernel::{
    Basis, Block, LaneBounds, MAX_TERMS, Values, basis, contract, weighted, weights,
};
use super::model::{Coefficient, DistortionModel, Evaluation, OutsidePolicy};
use super::samples::PoseError;
use crate::geometry::directions::{DirectionSet, Sphere, TriangleShape, Weighting};
use nalgebra::{Point3, Unit, Vector3};
use pulp::bytemuck::{Pod, cast_slice};
use pulp::{Arch, Simd, WithSimd};

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
}

impl Batch {
    /// Buffers that use certain instructions; the results agree to a few units in the last place.
    pub fn with_instructions(instructions: Instructions) -> Self {
        Self {
            instructions,
            ..Self::default()
        }
    }

    /// What [`DistortionModel::evaluate`] gives at each pose, to a few units in the last place of
    /// the largest coefficient.
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
        let nothing = Evaluation {
            error: PoseError::default(),
            is_inside: false,
        };
        out.resize(positions_mm.len(), nothing);
        if model.order() == 0 {
            for (evaluation, position_mm) in out.iter_mut().zip(positions_mm) {
                *evaluation = Evaluation {
                    is_inside: model.bounds().contains(position_mm),
                    ..nothing
                };
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
    Triangle(TriangleShape, [&'a [Coefficient]; 3]),
}

impl<'a> Shape<'a> {
    fn new(model: &'a DistortionModel, sphere: &Sphere, triangle: usize) -> Self {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::samples::MapKind;
    use crate::geometry::bounds::Bounds;

    /// Numbers from -1 to 1 that repeat no pattern, the same each time.
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }
    }

    fn model(order: usize, set: DirectionSet, weighting: Weighting) -> DistortionModel {
        let mut numbers = Numbers(order as u64);
        let count = set.len() * (order + 1).pow(3);
        DistortionModel::new(
            order,
            set,
            weighting,
            MapKind::Distortion,
            Bounds::from(([-100.0, -50.0, -300.0], [100.0, 50.0, -100.0])),
            (0..count)
                .map(|_| std::array::from_fn(|_| numbers.next()))
                .collect(),
        )
        .unwrap()
    }

    /// Poses in and around the box, axes everywhere and at all special places.
    fn poses(count: usize, set: DirectionSet) -> (Vec<Point3<f64>>, Vec<Unit<Vector3<f64>>>) {
        let mut numbers = Numbers(99);
        let corners = set.directions().iter().map(|a| a.into_inner());
        let edges = set.triangles().iter().map(|t| {
            set.directions()[t[0]].into_inner() + set.directions()[t[1]].into_inner() * 0.7
        });
        let special: Vec<_> = corners.chain(edges).collect();
        (0..count)
            .map(|i| {
                let p = Point3::new(
                    120.0 * numbers.next(),
                    60.0 * numbers.next(),
                    -200.0 + 110.0 * numbers.next(),
                );
                let anywhere = Vector3::from_fn(|_, _| numbers.next());
                let axis = match i % 3 {
                    0 => special[i / 3 % special.len()],
                    _ => anywhere,
                };
                (p, Unit::new_normalize(axis))
            })
            .unzip()
    }

    fn difference(a: &Evaluation, b: &Evaluation) -> f64 {
        (a.error.position_mm - b.error.position_mm)
            .amax()
            .max((a.error.rotation_rad - b.error.rotation_rad).amax())
    }

    const LEVELS: [Instructions; 3] = [
        Instructions::Best,
        Instructions::Avx2,
        Instructions::Portable,
    ];

    #[test]
    fn a_batch_gives_what_single_evaluations_give() {
        for set in DirectionSet::ALL {
            for weighting in [Weighting::Area, Weighting::Gnomonic] {
                for order in 1..=8 {
                    let model = model(order, set, weighting);
                    let (positions, axes) = poses(150, set);
                    for outside in [
                        OutsidePolicy::Clamp,
                        OutsidePolicy::Reject,
                        OutsidePolicy::Extrapolate,
                    ] {
                        // Outside the box a polynomial of order 8 reaches some hundred.
                        let scale = if outside == OutsidePolicy::Extrapolate {
                            1e3
                        } else {
                            1.0
                        };
                        for level in LEVELS {
                            let mut out = Vec::new();
                            Batch::with_instructions(level)
                                .evaluate(&model, &positions, &axes, outside, &mut out);
                            for ((p, a), found) in positions.iter().zip(&axes).zip(&out) {
                                let expected = model.evaluate(p, a, outside);
                                assert_eq!(found.is_inside, expected.is_inside);
                                let d = difference(found, &expected);
                                assert!(
                                    d <= 1e-13 * scale,
                                    "{set:?} {weighting:?} order {order} {outside:?} {level:?} {d}"
                                );
                            }
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn what_a_pose_gets_does_not_depend_on_the_poses_beside_it() {
        for set in [DirectionSet::One, DirectionSet::Fourteen] {
            let model = model(4, set, Weighting::Area);
            let (positions, axes) = poses(2 * CHUNK + 77, set);
            for level in LEVELS {
                let mut batch = Batch::with_instructions(level);
                let (mut all, mut part) = (Vec::new(), Vec::new());
                let outside = OutsidePolicy::Clamp;
                batch.evaluate(&model, &positions, &axes, outside, &mut all);
                for (start, len) in [(0, 1), (5, 2), (13, 8), (100, 17), (CHUNK - 3, 300)] {
                    let range = start..start + len;
                    let (p, a) = (&positions[range.clone()], &axes[range.clone()]);
                    batch.evaluate(&model, p, a, outside, &mut part);
                    assert_eq!(part, all[range], "{set:?} {level:?} {start} {len}");
                }
            }
        }
    }

    /// A model of order 1 whose field is one number an orientation; in a corner of the box, where
    /// one product of the basis is 1 and the others are 0, the answer is the blend of those.
    fn blend(set: DirectionSet, values: impl Fn(usize) -> f64) -> DistortionModel {
        let coefficients = (0..set.len() * 8).map(|i| [values(i / 8); 6]).collect();
        let bounds = Bounds::from(([0.0; 3], [1.0; 3]));
        let map = MapKind::Distortion;
        DistortionModel::new(1, set, Weighting::Area, map, bounds, coefficients).unwrap()
    }

    fn blended_in_a_corner(
        model: &DistortionModel,
        axis: Vector3<f64>,
        level: Instructions,
    ) -> f64 {
        let mut out = Vec::new();
        Batch::with_instructions(level).evaluate(
            model,
            &[Point3::origin()],
            &[Unit::new_normalize(axis)],
            OutsidePolicy::Clamp,
            &mut out,
        );
        out[0].error.position_mm.x
    }

    #[test]
    fn on_a_corner_its_weight_is_exactly_one() {
        for set in DirectionSet::ALL {
            let model = blend(set, |d| d as f64 + 1.0);
            for (d, axis) in set.directions().iter().enumerate() {
                for level in LEVELS {
                    let found = blended_in_a_corner(&model, axis.into_inner(), level);
                    assert_eq!(found, d as f64 + 1.0, "{set:?} {level:?}");
                }
            }
        }
    }

    #[test]
    fn on_an_edge_the_weight_of_the_corner_opposite_is_exactly_zero() {
        for set in DirectionSet::ALL.into_iter().skip(1) {
            for t in set.triangles() {
                let [a, b] = [t[0], t[1]].map(|i| set.directions()[i].into_inner());
                let on_edge = |d| if d == t[0] || d == t[1] { 1.0 } else { 1e300 };
                let model = blend(set, on_edge);
                for level in LEVELS {
                    let found = blended_in_a_corner(&model, a + b * 0.7, level);
                    assert!((found - 1.0).abs() < 1e-15, "{set:?} {level:?} {found}");
                }
            }
        }
    }

    #[test]
    fn order_zero_is_no_error_and_still_knows_its_box() {
        let model = DistortionModel::zero(Bounds::from(([0.0; 3], [1.0; 3])), MapKind::Distortion);
        let positions = [Point3::new(0.5, 0.5, 0.5), Point3::new(2.0, 0.5, 0.5)];
        let axes = [Vector3::z_axis(); 2];
        let mut out = Vec::new();
        Batch::default().evaluate(&model, &positions, &axes, OutsidePolicy::Clamp, &mut out);
        assert_eq!(out.len(), 2);
        assert!(out.iter().all(|e| e.error == PoseError::default()));
        assert_eq!([out[0].is_inside, out[1].is_inside], [true, false]);
    }

    #[test]
    fn no_poses_have_no_evaluations() {
        let model = model(2, DirectionSet::Six, Weighting::Area);
        let mut out =
            vec![model.evaluate(&Point3::origin(), &Vector3::z_axis(), OutsidePolicy::Clamp)];
        Batch::default().evaluate(&model, &[], &[], OutsidePolicy::Clamp, &mut out);
        assert!(out.is_empty());
    }

    #[test]
    fn what_is_not_a_number_harms_no_other_pose() {
        for set in DirectionSet::ALL {
            for weighting in [Weighting::Area, Weighting::Gnomonic] {
                let model = model(3, set, weighting);
                let (mut positions, mut axes) = poses(40, set);
                let mut before = Vec::new();
                let mut after = Vec::new();
                let outside = OutsidePolicy::Clamp;
                for level in LEVELS {
                    let mut batch = Batch::with_instructions(level);
                    batch.evaluate(&model, &positions, &axes, outside, &mut before);
                    let kept = (positions[7], axes[9]);
                    positions[7] = Point3::new(f64::NAN, f64::INFINITY, 0.0);
                    axes[9] = Unit::new_unchecked(Vector3::new(f64::NAN, 0.0, 1.0));
                    batch.evaluate(&model, &positions, &axes, outside, &mut after);
                    assert!(!after[7].is_inside);
                    // The nearest point of the box stands for any position.
                    assert!(after[7].error.position_mm.iter().all(|v| v.is_finite()));
                    let is_ignored = set == DirectionSet::One;
                    assert_eq!(after[9].error.position_mm.x.is_nan(), !is_ignored);
                    for i in (0..40).filter(|i| ![7, 9].contains(i)) {
                        assert_eq!(before[i], after[i]);
                    }
                    (positions[7], axes[9]) = kept;
                }
            }
        }
    }
}
