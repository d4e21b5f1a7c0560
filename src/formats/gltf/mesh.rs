//! Meshes of glTF files.

use std::mem::replace;

use glam::{DAffine3, DMat3, DVec3};

use super::Reader;
use super::file::{Attributes, Primitive};
use crate::formats::import::unique;
use crate::formats::view::Extent;
use crate::geometry::Bounds;
use crate::math::affine;
use crate::math::precise::unit;
use crate::scene::{PrimitiveFile, TrianglesFile};

/// The vertices and triangles of a part of a mesh.
struct MeshPrimitive {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    tangents: Vec<DVec3>,
    uvs: Vec<[f32; 2]>,
    second_uvs: Vec<[f32; 2]>,
    colors: Vec<[f32; 3]>,
    faces: Vec<[u32; 3]>,
}

impl Reader<'_, '_, '_> {
    /// Whether the mesh depends on its node, by a skin or by morph targets.
    pub(crate) fn is_deformed(&self, node: usize, mesh: usize) -> bool {
        let document = &self.gltf.document;
        let morphs = document.meshes[mesh].primitives.iter().any(|part| !part.targets.is_empty());
        document.nodes[node].skin.is_some() || morphs
    }

    /// The triangles of a mesh, placed by `map`.
    pub(crate) fn triangles(
        &mut self,
        node: usize,
        mesh: usize,
        map: &DAffine3,
    ) -> Result<Vec<TrianglesFile>, String> {
        let gltf = self.gltf;
        let mut all = Vec::new();
        for (i, primitive) in gltf.document.meshes[mesh].primitives.iter().enumerate() {
            let part = self.part(node, mesh, primitive);
            let part =
                part.map_err(|message| format!("meshes[{mesh}].primitives[{i}]: {message}"))?;
            let Some(part) = part else { continue };
            let material = self.material_of(primitive, !part.colors.is_empty())?;
            // A skin places its vertices itself.
            let skinned = gltf.document.nodes[node].skin.is_some();
            let map = if skinned { &DAffine3::IDENTITY } else { map };
            all.push(self.placed(part, map, material));
        }
        Ok(all)
    }

    /// The parts of a mesh that instances place, and its box.
    pub(crate) fn parts(
        &mut self,
        node: usize,
        mesh: usize,
    ) -> Result<(Vec<PrimitiveFile>, Bounds), String> {
        let empty = Extent::new(self.import.options.aspect());
        let before = replace(&mut self.extent, empty);
        let parts = self.triangles(node, mesh, &DAffine3::IDENTITY)?;
        let own = replace(&mut self.extent, before);
        Ok((parts.into_iter().map(PrimitiveFile::from).collect(), own.bounds))
    }

    /// Adds a named mesh, and returns its name.
    pub(crate) fn add_named_mesh(&mut self, mesh: usize, parts: Vec<PrimitiveFile>) -> String {
        let own = self.gltf.document.meshes[mesh].name.clone().unwrap_or_else(|| "mesh".to_owned());
        let name = self.unique(&own, mesh);
        self.scene.add_named_mesh(name.clone(), parts);
        name
    }

    /// A name like `own` that is not used yet. `number` is that of the element.
    pub(crate) fn unique(&mut self, own: &str, number: usize) -> String {
        unique(&mut self.names, own, number)
    }

    /// The extent of the mesh in a node with this map.
    pub(crate) fn reach(&mut self, node: usize, mesh: usize, map: &DAffine3) -> Result<(), String> {
        let gltf = self.gltf;
        let skinned = gltf.document.nodes[node].skin.is_some();
        let map = if skinned { &DAffine3::IDENTITY } else { map };
        for primitive in &gltf.document.meshes[mesh].primitives {
            if let Some(part) = self.part(node, mesh, primitive)? {
                self.extent.add(part.positions.iter().map(|&p| map.transform_point3(p).as_vec3()));
            }
        }
        Ok(())
    }

    /// Includes an instance of a mesh with this box in the bounds of the scene.
    pub(crate) fn cover(&mut self, Bounds { min, max }: Bounds, map: &DAffine3) {
        let corner = |i: u32| {
            let pick = |axis: usize| if i >> axis & 1 == 0 { min[axis] } else { max[axis] };
            let corner = DVec3::new(pick(0).into(), pick(1).into(), pick(2).into());
            map.transform_point3(corner).as_vec3()
        };
        self.extent.add((0..8).map(corner));
    }

    /// Reads a part of a mesh, and deforms it. `None` for parts that are not triangles.
    fn part(
        &mut self,
        node: usize,
        mesh: usize,
        primitive: &Primitive,
    ) -> Result<Option<MeshPrimitive>, String> {
        let attributes = Attributes::new(self.gltf, primitive)?;
        let Some(positions) = attributes.vectors::<3>("POSITION")? else {
            self.import.warn("parts of meshes without positions are left out");
            return Ok(None);
        };
        let count = positions.len();
        let (indices, mode) = attributes.indices(count)?;
        let Some(faces) = self.faces(indices, mode, count)? else { return Ok(None) };
        self.gltf.budget.hold_list(count, faces.len())?;
        let same = |name: &str, length: usize| match [0, count].contains(&length) {
            true => Ok(()),
            false => Err(format!("{name} has {length} elements, but there are {count} positions")),
        };
        let pairs = |name: &str| -> Result<Vec<[f32; 2]>, String> {
            let uvs = attributes.vectors::<2>(name)?.unwrap_or_default();
            same(name, uvs.len())?;
            // In glTF, v = 0 is the top of the image.
            Ok(uvs.into_iter().map(|[u, v]| [u, 1.0 - v]).collect())
        };
        let triples = |name: &str| -> Result<Vec<[f32; 3]>, String> {
            let vectors = attributes.vectors::<3>(name)?.unwrap_or_default();
            same(name, vectors.len()).map(|()| vectors)
        };
        let wide = |list: Vec<[f32; 3]>| list.into_iter().map(|v| DVec3::from(v.map(f64::from)));
        let colors = triples("COLOR_0")?.into_iter().map(|color| color.map(|c| c.clamp(0.0, 1.0)));
        let material = primitive.material.and_then(|i| self.gltf.document.materials.get(i));
        // Colours without alpha have three parts, which gives an error.
        if material.is_some_and(|material| material.alpha_mode() != "OPAQUE")
            && let Ok(Some(colors)) = attributes.vectors::<4>("COLOR_0")
            && colors.iter().any(|color| color[3] < 0.999)
        {
            self.import.warn("alpha of vertex colours is not supported, so it has no effect");
        }
        let normals: Vec<_> = wide(triples("NORMAL")?).collect();
        let uvs = pairs("TEXCOORD_0")?;
        let tangents = match normals.is_empty() || uvs.is_empty() {
            true => Vec::new(),
            false => self.tangents(&attributes, count),
        };
        let mut part = MeshPrimitive {
            positions: wide(positions).collect(),
            normals,
            tangents,
            uvs,
            second_uvs: pairs("TEXCOORD_1")?,
            colors: colors.collect(),
            faces,
        };
        self.morph(node, mesh, primitive, &mut part)?;
        self.skin(node, &attributes, &mut part)?;
        Ok(Some(part))
    }

    /// The tangents of a part, or none if the file has none that can be used. The side of the bitangent,
    /// the fourth number, follows from the texture coordinates.
    fn tangents(&mut self, attributes: &Attributes<'_, '_>, count: usize) -> Vec<DVec3> {
        let tangents = match attributes.vectors::<4>("TANGENT") {
            Ok(None) => return Vec::new(),
            Ok(Some(tangents)) => tangents,
            Err(_) => Vec::new(),
        };
        let tangents =
            tangents.into_iter().map(|[x, y, z, _]| DVec3::from([x, y, z].map(f64::from)));
        let tangents: Vec<_> = tangents.filter(|tangent| *tangent != DVec3::ZERO).collect();
        if tangents.len() == count {
            return tangents;
        }
        self.import
            .warn("some tangents are missing, 0 or not finite, so all of their part are computed");
        Vec::new()
    }

    /// The triangles of a part; `None` for points and lines.
    fn faces(
        &mut self,
        indices: Vec<u32>,
        mode: u32,
        count: usize,
    ) -> Result<Option<Vec<[u32; 3]>>, String> {
        if ![4, 5, 6].contains(&mode) {
            self.import.warn("points and lines are not supported, so they are left out");
            return Ok(None);
        }
        if let Some(index) = indices.iter().find(|&&index| index as usize >= count) {
            return Err(format!("the index {index} is beyond the {count} vertices"));
        }
        let triple = |window: &[u32]| [window[0], window[1], window[2]];
        let faces = match mode {
            4 => indices.as_chunks::<3>().0.to_vec(),
            5 => {
                let turned = |(i, [a, b, c]): (usize, [u32; 3])| {
                    if i % 2 == 0 { [a, b, c] } else { [b, a, c] }
                };
                indices.windows(3).map(triple).enumerate().map(turned).collect()
            }
            _ => indices.windows(2).skip(1).map(|edge| [indices[0], edge[0], edge[1]]).collect(),
        };
        Ok(Some(faces))
    }

    /// Moves the vertices of a part by its morph targets.
    fn morph(
        &mut self,
        node: usize,
        mesh: usize,
        primitive: &Primitive,
        part: &mut MeshPrimitive,
    ) -> Result<(), String> {
        let document = &self.gltf.document;
        let own = self.pose.weights.get(&node).or(document.nodes[node].weights.as_ref());
        let weights = own.unwrap_or(&document.meshes[mesh].weights);
        for (target, &weight) in primitive.targets.iter().zip(weights) {
            if weight == 0.0 {
                continue;
            }
            for (name, list) in [
                ("POSITION", &mut part.positions),
                ("NORMAL", &mut part.normals),
                ("TANGENT", &mut part.tangents),
            ] {
                let Some(&accessor) = target.get(name) else { continue };
                let moves = self.gltf.vectors::<3>(accessor)?;
                for (vector, by) in list.iter_mut().zip(moves) {
                    *vector += DVec3::from(by.map(f64::from)) * weight;
                }
            }
        }
        Ok(())
    }

    /// Moves the vertices of a part with the joints of its node's skin.
    fn skin(
        &mut self,
        node: usize,
        attributes: &Attributes<'_, '_>,
        part: &mut MeshPrimitive,
    ) -> Result<(), String> {
        let gltf = self.gltf;
        let Some(skin) = gltf.document.nodes[node].skin else { return Ok(()) };
        let skin = gltf.document.skins.get(skin).ok_or_else(|| format!("unknown skin {skin}"))?;
        let (Some(joints), Some(weights)) =
            (attributes.integers("JOINTS_0")?, attributes.vectors::<4>("WEIGHTS_0")?)
        else {
            return Ok(());
        };
        if attributes.vectors::<4>("WEIGHTS_1")?.is_some() {
            self.import.warn("vertices follow their first four joints only");
        }
        let binds =
            skin.inverse_bind_matrices.map(|accessor| gltf.vectors::<16>(accessor)).transpose()?;
        let map = |(i, joint): (usize, &usize)| {
            let place = self
                .maps
                .get(joint)
                .ok_or_else(|| format!("the joint {joint} is not in the scene"))?;
            let bind = binds
                .as_ref()
                .map(|binds| binds.get(i).ok_or("a joint has no inverse bind matrix"));
            let Some(bind) = bind.transpose()? else { return Ok(*place) };
            Ok(*place * affine::of_columns(&bind.map(f64::from)))
        };
        let maps =
            skin.joints.iter().enumerate().map(map).collect::<Result<Vec<DAffine3>, String>>()?;
        for (i, (joints, weights)) in
            joints.into_iter().zip(weights).enumerate().take(part.positions.len())
        {
            let sum: f64 = weights.iter().map(|&weight| f64::from(weight)).sum();
            let sum = if sum > 0.0 { sum } else { 1.0 };
            let mut map = DAffine3 { matrix3: DMat3::ZERO, translation: DVec3::ZERO };
            for (joint, weight) in joints.into_iter().zip(weights) {
                if weight == 0.0 {
                    continue;
                }
                let joint =
                    maps.get(joint as usize).ok_or_else(|| format!("unknown joint {joint}"))?;
                let weight = f64::from(weight) / sum;
                map.matrix3 += joint.matrix3 * weight;
                map.translation += joint.translation * weight;
            }
            part.positions[i] = map.transform_point3(part.positions[i]);
            if let Some(normal) = part.normals.get_mut(i) {
                *normal = map.matrix3 * *normal;
            }
            if let Some(tangent) = part.tangents.get_mut(i) {
                *tangent = map.matrix3 * *tangent;
            }
        }
        Ok(())
    }

    /// The triangles of a part, placed by `map`.
    fn placed(&mut self, part: MeshPrimitive, map: &DAffine3, material: String) -> TrianglesFile {
        let MeshPrimitive { positions, normals, tangents, uvs, second_uvs, colors, mut faces } =
            part;
        if map.matrix3.determinant() < 0.0 {
            faces.iter_mut().for_each(|face| face.swap(1, 2));
        }
        // The transpose of the inverse, up to a factor: cross products exist for singular maps, too.
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = map.matrix3;
        let side = if map.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
        let turn = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * side;
        let vertices: Vec<_> =
            positions.iter().map(|&p| map.transform_point3(p).as_vec3().to_array()).collect();
        self.extent.add(vertices.iter().map(|&v| v.into()));
        let rounded = |v: DVec3| {
            let v = if v == DVec3::ZERO { DVec3::Z } else { unit(v) };
            v.as_vec3().to_array()
        };
        TrianglesFile {
            normals: normals.iter().map(|&n| rounded(turn * n)).collect(),
            tangents: tangents.iter().map(|&t| rounded(map.matrix3 * t)).collect(),
            uvs,
            second_uvs,
            colors,
            number: Some(self.import.number()),
            ..TrianglesFile::new(vertices, faces, material)
        }
    }
}
