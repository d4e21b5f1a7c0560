//! The arguments for the codes of 8-bit files.

use clap::Args;

use super::{IMAGE, named};
use crate::image::{Display, Exposure, MAX_STOPS, ToneMap, Transfer};

#[derive(Clone, Debug, Args)]
pub(crate) struct DisplayArgs {
    /// Transfer curve of 8-bit files
    #[arg(long, value_name = "GAMMA", help_heading = IMAGE, default_value = Transfer::Srgb.name(), value_parser = named(&Transfer::ALL, Transfer::name))]
    gamma: Transfer,
    /// Exposure of 8-bit files: multiplies linear values by 2^STOPS; auto: so that at most a twentieth of the pixels is
    /// clipped
    #[arg(long, value_name = "STOPS|auto", help_heading = IMAGE, default_value = "0", allow_hyphen_values = true, value_parser = exposure)]
    exposure: Exposure,
    /// Tone map of 8-bit files, which compresses bright values instead of clamping them to white
    #[arg(long, value_name = "MAP", help_heading = IMAGE, default_value = ToneMap::None.name(), value_parser = named(&ToneMap::ALL, ToneMap::name))]
    tonemap: ToneMap,
    /// Write layers to EXR files as 16-bit floats, apart from colour and from numbers of instances and materials
    #[arg(long, help_heading = IMAGE)]
    half_layers: bool,
}

fn exposure(text: &str) -> Result<Exposure, String> {
    if text == "auto" {
        return Ok(Exposure::Auto);
    }
    let stops = text.parse().ok().filter(|stops: &f32| stops.abs() <= MAX_STOPS);
    let wrong = || format!("must be auto or a number from -{MAX_STOPS} to {MAX_STOPS}");
    stops.map(Exposure::Stops).ok_or_else(wrong)
}

impl DisplayArgs {
    pub(crate) fn display(&self) -> Display {
        Display {
            exposure: self.exposure,
            tone_map: self.tonemap,
            transfer: self.gamma,
            half_layers: self.half_layers,
        }
    }
}
