//! The slice: its lattice with a colour at each point, hatched where there is no value or the model
//! is not valid, with a line where the requirement is passed.

use super::drawing::Drawing;
use super::palette::Rgb;
use nalgebra::Point3;
use serde_json::{Value, json};
use trackwright_formats::gltf::write::{Elements, MaterialId, NodeId, Shape};
use trackwright_geometry::color::linear;
use trackwright_geometry::colormap::{
    LEVEL_LINE_SRGB, NO_VALUE_LINE_SRGB, NO_VALUE_SRGB, UNSUPPORTED_LINE_OPACITY,
    UNSUPPORTED_LINE_SRGB,
};
use trackwright_simulation::SliceOutcome;

/// How far lines are from the plane that they are drawn on, to either side.
const LIFT_MM: f64 = 0.4;

/// The cells of a slice.
struct Cells<'a> {
    slice: &'a SliceOutcome,
    /// At the points of the lattice; `None` where there is none.
    values: Vec<Option<f64>>,
}

impl<'a> Cells<'a> {
    fn of(slice: &'a SliceOutcome) -> Self {
        let [nu, nv] = slice.plan.counts;
        let places = (0..nv).flat_map(|v| (0..nu).map(move |u| [u, v]));
        let values = places.map(|[u, v]| slice.value_at([u as f64, v as f64]));
        Self { values: values.collect(), slice }
    }

    /// Corners in turn around a cell, as numbers of the lattice's points.
    fn corners(&self, [u, v]: [usize; 2]) -> [usize; 4] {
        let nu = self.slice.plan.counts[0];
        [v * nu + u, v * nu + u + 1, (v + 1) * nu + u + 1, (v + 1) * nu + u]
    }

    fn all(&self) -> impl Iterator<Item = [usize; 2]> + use<> {
        let [nu, nv] = self.slice.plan.counts;
        (0..nv - 1).flat_map(move |v| (0..nu - 1).map(move |u| [u, v]))
    }

    /// Whether each corner of a cell has a value.
    fn has_values(&self, cell: [usize; 2]) -> bool {
        let corners = self.corners(cell);
        corners.iter().all(|corner| self.values[*corner].is_some())
    }

    fn is_supported(&self, cell: [usize; 2]) -> bool {
        let supported = &self.slice.is_supported;
        let corners = self.corners(cell);
        corners.iter().all(|corner| supported.get(*corner).copied().unwrap_or(true))
    }

    fn point_mm(&self, corner: usize) -> Point3<f64> {
        let nu = self.slice.plan.counts[0];
        self.slice.plan.point_mm(corner % nu, corner / nu)
    }

    /// Lines through some cells from corner to corner, along both of the plane's axes or against one
    /// of them. They go on from cell to cell: every other diagonal, whichever way it runs.
    fn hatching(&self, cells: &[[usize; 2]], is_along: bool) -> Vec<[Point3<f64>; 2]> {
        let cells = cells.iter().filter(|[u, v]| (u + v).is_multiple_of(2));
        let ends = cells.map(|cell| {
            let [a, b, c, d] = self.corners(*cell);
            match is_along {
                true => [a, c],
                false => [b, d],
            }
        });
        ends.map(|ends| ends.map(|corner| self.point_mm(corner))).collect()
    }

    /// Where values pass a level, linear in each half of a cell.
    fn level(&self, level: f64) -> Vec<[Point3<f64>; 2]> {
        let mut lines = Vec::new();
        for cell in self.all().filter(|cell| self.has_values(*cell)) {
            let [a, b, c, d] = self.corners(cell);
            for triangle in [[a, b, c], [a, c, d]] {
                let passes = [[0, 1], [1, 2], [2, 0]].map(|[i, j]| {
                    let ends = [triangle[i], triangle[j]];
                    let [from, to] = ends.map(|corner| self.values[corner]);
                    let (from, to) = (from? - level, to? - level);
                    ((from < 0.0) != (to < 0.0)).then(|| {
                        let [p, q] = ends.map(|corner| self.point_mm(corner));
                        p + (q - p) * (from / (from - to))
                    })
                });
                let mut ends = passes.into_iter().flatten();
                if let (Some(p), Some(q)) = (ends.next(), ends.next()) {
                    lines.push([p, q]);
                }
            }
        }
        lines
    }
}

