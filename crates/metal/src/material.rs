//! Materials of metal bodies: conductivity, relative permeability, and the skin depth they give.

use std::f64::consts::PI;

/// Permeability of vacuum in H/m. CODATA 2018 differs from 4π·10⁻⁷ by 5·10⁻¹⁰ of it, far below what
/// is known of any material.
pub const VACUUM_PERMEABILITY_H_PER_M: f64 = 4e-7 * PI;

/// Largest conductivity: ten times that of the purest copper at room temperature.
pub const MAX_CONDUCTIVITY_S_PER_M: f64 = 1e9;

/// Largest relative permeability: that of the softest nickel alloys and amorphous ribbons.
pub const MAX_RELATIVE_PERMEABILITY: f64 = 1e6;

/// Highest frequency. Above it the field is not quasi-static in a room of some metres.
pub const MAX_FREQUENCY_HZ: f64 = 1e7;

/// Conductivity and relative permeability of a linear, homogeneous and isotropic material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    conductivity_s_per_m: f64,
    relative_permeability: f64,
}

/// Why two numbers are no material, or a number no frequency.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MaterialError {
    #[error("conductivity is {0} S/m, expected 0 to {MAX_CONDUCTIVITY_S_PER_M:e}")]
    Conductivity(f64),
    #[error("relative permeability is {0}, expected 1 to {MAX_RELATIVE_PERMEABILITY:e}")]
    RelativePermeability(f64),
    #[error("frequency is {0} Hz, expected 0 to {MAX_FREQUENCY_HZ:e}")]
    Frequency(f64),
}

/// A material with a name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NamedMaterial {
    /// What files write.
    pub key: &'static str,
    /// What people read.
    pub label: &'static str,
    pub material: Material,
    /// Where its numbers come from.
    pub source: &'static str,
}

const fn material(conductivity_s_per_m: f64, relative_permeability: f64) -> Material {
    Material { conductivity_s_per_m, relative_permeability }
}

/// The materials that have a name, at 20 °C.
///
/// Conductivities of alloys vary by some 5 % between melts. Permeabilities of ferromagnetic steels
/// vary by a factor of several with heat treatment and field strength; those of austenitic steels
/// rise above the annealed value with cold work.
pub const NAMED_MATERIALS: [NamedMaterial; 9] = [
    NamedMaterial {
        key: "aluminium",
        label: "Aluminium",
        material: material(1.0 / 2.650e-8, 1.0),
        source: "pure, 2.650e-8 Ω m at 20 °C: CRC Handbook of Chemistry and Physics, Electrical \
                 Resistivity of Pure Metals; alloys have 50 to 95 % of its conductivity",
    },
    NamedMaterial {
        key: "copper",
        label: "Copper",
        material: material(5.8e7, 1.0),
        source: "annealed copper standard, 100 % IACS, 5.8e7 S/m at 20 °C: IEC 60028",
    },
    NamedMaterial {
        key: "titanium",
        label: "Titanium Ti-6Al-4V",
        material: material(1.0 / 1.78e-6, 1.000_05),
        source: "1.78e-6 Ω m, permeability 1.00005, annealed: ASM Aerospace Specification Metals",
    },
    NamedMaterial {
        key: "steel-303",
        label: "Stainless steel 303",
        material: material(1.0 / 7.2e-7, 1.008),
        source: "7.2e-7 Ω m at 20 °C, permeability 1.008, annealed bar: MatWeb, AISI Type 303",
    },
    NamedMaterial {
        key: "steel-304",
        label: "Stainless steel 304",
        material: material(1.0 / 7.2e-7, 1.008),
        source: "7.2e-7 Ω m at 20 °C, permeability 1.008, annealed: MatWeb, AISI Type 304",
    },
    NamedMaterial {
        key: "steel-316",
        label: "Stainless steel 316",
        material: material(1.0 / 7.4e-7, 1.008),
        source: "7.4e-7 Ω m at 20 °C, permeability 1.008, annealed: MatWeb, AISI Type 316",
    },
    NamedMaterial {
        key: "steel-416",
        label: "Stainless steel 416",
        material: material(1.0 / 5.7e-7, 700.0),
        source: "5.7e-7 Ω m; maximum permeability 700 to 1000, the lower end here, as trackers' \
                 fields are weak: ASM Aerospace Specification Metals, AISI Type 416",
    },
    NamedMaterial {
        key: "bronze",
        label: "Phosphor bronze",
        material: material(0.15 * 5.8e7, 1.0),
        source: "C51000, 15 % IACS at 20 °C: Copper Development Association",
    },
    NamedMaterial {
        key: "ferrite",
        label: "Ferrite MnZn",
        material: material(0.1, 2200.0),
        source: "N87, initial permeability 2200 and 10 Ω m at 25 °C: TDK, SIFERRIT material N87",
    },
];

