//! The maps of MTL sections, and what their images hold where keywords do not say.

use std::collections::HashMap;
use std::path::Path;

use super::section::Section;
use crate::formats::import::Import;
use crate::image::{Encoding, Size, Source, Texels, has_alpha};
use crate::math::max;
use crate::shading::TextureRef;
use crate::shading::texture::{Channel, Image};

/// The maps of a section.
pub(crate) struct Maps {
    pub(crate) base_color: Option<TextureRef>,
    pub(crate) emission: Option<TextureRef>,
    pub(crate) roughness: Option<TextureRef>,
    pub(crate) metalness: Option<TextureRef>,
    pub(crate) alpha: Option<(TextureRef, Channel)>,
    pub(crate) normal: Option<TextureRef>,
}

/// What is known of images, by file, so that each is looked at once.
#[derive(Default)]
pub(crate) struct Images {
    alpha: HashMap<String, bool>,
    normals: HashMap<String, bool>,
}

impl Images {
    /// Whether an image has an alpha channel.
    pub(crate) fn has_alpha(&mut self, file: &str, import: &Import<'_>) -> bool {
        let look = || import.path_within(file).is_ok_and(|path| has_alpha(&Source::file(&path)));
        *self.alpha.entry(file.to_owned()).or_insert_with(look)
    }

    /// Whether an image holds normals of the tangent space: nine tenths of its colours stand for vectors
    /// of a length near 1 that point outwards, and are not grey. Black texels, with which atlases are padded, do not
    /// count. False for images that cannot be read.
    pub(crate) fn holds_normals(&mut self, file: &str, import: &Import<'_>) -> bool {
        let look = || {
            let Ok(path) = import.path_within(file) else { return false };
            let allow = |size: Size| import.budget.check(size.memory);
            Texels::read(&Source::file(&path), Encoding::Linear, &allow).is_ok_and(|texels| {
                let texels = (0..texels.len()).map(|i| texels.at(i as u32));
                let (mut count, mut normals) = (0, 0);
                for texel in texels.filter(|texel| texel[..3] != [0.0; 3]) {
                    (count, normals) = (count + 1, normals + usize::from(is_normal(texel)));
                }
                count > 0 && normals >= count - count / 10
            })
        };
        *self.normals.entry(file.to_owned()).or_insert_with(look)
    }
}

/// Whether a colour stands for a normal, which exporters may have filtered or not normalised.
fn is_normal([r, g, b, _]: [f32; 4]) -> bool {
    let [x, y, z] = [r, g, b].map(|channel| 2.0 * channel - 1.0);
    let is_grey = max((r - b).abs(), (g - b).abs()) < 0.0625;
    z > 0.0 && !is_grey && (0.5..1.6).contains(&(x * x + y * y + z * z))
}

impl Section<'_> {
    pub(crate) fn maps(&self, import: &mut Import<'_>, images: &mut Images, folder: &Path) -> Maps {
        let mut map =
            |keywords: &[&str], encoding| self.texture(keywords, encoding, import, folder);
        Maps {
            base_color: map(&["map_kd"], Encoding::Auto),
            emission: map(&["map_ke"], Encoding::Auto),
            roughness: map(&["map_pr"], Encoding::Linear),
            metalness: map(&["map_pm"], Encoding::Linear),
            alpha: self.alpha(import, images, folder),
            normal: self.normal(import, images, folder),
        }
    }

    /// The opacity by an image: its alpha, or else green, which is grey in masks, and the largest part of
    /// luminance in colours.
    fn alpha(
        &self,
        import: &mut Import<'_>,
        images: &mut Images,
        folder: &Path,
    ) -> Option<(TextureRef, Channel)> {
        let mut image = self.image(&["map_d"], import, folder)?;
        let channel = if images.has_alpha(&image.file, import) { Channel::A } else { Channel::G };
        (image.encoding, image.normal_scale) = (Encoding::Linear, 1.0);
        Some((image.into(), channel))
    }

    /// The normal map: `norm`, or a bump map with normals. Blender writes normals there.
    fn normal(
        &self,
        import: &mut Import<'_>,
        images: &mut Images,
        folder: &Path,
    ) -> Option<TextureRef> {
        let mut normal = self.image(&["norm", "map_kn"], import, folder);
        let bump = ["map_bump", "bump"].into_iter().find(|keyword| self.has(keyword));
        if let Some(keyword) = bump {
            let image = self.image(&[keyword], import, folder);
            let is_normal =
                |image: &Image| self.by_blender || images.holds_normals(&image.file, import);
            match image.filter(is_normal) {
                None => import.warn("bump maps are not supported, so surfaces stay flat"),
                found => normal = normal.or(found),
            }
        }
        let mut normal = normal?;
        normal.encoding = Encoding::Linear;
        Some(normal.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_are_told_from_heights_and_photos() {
        // Flat, tilted by 30 and by 45 degrees, and a tilt that was not normalised.
        for color in [[0.5, 0.5, 1.0], [0.75, 0.5, 0.93], [0.5, 0.15, 0.85], [0.8, 0.5, 0.8]] {
            assert!(is_normal([color[0], color[1], color[2], 1.0]), "{color:?}");
        }
        // Heights, wood, leaves and black.
        for color in [[0.8, 0.8, 0.8], [0.5; 3], [0.6, 0.4, 0.2], [0.1, 0.5, 0.1], [0.0; 3]] {
            assert!(!is_normal([color[0], color[1], color[2], 1.0]), "{color:?}");
        }
    }
}
