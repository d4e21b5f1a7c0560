//! The camera, film, filter, sampler and integrator of pbrt files.

use glam::{DAffine3, DVec3};

use super::{Params, Reader, rounded, twice_angle_of};
use crate::math::affine;
use crate::shading::{CameraFile, PixelFilter};

/// What the directives before `WorldBegin` say about the picture.
#[derive(Default)]
pub(crate) struct RenderOptions {
    camera: Option<Camera>,
    size: Option<[u32; 2]>,
    filter: Option<PixelFilter>,
    pub(crate) spp: Option<u32>,
    pub(crate) depth: Option<u32>,
}

struct Camera {
    to_scene: DAffine3,
    /// Angle of view along the shorter side; `None` for a parallel projection.
    fov: Option<f64>,
    /// Half the length of the shorter side of a parallel projection.
    half: f64,
    lens_radius: f64,
    focal_distance: f64,
}

/// The camera of files that have none.
impl Default for Camera {
    fn default() -> Self {
        Self {
            to_scene: DAffine3::IDENTITY,
            fov: Some(90.0),
            half: 1.0,
            lens_radius: 0.0,
            focal_distance: 1e6,
        }
    }
}

/// A whole number in 1 to `most`.
fn whole(params: &Params, name: &str, most: f64) -> Result<Option<u32>, String> {
    let number = params.number(name)?;
    Ok(number.map(|number| number.clamp(1.0, most) as u32))
}

impl Reader<'_, '_> {
    /// The directive `Camera`.
    pub(crate) fn camera(&mut self, class: &str, params: &Params) -> Result<(), String> {
        let usual = Camera::default();
        let fov = match class {
            "perspective" | "realistic" | "spherical" => {
                if class != "perspective" {
                    self.import.warn(format!(
                        "the camera {class} is not supported, so it is a perspective"
                    ));
                }
                params.number("fov")?.or(usual.fov)
            }
            "orthographic" => None,
            _ => return Err(format!("unknown camera `{class}`")),
        };
        let mut half = usual.half;
        if let Some([left, right, lower, upper]) = params.tuple::<4>("screenwindow")? {
            let sides = [right - left, upper - lower];
            half = 0.5 * if sides[0] < sides[1] { sides[0] } else { sides[1] };
            if class == "perspective" && half != 1.0 {
                self.import.warn(
                    "the screen window of a perspective is not supported, so it is the whole view",
                );
            }
            if left != -right || lower != -upper {
                self.import.warn("views beside the axis of the camera are not supported, so they are in the middle");
            }
        }
        if params.find("frameaspectratio").is_some() {
            self.import.warn("frameaspectratio is not supported, so pixels are square");
        }
        if class == "orthographic" && params.number("lensradius")?.unwrap_or(0.0) > 0.0 {
            self.import.warn(
                "lenses of orthographic cameras are not supported, so everything is in focus",
            );
        }
        let to_scene = self.state.transform.inverse();
        self.systems.insert("camera".to_owned(), to_scene);
        self.view.camera = Some(Camera {
            to_scene,
            fov,
            half,
            lens_radius: params.number("lensradius")?.unwrap_or(usual.lens_radius),
            focal_distance: params.number("focaldistance")?.unwrap_or(usual.focal_distance),
        });
        params.ignore(&["shutteropen", "shutterclose"]);
        self.view_medium.clone_from(&self.state.outside);
        self.warn_unused(params, &format!("the camera {class}"));
        Ok(())
    }

    /// The directive `Film`.
    pub(crate) fn film(&mut self, params: &Params) -> Result<(), String> {
        let most = f64::from(crate::limits::MAX_SIDE);
        let width = whole(params, "xresolution", most)?.unwrap_or(1280);
        let height = whole(params, "yresolution", most)?.unwrap_or(720);
        self.view.size = Some([width, height]);
        if params.find("cropwindow").or(params.find("pixelbounds")).is_some() {
            self.import.warn(
                "crops of the film are not supported, so the picture is whole; `crop` cuts it",
            );
        }
        params.ignore(&["filename", "savefp16", "diagonal"]);
        // These are the usual values of pbrt.
        let (sensor, iso) = (params.text("sensor")?, params.number("iso")?);
        let usual = [
            ("sensor", sensor.is_none_or(|sensor| sensor == "cie1931")),
            ("iso", iso.is_none_or(|iso| iso == 100.0)),
            ("exposuretime", params.number("exposuretime")?.is_none_or(|time| time == 1.0)),
            ("maxcomponentvalue", params.find("maxcomponentvalue").is_none()),
        ];
        for (name, usual) in usual {
            if !usual {
                self.import
                    .warn(format!("`{name}` of the film is not supported, so it has no effect"));
            }
        }
        self.warn_unused(params, "the film");
        Ok(())
    }

