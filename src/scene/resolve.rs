//! From what a file says to a scene that can be rendered: every number checked, every
//! name looked up.

use std::path::Path;

use glam::{DVec3, Vec3};

use super::camera::Camera;
use super::description::{
    Albedo, BackgroundFile, CameraFile, MaterialFile, PrimitiveFile, SceneFile, TextureFile,
};
use super::light::Lights;
use super::material::{Background, Emission, Material};
use super::medium::Medium;
use super::mesh::{Mesh, Placement};
use super::place::{Element, MAX_COORDINATE, MAX_RADIANCE, Places};
use super::texture::{Checker, Texture};
use super::{Scene, boxes};
use crate::error::{Result, suggestion};
use crate::geometry::{Geometry, Quad, Sphere, Triangle};
use crate::image::Image;
use crate::limits::{MAX_MEDIA, MAX_PRIMITIVES};

/// The scene that `file` describes. `name` is what errors call it, `folder` is where its
/// textures are.
pub(super) fn resolve(
    name: &str,
    folder: &Path,
    file: &SceneFile,
    places: &Places,
) -> Result<Scene> {
    let resolver = Resolver { name, file, places };
    let camera = resolver.camera(&file.camera)?;
    let background = resolver.background()?;
    resolver.render_defaults()?;
    let mut textures = resolver.textures(folder)?;
    let materials = resolver.materials(&mut textures)?;
    let (geometry, material_of) = resolver.primitives(folder)?;
    let media = resolver.media()?;
    let lights = Lights::new(&geometry, &materials, &material_of);
    Ok(Scene {
        name: name.to_owned(),
        camera,
        background,
        defaults: file.render.clone(),
        textures,
        materials,
        geometry,
        material_of,
        lights,
        media,
    })
}

struct Resolver<'a> {
    name: &'a str,
    file: &'a SceneFile,
    places: &'a Places,
}

