//! The alpha channel of images without a background.

use super::backdrop::Backdrop;
use super::observer::Observer;
use super::renderer::Renderer;
use super::settings::RenderSettings;
use super::state::RenderState;
use crate::error::Result;
use crate::film::Film;

impl RenderSettings {
    /// The settings that render 1 - alpha of the image of these settings.
    #[must_use]
    pub fn of_alpha(&self) -> Self {
        let clamp = f32::INFINITY;
        Self { backdrop: Backdrop::Alone, depth: 1, clamp, timeline: false, ..self.clone() }
    }
}

impl Renderer {
    /// Renders the alpha channel of the pixels and samples of `film`, which is empty: for each
    /// pixel, row by row, the fraction of its samples, in [0, 1], whose camera rays meet a surface or
    /// a medium. All samples count equally, also with a pixel filter that gives some a negative weight: with
    /// these weights, pixels without a surface would not be quite transparent. The numbers depend on the same
    /// settings as the image.
    ///
    /// Returns `None` if `observer` stops the render.
    ///
    /// # Errors
    /// If memory runs out, returns [`Error::Resource`](crate::Error::Resource).
    pub(crate) fn alpha(&self, film: Film, observer: &dyn Observer) -> Result<Option<Vec<f32>>> {
        let mut rendering = RenderState::new(film);
        self.with(self.settings().of_alpha())?.advance(&mut rendering, observer)?;
        if rendering.film.samples_done() < rendering.film.samples_to_do() {
            return Ok(None);
        }
        let alpha = |beyond: &[f32; 3]| 1.0 - beyond[0];
        Ok(Some(rendering.image()?.pixels().iter().map(alpha).collect()))
    }
}
