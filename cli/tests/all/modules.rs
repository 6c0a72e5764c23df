//! Laws that were compiled apart, in scenes.

use std::path::Path;
use std::process::Command;

use super::common::*;

/// A scene with a law of a module.
const SCENE: &str = r#"
[engine]
step = 1e-3
end = 1.0
integrator = "runge_kutta_4"

[domains.bodies]
mass = [2.0, 1.0]
position = [[0, 0, 0], [0, 0, 0]]
velocity = [[1, 0, 0], [3, 0, 0]]

[[laws]]
name = "motion"
[[laws]]
name = "lift"
module = "lift"
slope = { value = 500, unit = "g/s" }
"#;

/// A folder with the example in C, changed in one place, as `liblift.so`, and the scene.
pub fn folder(name: &str, from: &str, to: &str) -> Scratch {
    let scratch = Scratch::new(name);
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let source = std::fs::read_to_string(project.join("examples/modules/c/lift.c")).unwrap();
    assert!(source.contains(from), "{from}");
    let code = scratch.write("lift.c", &source.replace(from, to));
    let library = scratch.file("liblift.so");
    let include = project.join("bindings/c/include").display().to_string();
    let built = Command::new("cc").args(["-O2", "-shared", "-fPIC", "-I", &include, "-o", &library, &code]).output();
    let built = built.expect("cc is on the path: Rust links with it");
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    scratch.write("scene.toml", SCENE);
    scratch
}

fn height(run: &Done) -> f64 {
    run.json()["domains"]["bodies"]["position"][1][2].as_f64().unwrap()
}

#[test]
fn a_scene_runs_with_a_law_in_c() {
    let scratch = folder("module-runs", "slope", "slope");
    let (scene, laws) = (scratch.file("scene.toml"), scratch.0.display().to_string());
    // A force of 0.5 kg/s times 3 m/s on 1 kg for a second.
    let run = done(["run", &scene, "--laws", &laws, "--json"]);
    assert!((height(&run) - 0.75).abs() < 1e-12, "{}", height(&run));
    let in_f32 = done(["run", &scene, "--laws", &laws, "--json", "--precision", "f32"]);
    assert!((height(&in_f32) - 0.75).abs() < 1e-5);
    let output = Command::new(env!("CARGO_BIN_EXE_vesper"))
        .args(["run", &scene, "--json"])
        .env("VESPER_LAW_PATH", format!("/nowhere:{laws}"))
        .output()
        .unwrap();
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "");
    let explained = done(["explain", &scene, "--laws", &laws]).stdout;
    assert!(explained.contains("lift"), "{explained}");
    let out = scratch.file("out");
    done(["run", &scene, "--laws", &laws, "--quiet", "--end", "0.5", "--out", &out]);
    let checkpoint = scratch.file("out/checkpoint.json");
    let resumed = done(["run", &scene, "--laws", &laws, "--json", "--resume", &checkpoint]);
    assert_eq!(height(&resumed).to_bits(), height(&run).to_bits());
    let studied = done([
        "study",
        &scene,
        "--laws-from",
        &laws,
        "--json",
        "--quiet",
        "--integrators",
        "leapfrog",
        "--steps",
        "0.1",
    ]);
    assert!(studied.json()["runs"].as_array().is_some_and(|runs| !runs.is_empty()));
}

#[test]
fn what_is_wrong_with_a_module_is_said_at_its_place() {
    let scratch = folder("module-wrong", "slope", "slope");
    let laws = scratch.0.display().to_string();
    let told = |change: (&str, &str), more: &[&str]| {
        assert!(SCENE.contains(change.0), "{}", change.0);
        let scene = scratch.write("changed.toml", &SCENE.replace(change.0, change.1));
        let run = vesper([&["run", &scene, "--quiet"], more].concat());
        assert_eq!(run.status, 2, "{}", run.stderr);
        run.stderr
    };
    let nowhere = vesper(["run", &scratch.file("scene.toml")]).stderr;
    assert!(nowhere.contains("module `lift`: there is no folder to look for liblift.so in"), "{nowhere}");
    assert!(nowhere.contains("scene.toml:16:10"), "{nowhere}");
    let other = told(("module = \"lift\"", "module = \"lfit\""), &["--laws", &laws]);
    assert!(other.contains("did you mean lift?"), "{other}");
    let law = told(("name = \"lift\"", "name = \"lit\""), &["--laws", &laws]);
    assert!(law.contains("it has no law lit; did you mean lift?"), "{law}");
    let stock = told(("module = \"lift\"", ""), &["--laws", &laws]);
    assert!(stock.contains("one of a module has `module = \"..\"` too"), "{stock}");
    let parameter = told(("slope = {", "slop = {"), &["--laws", &laws]);
    assert!(parameter.contains("law `lift` has no parameter `slop`") && parameter.contains("`slope`"), "{parameter}");
    let unit = told(("g/s", "g"), &["--laws", &laws]);
    assert!(unit.contains("expected a unit like kg/s, found g"), "{unit}");
    let file = told(("module = \"lift\"", "module = \"./liblift.so\""), &["--laws", &laws]);
    assert!(file.contains("a scene may not name a file of code, only a module"), "{file}");
    let print =
        told(("module = \"lift\"", "module = \"lift\"\nfingerprint = \"0123456789abcdef\""), &["--laws", &laws]);
    assert!(print.contains("law `lift` is not the one that had the fingerprint 0123456789abcdef"), "{print}");
    assert!(
        print.contains("reads velocity: vector [m/s]") && print.contains("parameter slope: number [kg/s], default 0.1"),
        "{print}"
    );
    let listed = done(["laws", "lift", "--laws", &laws]).stdout;
    let fingerprint = listed.lines().find(|line| line.starts_with("fingerprint")).unwrap();
    let scene =
        scratch.write("pinned.toml", &SCENE.replace("module = \"lift\"", &format!("module = \"lift\"\n{fingerprint}")));
    done(["run", &scene, "--quiet", "--laws", &laws]);
    let scene = scratch.write("file.toml", &SCENE.replace("module = \"lift\"", "module = \"./liblift.so\""));
    done(["run", &scene, "--quiet", "--allow-module-files"]);
}