    /// The directive `PixelFilter`.
    pub(crate) fn pixel_filter(&mut self, class: &str, params: &Params) -> Result<(), String> {
        let [x, y] = [params.number("xradius")?, params.number("yradius")?];
        if x.is_some() && y.is_some() && x != y {
            self.import.warn(
                "filters of different width and height are not supported, so the width counts",
            );
        }
        let radius = |usual: f64| x.or(y).unwrap_or(usual).clamp(0.1, 16.0) as f32;
        let number = |name: &str, usual: f64| -> Result<f32, String> {
            Ok(params.number(name)?.unwrap_or(usual) as f32)
        };
        self.view.filter = Some(match class {
            "box" => {
                if radius(0.5) != 0.5 {
                    self.import.warn(
                        "box filters of other sizes are not supported, so they cover a pixel",
                    );
                }
                PixelFilter::Box
            }
            "triangle" => PixelFilter::Triangle { radius: radius(2.0) },
            "gaussian" => {
                let radius = radius(1.5);
                let asked = number("sigma", 0.5)?;
                let sigma = asked.clamp(0.25 * radius, 16.0);
                if sigma != asked {
                    self.import.warn(
                        "a sigma below a quarter of the filter's radius is not supported, so it is a quarter",
                    );
                }
                PixelFilter::Gaussian { radius, sigma }
            }
            "mitchell" => {
                let third = 1.0 / 3.0;
                let (b, c) = (number("B", third)?, number("C", third)?);
                PixelFilter::Mitchell {
                    radius: radius(2.0),
                    b: b.clamp(0.0, 1.0),
                    c: c.clamp(0.0, 1.0),
                }
            }
            _ => {
                self.import.warn(format!("the filter {class} is not supported, so it is mitchell"));
                params.ignore(&["xradius", "yradius", "tau"]);
                PixelFilter::Mitchell { radius: 2.0, b: 1.0 / 3.0, c: 1.0 / 3.0 }
            }
        });
        self.warn_unused(params, &format!("the filter {class}"));
        Ok(())
    }

    /// The directive `Integrator`. Most integrators of pbrt converge to the image that path tracing gives.
    /// The two that do not are named here.
    pub(crate) fn integrator(&mut self, class: &str, params: &Params) -> Result<(), String> {
        if ["ambientocclusion", "function"].contains(&class) {
            self.import
                .warn(format!("the integrator {class} is not supported, so paths are traced"));
        }
        self.sampling(params)
    }

    /// The numbers of samples and bounces of the directives `Sampler` and `Integrator`.
    pub(crate) fn sampling(&mut self, params: &Params) -> Result<(), String> {
        let most = f64::from(crate::limits::MAX_SPP);
        if let (Some(x), Some(y)) = (params.number("xsamples")?, params.number("ysamples")?) {
            self.view.spp = Some((x * y).clamp(1.0, most) as u32);
        }
        if let Some(spp) = whole(params, "pixelsamples", most)? {
            self.view.spp = Some(spp);
        }
        if let Some(bounces) = params.number("maxdepth")? {
            let most = f64::from(crate::limits::MAX_DEPTH);
            self.view.depth = Some((bounces + 1.0).clamp(1.0, most) as u32);
        }
        Ok(())
    }

    /// Sets the camera and the size of the scene.
    pub(crate) fn finish_view(&mut self) {
        let [width, height] = self.view.size.unwrap_or([1280, 720]);
        let render = &mut self.scene.render;
        (render.width, render.height) = (width, height);
        // The usual values of pbrt.
        (render.spp, render.depth) = (self.view.spp.unwrap_or(16), self.view.depth.unwrap_or(6));
        let Camera { to_scene, fov, half, lens_radius, focal_distance } =
            self.view.camera.take().unwrap_or_default();
        let from = to_scene.translation - self.import.origin;
        let at = affine::point_along(from, to_scene.matrix3 * DVec3::Z);
        // From the shorter side to the height.
        let longer = if width < height { f64::from(height) / f64::from(width) } else { 1.0 };
        let tangent = |fov: f64| crate::math::precise::tan_degrees(0.5 * fov.clamp(0.01, 179.0));
        let vfov = fov.map_or(0.0, |fov| twice_angle_of(tangent(fov) * longer));
        let camera = CameraFile::new(rounded(from), at, vfov as f32);
        let focus = focal_distance.clamp(1e-6, 1e9);
        self.scene.camera = CameraFile {
            up: rounded(to_scene.matrix3 * DVec3::Y),
            parallel: fov.is_none().then_some((2.0 * half * longer) as f32),
            // A camera of pbrt has x on the right, y up and z forward.
            mirrored: to_scene.matrix3.determinant() > 0.0,
            defocus_angle: if fov.is_some() {
                twice_angle_of(lens_radius / focus) as f32
            } else {
                0.0
            },
            focus_distance: focus as f32,
            filter: self.view.filter.unwrap_or(PixelFilter::Gaussian { radius: 1.5, sigma: 0.5 }),
            ..camera
        };
    }
}
