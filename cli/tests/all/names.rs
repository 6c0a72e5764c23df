//! Mistakes that need the laws and properties to be seen: scene, place, message.

use std::path::Path;

use vesper_cli::assemble;
use vesper_cli::modules::Modules;
use vesper_cli::run::Ready;
use vesper_cli::scene::*;

/// All faults of a scene, as `vesper run` finds them.
fn faults(text: &str) -> Vec<String> {
    let scene =
        Scene::from_text_and("a.toml", text, Path::new(""), &[], |scene| assemble::names(scene, &Modules::default()));
    let faults = match &scene {
        Ok(scene) => Ready::<f64>::new(scene, None).err().unwrap_or_default(),
        Err(faults) => faults.clone(),
    };
    let said = |fault: &SceneFault| {
        let help = fault.help.as_ref().map_or(String::new(), |help| format!("; {help}"));
        format!("{}:{}: {}{help}", fault.line, fault.column, fault.text)
    };
    faults.iter().map(said).collect()
}

/// Times, a moving body, and what is wrong with it. The lines of the mistake begin at 6.
const BODY: &str = "[engine]\nstep = 1\nend = 1\n[domains.bodies]\nposition = [[0, 0, 0]]\n";

/// Lines behind [`BODY`], then "line:column: message; help".
const TABLE: &[(&str, &str)] = &[
    // Laws and parameters.
    ("[[laws]]\nname = \"gravty\"", "7:8: no law is named `gravty`; did you mean `gravity`?"),
    ("[[laws]]\nname = \"phlogiston\"", "7:8: no law is named `phlogiston`; `vesper laws` lists them"),
    (
        "[[laws]]\nname = \"gravity\"\nsofening = 1",
        "8:1: law `gravity` has no parameter `sofening`; did you mean `softening`?",
    ),
    ("[[laws]]\nname = \"motion\"\ndrag = 1", "8:1: law `motion` has no parameter `drag`; `motion` has no parameters"),
    ("[[laws]]\nname = \"gravity\"\nsoftening = [1, 2, 3]", "8:13: expected a number for `softening`, found 3"),
    (
        "[[laws]]\nname = \"gravity\"\nsoftening = { value = 1, unit = \"kg\" }",
        "8:33: expected a unit like m, found kg",
    ),
    (
        "[[laws]]\nname = \"gravity\"\nsoftening = { value = 1e300, unit = \"Ypc\" }",
        "8:23: `softening` is too large in m",
    ),
    #[cfg(not(feature = "gpu"))]
    (
        "[[laws]]\nname = \"gravity\"\nbackend = \"gpu\"",
        "8:11: this build has no GPU backend; use auto, cpu or parallel, or build it with the feature `gpu`",
    ),
    ("[[laws]]\nname = \"gravity\"\nevery = 5000000000", "8:9: expected at most 4294967295 steps, found 5000000000"),
    // Columns, constants, fields.
    ("mass = { value = [1], unit = \"m\" }", "6:30: expected a unit like kg, found m"),
    ("velocity = [[0, 0]]", "6:13: `velocity` is a vector: expected 3 numbers, found 2"),
    ("mass = [[1, 2, 3]]", "6:9: `mass` is a scalar: expected a number, found 3"),
    ("uv = [[1, 2]]", "6:7: a value has 1, 3 or 4 components, and here 2"),
    ("[constants]\ngravity = 9.81", "7:11: `gravity` is a vector: expected 3 numbers, found 1"),
    ("[constants]\nspeed_of_light = { value = 1, unit = \"m\" }", "7:38: expected a unit like m/s, found m"),
    ("[fields.electric_field]\nuniform = 1", "7:11: `electric_field` is a vector: expected 3 numbers, found 1"),
    ("[fields.mass]\nuniform = 1", "6:9: `mass` is a scalar, and a field has a vector at every place"),
    ("[fields.electric_field]\nuniform = [1, 0, 0]\nunit = \"T\"", "8:8: expected a unit like V/m, found T"),
    // Links.
    (
        "[domains.springs]\nends = [[0, 0]]",
        "7:8: `ends` names rows of a domain, and does not say of which; write { domain = \"..\", value = [..] }",
    ),
    (
        "[domains.springs]\nends = { domain = \"bodies\", value = [[0, 0, 0]] }",
        "7:38: `ends` names 2 rows in each item, and here 3",
    ),
    ("mass = { domain = \"bodies\", value = [0] }", "6:19: `mass` is a scalar, which names no rows of a domain"),
    (
        "[domains.springs]\nstiffness = [1, 1]\nends = { domain = \"bodies\", rows = [0], value = [[0, 0]] }",
        "8:8: `ends` needs rows for every row of `springs`; leave `rows` out",
    ),
    // What only the library sees.
    (
        "[domains.stars]\nposition = [[0, 0, 0]]\nmass = [1]\n[domains.suns]\nposition = [[0, 0, 0]]\nmass = [1]\n[[laws]]\nname = \"gravity\"",
        "13:8: law `gravity` can stand on stars or suns; say on which: domain = \"stars\"",
    ),
];

