//! Chi-square tests: samples follow the density that `pdf` reports. Counts of samples are compared
//! with integrals of the density (Pharr et al., *Physically Based Rendering*, 4th ed., chapter 2;
//! Mitsuba's chi-square tests).
//!
//! `cargo test --lib proof -- --nocapture` prints a table. The environment variable
//! `PTFAST_PROOF_SEED` sets another seed.
#![allow(clippy::disallowed_methods)] // The f64 functions of libm are the reference.

mod bsdf;
mod camera;
mod filter;
mod light;
mod medium;

use glam::Vec3;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::f64::consts::{PI, TAU};

use crate::math::{Frame, PixelKey, normalize};
use crate::sampler::{Randoms, Sampler};

/// The probability of a false alarm in a test, over all its comparisons.
const ALARM: f64 = 1e-4;
/// Number of samples of each comparison.
const SAMPLES: u32 = 200_000;

fn seed() -> u64 {
    std::env::var("PTFAST_PROOF_SEED")
        .map_or(1, |seed| seed.parse().expect("PTFAST_PROOF_SEED must be an integer, 0 or more"))
}

/// The random numbers of sample number `sample` of comparison `case`.
fn randoms(case: usize, sample: u32) -> Randoms {
    let key = PixelKey::new(seed(), case as u32, 0).sample(sample);
    Randoms::new(Sampler::Independent, key, 1)
}

/// Divides the directions within a cone into cells: rings of equal angular width, and sectors.
struct Cone {
    frame: Frame,
    /// Angle from the axis to the rim; π for all directions.
    angle: f64,
}

impl Cone {
    const RINGS: usize = 16;
    const SECTORS: usize = 32;

    /// Creates a cone that contains the cone of `angle` around `middle`. Its axis is tilted
    /// from `middle`. Otherwise, if a density ended at a circle around `middle`, that circle would
    /// everywhere pass between the same two rings of integration points.
    fn new(middle: Vec3, angle: f64) -> Self {
        let aside = 0.15 * angle.min(1.0) as f32;
        let aside = Frame::new(middle).world(Vec3::new(aside, 0.3 * aside, 1.0));
        Self { frame: Frame::new(normalize(aside)), angle: (1.2 * angle).min(PI) }
    }

    fn all(middle: Vec3) -> Self {
        Self::new(middle, PI)
    }

    /// Returns the cell of a direction; `None` outside the cone.
    fn cell(&self, direction: Vec3) -> Option<usize> {
        let [x, y, z] = self.frame.local(direction).to_array().map(f64::from);
        let u = (x * x + y * y).sqrt().atan2(z) / self.angle;
        let v = (y.atan2(x) / TAU).rem_euclid(1.0);
        let ring = (u * Self::RINGS as f64) as usize;
        let sector = (v * Self::SECTORS as f64) as usize % Self::SECTORS;
        let ring = if self.angle >= PI { ring.min(Self::RINGS - 1) } else { ring };
        (ring < Self::RINGS).then_some(ring * Self::SECTORS + sector)
    }

    /// Integrates `f` over the solid angle of each cell. Also returns the possible error of the
    /// sum.
    fn integrate(&self, f: impl Fn(Vec3) -> f64) -> (Vec<f64>, f64) {
        let (mut cells, mut off) = (Vec::new(), 0.0);
        for ring in 0..Self::RINGS {
            for sector in 0..Self::SECTORS {
                let low = [ring as f64 / Self::RINGS as f64, sector as f64 / Self::SECTORS as f64];
                let size = [1.0 / Self::RINGS as f64, 1.0 / Self::SECTORS as f64];
                let once = self.midpoints(&f, low, size);
                cells.push(self.refined(&f, low, size, once, 0, &mut off));
            }
        }
        // Allow for edges of `f` that pass unnoticed between the integration points, and for
        // rounding errors.
        (cells, off + 5e-4)
    }

    /// Integrates over a part of a cell, which is halved in both directions until the result is
    /// stable.
    fn refined(
        &self,
        f: &impl Fn(Vec3) -> f64,
        low: [f64; 2],
        size: [f64; 2],
        once: f64,
        depth: u32,
        off: &mut f64,
    ) -> f64 {
        let half = size.map(|size| 0.5 * size);
        let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]]
            .map(|[i, j]| [low[0] + i * half[0], low[1] + j * half[1]]);
        let quarters = corners.map(|low| self.midpoints(f, low, half));
        let twice = quarters.iter().sum::<f64>();
        let change = (twice - once).abs();
        if depth == 8 || (depth > 2 && change < 1e-7) {
            // The error of the midpoint rule is a third of the change that the halving made. Edges
            // of `f` reach the depth limit and count in full, smooth parts only with a tenth.
            *off += 0.33 * change * if depth == 8 { 1.0 } else { 0.1 };
            return twice;
        }
        let part = |(low, once)| self.refined(f, low, half, once, depth + 1, off);
        corners.into_iter().zip(quarters).map(part).sum()
    }

    /// Integrates over a part of a cell by the midpoint rule with 3 × 3 points.
    fn midpoints(&self, f: &impl Fn(Vec3) -> f64, low: [f64; 2], size: [f64; 2]) -> f64 {
        let mut sum = 0.0;
        for (i, j) in (0..9).map(|k| (f64::from(k / 3), f64::from(k % 3))) {
            let (u, v) = (low[0] + size[0] * (i + 0.5) / 3.0, low[1] + size[1] * (j + 0.5) / 3.0);
            let ((radius, z), (sin, cos)) = ((u * self.angle).sin_cos(), (v * TAU).sin_cos());
            let local = [radius * cos, radius * sin, z].map(|x| x as f32);
            sum += radius * f(self.frame.world(Vec3::from_array(local)));
        }
        sum * self.angle * size[0] * TAU * size[1] / 9.0
    }
}

