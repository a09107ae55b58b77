//! The slide's writing over the 3D view, large enough for the back of a room. While slides are
//! made, the same words stand in fields at the same places.

use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::verdict::{figure_color, verdict_mark};
use crate::workspaces::present::panels::StageView;
use crate::workspaces::present::requests::PresentRequest;
use bevy_egui::egui::accesskit::{self, Role};
use bevy_egui::egui::{
    Align2, Area, Color32, Context, FontId, Frame, Galley, Id, Margin, Order, Painter, Pos2, Rect,
    TextEdit, Ui, pos2, vec2,
};
use std::sync::Arc;
use trackwright_report::words::{PlainFigure, plain_figure};

// In points of a stage that is some 560 points high.
const TITLE_SIZE: f32 = 30.0;
const VALUE_SIZE: f32 = 40.0;
const WORDS_SIZE: f32 = 15.0;
const CAPTION_SIZE: f32 = 18.0;
const PAGE_SIZE: f32 = 12.0;
/// From the edges to what is written.
const MARGIN: f32 = 26.0;
/// Left free below for the scale, and for where the picture's conclusions come from.
const FOOT: f32 = 62.0;
/// Widest caption, of the stage.
const CAPTION_PART: f32 = 0.62;

/// Draws the slide; what it covers is added to `covered`.
pub fn stage_ui(
    ctx: &Context,
    stage: Rect,
    view: &StageView,
    covered: &mut Vec<Rect>,
) -> Vec<PresentRequest> {
    let (slide, index, count) = view.slide();
    let mut actions = Vec::new();
    let painter = ctx.layer_painter(bevy_egui::egui::LayerId::background()).with_clip_rect(stage);
    let left_top = stage.left_top() + vec2(MARGIN, MARGIN * 0.8);
    let title_width = stage.width() - 2.0 * MARGIN;
    let mut y = left_top.y;
    if view.presenter.is_editing {
        let (changed, rect) = field_ui(
            ctx,
            Field {
                id: Id::new(("slide title", index)),
                at: left_top,
                align: Align2::LEFT_TOP,
                width: title_width,
                size: TITLE_SIZE,
                hint: "Title",
                rows: 1,
            },
            &slide.title,
        );
        actions.extend(changed.map(|title| PresentRequest::SetTitle { slide: index, title }));
        y = rect.bottom();
    } else if !slide.title.trim().is_empty() {
        let color = palette::TEXT_STRONG.color32();
        let text = laid(&painter, &slide.title, TITLE_SIZE, color, title_width);
        y = plated(&painter, left_top, Align2::LEFT_TOP, &text, covered).bottom();
    }
    let shown = view.figures.map(|figures| {
        let shown = slide.figures.iter().filter_map(|f| plain_figure(*f, figures));
        shown.collect::<Vec<_>>()
    });
    figures(&painter, pos2(left_top.x, y + 14.0), &shown.unwrap_or_default(), covered);
    let caption_at = stage.left_bottom() + vec2(MARGIN, -FOOT);
    let caption_width = CAPTION_PART * stage.width();
    if view.presenter.is_editing {
        let (changed, _) = field_ui(
            ctx,
            Field {
                id: Id::new(("slide caption", index)),
                at: caption_at,
                align: Align2::LEFT_BOTTOM,
                width: caption_width,
                size: CAPTION_SIZE,
                hint: "What is to be seen, in a sentence",
                rows: 2,
            },
            &slide.caption,
        );
        actions.extend(changed.map(|caption| PresentRequest::SetCaption { slide: index, caption }));
    } else if !slide.caption.trim().is_empty() {
        let color = palette::TEXT_STRONG.color32();
        let text = laid(&painter, &slide.caption, CAPTION_SIZE, color, caption_width);
        plated(&painter, caption_at, Align2::LEFT_BOTTOM, &text, covered);
    }
    if count > 1 {
        let text = format!("{} / {count}", index + 1);
        let color = palette::TEXT_QUIET.color32();
        let text = laid(&painter, &text, PAGE_SIZE, color, stage.width());
        let at = stage.right_top() + vec2(-14.0, 10.0);
        covered.push(Align2::RIGHT_TOP.anchor_size(at, text.size()));
        painter.galley(covered[covered.len() - 1].min, text, color);
    }
    actions
}

fn laid(painter: &Painter, text: &str, size: f32, color: Color32, width: f32) -> Arc<Galley> {
    painter.layout(text.to_owned(), FontId::proportional(size), color, width)
}

