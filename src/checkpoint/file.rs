//! Checkpoints in files.

use std::fs::File;
use std::io::{self, BufRead, BufReader, BufWriter, ErrorKind, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{Checkpoint, Identity, Shard};
use crate::engine::{Rendering, Tally};
use crate::error::{Error, Result};
use crate::film::{CHUNK, Film};
use crate::input;
use crate::limits::{Limits, check_image, check_sampling};
use crate::output::Pending;

/// The first line.
const MAGIC: &[u8] = b"ptfast film\n";
/// The version of the format.
const SCHEMA: u32 = 2;
/// Bytes of the second line, at most.
const MOST_HEADER: u64 = 1 << 16;
/// A file of so many bytes is hashed in a second, whatever its header says.
const SOON_HASHED: u64 = 1 << 30;
/// Longer than any render, and few enough for sums of many.
const MOST_SECONDS: f64 = 1e12;
/// More than any render has of anything, and few enough for sums of many.
const MOST_COUNT: u64 = 1 << 53;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    schema: u32,
    scene: String,
    identity: Identity,
    shard: Option<Shard>,
    samples: [u32; 2],
    tally: Tally,
    seconds: f64,
}

impl Checkpoint {
    /// Writes it to `path`: whole or not at all.
    ///
    /// # Errors
    /// Where `path` cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        self.pending(path)?.replace(path)
    }

    /// Writes it as a file that is to be in the folder of `path`.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub(crate) fn pending(&self, path: &Path) -> Result<Pending> {
        let Rendering { film, tally, seconds, .. } = &self.rendering;
        let Range { start, end } = film.samples();
        let header = Header {
            schema: SCHEMA,
            scene: self.scene.clone(),
            identity: self.identity.clone(),
            shard: self.shard,
            samples: [start, end],
            tally: tally.clone(),
            seconds: *seconds,
        };
        Pending::new(path, |file| {
            let hashing = Hashing { inner: file, hasher: blake3::Hasher::new() };
            // Hashes are made of many bytes at once.
            let mut file = BufWriter::with_capacity(1 << 16, hashing);
            file.write_all(MAGIC)?;
            serde_json::to_writer(&mut file, &header)?;
            file.write_all(b"\n")?;
            film.write(&mut file)?;
            let Hashing { inner, hasher } = file.into_inner()?;
            inner.write_all(hasher.finalize().as_bytes())
        })
    }

    /// Reads one from `path`, within `limits`.
    ///
    /// # Errors
    /// Where the file cannot be read, is no checkpoint, of a version that is not known, damaged, or beyond a
    /// limit.
    pub fn read(path: &Path, limits: &Limits) -> Result<Self> {
        let bad = |message: String| Error::input(path.display().to_string(), "", message);
        let failed = |error| Error::io(path, "read")(error);
        let length = input::length(path)?;
        let mut file = File::open(path).map(BufReader::new).map_err(failed)?;
        let mut magic = [0; MAGIC.len()];
        if length < MAGIC.len() as u64 || file.read_exact(&mut magic).is_err() || magic != *MAGIC {
            return Err(bad("not a checkpoint of ptfast".to_owned()));
        }
        let mut line = Vec::new();
        file.by_ref().take(MOST_HEADER).read_until(b'\n', &mut line).map_err(failed)?;
        let is_whole = |file: &mut BufReader<File>| {
            file.rewind().and_then(|()| is_whole(file, length)).map_err(failed)
        };
        let damaged = || bad("damaged: it is not what ptfast wrote".to_owned());
        let header = match header(&line) {
            Ok(header) => header,
            Err(message) if length <= SOON_HASHED && is_whole(&mut file)? => {
                return Err(bad(message));
            }
            Err(_) => return Err(damaged()),
        };
        let Header { scene, identity, shard, samples: [first, end], tally, seconds, .. } = header;
        let area = identity.area();
        limits.check_image(area.pixels(), Film::memory(area, first..end)).map_err(bad)?;
        let before = MAGIC.len() + line.len();
        let of_film = length.saturating_sub((before + blake3::OUT_LEN) as u64);
        // At least the end of each pixel's samples.
        if of_film < 4 * area.pixels() {
            return Err(bad("damaged: the film ends early".to_owned()));
        }
        if of_film > Film::most_bytes(area, first..end) {
            return Err(bad("damaged: the film ends late".to_owned()));
        }
        if !is_whole(&mut file)? {
            return Err(damaged());
        }
        file.seek(SeekFrom::Start(before as u64)).map_err(failed)?;
        let mut sums = file.take(of_film);
        let film = Film::read(area, first..end, &mut sums).map_err(|error| match error.kind() {
            ErrorKind::InvalidData => bad(format!("damaged: {error}")),
            ErrorKind::UnexpectedEof => bad("damaged: the film ends early".to_owned()),
            _ => failed(error),
        })?;
        if sums.limit() > 0 {
            return Err(bad("damaged: the film ends late".to_owned()));
        }
        let has = |x, y| shard.is_none_or(|shard| shard.has(identity.width, x, y));
        if !film.is_of(has) {
            return Err(bad("damaged: its pixels are not those of its shard".to_owned()));
        }
        let mut rendering = Rendering::new(film);
        (rendering.tally, rendering.seconds) = (tally, seconds);
        Ok(Self { scene, identity, shard, rendering })
    }
}

/// Whether a file of so many bytes ends with the hash of what comes before.
fn is_whole(mut file: impl Read, length: u64) -> io::Result<bool> {
    let mut hasher = blake3::Hasher::new();
    let before = length.saturating_sub(blake3::OUT_LEN as u64);
    hasher.update_reader(file.by_ref().take(before))?;
    let mut hash = Vec::new();
    file.take(blake3::OUT_LEN as u64 + 1).read_to_end(&mut hash)?;
    Ok(hash == hasher.finalize().as_bytes())
}

/// The header in the second line, checked.
fn header(line: &[u8]) -> Result<Header, String> {
    let wrong = |error: serde_json::Error| format!("header: {error}");
    let header: Value = serde_json::from_slice(line).map_err(wrong)?;
    if header["schema"] != SCHEMA {
        let message =
            format!("version {} of checkpoints is not known, {SCHEMA} is", header["schema"]);
        return Err(message);
    }
    let header: Header = serde_json::from_value(header).map_err(wrong)?;
    let Identity { width, height, spp, depth, crop: [left, upper, right, lower], .. } =
        header.identity;
    check_image(width, height).and_then(|()| check_sampling(spp, depth))?;
    if !(left < right && right <= width && upper < lower && lower <= height) {
        return Err(format!("the crop is not within {width} x {height}"));
    }
    if header.shard.is_some_and(|Shard { index, count }| index >= count) {
        return Err("the shard is none of so many".to_owned());
    }
    let Header { tally, seconds, .. } = &header;
    if !(0.0..=MOST_SECONDS).contains(seconds) {
        return Err("the seconds are none".to_owned());
    }
    if tally.counts().any(|count| count > MOST_COUNT) {
        return Err("the counts are none".to_owned());
    }
    let [first, end] = header.samples;
    if !(first.is_multiple_of(CHUNK) && first < end && end <= spp) {
        return Err(format!("the samples {first}..{end} cannot be of {spp}"));
    }
    Ok(header)
}

/// Hashes what goes through.
struct Hashing<'a, W> {
    inner: &'a mut W,
    hasher: blake3::Hasher,
}

impl<W: Write> Write for Hashing<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.hasher.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}
