//! In: identifiers, words, attributes. Out: names in snake case, the nearest known word, the text of doc comments.

use proc_macro2::Span;
use syn::{Attribute, Expr, Lit, LitStr, Meta};

/// "StandardGravitationalParameter" as "standard_gravitational_parameter"; runs of capitals stay together.
pub fn snake_case(name: &str) -> String {
    let letters: Vec<char> = name.trim_start_matches("r#").chars().collect();
    let mut text = String::new();
    for (i, &letter) in letters.iter().enumerate() {
        let after_small = i > 0 && !letters[i - 1].is_uppercase() && letters[i - 1] != '_';
        let before_small =
            i > 0 && letters[i - 1].is_uppercase() && letters.get(i + 1).is_some_and(|c| c.is_lowercase());
        if letter.is_uppercase() && (after_small || before_small) {
            text.push('_');
        }
        text.extend(letter.to_lowercase());
    }
    text
}

/// Whether the text is a name as columns and scenes have them: lower case letters, digits and `_`, a letter first.
pub fn is_snake_case(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_lowercase())
        && text.bytes().all(|byte| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'_')
}

/// "unknown key `domian`: did you mean `domain`?", or the list of what is known where nothing is near.
pub fn unknown(what: &str, word: &str, known: &[&str]) -> String {
    let nearest = known.iter().map(|known| (distance(word, known), known)).min_by_key(|&(edits, _)| edits);
    match nearest {
        Some((edits, nearest)) if edits <= 2 && edits < nearest.len() => {
            format!("unknown {what} `{word}`: did you mean `{nearest}`?")
        }
        _ => format!("unknown {what} `{word}`: known are {}", listed(known)),
    }
}

/// "`a`, `b`, `c`".
pub fn listed<T: AsRef<str>>(words: &[T]) -> String {
    words.iter().map(|word| format!("`{}`", word.as_ref())).collect::<Vec<_>>().join(", ")
}

/// The lines of the doc comments, trimmed, joined by line ends.
pub fn doc(attributes: &[Attribute]) -> String {
    let mut lines = Vec::new();
    for attribute in attributes {
        if let Meta::NameValue(pair) = &attribute.meta
            && pair.path.is_ident("doc")
            && let Expr::Lit(literal) = &pair.value
            && let Lit::Str(text) = &literal.lit
        {
            lines.extend(text.value().split('\n').map(|line| line.trim().to_string()));
        }
    }
    lines.join("\n").trim().to_string()
}

/// Checks a unit's text; the error stands at the text.
pub fn check_unit(text: &LitStr) -> syn::Result<()> {
    let value = text.value();
    match vesper_dimension::Unit::parse(&value) {
        Ok(_) => Ok(()),
        Err(error) => Err(fault(text.span(), error.message(&value))),
    }
}

/// An error at a token.
pub fn fault(span: Span, text: impl std::fmt::Display) -> syn::Error {
    syn::Error::new(span, text)
}

/// Levenshtein distance.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &y) in b.iter().enumerate() {
            let next = (diagonal + usize::from(x != y)).min(row[j] + 1).min(row[j + 1] + 1);
            diagonal = row[j + 1];
            row[j + 1] = next;
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn snake_case_of_types() {
        let table = [
            ("Gravity", "gravity"),
            ("StandardGravitationalParameter", "standard_gravitational_parameter"),
            ("GPUForce", "gpu_force"),
            ("ForceN", "force_n"),
            ("Part2Name", "part2_name"),
            ("already_small", "already_small"),
        ];
        for (name, snake) in table {
            assert_eq!(snake_case(name), snake);
        }
    }

    #[test]
    fn the_nearest_word_or_all_words() {
        assert_eq!(unknown("mode", "read", &["sets", "reads"]), "unknown mode `read`: did you mean `reads`?");
        assert_eq!(
            unknown("mode", "writes_to", &["sets", "reads"]),
            "unknown mode `writes_to`: known are `sets`, `reads`"
        );
    }
}
