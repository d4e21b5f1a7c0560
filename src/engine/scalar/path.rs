//! The path tracing loop of the scalar engine.

use glam::Vec3;

use super::intersect::Intersect;
use crate::engine::{
    Endings, FirstHit, FirstHits, ImageSettings, Layers, LightParts, RayCounts, SHADOW_REACH,
    Survival, View, emission_weight, finite, power_heuristic,
};
use crate::geometry::{Hit, Ray, Shape, Surface};
use crate::math::{PathKey, Real, dot, max_element};
use crate::sampler::{Dimension, Randoms};
use crate::scene::{Sampling, Scene};
use crate::shading::material::{
    Bsdf, MaterialModel, MaterialTable, MaterialVisitor, SPECULAR, Scatter,
};
use crate::shading::{Beyond, CameraFrame, Key, MOST_PANES, Nesting, SceneTables};

/// Estimates the radiance along camera rays, and counts rays and path endings.
pub(in crate::engine) struct PathTracer<'a> {
    scene: &'a Scene,
    tables: &'a SceneTables,
    intersect: &'a mut dyn Intersect,
    settings: &'a ImageSettings,
    survival: Survival,
    camera: &'a CameraFrame,
    /// The bodies around the camera.
    nesting: Nesting<f32>,
    layers: Layers,
    pub(in crate::engine) rays: RayCounts,
    pub(in crate::engine) endings: Endings,
}

/// The state of an active path.
struct Path {
    /// The ray to trace next.
    ray: Ray,
    /// Density with which the ray's direction was sampled.
    pdf: f32,
    /// Throughput: the factor from radiance along the ray to the sample's radiance.
    beta: Vec3,
    /// Radiance that has arrived at the camera so far.
    radiance: Vec3,
    /// The bodies that the segment is in.
    nesting: Nesting<f32>,
    key: PathKey,
    /// Number of the current segment, from 1.
    segment: u32,
    /// Whether the first hit is still to come.
    pending: bool,
    /// Whether the camera ray meets the background.
    background: bool,
    /// Radiance after shading the first segment, and after shading the second.
    after: [Option<Vec3>; 2],
}

/// A point at which a path is scattered.
struct Vertex<'a> {
    surface: &'a Surface,
    /// Surface normal on the side where the path arrives.
    normal: Vec3,
    /// The bodies beyond the surface.
    beyond: Nesting<f32>,
    randoms: &'a Randoms,
}

impl Path {
    /// Stores the radiance, after light that arrives by scattering was added.
    fn shaded(&mut self) {
        if let Some(after) = self.after.get_mut(self.segment as usize - 1) {
            *after = Some(self.radiance);
        }
    }
}

impl<'a> PathTracer<'a> {
    /// Creates a tracer of paths that begin in the bodies of `nesting`.
    pub(in crate::engine) fn new(
        view: &'a View,
        nesting: Nesting<f32>,
        intersect: &'a mut dyn Intersect,
    ) -> Self {
        let View { settings, camera, survival, .. } = view;
        let (rays, endings) = Default::default();
        let (scene, tables) = (view.scene(), view.prepared.tables());
        let layers = settings.stored_layers();
        let survival = *survival;
        Self {
            scene,
            tables,
            intersect,
            settings,
            survival,
            camera,
            nesting,
            layers,
            rays,
            endings,
        }
    }

    /// Returns one estimate of the radiance that arrives along `ray` (report, III.A, as a loop), and its parts,
    /// all with the weight `weight`. Writes the values of the first hit to `values`, one per channel of the
    /// layers.
    pub(in crate::engine) fn radiance(
        &mut self,
        ray: Ray,
        key: PathKey,
        weight: f32,
        values: &mut [f32],
    ) -> (Vec3, LightParts) {
        let (beta, radiance) = (Vec3::ONE, Vec3::ZERO);
        let (pending, background) = (!self.layers.is_empty(), false);
        let (pdf, segment, after) = (SPECULAR, 1, [None; 2]);
        let nesting = self.nesting;
        let mut path =
            Path { ray, pdf, beta, radiance, nesting, key, segment, pending, background, after };
        self.rays.primary += 1;
        while self.advance(&mut path, values) {
            self.rays.bounce += 1;
            path.segment += 1;
        }
        let all = path.radiance * weight;
        if self.layers.is_empty() {
            return (all, LightParts::default());
        }
        let after = path.after.map(|light| light.map(|light| light * weight));
        (all, LightParts::new(path.background, after, all))
    }

