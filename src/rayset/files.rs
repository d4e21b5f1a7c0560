//! Ray sets as folders of raw arrays.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::record::KINDS;
use super::{Query, RaySet, RaySets};
use crate::accel::{HitBatch, RayBatch};
use crate::error::{Error, Result};
use crate::geometry::{Geometry, Quad, Ray, Sphere, Triangle};
use crate::input::{self, read_json};
use crate::limits::{MAX_JSON, MAX_PRIMITIVES};
use crate::output::write_atomically;

/// The file that is written last, and so says that the folder is complete.
const MANIFEST: &str = "manifest.json";

#[derive(Debug, Serialize, Deserialize)]
struct Manifest {
    scene: String,
    seed: u64,
    counts: Counts,
    sets: Vec<SetEntry>,
    image: [u32; 2],
}

#[derive(Debug, Serialize, Deserialize)]
struct Counts {
    spheres: usize,
    quads: usize,
    triangles: usize,
}

#[derive(Debug, Serialize, Deserialize)]
struct SetEntry {
    name: String,
    kind: Query,
    rays: usize,
}

const SPHERES: &str = "spheres.f32";
const QUADS: &str = "quads.f32";
const TRIANGLES: &str = "triangles.f32";
/// Of each set.
const EXTENSIONS: [&str; 4] = ["rays", "range", "time", "hits"];

/// All files that there may be of ray sets in `folder`.
pub(crate) fn files(folder: &Path) -> Vec<PathBuf> {
    let fixed = [MANIFEST, SPHERES, QUADS, TRIANGLES].into_iter().map(|name| folder.join(name));
    fixed.chain(files_of_sets(folder)).collect()
}

fn files_of_sets(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let names = KINDS.into_iter().flat_map(|(_, name, _)| EXTENSIONS.map(|end| (name, end)));
    names.map(move |(name, end)| folder.join(format!("{name}.{end}")))
}

/// Writes `sets` into `folder`, which is made if it is missing. Files of an older set are
/// replaced; without `manifest.json`, the last to be written, a folder is no ray set.
///
/// # Errors
/// Where the folder cannot be written.
pub(crate) fn write(sets: &RaySets, folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).map_err(Error::io(folder, "make the folder"))?;
    let manifest = folder.join(MANIFEST);
    remove(&manifest)?;
    files_of_sets(folder).try_for_each(|file| remove(&file))?;
    let Geometry { spheres, quads, triangles } = &sets.geometry;
    let spheres_f32 = spheres.iter().flat_map(|s| {
        let ([x, y, z], [x1, y1, z1]) = (s.center.to_array(), s.center1.to_array());
        [x, y, z, s.radius, x1, y1, z1, 0.0]
    });
    write_floats(&folder.join(SPHERES), spheres_f32)?;
    let quads_f32 = quads.iter().flat_map(|q| [q.q, q.u, q.v]).flat_map(|v| v.to_array());
    write_floats(&folder.join(QUADS), quads_f32)?;
    let triangles_f32 = triangles.iter().flat_map(|t| t.vertices).flat_map(|v| v.to_array());
    write_floats(&folder.join(TRIANGLES), triangles_f32)?;
    let moving = sets.geometry.moves();
    for set in &sets.sets {
        let file = |extension: &str| folder.join(format!("{}.{extension}", set.name));
        let rays = &set.rays;
        let each = 0..rays.len();
        write_floats(
            &file("rays"),
            each.clone().flat_map(|i| {
                let (Ray { origin, direction, .. }, ..) = rays.get(i);
                origin.to_array().into_iter().chain(direction.to_array())
            }),
        )?;
        let range = |i: usize| {
            let (_, t_min, t_max) = rays.get(i);
            [t_min, t_max]
        };
        write_floats(&file("range"), each.clone().flat_map(range))?;
        if moving {
            write_floats(&file("time"), each.clone().map(|i| rays.get(i).0.time))?;
        }
        write_words(
            &file("hits"),
            each.flat_map(|i| [set.hits.t[i].to_bits(), set.hits.primitive[i]]),
        )?;
    }
    let entry =
        |set: &RaySet| SetEntry { name: set.name.clone(), kind: set.query, rays: set.rays.len() };
    let content = Manifest {
        scene: sets.scene.clone(),
        seed: sets.seed,
        counts: Counts { spheres: spheres.len(), quads: quads.len(), triangles: triangles.len() },
        sets: sets.sets.iter().map(entry).collect(),
        image: sets.image,
    };
    write_atomically(&manifest, |file| {
        serde_json::to_writer(&mut *file, &content)?;
        writeln!(file)
    })
}

