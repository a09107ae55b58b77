//! `trackwright render`: the 3D view as a picture, without a window.

use super::named_design::note_meshes;
use super::prelude::*;
use super::render_video::VideoArgs;
use clap::ValueEnum;
use trackwright_design::view::{Layer, Layers, View};
use trackwright_design::{BodyRole, MissingLayer};
use trackwright_editor::app::picture::{ComparedDesigns, PictureSetup, StudyTrial};
use trackwright_editor::app::{picture, preflight};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::palette::Theme;
use trackwright_editor::shell::preferences::InterfaceScale;
use trackwright_editor::shell::window::Workspace;
use trackwright_editor::workspaces::{self, field::state::TableRole};
use trackwright_geometry::orbit::{Axis, OrbitCamera};
use trackwright_optimization::Settings as SearchSettings;
use trackwright_project::World;

/// Widest and highest picture that adapters paint into one texture.
const MOST_PX: u32 = 8192;
const LEAST_PX: u32 = 64;

/// Draw a design's 3D view to a PNG file, without a window
#[derive(Args, Clone, Debug)]
pub struct RenderArgs {
    /// The design, or the name of a built-in one
    pub design: PathBuf,
    /// The picture to write, a PNG; with --turntable or --motion an .mp4, or a folder
    #[arg(short, long)]
    pub output: PathBuf,
    /// Width and height in pixels
    #[arg(long, default_value = "1440x900", value_name = "WxH", value_parser = picture_size)]
    pub size: [u32; 2],
    /// With the panels around it, as in the window
    #[arg(long)]
    pub window: bool,
    /// Size of panels and labels in percent, as the window's preference: at most what leaves the
    /// window 960 x 600 points
    #[arg(long, value_name = "PERCENT", default_value_t = 100, value_parser = clap::value_parser!(u32).range(50..=300))]
    pub scale: u32,
    /// With the panels of this workspace around it, or the writing of a slide
    #[arg(long, value_parser = WORKSPACE, value_name = "NAME")]
    pub workspace: Option<Workspace>,
    /// Measurement table to show in the Field workspace
    #[arg(long, value_name = "DATA.csv", requires = "workspace")]
    pub measurements: Option<PathBuf>,
    /// Held-out measurement table to show in the Field workspace
    #[arg(long, value_name = "DATA2.csv", requires = "workspace")]
    pub holdout: Option<PathBuf>,
    /// In the Decide workspace, the design that is pinned as the baseline
    #[arg(long, value_name = "DESIGN", requires = "workspace")]
    pub baseline: Option<PathBuf>,
    /// In the Decide workspace, further designs of the table
    #[arg(long, value_name = "DESIGN", num_args = 1.., requires = "workspace")]
    pub beside: Vec<PathBuf>,
    /// In the Decide workspace, recorded poses of the built tool
    #[arg(long, value_name = "RECORDED.csv", requires = "workspace")]
    pub recorded: Option<PathBuf>,
    /// In the Study workspace, the trial of the range of motion to show, from 1, or worst
    #[arg(long, value_name = "N", requires = "workspace", value_parser = study_trial)]
    pub trial: Option<StudyTrial>,
    /// In the Present workspace, the slide to show, from 1
    #[arg(long, value_name = "N", requires = "workspace", value_parser = clap::value_parser!(u32).range(1..))]
    pub slide: Option<u32>,
    /// What is selected: tool, crf, tool/tip, metal/NAME, or a sensor by its name, with its body where both
    /// bodies have one of that name, as in crf/left
    #[arg(long, value_name = "THING")]
    pub select: Option<String>,
    /// In light colours, for paper
    #[arg(long)]
    pub light: bool,
    /// From where to look; the design's own view by default
    #[arg(long, value_enum, value_name = "NAME")]
    pub view: Option<ViewName>,
    /// Turns the slice to face the view, through what the camera looks at
    #[arg(long)]
    pub facing_slice: bool,
    /// Search for better places of the sensors of this body first, the tool where none is named, and show
    /// what was found (in the Design workspace)
    #[arg(long, value_name = "BODY", value_parser = BODY, num_args = 0..=1, require_equals = true,
        default_missing_value = "tool")]
    pub better_places: Option<BodyRole>,
    #[arg(long, value_name = "LIST", value_parser = Layers::named, help = format!(
        "What to show, separated by commas: {}; or all, or none, which leaves bodies and sensors [default: the design's view]",
        Layer::names()
    ))]
    pub layers: Option<Layers>,
    #[command(flatten)]
    pub video: VideoArgs,
}

const BODY: Choice<BodyRole> = Choice(&[
    ("tool", "The sensors of the tool", BodyRole::Tool),
    ("crf", "The sensors of the CRF", BodyRole::Crf),
]);

