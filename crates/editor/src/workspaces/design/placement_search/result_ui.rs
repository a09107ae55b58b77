//! The result of a search: start and best side by side, the verdict on the gain, what binds, and the
//! answers that can be taken.

use crate::palette::{self, ThemedColor};
use crate::widgets::basic::right_text_ui;
use crate::widgets::basic::{
    MET_SIGN, count, decimal, main_button, quiet_ui, section_ui, short_name, signed, state_ui,
    warning_ui, with_unit,
};
use crate::widgets::theme;
use crate::widgets::tooltip::Explain;
use crate::widgets::verdict::verdict_mark;
use crate::workspaces::design::placement_search::charts_ui::{curve_ui, objective_text, pareto_ui};
use crate::workspaces::design::placement_search::state::{
    AnswerId, PlacementSearch, PlacementSearchRequest, SearchResult, Searched,
};
use crate::workspaces::design::placement_search::thumbnail::answer_row_ui;
use bevy_egui::egui::{Color32, Grid, Label, RichText, Ui};
use trackwright_optimization::{Goal, Layout as SensorLayout, Optimized};
use trackwright_simulation::comparison::{Difference, difference_words};
use trackwright_simulation::figures::{capitalised, with_minus_signs};
use trackwright_simulation::{Figures, Metric};

/// What stands over a result of another state of the design.
pub const STALE: &str = "Of another revision of the design: its answers cannot be taken";

/// Letters of a room's name.
const ROOM_CHARS: usize = 32;

/// Draws the result.
pub fn result_ui(
    ui: &mut Ui,
    search: &PlacementSearch,
    searched: &Searched,
    result: &SearchResult,
) -> Vec<PlacementSearchRequest> {
    let mut requests = Vec::new();
    let optimized = &result.optimized;
    section_ui(ui, "Result");
    if !search.is_current {
        warning_ui(ui, STALE);
    }
    verdict_ui(ui, searched.goal, optimized);
    for room in 0..result.rooms.len() {
        figures_ui(ui, searched.goal, result, room);
    }
    pose_changes_ui(ui, optimized);
    answers_ui(ui, search, searched.goal, result, &mut requests);
    pareto_ui(ui, (searched.goal, result), search.selected, &mut requests);
    ui.add_space(4.0);
    let take = ui.add_enabled(search.is_current, main_button("Take this one"));
    let about = "Gives the design the sensors and poses of the selected answer, in one undo step";
    if take.explained(about).clicked() {
        requests.push(PlacementSearchRequest::Take(search.selected));
    }
    details_ui(ui, result);
    section_ui(ui, "Course of the search");
    let start = Some(optimized.start.objective);
    curve_ui(ui, searched.goal, &search.curve, start, Some(result.took_secs));
    let layouts = count(usize::try_from(optimized.evaluations).unwrap_or(usize::MAX));
    let seconds = with_unit(&decimal(result.took_secs, 1), "s");
    quiet_ui(ui, format!("{layouts} layouts in {seconds}"));
    let is_hovered = |request: &PlacementSearchRequest| matches!(request, PlacementSearchRequest::Hover(hovered) if *hovered == search.hovered);
    let is_any = requests.iter().any(|r| matches!(r, PlacementSearchRequest::Hover(_)));
    requests.retain(|request| !is_hovered(request));
    if !is_any && search.hovered.is_some() {
        requests.push(PlacementSearchRequest::Hover(None));
    }
    requests
}

/// The figures that are made least.
fn least_figures(goal: Goal) -> Vec<Metric> {
    match goal {
        Goal::Figure(metric) => vec![metric],
        Goal::Requirement(requirement) => requirement.bounds().map(|(metric, _)| metric).collect(),
    }
}

fn difference(optimized: &Optimized, room: usize, metric: Metric) -> Option<&Difference> {
    optimized.gain.get(room)?.differences.iter().find(|of| of.metric == metric)
}

fn verdict_ui(ui: &mut Ui, goal: Goal, optimized: &Optimized) {
    let (text, color) = match optimized.is_better {
        true => (format!("{MET_SIGN} {}", optimized.verdict()), palette::MET),
        false => (optimized.verdict().to_owned(), palette::ACCENT),
    };
    state_ui(ui, &text, color);
    if optimized.is_stopped {
        quiet_ui(ui, "Stopped early: this is the best that was found until then");
    }
    let rough = optimized.roughly_built_words(|value| objective_text(goal, value));
    let crowded = optimized.crowded.iter().map(|own| capitalised(&own.words()));
    for words in rough.into_iter().chain(crowded) {
        wrapped_ui(ui, &words);
    }
    for (room, gain) in optimized.gain.iter().enumerate() {
        for metric in least_figures(goal) {
            let Some(difference) = difference(optimized, room, metric) else { continue };
            let words = with_minus_signs(&difference_words(difference, "the start"));
            let of_room = match optimized.gain.len() {
                1 => String::new(),
                _ => format!(" in {}", short_name(&gain.room, ROOM_CHARS)),
            };
            let label = capitalised(metric.label());
            wrapped_ui(
                ui,
                &format!("{label}{of_room}, in fields that the search did not see: {words}"),
            );
        }
    }
}

