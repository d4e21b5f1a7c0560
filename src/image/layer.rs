//! Layers of an image besides its colour.

use super::Image;
use crate::error::{Error, Result};

/// Values of each pixel besides its colour.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageLayer {
    pub(crate) name: &'static str,
    pub(crate) channels: &'static [&'static str],
    /// Whether files always hold the values as 32-bit floats, because 16 bits would not tell numbers of things apart.
    pub(crate) numbers: bool,
    pub(crate) values: Vec<[f32; 3]>,
}

impl ImageLayer {
    /// The name.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// The names of the channels, one to three.
    pub fn channels(&self) -> &'static [&'static str] {
        self.channels
    }

    /// The values of all pixels, row by row from the top. Numbers beyond the channels are 0.
    pub fn values(&self) -> &[[f32; 3]] {
        &self.values
    }
}

impl Image {
    /// The image with these layers, which are written to the same EXR file, or in other formats to files of
    /// their own.
    #[must_use]
    pub(crate) fn with_layers(self, layers: Vec<ImageLayer>) -> Self {
        Self { layers, ..self }
    }

    /// The image with other colours, and its colours as a layer of this name, without loss.
    #[must_use]
    pub(crate) fn replaced(mut self, pixels: Vec<[f32; 3]>, name: &'static str) -> Self {
        let values = std::mem::replace(&mut self.pixels, pixels);
        let layer = ImageLayer { name, channels: &["R", "G", "B"], numbers: true, values };
        self.layers.retain(|layer| layer.name != name);
        self.layers.push(layer);
        self
    }

    /// The image with only those layers whose names `keeps` accepts.
    #[must_use]
    pub(crate) fn only(mut self, keeps: impl Fn(&str) -> bool) -> Self {
        self.layers.retain(|layer| keeps(layer.name));
        self
    }

    /// Makes room for `pixels` pixels in all.
    ///
    /// # Errors
    /// [`Error::Resource`] if there is not enough memory.
    pub(crate) fn reserve(&mut self, pixels: usize) -> Result<()> {
        let lists = self.layers.iter_mut().map(|layer| &mut layer.values);
        for list in lists.chain([&mut self.pixels]) {
            list.try_reserve_exact(pixels - list.len()).map_err(|_| {
                Error::Resource(format!("not enough memory for an image of {pixels} pixels"))
            })?;
        }
        Ok(())
    }

    /// `above` with `below` under it, both of the same width and with the same layers.
    pub(crate) fn above(above: Self, below: Self) -> Self {
        let mut image = Self { height: above.height + below.height, ..above };
        image.pixels.extend(below.pixels);
        image.alpha.extend(below.alpha);
        for (layer, below) in image.layers.iter_mut().zip(below.layers) {
            layer.values.extend(below.values);
        }
        image
    }

    /// The layer of this name, if the image has it.
    pub fn layer(&self, name: &str) -> Option<&ImageLayer> {
        self.layers.iter().find(|layer| layer.name == name)
    }

    /// The layers besides colour.
    pub fn layers(&self) -> &[ImageLayer] {
        &self.layers
    }

    /// The layer as an image of three channels, of the same size.
    pub fn layer_image(&self, layer: &ImageLayer) -> Self {
        Self::from_pixels(self.width, self.height, layer.values.clone())
    }
}
