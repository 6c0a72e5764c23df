//! Scene files that are right, `--set`, and mutations of a right one.

use std::path::{Path, PathBuf};

use vesper_cli::generate::SplitMix64;
use vesper_cli::scene::*;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes")
}

fn read(overrides: &[&str]) -> Result<Scene, Vec<SceneFault>> {
    let overrides: Vec<Override> = overrides.iter().map(|one| Override::from(*one)).collect();
    Scene::read(&folder().join("valid.toml"), &overrides)
}

fn valid(overrides: &[&str]) -> Scene {
    read(overrides).unwrap_or_else(|faults| panic!("{}", print_faults(&faults)))
}

#[test]
fn everything_arrives() {
    let scene = valid(&[]);
    let engine = &scene.engine;
    assert_eq!(engine.precision.as_ref().unwrap().value, Precision::F64);
    let integrator = engine.integrator.as_ref().unwrap();
    assert_eq!(integrator.name.value, "dormand_prince");
    let options: Vec<_> = integrator.options.iter().map(|o| (o.name.value.as_str(), o.value[0])).collect();
    assert_eq!(options, [("rtol", 1e-9), ("atol", 1e-12)]);
    assert_eq!(engine.step.as_ref().unwrap().value, 1e-3);
    assert!((engine.frame.as_ref().unwrap().value - 0.016666667).abs() < 1e-15);
    assert_eq!((engine.end.as_ref().unwrap().value, engine.threads.as_ref().unwrap().value), (10.0, 2));
    assert_eq!(engine.observe.as_ref().unwrap()[1].value, "bodies.velocity");
    assert_eq!(scene.constants[1].value, [0.0, 0.0, -9.81]);
    assert_eq!(scene.constants[1].unit.as_ref().unwrap().value, "m/s^2");

    let FieldShape::Boxes(boxes) = &scene.fields[0].shape else { panic!() };
    assert_eq!((boxes[0].min[2], boxes[0].max[2]), (f64::NEG_INFINITY, f64::INFINITY));
    assert_eq!(scene.fields[1].unit.as_ref().unwrap().value, "km/h");
    assert_eq!(scene.fields[2].shape, FieldShape::Point { at: [0.0, 0.0, 1.0], strength: 2.5 });

    let names: Vec<_> = scene.domains.iter().map(|domain| domain.name.value.as_str()).collect();
    assert_eq!(names, ["bodies", "springs", "planets", "stars"]);
    let bodies = scene.domain("bodies").unwrap();
    let names: Vec<_> = bodies.columns.iter().map(|column| column.name.value.as_str()).collect();
    assert_eq!(names, ["mass", "position", "velocity", "charge", "colour"]);
    assert_eq!(bodies.rows(), Some(2));
    let velocity = bodies.column("velocity").unwrap();
    assert_eq!((velocity.width, velocity.rows, velocity.values[4]), (3, 2, 0.01));
    assert_eq!(bodies.column("charge").unwrap().subset.as_ref().unwrap()[0].value, 1);
    let ends = scene.domain("springs").unwrap().column("ends").unwrap();
    assert_eq!((ends.link.as_ref().unwrap().value.as_str(), &ends.values[..]), ("bodies", &[0.0, 1.0][..]));

    let planets = scene.domain("planets").unwrap();
    assert_eq!(planets.labels.as_ref().unwrap(), &["Sun", "Earth", "Moon"]);
    let position = planets.column("position").unwrap();
    assert_eq!((position.rows, &position.values[6..]), (3, &[1.0026, 0.0, 0.0][..]));
    assert_eq!(position.unit.as_ref().unwrap().value, "au");
    assert_eq!(planets.column("albedo").unwrap().values, [0.0, 0.3, 0.1]);

    let stars = scene.domain("stars").unwrap();
    assert_eq!(stars.rows(), Some(10));
    let far = stars.column("position").unwrap().values.iter().fold(0.0_f64, |far, x| far.max(x.abs()));
    assert!(far > 200.0, "the radius is 1 km, not 1 m: {far}");

    let law = &scene.laws[1];
    assert_eq!((law.called(), law.enabled, law.every.as_ref().unwrap().value), ("pull", false, 2));
    let names: Vec<_> = law.parameters.iter().map(|p| (p.name.value.as_str(), p.value.len())).collect();
    assert_eq!(names, [("softening", 1), ("g", 1), ("axis", 3)]);
    let compare = scene.compare.as_ref().unwrap();
    assert_eq!(compare.time.origin, 2440432.5);
    assert_eq!(compare.barycentres[0].1[1].value, "Moon");
    assert_eq!(compare.relative[0].1[0].value, "Moon");
    // Places survive, for whoever checks names.
    let fault = scene.fault(law.parameters[0].name.span, "x", None);
    assert_eq!((fault.line, fault.column, fault.source_line.as_str()), (59, 1, "softening = 0.1"));
}

