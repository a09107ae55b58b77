//! Tool, CRF and field generator where they stand, in parallel projection: what the page shows where
//! nothing can turn.

use super::paper::{DrawnPart, Paper, line, parts, text};
use super::{is_drawable, marks};
use maud::{Markup, html};
use nalgebra::{Point3, Unit, Vector3};
use trackwright_design::{BodyRole, Design};
use trackwright_field::Environment;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::RigidBody;

const SIZE_PX: [f64; 2] = [1000.0, 620.0];
const EDGE_PX: f64 = 40.0;

/// From where one looks: about the generator's axis from its x, and above its front.
const AZIMUTH_DEG: f64 = -60.0;
const ELEVATION_DEG: f64 = 18.0;

/// Nothing nearer to each other than this is apart on paper.
const LEAST_EXTENT_MM: f64 = 10.0;

/// What stands where.
pub struct SetUp<'a> {
    pub design: &'a Design,
    pub environment: &'a Environment,
    pub tool_mesh: Option<&'a SurfaceMesh>,
    pub crf_mesh: Option<&'a SurfaceMesh>,
    pub generator_mesh: Option<&'a SurfaceMesh>,
}

/// The drawing, the tracker's -z up: its generator below.
pub fn setup_drawing(setup: &SetUp) -> Markup {
    let design = setup.design;
    let tracker_from_tool = design.tracker_from_body(BodyRole::Tool).unwrap_or_else(Pose::identity);
    let tracker_from_crf = design.tracker_from_body(BodyRole::Crf);
    let meshes: Vec<(&SurfaceMesh, Pose, &str)> = [
        (setup.generator_mesh, Some(Pose::identity()), "generator"),
        (setup.crf_mesh, tracker_from_crf, "crf"),
        (setup.tool_mesh, Some(tracker_from_tool), "tool"),
    ]
    .into_iter()
    .filter_map(|(mesh, pose, class)| Some((mesh?, pose?, class)))
    .collect();
    let volume = match &setup.environment.volume {
        Some(volume) => volume.outline(),
        None => trackwright_geometry::outline::Outline::of_box(setup.environment.model.bounds()),
    };
    let tip = tracker_from_tool * design.tool.body.rigid.judged_tip_in_body();
    let bodies: Vec<(&RigidBody, Pose)> = BodyRole::ALL
        .into_iter()
        .filter_map(|role| {
            let body = &design.body(role)?.rigid;
            Some((body, design.tracker_from_body(role)?))
        })
        .collect();
    let sensors: Vec<Point3<f64>> = bodies
        .iter()
        .flat_map(|(body, pose)| body.sensors.iter().map(move |s| pose * s.position_in_body))
        .collect();
    let shapes = meshes.iter().flat_map(|(mesh, pose, _)| {
        let corners = mesh.body_bounds().map(|bounds| bounds.corners_mm());
        corners.into_iter().flatten().map(move |corner| pose * corner)
    });
    let lines = volume.lines.iter().flatten().copied();
    let points: Vec<Point3<f64>> = shapes
        .chain(lines)
        .chain(sensors.iter().copied())
        .chain([tip, Point3::origin()])
        .filter(is_drawable)
        .collect();
    let paper = fitted(&points);
    let mut drawn: Vec<(DrawnPart, &str)> = meshes
        .iter()
        .flat_map(|(mesh, pose, class)| {
            let parts = parts(&paper, mesh, pose);
            parts.into_iter().map(move |part| (part, *class))
        })
        .collect();
    drawn.sort_by(|a, b| a.0.depth_mm.total_cmp(&b.0.depth_mm));
    let [width, height] = SIZE_PX;
    html! {
        svg class="drawing" role="img" viewBox=(format!("0 0 {width:.0} {height:.0}")) {
            title { "Tool, reference and field generator where they stand" }
            @for path in &volume.lines {
                (polyline("volume", &paper, path))
            }
            @for (part, class) in &drawn {
                (part.draw(if part.is_anatomy { "part anatomy" } else { class }))
            }
            @for path in &volume.brackets {
                (polyline("bracket", &paper, path))
            }
            @for sensor in &sensors {
                @let [x, y] = paper.at(sensor);
                circle class="sensor-dot" cx=(format!("{x:.1}")) cy=(format!("{y:.1}")) r="3" {}
            }
            (marks::datum(&paper, &tip, "tip"))
            @for (body, pose) in &bodies {
                (named(&paper, &body.name, &sensors_middle(body, pose)))
            }
            (named(&paper, "field generator", &Point3::origin()))
        }
    }
}

fn sensors_middle(body: &RigidBody, tracker_from_body: &Pose) -> Point3<f64> {
    let sum: Vector3<f64> = body.sensors.iter().map(|s| s.position_in_body.coords).sum();
    tracker_from_body * Point3::from(sum / body.sensors.len().max(1) as f64)
}

/// The projection that holds all points.
fn fitted(points: &[Point3<f64>]) -> Paper {
    let (azimuth, elevation) = (AZIMUTH_DEG.to_radians(), ELEVATION_DEG.to_radians());
    let towards = Vector3::new(
        elevation.cos() * azimuth.cos(),
        elevation.cos() * azimuth.sin(),
        -elevation.sin(),
    );
    let right = Unit::new_normalize((-Vector3::z()).cross(&towards));
    let up = Unit::new_normalize(towards.cross(&right));
    let mut paper = Paper { right, up, px_per_mm: 1.0, origin_px: [0.0; 2] };
    let places: Vec<[f64; 2]> = points.iter().map(|point| paper.at(point)).collect();
    let span = |k: usize| {
        let low = places.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min);
        let high = places.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max);
        [low, high]
    };
    let spans = [span(0), span(1)];
    let scales = [0, 1].map(|k| {
        let extent = (spans[k][1] - spans[k][0]).max(LEAST_EXTENT_MM);
        (SIZE_PX[k] - 2.0 * EDGE_PX) / extent
    });
    paper.px_per_mm = scales[0].min(scales[1]);
    paper.origin_px = [0, 1].map(|k| {
        let middle = (spans[k][0] + spans[k][1]) / 2.0;
        SIZE_PX[k] / 2.0 - paper.px_per_mm * middle
    });
    paper
}

fn polyline(class: &str, paper: &Paper, path: &[Point3<f64>]) -> Markup {
    let points: Vec<String> =
        path.iter().map(|point| paper.at(point)).map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    html! { polyline class=(class) points=(points.join(" ")) {} }
}

/// A name beside what it names, on the side that has more room.
fn named(paper: &Paper, name: &str, at: &Point3<f64>) -> Markup {
    let [x, y] = paper.at(at);
    let is_left = x < SIZE_PX[0] / 2.0;
    let out = if is_left { -70.0 } else { 70.0 };
    let end = [x + out, y - 34.0];
    html! {
        (line("leader", [x, y], end))
        (text("word", if is_left { "end" } else { "start" }, [end[0] + out.signum() * 4.0, end[1] + 4.0], name))
    }
}
