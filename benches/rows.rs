//! Merged row laws: five laws and a step of semi-implicit Euler over many bodies, one thread.
//!
//! Composed at run time, composed at compile time, written by hand as one loop, as five systems of bevy_ecs, and as five queries of
//! hecs.

use vesper::prelude::*;
use vesper_benches::hand::{Charged, Step, difference};
use vesper_benches::scenes::{Bodies, ELECTRIC, GRAVITY, MAGNETIC, STEP};
use vesper_benches::{Case, Contender, Race, Run, Summary, criterion, peers};
use vesper_laws::{Drag, ElectricForce, FieldGravity, MagneticForce, Motion};

/// The five laws, one by one or as one chain.
fn engine<P: Precision>(bodies: &Bodies, chain: bool) -> Result<Engine<P>, Faults> {
    let builder = Engine::builder()
        .domain(bodies.domain())
        .field(GravityField, Uniform { value: GRAVITY })
        .field(ElectricField, Uniform { value: ELECTRIC })
        .field(MagneticField, Uniform { value: MAGNETIC });
    let builder = if chain {
        builder.laws(pipeline![FieldGravity, Drag, ElectricForce, MagneticForce, Motion])
    } else {
        builder.law(FieldGravity).law(Drag).law(ElectricForce).law(MagneticForce).law(Motion)
    };
    builder.integrator(SemiImplicitEuler).step(STEP).backend(Backend::Cpu).strict().build()
}

fn study<P: Precision>(rows: usize, run: Run, summary: &mut Summary, lines: &mut criterion::Criterion)
where
    Charged<P>: Step,
{
    let name = format!("rows/{}/{rows}", P::NAME);
    let bodies = Bodies::new(rows);
    let expect = "the scene has all that the laws read";
    let mut composed = engine::<P>(&bodies, false).expect(expect);
    let mut chained = engine::<P>(&bodies, true).expect(expect);
    let (mut hand, mut wide) = (Charged::<P>::new(&bodies), Charged::<P>::new(&bodies));
    let (mut world, mut schedule) = peers::bevy::charged::<P>(&bodies);
    let mut hecs = peers::hecs::charged::<P>(&bodies);

    // The same results first, the times then.
    let check = if run == Run::Measure { 64 } else { 4 };
    let stays = "the bodies stay finite";
    composed.steps_of(check, STEP).expect(stays);
    chained.steps_of(check, STEP).expect(stays);
    for _ in 0..check {
        hand.step();
        wide.step_wide();
        schedule.run(&mut world);
        peers::hecs::step::<P>(&mut hecs);
    }
    assert_eq!(composed.state().hash(), chained.state().hash(), "{name}: both ways give the same bits");
    let expect = "the engine has places";
    let by_hand = difference(&composed, Position, &hand.position).expect(expect);
    let by_hand_wide = difference(&chained, Position, &wide.position).expect(expect);
    let by_bevy = peers::bevy::difference(&composed, &mut world).expect(expect);
    let by_hecs = peers::hecs::difference(&composed, &mut hecs).expect(expect);
    let differences = [by_hand, by_hand_wide, by_bevy, by_hecs];
    assert!(differences.iter().all(|off| *off < 1e-6), "{name}: the same motion");

    // Frames of many steps: the check for numbers that are none comes once a frame, the hand loops have none.
    let steps = if run == Run::Measure { (100_000 / rows as u64).clamp(20, 100) } else { 1 };
    let units = (rows as u64 * steps) as f64;
    let mut contenders = [
        Contender::new("run time", || composed.steps_of(steps, STEP).expect(stays)),
        Contender::new("pipeline!", || chained.steps_of(steps, STEP).expect(stays)),
        Contender::new("hand loop avx2", || (0..steps).for_each(|_| wide.step_wide())),
        Contender::new("hand loop", || (0..steps).for_each(|_| hand.step())),
        Contender::new("bevy_ecs", || (0..steps).for_each(|_| schedule.run(&mut world))),
        Contender::new("hecs", || (0..steps).for_each(|_| peers::hecs::step::<P>(&mut hecs))),
    ];
    if run.wants(&name) {
        let times = Race::default().run(run, units, &mut contenders);
        let [composed, chained, wide, hand, bevy, hecs] = times[..] else { return };
        let peers = [(wide, by_hand_wide), (hand, by_hand), (bevy, by_bevy), (hecs, by_hecs)];
        let peers = peers.map(|(time, off)| (time, Some(off)));
        for (name, ours) in [("five laws at run time", composed), ("five laws in pipeline!", chained)] {
            summary.add(
                Case { name, n: rows, threads: 1, precision: P::NAME, unit: "ns/row", error: None },
                ours,
                &peers,
            );
        }
    }
    Race::lines(lines, &name, units, &mut contenders);
}

fn main() -> std::io::Result<()> {
    let run = Run::from_arguments();
    let (mut summary, mut lines) = (Summary::new("rows", run), criterion());
    for rows in [1000, 100_000, 1_000_000] {
        study::<f32>(rows, run, &mut summary, &mut lines);
        study::<f64>(rows, run, &mut summary, &mut lines);
    }
    lines.final_summary();
    summary.write()
}
