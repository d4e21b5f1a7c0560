//! Parameters of materials in the form of rows: constants, or the codes of textures.

use std::sync::Arc;

use glam::Vec3;

use super::{
    Channel, Color, Entries, Number, Rgba, Texture, TextureKind, TextureModel, TexturePoint,
    TextureRef,
};
use crate::math::{Mask, Real, Row, Vector, Word, row};

/// Number of low bits in a texture's code that hold its index in its table and the channel. The
/// bits above them hold its kind plus 1, so that code 0 means no texture.
const KIND_SHIFT: u32 = 28;
/// Number of low bits that hold the index. The bits from here to the kind hold the channel.
const CHANNEL_SHIFT: u32 = 26;

/// The textures of a scene.
#[derive(Debug, Default)]
pub(crate) struct TextureTables {
    entries: Entries,
    /// The textures in the tables, with their codes.
    known: Vec<(Arc<Texture>, u32)>,
    /// Number of parameters that are textures.
    uses: usize,
}

/// A texture as a row refers to it.
enum Stored {
    /// The same colour everywhere, which the row contains.
    Constant([f32; 3]),
    /// The code of an entry in a table.
    Code(u32),
}

/// Adds a texture of this kind to its table and returns its code.
pub(super) fn push<T: TextureModel>(
    kind: TextureKind,
    table: &mut Vec<T::Entry>,
    texture: &T,
) -> u32 {
    let entry = table.len();
    assert!(entry < 1 << CHANNEL_SHIFT, "too many textures of one kind");
    table.push(texture.entry());
    ((kind as u32 + 1) << KIND_SHIFT) | entry as u32
}

/// Returns `value`, but the colour and alpha of the texture in the lanes whose `code` is of this kind.
#[inline(always)]
pub(super) fn textured<T: TextureModel, R: Real>(
    kind: TextureKind,
    table: &[T::Entry],
    value: Rgba<R>,
    code: R::Word,
    at: &impl TexturePoint<R>,
) -> Rgba<R> {
    let here = (code >> KIND_SHIFT).eq(R::Word::splat(kind as u32 + 1));
    if T::CONSTANT || !here.any() {
        return value;
    }
    let entry = code & R::Word::splat((1 << CHANNEL_SHIFT) - 1);
    let entry = here.select(entry, R::Word::splat(0));
    // Pass a copy: if the original were passed by reference, the compiler would always keep it in
    // memory instead of in registers.
    let at = *at;
    let found = T::value(table, entry, &at);
    (here.select(found.0, value.0), here.select(found.1, value.1))
}

impl TextureTables {
    /// Returns the number of parameters that are textures.
    pub(crate) fn uses(&self) -> usize {
        self.uses
    }

    /// Adds a texture, unless it is known or has the same colour everywhere.
    fn store(&mut self, texture: &TextureRef) -> Stored {
        let texture = texture.get();
        if let Some(color) = texture.model().constant() {
            return Stored::Constant(color);
        }
        self.uses += 1;
        if let Some((_, code)) = self.known.iter().find(|(known, _)| Arc::ptr_eq(known, texture)) {
            return Stored::Code(*code);
        }
        let code = self.entries.push(texture);
        self.known.push((Arc::clone(texture), code));
        Stored::Code(code)
    }

    /// Returns the row of a colour: (the colour, 0), or (the factor, code) for a texture.
    pub(crate) fn row(&mut self, color: &Color) -> Row {
        match color {
            Color::Rgb(rgb) => row((*rgb).into(), 0.0),
            Color::Texture { texture, factor } => match self.store(texture) {
                Stored::Constant(color) => row(Vec3::from(color) * Vec3::from(*factor), 0.0),
                Stored::Code(code) => row((*factor).into(), f32::from_bits(code)),
            },
        }
    }

    /// Returns two words for a number: the number and 0, or the factor and the code for a texture.
    pub(crate) fn number(&mut self, number: &Number) -> [u32; 2] {
        match number {
            Number::Value(value) => [value.to_bits(), 0],
            Number::Texture { texture, channel, factor } => match self.store(texture) {
                Stored::Constant([r, g, b]) => {
                    [([r, g, b, 1.0][*channel as usize] * factor).to_bits(), 0]
                }
                Stored::Code(code) => [factor.to_bits(), code | (*channel as u32) << CHANNEL_SHIFT],
            },
        }
    }

    /// Returns the code of a normal map, or 0 without one.
    pub(crate) fn normal_code(&mut self, normal: Option<&TextureRef>) -> u32 {
        match normal.map(|normal| self.store(normal)) {
            None => 0,
            Some(Stored::Code(code)) => code,
            Some(Stored::Constant(_)) => unreachable!("a normal map is an image"),
        }
    }

    /// Returns the colours of the normal maps with these codes at the point `at`. Code 0 gives black.
    #[inline(always)]
    pub(crate) fn normal<R: Real>(&self, code: R::Word, at: &impl TexturePoint<R>) -> R::Vec3 {
        self.entries.textured((R::Vec3::zero(), R::ZERO), code, at).0
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
        color * self.entries.textured(white, code, at).0
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
        number * channel(self.entries.textured(white, texture, at), code)
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
        let value = self.entries.textured(white, one, at);
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
