//! The Present workspace: slides instead of panels, for people who do not design the tool.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`stage`] | looks at the design as the slide on the screen does, and gives the design's own view back |
//! | [`first`] | the slide of a design that has none |

pub mod first;
pub mod panels;
pub mod stage;

use crate::document::apply::WorldGeneration;
use crate::document::requests::{EditRequest, OpenWorld};
use crate::document::selection::Selection;
use crate::schedule::EditorSystems;
use crate::shell::commands::CommandsSystems;
use crate::shell::window::Workspace;
use crate::workspaces::present::stage::Stage;
use crate::workspaces::study::desk::StudyRequest;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use trackwright_design::{Edit, Slide, SlideEdit, View};

/// Shows slides while [`Workspace::Present`] is shown; nothing is looked at before.
///
/// Answers [`PresentRequest`] in [`EditorSystems::Input`], and looks at the design as the slide does
/// at the end of [`EditorSystems::Edit`].
pub struct PresentPlugin;

/// Asks for something while slides are shown.
#[derive(Message, Clone, Debug, PartialEq)]
pub enum PresentRequest {
    /// So many slides on, or back.
    Step(isize),
    /// From 0.
    Show(usize),
    /// Begins or ends writing on slides.
    ToggleEditing,
    /// Back to where it was begun.
    Leave,
    /// A slide like the shown one, looked at as it is now, after it.
    Add,
    Remove,
    /// The shown slide so many places on, or back.
    Move(isize),
    /// The shown slide, changed.
    Set(Box<Slide>),
    /// The shown slide is looked at as it is now.
    KeepView,
    /// As the slide has it, after one has looked around.
    BackToView,
}

/// Which slide is shown, and whether it is written on.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Presenter {
    /// From 0; no more than there are.
    pub slide: usize,
    pub is_editing: bool,
    /// Where it goes back to.
    pub(crate) from: Workspace,
}

/// What the person is at, as a run condition.
pub fn is_presenting(workspace: Res<Workspace>) -> bool {
    *workspace == Workspace::Present
}

impl Plugin for PresentPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Presenter>()
            .init_resource::<Stage>()
            .init_resource::<Workspace>()
            .init_resource::<WorldGeneration>()
            .init_resource::<Selection>()
            .add_message::<PresentRequest>()
            .add_message::<StudyRequest>()
            .add_message::<EditRequest>()
            .add_message::<RequestRedraw>()
            .add_systems(
                Update,
                answer
                    .run_if(on_message::<PresentRequest>)
                    .after(CommandsSystems)
                    .in_set(EditorSystems::Input),
            )
            .add_systems(
                Update,
                (
                    stage::remember_origin.before(EditorSystems::Edit),
                    stage::follow
                        .run_if(stage::may_differ)
                        .after(EditorSystems::Edit)
                        .before(EditorSystems::Solve),
                ),
            );
    }
}

fn answer(
    mut requests: MessageReader<PresentRequest>,
    world: Option<Res<OpenWorld>>,
    mut presenter: ResMut<Presenter>,
    mut stage: ResMut<Stage>,
    mut workspace: ResMut<Workspace>,
    mut edits: MessageWriter<EditRequest>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    let Some(world) = world else {
        requests.clear();
        return;
    };
    let document = &world.0.document;
    let slides = &document.design().slides;
    for request in requests.read() {
        let shown = presenter.slide.min(slides.len().saturating_sub(1));
        let last = slides.len().saturating_sub(1);
        // The first change of a design without slides makes its first one.
        let current = || {
            let slide = slides.get(shown).cloned();
            slide.unwrap_or_else(|| first::slide_of(document))
        };
        let mut edit = |edit| {
            edits.write(EditRequest::Apply(Edit::Slides(edit)));
        };
        let mut set = |slide: Slide| {
            let (index, slide) = (shown, Box::new(slide));
            edit(match slides.is_empty() {
                true => SlideEdit::Add { index: 0, slide },
                false => SlideEdit::Set { index, slide },
            });
        };
        match request {
            PresentRequest::Step(by) => {
                presenter.slide = shown.saturating_add_signed(*by).min(last);
            }
            PresentRequest::Show(slide) => presenter.slide = (*slide).min(last),
            PresentRequest::ToggleEditing => presenter.is_editing = !presenter.is_editing,
            PresentRequest::Leave => {
                presenter.is_editing = false;
                workspace.set_if_neq(presenter.from);
            }
            PresentRequest::Add => {
                let index = (shown + 1).min(slides.len());
                let slide = Slide { view: document.view().clone(), ..current() };
                let slide = Box::new(slide);
                edit(SlideEdit::Add { index, slide });
                presenter.slide = index;
            }
            PresentRequest::Remove if !slides.is_empty() => {
                edit(SlideEdit::Remove { index: shown });
            }
            PresentRequest::Remove => {}
            PresentRequest::Move(by) => {
                let to = shown.saturating_add_signed(*by).min(last);
                if to != shown {
                    edit(SlideEdit::Move { from: shown, to });
                    presenter.slide = to;
                }
            }
            PresentRequest::Set(slide) => set(Slide::clone(slide)),
            PresentRequest::KeepView => set(Slide {
                view: View {
                    // Who keeps the view has seen it.
                    unknown_layers: Vec::new(),
                    ..document.view().clone()
                },
                ..current()
            }),
            PresentRequest::BackToView => stage.forget(),
        }
        redraw.write(RequestRedraw);
    }
}
