//! Field generators, `*.generator.ron`: the coils of a tracker.

use super::error::FormatError;
use super::ron_text::{self, RonWriter, Version};
use serde::Deserialize;
use trackwright_field::generator::{Coil, Generator, GeneratorError};

#[derive(Deserialize)]
#[serde(rename = "Generator", deny_unknown_fields)]
struct GeneratorFile {
    #[serde(rename = "version")]
    _version: Version,
    name: String,
    coils: Vec<CoilEntry>,
}

/// A generator in a file of another kind, which has a version of its own.
#[derive(Deserialize)]
#[serde(rename = "Generator", deny_unknown_fields)]
pub(super) struct GeneratorEntry {
    name: String,
    coils: Vec<CoilEntry>,
}

#[derive(Deserialize)]
#[serde(rename = "Coil", deny_unknown_fields)]
enum CoilEntry {
    Dipole { position: [f64; 3], moment: [f64; 3] },
    SquareLoop { center: [f64; 3], normal: [f64; 3], side: f64 },
}

/// Reads a generator. Normals are normalised, moments kept: they are relative strengths.
///
/// # Errors
/// Anything that leaves a doubt about what the coils are; see [`FormatError`].
pub fn parse(bytes: &[u8]) -> Result<Generator, FormatError> {
    let GeneratorFile { name, coils, .. } = ron_text::parse(bytes)?;
    GeneratorEntry { name, coils }.check()
}

impl GeneratorEntry {
    pub(super) fn check(self) -> Result<Generator, FormatError> {
        let coils = self.coils.into_iter().enumerate();
        let coils = coils.map(|(index, coil)| coil.check(index));
        let generator = Generator { name: self.name, coils: coils.collect::<Result<_, _>>()? };
        match generator.problem() {
            None => Ok(generator),
            Some(GeneratorError::Coils(count)) => {
                Err(FormatError::field("coils", count, "5 to 32 coils"))
            }
            Some(GeneratorError::Coil { coil, field, found, expected }) => {
                let field = format!("coils[{coil}]: {field}");
                Err(FormatError::field(field, found, expected))
            }
        }
    }
}

impl CoilEntry {
    fn check(self, index: usize) -> Result<Coil, FormatError> {
        Ok(match self {
            Self::Dipole { position, moment } => {
                Coil::Dipole { at_mm: position.into(), moment: moment.into() }
            }
            Self::SquareLoop { center, normal, side } => Coil::SquareLoop {
                center_mm: center.into(),
                normal: ron_text::axis(&format!("coils[{index}]: normal"), normal)?,
                side_mm: side,
            },
        })
    }
}

/// Writes a generator, one coil a line.
pub fn write(generator: &Generator) -> String {
    RonWriter::file(|out| write_parts(out, generator))
}

