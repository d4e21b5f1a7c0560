//! Scenes of glTF 2.0 (<https://registry.khronos.org/glTF>).
//!
//! A mesh that is placed once becomes triangles of the scene, one that is placed more often becomes a
//! named mesh with instances.

mod file;
mod light;
mod material;
mod mesh;
mod pose;
mod texture;
mod view;

use std::collections::{HashMap, HashSet};
use std::path::Path;

use glam::{DAffine3, DMat3, DQuat, DVec3};

pub(crate) use self::file::Gltf;
use self::file::{Camera, SUPPORTED};
use self::pose::Pose;
use super::import::{Format, Import, Middle};
use super::view::{Extent, Z_UP};
use crate::error::{Error, Result};
use crate::geometry::{Bounds, Instance};
use crate::math::affine::{self, rows};
use crate::scene::{InstanceFile, SceneFile};
use crate::shading::CameraFile;

/// glTF 2.0.
pub(crate) static FORMAT: Format = Format { extensions: &["glb", "gltf"], read, middle: Middle::X };

/// Bytes of memory for each instance in a node: the place while the list grows, and the instance.
const INSTANCE: u64 = 500;

/// A mesh in a node.
struct Placement {
    node: usize,
    mesh: usize,
    /// From the mesh to the scene.
    map: DAffine3,
}

/// Builds the scene.
struct Reader<'i, 'a, 'g> {
    import: &'i mut Import<'a>,
    gltf: &'g Gltf<'a>,
    /// Name of the file.
    file: String,
    scene: SceneFile,
    pose: Pose,
    /// From each node of the scene to the scene.
    maps: HashMap<usize, DAffine3>,
    placements: Vec<Placement>,
    /// The names of the scene's materials, by number and by whether the mesh has colours.
    materials: HashMap<(Option<usize>, bool), String>,
    /// The names of the scene's materials and textures.
    names: HashSet<String>,
    textures: HashMap<String, String>,
    /// The number of the chosen variant.
    variant: Option<usize>,
    extent: Extent,
    has_camera: bool,
}

/// Reads the scene in `path`.
pub(crate) fn read(path: &Path, import: &mut Import<'_>) -> Result<SceneFile> {
    let bad = |message: String| Error::input(path.display().to_string(), "", message);
    let mut gltf = Gltf::read(path, import.budget)?;
    gltf.decompress().map_err(bad)?;
    let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut reader = Reader::new(import, &gltf, file).map_err(bad)?;
    reader.nodes().map_err(bad)?;
    reader.meshes().map_err(bad)?;
    reader.finish().map_err(bad)?;
    reader.warn_of_extensions();
    Ok(reader.scene)
}

/// The number of the variant that the options choose, or else of the first one, so that all files with
/// variants are shown with one.
fn variant(gltf: &Gltf<'_>, import: &mut Import<'_>) -> Result<Option<usize>, String> {
    let variants = &gltf.document.extensions.variants.variants;
    let Some(name) = &import.options.variant else {
        if !variants.is_empty() {
            let names: Vec<_> = variants.iter().take(10).map(|variant| &*variant.name).collect();
            import.note(format!(
                "is shown with the first variant of its materials; `--variant` chooses one: {}",
                names.join(", ")
            ));
        }
        return Ok((!variants.is_empty()).then_some(0));
    };
    let found = variants.iter().position(|variant| variant.name == *name);
    found.map(Some).ok_or_else(|| {
        let known = crate::error::suggestion(name, variants.iter().map(|variant| &*variant.name));
        format!("unknown variant `{name}`{known}")
    })
}

impl<'i, 'a, 'g> Reader<'i, 'a, 'g> {
    fn new(import: &'i mut Import<'a>, gltf: &'g Gltf<'a>, file: String) -> Result<Self, String> {
        Ok(Self {
            file,
            scene: SceneFile::new(CameraFile::new([0.0; 3], [0.0, 0.0, -1.0], 40.0)),
            pose: Pose::new(gltf, import)?,
            maps: HashMap::new(),
            placements: Vec::new(),
            materials: HashMap::new(),
            names: HashSet::new(),
            textures: HashMap::new(),
            variant: variant(gltf, import)?,
            extent: Extent::new(import.options.aspect()),
            has_camera: false,
            import,
            gltf,
        })
    }

