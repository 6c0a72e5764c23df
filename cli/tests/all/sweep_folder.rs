//! Folders of `vesper sweep`: whose they are, what they refuse, what a shard looks at, what is safe when machines go off.

use vesper_cli::modules::Modules;
use vesper_cli::sweep::{Ensemble, Manifest, Plan, Vary, check};

use crate::common::{Scratch, done, vesper};
use crate::modules::folder;
use crate::sweep::{SPRING, rows, sweep, swept};

/// Bodies out of a table, compared with those of another.
const TABLES: &str = r#"[engine]
step = 0.1
end = 1.0
[domains.bodies]
from = { csv = "a.csv", name = "body", mass = "m", position = ["x", "y", "z"], velocity = ["u", "v", "w"] }
[[laws]]
name = "motion"
[compare]
domain = "bodies"
csv = "then.csv"
name = "body"
time = { column = "t", unit = "s" }
position = ["x", "y", "z"]
"#;

/// The scene of [`TABLES`], and its tables.
fn tables(folder: &Scratch) -> String {
    for (name, speed) in [("a", 1), ("b", 2)] {
        folder.write(&format!("{name}.csv"), &format!("body,m,x,y,z,u,v,w\none,1,0,0,0,{speed},0,0\n"));
    }
    for (name, time) in [("then", 1.0), ("before", 0.5)] {
        folder.write(&format!("{name}.csv"), &format!("body,t,x,y,z\none,{time},1,0,0\n"));
    }
    folder.write("tables.toml", TABLES)
}

const OF_TABLES: [&str; 4] = [
    "--vary",
    "domains.bodies.from.csv=[\"a.csv\", \"b.csv\"]",
    "--vary",
    "compare.csv=[\"then.csv\", \"before.csv\"]",
];

#[test]
fn a_folder_refuses_a_sweep_of_other_tables_whichever_run_reads_them() {
    let folder = Scratch::new("sweep-tables");
    let (scene, out) = (tables(&folder), folder.file("out"));
    let words = [&["sweep", &scene, "--out", &out], &OF_TABLES[..]].concat();
    done(&words);
    let before = folder.read("out/manifest.json");
    for name in ["a.csv", "b.csv", "then.csv", "before.csv"] {
        let was = folder.read(name);
        folder.write(name, &format!("# other\n{was}"));
        let refused = vesper(&words);
        assert_eq!(refused.status, 2, "{name}");
        assert!(refused.stderr.contains("the folder is of another sweep; files beside the scene: "), "{name}");
        folder.write(name, &was);
    }
    done(&words);
    assert_eq!(folder.read("out/manifest.json"), before);
}

#[test]
fn a_table_that_changes_while_runs_are_made_fails_those_that_would_read_it() {
    let folder = Scratch::new("sweep-changes");
    let scene = tables(&folder);
    let ensemble = Ensemble { varies: vec![Vary::read(OF_TABLES[1]).unwrap()], ..Ensemble::default() };
    let mut plan = Plan::new(scene.as_ref(), Vec::new(), Modules::default(), ensemble).unwrap();
    check(&mut plan, Vec::new()).unwrap();
    let manifest = Manifest::new(&plan);
    assert_eq!(
        manifest.files.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(),
        ["a.csv", "b.csv", "then.csv"]
    );
    let was = folder.read("b.csv");
    folder.write("b.csv", &was.replace(",2,", ",3,"));
    assert!(plan.scene(1).is_ok());
    let told = plan.scene(2).unwrap_err();
    assert!(told[0].text.starts_with("cannot read `b.csv`: it has changed since it was read first"), "{}", told[0]);
    assert_eq!(Manifest::new(&plan), manifest);
    folder.write("b.csv", &was);
    assert!(plan.scene(2).is_ok());
}

#[test]
fn a_folder_refuses_a_sweep_by_other_code_of_a_module() {
    let scratch = folder("sweep-module", "slope", "slope");
    let (scene, laws, out) = (scratch.file("scene.toml"), scratch.0.display().to_string(), scratch.file("out"));
    let words = ["sweep", &scene, "--laws", &laws, "--vary", "engine.step=[1e-2,2e-2]", "--out", &out];
    done(words);
    let manifest = scratch.read("out/manifest.json");
    assert!(manifest.contains("\"module\":\"lift\"") && !manifest.contains(&laws), "{manifest}");
    // The same laws by their declarations, so that a fingerprint would not tell.
    let other = folder("sweep-module-other", "force[row] += slope", "force[row] -= slope");
    let told = vesper([&words[..], &["--laws", &other.0.display().to_string()]].concat());
    assert_eq!(told.status, 0, "the first folder has the module: {}", told.stderr);
    std::fs::remove_file(scratch.file("liblift.so")).unwrap();
    let told = vesper([&words[..], &["--laws", &other.0.display().to_string()]].concat());
    assert_eq!(told.status, 2, "{}", told.stderr);
    assert!(told.stderr.contains("the folder is of another sweep; modules of laws: in the folder `lift ("));
}

