//! Labels in the scene: names, warnings on the spot, lengths of the volume, letters of axes.

use crate::document::selection::Selected;
use crate::palette::ThemedColor;
use crate::palette::{self, Rgb};
use crate::viewport::overlay::OverlayView;
use crate::viewport::overlay::labels::{Wanted, leader, place};
use crate::viewport::troubles::{detail, determination_text, sensor_trouble_text};
use crate::widgets::basic::THIN_SPACE;
use crate::widgets::theme;
use bevy_egui::egui::{Align2, Painter, Pos2, Rect, Stroke, StrokeKind, pos2, vec2};
use nalgebra::{Point3, Vector3};
use trackwright_design::BodyRole;
use trackwright_formats::printable::printable;
use trackwright_geometry::orbit::Axis;
use trackwright_geometry::outline::DimensionKind;
use trackwright_geometry::volume::Volume;
use trackwright_report::words::for_audience;
use trackwright_simulation::SensorOrientation;

/// Where the letters of the tracker's axes stand: just beyond the arrows.
const AXIS_LETTER_MM: f64 = 130.0;

/// Radius of the plate behind a letter of a handle's axis.
const LETTER_PX: f32 = 8.0;

/// What labels leave free around the head of a handle's arrow.
const HEAD_PX: f32 = 30.0;

/// A label in the scene.
struct Label {
    at: Pos2,
    text: String,
    color: Rgb,
    /// Warnings and what the person works on.
    is_needed: bool,
}

/// Paints the labels around what is covered already.
pub fn paint(painter: &Painter, view: &OverlayView, covered: &[Rect]) {
    let mut labels = Vec::new();
    body_troubles(view, &mut labels);
    if !view.is_plain {
        warnings(view, &mut labels);
    }
    if view.layers.labels {
        tip(view, &mut labels);
        targets(view, &mut labels);
        bodies(view, &mut labels);
        metal(view, &mut labels);
        of_workspace(view, &mut labels);
        if !view.is_plain {
            sensors(view, &mut labels);
        }
        room(view, &mut labels);
    }
    let mut covered = covered.to_vec();
    if view.layers.labels && !view.is_plain && has_axes(view) {
        let letters = axis_letters(painter, view, &covered);
        covered.extend(letters);
    }
    covered.extend(gizmo_letters(painter, view));
    if let Some((at, text)) = view.readout {
        covered.push(readout(painter, view.rect, at, text));
    }
    paint_labels(painter, view, &labels, &covered);
}

fn paint_labels(painter: &Painter, view: &OverlayView, labels: &[Label], covered: &[Rect]) {
    let galleys: Vec<_> = labels
        .iter()
        .map(|label| {
            painter.layout_no_wrap(
                printable(&label.text).into_owned(),
                theme::label_font(),
                label.color.color32(),
            )
        })
        .collect();
    let wanted: Vec<Wanted> = labels
        .iter()
        .zip(&galleys)
        .map(|(label, galley)| Wanted {
            anchor: label.at,
            size: galley.size() + vec2(8.0, 4.0),
            is_needed: label.is_needed,
        })
        .collect();
    let places = place(&wanted, covered, view.rect.shrink(4.0));
    for ((label, galley), rect) in labels.iter().zip(galleys).zip(places) {
        let Some(rect) = rect else { continue };
        if let Some(line) = leader(label.at, rect) {
            painter.line_segment(line, Stroke::new(1.0, label.color.color32_alpha(140)));
        }
        painter.rect_filled(rect, 3.0, palette::plate());
        if label.is_needed && label.color == palette::MISSED {
            let stroke = Stroke::new(1.0, label.color.color32());
            painter.rect_stroke(rect, 3.0, stroke, StrokeKind::Inside);
        }
        painter.galley(rect.min + vec2(4.0, 2.0), galley, label.color.color32());
    }
}

