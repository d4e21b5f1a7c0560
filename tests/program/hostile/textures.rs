//! Faulty images, and decompression bombs.

use std::io::Write;

use super::{Case, Content};

fn scene(file: &str) -> String {
    format!(
        r#"(
    camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 40),
    textures: {{"t": image(file: "{file}")}},
    materials: {{"grey": lambertian(albedo: "t")}},
    primitives: [sphere(center: (0, 0, 0), radius: 1, material: "grey")],
)"#
    )
}

fn texture(file: &'static str, bytes: Vec<u8>, says: &str) -> Case {
    Case::scene("a.ron", scene(file), says).with(file, Content::Bytes(bytes))
}

/// 64 MiB of zeros, compressed by zlib.
const ZEROS: &[u8] = include_bytes!("zeros.zlib");

fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut crc = 0xffff_ffffu32;
    for byte in kind.iter().chain(data) {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
        }
    }
    [&(data.len() as u32).to_be_bytes()[..], kind, data, &(!crc).to_be_bytes()].concat()
}

/// Zeros in uncompressed zlib blocks of 65 535 bytes.
fn stored(length: usize) -> Vec<u8> {
    let mut bytes = vec![0x78, 1];
    let zeros = vec![0u8; length];
    let blocks = zeros.chunks(65_535).count();
    for (number, block) in zeros.chunks(65_535).enumerate() {
        bytes.push(u8::from(number + 1 == blocks));
        bytes.extend((block.len() as u16).to_le_bytes());
        bytes.extend((!(block.len() as u16)).to_le_bytes());
        bytes.extend(block);
    }
    // The Adler-32 checksum of zeros.
    bytes.extend(((length as u32 % 65_521) << 16 | 1).to_be_bytes());
    bytes
}

fn png(width: u32, height: u32, depth: u8, color: u8, rest: &[Vec<u8>]) -> Vec<u8> {
    let sides = [width.to_be_bytes(), height.to_be_bytes()].concat();
    let header = [&sides[..], &[depth, color, 0, 0, 0]].concat();
    [b"\x89PNG\r\n\x1a\n".to_vec(), chunk(b"IHDR", &header), rest.concat(), chunk(b"IEND", b"")]
        .concat()
}

pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    // A bomb of 31 250 × 32 000 pixels: a thousand million.
    for (width, height, says) in [
        (31_250, 32_000, "the limit of texture-bytes is 1.0 GiB, this needs"),
        (65_536, 65_536, "the limit of texture-bytes"),
        (1_000_000_000, 1, "damaged image"),
        (2_147_483_647, 2_147_483_647, "damaged image"),
        (4_294_967_295, 1, "damaged image"),
        (2_000, 2_000, "the limit of memory is 32.0 MiB"),
        (0, 0, "damaged image"),
        (0, 5, "damaged image"),
        (5, 0, "damaged image"),
    ] {
        for (depth, color) in [(8, 0), (8, 2), (16, 6)] {
            let bytes = png(width, height, depth, color, &[chunk(b"IDAT", &stored(1000))]);
            cases.push(texture("t.png", bytes, says));
        }
    }
    for (rest, says) in [
        (vec![], "damaged image"),
        (vec![chunk(b"IDAT", b"")], "damaged image"),
        (vec![chunk(b"IDAT", b"not zlib")], "damaged image"),
        (vec![chunk(b"IDAT", &stored(10))], "damaged image"),
        (vec![chunk(b"IDAT", &stored(1000))[..100].to_vec()], "damaged image"),
    ] {
        cases.push(texture("t.png", png(10, 10, 8, 2, &rest), says));
    }
    for (depth, color) in [(3, 2), (8, 5), (16, 3), (255, 255)] {
        cases.push(texture("t.png", png(10, 10, depth, color, &[]), "damaged image"));
    }
    // Chunks that hold no pixels and are larger than the picture.
    for kind in [b"zTXt", b"iCCP"] {
        let bomb = [&b"a\0\0"[..], &stored(9 << 20)].concat();
        let bytes = png(10, 10, 8, 2, &[chunk(kind, &bomb)]);
        let mut case = texture("t.png", bytes, "damaged image");
        case.name = "PNG with a large chunk".to_owned();
        cases.push(case);
    }
    let texts = vec![chunk(b"tEXt", b"a\0b"); 100_000];
    cases.push(texture(
        "t.png",
        png(10, 10, 8, 2, &texts),
        "too many chunks before the pixels (at most 256",
    ));
    let lines = [&b"#?RADIANCE\n"[..], &b"A=B\n".repeat(1 << 20), b"\n-Y 1 +X 1\n"].concat();
    cases.push(texture("t.hdr", lines, "the header is too long (at most 65536 bytes"));
    let attributes: Vec<u8> =
        (0..100_000).flat_map(|n| format!("a{n}\0string\0\0\0\0\0").into_bytes()).collect();
    let exr = [&b"\x76\x2f\x31\x01\x02\0\0\0"[..], &attributes, b"\0"].concat();
    cases.push(texture("t.exr", exr, "damaged image"));
    let tuple = format!(
        "P7\nWIDTH 1\nHEIGHT 1\nDEPTH 3\nMAXVAL 255\nTUPLTYPE {}\nENDHDR\nabc",
        "A".repeat(3 << 20)
    );
    cases.push(texture("t.pam", tuple.into_bytes(), "damaged image"));
    let huge = [&b"\x89PNG\r\n\x1a\n"[..], &u32::MAX.to_be_bytes(), b"IHDR"].concat();
    cases.push(texture("t.png", huge, "damaged image"));

    // JPEG: no headers, a size without pixels, and a size beyond the limits.
    let jpeg = |width: u16, height: u16| {
        let size = [height.to_be_bytes(), width.to_be_bytes()].concat();
        let frame = [&b"\xff\xd8\xff\xc0\0\x0b\x08"[..], &size, b"\x01\x01\x11\0"].concat();
        [&frame[..], b"\xff\xda\0\x08\x01\x01\0\0\x3f\0"].concat()
    };
    cases.push(texture("t.jpg", b"\xff\xd8\xff\xe0".to_vec(), "damaged image"));
    cases.push(texture("t.jpg", jpeg(0, 5), "damaged image"));
    cases.push(texture("t.jpg", jpeg(9, 9), "damaged image"));
    cases.push(texture("t.jpg", jpeg(65_535, 65_535), "t.jpg"));
    let photo = include_bytes!("../../data/photo.jpg");
    cases.push(texture("t.jpg", photo[..photo.len() / 2].to_vec(), "damaged image"));

    // Pixels and sizes that environment maps cannot have.
    let sky = |bytes: Vec<u8>, more: &str, says: &str| {
        let camera = "camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 40)";
        let scene = format!("({camera}, background: image(file: \"s.pfm\"{more}))");
        Case::scene("a.ron", scene, says).with("s.pfm", Content::Bytes(bytes))
    };
    let pfm = |width: usize, height: usize, value: f32| {
        let mut bytes = format!("PF\n{width} {height}\n-1.0\n").into_bytes();
        (0..3 * width * height).for_each(|_| bytes.extend(value.to_le_bytes()));
        bytes
    };
    cases.push(sky(pfm(4, 2, 1.0), ", mapping: equal_area", "an equal-area map must be square"));
    cases.push(sky(pfm(4, 2, 1e20), ", scale: 1e20", "so small that all radiances"));

    // Headers of other formats with huge or empty sizes.
    let bmp = |width: i32, height: i32, bits: u16| {
        let mut bytes = b"BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0".to_vec();
        bytes.extend([width.to_le_bytes(), height.to_le_bytes()].concat());
        bytes.extend([1, 0]);
        bytes.extend(bits.to_le_bytes());
        bytes.extend([0; 24]);
        bytes
    };
    for (width, height, bits, says) in [
        (30_000, 30_000, 24, "the limit of texture-bytes"),
        (i32::MAX, i32::MAX, 24, "damaged image"),
        (-5, 5, 24, "damaged image"),
        (0, 5, 24, "damaged image"),
        (5, i32::MIN, 24, "damaged image"),
        (5, 5, 7, "damaged image"),
        (5, 5, 24, "damaged image"),
    ] {
        cases.push(texture("t.bmp", bmp(width, height, bits), says));
    }
    for (text, says) in [
        ("P6 30000 30000 255\n", "the limit of texture-bytes"),
        ("P6 4294967295 4294967295 255\n", "damaged image"),
        ("P6 99999999999 1 255\n", "damaged image"),
        ("P6 0 0 255\n", "damaged image"),
        ("P6 5 5 0\n", "damaged image"),
        ("P6 5 5 255\nabc", "damaged image"),
        ("P3 5 5 255\n1 2 300 x", "damaged image"),
        (
            "P7\nWIDTH 30000\nHEIGHT 30000\nDEPTH 3\nMAXVAL 255\nTUPLTYPE RGB\nENDHDR\n",
            "the limit of texture-bytes",
        ),
        ("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 30000 +X 30000\n", "the limit of texture-bytes"),
        ("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4294967295 +X 4294967295\n", "damaged image"),
        ("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 5 +X 5\nabc", "damaged image"),
        ("#?RADIANCE\n\n", "damaged image"),
        ("GIF89a", "unsupported image"),
        ("", "unsupported image"),
        ("\u{0}\u{0}\u{0}\u{0}", "unsupported image"),
        ("<svg xmlns='http://www.w3.org/2000/svg'/>", "unsupported image"),
    ] {
        cases.push(texture("t.pnm", text.into(), says));
    }
    for (text, says) in [
        ("PF\n30000 30000\n-1\n", "need 10800000000 bytes"),
        ("PF\n65537 1\n-1\n", "is not in 1 to 65536"),
        ("PF\n0 1\n-1\n", "is not in 1 to 65536"),
        ("PF\n-1 1\n-1\n", "is not in 1 to 65536"),
        ("PF\n1 1\nx\n", "the scale is not a number"),
        ("PF\n1 1\n-1\nabc", "need 12 bytes"),
        ("PF", "damaged PFM header"),
        ("", "damaged PFM header"),
        ("P6\n1 1\n-1\n", "must begin with PF"),
    ] {
        cases.push(texture("t.pfm", text.into(), says));
    }
    let values = |value: f32| {
        let mut bytes = b"PF\n1 1\n-1\n".to_vec();
        (0..3).for_each(|_| bytes.write_all(&value.to_le_bytes()).unwrap());
        bytes
    };
    for value in [f32::INFINITY, 1.5] {
        let says = "albedo must be textures and factors with products in [0, 1]";
        cases.push(texture("t.pfm", values(value), says));
    }
    let pfm = |length: usize| [&b"PF\n1280 1280\n-1\n"[..], &vec![0; length]].concat();
    cases.push(texture("t.pfm", pfm(12 * 1280 * 1280), "the limit of memory"));

    // OpenEXR with invalid windows, and with one of a thousand million pixels.
    let exr = |window: [i32; 4], shown: [i32; 4]| {
        let attribute = |name: &str, kind: &str, value: &[u8]| {
            [
                name.as_bytes(),
                b"\0",
                kind.as_bytes(),
                b"\0",
                &(value.len() as u32).to_le_bytes(),
                value,
            ]
            .concat()
        };
        let [window, shown]: [Vec<u8>; 2] =
            [window, shown].map(|window| window.iter().flat_map(|c| c.to_le_bytes()).collect());
        let channel = |name: &str| {
            [
                name.as_bytes(),
                b"\0",
                &2u32.to_le_bytes(),
                &[0; 4],
                &1u32.to_le_bytes(),
                &1u32.to_le_bytes(),
            ]
            .concat()
        };
        let channels = [channel("B"), channel("G"), channel("R"), vec![0]].concat();
        [
            &[0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0][..],
            &attribute("channels", "chlist", &channels),
            &attribute("compression", "compression", &[0]),
            &attribute("dataWindow", "box2i", &window),
            &attribute("displayWindow", "box2i", &shown),
            &attribute("lineOrder", "lineOrder", &[0]),
            &attribute("pixelAspectRatio", "float", &1.0f32.to_le_bytes()),
            &attribute("screenWindowCenter", "v2f", &[0; 8]),
            &attribute("screenWindowWidth", "float", &1.0f32.to_le_bytes()),
            &[0],
        ]
        .concat()
    };
    for (window, says) in [
        ([0, 0, 31_249, 31_999], "the limit of texture-bytes"),
        ([0, 0, 999, 999], "the limit of memory"),
        ([0, 0, 9, 9], "damaged image"),
        ([0, 0, -2, -2], "damaged image"),
        ([9, 9, 0, 0], "damaged image"),
        ([i32::MIN, i32::MIN, i32::MAX, i32::MAX], "damaged image"),
        ([0, 0, i32::MAX, 0], "damaged image"),
    ] {
        cases.push(texture("t.exr", exr(window, window), says));
    }
    // The display window is small, but the data window is large.
    let shown = [0, 0, 0, 0];
    cases.push(texture("t.exr", exr([0, 0, 0x1fff_ffff, 15], shown), "the limit of texture-bytes"));
    cases.push(texture("t.exr", exr([0, 0, 65_535, 15], shown), "damaged image"));
    // Headers without an end, and a compressed text that expands to 64 MiB of zeros.
    for (file, begin) in
        [("t.hdr", "#?RADIANCE\n#"), ("t.pnm", "P6 #"), ("t.pnm", "P7\n#"), ("t.bmp", "BM")]
    {
        let mut case = texture(file, vec![], "the limit of memory");
        case.files[1].1 = Content::Begun(begin.as_bytes().to_vec(), 1 << 36);
        cases.push(case);
    }
    let note = [&b"ptfast:transfer\0\x01\0\0\0"[..], ZEROS].concat();
    let bomb = png(10, 10, 8, 2, &[chunk(b"iTXt", &note), chunk(b"IDAT", b"")]);
    cases.push(texture("t.png", bomb, "damaged image"));
    for (bytes, says) in [
        (&[0x76, 0x2f, 0x31, 0x01][..], "damaged image"),
        (&[0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0], "damaged image"),
        (&[0x76, 0x2f, 0x31, 0x01, 255, 255, 255, 255], "unsupported image"),
    ] {
        cases.push(texture("t.exr", bytes.to_vec(), says));
    }
    // WebP: nothing, a lossless header without pixels, and one of the largest size.
    let webp = |rest: &[u8]| [&b"RIFF\x40\0\0\0WEBP"[..], rest].concat();
    cases.push(texture("t.webp", webp(b""), "damaged image"));
    cases.push(texture("t.webp", webp(b"VP8L\x20\0\0\0\x2f\x02\x40\0\0"), "damaged image"));
    let huge = webp(b"VP8L\x20\0\0\0\x2f\xfe\xbf\xff\x0f");
    cases.push(texture("t.webp", huge, "the limit of"));
    // TGA has no magic number, so the extension decides the format.
    cases.push(texture("t.tga", vec![0; 18], "t.tga"));
    cases
}
