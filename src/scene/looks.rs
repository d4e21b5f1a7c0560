//! What each primitive looks like: its material, the key by which paths are sorted that hit it, and the
//! light that it is.

use super::Scene;
use super::emission::Emission;
use super::material::{MaterialKind, MaterialTables};
use super::texture::TextureTables;
use crate::geometry::{Hit, Shape};
use crate::math::{Mask, Real, Word};

/// The materials of a geometry's primitives: one for each sphere and quad, and for ranges of triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct MaterialMap {
    /// Of the spheres and quads.
    pub(super) solids: Vec<u32>,
    /// Of the triangles: one past the last primitive of a range, and its material.
    pub(super) ranges: Vec<(u32, u32)>,
}

impl MaterialMap {
    /// The material of a primitive.
    pub(super) fn get(&self, primitive: u32) -> u32 {
        match self.solids.get(primitive as usize) {
            Some(material) => *material,
            None => self.ranges[self.ranges.partition_point(|&(end, _)| end <= primitive)].1,
        }
    }
}

/// What paths arrive at that are shaded together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Key {
    /// Nothing.
    Background,
    /// A collision in a medium.
    Medium,
    /// Primitives of one shape, of one kind of material.
    Surface {
        shape: Shape,
        kind: MaterialKind,
        /// Whether they are lights.
        emits: bool,
    },
}

/// The looks of primitives, media and the background. Media are numbered after the primitives.
#[derive(Debug)]
pub(crate) struct Looks {
    /// The keys that the scene has.
    keys: Vec<Key>,
    /// The number of the key of each sphere and quad; of media and the background too where there are
    /// no triangles, else [`SEARCH`].
    key_of: Vec<u8>,
    /// The place of the material of each sphere and quad in the table of its kind.
    entries: Vec<u32>,
    /// The light that each sphere and quad is, or [`NO_LIGHT`].
    lights: Vec<u32>,
    /// Of triangles, media, and the background.
    ranges: Vec<Range>,
    first_medium: u32,
}

/// Consecutive primitives with the same look.
#[derive(Clone, Copy, Debug)]
struct Range {
    /// The first.
    begin: u32,
    /// The last.
    last: u32,
    key: u8,
    entry: u32,
    /// The light that the first is, or [`NO_LIGHT`].
    light: u32,
}

/// The number of no key: [`Looks::ranges`] have it.
const SEARCH: u8 = u8::MAX;
const NO_LIGHT: u32 = u32::MAX;

impl Looks {
    /// Those of `scene`, whose materials go to the tables. `shine` is called with each light in the
    /// order of primitives.
    pub(super) fn new(
        scene: &Scene,
        materials: &mut MaterialTables,
        textures: &mut TextureTables,
        mut shine: impl FnMut(u32, Emission),
    ) -> Self {
        let entries: Vec<u32> =
            scene.materials().iter().map(|material| materials.push(material, textures)).collect();
        let mut keys = vec![Key::Background];
        let mut number = |key| {
            let index = keys.iter().position(|&k| k == key).unwrap_or(keys.len());
            if index == keys.len() {
                keys.push(key);
            }
            assert!(index < usize::from(SEARCH), "more kinds of shapes and materials than keys");
            index as u8
        };
        let geometry = scene.geometry();
        // The primitives `begin..=last`, of one shape, with material number `material`.
        let mut light = 0;
        let mut range = |begin: u32, last: u32, material: u32| {
            let shape = geometry.get(begin).shape();
            let entry = entries[material as usize];
            let material = &scene.materials()[material as usize];
            let emission = material.emission();
            let emits = emission.is_some();
            let key = number(Key::Surface { shape, kind: material.kind(), emits });
            let first = light;
            if let Some(emission) = emission.filter(Emission::shines) {
                (begin..=last).for_each(|primitive| shine(primitive, emission));
                light += last - begin + 1;
            }
            let light = if light > first { first } else { NO_LIGHT };
            Range { begin, last, key, entry, light }
        };
        let MaterialMap { solids, ranges: triangles } = scene.material_map();
        let solids: Vec<Range> =
            (0..).zip(solids).map(|(primitive, &m)| range(primitive, primitive, m)).collect();
        let mut begin = solids.len() as u32;
        let mut ranges = Vec::new();
        for &(end, material) in triangles {
            ranges.push(range(begin, end - 1, material));
            begin = end;
        }
        let first_medium = begin;
        let rest = |begin, last, key| Range { begin, last, key, entry: 0, light: NO_LIGHT };
        for medium in (first_medium..).take(scene.media().len()) {
            ranges.push(rest(medium, medium, number(Key::Medium)));
        }
        ranges.push(rest(first_medium + scene.media().len() as u32, Hit::MISS, 0));
        let mut key_of: Vec<u8> = solids.iter().map(|solid| solid.key).collect();
        if triangles.is_empty() {
            key_of.extend(ranges.iter().map(|range| range.key));
        } else {
            key_of.push(SEARCH);
        }
        Self {
            keys,
            key_of,
            entries: solids.iter().map(|solid| solid.entry).collect(),
            lights: solids.iter().map(|solid| solid.light).collect(),
            ranges,
            first_medium,
        }
    }

    /// The keys by number; the first is the background's.
    pub(crate) fn keys(&self) -> &[Key] {
        &self.keys
    }

    /// The number of the key of a primitive, of a medium, or of [`Hit::MISS`].
    #[inline(always)]
    pub(crate) fn key(&self, primitive: u32) -> u8 {
        match self.key_of[(primitive as usize).min(self.key_of.len() - 1)] {
            SEARCH => self.range(primitive).key,
            key => key,
        }
    }

    #[inline(always)]
    fn range(&self, primitive: u32) -> &Range {
        &self.ranges[self.ranges.partition_point(|range| range.last < primitive)]
    }

    /// The places of the materials of primitives of one shape in the table of their kind, which has
    /// `len` entries.
    #[inline(always)]
    pub(crate) fn entries<R: Real>(
        &self,
        shape: Shape,
        primitive: R::Word,
        len: usize,
    ) -> R::Index {
        let entries = match shape {
            _ if len == 1 => R::Word::splat(0),
            Shape::Triangle => R::each_word(primitive, |primitive| self.range(primitive).entry),
            _ => R::pick(&self.entries, R::index(primitive, self.entries.len())),
        };
        R::index_of_few(entries, len)
    }

    /// The lights that primitives of one shape are, and whether they are lights.
    #[inline(always)]
    pub(crate) fn lights<R: Real>(&self, shape: Shape, primitive: R::Word) -> (R::Word, R::Mask) {
        let light = match shape {
            Shape::Triangle => R::each_word(primitive, |primitive| self.light_of(primitive)),
            _ => R::pick(&self.lights, R::index(primitive, self.lights.len())),
        };
        let none = light.eq(R::Word::splat(NO_LIGHT));
        (none.select(R::Word::splat(0), light), !none)
    }

    fn light_of(&self, triangle: u32) -> u32 {
        let range = self.range(triangle);
        match range.light {
            NO_LIGHT => NO_LIGHT,
            first => first + (triangle - range.begin),
        }
    }

    /// The number of the first medium among primitives.
    pub(crate) fn first_medium(&self) -> u32 {
        self.first_medium
    }
}
