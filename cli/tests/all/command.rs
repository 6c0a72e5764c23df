//! The command as a user runs it: exit status, output, files, checkpoints.

use crate::common::*;
use serde_json::json;

const PAIR: &str = "title = \"a, \\\"b\\\" & <c>\"\n[engine]\nstep = 0.01\nend = 1\n[domains.bodies]\nname = [\"left, first\", \"right\"]\n\
    mass = [1, 2]\nposition = [[-1, 0, 0], [1, 0, 0]]\nvelocity = [[0, 0.3, 0], [0, 0, 0.1]]\ncolour = [1, 2]\n\
    [domains.springs]\nends = { domain = \"bodies\", value = [[0, 1]] }\nstiffness = [10]\nrest_length = [1]\n\
    [[laws]]\nname = \"motion\"\n[[laws]]\nname = \"spring\"\n[[laws]]\nname = \"drag\"\n";

#[test]
fn json_is_all_there_is_on_standard_output() {
    let folder = Scratch::new("json");
    let path = folder.write("pair.toml", PAIR);
    let value = done(["run", &path, "--json"]).json();
    check_schema(&value);
    assert_eq!((&value["time"], &value["steps"], &value["evaluations"]), (&json!(1.0), &json!(100), &json!(101)));
    assert_eq!(value["unused"], json!(["bodies.colour"]));
    let statuses: Vec<_> =
        value["laws"].as_array().unwrap().iter().map(|law| law["status"].as_str().unwrap()).collect();
    assert_eq!(statuses, ["active", "active", "dormant"]);
    assert!(value["laws"][2]["reason"].as_str().unwrap().contains("drag_coefficient"));
    assert_eq!(value["invariants"]["energy"]["first"], json!(5.055), "5 of the spring, 0.045 + 0.01 of the motion");
    assert_eq!(value["invariants"]["momentum"]["first"], json!([0.0, 0.3, 0.2]));
    assert!(value["invariants"]["energy"]["max_relative_drift"].as_f64().unwrap() < 1e-3);
    // Every number reads back to the same bits, which the library's own run has too.
    let scene = vesper_cli::scene::Scene::from_text("a", PAIR, std::path::Path::new(""), &[]).unwrap();
    let mut engine = vesper_cli::assemble::engine::<f64>(&scene).unwrap();
    engine.steps_of(100, 0.01).unwrap();
    for property in ["position", "velocity"] {
        let column = engine.state().column("bodies", property).unwrap().components().unwrap();
        for row in 0..2 {
            for axis in 0..3 {
                let told = value["domains"]["bodies"][property][row][axis].as_f64().unwrap();
                assert_eq!(told.to_bits(), column[axis][row].to_bits(), "{property}");
            }
        }
    }
    assert_eq!(done(["run", &path, "--quiet"]).stdout, "");
    let said = done(["run", &path]).stdout;
    for word in [
        "100 steps of leapfrog",
        "drag is dormant: it reads drag_coefficient",
        "bodies.colour is unused",
        "angular momentum",
    ] {
        assert!(said.contains(word), "{word}: {said}");
    }
}

#[test]
fn damping_without_a_damper_is_told() {
    let folder = Scratch::new("damping");
    let damped = PAIR.replace("stiffness = [10]", "stiffness = [10]\ndamping = [1]");
    let path = folder.write("pair.toml", &damped);
    assert_eq!(done(["run", &path, "--json"]).json()["unused"], json!(["bodies.colour", "springs.damping"]));
    for told in [done(["run", &path]), done(["explain", &path])] {
        assert!(told.stdout.contains("springs.damping is unused: no running law touches it"), "{}", told.stdout);
    }
    let path = folder.write("pair.toml", &(damped + "[[laws]]\nname = \"damper\"\n"));
    let value = done(["run", &path, "--json"]).json();
    assert_eq!(value["unused"], json!(["bodies.colour"]));
    assert_eq!(value["evaluations"], json!(201), "leapfrog evaluates a force of velocities twice");
    let energy = &value["invariants"]["energy"];
    assert!(energy["last"].as_f64().unwrap() < 0.9 * energy["first"].as_f64().unwrap(), "{energy}");
}

