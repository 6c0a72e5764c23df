//! `vesper sweep`: the same table in shards as in one, folders that go on and that refuse, words for what is wrong.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use crate::common::{Done, Scratch, done, vesper};

pub const SPRING: &str = r#"title = "two masses on a spring"
[engine]
step = 0.01
end = 2.0
[domains.bodies]
name = ["left", "right"]
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

/// `vesper sweep` with these words, split at blanks.
pub fn sweep(words: &str, more: &[&str]) -> Done {
    vesper(["sweep"].into_iter().chain(words.split_whitespace()).chain(more.iter().copied()))
}

/// The same, which must be done without a word of complaint.
pub fn swept(words: &str, more: &[&str]) -> String {
    done(["sweep"].into_iter().chain(words.split_whitespace()).chain(more.iter().copied())).stdout
}

/// Every file of a folder, but for the time that a run took, which the clock decides.
fn contents(folder: &Path) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(contents(&path));
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let lines = text.lines().filter(|line| !line.contains("wall_seconds"));
        found.insert(path.file_name().unwrap().to_string_lossy().into_owned(), lines.collect::<Vec<_>>().join("\n"));
    }
    found
}

/// The table, without its head.
pub fn rows(folder: &Scratch, name: &str) -> Vec<Vec<String>> {
    folder.read(name).lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

const MANY: &str = "--vary domains.springs.stiffness.0=1:100:16:log --vary engine.step=0.005:0.02:4 \
                    --measure bodies.position[left].x --measure bodies.velocity[max].length";

#[test]
fn a_sweep_of_64_runs_in_4_shards_gives_the_same_table_as_in_one() {
    let folder = Scratch::new("sweep-shards");
    let scene = folder.write("spring.toml", SPRING);
    let [whole, parts] = ["whole", "parts"].map(|name| folder.file(name));
    let told = swept(MANY, &[&scene, "--out", &whole, "--jobs", "1"]);
    assert!(told.contains(&format!("written to {whole}: table.csv, sweep.svg")), "{told}");
    assert_eq!(told.lines().filter(|line| line.contains("0.02 ")).count(), 16, "{told}");
    // In whatever order, and on whatever number of threads.
    for (shard, missing) in [("3/4", "1-2, 4-6, 8-10"), ("1/4", "2, 4, 6, 8"), ("4/4", "2, 6, 10")] {
        let told = swept(MANY, &[&scene, "--out", &parts, "--shard", shard, "--jobs", "2"]);
        assert!(told.contains(&format!("not there, or not yet: {missing}")) && told.contains("--shard 2/4"), "{told}");
        assert!(!folder.0.join("parts/table.csv").exists());
    }
    swept(MANY, &[&scene, "--out", &parts, "--shard", "2/4", "--threads", "2"]);
    assert_eq!(rows(&folder, "whole/table.csv").len(), 64);
    assert_eq!(folder.read("parts/table.csv"), folder.read("whole/table.csv"));
    assert_eq!(contents(&folder.0.join("parts")), contents(&folder.0.join("whole")));
    let drawn = folder.read("whole/sweep.svg");
    assert!(drawn.starts_with("<svg") && drawn.trim_end().ends_with("</svg>") && !drawn.contains("NaN"));
    // Two maps of 64 cells, and their bars of 40 colours.
    assert_eq!(drawn.matches("stroke-width=\"0.3\"").count(), 128);
    // Each is the run that `vesper run` makes.
    let row = &rows(&folder, "whole/table.csv")[41];
    let (stiffness, step) = (format!("domains.springs.stiffness.0={}", row[1]), format!("engine.step={}", row[2]));
    let run = done(["run", &scene, "--set", &stiffness, "--set", &step, "--json"]).json();
    let number = |text: &String| text.parse::<f64>().unwrap();
    assert_eq!((row[0].as_str(), row[3].as_str()), ("42", "done"));
    assert_eq!(Some(number(&row[4])), run["time"].as_f64());
    assert_eq!(Some(number(&row[5]) as u64), run["steps"].as_u64());
    assert_eq!(Some(number(&row[6]) as u64), run["evaluations"].as_u64());
    for (column, name) in [(7, "energy"), (8, "momentum"), (9, "angular_momentum")] {
        assert_eq!(Some(number(&row[column])), run["invariants"][name]["max_relative_drift"].as_f64(), "{name}");
    }
    assert_eq!(Some(number(&row[10])), run["domains"]["bodies"]["position"][0][0].as_f64());
    let speed = |row: usize| {
        let velocity = &run["domains"]["bodies"]["velocity"][row];
        (0..3).map(|axis| velocity[axis].as_f64().unwrap().powi(2)).sum::<f64>().sqrt()
    };
    assert_eq!(number(&row[11]), speed(0).max(speed(1)));
}

#[test]
fn what_is_done_is_not_run_again_and_what_is_lost_or_broken_is() {
    let folder = Scratch::new("sweep-resume");
    let scene = folder.write("spring.toml", SPRING);
    let out = folder.file("out");
    let words = "--vary engine.step=0.005:0.02:8";
    swept(words, &[&scene, "--out", &out]);
    let table = folder.read("out/table.csv");
    let file = |run: usize| format!("out/runs/{run:06}.json");
    // A mark in a record shows whether its run was made again.
    let marked = folder.read(&file(1)).replace("\"wall_seconds\": ", "\"wall_seconds\": 77");
    folder.write(&file(1), &marked);
    std::fs::remove_file(folder.0.join(file(3))).unwrap();
    let half = folder.read(&file(5));
    folder.write(&file(5), &half[..half.len() / 2]);
    std::fs::copy(folder.0.join(file(6)), folder.0.join(file(7))).unwrap();
    std::fs::remove_file(folder.0.join("out/table.csv")).unwrap();
    // Left by a machine that went off.
    folder.write("out/.runs-000003.json.1.1.part", "{");
    let lacking = sweep("--collect", &["--out", &out]);
    assert!(lacking.status == 3 && lacking.stderr.contains("5 of 8 runs are in"), "{}", lacking.stderr);
    assert!(lacking.stderr.contains("not there, or not yet: 3, 5, 7\n"), "{}", lacking.stderr);
    swept(words, &[&scene, "--out", &out, "--json"]);
    assert_eq!(folder.read("out/table.csv"), table);
    assert_eq!(folder.read(&file(1)), marked);
    assert_ne!(folder.read(&file(7)), folder.read(&file(6)));
    // All there: nothing is run, by a folder alone nor with its scene.
    std::fs::remove_file(folder.0.join("out/table.csv")).unwrap();
    swept("--collect", &["--out", &out]);
    assert_eq!(folder.read("out/table.csv"), table);
    let told = swept(words, &[&scene, "--out", &out, "--collect"]);
    assert!(told.contains("two masses on a spring"), "{told}");
}

#[test]
fn a_folder_of_another_sweep_is_refused_and_left_as_it_is() {
    let folder = Scratch::new("sweep-other");
    let scene = folder.write("spring.toml", SPRING);
    let other = folder.write("other.toml", &SPRING.replace("rest_length = [1.5]", "rest_length = [1.4]"));
    let out = folder.file("out");
    let words = "--vary engine.step=[0.01,0.02]";
    swept(words, &[&scene, "--out", &out]);
    let before = contents(&folder.0.join("out"));
    let refused = |words: &str, more: &[&str], expected: &str| {
        let refused = sweep(words, &[more, &["--out", &out]].concat());
        assert_eq!(refused.status, 2);
        assert!(refused.stderr.contains("the folder is of another sweep; "), "{}", refused.stderr);
        assert!(refused.stderr.contains(expected), "{expected}: {}", refused.stderr);
        assert_eq!(contents(&folder.0.join("out")), before);
    };
    let line = "line 13 of the scene: in the folder `rest_length = [1.5]`, now `rest_length = [1.4]`";
    refused(words, &[&other], line);
    refused(words, &[&other, "--collect"], line);
    refused(words, &[&scene, "--end", "3"], "changes of the scene: in the folder nothing, now `--end 3`");
    let more = "what varies: in the folder `engine.step=[0.01, 0.02]`, now `engine.step=[0.01, 0.02, 0.03]`";
    refused("--vary engine.step=[0.01,0.02,0.03]", &[&scene], more);
    refused(words, &[&scene, "--measure", "bodies.mass[0]"], "what is measured: in the folder nothing, now");
    // The number of threads is nobody's business, and the name of the scene's file is not.
    let same = folder.write("same.toml", SPRING);
    swept(words, &[&same, "--threads", "2", "--out", &out]);
    // A folder of something else.
    folder.write("out/manifest.json", "{}");
    let refused = sweep(words, &[&scene, "--out", &out]);
    assert!(refused.status == 2 && refused.stderr.contains("is not the manifest of a sweep"), "{}", refused.stderr);
}

#[test]
fn a_run_that_fails_stops_no_other() {
    let folder = Scratch::new("sweep-fails");
    let scene = folder.write("spring.toml", &SPRING.replace("end = 2.0", "end = 20.0"));
    let out = folder.file("out");
    // The second is too stiff for its step; `nystrom_12` bears no forces of velocities, which only that law has.
    let words = "--vary domains.springs.stiffness.0=[10,60000,20] --measure bodies.position[0].x";
    let failed = sweep(words, &[&scene, "--out", &out]);
    assert!(failed.status == 3 && failed.stderr == "1 of 3 runs failed\n", "{}", failed.stderr);
    let table = rows(&folder, "out/table.csv");
    let statuses: Vec<&str> = table.iter().map(|row| row[2].as_str()).collect();
    assert_eq!(statuses, ["done", "failed", "done"]);
    assert!(table[1][9].is_empty() && !table[1][10].is_empty() && !table[0][9].is_empty(), "{table:?}");
    assert!(failed.stdout.contains("  failed: ") && failed.stdout.contains("bodies."), "{}", failed.stdout);
    let record: Value = serde_json::from_str(&folder.read("out/runs/000002.json")).unwrap();
    assert_eq!((&record["status"], &record["invariants"]), (&Value::from("failed"), &Value::Null));
    assert!(record["error"].as_str().unwrap().contains("bodies.") && record["steps"].as_u64() > Some(10), "{record}");
    assert!(folder.read("out/sweep.svg").contains("3 runs, 1 failed (crosses)"));
    // It is done with, unless one asks for it.
    let marked = folder.read("out/runs/000002.json").replace("\"steps\": ", "\"steps\": 9");
    folder.write("out/runs/000002.json", &marked);
    assert_eq!(sweep(words, &[&scene, "--out", &out]).status, 3);
    assert_eq!(folder.read("out/runs/000002.json"), marked);
    assert_eq!(sweep(words, &[&scene, "--out", &out, "--retry"]).status, 3);
    assert_ne!(folder.read("out/runs/000002.json"), marked);
    assert_eq!(rows(&folder, "out/table.csv"), table);
    // One that cannot begin is one that fails; none that can is a mistake of the scene.
    let damped =
        SPRING.replace("stiffness = [30.0]", "stiffness = [30.0]\ndamping = [1.0]") + "[[laws]]\nname = \"damper\"\n";
    let scene = folder.write("damped.toml", &damped);
    let some = sweep("--vary engine.integrator=[nystrom_12,leapfrog]", &[&scene, "--json"]);
    let told = some.json();
    assert_eq!(some.status, 3);
    assert_eq!((&told["runs"][0]["status"], &told["runs"][1]["status"]), (&"failed".into(), &"done".into()));
    assert!(told["runs"][0]["error"].as_str().unwrap().contains("nystrom_12"), "{told}");
    let none = sweep("--vary engine.step=[0.1,0.2] --integrator nystrom_12", &[&scene, "--out", &folder.file("no")]);
    assert!(none.status == 2 && none.stderr.contains("nystrom_12"), "{}", none.stderr);
    assert!(!folder.0.join("no").exists());
}

#[test]
fn wrong_words_are_told_all_at_once_and_nothing_is_written() {
    let folder = Scratch::new("sweep-wrong");
    let scene = folder.write("spring.toml", SPRING);
    let out = folder.file("out");
    let wrong = |words: &str, expected: &[&str]| {
        let told = sweep(words, &[&scene, "--out", &out]);
        assert_eq!(told.status, 2, "{words}");
        for text in expected {
            assert!(told.stderr.contains(text), "{words}: {text} is not in\n{}", told.stderr);
        }
        assert!(!folder.0.join("out").exists(), "{words}");
    };
    wrong("", &["--vary <PATH=VALUES>"]);
    wrong("--vary engine.step=1:2", &["expected FIRST:LAST:COUNT", "engine.step=1:2", "            ^^^"]);
    wrong(
        "--vary domains.springs.stifness.0=1:2:3",
        &["the scene has no `stifness` in `springs`", "did you mean `stiffness`?", "1 mistake; nothing was run"],
    );
    wrong(
        "--vary engine.integrator=[leapfrog,runge_kuta_4,leepfrog] --vary engine.step=[0.1,-1]",
        &[
            "no integrator is named `runge_kuta_4`",
            "did you mean `runge_kutta_4`?",
            "no integrator is named `leepfrog`",
            "--vary engine.step",
            "engine.step=-1",
            "3 mistakes",
        ],
    );
    wrong("--vary engine.step=[1,2] --shard 5/4", &["there is no shard 5 of 4", "shards count from 1 to 4"]);
    wrong("--vary engine.step=[1,2] --shard 0/4", &["shards count from 1", "--array=1-4"]);
    wrong("--vary engine.step=[1,2] --shard 1/0 --jobs 0", &["expected at least 1 shard", "from 1 to 1024, found `0`"]);
    wrong(
        "--vary engine.step=1:2:1000 --vary engine.end=1:2:1000",
        &["1000 x 1000 runs are too many: at most 100000 share a folder"],
    );
    let endless = ["step", "end", "frame", "threads"].map(|key| format!("--vary engine.{key}=1:2:100000 ")).concat();
    wrong(&endless, &["100000 x 100000 x 100000 x 100000 runs are too many", "1 mistake;"]);
    wrong("--vary engine.step=1:-1:100000", &["engine.step=-1\n", "1 mistake;"]);
    wrong("--vary engine.step=[1,2] --vary engine.step=[3,4]", &["the path is varied twice"]);
    wrong("--vary engine.step=[1,2] --step 3", &["--step", "`engine.step` is varied: it cannot also be set"]);
    wrong(
        "--vary engine.step=[0.1,0.2] --measure bodys.position[0].x --measure bodies.positon[0].x",
        &["the scene has no domain `bodys`", "did you mean `bodies`?", "`bodies` has no `positon`", "`position`?"],
    );
    wrong(
        "--vary engine.step=[0.1,0.2] --measure bodies.position[2].x --measure bodies.position[lift].x \
         --measure bodies.position[0] --measure bodies.mass[0].x --measure springs.ends[0].x",
        &[
            "`bodies` has no row 2: it has 2",
            "rows count from 0 to 1",
            "did you mean `left`?",
            "`position` is a vector, and one number of it is wanted",
            "`mass` is a scalar, and has no components",
            "`ends` names rows of a domain",
            "5 mistakes",
        ],
    );
    wrong("--vary engine.step=[0.1,0.2] --measure bodies.position", &["expected DOMAIN.PROPERTY[WHICH].COMPONENT"]);
    // A mistake of the scene itself is told once, at its line, with those of the arguments.
    let scene = folder.write("wrong.toml", &SPRING.replace("\"spring\"", "\"sprng\""));
    let told = sweep("--vary engine.stp=[1,2,3] --shard x", &[&scene, "--out", &out]).stderr;
    for text in ["wrong.toml:17:8", "did you mean `spring`?", "--vary engine.stp", "expected K/N", "3 mistakes"] {
        assert_eq!(told.matches(text).count(), 1, "{text} in {told}");
    }
    let told = sweep("--collect --vary a.b=[1,2]", &["--out", &out]);
    assert!(told.status == 2 && told.stderr.contains("without a scene the folder says"), "{}", told.stderr);
    let told = sweep("--collect", &["--out", &out]);
    assert!(told.status == 2 && told.stderr.contains("manifest.json"), "{}", told.stderr);
}

#[test]
fn words_numbers_and_vectors_vary_and_forces_can_be_measured() {
    let folder = Scratch::new("sweep-forms");
    let text = SPRING
        .replace("[engine]", "[constants]\ngravity = [0, 0, -9.81]\n[engine]")
        .replace("[[laws]]\nname = \"spring\"", "[[laws]]\nname = \"spring\"\n[[laws]]\nname = \"uniform_gravity\"");
    let (scene, out) = (folder.write("spring.toml", &text), folder.file("out"));
    let words = "--vary engine.integrator=[leapfrog,\"runge_kutta_4\"] --vary engine.step=1e-3:1e-1:3:log \
                 --measure bodies.force[1].z --measure springs.stiffness[mean]";
    let told = swept(words, &[&scene, "--out", &out, "--vary", "constants.gravity=[[0, 0, -9.81], [0, 0, -1.62]]"]);
    assert!(told.contains("bodies.force[1].z [N]"), "{told}");
    let text = folder.read("out/table.csv");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(
        lines[0],
        "run,engine.integrator,engine.step,constants.gravity,status,time,steps,evaluations,energy_drift,momentum_drift,\
         angular_momentum_drift,bodies.force[1].z,springs.stiffness[mean],error"
    );
    assert_eq!(lines.len(), 13);
    assert!(lines[1].starts_with("1,leapfrog,0.001,\"[0, 0, -9.81]\",done,2.0,2000,2001,"), "{}", lines[1]);
    assert!(lines[12].starts_with("12,runge_kutta_4,0.1,\"[0, 0, -1.62]\",done,2.0,20,80,"), "{}", lines[12]);
    assert!(lines[11].ends_with(",-19.62,30.0,") && lines[12].ends_with(",-3.24,30.0,"), "{text}");
    let drawn = folder.read("out/sweep.svg");
    // For each integrator a panel of each measure, with lines for the two gravities: they are vectors, no numbers.
    assert!(drawn.contains("bodies.force[1].z [N], engine.integrator=leapfrog"), "{drawn}");
    assert_eq!(drawn.matches("<circle").count(), 2 * 2 * (2 * 3 + 2));
    // What lies inside of another path is set after it, in whichever order they are given.
    let words =
        "--vary engine.integrator.rtol=[1e-5,1e-9] --vary engine.integrator=[dormand_prince_5,dormand_prince_8]";
    let told: Value = serde_json::from_str(&swept(words, &[&scene, "--json"])).unwrap();
    let evaluations = |run: usize| told["runs"][run]["evaluations"].as_u64().unwrap();
    assert!(evaluations(0) < evaluations(2) && evaluations(1) < evaluations(3), "{told}");
    assert_eq!(told["runs"][1]["key"], "engine.integrator.rtol=1e-5 engine.integrator=dormand_prince_8");
    // One number that varies, and drifts where nothing is measured.
    let told = swept("--vary engine.step=0.01:0.02:3", &[&scene]);
    assert!(told.contains("momentum drift") && !told.contains("written"), "{told}");
}

#[cfg(unix)]
#[test]
fn a_sweep_that_is_interrupted_or_killed_leaves_whole_runs_and_goes_on() {
    use std::process::{Command, Stdio};
    let folder = Scratch::new("sweep-stop");
    let scene = folder.write("spring.toml", &SPRING.replace("end = 2.0", "end = 4e2"));
    let words = ["sweep", &scene, "--vary", "domains.springs.stiffness.0=1:100:40", "--jobs", "2", "--out"];
    let records = |out: &str| -> Vec<String> {
        let Ok(runs) = std::fs::read_dir(folder.0.join(out).join("runs")) else { return Vec::new() };
        runs.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect()
    };
    for (signal, out) in [("-INT", "interrupted"), ("-KILL", "killed")] {
        let path = folder.file(out);
        let mut command = Command::new(env!("CARGO_BIN_EXE_vesper"));
        let run = command.args(words).arg(&path).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        while records(out).len() < 3 {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        assert!(Command::new("kill").args([signal, &run.id().to_string()]).status().unwrap().success());
        let ended = run.wait_with_output().unwrap();
        let there = records(out);
        assert!((3..40).contains(&there.len()), "{there:?}");
        for name in &there {
            let record: Value = serde_json::from_str(&folder.read(&format!("{out}/runs/{name}"))).unwrap();
            assert_eq!((&record["status"], &record["time"]), (&"done".into(), &4e2.into()), "{name}");
        }
        if signal == "-INT" {
            assert_eq!(ended.status.code(), Some(130));
            let told = String::from_utf8(ended.stderr).unwrap();
            let expected = format!("interrupted; {} of 40 runs are done; the same command goes on\n", there.len());
            assert_eq!(told, expected);
        }
        assert!(!folder.0.join(out).join("table.csv").exists());
    }
    let finish = |out: &str| done(words.iter().copied().chain([folder.file(out).as_str(), "--quiet"]));
    assert_eq!(finish("interrupted").stdout, "");
    finish("killed");
    assert_eq!(folder.read("interrupted/table.csv"), folder.read("killed/table.csv"));
    assert_eq!(rows(&folder, "killed/table.csv").len(), 40);
}

#[cfg(target_os = "linux")]
#[test]
fn runs_that_cannot_be_kept_are_told() {
    let folder = Scratch::new("sweep-full");
    let (scene, out) = (folder.write("spring.toml", SPRING), folder.file("out"));
    swept("--vary engine.step=[0.01,0.02]", &[&scene, "--out", &out]);
    // Where no file can be put.
    std::fs::remove_dir_all(folder.0.join("out/runs")).unwrap();
    std::os::unix::fs::symlink("/proc", folder.0.join("out/runs")).unwrap();
    let told = sweep("--vary engine.step=[0.01,0.02]", &[&scene, "--out", &out]);
    assert!(told.status == 3 && told.stderr.starts_with("error: cannot write `"), "{}", told.stderr);
    assert!(told.stderr.contains("out/runs/00000"), "{}", told.stderr);
}

#[test]
fn a_run_that_takes_longer_than_its_limit_is_given_up() {
    let folder = Scratch::new("sweep-limit");
    let (scene, out) = (folder.write("spring.toml", SPRING), folder.file("out"));
    let words = "--vary engine.end=[0.5,1e9,1] --jobs 1 --limit 0.2";
    let told = sweep(words, &[&scene, "--out", &out]);
    assert!(told.status == 3 && told.stderr == "1 of 3 runs failed\n", "{}", told.stderr);
    let table = rows(&folder, "out/table.csv");
    assert_eq!([0, 1, 2].map(|run| table[run][2].as_str()), ["done", "failed", "done"]);
    assert_eq!(table[1].last().map(String::as_str), Some("given up after 0.2 s"));
    assert!(table[1][4].parse::<u64>().unwrap() > 0, "how far it came: {table:?}");
    // It is done with, and the others know no limit.
    assert_eq!(sweep("--vary engine.end=[0.5,1e9,1]", &[&scene, "--out", &out]).status, 3);
    // Also in the middle of a frame.
    let words = "--vary engine.step=[1e7,2e7] --end 2e7 --integrator dormand_prince_8 --limit 0.2 --json";
    let told = sweep(words, &[&scene]).json();
    assert_eq!(told["runs"][0]["error"], "given up after 0.2 s", "{told}");
    for limit in ["0", "-1", "soon"] {
        let told = sweep("--vary engine.step=[1,2] --limit", &[limit, &scene]);
        assert!(told.status == 2 && told.stderr.contains("expected a number above 0"), "{}", told.stderr);
    }
}

#[cfg(unix)]
#[test]
fn without_a_folder_an_interrupted_sweep_tells_what_is_done() {
    use std::process::{Command, Stdio};
    let folder = Scratch::new("sweep-told");
    let scene = folder.write("spring.toml", &SPRING.replace("end = 2.0", "end = 4e2"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_vesper"));
    command.args(["sweep", &scene, "--vary", "domains.springs.stiffness.0=1:100:5000", "--jobs", "1"]);
    let told = |more: &[&str]| {
        let run = command.args(more).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(1500));
        assert!(Command::new("kill").args(["-INT", &run.id().to_string()]).status().unwrap().success());
        let ended = run.wait_with_output().unwrap();
        assert_eq!(ended.status.code(), Some(130));
        let told = String::from_utf8(ended.stderr).unwrap();
        let done: usize = told.split_whitespace().nth(1).unwrap().parse().unwrap();
        assert!(told.starts_with("interrupted; ") && told.contains("of 5000 runs are done; with --out DIR"), "{told}");
        assert!((1..5000).contains(&done), "{told}");
        (done, String::from_utf8(ended.stdout).unwrap())
    };
    let mut told = told;
    let (done, table) = told(&[]);
    assert!(table.starts_with("two masses on a spring\nrun"), "{table}");
    let lines = table.lines().count() - 2;
    assert!(lines == done || lines == 201 && table.ends_with(&format!("and {} more\n", done - 200)), "{done}: {table}");
    let (done, object) = told(&["--json"]);
    let object: Value = serde_json::from_str(&object).unwrap();
    assert_eq!(object["runs"].as_array().map(Vec::len), Some(done));
    assert_eq!(object["missing"].as_array().map(Vec::len), Some(5000 - done));
}

#[test]
fn the_help_has_an_example_of_each_form() {
    let help = done(["sweep", "--help"]).stdout;
    assert!(
        help.contains("Threads of each run [default: 1]") && !help.contains("all cores]\n      --strict"),
        "{help}"
    );
    for words in [
        "--limit <S>",
        "FIRST:LAST:COUNT:log",
        "[V,V,..]",
        "$SLURM_ARRAY_TASK_ID/16",
        "--collect",
        "bodies.position[0].x",
    ] {
        assert!(help.contains(words), "{words}: {help}");
    }
}
