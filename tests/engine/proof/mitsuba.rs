//! Compares pictures tile by tile with those of Mitsuba 3.
//!
//! `profiling/peers/mitsuba/reference` writes the means of Mitsuba's tiles.

use ptfast::{Sampling, Scene};

use super::tiles::{Disagreement, Tiles};

/// Reads the means of tiles, their standard errors, and the number of pictures behind them.
fn read(name: &str) -> Tiles {
    let path = format!("tests/data/{name}.txt");
    let text = std::fs::read_to_string(&path).unwrap();
    let head = text.lines().next().unwrap();
    let pictures = head.split(" pictures").next().unwrap().rsplit(' ').next().unwrap();
    let row = |line: &str| -> Vec<(f64, f64)> {
        let numbers: Vec<f64> = line.split(' ').map(|word| word.parse().unwrap()).collect();
        (0..3)
            .map(|channel| (numbers[channel], numbers[channel + 3] * numbers[channel + 3]))
            .collect()
    };
    let tiles = text.lines().filter(|line| !line.starts_with('#')).flat_map(row).collect();
    Tiles { tiles, pictures: pictures.parse().unwrap() }
}

#[test]
fn pictures_are_those_of_mitsuba() {
    // The last scene shares its images with other tests.
    let names = [
        "mitsuba/cornell",
        "mitsuba/checker",
        "mitsuba/spheres",
        "mitsuba/materials",
        "mitsuba/principled",
        "mitsuba/media",
        "mitsuba/instances",
        "environment",
    ];
    let mut disagreement = Disagreement::new("beside Mitsuba 3", names.len());
    for name in names {
        let scene = Scene::load(&format!("tests/data/{name}.ron")).unwrap();
        let ours = Tiles::render(name, &scene, Sampling::Mis, 64);
        disagreement.compare(name, "mis", &ours, &read(name));
    }
    disagreement.check();
}