impl Drawing<'_> {
    /// The slice's nodes: what is coloured, what has no value, and the lines over them.
    pub(super) fn slice(&mut self) -> Vec<NodeId> {
        let Some(slice) = &self.sampled.slice else {
            return Vec::new();
        };
        let max = self.stage.view.slice_range().unwrap_or(slice.p95);
        let map = self.stage.view.color_maps().slice;
        let cells = Cells::of(slice);
        let (colored, empty): (Vec<_>, Vec<_>) =
            cells.all().partition(|cell| cells.has_values(*cell));
        let quantity = slice.quantity;
        if !colored.is_empty() {
            let decimals = quantity.decimals();
            self.colors.push(format!(
                "slice: {}, 0 to {max:.decimals$} {}, {}",
                quantity.label(),
                quantity.unit(),
                map.name()
            ));
        }
        let extras = json!({
            "quantity": quantity.label(),
            "unit": quantity.unit(),
            "color_map": map.name(),
            "from": 0.0,
            "to": max,
            "largest": slice.max,
        });
        let color = |value: Option<f64>| {
            let srgb = value.map_or(NO_VALUE_SRGB, |value| map.srgb_of_value(value, max));
            let [r, g, b] = linear(srgb);
            [r, g, b, 1.0]
        };
        let name = format!("slice, {}", quantity.label());
        let material = self.vertex_colors(false);
        let mut nodes = Vec::new();
        nodes.extend(self.cells(&name, (&cells, &colored), color, material, extras));
        let grey = |_: Option<f64>| color(None);
        let name = "slice, no value";
        nodes.extend(self.cells(name, (&cells, &empty), grey, material, Value::Null));
        let unsupported: Vec<_> =
            colored.iter().copied().filter(|cell| !cells.is_supported(*cell)).collect();
        let requirement = self.stage.design().requirement;
        let level = requirement.and_then(|of| quantity.limit(&of));
        let lines = [
            (
                "hatching where there is no value",
                cells.hatching(&empty, true),
                Rgb::same(NO_VALUE_LINE_SRGB),
                1.0,
            ),
            (
                "hatching where the model is not valid",
                cells.hatching(&unsupported, false),
                Rgb::same(UNSUPPORTED_LINE_SRGB),
                UNSUPPORTED_LINE_OPACITY,
            ),
            (
                "line at the requirement",
                level.map_or_else(Vec::new, |level| cells.level(level)),
                Rgb::same(LEVEL_LINE_SRGB),
                1.0,
            ),
        ];
        let lift = slice.plan.plane.normal().into_inner() * LIFT_MM;
        for (name, lines, color, alpha) in lines {
            if lines.is_empty() {
                continue;
            }
            let material = self.unlit(name, color, alpha);
            let both: Vec<[Point3<f64>; 2]> = lines
                .iter()
                .flat_map(|line| [lift, -lift].map(|off| line.map(|end| end + off)))
                .collect();
            nodes.extend(self.lines(name, both.iter().map(|line| &line[..]), material));
        }
        nodes
    }

    /// Some cells with a colour at each corner.
    fn cells(
        &mut self,
        name: &str,
        (cells, chosen): (&Cells, &[[usize; 2]]),
        color: impl Fn(Option<f64>) -> [f64; 4],
        material: MaterialId,
        extras: Value,
    ) -> Option<NodeId> {
        let mut number_of = vec![None; cells.values.len()];
        let (mut positions, mut colors, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
        for cell in chosen {
            let [a, b, c, d] = cells.corners(*cell).map(|corner| {
                *number_of[corner].get_or_insert_with(|| {
                    positions.push(cells.point_mm(corner));
                    colors.push(color(cells.values[corner]));
                    positions.len() as u32 - 1
                })
            });
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        let shape = Shape::unlit(&positions, &colors, Elements::Triangles(&triangles));
        let shape = self.writer.shape(name, &shape);
        self.shape_node(name, shape, material, extras)
    }
}
