//! The sum over the 64 nodes around a place, with the numbers of a node in the lanes of the machine's
//! vectors. Places of one cell share the loads of its nodes.

use super::even_harmonics::{self, MAX_FUNCTIONS, functions};
use super::spline::LOCAL;
use super::{CompiledField, MAX_STRIDE};
use crate::evaluation::Coefficient;
use nalgebra::{Unit, Vector3};
use pulp::{Simd, WithSimd};

/// A node's numbers come in whole vectors of any machine.
pub const LANES: usize = 8;

/// Places that share the loads of a node: four sums and four nodes' numbers are in registers at once.
const TOGETHER: usize = 4;

/// The values of a field at places in the unit cube.
pub(super) struct Accumulation<'a> {
    pub field: &'a CompiledField,
    pub units: &'a [Vector3<f64>],
    pub axes: &'a [Unit<Vector3<f64>>],
    pub out: &'a mut [Coefficient],
}

/// The functions around a place.
#[derive(Clone, Copy, Default)]
struct LocalWeights {
    /// Index of its first node.
    node: usize,
    weights: [[f64; LOCAL]; 3],
}

impl WithSimd for Accumulation<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let mut places = vec![LocalWeights::default(); self.units.len()];
        for (place, unit) in places.iter_mut().zip(self.units) {
            *place = self.field.place(unit);
        }
        let mut order: Vec<u32> = (0..places.len() as u32).collect();
        order.sort_unstable_by_key(|&i| places[i as usize].node);
        let stride = self.field.stride();
        let mut sums = [[0.0; MAX_STRIDE]; TOGETHER];
        let mut rest = order.as_slice();
        while let Some(&first) = rest.first() {
            let node = places[first as usize].node;
            let same = rest.iter().take(TOGETHER);
            let same = same.take_while(|&&i| places[i as usize].node == node).count();
            let (own, after) = rest.split_at(same);
            rest = after;
            for sums in &mut sums {
                sums[..stride].fill(0.0);
            }
            if let &[a, b, c, d] = own {
                let own = [
                    &places[a as usize],
                    &places[b as usize],
                    &places[c as usize],
                    &places[d as usize],
                ];
                self.field.accumulate(simd, own, &mut sums);
            } else {
                for (&i, sums) in own.iter().zip(sums.chunks_exact_mut(1)) {
                    self.field.accumulate(simd, [&places[i as usize]], sums);
                }
            }
            for (&i, sums) in own.iter().zip(&sums) {
                let i = i as usize;
                self.out[i] = self.field.contracted(sums, &self.axes[i]);
            }
        }
    }
}

impl CompiledField {
    #[inline(always)]
    fn place(&self, unit: &Vector3<f64>) -> LocalWeights {
        let [ax, ay, az] = self.axes;
        let (x, y, z) = (ax.at(unit.x), ay.at(unit.y), az.at(unit.z));
        LocalWeights {
            node: (x.first * ay.functions() + y.first) * az.functions() + z.first,
            weights: [x.values, y.values, z.values],
        }
    }

    /// Adds the 64 nodes of places that share them. Arrays are filled by loops: `map` of an array is
    /// a call for each, without the machine's vectors.
    #[inline(always)]
    fn accumulate<S: Simd, const P: usize>(
        &self,
        simd: S,
        places: [&LocalWeights; P],
        sums: &mut [[f64; MAX_STRIDE]],
    ) {
        let stride = self.stride();
        let vectors = stride / S::F64_LANES;
        let [_, ay, az] = self.axes;
        let (along_y, along_z) = (ay.functions(), az.functions());
        for i in 0..LOCAL {
            for j in 0..LOCAL {
                let row = places[0].node + (i * along_y + j) * along_z;
                let nodes = &self.coefficients[row * stride..][..LOCAL * stride];
                let (nodes, _) = S::as_simd_f64s(nodes);
                let (a, rest) = nodes.split_at(vectors);
                let (b, rest) = rest.split_at(vectors);
                let (c, d) = rest.split_at(vectors);
                let mut weights = [[simd.splat_f64s(0.0); LOCAL]; P];
                for p in 0..P {
                    let [x, y, z] = &places[p].weights;
                    for k in 0..LOCAL {
                        weights[p][k] = simd.splat_f64s(x[i] * y[j] * z[k]);
                    }
                }
                let nodes = a.iter().zip(b).zip(c).zip(d);
                for (v, (((a, b), c), d)) in nodes.enumerate() {
                    for p in 0..P {
                        let [wa, wb, wc, wd] = weights[p];
                        let sum = &mut S::as_mut_simd_f64s(&mut sums[p]).0[v];
                        let low = simd.mul_add_f64s(wb, *b, simd.mul_add_f64s(wa, *a, *sum));
                        *sum = simd.mul_add_f64s(wd, *d, simd.mul_add_f64s(wc, *c, low));
                    }
                }
            }
        }
    }

    /// The sum over the functions of the axis.
    #[inline(always)]
    fn contracted(&self, sums: &[f64; MAX_STRIDE], axis: &Vector3<f64>) -> Coefficient {
        let mut by_axis = [0.0; MAX_FUNCTIONS];
        even_harmonics::values(self.degree, axis, &mut by_axis);
        let mut value = [0.0; 6];
        let each = sums.chunks_exact(6).zip(&by_axis[..functions(self.degree)]);
        for (values, by_axis) in each {
            for (sum, v) in value.iter_mut().zip(values) {
                *sum += by_axis * v;
            }
        }
        value
    }
}