impl<'a> Resolver<'a> {
    fn element(&self, place: String, kind: &'a str) -> Element<'a> {
        Element { file: self.name, place, kind }
    }

    fn camera(&self, camera: &CameraFile) -> Result<Camera> {
        let e = self.element(Places::section(self.places.camera), "camera");
        let from = e.point("look_from", camera.look_from)?.as_dvec3();
        let at = e.point("look_at", camera.look_at)?.as_dvec3();
        let up = e.point("up", camera.up)?.as_dvec3();
        let (vfov, defocus) = (camera.vfov, camera.defocus_angle);
        e.check(vfov > 0.0 && vfov < 180.0, "vfov", "in (0, 180) degrees", vfov)?;
        let defocus_ok = (0.0..180.0).contains(&defocus);
        e.check(defocus_ok, "defocus_angle", "in [0, 180) degrees", defocus)?;
        let focus = camera.focus_distance;
        let focus_ok = focus > 0.0 && focus <= MAX_COORDINATE;
        e.check(focus_ok, "focus_distance", "above 0 and at most 1e9", focus)?;
        let (open, close) = camera.shutter;
        let shutter_ok = (0.0..=close).contains(&open) && close <= 1.0;
        e.check(shutter_ok, "shutter", "two times with 0 <= open <= close <= 1", (open, close))?;
        let unit = |v: DVec3| v / v.dot(v).sqrt();
        let back = unit(from - at);
        if !back.is_finite() {
            return Err(e.error("look_from and look_at must differ, the camera looks at itself"));
        }
        let right = up.cross(back);
        if !(right.dot(right) > 1e-12 * up.dot(up)) {
            return Err(e.error("up must not be zero or parallel to the view direction"));
        }
        let right = unit(right);
        Ok(Camera {
            look_from: from,
            frame: [right, back.cross(right), back],
            vfov: f64::from(vfov),
            defocus_angle: f64::from(defocus),
            focus_distance: f64::from(focus),
            shutter: camera.shutter,
        })
    }

    fn background(&self) -> Result<Background> {
        let e = self.element(Places::section(self.places.background), "background");
        Ok(match self.file.background {
            BackgroundFile::Constant { radiance } => {
                Background::Constant(e.color("radiance", radiance, MAX_RADIANCE)?)
            }
            BackgroundFile::Gradient { bottom, top } => Background::Gradient {
                bottom: e.color("bottom", bottom, MAX_RADIANCE)?,
                top: e.color("top", top, MAX_RADIANCE)?,
            },
        })
    }

    fn render_defaults(&self) -> Result<()> {
        let render = &self.file.render;
        crate::limits::check_image(render.width, render.height)
            .and_then(|()| crate::limits::check_sampling(render.spp, render.depth))
            .map_err(|message| {
                self.element(Places::section(self.places.render), "render").error(message)
            })
    }

    fn textures(&self, folder: &Path) -> Result<Vec<Texture>> {
        let resolve = |(name, texture): &(String, TextureFile)| {
            let e = self.element(self.places.texture(name), "texture");
            Ok(match texture {
                TextureFile::Solid { color } => Texture::Solid(e.color("color", *color, 1.0)?),
                TextureFile::Checker { odd, even, scale } => {
                    let range = "above 0 and at most 1e6";
                    e.check(*scale > 0.0 && *scale <= 1e6, "scale", range, scale)?;
                    let (odd, even) = (e.color("odd", *odd, 1.0)?, e.color("even", *even, 1.0)?);
                    Texture::Checker(Checker::new(odd, even, *scale))
                }
                TextureFile::Image { file } => {
                    let image = Image::read(&folder.join(file)).map_err(|error| e.error(error))?;
                    if let Some(bad) =
                        image.pixels().iter().find(|p| p.iter().any(|c| !(0.0..=1.0).contains(c)))
                    {
                        return Err(e.error(format!(
                            "{file}: an albedo must be in [0, 1], a pixel is {bad:?}"
                        )));
                    }
                    Texture::Image(image)
                }
            })
        };
        self.file.textures.0.iter().map(resolve).collect()
    }

    /// Colours given in place of a texture are appended to `textures`.
    fn materials(&self, textures: &mut Vec<Texture>) -> Result<Vec<Material>> {
        let mut materials = Vec::new();
        let names: std::collections::HashMap<&str, u32> =
            self.file.textures.names().zip(0..).collect();
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

    /// Checks that no media overlap.
    fn media(&self) -> Result<Vec<Medium>> {
        let mut media: Vec<Medium> = Vec::new();
        for (index, file) in self.file.media.iter().enumerate() {
            let e = self.element(format!("media[{index}]"), "medium");
            if index >= MAX_MEDIA {
                return Err(e.error(format!("a scene can have {MAX_MEDIA} media at most")));
            }
            let medium = Medium::new(&e, file)?;
            if let Some(other) =
                media.iter().position(|other| other.volume.overlaps(&medium.volume))
            {
                return Err(
                    e.error(format!("overlaps media[{other}]: media must lie side by side"))
                );
            }
            media.push(medium);
        }
        Ok(media)
    }

    /// The primitives, and the material of each in their order.
    fn primitives(&self, folder: &Path) -> Result<(Geometry, Vec<u32>)> {
        let mut geometry = Geometry::default();
        let mut materials = [const { Vec::new() }; 3];
        let names: std::collections::HashMap<&str, u32> =
            self.file.materials.names().zip(0..).collect();
        for (index, primitive) in self.file.primitives.iter().enumerate() {
            let (kind, material) = primitive.kind_and_material();
            let e = self.element(self.places.primitive(index), kind);
            let material = *names.get(material).ok_or_else(|| {
                let known = self.file.materials.names();
                e.error(format!("unknown material `{material}`{}", suggestion(material, known)))
            })?;
            add(&e, folder, primitive, &mut geometry)?;
            if geometry.len() > MAX_PRIMITIVES {
                return Err(
                    e.error(format!("a scene can have {MAX_PRIMITIVES} primitives at most"))
                );
            }
            let counts = [geometry.spheres.len(), geometry.quads.len(), geometry.triangles.len()];
            for (list, count) in materials.iter_mut().zip(counts) {
                list.resize(count, material);
            }
        }
        Ok((geometry, materials.concat()))
    }
}

/// Checks one primitive and appends what it stands for.
fn add(
    e: &Element<'_>,
    folder: &Path,
    primitive: &PrimitiveFile,
    geometry: &mut Geometry,
) -> Result<()> {
    let radius_of = |radius: f32| {
        let ok = radius > 0.0 && radius <= MAX_COORDINATE;
        e.check(ok, "radius", "above 0 and at most 1e9", radius).map(|()| radius)
    };
    let quad = |q, u, v| {
        Quad::new(q, u, v).ok_or_else(|| {
            e.error("the edges must span an area, they are zero or (all but) parallel")
        })
    };
    match primitive {
        PrimitiveFile::Sphere { center, radius, .. } => {
            let center = e.point("center", *center)?;
            geometry.spheres.push(Sphere::still(center, radius_of(*radius)?));
        }
        PrimitiveFile::MovingSphere { center, center1, radius, .. } => {
            let center = e.point("center", *center)?;
            let center1 = e.point("center1", *center1)?;
            geometry.spheres.push(Sphere { center, center1, radius: radius_of(*radius)? });
        }
        PrimitiveFile::Quad { q, u, v, .. } => {
            geometry.quads.push(quad(e.point("q", *q)?, e.point("u", *u)?, e.point("v", *v)?)?);
        }
        PrimitiveFile::Box { min, max, rotation, .. } => {
            e.bounds(*min, *max)?;
            e.rotation(*rotation)?;
            for (q, u, v) in boxes::faces(*min, *max, *rotation) {
                geometry.quads.push(quad(q.into(), u.into(), v.into())?);
            }
        }
        PrimitiveFile::Mesh { file, scale, rotation, translation, .. } => {
            let ok = *scale > 0.0 && *scale <= MAX_COORDINATE;
            e.check(ok, "scale", "above 0 and at most 1e9", scale)?;
            e.rotation(*rotation)?;
            e.point("translation", *translation)?;
            let (scale, rotation, translation) = (*scale, *rotation, *translation);
            let mesh = Mesh::read(&folder.join(file)).map_err(|error| e.error(error))?;
            let placed = mesh.place(&Placement { scale, rotation, translation });
            let placed = placed.map_err(|message| e.error(format!("{file}: {message}")))?;
            geometry.triangles.extend(placed);
        }
        PrimitiveFile::Triangles { vertices, indices, .. } => {
            for (i, vertex) in vertices.iter().enumerate() {
                e.point(&format!("vertices[{i}]"), *vertex)?;
            }
            for (i, corner) in indices.iter().enumerate() {
                let vertex = |k: u32| vertices.get(k as usize).map(|v| Vec3::from_array(*v));
                let [Some(a), Some(b), Some(c)] = corner.map(vertex) else {
                    return Err(e.error(format!(
                        "indices[{i}] must be below the number of vertices {}, is {corner:?}",
                        vertices.len()
                    )));
                };
                let triangle = Triangle { vertices: [a, b, c] };
                // Meshes have some; they have no normal.
                if !triangle.is_degenerate() {
                    geometry.triangles.push(triangle);
                }
            }
        }
    }
    Ok(())
}
