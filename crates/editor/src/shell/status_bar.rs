//! The line at the bottom: what the pointer can do now, and what the study took.

use crate::document::own_program::WriteJob;
use crate::document::requests::{ActiveDrag, FileRequest, OpenWorld};
use crate::document::selection::{Hovered, Selected};
use crate::document::state::Notice;
use crate::palette;
use crate::palette::ThemedColor;
use crate::runner::results::Results;
use crate::shell::window::{PointerHint, Presentation, StatusNote};
use crate::widgets::basic::{THIN_SPACE, counted, quiet_ui, short_name};
use crate::widgets::tooltip::Explain;
use bevy::prelude::*;
use bevy_egui::egui::{self, Align, Button, Layout, RichText, Ui};
use std::time::Duration;
use trackwright_design::{BodyRole, Design};
use trackwright_formats::printable::printable;

/// Letters of a file's name, so that the rest of the line is seen in a narrow window.
const MOST_LETTERS: usize = 40;

/// What the line shows.
pub struct StatusView<'a> {
    pub hint: String,
    /// The workspace's note on what the scene shows.
    pub note: Option<&'a str>,
    /// Trials of the study shown and how long it took; a picture, which is the same each time,
    /// shows no time.
    pub study: Option<(usize, Option<Duration>)>,
    /// The file that is being written, by its name.
    pub writing: Option<String>,
    /// Trials with a sensor outside the model's box.
    pub outside: usize,
    /// What was done or refused last, if the person has not done anything since.
    pub notice: &'a Notice,
}

/// Draws the line.
pub(crate) fn status_bar(
    mut ui: InMut<Ui>,
    (world, results, notice): (Res<OpenWorld>, Res<Results>, Res<Notice>),
    (note, pointer): (Res<StatusNote>, Res<PointerHint>),
    (hovered, drag): (Res<Hovered>, Res<ActiveDrag>),
    presentation: Res<Presentation>,
    (writing, mut requests): (Option<Res<WriteJob>>, MessageWriter<FileRequest>),
) {
    let design = world.0.document.design();
    let study = results.study.as_ref();
    let status = StatusView {
        hint: pointer.0.clone().unwrap_or_else(|| hint(design, hovered.0, drag.0)),
        note: note.0.as_deref(),
        study: study.map(|study| {
            let took = presentation.window.then_some(study.took);
            (study.value.room_field.trials, took)
        }),
        outside: study.map_or(0, |study| study.value.room_field.outside),
        writing: writing.and_then(|job| job.file_name()),
        notice: &notice,
    };
    requests.write_batch(status_bar_ui(&mut ui, &status));
}

/// Draws the line from what it shows.
pub fn status_bar_ui(ui: &mut Ui, status: &StatusView) -> Option<FileRequest> {
    let mut request = None;
    ui.horizontal_centered(|ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.add_space(6.0);
            if status.outside > 0 {
                let text = format!("{} outside", crate::widgets::basic::count(status.outside));
                ui.label(small(text).color(palette::MISSED.color32()));
                ui.add_space(10.0);
            }
            if let Some((trials, took)) = status.study {
                let trials = counted(trials, "trial", "trials");
                quiet_ui(
                    ui,
                    took.map_or_else(
                        || trials.clone(),
                        |took| format!("{trials} in {}", duration(took)),
                    ),
                );
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                ui.add_space(6.0);
                if let Some(file) = &status.writing {
                    ui.label(small(format!("Writing {}…", short_name(file, MOST_LETTERS))));
                    let cancel = ui.add(Button::new(small("Cancel".to_owned())).small());
                    if cancel
                        .explained("Stops writing the file; an older one of its name stays")
                        .clicked()
                    {
                        request = Some(FileRequest::CancelWriting);
                    }
                    ui.add_space(10.0);
                }
                if let Some(note) = status.note {
                    ui.label(small(note.to_owned()).color(palette::ACCENT.color32()));
                    ui.add_space(10.0);
                }
                let (text, color) = match status.notice {
                    Notice::Refused(notice) => (format!("⚠ {notice}"), palette::MISSED),
                    Notice::Done(notice) => (notice.clone(), palette::TEXT),
                    Notice::Nothing => (status.hint.clone(), palette::TEXT_QUIET),
                };
                ui.add(egui::Label::new(small(text).color(color.color32())).truncate());
            });
        });
    });
    request
}

fn small(text: String) -> RichText {
    RichText::new(printable(&text)).font(crate::widgets::theme::label_font())
}

/// `4.1 ms`, `2.31 s`.
pub fn duration(took: Duration) -> String {
    let milliseconds = took.as_secs_f64() * 1e3;
    if milliseconds < 1000.0 {
        format!("{milliseconds:.1}{THIN_SPACE}ms")
    } else {
        format!("{:.2}{THIN_SPACE}s", took.as_secs_f64())
    }
}

/// What the pointer can do now, in words.
pub fn hint(design: &Design, hovered: Option<Selected>, is_dragging: bool) -> String {
    if is_dragging {
        return "Esc takes the drag back · Shift moves finely · Ctrl snaps · Alt leaves the surface"
            .to_owned();
    }
    let body_name = |role| match role {
        BodyRole::Tool => "tool",
        BodyRole::Crf => "CRF",
    };
    match hovered {
        Some(Selected::Sensor(role, index)) => {
            let name = design
                .body(role)
                .and_then(|body| body.rigid.sensors.get(index))
                .map_or("", |sensor| sensor.name.as_str());
            format!(
                "Sensor {name}: click selects, Ctrl+click adds, right click shows what can be done, \
                 drag slides it along the {}'s surface",
                body_name(role)
            )
        }
        Some(Selected::Body(role)) => format!("Click selects the {}", body_name(role)),
        Some(Selected::Anatomy(index)) => {
            let name = design.anatomy.get(index).map_or("", |a| a.name.as_str());
            format!("Click selects the anatomy {name}")
        }
        Some(Selected::Metal(index)) => {
            let name = design.metal_object(index).map_or("", |object| object.name.as_str());
            format!("Click selects the metal object {name}: its handles move and turn it")
        }
        Some(Selected::Tip(role)) => format!("Click selects the tip of the {}", body_name(role)),
        None => {
            "Left selects and drags · middle orbits · Shift+middle pans · wheel zooms · F frames"
                .to_owned()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_milliseconds_below_a_second() {
        assert_eq!(duration(Duration::from_micros(4_100)), "4.1\u{2009}ms");
        assert_eq!(duration(Duration::from_millis(2_310)), "2.31\u{2009}s");
    }
}