#[test]
fn a_strict_run_wants_every_law() {
    let folder = Scratch::new("strict");
    let path = folder.write("pair.toml", PAIR);
    for word in ["run", "explain"] {
        assert_eq!(vesper([word, &path]).status, 0);
        let strict = vesper([word, &path, "--strict"]);
        assert!(strict.status == 2 && strict.stderr.contains("drag must run, but is dormant"), "{}", strict.stderr);
    }
}

#[test]
fn observed_columns_and_subsets() {
    let folder = Scratch::new("observe");
    let text = PAIR.replace("end = 1", "end = 1\nobserve = [\"bodies.force\", \"bodies.charge\", \"springs.ends\"]");
    let path = folder.write("pair.toml", &text.replace("colour = [1, 2]", "charge = { rows = [1], value = [5] }"));
    let value = done(["run", &path, "--json", "--end", "0.05"]).json();
    let bodies = &value["domains"]["bodies"];
    assert!(bodies["position"].is_null() && bodies["force"][0][0].as_f64().unwrap() > 9.0, "{bodies}");
    assert_eq!(bodies["charge"], json!({ "rows": [1], "value": [5.0] }));
    assert_eq!(value["domains"]["springs"]["ends"], json!([[0, 1]]));
}

#[test]
fn exit_status_2_and_nothing_run_or_written() {
    let folder = Scratch::new("wrong");
    let path = folder.write("pair.toml", &PAIR.replace("spring\"", "sprng\""));
    let out = folder.file("out");
    let wrong = vesper(["run", &path, "--out", &out, "--json", "--set", "engine.stp=1"]);
    assert_eq!((wrong.status, wrong.stdout.as_str()), (2, ""));
    assert!(
        wrong.stderr.contains("pair.toml:18:8") && wrong.stderr.contains("did you mean `spring`?"),
        "{}",
        wrong.stderr
    );
    assert!(wrong.stderr.contains("--set engine.stp=1") && wrong.stderr.contains("2 mistakes; nothing was run"));
    assert!(!folder.0.join("out").exists());
    let right = folder.write("right.toml", PAIR);
    let garbage = folder.write("garbage.json", "{\"vesper_checkpoint\": 1}");
    for arguments in [
        vec!["run", "no-such-scene.toml"],
        vec!["run", &right, "--step", "nan"],
        vec!["run", &right, "--step=-1"],
        vec!["run", &right, "--end", "inf"],
        vec!["run", &right, "--integrator", "magic \" wand"],
        vec!["run", &right, "--threads", "0"],
        #[cfg(not(feature = "gpu"))]
        vec!["run", &right, "--backend", "gpu"],
        vec!["run", &right, "--precision", "f16"],
        vec!["run", &right, "--every", "5"],
        vec!["run", &right, "--out", &out, "--every", "0"],
        vec!["run", &right, "--resume", "no-such-file.json"],
        vec!["run", &right, "--resume", &garbage],
        vec!["run", &right, "--out", &right],
        vec!["explain", &path],
        vec!["laws", "gravty"],
        vec!["fly"],
        vec![],
    ] {
        let wrong = vesper(&arguments);
        assert_eq!(wrong.status, 2, "{arguments:?}: {}", wrong.stderr);
        assert!(wrong.stdout.is_empty() && !wrong.stderr.is_empty(), "{arguments:?}");
        assert!(!wrong.stderr.contains("panicked"), "{arguments:?}: {}", wrong.stderr);
    }
    assert!(!folder.0.join("out").exists());
}

#[test]
fn a_wrong_option_is_named_as_it_was_written() {
    let folder = Scratch::new("options");
    let path = folder.write("pair.toml", PAIR);
    for (option, value, expected) in [
        ("--step", "nan", "expected a number, found nan"),
        ("--step", "fast", "expected a number, found `fast`"),
        ("--step", "1e-300", "1 s in steps of 1e-300 s are too many to count"),
        ("--end", "-1", "expected a time not below 0, found -1"),
        ("--threads", "0", "expected a whole number, 1 or more, found 0"),
        ("--threads", "2.5", "expected a whole number, 1 or more, found 2.5"),
        ("--precision", "f16", "expected \"f32\" or \"f64\" or \"double-double\", found \"f16\""),
        ("--backend", "paralel", "did you mean `parallel`?"),
        ("--integrator", "leapfog", "no integrator is named `leapfog`"),
        ("--every", "0", "expected a whole number, 1 or more, found 0"),
        ("--every", "x", "expected a whole number, 1 or more, found x"),
    ] {
        let wrong = vesper(["run", &path, option, value, "--out", &folder.file("out")]);
        assert_eq!(wrong.status, 2, "{option} {value}");
        for words in [&format!("--> {option} {value}\n")[..], expected, "1 mistake; nothing was run\n"] {
            assert!(wrong.stderr.contains(words), "{option} {value} lacks {words}: {}", wrong.stderr);
        }
        assert!(!wrong.stderr.contains("--set"), "{}", wrong.stderr);
    }
}

