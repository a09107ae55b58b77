//! What the editor knows of the open document beside itself.

use bevy::prelude::*;

/// How many worlds were opened; grows when another design takes the place of the open one.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WorldGeneration(pub u64);

/// One line for the status bar: why an edit was refused, or what was saved where.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub enum Notice {
    #[default]
    Nothing,
    Done(String),
    Refused(String),
}

/// Owns [`WorldGeneration`] and [`Notice`].
pub struct DocumentStatePlugin;

impl Plugin for DocumentStatePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<WorldGeneration>().init_resource::<Notice>();
    }
}
