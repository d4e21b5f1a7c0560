//! Reads and writes checkpoint files.

use std::borrow::Borrow;
use std::fs::File;
use std::io::{self, BufRead, BufReader, BufWriter, ErrorKind, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{Checkpoint, Identity, Part, Shard};
use crate::engine::{ImageSettings, RenderState, Tally};
use crate::error::{Error, Result};
use crate::film::{CHUNK, Film};
use crate::input;
use crate::limits::Limits;
use crate::output::write_atomically_if;

/// First line of a checkpoint file.
const MAGIC: &[u8] = b"ptfast film\n";
/// Version of the format.
const SCHEMA: u32 = 3;
/// Maximum length of the second line in bytes.
const MOST_HEADER: u64 = 1 << 16;
/// Largest file that is hashed even if its header is invalid, which takes about a second.
const SOON_HASHED: u64 = 1 << 30;
/// Maximum time in seconds: longer than any render, but small enough that many can be added.
const MOST_SECONDS: f64 = 1e12;
/// Maximum count: more than any render reaches, but small enough that many can be added.
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

impl<R: Borrow<RenderState>> Checkpoint<R> {
    /// Writes the checkpoint to `path`, completely or not at all.
    ///
    /// # Errors
    /// If `path` cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        self.write_if(path, || Ok(()))
    }

    /// As [`write`](Self::write), but calls `check` just before the file appears at `path`.
    ///
    /// # Errors
    /// The errors of [`write`](Self::write) and of `check`. If `check` fails, `path` is unchanged.
    pub(crate) fn write_if(&self, path: &Path, check: impl FnOnce() -> Result<()>) -> Result<()> {
        let RenderState { film, tally, seconds, .. } = self.rendering.borrow();
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
        write_atomically_if(path, check, |file| {
            let hashing = Hashing { inner: file, hasher: blake3::Hasher::new() };
            // Hashing is faster with many bytes at once.
            let mut file = BufWriter::with_capacity(1 << 16, hashing);
            file.write_all(MAGIC)?;
            serde_json::to_writer(&mut file, &header)?;
            file.write_all(b"\n")?;
            film.write(&mut file)?;
            let Hashing { inner, hasher } = file.into_inner()?;
            inner.write_all(hasher.finalize().as_bytes())
        })
    }
}

impl Checkpoint {
    /// Reads a checkpoint from `path`, within `limits`.
    ///
    /// # Errors
    /// If the file cannot be read, is not a checkpoint, has an unsupported version, is damaged, or exceeds a
    /// limit.
    pub fn read(path: &Path, limits: &Limits) -> Result<Self> {
        let bad = |message: String| Error::input(path.display().to_string(), "", message);
        let failed = |error| Error::io(path, "read")(error);
        let (length, mut file, line) = open(path)?;
        let is_whole = |file: &mut BufReader<File>| {
            file.rewind().and_then(|()| is_whole(file, length)).map_err(failed)
        };
        let damaged = || bad("damaged: the content is not as ptfast wrote it".to_owned());
        let header = match header(&line) {
            Ok(header) => header,
            Err(message) if length <= SOON_HASHED && is_whole(&mut file)? => {
                return Err(bad(message));
            }
            Err(_) => return Err(damaged()),
        };
        let Header { scene, identity, shard, samples: [first, end], tally, seconds, .. } = header;
        let area = identity.area();
        let channels = identity.settings.stored_layers().channels();
        limits.check_image(area.pixels(), Film::memory(area, first..end, channels)).map_err(bad)?;
        let before = MAGIC.len() + line.len();
        let of_film = length.saturating_sub((before + blake3::OUT_LEN) as u64);
        // The film has at least 4 bytes per pixel, which store the end of its samples.
        if of_film < 4 * area.pixels() {
            return Err(bad("damaged: the film is too short".to_owned()));
        }
        if of_film > Film::most_bytes(area, first..end, channels) {
            return Err(bad("damaged: the film is too long".to_owned()));
        }
        if !is_whole(&mut file)? {
            return Err(damaged());
        }
        file.seek(SeekFrom::Start(before as u64)).map_err(failed)?;
        let mut sums = file.take(of_film);
        let film =
            Film::read(area, first..end, channels, &mut sums).map_err(|error| {
                match error.kind() {
                    ErrorKind::InvalidData => bad(format!("damaged: {error}")),
                    ErrorKind::UnexpectedEof => bad("damaged: the film is too short".to_owned()),
                    _ => failed(error),
                }
            })?;
        if sums.limit() > 0 {
            return Err(bad("damaged: the film is too long".to_owned()));
        }
        let has = |x, y| shard.is_none_or(|shard| shard.has(identity.settings.width, x, y));
        if !film.is_of(has) {
            return Err(bad("damaged: the pixels are not those of its shard".to_owned()));
        }
        let mut rendering = RenderState::new(film, &identity.settings);
        (rendering.tally, rendering.seconds) = (tally, seconds);
        Ok(Self { scene, identity, shard, rendering })
    }

