//! Makes the built-in 3D meshes: `cargo run --example make-meshes -- [folder]`.
//!
//! Lengths are millimetres until `glb` writes metres. A tool's tip is at the origin and its +z runs
//! back along the shaft; the reference frame, the field generator, the table and the C-arm have theirs
//! in their files. What may be metal in a room is one closed surface, whose parts are only painted.

mod c_arm;
#[cfg(test)]
mod checks;
mod endoscope;
mod field_generator;
mod forceps;
mod glb;
mod head;
mod implicit;
mod mallet;
mod model;
mod operating_table;
mod pod;
mod pointer;
mod profile;
mod reference_frame;
mod retractor;
mod shape;
mod shaver;
mod sweep;
mod vector;
mod windowed_tube;

use std::io::Write;
use std::path::PathBuf;
use std::{env, fs, io};

use model::Model;

/// Where the meshes belong when no folder is named, seen from the repository's root.
const DEFAULT_FOLDER: &str = "assets/meshes";

fn main() -> io::Result<()> {
    let folder = env::args_os().nth(1).map_or_else(|| PathBuf::from(DEFAULT_FOLDER), PathBuf::from);
    fs::create_dir_all(&folder)?;
    for model in models() {
        let path = folder.join(format!("{}.glb", model.name));
        let bytes = glb::to_bytes(&model);
        fs::write(&path, &bytes)?;
        let triangles: usize = model.parts.iter().map(|part| part.shape.triangles.len()).sum();
        writeln!(io::stdout(), "{}: {triangles} triangles, {} bytes", path.display(), bytes.len())?;
    }
    Ok(())
}

fn models() -> [Model; 10] {
    [
        pointer::pointer(),
        endoscope::endoscope(),
        shaver::shaver(),
        reference_frame::head_crf(),
        field_generator::field_generator(),
        operating_table::operating_table(),
        c_arm::c_arm(),
        retractor::retractor(),
        forceps::forceps(),
        mallet::mallet(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn making_everything_twice_gives_the_same_bytes() {
        let bytes = || models().map(|model| glb::to_bytes(&model));
        assert!(bytes() == bytes());
    }

    // Sines of other systems may differ in their last digit.
    #[cfg(target_os = "linux")]
    #[test]
    fn every_file_is_what_the_program_makes() {
        for model in models() {
            let file = format!("{DEFAULT_FOLDER}/{}.glb", model.name);
            assert!(fs::read(&file).unwrap() == glb::to_bytes(&model), "{file} is another");
        }
    }
}
