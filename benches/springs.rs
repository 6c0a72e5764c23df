//! Links: springs of a lattice on one thread and on two, beside two loops by hand: one spring after the other, and colour by
//! colour, so that two threads need no locks.
//!
//! 100 000 springs join neighbours on a cube of 33 bodies to an edge; a million join neighbours on a cube of 67 to an edge,
//! 300 763 bodies, and diagonals that chance chooses. Springs are numbered as their first bodies are.

use vesper::prelude::*;
use vesper_benches::hand::{Coloured, Column, Sprung, difference};
use vesper_benches::scenes::{GRAVITY, Lattice, STEP};
use vesper_benches::{Case, Contender, Race, Run, Summary, criterion};
use vesper_laws::{Motion, Spring, UniformGravity};

/// Steps whose results are compared.
const CHECK: usize = 4;

fn lattices() -> [Lattice; 2] {
    let lattices = [Lattice::new(33, 100_000), Lattice::braced(67, 1_000_000, 0.5)];
    assert_eq!(lattices.each_ref().map(|lattice| lattice.ends.len()), [100_000, 1_000_000]);
    lattices
}

fn engine<P: Precision>(lattice: &Lattice, threads: usize) -> Result<Engine<P>, Faults> {
    Engine::builder()
        .domain(lattice.bodies.moving())
        .domain(lattice.springs())
        .constant(GravityAcceleration, [GRAVITY])
        .law(UniformGravity)
        .law(Spring)
        .law(Motion)
        .integrator(SemiImplicitEuler)
        .step(STEP)
        .backend(if threads == 1 { Backend::Cpu } else { Backend::Parallel })
        .threads(threads)
        .strict()
        .build()
}

fn study<P: Precision>(
    lattice: &Lattice,
    threads: usize,
    run: Run,
    summary: &mut Summary,
    lines: &mut criterion::Criterion,
) {
    let springs = lattice.ends.len();
    let name = format!("springs/{}/{springs}/{threads}", P::NAME);
    if !run.wants(&name) {
        return;
    }
    let mut engine = engine::<P>(lattice, threads).expect("the scene has all that the laws read");
    let mut hand = Sprung::<P>::new(lattice);
    let mut coloured = Coloured::<P>::new(lattice);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let pool = (threads > 1).then_some(&pool);

    let stays = "the bodies stay finite";
    engine.steps_of(CHECK as u64, STEP).expect(stays);
    for _ in 0..CHECK {
        hand.step(GRAVITY);
        coloured.step(GRAVITY, pool);
    }
    let error = |theirs: &[Column<P>; 3]| difference(&engine, Velocity, theirs).expect("the engine has velocities");
    let errors = [error(&hand.velocity), error(&coloured.sprung.velocity)];
    assert!(errors.iter().all(|&error| error < 1e-5), "{name}: the same motion");

    let mut contenders = [
        Contender::new("spring law", || engine.steps_of(1, STEP).expect(stays)),
        Contender::new("hand loop", || hand.step(GRAVITY)),
        Contender::new("hand coloured loop", || coloured.step(GRAVITY, pool)),
    ];
    let times = Race::default().run(run, springs as f64, &mut contenders);
    let [ours, hand, coloured] = times[..] else { return };
    let case = Case { name: "springs", n: springs, threads, precision: P::NAME, unit: "ns/spring", error: None };
    summary.add(case, ours, &[(hand, Some(errors[0])), (coloured, Some(errors[1]))]);
    Race::lines(lines, &name, springs as f64, &mut contenders);
}

fn main() -> std::io::Result<()> {
    let run = Run::from_arguments();
    let (mut summary, mut lines) = (Summary::new("springs", run), criterion());
    for lattice in &lattices() {
        for threads in [1, 2] {
            study::<f32>(lattice, threads, run, &mut summary, &mut lines);
            study::<f64>(lattice, threads, run, &mut summary, &mut lines);
        }
    }
    lines.final_summary();
    summary.write()
}
