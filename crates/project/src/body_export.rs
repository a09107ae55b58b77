//! A body of an open design as a file of another kind: what is lost is known before it is written.

use super::error::StoreError;
use super::paths::{file_name, free_name};
use super::reader::home;
use super::tool::{body_format_of, is_same_file, moved_body_text};
use super::watch::watched_files;
use super::world::World;
use super::write::write_bytes;
use std::path::{Path, PathBuf};
use trackwright_design::definition::DefinitionKind;
use trackwright_design::{BodyRole, DesignBody};
use trackwright_formats::BodyFile;
use trackwright_formats::tool_definition::{BodyFormat, Conversion, Lost, from_body};
use trackwright_simulation::body::SensorOrientation;

/// What would be written, and where.
#[derive(Clone, Debug)]
pub struct BodyExport {
    file: PathBuf,
    source: PathBuf,
    body: BodyFile,
    /// `None` for a body file.
    conversion: Option<Conversion>,
    /// A mesh that no file on the disk could refer to.
    lost_mesh: Option<Lost>,
}

impl BodyExport {
    /// The body of a role in the format of the file's name; `None` where there is no such body.
    ///
    /// # Errors
    /// [`StoreError::NoBodyFormat`], [`StoreError::NotConvertible`], and [`StoreError::InUse`] for a
    /// file that the design is made of: Save alone writes those, and no maker's among them.
    pub fn of(world: &World, role: BodyRole, file: &Path) -> Result<Option<Self>, StoreError> {
        let (storage, design_file) = home(world.document.origin())?;
        let Some(own) = world.document.design().body(role) else {
            return Ok(None);
        };
        let format = body_format_of(file)?;
        let mut used = watched_files(world).into_iter();
        if used.any(|(_, used)| is_same_file(&used, file)) {
            return Err(StoreError::InUse { file: file.to_owned() });
        }
        let mut body = BodyFile::of(own);
        let conversion = match format {
            BodyFormat::Body => None,
            BodyFormat::Definition(format) => {
                let conversion = from_body(&body, format);
                Some(conversion.map_err(|cause| StoreError::NotConvertible {
                    file: file.to_owned(),
                    format: format.name(),
                    cause,
                })?)
            }
        };
        let is_embedded = |mesh: &str| !storage.is_on_disk(Path::new(mesh));
        let embedded = body.mesh.take_if(|mesh| is_embedded(&mesh.file));
        Ok(Some(Self {
            file: file.to_owned(),
            source: storage.resolve(&design_file, &own.reference),
            body,
            lost_mesh: embedded
                .filter(|_| conversion.is_none())
                .map(|mesh| Lost::Mesh { file: mesh.file }),
            conversion,
        }))
    }

    /// The file that is written.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// What it will be, with its article.
    pub fn kind_name(&self) -> &'static str {
        let kind = self.conversion.as_ref().map(|it| it.definition.kind());
        kind.map_or("a body", DefinitionKind::name)
    }

    /// What is lost and what else there is to know, a line each.
    pub fn notes(&self) -> Vec<String> {
        let mesh = self.lost_mesh.iter().map(|lost| format!("without {lost}"));
        let conversion = self.conversion.as_ref().map(Conversion::notes);
        mesh.chain(conversion.unwrap_or_default()).collect()
    }

    /// Writes it, over what is there.
    pub fn write(&self) -> Result<(), StoreError> {
        match &self.conversion {
            Some(conversion) => write_bytes(&self.file, &conversion.definition.write()),
            None => {
                let text = moved_body_text(&self.body, &self.source, &self.file);
                write_bytes(&self.file, text.as_bytes())
            }
        }
    }
}

/// A free name for a body's definition, of the kind that it came from or that holds its sensors.
pub fn definition_name(body: &DesignBody, folder: &Path) -> String {
    let kind = body.definition.as_ref().map(|it| it.kind);
    let sensors = &body.rigid.sensors;
    let all = |is: fn(&SensorOrientation) -> bool| sensors.iter().all(|s| is(&s.orientation));
    let is_rom = all(|it| *it == SensorOrientation::Marker)
        || all(|it| matches!(it, SensorOrientation::FiveDof(_)));
    let extension = match kind {
        Some(DefinitionKind::NdiOptical | DefinitionKind::NdiEm) => "rom",
        Some(DefinitionKind::ToolPlist) => "tool",
        Some(DefinitionKind::AtracsysIni) => "ini",
        Some(DefinitionKind::SawJson) => "json",
        None if is_rom => "rom",
        None => "ini",
    };
    let file = Path::new(&body.reference);
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    // "probe.body.ron" is "probe".
    let stem = stem.strip_suffix(".body").unwrap_or(&stem);
    let path = folder.join(format!("{stem}.{extension}"));
    file_name(&free_name(&path, |path| !path.exists()))
}

