//! Tests of `ptfast view`: in a browser, and against hostile clients.

mod attacks;
mod browser;
mod server;

use std::fs;

use serde_json::json;

use self::browser::Browser;
use self::server::Server;
use crate::common::{ptfast, stderr, stdout};

/// Whether there is more in the picture than one colour.
const SHOWN: &str = "canvas.toDataURL().length > 2000";

/// The hash that the page shows is that of the command that it prints.
#[test]
#[ignore = "needs Chromium, which .ci/run installs: cargo test --test program view:: -- --ignored"]
fn a_camera_is_moved_and_the_refined_picture_is_that_of_render() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["cornell", "--width", "160", "--height", "120", "--spp", "20"];
    let server = Server::start(folder.path(), &arguments);
    let mut browser = Browser::start();
    let tab = browser.open(&server.address);
    browser.wait(&tab, SHOWN);
    let hashed = "byId('hash').textContent.length === 64";
    browser.wait(&tab, hashed);
    let first = browser.value(&tab, "byId('hash').textContent");
    browser.drag(&tab);
    browser.wait(&tab, &format!("{hashed} && byId('hash').textContent !== {first}"));
    // By keys alone, with a lens.
    browser.press(&tab, "KeyW");
    browser.value(&tab, "byId('cone').value = 2; byId('cone').dispatchEvent(new Event('input'))");
    browser.wait(&tab, &format!("byId('command').value.includes('--defocus-angle 2') && {hashed}"));
    let hash = browser.value(&tab, "byId('hash').textContent");
    let command = browser.value(&tab, "byId('command').value");
    let words: Vec<&str> = command.as_str().unwrap().split(' ').skip(1).collect();
    let output =
        ptfast(folder.path(), &[&words[..], &["--print", "hash", "-q", "-o", "a.png"]].concat());
    assert!(output.status.success(), "{command}: {}", stderr(&output));
    assert_eq!(json!(stdout(&output).trim()), hash, "{command}");
    // The path of a pixel is what the command prints.
    browser.value(&tab, "connection.ask('path', { x: 0.5, y: 0.5 })");
    browser.wait(&tab, "document.querySelectorAll('#overlay line').length > 1");
    let path = browser.value(&tab, "byId('path').textContent");
    let render = command.as_str().unwrap();
    let words: Vec<&str> = render.split(' ').skip(1).collect();
    let known = |flag: &str| !["--spp", "--layers", "--first-hit"].contains(&flag);
    let pairs = words.windows(2).filter(|pair| pair[0].starts_with("--") && known(pair[0]));
    let flags: Vec<&str> = pairs.flatten().copied().collect();
    let of_pixel = [&["path", "cornell", "--pixel", "80,60"], &flags[..]].concat();
    let output = ptfast(folder.path(), &of_pixel);
    assert_eq!(json!(stdout(&output).trim_end()), path, "{of_pixel:?} {}", stderr(&output));
    // Refinement goes on.
    browser.wait(&tab, "Number(byId('samples').textContent) > 40");
    assert!(browser.console.is_empty(), "{:?}", browser.console);
}

#[test]
#[ignore = "needs Chromium, which .ci/run installs: cargo test --test program view:: -- --ignored"]
fn each_page_has_its_camera_and_comes_back_after_a_break() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &["spheres", "--width", "96", "--spp", "4"]);
    let mut browser = Browser::start();
    let (one, two) = (browser.open(&server.address), browser.open(&server.address));
    for tab in [&one, &two] {
        browser.wait(tab, &format!("{SHOWN} && byId('hash').textContent.length === 64"));
    }
    let hash = browser.value(&one, "byId('hash').textContent");
    assert_eq!(browser.value(&two, "byId('hash').textContent"), hash);
    browser.press(&two, "ArrowLeft");
    browser.wait(
        &two,
        &format!("byId('hash').textContent.length === 64 && byId('hash').textContent !== {hash}"),
    );
    assert_eq!(browser.value(&one, "byId('hash').textContent"), hash);
    browser.press(&two, "KeyR");
    browser.wait(&two, &format!("byId('hash').textContent === {hash}"));
    // A lost connection.
    browser.value(&one, "byId('hash').textContent = ''; connection.socket.close()");
    browser.wait(&one, &format!("byId('hash').textContent === {hash}"));
    // A phone.
    let phone = json!({ "width": 360, "height": 640, "deviceScaleFactor": 2, "mobile": true });
    browser.call(&one, "Emulation.setDeviceMetricsOverride", phone);
    browser.wait(&one, "document.documentElement.scrollWidth <= 360 && canvas.clientWidth <= 360");
    assert!(browser.console.is_empty(), "{:?}", browser.console);
    let (status, _) = server.interrupt();
    assert!(status.success(), "{status}");
    browser.wait(&one, "!byId('notice').hidden && byId('notice').textContent.includes('ended')");
}

#[test]
#[ignore = "needs Chromium, which .ci/run installs: cargo test --test program view:: -- --ignored"]
fn a_changed_scene_is_read_again_and_layers_are_shown() {
    let folder = tempfile::tempdir().unwrap();
    let shown = ptfast(folder.path(), &["scenes", "show", "cornell"]);
    let scene = stdout(&shown);
    let file = folder.path().join("a.ron");
    fs::write(&file, &scene).unwrap();
    let arguments = ["a.ron", "--width", "64", "--height", "64", "--spp", "4"];
    let server = Server::start(folder.path(), &arguments);
    let mut browser = Browser::start();
    let tab = browser.open(&server.address);
    let hashed = "byId('hash').textContent.length === 64";
    browser.wait(&tab, hashed);
    browser.press(&tab, "ArrowLeft");
    browser.wait(&tab, &format!("byId('command').value.includes('--look-from') && {hashed}"));
    let hash = browser.value(&tab, "byId('hash').textContent");
    let command = browser.value(&tab, "byId('command').value");
    fs::write(&file, "(broken").unwrap();
    browser.wait(&tab, "byId('notice').textContent.includes('a.ron')");
    assert_eq!(browser.value(&tab, SHOWN), json!(true), "the last good scene stays");
    // Another colour of a wall, by the same camera.
    let green = scene.replacen("0.12", "0.9", 1);
    assert_ne!(green, scene);
    fs::write(&file, green).unwrap();
    browser.wait(
        &tab,
        &format!("byId('notice').hidden && {hashed} && byId('hash').textContent !== {hash}"),
    );
    assert_eq!(browser.value(&tab, "byId('command').value"), command);
    let picture = "canvas.toDataURL()";
    for layer in ["normal", "depth", "material"] {
        let before = browser.value(&tab, picture);
        let choose = format!(
            "byId('layer').value = '{layer}'; byId('layer').dispatchEvent(new Event('input'))"
        );
        browser.value(&tab, &choose);
        browser.wait(&tab, &format!("{picture} !== {before} && byId('samples').textContent > 4"));
    }
    assert!(browser.console.is_empty(), "{:?}", browser.console);
}

#[test]
fn a_port_that_is_taken_gives_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let output = ptfast(folder.path(), &["view", "cornell", "--port", &port]);
    assert_eq!(output.status.code(), Some(71), "{}", stderr(&output));
    let said = stderr(&output);
    assert!(said.lines().count() == 1 && said.contains(&format!("--port {port}")), "{said}");
}
