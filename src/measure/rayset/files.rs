//! Reads and writes ray sets as folders of raw arrays.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::arrays::{MANIFEST, read_records, write_floats, write_words};
use super::instances;
use super::record::KINDS;
use super::{Query, RaySet, RaySets};
use crate::accel::{HitBatch, RayBatch};
use crate::error::{Error, Result};
use crate::geometry::{Geometry, PrimitiveModel, Ray, primitives};
use crate::input::read_json;
use crate::limits::{MAX_JSON, MAX_PRIMITIVES};
use crate::output::write_atomically;

#[derive(Debug, Serialize, Deserialize)]
struct Manifest {
    scene: String,
    seed: u64,
    counts: Counts,
    sets: Vec<SetEntry>,
    image: [u32; 2],
    #[serde(default)]
    origin: [f64; 3],
}

#[derive(Debug, Serialize, Deserialize)]
struct SetEntry {
    name: String,
    kind: Query,
    rays: usize,
}

/// Extensions of the files of each set.
const EXTENSIONS: [&str; 5] = ["rays", "range", "time", "hits", "instances"];

macro_rules! geometry_files {
    ($($(#[doc = $doc:literal])* $name:ident in $module:ident listed in $list:ident: $many:ty,)*) => {
        /// Number of primitives of each kind.
        #[derive(Debug, Serialize, Deserialize)]
        struct Counts {
            $($list: usize,)*
            /// Number of triangles of each mesh that instances place.
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            meshes: Vec<usize>,
            #[serde(default, skip_serializing_if = "is_zero")]
            instances: usize,
        }

        impl Counts {
            fn of(geometry: &Geometry) -> Self {
                let instances = &geometry.instances;
                let meshes = (0..instances.meshes()).map(|mesh| instances.range(mesh).len());
                Self {
                    $($list: geometry.$list.len(),)*
                    meshes: meshes.collect(),
                    instances: instances.len(),
                }
            }

            fn all(&self) -> usize {
                let counts = [$(self.$list,)* self.instances].into_iter();
                counts.chain(self.meshes.iter().copied()).fold(0, usize::saturating_add)
            }
        }

        /// The files of the primitives.
        const PRIMITIVES: &[&str] =
            &[$(concat!(stringify!($list), ".f32"),)* instances::MESHES, instances::INSTANCES];

        fn write_geometry(folder: &Path, geometry: &Geometry) -> Result<()> {
            $(
                let file = folder.join(concat!(stringify!($list), ".f32"));
                write_floats(&file, geometry.$list.iter().flat_map(|primitive| primitive.record()))?;
            )*
            instances::write(folder, &geometry.instances)
        }

        fn read_geometry(folder: &Path, counts: &Counts) -> Result<Geometry> {
            let mut geometry = Geometry::default();
            $(
                let file = concat!(stringify!($list), ".f32");
                for (index, record) in read_records(folder, file, counts.$list)?.iter().enumerate() {
                    let primitive = match record.iter().all(|number| number.is_finite()) {
                        true => PrimitiveModel::from_record(record),
                        false => Err("a coordinate is not finite"),
                    };
                    geometry.$list.push(primitive.map_err(|message| {
                        let file = folder.join(file).display().to_string();
                        Error::input(file, format!("[{index}]"), message)
                    })?);
                }
            )*
            geometry.instances = instances::read(folder, &counts.meshes, counts.instances)?;
            Ok(geometry)
        }
    };
}

primitives!(geometry_files);

fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// All files that ray sets in `folder` may consist of.
pub(crate) fn files(folder: &Path) -> Vec<PathBuf> {
    let fixed =
        [MANIFEST].into_iter().chain(PRIMITIVES.iter().copied()).map(|name| folder.join(name));
    fixed.chain(files_of_sets(folder)).collect()
}

/// Whether `folder` contains a complete ray set.
pub(crate) fn is_set(folder: &Path) -> bool {
    read_json::<Manifest>(&folder.join(MANIFEST), "a manifest", MAX_JSON).is_ok()
}

fn files_of_sets(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let names = KINDS.into_iter().flat_map(|(_, name, _)| EXTENSIONS.map(|end| (name, end)));
    names.map(move |(name, end)| folder.join(format!("{name}.{end}")))
}

/// Writes `sets` into `folder`, which is created if missing. Files of older sets are removed or
/// overwritten. `manifest.json` is written last; a folder without it is not a ray set.
///
/// # Errors
/// If a file cannot be written.
pub(crate) fn write(sets: &RaySets, folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
    let manifest = folder.join(MANIFEST);
    remove(&manifest)?;
    files_of_sets(folder).try_for_each(|file| remove(&file))?;
    PRIMITIVES.iter().try_for_each(|name| remove(&folder.join(name)))?;
    write_geometry(folder, &sets.geometry)?;
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
            each.clone().flat_map(|i| [set.hits.t[i].to_bits(), set.hits.primitive[i]]),
        )?;
        if !sets.geometry.instances.is_empty() {
            write_words(&file("instances"), each.map(|i| set.hits.instance[i]))?;
        }
    }
    let entry =
        |set: &RaySet| SetEntry { name: set.name.clone(), kind: set.query, rays: set.rays.len() };
    let content = Manifest {
        scene: sets.scene.clone(),
        seed: sets.seed,
        counts: Counts::of(&sets.geometry),
        sets: sets.sets.iter().map(entry).collect(),
        image: sets.image,
        origin: sets.origin,
    };
    write_atomically(&manifest, |file| {
        serde_json::to_writer(&mut *file, &content)?;
        writeln!(file)
    })
}

