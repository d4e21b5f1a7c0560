//! The appearance of each primitive: its material, its light, and its sort key for paths.

use glam::Vec3;

use super::material::{MaterialKind, MaterialTables};
use super::{Bodies, Color, Emission, MaterialMap, Sides, TextureTables, World};
use crate::geometry::{Hit, Shape};
use crate::math::{Mask, Real, Row, Word};

/// The key by which paths are sorted. Paths with the same key are shaded together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Key {
    /// The path left the scene.
    Background,
    /// The path collided in a medium.
    Medium,
    /// The path hit a primitive of this shape and this kind of material.
    Surface {
        shape: Shape,
        kind: MaterialKind,
        /// Whether the primitive emits light.
        emits: bool,
        /// Whether rays can pass it as a pane.
        pane: bool,
    },
}

/// The appearance of primitives, media and the background. Media are numbered after the primitives.
#[derive(Debug)]
pub(crate) struct Looks {
    /// All keys that occur in the scene.
    keys: Vec<Key>,
    /// For each sphere and quad, the index of its key in `keys`. If the scene has triangles, a
    /// single [`SEARCH`] follows. Otherwise the keys of the media and the background follow.
    key_of: Vec<u8>,
    /// For each sphere and quad, the index of its material in the table of the material's kind.
    entries: Vec<u32>,
    /// For each sphere and quad, the index of its light, or [`NO_LIGHT`].
    lights: Vec<u32>,
    /// The appearance of triangles, media and the background, sorted by primitive.
    ranges: Vec<Range>,
    /// The last primitive and the key of each run of primitives with the same key, if there are at
    /// most [`MOST_RUNS`] runs.
    runs: Option<Vec<(u32, u8)>>,
    first_medium: u32,
    have_panes: bool,
}

/// A primitive that is a light.
#[derive(Clone, Copy)]
pub(super) struct Emitter {
    pub(super) shape: Shape,
    pub(super) primitive: u32,
    pub(super) glow: Glow,
}

/// The light of a primitive.
#[derive(Clone, Copy)]
pub(super) enum Glow {
    Constant(Emission),
    /// The row of its colour, a bound on that, and the sides that emit it.
    Varied(Row, Vec3, Sides),
}

/// Consecutive primitives with the same appearance.
#[derive(Clone, Copy, Debug)]
struct Range {
    /// The first primitive.
    begin: u32,
    /// The last primitive.
    last: u32,
    key: u8,
    entry: u32,
    /// The index of the first primitive's light, or [`NO_LIGHT`]. The others' lights follow it.
    light: u32,
}

/// A value in [`Looks::key_of`] that is not a key: the key is found in [`Looks::ranges`].
const SEARCH: u8 = u8::MAX;
const NO_LIGHT: u32 = u32::MAX;
/// Up to this number of runs, comparing primitives with all of them is faster than looking up keys
/// one by one.
const MOST_RUNS: usize = 8;

