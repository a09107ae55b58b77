//! What a mesh is and what is wrong with it, in numbers and in words.

use super::bounds::Bounds;
use super::mesh::SurfaceMesh;
use super::mesh_reference::MeshUnit;
use super::weld::welded;
use nalgebra::{Point3, Vector3};
use rayon::slice::ParallelSliceMut;

/// Longest side of what a tracker follows: a coil's housing to a flexible endoscope.
const PLAUSIBLE_MM: [f64; 2] = [5.0, 1500.0];

/// Length of a hand-held instrument, to choose by where several units would do.
const USUAL_MM: f64 = 150.0;

/// Doubled area relative to the square of the longest side, below which a triangle has none. Corners
/// in f32 that were meant to be on a line stray by 1e-7 of it.
const NO_AREA: f64 = 1e-9;

/// A mesh in numbers. Corners at one place count as one, however the file has them.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshReport {
    pub parts: usize,
    pub triangles: usize,
    /// Corners where corners are.
    pub vertices: usize,
    /// Body frame, anatomy included; `None` for an empty mesh.
    pub bounds: Option<Bounds>,
    /// Triangles whose corners are on a line.
    pub without_area: usize,
    /// Edges with a triangle on one side only: the rims of holes.
    pub boundary_edges: usize,
    /// Edges of three triangles or more.
    pub non_manifold_edges: usize,
    /// Edges whose two triangles face opposite ways.
    pub turned_edges: usize,
    /// Pieces that share no vertex.
    pub components: usize,
    /// Whether a closed mesh shows its inside; it can then not be picked from outside.
    pub is_inside_out: bool,
    pub normals_made: bool,
    /// Triangles with a corner that is no finite number.
    pub triangles_left_out: usize,
    /// Where the size is one that no instrument has.
    pub suggestion: Option<UnitSuggestion>,
}

/// What is wrong with a body in millimetres whose ends are so far apart: no instrument is that long.
/// Nothing is wrong with a short one, as the sensors of a long tool may be close together.
pub fn length_doubt(found_mm: f64) -> Option<String> {
    let [_, longest_mm] = PLAUSIBLE_MM;
    if found_mm <= longest_mm {
        return None;
    }
    let in_mm = found_mm / 1000.0;
    let guess = match (PLAUSIBLE_MM[0]..=longest_mm).contains(&in_mm) {
        true => format!(": are its coordinates in µm? It is {} mm long then", figure(in_mm)),
        false => String::new(),
    };
    Some(format!("{} mm long, expected at most {longest_mm} mm{guess}", figure(found_mm)))
}

/// A unit in which the instrument would have a plausible size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitSuggestion {
    /// The longest side as it was read, and as it would be.
    pub found_mm: f64,
    pub suggested_mm: f64,
    /// The unit that the file was read in, and the one it may be in.
    pub read_in: MeshUnit,
    pub unit: MeshUnit,
}

impl UnitSuggestion {
    /// What the mesh would grow by.
    pub fn factor(&self) -> f64 {
        self.unit.mm_per_unit() / self.read_in.mm_per_unit()
    }

    /// Every unit that the file may be in, with the longest side that makes, in millimetres: the
    /// suggested one first, then those with a name.
    pub fn choices(&self) -> Vec<(MeshUnit, f64)> {
        let units = self.found_mm / self.read_in.mm_per_unit();
        let others = MeshUnit::NAMED.into_iter().chain([self.read_in]);
        let mut choices = vec![(self.unit, self.suggested_mm)];
        for unit in others {
            if choices.iter().all(|(known, _)| *known != unit) {
                choices.push((unit, units * unit.mm_per_unit()));
            }
        }
        choices
    }
}

/// A finding about a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    pub text: String,
    /// Whether somebody should do something about it.
    pub is_fault: bool,
}

impl Finding {
    fn fault(text: String) -> Self {
        Self { text, is_fault: true }
    }

