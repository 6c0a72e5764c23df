//! Steps that are too long for an explicit integrator: told before a run, refused by a study; implicit integrators by name.

use crate::common::{Scratch, done, vesper};

/// k = 5e6 N/m, m = 100 kg: leapfrog is stable up to 2 / omega = 8.94 ms.
const STIFF: &str = r#"
title = "a stiff spring"
[engine]
step = 0.016666666666666666
end = 1.0
[domains.bodies]
mass = [0.0, 100.0]
position = [[0, 0, 0], [1.01, 0, 0]]
velocity = [[0, 0, 0], [0, 0, 0]]
[domains.springs]
ends = { domain = "bodies", value = [[0, 1]] }
stiffness = [5e6]
rest_length = [1.0]
[[laws]]
name = "motion"
[[laws]]
name = "spring"
"#;

#[test]
fn a_run_warns_of_a_step_that_is_too_long_and_implicit_integrators_take_it() {
    let folder = Scratch::new("stable-run");
    let scene = folder.write("stiff.toml", STIFF);
    let warned = vesper(["run", &scene]);
    let expected = "warning: leapfrog is stable up to steps of 0.00894 s here, where laws oscillate at 224 rad/s, and the step is \
                    0.01667 s: take a shorter one, or implicit_midpoint, or implicit_euler\n";
    assert!(warned.stderr.starts_with(expected), "{}", warned.stderr);
    let short = done(["run", &scene, "--step", "0.008"]);
    assert!(!short.stderr.contains("warning"), "{}", short.stderr);
    for integrator in ["implicit_midpoint", "implicit_euler"] {
        let went = done(["run", &scene, "--integrator", integrator]);
        assert!(!went.stderr.contains("warning") && went.stdout.contains(integrator), "{}", went.stderr);
    }
}

#[test]
fn a_study_refuses_steps_that_are_too_long() {
    let folder = Scratch::new("stable-study");
    let scene = folder.write("stiff.toml", STIFF);
    let asked =
        ["study", &scene, "--integrators", "leapfrog,implicit_midpoint", "--steps", "0.02,0.005", "--limit", "1"];
    let told = done(asked.into_iter().chain(["--json"])).json();
    let steps = |name: &str| -> Vec<f64> {
        let runs = told["runs"].as_array().unwrap().iter().filter(|run| run["integrator"] == name);
        let runs = runs.filter(|run| run["compensated"] == false);
        runs.map(|run| run["step"].as_f64().unwrap()).collect()
    };
    assert_eq!((steps("leapfrog"), steps("implicit_midpoint")), (vec![0.005], vec![0.02, 0.005]));
    let refused = told["refused"].as_array().unwrap();
    assert_eq!(refused.len(), 1, "{refused:?}");
    assert!(refused[0]["longer_steps"] == true && refused[0]["integrator"] == "leapfrog", "{refused:?}");
    let words = done(asked).stdout;
    assert!(
        words.contains("\nno leapfrog with longer steps: leapfrog is stable up to steps of 0.00894 s here"),
        "{words}"
    );
}
