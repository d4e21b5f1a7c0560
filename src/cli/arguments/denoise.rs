//! The argument for denoising, and what it needs of a render.

use std::mem;
use std::time::Instant;

use clap::Args;

use super::{IMAGE, named};
use crate::denoise::Denoise;
use crate::engine::{FirstHits, ImageSettings, Layer, Layers, Pin, Pool, Session, threads_for};
use crate::error::{Error, Result};
use crate::image::{Image, Metadata};

/// The metadata keys of the quality, of the library's version, and of the hash of the denoised image.
const QUALITY_KEY: &str = "ptfast:denoise";
const LIBRARY_KEY: &str = "ptfast:oidn";
pub(crate) const HASH_KEY: &str = "ptfast:denoised";
/// The key of the layers that were asked for, besides those that denoising needs.
const LAYERS_KEY: &str = "ptfast:layers";

/// The layers that denoising uses: first what all qualities use. The odd halves of features follow from the others.
const LAYERS: [Layer; 8] = [
    Layer::Albedo,
    Layer::Normal,
    Layer::ColorEven,
    Layer::ColorOdd,
    Layer::Depth,
    Layer::AlbedoEven,
    Layer::NormalEven,
    Layer::DepthEven,
];

/// Those of [`LAYERS`] that a quality uses, or the estimate of its error.
pub(crate) fn layers_of(quality: Denoise) -> &'static [Layer] {
    match quality {
        Denoise::Oidn => &LAYERS[..4],
        Denoise::Fast => &LAYERS[..5],
        Denoise::Good => &LAYERS,
    }
}

#[derive(Clone, Debug, Args)]
pub(crate) struct DenoiseArgs {
    /// Remove the noise of the picture. An .exr keeps the noisy picture as the layer `noisy`; layers hold the first
    /// hit behind smooth mirrors and clear glass. oidn is Open Image Denoise 2, which must be installed: PTFAST_OIDN
    /// names its library or the folder of it [default quality: good]
    #[arg(long, value_name = "QUALITY", help_heading = IMAGE, num_args = 0..=1, require_equals = true, default_missing_value = Denoise::Good.name(), value_parser = named(&Denoise::ALL, Denoise::name))]
    pub(crate) denoise: Option<Denoise>,
}

/// How an image was denoised.
pub(crate) struct Denoised {
    quality: Denoise,
    asked: Layers,
    /// The version of the library that was used.
    library: Option<String>,
    /// The hash of the denoised image, if it is the same on all machines.
    pub(crate) hash: Option<String>,
    pub(crate) seconds: f64,
}

impl Denoised {
    /// Adds how an image was denoised, if it was, to the metadata of its file.
    pub(crate) fn noted(denoised: Option<&Self>, metadata: Metadata) -> Metadata {
        let Some(Self { quality, asked, library, hash, .. }) = denoised else { return metadata };
        let metadata = metadata.with(QUALITY_KEY, quality.name()).with(LAYERS_KEY, asked);
        let more = [(LIBRARY_KEY, library), (HASH_KEY, hash)];
        more.into_iter().fold(metadata, |metadata, (key, value)| match value {
            Some(value) => metadata.with(key, value),
            None => metadata,
        })
    }
}

impl DenoiseArgs {
    /// Checks that a library that denoising needs can be used, before anything takes time.
    ///
    /// # Errors
    /// Those of [`Denoise::library`].
    pub(crate) fn check(&self) -> Result<()> {
        self.denoise.map(Denoise::library).transpose().map(|_| ())
    }

    /// Adds what denoising needs to the settings of a render.
    ///
    /// # Errors
    /// [`Error::Usage`] if pixels have too few samples.
    pub(crate) fn prepare(&self, settings: &mut ImageSettings) -> Result<()> {
        let Some(quality) = self.denoise else { return Ok(()) };
        if quality == Denoise::Good && settings.spp < 2 {
            let message = "--denoise compares two halves of the samples: use --spp 2 or more, or --denoise=fast";
            return Err(Error::Usage(message.to_owned()));
        }
        settings.first_hit = FirstHits::Through;
        let needed = layers_of(quality).iter().copied();
        let needed = needed.filter(|layer| settings.spp > 1 || !layer.is_half());
        settings.layers = Layers::new(settings.layers.iter().chain(needed));
        Ok(())
    }