/// Returns the probability that chance makes counts differ from `expected` at least as much as
/// `counts` do, the chi-square statistic, and the degrees of freedom. Cells with low expected
/// counts are pooled. `counts` and `expected` must have the same sum, up to rounding errors.
fn p_value(counts: &[u32], expected: &[f64]) -> (f64, f64, usize) {
    const FEW: f64 = 10.0;
    let (mut statistic, mut cells) = (0.0, 0);
    let (mut rest_count, mut rest) = (0.0, 0.0);
    for (&count, &expected) in counts.iter().zip(expected) {
        if expected < FEW {
            (rest_count, rest) = (rest_count + f64::from(count), rest + expected);
        } else {
            statistic += (f64::from(count) - expected) * (f64::from(count) - expected) / expected;
            cells += 1;
        }
    }
    if rest >= FEW {
        statistic += (rest_count - rest) * (rest_count - rest) / rest;
        cells += 1;
    } else {
        // Too few samples are expected for a chi-square test, but a large excess is an error.
        assert!(
            rest_count < rest + 12.0 + 8.0 * rest.sqrt(),
            "{rest_count} samples in rare cells, expected {rest}"
        );
    }
    assert!(cells > 1, "the test needs at least 2 cells");
    let degrees = (cells - 1) as f64;
    let p = ChiSquared::new(degrees).expect("degrees of freedom above 0").sf(statistic);
    (p, statistic, cells - 1)
}

/// Prints the comparisons of a test as a table, and checks the lowest p-value.
struct Table {
    rows: usize,
    least: (f64, String),
}

impl Table {
    fn new(of: &str) -> Self {
        println!("\n{of:<34}{:>10}{:>8}{:>9}{:>10}{:>9}", "chi²", "degrees", "p", "∫pdf", "kept");
        Self { rows: 0, least: (1.0, String::new()) }
    }

    /// Compares samples of directions with their density. `sample` may return `None`. The integral
    /// of the density must equal the share of samples that are not `None`.
    fn directions(
        &mut self,
        name: &str,
        cone: &Cone,
        mut sample: impl FnMut(u32) -> Option<Vec3>,
        pdf: impl Fn(Vec3) -> f64,
    ) {
        let mut counts = vec![0; Cone::RINGS * Cone::SECTORS];
        let mut kept = 0;
        for index in 0..SAMPLES {
            let Some(direction) = sample(index) else { continue };
            kept += 1;
            let cell = cone.cell(direction);
            counts[cell.unwrap_or_else(|| panic!("{name}: {direction} is outside the cone"))] += 1;
        }
        let (integrals, off) = cone.integrate(pdf);
        let whole: f64 = integrals.iter().sum();
        let share = f64::from(kept) / f64::from(SAMPLES);
        let deviation = (share * (1.0 - share) / f64::from(SAMPLES)).sqrt();
        let bound = 5.0 * deviation + off;
        assert!(off < 3e-3, "{name}: the integral may be off by {off}, must be less than 3e-3");
        assert!(
            (whole - share).abs() < bound,
            "{name}: ∫pdf is {whole}, must be the share {share} of samples that are kept"
        );
        let expected: Vec<f64> = integrals.iter().map(|p| p / whole * f64::from(kept)).collect();
        self.compare(name, &counts, &expected, whole, share);
    }

    fn compare(&mut self, name: &str, counts: &[u32], expected: &[f64], whole: f64, kept: f64) {
        let (p, statistic, degrees) = p_value(counts, expected);
        println!("{name:<34}{statistic:>10.1}{degrees:>8}{p:>9.4}{whole:>10.5}{kept:>9.5}");
        self.rows += 1;
        if p < self.least.0 {
            self.least = (p, name.to_owned());
        }
    }

    /// Panics if the lowest p-value is too low to be due to chance (Šidák correction).
    fn check(self) {
        let bound = 1.0 - (1.0 - ALARM).powf(1.0 / self.rows as f64);
        let (p, name) = self.least;
        assert!(p > bound, "{name}: p = {p:e}, below {bound:e}");
    }
}

/// Wrong densities make the tests fail.
#[test]
fn wrong_densities_are_found() {
    let alarms = |f: &dyn Fn(&mut Table)| {
        let mut table = Table::new("wrong on purpose");
        f(&mut table);
        table.rows
    };
    let uniform = |index| {
        let (u, v) = randoms(99, index).two(crate::sampler::Dimension::SCATTER);
        Some(crate::math::warp::uniform_sphere(u, v))
    };
    let sphere = Cone::all(Vec3::Y);
    let density = 0.5 / TAU;
    assert_eq!(alarms(&|table| table.directions("right", &sphere, uniform, |_| density)), 1);
    let off = std::panic::catch_unwind(|| {
        Table::new("1%").directions("1%", &sphere, uniform, |_| 1.01 * density);
    });
    assert!(off.is_err(), "an integral of 1.01 must fail");
    let tilted = std::panic::catch_unwind(|| {
        let mut table = Table::new("tilted");
        let pdf = |d: Vec3| density * (1.0 + 0.1 * f64::from(d.x));
        table.directions("tilted", &Cone::all(Vec3::Y), uniform, pdf);
        table.check();
    });
    assert!(tilted.is_err(), "a density 10% higher on one side must fail");
}
