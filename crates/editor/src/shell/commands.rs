//! Commands: what can be requested by name. Each plugin registers its own; menus, keys, the
//! palette and the sheet of shortcuts read the registry.

use crate::document::requests::{ActiveDrag, OpenWorld};
use crate::document::selection::Selection;
use crate::schedule::EditorSystems;
use crate::shell::keys::Keys;
use crate::shell::window::{PanelsShown, Workspace};
use crate::widgets::tooltip::with_keys;
use bevy::ecs::system::{SystemId, SystemParam, SystemState};
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use trackwright_design::Document;

/// Runs the commands that [`RunCommand`] requests, in [`EditorSystems::Input`].
pub struct CommandsPlugin;

/// When commands are run.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CommandsSystems;

/// Requests a command by its name.
#[derive(Message, Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunCommand(pub &'static str);

/// A menu, or a heading in lists of commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Group {
    /// Among the groups.
    pub order: u8,
    pub name: &'static str,
    /// The one workspace in which its commands are there; their keys may be others' elsewhere.
    pub workspace: Option<&'static str>,
}

impl Group {
    /// What its menu has.
    pub fn about(&self) -> String {
        format!("Commands of the group {}, with their keys", self.name)
    }
}

pub const FILE: Group = Group { order: 0, name: "File", workspace: None };
pub const EDIT: Group = Group { order: 1, name: "Edit", workspace: None };
pub const VIEW: Group = Group { order: 2, name: "View", workspace: None };
pub const HELP: Group = Group { order: 9, name: "Help", workspace: None };

/// What is known of a command without running it.
#[derive(Clone, Copy, Debug)]
pub struct Command {
    pub group: Group,
    /// Position in the group: tens are the parts of its menu; from 100 on it is in lists only.
    pub order: u16,
    /// No two commands share one.
    pub name: &'static str,
    /// What it does and what for, for tooltips and the palette.
    pub about: &'static str,
    /// The first is the one that is shown.
    pub keys: &'static [Keys],
    is_available: fn(&Situation) -> bool,
    label: Option<fn(&Situation) -> String>,
    is_for_drags: bool,
}

impl Command {
    /// A command without keys that is always available.
    pub const fn new(group: Group, order: u16, name: &'static str, about: &'static str) -> Self {
        Self {
            group,
            order,
            name,
            about,
            keys: &[],
            is_available: |_| true,
            label: None,
            is_for_drags: false,
        }
    }

    /// Keys that request it.
    #[must_use]
    pub const fn keys(self, keys: &'static [Keys]) -> Self {
        Self { keys, ..self }
    }

    /// Shown always, but to be chosen only while this holds.
    #[must_use]
    pub const fn available_if(self, is_available: fn(&Situation) -> bool) -> Self {
        Self { is_available, ..self }
    }

    /// What its menu calls it now.
    #[must_use]
    pub const fn labelled(self, label: fn(&Situation) -> String) -> Self {
        Self { label: Some(label), ..self }
    }

    /// Available in the middle of a drag, and only there.
    #[must_use]
    pub const fn for_drags(self) -> Self {
        Self { is_for_drags: true, ..self }
    }

    /// What its menu calls it now.
    pub fn label(&self, situation: &Situation) -> String {
        self.label.map_or_else(|| self.name.to_owned(), |label| label(situation))
    }

    /// Whether its menu lists it.
    pub fn is_in_menu(&self) -> bool {
        self.order < 100
    }

    /// Whether something opens that has the keys then, as the dots of its name have it.
    pub fn opens_something(&self) -> bool {
        self.name.ends_with('…')
    }

    /// What it does, and the key that does it.
    pub fn tooltip(&self) -> String {
        with_keys(self.about, &self.shown_keys())
    }

    /// Its first key as people write it; empty without one.
    pub fn shown_keys(&self) -> String {
        self.keys.first().map(ToString::to_string).unwrap_or_default()
    }
}

/// What decides which commands are available, and what they are called.
pub struct Situation<'a> {
    pub world: Option<&'a OpenWorld>,
    pub selection: &'a Selection,
    pub is_dragging: bool,
    pub workspace: Workspace,
    pub panels: PanelsShown,
}

