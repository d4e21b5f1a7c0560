//! Checks the headers of OpenEXR files before the decoder loads them into memory.

use std::io::{self, BufRead, ErrorKind, Read, Seek};

/// Largest number of attributes of all parts. The decoder needs a few hundred bytes for each.
const MAX_ATTRIBUTES: usize = 1 << 13;
/// Largest number of bytes of a name, with its end.
const MAX_NAME: u64 = 257;
/// The flag of files with several parts, in the bytes that follow the signature.
const PARTS: u32 = 1 << 12;
/// The first compression method that the decoder does not know, and with it not even the rest of the header.
const UNKNOWN: u8 = 12;

/// Checks the number of attributes and the compression methods. The validity of the headers is left to the decoder.
pub(super) fn check(file: impl BufRead + Seek) -> Result<(), String> {
    match walk(file) {
        Ok(result) => result,
        // The decoder reports truncated files with a better message.
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => Ok(()),
        Err(error) => Err(format!("damaged image: {error}")),
    }
}

fn walk(mut file: impl BufRead + Seek) -> io::Result<Result<(), String>> {
    let _signature = number(&mut file)?;
    let several = number(&mut file)? & PARTS != 0;
    let (mut attributes, mut in_header) = (0, false);
    loop {
        let name = text(&mut file)?;
        if name.is_empty() {
            // Without a name, a header ends, and with an empty header the list of them.
            if !(several && in_header) {
                return Ok(Ok(()));
            }
            in_header = false;
            continue;
        }
        (attributes, in_header) = (attributes + 1, true);
        if attributes > MAX_ATTRIBUTES {
            return Ok(Err(format!(
                "damaged image: it has too many attributes (at most {MAX_ATTRIBUTES} are allowed)"
            )));
        }
        text(&mut file)?;
        let mut size = i64::from(number(&mut file)?);
        if name == b"compression" && size > 0 {
            let mut method = [0];
            file.read_exact(&mut method)?;
            size -= 1;
            match method[0] {
                13 => return Ok(Err(super::compression("ZSTD"))),
                method @ UNKNOWN.. => {
                    return Ok(Err(super::compression(&format!("number {method}"))));
                }
                _ => {}
            }
        }
        file.seek_relative(size)?;
    }
}

fn number(file: &mut impl Read) -> io::Result<u32> {
    let mut bytes = [0; 4];
    file.read_exact(&mut bytes)?;
    Ok(u32::from_le_bytes(bytes))
}

/// A text that ends with a zero, without it. A longer one is cut, which the decoder rejects.
fn text(file: &mut impl BufRead) -> io::Result<Vec<u8>> {
    let mut text = Vec::new();
    file.take(MAX_NAME).read_until(0, &mut text)?;
    match text.pop() {
        Some(0) => Ok(text),
        _ => Err(ErrorKind::UnexpectedEof.into()),
    }
}
