//! The texture maps of MTL files, with their options.

use crate::formats::import::Import;
use crate::shading::texture::{Image, Wrap};

/// The options of a map that are read, or change nothing here: filtering, and the size of textures in
/// memory.
const READ: [&str; 8] = ["-s", "-o", "-clamp", "-blendu", "-blendv", "-boost", "-bm", "-texres"];

/// The options of a map and its file, whose name may contain blanks.
pub(crate) fn options(text: &str, import: &mut Import<'_>) -> (Image, String) {
    let mut image = Image::from_file("");
    let mut rest = text.trim();
    while rest.starts_with('-') {
        let (option, after) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
        let most = match option {
            "-s" | "-o" | "-t" => 3,
            "-mm" => 2,
            _ => 1,
        };
        let (mut values, mut after) = (Vec::new(), after.trim_start());
        while values.len() < most {
            let (word, next) = after.split_once(char::is_whitespace).unwrap_or((after, ""));
            // `-s` and `-o` may have fewer than three numbers.
            if most > 1 && word.parse::<f32>().is_err() {
                break;
            }
            values.push(word);
            after = next.trim_start();
        }
        let number = |i: usize, usual: f32| {
            let number = values.get(i).and_then(|word| word.parse().ok());
            number.filter(|number: &f32| number.abs() <= 1e6).unwrap_or(usual)
        };
        match option {
            "-s" => image.scale = (number(0, 1.0), number(1, 1.0)),
            "-o" => image.offset = (number(0, 0.0), number(1, 0.0)),
            // The strength of bumps, and of normals in Blender's files.
            "-bm" => image.normal_scale = number(0, 1.0).clamp(-1e3, 1e3),
            "-clamp" if values.first() == Some(&"on") => {
                (image.wrap_u, image.wrap_v) = (Wrap::Clamp, Wrap::Clamp);
            }
            _ => {}
        }
        // `off` is the default of the others.
        if !READ.contains(&option) && values.first() != Some(&"off") {
            import.warn(format!(
                "the option `{option}` of maps is not supported, so it has no effect"
            ));
        }
        rest = after;
    }
    (image, rest.replace('\\', "/"))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::formats::ImportOptions;
    use crate::limits::{Budget, Limits};

    #[test]
    fn maps_have_options_and_names_with_blanks() {
        let (limits, choices) = (Limits::default(), ImportOptions::default());
        let budget = Budget::new(&limits, 0);
        let mut import = Import::new(Path::new(""), &choices, &budget);
        let mut options = |text| options(text, &mut import);
        let (image, file) = options("-s 2 3 -o 0.5 0.25 0 -clamp on -bm 0.3 my folder\\a b#1.png");
        assert_eq!(file, "my folder/a b#1.png");
        assert_eq!((image.scale, image.offset), ((2.0, 3.0), (0.5, 0.25)));
        assert_eq!((image.wrap_u, image.normal_scale), (Wrap::Clamp, 0.3));
        assert_eq!(options("-mm 0 2 a.png").1, "a.png");
        let warnings = import.into_warnings("a.obj").unwrap();
        assert_eq!(warnings.len(), 1);
        assert!(warnings[0].contains("`-mm` of maps is not supported"), "{warnings:?}");
    }
}