#[test]
fn exit_status_3_with_the_state_up_to_then() {
    let folder = Scratch::new("broken");
    // A spring so stiff that the step makes it explode.
    let path = folder
        .write("pair.toml", &PAIR.replace("stiffness = [10]", "stiffness = [1e9]").replace("end = 1", "end = 100"));
    let out = folder.file("out");
    let broken = vesper(["run", &path, "--json", "--out", &out]);
    assert_eq!(broken.status, 3, "{}", broken.stderr);
    assert!(
        broken.stderr.contains("is NaN; motion moves it")
            && broken.stderr.contains(&format!("written to {out}: bodies.csv, trajectories.svg, summary.json\n")),
        "{}",
        broken.stderr
    );
    let value = broken.json();
    check_schema(&value);
    assert!(value["error"].as_str().unwrap().contains("bodies."), "{}", value["error"]);
    let (time, steps) = (value["time"].as_f64().unwrap(), value["steps"].as_u64().unwrap());
    assert!(time < 100.0 && steps > 1 && (time - 0.01 * steps as f64).abs() < 1e-9);
    assert!(value["domains"]["bodies"]["velocity"].to_string().contains("null"), "{value}");
    let table = folder.read("out/bodies.csv");
    assert!(table.lines().last().unwrap().starts_with(&format!("{time:?},1,")), "{table}");
    assert_eq!(serde_json::from_str::<serde_json::Value>(&folder.read("out/summary.json")).unwrap()["steps"], steps);
    assert!(!folder.0.join("out/checkpoint.json").exists(), "there is nothing to go on from");
}

#[test]
fn a_run_that_fails_late_leaves_a_checkpoint_from_before() {
    let folder = Scratch::new("late");
    // A little stiffer than the step can follow: it takes about 1000 steps to grow beyond all numbers.
    let path = folder
        .write("pair.toml", &PAIR.replace("stiffness = [10]", "stiffness = [30000]").replace("end = 1", "end = 100"));
    let out = folder.file("out");
    let broken = vesper(["run", &path, "--out", &out, "--quiet"]);
    assert_eq!(broken.status, 3, "{}", broken.stderr);
    let half = folder.file("out/checkpoint.json");
    let state: serde_json::Value = serde_json::from_str(&folder.read("out/checkpoint.json")).unwrap();
    let failed: serde_json::Value = serde_json::from_str(&folder.read("out/summary.json")).unwrap();
    let (kept, last) = (state["steps"].as_u64().unwrap(), failed["steps"].as_u64().unwrap());
    assert!(0 < kept && kept < last && last - kept <= 80, "{kept} {last}");
    assert!(broken.stderr.contains(&format!("step {kept}, with --resume {half}\n")), "{}", broken.stderr);
    done([
        "run",
        &path,
        "--resume",
        &half,
        "--step",
        "0.001",
        "--end",
        &(0.01 * kept as f64 + 0.1).to_string(),
        "--quiet",
    ]);
}

#[cfg(target_os = "linux")]
#[test]
fn files_that_cannot_be_written_are_not_said_to_be() {
    let all = ["bodies.csv", "trajectories.svg", "summary.json", "checkpoint.json"];
    for (index, lost) in all.iter().enumerate() {
        let folder = Scratch::new(&format!("lost-{index}"));
        let path = folder.write("pair.toml", PAIR);
        std::fs::create_dir(folder.0.join("out")).unwrap();
        std::os::unix::fs::symlink("/dev/full", folder.0.join("out").join(lost)).unwrap();
        let out = folder.file("out");
        let failed = vesper(["run", &path, "--out", &out]);
        assert_eq!(failed.status, 3, "{lost}");
        let written: Vec<&str> = all.into_iter().filter(|file| file != lost).collect();
        for words in [format!("cannot write `{out}/{lost}`"), format!("written to {out}: {}\n", written.join(", "))] {
            assert!(failed.stderr.contains(&words), "{lost} lacks {words}: {}", failed.stderr);
        }
        assert!(!failed.stdout.contains("written"), "{}", failed.stdout);
    }
}