/// Whole `[engine]` sections.
const ENGINES: &[(&str, &str)] = &[
    ("end = 1", "0:0: the scene has no step; write `step = ..` into [engine], or run with --step S"),
    ("step = 1", "0:0: the scene has no end; write `end = ..` into [engine], or run with --end S"),
    ("step = 1\nend = 1\nintegrator = \"leapfog\"", "4:14: no integrator is named `leapfog`; did you mean `leapfrog`?"),
    (
        "step = 1\nend = 1\nintegrator = \"euler\"",
        "4:14: no integrator is named `euler`; did you mean `semi_implicit_euler`?",
    ),
    ("step = 1\nend = 1\nintegrator = \"rk4\"", "4:14: no integrator is named `rk4`; did you mean `runge_kutta_4`?"),
    ("step = 1\nend = 1\nintegrator = \"KDK\"", "4:14: no integrator is named `KDK`; did you mean `leapfrog`?"),
    ("step = 1\nend = 1\nintegrator = { name = \"leapfrog\", rtol = 1e-9 }", "4:35: `leapfrog` has no option `rtol`"),
    (
        "end = 1\nintegrator = { name = \"dormand_prince_8\", rtoll = 1e-9 }",
        "3:43: `dormand_prince_8` has no option `rtoll`; did you mean `rtol`?",
    ),
    ("end = 1\nintegrator = { name = \"dormand_prince_5\", rtol = 0 }", "3:50: expected a number above 0 for `rtol`"),
    #[cfg(not(feature = "gpu"))]
    (
        "step = 1\nend = 1\nbackend = \"gpu\"",
        "4:11: this build has no GPU backend; use auto, cpu or parallel, or build it with the feature `gpu`",
    ),
    ("step = 1\nend = 1\nthreads = 100000", "4:11: expected at most 1024 threads, found 100000"),
    (
        "step = 1\nend = 1\nobserve = [\"bodies.forze\"]\n[domains.bodies]\nmass = [1]",
        "4:12: `bodies` has no property `forze`, and no running law makes one",
    ),
    ("step = 1e-9\nend = 1e9", "2:8: 1e9 s in steps of 1e-9 s are too many to count"),
    ("step = 1\nend = 1\n[constants]\ntime = 5", "3:7: the end, 1 s, is before the start, 5 s"),
];