impl Situation<'_> {
    /// The open document.
    pub fn document(&self) -> Option<&Document> {
        self.world.map(|world| &world.0.document)
    }

    /// Whether a command can be run now.
    pub fn allows(&self, command: &Command) -> bool {
        // Nothing else happens in the middle of a drag.
        let is_its_time = command.is_for_drags == self.is_dragging;
        let is_here = command.group.workspace.is_none_or(|own| own == self.workspace.name);
        is_its_time && is_here && (command.is_available)(self)
    }
}

/// Reads the [`Situation`].
#[derive(SystemParam)]
pub struct Availability<'w> {
    world: Option<Res<'w, OpenWorld>>,
    selection: Res<'w, Selection>,
    drag: Res<'w, ActiveDrag>,
    workspace: Res<'w, Workspace>,
    panels: Res<'w, PanelsShown>,
}

impl Availability<'_> {
    pub fn situation(&self) -> Situation<'_> {
        Situation {
            world: self.world.as_deref(),
            selection: &self.selection,
            is_dragging: self.drag.0,
            workspace: *self.workspace,
            panels: *self.panels,
        }
    }
}

/// Every command that was registered, in the order of menus.
#[derive(Resource, Default)]
pub struct CommandRegistry {
    all: Vec<Command>,
    systems: Vec<(&'static str, SystemId)>,
}

impl CommandRegistry {
    pub fn all(&self) -> &[Command] {
        &self.all
    }

    /// The command of a key with its modifiers: a workspace's own goes before one that is
    /// everywhere.
    pub fn of_key(
        &self,
        key: &str,
        control: bool,
        shift: bool,
        workspace: Workspace,
    ) -> Option<&Command> {
        let pressed =
            |keys: &Keys| keys.key == key && keys.control == control && keys.shift == shift;
        let of_group = |wanted: Option<&str>| {
            let mut all = self.all.iter();
            all.find(|own| own.group.workspace == wanted && own.keys.iter().any(pressed))
        };
        of_group(Some(workspace.name)).or_else(|| of_group(None))
    }
}

/// Registers commands.
pub trait AddCommand {
    /// Adds a command, and the system that carries it out.
    fn add_command<M>(
        &mut self,
        command: Command,
        system: impl IntoSystem<(), (), M> + 'static,
    ) -> &mut Self;
}

impl AddCommand for App {
    fn add_command<M>(
        &mut self,
        command: Command,
        system: impl IntoSystem<(), (), M> + 'static,
    ) -> &mut Self {
        let system = self.register_system(system);
        let mut commands = self.world_mut().get_resource_or_init::<CommandRegistry>();
        let key = |command: &Command| (command.group, command.order);
        let at = commands.all.partition_point(|other| key(other) <= key(&command));
        commands.all.insert(at, command);
        commands.systems.push((command.name, system));
        self
    }
}

/// A system that writes a message: most commands are no more.
pub fn write<T: Message + Clone>(message: T) -> impl FnMut(MessageWriter<T>) {
    move |mut messages: MessageWriter<T>| {
        messages.write(message.clone());
    }
}

impl Plugin for CommandsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<CommandRegistry>().add_message::<RunCommand>().add_systems(
            Update,
            run_commands
                .run_if(on_message::<RunCommand>)
                .in_set(CommandsSystems)
                .in_set(EditorSystems::Input),
        );
    }
}

/// A command that is not available now, or that nobody registered, does nothing.
fn run_commands(
    world: &mut World,
    requests: &mut SystemState<MessageReader<RunCommand>>,
    availability: &mut SystemState<(Res<CommandRegistry>, Availability)>,
) -> Result {
    let requested: Vec<RunCommand> = requests.get_mut(world)?.read().copied().collect();
    for RunCommand(name) in requested {
        let (commands, now) = availability.get_mut(world)?;
        let situation = now.situation();
        let is_available = commands.all.iter().any(|own| own.name == name && situation.allows(own));
        let system = commands.systems.iter().find(|(own, _)| *own == name && is_available);
        if let Some((_, system)) = system.copied() {
            world.run_system(system)?;
            world.write_message(RequestRedraw);
        }
    }
    Ok(())
}
