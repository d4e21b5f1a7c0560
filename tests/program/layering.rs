//! Checks the source against the layering rules of ARCHITECTURE.md: which module may import which.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Reads the layering table: module → modules that it may import.
fn allowed() -> BTreeMap<String, BTreeSet<String>> {
    let text = fs::read_to_string("ARCHITECTURE.md").unwrap();
    let table = text
        .split("<!-- layering -->")
        .nth(1)
        .expect("the layering table must be marked by `<!-- layering -->`");
    let names = |cell: &str| -> BTreeSet<String> {
        cell.split('`').skip(1).step_by(2).map(str::to_owned).collect()
    };
    let mut allowed = BTreeMap::new();
    for row in table.lines().filter(|line| line.starts_with("| `")) {
        let cells: Vec<&str> = row.split('|').collect();
        for module in names(cells[1]) {
            allowed.insert(module, names(cells[2]));
        }
    }
    allowed
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// The top-level module of a source file, or `None` for the roots of the crate.
fn module_of(path: &Path) -> Option<String> {
    let inside = path.strip_prefix("src").unwrap();
    let first = inside.components().next().unwrap().as_os_str().to_str().unwrap();
    let name = first.strip_suffix(".rs").unwrap_or(first);
    (!matches!(name, "lib" | "main" | "build")).then(|| name.to_owned())
}

/// The name after each `crate::` outside comments and test modules.
fn imports(text: &str) -> BTreeSet<String> {
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap();
    let code: String = text.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
    let name = |rest: &str| -> String {
        rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
    };
    code.split("crate::").skip(1).map(name).collect()
}

#[test]
fn modules_import_only_what_architecture_allows() {
    let allowed = allowed();
    assert!(allowed.len() > 8, "the layering table of ARCHITECTURE.md was not found: {allowed:?}");
    let mut files = Vec::new();
    sources(Path::new("src"), &mut files);
    let mut modules = BTreeSet::new();
    for path in files {
        let Some(module) = module_of(&path) else { continue };
        let may = allowed
            .get(&module)
            .unwrap_or_else(|| panic!("`{module}` is missing in the table of ARCHITECTURE.md"));
        let text = fs::read_to_string(&path).unwrap();
        // `formats` adds methods to `Scene`, which need no import. `engine/proof` is a test.
        if module != "formats" && !may.contains("formats") && !path.starts_with("src/engine/proof")
        {
            let code = text.split("#[cfg(test)]\nmod tests").next().unwrap();
            let mut calls = ["Scene::load(", "Scene::from_"].into_iter();
            assert!(!calls.any(|call| code.contains(call)), "{} loads a scene", path.display());
        }
        for import in imports(&text) {
            assert!(
                import == module || may.contains(&import),
                "{} imports `{import}`, but ARCHITECTURE.md allows only {may:?}",
                path.display()
            );
        }
        modules.insert(module);
    }
    let listed: BTreeSet<String> = allowed.into_keys().collect();
    assert_eq!(listed, modules, "ARCHITECTURE.md lists modules that do not exist");
}

/// The module path of a source file: `[engine, wavefront, order]` for `engine/wavefront/order.rs`.
fn path_of(file: &Path) -> Vec<String> {
    let inside = file.strip_prefix("src").unwrap().with_extension("");
    let names = inside.iter().map(|name| name.to_str().unwrap().to_owned());
    names.filter(|name| !matches!(&**name, "mod" | "lib")).collect()
}

/// Parses the paths at the start of `text`, such as `a::{b, c::d}`, and returns the rest of it too.
fn tree(text: &str) -> (Vec<Vec<String>>, &str) {
    let end = text.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(text.len());
    let (name, mut rest) = text.split_at(end);
    let mut paths = Vec::new();
    if let Some(mut inside) = rest.strip_prefix("::{") {
        loop {
            let (more, after) = tree(inside.trim_start());
            paths.extend(more);
            // Skip `as another` after the name, up to a comma or the end.
            let end = after.find([',', '}']).unwrap_or(after.len());
            let (mark, next) = after[end..].split_at(after[end..].len().min(1));
            (rest, inside) = (next, next.trim_start());
            if mark != "," {
                break;
            }
            if let Some(after) = inside.strip_prefix('}') {
                rest = after;
                break;
            }
        }
    } else if let Some(after) = rest.strip_prefix("::") {
        (paths, rest) = tree(after);
    } else {
        return (vec![vec![name.to_owned()]], rest);
    }
    for path in &mut paths {
        path.insert(0, name.to_owned());
    }
    (paths, rest)
}

/// All paths that the file of `module` names by `crate` or `super`, relative to the root of the crate.
fn named_paths(module: &[String], text: &str) -> Vec<Vec<String>> {
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap();
    let lines = text.lines().filter(|line| !line.trim_start().starts_with("//"));
    let code = lines.collect::<Vec<_>>().join("\n");
    let mut found = Vec::new();
    for (start, root) in code.match_indices("crate::").chain(code.match_indices("super::")) {
        if code[..start].ends_with(|c: char| c.is_alphanumeric() || matches!(c, '_' | ':')) {
            continue; // part of a longer path
        }
        let mut rest = &code[start + root.len()..];
        let mut base = if root == "crate::" { &[][..] } else { &module[..module.len() - 1] };
        while let Some(after) = rest.strip_prefix("super::") {
            (rest, base) = (after, &base[..base.len() - 1]);
        }
        found.extend(
            tree(&format!("_::{rest}"))
                .0
                .into_iter()
                .map(|path| base.iter().chain(&path[1..]).cloned().collect::<Vec<String>>()),
        );
    }
    found
}

/// For each module with a `mod.rs`, maps each name that it imports from a module in its folder to
/// this module.
fn re_exports(files: &[PathBuf]) -> BTreeMap<Vec<String>, BTreeMap<String, String>> {
    let mut all = BTreeMap::new();
    for file in files.iter().filter(|file| file.ends_with("mod.rs")) {
        let text = fs::read_to_string(file).unwrap();
        let mut names = BTreeMap::new();
        for (start, _) in text.match_indices("use ") {
            let text = text[start + 4..].trim_start_matches("self::");
            for path in tree(&format!("_::{text}")).0 {
                if let [_, child, .., name] = &path[..] {
                    // `child::*` would hide the names of a module from this test.
                    let known = !name.is_empty() || ["rayon", "super"].contains(&&**child);
                    assert!(known, "{} imports {child}::*", file.display());
                    names.insert(name.clone(), child.clone());
                }
            }
        }
        all.insert(path_of(file), names);
    }
    all
}

/// The entries of `imports` that are part of a circle or lead to one.
fn circles(mut imports: BTreeMap<String, BTreeSet<String>>) -> BTreeMap<String, BTreeSet<String>> {
    // Remove modules whose imports have all been removed.
    loop {
        let left: BTreeSet<String> = imports.keys().cloned().collect();
        imports.retain(|_, to| !to.is_disjoint(&left));
        if imports.len() == left.len() {
            return imports;
        }
    }
}

/// Folders that may have circles, because their types define each other: a vector of floats has bits,
/// which are integers.
const ONE_VOCABULARY: [&str; 1] = ["simd"];

/// Modules of one folder must not import each other in a circle.
#[test]
fn imports_have_no_circles() {
    let mut files = Vec::new();
    sources(Path::new("src"), &mut files);
    // Folder → module in it → modules of the same folder that its files import.
    let mut folders: BTreeMap<Vec<String>, BTreeMap<String, BTreeSet<String>>> = BTreeMap::new();
    let modules: BTreeSet<Vec<String>> = files.iter().map(|file| path_of(file)).collect();
    let re_exports = re_exports(&files);
    for file in &files {
        let module = path_of(file);
        for path in named_paths(&module, &fs::read_to_string(file).unwrap()) {
            let common = module.iter().zip(&path).take_while(|(a, b)| a == b).count();
            let (Some(from), Some(to)) = (module.get(common), path.get(common)) else { continue };
            let there = &path[..common];
            let direct = modules.contains(&path[..=common]).then_some(to);
            let to = direct.or_else(|| re_exports.get(there)?.get(to));
            if let Some(to) = to.filter(|to| *to != from) {
                let folder = folders.entry(there.to_vec()).or_default();
                folder.entry(from.clone()).or_default().insert(to.clone());
            }
        }
    }
    assert!(folders.len() > 10, "the imports were not found");
    for (folder, imports) in folders {
        let (folder, circles) = (folder.join("/"), circles(imports));
        let allowed = ONE_VOCABULARY.contains(&&*folder);
        assert!(allowed || circles.is_empty(), "circles in src/{folder}: {circles:?}");
    }
}

#[test]
fn circles_are_found() {
    let imports = |all: &[(&str, &str)]| {
        let mut imports: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for (from, to) in all {
            imports.entry((*from).to_owned()).or_default().insert((*to).to_owned());
        }
        circles(imports).len()
    };
    assert_eq!(imports(&[("a", "b"), ("b", "c"), ("a", "c")]), 0);
    assert_eq!(imports(&[("a", "b"), ("b", "c"), ("c", "b"), ("b", "d")]), 3);
}

/// Each file must begin with a `//!` line that says what the file is for.
#[test]
fn every_file_says_what_it_is_for() {
    let mut files = Vec::new();
    sources(Path::new("src"), &mut files);
    for path in files {
        let text = fs::read_to_string(&path).unwrap();
        let first = text.lines().next().unwrap_or_default();
        assert!(first.starts_with("//! ") && first.len() > 10, "{}: {first}", path.display());
    }
}

#[test]
fn named_paths_are_found() {
    let text = "use crate::math::{dot as d, trig::{sin, cos,}};\npub(super) fn f() { super::g::h() }\n\
                use super::super::x;\n// crate::cli\n";
    let module = ["a", "b"].map(str::to_owned);
    let paths: Vec<String> =
        named_paths(&module, text).iter().map(|path| path.join("::")).collect();
    assert_eq!(paths, ["math::dot", "math::trig::sin", "math::trig::cos", "a::g::h", "x"]);
}

#[test]
fn imports_are_found() {
    let text = "use crate::math::dot;\n// crate::cli\nfn f() { crate::limits::check() }\n";
    let want = BTreeSet::from(["math".to_owned(), "limits".to_owned()]);
    assert_eq!(imports(text), want);
}