const WORKSPACE: Choice<Workspace> = Choice(&[
    ("design", "Bodies, sensors, the result", workspaces::design::WORKSPACE),
    ("field", "The room and its measurements", workspaces::field::WORKSPACE),
    ("study", "Trials one by one", workspaces::study::WORKSPACE),
    (
        "decide",
        "The design beside a baseline, designs and rooms in one table",
        workspaces::decide::WORKSPACE,
    ),
    ("present", "Slides, as an audience sees them", workspaces::present::WORKSPACE),
]);

/// From where to look.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ViewName {
    /// Tool and CRF with what is around them
    Overview,
    /// Along the tracker's y axis
    Front,
    /// Along the tracker's x axis
    Side,
    /// From above, along the tracker's z axis
    Top,
    /// Near the tip
    Tip,
}

/// A trial by its number from 1, or the worst.
fn study_trial(text: &str) -> Result<StudyTrial, String> {
    match text.parse::<usize>() {
        Ok(number) if number > 0 => Ok(StudyTrial::Number(number - 1)),
        _ if text == "worst" => Ok(StudyTrial::Worst),
        _ => Err("expected a number from 1, or worst".to_owned()),
    }
}

/// Width and height in pixels.
fn picture_size(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.parse().ok().filter(|px| (LEAST_PX..=MOST_PX).contains(px));
    text.split_once('x')
        .and_then(|(width, height)| Some([side(width)?, side(height)?]))
        .ok_or_else(|| format!("expected WxH, each from {LEAST_PX} to {MOST_PX}, as in 1440x900"))
}

/// Writes the picture, whole or not at all. A mesh that cannot be read is noted and left out.
///
/// # Errors
/// A design that cannot be opened, no graphics adapter, or a file that cannot be written.
pub fn run(args: &RenderArgs, files: &Files) -> anyhow::Result<()> {
    let output = files.output(&args.output)?;
    let is_png = |e: &std::ffi::OsStr| e.eq_ignore_ascii_case("png");
    if !args.video.is_wanted() && !args.output.extension().is_some_and(is_png) {
        bail!("{}: expected a name that ends in .png", args.output.display());
    }
    refuse_unused(args)?;
    let mut world = files.open_design(&args.design)?;
    if args.better_places == Some(BodyRole::Crf) && world.document.design().crf.is_none() {
        bail!("--better-places=crf: the design has no CRF");
    }
    note_meshes(&world);
    preflight::adapter().context("cannot render")?;
    let size = args.size;
    let mut view = world.document.view().clone();
    if let Some(layers) = args.layers {
        view.layers = layers;
        view.unknown_layers.clear();
    }
    if let Some(name) = args.view {
        aim(&mut view, name, &world, size);
    }
    world.document.set_view(view);
    if args.facing_slice {
        face_slice(&mut world, size);
    }
    let selected = args.select.as_ref().map(|name| thing_named(&world, name)).transpose()?;
    let tables = [(TableRole::Training, &args.measurements), (TableRole::HeldOut, &args.holdout)];
    let slide = args.slide.map_or(Ok(0), |number| slide_numbered(&world, number))?;
    for missing in missing_layers(&world, args.workspace, slide, selected) {
        output::note(&format!("note: drawn without the {missing}"));
    }
    let setup = PictureSetup {
        slide,
        has_panels: args.window || args.workspace.is_some(),
        scale: InterfaceScale(f64::from(args.scale) / 100.0),
        workspace: args.workspace.unwrap_or_default(),
        tables: tables.into_iter().filter_map(|(role, file)| Some((role, file.clone()?))).collect(),
        compared: ComparedDesigns {
            baseline: args.baseline.clone(),
            designs: args.beside.clone(),
            recorded: args.recorded.clone(),
        },
        placement_search: args.better_places.map(|body| (body, SearchSettings::default())),
        trial: args.trial,
        selected,
        theme: match args.light {
            true => Theme::Light,
            false => Theme::Dark,
        },
    };
    if args.video.is_wanted() {
        return args.video.run(world, size, setup, &output);
    }
    let png = picture::png(world, size, setup)?;
    output.write_bytes(&png).with_context(|| format!("cannot write {}", args.output.display()))?;
    Ok(())
}

