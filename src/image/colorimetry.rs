//! Converts the colours of float images to linear Rec. 709.

use crate::math::precise::{exp2, log2};

/// The chromaticities x and y of red, green, blue and white.
type Primaries = [[f64; 2]; 4];

const D65: [f64; 2] = [0.3127, 0.329];
/// The white point of ACES.
const D60: [f64; 2] = [0.32168, 0.33767];
const REC709: Primaries = [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], D65];
/// Chromaticities that differ less are the same: files round them.
const SAME: f64 = 1e-3;
/// The cone responses of Bradford, in which white points are adapted.
const BRADFORD: [[f64; 3]; 3] =
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

/// The primaries that identifiers of colour spaces name.
const KNOWN: [(&str, Primaries); 6] = [
    ("rec709", REC709),
    ("p3d65", [[0.68, 0.32], [0.265, 0.69], [0.15, 0.06], D65]),
    ("rec2020", [[0.708, 0.292], [0.17, 0.797], [0.131, 0.046], D65]),
    ("adobergb", [[0.64, 0.33], [0.21, 0.71], [0.15, 0.06], D65]),
    ("ap0", [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], D60]),
    ("ap1", [[0.713, 0.293], [0.165, 0.83], [0.128, 0.044], D60]),
];

/// A curve through which values are stored.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Curve {
    Linear,
    Srgb,
    Power(f64),
}

/// How the colours of a file become linear Rec. 709.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Conversion {
    curve: Curve,
    matrix: Option<[[f64; 3]; 3]>,
}

impl Conversion {
    /// The conversion of a file with this identifier of a colour space, or with these primaries; `None` if the
    /// colours are linear Rec. 709 already. The identifier has precedence, unless it is unknown.
    ///
    /// # Errors
    /// If ptfast lacks the colour space, or the primaries make none.
    pub(super) fn of(
        id: Option<&str>,
        primaries: Option<Primaries>,
    ) -> Result<Option<Self>, String> {
        let (curve, primaries) = match id.and_then(named) {
            Some(Named::Unsupported) if primaries.is_none() => {
                let id = id.unwrap_or_default();
                return Err(format!(
                    "unsupported image: its colour space is `{id}`, write it as linear Rec. 709"
                ));
            }
            Some(Named::Data) => return Ok(None),
            Some(Named::Space(curve, primaries)) => (curve, primaries),
            Some(Named::Unsupported) | None => (Curve::Linear, primaries.unwrap_or(REC709)),
        };
        let near = |(a, b): (&f64, &f64)| (a - b).abs() < SAME;
        let is_same = primaries.as_flattened().iter().zip(REC709.as_flattened()).all(near);
        let matrix = match is_same {
            true => None,
            false => {
                Some(matrix(primaries).ok_or("damaged image: its chromaticities make no colours")?)
            }
        };
        Ok((matrix.is_some() || curve != Curve::Linear).then_some(Self { curve, matrix }))
    }

    /// Converts a pixel of three colours, by which its alpha may be multiplied. Pixels with values that are not finite
    /// stay as they are.
    pub(super) fn apply(&self, pixel: &mut [f32]) {
        if pixel.iter().any(|value| !value.is_finite()) {
            return;
        }
        let alpha = pixel.get(3).map_or(1.0, |&alpha| f64::from(alpha));
        let mut color = [0, 1, 2].map(|i| f64::from(pixel[i]));
        if self.curve != Curve::Linear {
            let alpha = if alpha > 0.0 { alpha } else { 1.0 };
            color = color.map(|value| self.curve.linear(value / alpha) * alpha);
        }
        if let Some(matrix) = self.matrix {
            color = product(matrix, color);
        }
        for (value, color) in pixel.iter_mut().zip(color) {
            *value = color as f32;
        }
    }
}

/// What an identifier of the Color Interop Forum means.
enum Named {
    Space(Curve, Primaries),
    /// Numbers.
    Data,
    /// A colour space that ptfast lacks.
    Unsupported,
}

/// The meaning of an identifier such as `lin_ap1_scene`: a curve, primaries, and a state that does not matter here. A
/// namespace may come first, as in `ocio:lin_ap1_scene`. `None` for `unknown`.
fn named(id: &str) -> Option<Named> {
    let mut words = id.rsplit(':').next()?.split('_');
    let (curve, primaries) = (words.next()?, words.next());
    let curve = match curve {
        "data" if primaries.is_none() => return Some(Named::Data),
        "lin" => Curve::Linear,
        "srgb" => Curve::Srgb,
        "g18" => Curve::Power(1.8),
        "g22" => Curve::Power(2.2),
        "g24" => Curve::Power(2.4),
        "g26" => Curve::Power(2.6),
        "unknown" | "" => return None,
        _ => return Some(Named::Unsupported),
    };
    let known = KNOWN.iter().find(|(name, _)| Some(*name) == primaries);
    Some(known.map_or(Named::Unsupported, |&(_, primaries)| Named::Space(curve, primaries)))
}

impl Curve {
    /// The linear value of a stored one. Negative values mirror positive ones.
    fn linear(self, value: f64) -> f64 {
        let power = |x: f64, exponent: f64| if x > 0.0 { exp2(exponent * log2(x)) } else { 0.0 };
        let x = value.abs();
        let linear = match self {
            Self::Linear => x,
            Self::Srgb if x <= 0.04045 => x / 12.92,
            Self::Srgb => power((x + 0.055) / 1.055, 2.4),
            Self::Power(exponent) => power(x, exponent),
        };
        if value < 0.0 { -linear } else { linear }
    }
}

