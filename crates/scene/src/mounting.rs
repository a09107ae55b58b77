//! Where sensors of a body may be mounted: patches of its surface, channels, seats; and where no coil
//! may be: forbidden boxes, the clearance of the tip.

use super::drawing::Drawing;
use super::palette::{CRF, FORBIDDEN, MOUNTING, Rgb};
use nalgebra::{Point3, Vector3};
use serde_json::Value;
use trackwright_design::BodyRole;
use trackwright_formats::gltf::write::NodeId;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::outline::Outline;
use trackwright_geometry::solid::{ArrowSize, Solid};
use trackwright_simulation::{Mounting, MountingRegion};

/// What the colours mean, for a legend.
pub const MOUNTING_WORDS: &str = "sensors may be mounted here";
pub const CRF_PATCH_WORDS: &str = "the CRF may stand here";
pub const FORBIDDEN_WORDS: &str = "no coil here: forbidden box, tip clearance";

/// Before the surface that it is a part of, which would hide every other piece of it.
const LIFT_MM: f64 = 0.05;

/// Radius of a channel that states none.
const THIN_MM: f64 = 0.25;

/// A seat: a ball, with an arrow where it states an axis.
const SEAT_RADIUS_MM: f64 = 1.2;
const SEAT_AXIS_MM: f64 = 8.0;
const SEAT_ARROW: ArrowSize =
    ArrowSize { shaft_mm: 0.5, head_width_mm: 1.5, head_length_mm: 2.2, most_mm: SEAT_AXIS_MM };

/// Opacity of a forbidden box up to an extent, and the least part of it that a larger one has: its
/// edges show where it is.
const FORBIDDEN_ALPHA: f64 = 0.2;
const SMALL_MM: f64 = 30.0;
const LEAST_PART: f64 = 0.15;

/// What a shape stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MountingPart {
    Patch,
    /// Of anatomy.
    CrfPatch,
    Channel,
    Seat,
    ForbiddenBox,
    TipClearance,
}

/// A translucent solid and lines, in the body's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct MountingShape {
    pub part: MountingPart,
    pub solid: Solid,
    pub lines: Vec<Vec<Point3<f64>>>,
    /// How opaque the solid is.
    pub alpha: f64,
}

impl MountingPart {
    pub fn name(self) -> &'static str {
        match self {
            Self::Patch => "mounting patch",
            Self::CrfPatch => "CRF patch",
            Self::Channel => "mounting channel",
            Self::Seat => "mounting seat",
            Self::ForbiddenBox => "forbidden box",
            Self::TipClearance => "tip clearance",
        }
    }

    pub fn color(self) -> Rgb {
        match self {
            Self::Patch | Self::Channel | Self::Seat => MOUNTING,
            Self::CrfPatch => CRF,
            Self::ForbiddenBox | Self::TipClearance => FORBIDDEN,
        }
    }

    /// How opaque one of an extent is. Where no coil may be there is something else: a large box
    /// fades, so that the anatomy inside it is seen.
    fn alpha(self, extent_mm: f64) -> f64 {
        match self {
            Self::Patch => 0.35,
            Self::CrfPatch => 0.6,
            Self::Channel => 0.45,
            Self::Seat => 0.8,
            Self::ForbiddenBox | Self::TipClearance => {
                let part = (SMALL_MM / extent_mm.max(SMALL_MM)).max(LEAST_PART);
                FORBIDDEN_ALPHA * part
            }
        }
    }
}

/// Whether a body states where no coil may be.
pub fn forbids(mounting: &Mounting) -> bool {
    !mounting.keep_out.is_empty() || mounting.tip_clearance_mm > 0.0
}

/// Everything that a body states. Without regions its whole surface is a patch.
pub fn mounting_shapes(
    mounting: &Mounting,
    mesh: Option<&SurfaceMesh>,
    tip_in_body: &Point3<f64>,
) -> Vec<MountingShape> {
    let whole = [MountingRegion::whole_surface()];
    let regions = match mounting.regions.is_empty() {
        true => &whole[..],
        false => &mounting.regions,
    };
    let mut shapes: Vec<MountingShape> =
        regions.iter().map(|region| region_shape(region, mesh)).collect();
    shapes.extend(mounting.keep_out.iter().map(|own| {
        let part = MountingPart::ForbiddenBox;
        // A long thin one hides little.
        let size = own.size_mm();
        let extent_mm = (size.sum() - size.max() - size.min()).max(0.0);
        MountingShape {
            part,
            solid: Solid::cuboid(own),
            lines: Outline::of_box(own).lines,
            alpha: part.alpha(extent_mm),
        }
    }));
    if mounting.tip_clearance_mm > 0.0 {
        let mut solid = Solid::default();
        let sphere = Solid::sphere(mounting.tip_clearance_mm);
        solid.push(&sphere, |p| tip_in_body + p.coords, |n| *n);
        let part = MountingPart::TipClearance;
        let alpha = part.alpha(2.0 * mounting.tip_clearance_mm);
        shapes.push(MountingShape { part, solid, lines: Vec::new(), alpha });
    }
    shapes
}

