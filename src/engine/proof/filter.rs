//! Tests of pixel filters: weighted samples have the integrals of the filter.

use std::f64::consts::PI;

use crate::math::{Real, Stream};
use crate::shading::{FilterTable, PixelFilter};
use crate::simd::{Float, LANES};

type Function = Box<dyn Fn(f64) -> f64>;

/// Every kind of filter with its radius, and the filter in f64, up to a constant factor.
fn filters() -> Vec<(PixelFilter, f64, Function)> {
    let gauss = |radius: f64, sigma: f64| {
        let g = move |x: f64| (-0.5 * (x / sigma).powi(2)).exp();
        move |x: f64| g(x) - g(radius)
    };
    let mitchell = |radius: f64, b: f64, c: f64| {
        move |x: f64| match 2.0 * x.abs() / radius {
            x if x < 1.0 => {
                (12.0 - 9.0 * b - 6.0 * c) * x.powi(3)
                    + (-18.0 + 12.0 * b + 6.0 * c) * x.powi(2)
                    + (6.0 - 2.0 * b)
            }
            x => {
                (-b - 6.0 * c) * x.powi(3)
                    + (6.0 * b + 30.0 * c) * x.powi(2)
                    + (-12.0 * b - 48.0 * c) * x
                    + (8.0 * b + 24.0 * c)
            }
        }
    };
    let harris = |radius: f64| {
        let cos = move |k: f64, x: f64| (k * PI * x / radius).cos();
        move |x| 0.35875 + 0.48829 * cos(1.0, x) + 0.14128 * cos(2.0, x) + 0.01168 * cos(3.0, x)
    };
    let third = 1.0 / 3.0;
    vec![
        (PixelFilter::Triangle { radius: 1.0 }, 1.0, Box::new(|x: f64| 1.0 - x.abs())),
        (PixelFilter::Gaussian { radius: 1.5, sigma: 0.5 }, 1.5, Box::new(gauss(1.5, 0.5))),
        (PixelFilter::Gaussian { radius: 2.0, sigma: 0.5 }, 2.0, Box::new(gauss(2.0, 0.5))),
        (PixelFilter::Gaussian { radius: 0.5, sigma: 16.0 }, 0.5, Box::new(gauss(0.5, 16.0))),
        (
            PixelFilter::Mitchell { radius: 2.0, b: third as f32, c: third as f32 },
            2.0,
            Box::new(mitchell(2.0, third, third)),
        ),
        (
            PixelFilter::Mitchell { radius: 2.0, b: 0.0, c: 1.0 },
            2.0,
            Box::new(mitchell(2.0, 0.0, 1.0)),
        ),
        // The outer half of this filter is 0 everywhere.
        (
            PixelFilter::Mitchell { radius: 3.0, b: 0.0, c: 0.0 },
            3.0,
            Box::new(mitchell(3.0, 0.0, 0.0)),
        ),
        (PixelFilter::BlackmanHarris { radius: 1.5 }, 1.5, Box::new(harris(1.5))),
    ]
}

#[test]
fn weighted_samples_have_the_integrals_of_the_filter() {
    const COUNTED: usize = 64;
    const FINE: u32 = 1000;
    const DRAWN: u32 = 1 << 20;
    for (filter, radius, f) in filters() {
        let table = FilterTable::new(&filter).expect("it is not the box");
        let mut drawn = [0.0; COUNTED];
        for i in 0..DRAWN {
            let (x, weight) = table.sample((i as f32 + 0.5) / DRAWN as f32);
            let cell = (f64::from(x) - 0.5 + radius) / (2.0 * radius) * COUNTED as f64;
            assert!((-1e-4..=COUNTED as f64 + 1e-4).contains(&cell), "{filter:?}: {x}");
            drawn[(cell as usize).min(COUNTED - 1)] += f64::from(weight) / f64::from(DRAWN);
            assert!(weight == 1.0 || matches!(filter, PixelFilter::Mitchell { .. }), "{filter:?}");
        }
        let integral = |cell: usize| -> f64 {
            let at = |k| (cell as f64 + (f64::from(k) + 0.5) / f64::from(FINE)) / COUNTED as f64;
            (0..FINE).map(|k| f(radius * (2.0 * at(k) - 1.0))).sum()
        };
        let wanted: Vec<f64> = (0..COUNTED).map(integral).collect();
        let whole: f64 = wanted.iter().sum();
        for (cell, (drawn, wanted)) in drawn.iter().zip(&wanted).enumerate() {
            // A bin of the table has 2^-12 of the integral, and its ends are exact.
            let off = (drawn - wanted / whole).abs();
            assert!(off < 2e-4, "{filter:?}, cell {cell}: {drawn}, not {}", wanted / whole);
        }
        let mean: f64 = drawn.iter().sum();
        assert!((mean - 1.0).abs() < 1e-6, "{filter:?}: the mean weight is {mean}");
    }
}

#[test]
fn lanes_have_the_bits_of_single_samples() {
    let mut random = Stream::new(3);
    for (filter, ..) in filters() {
        let table = FilterTable::new(&filter).expect("it is not the box");
        for _ in 0..1000 {
            let mut u: [f32; LANES] = std::array::from_fn(|_| random.uniform());
            (u[0], u[1]) = (0.0, 1.0f32.next_down());
            let (x, weight) = table.sample(Float::new(u));
            let one = u.map(|u| table.sample::<f32>(u));
            assert_eq!(x.to_bits().to_array(), one.map(|(x, _)| x.to_bits()), "{filter:?}");
            let bits = weight.to_bits().to_array();
            assert_eq!(bits, one.map(|(_, weight)| Real::to_bits(weight)), "{filter:?}");
        }
    }
    assert!(FilterTable::new(&PixelFilter::Box).is_none());
}
