//! `vesper study`: what it prints and writes, from a scene without an answer and from cases with one.

use serde_json::Value;

use crate::common::{Scratch, done, vesper};

const SPRING: &str = r#"
title = "two masses on a spring"
[engine]
step = 0.01
end = 2.0
[domains.bodies]
mass = [1.0, 2.0]
position = [[-1, 0, 0], [1, 0, 0]]
velocity = [[0, 0.1, 0], [0, 0, 0]]
[domains.springs]
ends = { domain = "bodies", value = [[0, 1]] }
stiffness = [30.0]
rest_length = [1.5]
[[laws]]
name = "motion"
[[laws]]
name = "spring"
"#;

#[test]
fn a_scene_without_an_answer_gets_one_and_a_diagram() {
    let folder = Scratch::new("study-scene");
    let (scene, out) = (folder.write("spring.toml", SPRING), folder.file("out"));
    let asked = "leapfrog,dormand_prince_8,symplectic_6";
    let told = done(["study", &scene, "--integrators", asked, "--limit", "0.05", "--out", &out, "--json"]).json();
    let runs = told["runs"].as_array().unwrap();
    let errors = |name: &str| -> Vec<(f64, f64, f64)> {
        let of = runs.iter().filter(|run| run["integrator"] == name && run["compensated"] == false);
        let number = |run: &Value, key: &str| run[key].as_f64().unwrap_or(f64::NAN);
        of.map(|run| (number(run, "step"), number(run, "error"), number(run, "bound"))).collect()
    };
    // Order 2, from the scene's own step by halves.
    let leapfrog = errors("leapfrog");
    let at = |step: f64| leapfrog.iter().find(|(length, ..)| *length == step).unwrap().1;
    let order = (at(0.01) / at(0.005)).log2();
    assert!((order - 2.0).abs() < 0.05, "{order}");
    // On a machine that is busy some are given up.
    let ended: Vec<&Value> = runs.iter().filter(|run| run["error"].is_number()).collect();
    assert!(ended.len() > 10 && ended.iter().all(|run| run["error"].as_f64() < run["bound"].as_f64()));
    assert!(told["best"]["spring"]["error"].as_f64().unwrap() < 1e-12);
    let cheap = &told["cheapest"]["spring"]["1e-6"];
    assert!(cheap["bound"].as_f64().unwrap() <= 1e-6, "{cheap}");
    let answer = told["answers"]["spring"]["by"].as_str().unwrap();
    assert!(answer.starts_with("gauss_radau_15 with precision 1e-7; dormand_prince_8"), "{answer}");
    let drawn = folder.read("out/spring.svg");
    assert!(drawn.starts_with("<svg") && drawn.contains("symplectic_6") && drawn.trim_end().ends_with("</svg>"));
    let lines = folder.read("out/study.csv").lines().count();
    assert_eq!(lines, runs.len() + 1);
    // The same again takes the runs as they are.
    let resume = folder.file("out/study.json");
    let again = done(["study", &scene, "--integrators", asked, "--limit", "0.05", "--resume", &resume, "--json"]);
    assert_eq!(again.json()["runs"], told["runs"]);
}

#[test]
fn a_budget_is_met_by_a_run_that_was_made() {
    let folder = Scratch::new("study-budget");
    let scene = folder.write("spring.toml", SPRING);
    let asked =
        ["study", &scene, "--integrators", "leapfrog,symplectic_6", "--limit", "0.05", "--of", "bodies.position"];
    let told = done(asked.into_iter().chain(["--error", "1e-6", "--json"])).json();
    let choice = &told["choice"]["spring"];
    let number = |run: &Value, key: &str| run[key].as_f64().unwrap_or(f64::INFINITY);
    assert!(number(choice, "bound") <= 1e-6 && choice["stable"] == true, "{choice}");
    let runs = told["runs"].as_array().unwrap();
    assert!(runs.contains(choice));
    // It was looked for between and beyond the steps of the study, which are halves; which of them is the fastest is a
    // matter of the clock.
    let halves = |run: &Value| (0.01 / number(run, "step")).log2();
    assert!(runs.iter().any(|run| (halves(run) - halves(run).round()).abs() > 0.1), "{runs:?}");
    let words = done(asked.into_iter().chain(["--error", "1e-6", "--fps", "60"])).stdout;
    assert!(words.contains("spring: an error of at most 1e-6 costs least by symplectic_6 with step "), "{words}");
    assert!(words.contains("% of the time of a frame, at 60 frames a second"), "{words}");
    let words = done(asked.into_iter().chain(["--error", "1e-30"])).stdout;
    assert!(words.contains("spring: an error of at most 1e-30 is met by no run: the nearest one comes to "), "{words}");
    let wrong = vesper(asked.into_iter().chain(["--error", "small"]));
    assert!(
        wrong.status == 2 && wrong.stderr.contains("expected a number above 0\n  --> --error small"),
        "{}",
        wrong.stderr
    );
}

#[test]
fn cases_have_a_table_with_the_nearest_and_the_fastest() {
    let cases = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/references.json");
    let chosen = "projectile_vacuum,rel_force_free";
    let done = done(["study", cases, "--cases", chosen, "--integrators", "gauss_radau_15,drift_kick_drift"]);
    let lines: Vec<&str> = done.stdout.lines().collect();
    assert!(lines[0].starts_with("case ") && lines[0].ends_with("fastest at 1e-12"), "{}", done.stdout);
    assert!(lines[1].starts_with("projectile_vacuum ") && lines[2].starts_with("rel_force_free "), "{}", done.stdout);
    assert!(done.stdout.contains("no drift_kick_drift for 1 of 2 cases (rel_force_free): "), "{}", done.stdout);
}

