//! Materials of pbrt files.

use std::rc::Rc;

use super::definition::{Definition, MaterialKey};
use super::light::LitSurface;
use super::{Params, Reader, Value};
use crate::shading::material::{
    CoatedDiffuse, Conductor, Dielectric, DiffuseTransmission, Fresnel, Lambertian, Principled,
    RoughDielectric,
};
use crate::shading::texture::Image;
use crate::shading::{Color, Material, Number, Opacity, TextureRef};

/// Largest number of mixtures within each other.
const MAX_MIXTURES: usize = 100;

const NO_ROOT: &str =
    "the square root of textures of roughness is not supported, so they are used as they are";

/// The α from which glass counts as rough.
const ROUGH: f64 = 0.001;

/// The index of refraction whose surface reflects as much as both faces of a sheet of index `ior`, with all reflections
/// between them: 2 F/(1 + F), at normal incidence (pbrt-v4, `ThinDielectricBxDF`).
fn of_both_faces(ior: f32) -> f32 {
    let root = (ior - 1.0) / (ior + 1.0);
    let reflected = root * root;
    let root = (2.0 * reflected / (1.0 + reflected)).sqrt();
    ((1.0 + root) / (1.0 - root)).clamp(1.01, 10.0)
}

impl Reader<'_, '_> {
    /// The name of the scene's material for the current one, with alpha and with the absorption of the
    /// medium inside. `None` for a surface that does not change light.
    pub(crate) fn current_material(
        &mut self,
        alpha: Option<&Value>,
    ) -> Result<Option<String>, String> {
        let definition = Rc::clone(&self.state.material);
        if definition.is_invisible() {
            return Ok(None);
        }
        let inside = self.state.inside.clone().filter(|_| definition.class == "dielectric");
        let key = MaterialKey {
            definition: definition.index,
            inside: inside.clone(),
            alpha: alpha.map(Value::key),
        };
        if let Some(name) = self.materials.known.get(&key) {
            return Ok(Some(name.clone()));
        }
        let class = format!("the material {}", definition.class);
        let mut material = self
            .material(&definition)
            .map_err(|message| format!("{class} of line {}: {message}", definition.line))?;
        self.warn_unused(&definition.params, &class);
        if let Some(medium) = &inside {
            material = self.absorbing(material, medium)?;
        }
        if let Some(alpha) = alpha {
            let alpha = alpha.mapped(|alpha| alpha);
            match material.model_mut().opacity_mut() {
                Some(opacity) => *opacity = Some(Opacity::Blend { alpha }),
                None => {
                    self.import.warn(format!("alpha of {class} is not supported, so it is opaque"))
                }
            }
        }
        let name = definition.name.as_ref().unwrap_or(&definition.class);
        let name = self.materials.unique(name);
        if !material.textures().is_empty() {
            self.materials.textured.insert(name.clone());
        }
        self.scene.add_material(name.clone(), material);
        self.materials.known.insert(key, name.clone());
        Ok(Some(name))
    }

    /// The current material as one that can also emit light; `None` if it only needs to do that.
    pub(crate) fn lit_surface(
        &mut self,
        alpha: Option<&Value>,
    ) -> Result<Option<LitSurface>, String> {
        let definition = Rc::clone(&self.state.material);
        let black = || Principled {
            base_color: [0.0; 3].into(),
            specular: 0.0.into(),
            ..Principled::default()
        };
        let mut material = if definition.is_black() {
            if alpha.is_none() {
                return Ok(None);
            }
            black()
        } else {
            let class = format!("the material {}", definition.class);
            let material = self
                .material(&definition)
                .map_err(|message| format!("{class} of line {}: {message}", definition.line))?;
            self.warn_unused(&definition.params, &class);
            match material {
                Material::Principled(material) => material,
                Material::Lambertian(material) => {
                    Principled { base_color: material.albedo, normal: material.normal, ..black() }
                }
                _ => {
                    self.import.warn(format!(
                        "area lights on {class} are not supported, so they only emit light"
                    ));
                    black()
                }
            }
        };
        material.opacity = alpha.map(|alpha| Opacity::Blend { alpha: alpha.mapped(|alpha| alpha) });
        let key = (definition.index, alpha.map(Value::key));
        Ok(Some(LitSurface { material, key }))
    }

