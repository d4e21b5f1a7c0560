//! Textures and materials.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use super::Resolver;
use crate::error::{Result, suggestion};
use crate::image::Image;
use crate::limits::Limit;
use crate::scene::description::{Albedo, MaterialFile, TextureFile};
use crate::scene::material::{Emission, Material};
use crate::scene::place::MAX_RADIANCE;
use crate::scene::texture::{Checker, Texture};

impl Resolver<'_> {
    /// The textures, and the files that they were read from.
    pub(super) fn textures(&self, folder: &Path) -> Result<(Vec<Texture>, BTreeSet<PathBuf>)> {
        // The number of the first texture of each file: none is read twice.
        let mut files: HashMap<PathBuf, usize> = HashMap::new();
        let mut textures: Vec<Texture> = Vec::new();
        for (name, texture) in &self.file.textures.0 {
            let e = self.element(self.places.texture(name), "texture");
            textures.push(match texture {
                TextureFile::Solid { color } => Texture::Solid(e.color("color", *color, 1.0)?),
                TextureFile::Checker { odd, even, scale } => {
                    let range = "above 0 and at most 1e6";
                    e.check(*scale > 0.0 && *scale <= 1e6, "scale", range, scale)?;
                    let (odd, even) = (e.color("odd", *odd, 1.0)?, e.color("even", *even, 1.0)?);
                    Texture::Checker(Checker::new(odd, even, *scale))
                }
                TextureFile::Image { file } => {
                    let path = self.path(&e, folder, file)?;
                    if let Some(Texture::Image(there)) = files.get(&path).map(|&i| &textures[i]) {
                        let room = self.budget.hold(12 * there.pixels().len() as u64);
                        room.map_err(|message| e.error(message))?;
                        textures.push(Texture::Image(there.clone()));
                        continue;
                    }
                    let allow = |pixels: u64, memory: u64| {
                        let bytes = 12 * pixels;
                        let limits = &self.budget.limits;
                        limits
                            .check(Limit::TextureBytes, bytes)
                            .and_then(|()| self.budget.check(memory))
                            .and_then(|()| self.budget.hold(bytes))
                    };
                    let image = Image::read_where(&path, &allow).map_err(|error| e.error(error))?;
                    if let Some(bad) =
                        image.pixels().iter().find(|p| p.iter().any(|c| !(0.0..=1.0).contains(c)))
                    {
                        return Err(e.error(format!(
                            "{file}: an albedo must be in [0, 1], a pixel is {bad:?}"
                        )));
                    }
                    files.insert(path, textures.len());
                    Texture::Image(image)
                }
            });
        }
        Ok((textures, files.into_keys().collect()))
    }

    /// Colours given in place of a texture are appended to `textures`.
    pub(super) fn materials(&self, textures: &mut Vec<Texture>) -> Result<Vec<Material>> {
        let mut materials = Vec::new();
        let names: HashMap<&str, u32> = self.file.textures.names().zip(0..).collect();
        for (index, (name, material)) in self.file.materials.0.iter().enumerate() {
            let e = self.element(self.places.material(index, name), "material");
            let mut texture = |albedo: &Albedo| match albedo {
                Albedo::Color(color) => {
                    textures.push(Texture::Solid(e.color("albedo", *color, 1.0)?));
                    Ok(textures.len() as u32 - 1)
                }
                Albedo::Texture(wanted) => names.get(wanted.as_str()).copied().ok_or_else(|| {
                    let known = self.file.textures.names();
                    e.error(format!("unknown texture `{wanted}`{}", suggestion(wanted, known)))
                }),
            };
            materials.push(match material {
                MaterialFile::Diffuse { albedo } => Material::Diffuse { albedo: texture(albedo)? },
                MaterialFile::Lambertian { albedo } => {
                    Material::Lambertian { albedo: texture(albedo)? }
                }
                MaterialFile::Metal { albedo, fuzz } => {
                    e.check((0.0..=1.0).contains(fuzz), "fuzz", "in [0, 1]", fuzz)?;
                    Material::Metal { albedo: texture(albedo)?, fuzz: *fuzz }
                }
                MaterialFile::Dielectric { ior, fresnel } => {
                    let ok = (0.01..=100.0).contains(ior);
                    e.check(ok, "ior", "in [0.01, 100]", ior)?;
                    Material::Dielectric { ior: *ior, fresnel: *fresnel }
                }
                MaterialFile::RoughDielectric { ior, alpha } => {
                    // Towards 1 all microfacets let light pass straight on.
                    let ok = (0.01..=0.99).contains(ior) || (1.01..=100.0).contains(ior);
                    e.check(ok, "ior", "in [0.01, 0.99] or [1.01, 100]", ior)?;
                    e.check((0.001..=1.0).contains(alpha), "alpha", "in [0.001, 1]", alpha)?;
                    Material::RoughDielectric { ior: *ior, alpha: *alpha }
                }
                MaterialFile::Conductor { eta, k, alpha } => {
                    let smooth_or_rough = *alpha == 0.0 || (0.001..=1.0).contains(alpha);
                    e.check(smooth_or_rough, "alpha", "0 or in [0.001, 1]", alpha)?;
                    let (eta, k) = (e.color("eta", *eta, 100.0)?, e.color("k", *k, 100.0)?);
                    // Else Fresnel's equations come to 0/0 where light meets the surface upright.
                    let known = (0..3).all(|channel| eta[channel] >= 0.001 || k[channel] >= 0.001);
                    e.check(known, "k", "0.001 or more where eta is less", k.to_array())?;
                    Material::Conductor { eta, k, alpha: *alpha }
                }
                MaterialFile::Light { radiance, sides } => Material::Light(Emission {
                    radiance: e.color("radiance", *radiance, MAX_RADIANCE)?,
                    sides: *sides,
                }),
            });
        }
        Ok(materials)
    }
}
