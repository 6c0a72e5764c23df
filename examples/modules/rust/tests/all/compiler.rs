//! Modules in C, compiled when a test wants them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, PoisonError};
use vesper::module::Module;
use vesper::prelude::*;

/// The folder of the project.
pub fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..")
}

/// The library that this package is, beside its tests.
pub fn wings() -> &'static Module {
    let folder = std::env::current_exe().unwrap().parent().unwrap().to_owned();
    let file = format!("{}wings{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    // SAFETY: it was made from these sources.
    unsafe { Module::open(&folder.join(file)) }.unwrap_or_else(|faults| panic!("{faults}"))
}

/// Compiles a module of this name, by the compiler that Rust links with, and says where it is. Once: what is loaded must not change.
pub fn compiled(name: &str, source: &str) -> PathBuf {
    static KNOWN: Mutex<BTreeMap<String, PathBuf>> = Mutex::new(BTreeMap::new());
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(path) = known.get(name) {
        return path.clone();
    }
    let path = made(name, source);
    known.insert(name.to_owned(), path.clone());
    path
}

fn made(name: &str, source: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("modules-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let (code, library) = (folder.join(format!("{name}.c")), folder.join(format!("lib{name}.so")));
    std::fs::write(&code, source).unwrap();
    let done = Command::new("cc")
        .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-Wno-unused-function", "-O2", "-shared", "-fPIC", "-I"])
        .arg(project().join("bindings/c/include"))
        .arg("-o")
        .args([&library, &code])
        .output()
        .expect("cc is on the path: Rust links with it");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    library
}

/// The same, opened.
pub fn opened(name: &str, source: &str) -> Result<&'static Module, Faults> {
    // SAFETY: what is wrong with it, it is opened for.
    unsafe { Module::open(&compiled(name, source)) }
}

/// The law in C that stands in the examples.
pub fn lift_in_c() -> String {
    std::fs::read_to_string(project().join("examples/modules/c/lift.c")).unwrap()
}