    /// Traces a segment of `path`. Returns whether another segment follows.
    fn advance(&mut self, path: &mut Path, values: &mut [f32]) -> bool {
        let ray = path.ray;
        let randoms = Randoms::new(self.settings.sampler, path.key, path.segment);

        // Extend: find the closest surface, or a collision in a medium before it.
        let hit = self.intersect.closest(&ray, path.segment);
        let mut hit = hit.unwrap_or(Hit::of(Hit::MISS, f32::INFINITY));
        (hit.t, hit.primitive) = self.tables.media.collide(&ray, (hit.t, hit.primitive), &randoms);

        // The distance at which the last ray began.
        let mut begins = 0.0;
        if self.tables.looks.have_panes() {
            (hit, begins) = self.pass(path, hit);
        }
        if !self.tables.bodies.are_clear() {
            path.beta *= self.tables.bodies.transmittance(path.nesting, hit.t);
        }

        // Shade: add emitted light, or sample the next direction.
        match self.tables.looks.keys()[usize::from(self.tables.looks.key(hit.primitive))] {
            Key::Background => {
                if path.pending {
                    self.store(path, values, &FirstHit::none(path.segment), false);
                }
                path.radiance += path.beta * self.background(path);
                self.endings.background += 1;
                false
            }
            Key::Medium => {
                self.intersect.collided(hit.t - begins);
                let phase = self.tables.media.phase(hit.primitive);
                let point = ray.origin + ray.direction * hit.t;
                if path.pending {
                    let first = FirstHit::in_medium(self.scene, self.camera, point, phase.albedo());
                    self.store(path, values, &first, false);
                }
                path.shaded();
                if self.ends_by_depth(path) {
                    return false;
                }
                // A medium has no surface that rays could hit again, so they start at offset 0.
                let surface = Surface::flat(point, ray.direction, 0.0);
                let (surface, normal) = (&surface, -ray.direction);
                let vertex = Vertex { surface, normal, beyond: path.nesting, randoms: &randoms };
                self.scatter(&phase, &vertex, path)
            }
            Key::Surface { shape, kind, emits, .. } => {
                let tracer = self;
                let shade = Shade { tracer, path, values, shape, hit, emits, randoms: &randoms };
                shade.tracer.tables.materials.visit(kind, shade)
            }
        }
    }

    /// Returns what `path`, whose ray has this hit, meets beyond the panes that it passes, and the distance at which
    /// the last part of its ray begins.
    fn pass(&mut self, path: &mut Path, mut hit: Hit) -> (Hit, f32) {
        let mut begins = 0.0;
        for number in 1..=MOST_PANES {
            let Some(pane) = self.tables.pane(&path.ray, hit) else { break };
            let (sampler, key) = (self.settings.sampler, path.key.beyond(number));
            let randoms = Randoms::new(sampler, key, path.segment);
            let chance = pane.chance();
            if randoms.one(Dimension::PANE) >= chance {
                path.beta *= Vec3::splat(1.0 / (1.0 - chance));
                break;
            }
            path.beta *= pane.transmittance / chance;
            let part = Beyond::new(&path.ray, &pane);
            self.rays.bounce += 1;
            let found = self.intersect.closest(&part.ray, path.segment);
            let mut next = found.unwrap_or(Hit::of(Hit::MISS, f32::INFINITY));
            (next.t, next.primitive) =
                self.tables.media.collide(&part.ray, (next.t, next.primitive), &randoms);
            (hit, begins) = (part.whole(next), part.begins);
        }
        (hit, begins)
    }

    /// Stores the first hit of `path`, which is still to come. It stays so if the first hit may follow this one.
    // Out of the way of renders without layers.
    #[inline(never)]
    fn store(&self, path: &mut Path, values: &mut [f32], hit: &FirstHit<'_, f32>, follows: bool) {
        let first = path.segment == 1;
        for (layer, place) in self.layers.places() {
            let values = &mut values[place..place + layer.channels()];
            for (value, here) in values.iter_mut().zip(layer.of_hit(hit)) {
                *value = finite(here);
            }
        }
        path.background |= first && !hit.exists;
        path.pending = follows && self.settings.first_hit == FirstHits::Through;
    }

