//! The built-in world, embedded in the program: designs, and all that they refer to.

use super::error::StoreError;
use std::path::{Path, PathBuf};
use trackwright_design::Origin;

/// What opens where no file is named.
pub const DEFAULT_BUILTIN: &str = "pointer-on-head";

const NAMES: [&str; 4] = ["pointer-on-head", "shaver-on-head", "endoscope", "operating-theatre"];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Starter {
    Tool,
    ToolOnCrf,
}

impl Starter {
    pub const ALL: [Self; 2] = [Self::Tool, Self::ToolOnCrf];

    /// Of the embedded design; none of [`builtin_names`].
    pub fn name(self) -> &'static str {
        match self {
            Self::Tool => "new-tool",
            Self::ToolOnCrf => "new-tool-on-crf",
        }
    }

    /// The starter that a document still is, if it is one: it has no name of its own yet.
    pub fn of(origin: &Origin) -> Option<Self> {
        match origin {
            Origin::BuiltIn(name) => Self::ALL.into_iter().find(|it| it.name() == *name),
            Origin::File(_) => None,
        }
    }
}

/// A file of the repository by its path there.
macro_rules! embedded {
    ($($path:literal),* $(,)?) => {
        &[$(($path, include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../", $path)))),*]
    };
}

const FILES: &[(&str, &[u8])] = embedded![
    "designs/pointer-on-head.design.ron",
    "designs/shaver-on-head.design.ron",
    "designs/endoscope.design.ron",
    "designs/operating-theatre.design.ron",
    "designs/new-tool.design.ron",
    "designs/new-tool-on-crf.design.ron",
    "assets/bodies/pointer.body.ron",
    "assets/bodies/shaver.body.ron",
    "assets/bodies/endoscope.body.ron",
    "assets/bodies/head-crf.body.ron",
    "assets/bodies/tool.body.ron",
    "assets/bodies/crf.body.ron",
    "assets/environments/operating-table.env.ron",
    "assets/environments/operating-theatre.env.ron",
    "assets/meshes/pointer.glb",
    "assets/meshes/shaver.glb",
    "assets/meshes/endoscope.glb",
    "assets/meshes/head-crf.glb",
    "assets/meshes/field-generator.glb",
    "assets/meshes/operating-table.glb",
    "assets/meshes/c-arm.glb",
    "assets/meshes/retractor.glb",
    "assets/meshes/forceps.glb",
    "assets/meshes/mallet.glb",
];

/// The field generator.
pub(super) const GENERATOR_MESH: &str = "assets/meshes/field-generator.glb";

/// The built-in designs' names.
pub fn builtin_names() -> impl Iterator<Item = &'static str> {
    NAMES.into_iter()
}

/// The built-in design that a name stands for: one of its own, where there is no such file.
pub fn builtin_named(name: &str, file: &Path) -> Option<&'static str> {
    builtin_names().find(|builtin| *builtin == name && !file.exists())
}

pub(super) fn paths() -> impl Iterator<Item = &'static str> {
    FILES.iter().map(|(path, _)| *path)
}

/// The embedded file's own spelling of a path without dots.
pub(super) fn path_of(path: &Path) -> Option<&'static str> {
    paths().find(|name| Path::new(name) == path)
}

pub(super) fn bytes(path: &Path) -> Option<&'static [u8]> {
    FILES.iter().find(|(name, _)| Path::new(name) == path).map(|(_, bytes)| *bytes)
}

