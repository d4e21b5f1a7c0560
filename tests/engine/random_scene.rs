//! Random scenes that mix all features of scene files.

use ptfast::internals::{Stream, min};
use ptfast::light::{Distant, EnvironmentMap, Falloff, LightFile, Mapping, Point, Spot};
use ptfast::material::{
    CoatedDiffuse, Conductor, Dielectric, Diffuse, DiffuseTransmission, Fresnel, Lambertian, Light,
    Material, Metal, Opacity, Principled, RoughDielectric, Sides,
};
use ptfast::primitive::{
    BoxFile, InstanceFile, MovingSphereFile, QuadFile, SphereFile, TrianglesFile,
};
use ptfast::texture::{
    Channel, Checker, Color, Filter, Image, Number, Solid, Texture, VertexColor, Wrap,
};
use ptfast::{
    Background, CameraFile, MediumFile, Named, NamedMesh, PixelFilter, PrimitiveFile, Sampling,
    SceneFile,
};

/// Returns the random scene for `seed`. Some scenes are tiny, others huge.
pub(crate) fn random_scene(seed: u64) -> SceneFile {
    let mut scene = Maker(Stream::new(seed)).scene();
    match seed % 8 {
        1 => scale(&mut scene, 1e-6),
        2 => scale(&mut scene, 1e7),
        _ => (),
    }
    scene
}

/// Scales `scene` by the factor `by`.
fn scale(scene: &mut SceneFile, by: f32) {
    let camera = &mut scene.camera;
    camera.focus_distance *= by;
    let mut points = vec![&mut camera.look_from, &mut camera.look_at];
    let parts = scene.meshes.0.iter_mut().flat_map(|(_, mesh)| match mesh {
        NamedMesh::Parts(parts) => parts,
        _ => unreachable!("`Maker` names no file"),
    });
    for primitive in parts.chain(&mut scene.primitives) {
        match primitive {
            PrimitiveFile::Sphere(SphereFile { center, radius, .. }) => {
                *radius *= by;
                points.push(center);
            }
            PrimitiveFile::MovingSphere(MovingSphereFile { center, center1, radius, .. }) => {
                *radius *= by;
                points.extend([center, center1]);
            }
            PrimitiveFile::Quad(QuadFile { q, u, v, .. }) => points.extend([q, u, v]),
            PrimitiveFile::Box(BoxFile { min, max, .. }) => points.extend([min, max]),
            PrimitiveFile::Triangles(TrianglesFile { vertices, .. }) => points.extend(vertices),
            // The mesh is scaled, so only the translation changes.
            PrimitiveFile::Instance(InstanceFile { matrix, .. }) => {
                matrix.iter_mut().for_each(|row| row[3] *= by);
            }
            _ => unreachable!("`Maker` generates no other kind"),
        }
    }
    for medium in &mut scene.media {
        match medium {
            MediumFile::Ball { center, radius, density, .. } => {
                *radius *= by;
                *density = min(*density / by, 1e6);
                points.push(center);
            }
            MediumFile::Box { min: lo, max: hi, density, .. } => {
                *density = min(*density / by, 1e6);
                points.extend([lo, hi]);
            }
            _ => unreachable!("`Maker` generates no other kind"),
        }
    }
    points.into_iter().flatten().for_each(|coordinate| *coordinate *= by);
}

struct Maker(Stream);

impl Maker {
    fn below(&mut self, end: u64) -> u64 {
        self.0.bits() % end
    }

    fn one_in(&mut self, chances: u64) -> bool {
        self.below(chances) == 0
    }

    fn vector(&mut self, lo: f32, hi: f32) -> [f32; 3] {
        [(); 3].map(|()| self.0.between(lo, hi))
    }

