//! Large meshes of a design that was opened: read by a thread, one after the other, while a rod stands
//! in for each.

use crate::document::apply::what_is_missing;
use crate::document::requests::OpenWorld;
use crate::document::state::Notice;
use crate::runner::jobs::Job;
use crate::runner::wake::Waker;
use crate::schedule::EditorSystems;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::io;
use trackwright_project::{ImportedMesh, MeshImport, StoreError, file_name};

/// The mesh that is being read, if any.
#[derive(Resource, Default)]
pub struct AwaitedMeshes(Option<Reading>);

struct Reading {
    mesh: MeshImport,
    job: Job<Result<ImportedMesh, StoreError>>,
}

impl AwaitedMeshes {
    pub fn is_reading(&self) -> bool {
        self.0.is_some()
    }
}

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<AwaitedMeshes>().add_systems(
        Update,
        follow
            .run_if(resource_exists_and_changed::<OpenWorld>.or_else(is_reading))
            .in_set(EditorSystems::Input),
    );
}

fn is_reading(awaited: Res<AwaitedMeshes>) -> bool {
    awaited.is_reading()
}

/// Gives the world what was read, and has the next one read.
fn follow(
    world: Option<ResMut<OpenWorld>>,
    mut awaited: ResMut<AwaitedMeshes>,
    waker: Res<Waker>,
    mut notice: ResMut<Notice>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    let Some(mut world) = world else { return };
    let reading = &mut awaited.bypass_change_detection().0;
    let mut wanted = world.0.awaited_meshes();
    if let Some(Reading { mesh, job }) = reading {
        // Another design may be open by now, or the mesh be another one.
        let is_wanted = wanted.contains(mesh);
        let answer = job.answer();
        if is_wanted && answer.is_none() {
            return;
        }
        let own_notice = reading_words(mesh);
        if let (true, Some(answer)) = (is_wanted, answer) {
            let read = answer.unwrap_or_else(|lost| Err(lost_mesh(mesh, &lost)));
            match read {
                Ok(read) => {
                    world.0.keep_mesh(read);
                }
                Err(error) => {
                    world.0.miss_mesh(mesh, error);
                }
            }
            wanted = world.0.awaited_meshes();
        }
        *reading = None;
        // What was reported since stays.
        if *notice == own_notice {
            *notice = what_is_missing(&world.0);
        }
        redraw.write(RequestRedraw);
    }
    if let Some(mesh) = wanted.into_iter().next() {
        *notice = reading_words(&mesh);
        let import = mesh.clone();
        let job = Job::start("opened mesh", &waker, move |_| import.read());
        *reading = Some(Reading { mesh, job });
        redraw.write(RequestRedraw);
    }
}

fn reading_words(mesh: &MeshImport) -> Notice {
    Notice::Done(format!("Reading {}…", file_name(mesh.file())))
}

fn lost_mesh(mesh: &MeshImport, lost: &dyn std::error::Error) -> StoreError {
    StoreError::Read {
        file: mesh.file().to_owned(),
        expected: "a mesh",
        cause: io::Error::other(lost.to_string()),
    }
}
