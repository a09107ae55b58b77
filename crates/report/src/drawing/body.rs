//! A body from three sides in third-angle projection, at one scale, with its sensors' places as
//! dimensions from the tip or the frame's origin.

use super::dimension::{across, scale_bar, upright};
use super::is_drawable;
use super::marks;
use super::paper::{Paper, parts, text};
use maud::{Markup, html};
use nalgebra::{Point3, Unit, Vector3};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::{RigidBody, Sensor};

const WIDTH_PX: f64 = 1000.0;

/// Largest height of the three views together, without dimensions.
const VIEWS_HEIGHT_PX: f64 = 380.0;

/// No drawing is magnified further than this: a coil is 9 mm long.
const MOST_PX_PER_MM: f64 = 8.0;

const EDGE_PX: f64 = 16.0;
const GAP_PX: f64 = 52.0;
/// For the balloons over a view.
const BALLOONS_PX: f64 = 40.0;
/// From one dimension line to the next.
const STEP_PX: f64 = 24.0;

/// Most dimensions along one axis; those of more sensors are in the table.
const MOST_DIMENSIONS: usize = 8;

/// Places nearer to each other are one place on paper.
const SAME_MM: f64 = 0.005;

/// A letter of the datum's word, and from the datum to the word's end with its halo.
const LETTER_PX: f64 = 9.5;
const WORD_OFF_PX: f64 = 16.0;

/// Room around what is drawn.
const MARGIN_MM: f64 = 3.0;

/// A body many times larger than the group of its sensors is drawn twice: as it is, and the sensors
/// alone at a scale at which their places can be read.
const CROWDED: f64 = 4.0;

/// The drawings of a body, dimensions from the tip, or from the frame's origin where it has none.
pub fn body_drawings(body: &RigidBody, mesh: Option<&SurfaceMesh>) -> Vec<Markup> {
    let datum = Some(body.judged_tip_in_body()).filter(is_drawable);
    let datum = datum.unwrap_or_else(Point3::origin);
    let mesh = mesh.filter(|mesh| mesh.body_bounds().is_some());
    let whole_mm = mesh.and_then(SurfaceMesh::body_bounds).map(|bounds| bounds.diagonal_mm());
    let places = drawn_sensors(body).map(|(_, sensor)| sensor.position_in_body);
    let group_mm = Bounds::around(places.chain([datum])).map(|bounds| bounds.diagonal_mm());
    match (whole_mm, group_mm) {
        (Some(whole), Some(group)) if whole > CROWDED * group && group > 0.0 => vec![
            drawing(body, mesh, datum, Shown::Shape),
            drawing(body, None, datum, Shown::Sensors),
        ],
        _ => vec![drawing(body, mesh, datum, Shown::Sensors)],
    }
}

/// What has numbers and dimensions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shown {
    /// The body alone: sensors are marked where they are.
    Shape,
    Sensors,
}

fn drawing(
    body: &RigidBody,
    mesh: Option<&SurfaceMesh>,
    datum: Point3<f64>,
    shown: Shown,
) -> Markup {
    let sheet = Sheet::new(body, mesh, datum, shown);
    let word = datum_word(body);
    let [front, top, side] = sheet.papers();
    let title = format!("{} from three sides, with the places of its sensors", body.name);
    html! {
        svg class="drawing" role="img" viewBox=(format!("0 0 {WIDTH_PX:.0} {:.0}", sheet.height_px())) {
            title { (title) }
            @for paper in [&top, &front, &side] {
                @if let Some(mesh) = mesh {
                    @let mut drawn = parts(paper, mesh, &Pose::identity());
                    @let () = drawn.sort_by(|a, b| a.depth_mm.total_cmp(&b.depth_mm));
                    @for part in drawn.iter().filter(|part| !part.is_anatomy) {
                        (part.draw("part"))
                    }
                }
            }
            (sheet.dimensions(&front, &side))
            @for (paper, top_px) in [(&front, sheet.front_top_px()), (&top, sheet.top_top_px()), (&side, sheet.front_top_px())] {
                @let places: Vec<(usize, [f64; 2])> = drawn_sensors(body).map(|(number, s)| (number, paper.at(&s.position_in_body))).collect();
                @if shown == Shown::Sensors { (marks::balloons(&places, top_px - BALLOONS_PX + 12.0)) }
                @for (number, sensor) in drawn_sensors(body) {
                    (marks::sensor(paper, sensor, number))
                }
                (marks::datum(paper, &datum, word))
            }
            (marks::axes(&front, [EDGE_PX + 24.0, sheet.height_px() - 30.0]))
            (scale_bar([EDGE_PX + 110.0, sheet.height_px() - 30.0], sheet.px_per_mm, 110.0))
            (text("quiet", "end", [WIDTH_PX - EDGE_PX, sheet.height_px() - 25.0],
                &format!("dimensions in mm from the {word}")))
        }
    }
}

