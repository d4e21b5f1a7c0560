//! The sections of MTL files: the lines of one material, and the values in them.

use std::collections::HashMap;
use std::path::Path;

use super::map::options;
use crate::formats::import::Import;
use crate::image::Encoding;
use crate::shading::TextureRef;
use crate::shading::texture::Image;

/// The lines of one material, by keyword in lower case: the line number and what follows.
pub(crate) struct Section<'a> {
    pub(crate) name: String,
    /// Whether Blender wrote the file, as its comment says.
    pub(crate) by_blender: bool,
    lines: HashMap<String, (usize, &'a str)>,
}

/// A line number and what is wrong there.
pub(crate) type Wrong = (usize, String);

/// The sections of a file. Only a `#` at the beginning of a line begins a comment, since names may
/// contain one.
pub(crate) fn sections(text: &str) -> Result<Vec<Section<'_>>, Wrong> {
    let mut sections: Vec<Section<'_>> = Vec::new();
    let mut by_blender = false;
    for (line, content) in text.lines().enumerate() {
        let content = content.trim();
        let (keyword, rest) = content.split_once([' ', '\t']).unwrap_or((content, ""));
        match (keyword, sections.last_mut()) {
            ("", _) => {}
            _ if keyword.starts_with('#') => by_blender |= content.starts_with("# Blender"),
            ("newmtl", _) => sections.push(Section {
                name: rest.trim().to_owned(),
                by_blender,
                lines: HashMap::new(),
            }),
            (_, None) => return Err((line + 1, format!("`{keyword}` comes before `newmtl`"))),
            (_, Some(section)) => {
                section.lines.insert(keyword.to_lowercase(), (line + 1, rest.trim()));
            }
        }
    }
    Ok(sections)
}

impl Section<'_> {
    pub(crate) fn has(&self, keyword: &str) -> bool {
        self.lines.contains_key(keyword)
    }

    /// Whether the line has only zeros, so that it asks for nothing.
    pub(crate) fn is_zero(&self, keyword: &str) -> bool {
        let text = self.lines.get(keyword).map_or("", |(_, text)| text);
        let mut words =
            text.split('#').next().unwrap_or_default().split_ascii_whitespace().peekable();
        words.peek().is_some() && words.all(|word| word.parse() == Ok(0.0_f32))
    }

    /// The keywords of the lines, in alphabetic order.
    pub(crate) fn keywords(&self) -> Vec<&str> {
        let mut keywords: Vec<&str> = self.lines.keys().map(String::as_str).collect();
        keywords.sort_unstable();
        keywords
    }

    fn numbers<const N: usize>(&self, keyword: &str) -> Result<Option<[f32; N]>, Wrong> {
        let Some(&(line, text)) = self.lines.get(keyword) else { return Ok(None) };
        // `d -halo` makes a surface more opaque at its rim.
        let text = text.trim_start_matches("-halo").split('#').next().unwrap_or_default();
        let numbers: Option<Vec<f32>> =
            text.split_ascii_whitespace().take(N).map(|word| word.parse().ok()).collect();
        let numbers = numbers.filter(|numbers| numbers.iter().all(|number| number.is_finite()));
        match numbers.as_deref() {
            // A single number is grey.
            Some([one]) => Ok(Some([*one; N])),
            Some(numbers) if numbers.len() == N => Ok(numbers.try_into().ok()),
            _ => {
                let wanted = if N == 1 { "a finite number" } else { "one or three finite numbers" };
                Err((line, format!("`{keyword}` must be {wanted}, is `{text}`")))
            }
        }
    }

    /// A colour in RGB.
    pub(crate) fn color(
        &self,
        keyword: &str,
        import: &mut Import<'_>,
    ) -> Result<Option<[f32; 3]>, Wrong> {
        let words = |(_, text): &(usize, &str)| text.starts_with(char::is_alphabetic);
        if self.lines.get(keyword).is_some_and(words) {
            import.warn(format!("`{keyword}` is only supported as RGB, so it has its usual value"));
            return Ok(None);
        }
        self.numbers::<3>(keyword)
    }

    pub(crate) fn number(&self, keyword: &str) -> Result<Option<f32>, Wrong> {
        Ok(self.numbers::<1>(keyword)?.map(|[number]| number))
    }

    /// The texture of the first of these maps, if there is one that can be used.
    pub(crate) fn texture(
        &self,
        keywords: &[&str],
        encoding: Encoding,
        import: &mut Import<'_>,
        folder: &Path,
    ) -> Option<TextureRef> {
        let mut image = self.image(keywords, import, folder)?;
        image.encoding = encoding;
        image.normal_scale = 1.0;
        Some(image.into())
    }

    /// The image of the first of these maps, if there is one that can be used.
    pub(crate) fn image(
        &self,
        keywords: &[&str],
        import: &mut Import<'_>,
        folder: &Path,
    ) -> Option<Image> {
        let &(_, text) = keywords.iter().find_map(|keyword| self.lines.get(*keyword))?;
        let (mut image, file) = options(text, import);
        if file.is_empty() {
            return None;
        }
        image.file = folder.join(file).to_string_lossy().into_owned();
        import.is_usable(&image.file, "so it is left out").then_some(image)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_may_contain_hashes_and_numbers_may_have_comments() {
        let text = "# mtllib\nnewmtl Mat #1\nKd 1 0 0 # red\nNs 5\nd -halo 0.5\nnewmtl Mat #2\n";
        let sections = sections(text).unwrap();
        let names: Vec<_> = sections.iter().map(|section| &*section.name).collect();
        assert_eq!(names, ["Mat #1", "Mat #2"]);
        assert_eq!(sections[0].numbers("kd"), Ok(Some([1.0, 0.0, 0.0])));
        assert_eq!(
            (sections[0].number("ns"), sections[0].number("d")),
            (Ok(Some(5.0)), Ok(Some(0.5)))
        );
        assert_eq!(sections[0].keywords(), ["d", "kd", "ns"]);
        assert_eq!((sections[1].has("kd"), sections[1].number("ns")), (false, Ok(None)));
    }
}