#[test]
fn each_mistake_has_its_message() {
    let mut wrong = Vec::new();
    let behind = TABLE.iter().map(|(text, expected)| (format!("{BODY}{text}"), expected));
    let engines = ENGINES.iter().map(|(text, expected)| (format!("[engine]\n{text}"), expected));
    for (text, expected) in behind.chain(engines) {
        let found = faults(&text);
        if found != [*expected] {
            wrong.push(format!("{text}\n  expected {expected}\n  found    {}", found.join("\n           ")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn a_strict_scene_says_what_a_law_lacks() {
    let text = format!("{BODY}[[laws]]\nname = \"motion\"").replace("step = 1\n", "step = 1\nstrict = true\n");
    let found = faults(&text);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].starts_with("8:8: motion must run, but is dormant: "), "{found:?}");
    assert!(found[0].contains("velocity"), "{found:?}");
}

#[test]
fn a_law_that_sleeps_by_mistake_is_a_fault() {
    let near = "no law knows this name; a law that may sleep is listed with `enabled = false`";
    let none = "no law of the scene runs; `vesper explain` tells what each needs";
    let motion = "[[laws]]\nname = \"motion\"\n";
    let drag = "[[laws]]\nname = \"drag\"\n";
    let moving = "mass = [1]\nvelocity = [[0, 0, 1]]\n";
    for (text, expected) in [
        (
            format!("velocty = [[0, 0, 1]]\nmass = [1]\n{motion}"),
            format!(
                "6:1: motion is dormant: it reads velocity [m/s], which domain bodies does not have; there is velocty: rename it, or add velocity; {near}"
            ),
        ),
        (
            format!("{moving}drag_coeficient = [1]\n{motion}{drag}"),
            format!(
                "8:1: drag is dormant: it reads drag_coefficient [kg/s], which domain bodies does not have; there is drag_coeficient: rename it, or add drag_coefficient; {near}"
            ),
        ),
        (
            format!("mass = [1]\n{drag}"),
            format!(
                "8:8: drag is dormant: it reads velocity [m/s], which domain bodies does not have: add velocity; it reads drag_coefficient [kg/s], which domain bodies does not have: add drag_coefficient; {none}"
            ),
        ),
    ] {
        let found = faults(&format!("{BODY}{text}"));
        assert!(found.len() == 1 && found[0] == expected, "{text}\n  expected {expected}\n  found    {found:#?}");
    }
    let both = faults(&format!("{BODY}velocty = [[0, 0, 1]]\nmass = [1]\ndrag_coefficient = [1]\n{motion}{drag}"));
    assert!(both.len() == 1 && both[0].starts_with("6:1: motion is dormant"), "one slip is one mistake: {both:#?}");
    // A law that lacks what nothing resembles may sleep, and so may one that is switched off.
    assert!(faults(&format!("{BODY}{moving}colour = [1]\n{motion}{drag}")).is_empty());
    assert!(faults(&format!("{BODY}{moving}drag_coeficient = [1]\n{motion}{drag}enabled = false\n")).is_empty());
}

#[test]
fn mistakes_of_all_kinds_are_told_at_once() {
    let text = "[engine]\nstep = \"slow\"\nintegrator = \"leapfog\"\nend = 1\n[domains.bodies]\nmass = { value = [1], unit = \"m\" }\n\
                velocity = [[0, 0]]\nposition = [[0, 0, 0], [1, 1, 1]]\n[[laws]]\nname = \"gravty\"\n[[laws]]\nname = \"motion\"\nevery = 0\n";
    let found = faults(text);
    let places: Vec<&str> = found.iter().map(|fault| fault.split(": ").next().unwrap()).collect();
    assert_eq!(places, ["2:8", "3:14", "6:30", "7:13", "8:1", "10:8", "13:9"], "{found:#?}");
}

#[test]
fn unknown_properties_are_kept_in_si() {
    let text = format!("{BODY}boiling_point = {{ value = [2], unit = \"mK\" }}\n");
    let text = text.replace("end = 1\n", "end = 1\nobserve = [\"bodies.boiling_point\"]\n");
    let scene = Scene::from_text("a.toml", &text, Path::new(""), &[]).unwrap();
    let outcome = Ready::<f64>::new(&scene, None).unwrap().run(Default::default(), &mut |_, _| Ok(()));
    assert_eq!(outcome.domains[0].columns[0].numbers, [0.002]);
    assert_eq!(outcome.domains[0].columns[0].property.unit, "K");
    assert_eq!(outcome.unused, ["bodies.position", "bodies.boiling_point"]);
}

#[test]
fn a_moment_at_which_a_run_is_stopped_is_recorded_once() {
    let text = format!("{BODY}mass = [1]\nvelocity = [[0, 0, 1]]\n[[laws]]\nname = \"motion\"\n");
    let scene = Scene::from_text("a.toml", &text.replace("end = 1", "end = 1000"), Path::new(""), &[]).unwrap();
    let request = vesper_cli::run::Request { record_every: 10, draw_every: 4, ..Default::default() };
    let (stop, mut recorded, mut drawn) = (request.stop.clone(), Vec::new(), Vec::new());
    let outcome = Ready::<f64>::new(&scene, None).unwrap().run(request, &mut |engine, shown| {
        let moments = if shown.is_some() { &mut recorded } else { &mut drawn };
        moments.push(engine.steps());
        stop.store(engine.steps() == 20, std::sync::atomic::Ordering::Relaxed);
        Ok(())
    });
    assert!(outcome.interrupted && outcome.faults.is_empty());
    assert_eq!((outcome.steps, recorded, drawn), (20, vec![0, 10, 20], vec![4, 8, 12, 16]));
}
