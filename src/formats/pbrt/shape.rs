//! Shapes of pbrt files.

use glam::DAffine3;

use super::light::{AreaLight, LitSurface};
use super::list::{List, corners, disk, globe, vertices};
use super::parallelogram::parallelogram;
use super::{Params, Reader, Value, rounded, uniform_scale};
use crate::math::affine::rows;
use crate::math::precise::unit;
use crate::scene::{MeshFile, PrimitiveFile, QuadFile, SphereFile, TrianglesFile};
use crate::shading::MediumFile;

impl Reader<'_, '_> {
    /// The directive `Shape`.
    pub(crate) fn shape(&mut self, class: &str, params: &Params) -> Result<(), String> {
        self.shape = self.import.number();
        let alpha = self.value(params, "alpha", "float")?;
        let alpha =
            alpha.filter(|alpha| !matches!(alpha, Value::Constant([alpha, ..]) if *alpha >= 1.0));
        let light = self.state.area_light.clone();
        if class == "sphere" && self.state.material.is_invisible() && light.is_none() {
            return self.filled_ball(params);
        }
        let material = match &light {
            None => self.current_material(alpha.as_ref())?,
            Some(light) => {
                let surface = self.lit_surface(alpha.as_ref())?;
                Some(self.area_light(light, class, params, surface)?)
            }
        };
        let Some(material) = material else {
            self.import.warn(
                "volumes other than spheres are not supported, so surfaces without a material are left out",
            );
            return Ok(());
        };
        match class {
            "plymesh" => self.ply_mesh(params, material)?,
            "sphere" => self.sphere(params, material, alpha.is_some())?,
            _ => match self.list(class, params)? {
                Some(list) => self.add_list(list, material)?,
                None => {
                    let message = format!("the shape {class} is not supported, so it is left out");
                    self.import.warn(message);
                    return Ok(());
                }
            },
        }
        self.warn_unused(params, &format!("the shape {class}"));
        Ok(())
    }

    fn add(&mut self, primitive: impl Into<PrimitiveFile>) {
        match &mut self.object {
            Some((_, parts)) => parts.push(primitive.into()),
            None => self.scene.add(primitive),
        }
    }

    fn ply_mesh(&mut self, params: &Params, material: String) -> Result<(), String> {
        let file = params.text("filename")?.ok_or("a plymesh needs a `filename`")?.to_owned();
        if self.state.reversed {
            self.import.warn("ReverseOrientation is not supported for files, so their front stays");
        }
        if self.import.is_usable(&file, "so it is left out") {
            let mut mesh = MeshFile::new(file, material);
            if self.placed() != DAffine3::IDENTITY {
                mesh.matrix = Some(rows(&self.placed()));
            }
            self.add(mesh);
        }
        Ok(())
    }

    fn sphere(&mut self, params: &Params, material: String, has_alpha: bool) -> Result<(), String> {
        let radius = params.number("radius")?.unwrap_or(1.0);
        if self.state.reversed && self.state.area_light.is_some() {
            self.import
                .warn("lights on the inside of spheres are not supported, so they shine outwards");
        }
        if params.unused().any(|name| ["zmin", "zmax", "phimax"].contains(&name)) {
            params.ignore(&["zmin", "zmax", "phimax"]);
            self.import.warn("parts of spheres are not supported, so spheres are whole");
        }
        // Only triangles may be instanced or have opacity, and our spheres have other poles than pbrt's.
        let needs_triangles =
            has_alpha || self.object.is_some() || self.materials.textured.contains(&material);
        match self.ball(radius) {
            Some((center, radius)) if !needs_triangles => {
                self.add(SphereFile { center, radius, material });
                Ok(())
            }
            _ => {
                self.import.warn("spheres that are stretched, textured, in objects or with alpha become 8192 triangles");
                self.add_list(globe(radius), material)
            }
        }
    }

    /// From the coordinates of lights and instances to the scene.
    pub(crate) fn to_scene(&self) -> DAffine3 {
        DAffine3::from_translation(-self.import.origin) * self.state.transform
    }

    /// From the coordinates of shapes to the scene, or to the object that is being defined.
    fn placed(&self) -> DAffine3 {
        if self.object.is_some() { self.state.transform } else { self.to_scene() }
    }

    /// Centre and radius of a sphere in the scene; `None` if it is stretched.
    fn ball(&self, radius: f64) -> Option<([f32; 3], f32)> {
        let scale = uniform_scale(&self.state.transform)?;
        Some((rounded(self.placed().translation), (radius * scale) as f32))
    }

    /// A sphere without a material, which is the boundary of a medium.
    fn filled_ball(&mut self, params: &Params) -> Result<(), String> {
        let radius = params.number("radius")?.unwrap_or(1.0);
        let Some(inside) = self.state.inside.clone() else { return Ok(()) };
        let (density, albedo) = self.medium(&inside)?.mean();
        match self.ball(radius) {
            Some((center, radius)) if self.object.is_none() => {
                self.scene.media.push(MediumFile::Ball { center, radius, density, albedo });
            }
            _ => self.import.warn(
                "volumes that are stretched or in objects are not supported, so they are left out",
            ),
        }
        Ok(())
    }

