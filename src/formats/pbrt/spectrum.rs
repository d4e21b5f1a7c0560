//! Spectra as linear RGB.

use super::{Param, Values};
use crate::math::precise::exp;

/// Linear RGB of a spectrum. Blackbodies and measured illuminants have a luminance of 1.
///
/// # Errors
/// If the values do not suit the type of the parameter. A spectrum that ptfast does not know is an
/// error, too.
pub(crate) fn rgb(param: &Param) -> Result<[f64; 3], String> {
    let Param { kind, name, values, .. } = param;
    match (kind.as_str(), values) {
        ("rgb" | "color", Values::Numbers(numbers)) => {
            numbers.as_slice().try_into().map_err(|_| format!("`{name}` must be three numbers"))
        }
        ("float", Values::Numbers(numbers)) if numbers.len() == 1 => Ok([numbers[0]; 3]),
        ("xyz", Values::Numbers(numbers)) => {
            let xyz = numbers.as_slice().try_into();
            xyz.map(of_xyz).map_err(|_| format!("`{name}` must be three numbers"))
        }
        ("blackbody", Values::Numbers(numbers)) if !numbers.is_empty() => Ok(blackbody(numbers[0])),
        ("spectrum", Values::Numbers(numbers)) if numbers.len() >= 2 && numbers.len() % 2 == 0 => {
            Ok(WAVELENGTHS.map(|wavelength| interpolated(numbers, wavelength)))
        }
        ("spectrum", Values::Texts(texts)) if texts.len() == 1 => {
            let unknown =
                || format!("`{name}`: ptfast does not know the spectrum \"{}\"", texts[0]);
            named(&texts[0]).ok_or_else(unknown)
        }
        _ => Err(format!("`{name}` must be a spectrum, such as \"rgb {name}\" [ 1 1 1 ]")),
    }
}

/// Wavelengths in nanometres that stand for red, green and blue.
const WAVELENGTHS: [f64; 3] = [610.0, 550.0, 465.0];

/// The value at `wavelength` between pairs of a wavelength and a value.
fn interpolated(pairs: &[f64], wavelength: f64) -> f64 {
    let (pairs, _) = pairs.as_chunks::<2>();
    let after = pairs.iter().position(|pair| pair[0] > wavelength);
    match after {
        Some(0) => pairs[0][1],
        None => pairs[pairs.len() - 1][1],
        Some(i) => {
            let ([from, a], [to, b]) = (pairs[i - 1], pairs[i]);
            a + (b - a) * (wavelength - from) / (to - from)
        }
    }
}

/// The spectra that pbrt knows by name: indices of refraction, and illuminants, which are white.
fn named(name: &str) -> Option<[f64; 3]> {
    let all = METALS.iter().flat_map(|(metal, eta, k)| {
        [(format!("metal-{metal}-eta"), *eta), (format!("metal-{metal}-k"), *k)]
    });
    if let Some((_, rgb)) = all.into_iter().find(|(known, _)| known == name) {
        return Some(rgb);
    }
    if let Some(&(_, ior)) = GLASSES.iter().find(|(known, _)| *known == name) {
        return Some([ior; 3]);
    }
    (name.starts_with("stdillum-") || name.starts_with("illum-")).then_some([1.0; 3])
}

/// Complex indices of refraction of metals, as in the public scenes that give them in RGB.
const METALS: [(&str, [f64; 3], [f64; 3]); 7] = [
    ("Ag", [0.155265, 0.116725, 0.138342], [4.828370, 3.122497, 2.147033]),
    ("Al", [1.657460, 0.880369, 0.521229], [9.223869, 6.269523, 4.837001]),
    ("Au", [0.143119, 0.374957, 1.442479], [3.983160, 2.385721, 1.603215]),
    ("Cu", [0.200438, 0.924033, 1.102212], [3.912949, 2.452848, 2.142188]),
    ("CuZn", [0.444, 0.527, 1.094], [3.695, 2.765, 1.829]),
    ("MgO", [1.735, 1.740, 1.750], [0.001, 0.001, 0.001]),
    ("TiO2", [2.59, 2.65, 2.85], [0.001, 0.001, 0.001]),
];

/// Indices of refraction of glasses at 588 nm.
const GLASSES: [(&str, f64); 7] = [
    ("glass-BK7", 1.5168),
    ("glass-BAF10", 1.6700),
    ("glass-FK51A", 1.4866),
    ("glass-LASF9", 1.8503),
    // Here pbrt's data are those of SF5, SF10 and SF11.
    ("glass-F5", 1.6727),
    ("glass-F10", 1.7283),
    ("glass-F11", 1.7847),
];

/// Linear RGB of a colour in CIE XYZ (IEC 61966-2-1).
fn of_xyz([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        3.240_969_9 * x - 1.537_383_2 * y - 0.498_610_8 * z,
        -0.969_243_6 * x + 1.875_967_5 * y + 0.041_555_1 * z,
        0.055_630_1 * x - 0.203_977_0 * y + 1.056_971_5 * z,
    ]
}

/// Linear RGB of a black body at `kelvin`, with a luminance of 1. Colours outside sRGB lose their
/// negative parts.
pub(crate) fn blackbody(kelvin: f64) -> [f64; 3] {
    let kelvin = kelvin.clamp(500.0, 50_000.0);
    let mut xyz = [0.0; 3];
    for i in 0..81 {
        let nanometres = 380.0 + 5.0 * f64::from(i);
        // Planck's law, up to a constant factor.
        let ratio = 1000.0 / nanometres;
        let square = ratio * ratio;
        let power = square * square * ratio / (exp(14_387_768.775 / (nanometres * kelvin)) - 1.0);
        let response = matching(nanometres);
        xyz.iter_mut().zip(response).for_each(|(sum, response)| *sum += power * response);
    }
    let rgb = of_xyz(xyz).map(|c| if c > 0.0 { c } else { 0.0 });
    let luminance = 0.212_639 * rgb[0] + 0.715_169 * rgb[1] + 0.072_192 * rgb[2];
    rgb.map(|c| c / luminance)
}

/// The CIE 1931 matching functions (Wyman, Sloan, Shirley 2013, "Simple analytic approximations").
fn matching(nanometres: f64) -> [f64; 3] {
    let lobe = |scale: f64, middle: f64, below: f64, above: f64| {
        let t = (nanometres - middle) * if nanometres < middle { below } else { above };
        scale * exp(-0.5 * t * t)
    };
    [
        lobe(0.362, 442.0, 0.0624, 0.0374) + lobe(1.056, 599.8, 0.0264, 0.0323)
            - lobe(0.065, 501.1, 0.0490, 0.0382),
        lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322),
        lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn black_bodies_turn_from_red_to_blue() {
        let [warm, white, cold] = [2700.0, 6500.0, 15_000.0].map(blackbody);
        assert!(warm[0] > 1.5 && warm[2] < 0.4, "{warm:?}");
        assert!(white.iter().all(|c| (c - 1.0).abs() < 0.1), "{white:?}");
        assert!(cold[0] < 0.9 && cold[2] > 1.4, "{cold:?}");
    }

    #[test]
    fn pairs_are_interpolated() {
        let pairs = [400.0, 0.0, 600.0, 1.0, 700.0, 1.0];
        assert_eq!(WAVELENGTHS.map(|w| interpolated(&pairs, w)), [1.0, 0.75, 0.325]);
        assert_eq!(interpolated(&pairs, 300.0), 0.0);
        assert_eq!(interpolated(&pairs, 800.0), 1.0);
    }
}