/// Refuses what another workspace than the named one would show.
fn refuse_unused(args: &RenderArgs) -> anyhow::Result<()> {
    let (field, decide) = (workspaces::field::WORKSPACE, workspaces::decide::WORKSPACE);
    let (study, present) = (workspaces::study::WORKSPACE, workspaces::present::WORKSPACE);
    let all = [
        ("--measurements", args.measurements.is_some(), vec![field], "field"),
        ("--holdout", args.holdout.is_some(), vec![field], "field"),
        ("--baseline", args.baseline.is_some(), vec![decide], "decide"),
        ("--beside", !args.beside.is_empty(), vec![decide], "decide"),
        ("--recorded", args.recorded.is_some(), vec![decide], "decide"),
        ("--trial", args.trial.is_some(), vec![study, present], "study"),
        ("--slide", args.slide.is_some(), vec![present], "present"),
    ];
    for (name, is_given, shown_by, expected) in all {
        let is_shown = args.workspace.is_some_and(|own| shown_by.contains(&own));
        if is_given && !is_shown {
            bail!("{name}: found another workspace, expected --workspace {expected}");
        }
    }
    let is_design = args.workspace.is_none_or(|own| own == workspaces::design::WORKSPACE);
    if args.better_places.is_some() && !is_design {
        bail!("--better-places: found another workspace, expected --workspace design");
    }
    Ok(())
}

/// Layers that the picture should show and cannot.
fn missing_layers(
    world: &World,
    workspace: Option<Workspace>,
    slide: usize,
    selected: Option<Selected>,
) -> Vec<MissingLayer> {
    let (design, is_slide) =
        (world.document.design(), workspace == Some(workspaces::present::WORKSPACE));
    let slide = design.slides.get(slide).filter(|_| is_slide);
    let view = slide.map_or(world.document.view(), |slide| &slide.view);
    let is_sensor_selected = is_slide || matches!(selected, Some(Selected::Sensor(..)));
    view.missing_layers(design, &world.environment, is_sensor_selected)
}

/// From 0. A design without slides is shown with one.
fn slide_numbered(world: &World, number: u32) -> anyhow::Result<usize> {
    let slides = world.document.design().slides.len().max(1);
    let slide = number as usize - 1;
    if slide >= slides {
        bail!("there is no slide {number}, expected one from 1 to {slides}");
    }
    Ok(slide)
}

fn thing_named(world: &World, name: &str) -> anyhow::Result<Selected> {
    let mut things = Vec::new();
    for (role, body) in world.document.design().bodies() {
        let of = role.name().to_lowercase();
        things.push((of.clone(), Selected::Body(role)));
        if body.rigid.tip_in_body.is_some() {
            things.push((format!("{of}/tip"), Selected::Tip(role)));
        }
        let sensors = body.rigid.sensors.iter().enumerate();
        things.extend(sensors.map(|(index, sensor)| {
            let what = Selected::Sensor(role, index);
            (format!("{of}/{}", sensor.name), what)
        }));
    }
    let objects = world.document.design().room_metal.iter().flat_map(|metal| &metal.objects);
    let objects = objects.enumerate();
    things
        .extend(objects.map(|(i, object)| (format!("metal/{}", object.name), Selected::Metal(i))));
    let is_named = |thing: &&(String, Selected)| thing.0 == name;
    // A sensor's own name is enough where it is unique.
    let is_sensor = |thing: &&(String, Selected)| {
        let own = thing.0.split_once('/').map(|(_, own)| own);
        own == Some(name) && matches!(thing.1, Selected::Sensor(..))
    };
    let found = (things.iter().find(is_named)).or_else(|| things.iter().find(is_sensor));
    found.map(|thing| thing.1).with_context(|| {
        let names: Vec<&str> = things.iter().map(|thing| thing.0.as_str()).collect();
        format!("nothing is named {name}, expected one of {}", names.join(", "))
    })
}

fn face_slice(world: &mut World, size: [u32; 2]) {
    let camera = trackwright_editor::viewport::camera::opening_camera(world, size.map(f64::from));
    let mut view = world.document.view().clone();
    view.slice.face(&camera, world.environment.model.bounds());
    world.document.set_view(view);
}

fn aim(view: &mut View, name: ViewName, world: &World, size: [u32; 2]) {
    use trackwright_editor::scene::extent;
    let view_px = size.map(f64::from);
    let target = match name {
        ViewName::Tip => Some(Selected::Tip(trackwright_design::BodyRole::Tool)),
        _ => None,
    };
    let target = Selection::of(target);
    let Some(sphere) = extent::of_selection(world, world.document.design(), &target) else {
        view.camera = None;
        return;
    };
    let mut camera: OrbitCamera = trackwright_editor::viewport::camera::OrbitRig::default().camera;
    match name {
        ViewName::Overview => {
            view.camera = None;
            return;
        }
        ViewName::Front => camera.look_along(Axis::Y),
        ViewName::Side => camera.look_along(Axis::X),
        ViewName::Top => camera.look_along(Axis::Z),
        ViewName::Tip => {}
    }
    camera.frame_sphere(sphere.center_mm, sphere.radius_mm, view_px);
    view.camera = Some(camera.into());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_two_numbers_within_limits() {
        assert_eq!(picture_size("320x240"), Ok([320, 240]));
        for wrong in ["320", "0x240", "320x", "9000x240", "axb", "-1x2", "320x240x3"] {
            assert!(picture_size(wrong).is_err(), "{wrong}");
        }
    }
}