    fn fact(text: &str) -> Self {
        Self { text: text.to_owned(), is_fault: false }
    }
}

impl std::fmt::Display for UnitSuggestion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let found = figure(self.found_mm);
        let suggested = figure(self.suggested_mm);
        match self.unit {
            MeshUnit::Factor(_) => write!(
                f,
                "{found} mm long: is the file in another unit than {}? {} times as long it is \
                 {suggested} mm",
                self.read_in,
                figure(self.factor()),
            ),
            unit => write!(
                f,
                "{found} mm long: is the file in {unit} rather than {}? It is {suggested} mm long \
                 then",
                self.read_in,
            ),
        }
    }
}

impl MeshReport {
    /// Looks at all parts of a mesh.
    pub fn of(mesh: &SurfaceMesh) -> Self {
        let places = Corners::of(mesh);
        let triangles = &places.triangles;
        let edges = Edges::of(triangles);
        let is_closed = edges.boundary == 0 && edges.non_manifold == 0;
        let all = mesh.parts.iter().flat_map(|part| &part.positions_mm);
        Self {
            parts: mesh.parts.len(),
            triangles: triangles.len(),
            vertices: places.positions_mm.len(),
            bounds: Bounds::around(all.copied()),
            without_area: triangles.iter().filter(|t| !places.has_area(t)).count(),
            boundary_edges: edges.boundary,
            non_manifold_edges: edges.non_manifold,
            turned_edges: edges.turned,
            components: components(places.positions_mm.len(), triangles),
            is_inside_out: is_closed && edges.turned == 0 && places.volume_mm3() < 0.0,
            normals_made: mesh.reading.normals_made,
            triangles_left_out: mesh.reading.triangles_left_out,
            suggestion: suggestion(mesh),
        }
    }

    /// Whether the surface has no holes.
    pub fn is_closed(&self) -> bool {
        self.triangles > 0 && self.boundary_edges == 0
    }

    /// The findings, a sentence each: what the mesh is first, then what is wrong with it.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!(
            "{} and {} in {}",
            counted(self.triangles, "triangle", "triangles"),
            counted(self.vertices, "vertex", "vertices"),
            counted(self.components, "piece", "pieces"),
        )];
        if let Some(bounds) = &self.bounds {
            let size = bounds.size_mm().map(figure);
            lines.push(format!("{} × {} × {} mm", size.x, size.y, size.z));
        }
        lines.extend(self.findings().into_iter().map(|finding| finding.text));
        lines
    }

    /// What is right and wrong with it, a sentence each.
    pub fn findings(&self) -> Vec<Finding> {
        let mut found = Vec::new();
        if self.is_closed() {
            found.push(Finding::fact("Closed"));
        } else if self.boundary_edges > 0 {
            let edges = counted(self.boundary_edges, "edge has", "edges have");
            let text = format!("Open: {edges} a triangle on one side only");
            found.push(Finding::fault(text));
        }
        let faults = [
            (self.non_manifold_edges, "edge has", "edges have", "more than two triangles"),
            (self.turned_edges, "edge has", "edges have", "triangles that face opposite ways"),
            (self.without_area, "triangle has", "triangles have", "no area"),
        ];
        for (count, one, many, what) in faults {
            if count > 0 {
                let text = format!("{} {what}", counted(count, one, many));
                found.push(Finding::fault(text));
            }
        }
        if self.triangles_left_out > 0 {
            let left_out = counted(self.triangles_left_out, "triangle was", "triangles were");
            found.push(Finding::fault(format!(
                "{left_out} left out, with corners that are no numbers"
            )));
        }
        if self.is_inside_out {
            let text = "Inside out: its triangles face inward".to_owned();
            found.push(Finding::fault(text));
        }
        if self.normals_made {
            found.push(Finding::fact("Without normals in the file; they were made"));
        }
        found.extend(self.suggestion.map(|it| Finding::fault(it.to_string())));
        found
    }
}