    fn material(&mut self, definition: &Definition) -> Result<Material, String> {
        let Definition { class, params, .. } = definition;
        if params.find("displacement").is_some() {
            self.import.warn("displacement is not supported, so surfaces stay flat");
        }
        let normal = params.text("normalmap")?.map(str::to_owned);
        let normal = normal.filter(|file| self.import.is_usable(file, "so surfaces stay flat"));
        let normal = normal.map(|file| TextureRef::from(Image::normals_from_file(file)));
        let grey = |share: f64| Value::Constant([share; 3]);
        Ok(match class.as_str() {
            "diffuse" => {
                let albedo = self.value(params, "reflectance", "spectrum")?.unwrap_or(grey(0.5));
                Lambertian { normal, ..Lambertian::new(albedo.color()) }.into()
            }
            "coateddiffuse" => {
                let color = self.value(params, "reflectance", "spectrum")?.unwrap_or(grey(0.5));
                let roughness = self.roughness(params, "", true)?;
                let ior = self.ior(params, "eta", 1.5)?;
                params.ignore(&["thickness", "maxdepth", "nsamples"]);
                let coated = CoatedDiffuse::new(color.color(), roughness);
                CoatedDiffuse { normal, ior: ior.clamp(1.01, 10.0), ..coated }.into()
            }
            "conductor" => self.conductor(params, normal)?,
            "coatedconductor" => {
                self.import.warn(
                    "coatedconductor is not supported, so it is principled metal with a coat",
                );
                let [eta, k] = self.indices(params, "conductor.")?;
                let reflectance = |i: usize| {
                    let (eta, k) = (eta[i], k[i] * k[i]);
                    ((eta - 1.0) * (eta - 1.0) + k) / ((eta + 1.0) * (eta + 1.0) + k)
                };
                let base = match self.value(params, "reflectance", "spectrum")? {
                    Some(value) => value,
                    None => Value::Constant([0, 1, 2].map(reflectance)),
                };
                params.ignore(&["thickness", "maxdepth", "nsamples"]);
                Principled {
                    base_color: base.color(),
                    metalness: 1.0.into(),
                    roughness: self.roughness(params, "conductor.", true)?,
                    coat: 1.0.into(),
                    coat_roughness: self.roughness(params, "interface.", true)?,
                    ior: self.ior(params, "interface.eta", 1.5)?.clamp(1.01, 10.0),
                    normal,
                    ..Principled::default()
                }
                .into()
            }
            "dielectric" => {
                let ior = self.ior(params, "eta", 1.5)?;
                let alpha = self.roughness(params, "", false)?;
                let smooth = matches!(alpha, Number::Value(alpha) if f64::from(alpha) < ROUGH);
                if smooth || (ior - 1.0).abs() < 0.01 {
                    Dielectric { normal, ..Dielectric::new(ior, Fresnel::Exact) }.into()
                } else {
                    RoughDielectric { normal, ..RoughDielectric::new(ior, alpha) }.into()
                }
            }
            "thindielectric" => Principled {
                base_color: [1.0; 3].into(),
                roughness: 0.0.into(),
                ior: of_both_faces(self.ior(params, "eta", 1.5)?),
                transmission: 1.0.into(),
                thin: true,
                normal,
                ..Principled::default()
            }
            .into(),
            "diffusetransmission" => {
                let reflectance =
                    self.value(params, "reflectance", "spectrum")?.unwrap_or(grey(0.25));
                let transmittance =
                    self.value(params, "transmittance", "spectrum")?.unwrap_or(grey(0.25));
                let scale = params.number("scale")?.unwrap_or(1.0).clamp(0.0, 1.0) as f32;
                let (reflectance, transmittance) =
                    limited(reflectance.color(), transmittance.color());
                let leaf = DiffuseTransmission::new(reflectance, transmittance);
                DiffuseTransmission { normal, scale, ..leaf }.into()
            }
            "mix" => return self.mixture(params),
            "hair" => {
                self.import.warn("hair is not supported, so it is matte");
                params.ignore(&[
                    "eumelanin",
                    "pheomelanin",
                    "sigma_a",
                    "color",
                    "reflectance",
                    "eta",
                    "beta_m",
                    "beta_n",
                    "alpha",
                ]);
                Lambertian::new([0.2, 0.1, 0.05]).into()
            }
            _ => {
                self.import
                    .warn(format!("the material {class} is not supported, so it is matte grey"));
                params.ignore_all();
                Lambertian::new([0.5; 3]).into()
            }
        })
    }

