//! Tests of exposure and tone maps of 8-bit files.

use std::fs;

use super::succeeds;
use crate::common::{ptfast, stderr, stdout};

#[test]
fn exposure_and_tone_maps_change_png_files_only() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let base = ["render", "cornell", "--width", "24", "--spp", "2", "-q", "-o"];
    let render = |name: &str, more: &[&str]| {
        succeeds(here, &[&base[..], &[name], more].concat());
        fs::read(here.join(name)).unwrap()
    };
    let plain = render("a.png", &[]);
    assert_eq!(render("a.png", &["--exposure", "0", "--tonemap", "none"]), plain);
    let (bright, agx, neutral) =
        (["--exposure", "1.5"], ["--tonemap", "agx"], ["--tonemap", "neutral"]);
    let files = [&bright[..], &agx, &neutral].map(|more| render("b.png", more));
    assert!(files.iter().all(|file| *file != plain));
    assert_eq!(render("b.png", &agx), files[1], "equal renders give equal files");
    let linear = render("a.exr", &[]);
    assert_eq!(render("b.exr", &[&bright[..], &agx].concat()), linear);

    // The linear values of these files are lost.
    for more in [&bright[..], &agx] {
        render("c.png", more);
        let output = ptfast(here, &["compare", "a.exr", "c.png"]);
        let error = stderr(&output);
        assert_eq!(output.status.code(), Some(65), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(error.contains("c.png: has no linear values"), "{error}");
    }
}

#[test]
fn complete_files_have_the_same_exposure_and_tone_map() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let base = ["render", "cornell", "--width", "24", "--spp", "16", "-o"];
    let skips = |more: &[&str]| {
        let skip = ["a.png", "--skip-complete"];
        succeeds(here, &[&base[..], &skip, more].concat()).contains("is complete")
    };
    let both = ["--exposure", "-0.5", "--tonemap", "agx"];
    for options in [&both[..], &["--exposure", "-0.5"], &["--tonemap", "neutral"], &[]] {
        assert!(!skips(options) && skips(options), "{options:?}");
    }

    // Merged parts have the file of the whole render.
    succeeds(here, &[&base[..], &["a.png"], &both].concat());
    for shard in ["0", "1"] {
        let (name, part) = (format!("{shard}.film"), format!("{shard}/2"));
        succeeds(here, &[&base[..], &[&name, "--shard", &part]].concat());
    }
    succeeds(here, &[&["merge", "0.film", "1.film", "-o", "m.png"], &both[..]].concat());
    assert!(fs::read(here.join("m.png")).unwrap() == fs::read(here.join("a.png")).unwrap());
    for wrong in ["33", "NaN", "bright"] {
        let output = ptfast(here, &[&base[..], &["a.png", "--exposure", wrong]].concat());
        let error = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains("must be auto or a number from -32 to 32"), "{error}");
    }
}

#[test]
#[allow(clippy::disallowed_methods)] // libm is the reference
fn transparent_images_have_an_alpha_channel() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let base = ["render", "spheres", "--width", "32", "--spp", "4", "--transparent"];
    let file = |name: &str| here.join(name).to_str().unwrap().to_owned();
    for name in ["a.png", "a.exr"] {
        succeeds(here, &[&base[..], &["-o", name]].concat());
    }
    let png = image::open(file("a.png")).unwrap();
    assert_eq!(png.color(), image::ColorType::Rgba8);
    let png = png.into_rgba8();
    let exr = exr::prelude::read_first_rgba_layer_from_file(
        file("a.exr"),
        |size, _| vec![vec![[0.0f32; 4]; size.width()]; size.height()],
        |rows, place, (r, g, b, alpha): (f32, f32, f32, f32)| {
            rows[place.y()][place.x()] = [r, g, b, alpha];
        },
    );
    let exr = exr.unwrap().layer_data.channel_data.pixels.concat();
    let mut partial = 0;
    for (codes, linear) in png.pixels().zip(exr) {
        let ([.., code], [r, g, b, alpha]) = (codes.0, linear);
        assert_eq!(code, (alpha * 255.0).round() as u8);
        if alpha == 0.0 {
            assert_eq!((codes.0, [r, g, b]), ([0; 4], [0.0; 3]));
        } else if alpha < 1.0 {
            partial += 1;
            // The colours of a PNG file are not multiplied by alpha.
            let srgb = |linear: f32| {
                let linear = f64::from(linear).min(1.0);
                let high = 1.055 * linear.powf(1.0 / 2.4) - 0.055;
                255.0 * if linear <= 0.003_130_8 { 12.92 * linear } else { high }
            };
            let error = f64::from(codes.0[0]) - srgb(r / alpha);
            assert!(error.abs() < 0.51, "{codes:?} {linear:?}");
        }
    }
    assert!(partial > 0 && png.pixels().any(|codes| codes[3] == 0));
    let again = succeeds(here, &[&base[..], &["-o", "a.png", "--skip-complete"]].concat());
    assert!(again.contains("is complete"), "{again}");
    let opaque = succeeds(here, &[&base[..6], &["-o", "a.png", "--skip-complete"]].concat());
    assert!(!opaque.contains("is complete"), "{opaque}");
    let layers = ["-o", "b.exr", "--skip-complete", "--layers", "depth"];
    for half in [&["--half-layers"][..], &[]] {
        for is_complete in [false, true] {
            let text = succeeds(here, &[&base[..], &layers, half].concat());
            assert_eq!(text.contains("is complete"), is_complete, "{half:?}: {text}");
        }
    }

    let output = ptfast(here, &[&base[..], &["-o", "a.pfm"]].concat());
    let error = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("no alpha channel") && error.lines().count() == 1, "{error}");
    assert!(!here.join("a.pfm").exists());
}