impl std::fmt::Display for MeshReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.lines().join("\n"))
    }
}

fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// Three significant digits, and no point where there are as many before it.
fn figure(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude == 0.0 || !(1e-6..1e9).contains(&magnitude) {
        return format!("{value}");
    }
    let decimals = (2 - magnitude.log10().floor() as i32).max(0);
    let text = format!("{value:.*}", decimals as usize);
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// The instrument alone decides, unless there is only anatomy.
fn suggestion(mesh: &SurfaceMesh) -> Option<UnitSuggestion> {
    let all = || mesh.parts.iter().flat_map(|part| part.positions_mm.iter());
    let bounds = mesh.body_bounds().or_else(|| Bounds::around(all().copied()))?;
    let found_mm = bounds.size_mm().amax();
    let is_plausible = |mm: f64| (PLAUSIBLE_MM[0]..=PLAUSIBLE_MM[1]).contains(&mm);
    let mm_per_unit = mesh.reading.mm_per_unit;
    let units = found_mm / mm_per_unit;
    if is_plausible(found_mm) || !units.is_normal() {
        return None;
    }
    let unusual = |unit: &MeshUnit| (units * unit.mm_per_unit() / USUAL_MM).ln().abs();
    let unit = MeshUnit::NAMED
        .into_iter()
        .filter(|unit| is_plausible(units * unit.mm_per_unit()))
        .min_by(|a, b| unusual(a).total_cmp(&unusual(b)))
        .unwrap_or_else(|| {
            // The power of ten that leads nearest to an instrument.
            let power = (USUAL_MM / found_mm).log10().round();
            MeshUnit::Factor(mm_per_unit * 10.0_f64.powf(power))
        });
    Some(UnitSuggestion {
        found_mm,
        suggested_mm: units * unit.mm_per_unit(),
        read_in: MeshUnit::of_mm(mm_per_unit),
        unit,
    })
}

/// A mesh whose corners at one place are one.
struct Corners {
    positions_mm: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
}

impl Corners {
    fn of(mesh: &SurfaceMesh) -> Self {
        let positions = mesh.parts.iter().flat_map(|part| &part.positions_mm);
        let positions: Vec<Point3<f64>> = positions.copied().collect();
        let places = welded(&positions);
        let count = places.iter().max().map_or(0, |last| *last as usize + 1);
        let mut positions_mm = vec![Point3::origin(); count];
        for (position, &place) in positions.iter().zip(&places) {
            positions_mm[place as usize] = *position;
        }
        let mut triangles = Vec::new();
        let mut first = 0;
        for part in &mesh.parts {
            let of_part = |t: &[u32; 3]| t.map(|i| places[first + i as usize]);
            triangles.extend(part.triangles.iter().map(of_part));
            first += part.positions_mm.len();
        }
        Self { positions_mm, triangles }
    }

    fn corners(&self, triangle: &[u32; 3]) -> [Point3<f64>; 3] {
        triangle.map(|i| self.positions_mm[i as usize])
    }

    fn has_area(&self, triangle: &[u32; 3]) -> bool {
        let [a, b, c] = self.corners(triangle);
        let sides = [b - a, c - b, a - c];
        let longest2 = sides.iter().fold(0.0_f64, |most, side| most.max(side.norm_squared()));
        sides[0].cross(&sides[1]).norm() > NO_AREA * longest2
    }

    /// Positive where triangles face outward (divergence theorem).
    fn volume_mm3(&self) -> f64 {
        let Some(&reference) = self.positions_mm.first() else {
            return 0.0;
        };
        self.triangles
            .iter()
            .map(|triangle| {
                let [a, b, c]: [Vector3<f64>; 3] = self.corners(triangle).map(|p| p - reference);
                a.dot(&b.cross(&c)) / 6.0
            })
            .sum()
    }
}

/// Edges by how many triangles they have.
#[derive(Default)]
struct Edges {
    boundary: usize,
    non_manifold: usize,
    turned: usize,
}

impl Edges {
    /// Triangles that have a vertex twice have no sides.
    fn of(triangles: &[[u32; 3]]) -> Self {
        let mut all: Vec<(u32, u32, bool)> = triangles
            .iter()
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
            .map(|(from, to)| (from.min(to), from.max(to), from < to))
            .collect();
        all.par_sort_unstable();
        let mut edges = Self::default();
        for edge in all.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            match edge {
                [_] => edges.boundary += 1,
                [one, other] => edges.turned += usize::from(one.2 == other.2),
                _ => edges.non_manifold += 1,
            }
        }
        edges
    }
}

