//! `metal distance`: from how far away a metal object lets a design meet its requirement.

use crate::cli::numbers::three;
use crate::cli::prelude::*;
use crate::cli::simulate::note_world;
use nalgebra::{Unit, Vector3};
use trackwright_metal::furnished::Furnisher;
use trackwright_metal::setup::RoomMetal;
use trackwright_report::{metal_chart, metal_distance};
use trackwright_result::Section;
use trackwright_simulation::Mode;
use trackwright_simulation::metal_distance::{MetalDistanceSearch, metal_distances};

#[derive(Debug, Args)]
pub struct DistanceArgs {
    /// Design (*.design.ron), or the name of a built-in one, in a room with metal
    design: PathBuf,

    /// The object that is moved, by its name; the only one where left out
    #[arg(long, value_name = "NAME")]
    object: Option<String>,

    /// Direction that it is moved in, tracker frame; away from the tool's tip where left out
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = direction)]
    direction: Option<Unit<Vector3<f64>>>,

    /// How far it is moved at most, mm
    #[arg(long, value_name = "MM", default_value_t = 500.0, allow_hyphen_values = true)]
    farthest: f64,

    /// Chart to write, error against distance
    #[arg(long, value_name = "OUT.svg")]
    chart: Option<PathBuf>,

    /// How to print the distances
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

fn direction(text: &str) -> Result<Unit<Vector3<f64>>, String> {
    trackwright_geometry::number::direction(three(text)?)
        .ok_or_else(|| "expected three numbers that are not all zero, as in 0,-1,0".to_owned())
}

/// Studies the design with the object at other places and prints the figures there.
///
/// # Errors
/// Files that can't be used, a room without metal, no object of the name.
pub fn run(args: &DistanceArgs, files: &Files) -> anyhow::Result<()> {
    let chart = files.optional_output(args.chart.as_deref())?;
    let world = files.open_design_without_meshes(&args.design)?;
    let design = world.document.design();
    let named = || args.design.display().to_string();
    let metal = design.room_metal.as_deref().with_context(|| {
        format!("{}: found a room without metal, expected an object to move", named())
    })?;
    let object = object_index(metal, args.object.as_deref()).with_context(named)?;
    note_world(&world);
    let scenario = trackwright_project::resolve(design, &world.environment);
    let mode = if scenario.motion.is_some() { Mode::Motion } else { Mode::Single };
    let search = MetalDistanceSearch {
        scenario: &scenario,
        bare: world.bare_environment(),
        metal,
        object,
        direction: args.direction,
        farthest_mm: args.farthest,
        mode: &mode,
    };
    let shown = Shown::new("moving the object");
    let found = metal_distances(&search, &mut Furnisher::default(), &shown.task);
    drop(shown);
    let found = found.with_context(named)?;
    let name = metal.objects[object].name.as_str();
    if let Some(chart) = &chart {
        let svg = metal_chart::chart(&design.name, name, &scenario, &found).to_svg((900, 560));
        chart.write_bytes(svg.as_bytes())?;
    }
    let found = Section::default()
        .with(output::head(&design.name, &world.environment.name))
        .with_all(metal_distance::section(name, &scenario, &found).items);
    output::print_section(args.format, &found)
}

/// The index of an object by its name; of the only one without.
pub fn object_index(metal: &RoomMetal, name: Option<&str>) -> anyhow::Result<usize> {
    let names: Vec<&str> = metal.objects.iter().map(|object| object.name.as_str()).collect();
    match (name, &names[..]) {
        (None, [_]) => Ok(0),
        (None, _) => bail!("expected --object, one of {}", names.join(", ")),
        (Some(name), names) => {
            let index = names.iter().position(|own| *own == name);
            index.with_context(|| {
                format!("found no metal object {name:?}, expected one of {}", names.join(", "))
            })
        }
    }
}