/// Removes a file of an older set, if there is one.
fn remove(path: &Path) -> Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            Err(Error::io(path, "replace")(error))
        }
        _ => Ok(()),
    }
}

fn write_floats(path: &Path, values: impl Iterator<Item = f32>) -> Result<()> {
    write_words(path, values.map(f32::to_bits))
}

fn write_words(path: &Path, mut words: impl Iterator<Item = u32>) -> Result<()> {
    write_atomically(path, |file| words.try_for_each(|word| file.write_all(&word.to_le_bytes())))
}

/// Reads the ray sets in `folder`.
///
/// # Errors
/// Where a file is missing, has not the length that the manifest says, or holds a primitive that
/// cannot be, and where the manifest names no set, or one that cannot be.
pub(crate) fn read(folder: &Path) -> Result<RaySets> {
    let path = folder.join(MANIFEST);
    let manifest: Manifest = read_json(&path, "a manifest", MAX_JSON)?;
    check_counts(&manifest.counts)
        .and_then(|()| check_entries(&manifest.sets))
        .map_err(|(place, message)| Error::input(path.display().to_string(), place, message))?;
    let geometry = read_geometry(folder, &manifest.counts)?;
    let sets = manifest.sets.iter().map(|entry| read_set(folder, entry, &geometry));
    let sets = sets.collect::<Result<Vec<RaySet>>>()?;
    let Manifest { scene, seed, image, .. } = manifest;
    Ok(RaySets { scene, seed, image, geometry, sets })
}

/// `Err` says which place of the manifest is wrong, and what would be right.
fn check_counts(counts: &Counts) -> Result<(), (String, String)> {
    let Counts { spheres, quads, triangles } = *counts;
    let all = spheres.saturating_add(quads).saturating_add(triangles);
    match all <= MAX_PRIMITIVES {
        true => Ok(()),
        false => Err((
            "counts".to_owned(),
            format!("there can be {MAX_PRIMITIVES} primitives at most, not {all}"),
        )),
    }
}

/// As [`check_counts`].
fn check_entries(sets: &[SetEntry]) -> Result<(), (String, String)> {
    if sets.is_empty() {
        return Err(("sets".to_owned(), "there must be one at least".to_owned()));
    }
    for (index, entry) in sets.iter().enumerate() {
        let known = KINDS.iter().find(|(_, name, _)| *name == entry.name);
        let again = sets[..index].iter().any(|other| other.name == entry.name);
        let message = match known {
            Some(_) if again || entry.rays == 0 => "each set must be there once and have rays",
            Some((.., query)) if *query != entry.kind => {
                "primary and bounce must be closest, shadow occluded"
            }
            Some(_) => continue,
            None => "the name must be primary, bounce or shadow",
        };
        return Err((format!("sets[{index}]"), message.to_owned()));
    }
    Ok(())
}