pub(super) fn design_file(name: &str) -> Result<(&'static str, PathBuf), StoreError> {
    let name =
        NAMES.into_iter().chain(Starter::ALL.map(Starter::name)).find(|n| *n == name).ok_or_else(
            || StoreError::NoSuchBuiltIn { name: name.to_owned(), names: NAMES.join(", ") },
        )?;
    Ok((name, PathBuf::from(format!("designs/{name}.design.ron"))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Files, generator_mesh, open_builtin, resolve};
    use trackwright_calibration::room_fit::{RoomOrder, RoomTable, fit_room};
    use trackwright_calibration::room_model::{GeneratorChoice, HarmonicOrder, RoomModel};
    use trackwright_field::fit::FitSettings;
    use trackwright_field::gaussian::GaussianField;
    use trackwright_field::generator::Generator;
    use trackwright_field::harmonic::Loss;
    use trackwright_field::samples::MapKind;
    use trackwright_field::{Environment, OutsidePolicy};
    use trackwright_formats::{body, design_file, environment};
    use trackwright_geometry::volume::Volume;
    use trackwright_simulation::{CancelToken, Mode, run};
    use trackwright_task::Task;

    const ENVIRONMENT: &str = "assets/environments/operating-table.env.ron";

    fn in_repository(path: &str) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
    }

    /// What a plain `fit` makes of the data: it chooses this generator, degree and loss.
    fn fitted() -> Environment {
        let read = |name: &str| {
            let path = in_repository("assets/environments/data").join(name);
            Files::default().read_measurements(&path).unwrap().samples(MapKind::Distortion)
        };
        let [samples, held_out] = ["cube-fit.csv", "cube-holdout.csv"].map(read);
        let order = RoomOrder {
            name: "Operating table",
            table: RoomTable { name: "cube-fit.csv", samples: &samples },
            held_out: Some(RoomTable { name: "cube-holdout.csv", samples: &held_out }),
            model: &RoomModel::Harmonic(HarmonicOrder {
                generator: GeneratorChoice::Known(Generator::planar_nine()),
                degree: Some(8),
                ridge: None,
                loss: Loss::default(),
            }),
            settings: FitSettings::without_polynomials(MapKind::Distortion),
            bounds: None,
            volume: Some(Volume::AuroraCube),
            jitter: None,
            with_support: true,
            sensors: None,
            registration: None,
        };
        fit_room(&order, |_| Task::default()).unwrap().environment
    }

    /// `UPDATE_BUILTIN=1` writes the environment anew, after a change of the fit.
    #[test]
    fn the_environment_is_the_fit_of_the_cube_data() {
        let fitted = fitted();
        if std::env::var_os("UPDATE_BUILTIN").is_some() {
            let files = Files::overwriting(true);
            let output = files.output(&in_repository(ENVIRONMENT)).unwrap();
            return output.write_environment(&fitted).unwrap();
        }
        let file = environment::parse(bytes(Path::new(ENVIRONMENT)).unwrap()).unwrap();
        let stored = file.environment;
        assert_eq!(stored.model.bounds(), fitted.model.bounds());
        let (kept, found) = (stored.process.unwrap(), fitted.process.unwrap());
        for row in &found.rows {
            let [kept, found] = [&stored.model, &fitted.model]
                .map(|model| model.evaluate_point(&row.point, OutsidePolicy::Clamp).error.values());
            let is_close = kept.iter().zip(&found).all(|(k, f)| (k - f).abs() < 1e-6);
            assert!(is_close, "{kept:?} {found:?}");
        }
        assert_eq!((kept.rows.len(), kept.refits.len()), (found.rows.len(), found.refits.len()));
        // A search that ends where steps are 3 %: other instructions may take another way there.
        let length_mm = |process: &GaussianField| process.kernel.scales[0].length_mm;
        assert!((length_mm(&kept) / length_mm(&found) - 1.0).abs() < 0.05);
        let holdout = stored.provenance.unwrap().holdout.unwrap();
        assert!((holdout.before.position_rms_mm - 2.48).abs() < 0.01, "{holdout:?}");
        assert!((holdout.after.position_rms_mm - 0.0356).abs() < 5e-4, "{holdout:?}");
    }

    /// `UPDATE_BUILTIN=1` writes them anew.
    #[test]
    fn every_file_is_as_the_program_would_write_it() {
        for (path, bytes) in FILES {
            let text = if path.ends_with(".body.ron") {
                body::write(&body::parse(bytes).unwrap())
            } else if path.ends_with(".design.ron") {
                design_file::write(&design_file::parse(bytes).unwrap())
            } else if path.ends_with(".env.ron") && !bytes.is_empty() {
                let file = environment::parse(bytes).unwrap();
                environment::write(&file.environment, file.metal.as_ref())
            } else {
                continue;
            };
            if std::env::var_os("UPDATE_BUILTIN").is_some() && *path != ENVIRONMENT {
                std::fs::write(in_repository(path), text).unwrap();
            } else {
                assert_eq!(text, std::str::from_utf8(bytes).unwrap(), "{path}");
            }
        }
    }

    #[test]
    fn each_design_has_its_sensors_in_the_volume() {
        for name in builtin_names().chain(Starter::ALL.map(Starter::name)) {
            let world = open_builtin(name).unwrap();
            let scenario = resolve(world.document.design(), &world.environment);
            let outcome = run(&scenario, &Mode::Single, &CancelToken::default(), None).unwrap();
            assert_eq!(
                (outcome.room_field.outside, outcome.room_field.out_of_volume),
                (0, 0),
                "{name}"
            );
            let outcome = run(&scenario, &Mode::Motion, &CancelToken::default(), None).unwrap();
            assert_eq!(outcome.room_field.trials, 3375, "{name}");
            assert_eq!(outcome.room_field.out_of_volume, 0, "{name}");
            assert!(outcome.room_field.free_axis.is_none(), "{name}");
        }
    }

    #[test]
    fn the_generator_is_behind_the_tracker_origin() {
        let bounds = generator_mesh().unwrap().body_bounds().unwrap();
        assert!(bounds.min_mm.z > -1.0 && bounds.max_mm.z > 10.0, "{bounds:?}");
    }

    #[test]
    fn the_coils_of_built_in_designs_fit() {
        for name in builtin_names().chain(Starter::ALL.map(Starter::name)) {
            let world = open_builtin(name).unwrap();
            let found = trackwright_simulation::coil_statements(&crate::coil_findings(&world));
            assert!(found.is_empty(), "{name}: {found:?}");
        }
    }

    #[test]
    fn the_pointers_axis_is_that_of_its_shaft() {
        let world = open_builtin("pointer-on-head").unwrap();
        let mesh = world.mesh(trackwright_design::BodyRole::Tool).unwrap();
        let surface = trackwright_geometry::surface::Surface::new(mesh).unwrap();
        let axis = surface.revolution_axis(&mesh.long_axis()).unwrap();
        assert_eq!(axis.direction, nalgebra::Vector3::z_axis());
        let off_mm = axis.arm_mm(&nalgebra::Point3::origin()).norm();
        assert!(off_mm < 1e-3, "{off_mm}");
    }

    #[test]
    fn sensors_sit_within_their_bodies() {
        for name in builtin_names() {
            let world = open_builtin(name).unwrap();
            for (role, body) in world.document.design().bodies() {
                let bounds = world.mesh(role).unwrap().body_bounds().unwrap();
                for sensor in &body.rigid.sensors {
                    assert!(bounds.contains(&sensor.position_in_body), "{name}: {}", sensor.name);
                }
            }
        }
    }
}