/// Start and best in one room.
fn figures_ui(ui: &mut Ui, goal: Goal, result: &SearchResult, room: usize) {
    let optimized = &result.optimized;
    let of = |layout: &SensorLayout| layout.studies.get(room).cloned();
    let (Some(start), Some(best)) = (of(&optimized.start), of(&optimized.best)) else {
        return;
    };
    if result.rooms.len() > 1 {
        quiet_ui(ui, short_name(&result.rooms[room], ROOM_CHARS));
    }
    Grid::new(("places figures", room)).num_columns(4).spacing([7.0, 3.0]).show(ui, |ui| {
        quiet_ui(ui, "");
        for head in ["start", "best", "change"] {
            right_text_ui(ui, head, palette::TEXT_QUIET.color32());
        }
        ui.end_row();
        for metric in least_figures(goal) {
            let name = format!("{}, {}", metric.short_label(), metric.unit());
            ui.label(RichText::new(name).color(palette::TEXT_QUIET.color32()));
            for study in [&start, &best] {
                let (text, color) = figure_text(goal, &study.figures, metric);
                let cell = right_text_ui(ui, &text, color);
                if let Some(figure) = study.figures.get(metric) {
                    cell.explained(figure.words(3, " "));
                }
            }
            let known = [&best, &start].map(|study| study.figures.get(metric).map(|f| f.value));
            let change = match known {
                [Some(best), Some(start)] => signed(best - start, 3),
                _ => String::new(),
            };
            right_text_ui(ui, &change, palette::TEXT_QUIET.color32());
            ui.end_row();
        }
    });
}

/// With the sign of its verdict where it has a bound.
fn figure_text(goal: Goal, figures: &Figures, metric: Metric) -> (String, Color32) {
    let text = figures.get(metric).map_or("none".to_owned(), |figure| decimal(figure.value, 3));
    let bound = match goal {
        Goal::Requirement(_) => figures.requirement.as_ref().and_then(|own| own.bound(metric)),
        Goal::Figure(_) => None,
    };
    match bound.map(|bound| verdict_mark(bound.verdict)) {
        Some((sign, color)) => (format!("{sign} {text}"), color),
        None => (text, theme::verdict_color(None)),
    }
}

fn pose_changes_ui(ui: &mut Ui, optimized: &Optimized) {
    let (best, start) = (&optimized.best, &optimized.start);
    for (name, change) in [
        ("CRF on the patient", best.crf_change(start)),
        ("Field generator", best.generator_change(start)),
    ] {
        if let Some(change) = change {
            let way = with_unit(&decimal(change.way_mm, 1), "mm");
            let turn = with_unit(&decimal(change.turn_deg, 1), "°");
            wrapped_ui(ui, &format!("{name}: moved {way}, turned {turn}"));
        }
    }
}

fn answers_ui(
    ui: &mut Ui,
    search: &PlacementSearch,
    goal: Goal,
    result: &SearchResult,
    requests: &mut Vec<PlacementSearchRequest>,
) {
    if result.optimized.candidates.is_empty() {
        return;
    }
    section_ui(ui, "Good answers");
    for (index, layout) in result.optimized.candidates.iter().enumerate() {
        let answer = AnswerId::Candidate(index);
        let name = format!("answer {}", index + 1);
        let value = match goal {
            Goal::Requirement(_) => format!("ratio {}", decimal(layout.objective, 3)),
            Goal::Figure(_) => objective_text(goal, layout.objective),
        };
        let is_selected = search.selected == answer;
        let row = answer_row_ui(ui, result, answer, (&name, &value), is_selected)
            .explained("Shows its places in the scene; a click selects it");
        if row.clicked() {
            requests.push(PlacementSearchRequest::Show(answer));
        }
        if row.hovered() {
            requests.push(PlacementSearchRequest::Hover(Some(answer)));
        }
    }
    quiet_ui(ui, "Green dots: sensors that are elsewhere than at the start");
}

/// What limits it, how flat the optimum is, what is undetermined, what else is to be known.
fn details_ui(ui: &mut Ui, result: &SearchResult) {
    let optimized = &result.optimized;
    if !optimized.binding.is_empty() {
        section_ui(ui, "What limits it");
        for binding in &optimized.binding {
            let words = binding.constraint.words();
            wrapped_ui(ui, &format!("Better beyond it: the coil of {} {words}", binding.sensor));
        }
    }
    if !optimized.flatness.is_empty() {
        section_ui(ui, "How far each may be off for 5\u{2009}% more");
        for flat in &optimized.flatness {
            let within = match flat.within_mm {
                Some(within_mm) => with_unit(&decimal(within_mm, 1), "mm"),
                None => "anywhere in its regions".to_owned(),
            };
            wrapped_ui(ui, &format!("{}: {within}", flat.sensor));
        }
    }
    let certain = optimized.certain_to_mm.map(|grid_mm| {
        let grid = with_unit(&decimal(grid_mm, 2), "mm");
        format!("certain up to {grid}: every layout of a grid so fine was judged")
    });
    let statements = optimized.undetermined.iter().chain(&certain).chain(&optimized.notes);
    let statements: Vec<&String> = statements.collect();
    if !statements.is_empty() {
        section_ui(ui, "To be known");
        for statement in statements {
            wrapped_ui(ui, &capitalised(statement));
        }
    }
}

fn wrapped_ui(ui: &mut Ui, text: &str) {
    ui.add(Label::new(RichText::new(text).color(palette::TEXT.color32())).wrap());
}