    /// Whether a file with this metadata was denoised as it is asked for, and has the layers `asked`.
    pub(crate) fn is_noted_in(&self, metadata: &Metadata, asked: &Layers) -> bool {
        let asked = self.denoise.map(|_| asked.to_string());
        metadata.get(QUALITY_KEY) == self.denoise.map(Denoise::name)
            && metadata.get(LAYERS_KEY) == asked.as_deref()
    }

    /// About the seconds that denoising `pixels` takes with `threads` threads, 0 for one per available core.
    pub(crate) fn seconds(&self, pixels: u64, threads: u32) -> f64 {
        let per_pixel = match self.denoise {
            None => 0.0,
            Some(Denoise::Fast) => 1e-7,
            Some(Denoise::Good) => 1.2e-6,
            Some(Denoise::Oidn) => 3.5e-6,
        };
        per_pixel * pixels as f64 / threads_for(threads) as f64
    }

    /// An estimate of the relative error of the denoised picture of `session`, if there is one.
    ///
    /// # Errors
    /// Those of [`Image::denoised_noise`], [`Error::Resource`] if memory runs out or threads cannot be started.
    pub(crate) fn noise(&self, session: &Session) -> Result<Option<f64>> {
        let Some(quality) = self.denoise else { return Ok(None) };
        let image = session.snapshot_of(&Layers::new(layers_of(quality).iter().copied()))?;
        let threads = session.renderer().compute_settings().threads;
        Pool::start(threads, Pin::Off)?.install(|| image.denoised_noise(quality))
    }

    /// The layers of films with these settings that denoising uses.
    ///
    /// # Errors
    /// [`Error::Usage`] if they lack halves that it needs.
    pub(crate) fn layers(&self, settings: &ImageSettings) -> Result<Layers> {
        let stored = settings.stored_layers();
        let halves = stored.contains(Layer::ColorEven) && stored.contains(Layer::ColorOdd);
        if self.denoise == Some(Denoise::Good) && !halves {
            let message = "--denoise: the parts lack halves of their samples: render them with --layers \
                           halves,albedo,normal,depth --first-hit through, or use --denoise=fast";
            return Err(Error::Usage(message.to_owned()));
        }
        let wanted = self.denoise.map_or(&[][..], layers_of).iter().copied();
        Ok(Layers::new(wanted.filter(|layer| stored.contains(*layer))))
    }

    /// Denoises `image` with `threads` threads, if that is asked for. Of its layers, those that are `asked` for remain,
    /// and with `keeps_noisy` also what the image was.
    ///
    /// # Errors
    /// [`Error::Usage`] if the image lacks layers, [`Error::Resource`] if threads cannot be started.
    pub(crate) fn apply(
        &self,
        image: &mut Image,
        threads: u32,
        asked: &Layers,
        keeps_noisy: bool,
    ) -> Result<Option<Denoised>> {
        let Some(quality) = self.denoise else { return Ok(None) };
        let start = Instant::now();
        let pool = Pool::start(threads, Pin::Off)?;
        let library = quality.library()?;
        let noisy = mem::replace(image, Image::new(0, 0));
        let keeps = |name: &str| {
            asked.iter().any(|layer| layer.name() == name) || keeps_noisy && name == "noisy"
        };
        *image = pool.install(|| noisy.denoised(quality))?.only(keeps);
        let hash = library.is_none().then(|| image.hash());
        let seconds = start.elapsed().as_secs_f64();
        Ok(Some(Denoised { quality, asked: asked.clone(), library, hash, seconds }))
    }
}