/// The matrix from colours of these primaries to Rec. 709, with the white point adapted; `None` if they are singular.
fn matrix(primaries: Primaries) -> Option<[[f64; 3]; 3]> {
    let back = inverse(to_xyz(REC709)?)?;
    let cones = |white: [f64; 2]| product(BRADFORD, xyz(white));
    let (from, to) = (cones(primaries[3]), cones(D65));
    let mut adapted = BRADFORD;
    for (row, (from, to)) in adapted.iter_mut().zip(from.into_iter().zip(to)) {
        *row = row.map(|value| value * to / from);
    }
    let adapt = times(inverse(BRADFORD)?, adapted);
    let all = times(back, times(adapt, to_xyz(primaries)?));
    all.as_flattened().iter().all(|value| value.is_finite()).then_some(all)
}

/// XYZ of a chromaticity, with Y = 1.
fn xyz([x, y]: [f64; 2]) -> [f64; 3] {
    [x / y, 1.0, (1.0 - x - y) / y]
}

/// The matrix from RGB of these primaries to XYZ, in which equal parts make the white point.
fn to_xyz([red, green, blue, white]: Primaries) -> Option<[[f64; 3]; 3]> {
    let column = |[x, y]: [f64; 2]| [x, y, 1.0 - x - y];
    let [r, g, b] = [red, green, blue].map(column);
    let all = [0, 1, 2].map(|i| [r[i], g[i], b[i]]);
    let shares = product(inverse(all)?, xyz(white));
    Some(all.map(|row| [0, 1, 2].map(|i| row[i] * shares[i])))
}

fn product(matrix: [[f64; 3]; 3], vector: [f64; 3]) -> [f64; 3] {
    matrix.map(|[a, b, c]| a * vector[0] + b * vector[1] + c * vector[2])
}

fn times(a: [[f64; 3]; 3], b: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let column = |i: usize| product(a, b.map(|row| row[i]));
    let [x, y, z] = [column(0), column(1), column(2)];
    [0, 1, 2].map(|i| [x[i], y[i], z[i]])
}

fn inverse([a, b, c]: [[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let cross = |u: [f64; 3], v: [f64; 3]| {
        [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    };
    let [x, y, z] = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant = a[0] * x[0] + a[1] * x[1] + a[2] * x[2];
    let is_regular = determinant.is_finite() && determinant.abs() > 1e-9;
    is_regular.then(|| [0, 1, 2].map(|i| [x[i], y[i], z[i]].map(|value| value / determinant)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn converted(id: Option<&str>, primaries: Option<Primaries>, color: [f32; 3]) -> [f32; 3] {
        let mut pixel = color;
        Conversion::of(id, primaries).unwrap().unwrap().apply(&mut pixel);
        pixel
    }

    fn assert_near(found: [f32; 3], want: [f32; 3]) {
        let near = found.iter().zip(want).all(|(a, b)| (a - b).abs() < 2e-4);
        assert!(near, "{found:?} instead of {want:?}");
    }

    /// The matrices of ACES AP0 and AP1 to linear sRGB with Bradford adaptation, as colour-science and OpenColorIO
    /// publish them.
    #[test]
    fn primaries_become_rec_709_with_adapted_white() {
        let ap0 = Some(KNOWN[4].1);
        assert_near(converted(None, ap0, [1.0; 3]), [1.0; 3]);
        assert_near(converted(None, ap0, [1.0, 0.0, 0.0]), [2.5217, -0.2765, -0.0154]);
        let ap1 = |color| converted(Some("lin_ap1_scene"), None, color);
        assert_near(ap1([1.0, 0.0, 0.0]), [1.7051, -0.1303, -0.0240]);
        assert_near(ap1([0.0, 1.0, 0.0]), [-0.6218, 1.1408, -0.1290]);
        assert_eq!(Conversion::of(None, Some(REC709)), Ok(None));
        assert_eq!(Conversion::of(None, None), Ok(None));
        assert!(Conversion::of(None, Some([[0.0; 2]; 4])).unwrap_err().contains("chromaticities"));
    }

    /// IEC 61966-2-1. Identifiers are those of the Color Interop Forum.
    #[test]
    fn identifiers_name_curves_and_primaries() {
        let srgb = |color| converted(Some("srgb_rec709_scene"), None, color);
        assert_near(srgb([0.5, 0.04, -0.5]), [0.21404, 0.003096, -0.21404]);
        assert_near(
            converted(Some("g22_rec709_scene"), None, [0.5, 0.0, 1.0]),
            [0.21764, 0.0, 1.0],
        );
        // Colours are multiplied by alpha.
        let mut pixel = [0.25, 0.25, 0.25, 0.5];
        Conversion::of(Some("srgb_rec709_scene"), None).unwrap().unwrap().apply(&mut pixel);
        assert_near([pixel[0], pixel[3], 0.0], [0.10702, 0.5, 0.0]);
        for (id, primaries) in [("data", KNOWN[4].1), ("lin_rec709_scene", KNOWN[4].1)] {
            assert_eq!(Conversion::of(Some(id), Some(primaries)), Ok(None), "{id}");
        }
        assert!(Conversion::of(Some("unknown"), Some(KNOWN[4].1)).unwrap().is_some());
        let error = Conversion::of(Some("pq_rec2020_display"), None).unwrap_err();
        assert!(
            error.contains("unsupported image: its colour space is `pq_rec2020_display`"),
            "{error}"
        );
    }
}