#[test]
fn mistakes_are_told_all_at_once_and_nothing_runs() {
    let cases = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/references.json");
    let done = vesper([
        "study",
        cases,
        "--cases",
        "kepler_e0.8",
        "--integrators",
        "leapfog",
        "--steps",
        "-1",
        "--precisions",
        "f16",
        "--of",
        "bodies.position",
    ]);
    assert_eq!(done.status, 2);
    let expected = [
        "--of",
        "--cases kepler_e0.8",
        "did you mean `kepler_e0.9`?",
        "--integrators leapfog",
        "did you mean `leapfrog`?",
        "--steps -1",
        "--precisions f16",
    ];
    for text in expected {
        assert!(done.stderr.contains(text), "{text}: {}", done.stderr);
    }
    let folder = Scratch::new("study-mistakes");
    let done = vesper(["study", &folder.write("spring.toml", SPRING), "--of", "bodies.mass"]);
    let expected = "--of bodies.mass: the scene does not show it; it shows bodies.position, bodies.velocity";
    assert!(done.status == 2 && done.stderr.contains(expected), "{}", done.stderr);
}

#[test]
fn each_law_is_switched_off_in_turn() {
    let folder = Scratch::new("study-laws");
    let scene = folder.write(
        "damped.toml",
        &SPRING.replace("[[laws]]", "").replace("name = \"motion\"", "").replace(
            "name = \"spring\"",
            r#"
[constants]
gravity = [0, 0, -1e-9]
[[laws]]
name = "motion"
[[laws]]
name = "spring"
[[laws]]
name = "uniform_gravity"
"#,
        ),
    );
    let told = done(["study", &scene, "--laws", "--of", "bodies.position", "--json"]).json();
    let law = |name: &str| told["laws"].as_array().unwrap().iter().find(|law| law["law"] == name).unwrap().clone();
    assert_eq!(law("motion")["verdict"], "stays");
    // Without the spring both fly on at the speeds that they have: the lighter one is 0.2 m on its way, after 2 s.
    let spring = law("spring");
    assert!(spring["verdict"] == "needed" && spring["change"].as_f64().unwrap() > 0.1, "{spring}");
    // g t^2 / 2, which is less than the error of leapfrog with the scene's step.
    let gravity = law("uniform_gravity");
    assert!((gravity["change"].as_f64().unwrap() / 2e-9 - 1.0).abs() < 1e-3, "{gravity}");
    assert!(gravity["verdict"] == "below_step" && gravity["unit"] == "m", "{gravity}");
    let words = done(["study", &scene, "--laws", "--of", "bodies.position", "--error", "1e-10"]).stdout;
    assert!(words.contains("2 nm of row") && words.contains("needed"), "{words}");
    let words = done(["study", &scene, "--laws", "--of", "bodies.position", "--error", "1e-6"]).stdout;
    assert!(words.contains("can be dropped: less than 1e-6"), "{words}");
}

#[test]
fn a_choice_is_written_into_its_scene_which_then_meets_the_error() {
    let folder = Scratch::new("study-write");
    let commented = SPRING.replace("step = 0.01", "step = 0.01   # as it was").replace("[engine]", "# how\n[engine]");
    for (asked, key) in
        [("symplectic_6", "integrator = \"symplectic_6\""), ("dormand_prince_8", "{ name = \"dormand_prince_8\"")]
    {
        let scene = folder.write("spring.toml", &commented);
        let study = ["study", &scene, "--integrators", asked, "--limit", "0.05", "--error", "1e-7", "--write"];
        let words = done(study).stdout;
        assert!(words.contains("written into") && words.contains(key), "{words}");
        let text = folder.read("spring.toml");
        assert!(text.contains(key) && text.contains("# as it was") && text.contains("# how\n[engine]"), "{text}");
        let position = |more: &[&str]| -> Vec<f64> {
            let told = done(["run", &scene, "--json"].iter().chain(more)).json();
            let rows = told["domains"]["bodies"]["position"].as_array().unwrap().clone();
            rows.iter().flat_map(|row| row.as_array().unwrap().iter().map(|x| x.as_f64().unwrap())).collect()
        };
        let (chosen, exact) = (position(&[]), position(&["--integrator", "gauss_radau_15"]));
        let off = chosen.iter().zip(&exact).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
        assert!(off < 1e-7 && off > 0.0, "{asked}: {off:e}");
    }
    // Nothing meets it: nothing is changed.
    let scene = folder.write("spring.toml", &commented);
    let study = ["study", &scene, "--integrators", "leapfrog", "--limit", "0.05", "--error", "1e-30", "--write"];
    assert!(done(study).stdout.contains("is left as it is"));
    assert_eq!(folder.read("spring.toml"), commented);
}

/// What the laws suggest may be a method of fixed steps: then it is no ladder of tolerances, and a study says which one it is.
#[test]
fn auto_is_studied_where_it_chooses_its_steps_and_named_where_it_does_not() {
    let folder = Scratch::new("study-auto");
    let scene = folder.write("spring.toml", SPRING);
    let told = done(["study", &scene, "--integrators", "auto", "--json"]).json();
    let first = &told["runs"][0];
    // As it is, and not coarser.
    assert_eq!((first["integrator"].as_str(), first["options"]["precision"].as_f64()), (Some("auto"), Some(1e-7)));
    let held = SPRING.replace("name = \"spring\"", "name = \"spring\"\nevery = 4");
    let scene = folder.write("held.toml", &held);
    let told = done(["study", &scene, "--integrators", "auto", "--json"]).json();
    assert_eq!(told["runs"].as_array().map(Vec::len), Some(0));
    let refused = told["refused"][0].to_string();
    assert!(refused.contains("for these laws auto is respa, which takes fixed steps: study that"), "{refused}");
}