    /// Returns whether the depth limit ends the path here, and counts it if so. Rays beyond the
    /// limit are not traced, so scattering would be useless.
    fn ends_by_depth(&mut self, path: &Path) -> bool {
        let ends = path.segment == self.settings.depth;
        self.endings.depth += u64::from(ends);
        ends
    }

    /// Adds direct light and samples the next direction. Returns whether the path continues.
    fn scatter<B: Bsdf<f32>>(&mut self, bsdf: &B, vertex: &Vertex<'_>, path: &mut Path) -> bool {
        // Connect: sample one light with one shadow ray. The depth limit counts this ray as the
        // path's next segment.
        if self.settings.samples_lights(self.scene) && !bsdf.specular() {
            let direct = self.direct(bsdf, vertex, path);
            path.radiance += direct.unwrap_or(Vec3::ZERO);
        }
        let Scatter { direction, transmitted, weight, pdf, scattered } =
            bsdf.sample(vertex.randoms);
        if !scattered {
            self.endings.absorbed += 1;
            return false;
        }
        path.beta *= weight;
        path.pdf = pdf;
        let side = if transmitted { -vertex.normal } else { vertex.normal };
        path.nesting = if transmitted { vertex.beyond } else { path.nesting };
        path.ray = Ray { origin: vertex.surface.spawn(side), direction, time: path.ray.time };

        // Terminate paths of zero throughput, and most paths of low throughput.
        if max_element(path.beta) <= 0.0 {
            self.endings.black += 1;
            return false;
        }
        if self.survival.applies(path.segment + 1) {
            let survival: f32 = self.survival.probability(path.beta);
            if vertex.randoms.one(Dimension::ROULETTE) >= survival {
                self.endings.roulette += 1;
                return false;
            }
            path.beta /= survival;
        }
        true
    }

    /// Estimates the radiance that one light sends directly to `vertex` and from there along the
    /// path to the camera, with one shadow ray. Returns `None` if no light arrives.
    fn direct<B: Bsdf<f32>>(&mut self, bsdf: &B, vertex: &Vertex<'_>, path: &Path) -> Option<Vec3> {
        let Vertex { surface, normal, beyond, randoms } = *vertex;
        let time = path.ray.time;
        let from = surface.spawn(normal);
        let light = self.tables.lights.choose(randoms, from);
        let sample = light.sample(from, time, randoms.two(Dimension::LIGHT));
        let mut emitted = light.radiance(sample.front) * sample.tint;
        if self.tables.lights.has_varied() {
            let ray = Ray { origin: from, direction: sample.direction, time };
            let constant = (emitted, sample.front);
            emitted = self.tables.radiance_of_sample(&light, constant, &ray, sample.distance);
        }
        if !(sample.visible && max_element(emitted) > 0.0) {
            return None;
        }
        let (f_cos, bsdf_pdf) = bsdf.evaluate(sample.direction);
        if !(max_element(f_cos) > 0.0) {
            return None;
        }
        self.rays.shadow += 1;
        // A light behind the surface is sampled from the front but needs a shadow ray from the
        // back. Both origins have the same distance to it, up to rounding errors.
        let above = dot(sample.direction, normal) > 0.0;
        let (side, nesting) = if above { (normal, path.nesting) } else { (-normal, beyond) };
        let shadow = Ray { origin: surface.spawn(side), direction: sample.direction, time };
        let t_max = sample.distance * SHADOW_REACH;
        let occluded = self.intersect.occluded(&shadow, t_max, path.segment);
        if occluded && !self.tables.looks.have_panes() {
            return None;
        }
        let pdf = sample.pdf * light.chance(from);
        let weight = match self.settings.sampling {
            Sampling::Mis if !light.unseen() => power_heuristic(pdf, bsdf_pdf),
            _ => 1.0,
        };
        let crossing = self.tables.media.transmittance(&shadow, sample.distance);
        let mut light = f_cos * emitted * (weight / pdf * crossing);
        if !self.tables.bodies.are_clear() {
            light *= self.tables.bodies.transmittance(nesting, sample.distance);
        }
        let light = path.beta * light;
        if occluded { self.pass_shadow(shadow, t_max, path.segment, light) } else { Some(light) }
    }

