//! Tests of OpenEXR files.

use std::io::Cursor;
use std::path::Path;

use ::exr::meta::attribute::{AttributeValue, IntegerBounds};
use ::exr::prelude::{
    AnyChannel, AnyChannels, Encoding as Stored, FlatSamples, Image as Exr, ImageAttributes, Layer,
    LayerAttributes, WritableImage,
};

use super::*;

type Part<'a> = (&'a str, &'a [(&'a str, f32)]);

/// A file of 2 × 1 pixels with these parts, whose channels have one value each.
fn exr(parts: &[Part<'_>], change: impl Fn(&mut LayerAttributes)) -> Vec<u8> {
    let layer = |&(name, channels): &Part<'_>| {
        let channel =
            |&(name, value): &(&str, f32)| AnyChannel::new(name, FlatSamples::F32(vec![value; 2]));
        let channels = AnyChannels::sort(channels.iter().map(channel).collect());
        let mut attributes = LayerAttributes::named(name);
        change(&mut attributes);
        Layer::new((2, 1), attributes, Stored::UNCOMPRESSED, channels)
    };
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((2, 1)));
    let mut bytes = Cursor::new(Vec::new());
    let image = Exr::from_layers(attributes, parts.iter().map(layer).collect::<Vec<_>>());
    image.write().non_parallel().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// The first pixel of the layer `wanted`.
fn pixel(bytes: &[u8], wanted: Option<&str>) -> Result<Vec<f32>, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.exr");
    std::fs::write(&file, bytes).unwrap();
    let layer = wanted.map_or(String::new(), |wanted| format!(":{wanted}"));
    let path = format!("{}{layer}", file.display());
    let image = decode(&Source::file(Path::new(&path)), Encoding::Auto, &|_| Ok(()));
    let image = image.map_err(|error| error.to_string())?;
    Ok(match image {
        DynamicImage::ImageRgba32F(image) => image.get_pixel(0, 0).0.to_vec(),
        image => image.to_rgb32f().get_pixel(1, 0).0.to_vec(),
    })
}

/// `bytes` with the bytes at `at` after the first `mark` replaced.
fn patched(mut bytes: Vec<u8>, mark: &[u8], at: usize, new: &[u8]) -> Vec<u8> {
    let begin = bytes.windows(mark.len()).position(|part| part == mark).unwrap() + mark.len() + at;
    bytes[begin..begin + new.len()].copy_from_slice(new);
    bytes
}

const RGB: &[(&str, f32)] = &[("R", 0.1), ("G", 0.2), ("B", 0.3)];

/// Names as Blender, Houdini, Arnold and Nuke write them.
#[test]
fn the_picture_itself_is_chosen_among_layers_and_parts() {
    let one = |channels: &[(&str, f32)]| exr(&[("a", channels)], |_| ());
    let first = |bytes: &[u8]| pixel(bytes, None).unwrap();
    assert_eq!(first(&one(RGB)), [0.1, 0.2, 0.3]);
    assert_eq!(first(&one(&[("Y", 0.5)])), [0.5; 3]);
    assert_eq!(first(&one(&[("V", 0.5), ("A", 0.25)])), [0.5, 0.5, 0.5, 0.25]);
    assert_eq!(first(&one(&[("Z", 7.0)])), [7.0; 3]);
    let blender = [
        ("View.AO.R", 1.0),
        ("View.AO.G", 1.0),
        ("View.AO.B", 1.0),
        ("View.Combined.R", 0.1),
        ("View.Combined.G", 0.2),
        ("View.Combined.B", 0.3),
        ("View.Combined.A", 1.0),
        ("View.Depth.V", 9.0),
        ("View.Normal.X", 0.0),
        ("View.Normal.Y", 0.5),
        ("View.Normal.Z", 1.0),
    ];
    let blender = one(&blender);
    assert_eq!(first(&blender), [0.1, 0.2, 0.3, 1.0]);
    for (name, want) in [
        ("View.AO", [1.0; 3]),
        ("AO", [1.0; 3]),
        ("View.Depth", [9.0; 3]),
        ("View.Normal", [0.0, 0.5, 1.0]),
        ("View.Combined.G", [0.2; 3]),
    ] {
        assert_eq!(pixel(&blender, Some(name)).unwrap(), want, "{name}");
    }
    let error = pixel(&blender, Some("Norml")).unwrap_err();
    assert!(error.contains("it has no layer `Norml`"), "{error}");
    // Without a layer before layers, and by the names of parts.
    let both = [RGB, &[("Beauty.R", 1.0), ("Beauty.G", 1.0), ("Beauty.B", 1.0)]].concat();
    assert_eq!(first(&one(&both)), [0.1, 0.2, 0.3]);
    let other: &[(&str, f32)] = &[("R", 1.0), ("G", 1.0), ("B", 1.0)];
    let parts = exr(&[("depth", &[("Z", 5.0)]), ("N", other), ("rgba", RGB)], |_| ());
    assert_eq!(first(&parts), [0.1, 0.2, 0.3]);
    assert_eq!(pixel(&parts, Some("N")).unwrap(), [1.0; 3]);
    assert_eq!(pixel(&parts, Some("depth")).unwrap(), [5.0; 3]);
    assert_eq!(first(&exr(&[("left", RGB), ("right", other)], |_| ())), [0.1, 0.2, 0.3]);
}

