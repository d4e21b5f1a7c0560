//! From what a file says to a scene that can be rendered: every number checked, every
//! name looked up.

mod materials;
mod primitives;

use std::path::Path;

use glam::DVec3;

use super::Scene;
use super::camera::Camera;
use super::description::{BackgroundFile, CameraFile, SceneFile};
use super::light::Lights;
use super::material::Background;
use super::medium::Medium;
use super::place::{Element, MAX_COORDINATE, MAX_RADIANCE, Places};
use crate::error::Result;
use crate::limits::MAX_MEDIA;

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
}
