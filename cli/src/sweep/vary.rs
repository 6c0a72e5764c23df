//! `--vary PATH=VALUES`: the values that one place of the scene takes, run by run.
//!
//! In: the argument. Out: a [`Vary`], whose values are texts as they could stand behind `--set PATH=`; or what is wrong with
//! the argument, at its place. Never: knows what the path means; that is seen when a value is set.
//!
//! | VALUES | |
//! |---|---|
//! | `FIRST:LAST:COUNT` | so many numbers at equal distances, both ends included |
//! | `FIRST:LAST:COUNT:log` | the same by equal factors |
//! | `[V, V, ..]` | these: numbers, words, or anything else that `--set` takes, as `[[0, 0, -9.81], [0, 0, -1.62]]` |
//!
//! Of values at equal distances the last bits give way where that saves digits, so that a table says 0.3, and not
//! 0.30000000000000004. Values by equal factors are rounded to 12 digits: so machines whose powers differ in a last bit agree
//! on the runs.

use super::ensemble::MOST_RUNS;
use crate::fault::{SceneFault, number};
use crate::scene::is_word;

/// How the values of a [`Vary`] follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spacing {
    /// At equal distances.
    Even,
    /// By equal factors.
    Log,
    /// As they were listed.
    List,
}

impl Spacing {
    /// Each, with its name in files.
    pub const NAMES: [(&'static str, Spacing); 3] =
        [("even", Spacing::Even), ("log", Spacing::Log), ("list", Spacing::List)];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, known)| *known == self).map_or("list", |(name, _)| name)
    }
}

/// A place of the scene, and the values that it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct Vary {
    /// The path, as `--set` has it.
    pub path: String,
    /// The values, as texts; each another one.
    pub values: Vec<String>,
    /// How they follow each other.
    pub spacing: Spacing,
}

/// The option, for faults.
const OPTION: &str = "--vary";

impl Vary {
    /// Reads an argument.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn read(argument: &str) -> Result<Self, Vec<SceneFault>> {
        let wrong = |piece: &str, text: String, help: Option<&str>| {
            SceneFault::of_argument(OPTION, argument, piece, text, help.map(str::to_owned))
        };
        let Some((path, text)) = argument.split_once('=') else {
            let help = "as in --vary engine.step=0.01:0.1:10";
            return Err(vec![wrong(argument, "expected PATH=VALUES".to_owned(), Some(help))]);
        };
        let (path, text) = (path.trim(), text.trim());
        let (spacing, values) = match text.strip_prefix('[') {
            Some(rest) => (Spacing::List, list(rest, &wrong)),
            None => match text.split(':').collect::<Vec<_>>()[..] {
                [first, last, count] => (Spacing::Even, range([first, last, count], false, &wrong)),
                [first, last, count, "log"] => (Spacing::Log, range([first, last, count], true, &wrong)),
                [_, _, _, word] => {
                    (Spacing::Log, Err(vec![wrong(word, format!("expected `log`, found `{word}`"), None)]))
                }
                _ => {
                    let text = "expected FIRST:LAST:COUNT, FIRST:LAST:COUNT:log or [V, V, ..]".to_owned();
                    (Spacing::List, Err(vec![wrong(value_or_all(argument, path), text, None)]))
                }
            },
        };
        let mut faults = Vec::new();
        if path.is_empty() {
            faults.push(wrong(argument, "a path is missing before `=`".to_owned(), None));
        }
        match values {
            Ok(values) => match twice(&values) {
                Some(value) => {
                    let text = format!("`{value}` comes twice: each run has values of its own");
                    faults.push(wrong(value_or_all(argument, path), text, None));
                }
                None if faults.is_empty() => return Ok(Vary { path: path.to_owned(), values, spacing }),
                None => {}
            },
            Err(more) => faults.extend(more),
        }
        Err(faults)
    }

    /// The values as numbers, where all are.
    pub fn numbers(&self) -> Option<Vec<f64>> {
        let number = |text: &String| text.parse().ok().filter(|value: &f64| value.is_finite());
        self.values.iter().map(number).collect()
    }
}

/// What stands behind `=`, for a caret; the whole argument where nothing does.
fn value_or_all<'a>(argument: &'a str, path: &str) -> &'a str {
    let value = argument.split_once('=').map_or("", |(_, value)| value.trim());
    if value.is_empty() || path.is_empty() { argument } else { value }
}

type Wrong<'w> = dyn Fn(&str, String, Option<&str>) -> SceneFault + 'w;

