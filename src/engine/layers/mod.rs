//! Layers: what a film holds of each sample besides its colour, and how the samples of a pixel combine.
//!
//! To add a layer, add it to the enum, its name, [`Layer::facts`] and [`Layer::of_hit`] or
//! [`Layer::of_light`].

mod set;

pub use self::set::Layers;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::first_hit::FirstHit;
use crate::math::{Mask, Real};
use crate::shading::texture::TexturePoint;

/// Values of an image besides its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Layer {
    /// Share of the samples whose camera ray meets a surface or a medium. All samples count equally, also with a
    /// pixel filter that gives some a negative weight: with these weights, pixels without a surface would not
    /// be quite transparent.
    Alpha,
    /// About the share of light that the first hit scatters, per channel in [0, 1].
    Albedo,
    /// Shading normal of the first hit in world space, on the side that was hit; 0 in media.
    Normal,
    /// Distance of the first hit from the camera, along the direction of view.
    Depth,
    /// Position of the first hit in world space.
    Position,
    /// Texture coordinates of the first hit; 0 in media.
    Uv,
    /// Light that reaches the camera after it was scattered once.
    Direct,
    /// Light that reaches the camera after it was scattered more than once.
    Indirect,
    /// Light that surfaces emit towards the camera.
    Emission,
    /// Light of the background that reaches the camera directly.
    Background,
    /// Number of the instance of the first hit, from 1; 0 for surfaces that are not in an instance.
    Instance,
    /// Number of the material of the first hit, from 1; 0 in media.
    Material,
    /// Number of samples.
    Samples,
    /// Colour of the samples with even numbers.
    ColorEven,
    /// Colour of the samples with odd numbers.
    ColorOdd,
    /// `Albedo` of the samples with even numbers.
    AlbedoEven,
    /// `Albedo` of the samples with odd numbers.
    AlbedoOdd,
    /// `Normal` of the samples with even numbers.
    NormalEven,
    /// `Normal` of the samples with odd numbers.
    NormalOdd,
    /// `Depth` of the samples with even numbers.
    DepthEven,
    /// `Depth` of the samples with odd numbers.
    DepthOdd,
    /// Share of the samples that have a first hit, and of those with even numbers: other layers need them.
    #[doc(hidden)]
    Hits,
    #[doc(hidden)]
    HitsEven,
}

names! {
    pub Layer:
    Alpha = "alpha",
    Albedo = "albedo",
    Normal = "normal",
    Depth = "depth",
    Position = "position",
    Uv = "uv",
    Direct = "direct",
    Indirect = "indirect",
    Emission = "emission",
    Background = "background",
    Instance = "instance",
    Material = "material",
    Samples = "samples",
    ColorEven = "color_even",
    ColorOdd = "color_odd",
    AlbedoEven = "albedo_even",
    AlbedoOdd = "albedo_odd",
    NormalEven = "normal_even",
    NormalOdd = "normal_odd",
    DepthEven = "depth_even",
    DepthOdd = "depth_odd",
    Hits = "hits",
    HitsEven = "hits_even",
}

/// How the samples of a pixel combine to its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Combine {
    /// The mean of all samples, with the weights and the clamping of the colour.
    Light,
    /// The mean of all samples.
    Mean,
    /// The mean of the samples that have a first hit; 0 if none has.
    MeanOfHits,
    /// The value of the pixel's first sample.
    First,
    /// The number of samples, which a film knows without a layer.
    Count,
}

/// The light of a sample by the number of times it was scattered.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LightParts {
    pub(crate) unscattered: Vec3,
    /// Whether the unscattered light is that of the background.
    pub(crate) is_background: bool,
    pub(crate) direct: Vec3,
    pub(crate) indirect: Vec3,
    pub(crate) all: Vec3,
}

impl LightParts {
    /// The parts of the light `all`, of which the path had the given light after its first and its second
    /// segment, if it had that many.
    pub(in crate::engine) fn new(is_background: bool, after: [Option<Vec3>; 2], all: Vec3) -> Self {
        let [unscattered, once] = after.map(|light| light.unwrap_or(all));
        let (direct, indirect) = (once - unscattered, all - once);
        Self { unscattered, is_background, direct, indirect, all }
    }
}

/// `value`, or 0 if it is not finite.
#[inline(always)]
pub(super) fn finite<R: Real>(value: R) -> R {
    // False for NaN.
    value.abs().lt(R::INFINITY).select(value, R::ZERO)
}

