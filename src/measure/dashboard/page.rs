//! Builds the page: data, charts and styles in one file.

use super::history::History;
use super::series::Data;
use crate::error::{Error, Result};

/// Returns a page about `history` that opens from disk without a network. It links to criterion's own
/// report if `criterion` is given.
///
/// # Errors
/// [`Error::Internal`] if the data cannot be serialized, which is a fault of the program.
pub(crate) fn page(history: &History, criterion: Option<&str>) -> Result<String> {
    let data = serde_json::to_string(&Data::of(history));
    let data = data.map_err(|error| Error::Internal(error.to_string()))?;
    let criterion = criterion.map_or_else(String::new, |link| {
        format!(
            r#"<p><a href="{}">Criterion's report</a> on single kernels, stages and frames.</p>"#,
            attribute(link)
        )
    });
    let parts = [
        ("/*uplot.css*/", include_str!("uplot/uPlot.min.css")),
        ("/*page.css*/", include_str!("page.css")),
        ("/*uplot.licence*/", include_str!("uplot/LICENSE")),
        ("/*uplot.js*/", include_str!("uplot/uPlot.iife.min.js")),
        ("/*charts.js*/", include_str!("charts.js")),
        ("/*page.js*/", include_str!("page.js")),
        ("<!--criterion-->", &criterion),
        ("<!--version-->", env!("CARGO_PKG_VERSION")),
        // The data comes last, so that no text in it is mistaken for a marker.
        ("/*data*/", &in_script(&data)),
    ];
    let page = include_str!("page.html").to_owned();
    Ok(parts.into_iter().fold(page, |page, (mark, part)| page.replacen(mark, part, 1)))
}

/// Escapes JSON so that it cannot end the script element around it.
fn in_script(json: &str) -> String {
    json.replace('<', "\\u003c")
}

fn attribute(text: &str) -> String {
    text.replace('&', "&amp;").replace('"', "&quot;").replace('<', "&lt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_of_files_cannot_become_markup() {
        assert_eq!(in_script(r#"{"a":"</script>"}"#), r#"{"a":"\u003c/script>"}"#);
        assert_eq!(attribute("a\"b&<"), "a&quot;b&amp;&lt;");
    }
}