/// What stands at the left of the datum.
fn datum_word(body: &RigidBody) -> &'static str {
    match body.tip_in_body {
        Some(_) => "tip",
        None => "origin",
    }
}

/// The sensors with their numbers in the table, from 1.
fn drawn_sensors(body: &RigidBody) -> impl Iterator<Item = (usize, &Sensor)> {
    let numbered = (1..).zip(&body.sensors);
    numbered.filter(|(_, sensor)| is_drawable(&sensor.position_in_body))
}

/// What is drawn where.
struct Sheet {
    /// To the right, up, and to the reader of the front view; axes of the body's frame.
    axes: [Unit<Vector3<f64>>; 3],
    /// From where to where the body reaches along them.
    spans_mm: [[f64; 2]; 3],
    /// Of the body itself, where its shape is known.
    whole_mm: Option<[[f64; 2]; 3]>,
    datum: Point3<f64>,
    px_per_mm: f64,
    /// How far the datum's word reaches out of the front view at its left.
    word_px: f64,
    /// Dimension lines below and beside the front view, and below the side view.
    rows: [Vec<f64>; 3],
}

impl Sheet {
    fn new(body: &RigidBody, mesh: Option<&SurfaceMesh>, datum: Point3<f64>, shown: Shown) -> Self {
        let coil_ends = body.sensors.iter().flat_map(|sensor| {
            let half_mm = sensor.coil.map_or(0.0, |coil| coil.length_mm / 2.0);
            let axis = sensor.axis_in_body().map_or(Vector3::zeros(), Unit::into_inner);
            [-half_mm, half_mm].map(|along| sensor.position_in_body + axis * along)
        });
        let mesh_bounds = mesh.and_then(SurfaceMesh::body_bounds);
        let corners = mesh_bounds.iter().flat_map(Bounds::corners_mm);
        let points = coil_ends.chain(corners).chain([datum]);
        let bounds = Bounds::around(points.filter(is_drawable));
        let bounds =
            bounds.unwrap_or(Bounds { min_mm: Point3::origin(), max_mm: Point3::origin() });
        let axes = axes_of(&bounds);
        let spans_mm = axes.map(|axis| {
            let [low, high] = bounds.span_mm(&axis);
            [low - MARGIN_MM, high + MARGIN_MM]
        });
        let whole_mm = mesh_bounds.map(|bounds| axes.map(|axis| bounds.span_mm(&axis)));
        let rows = [0, 1, 2].map(|k| {
            let mut places: Vec<f64> = Vec::new();
            let zero = axes[k].dot(&datum.coords);
            for (_, sensor) in drawn_sensors(body).filter(|_| shown == Shown::Sensors) {
                let place = axes[k].dot(&sensor.position_in_body.coords) - zero;
                let is_new = |other: &f64| (other - place).abs() > SAME_MM;
                if place.abs() > SAME_MM && places.iter().all(is_new) {
                    places.push(place);
                }
            }
            places.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
            places.truncate(MOST_DIMENSIONS);
            places
        });
        let [right, up, towards] = spans_mm.map(|[low, high]| high - low);
        let beside = EDGE_PX + STEP_PX * (rows[1].len() + 1) as f64;
        let width = WIDTH_PX - beside - EDGE_PX - 2.0 * GAP_PX;
        let px_per_mm =
            (width / (right + towards)).min(VIEWS_HEIGHT_PX / (up + towards)).min(MOST_PX_PER_MM);
        let to_datum_px = (axes[0].dot(&datum.coords) - spans_mm[0][0]) * px_per_mm;
        let letters = datum_word(body).len() as f64;
        let word_px = (WORD_OFF_PX + LETTER_PX * letters - to_datum_px).max(0.0);
        Self {
            axes,
            spans_mm,
            whole_mm,
            datum,
            // With the word beside it, which is small, there may be a little less room.
            px_per_mm: px_per_mm.min((width - word_px) / (right + towards)),
            word_px,
            rows,
        }
    }

