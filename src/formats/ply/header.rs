//! Headers of PLY files, as the parser takes them.

/// A header with names that the parser reads.
pub(super) struct Header {
    pub(super) text: String,
    /// Number of bytes of the header in the file.
    pub(super) bytes: usize,
}

/// Last line of a header.
const END: &[u8] = b"end_header";

impl Header {
    /// Finds the header at the beginning of `bytes`, of at most `most` bytes. Without an end, it is all that
    /// there may be. The parser only knows names of ASCII letters, digits and a few signs, so that others,
    /// which no reader looks for, are replaced: Blender's attributes have blanks, for example.
    pub(super) fn new(bytes: &[u8], most: usize) -> Result<Self, String> {
        let (mut text, mut end) = (String::new(), 0);
        for (number, line) in
            bytes[..bytes.len().min(most)].split_inclusive(|byte| *byte == b'\n').enumerate()
        {
            end += line.len();
            text.push_str(&plain(&String::from_utf8_lossy(line), number));
            if line.trim_ascii_end() == END {
                return Ok(Self { text, bytes: end });
            }
        }
        match bytes.len() > most {
            true => Err(format!("the header must end with `end_header` within {most} bytes")),
            false => Ok(Self { text, bytes: end }),
        }
    }
}

/// The line with a name that the parser reads, which `number` makes unique.
fn plain(line: &str, number: usize) -> String {
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let before = match words[..] {
        ["property", "list", _, _, _, ..] => 4,
        ["property", _, _, ..] => 2,
        _ => return line.to_owned(),
    };
    let [name] = words[before..] else {
        return format!("{} _{number}\n", words[..before].join(" "));
    };
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    match name.chars().all(is_plain) && !name.starts_with(|c: char| c.is_ascii_digit() || c == '-')
    {
        true => line.to_owned(),
        false => format!("{} _{number}\n", words[..before].join(" ")),
    }
}