    fn scene(mut self) -> SceneFile {
        let textures = (0..self.below(4)).map(|i| (format!("t{i}"), self.texture())).collect();
        let mut textures: Named<Texture> = Named(textures);
        let materials: Vec<_> = (0..1 + self.below(8))
            .map(|i| (format!("m{i}"), self.material(textures.0.len() as u64)))
            .collect();
        let holed = self.holed(textures.0.len() as u64);
        textures
            .0
            .push(("bumps".to_owned(), Image::normals_from_file("tests/data/bumps.png").into()));
        let count = match self.below(4) {
            0 => self.below(3),
            1 => 30 + self.below(100),
            _ => 3 + self.below(20),
        };
        let mut primitives: Vec<_> =
            (0..count).map(|_| self.primitive(materials.len() as u64)).collect();
        let meshes = if self.one_in(2) { self.below(4) } else { 0 };
        let named = (0..meshes).map(|i| (format!("g{i}"), self.mesh(i, materials.len() as u64)));
        let named: Vec<_> = named.collect();
        let instances = if meshes > 0 { self.below(12) } else { 0 };
        primitives
            .extend((0..instances).map(|_| self.instance(meshes, materials.len() as u64).into()));
        let mut scene = SceneFile::new(self.camera());
        scene.background = self.background();
        // Many lights are chosen by a light tree.
        let lights = match self.below(6) {
            0 | 1 => 1 + self.below(4),
            2 => 60 + self.below(100),
            _ => 0,
        };
        scene.lights = (0..lights).map(|_| self.light()).collect();
        scene.render.width = 1 + self.below(20) as u32;
        scene.render.height = 1 + self.below(20) as u32;
        scene.render.spp = 1 + self.below(20) as u32;
        scene.render.depth = if self.one_in(8) { 1 } else { 1 + self.below(12) as u32 };
        scene.render.sampling = Some(Sampling::ALL[self.below(3) as usize]);
        scene.textures = textures;
        scene.materials = Named(materials.into_iter().chain(holed).collect());
        scene.meshes = Named(named);
        scene.primitives = primitives;
        scene.media = (0..self.below(3)).map(|i| self.medium(i as f32)).collect();
        scene
    }

    /// A random medium. Media with different `place` lie side by side, without overlap.
    fn medium(&mut self, place: f32) -> MediumFile {
        let density = self.0.between(0.01, 3.0);
        let albedo = self.vector(0.0, 1.0);
        let center = [3.0 * place - 2.0, self.0.between(-1.0, 1.0), self.0.between(-1.0, 1.0)];
        let radius = self.0.between(0.2, 1.4);
        if self.one_in(2) {
            return MediumFile::Ball { center, radius, density, albedo };
        }
        let half = 0.57 * radius;
        let rotation = if self.one_in(2) { [0.0; 3] } else { self.vector(-90.0, 90.0) };
        let [min, max] = [-half, half].map(|half| center.map(|c| c + half));
        MediumFile::Box { min, max, rotation, density, albedo }
    }

    fn camera(&mut self) -> CameraFile {
        let (open, length) = (self.0.between(0.0, 0.5), self.0.between(0.0, 0.5));
        let (from, at) = (self.vector(-5.0, 5.0), self.vector(-1.0, 1.0));
        let mut camera = CameraFile::new(from, at, self.0.between(20.0, 120.0));
        camera.up = [0.1, 1.0, 0.2];
        camera.defocus_angle = if self.one_in(2) { 0.0 } else { self.0.between(0.1, 5.0) };
        camera.focus_distance = self.0.between(1.0, 8.0);
        camera.shutter = if self.one_in(3) { (open, open) } else { (open, open + length) };
        camera.filter = self.filter();
        camera
    }

    fn filter(&mut self) -> PixelFilter {
        let radius = self.0.between(0.1, 3.0);
        match self.below(8) {
            0 => PixelFilter::Triangle { radius },
            1 => PixelFilter::Gaussian { radius, sigma: radius * self.0.between(0.25, 2.0) },
            2 => PixelFilter::Mitchell { radius, b: self.0.uniform(), c: self.0.uniform() },
            3 => PixelFilter::BlackmanHarris { radius },
            _ => PixelFilter::Box,
        }
    }

    fn background(&mut self) -> Background {
        match self.below(4) {
            0 => Background::Constant { radiance: [0.0; 3] },
            1 => {
                let mut map = EnvironmentMap::from_file("tests/data/sky.pfm");
                map.rotation = if self.one_in(2) { [0.0; 3] } else { self.vector(-180.0, 180.0) };
                map.scale = self.0.between(0.0, 0.5);
                map.compensated = self.one_in(2);
                if self.one_in(2) {
                    map.file = "tests/data/square.pfm".to_owned();
                    map.mapping = Mapping::EqualArea;
                }
                Background::Image(map)
            }
            2 => Background::Constant { radiance: self.vector(0.0, 2.0) },
            _ => Background::Gradient { bottom: self.vector(0.0, 1.0), top: self.vector(0.0, 1.0) },
        }
    }

