//! A design: a tool, perhaps a coordinate reference frame (CRF), and the requirements on them.

use super::anatomy::{Anatomy, AnatomyFrame};
use super::definition::DefinitionFile;
use super::procedure::Procedure;
use super::slides::Slide;
use super::things::BodyRole;
use nalgebra::{Point3, Vector3};
use std::sync::Arc;
use trackwright_geometry::mesh_reference::MeshReference;
use trackwright_geometry::pose::Pose;
use trackwright_metal::setup::RoomMetal;
use trackwright_simulation::body::RigidBody;
use trackwright_simulation::motion::Motion;
use trackwright_simulation::mounting::Mounting;
use trackwright_simulation::requirement::Requirement;

/// Everything that a study of a tool depends on, apart from the room itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    pub name: String,
    /// The environment's file as written in the design, relative to it.
    pub environment: String,
    /// The metal that is in the room, which the environment's file holds once it is saved.
    pub room_metal: Option<Arc<RoomMetal>>,
    pub crf: Option<CrfPlacement>,
    pub tool: ToolPlacement,
    pub motion: Option<Motion>,
    /// `None` leaves it to the environment.
    pub orientation_weight_mm: Option<f64>,
    pub requirement: Option<Requirement>,
    /// Where it is judged beside its own room, and what was decided.
    pub procedure: Procedure,
    /// What is shown beside its bodies.
    pub anatomy: Vec<Anatomy>,
    /// What it shows to people who do not design it.
    pub slides: Vec<Slide>,
}

/// A body as a design holds it: its content, and where that is kept.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignBody {
    /// The body's file as written in the design, relative to it.
    pub reference: String,
    /// The mesh as the body file refers to it.
    pub mesh: Option<MeshReference>,
    pub rigid: RigidBody,
    /// The maker's file that the body came from: what no body has of it stays with the body.
    pub definition: Option<Arc<DefinitionFile>>,
    /// Where its sensors may be put.
    pub mounting: Mounting,
}

impl DesignBody {
    /// A body of which only the file is known: nothing can be simulated of it before it is read.
    pub fn of_file(reference: String) -> Self {
        let rigid = RigidBody { name: String::new(), tip_in_body: None, sensors: Vec::new() };
        Self { reference, mesh: None, rigid, definition: None, mounting: Mounting::default() }
    }
}

/// The CRF, where it is, and where its own study judges it.
#[derive(Clone, Debug, PartialEq)]
pub struct CrfPlacement {
    pub body: DesignBody,
    pub tracker_from_crf: Pose,
    pub targets: Vec<Target>,
    /// Of the CRF's own study.
    pub motion: Option<Motion>,
    /// Of the CRF's own study.
    pub requirement: Option<Requirement>,
}

/// The tool and where it is; in the tracker frame where the design has no CRF.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolPlacement {
    pub body: DesignBody,
    pub crf_from_tool: Pose,
}

/// A place that matters, fixed to the CRF.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    pub name: String,
    /// Millimetres, CRF frame.
    pub position_in_crf: Point3<f64>,
}

/// How far from the tool a new CRF is, as in the design that a new one begins as.
const BESIDE_MM: f64 = 60.0;

impl Design {
    /// A design of a tool alone, at the tracker's origin, of which nothing is required.
    pub fn of_tool(name: &str, environment: &str, body: DesignBody) -> Self {
        Self {
            name: name.to_owned(),
            environment: environment.to_owned(),
            room_metal: None,
            crf: None,
            tool: ToolPlacement { body, crf_from_tool: Pose::identity() },
            motion: None,
            orientation_weight_mm: None,
            requirement: None,
            procedure: Procedure::default(),
            anatomy: Vec::new(),
            slides: Vec::new(),
        }
    }