/// The values of `FIRST:LAST:COUNT`, by equal distances or by equal factors.
fn range([first, last, count]: [&str; 3], log: bool, wrong: &Wrong<'_>) -> Result<Vec<String>, Vec<SceneFault>> {
    let mut faults = Vec::new();
    let mut end = |piece: &str| match piece.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => value,
        _ => {
            let help = piece.trim().is_empty().then_some("FIRST:LAST:COUNT has three numbers");
            faults.push(wrong(piece, format!("expected a number, found `{}`", piece.trim()), help));
            f64::NAN
        }
    };
    let (low, high) = (end(first), end(last));
    let many = match count.trim().parse::<usize>() {
        Ok(many) if (2..=MOST_RUNS).contains(&many) => many,
        Ok(many) if many > MOST_RUNS => {
            faults.push(wrong(count, format!("expected at most {MOST_RUNS} values, found {many}"), None));
            0
        }
        _ => {
            let text = format!("expected a whole number of values, 2 or more, found `{}`", count.trim());
            faults.push(wrong(count, text, Some("one value is what --set is for")));
            0
        }
    };
    if low == high {
        let text = format!("both ends are {}: nothing varies", number(low));
        faults.push(wrong(last, text, Some("one value is what --set is for")));
    }
    if log && !low.is_nan() && !high.is_nan() && (low == 0.0 || high == 0.0 || (low < 0.0) != (high < 0.0)) {
        let text = "equal factors lead from one number to another of the same sign, and neither is 0".to_owned();
        faults.push(wrong(if low == 0.0 { first } else { last }, text, None));
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let parts = (many - 1) as f64;
    let between = |index: usize| {
        let (before, after) = ((many - 1 - index) as f64 / parts, index as f64 / parts);
        if log {
            let size = (low.abs().ln() * before + high.abs().ln() * after).exp();
            return rounded(size.copysign(low), 12);
        }
        // Whole distances first, which are exact for most numbers that people write; where that is too large, parts.
        let sum = (low * (many - 1 - index) as f64 + high * index as f64) / parts;
        short(if sum.is_finite() { sum } else { low * before + high * after })
    };
    let value = |index: usize| match index {
        0 => low,
        _ if index == many - 1 => high,
        _ => between(index),
    };
    Ok((0..many).map(|index| number_text(value(index))).collect())
}

/// To so many significant digits.
fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

/// The number of 15 digits that is a last bit or two away, where there is one.
fn short(value: f64) -> f64 {
    let near = rounded(value, 15);
    if (near - value).abs() <= f64::EPSILON * value.abs() { near } else { value }
}

/// A number as TOML has it; one that is whole without a point, so that it may also count something.
fn number_text(value: f64) -> String {
    if value == value.trunc() && value.abs() < 1e15 { format!("{}", value as i64) } else { format!("{value:?}") }
}

/// The items of a list whose `[` has been read.
fn list(rest: &str, wrong: &Wrong<'_>) -> Result<Vec<String>, Vec<SceneFault>> {
    let Some(inner) = rest.strip_suffix(']') else {
        return Err(vec![wrong(rest, "the list has no `]` at its end".to_owned(), None)]);
    };
    let mut items = items(inner);
    // A comma may stand behind the last one.
    if items.len() > 1 && items.last().is_some_and(|item| item.trim().is_empty()) {
        items.pop();
    }
    if let Some(empty) = items.iter().find(|item| item.trim().is_empty()) {
        let text = if inner.trim().is_empty() { "the list is empty" } else { "a value is missing" };
        return Err(vec![wrong(empty, text.to_owned(), None)]);
    }
    Ok(items.into_iter().map(|item| plain(item.trim())).collect())
}

/// Splits at commas that stand in no bracket and no quotes.
fn items(text: &str) -> Vec<&str> {
    let (mut parts, mut start, mut depth) = (Vec::new(), 0, 0_i32);
    let (mut quote, mut escaped) = (None, false);
    for (at, letter) in text.char_indices() {
        match (quote, letter) {
            (Some('"'), '\\') if !escaped => {
                escaped = true;
                continue;
            }
            (Some(open), _) if letter == open && !escaped => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'') => quote = Some(letter),
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') => depth -= 1,
            (None, ',') if depth == 0 => {
                parts.push(&text[start..at]);
                start = at + 1;
            }
            (None, _) => {}
        }
        escaped = false;
    }
    parts.push(&text[start..]);
    parts
}

