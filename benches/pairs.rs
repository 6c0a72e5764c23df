//! A pair law of a foreign crate beside the stock one, and a hand-written loop: gravitation of 1536 bodies.

use foreign_gravity::Gravity as ForeignGravity;
use vesper::prelude::*;
use vesper_benches::hand::{Attracted, difference};
use vesper_benches::scenes::{Bodies, STEP};
use vesper_benches::{Case, Contender, Race, Run, Summary, criterion};
use vesper_laws::{Gravity, Motion};

const G: f64 = 1e-3;
const SOFTENING: f64 = 0.25;
const BODIES: usize = 1536;

fn engine<P: Precision>(bodies: &Bodies, foreign: bool) -> Result<Engine<P>, Faults> {
    let builder = Engine::builder().domain(bodies.moving()).law(Motion);
    let builder = if foreign {
        builder.law(ForeignGravity { g: G, softening: SOFTENING })
    } else {
        builder.law(Gravity { g: G, softening: SOFTENING })
    };
    builder.integrator(SemiImplicitEuler).step(STEP).backend(Backend::Cpu).strict().build()
}

fn study<P: Precision>(run: Run, summary: &mut Summary, lines: &mut criterion::Criterion) {
    let name = format!("pairs/{}/{BODIES}", P::NAME);
    let bodies = Bodies::new(BODIES);
    let expect = "the scene has all that the laws read";
    let mut stock = engine::<P>(&bodies, false).expect(expect);
    let mut foreign = engine::<P>(&bodies, true).expect(expect);
    let mut hand = Attracted::<P>::new(&bodies);

    let stays = "the bodies stay finite";
    for _ in 0..4 {
        stock.steps_of(1, STEP).expect(stays);
        foreign.steps_of(1, STEP).expect(stays);
        hand.step(G, SOFTENING);
    }
    assert_eq!(stock.state().hash(), foreign.state().hash(), "{name}: stock and foreign give the same bits");
    let error = difference(&stock, Velocity, &hand.velocity).expect("the engine has velocities");
    assert!(error < 1e-6, "{name}: the same motion");

    // Each body is pulled by all others.
    let pairs = (BODIES * (BODIES - 1)) as f64;
    let mut contenders = [
        Contender::new("foreign law", || foreign.steps_of(1, STEP).expect(stays)),
        Contender::new("stock law", || stock.steps_of(1, STEP).expect(stays)),
        Contender::new("hand loop", || hand.step(G, SOFTENING)),
    ];
    if run.wants(&name) {
        let times = Race::default().run(run, pairs, &mut contenders);
        let [foreign, stock, hand] = times[..] else { return };
        let case = |name| Case { name, n: BODIES, threads: 1, precision: P::NAME, unit: "ns/pair" };
        summary.add(case("foreign law beside stock"), foreign, &[(stock, Some(0.0))]);
        summary.add(case("gravity of all pairs"), stock, &[(hand, Some(error))]);
        if run == Run::Measure {
            println!("    {:.2e} ordered pairs per second on one thread", 1e9 / stock.median);
        }
    }
    Race::lines(lines, &name, pairs, &mut contenders);
}

fn main() -> std::io::Result<()> {
    let run = Run::from_arguments();
    let (mut summary, mut lines) = (Summary::new("pairs", run), criterion());
    study::<f32>(run, &mut summary, &mut lines);
    study::<f64>(run, &mut summary, &mut lines);
    lines.final_summary();
    summary.write()
}
