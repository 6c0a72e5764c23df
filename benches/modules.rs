//! A law that was compiled apart, beside the same law that was compiled with the program: the same steps, the same bits.
//!
//! The law is `lift` of `examples/modules`, in Rust as it is and in C. What one costs on two rows is the time of sixteen of them less
//! that of none, by sixteen.

use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;
use vesper::module::{Module, ModuleLaw};
use vesper::prelude::*;
use vesper_benches::scenes::{Bodies, STEP};
use vesper_benches::{Case, Contender, Race, Run, Summary, Time, criterion};
use vesper_laws::Motion;
use wings::Lift;

/// Laws from whose time together the time of one is taken.
const LAWS: usize = 16;
/// Steps of one piece of work on few rows.
const STEPS: f64 = 100.0;

/// The library that the package of the example is, beside this program.
fn in_rust() -> ModuleLaw {
    let program = std::env::current_exe().expect("a program is somewhere");
    let file = format!("{}wings{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    lift(&program.with_file_name(file))
}

/// The example in C, compiled when it is first asked for.
fn in_c() -> ModuleLaw {
    static LAW: OnceLock<ModuleLaw> = OnceLock::new();
    LAW.get_or_init(compiled).clone()
}

fn compiled() -> ModuleLaw {
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let library = std::env::temp_dir().join(format!("libvesper_bench_lift_{}.so", std::process::id()));
    let done = Command::new("cc")
        .args(["-O3", "-march=native", "-shared", "-fPIC", "-I"])
        .arg(project.join("bindings/c/include"))
        .arg("-o")
        .args([&library, &project.join("examples/modules/c/lift.c")])
        .status();
    assert!(done.is_ok_and(|status| status.success()), "cc compiles the example");
    let law = lift(&library);
    // It stays open.
    _ = std::fs::remove_file(library);
    law
}

fn lift(library: &Path) -> ModuleLaw {
    // SAFETY: it was made from this project.
    let module = unsafe { Module::open(library) }.unwrap_or_else(|faults| panic!("{faults}"));
    module.law("lift").unwrap_or_else(|fault| panic!("{fault}"))
}

/// Which of the three an engine has.
enum Of {
    Here,
    Rust,
    C,
}

fn engine(rows: usize, laws: usize, of: &Of) -> Engine<f64> {
    let mut builder = Engine::builder().domain(Bodies::new(rows).moving()).law(Motion).step(STEP).threads(1);
    for law in 0..laws {
        let label = format!("lift {law}");
        builder = match of {
            Of::Here => builder.law(Lift::default().label(&label)),
            Of::Rust => builder.law(in_rust().label(&label)),
            Of::C => builder.law(in_c().label(&label)),
        };
    }
    builder.build().expect("the scene has all that the laws read")
}

fn same_bits(rows: usize) {
    let run = |of| {
        let mut engine = engine(rows, 1, &of);
        engine.steps_of(5, STEP).expect("the bodies stay finite");
        engine.state().hash()
    };
    assert!(run(Of::Here) == run(Of::Rust) && run(Of::Here) == run(Of::C), "the same bits");
}

fn each(name: &'static str, none: Time, all: Time) -> Time {
    let of = |all: f64| (all - none.median).max(0.0) / LAWS as f64;
    Time { name, median: of(all.median), low: of(all.low), high: of(all.high) }
}

fn main() -> std::io::Result<()> {
    let run = Run::from_arguments();
    let (mut summary, mut lines) = (Summary::new("modules", run), criterion());
    let case = |name, n| Case { name, n, threads: 1, precision: "f64", unit: "ns", error: None };
    let stays = "the bodies stay finite";
    same_bits(1000);
    let mut few =
        [engine(2, 0, &Of::Here), engine(2, LAWS, &Of::Here), engine(2, LAWS, &Of::Rust), engine(2, LAWS, &Of::C)];
    let names = ["no law", "compiled with the program", "module in Rust", "module in C"];
    let mut contenders: Vec<Contender<'_>> = names
        .into_iter()
        .zip(&mut few)
        .map(|(name, engine)| Contender::new(name, move || engine.steps_of(STEPS as u64, STEP).expect(stays)))
        .collect();
    if run.wants("modules/2 rows") {
        let times = Race::default().run(run, STEPS, &mut contenders);
        let [none, here, rust, c] = times[..] else { return summary.write() };
        let here = each("compiled with the program", none, here);
        for of in [each("module in Rust", none, rust), each("module in C", none, c)] {
            summary.add(case(of.name, 2), of, &[(here, None)]);
            if run == Run::Measure {
                println!(
                    "    a call of a {} takes {:+.1} ns more than one of the law that is here",
                    of.name,
                    of.median - here.median
                );
            }
        }
    }
    Race::lines(&mut lines, "modules/2 rows", STEPS, &mut contenders);
    drop(contenders);
    let rows = if run == Run::Test { 1000 } else { 1_000_000 };
    let mut many = [engine(rows, 1, &Of::Here), engine(rows, 1, &Of::Rust), engine(rows, 1, &Of::C)];
    let mut contenders: Vec<Contender<'_>> = names[1..]
        .iter()
        .zip(&mut many)
        .map(|(name, engine)| Contender::new(name, move || engine.steps_of(1, STEP).expect(stays)))
        .collect();
    if run.wants("modules/1e6 rows") {
        let times = Race::default().run(run, rows as f64, &mut contenders);
        let [here, rust, c] = times[..] else { return summary.write() };
        for of in [rust, c] {
            summary.add(case(of.name, rows), of, &[(here, None)]);
        }
    }
    Race::lines(&mut lines, "modules/1e6 rows", rows as f64, &mut contenders);
    lines.final_summary();
    summary.write()
}
