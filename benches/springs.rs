//! Links: 100 000 springs of a lattice beside a hand-written loop.

use vesper::prelude::*;
use vesper_benches::hand::{Sprung, difference};
use vesper_benches::scenes::{GRAVITY, Lattice, STEP};
use vesper_benches::{Case, Contender, Race, Run, Summary, criterion};
use vesper_laws::{Motion, Spring, UniformGravity};

const SPRINGS: usize = 100_000;
/// Bodies to an edge: the smallest lattice that has so many springs.
const EDGE: u32 = 33;

fn engine<P: Precision>(lattice: &Lattice) -> Result<Engine<P>, Faults> {
    Engine::builder()
        .domain(lattice.bodies.moving())
        .domain(lattice.springs())
        .constant(GravityAcceleration, [GRAVITY])
        .law(UniformGravity)
        .law(Spring)
        .law(Motion)
        .integrator(SemiImplicitEuler)
        .step(STEP)
        .backend(Backend::Cpu)
        .strict()
        .build()
}

fn study<P: Precision>(run: Run, summary: &mut Summary, lines: &mut criterion::Criterion) {
    let name = format!("springs/{}/{SPRINGS}", P::NAME);
    let lattice = Lattice::new(EDGE, SPRINGS);
    assert_eq!(lattice.ends.len(), SPRINGS);
    let mut engine = engine::<P>(&lattice).expect("the scene has all that the laws read");
    let mut hand = Sprung::<P>::new(&lattice);

    let stays = "the bodies stay finite";
    let check = 4;
    engine.steps_of(check, STEP).expect(stays);
    (0..check).for_each(|_| hand.step(GRAVITY));
    let error = difference(&engine, Velocity, &hand.velocity).expect("the engine has velocities");
    assert!(error < 1e-5, "{name}: the same motion");

    let mut contenders = [
        Contender::new("spring law", || engine.steps_of(1, STEP).expect(stays)),
        Contender::new("hand loop", || hand.step(GRAVITY)),
    ];
    if run.wants(&name) {
        let times = Race::default().run(run, SPRINGS as f64, &mut contenders);
        let [ours, hand] = times[..] else { return };
        let case = Case { name: "springs", n: SPRINGS, precision: P::NAME, unit: "ns/spring" };
        summary.add(case, ours, &[(hand, Some(error))]);
    }
    Race::lines(lines, &name, SPRINGS as f64, &mut contenders);
}

fn main() -> std::io::Result<()> {
    let run = Run::from_arguments();
    let (mut summary, mut lines) = (Summary::new("springs", run), criterion());
    study::<f32>(run, &mut summary, &mut lines);
    study::<f64>(run, &mut summary, &mut lines);
    lines.final_summary();
    summary.write()
}