#[test]
fn set_changes_values_before_they_are_read() {
    let scene = valid(&[
        "engine.step=2e-3",
        "engine.integrator.rtol=1e-6",
        "laws.pull.softening=0.5",
        "laws.motion.every=3",
        "laws.pull.enabled=true",
        "constants.gravity=[0,0,-1.62]",
        "domains.springs.stiffness=[30.0]",
        "domains.springs.ends=[[1,0]]",
        "domains.bodies.position.1=[7,7,7]",
        "domains.bodies.velocity.0 = [9,9,9]",
        "generate.stars.count=20",
        "title=short",
        "compare.time.origin=0",
    ]);
    assert_eq!(scene.engine.step.as_ref().unwrap().value, 2e-3);
    assert_eq!(scene.engine.integrator.as_ref().unwrap().options[0].value, [1e-6]);
    assert_eq!(scene.laws[1].parameters[0].value, [0.5]);
    assert_eq!((scene.laws[0].every.as_ref().unwrap().value, scene.laws[1].enabled), (3, true));
    // The value is replaced, the unit stays; so do the target of a link and the rows of a subset.
    assert_eq!(scene.constants[1].value, [0.0, 0.0, -1.62]);
    assert_eq!(scene.constants[1].unit.as_ref().unwrap().value, "m/s^2");
    assert_eq!(scene.domain("springs").unwrap().column("stiffness").unwrap().values, [30.0]);
    let ends = scene.domain("springs").unwrap().column("ends").unwrap();
    assert_eq!((&ends.values[..], ends.link.is_some()), (&[1.0, 0.0][..], true));
    let bodies = scene.domain("bodies").unwrap();
    assert_eq!(bodies.column("position").unwrap().values[3..], [7.0; 3]);
    assert_eq!(bodies.column("velocity").unwrap().values[..3], [9.0; 3]);
    assert_eq!(scene.domain("stars").unwrap().rows(), Some(20));
    assert_eq!(scene.title.as_ref().unwrap().value, "short");
    assert_eq!(scene.compare.as_ref().unwrap().time.origin, 0.0);

    let short =
        Scene::from_text("a.toml", "[engine]\nintegrator='rk4'", Path::new(""), &["engine.integrator.rtol=1".into()]);
    let integrator = short.unwrap().engine.integrator.unwrap();
    assert_eq!((integrator.name.value.as_str(), integrator.options.len()), ("rk4", 1));
    assert_eq!(valid(&["engine.integrator=rk4"]).engine.integrator.unwrap().name.value, "rk4");
    let empty = Scene::from_text("a.toml", "", Path::new(""), &["engine.step=1".into()]).unwrap();
    assert_eq!(empty.engine.step.unwrap().value, 1.0);
}

