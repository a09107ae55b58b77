//! The Present workspace: slides instead of panels, for people who do not design the tool.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`stage`] | looks at the design as the slide on the screen does, and gives the design's own view back |
//! | [`first`] | the slide of a design that has none |

pub mod first;
pub mod panels;
pub mod requests;
pub mod stage;

pub use requests::{PresentRequest, Presenter, WORKSPACE, is_presenting};

use crate::document::requests::{EditRequest, OpenWorld};
use crate::schedule::EditorSystems;
use crate::shell::commands::{AddCommand, Command, CommandsSystems, Group, write};
use crate::shell::keys::Keys;
use crate::shell::registry::{AddToShell, PanelInfo, Side, Workspaces};
use crate::shell::window::Workspace;
use crate::workspaces::layers_panel::layers_panel;
use crate::workspaces::present::panels::systems::{slides_panel, stage_panel};
use crate::workspaces::present::stage::Stage;
use crate::workspaces::study::state::StudyRequest;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use trackwright_design::{Document, Edit, Slide, SlideEdit, View};

const PRESENT: Group = Group { order: 4, name: "Present", workspace: Some(WORKSPACE.name) };

const NEXT: Command = Command::new(PRESENT, 100, "Next slide", "Goes on to the next slide")
    .keys(&[Keys::plain("right"), Keys::plain("pagedown")]);
const PREVIOUS: Command =
    Command::new(PRESENT, 101, "Previous slide", "Goes back to the slide before")
        .keys(&[Keys::plain("left"), Keys::plain("pageup")]);
const FIRST: Command =
    Command::new(PRESENT, 102, "First slide", "Begins again with the first slide")
        .keys(&[Keys::plain("home")]);
const PLAY: Command = Command::new(
    PRESENT,
    103,
    "Play the motion, or pause",
    "Moves the tool through its range of motion",
)
.keys(&[Keys::plain("space")])
.available_if(|now| now.document().is_some_and(|own| own.design().motion.is_some()));
const EDIT_SLIDES: Command = Command::new(
    PRESENT,
    104,
    "Edit slides",
    "Writes on slides, chooses what they show, and keeps views; once more shows them as others see them",
)
.keys(&[Keys::plain("e")]);
const LEAVE: Command =
    Command::new(PRESENT, 105, "End the presentation", "Back to where it was begun")
        .keys(&[Keys::plain("escape")]);

/// Shows slides while its workspace is shown; nothing is looked at before.
///
/// Answers [`PresentRequest`] in [`EditorSystems::Input`], and looks at the design as the slide does
/// at the end of [`EditorSystems::Edit`].
pub struct PresentPlugin;

impl Plugin for PresentPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Presenter>()
            .init_resource::<Stage>()
            .add_message::<PresentRequest>()
            .add_message::<StudyRequest>()
            .add_workspace_with(WORKSPACE, begin_or_leave)
            .add_panel(PanelInfo::new(WORKSPACE, Side::Left).shown_if(is_editing), slides_panel)
            .add_panel(PanelInfo::new(WORKSPACE, Side::Left).shown_if(is_editing), layers_panel)
            .add_panel(PanelInfo::new(WORKSPACE, Side::Stage), stage_panel)
            .add_command(NEXT, write(PresentRequest::Step(1)))
            .add_command(PREVIOUS, write(PresentRequest::Step(-1)))
            .add_command(FIRST, write(PresentRequest::Show(0)))
            .add_command(PLAY, write(StudyRequest::TogglePlay))
            .add_command(EDIT_SLIDES, write(PresentRequest::ToggleEditing))
            .add_command(LEAVE, write(PresentRequest::Leave))
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

fn is_editing(world: &World) -> bool {
    world.get_resource::<Presenter>().is_some_and(|presenter| presenter.is_editing)
}

/// Once more goes back.
fn begin_or_leave(mut shown: ResMut<Workspace>, mut requests: MessageWriter<PresentRequest>) {
    match *shown == WORKSPACE {
        true => {
            requests.write(PresentRequest::Leave);
        }
        false => *shown = WORKSPACE,
    }
}

/// The slides as the requests of a frame leave them, and the edits that do it: the document applies
/// those only afterwards.
struct Writing<'a, 'w> {
    document: &'a Document,
    slides: Vec<Slide>,
    edits: &'a mut MessageWriter<'w, EditRequest>,
}