    fn length_px(&self, axis: usize) -> f64 {
        let [low, high] = self.spans_mm[axis];
        (high - low) * self.px_per_mm
    }

    fn top_top_px(&self) -> f64 {
        BALLOONS_PX
    }

    fn front_top_px(&self) -> f64 {
        self.top_top_px() + self.length_px(2) + BALLOONS_PX + 8.0
    }

    fn front_bottom_px(&self) -> f64 {
        self.front_top_px() + self.length_px(1)
    }

    fn left_px(&self) -> f64 {
        let columns = self.rows[1].len() + 1;
        // Views are in the middle of what is free.
        let used = self.length_px(0) + self.length_px(2) + GAP_PX;
        let beside = EDGE_PX + self.word_px + STEP_PX * columns as f64 + GAP_PX / 2.0;
        beside.max((WIDTH_PX - used) / 2.0)
    }

    fn height_px(&self) -> f64 {
        let rows = self.rows[0].len().max(self.rows[2].len());
        self.front_bottom_px() + STEP_PX * (rows + 1) as f64 + 60.0
    }

    /// Front, top and right side.
    fn papers(&self) -> [Paper; 3] {
        let [right, up, towards] = self.axes;
        let s = self.px_per_mm;
        let [r, u, t] = self.spans_mm;
        let front_x = self.left_px() - r[0] * s;
        let front_y = self.front_top_px() + u[1] * s;
        let side_left = self.left_px() + self.length_px(0) + GAP_PX;
        [
            Paper { right, up, px_per_mm: s, origin_px: [front_x, front_y] },
            Paper {
                right,
                up: -towards,
                px_per_mm: s,
                origin_px: [front_x, self.top_top_px() - t[0] * s],
            },
            Paper { right: -towards, up, px_per_mm: s, origin_px: [side_left + t[1] * s, front_y] },
        ]
    }

    /// Dimensions of the sensors below and beside the front view, and below the side view.
    fn dimensions(&self, front: &Paper, side: &Paper) -> Markup {
        let s = self.px_per_mm;
        let datum = front.at(&self.datum);
        let datum_side = side.at(&self.datum);
        let bottom = self.front_bottom_px();
        let row = |index: usize| bottom + STEP_PX * (index + 1) as f64;
        let left = self.left_px() - self.word_px;
        let column = |index: usize| left - STEP_PX * (index + 1) as f64;
        html! {
            @for (index, place) in self.rows[0].iter().enumerate() {
                (across([datum[0], datum[0] + place * s], bottom, row(index), place.abs()))
            }
            @for (index, place) in self.rows[1].iter().enumerate() {
                (upright([datum[1], datum[1] - place * s], self.left_px(), column(index), place.abs()))
            }
            @for (index, place) in self.rows[2].iter().enumerate() {
                (across([datum_side[0], datum_side[0] - place * s], bottom, row(index), place.abs()))
            }
            @if let Some([right, up, towards]) = self.whole_mm {
                (across(right.map(|mm| front.origin_px[0] + mm * s), bottom, row(self.rows[0].len()), right[1] - right[0]))
                (upright(up.map(|mm| front.origin_px[1] - mm * s), self.left_px(), column(self.rows[1].len()), up[1] - up[0]))
                (across(towards.map(|mm| side.origin_px[0] - mm * s), bottom, row(self.rows[2].len()), towards[1] - towards[0]))
            }
        }
    }
}

/// The axis along which a body is longest, away from the origin, to the right; y up, or z for what
/// is longest along y.
fn axes_of(bounds: &Bounds) -> [Unit<Vector3<f64>>; 3] {
    let longest = bounds.size_mm().imax();
    let mut right = Vector3::zeros();
    right[longest] = if bounds.center_mm()[longest] < 0.0 { -1.0 } else { 1.0 };
    let up = if longest == 1 { Vector3::z() } else { Vector3::y() };
    [right, up, right.cross(&up)].map(Unit::new_unchecked)
}