#[test]
fn mistakes_in_set_are_found_in_the_argument() {
    // Argument, column in it, words, help.
    let table: &[(&str, usize, &str, &str)] = &[
        ("engine.stp=1", 8, "`stp` is not known in [engine]", "did you mean `step`?"),
        ("engin.step=1", 1, "no section is named `engin`", "did you mean `engine`?"),
        ("engine.step", 1, "expected PATH=VALUE", "as in --set engine.step=1e-3"),
        ("engine.step=", 13, "a value is missing after `=`", ""),
        ("engine.step=fast", 13, "expected a number, found text", ""),
        ("engine.step=[1", 15, "unclosed array, expected `]`", ""),
        ("engine=1", 1, "`engine` is a section: name what to set in it", ""),
        ("engine..step=1", 8, "a name is missing in the path", ""),
        ("laws.gravty.softening=1", 6, "the scene has no law `gravty`", "known here: motion, pull"),
        ("laws.pul.softening=1", 6, "the scene has no law `pul`", "did you mean `pull`?"),
        ("laws.pull.every=0", 17, "expected a whole number, 1 or more, found 0", ""),
        ("constants.gravty=[0,0,1]", 11, "the scene has no `gravty` in `constants`", "did you mean `gravity`?"),
        ("domains.sprngs.stiffness=[1]", 9, "the scene has no `sprngs` in `domains`", "did you mean `springs`?"),
        ("domains.springs.stifness=[1]", 17, "the scene has no `stifness` in `springs`", "did you mean `stiffness`?"),
        ("domains.springs.ends=[[0,9]]", 23, "row 9 does not exist: `bodies` has 2 rows", "rows count from 0 to 1"),
        ("domains.bodies.mass.5=1", 21, "`mass` has 2 items, none is number `5`", ""),
        ("title.x=1", 7, "`title` is text: it has no `x`", ""),
    ];
    for &(argument, column, text, help) in table {
        let faults = read(&[argument]).expect_err(argument);
        assert_eq!(faults.len(), 1, "{argument}: {}", print_faults(&faults));
        let fault = &faults[0];
        assert_eq!(fault.file, format!("--set {argument}"));
        assert_eq!((fault.line, fault.column, fault.text.as_str()), (0, column, text), "{argument}");
        assert_eq!(fault.help.as_deref().unwrap_or(""), help, "{argument}");
    }
    let twice = Scene::from_text(
        "a.toml",
        "[[laws]]\nname='g'\ndomain='scene'\n[[laws]]\nname='g'",
        Path::new(""),
        &["laws.g.x=1".into()],
    );
    assert_eq!(twice.unwrap_err()[0].text, "the scene has 2 laws `g`");
    let shown = read(&["engine.stp=1"]).unwrap_err()[0].to_string();
    let expected = [
        "error: `stp` is not known in [engine]",
        "  --> --set engine.stp=1",
        "    | engine.stp=1",
        "    |        ^^^",
        "    = help: did you mean `step`?",
    ];
    assert_eq!(shown, expected.join("\n"));
}

#[test]
fn no_mutation_panics() {
    let text = std::fs::read(folder().join("valid.toml")).unwrap();
    let mut deviates = SplitMix64::new(20);
    let mut below = |n: usize| (deviates.bits() % n as u64) as usize;
    let mut refused = 0;
    for _ in 0..3000 {
        let mut bytes = text.clone();
        for _ in 0..1 + below(3) {
            let start = below(bytes.len());
            let end = (start + 1 + below(12)).min(bytes.len());
            match below(4) {
                0 | 1 => drop(bytes.drain(start..end)),
                2 => {
                    let piece = bytes[start..end].to_vec();
                    let at = below(bytes.len());
                    bytes.splice(at..at, piece);
                }
                _ => bytes[start] = b"[]{}=\".,#-9\n"[below(12)],
            }
        }
        // A generator may be asked for very many rows by a doubled digit; that is right, and slow.
        let text = String::from_utf8_lossy(&bytes);
        if text.lines().any(|line| line.starts_with("count") && line.len() > 14) {
            continue;
        }
        if let Err(faults) = Scene::from_text("mutant.toml", &text, &folder(), &["engine.step=1".into()]) {
            refused += 1;
            assert!(!faults.is_empty());
            let _ = print_faults(&faults);
        }
    }
    assert!(refused > 1500, "{refused}");
}
