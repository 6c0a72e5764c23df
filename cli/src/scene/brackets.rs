//! Brackets that were left open.
//!
//! In: the text of a scene. Out: the same text with every entry whose bracket stays open blanked out, and a fault for
//! each. Never: moves a byte. An open bracket swallows all lines behind it and every mistake in them, so that the parser
//! alone would report one of many, at a line where nothing is wrong.

use std::ops::Range;

use toml::de::DeTable;

/// Each costs a parse of the file.
const MOST: usize = 50;

/// `text` without entries whose bracket is never closed, and those entries' faults.
pub(crate) fn without_open_entries(text: &str) -> (String, Vec<(Range<usize>, String)>) {
    let mut text = text.to_owned();
    let mut faults = Vec::new();
    while faults.len() < MOST {
        let Some(entry) = first_open(&text) else { break };
        let head = entry.start + text[entry.clone()].find('=').map_or(0, |at| at + 1);
        let rest = &text[head..entry.end];
        let value = head + rest.len() - rest.trim_start().len();
        let (what, bracket) = if rest.trim_start().starts_with('{') { ("table", '}') } else { ("list", ']') };
        let place = match text[entry.end..].is_empty() {
            true => "the end".to_owned(),
            false => format!("line {}", 1 + text.as_bytes()[..entry.end].iter().filter(|&&b| b == b'\n').count()),
        };
        let fault = format!("this {what} is not closed: `{bracket}` is missing before {place}");
        faults.push((value..value + 1, fault));
        let blank: String = text[entry.clone()].bytes().map(|b| if b == b'\n' { '\n' } else { ' ' }).collect();
        text.replace_range(entry, &blank);
    }
    (text, faults)
}

/// The first entry that the parser finds open, up to the next line that begins an entry or a section.
fn first_open(text: &str) -> Option<Range<usize>> {
    let (_, errors) = DeTable::parse_recoverable(text);
    let unclosed = ["unclosed array", "unclosed inline table"];
    if !errors.iter().any(|error| unclosed.iter().any(|words| error.message().starts_with(words))) {
        return None;
    }
    let about_brackets = |error: &&toml::de::Error| {
        ["array", "inline table", "key-value pairs"].iter().any(|words| error.message().contains(words))
    };
    let at = errors
        .iter()
        .filter(about_brackets)
        .filter_map(|error| error.span())
        .map(|range| range.start)
        .min()?
        .min(text.len());
    // The entry is above the place where the parser noticed, or on its line where the place is behind the `=`.
    let own = line_start(text, at);
    let mut start = own;
    if text.as_bytes()[own..at].contains(&b'=')
        && let Some(entry) = open_entry(text, own)
    {
        return Some(entry);
    }
    while start > 0 {
        start = line_start(text, start - 1);
        if let Some(entry) = open_entry(text, start) {
            return Some(entry);
        }
    }
    None
}

/// The entry that begins at `start`, if one does and has more opening than closing brackets.
fn open_entry(text: &str, start: usize) -> Option<Range<usize>> {
    if !begins_entry(&text[start..]) {
        return None;
    }
    let mut end = start;
    loop {
        end = text[end..].find('\n').map_or(text.len(), |at| end + at + 1);
        if end == text.len() || begins_entry(&text[end..]) {
            break;
        }
    }
    (surplus(&text[start..end]) > 0).then_some(start..end)
}

/// Opening less closing brackets, outside of texts and comments.
fn surplus(entry: &str) -> isize {
    let (mut surplus, mut quote, mut comment) = (0, None, false);
    for c in entry.chars() {
        match (c, quote) {
            // Texts of several lines hold no brackets in a scene; a text ends with its line at the latest.
            ('\n', _) => (quote, comment) = (None, false),
            _ if comment => {}
            (c, Some(open)) => quote = (c != open).then_some(open),
            ('"' | '\'', None) => quote = Some(c),
            ('#', None) => comment = true,
            ('[' | '{', None) => surplus += 1,
            (']' | '}', None) => surplus -= 1,
            _ => {}
        }
    }
    surplus
}

fn line_start(text: &str, offset: usize) -> usize {
    text.as_bytes()[..offset.min(text.len())].iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1)
}

/// Whether the first line of `rest` is the head of a section or begins with `key =`.
fn begins_entry(rest: &str) -> bool {
    let line = rest.lines().next().unwrap_or("").split('#').next().unwrap_or("").trim();
    let is_key = |key: &str| {
        let key = key.trim();
        key.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && key.chars().all(|c| c.is_ascii_alphanumeric() || "_-.".contains(c))
    };
    let head = line.strip_prefix("[[").and_then(|head| head.strip_suffix("]]"));
    let head = head.or_else(|| line.strip_prefix('[').and_then(|head| head.strip_suffix(']')));
    head.is_some_and(is_key) || line.split_once('=').is_some_and(|(key, _)| is_key(key))
}