    /// Reads which part of which render the checkpoint at `path` holds, without reading the film.
    ///
    /// # Errors
    /// If the file cannot be read, or it does not have the header of a checkpoint.
    pub(crate) fn read_part(path: &Path) -> Result<Part> {
        let (_, _, line) = open(path)?;
        let bad = |message| Error::input(path.display().to_string(), "", message);
        let Header { identity, shard, samples: [first, end], .. } = header(&line).map_err(bad)?;
        Ok(Part { identity, shard, samples: first..end })
    }
}

/// Opens a checkpoint and returns its length in bytes, the file positioned after the second line, and that
/// line.
fn open(path: &Path) -> Result<(u64, BufReader<File>, Vec<u8>)> {
    let failed = |error| Error::io(path, "read")(error);
    let length = input::length(path)?;
    let mut file = File::open(path).map(BufReader::new).map_err(failed)?;
    let mut magic = [0; MAGIC.len()];
    if length < MAGIC.len() as u64 || file.read_exact(&mut magic).is_err() || magic != *MAGIC {
        return Err(Error::input(path.display().to_string(), "", "not a checkpoint of ptfast"));
    }
    let mut line = Vec::new();
    file.by_ref().take(MOST_HEADER).read_until(b'\n', &mut line).map_err(failed)?;
    Ok((length, file, line))
}

/// Whether a file of `length` bytes ends with the hash of all bytes before the hash.
fn is_whole(mut file: impl Read, length: u64) -> io::Result<bool> {
    let mut hasher = blake3::Hasher::new();
    let before = length.saturating_sub(blake3::OUT_LEN as u64);
    hasher.update_reader(file.by_ref().take(before))?;
    let mut hash = Vec::new();
    file.take(blake3::OUT_LEN as u64 + 1).read_to_end(&mut hash)?;
    Ok(hash == hasher.finalize().as_bytes())
}

/// Parses and checks the header, which is the second line of a file.
fn header(line: &[u8]) -> Result<Header, String> {
    let wrong = |error: serde_json::Error| format!("header: {error}");
    let header: Value = serde_json::from_slice(line).map_err(wrong)?;
    if header["schema"] != SCHEMA {
        let message = format!("version {} is not supported, it must be {SCHEMA}", header["schema"]);
        return Err(message);
    }
    let header: Header = serde_json::from_value(header).map_err(wrong)?;
    let Identity { settings, crop: [left, upper, right, lower], .. } = &header.identity;
    settings.check_ranges()?;
    let ImageSettings { width, height, spp, .. } = *settings;
    if !(left < right && *right <= width && upper < lower && *lower <= height) {
        return Err(format!("the crop is not within the image of {width} x {height} pixels"));
    }
    if header.shard.is_some_and(|Shard { index, count }| index >= count) {
        return Err("the shard index must be less than the shard count".to_owned());
    }
    let Header { tally, seconds, .. } = &header;
    if !(0.0..=MOST_SECONDS).contains(seconds) {
        return Err("the seconds must be 0 to 1e12".to_owned());
    }
    if tally.counts().any(|count| count > MOST_COUNT) {
        return Err("each count must be at most 2^53".to_owned());
    }
    let [first, end] = header.samples;
    if !(first.is_multiple_of(CHUNK) && first < end && end <= spp) {
        return Err(format!(
            "the samples {first}..{end} must begin at a multiple of {CHUNK} and end after it, at {spp} or less"
        ));
    }
    Ok(header)
}

/// A writer that hashes all bytes that pass through it.
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
