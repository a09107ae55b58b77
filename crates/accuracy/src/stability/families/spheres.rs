//! Spheres of any size in fields of any frequency: their induced dipole and higher orders.

use super::prelude::*;
use trackwright_metal::material::{Material, VACUUM_PERMEABILITY_H_PER_M};
use trackwright_metal::sphere::SphereResponse;

const SLOPE: &str = "relative change of the part by one of the squared argument, and one";

const REAL: Quantity = Quantity::new("real part of the factor", 30.0, SLOPE, "itself");

const IMAGINARY: Quantity = Quantity::new("imaginary part of the factor", 30.0, SLOPE, "itself");

const ORDERS: Quantity = Quantity::new("real part of higher orders", 30.0, SLOPE, "itself");

/// Orders above the dipole's that are compared.
const HIGHER: [usize; 3] = [2, 7, 40];

/// Largest argument whose higher orders are compared: their recurrence begins beyond it.
const MOST_ARGUMENT: f64 = 500.0;

const MATERIALS: [&str; 5] = ["copper", "steel-304", "steel-416", "titanium", "ferrite"];

pub(super) fn family(extent: Extent) -> Family {
    let radii_mm = extent.of(vec![0.1, 1.0, 10.0, 100.0, 500.0], vec![0.1, 20.0, 500.0]);
    let decades = extent.of(&[0, 1, 2, 3, 4, 5, 6][..], &[0, 3, 6]);
    let spheres = MATERIALS.into_iter().flat_map(|key| {
        let radii_mm = radii_mm.iter();
        radii_mm.map(move |&mm| (format!("{key}, {mm} mm, 1 Hz to 1 MHz"), (key, mm)))
    });
    Family::new(
        "spheres",
        "Induced dipole and higher orders of spheres of five materials, against the \
            cotangent's formula and Miller's algorithm in 192 bits. Small spheres of metal that is \
            not magnetic have a real part of a square's square, which the formula as it is written \
            does not have; large ones a cotangent beyond the range of f64.",
        &[REAL, IMAGINARY, ORDERS],
    )
    .with(spheres, move |methods, &(key, radius_mm)| {
        let material = Material::named(key).ok_or("is a material")?;
        let mut rows = Vec::new();
        for &decade in decades {
            rows.extend(at_frequency(methods, radius_mm, &material, 10.0_f64.powi(decade))?);
        }
        Ok(rows)
    })
}

fn at_frequency(
    methods: &Methods,
    radius_mm: f64,
    material: &Material,
    frequency_hz: f64,
) -> Found {
    let found =
        (methods.sphere_factor)(radius_mm, material, frequency_hz).map_err(|_| "has a factor")?;
    let mu = material.relative_permeability();
    let squared = squared_size(radius_mm, material, frequency_hz);
    // A change of the argument that is far above the reference's round-off.
    let step = 1e-12;
    let [there, beside] = [0.0, step].map(|step| factor(&(&squared * (High::one() + step)), mu));
    let row = |q: &Quantity, found: f64, there: &High, beside: &High| {
        let size = there.abs();
        let condition = ((beside - there).abs() / &size).to_f64() / step + 1.0;
        q.row(condition, (High::from(found) - there).abs().to_f64(), size.to_f64())
    };
    let mut rows = vec![
        row(&REAL, found.re, &there[0], &beside[0]),
        row(&IMAGINARY, found.im, &there[1], &beside[1]),
    ];
    if squared.to_f64().sqrt() < MOST_ARGUMENT {
        let response =
            SphereResponse::new(radius_mm, material, frequency_hz).map_err(|_| "has orders")?;
        let [there, beside] =
            [0.0, step].map(|step| orders(&(&squared * (High::one() + step)), mu));
        for ((order, there), beside) in HIGHER.into_iter().zip(&there).zip(&beside) {
            rows.push(row(&ORDERS, response.ratio(order), there, beside));
        }
    }
    Ok(rows)
}

/// Real and imaginary part.
type HighComplex = [High; 2];

fn times(a: &HighComplex, b: &HighComplex) -> HighComplex {
    [&a[0] * &b[0] - &a[1] * &b[1], &a[0] * &b[1] + &a[1] * &b[0]]
}

fn over(a: &HighComplex, b: &HighComplex) -> HighComplex {
    let square = &b[0] * &b[0] + &b[1] * &b[1];
    let product = times(a, &[b[0].clone(), -&b[1]]);
    product.map(|part| part / &square)
}

fn plus(a: &HighComplex, re: f64) -> HighComplex {
    [&a[0] + re, a[1].clone()]
}

/// `2 (a/δ)²`: the argument `x = (1 + i) a/δ` squared is `i` times that.
fn squared_size(radius_mm: f64, material: &Material, frequency_hz: f64) -> High {
    let radius = High::from(radius_mm);
    let per_m2 = High::pi()
        * frequency_hz
        * VACUUM_PERMEABILITY_H_PER_M
        * material.relative_permeability()
        * material.conductivity_s_per_m();
    per_m2 * &radius * &radius * 2.0 / 1e6
}

/// `(2μ − u) / (2 (μ + u))`, `u = x² / (1 − x cot x) − 1`.
fn factor(squared: &High, mu: f64) -> HighComplex {
    let s = (squared / 2.0).sqrt();
    let twice = &s * 2.0;
    let (up, down) = (twice.exp(), (-&twice).exp());
    let (cosh, sinh) = ((&up + &down) / 2.0, (&up - &down) / 2.0);
    let below = cosh - twice.cos();
    let cot = [twice.sin() / &below, -(sinh / &below)];
    let x_cot_x = times(&[s.clone(), s], &cot);
    let one_less = plus(&x_cot_x.map(|part| -part), 1.0);
    let u = plus(&over(&[High::zero(), squared.clone()], &one_less), -1.0);
    let above = plus(&u.clone().map(|part| -part), 2.0 * mu);
    over(&above, &plus(&u, mu).map(|part| part * 2.0))
}

/// Real parts of `g_n = −n ((n + 1)(μ − 1) + h_n) / ((n + 1)(n + 1 + nμ − h_n))`, with `h_n = x²/(2n + 3 −
/// h_{n+1})` from far above.
fn orders(squared: &High, mu: f64) -> [High; HIGHER.len()] {
    let first = HIGHER[2] + 2 * squared.to_f64().sqrt() as usize + 120;
    let x2 = [High::zero(), squared.clone()];
    let mut h = [High::zero(), High::zero()];
    let mut found = [const { None }; HIGHER.len()];
    for n in (HIGHER[0]..=first).rev() {
        let below = plus(&h.clone().map(|part| -part), (2 * n + 3) as f64);
        h = over(&x2, &below);
        if let Some(k) = HIGHER.iter().position(|order| *order == n) {
            let order = High::from(n as f64);
            let excess = (&order + 1.0) * (High::from(mu) - 1.0);
            let above = [(&h[0] + &excess) * -(n as f64), &h[1] * -(n as f64)];
            let sum = &order + 1.0 + &order * mu - &h[0];
            let below = [sum * (&order + 1.0), -(&h[1] * (&order + 1.0))];
            found[k] = Some(over(&above, &below)[0].clone());
        }
    }
    found.map(|value| value.unwrap_or_else(High::zero))
}