impl Writing<'_, '_> {
    /// The last of the slides that has this number at most.
    fn nearest(&self, slide: usize) -> usize {
        slide.min(self.slides.len().saturating_sub(1))
    }

    /// A slide; of a design without slides, the one that it is shown with.
    fn slide(&self, index: usize) -> Slide {
        self.slides.get(index).cloned().unwrap_or_else(|| first::slide_of(self.document))
    }

    /// Changes a slide; the first change of a design without slides makes its first one.
    fn change(&mut self, index: usize, change: impl FnOnce(&mut Slide)) {
        let index = self.nearest(index);
        let mut slide = Box::new(self.slide(index));
        change(&mut slide);
        self.edit(match self.slides.is_empty() {
            true => SlideEdit::Add { index: 0, slide },
            false => SlideEdit::Set { index, slide },
        });
    }

    fn edit(&mut self, edit: SlideEdit) {
        match &edit {
            SlideEdit::Add { index, slide } => self.slides.insert(*index, Slide::clone(slide)),
            SlideEdit::Set { index, slide } => self.slides[*index].clone_from(slide),
            SlideEdit::Remove { index } => {
                self.slides.remove(*index);
            }
            SlideEdit::Move { from, to } => {
                let moved = self.slides.remove(*from);
                self.slides.insert(*to, moved);
            }
        }
        self.edits.write(EditRequest::Apply(Edit::Slides(edit)));
    }
}

fn answer(
    mut requests: MessageReader<PresentRequest>,
    world: Option<Res<OpenWorld>>,
    mut presenter: ResMut<Presenter>,
    mut stage: ResMut<Stage>,
    (mut workspace, workspaces): (ResMut<Workspace>, Option<Res<Workspaces>>),
    mut edits: MessageWriter<EditRequest>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    let Some(world) = world else {
        requests.clear();
        return;
    };
    let document = &world.0.document;
    let slides = document.design().slides.clone();
    let mut writing = Writing { document, slides, edits: &mut edits };
    // What was written comes first: one click may end the writing and begin something else.
    let (written, others): (Vec<_>, Vec<_>) =
        requests.read().cloned().partition(PresentRequest::is_writing);
    for request in written.into_iter().chain(others) {
        let shown = writing.nearest(presenter.slide);
        match request {
            PresentRequest::Step(by) => {
                presenter.slide = writing.nearest(shown.saturating_add_signed(by));
            }
            PresentRequest::Show(slide) => presenter.slide = writing.nearest(slide),
            PresentRequest::ToggleEditing => presenter.is_editing = !presenter.is_editing,
            PresentRequest::Leave => {
                presenter.is_editing = false;
                // A window that began with slides goes to the first workspace.
                let first = workspaces.as_ref().and_then(|all| all.0.first());
                workspace.set_if_neq(match presenter.from == Workspace::NONE {
                    true => first.copied().unwrap_or_default(),
                    false => presenter.from,
                });
            }
            PresentRequest::Add => {
                let index = (shown + 1).min(writing.slides.len());
                let slide = Slide { view: document.view().clone(), ..writing.slide(shown) };
                writing.edit(SlideEdit::Add { index, slide: Box::new(slide) });
                presenter.slide = index;
            }
            PresentRequest::Remove if !writing.slides.is_empty() => {
                writing.edit(SlideEdit::Remove { index: shown });
            }
            PresentRequest::Remove => {}
            PresentRequest::Move(by) => {
                let to = writing.nearest(shown.saturating_add_signed(by));
                if to != shown {
                    writing.edit(SlideEdit::Move { from: shown, to });
                    presenter.slide = to;
                }
            }
            PresentRequest::SetTitle { slide, title } => {
                writing.change(slide, |slide| slide.title = title);
            }
            PresentRequest::SetCaption { slide, caption } => {
                writing.change(slide, |slide| slide.caption = caption);
            }
            PresentRequest::SetFigure(figure, is_on) => writing.change(shown, |slide| {
                slide.figures.retain(|other| *other != figure);
                slide.figures.extend(is_on.then_some(figure));
            }),
            PresentRequest::KeepView => writing.change(shown, |slide| {
                // Who keeps the view has seen it.
                slide.view = View { unknown_layers: Vec::new(), ..document.view().clone() };
            }),
            PresentRequest::BackToView => stage.forget(),
        }
        redraw.write(RequestRedraw);
    }
}
