//! The meshes of a design's anatomy as they were read, or not: by what the design refers to them by,
//! so that the order of its list, names and poses mean nothing to them.

use super::error::StoreError;
use super::mesh_cache::{ImportedMesh, MeshImport};
use super::meshes::{MeshOwner, MeshProblem, words};
use super::open::{Reader, World};
use std::path::Path;
use std::sync::{Arc, OnceLock};
use trackwright_design::Design;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::mesh_reference::MeshReference;
use trackwright_geometry::mesh_report::MeshReport;

/// What was read for a design's anatomy.
#[derive(Clone, Debug, Default)]
pub(super) struct AnatomyMeshes(Vec<AnatomyMesh>);

#[derive(Clone, Debug)]
struct AnatomyMesh {
    reference: MeshReference,
    surface: Option<Arc<SurfaceMesh>>,
    /// Made when it is first asked for.
    report: OnceLock<Arc<MeshReport>>,
    cause: Option<Arc<StoreError>>,
}

impl World {
    /// The mesh that anatomy refers to; `None` where it could not be read.
    pub fn anatomy_mesh(&self, reference: &MeshReference) -> Option<&Arc<SurfaceMesh>> {
        self.anatomy.find(reference)?.surface.as_ref()
    }

    /// What there is to say of it, made when it is first asked for.
    pub fn anatomy_report(&self, reference: &MeshReference) -> Option<Arc<MeshReport>> {
        let mesh = self.anatomy.find(reference)?;
        let surface = mesh.surface.as_ref()?;
        let made = || Arc::new(MeshReport::of(surface));
        Some(Arc::clone(mesh.report.get_or_init(made)))
    }
}

impl AnatomyMeshes {
    pub(super) fn read(reader: &mut Reader, design_file: &Path, design: &Design) -> Self {
        let mut meshes = Self::default();
        for anatomy in &design.anatomy {
            // Several may show one file.
            if meshes.find(&anatomy.mesh).is_none() {
                let read = AnatomyMesh::read(reader, design_file, &anatomy.mesh);
                meshes.0.push(read);
            }
        }
        meshes
    }

    fn find(&self, reference: &MeshReference) -> Option<&AnatomyMesh> {
        self.0.iter().find(|mesh| mesh.reference == *reference)
    }

    /// Takes what a thread read in the place of what was there; whether the design refers to it.
    pub(super) fn take(&mut self, design: &Design, mesh: &ImportedMesh) -> bool {
        let reference = &mesh.wanted.reference;
        let is_wanted = design.anatomy.iter().any(|a| a.mesh == *reference);
        if is_wanted {
            self.0.retain(|mesh| mesh.reference != *reference);
            self.0.push(AnatomyMesh::kept(mesh));
        }
        is_wanted
    }

    /// The anatomy of a design that could not be read.
    pub(super) fn problems(&self, design: &Design) -> impl Iterator<Item = MeshProblem> {
        let anatomy = design.anatomy.iter().enumerate();
        anatomy.filter_map(|(index, anatomy)| {
            let cause = self.find(&anatomy.mesh)?.cause.as_ref()?;
            Some(MeshProblem {
                whose: MeshOwner::Anatomy(Some(index)),
                name: anatomy.name.clone(),
                reference: anatomy.mesh.clone(),
                cause: Arc::clone(cause),
            })
        })
    }

    /// States that the design moved, and what its files are called from there.
    pub(super) fn moved(&mut self, file_now: impl Fn(&str) -> String) {
        for mesh in &mut self.0 {
            mesh.reference.file = file_now(&mesh.reference.file);
        }
    }
}

impl AnatomyMesh {
    fn read(reader: &mut Reader, design_file: &Path, reference: &MeshReference) -> Self {
        let (surface, cause) = match reader.mesh_of(design_file, reference) {
            Ok(surface) => (Some(surface), None),
            Err(error) => (None, Some(Arc::new(error))),
        };
        Self { reference: reference.clone(), surface, report: OnceLock::new(), cause }
    }

    fn kept(mesh: &ImportedMesh) -> Self {
        Self {
            reference: mesh.wanted.reference.clone(),
            surface: Some(Arc::clone(&mesh.surface)),
            report: Arc::clone(&mesh.report).into(),
            cause: None,
        }
    }
}