/// The point of a sensor in the tracker frame.
fn sensor_point(view: &OverlayView, role: BodyRole, index: usize) -> Option<Point3<f64>> {
    let body = view.design.body(role)?;
    let sensor = body.rigid.sensors.get(index)?;
    Some(view.design.tracker_from_body(role)? * sensor.position_in_body)
}

fn roles(view: &OverlayView) -> impl Iterator<Item = BodyRole> {
    BodyRole::ALL.into_iter().filter(|role| view.design.body(*role).is_some())
}

/// What is wrong, labelled where it is wrong.
fn warnings(view: &OverlayView, labels: &mut Vec<Label>) {
    for role in roles(view) {
        let Some(body) = view.design.body(role) else {
            continue;
        };
        let detail = detail(view.pose, role);
        for (index, sensor) in body.rigid.sensors.iter().enumerate() {
            let Some(trouble) = sensor_trouble_text(detail, view.coils, role, index) else {
                continue;
            };
            let at = sensor_point(view, role, index).and_then(|p| view.project(&p));
            labels.extend(at.map(|at| Label {
                at,
                text: format!("{}: {trouble}", sensor.name),
                color: palette::MISSED,
                is_needed: true,
            }));
        }
        if let Some(detail) = detail
            && let Some(text) = determination_text(detail)
            && let Some(at) = view.project(&detail.tracker_from_body.translation.vector.into())
        {
            labels.push(Label { at, text, color: palette::MISSED, is_needed: true });
        }
    }
}

fn tip(view: &OverlayView, labels: &mut Vec<Label>) {
    let role = BodyRole::Tool;
    let (Some(body), Some(pose)) = (view.design.body(role), view.design.tracker_from_body(role))
    else {
        return;
    };
    let tip = pose * body.rigid.judged_tip_in_body();
    let Some(at) = view.project(&tip) else { return };
    labels.push(Label {
        at,
        text: "tip".to_owned(),
        color: palette::TEXT_STRONG,
        is_needed: view.selected == Some(Selected::Tip(role)),
    });
}

fn sensors(view: &OverlayView, labels: &mut Vec<Label>) {
    for role in roles(view) {
        let Some(body) = view.design.body(role) else {
            continue;
        };
        for (index, sensor) in body.rigid.sensors.iter().enumerate() {
            if view.hidden.has_sensor(role, &sensor.name) {
                continue;
            }
            // A sensor in trouble has its label already.
            let detail = detail(view.pose, role);
            if sensor_trouble_text(detail, view.coils, role, index).is_some() {
                continue;
            }
            let what = Selected::Sensor(role, index);
            let at = sensor_point(view, role, index).and_then(|p| view.project(&p));
            let Some(at) = at else { continue };
            let is_looked_at = view.selected == Some(what) || view.hovered == Some(what);
            labels.push(Label {
                at,
                // A ball is seen to be a marker, and mostly called one.
                text: match sensor.orientation {
                    SensorOrientation::Marker => sensor.name.clone(),
                    measured => format!("{} · {}", sensor.name, measured.kind_name()),
                },
                color: if is_looked_at { palette::SELECTED } else { palette::SENSOR },
                is_needed: is_looked_at,
            });
        }
    }
}

fn targets(view: &OverlayView, labels: &mut Vec<Label>) {
    let Some(crf) = &view.design.crf else { return };
    for target in &crf.targets {
        let point = crf.tracker_from_crf * target.position_in_crf;
        labels.extend(view.project(&point).map(|at| Label {
            at,
            text: target.name.clone(),
            color: palette::TEXT_QUIET,
            is_needed: false,
        }));
    }
}

/// A body that does not stand where it is now is distinguishable at once from one that does.
fn body_troubles(view: &OverlayView, labels: &mut Vec<Label>) {
    for (role, trouble) in view.body_troubles {
        let Some(at) = far_end(view, *role).and_then(|far| view.project(&far)) else {
            continue;
        };
        let text = if view.is_plain { for_audience(trouble) } else { trouble.clone() };
        labels.push(Label { at, text, color: palette::MISSED, is_needed: true });
    }
}

