//! What is done with the bytes of each fuzz target. `tests/adversarial` does the same with the corpora,
//! so that nothing here may need more than the standard library and `trackwright`.
//!
//! A target reads its bytes in every way that its formats allow and asserts more than that nothing
//! panics: what was read and written is read as the same again, and what is kept is bounded by what came.

mod calibration_files;
mod meshes;
mod openigtlink;
mod recordings;
mod ron_files;
mod tables;
mod tool_definitions;
mod typed_number;

pub use calibration_files::calibration_files;
pub use meshes::{gltf, mesh};
pub use openigtlink::openigtlink;
pub use recordings::recording;
pub use ron_files::{body_file, design_file, environment_file, state_file};
pub use tables::table;
pub use tool_definitions::tool_definition;
pub use typed_number::typed_number;

/// One fuzz target and its corpus, both by the same name.
#[derive(Clone, Copy)]
pub struct Target {
    pub name: &'static str,
    /// Whether anything was found in the bytes.
    pub read: fn(&[u8]) -> bool,
    /// Whether every format states where it ends, so that a file that is cut short is never taken
    /// for a whole one. A table's last number may lack digits, which cannot be detected.
    pub states_its_end: bool,
}

/// All targets.
pub const TARGETS: [Target; 13] = [
    target("openigtlink", openigtlink, false),
    target("tool_image", tool_definition, true),
    target("tool_text", tool_definition, false),
    target("mesh", mesh, false),
    target("gltf", gltf, true),
    target("recording", recording, false),
    target("calibration_files", calibration_files, false),
    target("table", table, false),
    target("body_file", body_file, true),
    target("design_file", design_file, true),
    target("environment_file", environment_file, true),
    target("state_file", state_file, true),
    target("typed_number", typed_number, false),
];

const fn target(name: &'static str, read: fn(&[u8]) -> bool, states_its_end: bool) -> Target {
    Target { name, read, states_its_end }
}

/// What was read; an error is put into words, since these quote the bytes.
fn read<T, E: ToString>(parsed: Result<T, E>) -> Option<T> {
    match parsed {
        Ok(read) => Some(read),
        Err(error) => {
            assert!(!error.to_string().is_empty());
            None
        }
    }
}