#[test]
fn long_headers_are_read_and_many_attributes_are_not() {
    let long = |all: &mut LayerAttributes| all.comments = Some(Text::from(&*"a".repeat(200_000)));
    assert_eq!(pixel(&exr(&[("a", RGB)], long), None).unwrap(), [0.1, 0.2, 0.3]);
    let many = |all: &mut LayerAttributes| {
        let attribute = |n| (Text::from(&*format!("a{n}")), AttributeValue::F32(0.0));
        all.other.extend((0..10_000).map(attribute));
    };
    let error = pixel(&exr(&[("a", RGB)], many), None).unwrap_err();
    assert!(error.contains("too many attributes (at most 8192"), "{error}");
}

/// OpenEXR 3.5 numbers HTJ2K 10 and 11, and ZSTD 13.
#[test]
fn kinds_that_the_decoder_lacks_are_unsupported_by_name() {
    let rgb = || exr(&[("a", RGB)], |_| ());
    let fails = |bytes: &[u8], message: &str| {
        let error = pixel(bytes, None).unwrap_err();
        assert!(error.contains(&format!("unsupported image: {message}")), "{error}");
    };
    for (method, name) in
        [(10, "HTJ2K,"), (11, "HTJ2K,"), (13, "ZSTD,"), (12, "number 12"), (200, "number 200")]
    {
        let bytes = patched(rgb(), b"compression\0compression\0", 4, &[method]);
        fails(&bytes, &format!("its compression is {name}"));
    }
    let cube = |all: &mut LayerAttributes| all.environment_map = Some(EnvironmentMap::Cube);
    fails(&exr(&[("a", RGB)], cube), "it is a cube map");
    let chroma = exr(&[("a", &[("BY", 0.0), ("RY", 0.0), ("Y", 0.5)])], |_| ());
    fails(&chroma, "it has luminance and chroma");
    fails(&patched(chroma, b"RY\0", 8, &[2, 0, 0, 0, 2]), "it has luminance and chroma");
    fails(&patched(rgb(), b"G\0", 8, &[2]), "its channels have different resolutions");
    fails(&exr(&[("a", &[("U", 0.0), ("V", 0.0)])], |_| ()), "it has no colours or greys");
    let error = pixel(&rgb()[..300], None).unwrap_err();
    assert!(error.contains("damaged image"), "{error}");
}

#[test]
fn counts_of_values_that_a_block_cannot_have_are_rejected() {
    let file = |channels: &[(&str, f32)]| {
        let channel = |&(name, value): &(&str, f32)| {
            AnyChannel::new(name, FlatSamples::F32(vec![value; 256]))
        };
        let channels = AnyChannels::sort(channels.iter().map(channel).collect());
        let stored = Stored { compression: Compression::DWAA(None), ..Stored::UNCOMPRESSED };
        let layer = Layer::new((16, 16), LayerAttributes::default(), stored, channels);
        let mut bytes = Cursor::new(Vec::new());
        Exr::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    };
    let good = file(RGB);
    let found = pixel(&good, None).unwrap();
    assert!(found.iter().zip([0.1, 0.2, 0.3]).all(|(a, b)| (a - b).abs() < 0.01), "{found:?}");
    // The only block begins with its row and its size. The ninth number after them counts values.
    let begin = good.len() - block_length(&good);
    let mut bad = good;
    bad[begin + 8 * 8 + 5] = 1;
    let error = pixel(&bad, None).unwrap_err();
    assert!(error.contains("damaged image") && error.contains("too many values"), "{error}");
}

/// The length of the only block of a file, which ends it.
fn block_length(file: &[u8]) -> usize {
    let is_length = |length: &usize| {
        let at = file.len() - length - 4;
        u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize == *length
    };
    (88..file.len() - 300).find(is_length).unwrap()
}
