//! Tests of films, and helpers that make films for the tests of the other modules.

use super::*;
use crate::math::Stream;

pub(super) const AREA: Tile = Tile { x: 3, y: 2, width: 23, height: 9 };

/// More than a colour has.
pub(super) const CHANNELS: usize = 5;

type Sample = [f32; CHANNELS];

/// Sample number `sample` of pixel `(x, y)`.
fn sample((x, y): (u32, u32), sample: u32) -> Sample {
    let mut random = Stream::new(u64::from(x) << 40 | u64::from(y) << 20 | u64::from(sample));
    [1.0, 1e4, 1.0, 100.0, 1.0].map(|most| random.between(0.0, most))
}

fn add(one: Sample, two: Sample) -> Sample {
    std::array::from_fn(|channel| one[channel] + two[channel])
}

/// The result of rendering `unit`, which must be the next unit of `film`.
pub(super) fn rendered(film: &Film, unit: Unit) -> UnitSums {
    let open = film.open_sums(unit);
    let sum = |pixel: u32| {
        let open = open.chunks_exact(CHANNELS).nth(pixel as usize);
        let open = open.map_or([0.0; CHANNELS], |sum| sum.try_into().unwrap());
        let samples = (unit.first..unit.end).map(|number| sample(unit.tile.pixel(pixel), number));
        samples.fold(open, add)
    };
    UnitSums { unit, sums: (0..unit.tile.pixels() as u32).flat_map(sum).collect() }
}

/// Node (level, index) of the tree in `sum.rs`, by its definition: the sum of its children, or the
/// left child if there is no right one.
fn node(chunks: &[Sample], level: u32, index: usize) -> Option<Sample> {
    if level == 0 {
        return chunks.get(index).copied();
    }
    let left = node(chunks, level - 1, 2 * index)?;
    Some(node(chunks, level - 1, 2 * index + 1).map_or(left, |right| add(left, right)))
}

/// Sum of the first `samples` samples of the pixel.
fn total(pixel: (u32, u32), samples: u32) -> Sample {
    let numbers: Vec<u32> = (0..samples).collect();
    let chunk = |numbers: &[u32]| {
        numbers.iter().fold([0.0; CHANNELS], |sum, &number| add(sum, sample(pixel, number)))
    };
    let chunks: Vec<Sample> = numbers.chunks(CHUNK as usize).map(chunk).collect();
    node(&chunks, 10, 0).unwrap()
}

/// Mean colour of the first `samples` samples of the pixel.
fn mean(pixel: (u32, u32), samples: u32) -> [f32; 3] {
    let [r, g, b, ..] = total(pixel, samples);
    [r, g, b].map(|sum| sum / samples as f32)
}

pub(super) fn want(samples: u32) -> Plane {
    (0..AREA.pixels() as u32).map(|pixel| mean(AREA.pixel(pixel), samples)).collect()
}

/// A film of the pixels that `keep` selects, with all samples finished.
pub(super) fn rendered_film(samples: Range<u32>, keep: impl Fn(u32, u32) -> bool) -> Film {
    let mut film = Film::new(AREA, samples, CHANNELS).unwrap();
    film.retain(keep);
    let mut schedule = Schedule::new(&film, film.samples().end, 500);
    render(&mut film, &mut schedule);
    film
}

fn render(film: &mut Film, schedule: &mut Schedule) {
    while let Some(unit) = schedule.next(film) {
        assert!(film.is_next(unit), "{unit:?}");
        film.add(&rendered(film, unit)).unwrap();
    }
}

/// The sums of all channels of all pixels.
pub(super) fn totals(film: &Film) -> Vec<[f32; CHANNELS]> {
    let mut totals = Vec::new();
    for row in 0..film.area().height {
        film.totals(row, |sums, _| totals.push(sums.try_into().unwrap()));
    }
    totals
}

/// Means depend neither on the sizes of units nor on interruptions.
#[test]
fn units_of_all_sizes_give_the_same_means() {
    let mut random = Stream::new(3);
    for samples in [1, 15, 16, 17, 50, 100, 333] {
        let want = want(samples);
        for round in 0..10 {
            let mut film = Film::new(AREA, 0..samples, CHANNELS).unwrap();
            while film.samples_done() < film.samples_to_do() {
                let paths = 1 + (random.bits() % 5000) as u32;
                let mut schedule = Schedule::new(&film, samples, paths);
                for _ in 0..random.bits() % 100 {
                    let Some(unit) = schedule.next(&film) else { break };
                    assert!(film.is_next(unit), "{unit:?}");
                    film.add(&rendered(&film, unit)).unwrap();
                }
            }
            assert_eq!(film.samples_to_do(), AREA.pixels() * u64::from(samples));
            assert!(Schedule::new(&film, samples, 100).next(&film).is_none());
            assert_eq!(film.means().unwrap(), want, "{samples} samples, round {round}");
            let others = (0..AREA.pixels() as u32).map(|pixel| total(AREA.pixel(pixel), samples));
            assert!(others.eq(totals(&film)), "{samples} samples, round {round}");
        }
    }
}

/// A film that grows has the same means as one that was created with the larger number of samples.
#[test]
fn films_grow() {
    for (from, to) in [(16, 333), (50, 51), (50, 64), (15, 100), (48, 48)] {
        let mut film = rendered_film(0..from, |x, _| x > 5);
        let rest = film.samples_to_do() / u64::from(from) * u64::from(to - from);
        film.grow(to);
        assert_eq!(film.samples_to_do() - film.samples_done(), rest);
        let mut schedule = Schedule::new(&film, to, 300);
        render(&mut film, &mut schedule);
        let want = rendered_film(0..to, |x, _| x > 5).means().unwrap();
        assert_eq!(film.means().unwrap(), want, "{from} to {to}");
    }
}

/// A film that grows by a few samples at a time, often before all its units are rendered, has the
/// same means as a film that is rendered in one pass.
#[test]
fn chunks_are_continued() {
    let mut random = Stream::new(4);
    let mut passes = 0;
    for round in 0..20 {
        let mut film = Film::new(AREA, 0..1, CHANNELS).unwrap();
        let mut end = 1;
        while end < 70 {
            let mut schedule = Schedule::new(&film, end, 1 + (random.bits() % 300) as u32);
            for _ in 0..random.bits() % 30 {
                let Some(unit) = schedule.next(&film) else { break };
                film.add(&rendered(&film, unit)).unwrap();
            }
            if random.bits().is_multiple_of(4) {
                render(&mut film, &mut schedule);
                assert_eq!(film.means().unwrap(), want(end), "round {round}, {end} samples");
                passes += 1;
            }
            if random.bits().is_multiple_of(2) {
                end += 1 + (random.bits() % 7) as u32;
                film.grow(end);
            }
        }
    }
    assert!(passes > 50, "{passes} passes");
}

#[test]
fn means_are_those_of_finished_samples() {
    let area = Tile { width: 4, height: 1, ..AREA };
    let mut film = Film::new(area, 0..20, CHANNELS).unwrap();
    let [one, two] = [1, 2].map(|width| Tile { width, ..area });
    film.add(&rendered(&film, Unit { tile: two, first: 0, end: 16 })).unwrap();
    film.add(&rendered(&film, Unit { tile: one, first: 16, end: 20 })).unwrap();
    assert_eq!(film.samples_done(), 20 + 16);
    assert!(!film.is_next(Unit { tile: two, first: 16, end: 20 }));
    let want = [mean(area.pixel(0), 20), mean(area.pixel(1), 16), [0.0; 3], [0.0; 3]];
    assert_eq!(film.means().unwrap(), want);
}
