//! Folders of `vesper sweep`: whose they are, what they refuse, what a shard looks at, what is safe when machines go off.

use vesper_cli::modules::Modules;
use vesper_cli::sweep::{Ensemble, Manifest, Plan, Vary, check};

use crate::common::{Scratch, done, vesper};
use crate::modules::folder;

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