#[test]
fn changes_of_the_scene() {
    let folder = Scratch::new("set");
    let path = folder.write("pair.toml", PAIR);
    let run = |more: &[&str]| done([&["run", &path, "--json"], more].concat()).json();
    assert_eq!(run(&["--end", "0.5"])["steps"], 50);
    assert_eq!(run(&["--end", "0.5", "--step", "0.1"])["steps"], 5);
    assert_eq!(run(&["--set", "engine.step=0.1"])["steps"], 10);
    assert_eq!(run(&["--integrator", "runge_kutta_4"])["evaluations"], 400);
    assert_eq!(run(&["--end", "0"])["steps"], 0);
    assert_eq!(run(&["--set", "domains.springs.stiffness.0=0"])["domains"]["bodies"]["position"][0][0], -1.0);
    let single = run(&["--precision", "f32", "--threads", "2", "--backend", "parallel"]);
    let x = single["domains"]["bodies"]["position"][0][0].as_f64().unwrap();
    assert_eq!(f64::from(x as f32), x, "an f32 is told exactly");
    assert_ne!(run(&[])["domains"]["bodies"]["position"][0][0], x);
    // An option is in seconds, whatever unit the scene has.
    let text = PAIR.replace("end = 1", "end = { value = 1, unit = \"min\" }");
    let minutes = folder.write("minutes.toml", &text);
    assert_eq!(done(["run", &minutes, "--json", "--end", "0.5"]).json()["steps"], 50);
    assert_eq!(done(["run", &minutes, "--json", "--set", "engine.end=0.01"]).json()["steps"], 60);
    // The end is covered exactly, by a shorter last step.
    let odd = run(&["--end", "0.123"]);
    assert_eq!((&odd["time"], &odd["steps"]), (&json!(0.123), &json!(13)));
    // Leapfrog does not bear it, and that is told.
    let long = vesper(["run", &path, "--step", "100", "--end", "3"]);
    assert!(long.stderr.starts_with("warning: ") && long.stderr.contains("the step is 3 s"), "{}", long.stderr);
    assert!(!long.stderr.trim_end().contains('\n') && long.status == 0, "{}", long.stderr);
    let long = long.stdout;
    assert!(long.contains("in 1 step of") && long.contains("the last step is 3 s, not 100 s"), "{long}");
    assert!(!done(["run", &path]).stdout.contains("the last step"));
}

