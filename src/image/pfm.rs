//! Reads portable float maps (PFM).

use image::Rgb32FImage;

use crate::limits::MAX_SIDE;

/// Header of a portable float map: `PF` (colour) or `Pf` (grey), the size, and a scale whose sign gives the byte order,
/// and whose magnitude multiplies all values.
pub(super) struct Pfm {
    width: u32,
    height: u32,
    channels: usize,
    little_endian: bool,
    scale: f32,
    /// Length of the header in bytes.
    begin: usize,
}

impl Pfm {
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, String> {
        let mut rest = bytes;
        let mut word = || {
            // Programs also write several blanks, and comments.
            while let Some(first) = rest.first() {
                let skipped = match first {
                    b'#' => rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len() - 1),
                    first if first.is_ascii_whitespace() => 0,
                    _ => break,
                };
                rest = &rest[skipped + 1..];
            }
            let end = rest
                .iter()
                .position(u8::is_ascii_whitespace)
                .ok_or("damaged PFM header: expected `PF` or `Pf`, width, height and scale")?;
            let word = std::str::from_utf8(&rest[..end])
                .map_err(|_| "damaged PFM header: it is not text")?;
            rest = &rest[end + 1..];
            Ok::<&str, String>(word)
        };
        let channels = match word()? {
            "PF" => 3,
            "Pf" => 1,
            _ => return Err("not a PFM file: it must begin with PF or Pf".into()),
        };
        let mut side = || {
            let word = word()?;
            match word.parse() {
                Ok(side) if (1..=MAX_SIDE).contains(&side) => Ok(side),
                _ => Err(format!("damaged PFM header: size `{word}` is not in 1 to {MAX_SIDE}")),
            }
        };
        let (width, height) = (side()?, side()?);
        let scale: f32 =
            word()?.parse().map_err(|_| "damaged PFM header: the scale is not a number")?;
        if !scale.is_finite() || scale == 0.0 {
            return Err("damaged PFM header: the scale is 0 or not finite".into());
        }
        let begin = bytes.len() - rest.len();
        Ok(Self { width, height, channels, little_endian: scale < 0.0, scale: scale.abs(), begin })
    }

    pub(super) fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    pub(super) fn check_length(&self, length: u64) -> Result<(), String> {
        let Self { width, height, channels, begin, .. } = *self;
        let (expected, found) = (self.pixels() * 4 * channels as u64, length - begin as u64);
        if found == expected {
            return Ok(());
        }
        Err(format!("damaged PFM: {width} × {height} pixels need {expected} bytes, found {found}"))
    }

    /// Decodes the image in `bytes`, whose length must be right.
    pub(super) fn image(&self, bytes: &[u8]) -> Rgb32FImage {
        let value = |b: &[u8]| {
            let b = [b[0], b[1], b[2], b[3]];
            let read = if self.little_endian { f32::from_le_bytes } else { f32::from_be_bytes };
            read(b) * self.scale
        };
        let channels = self.channels;
        let pixels = bytes[self.begin..]
            .chunks_exact(self.width as usize * channels * 4)
            .rev()
            .flat_map(|row| row.chunks_exact(channels * 4))
            .flat_map(|p| [0, 1, 2].map(|c| value(&p[4 * c.min(channels - 1)..])))
            .collect();
        Rgb32FImage::from_raw(self.width, self.height, pixels).expect("the length is right")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pfm_of_both_byte_orders_and_grey() {
        let mut bytes = b"Pf\n1 2\n1.0\n".to_vec();
        bytes.extend(1.0f32.to_be_bytes());
        bytes.extend(2.0f32.to_be_bytes());
        let read_pfm = |bytes: &[u8]| {
            let pfm = Pfm::parse(bytes)?;
            pfm.check_length(bytes.len() as u64).map(|()| pfm.image(bytes))
        };
        let image = read_pfm(&bytes).unwrap();
        assert_eq!(*image.as_raw(), [2.0, 2.0, 2.0, 1.0, 1.0, 1.0], "the bottom row comes first");
        // OpenImageIO, Mitsuba and pbrt multiply by the magnitude.
        let scaled = [&b"Pf\n1 1\n-2.5\n"[..], &2.0f32.to_le_bytes()].concat();
        assert_eq!(*read_pfm(&scaled).unwrap().as_raw(), [5.0; 3]);
        assert!(read_pfm(b"PF\n1 1\n0\n").unwrap_err().contains("the scale is 0"));
        bytes.pop();
        assert!(read_pfm(&bytes).unwrap_err().contains("need 8 bytes"));
        assert!(read_pfm(b"PF\n0 1\n-1\n").unwrap_err().contains("size `0`"));
        assert!(read_pfm(b"P6 ").unwrap_err().contains("PF or Pf"));
    }
}
