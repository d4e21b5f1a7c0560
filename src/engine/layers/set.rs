//! A set of layers, as settings name it and films hold it.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Combine, Layer, LightParts};
use crate::error::suggestion;
use crate::film::COLOR;

/// The name of colour, which every film has.
const COLOR_NAME: &str = "color";
/// The name of all halves together.
const HALVES: &str = "halves";

/// A set of layers, in the order of [`Layer::ALL`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Layers(Vec<Layer>);

impl Layers {
    /// The layers `layers`, each once.
    pub fn new(layers: impl IntoIterator<Item = Layer>) -> Self {
        let mut layers: Vec<Layer> = layers.into_iter().collect();
        layers.sort_unstable();
        layers.dedup();
        Self(layers)
    }

    /// The layers, in their order.
    pub fn iter(&self) -> impl Iterator<Item = Layer> {
        self.0.iter().copied()
    }

    /// Whether `layer` is one of them.
    pub fn contains(&self, layer: Layer) -> bool {
        self.0.contains(&layer)
    }

    /// Whether the layers contain light.
    pub(in crate::engine) fn have_light(&self) -> bool {
        self.iter().any(|layer| layer.facts().1 == Combine::Light)
    }

    /// Whether some values depend on the surfaces that are hit.
    pub(in crate::engine) fn need_surfaces(&self) -> bool {
        self.iter().any(Layer::needs_surfaces)
    }

    /// Adds the light of sample number `sample` to the sums of its pixel. `scale` is the factor by which clamping
    /// changed its colour.
    pub(in crate::engine) fn add_light(
        &self,
        sums: &mut [f32],
        light: &LightParts,
        sample: u32,
        scale: f32,
    ) {
        let wanted =
            |&(layer, _): &(Layer, usize)| layer.facts().1 == Combine::Light && layer.takes(sample);
        for (layer, place) in self.places().filter(wanted) {
            let light = (layer.of_light(light) * scale).to_array();
            for (sum, light) in sums[place..].iter_mut().zip(light) {
                *sum += light;
            }
        }
    }

    /// Adds the values of the first hit of sample number `sample`, one per channel, to the sums of its pixel.
    pub(in crate::engine) fn add_first_hit(&self, sums: &mut [f32], values: &[f32], sample: u32) {
        for (layer, place) in self.places().filter(|(layer, _)| layer.takes_hit(sample)) {
            for channel in place..place + layer.channels() {
                sums[channel] += values[channel];
            }
        }
    }

    /// Whether the set is empty.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// These layers and those that they need, as a film stores them.
    pub(crate) fn stored(&self) -> Self {
        let of_hits = || self.iter().filter(|layer| layer.facts().1 == Combine::MeanOfHits);
        let hits = of_hits().next().map(|_| Layer::Hits);
        let halves = of_hits().find(|layer| layer.parity().is_some()).map(|_| Layer::HitsEven);
        Self::new(self.iter().chain(hits).chain(halves))
    }

    /// Each layer with the number of its first channel in a film.
    pub(crate) fn places(&self) -> impl Iterator<Item = (Layer, usize)> {
        let mut next = COLOR;
        self.iter().map(move |layer| {
            next += layer.channels();
            (layer, next - layer.channels())
        })
    }

    /// Number of channels of a film of colour and these layers.
    pub(crate) fn channels(&self) -> usize {
        COLOR + self.iter().map(Layer::channels).sum::<usize>()
    }
}

/// Names with commas between them.
impl fmt::Display for Layers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.iter().map(Layer::name).collect();
        f.write_str(&names.join(","))
    }
}

impl FromStr for Layers {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut layers = Vec::new();
        for name in text.split(',').map(str::trim) {
            let shown = Layer::ALL.into_iter().filter(|layer| layer.whole() != Layer::Hits);
            let (halves, others): (Vec<_>, Vec<_>) = shown.partition(|l| l.parity().is_some());
            match others.iter().chain(&halves).find(|layer| layer.name() == name) {
                Some(layer) => layers.push(*layer),
                None if name == HALVES => layers.extend(halves),
                None if name == COLOR_NAME => {}
                None => {
                    let names = others.iter().map(|layer| layer.name()).chain([COLOR_NAME, HALVES]);
                    return Err(format!("unknown layer `{name}`{}", suggestion(name, names)));
                }
            }
        }
        Ok(Self::new(layers))
    }
}

impl Serialize for Layers {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.is_empty() {
            true => serializer.serialize_none(),
            false => serializer.collect_str(self),
        }
    }
}

impl<'de> Deserialize<'de> for Layers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = Option::<String>::deserialize(deserializer)?;
        text.map_or(Ok(Self::default()), |text| text.parse().map_err(serde::de::Error::custom))
    }
}