    /// Returns the part of the `light` of a blocked shadow ray that passes panes, if they alone block it.
    fn pass_shadow(
        &mut self,
        mut ray: Ray,
        mut t_max: f32,
        segment: u32,
        mut light: Vec3,
    ) -> Option<Vec3> {
        for number in 0..=MOST_PANES {
            self.rays.shadow += 1;
            let Some(hit) = self.intersect.closest_before(&ray, t_max, segment) else {
                return Some(light);
            };
            let pane = self.tables.pane(&ray, hit).filter(|_| number < MOST_PANES)?;
            light *= pane.transmittance;
            ray.origin = pane.beyond;
            t_max -= hit.t;
        }
        None
    }

    /// Returns the radiance that arrives along `path` from outside the scene, times its weight.
    fn background(&self, path: &Path) -> Vec3 {
        let direction = path.ray.direction;
        if path.segment == 1 && self.settings.transparent {
            return Vec3::ZERO;
        }
        let Some((map, light)) = self.tables.lights.environment::<f32>() else {
            return self.scene.background().radiance(|| direction);
        };
        let (radiance, pdf) = map.look::<f32>(direction);
        let light_pdf = || pdf * light.chance(path.ray.origin);
        // A compensated map is never sampled where it is dark.
        let weight = match pdf {
            0.0 => 1.0,
            _ => emission_weight(self.settings.sampling, path.pdf, light_pdf),
        };
        radiance * light.radiance(true) * weight
    }

    /// Returns the radiance that the surface at the end of the segment emits towards `path`,
    /// its weight, and whether the row of the material replaces the radiance. [`Self::direct`] contributes the rest.
    fn emitted(&self, path: &Path, shape: Shape, hit: Hit, front: bool) -> (Vec3, f32, bool) {
        let (light, is_light) = self.tables.looks.lights::<f32>(shape, hit.primitive);
        if !is_light {
            return (Vec3::ZERO, 1.0, true);
        }
        let light = self.tables.lights.get::<f32>(light);
        let light_pdf = || light.pdf(&path.ray, hit.t) * light.chance(path.ray.origin);
        let weight = emission_weight(self.settings.sampling, path.pdf, light_pdf);
        (light.radiance(front), weight, light.varies() && !light.is_dark(front))
    }
}

/// Shades a path at a surface whose kind of material is known only at run time.
struct Shade<'s, 'a> {
    tracer: &'s mut PathTracer<'a>,
    path: &'s mut Path,
    values: &'s mut [f32],
    shape: Shape,
    hit: Hit,
    emits: bool,
    randoms: &'s Randoms,
}

impl MaterialVisitor for Shade<'_, '_> {
    /// Whether the path continues.
    type Output = bool;

    fn visit<M: MaterialModel>(self, table: &MaterialTable<M::Entry>) -> bool {
        let Self { tracer, path, values, shape, hit, emits, randoms } = self;
        let tables = tracer.tables;
        let mut at = tables.interaction::<f32>(
            shape,
            path.ray,
            hit,
            table.textured,
            M::GLOSSY,
            shape == Shape::Instance,
        );
        let entry = tables.looks.entries::<f32>(shape, hit.primitive, table.entries.len());
        if emits {
            let (mut light, weight, varies) = tracer.emitted(path, shape, hit, at.front);
            if varies && !table.emission_rows.is_empty() {
                light = at.color(f32::gather(&table.emission_rows, entry, |row| row));
            }
            path.radiance += path.beta * light * weight;
        }
        path.shaded();
        let ends = if M::SCATTERS {
            tracer.ends_by_depth(path)
        } else {
            tracer.endings.light += 1;
            true
        };
        if ends && !path.pending {
            return false;
        }
        if M::TEXTURED && table.textured {
            at.map_normals(table, entry, M::GLOSSY);
        }
        let bsdf = M::bsdf::<f32>(&table.entries, entry, &at);
        if path.pending {
            let first = FirstHit::on_surface(tracer.scene, tracer.camera, &at, &bsdf);
            tracer.store(path, values, &first, bsdf.specular());
            if ends {
                return false;
            }
        }
        let bsdf = at.smoothed(bsdf);
        let beyond = path.nesting.beyond(table.bodies[entry as usize], at.front);
        let vertex = Vertex { surface: &at.surface, normal: at.normal, beyond, randoms };
        tracer.scatter(&bsdf, &vertex, path)
    }
}
