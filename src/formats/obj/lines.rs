//! Parses a part of an OBJ file, apart from what its faces refer to.

use std::str::{self, FromStr};

use glam::{DVec3, Vec2, Vec3};
use memchr::{memchr, memchr_iter};

use crate::scene::mesh::in_range;

pub(crate) const VERTEX: &str = "a vertex is `v` and three numbers";
pub(crate) const RANGE: &str = "coordinates must be finite and within ±1e9";
pub(crate) const NORMAL: &str = "a normal is `vn` and three finite numbers";
pub(crate) const UV: &str = "texture coordinates are `vt` and one to three finite numbers";
pub(crate) const FACE: &str = "a face is `f` and three or more vertex numbers";
/// Never reported: the next line continues this one.
const CONTINUED: &str = "continued";
pub(crate) const LONG: &str = "a line may have at most 65536 bytes";

/// Largest size of a line in bytes.
const MAX_LINE: usize = 1 << 16;
/// The number of an attribute that a corner does not have.
pub(crate) const ABSENT: i32 = i32::MIN;

/// Consecutive lines of a file.
#[derive(Default)]
pub(crate) struct ParsedLines<'a> {
    /// What is subtracted from positions.
    origin: DVec3,
    pub(crate) positions: Vec<Vec3>,
    /// The colour of each position, or empty if there is none.
    pub(crate) colors: Vec<Vec3>,
    pub(crate) uvs: Vec<Vec2>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) faces: Vec<Face>,
    /// The corners of all faces: the numbers in the file of position, texture coordinates and normal.
    pub(crate) corners: Vec<[i32; 3]>,
    /// Names, each with the number of faces before it.
    pub(crate) names: Vec<(usize, Kind, &'a [u8])>,
    /// Number of lines that have been read.
    pub(crate) lines: usize,
    /// The reason why the line after those could not be read.
    pub(crate) error: Option<&'static str>,
}

/// A polygon.
pub(crate) struct Face {
    /// Number of lines of the part before this one.
    pub(crate) line: u32,
    /// One past its last corner in [`ParsedLines::corners`].
    pub(crate) end: u32,
    /// Number of positions, texture coordinates and normals of the part before this line.
    pub(crate) before: [u32; 3],
}

/// What a name stands for.
#[derive(Clone, Copy)]
pub(crate) enum Kind {
    Material,
    Group,
    Object,
}

impl<'a> ParsedLines<'a> {
    /// Reads all lines of `bytes`, or those before the first invalid one.
    pub(crate) fn parse(bytes: &'a [u8], origin: DVec3) -> Self {
        let mut part = Self { origin, ..Self::default() };
        let mut begin = 0;
        let mut ends = memchr_iter(b'\n', bytes).chain([bytes.len()]);
        while let Some(mut end) = ends.next() {
            let mut count = 1;
            let mut read = part.line(&bytes[begin..end]);
            if read == Err(CONTINUED) {
                let mut joined = Vec::new();
                while let Some(line) = continued(&bytes[begin..end])
                    && joined.len() <= MAX_LINE
                    && let Some(next) = ends.next()
                {
                    joined.extend_from_slice(line);
                    joined.push(b' ');
                    (begin, end) = (end + 1, next);
                    count += 1;
                }
                let last = &bytes[begin..end];
                joined.extend_from_slice(continued(last).unwrap_or(last));
                read = if joined.len() > MAX_LINE { Err(LONG) } else { part.joined(&joined) };
            }
            part.error = read.err();
            if part.error.is_some() {
                break;
            }
            part.lines += count;
            begin = end + 1;
        }
        part
    }

    fn line(&mut self, line: &'a [u8]) -> Result<(), &'static str> {
        if line.len() > MAX_LINE {
            return Err(LONG);
        }
        let line = line.trim_ascii();
        let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
        let (keyword, whole) = line.split_at(end);
        let mut name = |kind| self.names.push((self.faces.len(), kind, whole.trim_ascii()));
        match keyword {
            b"usemtl" => name(Kind::Material),
            b"o" => name(Kind::Object),
            b"g" => name(Kind::Group),
            _ => self.numbers(keyword, whole)?,
        }
        Ok(())
    }

    /// Reads a line that was joined from several.
    fn joined(&mut self, line: &[u8]) -> Result<(), &'static str> {
        let line = line.trim_ascii();
        let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
        self.numbers(&line[..end], &line[end..])
    }

