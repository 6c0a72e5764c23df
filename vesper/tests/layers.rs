//! The core's layers: who may import whom, and which words it does not know.

use std::fs;
use std::path::{Path, PathBuf};

/// Lowest layer first, as in the documentation of `lib.rs`; a module imports only from those before it.
const LAYERS: [&str; 18] = [
    "dimension",
    "error",
    "real",
    "property",
    "column",
    "domain",
    "field",
    "state",
    "law",
    "registry",
    "graph",
    "backend",
    "module",
    "integrate",
    "pipeline",
    "engine",
    "prelude",
    "lib",
];

/// Words of physics that the core does not know. Standard properties are declarations for laws, and may have them.
const WORDS: [&str; 14] = [
    "gravity",
    "gravit",
    "spring",
    "coulomb",
    "charge",
    "newton",
    "mass",
    "force",
    "velocity",
    "acceleration",
    "drag",
    "electric",
    "magnetic",
    "planet",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

/// All Rust files under a folder, but for what is built.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            if name != "target" && name != "out" && !name.starts_with('.') {
                found.extend(sources(&path));
            }
        } else if name.ends_with(".rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The code of a file, without comments, documentation and its tests module.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let text = text.split("\n#[cfg(test)]\nmod tests").next().unwrap_or_default();
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// The layer that a file of the core belongs to.
fn layer(path: &Path) -> String {
    let path = path.strip_prefix(root().join("src")).unwrap();
    let first = path.iter().next().unwrap().to_string_lossy();
    first.trim_end_matches(".rs").to_owned()
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|letter: char| !(letter.is_alphanumeric() || letter == '_'))
}

/// The modules of the crate that a text names, `crate::x` and `crate::{x, y::z}`.
fn imports(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (at, _) in text.match_indices("crate::") {
        let before = text[..at].chars().next_back();
        if before.is_some_and(|letter| letter.is_alphanumeric() || letter == '$' || letter == '_') {
            continue; // `$crate` in a macro is the name of the crate for others
        }
        let rest = &text[at + "crate::".len()..];
        if let Some(list) = rest.strip_prefix('{') {
            let mut depth = 0;
            let end = list.find(|letter| {
                depth += i32::from(letter == '{') - i32::from(letter == '}');
                depth < 0
            });
            let top = list[..end.unwrap()].split(',').map(|item| words(item.trim()).next().unwrap().to_owned());
            found.extend(top);
        } else {
            found.extend(words(rest).next().map(str::to_owned));
        }
    }
    found
}

#[test]
fn modules_import_only_from_the_layers_below_them() {
    let place = |name: &str| LAYERS.iter().position(|layer| *layer == name);
    let mut wrong = Vec::new();
    let mut seen = Vec::new();
    for path in sources(&root().join("src")) {
        let own = layer(&path);
        let at = place(&own).unwrap_or_else(|| panic!("{own} has no place among the layers"));
        seen.push(own.clone());
        for import in imports(&code(&path)) {
            // An item of the root, such as a macro, is no module.
            if let Some(from) = place(&import)
                && from > at
            {
                wrong.push(format!("{} uses {import}, which stands above {own}", path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let known = |layer: &&str| *layer == "dimension" || seen.iter().any(|own| own == *layer);
    assert!(LAYERS.iter().all(known), "every layer has a file: {seen:?}");
}

#[test]
fn the_reader_of_imports_reads_them() {
    let text =
        "use crate::error::Fault;\nuse crate::{column::{Column, Lent}, state};\n$crate::engine::X; crate::law::Law";
    assert_eq!(imports(text), ["error", "column", "Lent}", "state", "law"].map(|name| name.trim_end_matches('}')));
}

#[test]
fn the_documented_order_is_the_tested_one() {
    let text = fs::read_to_string(root().join("src/lib.rs")).unwrap();
    let start = text.find("Lowest layer first").unwrap();
    let paragraph = &text[start..start + text[start..].find("\n//!\n").unwrap()];
    let plain = paragraph.replace("mod@", "");
    let named: Vec<&str> = plain.split('`').skip(1).step_by(2).filter(|name| !name.contains(' ')).collect();
    assert_eq!(named, LAYERS[..17], "the documentation of lib.rs lists the layers");
}

#[test]
fn the_core_knows_no_physics() {
    let mut wrong = Vec::new();
    for path in sources(&root().join("src")).iter().filter(|path| !path.ends_with("property/standard.rs")) {
        for (number, line) in code(path).lines().enumerate() {
            let lower = line.to_lowercase();
            for word in words(&lower).flat_map(|word| word.split('_')).filter(|word| WORDS.contains(word)) {
                wrong.push(format!("{}:{}: {word}", path.display(), number + 1));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn files_are_short_and_finished() {
    let workspace = root().parent().unwrap().to_owned();
    let files = sources(&workspace);
    assert!(files.len() > 50, "{} files found", files.len());
    let unfinished = concat!("todo", "!");
    for path in files {
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.lines().count() <= 500, "{} has {} lines: split it", path.display(), text.lines().count());
        assert!(!text.contains(unfinished), "{} is not finished", path.display());
    }
}
