//! Chooses the colours of an OpenEXR file among its parts and layers.

use std::collections::BTreeMap;

use exr::meta::attribute::ChannelList;
use exr::meta::header::Header;

use crate::error::suggestion;

/// Names that renderers give to the layer or part with the picture itself: Blender writes `ViewLayer.Combined`,
/// Houdini `C`, Arnold `RGBA`, RenderMan `Ci`.
const BEAUTY: [&str; 9] =
    ["combined", "beauty", "rgba", "rgb", "c", "ci", "color", "main", "image"];

/// Channels of one part that make an image.
pub(super) struct ExrLayer {
    /// The number of the part.
    pub(super) part: usize,
    /// The numbers of the channels for red, green and blue.
    pub(super) colors: [usize; 3],
    pub(super) alpha: Option<usize>,
    /// What the channels are, the best first.
    pub(super) kind: Kind,
    /// The names of the layers in the part and of the part.
    prefix: String,
    name: Option<String>,
    /// How well the names suggest that this is the picture itself; 0 is best.
    rank: u8,
}

/// What the channels of a layer are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    Colors,
    /// `Y`, or `V`, as Blender calls it.
    Grey,
    /// The luminance of colours whose chroma is in the channels `RY` and `BY`.
    Luma,
    /// One channel of any name, such as a depth.
    Number,
    /// `X`, `Y` and `Z`.
    Vector,
}

/// The image that a file shows: the layer called `wanted`, or else colours before greys, and among these those
/// without a layer, then those that are called like a picture, then the first.
pub(super) fn choose(headers: &[Header], wanted: Option<&str>) -> Result<ExrLayer, String> {
    let mut layers = layers(headers);
    if let Some(wanted) = wanted {
        if layers.iter().any(|layer| layer.is_called(wanted)) {
            layers.retain(|layer| layer.is_called(wanted));
        } else if let Some(channel) = channel(headers, wanted) {
            return Ok(channel);
        } else {
            let names: Vec<String> = layers.iter().filter_map(ExrLayer::shown).collect();
            let known = suggestion(wanted, names.iter().map(String::as_str));
            return Err(format!("it has no layer `{wanted}`{known}"));
        }
    }
    let best = layers.into_iter().min_by_key(|layer| (layer.kind, layer.rank));
    best.ok_or_else(|| {
        let names = headers.iter().flat_map(|header| &header.channels.list);
        let names: Vec<String> = names.take(8).map(|channel| channel.name.to_string()).collect();
        format!(
            "unsupported image: it has no colours or greys, but the channels {}",
            names.join(", ")
        )
    })
}

/// All layers, part by part.
fn layers(headers: &[Header]) -> Vec<ExrLayer> {
    let mut layers = Vec::new();
    for (part, header) in headers.iter().enumerate() {
        let name = header.own_attributes.layer_name.as_ref().map(ToString::to_string);
        let mut channels: BTreeMap<String, Vec<(String, usize)>> = BTreeMap::new();
        for (number, channel) in header.channels.list.iter().enumerate() {
            let full = channel.name.to_string();
            let (prefix, own) = full.rsplit_once('.').unwrap_or(("", &full));
            let channels = channels.entry(prefix.to_owned()).or_default();
            channels.push((own.to_ascii_lowercase(), number));
        }
        for (prefix, channels) in channels {
            let Some((kind, colors)) = kind(&channels) else { continue };
            let alpha = find(&channels, &["a", "alpha"]);
            let is_beauty = |name: &str| {
                // The name of a view may come last.
                name.to_ascii_lowercase().split('.').any(|word| BEAUTY.contains(&word))
            };
            let named = name.as_deref().is_some_and(is_beauty);
            let rank = match prefix.is_empty() {
                true if named || headers.len() == 1 => 0,
                _ if named || is_beauty(&prefix) => 1,
                true => 2,
                false => 3,
            };
            layers.push(ExrLayer { part, colors, alpha, kind, prefix, name: name.clone(), rank });
        }
    }
    layers
}

fn find(channels: &[(String, usize)], names: &[&str]) -> Option<usize> {
    let found = channels.iter().find(|(name, _)| names.contains(&&**name));
    found.map(|&(_, number)| number)
}

fn kind(channels: &[(String, usize)]) -> Option<(Kind, [usize; 3])> {
    let find = |names: &[&str]| find(channels, names);
    let three = |r: Option<usize>, g: Option<usize>, b: Option<usize>| Some([r?, g?, b?]);
    if let Some(colors) = three(find(&["r", "red"]), find(&["g", "green"]), find(&["b", "blue"])) {
        return Some((Kind::Colors, colors));
    }
    let [x, y, z] = ["x", "y", "z"].map(|name| find(&[name]));
    match (three(x, y, z), y, find(&["v"])) {
        (Some(vector), ..) => return Some((Kind::Vector, vector)),
        (None, Some(y), _) if find(&["ry"]).or(find(&["by"])).is_some() => {
            return Some((Kind::Luma, [y; 3]));
        }
        (None, Some(y), _) if x.is_none() => return Some((Kind::Grey, [y; 3])),
        (None, None, Some(v)) if find(&["u"]).is_none() => return Some((Kind::Grey, [v; 3])),
        _ => {}
    }
    let mut others = channels.iter().filter(|(name, _)| name != "a" && name != "alpha");
    match (others.next(), others.next()) {
        (Some(&(_, only)), None) => Some((Kind::Number, [only; 3])),
        _ => None,
    }
}

/// The channel with this full name, as a grey image.
fn channel(headers: &[Header], wanted: &str) -> Option<ExrLayer> {
    let find = |channels: &ChannelList| channels.list.iter().position(|c| c.name.eq(wanted));
    let (part, number) = (headers.iter().enumerate())
        .find_map(|(part, header)| Some((part, find(&header.channels)?)))?;
    let (prefix, name, alpha) = (wanted.to_owned(), None, None);
    Some(ExrLayer { part, colors: [number; 3], alpha, kind: Kind::Number, prefix, name, rank: 0 })
}

impl ExrLayer {
    /// Whether `name` is the name of the layer, of its part, or of both, or the end of one of them.
    fn is_called(&self, name: &str) -> bool {
        let (layer, part) = (self.prefix.as_str(), self.name.as_deref().unwrap_or_default());
        let both = format!("{part}.{layer}");
        both == name
            || [layer, part]
                .iter()
                .any(|own| *own == name || own.rsplit_once('.').is_some_and(|(_, end)| end == name))
    }

    /// Its name in messages.
    fn shown(&self) -> Option<String> {
        match (self.prefix.as_str(), &self.name) {
            ("", None) => None,
            ("", Some(part)) => Some(part.clone()),
            (prefix, _) => Some(prefix.to_owned()),
        }
    }
}