    /// Visits all nodes of the scene.
    fn nodes(&mut self) -> Result<(), String> {
        let document = &self.gltf.document;
        let roots = match document.scenes.get(document.scene.unwrap_or(0)) {
            Some(scene) => scene.nodes.clone(),
            None => {
                let children: HashSet<_> =
                    document.nodes.iter().flat_map(|node| node.children.iter().copied()).collect();
                (0..document.nodes.len()).filter(|node| !children.contains(node)).collect()
            }
        };
        if document.scenes.len() > 1 {
            self.import.warn("only one of the scenes in the file is shown, the one that it names");
        }
        let turned = self.import.options.z_up;
        let root = if turned { DAffine3::from_mat3(Z_UP) } else { DAffine3::IDENTITY };
        let root = DAffine3::from_translation(-self.import.origin) * root;
        let mut open: Vec<_> = roots.into_iter().rev().map(|node| (node, root)).collect();
        while let Some((index, parent)) = open.pop() {
            let node = document.nodes.get(index).ok_or_else(|| format!("unknown node {index}"))?;
            let map = parent * self.pose.local(index, node);
            if self.maps.insert(index, map).is_some() {
                return Err(format!("the node {index} is reached twice, nodes must form a tree"));
            }
            open.extend(node.children.iter().rev().map(|&child| (child, map)));
        }
        let mut order: Vec<_> = self.maps.keys().copied().collect();
        order.sort_unstable();
        for index in order {
            self.node(index)?;
        }
        Ok(())
    }

    /// Adds the camera, the light and the mesh of a node.
    fn node(&mut self, index: usize) -> Result<(), String> {
        let (gltf, map) = (self.gltf, self.maps[&index]);
        let node = &gltf.document.nodes[index];
        // A scale of 0 hides a node.
        let hidden = map.matrix3 * DVec3::Z == DVec3::ZERO;
        if let Some(camera) = node.camera.filter(|_| !hidden) {
            let camera = gltf.document.cameras.get(camera);
            let camera = camera.ok_or_else(|| format!("the node {index} has an unknown camera"))?;
            self.camera(node.name.as_deref().or(camera.name.as_deref()), camera, &map)?;
        }
        if let Some(light) = node.extensions.light.as_ref().filter(|_| !hidden) {
            let lights = &gltf.document.extensions.lights.lights;
            let light = lights.get(light.light);
            self.light(
                light.ok_or_else(|| format!("the node {index} has an unknown light"))?,
                &map,
            );
        }
        let Some(mesh) = node.mesh else { return Ok(()) };
        if gltf.document.meshes.get(mesh).is_none() {
            return Err(format!("the node {index} has the unknown mesh {mesh}"));
        }
        match &node.extensions.instances {
            None => self.placements.push(Placement { node: index, mesh, map }),
            Some(instances) => {
                let attribute = |name: &str| instances.attributes.get(name).copied();
                let read = |name: &str| {
                    attribute(name).map(|accessor| gltf.vectors::<3>(accessor)).transpose()
                };
                let (translations, scales) = (read("TRANSLATION")?, read("SCALE")?);
                let rotations = attribute("ROTATION")
                    .map(|accessor| gltf.vectors::<4>(accessor))
                    .transpose()?;
                let counts = [
                    translations.as_ref().map(Vec::len),
                    rotations.as_ref().map(Vec::len),
                    scales.as_ref().map(Vec::len),
                ];
                let count = counts.into_iter().flatten().min().unwrap_or(0);
                gltf.budget.hold(INSTANCE * count as u64)?;
                for i in 0..count {
                    let translation = translations.as_ref().map(|list| list[i].map(f64::from));
                    let rotation = rotations.as_ref().map(|list| list[i].map(f64::from));
                    let scale = scales.as_ref().map(|list| list[i].map(f64::from));
                    let map = map * placed(translation, rotation, scale);
                    self.placements.push(Placement { node: index, mesh, map });
                }
            }
        }
        Ok(())
    }

