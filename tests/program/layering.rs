//! ARCHITECTURE.md says which module may import which; this holds the source to it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The rows of the layering table: module → modules that it may import.
fn allowed() -> BTreeMap<String, BTreeSet<String>> {
    let text = fs::read_to_string("ARCHITECTURE.md").unwrap();
    let table = text.split("<!-- layering -->").nth(1).expect("the layering table is marked");
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

/// The top-level module of a source file; `None` for the crate's roots.
fn module_of(path: &Path) -> Option<String> {
    let inside = path.strip_prefix("src").unwrap();
    let first = inside.components().next().unwrap().as_os_str().to_str().unwrap();
    let name = first.strip_suffix(".rs").unwrap_or(first);
    (!matches!(name, "lib" | "main" | "build")).then(|| name.to_owned())
}

/// Every `crate::name` outside comments and test modules.
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
    assert!(allowed.len() > 8, "the table was not found: {allowed:?}");
    let mut files = Vec::new();
    sources(Path::new("src"), &mut files);
    let mut modules = BTreeSet::new();
    for path in files {
        let Some(module) = module_of(&path) else { continue };
        let may = allowed
            .get(&module)
            .unwrap_or_else(|| panic!("`{module}` is missing in ARCHITECTURE.md's table"));
        for import in imports(&fs::read_to_string(&path).unwrap()) {
            assert!(
                import == module || may.contains(&import),
                "{} imports `{import}`, ARCHITECTURE.md allows {may:?}",
                path.display()
            );
        }
        modules.insert(module);
    }
    let listed: BTreeSet<String> = allowed.into_keys().collect();
    assert_eq!(listed, modules, "ARCHITECTURE.md lists modules that do not exist");
}

/// The first line of a file says what it is for.
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
fn the_imports_of_a_file_are_seen() {
    let text = "use crate::math::dot;\n// crate::cli\nfn f() { crate::limits::check() }\n";
    let want = BTreeSet::from(["math".to_owned(), "limits".to_owned()]);
    assert_eq!(imports(text), want);
}