fn read_geometry(folder: &Path, counts: &Counts) -> Result<Geometry> {
    let bad = |file: &str, index: usize, message: &str| {
        Error::input(folder.join(file).display().to_string(), format!("[{index}]"), message)
    };
    let finite = |file: &str, index: usize, values: &[f32]| match values
        .iter()
        .all(|value| value.is_finite())
    {
        true => Ok(()),
        false => Err(bad(file, index, "a coordinate is not finite")),
    };
    let mut geometry = Geometry::default();
    let file = SPHERES;
    for (index, sphere) in read_records::<8>(folder, file, counts.spheres)?.iter().enumerate() {
        finite(file, index, sphere)?;
        let &[x, y, z, radius, x1, y1, z1, _] = sphere;
        if radius <= 0.0 {
            return Err(bad(file, index, "the radius must be above 0"));
        }
        let (center, center1) = (Vec3::new(x, y, z), Vec3::new(x1, y1, z1));
        geometry.spheres.push(Sphere { center, center1, radius });
    }
    let vectors =
        |values: &[f32; 9]| [0, 3, 6].map(|i| Vec3::new(values[i], values[i + 1], values[i + 2]));
    let file = QUADS;
    for (index, quad) in read_records::<9>(folder, file, counts.quads)?.iter().enumerate() {
        finite(file, index, quad)?;
        let [q, u, v] = vectors(quad);
        let quad = Quad::new(q, u, v).ok_or_else(|| bad(file, index, "the quad has no area"))?;
        geometry.quads.push(quad);
    }
    let file = TRIANGLES;
    for (index, triangle) in read_records::<9>(folder, file, counts.triangles)?.iter().enumerate() {
        finite(file, index, triangle)?;
        geometry.triangles.push(Triangle { vertices: vectors(triangle) });
    }
    Ok(geometry)
}

fn read_set(folder: &Path, entry: &SetEntry, geometry: &Geometry) -> Result<RaySet> {
    let primitives = geometry.len();
    let name = |extension: &str| format!("{}.{extension}", entry.name);
    let rays = read_records::<6>(folder, &name("rays"), entry.rays)?;
    let range = read_records::<2>(folder, &name("range"), entry.rays)?;
    // Only where nothing moves it may be missing.
    let time = if geometry.moves() || folder.join(name("time")).exists() {
        read_records::<1>(folder, &name("time"), entry.rays)?
    } else {
        vec![[0.0]; entry.rays]
    };
    let hits = read_records::<2>(folder, &name("hits"), entry.rays)?;
    let mut set = RaySet {
        name: entry.name.clone(),
        query: entry.kind,
        rays: RayBatch::default(),
        hits: HitBatch::default(),
    };
    for (index, ((ray, [t_min, t_max]), [time])) in rays.iter().zip(range).zip(time).enumerate() {
        let bad = |extension: &str, message: &str| {
            let file = folder.join(name(extension)).display().to_string();
            Error::input(file, format!("[{index}]"), message)
        };
        if !(t_min >= 0.0) {
            return Err(bad("range", "t_min must be 0 or more"));
        }
        if !(0.0..=1.0).contains(&time) {
            return Err(bad("time", "a time must be in [0, 1]"));
        }
        let &[ox, oy, oz, dx, dy, dz] = ray;
        let (origin, direction) = (Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz));
        set.rays.push(&Ray { origin, direction, time }, t_min, t_max);
        let [t, primitive] = hits[index];
        let primitive = primitive.to_bits();
        if primitive != HitBatch::MISS && primitive as usize >= primitives {
            return Err(bad("hits", &format!("primitive {primitive} of {primitives}")));
        }
        set.hits.t.push(t);
        set.hits.primitive.push(primitive);
    }
    Ok(set)
}

/// `count` records of `N` little-endian f32.
fn read_records<const N: usize>(folder: &Path, file: &str, count: usize) -> Result<Vec<[f32; N]>> {
    let path = folder.join(file);
    // Asked first: what is not as long as it should be is not read at all.
    let found = input::length(&path)?;
    if Some(found) != (count as u64).checked_mul(4 * N as u64) {
        let record = 4 * N;
        let message =
            format!("{found} bytes, where {MANIFEST} says {count} records of {record} bytes");
        return Err(Error::input(path.display().to_string(), "", message));
    }
    let bytes = fs::read(&path).map_err(Error::io(&path, "read"))?;
    let (words, _) = bytes.as_chunks::<4>();
    let (records, _) = words.as_chunks::<N>();
    Ok(records.iter().map(|record| record.map(f32::from_le_bytes)).collect())
}