    fn light(&mut self) -> LightFile {
        let position = self.vector(-4.0, 4.0);
        match self.below(3) {
            0 => Point { position, intensity: self.vector(0.0, 20.0) }.into(),
            1 => {
                let (inner, outer) = (self.0.between(0.0, 30.0), self.0.between(31.0, 180.0));
                let (look_at, intensity) = (self.vector(-1.0, 1.0), self.vector(0.0, 20.0));
                let falloff = if self.one_in(2) { Falloff::Smooth } else { Falloff::Square };
                Spot { position, look_at, intensity, inner, outer, falloff }.into()
            }
            _ => {
                let angle = if self.one_in(2) { 0.0 } else { self.0.between(0.0, 20.0) };
                let (direction, irradiance) = (self.vector(-1.0, 1.0), self.vector(0.0, 5.0));
                Distant { direction, irradiance, angle }.into()
            }
        }
    }

    fn texture(&mut self) -> Texture {
        match self.below(4) {
            0 => VertexColor {}.into(),
            1 => Solid { color: self.vector(0.0, 1.0) }.into(),
            2 => {
                let (odd, even) = (self.vector(0.0, 1.0), self.vector(0.0, 1.0));
                Checker { odd, even, scale: self.0.between(0.5, 20.0) }.into()
            }
            _ => {
                let file = if self.one_in(3) { "floats.pfm" } else { "picture.png" };
                let mut image = Image::from_file(format!("tests/data/{file}"));
                image.uv = self.below(2) as u32;
                let wraps = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
                image.wrap_u = wraps[self.below(3) as usize];
                image.wrap_v = wraps[self.below(3) as usize];
                image.filter = if self.one_in(3) { Filter::Nearest } else { Filter::Bilinear };
                if self.one_in(2) {
                    image.rotation = self.0.between(-180.0, 180.0);
                    image.scale = (self.0.between(-3.0, 3.0), self.0.between(0.1, 3.0));
                    image.offset = (self.0.between(-2.0, 2.0), self.0.between(-2.0, 2.0));
                }
                image.into()
            }
        }
    }

    fn albedo(&mut self, textures: u64) -> Color {
        match self.below(2 + textures) {
            0 if self.one_in(4) => [0.0; 3].into(),
            0 | 1 => self.vector(0.0, 1.0).into(),
            i => {
                let factor = if self.one_in(2) { [1.0; 3] } else { self.vector(0.0, 1.0) };
                Color::Texture { texture: format!("t{}", i - 2).as_str().into(), factor }
            }
        }
    }

    /// A number in [0, 1].
    fn number(&mut self, textures: u64) -> Number {
        match self.below(4 + textures) {
            0 => 0.0.into(),
            1..4 => self.0.uniform().into(),
            i => {
                let channels = [Channel::R, Channel::G, Channel::B, Channel::A];
                let channel = channels[self.below(4) as usize];
                let texture = format!("t{}", i - 4).as_str().into();
                Number::Texture { texture, channel, factor: self.0.uniform() }
            }
        }
    }

    fn material(&mut self, textures: u64) -> Material {
        let mut material = self.plain_material(textures);
        let normal = self.one_in(3).then(|| "bumps".into());
        match &mut material {
            Material::Lambertian(lambertian) => lambertian.normal = normal,
            Material::Metal(metal) => metal.normal = normal,
            Material::Conductor(conductor) => conductor.normal = normal,
            Material::Dielectric(glass) => glass.normal = normal,
            Material::RoughDielectric(frosted) => frosted.normal = normal,
            Material::DiffuseTransmission(leaf) => leaf.normal = normal,
            Material::CoatedDiffuse(coated) => coated.normal = normal,
            Material::Principled(principled) => principled.normal = normal,
            _ => {}
        }
        material
    }

