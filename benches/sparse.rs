//! A subset: 40 charges among 1000 bodies cost what 40 bodies cost.

use vesper::prelude::*;
use vesper_benches::scenes::{Bodies, STEP};
use vesper_benches::{Case, Contender, Race, Run, Summary, criterion};
use vesper_laws::{Coulomb, Motion};

const CHARGES: usize = 40;
const BODIES: usize = 1000;
/// Every 25th body is charged.
const STRIDE: usize = BODIES / CHARGES;

/// The charged bodies alone, or among all.
fn domain<P: Precision>(alone: bool) -> Domain<P> {
    let all = Bodies::new(BODIES);
    if !alone {
        let rows = (0..BODIES).step_by(STRIDE);
        let charges: Vec<f64> = rows.clone().map(|row| all.charge[row]).collect();
        return all.moving().subset(Charge, rows.map(|row| row as u32), charges);
    }
    let mut few = Bodies::default();
    for row in (0..BODIES).step_by(STRIDE) {
        few.position.push(all.position[row]);
        few.velocity.push(all.velocity[row]);
        few.mass.push(all.mass[row]);
        few.charge.push(all.charge[row]);
    }
    few.moving().with(Charge, few.charge.clone())
}

/// The force alone, looked at once a frame; or with the motion of all bodies.
fn engine<P: Precision>(alone: bool, motion: bool) -> Result<Engine<P>, Faults> {
    let builder = Engine::builder().domain(domain(alone)).law(Coulomb { k: 1e-3, softening: 0.25 });
    let builder = if motion { builder.law(Motion) } else { builder.observe("bodies", Force) };
    builder.integrator(SemiImplicitEuler).step(STEP).backend(Backend::Cpu).strict().build()
}

fn study<P: Precision>(motion: bool, run: Run, summary: &mut Summary, lines: &mut criterion::Criterion) {
    let case = if motion { "force and motion" } else { "force" };
    let name = format!("sparse/{}/{case}", P::NAME);
    let expect = "the scene has all that the laws read";
    let mut among = engine::<P>(false, motion).expect(expect);
    let mut alone = engine::<P>(true, motion).expect(expect);

    let stays = "the bodies stay finite";
    among.steps_of(4, STEP).expect(stays);
    alone.steps_of(4, STEP).expect(stays);
    let of = |engine: &Engine<P>| {
        let state = engine.state();
        let numbers = if motion { state.numbers("bodies", Velocity) } else { state.numbers("bodies", Force) };
        numbers.expect("the engine has the property")
    };
    let (all, few) = (of(&among), of(&alone));
    for (charged, numbers) in few.chunks_exact(3).enumerate() {
        assert_eq!(all[charged * STRIDE * 3..][..3], *numbers, "{name}: the same bits");
    }

    let mut contenders = [
        Contender::new("40 among 1000", || among.steps_of(1, STEP).expect(stays)),
        Contender::new("40 bodies alone", || alone.steps_of(1, STEP).expect(stays)),
    ];
    if run.wants(&name) {
        let times = Race::default().run(run, 1.0, &mut contenders);
        let [among, alone] = times[..] else { return };
        let case = Case { name: case, n: CHARGES, threads: 1, precision: P::NAME, unit: "ns/step", error: None };
        summary.add(case, among, &[(alone, Some(0.0))]);
    }
    Race::lines(lines, &name, 1.0, &mut contenders);
}

fn main() -> std::io::Result<()> {
    let run = Run::from_arguments();
    let (mut summary, mut lines) = (Summary::new("sparse", run), criterion());
    for motion in [false, true] {
        study::<f32>(motion, run, &mut summary, &mut lines);
        study::<f64>(motion, run, &mut summary, &mut lines);
    }
    lines.final_summary();
    summary.write()
}