    /// The triangles of a shape; `None` for shapes that ptfast lacks.
    fn list(&mut self, class: &str, params: &Params) -> Result<Option<List>, String> {
        Ok(Some(match class {
            "trianglemesh" | "loopsubdiv" => {
                if class == "loopsubdiv" {
                    self.import
                        .warn("subdivision is not supported, so surfaces keep their triangles");
                    params.ignore(&["levels", "scheme"]);
                }
                params.ignore(&["S", "faceIndices"]);
                let mut list = vertices(params)?;
                list.indices = match params.tuples::<3>("indices")? {
                    Some(indices) => indices.into_iter().map(corners).collect::<Result<_, _>>()?,
                    None if list.positions.len() == 3 => vec![[0, 1, 2]],
                    None => return Err(format!("a {class} needs `indices`")),
                };
                list
            }
            "bilinearmesh" => {
                let mut list = vertices(params)?;
                let quads = match params.tuples::<4>("indices")? {
                    Some(indices) => indices.into_iter().map(corners).collect::<Result<_, _>>()?,
                    None if list.positions.len() == 4 => vec![[0, 1, 2, 3]],
                    None => return Err("a bilinearmesh needs `indices`".to_owned()),
                };
                list.indices =
                    quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, d], [a, d, c]]).collect();
                list
            }
            "disk" => {
                let (height, radius) = (
                    params.number("height")?.unwrap_or(0.0),
                    params.number("radius")?.unwrap_or(1.0),
                );
                if params.unused().any(|name| ["innerradius", "phimax"].contains(&name)) {
                    params.ignore(&["innerradius", "phimax"]);
                    self.import.warn("parts of disks are not supported, so disks are whole");
                }
                disk(height, radius)
            }
            _ => return Ok(None),
        }))
    }

    /// Adds triangles, placed by the current transform.
    fn add_list(&mut self, list: List, material: String) -> Result<(), String> {
        self.import.budget.hold_list(list.positions.len(), list.indices.len())?;
        let (transform, reversed) = (self.placed(), &self.state.reversed);
        let inverse = transform.matrix3.inverse().transpose();
        let List { positions, normals, uvs, mut indices } = list;
        let mirrored = transform.matrix3.determinant() < 0.0;
        // If there are normals, the front is where they point, as in pbrt.
        let agrees = |&[a, b, c]: &[u32; 3]| {
            let at = |i: u32| positions.get(i as usize).copied().unwrap_or_default();
            let normal = |i: u32| normals.get(i as usize).copied().unwrap_or_default();
            let face = (at(b) - at(a)).cross(at(c) - at(a));
            face.dot(normal(a) + normal(b) + normal(c)) >= 0.0
        };
        for face in &mut indices {
            if (agrees(face) != mirrored) == *reversed {
                face.swap(1, 2);
            }
        }
        let side = if *reversed { -1.0 } else { 1.0 };
        let vertices: Vec<_> =
            positions.iter().map(|p| rounded(transform.transform_point3(*p))).collect();
        // Light samples of a quad are better distributed than those of two triangles. Objects may hold
        // triangles only, and quads have other texture coordinates.
        if self.state.area_light.is_some()
            && self.object.is_none()
            && !self.materials.textured.contains(&material)
            && let Some([q, u, v]) = parallelogram(&vertices, &indices)
        {
            self.add(QuadFile { q, u, v, material });
            return Ok(());
        }
        let triangles = TrianglesFile {
            normals: normals.iter().map(|n| rounded(unit(inverse * *n) * side)).collect(),
            uvs: uvs.iter().map(|uv| uv.as_vec2().to_array()).collect(),
            number: Some(self.shape),
            ..TrianglesFile::new(vertices, indices, material)
        };
        self.add(triangles);
        Ok(())
    }

    /// The name of a material for `light` on a shape.
    fn area_light(
        &mut self,
        light: &AreaLight,
        class: &str,
        params: &Params,
        surface: Option<LitSurface>,
    ) -> Result<String, String> {
        let area = match light.power {
            None => 1.0,
            Some(_) => self.mean_area(class, params)?,
        };
        Ok(self.light_material(light, area, surface))
    }

    /// The area of a shape, or the mean area of its triangles or patches, each of which is a light in pbrt.
    fn mean_area(&mut self, class: &str, params: &Params) -> Result<f64, String> {
        let scale = self.state.transform;
        let area = |list: &List, [a, b, c]: [u32; 3]| {
            let at = |i: u32| {
                let point = list.positions.get(i as usize).copied().unwrap_or_default();
                scale.transform_point3(point)
            };
            let cross = (at(b) - at(a)).cross(at(c) - at(a));
            0.5 * cross.dot(cross).sqrt()
        };
        let list = match class {
            "sphere" => Some(globe(params.number("radius")?.unwrap_or(1.0))),
            _ => self.list(class, params)?,
        };
        let Some(list) = list else {
            self.import
                .warn("the power of lights in files is not supported, so their area counts as 1");
            return Ok(1.0);
        };
        let all: f64 = list.indices.iter().map(|face| area(&list, *face)).sum();
        let lights = match class {
            "sphere" | "disk" => 1,
            // Two triangles stand for each patch.
            "bilinearmesh" => list.indices.len() / 2,
            _ => list.indices.len(),
        };
        Ok(all / lights.max(1) as f64)
    }
}