/// Removes a file of an older set, if it exists.
fn remove(path: &Path) -> Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            Err(Error::io(path, "replace")(error))
        }
        _ => Ok(()),
    }
}

/// Reads the ray sets in `folder`.
///
/// # Errors
/// If a file is missing, does not have the length that the manifest requires, or holds an invalid
/// primitive, ray or hit. If the manifest lists no set or an invalid one, or too many primitives.
pub(crate) fn read(folder: &Path) -> Result<RaySets> {
    let path = folder.join(MANIFEST);
    let manifest: Manifest = read_json(&path, "a manifest", MAX_JSON)?;
    check_counts(&manifest.counts)
        .and_then(|()| check_entries(&manifest.sets))
        .map_err(|(place, message)| Error::input(path.display().to_string(), place, message))?;
    let geometry = read_geometry(folder, &manifest.counts)?;
    let sets = manifest.sets.iter().map(|entry| read_set(folder, entry, &geometry));
    let sets = sets.collect::<Result<Vec<RaySet>>>()?;
    let Manifest { scene, seed, image, origin, .. } = manifest;
    Ok(RaySets { scene, seed, image, origin, geometry, sets })
}

/// Checks the number of primitives. An error consists of the place in the manifest that is wrong, and a
/// message that says what would be right.
fn check_counts(counts: &Counts) -> Result<(), (String, String)> {
    let all = counts.all();
    if counts.meshes.contains(&0) {
        return Err(("counts".to_owned(), "each mesh must have a triangle".to_owned()));
    }
    match all <= MAX_PRIMITIVES {
        true => Ok(()),
        false => Err((
            "counts".to_owned(),
            format!("at most {MAX_PRIMITIVES} primitives are supported, not {all}"),
        )),
    }
}

/// Checks the list of sets. Errors are like those of [`check_counts`].
fn check_entries(sets: &[SetEntry]) -> Result<(), (String, String)> {
    if sets.is_empty() {
        return Err(("sets".to_owned(), "there must be at least one set".to_owned()));
    }
    for (index, entry) in sets.iter().enumerate() {
        let known = KINDS.iter().find(|(_, name, _)| *name == entry.name);
        let again = sets[..index].iter().any(|other| other.name == entry.name);
        let message = match known {
            Some(_) if again || entry.rays == 0 => "each set must be listed once and have rays",
            Some((.., query)) if *query != entry.kind => {
                "the kind must be closest for primary and bounce, occluded for shadow"
            }
            Some(_) => continue,
            None => "the name must be primary, bounce or shadow",
        };
        return Err((format!("sets[{index}]"), message.to_owned()));
    }
    Ok(())
}

fn read_set(folder: &Path, entry: &SetEntry, geometry: &Geometry) -> Result<RaySet> {
    let primitives = geometry.len() + geometry.instances.triangle_count();
    let name = |extension: &str| format!("{}.{extension}", entry.name);
    let rays = read_records::<6>(folder, &name("rays"), entry.rays)?;
    let range = read_records::<2>(folder, &name("range"), entry.rays)?;
    // The file of times may be missing only if no primitive moves.
    let time = if geometry.moves() || folder.join(name("time")).exists() {
        read_records::<1>(folder, &name("time"), entry.rays)?
    } else {
        vec![[0.0]; entry.rays]
    };
    let hits = read_records::<2>(folder, &name("hits"), entry.rays)?;
    let instances = if geometry.instances.is_empty() {
        vec![[0.0]; entry.rays]
    } else {
        read_records::<1>(folder, &name("instances"), entry.rays)?
    };
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
            return Err(bad("time", "the time must be in [0, 1]"));
        }
        let &[ox, oy, oz, dx, dy, dz] = ray;
        let (origin, direction) = (Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz));
        set.rays.push(&Ray { origin, direction, time }, t_min, t_max);
        let [t, primitive] = hits[index];
        let primitive = primitive.to_bits();
        if primitive != HitBatch::MISS && primitive as usize >= primitives {
            return Err(bad(
                "hits",
                &format!("primitive {primitive} does not exist, there are {primitives}"),
            ));
        }
        let instance = instances[index][0].to_bits();
        let count = geometry.instances.len();
        if instance as usize >= count.max(1) {
            return Err(bad(
                "instances",
                &format!("instance {instance} does not exist, there are {count}"),
            ));
        }
        set.hits.t.push(t);
        set.hits.primitive.push(primitive);
        set.hits.instance.push(instance);
    }
    Ok(set)
}
