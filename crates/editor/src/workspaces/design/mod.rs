//! The Design workspace: bodies, sensors, the result.

pub mod anatomy_ui;
pub mod baseline;
pub mod body_file_ui;
pub mod crf_study_ui;
pub mod history_ui;
pub mod inspector;
pub mod mesh_ui;
pub mod motion_ui;
pub mod outliner;
pub mod result;
pub mod row_page;
pub mod sensor_ui;