/// Writing on a plate, so that it reads over any scene.
fn plated(
    painter: &Painter,
    at: Pos2,
    align: Align2,
    text: &Arc<Galley>,
    covered: &mut Vec<Rect>,
) -> Rect {
    let rect = align.anchor_size(at, text.size());
    let plate = rect.expand2(vec2(10.0, 6.0));
    painter.rect_filled(plate, 6.0, palette::plate());
    painter.galley(rect.min, Arc::clone(text), palette::TEXT_STRONG.color32());
    covered.push(plate);
    plate
}

/// One below the other.
fn figures(painter: &Painter, at: Pos2, shown: &[PlainFigure], covered: &mut Vec<Rect>) {
    let mut top = at;
    for figure in shown {
        let color = figure_color(figure.verdict);
        let value = laid(painter, &figure.value, VALUE_SIZE, color, f32::INFINITY);
        // Never by colour alone.
        let words = match figure.verdict {
            Some(verdict) => format!("{} {}", verdict_mark(verdict).0, figure.words),
            None => figure.words.clone(),
        };
        let quiet = palette::TEXT.color32();
        let words = laid(painter, &words, WORDS_SIZE, quiet, f32::INFINITY);
        let size = vec2(value.size().x.max(words.size().x), value.size().y + words.size().y - 2.0);
        let rect = Rect::from_min_size(top, size);
        let plate = rect.expand2(vec2(10.0, 5.0));
        painter.rect_filled(plate, 6.0, palette::plate());
        let words_at = rect.left_top() + vec2(0.0, value.size().y - 2.0);
        name_figure(painter, rect, &format!("{} {}", value.text(), words.text()));
        painter.galley(rect.min, value, color);
        painter.galley(words_at, words, quiet);
        covered.push(plate);
        top.y = plate.bottom() + 12.0;
    }
}

/// What is only painted has no name otherwise, for screen readers and for scripts.
fn name_figure(painter: &Painter, rect: Rect, name: &str) {
    painter.ctx().accesskit_node_builder(Id::new(("slide figure", name)), |node| {
        node.set_role(Role::Label);
        node.set_value(name);
        let [x0, y0, x1, y1] =
            [rect.left(), rect.top(), rect.right(), rect.bottom()].map(f64::from);
        node.set_bounds(accesskit::Rect { x0, y0, x1, y1 });
    });
}

/// A field over the scene.
struct Field {
    id: Id,
    at: Pos2,
    align: Align2,
    width: f32,
    size: f32,
    hint: &'static str,
    rows: usize,
}

/// What was written once the field is left, by Escape too, and where the field is. The words belong
/// to the field while it is written in, so that undo has one step for them.
fn field_ui(ctx: &Context, field: Field, text: &str) -> (Option<String>, Rect) {
    let area = Area::new(field.id)
        .order(Order::Middle)
        .fixed_pos(field.at)
        .pivot(field.align)
        .constrain(false);
    let shown = area.show(ctx, |ui| {
        Frame::new()
            .fill(palette::FIELD.color32_alpha(215))
            .inner_margin(Margin::symmetric(8, 4))
            .corner_radius(4)
            .show(ui, |ui| draft_ui(ui, &field, text))
            .inner
    });
    (shown.inner, shown.response.rect)
}

fn draft_ui(ui: &mut Ui, field: &Field, text: &str) -> Option<String> {
    let draft_id = field.id.with("draft");
    let mut draft: String =
        (ui.data(|data| data.get_temp(draft_id))).unwrap_or_else(|| text.to_owned());
    let edit = match field.rows {
        1 => TextEdit::singleline(&mut draft),
        rows => TextEdit::multiline(&mut draft).desired_rows(rows),
    };
    let edit = edit
        .id(field.id.with("text"))
        .font(FontId::proportional(field.size))
        .hint_text(field.hint)
        .desired_width(field.width - 16.0)
        .frame(Frame::NONE);
    let response = ui.add(edit);
    // Whether or not the window itself has the focus: what is written is not lost by another window.
    if ui.memory(|memory| memory.has_focus(response.id)) {
        ui.data_mut(|data| data.insert_temp(draft_id, draft));
        return None;
    }
    ui.data_mut(|data| data.remove::<String>(draft_id));
    (response.lost_focus() && draft != text).then_some(draft)
}
