//! `report`: a design and its study as one HTML page.

use super::named_design::note_meshes;
use super::prelude::*;
use super::simulate::{ModeArg, mode_arg, mode_of, note_world};
use std::ffi::{OsStr, OsString};
use trackwright_project::World;
use trackwright_report::page::{
    Extras, Report, ReportedStudy, SceneLegend, Slide, TableSection, workshop_section,
};
use trackwright_scene::{Ground, SceneWish};
use trackwright_simulation::CancelToken;
use trackwright_simulation::tolerance::manufacturing_sheet;

/// What a design's file is called after its own name.
const DESIGN_EXTENSION: &str = ".design.ron";

/// Width and height of a slide's picture.
#[cfg(feature = "editor")]
const SLIDE_PX: [u32; 2] = [1280, 720];

/// Write a design's report: one HTML page that holds all it shows, to open, mail and print
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// Design (*.design.ron), or the name of a built-in one
    design: PathBuf,

    /// Page to write (*.html), or a folder for it, where it gets the design's name; one that is there
    /// already is written over
    #[arg(short, long, value_name = "FOLDER|FILE.html")]
    output: PathBuf,

    /// Which poses to visit; the range of motion where the design has one, else its own pose
    #[arg(long, value_enum)]
    mode: Option<ModeArg>,

    /// Poses to visit (CSV): crf_x … crf_qz in the tracker frame, tool_x … tool_qz in the CRF frame
    #[arg(long, value_name = "FILE")]
    input: Option<PathBuf>,

    #[command(flatten)]
    as_is: AsIsArgs,
}

/// Simulates, and writes the page.
///
/// # Errors
/// Files that can't be used, a place that can't be written to.
pub fn run(args: &ReportArgs, files: &Files) -> anyhow::Result<()> {
    let mode = mode_arg(args.mode, args.input.as_deref())?;
    let date = trackwright_project::today()?.to_string();
    let world = files.open_design(&args.design)?;
    let mode = mode.unwrap_or(match world.document.design().motion {
        Some(_) => ModeArg::Motion,
        None => ModeArg::Single,
    });
    let mode = mode_of(files, mode, args.input.as_deref(), &world, args.as_is)?;
    let file = trackwright_project::report_file(&args.output, &own_name(&args.design))?;
    let output = files.output(&file)?;
    note_world(&world);
    note_meshes(&world);
    for missing in world.document.missing_layers(&world.environment) {
        output::note(&format!("note: {missing}"));
    }
    let study = ReportedStudy::run(&world, mode, &CancelToken::default())
        .with_context(|| args.design.display().to_string())?;
    let (scene_glb, scene_legend) = scene(&world).unzip();
    let extras = Extras {
        design_file: Some(file_name(&args.design)),
        input_file: args.input.as_deref().map(file_name),
        date: Some(date),
        slides: slides(&world)?,
        scene_glb,
        scene_legend,
        manufacturing: workshop(&world, &study)?,
    };
    let html = Report { world: &world, study: &study, extras }.to_html();
    output.write_bytes(html.as_bytes())?;
    let megabytes = html.len() as f64 / 1e6;
    output::print(&format!("{}: {megabytes:.2} MB", file.display()))
}

/// The scene that turns, and what it shows. Without one the page has its drawing.
fn scene(world: &World) -> Option<(Vec<u8>, SceneLegend)> {
    let wish = SceneWish { ground: Ground::Light, ..SceneWish::default() };
    let shown = Shown::new("computing what the layers show");
    match trackwright_scene::glb(world, &wish, &shown.task) {
        Ok(scene) => {
            let keys = scene.legend.into_iter().map(|key| (key.color, key.text)).collect();
            let (magnification, maps) = (scene.magnification, scene.colors);
            Some((scene.glb, SceneLegend { magnification, keys, maps }))
        }
        Err(error) => {
            output::note(&format!("note: no view that turns: {error}"));
            None
        }
    }
}

/// The manufacturing sheet of the range of motion, or of the own pose.
fn workshop(world: &World, study: &ReportedStudy) -> anyhow::Result<Option<TableSection>> {
    let shown = Shown::new("looking for tolerances");
    let mut sheet = manufacturing_sheet(&study.scenario, &shown.task)?;
    sheet.coils = trackwright_project::coil_findings(world);
    Ok(Some(workshop_section(&sheet)))
}

/// The slides as pictures.
#[cfg(feature = "editor")]
fn slides(world: &World) -> anyhow::Result<Vec<Slide>> {
    use trackwright_editor::app::picture::{self, PictureSetup};
    use trackwright_editor::app::preflight;
    use trackwright_editor::palette::Theme;
    use trackwright_editor::workspaces;

    let slides = &world.document.design().slides;
    if slides.is_empty() {
        return Ok(Vec::new());
    }
    if let Err(missing) = preflight::adapter() {
        output::note(&format!("note: the slides are left out: {missing}"));
        return Ok(Vec::new());
    }
    let mut pictures = Vec::with_capacity(slides.len());
    for (index, slide) in slides.iter().enumerate() {
        let setup = PictureSetup {
            has_panels: true,
            workspace: workspaces::present::WORKSPACE,
            slide: index,
            // A page is read on paper too: slides have its ground.
            theme: Theme::Light,
            ..PictureSetup::default()
        };
        let png = picture::png(world.clone(), SLIDE_PX, setup)?;
        let title = match slide.title.trim() {
            "" => format!("Slide {}", index + 1),
            title => title.to_owned(),
        };
        pictures.push(Slide::new(title, slide.caption.clone(), png)?);
    }
    Ok(pictures)
}

/// Without the editor nothing can be painted.
#[cfg(not(feature = "editor"))]
fn slides(world: &World) -> anyhow::Result<Vec<Slide>> {
    if !world.document.design().slides.is_empty() {
        output::note("note: the slides are left out: this build has no editor to paint them");
    }
    Ok(Vec::new())
}

/// A design's name among files: that of its file without `.design.ron`.
fn own_name(design: &Path) -> OsString {
    let name = design.file_name().unwrap_or(OsStr::new("report"));
    match name.to_str().and_then(|n| n.strip_suffix(DESIGN_EXTENSION)) {
        Some(stem) if !stem.is_empty() => stem.into(),
        _ => Path::new(name).file_stem().unwrap_or(name).to_owned(),
    }
}
