//! Faults in text that people wrote: where they are, what is wrong, what was probably meant.
//!
//! In: the texts of one run (a scene file and `--set` arguments) and byte ranges in them. Out: [`SceneFault`]s, values
//! that print themselves with the line and a caret. Never: stops at the first; that is the caller's choice.

use std::fmt;

/// A range of bytes in the texts of one [`Sources`]. Texts stand one behind the other, so that one number orders all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Span {
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

/// A value and where it was written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spanned<T> {
    /// The value.
    pub value: T,
    /// Where it stands.
    pub span: Span,
}

impl<T> Spanned<T> {
    /// A value written at `span`.
    pub const fn new(value: T, span: Span) -> Self {
        Self { value, span }
    }
}

/// One thing wrong in a scene file, a table beside it, or a `--set` argument.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneFault {
    /// The file as it was named, or `--set PATH=VALUE`.
    pub file: String,
    /// Line, from 1; 0 where there are no lines: a `--set` argument, a file that cannot be read.
    pub line: usize,
    /// Column in characters, from 1; 0 where nothing can be pointed at.
    pub column: usize,
    /// The line itself; empty where there is none.
    pub source_line: String,
    /// Length of the faulted piece in characters, at least 1.
    pub span_len: usize,
    /// What is wrong: lower case, no full stop.
    pub text: String,
    /// What to do, or the nearest known name.
    pub help: Option<String>,
}

impl SceneFault {
    /// A fault of a whole file, without a place in it.
    pub fn of_file(file: impl Into<String>, text: impl Into<String>) -> Self {
        Self {
            file: file.into(),
            line: 0,
            column: 0,
            source_line: String::new(),
            span_len: 1,
            text: text.into(),
            help: None,
        }
    }

    /// A fault of an argument, at `piece` of its text; at the whole of it where `piece` is no part of it.
    pub fn of_argument(
        option: &str,
        argument: &str,
        piece: &str,
        text: impl Into<String>,
        help: Option<String>,
    ) -> Self {
        let start = (piece.as_ptr() as usize).checked_sub(argument.as_ptr() as usize);
        let start = start.filter(|start| start + piece.len() <= argument.len());
        let (start, piece) = start.map_or((0, argument), |start| (start, piece));
        let mut sources = Sources::default();
        let base = sources.add(format!("{option} {argument}"), argument, false);
        sources.fault(Span { start: base + start, end: base + start + piece.len() }, text, help)
    }
}

/// Lines longer than this are cut around the caret: a column of numbers may be one line of a megabyte.
const WIDEST: usize = 110;

impl fmt::Display for SceneFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "error: {}", printable(&self.text))?;
        let number = if self.line == 0 { String::new() } else { self.line.to_string() };
        let gutter = number.len().max(2);
        write!(f, "{:gutter$}--> {}", "", printable(&self.file))?;
        if self.line > 0 {
            write!(f, ":{}:{}", self.line, self.column)?;
        }
        if self.column > 0 {
            let characters: Vec<char> = printable(&self.source_line).chars().collect();
            let at = (self.column - 1).min(characters.len());
            let first = if characters.len() <= WIDEST { 0 } else { at.saturating_sub(WIDEST / 2) };
            let last = characters.len().min(first + WIDEST);
            let shown: String = characters[first..last].iter().collect();
            let carets = self.span_len.clamp(1, (last - at).max(1));
            write!(f, "\n {number:>gutter$} | {}{shown}", if first > 0 { "..." } else { "" })?;
            write!(f, "\n {:gutter$} | ", "")?;
            write!(f, "{:indent$}{}", "", "^".repeat(carets), indent = at - first + if first > 0 { 3 } else { 0 })?;
        }
        if let Some(help) = &self.help {
            write!(f, "\n {:gutter$} = help: {}", "", printable(help))?;
        }
        Ok(())
    }
}

impl std::error::Error for SceneFault {}

/// Control characters of a file must not reach a terminal; tabs become one blank, so that the caret stays in place.
fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// All faults as one text, with a last line that counts them.
pub fn print_faults(faults: &[SceneFault]) -> String {
    let mut text: String = faults.iter().map(|fault| format!("{fault}\n")).collect();
    text.push_str(&match faults.len() {
        1 => "1 mistake; nothing was run\n".to_owned(),
        n => format!("{n} mistakes; nothing was run\n"),
    });
    text
}

#[derive(Clone, Debug)]
struct Source {
    name: String,
    text: String,
    base: usize,
    lines: bool,
}

/// The texts that spans point into: the scene file first, then each `--set` argument.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    list: Vec<Source>,
}

