//! A law with a cut-off: the usual melt of 32 000 Lennard-Jones atoms, a step of velocity Verlet with all that lists of neighbours
//! take. The law is that of `examples/ladder/lennard_jones.rs`, as a user writes it.

use vesper::prelude::*;
use vesper_benches::{Case, Contender, Race, Run, Summary};
use vesper_examples::lennard_jones::{LATTICE_ENERGY, LennardJones, length, melt};
use vesper_laws::Motion;

const CELLS: usize = 20;
const STEP: f64 = 0.005;
/// Steps of a turn: some times as many as lists hold for.
const STEPS: u64 = 50;

fn engine<P: Precision>(threads: usize) -> Engine<P> {
    let builder = Engine::builder().domain(melt(CELLS)).constant(PeriodicBox, [[length(CELLS); 3]]);
    let builder = builder.law(LennardJones::default()).law(Motion).integrator(Leapfrog::default()).step(STEP);
    builder.threads(threads).strict().build().expect("the scene has all that the laws read")
}

fn study<P: Precision>(run: Run, summary: &mut Summary) {
    let atoms = 4 * CELLS.pow(3);
    let mut first = engine::<P>(1);
    let kinetic = |engine: &Engine<P>| -> f64 {
        let velocities = engine.state().numbers("atoms", Velocity).expect("the engine has velocities");
        velocities.iter().map(|v| 0.5 * v * v).sum::<f64>()
    };
    let total = first.energy().expect("the law knows its energy").0;
    let error = ((total - kinetic(&first)) / atoms as f64 - LATTICE_ENERGY).abs();
    assert!(error < 1e-9 + 16.0 * P::EPSILON, "the energy of the lattice is off by {error:e}");
    let mut contenders = [1, 2].map(|threads| {
        let mut engine = engine::<P>(threads);
        engine.steps_of(if run == Run::Test { 1 } else { 200 }, STEP).expect("the atoms stay finite");
        let steps = if run == Run::Test { 1 } else { STEPS };
        Contender::new("melt", move || engine.steps_of(steps, STEP).expect("the atoms stay finite"))
    });
    let units = atoms as f64 * STEPS as f64;
    let times = Race { rounds: 15, ..Race::default() }.run(run, units, &mut contenders);
    let [one, two] = times[..] else { return };
    let case = |threads| Case {
        name: "Lennard-Jones melt",
        n: atoms,
        threads,
        precision: P::NAME,
        unit: "ns/atom-step",
        error: Some(error),
    };
    summary.add(case(1), one, &[]);
    summary.add(case(2), two, &[(one, None)]);
    if run == Run::Measure {
        println!("    {:.2e} atom-steps a second on one thread, {:.2e} on two", 1e9 / one.median, 1e9 / two.median);
    }
}

fn main() -> std::io::Result<()> {
    let run = Run::from_arguments();
    let mut summary = Summary::new("cut_off", run);
    study::<f64>(run, &mut summary);
    study::<f32>(run, &mut summary);
    summary.write()
}
