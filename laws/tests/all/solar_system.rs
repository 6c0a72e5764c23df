//! Eleven years of the solar system against JPL's own positions, with and without the post-Newtonian correction.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use vesper::prelude::*;
use vesper_laws::{EinsteinInfeldHoffmann, GravityByParameter, Kinematics, NewtonianField, PostNewtonian};

const EPOCH: f64 = 2_440_432.5;
const DAY: f64 = 86_400.0;
const AU_KM: f64 = 149_597_870.7;

/// The rows of a table beside the scenes: a name, and numbers.
fn table(file: &str) -> Vec<(String, Vec<f64>)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes").join(file);
    let text = fs::read_to_string(path).unwrap();
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    rows.map(|row| {
        let (name, numbers) = row.split_once(',').unwrap();
        (name.to_owned(), numbers.split(',').map(|number| number.parse().unwrap()).collect())
    })
    .collect()
}

fn vectors(rows: &[(String, Vec<f64>)], from: usize) -> Vec<[f64; 3]> {
    rows.iter().map(|(_, numbers)| [numbers[from], numbers[from + 1], numbers[from + 2]]).collect()
}

/// The correction to Newton's law.
#[derive(Clone, Copy, PartialEq)]
enum Correction {
    None,
    /// The terms of the Sun alone.
    Centre,
    /// The terms of all bodies.
    All,
}

/// Distances from the truth in km at the last date of each body, by name.
fn distances(correction: Correction, step: f64) -> BTreeMap<String, f64> {
    let start = table("solar_system_1969_de441.csv");
    let names: Vec<&str> = start.iter().map(|(name, _)| name.as_str()).collect();
    let parameters: Vec<f64> = start.iter().map(|(_, numbers)| numbers[1]).collect();
    let bodies = Domain::new("bodies")
        .with_unit(StandardGravitationalParameter, "au^3/d^2", parameters.clone())
        .with_unit(Position, "au", vectors(&start, 2))
        .with_unit(Velocity, "au/d", vectors(&start, 5));
    let builder = Engine::<f64>::builder().domain(bodies).law(GravityByParameter::default()).law(Kinematics);
    let builder = match correction {
        Correction::None => builder,
        Correction::Centre => builder.law(PostNewtonian),
        Correction::All => builder.law(NewtonianField).law(EinsteinInfeldHoffmann),
    };
    let mut engine = builder.integrator(RungeKutta4).step(step).build().unwrap();
    let mut truth = table("solar_system_truth_1970_1985.csv");
    truth.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]));
    let mut off = BTreeMap::new();
    for (name, numbers) in &truth {
        let steps = ((numbers[0] - EPOCH) * DAY / step).round() as u64 - engine.steps();
        engine.steps_of(steps, step).unwrap();
        let at = |name: &str| {
            let row = names.iter().position(|other| *other == name).unwrap();
            (engine.state().get("bodies", Position, row).unwrap() / (1000.0 * AU_KM), parameters[row])
        };
        let place = match name.as_str() {
            "EMB" => {
                let ((earth, of_earth), (moon, of_moon)) = (at("Earth"), at("Moon"));
                (earth * of_earth + moon * of_moon) / (of_earth + of_moon)
            }
            "GeoMoon" => at("Moon").0 - at("Earth").0,
            name => at(name).0,
        };
        off.insert(name.clone(), (place - DVec3::from_slice(&numbers[1..4])).length() * AU_KM);
    }
    off
}

#[test]
fn eleven_years_of_planets() {
    let with = distances(Correction::All, 3600.0);
    let centre = distances(Correction::Centre, 3600.0);
    // Hundreds of kilometres do not need the short step.
    let without = distances(Correction::None, 7200.0);
    for (name, with) in &with {
        println!(
            "{name:8} {with:12.2} km with, {:12.2} km by the Sun alone, {:12.2} km without",
            centre[name], without[name]
        );
    }
    // What eleven point masses are off by, from an independent integration: DOP853 of SciPy with a relative tolerance of
    // 3e-14. Half the step moves Mercury by 0.11 km, the Moon by 0.7 km, Venus and Earth by less than
    // 0.01 km.
    for (off, name, converged, error) in [
        (&with, "Mercury", 3.82, 0.15),
        (&with, "Venus", 2.33, 0.02),
        (&with, "Earth", 1.47, 0.02),
        (&centre, "Mercury", 3.69, 0.15),
        (&centre, "Venus", 2.04, 0.02),
        (&centre, "Earth", 1.10, 0.02),
        // The Moon lacks tides and figure, and goes round the Earth 147 times.
        (&with, "GeoMoon", 316.5, 1.0),
        (&centre, "GeoMoon", 260.4, 1.0),
    ] {
        assert!((off[name] - converged).abs() < error, "{name}: {} km, not {converged} km", off[name]);
    }
    // The correction is what makes the difference.
    for (name, expected) in [("Mercury", 3594.0), ("Venus", 978.0), ("Earth", 563.0)] {
        assert!((without[name] / expected - 1.0).abs() < 0.01, "{name}: {} km, not {expected} km", without[name]);
    }
}