    fn plain_material(&mut self, textures: u64) -> Material {
        match self.below(12) {
            11 => {
                let mut coated = CoatedDiffuse::new(self.albedo(textures), self.number(textures));
                coated.ior = self.0.between(1.02, 3.0);
                coated.into()
            }
            10 => {
                let mut leaf =
                    DiffuseTransmission::new(self.albedo(textures), self.albedo(textures));
                leaf.scale = self.0.between(0.0, 0.5);
                leaf.into()
            }
            8 | 9 => self.principled(textures).into(),
            0 => Diffuse { albedo: self.albedo(textures) }.into(),
            1 | 2 => Lambertian::new(self.albedo(textures)).into(),
            3 => {
                let albedo = self.albedo(textures);
                Metal::new(albedo, self.number(textures)).into()
            }
            4 => {
                let ior = self.0.between(1.0, 2.5);
                let fresnel = if self.one_in(2) { Fresnel::Schlick } else { Fresnel::Exact };
                Dielectric::new(ior, fresnel).into()
            }
            5 => {
                let ior = self.0.between(1.02, 2.5);
                let alpha = match self.number(textures) {
                    Number::Value(_) => self.0.between(0.001, 1.0).into(),
                    texture => texture,
                };
                RoughDielectric::new(ior, alpha).into()
            }
            6 => {
                let (eta, k) = (self.vector(0.0, 2.0), self.vector(0.1, 5.0));
                Conductor::new(eta, k, self.number(textures)).into()
            }
            _ => {
                let radiance = if self.one_in(6) { [0.0; 3] } else { self.vector(0.0, 8.0) };
                let sides = if self.one_in(2) { Sides::Both } else { Sides::Front };
                Light { radiance, sides }.into()
            }
        }
    }

    fn principled(&mut self, textures: u64) -> Principled {
        let mut principled = Principled::default();
        principled.base_color = self.albedo(textures);
        principled.roughness = self.number(textures);
        if self.one_in(2) {
            principled.metalness = self.number(textures);
            principled.specular = self.number(textures);
        }
        if self.one_in(2) {
            principled.transmission = self.number(textures);
            principled.ior = self.0.between(1.02, 3.0);
            principled.thin = self.one_in(3);
            if principled.thin && self.one_in(2) {
                principled.roughness = 0.0.into();
            }
            principled.attenuation_color = self.vector(0.1, 1.0);
            principled.attenuation_distance = self.0.between(0.1, 4.0);
        }
        if self.one_in(2) {
            principled.coat = self.number(textures);
            principled.coat_roughness = self.number(textures);
            principled.coat_color = self.vector(0.0, 1.0);
            principled.coat_normal = self.one_in(3).then(|| "bumps".into());
        }
        if self.one_in(3) {
            principled.specular_color = self.vector(0.0, 20.0).into();
            principled.anisotropy = self.0.between(0.0, 1.0);
            principled.anisotropy_rotation = self.0.between(-360.0, 360.0);
            principled.anisotropy_map = self.one_in(3).then(|| "bumps".into());
            principled.sheen_color = self.albedo(textures);
            principled.sheen_roughness = self.number(textures);
            principled.diffuse_transmission = self.number(textures);
            principled.diffuse_transmission_color = self.albedo(textures);
        }
        if self.one_in(6) {
            principled.emission =
                if self.one_in(2) { self.vector(0.0, 3.0).into() } else { self.albedo(textures) };
        }
        principled
    }

    fn primitive(&mut self, materials: u64) -> PrimitiveFile {
        let material = format!("m{}", self.below(materials));
        // Some primitives are far larger, so that they may contain the camera.
        let size = if self.one_in(12) { 20.0 } else { 1.0 };
        match self.below(7) {
            0 | 1 => SphereFile {
                center: self.vector(-3.0, 3.0),
                radius: size * self.0.between(0.05, 1.0),
                material,
            }
            .into(),
            2 => MovingSphereFile {
                center: self.vector(-3.0, 3.0),
                center1: self.vector(-3.0, 3.0),
                radius: self.0.between(0.05, 1.0),
                material,
            }
            .into(),
            3 => QuadFile {
                q: self.vector(-3.0, 3.0),
                u: self.vector(-size, size),
                v: self.vector(-size, size),
                material,
            }
            .into(),
            // A rectangle with edges along the axes.
            4 => QuadFile {
                q: self.vector(-3.0, 3.0),
                u: [0.0, 0.0, self.0.between(0.1, 3.0)],
                v: [self.0.between(0.1, 3.0), 0.0, 0.0],
                material,
            }
            .into(),
            5 => {
                let min = self.vector(-3.0, 2.0);
                let edges = self.vector(0.1, 1.5);
                let max = [0, 1, 2].map(|axis| min[axis] + edges[axis]);
                let rotation = if self.one_in(2) { [0.0; 3] } else { self.vector(-90.0, 90.0) };
                BoxFile { min, max, rotation, material }.into()
            }
            _ => {
                let material = self.with_holes(material);
                self.triangles(material).into()
            }
        }
    }