impl Looks {
    /// Finds the appearance of all primitives and media of `world`, and adds its materials,
    /// textures and bodies to the tables. Calls `emit` for each primitive that is a light, in their order.
    pub(super) fn new(
        world: &World,
        materials: &mut MaterialTables,
        textures: &mut TextureTables,
        bodies: &mut Bodies,
        mut emit: impl FnMut(Emitter, &TextureTables),
    ) -> Self {
        let entries: Vec<u32> = world
            .materials
            .iter()
            .map(|material| materials.push(material, textures, bodies))
            .collect();
        let mut keys = vec![Key::Background];
        let mut number = |key| {
            let index = keys.iter().position(|&k| k == key).unwrap_or(keys.len());
            if index == keys.len() {
                keys.push(key);
            }
            assert!(index < usize::from(SEARCH), "a scene can have at most 255 keys");
            index as u8
        };
        let geometry = &world.geometry;
        // `range` handles the primitives `begin..=last`, which have one shape and one material.
        let mut light = 0;
        let mut range = |begin: u32, last: u32, material: u32| {
            let shape = geometry.shape(begin);
            let entry = entries[material as usize];
            let material = &world.materials[material as usize];
            let emission = material.emission().filter(Emission::emits).map(Glow::Constant);
            let varied = |(color, sides): (&Color, _)| {
                Glow::Varied(textures.row(color), color.largest(), sides)
            };
            let emission = emission.or_else(|| material.model().varied_emission().map(varied));
            let emits = emission.is_some();
            let key = {
                let (kind, pane) = (material.kind(), material.model().is_pane());
                number(Key::Surface { shape, kind, emits, pane })
            };
            let first = light;
            // Paths alone find the light of meshes that instances place.
            if let Some(glow) = emission.filter(|_| shape != Shape::Instance) {
                for primitive in begin..=last {
                    emit(Emitter { shape, primitive, glow }, textures);
                }
                light += last - begin + 1;
            }
            let light = if light > first { first } else { NO_LIGHT };
            Range { begin, last, key, entry, light }
        };
        let MaterialMap { solids, ranges: triangles } = &world.material_map;
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
        for medium in (first_medium..).take(world.media.len()) {
            ranges.push(rest(medium, medium, number(Key::Medium)));
        }
        ranges.push(rest(first_medium + world.media.len() as u32, Hit::MISS, 0));
        let keys_of_all = solids.iter().chain(&ranges).map(|range| (range.last, range.key));
        let mut runs: Vec<(u32, u8)> = Vec::new();
        for (last, key) in keys_of_all {
            match runs.last_mut() {
                Some(run) if run.1 == key => run.0 = last,
                _ => runs.push((last, key)),
            }
        }
        let mut key_of: Vec<u8> = solids.iter().map(|solid| solid.key).collect();
        if triangles.is_empty() {
            key_of.extend(ranges.iter().map(|range| range.key));
        } else {
            key_of.push(SEARCH);
        }
        Self {
            have_panes: keys.iter().any(|key| matches!(key, Key::Surface { pane: true, .. })),
            keys,
            key_of,
            entries: solids.iter().map(|solid| solid.entry).collect(),
            lights: solids.iter().map(|solid| solid.light).collect(),
            ranges,
            runs: Some(runs).filter(|runs| runs.len() <= MOST_RUNS),
            first_medium,
        }
    }

    /// Whether rays can pass a primitive as a pane.
    pub(crate) fn have_panes(&self) -> bool {
        self.have_panes
    }

    /// The keys by index. The first is [`Key::Background`].
    pub(crate) fn keys(&self) -> &[Key] {
        &self.keys
    }

    /// The index of the key of a primitive, of a medium, or of the background for [`Hit::MISS`].
    #[inline(always)]
    pub(crate) fn key(&self, primitive: u32) -> u8 {
        match self.key_of[(primitive as usize).min(self.key_of.len() - 1)] {
            SEARCH => self.range(primitive).key,
            key => key,
        }
    }

    /// The indices of the keys of primitives, or `None` if there are too many to compare with; then
    /// use [`Looks::key`].
    #[inline(always)]
    pub(crate) fn key_words<R: Real>(&self) -> Option<impl Fn(R::Word) -> R::Word> {
        let runs = self.runs.as_deref()?;
        Some(|primitive: R::Word| {
            let mut key = R::Word::splat(u32::from(runs[0].1));
            for (&(last, _), &(_, next)) in runs.iter().zip(&runs[1..]) {
                let before = primitive.le(R::Word::splat(last));
                key = before.select(key, R::Word::splat(u32::from(next)));
            }
            key
        })
    }

    #[inline(always)]
    fn range(&self, primitive: u32) -> &Range {
        &self.ranges[self.ranges.partition_point(|range| range.last < primitive)]
    }

    /// The indices of the materials of primitives of one shape, in the table of their kind, which
    /// has `len` entries.
    #[inline(always)]
    pub(crate) fn entries<R: Real>(
        &self,
        shape: Shape,
        primitive: R::Word,
        len: usize,
    ) -> R::Index {
        let entries = match shape {
            _ if len == 1 => R::Word::splat(0),
            Shape::Triangle | Shape::Instance => {
                R::each_word(primitive, |primitive| self.range(primitive).entry)
            }
            _ => R::pick(&self.entries, R::index(primitive, self.entries.len())),
        };
        R::index_of_few(entries, len)
    }

    /// The indices of the lights of primitives of one shape, and the lanes whose primitive is a
    /// light. The other lanes have index 0.
    #[inline(always)]
    pub(crate) fn lights<R: Real>(&self, shape: Shape, primitive: R::Word) -> (R::Word, R::Mask) {
        let light = match shape {
            Shape::Triangle | Shape::Instance => {
                R::each_word(primitive, |primitive| self.light_of(primitive))
            }
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

    /// The number of the first medium. Media are numbered after the primitives.
    pub(crate) fn first_medium(&self) -> u32 {
        self.first_medium
    }
}
