//! How deep a text in RON or JSON is nested, before it is parsed.

/// The place (line and column) of the first bracket that is deeper than `most`, and how deep the text is.
pub(super) fn deeper_than(text: &str, most: u64) -> Option<((usize, usize), u64)> {
    let (mut depth, mut deepest, mut first) = (0u64, 0u64, None);
    let (mut rest, mut line, mut line_start) = (text, 1, text);
    while let Some(c) = rest.chars().next() {
        if c == '\n' {
            (line, line_start) = (line + 1, &rest[1..]);
        }
        let skip = match c {
            '(' | '[' | '{' => {
                depth += 1;
                deepest = deepest.max(depth);
                if depth > most && first.is_none() {
                    let before = &line_start[..line_start.len() - rest.len()];
                    first = Some((line, 1 + before.chars().count()));
                }
                1
            }
            ')' | ']' | '}' => {
                depth = depth.saturating_sub(1);
                1
            }
            '"' => string(rest),
            'r' => raw_string(rest).unwrap_or(1),
            '/' => comment(rest).unwrap_or(1),
            c => c.len_utf8(),
        };
        let skipped = &rest[..skip];
        if let Some(last) = skipped[c.len_utf8()..].rfind('\n') {
            line += skipped[c.len_utf8()..].matches('\n').count();
            line_start = &rest[c.len_utf8() + last + 1..];
        }
        rest = &rest[skip..];
    }
    first.map(|place| (place, deepest))
}

/// Bytes of the string at the begin of `text`.
fn string(text: &str) -> usize {
    let mut escaped = false;
    let end = text[1..].find(|c| {
        let ends = c == '"' && !escaped;
        escaped = c == '\\' && !escaped;
        ends
    });
    end.map_or(text.len(), |end| end + 2)
}

/// Bytes of the string like `r#"..."#` at the begin of `text`, if there is one.
fn raw_string(text: &str) -> Option<usize> {
    let hashes = text[1..].len() - text[1..].trim_start_matches('#').len();
    let begin = text[1 + hashes..].strip_prefix('"')?;
    let end = format!("\"{}", &text[1..1 + hashes]);
    let before = text.len() - begin.len();
    Some(begin.find(&end).map_or(text.len(), |at| before + at + end.len()))
}

/// Bytes of the comment at the begin of `text`, if there is one: `//` to the end of the line, or `/* */`, which
/// may hold others.
fn comment(text: &str) -> Option<usize> {
    if text.starts_with("//") {
        return Some(text.find('\n').unwrap_or(text.len()));
    }
    text.strip_prefix("/*")?;
    let (mut at, mut depth) = (2, 1);
    while depth > 0 {
        let next = at + text[at..].find(['/', '*']).unwrap_or(text.len() - at);
        let (step, change) = match text.get(next..next + 2) {
            Some("/*") => (2, 1),
            Some("*/") => (2, -1),
            _ => (1, 0),
        };
        if next >= text.len() {
            return Some(text.len());
        }
        (at, depth) = (next + step, depth + change);
    }
    Some(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brackets_are_counted_where_they_count() {
        let deep = |text: &str, most| deeper_than(text, most);
        assert_eq!(deep("([{}])", 3), None);
        assert_eq!(deep("([{}])\n", 2), Some(((1, 3), 3)));
        assert_eq!(deep("()()(())", 1), Some(((1, 6), 2)));
        assert_eq!(deep("a: \"((\\\"((\", b: (é[\n", 1), Some(((1, 19), 2)));
        assert_eq!(
            deep("// ((\n/* (( \n /* ( */ ( */ r#\"((\"(\n\"# (\n  (", 1),
            Some(((5, 3), 2))
        );
        assert_eq!(deep("\"((\n((\n\" (\n(", 1), Some(((4, 1), 2)));
        // Not closed, and nothing that a parser would like.
        for text in ["\"((", "/* ((", "r##\"((", "//((", "r", "/", ")))((", "\"\\", "/*/", "é*/"] {
            assert_eq!(deep(text, 2), None, "{text}");
        }
        let many = "[".repeat(1_000_000);
        assert_eq!(deep(&many, 32), Some(((1, 33), 1_000_000)));
    }
}