/// Where on anatomy the CRF may stand, in the frame of its mesh; nothing is drawn without boxes, which
/// state nothing.
pub fn crf_patch_shape(boxes: &[Bounds], mesh: &SurfaceMesh) -> MountingShape {
    let part = MountingPart::CrfPatch;
    let solid = match boxes {
        [] => Solid::default(),
        boxes => mesh.patch(boxes, LIFT_MM),
    };
    MountingShape { part, solid, lines: Vec::new(), alpha: part.alpha(0.0) }
}

fn region_shape(region: &MountingRegion, mesh: Option<&SurfaceMesh>) -> MountingShape {
    let mut solid = Solid::default();
    let (part, lines) = match region {
        MountingRegion::Surface { boxes, .. } => {
            solid = mesh.map(|mesh| mesh.patch(boxes, LIFT_MM)).unwrap_or_default();
            (MountingPart::Patch, Vec::new())
        }
        MountingRegion::Channel { points_mm, radius_mm, .. } => {
            solid.push_tube(points_mm, radius_mm.unwrap_or(THIN_MM));
            (MountingPart::Channel, vec![points_mm.clone()])
        }
        MountingRegion::Seat { position_mm, axis } => {
            solid.push(&Solid::sphere(SEAT_RADIUS_MM), |p| position_mm + p.coords, |n| *n);
            let along = axis.map_or_else(Vector3::zeros, |axis| *axis * SEAT_AXIS_MM);
            solid.push_arrow(position_mm, &along, &SEAT_ARROW);
            (MountingPart::Seat, Vec::new())
        }
    };
    MountingShape { part, solid, lines, alpha: part.alpha(0.0) }
}