    /// Adds a camera, which looks along the −z-axis of its node.
    fn camera(
        &mut self,
        name: Option<&str>,
        camera: &Camera,
        map: &DAffine3,
    ) -> Result<(), String> {
        let from = map.translation;
        let at = affine::point_along(from, -(map.matrix3 * DVec3::Z));
        let rounded = |v: DVec3| v.as_vec3().to_array();
        let mut file = CameraFile::new(rounded(from), at, 40.0);
        file.up = rounded(map.matrix3 * DVec3::Y);
        let aspect = match (&camera.perspective, &camera.orthographic) {
            (Some(perspective), _) => {
                file.vfov = perspective.yfov.to_degrees().clamp(0.01, 179.0) as f32;
                perspective.aspect_ratio
            }
            (None, Some(parallel)) => {
                file.vfov = 0.0;
                file.parallel = Some((2.0 * parallel.ymag.abs()).clamp(1e-6, 1e9) as f32);
                Some(parallel.xmag / parallel.ymag)
            }
            (None, None) => {
                return Err("a camera is neither perspective nor orthographic".to_owned());
            }
        };
        if !self.has_camera {
            self.has_camera = true;
            self.scene.camera = file.clone();
            if let Some(aspect) = aspect.filter(|aspect| (0.1..=10.0).contains(aspect)) {
                let render = &mut self.scene.render;
                render.height = (f64::from(render.width) / aspect).round() as u32;
            }
        }
        self.gltf.budget.hold(INSTANCE)?;
        let name = self.unique(name.unwrap_or("camera"), self.scene.cameras.0.len());
        self.scene.add_camera(name, file);
        Ok(())
    }

    /// Adds the triangles of all placements.
    fn meshes(&mut self) -> Result<(), String> {
        let mut counts: HashMap<usize, usize> = HashMap::new();
        for placement in &self.placements {
            *counts.entry(placement.mesh).or_default() += 1;
        }
        let mut named: HashMap<usize, Option<(String, Bounds)>> = HashMap::new();
        for Placement { node, mesh, map } in std::mem::take(&mut self.placements) {
            if !map.is_finite() {
                return Err(format!("the transform of the node {node} is not finite"));
            }
            let rows = rows(&map);
            let deformed = self.is_deformed(node, mesh);
            let placeable = Instance::new(0, &rows).is_ok();
            if counts[&mesh] == 1 || deformed || !placeable {
                for triangles in self.triangles(node, mesh, &map)? {
                    self.scene.add(triangles);
                }
                continue;
            }
            let name = match named.get(&mesh) {
                Some(known) => known.clone(),
                None => {
                    let (parts, bounds) = self.parts(node, mesh)?;
                    let fresh = !parts.is_empty();
                    let name = fresh.then(|| (self.add_named_mesh(mesh, parts), bounds));
                    named.insert(mesh, name.clone());
                    name
                }
            };
            if let Some((name, bounds)) = name {
                self.scene.add(InstanceFile::new(name, rows));
                self.cover(bounds, &map);
            }
        }
        Ok(())
    }

    /// Warns of extensions that ptfast lacks.
    fn warn_of_extensions(&mut self) {
        let instead = |name: &str| match name {
            "KHR_materials_iridescence" => "surfaces do not iridesce",
            "KHR_materials_dispersion" => "glass does not disperse light",
            "KHR_materials_pbrSpecularGlossiness" => {
                "such materials are white, unless the file also describes them in the usual way"
            }
            "KHR_animation_pointer" => "what it animates stands still",
            _ => "it has no effect",
        };
        // Textures whose only image is in that format have a warning of their own.
        let known = |name: &str| SUPPORTED.contains(&name) || name == "MSFT_texture_dds";
        for name in &self.gltf.document.extensions_used {
            if !known(name) {
                let message = format!("{name} is not supported, so {}", instead(name));
                self.import.warn(message);
            }
        }
    }
}

/// The map that scales, then rotates by a quaternion, then translates.
fn placed(
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
) -> DAffine3 {
    let [x, y, z, w] = rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let length = (x * x + y * y + z * z + w * w).sqrt();
    let turn = match length > 0.0 {
        true => DQuat::from_xyzw(x / length, y / length, z / length, w / length),
        false => DQuat::IDENTITY,
    };
    let scale = DMat3::from_diagonal(scale.map_or(DVec3::ONE, DVec3::from));
    DAffine3 {
        matrix3: DMat3::from_quat(turn) * scale,
        translation: translation.map_or(DVec3::ZERO, DVec3::from),
    }
}