    fn conductor(
        &mut self,
        params: &Params,
        normal: Option<TextureRef>,
    ) -> Result<Material, String> {
        let reflectance = self.value(params, "reflectance", "spectrum")?;
        let [eta, k] = match reflectance {
            None => self.indices(params, "")?,
            // An index without imaginary part would not reflect enough, so pbrt sets eta to 1.
            Some(Value::Constant(color)) => {
                let color = color.map(|c| c.clamp(0.0, 0.9999));
                [[1.0; 3], color.map(|c| 2.0 * (c / (1.0 - c)).sqrt())]
            }
            Some(texture) => {
                return Ok(Principled {
                    base_color: texture.color(),
                    metalness: 1.0.into(),
                    roughness: self.roughness(params, "", true)?,
                    normal,
                    ..Principled::default()
                }
                .into());
            }
        };
        let alpha = self.roughness(params, "", false)?;
        let index = |index: [f64; 3], least| index.map(|c| c.clamp(least, 100.0) as f32);
        Ok(Conductor { normal, ..Conductor::new(index(eta, 0.0), index(k, 0.001), alpha) }.into())
    }

    /// The parameters `eta` and `k`, by default those of copper.
    fn indices(&mut self, params: &Params, prefix: &str) -> Result<[[f64; 3]; 2], String> {
        let mut index = |name: &str, usual| match params.find(&format!("{prefix}{name}")) {
            None => Ok(usual),
            Some(param) => self.spectrum(param),
        };
        let eta = index("eta", [0.200438, 0.924033, 1.102212])?;
        Ok([eta, index("k", [3.912949, 2.452848, 2.142188])?])
    }

    /// An index of refraction that does not depend on the wavelength.
    fn ior(&mut self, params: &Params, name: &str, usual: f64) -> Result<f32, String> {
        let Some(param) = params.find(name) else { return Ok(usual as f32) };
        let rgb = self.spectrum(param)?;
        if rgb[0] != rgb[2] {
            self.import.warn("dispersion is not supported, so glass has its index for green light");
        }
        Ok(rgb[1].clamp(0.01, 100.0) as f32)
    }

    /// The roughness: the GGX α, or with `root` its square root.
    fn roughness(&mut self, params: &Params, prefix: &str, root: bool) -> Result<Number, String> {
        let mut own = |name: &str| self.value(params, &format!("{prefix}{name}"), "float");
        let both = own("roughness")?;
        let (u, v) = (own("uroughness")?, own("vroughness")?);
        if let (Some(Value::Constant(u)), Some(Value::Constant(v))) = (&u, &v)
            && u != v
        {
            self.import.warn("anisotropic roughness is not supported, so it is the mean of both");
        }
        let value = match (u, v) {
            (Some(Value::Constant(u)), Some(Value::Constant(v))) => {
                Value::number(0.5 * (u[0] + v[0]))
            }
            (u, v) => u.or(v).or(both).unwrap_or(Value::number(0.0)),
        };
        let remapped = params.flag("remaproughness")?.unwrap_or(true);
        // pbrt's α is the square root of the roughness.
        let alpha = |value: f64| if remapped { value.clamp(0.0, 1.0).sqrt() } else { value };
        let textured = matches!(value, Value::Texture { .. });
        if textured && (root || remapped) {
            self.import.warn(NO_ROOT);
        }
        Ok(value
            .mapped(|value| if root { alpha(value).clamp(0.0, 1.0).sqrt() } else { alpha(value) }))
    }

