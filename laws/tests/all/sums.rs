//! What integrators sum: the same bits, whatever the state is like.

use vesper::prelude::*;
use vesper_laws::Motion;

/// An integrator that sums rows of weights, and others, of coordinates and of momenta.
#[derive(Debug)]
struct Mixed;

impl Integrator for Mixed {
    fn name(&self) -> &'static str {
        "mixed"
    }
    fn order(&self) -> u32 {
        1
    }
    fn work_vectors(&self) -> usize {
        3
    }
    fn step(&mut self, system: &mut dyn System, _step: f64) -> Result<(), Fault> {
        assert!(system.coordinates_follow_momenta());
        system.copy(Register::Work(0), Register::State, Part::All);
        system.evaluate_to(Register::Work(1), Part::All);
        system.evaluate(Part::All);
        let (to, part) = (Register::Work(2), Part::Coordinates);
        let terms = Terms::weighted(0, &[0.5, -0.25], 2.0).and(&[(1.0, Register::State)]);
        let momenta = Terms::weighted(0, &[0.1, 0.0], 3.0).and(&[(0.3, Register::Rates)]);
        system.linear(Combination { to, adds: false, part, terms, momenta });
        system.copy(Register::State, to, part);
        Ok(())
    }
}

#[test]
fn sums_have_one_order_whatever_the_state_is_like() {
    let (place, velocity, force) = ([1.1, -2.3, 0.7], [0.13, 0.21, -0.37], [1.9, -1.3, 0.57]);
    let expected: [f64; 3] = core::array::from_fn(|c| {
        let row = (0.1 * 3.0) * velocity[c] + place[c] * (0.5 * 2.0) + velocity[c] * (-0.25 * 2.0);
        row + 0.3 * (force[c] / 2.0) + place[c]
    });
    // In one array, with gaps, and in the client's memory; beside a domain without a row.
    for (rows, lends) in [(1, false), (3, false), (300, false), (3, true)] {
        let lent = Lent::<f64, 3>::new(vec![place; rows]);
        let bodies = Domain::new("bodies");
        let bodies = if lends { bodies.lend(Position, &lent) } else { bodies.with(Position, vec![place; rows]) };
        let bodies = bodies.with(Velocity, vec![velocity; rows]).with(Mass, vec![2.0; rows]);
        let bodies = bodies.with(ExternalForce, vec![force; rows]);
        let empty = Domain::new("nobody").with(Position, [[0.0; 3]; 0]).with(Velocity, [[0.0; 3]; 0]);
        let builder = Engine::<f64>::builder().domain(bodies).domain(empty.with(Mass, [0.0; 0]));
        let builder = builder.law(Motion.on("bodies")).law(Motion.on("nobody").label("still"));
        let mut engine = builder.integrator(Mixed).step(0.1).build().unwrap();
        engine.steps_of(1, 0.1).unwrap();
        let found = engine.state().numbers("bodies", Position).unwrap();
        assert!(found.chunks_exact(3).all(|row| row == expected), "{rows} {lends}: {found:?} {expected:?}");
    }
}