impl Material {
    /// A material of one's own; conductivity 0 for one without eddy currents, permeability 1 for one
    /// that is not magnetic.
    ///
    /// # Errors
    /// A [`MaterialError`] with the number that is out of range or not finite.
    pub fn new(
        conductivity_s_per_m: f64,
        relative_permeability: f64,
    ) -> Result<Self, MaterialError> {
        if !(0.0..=MAX_CONDUCTIVITY_S_PER_M).contains(&conductivity_s_per_m) {
            return Err(MaterialError::Conductivity(conductivity_s_per_m));
        }
        if !(1.0..=MAX_RELATIVE_PERMEABILITY).contains(&relative_permeability) {
            return Err(MaterialError::RelativePermeability(relative_permeability));
        }
        Ok(Self { conductivity_s_per_m, relative_permeability })
    }

    /// A material of [`NAMED_MATERIALS`] by its key; `None` where none has it.
    pub fn named(key: &str) -> Option<Self> {
        NAMED_MATERIALS.iter().find(|named| named.key == key).map(|named| named.material)
    }

    pub fn conductivity_s_per_m(&self) -> f64 {
        self.conductivity_s_per_m
    }

    pub fn relative_permeability(&self) -> f64 {
        self.relative_permeability
    }

    /// Whether its permeability counts: what is below 1.05 hardly has a part in any response.
    pub fn is_magnetic(&self) -> bool {
        self.relative_permeability > 1.05
    }

    /// Whether currents flow in it.
    /// Whether currents flow in it.
    pub fn is_conductor(&self) -> bool {
        self.conductivity_s_per_m > 0.0
    }

    /// `1/δ² = π f μ₀ μ σ` in mm⁻²; 0 at rest and where no currents flow.
    pub fn inverse_squared_skin_depth_per_mm2(&self, frequency_hz: f64) -> f64 {
        PI * frequency_hz
            * VACUUM_PERMEABILITY_H_PER_M
            * self.relative_permeability
            * self.conductivity_s_per_m
            * 1e-6
    }

    /// Depth at which the field of an even surface has fallen to 1/e, `δ = 1/√(π f μ₀ μ σ)`, in mm;
    /// infinite at rest and where no currents flow.
    pub fn skin_depth_mm(&self, frequency_hz: f64) -> f64 {
        1.0 / self.inverse_squared_skin_depth_per_mm2(frequency_hz).sqrt()
    }
}

/// Checks a frequency: finite, zero or more, and quasi-static.
///
/// # Errors
/// [`MaterialError::Frequency`] with the number.
pub fn check_frequency(frequency_hz: f64) -> Result<(), MaterialError> {
    match (0.0..=MAX_FREQUENCY_HZ).contains(&frequency_hz) {
        true => Ok(()),
        false => Err(MaterialError::Frequency(frequency_hz)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skin_depths_are_the_textbooks() {
        // Copper at 50 Hz: 9.35 mm; titanium alloy and 316 at 10 kHz.
        for (key, frequency_hz, depth_mm) in [
            ("copper", 50.0, 9.346),
            ("copper", 1e6, 0.066_09),
            ("aluminium", 1e3, 2.591),
            ("steel-316", 1e4, 4.312),
        ] {
            let found = Material::named(key).unwrap().skin_depth_mm(frequency_hz);
            assert!((found / depth_mm - 1.0).abs() < 1e-3, "{key} {found}");
        }
    }

    #[test]
    fn no_current_has_no_skin_depth() {
        assert!(Material::named("copper").unwrap().skin_depth_mm(0.0).is_infinite());
        let insulator = Material::new(0.0, 100.0).unwrap();
        assert!(insulator.skin_depth_mm(1e4).is_infinite() && !insulator.is_conductor());
    }

    #[test]
    fn named_materials_are_valid_and_differ() {
        for (index, named) in NAMED_MATERIALS.iter().enumerate() {
            let Material { conductivity_s_per_m, relative_permeability } = named.material;
            let again = Material::new(conductivity_s_per_m, relative_permeability);
            assert_eq!(again, Ok(named.material));
            assert_eq!(Material::named(named.key), Some(named.material));
            assert!(NAMED_MATERIALS[..index].iter().all(|other| other.key != named.key));
        }
        assert_eq!(Material::named("cheese"), None);
    }

    #[test]
    fn numbers_out_of_range_are_refused() {
        for (conductivity, permeability, message) in [
            (-1.0, 1.0, "conductivity is -1 S/m, expected 0 to 1e9"),
            (f64::NAN, 1.0, "conductivity is NaN S/m, expected 0 to 1e9"),
            (f64::INFINITY, 1.0, "conductivity is inf S/m, expected 0 to 1e9"),
            (1e6, 0.5, "relative permeability is 0.5, expected 1 to 1e6"),
            (1e6, f64::NAN, "relative permeability is NaN, expected 1 to 1e6"),
        ] {
            let error = Material::new(conductivity, permeability).unwrap_err();
            assert_eq!(error.to_string(), message);
        }
        assert_eq!(check_frequency(0.0), Ok(()));
        for frequency in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(check_frequency(frequency).is_err());
        }
    }
}
