//! The list of stock laws: complete, documented, and no more powerful than anyone's own.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use vesper::law::{Law, Signature};
use vesper::prelude::*;
use vesper_laws::catalog::{stock_law, stock_laws};

/// The files that hold one law each.
fn law_files() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| {
        let name = file.file_name().unwrap().to_str().unwrap();
        file.is_file() && !["lib.rs", "catalog.rs", "invariants.rs"].contains(&name)
    });
    files.sort();
    files
}

#[test]
fn every_law_file_is_in_the_catalog() {
    let files: Vec<String> =
        law_files().iter().map(|file| file.file_stem().unwrap().to_str().unwrap().to_owned()).collect();
    let names: Vec<&str> = stock_laws().iter().map(|law| law.signature.name).collect();
    assert_eq!(files, names, "one file for each law, both by name");
    assert!(names.len() >= 16);
}

#[test]
fn every_law_says_what_it_is_its_equation_its_source_and_its_limits() {
    for law in stock_laws() {
        let Signature { name, doc, ports, parameters, .. } = law.signature;
        assert!(law.summary().ends_with('.') && law.summary().len() > 20, "{name}: {}", law.summary());
        for word in ["Equation: ", "Source: ", "Limits: "] {
            assert_eq!(doc.lines().filter(|line| line.starts_with(word)).count(), 1, "{name} has one line of {word}");
        }
        assert!(ports.iter().any(|port| !port.mode.is_input()), "{name} changes something");
        for parameter in parameters {
            assert!(parameter.doc.ends_with('.') && !parameter.unit.is_empty(), "{name}: {parameter:?}");
        }
    }
}

/// Which of the lines of a law file name something of the framework that is not in the prelude.
fn beyond_the_prelude(text: &str) -> Vec<&str> {
    text.lines().filter(|line| line.contains("vesper::") && line.trim() != "use vesper::prelude::*;").collect()
}

#[test]
fn a_law_uses_only_the_prelude() {
    for file in law_files() {
        let text = fs::read_to_string(&file).unwrap();
        assert_eq!(beyond_the_prelude(&text), Vec::<&str>::new(), "{}", file.display());
        assert!(text.contains("#[cfg(test)]"), "{} has its test beside it", file.display());
        assert!(!text.contains("unsafe"), "{}", file.display());
    }
    assert_eq!(beyond_the_prelude("use vesper::law::Law;\nuse vesper::prelude::*;").len(), 1);
}

#[test]
fn laws_are_found_by_name() {
    assert_eq!(stock_law("gravity").unwrap().signature, vesper_laws::Gravity::SIGNATURE);
    assert!(stock_law("gravitas").is_none());
    let names: BTreeSet<&str> = stock_laws().iter().map(|law| law.signature.name).collect();
    assert_eq!(names.len(), stock_laws().len());
}

/// Two rows at a distance of 2 along x that a law of the catalog drives for one step.
fn pushed<P: Precision>(name: &str, parameters: &[f64]) -> f64 {
    let bodies = Domain::<P>::new("bodies")
        .with(Position, [[0.0; 3], [2.0, 0.0, 0.0]])
        .with(Velocity, [[0.0; 3]; 2])
        .with(Mass, [1.0; 2])
        .with(Charge, [1.0; 2]);
    let mut engine = Engine::<P>::builder()
        .domain(bodies)
        .listed(stock_law(name).unwrap().compile(parameters), Default::default())
        .law(vesper_laws::Motion)
        .integrator(SemiImplicitEuler)
        .step(1.0)
        .build()
        .unwrap();
    engine.advance(1.0).unwrap();
    engine.state().numbers("bodies", Velocity).unwrap()[0]
}

#[test]
fn parameters_reach_the_law_in_declared_order() {
    // 8 / (2^2 + 2^2)^(3/2) * 2 for g or k = 8 and a softening of 2.
    let softened = 16.0 / 512.0_f64.sqrt();
    assert!((pushed::<f64>("gravity", &[8.0, 2.0]) - softened).abs() < 1e-15);
    assert!((pushed::<f64>("coulomb", &[8.0, 2.0]) + softened).abs() < 1e-15);
    assert_eq!(pushed::<f32>("gravity", &[8.0]), 2.0);
    // Too few have their defaults, too many are not looked at.
    assert_eq!(pushed::<f64>("gravity", &[]), 6.674_30e-11 / 4.0);
    assert_eq!(pushed::<f64>("gravity", &[8.0, 0.0, 7.0]), 2.0);
    assert_eq!(stock_law("coulomb").unwrap().default_parameters(), [8.987_551_786_2e9, 0.0]);
}
