//! `export scene`: the 3D view of a design as binary glTF.

use super::super::file_kinds::ends_with;
use super::super::named_design::note_meshes;
use super::super::prelude::*;
use super::super::simulate::note_world;
use trackwright_design::view::{Layer, Layers};
use trackwright_design::{BodyRole, Design};
use trackwright_scene::{Ground, MOST_TRIANGLES, SceneWish};

#[derive(Debug, Args)]
pub struct SceneArgs {
    /// Design (*.design.ron), or the name of a built-in one
    design: PathBuf,

    /// File to write (*.glb): binary glTF 2.0, metres, +y up
    #[arg(short, long, value_name = "FILE.glb")]
    output: PathBuf,

    #[arg(long, value_name = "LIST", value_parser = Layers::named, help = format!(
        "What to show, separated by commas: {}; or all, or none, which leaves bodies and sensors [default: the design's view]",
        Layer::names()
    ))]
    layers: Option<Layers>,

    /// The sensor whose placements paint its body, by its name, with its body where both bodies have
    /// one of that name, as in crf/left; the tool's first where left out
    #[arg(long, value_name = "NAME")]
    sensor: Option<String>,

    /// In light colours, for a light ground
    #[arg(long)]
    light: bool,

    /// Most triangles of a body; one that has more is drawn coarser, with the fewest that make a surface
    /// where that is more
    #[arg(long, value_name = "N", default_value_t = MOST_TRIANGLES as u64, value_parser = clap::value_parser!(u64).range(1..))]
    triangles: u64,
}

/// Computes what the layers show, draws and writes it.
///
/// # Errors
/// A design that can't be opened, a sensor that is not there, what the format cannot hold.
pub fn run(args: &SceneArgs, files: &Files) -> anyhow::Result<()> {
    let output = files.output(&args.output)?;
    if !ends_with(&args.output, ".glb") {
        bail!(
            "{}: expected a name that ends with .glb, as the scene is written in binary glTF",
            args.output.display()
        );
    }
    let world = files.open_design(&args.design)?;
    note_meshes(&world);
    note_world(&world);
    let named = || args.design.display().to_string();
    let painted = args.sensor.as_ref().map(|name| sensor_named(world.document.design(), name));
    let painted = painted.transpose().with_context(named)?;
    let wish = SceneWish {
        layers: args.layers,
        ground: match args.light {
            true => Ground::Light,
            false => Ground::Dark,
        },
        painted,
        most_triangles: usize::try_from(args.triangles).unwrap_or(usize::MAX),
    };
    let shown = Shown::new("computing what the layers show");
    let scene = trackwright_scene::glb(&world, &wish, &shown.task).with_context(named)?;
    drop(shown);
    output.write_bytes(&scene.glb)?;
    for note in &scene.notes {
        output::note(&format!("note: {note}"));
    }
    let mut lines = vec![format!(
        "{} kB written to {}, errors × {}",
        with_separators(scene.glb.len().div_ceil(1000)),
        args.output.display(),
        scene.magnification
    )];
    lines.extend(scene.colors);
    output::print(&lines.join("\n"))
}

/// A sensor by its name, after its body's where both have one of that name.
fn sensor_named(design: &Design, name: &str) -> anyhow::Result<(BodyRole, usize)> {
    let all: Vec<(String, BodyRole, usize)> = design
        .bodies()
        .flat_map(|(role, body)| {
            let sensors = body.rigid.sensors.iter().enumerate();
            let full = move |sensor: &str| format!("{}/{sensor}", role.name().to_lowercase());
            sensors.map(move |(index, sensor)| (full(&sensor.name), role, index))
        })
        .collect();
    let own = |full: &str| full.split_once('/').map(|(_, own)| own == name);
    let found = all.iter().find(|(full, ..)| full == name);
    let found = found.or_else(|| all.iter().find(|(full, ..)| own(full) == Some(true)));
    match found {
        Some((_, role, index)) => Ok((*role, *index)),
        None => bail!(
            "no sensor is named {name}, expected one of {}",
            all.iter().map(|(full, ..)| full.as_str()).collect::<Vec<_>>().join(", ")
        ),
    }
}