#[test]
fn laws_of_modules_are_listed() {
    let scratch = folder(
        "module-lists",
        ".kind = VESPER_VECTOR, .mode = VESPER_READS",
        ".kind = VESPER_VECTOR, .mode = VESPER_READS",
    );
    scratch.write("libbroken.so", "no library");
    let laws = scratch.0.display().to_string();
    let listed = done(["laws", "--laws", &laws]).stdout;
    assert!(listed.contains("gravity ") && listed.contains("\nmodule lift (lift.c), "), "{listed}");
    assert!(listed.contains("\n  lift  Lift of a wing, by the speed forwards.\n"), "{listed}");
    assert!(listed.contains("\nno module broken: it is no library that can be loaded: "), "{listed}");
    let one = done(["laws", "lift", "--laws", &laws]).stdout;
    assert!(one.contains("reads velocity [m/s]") && one.contains("slope [kg/s], default 0.1"), "{one}");
}

#[test]
fn a_law_that_fails_does_not_stop_a_run_unless_all_have_to() {
    let scratch = folder(
        "module-fails",
        "    return 0;\n}\n\nstatic const vesper_port",
        "    return speed[call->begin] == 1 ? 5 : 0;\n}\n\nstatic const vesper_port",
    );
    let (scene, laws) = (scratch.file("scene.toml"), scratch.0.display().to_string());
    let run = vesper(["run", &scene, "--laws", &laws, "--json"]);
    assert_eq!(run.status, 3, "{}", run.stderr);
    assert_eq!(run.stderr, "error: law lift failed, and the run went on without it: `apply` returned 5\n");
    let json = run.json();
    let lift = json["laws"].as_array().unwrap().iter().find(|law| law["name"] == "lift").unwrap();
    assert_eq!((lift["status"].as_str(), lift["reason"].as_str()), (Some("failed"), Some("`apply` returned 5")));
    assert_eq!(json["domains"]["bodies"]["position"][0][0].as_f64().map(|x| (x - 1.0).abs() < 1e-12), Some(true));
    let strict = vesper(["run", &scene, "--laws", &laws, "--json", "--strict"]);
    assert_eq!(strict.status, 3, "{}", strict.stderr);
    assert!(strict.stderr.contains("lift failed and is switched off"), "{}", strict.stderr);
}

#[test]
fn a_run_of_a_sweep_whose_law_failed_has_failed() {
    let scratch = folder(
        "module-fails-sweep",
        "    return 0;\n}\n\nstatic const vesper_port",
        "    return speed[call->begin] == 1 ? 5 : 0;\n}\n\nstatic const vesper_port",
    );
    let (scene, laws, out) = (scratch.file("scene.toml"), scratch.0.display().to_string(), scratch.file("out"));
    let words = ["sweep", &scene, "--laws", &laws, "--vary", "domains.bodies.velocity.0=[[1, 0, 0], [2, 0, 0]]"];
    let more = ["--measure", "bodies.position[0].z", "--out", &out, "--quiet"];
    let told = vesper([&words[..], &more[..]].concat());
    assert!(told.status == 3 && told.stderr == "1 of 2 runs failed\n", "{} {}", told.status, told.stderr);
    let table = scratch.read("out/table.csv");
    let lines: Vec<&str> = table.lines().collect();
    assert!(lines[1].contains(",failed,") && lines[1].ends_with(",,law lift failed: `apply` returned 5"), "{table}");
    assert!(lines[2].contains(",done,") && lines[2].ends_with(','), "{table}");
    // Where all laws have to run, it is said once.
    let strict = vesper([&words[..], &["--strict", "--json"]].concat());
    let fault = strict.json()["runs"][0]["error"].as_str().unwrap().to_owned();
    assert!(strict.status == 3 && fault.matches("returned 5").count() == 1, "{fault}");
}