impl Layer {
    /// The names of the channels, and how samples combine.
    pub(crate) fn facts(self) -> (&'static [&'static str], Combine) {
        const RGB: &[&str] = &["R", "G", "B"];
        const XYZ: &[&str] = &["X", "Y", "Z"];
        match self {
            Self::Alpha => (&["A"], Combine::Mean),
            Self::Albedo => (RGB, Combine::Mean),
            Self::Normal | Self::Position => (XYZ, Combine::MeanOfHits),
            Self::Depth => (&["Z"], Combine::MeanOfHits),
            Self::Uv => (&["U", "V"], Combine::MeanOfHits),
            Self::Direct | Self::Indirect | Self::Emission | Self::Background => {
                (RGB, Combine::Light)
            }
            Self::Instance | Self::Material => (&["ID"], Combine::First),
            Self::Samples => (&["N"], Combine::Count),
            Self::ColorEven | Self::ColorOdd => (RGB, Combine::Light),
            Self::Hits | Self::HitsEven => (&["N"], Combine::Mean),
            half => half.whole().facts(),
        }
    }

    /// The layer of which this one is a half; otherwise this one.
    fn whole(self) -> Self {
        match self {
            Self::AlbedoEven | Self::AlbedoOdd => Self::Albedo,
            Self::NormalEven | Self::NormalOdd => Self::Normal,
            Self::DepthEven | Self::DepthOdd => Self::Depth,
            Self::HitsEven => Self::Hits,
            whole => whole,
        }
    }

    /// Whether only every second sample counts.
    pub(crate) fn is_half(self) -> bool {
        self.parity().is_some()
    }

    /// The parity of the samples that count, 0 or 1; `None` if all do.
    pub(in crate::engine) fn parity(self) -> Option<u32> {
        match self {
            Self::ColorEven | Self::AlbedoEven | Self::NormalEven | Self::DepthEven => Some(0),
            Self::HitsEven => Some(0),
            Self::ColorOdd | Self::AlbedoOdd | Self::NormalOdd | Self::DepthOdd => Some(1),
            _ => None,
        }
    }

    /// Whether sample number `sample` counts.
    pub(in crate::engine) fn takes(self, sample: u32) -> bool {
        self.parity().is_none_or(|parity| sample % 2 == parity)
    }

    /// Whether the first hit of sample number `sample` counts.
    pub(in crate::engine) fn takes_hit(self, sample: u32) -> bool {
        let is_of_hit = match self.facts().1 {
            Combine::Light | Combine::Count => false,
            Combine::First => sample == 0,
            Combine::Mean | Combine::MeanOfHits => true,
        };
        is_of_hit && self.takes(sample)
    }

    /// Number of channels of a film.
    pub(in crate::engine) fn channels(self) -> usize {
        if self == Self::Samples { 0 } else { self.facts().0.len() }
    }

    /// Whether its values depend on the surface that is hit.
    fn needs_surfaces(self) -> bool {
        let (_, combine) = self.facts();
        self != Self::Alpha && !matches!(combine, Combine::Light | Combine::Count)
    }

    /// The value of a sample with this first hit, in the first channels.
    #[inline(always)]
    pub(in crate::engine) fn of_hit<R: Real>(self, hit: &FirstHit<'_, R>) -> [R; 3] {
        let one = |number: R| [number, R::ZERO, R::ZERO];
        let all = |v: R::Vec3| [v[0], v[1], v[2]];
        match self.whole() {
            Self::Alpha => one(if hit.covers { R::ONE } else { R::ZERO }),
            Self::Hits => one(if hit.exists { R::ONE } else { R::ZERO }),
            Self::Albedo => all(hit.albedo),
            Self::Normal => all(hit.normal),
            Self::Depth => one(hit.depth),
            Self::Position => all(hit.position),
            Self::Uv => hit.at.map_or([R::ZERO; 3], |at| {
                let (u, v) = at.uv();
                [u, v, R::ZERO]
            }),
            Self::Instance => one(R::from_word(hit.instance)),
            Self::Material => one(R::from_word(hit.material())),
            // Light and counts.
            _ => [R::ZERO; 3],
        }
    }

    /// The value of a sample with this light; black for layers of the first hit.
    pub(crate) fn of_light(self, light: &LightParts) -> Vec3 {
        match self {
            Self::ColorEven | Self::ColorOdd => light.all,
            Self::Direct => light.direct,
            Self::Indirect => light.indirect,
            Self::Emission if !light.is_background => light.unscattered,
            Self::Background if light.is_background => light.unscattered,
            _ => Vec3::ZERO,
        }
    }
}

/// Which hit layers of the first hit hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "Option<&'static str>", try_from = "Option<String>")]
pub enum FirstHits {
    /// That of the camera ray.
    #[default]
    Surface,
    /// The first one that is neither a perfectly smooth mirror nor clear glass.
    Through,
}

names! { pub FirstHits: Surface = "surface", Through = "through" }

/// The default is written as null, like other settings that are off.
impl From<FirstHits> for Option<&'static str> {
    fn from(hits: FirstHits) -> Self {
        (hits != FirstHits::Surface).then_some(hits.name())
    }
}

impl TryFrom<Option<String>> for FirstHits {
    type Error = &'static str;

    fn try_from(name: Option<String>) -> Result<Self, &'static str> {
        match name.as_deref() {
            None | Some("surface") => Ok(Self::Surface),
            Some("through") => Ok(Self::Through),
            Some(_) => Err("must be \"through\" or null"),
        }
    }
}