    /// The larger part of a mixture of two materials, which may be mixtures.
    fn mixture(&mut self, params: &Params) -> Result<Material, String> {
        self.import.warn("mixtures of materials are not supported, so the larger part is used");
        let mut part = self.larger_part(params)?;
        for _ in 0..MAX_MIXTURES {
            if part.class != "mix" {
                return self.material(&part);
            }
            part = self.larger_part(&part.params)?;
        }
        Err("the mixture contains itself, or too many others".to_owned())
    }

    fn larger_part(&mut self, params: &Params) -> Result<Rc<Definition>, String> {
        let amount = self.value(params, "amount", "float")?.unwrap_or(Value::number(0.5));
        let second = matches!(amount, Value::Constant([amount, ..]) if amount > 0.5);
        let names = params.texts("materials")?;
        let name = names.get(usize::from(second)).ok_or("`materials` must be two names")?;
        let definition = self.materials.named.get(name);
        definition.cloned().ok_or_else(|| format!("unknown material \"{name}\""))
    }

    /// Glass filled with a medium that absorbs light.
    fn absorbing(&mut self, glass: Material, medium: &str) -> Result<Material, String> {
        let medium = self.medium(medium)?;
        let (ior, alpha, normal) = match &glass {
            Material::Dielectric(glass) => (glass.ior, 0.0.into(), glass.normal.clone()),
            Material::RoughDielectric(glass) => {
                (glass.ior, glass.alpha.clone(), glass.normal.clone())
            }
            _ => return Ok(glass),
        };
        if medium.scatters() {
            self.import.warn("glass cannot scatter light inside, so it only absorbs light");
        }
        let absorbed = medium.absorption;
        let largest = absorbed.into_iter().fold(0.0, |a, b| if a > b { a } else { b });
        if largest <= 0.0 {
            return Ok(glass);
        }
        let roughness = match alpha {
            Number::Value(alpha) => alpha.sqrt().into(),
            texture => {
                self.import.warn(NO_ROOT);
                texture
            }
        };
        // The distance at which the strongest absorption leaves 1/e.
        let color = absorbed.map(|sigma| crate::math::precise::exp(-sigma / largest) as f32);
        Ok(Principled {
            base_color: [1.0; 3].into(),
            roughness,
            ior: ior.clamp(1.01, 10.0),
            transmission: 1.0.into(),
            attenuation_color: color,
            attenuation_distance: (1.0 / largest) as f32,
            normal,
            ..Principled::default()
        }
        .into())
    }
}

/// Colours whose sum does not exceed 1, if both are constants.
fn limited(reflectance: Color, transmittance: Color) -> (Color, Color) {
    let (Color::Rgb(a), Color::Rgb(b)) = (&reflectance, &transmittance) else {
        return (reflectance, transmittance);
    };
    let share = |i: usize| 1.0 / if a[i] + b[i] > 1.0 { a[i] + b[i] } else { 1.0 };
    let shares = [share(0), share(1), share(2)];
    let scaled = |color: &[f32; 3]| Color::Rgb([0, 1, 2].map(|i| color[i] * shares[i] * 0.999_999));
    if shares == [1.0; 3] { (reflectance, transmittance) } else { (scaled(a), scaled(b)) }
}