/// An EXR file has a channel `layer.channel` for each layer, and other formats have a file for each layer.
#[test]
fn layers_are_written() {
    use exr::prelude::{FlatSamples, read_all_flat_layers_from_file};
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let base = [
        "render",
        "spheres",
        "--width",
        "32",
        "--spp",
        "4",
        "--layers",
        "depth,normal,material,uv",
    ];
    for (name, half) in [("a.exr", false), ("half.exr", true)] {
        let flag = if half { &["--half-layers"][..] } else { &[] };
        succeeds(here, &[&base[..], &["-o", name], flag].concat());
        let file = read_all_flat_layers_from_file(here.join(name)).unwrap();
        let channels = &file.layer_data[0].channel_data.list;
        let names: Vec<String> = channels.iter().map(|c| c.name.to_string()).collect();
        let want = [
            "B",
            "G",
            "R",
            "depth.Z",
            "material.ID",
            "normal.X",
            "normal.Y",
            "normal.Z",
            "uv.U",
            "uv.V",
        ];
        assert_eq!(names, want);
        for channel in channels {
            let name = channel.name.to_string();
            let is_half = matches!(channel.sample_data, FlatSamples::F16(_));
            assert_eq!(is_half, half && name.contains('.') && name != "material.ID", "{name}");
        }
    }
    succeeds(here, &[&base[..], &["-o", "b.pfm"]].concat());
    for layer in ["depth", "normal", "material", "uv"] {
        assert!(here.join(format!("b.{layer}.pfm")).exists(), "{layer}");
    }

    // `compare` compares all layers, exactly.
    let same = succeeds(here, &["compare", "a.exr", "a.exr"]);
    for layer in ["depth", "normal", "material", "uv"] {
        assert!(same.contains(&format!("layer {layer:<10} identical")), "{same}");
    }
    let differ = ptfast(here, &["compare", "a.exr", "half.exr"]);
    assert_eq!(differ.status.code(), Some(1));
    let differ = stdout(&differ);
    assert!(differ.contains("identical        yes"), "{differ}");
    assert!(differ.contains("layer depth      differs, most by"), "{differ}");
    assert!(differ.contains("layer material   identical"), "{differ}");
    succeeds(here, &["render", "spheres", "--width", "32", "--spp", "4", "-o", "bare.exr"]);
    let bare = stdout(&ptfast(here, &["compare", "a.exr", "bare.exr"]));
    assert!(bare.contains("layer uv         only in the first image"), "{bare}");

    let hashes = succeeds(here, &[&base[..], &["-o", "c.exr", "--print", "hashes"]].concat());
    let names: Vec<&str> = hashes.lines().map(|line| line.split(' ').next().unwrap()).collect();
    assert_eq!(names, ["color", "normal", "depth", "uv", "material"]);

    for (wrong, says) in [
        (&["--layers", "albdo"][..], "unknown layer `albdo`, did you mean `albedo`?"),
        (&["--aov", "normal"], "unexpected argument '--aov' found, use --layers"),
        (&["--normals"], "use --layers"),
        (&["--layers", "depth", "--memory-limit", "20MiB"], "(layers: "),
        (&["--first-hit", "glass"], "surface, through"),
        (&["--layers", "depth", "-o", "-"], "standard output"),
    ] {
        let output =
            ptfast(here, &[&["render", "spheres", "--width", "8", "--spp", "1"], wrong].concat());
        let error = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains(says), "{error}");
    }
}
