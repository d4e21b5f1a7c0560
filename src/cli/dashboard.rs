//! `ptfast dashboard`.

use std::fs;
use std::io::Write;
use std::path::{Component, Path, PathBuf};
use std::slice;

use clap::Args;

use super::console::say;
use super::folder;
use crate::error::{Error, Result};
use crate::measure::dashboard::{History, page};
use crate::output::write_atomically;

#[derive(Debug, Args)]
pub(crate) struct DashboardArgs {
    /// Folder with bench records, from `ptfast bench --json`
    #[arg(long, value_name = "DIR")]
    pub(crate) history: PathBuf,
    /// Folder for index.html; created if missing
    #[arg(short, long, visible_alias = "out", value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Folder of criterion's report; the page links to it if it exists
    #[arg(long, value_name = "DIR", default_value = "target/criterion")]
    pub(crate) criterion: PathBuf,
}

/// The page's title, by which an earlier output of this command is recognised.
const TITLE: &str = "<title>ptfast: speed over commits</title>";

pub(crate) fn run(args: &DashboardArgs) -> Result<()> {
    let history = History::read(&args.history)?;
    let file = args.output.join("index.html");
    folder::check_unrelated(slice::from_ref(&file), |file| folder::contains(file, TITLE))?;
    fs::create_dir_all(&args.output).map_err(Error::io(&args.output, "create the folder"))?;
    let report = args.criterion.join("report").join("index.html");
    let link = report.is_file().then(|| link(&args.output, &report)).transpose()?;
    let html = page(&history, link.as_deref())?;
    write_atomically(&file, |out| out.write_all(html.as_bytes()))?;
    say(format_args!("{} records  {}", history.records.len(), file.display()))
}

/// The relative link from a page in `folder` to `file`.
fn link(folder: &Path, file: &Path) -> Result<String> {
    let folder = fs::canonicalize(folder).map_err(Error::io(folder, "find"))?;
    let file = fs::canonicalize(file).map_err(Error::io(file, "find"))?;
    Ok(relative(&folder, &file))
}

fn relative(folder: &Path, file: &Path) -> String {
    let (from, to): (Vec<Component<'_>>, Vec<Component<'_>>) =
        (folder.components().collect(), file.components().collect());
    let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let up = from[common..].iter().map(|_| "..".into());
    let down = to[common..].iter().map(|part| encoded(&part.as_os_str().to_string_lossy()));
    up.chain(down).collect::<Vec<String>>().join("/")
}

/// `name` with percent escapes for characters that have a meaning in links (RFC 3986).
fn encoded(name: &str) -> String {
    let plain = |c: u8| c.is_ascii_alphanumeric() || b"-._~".contains(&c);
    name.bytes()
        .map(|c| if plain(c) { char::from(c).to_string() } else { format!("%{c:02X}") })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_lead_from_folder_to_file() {
        let to = |folder, file| relative(Path::new(folder), Path::new(file));
        assert_eq!(to("/a/out", "/a/target/criterion/x.html"), "../target/criterion/x.html");
        assert_eq!(to("/a", "/a/b c/100%.html"), "b%20c/100%25.html");
    }
}