#[test]
fn a_folder_of_results() {
    let folder = Scratch::new("out");
    let path = folder.write(
        "pair.toml",
        &PAIR.replace("[domains.springs]", "[domains.\"/springs\"]").replace("end = 1", "end = 1\nframe = 0.1"),
    );
    let out = folder.file("deep/out");
    done([
        "run",
        &path,
        "--out",
        &out,
        "--every",
        "4",
        "--set",
        "engine.observe=[\"bodies.position\", \"/springs.stiffness\"]",
    ]);
    let table = folder.read("deep/out/bodies.csv");
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines[0], "time,row,label,position_x,position_y,position_z");
    assert_eq!(lines[1], "0.0,0,\"left, first\",-1.0,0.0,0.0");
    // The first frame, every fourth, and the last.
    let times: Vec<&str> = lines[1..].iter().step_by(2).map(|line| line.split(',').next().unwrap()).collect();
    assert_eq!(times, ["0.0", "0.4", "0.8", "1.0"]);
    assert!(folder.read("deep/out/_springs.csv").starts_with("time,row,label,stiffness\n0.0,0,,10.0\n"));
    let picture = folder.read("deep/out/trajectories.svg");
    assert!(
        picture.contains("a, &quot;b&quot; &amp; &lt;c&gt;")
            && picture.contains("left, first")
            && picture.contains("[m]")
    );
    assert!(picture.contains("link at the end") && picture.ends_with("</svg>\n") && !picture.contains("NaN"));
    check_schema(&serde_json::from_str(&folder.read("deep/out/summary.json")).unwrap());
    // Without --every all ten frames are few enough.
    done(["run", &path, "--out", &out]);
    assert_eq!(folder.read("deep/out/bodies.csv").lines().count(), 1 + 2 * 11);
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_is_written_and_goes_on() {
    use std::process::{Command, Stdio};
    let folder = Scratch::new("interrupt");
    let path = folder.write("pair.toml", &PAIR.replace("end = 1", "end = 1e6\nframe = 0.1"));
    let out = folder.file("out");
    let mut command = Command::new(env!("CARGO_BIN_EXE_vesper"));
    command.args(["run", &path, "--out", &out, "--every", "1000"]).stdout(Stdio::piped()).stderr(Stdio::piped());
    let run = command.spawn().unwrap();
    // It runs once it has begun its table.
    while !folder.0.join("out/bodies.csv").exists() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert!(Command::new("kill").args(["-INT", &run.id().to_string()]).status().unwrap().success());
    let ended = run.wait_with_output().unwrap();
    let (said, complained) = (String::from_utf8(ended.stdout).unwrap(), String::from_utf8(ended.stderr).unwrap());
    assert_eq!(ended.status.code(), Some(130), "{complained}");
    assert!(complained.contains(&format!("--resume {out}/checkpoint.json")), "{complained}");
    assert!(said.contains("steps of leapfrog"), "{said}");
    let summary: serde_json::Value = serde_json::from_str(&folder.read("out/summary.json")).unwrap();
    check_schema(&summary);
    assert_eq!(summary["error"], "interrupted");
    let time = summary["time"].as_f64().unwrap();
    assert!(time < 1e6);
    assert!(folder.read("out/bodies.csv").lines().last().unwrap().starts_with(&format!("{time:?},1,")));
    // Where it goes on to, it comes to the same bits as a run in one.
    let (end, half) = ((time + 1.0).to_string(), folder.file("out/checkpoint.json"));
    let json =
        |more: &[&str]| done([&["run", &path, "--json", "--end", &end], more].concat()).json()["domains"].clone();
    assert_eq!(json(&["--resume", &half]), json(&[]));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told_and_a_reader_that_went_away_is_not() {
    use std::process::{Command, Stdio};
    let folder = Scratch::new("full");
    let path = folder.write("pair.toml", PAIR);
    for arguments in [
        &["run", &path][..],
        &["run", &path, "--json"],
        &["explain", &path],
        &["laws"],
        &["laws", "gravity"],
        &["--help"],
    ] {
        let vesper = || Command::new(env!("CARGO_BIN_EXE_vesper"));
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let full = vesper().args(arguments).stdout(full).output().unwrap();
        let said = String::from_utf8(full.stderr).unwrap();
        assert!(
            full.status.code() == Some(3) && said.contains("cannot write to standard output"),
            "{arguments:?} {said}"
        );
        let mut gone = vesper().args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(gone.stdout.take());
        let gone = gone.wait_with_output().unwrap();
        assert!(gone.status.success() && gone.stderr.is_empty(), "{arguments:?}");
    }
}

#[test]
fn a_picture_has_more_moments_than_its_table_and_a_title_of_what_was_run() {
    let folder = Scratch::new("picture");
    let path = folder.write("pair.toml", PAIR);
    let draw = |more: &[&str]| {
        done([&["run", &path, "--quiet", "--out", &folder.file("out"), "--every", "50"], more].concat());
        folder.read("out/trajectories.svg")
    };
    let whole = draw(&[]);
    assert_eq!(folder.read("out/bodies.csv").lines().count(), 1 + 2 * 3);
    let points = whole.lines().filter(|line| line.starts_with("<path d=\"M") && line.contains("stroke-linejoin"));
    let points: Vec<usize> = points.map(|line| line.matches('L').count()).collect();
    assert!(points.len() == 2 && points.iter().all(|points| *points > 60), "{points:?}");
    assert!(!whole.contains("run to"), "{whole}");
    let part = draw(&["--end", "0.5"]);
    assert!(part.contains("&lt;c&gt; (run to 0.5 s)</text>"), "{part}");
}

/// Runs to `end` at once, and to `middle` and on from there: the same bits.
fn resumes(name: &str, scene: &str, middle: &str, end: &str, more: &[&str]) {
    let folder = Scratch::new(name);
    let path = folder.write("a.toml", scene);
    let run = |end: &str, out: &str, more: &[&str]| {
        let out = folder.file(out);
        done([&["run", &path, "--end", end, "--out", &out, "--quiet"], more].concat());
    };
    run(end, "whole", more);
    run(middle, "half", more);
    let half = folder.file("half/checkpoint.json");
    run(end, "rest", &[more, &["--resume", &half]].concat());
    assert_ne!(folder.read("half/checkpoint.json"), folder.read("whole/checkpoint.json"));
    assert_eq!(folder.read("rest/checkpoint.json"), folder.read("whole/checkpoint.json"), "{name}");
    let last = |table: String| table.lines().last().unwrap().to_owned();
    assert_eq!(last(folder.read("rest/bodies.csv")), last(folder.read("whole/bodies.csv")), "{name}");
    let of = |name: &str| serde_json::from_str::<serde_json::Value>(&folder.read(name)).unwrap();
    assert_eq!(of("rest/summary.json")["domains"], of("whole/summary.json")["domains"]);
}

#[test]
fn a_resumed_run_has_the_same_bits() {
    resumes("leapfrog", PAIR, "0.37", "1", &[]);
    resumes("rk4", PAIR, "0.37", "1", &["--integrator", "runge_kutta_4"]);
    resumes("euler-f32", PAIR, "0.37", "1", &["--integrator", "semi_implicit_euler", "--precision", "f32"]);
    // Ends that no step has: the shorter last step is not gone on from.
    resumes("odd", PAIR, "0.3777", "1.0001", &[]);
    // A law that is held between steps, a start that is not 0, frames of another length than the steps.
    let held = PAIR.replace("name = \"spring\"", "name = \"spring\"\nevery = 4") + "[constants]\ntime = -2\n";
    resumes("held", &held, "0.33", "1", &["--set", "engine.frame=0.07", "--integrator", "semi_implicit_euler"]);
}

#[test]
fn a_checkpoint_of_another_scene_is_refused() {
    let folder = Scratch::new("other");
    let path = folder.write("a.toml", PAIR);
    done(["run", &path, "--end", "0.1", "--out", &folder.file("out"), "--quiet"]);
    let half = folder.file("out/checkpoint.json");
    for more in [["--precision", "f32"], ["--integrator", "runge_kutta_4"]] {
        let refused = vesper([&["run", &path, "--resume", &half], &more[..]].concat());
        assert!(refused.status == 2 && refused.stderr.contains("the checkpoint does not fit"), "{}", refused.stderr);
    }
    // At its end already: nothing to do is no fault.
    let value = done(["run", &path, "--end", "0.1", "--resume", &half, "--json"]).json();
    assert_eq!((&value["steps"], &value["time"]), (&json!(10), &json!(0.1)));
    let past = vesper(["run", &path, "--end", "0.05", "--resume", &half]);
    assert!(past.status == 2 && past.stderr.contains("at 0.1 s, is already past the end, 0.05 s"), "{}", past.stderr);
}

#[test]
fn the_help_tells_what_is_written_and_offers_what_there_is() {
    let help = done(["run", "--help"]).stdout;
    for words in ["for each domain that shows columns", "overwritten", "velocities in m/s", "auto|cpu|parallel"] {
        assert!(help.contains(words), "{words}: {help}");
    }
    assert_eq!(help.contains("gpu"), cfg!(feature = "gpu"), "{help}");
}

#[test]
fn the_laws_are_told() {
    let list = done(["laws"]).stdout;
    let names: Vec<&str> = list.lines().map(|line| line.split(' ').next().unwrap()).collect();
    assert!(names.len() >= 16 && names.is_sorted(), "{list}");
    for name in names {
        let told = done(["laws", name]).stdout;
        assert!(told.starts_with(&format!("{name}\n")), "{told}");
        for word in ["Equation: ", "Source: ", "Limits: ", "\ntouches\n", "parameters"] {
            assert!(told.contains(word), "{name} lacks {word}: {told}");
        }
    }
    let gravity = done(["laws", "gravity"]).stdout;
    for line in [
        "  reads mass [kg]\n",
        "  adds  force [N]\n",
        "  g [m^3 kg^-1 s^-2], default 6.6743e-11: ",
        "  softening [m], default 0: ",
    ] {
        assert!(gravity.contains(line), "{gravity}");
    }
    assert!(done(["laws", "drag"]).stdout.contains("  reads wind_velocity [m/s], optional\n"));
    assert!(
        done(["laws", "post_newtonian"])
            .stdout
            .contains("  reads speed_of_light [m/s] of the scene, default 299792458\n")
    );
}