    /// Whether every study of both is the same, in the same rooms. Names, what is shown, and what was
    /// decided are in no figure.
    pub fn has_studies_of(&self, other: &Self) -> bool {
        let of_crf = |crf: &CrfPlacement| {
            let CrfPlacement { body, tracker_from_crf, targets, motion, requirement } = crf.clone();
            (body.rigid, tracker_from_crf, targets, motion, requirement)
        };
        self.environment == other.environment
            && self.room_metal == other.room_metal
            && self.crf.as_ref().map(of_crf) == other.crf.as_ref().map(of_crf)
            && self.tool.body.rigid == other.tool.body.rigid
            && self.tool.crf_from_tool == other.tool.crf_from_tool
            && self.motion == other.motion
            && self.orientation_weight_mm == other.orientation_weight_mm
            && self.requirement == other.requirement
            && self.procedure.further_rooms == other.procedure.further_rooms
    }

    /// The body of a role; `None` for the CRF of a design without one.
    pub fn body(&self, role: BodyRole) -> Option<&DesignBody> {
        match role {
            BodyRole::Tool => Some(&self.tool.body),
            BodyRole::Crf => self.crf.as_ref().map(|crf| &crf.body),
        }
    }

    pub fn body_mut(&mut self, role: BodyRole) -> Option<&mut DesignBody> {
        match role {
            BodyRole::Tool => Some(&mut self.tool.body),
            BodyRole::Crf => self.crf.as_mut().map(|crf| &mut crf.body),
        }
    }

    /// The bodies that there are, the tool first.
    pub fn bodies(&self) -> impl Iterator<Item = (BodyRole, &DesignBody)> {
        BodyRole::ALL.into_iter().filter_map(|role| self.body(role).map(|body| (role, body)))
    }

    /// The design with its bodies where a tracker has them. What is not given stays: the CRF where it
    /// is, the tool where it is on the CRF.
    pub fn with_bodies_at(
        &self,
        tracker_from_tool: Option<Pose>,
        tracker_from_crf: Option<Pose>,
    ) -> Self {
        let mut design = self.clone();
        if let (Some(crf), Some(pose)) = (&mut design.crf, tracker_from_crf) {
            crf.tracker_from_crf = pose;
        }
        if let Some(tracker_from_tool) = tracker_from_tool {
            design.tool.crf_from_tool = match &design.crf {
                Some(crf) => crf.tracker_from_crf.inverse() * tracker_from_tool,
                None => tracker_from_tool,
            };
        }
        design
    }

    /// Where a CRF is put that the design gains, in the tracker frame: beside the tool, and turned as
    /// the tracker is, so that the range of motion has the axes that it had.
    pub fn pose_of_new_crf(&self) -> Pose {
        let tracker_from_tool = self.tracker_from_body(BodyRole::Tool);
        let at = tracker_from_tool.map_or_else(Vector3::zeros, |pose| pose.translation.vector);
        Pose::translation(at.x - BESIDE_MM, at.y, at.z)
    }

    /// The body's pose in the tracker frame; the tool's goes by way of the CRF where there is one.
    pub fn tracker_from_body(&self, role: BodyRole) -> Option<Pose> {
        let tracker_from_crf = self.crf.as_ref().map(|crf| crf.tracker_from_crf);
        match role {
            BodyRole::Crf => tracker_from_crf,
            BodyRole::Tool => Some(match tracker_from_crf {
                Some(tracker_from_crf) => tracker_from_crf * self.tool.crf_from_tool,
                None => self.tool.crf_from_tool,
            }),
        }
    }
}

impl Anatomy {
    /// Where the mesh is in the tracker frame.
    pub fn tracker_from_mesh(&self, design: &Design) -> Pose {
        tracker_from_frame(design, self.on) * self.frame_from_mesh
    }

    /// The same on another frame, staying where it is.
    pub fn put_on(&self, on: AnatomyFrame, design: &Design) -> Self {
        let frame_from_tracker = tracker_from_frame(design, on).inverse();
        Self {
            on,
            frame_from_mesh: match on == self.on {
                true => self.frame_from_mesh,
                false => frame_from_tracker * self.tracker_from_mesh(design),
            },
            ..self.clone()
        }
    }
}

fn tracker_from_frame(design: &Design, frame: AnatomyFrame) -> Pose {
    match frame {
        AnatomyFrame::Tracker => Pose::identity(),
        AnatomyFrame::Crf => {
            (design.tracker_from_body(BodyRole::Crf)).unwrap_or_else(Pose::identity)
        }
    }
}