/// Pieces of triangles that are connected by their vertices.
fn components(vertices: usize, triangles: &[[u32; 3]]) -> usize {
    let mut parents: Vec<u32> = (0..vertices as u32).collect();
    let mut is_used = vec![false; vertices];
    let mut joined = 0;
    for &[a, b, c] in triangles {
        for vertex in [a, b, c] {
            is_used[vertex as usize] = true;
        }
        for other in [b, c] {
            let (one, other) = (root(&mut parents, a), root(&mut parents, other));
            if one != other {
                parents[one.max(other) as usize] = one.min(other);
                joined += 1;
            }
        }
    }
    is_used.iter().filter(|&&used| used).count() - joined
}

fn root(parents: &mut [u32], mut vertex: u32) -> u32 {
    loop {
        let parent = parents[vertex as usize];
        if parent == vertex {
            return vertex;
        }
        // Halving the way keeps it short for the next.
        parents[vertex as usize] = parents[parent as usize];
        vertex = parent;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::MeshReading;
    use crate::surface::tests::cylinder;

    #[test]
    fn a_body_of_twenty_metres_is_doubted() {
        assert_eq!(length_doubt(1500.0), None);
        assert_eq!(length_doubt(0.7), None);
        assert_eq!(
            length_doubt(20_000.0).unwrap(),
            "20000 mm long, expected at most 1500 mm: are its coordinates in µm? It is 20 mm long then"
        );
        assert_eq!(length_doubt(2e7).unwrap(), "20000000 mm long, expected at most 1500 mm");
    }

    fn scaled(mesh: &SurfaceMesh, factor: f64, read_in: MeshUnit) -> SurfaceMesh {
        let mut mesh = mesh.clone();
        for position in mesh.parts.iter_mut().flat_map(|p| &mut p.positions_mm) {
            *position *= factor;
        }
        mesh.reading.mm_per_unit = read_in.mm_per_unit();
        mesh
    }

    #[test]
    fn corners_at_one_place_count_as_one() {
        let report = MeshReport::of(&cylinder(2.0, 150.0, 16));
        assert!(report.is_closed() && !report.is_inside_out);
        // Two rims and two centres; two triangles a side and two on the caps.
        assert_eq!((report.vertices, report.triangles), (34, 64));
        assert_eq!((report.components, report.without_area), (1, 0));
        assert_eq!((report.non_manifold_edges, report.turned_edges), (0, 0));
        assert_eq!(report.suggestion, None);
        let expected = ["64 triangles and 34 vertices in 1 piece", "4 × 4 × 150 mm", "Closed"];
        assert_eq!(report.lines(), expected);
    }

    #[test]
    fn corners_apart_by_round_off_count_as_one() {
        let mut mesh = cylinder(2.0, 150.0, 16);
        // Each corner of each triangle is computed by itself.
        for (index, position) in mesh.parts[0].positions_mm.iter_mut().enumerate() {
            position.x += (index % 3) as f64 * 1e-16;
            position.y -= (index % 2) as f64 * 1e-16;
        }
        let report = MeshReport::of(&mesh);
        assert!(report.is_closed(), "{report}");
        assert_eq!((report.vertices, report.components), (34, 1));
    }

    #[test]
    fn what_is_wrong_is_counted_and_reported() {
        let mut mesh = cylinder(2.0, 150.0, 16);
        let mut copy = cylinder(2.0, 150.0, 16).parts.remove(0);
        for position in &mut copy.positions_mm {
            position.x += 10.0;
        }
        // A hole of one triangle, one turned around, one in the tube's inside, and one of no area.
        copy.triangles.remove(0);
        copy.triangles[20].swap(0, 1);
        let [a, b, _] = mesh.parts[0].triangles[0];
        let axis = mesh.parts[0].triangles[2][0];
        mesh.parts[0].triangles.extend([[a, b, axis], [a, a, b]]);
        mesh.parts.push(copy);
        mesh.reading = MeshReading { normals_made: true, triangles_left_out: 1, ..mesh.reading };
        let report = MeshReport::of(&mesh);
        assert_eq!(report.components, 2);
        // The rim's edge gets a third triangle, or its neighbour from the cap to the centre.
        assert!(report.non_manifold_edges >= 1, "{report}");
        assert_eq!((report.turned_edges, report.without_area), (3, 1));
        assert!(report.boundary_edges >= 3);
        let text = report.to_string();
        for part in [
            "in 2 pieces",
            "Open: ",
            "more than two triangles",
            "3 edges have triangles that face opposite ways",
            "1 triangle has no area",
            "1 triangle was left out, with corners that are no numbers",
            "Without normals in the file",
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
    }

    #[test]
    fn a_mesh_that_faces_inward_is_inside_out() {
        let mut mesh = cylinder(2.0, 150.0, 16);
        for triangle in &mut mesh.parts[0].triangles {
            triangle.swap(1, 2);
        }
        assert!(MeshReport::of(&mesh).is_inside_out);
        // Far from the origin as well.
        for position in &mut mesh.parts[0].positions_mm {
            position.x += 1e4;
        }
        assert!(MeshReport::of(&mesh).is_inside_out);
    }

    #[test]
    fn implausible_sizes_suggest_a_unit() {
        use MeshUnit::{Centimetre, Factor, Inch, Metre, Millimetre};
        let pointer = cylinder(2.0, 150.0, 8);
        for (factor, read_in, unit, suggested_mm) in [
            // Metres in a file that states millimetres, and the other way round.
            (0.001, Millimetre, Metre, 150.0),
            (1000.0, Metre, Millimetre, 150.0),
            (100.0, Metre, Centimetre, 150.0),
            (1.0 / 50.8, Millimetre, Inch, 75.0),
            (1e-6, Millimetre, Factor(1e6), 150.0),
            (20.0, Millimetre, Factor(0.1), 300.0),
        ] {
            let report = MeshReport::of(&scaled(&pointer, factor, read_in));
            let found = report.suggestion.unwrap();
            let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-9;
            assert!(near(found.unit.mm_per_unit(), unit.mm_per_unit()), "{found}");
            assert!(near(found.suggested_mm, suggested_mm), "{found}");
            assert!(near(found.factor() * found.found_mm, suggested_mm));
            assert_eq!(report.lines().last(), Some(&found.to_string()));
        }
        let words = |factor, read_in| {
            let report = MeshReport::of(&scaled(&pointer, factor, read_in));
            report.suggestion.unwrap().to_string()
        };
        assert_eq!(
            words(1000.0, Metre),
            "150000 mm long: is the file in mm rather than m? It is 150 mm long then"
        );
        assert_eq!(
            words(20.0, Millimetre),
            "3000 mm long: is the file in another unit than mm? 0.1 times as long it is 300 mm"
        );
    }

    #[test]
    fn an_empty_mesh_is_nothing() {
        let report = MeshReport::of(&SurfaceMesh::default());
        assert_eq!((report.triangles, report.components), (0, 0));
        assert!(report.suggestion.is_none() && !report.is_closed() && !report.is_inside_out);
        assert_eq!(report.to_string(), "0 triangles and 0 vertices in 0 pieces");
    }
}