/// Where a body's name stands, away from the tip: at the sensors' far end, in the tracker's frame.
fn far_end(view: &OverlayView, role: BodyRole) -> Option<Point3<f64>> {
    let body = view.design.body(role)?;
    let tip = body.rigid.judged_tip_in_body();
    let far = (body.rigid.sensors.iter())
        .map(|s| s.position_in_body)
        .max_by(|a, b| (a - tip).norm().total_cmp(&(b - tip).norm()));
    Some(view.design.tracker_from_body(role)? * far.unwrap_or(tip))
}

/// The bodies' names.
fn bodies(view: &OverlayView, labels: &mut Vec<Label>) {
    for role in roles(view).filter(|role| !view.hidden.has_body(*role)) {
        let (Some(body), Some(far)) = (view.design.body(role), far_end(view, role)) else {
            continue;
        };
        let Some(at) = view.project(&far) else {
            continue;
        };
        let (kind, color) = match role {
            BodyRole::Tool => ("tool", palette::TOOL),
            BodyRole::Crf => ("CRF", palette::CRF),
        };
        let name = &body.rigid.name;
        let is_named = name.to_lowercase().contains(&kind.to_lowercase());
        let text = match (view.is_plain, is_named) {
            (true, _) => for_audience(name),
            (false, true) => name.clone(),
            (false, false) => format!("{name} ({kind})"),
        };
        labels.push(Label {
            at,
            text,
            color,
            is_needed: view.selected == Some(Selected::Body(role)),
        });
    }
}

/// The names of metal objects.
fn metal(view: &OverlayView, labels: &mut Vec<Label>) {
    let objects = view.design.room_metal.iter().flat_map(|metal| &metal.objects);
    for (index, object) in objects.enumerate() {
        let middle = Point3::from(object.tracker_from_object.translation.vector);
        let Some(at) = view.project(&middle).filter(|_| !view.hidden.has_metal(&object.name))
        else {
            continue;
        };
        let what = Some(Selected::Metal(index));
        let is_looked_at = view.selected == what || view.hovered == what;
        let text = if view.is_plain { for_audience(&object.name) } else { object.name.clone() };
        labels.push(Label {
            at,
            text,
            color: if is_looked_at { palette::SELECTED } else { palette::TEXT_QUIET },
            is_needed: is_looked_at,
        });
    }
}

/// What the shown workspace names.
fn of_workspace(view: &OverlayView, labels: &mut Vec<Label>) {
    labels.extend(view.labels.iter().filter_map(|label| {
        Some(Label {
            at: view.project(&label.at_mm)?,
            text: label.text.clone(),
            color: label.color,
            is_needed: true,
        })
    }));
}

fn room(view: &OverlayView, labels: &mut Vec<Label>) {
    if view.layers.volume
        && let Some(volume) = &view.environment.volume
    {
        volume_lengths(view, volume, labels);
    }
    if view.layers.generator {
        let behind = Point3::new(0.0, 0.0, 40.0);
        labels.extend(view.project(&behind).map(|at| Label {
            at,
            text: "field generator".to_owned(),
            color: palette::TEXT_QUIET,
            is_needed: false,
        }));
    }
}

/// The tracker's axes are drawn with its generator and with the ground.
fn has_axes(view: &OverlayView) -> bool {
    view.layers.generator || view.layers.grid
}