    /// The material of triangles, some of which have holes.
    fn with_holes(&mut self, material: String) -> String {
        if self.one_in(3) { format!("h{}", self.below(3)) } else { material }
    }

    /// Materials with holes, for triangles.
    fn holed(&mut self, textures: u64) -> [(String, Material); 3] {
        let [first, second, third] = [(); 3].map(|()| {
            let (alpha, threshold) = (self.number(textures), self.0.uniform());
            Some(match self.one_in(2) {
                true => Opacity::Mask { alpha, threshold },
                false => Opacity::Blend { alpha },
            })
        });
        let card: Material = match self.below(3) {
            0 => {
                let mut card = Lambertian::new([0.5; 3]);
                card.opacity = first;
                card.into()
            }
            1 => {
                let mut foil = Metal::new([0.7; 3], 0.1);
                foil.opacity = first;
                foil.into()
            }
            _ => {
                let mut foil = Conductor::new([0.2; 3], [3.0; 3], 0.2);
                foil.opacity = first;
                foil.into()
            }
        };
        let mut leaf = DiffuseTransmission::new([0.3; 3], [0.4; 3]);
        leaf.opacity = second;
        let glass: Material = match self.below(3) {
            0 => {
                let mut glass = Dielectric::new(1.5, Fresnel::Exact);
                glass.opacity = third;
                glass.into()
            }
            1 => {
                let mut glass = RoughDielectric::new(1.5, 0.3);
                glass.opacity = third;
                glass.into()
            }
            _ => {
                let mut glass = Principled::default();
                (glass.opacity, glass.transmission) = (third, 0.5.into());
                if self.one_in(2) {
                    // A texture that is known to vary.
                    glass.emission = "bumps".into();
                }
                glass.into()
            }
        };
        let named = |name: &str, material: Material| (name.to_owned(), material);
        [named("h0", card), named("h1", leaf.into()), named("h2", glass)]
    }

    fn triangles(&mut self, material: String) -> TrianglesFile {
        let vertices: Vec<_> = (0..6).map(|_| self.vector(-3.0, 3.0)).collect();
        let indices = vec![[0, 1, 2], [1, 2, 3], [3, 4, 5]];
        let mut triangles = TrianglesFile::new(vertices, indices, material);
        if self.one_in(2) {
            triangles.normals = (0..6).map(|_| self.vector(-1.0, 1.0)).collect();
            triangles.soft_terminator = self.one_in(2);
        }
        if self.one_in(2) {
            let uv = |[u, v, _]: [f32; 3]| [u, v];
            triangles.uvs = (0..6).map(|_| uv(self.vector(-1.0, 2.0))).collect();
            if self.one_in(3) {
                triangles.second_uvs = (0..6).map(|_| uv(self.vector(-1.0, 2.0))).collect();
            }
        }
        if self.one_in(3) {
            triangles.colors = (0..6).map(|_| self.vector(0.0, 1.0)).collect();
        }
        if self.one_in(4) {
            triangles.tangents = (0..6).map(|_| self.vector(-1.0, 1.0)).collect();
        }
        triangles
    }

    /// Mesh number `number`, which may contain instances of meshes before it.
    fn mesh(&mut self, number: u64, materials: u64) -> NamedMesh {
        let parts = (0..1 + self.below(3)).map(|_| match number {
            1.. if self.one_in(3) => self.instance(number, materials).into(),
            _ => {
                let material = format!("m{}", self.below(materials));
                let material = self.with_holes(material);
                self.triangles(material).into()
            }
        });
        parts.collect::<Vec<PrimitiveFile>>().into()
    }

    /// An instance of one of the first `meshes` meshes.
    fn instance(&mut self, meshes: u64, materials: u64) -> InstanceFile {
        let factors = [(); 3].map(|()| self.vector(-0.5, 0.5));
        let move_by = self.vector(-2.0, 2.0);
        let mut matrix = [0, 1, 2].map(|i| {
            let [x, y, z] = factors[i];
            [x, y, z, move_by[i]]
        });
        // Far from singular, also in products of such matrices.
        (0..3).for_each(|i| matrix[i][i] = if self.one_in(3) { -1.2 } else { 1.2 });
        let mut instance = InstanceFile::new(format!("g{}", self.below(meshes)), matrix);
        if self.one_in(4) {
            instance.material = Some(format!("m{}", self.below(materials)));
        }
        instance
    }
}