/// Name and coils as fields of a file.
pub(super) fn write_parts(out: &mut RonWriter, generator: &Generator) {
    out.string("name", &generator.name);
    let line = |coil: &Coil| match coil {
        Coil::Dipole { at_mm, moment } => {
            let position = ron_text::tuple(at_mm.coords.as_slice());
            format!("Dipole(position: {position}, moment: {})", ron_text::tuple(moment.as_slice()))
        }
        Coil::SquareLoop { center_mm, normal, side_mm: side } => {
            let center = ron_text::tuple(center_mm.coords.as_slice());
            let normal = ron_text::tuple(normal.as_slice());
            format!("SquareLoop(center: {center}, normal: {normal}, side: {side:?})")
        }
    };
    out.lines("coils", generator.coils.iter().map(line));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_cases::assert_refused;
    use trackwright_field::generator::MAX_COILS;

    const EXAMPLE: &str = r#"(
    version: 1,
    name: "Planar",
    coils: [
        Dipole(position: (-120.0, -120.0, 0.0), moment: (0.64, 0.53, 0.57)),
        Dipole(position: (-120, 0, 0), moment: (0, 0, 2)),
        Dipole(position: (120.0, -120.0, 0.0), moment: (1.0, 0.0, 0.0)),
        Dipole(position: (120.0, 120.0, 0.0), moment: (0.0, 1.0, 0.0)),
        SquareLoop(center: (0.0, 68.55, 0.0), normal: (0.0, 0.0, 3.0), side: 70.0), // Anser's
    ],
)
"#;

    fn error(text: &str) -> String {
        parse(text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn the_example_of_the_contract_is_read() {
        let generator = parse(EXAMPLE.as_bytes()).unwrap();
        assert_eq!(generator.name, "Planar");
        assert_eq!(generator.coils.len(), 5);
        let Coil::Dipole { moment, .. } = generator.coils[1] else {
            panic!("{:?}", generator.coils[1])
        };
        assert_eq!(moment.z, 2.0);
        let Coil::SquareLoop { normal, side_mm, .. } = generator.coils[4] else {
            panic!("{:?}", generator.coils[4])
        };
        assert_eq!((normal.z, side_mm), (1.0, 70.0));
    }

    #[test]
    fn what_is_written_reads_back_to_the_bit() {
        let mut generators =
            vec![Generator::planar_nine(), Generator::anser(), parse(EXAMPLE.as_bytes()).unwrap()];
        generators[0].name = "a \"name\" \\ \n\u{1}".to_owned();
        if let Coil::Dipole { at_mm, moment } = &mut generators[0].coils[2] {
            *at_mm = [1.0 / 3.0, 1e-300, -1e6].into();
            *moment = [0.1 + 0.2, -0.0, 1e9].into();
        }
        for generator in generators {
            let text = write(&generator);
            let back = parse(text.as_bytes()).unwrap();
            assert_eq!(back, generator);
            assert_eq!(write(&back), text);
        }
    }

    #[test]
    fn every_wrong_field_is_named() {
        let cases = r#"
            (-120, 0, 0) => (NaN, 0, 0)
                | coils[1]: position is (NaN, 0, 0), expected finite numbers
            (0, 0, 2) => (0, 0, 0)
                | coils[1]: moment is (0, 0, 0), expected a finite vector above zero
            (0, 0, 2) => (0, inf, 2)
                | coils[1]: moment is (0, inf, 2), expected a finite vector above zero
            (0.0, 0.0, 3.0) => (0, 0, 0)
                | coils[4]: normal is (0, 0, 0), expected a direction
            side: 70.0 => side: -70 | coils[4]: side is -70, expected a length above zero
            side: 70.0 => side: NaN | coils[4]: side is NaN, expected a length above zero
            center: (0.0, 68.55, 0.0) => center: (0.0, -inf, 0.0)
                | coils[4]: center is (0, -inf, 0), expected finite numbers
            Dipole(position: (-120, 0, 0), moment: (0, 0, 2)),\n =>
                | coils is 4, expected 5 to 32 coils
            (version: 1, name: "", coils: []) | coils is 0, expected 5 to 32 coils
            version: 1, => version: 1, maker: Some((year: 2026)),
                | line 2, column 17: found the unknown field `maker`, expected `version` or `name`
                | or `coils`
        "#;
        assert_refused(EXAMPLE, cases, error);
        let one = "Dipole(position: (0, 0, 0), moment: (0, 0, 1)),";
        let many = format!("coils: [{}", one.repeat(MAX_COILS));
        assert_eq!(
            error(&EXAMPLE.replace("coils: [", &many)),
            "coils is 37, expected 5 to 32 coils"
        );
    }

    #[test]
    fn broken_syntax_is_found_at_its_line() {
        let cases = r#"
            Dipole( => Triangle( | line 5, column 9: found `Triangle`, expected `Dipole` or `SquareLoop`
            side: 70.0 => side: "70" | line 9, column …
            , side: 70.0 => | line 9, column …
            , side: 70.0 => | …found no field `side`, expected it
            moment: (0, 0, 2) => moment: (0, 2) | line 6, column …
            name: "Planar", => name: "Planar" | line 4, column …
            name: "Planar",\n => | line 10, column 1: found no field `name`, expected it
        "#;
        assert_refused(EXAMPLE, cases, error);
        for end in [1, 10, EXAMPLE.len() / 2, EXAMPLE.len() - 3] {
            assert!(parse(&EXAMPLE.as_bytes()[..end]).is_err());
        }
        assert!(error("").contains("end of the file"));
        let message = parse(b"(\n  \xff").unwrap_err().to_string();
        assert!(message.starts_with("line 2, column 3"), "{message}");
    }
}
