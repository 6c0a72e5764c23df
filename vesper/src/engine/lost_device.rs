//! What an engine does when its graphics processor is lost.

use crate::prelude::*;

#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position, velocity: Velocity), rates(velocity: Velocity, moves: Position))]
struct Oscillation;

#[kernel]
impl<R: Real> RowLaw<R> for Oscillation {
    fn row(&self, row: OscillationRow<R>) -> OscillationOutput<R> {
        OscillationOutput { velocity: -row.position, moves: row.velocity }
    }
}

fn engine(backend: Backend) -> Engine<f32> {
    let places: Vec<DVec3> = (0..300).map(|row| DVec3::new(f64::from(row), 1.0, -0.25)).collect();
    let rows = Domain::new("rows").rows(300).with(Position, places).with(Velocity, vec![DVec3::Z; 300]);
    let builder = Engine::<f32>::builder().domain(rows).law(Oscillation.backend(backend));
    builder.integrator(SemiImplicitEuler).step(0.125).build().unwrap()
}

#[test]
fn a_device_that_is_lost_changes_no_result() {
    let mut here = engine(Backend::Cpu);
    let mut there = engine(Backend::Gpu);
    if there.backends() != [Some(Backend::Gpu)] {
        let required = std::env::var("VESPER_REQUIRE_GPU").is_ok_and(|required| required == "1");
        assert!(!required, "{}", there.explain());
        return eprintln!("not run: {}", there.explain());
    }
    here.steps_of(4, 0.125).unwrap();
    there.steps_of(4, 0.125).unwrap();
    assert_eq!(here.state().hash(), there.state().hash());
    there.machine.device.as_ref().unwrap().as_ref().unwrap().destroy();
    here.steps_of(4, 0.125).unwrap();
    there.steps_of(4, 0.125).unwrap();
    assert_eq!(here.state().hash(), there.state().hash());
}
