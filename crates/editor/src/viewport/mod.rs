//! The 3D view: camera, picking, drags, handles, overlay.

pub mod ball_handle;
pub mod camera;
pub mod camera_gestures;
pub mod coil_fit;
pub mod commands;
pub mod fine_pointer;
pub mod gizmo;
pub mod light_drawing;
pub mod mounting;
pub mod nudge;
pub mod overlay;
pub mod picking;
pub mod pointer_hint;
pub mod scene_drag;
pub mod scene_menu;
pub mod sensor_commands;
pub mod sensor_drag;
pub mod surfaces;
pub mod tip_drag;
pub mod tool;
pub mod troubles;
pub mod typed_move;
pub mod view_axes;