/// Reads what the design's anatomy refers to and is not there yet, or all of it; whether anything
/// differs from before.
pub(super) fn refresh_anatomy(
    world: &mut World,
    reader: &mut Reader,
    design_file: &Path,
    is_forced: bool,
) -> Result<bool, StoreError> {
    let design = world.document.shared_design();
    let mut now = AnatomyMeshes::default();
    let mut is_changed = false;
    for anatomy in &design.anatomy {
        if now.find(&anatomy.mesh).is_some() {
            continue;
        }
        let before = world.anatomy.find(&anatomy.mesh).cloned();
        if !is_forced && let Some(before) = before {
            now.0.push(before);
            continue;
        }
        let owner = MeshOwner::Anatomy(None);
        let wanted = MeshImport::of_reference(world, owner, anatomy.mesh.clone())?;
        let kept = wanted.and_then(|wanted| world.mesh_cache.find(&wanted));
        let mut read = match kept.filter(|_| !is_forced) {
            Some(kept) => {
                reader.stamps.extend(kept.stamps());
                AnatomyMesh { reference: anatomy.mesh.clone(), ..AnatomyMesh::kept(kept) }
            }
            None => AnatomyMesh::read(reader, design_file, &anatomy.mesh),
        };
        match &before {
            // Whoever made something of it need not make it again.
            Some(before) if before.surface == read.surface => {
                read.surface.clone_from(&before.surface);
                is_changed |= words(before.cause.as_ref()) != words(read.cause.as_ref());
            }
            _ => is_changed = true,
        }
        now.0.push(read);
    }
    world.anatomy = now;
    Ok(is_changed)
}

#[cfg(test)]
mod tests {
    use super::super::{
        FileChange, MeshProblem, WatchedPart, changes, open_builtin, open_design, refresh_meshes,
        reload_meshes, save, save_as,
    };
    use super::*;
    use std::fs;
    use trackwright_design::{Anatomy, AnatomyEdit, AnatomyFrame, Edit};
    use trackwright_geometry::mesh_reference::MeshUnit;
    use trackwright_geometry::pose::Pose;

    /// A tetrahedron of this size, as OBJ.
    fn tetrahedron(size: f64) -> String {
        format!(
            "v 0 0 0\nv {size} 0 0\nv 0 {size} 0\nv 0 0 {size}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
        )
    }

    fn anatomy(name: &str, file: &str) -> Anatomy {
        Anatomy {
            name: name.to_owned(),
            mesh: MeshReference::new(file),
            on: AnatomyFrame::Crf,
            frame_from_mesh: Pose::identity(),
            color: None,
        }
    }

    fn add(world: &mut World, anatomy: Anatomy) {
        let edit = Edit::Anatomy(AnatomyEdit::Add(Box::new(anatomy)));
        world.document.apply(edit).unwrap();
        refresh_meshes(world).unwrap();
    }

    /// The pointer's design on the disk, with a head beside it in another folder.
    fn saved_world() -> (tempfile::TempDir, World) {
        let folder = tempfile::tempdir().unwrap();
        let scans = folder.path().join("scans");
        fs::create_dir(&scans).unwrap();
        fs::write(scans.join("head.obj"), tetrahedron(100.0)).unwrap();
        let mut world = open_builtin("pointer-on-head").unwrap();
        save_as(&mut world, &folder.path().join("a.design.ron")).unwrap();
        add(&mut world, anatomy("head", "scans/head.obj"));
        (folder, world)
    }

    fn size_mm(world: &World, index: usize) -> Option<f64> {
        let mesh = world.anatomy_mesh(&world.document.design().anatomy[index].mesh)?;
        Some(mesh.body_bounds()?.size_mm().amax())
    }

    #[test]
    fn anatomy_is_read_with_the_design_and_again_after_edits_and_their_undo() {
        let (folder, mut world) = saved_world();
        assert_eq!(size_mm(&world, 0), Some(100.0));
        save(&mut world).unwrap();
        let opened = open_design(&folder.path().join("a.design.ron")).unwrap();
        assert_eq!(opened.document.design(), world.document.design());
        assert_eq!(size_mm(&opened, 0), Some(100.0));
        // Another unit of the same file is another mesh; where it is is none.
        let mut inch = anatomy("inch", "scans/head.obj");
        inch.mesh.unit = Some(MeshUnit::Inch);
        inch.frame_from_mesh = Pose::translation(0.0, 0.0, 5.0);
        add(&mut world, inch);
        let head = Arc::clone(world.anatomy_mesh(&MeshReference::new("scans/head.obj")).unwrap());
        assert_eq!(size_mm(&world, 1), Some(2540.0));
        let remove = Edit::Anatomy(AnatomyEdit::Remove { index: 0 });
        world.document.apply(remove).unwrap();
        refresh_meshes(&mut world).unwrap();
        assert_eq!(size_mm(&world, 0), Some(2540.0));
        world.document.undo();
        refresh_meshes(&mut world).unwrap();
        assert_eq!((size_mm(&world, 0), size_mm(&world, 1)), (Some(100.0), Some(2540.0)));
        assert_eq!(world.anatomy_mesh(&MeshReference::new("scans/head.obj")), Some(&head));
    }

