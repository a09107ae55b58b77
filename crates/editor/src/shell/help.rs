//! Help: where the documentation is, and what this program is.

use crate::document::open_outside::OpenOutside;
use crate::shell::commands::{AddCommand, Command, HELP};
use crate::shell::dialogs::{Dialog, DialogAnswer, Dialogs, NoRequest, buttons_ui, title_ui};
use crate::widgets::basic::quiet_ui;
use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;
use bevy_egui::egui::{Label, Ui};
use std::path::{Path, PathBuf};

pub const DOCUMENTATION: Command =
    Command::new(HELP, 10, "Documentation", "Opens the pages of the program's folder docs");
pub const ABOUT: Command = Command::new(
    HELP,
    11,
    "About trackwright…",
    "Shows the version, the licence, the graphics adapter, and the paper that the model is from",
);

/// The first page of the documentation, where it is at hand.
#[derive(Resource, Clone, Debug, PartialEq, Eq)]
pub struct Documentation(pub Option<PathBuf>);

impl Default for Documentation {
    fn default() -> Self {
        Self(std::env::current_exe().ok().and_then(|program| documentation_near(&program)))
    }
}

/// Where the pages of an installed program are, or of one that was built in its source.
const PLACES: [&str; 2] = ["docs", "share/doc/trackwright"];

/// A page that only this program's documentation has.
const OWN_PAGE: [&str; 2] = ["how-to", "decide-on-a-design.md"];

/// The first page in a folder above the program.
pub fn documentation_near(program: &Path) -> Option<PathBuf> {
    let folders = program.ancestors().skip(1);
    let mut places = folders.flat_map(|folder| PLACES.map(|place| folder.join(place)));
    let [folder, page] = OWN_PAGE;
    let docs = places.find(|docs| docs.join(folder).join(page).is_file())?;
    Some(docs.join("README.md"))
}

/// What the program is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AboutDialog {
    pub adapter: String,
}

const LICENCE: &str = "MIT or Apache-2.0, at your option";
const PAPER: &str = "The model: Fischer, G. S., Taylor, R. H.: Electromagnetic Tracker Measurement Error \
                     Simulation and Tool Design, MICCAI 2005";

impl AboutDialog {
    fn lines(&self) -> [String; 5] {
        [
            format!("Version {}", env!("CARGO_PKG_VERSION")),
            format!("Licence: {LICENCE}"),
            format!("Graphics adapter: {}", self.adapter),
            PAPER.to_owned(),
            "Not for clinical use".to_owned(),
        ]
    }
}

impl Dialog for AboutDialog {
    type Request = NoRequest;

    fn name(&self) -> &'static str {
        "about"
    }

    fn ui(&mut self, ui: &mut Ui) -> Option<DialogAnswer<Self>> {
        title_ui(ui, "trackwright");
        for line in self.lines() {
            ui.add(Label::new(line).wrap().selectable(true));
            ui.add_space(2.0);
        }
        buttons_ui(ui, &[("OK", DialogAnswer::Close)])
    }
}

/// Where the documentation would be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoDocumentation;

impl Dialog for NoDocumentation {
    type Request = NoRequest;

    fn name(&self) -> &'static str {
        "no documentation"
    }

    fn ui(&mut self, ui: &mut Ui) -> Option<DialogAnswer<Self>> {
        title_ui(ui, "The documentation is not at hand");
        let text = "It is the folder docs of the program's source, whose first page is docs/README.md. \
                    Beside this program there is none.";
        ui.add(Label::new(text).wrap());
        ui.add_space(4.0);
        quiet_ui(ui, "trackwright help lists the commands, F1 the keys of this window");
        buttons_ui(ui, &[("OK", DialogAnswer::Close)])
    }
}

/// Registers the commands.
pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<Documentation>()
        .add_message::<OpenOutside>()
        .add_command(DOCUMENTATION, show_documentation)
        .add_command(ABOUT, show_about);
}

fn show_documentation(
    documentation: Res<Documentation>,
    mut dialogs: ResMut<Dialogs>,
    mut outside: MessageWriter<OpenOutside>,
) {
    match &documentation.0 {
        Some(page) => {
            outside.write(OpenOutside(page.clone()));
        }
        None => dialogs.show(NoDocumentation),
    }
}

fn show_about(adapter: Option<Res<RenderAdapterInfo>>, mut dialogs: ResMut<Dialogs>) {
    let adapter = adapter.map_or_else(
        || "none".to_owned(),
        |adapter| format!("{} ({})", adapter.name, adapter.backend),
    );
    dialogs.show(AboutDialog { adapter });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn documentation_is_found_above_the_program() {
        let folder = tempfile::tempdir().unwrap();
        let at = |path: &str| {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            path
        };
        let program = at("target/release/trackwright");
        assert_eq!(documentation_near(&program), None);
        // Another program's documentation.
        std::fs::write(at("target/docs/README"), "").unwrap();
        assert_eq!(documentation_near(&program), None);
        let [how_to, page] = OWN_PAGE;
        std::fs::write(at(&["docs", how_to, page].join("/")), "").unwrap();
        assert_eq!(documentation_near(&program), Some(folder.path().join("docs/README.md")));
    }
}
