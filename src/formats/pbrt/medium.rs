//! Media of pbrt files.

use super::{Params, Reader};

/// A homogeneous medium.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Medium {
    /// Absorption coefficient per unit of length in the scene.
    pub(crate) absorption: [f64; 3],
    /// Scattering coefficient per unit of length in the scene.
    scattering: [f64; 3],
}

impl Medium {
    pub(crate) fn scatters(&self) -> bool {
        self.scattering != [0.0; 3]
    }

    /// The mean density, and the albedo.
    pub(crate) fn mean(&self) -> (f32, [f32; 3]) {
        let sum = |i: usize| self.absorption[i] + self.scattering[i];
        let density = (sum(0) + sum(1) + sum(2)) / 3.0;
        let albedo =
            |i: usize| (self.scattering[i] / sum(i).clamp(1e-9, 1e9)).clamp(0.0, 1.0) as f32;
        (density.clamp(1e-9, 1e6) as f32, [albedo(0), albedo(1), albedo(2)])
    }
}

impl Reader<'_, '_> {
    /// The medium called `name`.
    pub(crate) fn medium(&self, name: &str) -> Result<Medium, String> {
        self.media.get(name).copied().ok_or_else(|| format!("unknown medium \"{name}\""))
    }

    /// The directive `MakeNamedMedium`.
    pub(crate) fn make_medium(&mut self, name: &str, params: &Params) -> Result<(), String> {
        let class = params.text("type")?.unwrap_or("homogeneous").to_owned();
        if class != "homogeneous" {
            self.import.warn(format!(
                "media of the type {class} are not supported, so they are homogeneous"
            ));
        }
        let scale = params.number("scale")?.unwrap_or(1.0);
        let mut coefficient = |name: &str, usual: [f64; 3]| -> Result<[f64; 3], String> {
            let rgb = params.find(name).map_or(Ok(usual), |param| self.spectrum(param))?;
            Ok(rgb.map(|c| (c * scale).clamp(0.0, 1e9)))
        };
        // The usual values are those of pbrt's code.
        let absorption = coefficient("sigma_a", [1.0; 3])?;
        let scattering = coefficient("sigma_s", [1.0; 3])?;
        if params.number("g")?.is_some_and(|g| g != 0.0) {
            self.import.warn(
                "media that scatter forward or backward are not supported, so they scatter evenly",
            );
        }
        let sum = [0, 1, 2].map(|i| absorption[i] + scattering[i]);
        if scattering != [0.0; 3] && (sum[0] != sum[1] || sum[0] != sum[2]) {
            self.import.warn("media whose density depends on the colour have their mean density");
        }
        self.warn_unused(params, "media");
        self.media.insert(name.to_owned(), Medium { absorption, scattering });
        Ok(())
    }
}
