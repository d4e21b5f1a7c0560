//! Textures: colours that vary over a surface.

use glam::Vec3;
use std::f64::consts::PI;

use crate::image::Image;
use crate::math::clamp;

/// A resolved texture.
#[derive(Clone, Debug, PartialEq)]
pub enum Texture {
    /// One colour.
    Solid(Vec3),
    /// A 3-D checker.
    Checker(Checker),
    /// A picture, filtered bilinearly; u repeats, v is clamped, v = 0 is the bottom.
    Image(Image),
}

/// Cubic cells of two colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checker {
    /// Where sin(sx)·sin(sy)·sin(sz) < 0.
    pub odd: Vec3,
    /// Elsewhere.
    pub even: Vec3,
    /// Cells per unit of length, s/π.
    pub frequency: f32,
}

impl Texture {
    /// Colour at `point`, whose texture coordinates `uv` gives if asked.
    #[inline]
    pub fn color(&self, point: Vec3, uv: impl FnOnce() -> (f32, f32)) -> Vec3 {
        match self {
            Self::Solid(color) => *color,
            Self::Checker(checker) => checker.color(point),
            Self::Image(image) => bilinear(image, uv()),
        }
    }
}

impl Checker {
    /// The checker with `scale` s.
    pub fn new(odd: Vec3, even: Vec3, scale: f32) -> Self {
        Self { odd, even, frequency: (f64::from(scale) / PI) as f32 }
    }

    /// The product of sines is negative where the sum of the cells' numbers is odd.
    #[inline]
    fn color(&self, point: Vec3) -> Vec3 {
        let odd = |x: f32| {
            let cell = (x * self.frequency).floor();
            cell - 2.0 * (cell * 0.5).floor() != 0.0
        };
        if odd(point.x) ^ odd(point.y) ^ odd(point.z) { self.odd } else { self.even }
    }
}

fn bilinear(image: &Image, (u, v): (f32, f32)) -> Vec3 {
    let (width, height) = (image.width(), image.height());
    let x = clamp(u, 0.0, 1.0) * width as f32 - 0.5;
    let y = (1.0 - clamp(v, 0.0, 1.0)) * height as f32 - 0.5;
    let (x0, y0) = (x.floor(), y.floor());
    let (fx, fy) = (x - x0, y - y0);
    let (x0, y0) = (x0 as i32, y0 as i32);
    let pixel = |x: i32, y: i32| {
        let x = if x < 0 { width - 1 } else { x as u32 % width };
        let y = y.clamp(0, height as i32 - 1) as u32;
        Vec3::from_array(image.pixels()[(y * width + x) as usize])
    };
    let row = |y| pixel(x0, y) * (1.0 - fx) + pixel(x0 + 1, y) * fx;
    row(y0) * (1.0 - fy) + row(y0 + 1) * fy
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;

    #[test]
    #[allow(clippy::disallowed_methods)] // the definition has sines
    fn checker_is_the_sign_of_the_product_of_sines() {
        let checker = Texture::Checker(Checker::new(Vec3::X, Vec3::Y, 10.0));
        let mut random = Stream::new(2);
        for _ in 0..100_000 {
            let p = Vec3::from_array(std::array::from_fn(|_| random.between(-30.0, 30.0)));
            let sines = p.to_array().map(|x| (10.0 * f64::from(x)).sin());
            if sines.iter().any(|s| s.abs() < 1e-4) {
                continue;
            }
            let want = if sines.iter().product::<f64>() < 0.0 { Vec3::X } else { Vec3::Y };
            assert_eq!(checker.color(p, || (0.0, 0.0)), want, "{p}");
        }
    }

    #[test]
    fn images_are_filtered_and_wrap_around() {
        let image = Image::from_pixels(2, 2, vec![[0.0; 3], [4.0; 3], [8.0; 3], [12.0; 3]]);
        let texture = Texture::Image(image);
        let at = |u, v| texture.color(Vec3::ZERO, || (u, v)).x;
        assert_eq!(at(0.25, 0.75), 0.0, "middle of the upper left pixel");
        assert_eq!(at(0.75, 0.25), 12.0, "middle of the lower right pixel");
        assert_eq!(at(0.5, 0.5), 6.0);
        assert_eq!(at(0.0, 1.0), 2.0, "u wraps, v is clamped");
        assert_eq!(at(1.0, 0.0), 10.0);
        assert_eq!(at(f32::NAN, f32::NAN), at(0.0, 0.0));
    }
}