impl Drawing<'_> {
    /// The mounting regions of a body, in its frame.
    pub(super) fn mounting(&mut self, role: BodyRole) -> Vec<NodeId> {
        let stage = self.stage;
        let Some(body) = stage.design().body(role) else {
            return Vec::new();
        };
        let tip = body.rigid.judged_tip_in_body();
        // A rod that stands in for a mesh is no surface.
        let mesh = stage.world.mesh(role).and(stage.mesh(role)).map(|mesh| &**mesh);
        let shapes = mounting_shapes(&body.mounting, mesh, &tip);
        shapes.iter().flat_map(|shape| self.mounting_nodes(shape)).collect()
    }

    /// A shape of mounting regions, in its frame.
    pub(super) fn mounting_nodes(&mut self, shape: &MountingShape) -> Vec<NodeId> {
        let (name, color) = (shape.part.name(), shape.part.color());
        let look = self.veil(name, color, shape.alpha);
        let solid = self.solid_node(name, &shape.solid, look, Value::Null);
        let mut nodes: Vec<NodeId> = solid.into_iter().collect();
        if !shape.lines.is_empty() {
            let look = self.unlit(name, color, 1.0);
            let lines = shape.lines.iter().map(Vec::as_slice);
            nodes.extend(self.lines(&format!("{name}, lines"), lines, look));
        }
        nodes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Unit;
    use trackwright_geometry::placeholder::placeholder;
    use trackwright_simulation::MountingAxis;

    fn rod() -> SurfaceMesh {
        placeholder(&Point3::origin(), &[Point3::new(0.0, 0.0, 100.0)])
    }

    fn around(solid: &Solid) -> Bounds {
        Bounds::around(solid.positions_mm.iter().copied()).unwrap()
    }

    #[test]
    fn nothing_stated_is_the_whole_surface() {
        let shapes = mounting_shapes(&Mounting::default(), Some(&rod()), &Point3::origin());
        let [only] = &shapes[..] else { panic!("{shapes:?}") };
        assert_eq!(only.part, MountingPart::Patch);
        let triangles: usize = rod().body_parts().map(|part| part.triangles.len()).sum();
        assert_eq!(only.solid.triangles.len(), triangles);
    }

    #[test]
    fn each_statement_has_its_shape() {
        let own = Bounds::from(([-9.0, -9.0, 10.0], [9.0, 9.0, 20.0]));
        let ends = [Point3::new(0.0, 0.0, 30.0), Point3::new(0.0, 0.0, 60.0)];
        let seat = Point3::new(0.0, 0.0, 70.0);
        let mounting = Mounting {
            regions: vec![
                MountingRegion::Surface { axis: MountingAxis::Normal, boxes: vec![own] },
                MountingRegion::Channel {
                    points_mm: ends.to_vec(),
                    radius_mm: Some(0.7),
                    axis: MountingAxis::Along,
                },
                MountingRegion::Seat {
                    position_mm: seat,
                    axis: Some(Unit::new_unchecked(Vector3::x())),
                },
            ],
            keep_out: vec![own],
            tip_clearance_mm: 5.0,
            ..Mounting::default()
        };
        let tip = Point3::new(1.0, 2.0, 3.0);
        let shapes = mounting_shapes(&mounting, Some(&rod()), &tip);
        let parts: Vec<MountingPart> = shapes.iter().map(|shape| shape.part).collect();
        use MountingPart::{Channel, ForbiddenBox, Patch, Seat, TipClearance};
        assert_eq!(parts, [Patch, Channel, Seat, ForbiddenBox, TipClearance]);
        let [patch, channel, seat, keep_out, clearance] =
            [0, 1, 2, 3, 4].map(|k| around(&shapes[k].solid));
        // Lifted off, and a little across at the cut.
        assert!((patch.min_mm.z - 10.0).abs() < 0.1 && (patch.max_mm.z - 20.0).abs() < 0.1);
        assert_eq!((channel.min_mm.z, channel.max_mm.z), (30.0, 60.0));
        assert!((channel.max_mm.x - 0.7).abs() < 1e-9);
        assert!((seat.max_mm.x - SEAT_AXIS_MM).abs() < 1e-9, "{seat:?}");
        assert_eq!(keep_out, own);
        assert!((clearance.center_mm() - tip).norm() < 0.1, "{clearance:?}");
        assert!(forbids(&mounting) && !forbids(&Mounting::default()));
        assert_eq!((shapes[1].lines.len(), shapes[3].lines.len()), (1, 12));
    }

    #[test]
    fn a_large_forbidden_box_is_faint() {
        let alpha = |[x, y, z]: [f64; 3]| {
            let keep_out = vec![Bounds::from(([0.0; 3], [x, y, z]))];
            let mounting = Mounting { keep_out, ..Mounting::default() };
            let shapes = mounting_shapes(&mounting, None, &Point3::origin());
            let own = shapes.iter().find(|shape| shape.part == MountingPart::ForbiddenBox);
            own.unwrap().alpha
        };
        assert_eq!(alpha([10.0; 3]), FORBIDDEN_ALPHA);
        // As long as a shaft.
        assert_eq!(alpha([10.0, 300.0, 10.0]), FORBIDDEN_ALPHA);
        // Around a head.
        let head = alpha([180.0, 220.0, 240.0]);
        assert!((LEAST_PART * FORBIDDEN_ALPHA..0.04).contains(&head), "{head}");
        assert!(alpha([60.0; 3]) > head && alpha([60.0; 3]) < FORBIDDEN_ALPHA);
    }

    #[test]
    fn a_crf_patch_is_what_its_boxes_hold() {
        let own = Bounds::from(([-9.0, -9.0, 10.0], [9.0, 9.0, 20.0]));
        let shape = crf_patch_shape(&[own], &rod());
        let bounds = around(&shape.solid);
        assert!((bounds.min_mm.z - 10.0).abs() < 0.1 && (bounds.max_mm.z - 20.0).abs() < 0.1);
        assert_eq!((shape.part.color(), shape.part.name()), (CRF, "CRF patch"));
        // Without boxes nothing is stated, unlike of a body.
        assert!(crf_patch_shape(&[], &rod()).solid.triangles.is_empty());
    }

    #[test]
    fn a_body_without_a_mesh_has_no_patch() {
        let shapes = mounting_shapes(&Mounting::default(), None, &Point3::origin());
        assert!(shapes.iter().all(|shape| shape.solid.triangles.is_empty()));
    }
}