/// An item in one form of those that mean the same: words without quotes, numbers in the fewest digits.
fn plain(item: &str) -> String {
    let inner = ['"', '\''].into_iter().find_map(|quote| item.strip_prefix(quote)?.strip_suffix(quote));
    match (inner, item.parse::<f64>()) {
        (Some(word), _) if is_word(word) => word.to_owned(),
        // Whole numbers stay as they are: a seed may have more digits than an f64.
        (None, Ok(value)) if value.is_finite() && item.contains(['.', 'e', 'E']) => number_text(value),
        _ => item.to_owned(),
    }
}

/// A value that is there more than once.
fn twice(values: &[String]) -> Option<&String> {
    let mut sorted: Vec<&String> = values.iter().collect();
    sorted.sort();
    sorted.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(argument: &str) -> Vec<String> {
        Vary::read(argument).unwrap_or_else(|faults| panic!("{faults:?}")).values
    }

    #[test]
    fn even_and_log_values_include_both_ends_and_are_short() {
        assert_eq!(values("a.b=0:1:11")[3..8], ["0.3", "0.4", "0.5", "0.6", "0.7"]);
        assert_eq!(values("a.b=0.1:1:10")[1..9], ["0.2", "0.3", "0.4", "0.5", "0.6", "0.7", "0.8", "0.9"]);
        assert_eq!(values("a.b=0:20:4"), ["0", "6.666666666666667", "13.333333333333334", "20"]);
        assert_eq!(values("a.b=1:8:8"), ["1", "2", "3", "4", "5", "6", "7", "8"]);
        assert_eq!(values("a.b=1e-3:1:4:log"), ["0.001", "0.01", "0.1", "1"]);
        assert_eq!(values("a.b=-1:-100:3:log"), ["-1", "-10", "-100"]);
        assert_eq!(values("a.b=0.1:-0.1:3"), ["0.1", "0", "-0.1"]);
        assert_eq!(values("a.b=-1.5e308:1.5e308:3"), ["-1.5e308", "0", "1.5e308"]);
        assert_eq!(values("a.b=1:2:3:log")[1], "1.41421356237");
    }

    #[test]
    fn lists_take_what_set_takes() {
        assert_eq!(values("a=[leapfrog, \"runge_kutta_4\"]"), ["leapfrog", "runge_kutta_4"]);
        assert_eq!(values("a=[1.50, 1e3, 18446744073709551615]"), ["1.5", "1000", "18446744073709551615"]);
        assert_eq!(values("a=[[0, 0, -9.81], [0, 0, -1.62],]"), ["[0, 0, -9.81]", "[0, 0, -1.62]"]);
        let table = "{ name = \"dormand_prince_5\", rtol = 1e-9 }";
        assert_eq!(values(&format!("a=[{table}, 'x, y', \"a\\\"],\"]")), [table, "'x, y'", "\"a\\\"],\""]);
        assert_eq!(values("a=[true, false]"), ["true", "false"]);
    }

    #[test]
    fn what_is_wrong_is_said_at_its_place() {
        let told = |argument: &str| -> Vec<String> {
            let faults = Vary::read(argument).expect_err(argument);
            faults.iter().map(|fault| format!("{}: {}", fault.column, fault.text)).collect()
        };
        let forms = "expected FIRST:LAST:COUNT, FIRST:LAST:COUNT:log or [V, V, ..]";
        assert_eq!(told("engine.step"), ["1: expected PATH=VALUES"]);
        assert_eq!(told("a=1:2"), [format!("3: {forms}")]);
        assert_eq!(told("a="), [format!("1: {forms}")]);
        assert_eq!(told("a=x:inf:1.5").len(), 3);
        assert_eq!(told("a=1:2:1"), ["7: expected a whole number of values, 2 or more, found `1`"]);
        assert_eq!(told("a=1:2:1000000"), ["7: expected at most 100000 values, found 1000000"]);
        assert_eq!(told("a=1:1:5"), ["5: both ends are 1: nothing varies"]);
        assert_eq!(told("a=1:2:3:lg"), ["9: expected `log`, found `lg`"]);
        let sign = "equal factors lead from one number to another of the same sign, and neither is 0";
        assert_eq!(told("a=0:2:3:log"), [format!("3: {sign}")]);
        assert_eq!(told("a=-1:2:3:log"), [format!("6: {sign}")]);
        assert_eq!(told("a=[1, 1.0]"), ["3: `1` comes twice: each run has values of its own"]);
        assert_eq!(told("a=[1, , 2]"), ["6: a value is missing"]);
        assert_eq!(told("a=[]"), ["4: the list is empty"]);
        assert_eq!(told("a=[1"), ["4: the list has no `]` at its end"]);
        assert_eq!(told("=1:2:3"), ["1: a path is missing before `=`"]);
    }
}
