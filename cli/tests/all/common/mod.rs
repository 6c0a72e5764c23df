//! The command as a user runs it.

#![allow(dead_code, reason = "each test file uses a part")]

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// What a run of the command left.
pub struct Done {
    pub status: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Done {
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|error| panic!("{error}: {}{}", self.stdout, self.stderr))
    }
}

/// Runs `vesper` with these arguments.
pub fn vesper<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> Done {
    let output = Command::new(env!("CARGO_BIN_EXE_vesper")).args(arguments).output().unwrap();
    Done {
        status: output.status.code().unwrap(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

/// The same, which must be done without a word of complaint.
pub fn done<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> Done {
    let done = vesper(arguments);
    assert!(done.status == 0 && done.stderr.is_empty(), "{} {}", done.status, done.stderr);
    done
}

/// The folder of the scenes.
pub fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes")
}

/// One of the scenes.
pub fn scene(name: &str) -> String {
    scenes().join(name).with_extension("toml").display().to_string()
}

/// A folder of a test's own, gone when it is dropped.
pub struct Scratch(pub PathBuf);

impl Scratch {
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("vesper-{name}-{}", std::process::id()));
        _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn file(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }

    pub fn write(&self, name: &str, text: &str) -> String {
        std::fs::write(self.0.join(name), text).unwrap();
        self.file(name)
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.0.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Checks that a value is what `run --json` promises.
pub fn check_schema(value: &Value) {
    let keys: Vec<&str> = value.as_object().unwrap().keys().map(String::as_str).collect();
    let promised =
        ["time", "steps", "evaluations", "wall_seconds", "domains", "laws", "unused", "transfers", "invariants"];
    assert!(keys.starts_with(&promised), "{keys:?}");
    assert!(keys[promised.len()..].iter().all(|key| ["compare", "error"].contains(key)), "{keys:?}");
    assert!(value["time"].is_f64() && value["wall_seconds"].is_f64());
    assert!(value["steps"].is_u64() && value["evaluations"].is_u64());
    for (_, columns) in value["domains"].as_object().unwrap() {
        for (name, column) in columns.as_object().unwrap() {
            let rows = column.as_array().unwrap_or_else(|| column["value"].as_array().unwrap());
            assert!(rows.iter().all(|row| row.is_array() || row.is_f64() || row.is_null()), "{name}");
        }
    }
    for law in value["laws"].as_array().unwrap() {
        assert!(law["name"].is_string(), "{law}");
        match law["status"].as_str().unwrap() {
            "active" => {
                assert!(["cpu", "parallel"].contains(&law["backend"].as_str().unwrap()), "{law}");
                assert!(law["seconds"].as_f64().unwrap() >= 0.0, "{law}");
            }
            "dormant" | "pruned" => assert!(law["reason"].is_string(), "{law}"),
            other => assert_eq!(other, "off"),
        }
    }
    for count in ["uploads", "upload_bytes", "downloads", "download_bytes"] {
        assert_eq!(value["transfers"][count], 0);
    }
    let energy = &value["invariants"]["energy"];
    assert!(energy["first"].is_f64() && energy.get("max_relative_drift").is_some(), "{energy}");
    for name in ["momentum", "angular_momentum"] {
        let drift = value["invariants"][name].as_object().unwrap();
        assert!(drift.is_empty() || drift["first"].as_array().unwrap().len() == 3);
    }
}
