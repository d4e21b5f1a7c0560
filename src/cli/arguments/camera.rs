//! The arguments that choose the camera, or replace some of its values.

use std::fmt::Display;
use std::str::FromStr;

use clap::Args;
use glam::DVec3;

use crate::error::{Error, Result, suggestion};
use crate::measure::settings::quoted;
use crate::scene::Scene;
use crate::shading::{Camera, CameraFile};

const CAMERA: &str = "Camera";

#[derive(Clone, Debug, Default, Args)]
pub(crate) struct CameraArgs {
    /// Name of a camera in the section `cameras` of the scene file [default: the section `camera`]
    #[arg(long, value_name = "NAME", help_heading = CAMERA)]
    camera: Option<String>,
    /// Position of the camera [default: the camera's, as for the options below]
    #[arg(long, value_name = "X,Y,Z", help_heading = CAMERA, allow_hyphen_values = true, value_parser = vector::<f64>)]
    look_from: Option<[f64; 3]>,
    /// Point in the middle of the image
    #[arg(long, value_name = "X,Y,Z", help_heading = CAMERA, allow_hyphen_values = true, value_parser = vector::<f64>)]
    look_at: Option<[f64; 3]>,
    /// Direction that points up in the image
    #[arg(long, value_name = "X,Y,Z", help_heading = CAMERA, allow_hyphen_values = true, value_parser = vector::<f32>)]
    up: Option<[f32; 3]>,
    /// Full vertical angle of view, between 0 and 180
    #[arg(long, value_name = "DEGREES", help_heading = CAMERA, allow_hyphen_values = true)]
    fov: Option<f32>,
    /// Apex angle of the cone from a point in focus to the lens, 0 for a pinhole
    #[arg(long, value_name = "DEGREES", help_heading = CAMERA)]
    defocus_angle: Option<f32>,
    /// Distance from the camera to the plane in focus
    #[arg(long, value_name = "LENGTH", help_heading = CAMERA)]
    focus_distance: Option<f32>,
}

fn vector<T: FromStr>(text: &str) -> Result<[T; 3], String> {
    let numbers: Option<Vec<T>> = text.split(',').map(|word| word.trim().parse().ok()).collect();
    numbers.and_then(|numbers| numbers.try_into().ok()).ok_or_else(|| {
        "must be three numbers with commas between them, such as 0,1.5,-4".to_owned()
    })
}

impl CameraArgs {
    /// The chosen camera of `scene` with the values that replace its own.
    ///
    /// # Errors
    /// [`Error::Usage`] if the scene has no camera of this name, or a value is out of range.
    pub(crate) fn camera(&self, scene: &Scene) -> Result<Camera> {
        Camera::try_from(&self.file(scene)?).map_err(|error| match error {
            Error::Input { message, .. } => Error::Usage(message),
            other => other,
        })
    }

    /// [`camera`](Self::camera) as scene files describe it, unchecked.
    ///
    /// # Errors
    /// [`Error::Usage`] if the scene has no camera of this name.
    pub(crate) fn file(&self, scene: &Scene) -> Result<CameraFile> {
        let file = match &self.camera {
            None => scene.camera_file(),
            Some(name) => {
                let named = scene.cameras().0.iter().find(|(known, _)| known == name);
                &named.ok_or_else(|| unknown(name, scene))?.1
            }
        };
        let mut file: CameraFile = file.clone();
        let in_scene = |point: [f64; 3]| (DVec3::from(point) - scene.origin()).as_vec3().to_array();
        file.look_from = self.look_from.map_or(file.look_from, in_scene);
        file.look_at = self.look_at.map_or(file.look_at, in_scene);
        file.up = self.up.unwrap_or(file.up);
        if let Some(fov) = self.fov {
            (file.vfov, file.parallel) = (fov, None);
        }
        file.defocus_angle = self.defocus_angle.unwrap_or(file.defocus_angle);
        file.focus_distance = self.focus_distance.unwrap_or(file.focus_distance);
        Ok(file)
    }

    /// The arguments of `camera`, which these arguments chose and somebody moved.
    pub(crate) fn moved(&self, scene: &Scene, camera: &CameraFile) -> Self {
        let chosen = self.file(scene).ok();
        let Some(chosen) = chosen.filter(|chosen| chosen != camera) else { return self.clone() };
        let in_file =
            |point: [f32; 3]| Some((scene.origin() + DVec3::from(point.map(f64::from))).to_array());
        let lens = camera.defocus_angle != chosen.defocus_angle
            || camera.focus_distance != chosen.focus_distance;
        Self {
            camera: self.camera.clone(),
            look_from: in_file(camera.look_from),
            look_at: in_file(camera.look_at),
            up: Some(camera.up),
            fov: camera.parallel.is_none().then_some(camera.vfov),
            defocus_angle: lens.then_some(camera.defocus_angle).or(self.defocus_angle),
            focus_distance: lens.then_some(camera.focus_distance).or(self.focus_distance),
        }
    }

    /// The arguments for the camera called `name` instead.
    pub(crate) fn named(name: &str) -> Self {
        Self { camera: Some(name.to_owned()), ..Self::default() }
    }

    /// These arguments on a command line, each with a space before it.
    pub(crate) fn words(&self) -> String {
        fn vector<T: Display>([x, y, z]: [T; 3]) -> String {
            format!("{x},{y},{z}")
        }
        let words = [
            ("camera", self.camera.as_deref().map(quoted)),
            ("look-from", self.look_from.map(vector)),
            ("look-at", self.look_at.map(vector)),
            ("up", self.up.map(vector)),
            ("fov", self.fov.map(|degrees| degrees.to_string())),
            ("defocus-angle", self.defocus_angle.map(|degrees| degrees.to_string())),
            ("focus-distance", self.focus_distance.map(|length| length.to_string())),
        ];
        let word = |(name, value): (&str, Option<String>)| Some(format!(" --{name} {}", value?));
        words.into_iter().filter_map(word).collect()
    }
}

fn unknown(name: &str, scene: &Scene) -> Error {
    Error::Usage(format!("unknown camera `{name}`{}", suggestion(name, scene.cameras().names())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_replace_those_of_the_camera() {
        let scene = Scene::load("cornell").unwrap();
        let none = CameraArgs::default();
        assert_eq!(none.camera(&scene).unwrap(), *scene.camera());
        assert_eq!(none.words(), "");
        let look_from = Some(vector("1,-2.5,3e2").unwrap());
        let some = CameraArgs { look_from, fov: Some(30.5), ..CameraArgs::default() };
        assert_eq!(some.words(), " --look-from 1,-2.5,300 --fov 30.5");
        let mut file = scene.camera_file().clone();
        (file.look_from, file.vfov) = ([1.0, -2.5, 300.0], 30.5);
        assert_eq!(some.camera(&scene).unwrap(), Camera::try_from(&file).unwrap());
        // As somebody moves it.
        let moved =
            some.moved(&scene, &CameraFile { vfov: 31.0, defocus_angle: 1.5, ..file.clone() });
        let want = CameraFile { vfov: 31.0, defocus_angle: 1.5, ..file.clone() };
        assert_eq!(moved.file(&scene).unwrap(), want);
        assert!(
            moved.words().contains(" --defocus-angle 1.5 --focus-distance "),
            "{}",
            moved.words()
        );
        assert_eq!(some.moved(&scene, &file).words(), some.words());
        for wrong in ["", "1,2", "1,2,3,4", "1,2,x"] {
            assert!(vector::<f32>(wrong).is_err(), "{wrong}");
        }
    }
}
