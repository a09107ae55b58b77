//! What registers with the shell: workspaces, and panels around the 3D view. The shell lays out
//! what it finds here and knows none of it by name.

use crate::shell::commands::{AddCommand, Command, VIEW};
use crate::shell::window::Workspace;
use bevy::ecs::system::SystemId;
use bevy::prelude::*;
use bevy_egui::egui::Ui;

/// Where a panel is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Left,
    Right,
    /// Below the 3D view; of the height that [`PanelInfo::high`] gives.
    Bottom,
    /// Over the 3D view: gets a `Ui` of its size.
    Stage,
}

/// What is known of a panel without drawing it. Panels of one side stand in the order in which they
/// were registered.
#[derive(Clone, Copy, Debug)]
pub struct PanelInfo {
    /// Of the workspace.
    pub workspace: &'static str,
    pub side: Side,
    /// Whether it stays where it is while the others of its side scroll: it draws a panel of its
    /// own at the top or the foot of the side.
    pub is_fixed: bool,
    pub is_shown: fn(&World) -> bool,
    /// Of a panel at the bottom.
    pub height: fn(&World) -> f32,
}

impl PanelInfo {
    /// A section of a side that scrolls with the others.
    pub const fn new(workspace: Workspace, side: Side) -> Self {
        Self {
            workspace: workspace.name,
            side,
            is_fixed: false,
            is_shown: |_| true,
            height: |_| 0.0,
        }
    }

    /// It stays where it is while the others of its side scroll.
    #[must_use]
    pub const fn fixed(self) -> Self {
        Self { is_fixed: true, ..self }
    }

    /// How high it is at the bottom.
    #[must_use]
    pub const fn high(self, height: fn(&World) -> f32) -> Self {
        Self { height, ..self }
    }

    #[must_use]
    pub const fn shown_if(self, is_shown: fn(&World) -> bool) -> Self {
        Self { is_shown, ..self }
    }
}

/// A panel with the system that draws it.
#[derive(Clone, Copy, Debug)]
pub struct Registered {
    pub info: PanelInfo,
    pub system: SystemId<InMut<'static, Ui>>,
}

/// Every panel that was registered.
#[derive(Resource, Default)]
pub struct Panels(pub Vec<Registered>);

/// Every workspace that was registered, in the order of their tabs.
#[derive(Resource, Default)]
pub struct Workspaces(pub Vec<Workspace>);

impl Workspace {
    /// The command that shows it.
    pub fn command(&self) -> Command {
        let order = 100 + u16::from(self.order);
        Command::new(VIEW, order, self.command, self.about).keys(self.keys)
    }
}

/// Registers workspaces and panels.
pub trait AddToShell {
    /// Adds a workspace with its tab, and the command that shows it. That of order 0 is shown
    /// first.
    fn add_workspace(&mut self, workspace: Workspace) -> &mut Self {
        self.add_workspace_with(workspace, move |mut shown: ResMut<Workspace>| {
            shown.set_if_neq(workspace);
        })
    }

    /// Adds a workspace whose command does this.
    fn add_workspace_with<M>(
        &mut self,
        workspace: Workspace,
        command: impl IntoSystem<(), (), M> + 'static,
    ) -> &mut Self;

    /// Adds a panel, drawn by a system of its own that gets the `Ui` to draw in.
    fn add_panel<M>(
        &mut self,
        info: PanelInfo,
        system: impl IntoSystem<InMut<'static, Ui>, (), M> + 'static,
    ) -> &mut Self;
}

impl AddToShell for App {
    fn add_workspace_with<M>(
        &mut self,
        workspace: Workspace,
        command: impl IntoSystem<(), (), M> + 'static,
    ) -> &mut Self {
        let mut all = self.world_mut().get_resource_or_init::<Workspaces>();
        let at = all.0.partition_point(|other| other.order <= workspace.order);
        all.0.insert(at, workspace);
        let mut shown = self.world_mut().get_resource_or_init::<Workspace>();
        if at == 0 && workspace.order == 0 && *shown == Workspace::NONE {
            *shown = workspace;
        }
        self.add_command(workspace.command(), command)
    }

    fn add_panel<M>(
        &mut self,
        info: PanelInfo,
        system: impl IntoSystem<InMut<'static, Ui>, (), M> + 'static,
    ) -> &mut Self {
        let system = self.register_system(system);
        let mut panels = self.world_mut().get_resource_or_init::<Panels>();
        panels.0.push(Registered { info, system });
        self
    }
}
