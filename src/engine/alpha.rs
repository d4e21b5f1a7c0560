//! The alpha channel of images without a background.

use super::{ComputeSettings, ImageSettings, Observer, RenderState, Renderer, View};
use crate::error::Result;
use crate::film::Film;

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
        let image = ImageSettings { depth: 1, clamp: None, ..self.image_settings().clone() };
        let coverage = self.with_view(|prepared, compute| {
            let compute = ComputeSettings { timeline: false, ..compute.clone() };
            View::new(prepared, image, compute).alone()
        })?;
        coverage.advance(&mut rendering, observer)?;
        if rendering.film.samples_done() < rendering.film.samples_to_do() {
            return Ok(None);
        }
        let alpha = |beyond: &[f32; 3]| 1.0 - beyond[0];
        Ok(Some(rendering.image()?.pixels().iter().map(alpha).collect()))
    }
}
