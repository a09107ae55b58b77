//! The program's own files. Each is written and read as the same again; compared as text, because
//! numbers that are none differ from themselves.

use super::read;
use trackwright_formats::{
    EnvironmentFile, body, design_file, environment, preferences_file, recent_file, recovery_file,
    sweep_plan,
};

pub fn body_file(bytes: &[u8]) -> bool {
    survives(read(body::parse(bytes)), body::write, |text| body::parse(text.as_bytes()))
}

pub fn design_file(bytes: &[u8]) -> bool {
    survives(read(design_file::parse(bytes)), design_file::write, |text| {
        design_file::parse(text.as_bytes())
    })
}

pub fn environment_file(bytes: &[u8]) -> bool {
    let write = |file: &EnvironmentFile| environment::write(&file.environment, file.metal.as_ref());
    survives(read(environment::parse(bytes)), write, |text| environment::parse(text.as_bytes()))
}

/// What the program leaves for its own next start, and plans of sweeps, as each of their kinds.
pub fn state_file(bytes: &[u8]) -> bool {
    let is_recovery = survives(read(recovery_file::parse(bytes)), recovery_file::write, |text| {
        recovery_file::parse(text.as_bytes())
    });
    let is_preferences =
        survives(read(preferences_file::parse(bytes)), preferences_file::write, |text| {
            preferences_file::parse(text.as_bytes())
        });
    let is_recent = survives(
        read(recent_file::parse(bytes)),
        |designs| recent_file::write(designs),
        |text| recent_file::parse(text.as_bytes()),
    );
    let is_plan = survives(read(sweep_plan::parse(bytes)), sweep_plan::write, |text| {
        sweep_plan::parse(text.as_bytes())
    });
    is_recovery || is_preferences || is_recent || is_plan
}

/// Whether there was a file to survive.
fn survives<T, E: std::fmt::Debug>(
    file: Option<T>,
    write: impl Fn(&T) -> String,
    parse: impl Fn(&str) -> Result<T, E>,
) -> bool {
    let Some(file) = file else { return false };
    let once = write(&file);
    match parse(&once) {
        Ok(again) => assert_eq!(write(&again), once),
        Err(error) => panic!("{error:?} in what was written here:\n{once}"),
    }
    true
}