/// Letters at the ends of the tracker's axes, where no legend is; what they cover.
fn axis_letters(painter: &Painter, view: &OverlayView, covered: &[Rect]) -> Vec<Rect> {
    let mut letters = Vec::new();
    for (axis, letter, color) in [
        (Vector3::x(), "x", palette::AXIS_X),
        (Vector3::y(), "y", palette::AXIS_Y),
        (Vector3::z(), "z", palette::AXIS_Z),
    ] {
        let end = Point3::from(axis * AXIS_LETTER_MM);
        let Some(at) = view.project(&end) else { continue };
        let room = Rect::from_center_size(at, vec2(2.0, 2.0) * LETTER_PX);
        if !covered.iter().any(|other| other.intersects(room)) {
            let font = theme::body_font();
            letters.push(painter.text(at, Align2::CENTER_CENTER, letter, font, color.color32()));
        }
    }
    letters
}

/// Letters beyond the arrows of the gizmo. Labels leave both free.
fn gizmo_letters(painter: &Painter, view: &OverlayView) -> Vec<Rect> {
    let place = |[x, y]: [f64; 2]| view.rect.min + vec2(x as f32, y as f32);
    let letter = |(axis, color): (Axis, Rgb)| {
        let [tip, at] = view.gizmo?.arrow_end_px(axis, &view.eye())?.map(place);
        let font = theme::body_font();
        let text = axis.name();
        painter.circle_filled(at, LETTER_PX, palette::plate());
        let letter = painter.text(at, Align2::CENTER_CENTER, text, font, color.color32());
        Some(letter.union(Rect::from_center_size(tip, vec2(HEAD_PX, HEAD_PX))))
    };
    let axes = Axis::ALL.into_iter().zip(palette::AXES);
    axes.filter_map(letter).collect()
}

/// Each length is written where it is lowest on the screen.
fn volume_lengths(view: &OverlayView, volume: &Volume, labels: &mut Vec<Label>) {
    for dimension in volume.dimensions() {
        let places = dimension.places_mm.iter().filter_map(|p| view.project(p));
        // Vertical edges are chosen by how far out they are instead.
        let outwards = |p: &Pos2| p.y + 0.3 * (p.x - view.rect.center().x).abs();
        let Some(at) = places.max_by(|a, b| outwards(a).total_cmp(&outwards(b))) else {
            continue;
        };
        let which_way = match dimension.kind {
            DimensionKind::Side => "",
            DimensionKind::Diameter => " across",
            DimensionKind::Depth => " deep",
        };
        labels.push(Label {
            at,
            text: format!("{:.0}{THIN_SPACE}mm{which_way}", dimension.length_mm),
            color: palette::TEXT_QUIET,
            is_needed: false,
        });
    }
    let outline = volume.outline();
    let top = outline
        .lines
        .iter()
        .flatten()
        .filter_map(|point| view.project(point))
        .filter(|at| view.rect.contains(*at))
        .min_by(|a, b| a.y.total_cmp(&b.y));
    labels.extend(top.map(|at| Label {
        at,
        text: format!("measurement volume ({})", volume.name()),
        color: palette::TEXT_QUIET,
        is_needed: false,
    }));
}

/// The number next to the pointer; what it covers.
fn readout(painter: &Painter, view: Rect, at: Pos2, text: &str) -> Rect {
    let galley =
        painter.layout(text.to_owned(), theme::body_font(), palette::TEXT_STRONG.color32(), 320.0);
    let size = galley.size() + vec2(14.0, 8.0);
    let mut rect = Rect::from_min_size(at + vec2(18.0, 14.0), size);
    if rect.right() > view.right() - 4.0 {
        rect = Rect::from_min_size(pos2(at.x - 18.0 - size.x, rect.top()), size);
    }
    if rect.bottom() > view.bottom() - 4.0 {
        rect = Rect::from_min_size(pos2(rect.left(), at.y - 14.0 - size.y), size);
    }
    painter.rect_filled(rect, 4.0, palette::PANEL.color32_alpha(235));
    let stroke = Stroke::new(1.0, palette::ACCENT.color32());
    painter.rect_stroke(rect, 4.0, stroke, StrokeKind::Inside);
    painter.galley(rect.min + vec2(7.0, 4.0), galley, palette::TEXT_STRONG.color32());
    rect
}