impl Sources {
    /// Adds a text; its bytes begin at the number returned. Without `lines` it is an argument, not a file.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<String>, lines: bool) -> usize {
        let base = self.list.last().map_or(0, |last| last.base + last.text.len() + 1);
        self.list.push(Source { name: name.into(), text: text.into(), base, lines });
        base
    }

    /// The fault `text` at `span`, with its line.
    pub fn fault(&self, span: Span, text: impl Into<String>, help: Option<String>) -> SceneFault {
        let text = text.into();
        let Some(source) = self.list.iter().rev().find(|source| source.base <= span.start) else {
            return SceneFault { help, ..SceneFault::of_file("", text) };
        };
        let bytes = source.text.as_bytes();
        let start = boundary(&source.text, span.start - source.base);
        let end = boundary(&source.text, span.end.saturating_sub(source.base)).max(start);
        let line_start = bytes[..start].iter().rposition(|&b| b == b'\n').map_or(0, |at| at + 1);
        let mut line_end = bytes[start..].iter().position(|&b| b == b'\n').map_or(bytes.len(), |at| start + at);
        if line_end > start && bytes[line_end - 1] == b'\r' {
            line_end -= 1;
        }
        let line = if source.lines { 1 + bytes[..line_start].iter().filter(|&&b| b == b'\n').count() } else { 0 };
        SceneFault {
            file: source.name.clone(),
            line,
            column: 1 + source.text[line_start..start].chars().count(),
            source_line: source.text[line_start..line_end.max(start)].to_owned(),
            span_len: source.text[start..end.min(line_end).max(start)].chars().count().max(1),
            text,
            help,
        }
    }

    /// The line of `span` in its source, as a number that orders and compares; used to group faults of one line.
    pub(crate) fn line_key(&self, span: Span) -> (usize, usize) {
        let index = self.list.iter().rposition(|source| source.base <= span.start).unwrap_or(0);
        let Some(source) = self.list.get(index) else { return (0, 0) };
        let offset = (span.start - source.base).min(source.text.len());
        (index, source.text.as_bytes()[..offset].iter().filter(|&&b| b == b'\n').count())
    }
}

/// The nearest character boundary at or before `offset`.
fn boundary(text: &str, offset: usize) -> usize {
    let mut offset = offset.min(text.len());
    while !text.is_char_boundary(offset) {
        offset -= 1;
    }
    offset
}

/// The known name nearest to `name`, where one is near enough to be what was meant.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    known
        .into_iter()
        .map(|candidate| (strsim::damerau_levenshtein(name, candidate), candidate))
        .filter(|&(distance, candidate)| distance * 5 <= 2 * name.chars().count().max(candidate.chars().count()))
        .min()
        .map(|(_, candidate)| candidate)
}

/// Help for an unknown name: the nearest known one, or the list of all, where there are few.
pub fn help_for<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let mut unique: Vec<&str> = Vec::new();
    for name in known {
        if !unique.contains(&name) {
            unique.push(name);
        }
    }
    let known = unique;
    if let Some(near) = nearest(name, known.iter().copied()) {
        return Some(format!("did you mean `{near}`?"));
    }
    match known.len() {
        0 => None,
        1..=16 => Some(format!("known here: {}", known.join(", "))),
        n => Some(format!("known here: {} and {} more", known[..12].join(", "), n - 12)),
    }
}

/// All digits, and no more zeros than one can count.
pub(crate) fn number(value: f64) -> String {
    if value == 0.0 || (1e-4..1e9).contains(&value.abs()) { value.to_string() } else { format!("{value:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prints_line_and_caret() {
        let mut sources = Sources::default();
        sources.add("springs.toml", "a = 1\nvélocity = [\"fast\"]\r\n", true);
        let fault = sources.fault(Span { start: 19, end: 25 }, "expected a number, found text", Some("x".into()));
        let expected = [
            "error: expected a number, found text",
            "  --> springs.toml:2:13",
            "  2 | vélocity = [\"fast\"]",
            "    |             ^^^^^^",
            "    = help: x",
        ];
        assert_eq!(fault.to_string(), expected.join("\n"));
    }

    #[test]
    fn a_line_of_many_numbers_is_cut_around_the_caret() {
        let mut sources = Sources::default();
        sources.add("long.toml", format!("{}X{}", "1, ".repeat(1000), "2, ".repeat(1000)), true);
        let shown = sources.fault(Span { start: 3000, end: 3001 }, "x", None).to_string();
        let lines: Vec<&str> = shown.lines().collect();
        assert!(lines[2].len() < 130, "{shown}");
        assert_eq!(lines[2].find('X'), lines[3].find('^'), "{shown}");
    }

    #[test]
    fn any_span_is_safe() {
        let mut sources = Sources::default();
        sources.add("é", "é\nü", true);
        for start in 0..12 {
            for end in 0..12 {
                let _ = sources.fault(Span { start, end }, "x", None).to_string();
            }
        }
    }
}
