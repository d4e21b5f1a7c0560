//! Parameters of materials in the form of rows: constants, or the codes of textures.

use std::sync::Arc;

use glam::Vec3;

use super::{
    CHANNEL_SHIFT, Channel, Color, KIND_SHIFT, Number, Rgba, TexturePoint, TextureRef,
    TextureTables,
};
use crate::math::{Mask, Real, Row, Vector, Word, row};

impl TextureTables {
    /// Returns the number of parameters that are textures.
    pub(crate) fn uses(&self) -> usize {
        self.uses
    }

    /// Returns the code of a texture, or its colour as `Ok` if that is the same everywhere.
    fn code(&mut self, texture: &TextureRef) -> std::result::Result<[f32; 3], u32> {
        let texture = texture.get();
        let known = self.known.iter().find(|(known, _)| Arc::ptr_eq(known, texture));
        let code = match known {
            Some((_, code)) => *code,
            None => match self.push(texture) {
                Ok(color) => return Ok(color),
                Err(code) => {
                    let entry = code & ((1 << KIND_SHIFT) - 1);
                    assert!(entry < 1 << CHANNEL_SHIFT, "too many textures of one kind");
                    self.known.push((Arc::clone(texture), code));
                    code
                }
            },
        };
        self.uses += 1;
        Err(code)
    }

    /// Returns the row of a colour: (the colour, 0), or (the factor, code) for a texture.
    pub(crate) fn row(&mut self, color: &Color) -> Row {
        match color {
            Color::Rgb(rgb) => row((*rgb).into(), 0.0),
            Color::Texture { texture, factor } => match self.code(texture) {
                Ok(color) => row(Vec3::from(color) * Vec3::from(*factor), 0.0),
                Err(code) => row((*factor).into(), f32::from_bits(code)),
            },
        }
    }

    /// Returns two words for a number: the number and 0, or the factor and the code for a texture.
    pub(crate) fn number(&mut self, number: &Number) -> [u32; 2] {
        match number {
            Number::Value(value) => [value.to_bits(), 0],
            Number::Texture { texture, channel, factor } => match self.code(texture) {
                Ok([r, g, b]) => [([r, g, b, 1.0][*channel as usize] * factor).to_bits(), 0],
                Err(code) => [factor.to_bits(), code | (*channel as u32) << CHANNEL_SHIFT],
            },
        }
    }

    /// Returns the code of a normal map, or 0 without one.
    pub(crate) fn normal_code(&mut self, normal: Option<&TextureRef>) -> u32 {
        normal.map_or(0, |normal| self.code(normal).expect_err("a normal map is an image"))
    }

    /// Returns the colours of the normal maps with these codes at the point `at`. Code 0 gives black.
    #[inline(always)]
    pub(crate) fn normal<R: Real>(&self, code: R::Word, at: &impl TexturePoint<R>) -> R::Vec3 {
        self.textured((R::Vec3::zero(), R::ZERO), code, at).0
    }

    /// Returns the colour of a row at the point `at`.
    #[inline(always)]
    pub(crate) fn color<R: Real>(
        &self,
        (color, code): (R::Vec3, R),
        at: &impl TexturePoint<R>,
    ) -> R::Vec3 {
        let code = code.to_bits();
        let plain = code.eq(R::Word::splat(0));
        if !(!plain).any() {
            return color;
        }
        let white = (R::Vec3::gray(R::ONE), R::ONE);
        color * self.textured(white, code, at).0
    }

    /// Returns the number for two words of [`TextureTables::number`] at the point `at`.
    #[inline(always)]
    pub(crate) fn number_at<R: Real>(
        &self,
        [number, code]: [R; 2],
        at: &impl TexturePoint<R>,
    ) -> R {
        let code = code.to_bits();
        let plain = code.eq(R::Word::splat(0));
        if !(!plain).any() {
            return number;
        }
        let white = (R::Vec3::gray(R::ONE), R::ONE);
        let texture = code & R::Word::splat(!(3 << CHANNEL_SHIFT));
        number * channel(self.textured(white, texture, at), code)
    }

    /// As [`number_at`](Self::number_at), for two numbers. If they are channels of the same
    /// textures, these are evaluated once.
    #[inline(always)]
    pub(crate) fn two_numbers_at<R: Real>(
        &self,
        numbers: [[R; 2]; 2],
        at: &impl TexturePoint<R>,
    ) -> [R; 2] {
        let [[first, code], [second, other]] = numbers;
        let texture = |code: R| code.to_bits() & R::Word::splat(!(3 << CHANNEL_SHIFT));
        let (one, two) = (texture(code), texture(other));
        let plain = (one | two).eq(R::Word::splat(0));
        if (!one.eq(two)).any() || !(!plain).any() {
            return [self.number_at([first, code], at), self.number_at([second, other], at)];
        }
        let white = (R::Vec3::gray(R::ONE), R::ONE);
        let value = self.textured(white, one, at);
        [first * channel(value, code.to_bits()), second * channel(value, other.to_bits())]
    }
}

/// The channel of `value` that the code of a number names.
#[inline(always)]
fn channel<R: Real>((color, alpha): Rgba<R>, code: R::Word) -> R {
    let named = (code >> CHANNEL_SHIFT) & R::Word::splat(3);
    let is = |c: Channel| named.eq(R::Word::splat(c as u32));
    let red_or_alpha = is(Channel::A).select(alpha, color[0]);
    is(Channel::G).select(color[1], is(Channel::B).select(color[2], red_or_alpha))
}
