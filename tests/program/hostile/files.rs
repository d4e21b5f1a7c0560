//! Paths that lead out of the scene's folder, and faulty checkpoints, plans and records.

use super::meshes::scene as mesh;
use super::{Case, Content};

fn texture(file: &str) -> String {
    let place = "primitives: [mesh(";
    let scene = mesh("")
        .replace(place, &format!("textures: {{\"t\": image(file: \"{file}\")}},\n    {place}"));
    scene.replace("(file: \"\", material: \"grey\")]", "(file: \"none.obj\", material: \"grey\")]")
}

/// A render that fits into the memory limit.
const SMALL: [&str; 7] = ["render", "--scene", "cornell", "--width", "20", "--threads", "1"];

const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n";

pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let outside = "is outside the folder of the scene";
    for (file, says) in [
        ("/etc/passwd", outside),
        ("../../../../../../../etc/passwd", outside),
        ("..", outside),
        ("/", outside),
        ("/dev/zero", outside),
        ("/proc/self/mem", outside),
        ("none.obj", "No such file"),
        ("", "unsupported file extension"),
        (".", "unsupported file extension"),
        ("a.ron", "unsupported file extension"),
        ("a\\u{0}.obj", "a.ron"),
    ] {
        cases.push(Case::scene("a.ron", mesh(file).replace("\\\\u", "\\u"), says));
    }
    for (file, says) in [
        ("/etc/passwd", outside),
        ("/dev/zero", outside),
        ("none.png", "No such file"),
        (".", "a.ron"),
        ("a.ron", "unsupported image"),
    ] {
        cases.push(Case::scene("a.ron", texture(file), says));
    }
    cases.push(Case::scene("a.ron", mesh(&"a".repeat(5000)), "a.ron"));
    cases.push(Case::scene("a.ron", mesh(&format!("{}.obj", "a/".repeat(5000))), "a.ron"));
    for (name, content, says) in [
        ("m.obj", Content::Link("m.obj"), "m.obj"),
        ("m.obj", Content::Link("/etc/passwd"), outside),
        ("m.obj", Content::Link("/dev/zero"), outside),
        ("m.obj", Content::Link("a.ron"), "the file has no faces"),
        ("m.obj", Content::Folder, "m.obj"),
        ("m.obj", Content::Pipe, "it is a device or pipe"),
    ] {
        cases.push(Case::scene("a.ron", mesh(name), says).with(name, content));
    }
    // Two links that point to each other.
    let circle = Case::scene("a.ron", mesh("m.obj"), "m.obj");
    cases.push(circle.with("m.obj", Content::Link("n.obj")).with("n.obj", Content::Link("m.obj")));
    // A path that leaves the folder through a link, and whose `..` seem to lead back into it.
    let around = Case::scene("a.ron", mesh("out/inner/../../etc/passwd"), "a.ron");
    cases.push(around.with("out", Content::Link("/")));
    for (content, code, says) in [
        (Content::Link("a.ron"), 74, "cannot read"),
        (Content::Link("/dev/zero"), 74, "it is a device"),
        (Content::Folder, 74, "cannot read"),
        (Content::Pipe, 74, "it is a device or pipe"),
    ] {
        let mut case = Case::scene("a.ron", "", says);
        case.files = vec![("a.ron", content)];
        case.code = code;
        cases.push(case);
    }

    // Checkpoints.
    let film =
        |header: &str, rest: &[u8]| [b"ptfast film\n", header.as_bytes(), b"\n", rest].concat();
    let whole = |header: &str, rest: &[u8]| {
        let mut bytes = film(header, rest);
        bytes.extend(blake3::hash(&bytes).as_bytes());
        bytes
    };
    let header = |from: &str, to: &str| {
        let good = concat!(
            r#"{"schema":3,"scene":"cornell","identity":{"bits":1,"scene_hash":"x","crop":[0,0,8,8],"settings":{"#,
            r#""width":8,"height":8,"spp":4,"depth":5,"seed":1,"sampling":"mis","sampler":"sobol","roulette":5,"#,
            r#""clamp":null,"transparent":false}},"#,
            r#""shard":null,"samples":[0,4],"tally":TALLY,"seconds":1.0}"#
        );
        assert!(good.contains(from), "{from}");
        let tally = concat!(
            r#"{"rays":{"primary":0,"bounce":0,"shadow":0},"endings":{"background":0,"light":0,"absorbed":0,"black":0,"roulette":0,"depth":0},"#,
            r#""non_finite":{"count":0,"first":null},"clamped":0}"#
        );
        good.replacen(from, to, 1).replace("TALLY", tally)
    };
    let done = |ends: u32| ends.to_le_bytes().repeat(64);
    let films: Vec<(Vec<u8>, &str)> = vec![
        (vec![], "not a checkpoint"),
        (b"ptfast film".to_vec(), "not a checkpoint"),
        (film(&header("8", "8"), &done(0)), "damaged"),
        (whole("", b""), "header"),
        (whole("null", b""), "version null"),
        (whole("[]", b""), "m.film"),
        (whole(&"[".repeat(60_000), b""), "header"),
        (whole(&" ".repeat(100_000), b""), "header"),
        (whole(&header("\"schema\":3", "\"schema\":99"), b""), "version 99"),
        (whole(&header("\"width\":8", "\"width\":4000000000"), b""), "width must be"),
        (whole(&header("\"crop\":[0,0,8,8]", "\"crop\":[8,8,0,0]"), b""), "the crop is not within"),
        (
            whole(&header("\"crop\":[0,0,8,8]", "\"crop\":[0,0,8,4294967295]"), b""),
            "the crop is not within",
        ),
        (whole(&header("\"samples\":[0,4]", "\"samples\":[4,0]"), b""), "the samples 4..0"),
        (whole(&header("\"samples\":[0,4]", "\"samples\":[0,5]"), b""), "the samples 0..5"),
        (whole(&header("\"spp\":4", "\"spp\":4294967295"), b""), "spp must be"),
        (
            whole(&header("\"shard\":null", "\"shard\":{\"index\":0,\"count\":0}"), b""),
            "the shard index must be",
        ),
        (whole(&header("\"seconds\":1.0", "\"seconds\":1e999"), b""), "header"),
        (whole(&header("8", "8"), b""), "the film is too short"),
        (whole(&header("8", "8"), &done(4)), "damaged"),
        (whole(&header("8", "8"), &done(7)), "samples end at 7"),
        (whole(&header("8", "8"), &[0; 100]), "the film is too short"),
        (whole(&header("8", "8"), &[0; 5000]), "the film is too long"),
        (
            whole(
                &header(
                    "\"crop\":[0,0,8,8],\"settings\":{\"width\":8,\"height\":8",
                    "\"crop\":[0,0,65536,65536],\"settings\":{\"width\":65536,\"height\":65536",
                ),
                b"",
            ),
            "the limit of pixels",
        ),
        (
            whole(
                &header(
                    "\"crop\":[0,0,8,8],\"settings\":{\"width\":8,\"height\":8",
                    "\"crop\":[0,0,9999,9999],\"settings\":{\"width\":9999,\"height\":9999",
                ),
                b"",
            ),
            "the limit of memory",
        ),
    ];
    for (bytes, says) in films {
        let mut case = Case::scene("m.film", bytes, says);
        case.arguments = vec!["merge", "m.film", "-o", "a.png"];
        cases.push(case);
    }

    // Huge sparse files, which must be rejected before all of their bytes are hashed.
    let mut sparse = Case::scene("m.film", "", "damaged");
    sparse.files = vec![("m.film", Content::Begun(b"ptfast film\n".to_vec(), 1 << 40))];
    sparse.arguments = vec!["merge", "m.film", "-o", "a.png"];
    cases.push(sparse);
    let mut sparse = Case::scene("m.film", "", "the film is too long");
    sparse.files = vec![("m.film", Content::Begun(film(&header("8", "8"), &[]), 1 << 40))];
    sparse.arguments = vec!["merge", "m.film", "-o", "a.png"];
    cases.push(sparse);

    // Plans.
    for (text, says) in [
        ("", "p.json"),
        ("null", "p.json"),
        ("{\"plan\": 5}", "p.json"),
        ("{\"plan\": {\"wave_size\": 4294967295, \"segments\": []}}", "p.json"),
        ("[[[[[[[[", "p.json"),
        ("{\"wave_size\": 1e999}", "p.json"),
    ] {
        let mut case = Case::scene("p.json", text, says);
        case.arguments = vec!["render", "--scene", "cornell", "--plan", "p.json", "-o", "a.png"];
        cases.push(case);
    }
    let mut large = Case::scene("p.json", "", "at most 1048576 are allowed");
    large.files = vec![("p.json", Content::Sparse(1 << 40))];
    large.arguments = vec!["render", "--scene", "cornell", "--plan", "p.json", "-o", "a.png"];
    cases.push(large);

    let numbers = format!("[{}0]", "0,".repeat((1 << 19) - 8));
    let mut many = Case::scene("p.json", numbers, "must be a plan or the record");
    many.arguments = vec!["render", "--scene", "cornell", "--plan", "p.json", "-o", "a.png"];
    cases.push(many);

    // A pipe as the image file, and a checkpoint with the name of an image file.
    let mut pipe = Case::scene("a.png", "", "it is a device or pipe");
    pipe.files = vec![("a.png", Content::Pipe)];
    pipe.arguments = [&SMALL[..], &["-o", "a.png", "--skip-complete"]].concat();
    pipe.code = 74;
    cases.push(pipe);
    for (kept, says) in [
        ("a.png", "the image and the checkpoint"),
        ("a.partial.png", "the checkpoint and the partial"),
    ] {
        let mut case = Case::scene("m.obj", TETRAHEDRON, says);
        case.arguments = [&SMALL[..], &["-o", "a.png", "--checkpoint", kept]].concat();
        case.code = 2;
        cases.push(case);
    }

    // Images that exceed the limit of pixels or of memory.
    for (arguments, says) in [
        (vec!["--width", "2000"], "the limit of memory is 32.0 MiB"),
        (vec!["--width", "60000", "--height", "60000"], "the limit of pixels is 268435456"),
        (
            vec!["--width", "60000", "--height", "60000", "--limit", "pixels=4294967296"],
            "the limit of memory",
        ),
    ] {
        let mut case = Case::scene("m.obj", TETRAHEDRON, says);
        case.arguments =
            [vec!["render", "--scene", "cornell", "-o", "a.png", "--quiet"], arguments].concat();
        case.code = 2;
        cases.push(case);
    }
    cases
}