#[test]
fn a_shard_has_failed_where_one_of_its_own_runs_has() {
    let folder = Scratch::new("sweep-own");
    let scene = folder.write("spring.toml", &SPRING.replace("end = 2.0", "end = 20.0"));
    let out = folder.file("out");
    // The second is too stiff for its step.
    let words = "--vary domains.springs.stiffness.0=[10,60000,20]";
    let shard = |shard: &str| {
        let told = sweep(words, &[&scene, "--out", &out, "--shard", shard]);
        (told.status, told.stdout, told.stderr)
    };
    // No business of the first one, whatever it is.
    std::fs::create_dir_all(folder.0.join("out/runs/000002.json")).unwrap();
    let (status, told, complaint) = shard("1/3");
    assert!(status == 0 && complaint.is_empty() && told.contains("2 of 3 runs are in"), "{told}{complaint}");
    assert!(told.contains("not there, or not yet: 3\n"), "{told}");
    std::fs::remove_dir(folder.0.join("out/runs/000002.json")).unwrap();
    let (status, _, complaint) = shard("2/3");
    assert!(status == 3 && complaint.ends_with("\n1 of 1 run failed\n"), "{complaint}");
    assert!(complaint.starts_with("run 2 (domains.springs.stiffness.0=60000): "), "{complaint}");
    let (status, _, complaint) = shard("1/3");
    assert_eq!((status, complaint.as_str()), (0, ""));
    let (status, told, complaint) = shard("3/3");
    assert!(status == 0 && complaint.is_empty() && told.contains("  failed: "), "{told}{complaint}");
    assert_eq!(rows(&folder, "out/table.csv")[1][2], "failed");
    assert_eq!(shard("2/3").0, 3);
    let whole = sweep("--collect", &["--out", &out]);
    assert!(whole.status == 3 && whole.stderr == "1 of 3 runs failed\n", "{}", whole.stderr);
}

#[test]
fn records_that_cannot_be_read_or_are_of_another_sweep_are_told_and_stay() {
    let folder = Scratch::new("sweep-records");
    let (scene, out, longer) = (folder.write("spring.toml", SPRING), folder.file("out"), folder.file("longer"));
    let words = "--vary engine.step=[0.01,0.02]";
    swept(words, &[&scene, "--out", &out]);
    swept(words, &[&scene, "--out", &longer, "--end", "3"]);
    let record = folder.0.join("out/runs/000002.json");
    // The same run by its values, and of other physics.
    std::fs::copy(folder.0.join("longer/runs/000002.json"), &record).unwrap();
    let told = sweep(words, &[&scene, "--out", &out]);
    let expected = "000002.json` is of another sweep than manifest.json: take it away, and its run is made here";
    assert!(told.status == 2 && told.stderr.contains(expected), "{}", told.stderr);
    assert_eq!(folder.read("out/runs/000002.json"), folder.read("longer/runs/000002.json"));
    let told = sweep("--collect", &["--out", &out]);
    assert!(told.status == 3 && told.stderr.contains(expected), "{}", told.stderr);
    std::fs::remove_file(&record).unwrap();
    std::fs::create_dir(&record).unwrap();
    let told = sweep(words, &[&scene, "--out", &out]);
    assert!(told.status == 2 && told.stderr.contains("cannot read `") && record.is_dir(), "{}", told.stderr);
    // Of a folder that a machine left when it went off there may be no more than the manifest.
    std::fs::remove_dir_all(folder.0.join("out/runs")).unwrap();
    swept(words, &[&scene, "--out", &out]);
    assert_eq!(rows(&folder, "out/table.csv").len(), 2);
}

#[test]
fn a_run_that_somebody_else_made_meanwhile_is_not_made_again() {
    let folder = Scratch::new("sweep-meanwhile");
    let scene = folder.write("spring.toml", &SPRING.replace("end = 2.0", "end = 4e2"));
    let words = ["sweep", &scene, "--vary", "domains.springs.stiffness.0=1:100:20", "--jobs", "1", "--quiet", "--out"];
    let whole = folder.file("whole");
    done(words.iter().chain([&whole.as_str()]));
    let marked = folder.read("whole/runs/000020.json").replace("\"wall_seconds\": ", "\"wall_seconds\": 77");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_vesper"));
    let mut run = command.args(words).arg(folder.file("out")).spawn().unwrap();
    while !folder.0.join("out/runs/000001.json").exists() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    folder.write("out/runs/000020.json", &marked);
    assert!(run.wait().unwrap().success());
    assert_eq!(folder.read("out/runs/000020.json"), marked);
    assert_eq!(folder.read("out/table.csv"), folder.read("whole/table.csv"));
}