#[cfg(test)]
mod tests {
    use super::super::tool::read_tool;
    use super::super::{open_builtin, save_as};
    use super::*;
    use std::fs;
    use trackwright_formats::tool_definition::OnMismatch;

    #[test]
    fn losses_are_known_before_writing() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let world = open_builtin("pointer-on-head").unwrap();
        let own = world.document.design().tool.body.clone();
        assert_eq!(definition_name(&own, folder.path()), "pointer.rom");
        fs::write(at("pointer.rom"), "theirs").unwrap();
        assert_eq!(definition_name(&own, folder.path()), "pointer-2.rom");
        for (name, kind) in [
            ("a.rom", "an NDI Aurora ROM"),
            ("a.tool", "an NDI .tool file"),
            ("a.ini", "an Atracsys geometry"),
            ("a.body.ron", "a body"),
        ] {
            let export = BodyExport::of(&world, BodyRole::Tool, &at(name));
            let export = export.unwrap().unwrap();
            assert_eq!(export.kind_name(), kind);
            let notes = export.notes().join("\n");
            assert!(notes.contains("without the mesh"), "{name}: {notes}");
            let is_aurora = matches!(name, "a.rom" | "a.tool");
            assert_eq!(notes.contains("experimental"), is_aurora, "{notes}");
            assert!(!at(name).exists());
            export.write().unwrap();
            let read = read_tool(&at(name), OnMismatch::Refuse).unwrap().body;
            let sensors = |body: &trackwright_simulation::body::RigidBody| body.sensors.len();
            assert_eq!(sensors(&read.rigid), sensors(&own.rigid));
            // Nothing on the disk is what a part of the program is called.
            assert_eq!(read.mesh, None);
        }
    }

    #[test]
    fn the_designs_own_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let design = folder.path().join("a.design.ron");
        let mut world = open_builtin("pointer-on-head").unwrap();
        save_as(&mut world, &design).unwrap();
        let crf = folder.path().join("head-crf.body.ron");
        let before = fs::read(&crf).unwrap();
        for (file, expected) in [
            (&crf, "the design itself uses this file"),
            (&folder.path().join("a.txt"), "expected one in .body.ron, .rom"),
        ] {
            let error = BodyExport::of(&world, BodyRole::Tool, file).unwrap_err();
            assert!(error.to_string().contains(expected), "{error}");
        }
        assert_eq!(fs::read(&crf).unwrap(), before);
        // From the disk a body keeps its mesh.
        let deep = folder.path().join("deep/b.body.ron");
        fs::create_dir(folder.path().join("deep")).unwrap();
        let export = BodyExport::of(&world, BodyRole::Tool, &deep);
        let export = export.unwrap().unwrap();
        assert_eq!(export.notes(), [""; 0]);
        export.write().unwrap();
        let read = read_tool(&deep, OnMismatch::Refuse).unwrap().body;
        assert_eq!(read.mesh.unwrap().file, "../pointer.glb");
    }

    #[test]
    fn a_body_that_a_format_cannot_hold_is_refused() {
        let mut world = open_builtin("pointer-on-head").unwrap();
        let mut sensor = world.document.design().tool.body.rigid.sensors[0].clone();
        sensor.orientation = SensorOrientation::Marker;
        let edit = trackwright_design::Edit::SetSensor { body: BodyRole::Tool, index: 0, sensor };
        world.document.apply(edit).unwrap();
        let body = &world.document.design().tool.body;
        let name = definition_name(body, Path::new("/nowhere"));
        assert_eq!(name, "pointer.ini");
        let file = Path::new("/nowhere/pointer.rom");
        let error = BodyExport::of(&world, BodyRole::Tool, file).unwrap_err();
        let message = error.to_string();
        assert!(
            message.starts_with("/nowhere/pointer.rom: the body cannot be a ROM: 1 markers"),
            "{message}"
        );
    }
}