    /// Reads a line with numbers.
    #[inline(always)]
    fn numbers(&mut self, keyword: &[u8], whole: &[u8]) -> Result<(), &'static str> {
        // Names may contain a `#`.
        let rest = &whole[..memchr(b'#', whole).unwrap_or(whole.len())];
        let words = |wrong| {
            let words = str::from_utf8(rest).map_err(|_| wrong)?;
            if words.ends_with('\\') { Err(CONTINUED) } else { Ok(words) }
        };
        match keyword {
            b"v" => self.vertex(words(VERTEX)?)?,
            b"vn" => {
                let normal = numbers::<3>(words(NORMAL)?).filter(|(_, count)| *count == 3);
                let normal = normal.map(|(numbers, _)| Vec3::from_array(numbers));
                self.normals.push(normal.filter(|normal| normal.is_finite()).ok_or(NORMAL)?);
            }
            b"vt" => {
                let uv = numbers::<3>(words(UV)?).filter(|(_, count)| *count >= 1);
                let uv = uv.map(|([u, v, _], _)| Vec2::new(u, v));
                self.uvs.push(uv.filter(|uv| uv.is_finite()).ok_or(UV)?);
            }
            b"f" => self.face(words(FACE)?)?,
            _ => {}
        }
        Ok(())
    }

    fn vertex(&mut self, words: &str) -> Result<(), &'static str> {
        let (numbers, count) = numbers::<6>(words).ok_or(VERTEX)?;
        let [x, y, z, w, g, b] = numbers;
        // After three coordinates, there may be w or a colour.
        let position = match count {
            3 | 6 => Vec3::new(x, y, z),
            4 | 5 if w != 0.0 => Vec3::new(x, y, z) / w,
            _ => return Err(VERTEX),
        };
        if !(in_range(position) && [w, g, b].iter().all(|c| c.is_finite())) {
            return Err(RANGE);
        }
        if count >= 6 {
            // Positions without a colour are white.
            self.colors.resize(self.positions.len(), Vec3::ONE);
            self.colors.push(Vec3::new(w, g, b));
        }
        self.positions.push(if self.origin == DVec3::ZERO {
            position
        } else {
            let ([x, y, z, w], _) = parsed::<f64, 4>(words).ok_or(VERTEX)?;
            let w = if matches!(count, 4 | 5) { w } else { 1.0 };
            (DVec3::new(x, y, z) / w - self.origin).as_vec3()
        });
        Ok(())
    }

    fn face(&mut self, words: &str) -> Result<(), &'static str> {
        let first = self.corners.len();
        for word in words.split_ascii_whitespace() {
            self.corners.push(corner(word).ok_or(FACE)?);
        }
        let end = self.corners.len();
        if end < first + 3 {
            return Err(FACE);
        }
        let before =
            [self.positions.len(), self.uvs.len(), self.normals.len()].map(|len| len as u32);
        self.faces.push(Face { line: self.lines as u32, end: end as u32, before });
        Ok(())
    }
}

/// The line without the backslash at its end, if it has one: then the next line continues it.
pub(crate) fn continued(line: &[u8]) -> Option<&[u8]> {
    line.trim_ascii_end().strip_suffix(b"\\")
}

/// The numbers of a corner such as `1`, `1/2`, `1/2/3` or `1//3`.
fn corner(word: &str) -> Option<[i32; 3]> {
    let mut numbers = [ABSENT; 3];
    let (mut slot, mut rest) = (0, word.as_bytes());
    loop {
        let (number, after) = integer(rest);
        *numbers.get_mut(slot)? = number.unwrap_or(ABSENT);
        match after {
            [] => return (numbers[0] != ABSENT).then_some(numbers),
            [b'/', after @ ..] => (slot, rest) = (slot + 1, after),
            _ => return None,
        }
    }
}

/// The integer at the front of `bytes`, if there is one, and what follows it. Values out of range are
/// limited: no file has so many vertices.
fn integer(bytes: &[u8]) -> (Option<i32>, &[u8]) {
    let (is_negative, digits) = match bytes {
        [b'-', digits @ ..] => (true, digits),
        digits => (false, digits),
    };
    let (mut value, mut after) = (0_i32, digits);
    while let [digit @ b'0'..=b'9', next @ ..] = after {
        value = value.saturating_mul(10).saturating_add(i32::from(digit - b'0'));
        after = next;
    }
    match after.len() == digits.len() {
        true => (None, bytes),
        false => (Some(if is_negative { -value } else { value }), after),
    }
}

/// Up to N numbers, and how many there are. Missing ones are 0; further words are not read. `None`
/// if a word is not a number.
fn numbers<const N: usize>(words: &str) -> Option<([f32; N], usize)> {
    parsed(words)
}

/// As [`numbers`], with any precision.
#[inline(always)]
fn parsed<T: Default + Copy + FromStr, const N: usize>(words: &str) -> Option<([T; N], usize)> {
    let (mut numbers, mut count) = ([T::default(); N], 0);
    for word in words.split_ascii_whitespace().take(N) {
        numbers[count] = word.parse().ok()?;
        count += 1;
    }
    Some((numbers, count))
}