    #[test]
    fn anatomy_that_cannot_be_read_is_told_by_its_name_and_ends_nothing() {
        let (folder, mut world) = saved_world();
        add(&mut world, anatomy("face", "scans/face.stl"));
        fs::write(folder.path().join("scans/broken.stl"), "no mesh").unwrap();
        add(&mut world, anatomy("broken", "scans/broken.stl"));
        let told = |world: &World| -> Vec<(MeshOwner, String)> {
            let problems = world.mesh_problems().into_iter();
            let tell = |p: MeshProblem| (p.whose, p.to_string());
            problems.map(tell).collect()
        };
        save(&mut world).unwrap();
        let opened = open_design(&folder.path().join("a.design.ron")).unwrap();
        for world in [&world, &opened] {
            let [(face, missing), (broken, unreadable)] = &told(world)[..] else {
                panic!("{:?}", told(world));
            };
            assert_eq!(*face, MeshOwner::Anatomy(Some(1)));
            assert!(missing.starts_with("the anatomy \"face\" is missing: "), "{missing}");
            assert!(missing.contains("face.stl"), "{missing}");
            assert_eq!(*broken, MeshOwner::Anatomy(Some(2)));
            assert!(unreadable.contains("broken.stl"), "{unreadable}");
            assert_eq!(size_mm(world, 0), Some(100.0));
        }
        fs::write(folder.path().join("scans/face.stl"), "solid face\nendsolid face\n").unwrap();
        fs::write(folder.path().join("scans/broken.stl"), tetrahedron(1.0)).unwrap();
        assert!(reload_meshes(&mut world).unwrap());
        fs::copy(folder.path().join("scans/head.obj"), folder.path().join("scans/face.obj"))
            .unwrap();
        let found = Edit::Anatomy(AnatomyEdit::Set {
            index: 1,
            anatomy: Box::new(anatomy("face", "scans/face.obj")),
        });
        world.document.apply(found).unwrap();
        assert!(refresh_meshes(&mut world).unwrap());
        assert_eq!(size_mm(&world, 1), Some(100.0));
        assert_eq!(told(&world).len(), 1);
    }

    #[test]
    fn what_a_thread_read_is_not_read_twice_and_takes_the_place_of_what_was_there() {
        let (folder, mut world) = saved_world();
        let file = folder.path().join("scans/face.obj");
        fs::write(&file, tetrahedron(7.0)).unwrap();
        let wanted = MeshImport::of_file(&world, MeshOwner::Anatomy(None), &file, None);
        let wanted = wanted.unwrap().unwrap();
        assert_eq!(wanted.reference.file, "scans/face.obj");
        let read = wanted.read().unwrap();
        assert!(!world.keep_mesh(read.clone()));
        add(&mut world, anatomy("face", &wanted.reference.file));
        assert!(Arc::ptr_eq(world.anatomy_mesh(&wanted.reference).unwrap(), &read.surface));
        fs::write(&file, tetrahedron(8.0)).unwrap();
        assert!(world.keep_mesh(wanted.read().unwrap()));
        assert_eq!(size_mm(&world, 1), Some(8.0));
        assert!(changes(&world).is_empty());
    }

    #[test]
    fn a_design_that_is_saved_elsewhere_finds_its_anatomy_and_so_does_undo() {
        let (folder, mut world) = saved_world();
        let far = folder.path().join("far");
        fs::create_dir(&far).unwrap();
        let whole = folder.path().join("scans/head.obj");
        add(&mut world, anatomy("whole", &whole.to_string_lossy()));
        let remove = Edit::Anatomy(AnatomyEdit::Remove { index: 0 });
        world.document.apply(remove).unwrap();
        world.document.undo();
        refresh_meshes(&mut world).unwrap();
        save_as(&mut world, &far.join("b.design.ron")).unwrap();
        let file =
            |world: &World, index: usize| world.document.design().anatomy[index].mesh.file.clone();
        assert_eq!(file(&world, 0), "../scans/head.obj");
        assert_eq!(file(&world, 1), whole.to_string_lossy());
        assert_eq!((size_mm(&world, 0), size_mm(&world, 1)), (Some(100.0), Some(100.0)));
        assert!(!refresh_meshes(&mut world).unwrap());
        let opened = open_design(&far.join("b.design.ron")).unwrap();
        assert_eq!(size_mm(&opened, 0), Some(100.0));
        world.document.undo();
        refresh_meshes(&mut world).unwrap();
        assert_eq!(size_mm(&world, 0), Some(100.0));
        assert!(world.mesh_problems().is_empty());
    }

    #[test]
    fn a_mesh_that_somebody_else_writes_anew_is_told() {
        let (folder, world) = saved_world();
        assert_eq!(changes(&world), []);
        fs::write(folder.path().join("scans/head.obj"), "").unwrap();
        let [changed] = &changes(&world)[..] else {
            panic!("{:?}", changes(&world));
        };
        assert_eq!(changed.part, WatchedPart::Anatomy);
        assert_eq!(changed.change, FileChange::Content);
    }
}
