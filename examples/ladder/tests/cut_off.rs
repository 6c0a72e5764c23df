//! A law with a cut-off, by lists of neighbours: what it gives, with what bits, and what is refused.

use vesper::prelude::*;
use vesper::real::Isa;
use vesper_examples::lennard_jones::{LATTICE_ENERGY, LennardJones, LennardJonesRow, length, melt};
use vesper_laws::Motion;

const STEP: f64 = 0.005;

fn builder<P: Precision>(atoms: Domain<P>, side: f64) -> Builder<P> {
    let builder =
        Engine::builder().domain(atoms).constant(PeriodicBox, [[side; 3]]).law(LennardJones::default()).law(Motion);
    builder.integrator(Leapfrog::default()).step(STEP).strict()
}

#[test]
fn the_lattice_has_the_energy_that_is_known() {
    for cells in [5_usize, 8] {
        let atoms = 4 * cells.pow(3);
        let at_rest = |numbers: &[f64]| numbers.iter().map(|v| 0.5 * v * v).sum::<f64>();
        let mut engine = builder::<f64>(melt(cells), length(cells)).build().unwrap();
        let moving = at_rest(&engine.state().numbers("atoms", Velocity).unwrap());
        let energy = (engine.energy().unwrap().0 - moving) / atoms as f64;
        assert!((energy - LATTICE_ENERGY).abs() < 1e-10, "{energy:.12}");
        let mut engine = builder::<f32>(melt(cells), length(cells)).build().unwrap();
        let moving = at_rest(&engine.state().numbers("atoms", Velocity).unwrap());
        let energy = (engine.energy().unwrap().0 - moving) / atoms as f64;
        assert!((energy - LATTICE_ENERGY).abs() < 1e-5, "{energy:.12}");
    }
}

fn same_bits<P: Precision>() {
    let run = |isa: Isa, threads: usize, stop: bool| {
        let build = || {
            let builder = builder::<P>(melt(5), length(5)).isa(isa).threads(threads).estimates(false);
            builder.backend(Backend::Parallel).build().unwrap()
        };
        let mut engine = build();
        engine.steps_of(60, STEP).unwrap();
        if stop {
            // Lists are made anew after that, at another time than else.
            let checkpoint = engine.checkpoint().unwrap();
            engine = build();
            engine.restore(&checkpoint).unwrap();
        }
        engine.steps_of(60, STEP).unwrap();
        engine.state().hash()
    };
    let reference = run(Isa::Scalar, 1, false);
    for isa in Isa::available() {
        for threads in [1, 2, 3, 7] {
            assert_eq!(run(isa, threads, threads == 2), reference, "{isa:?}, {threads} threads");
        }
    }
}

#[test]
fn a_fluid_has_the_same_bits_on_every_machine_and_after_a_stop() {
    same_bits::<f64>();
    same_bits::<f32>();
}

#[test]
fn with_estimates_bits_do_not_depend_on_threads() {
    let run = |threads: usize| {
        let mut engine =
            builder::<f32>(melt(6), length(6)).threads(threads).backend(Backend::Parallel).build().unwrap();
        engine.steps_of(80, STEP).unwrap();
        engine.state().hash()
    };
    let reference = run(1);
    assert!([2, 3, 7].into_iter().all(|threads| run(threads) == reference));
}

#[test]
fn clusters_that_do_not_fill_lanes_are_given_once() {
    // The last cluster of 1005 atoms has five rows, one more than a register of AVX2 holds; gravity begins the sum of forces.
    let start = Engine::<f64>::builder().domain(melt(7)).law(Motion).step(STEP).build().unwrap();
    let value = |property: PropertyInfo, row| start.state().numbers("atoms", property).unwrap()[row];
    let place = |at| value(Position::INFO, at) + 0.05 * value(Velocity::INFO, at);
    let places: Vec<_> = (0..1005).map(|row| [place(3 * row), place(3 * row + 1), place(3 * row + 2)]).collect();
    let run = |isa: Isa, estimates: bool| {
        let atoms = Domain::new("atoms").with(Position, &places).with(Velocity, vec![[0.0; 3]; 1005]);
        let gravity = vesper_laws::Gravity { g: 1e-3, softening: 0.1 };
        let builder = builder::<f64>(atoms.with(Mass, vec![1.0; 1005]), length(7)).law(gravity);
        let builder = builder.integrator(SemiImplicitEuler);
        let mut engine = builder.isa(isa).estimates(estimates).build().unwrap();
        engine.steps_of(1, STEP).unwrap();
        engine.state().numbers("atoms", Velocity).unwrap()
    };
    let exact = run(Isa::Scalar, false);
    for isa in Isa::available() {
        let off = run(isa, true).iter().zip(&exact).fold(0.0, |most, (a, b)| f64::max(most, (a - b).abs()));
        assert!(off < 1e-11, "{isa:?}: {off:e}");
    }
}

/// What all images of all atoms do to each other, one by one.
fn forces(places: &[[f64; 3]], side: f64, reach: i32) -> Vec<f64> {
    let law = LennardJones::default();
    let row = |place: [f64; 3]| LennardJonesRow { position: DVec3::from(place) };
    let boxes = if side > 0.0 { -reach..=reach } else { 0..=0 };
    let mut forces = Vec::new();
    for i in places {
        let mut sum = DVec3::ZERO;
        for j in places {
            for x in boxes.clone() {
                for y in boxes.clone() {
                    for z in boxes.clone() {
                        let moved =
                            [j[0] + side * f64::from(x), j[1] + side * f64::from(y), j[2] + side * f64::from(z)];
                        let distance = (DVec3::from(*i) - DVec3::from(moved)).length();
                        if distance > 0.0 && distance < law.cutoff {
                            sum += law.pair(row(*i), row(moved));
                        }
                    }
                }
            }
        }
        forces.extend([sum.x, sum.y, sum.z]);
    }
    forces
}

#[test]
fn forces_are_those_of_all_images() {
    // An open box by all pairs and by lists; periodic ones from many cut-offs to less than one, and atoms in other boxes.
    for (cells, side, away) in
        [(3, 0.0, 0), (5, 0.0, 0), (5, length(5), 0), (5, length(5), 9), (2, length(2), 2), (1, length(1), 1)]
    {
        let atoms = melt::<f64>(cells);
        let start = Engine::<f64>::builder().domain(atoms).law(Motion).step(STEP).build().unwrap();
        let mut places: Vec<[f64; 3]> = (0..4 * cells.pow(3))
            .map(|row| {
                start.state().get("atoms", Position, row).unwrap()
                    + start.state().get("atoms", Velocity, row).unwrap() * 0.05
            })
            .map(|place| place.to_array())
            .collect();
        let expected = forces(&places, side, 4);
        for (row, place) in places.iter_mut().enumerate() {
            place[row % 3] += f64::from((row % 5) as i32 - 2) * side * f64::from(away);
        }
        let count = places.len();
        let atoms = Domain::new("atoms")
            .with(Position, &places)
            .with(Velocity, vec![[0.0; 3]; count])
            .with(Mass, vec![1.0; count]);
        let tiny = 1.0 / (1_u64 << 40) as f64;
        for estimates in [false, true] {
            let builder =
                builder::<f64>(atoms.clone(), side).integrator(SemiImplicitEuler).step(tiny).estimates(estimates);
            let mut engine = builder.build().unwrap();
            engine.steps_of(1, tiny).unwrap();
            let found = engine.state().numbers("atoms", Velocity).unwrap();
            let largest = expected.iter().fold(0.0, |most, force: &f64| f64::max(most, force.abs()));
            let off = found.iter().zip(&expected).fold(0.0, |most, (v, f)| f64::max(most, (v / tiny - f).abs()));
            assert!(off < 1e-11 * largest.max(1.0), "{cells} cells in {side}, {away} away: {off:e} of {largest}");
        }
    }
}

#[test]
fn an_implicit_method_sees_the_same_neighbours() {
    fn run(integrator: impl Integrator + 'static) -> Vec<f64> {
        let mut engine = builder::<f64>(melt(3), length(3)).integrator(integrator).step(1e-4).build().unwrap();
        engine.steps_of(20, 1e-4).unwrap();
        engine.state().numbers("atoms", Position).unwrap()
    }
    let (implicit, explicit) = (run(ImplicitMidpoint::default()), run(RungeKutta4));
    let off = implicit.iter().zip(&explicit).fold(0.0, |most, (a, b)| f64::max(most, (a - b).abs()));
    assert!(off < 1e-6, "{off:e}");
}

#[test]
fn what_is_no_cut_off_is_refused() {
    let fault = |law: LennardJones, side: f64| {
        let builder = Engine::<f64>::builder().domain(melt(2)).constant(PeriodicBox, [[side; 3]]).law(law).law(Motion);
        builder.step(STEP).build().err().unwrap().to_string()
    };
    let negative = fault(LennardJones { cutoff: -1.0, ..LennardJones::default() }, 0.0);
    assert_eq!(
        negative,
        "lennard_jones has no cut-off that neighbours can be found within: a cut-off is a positive number, and a skin is not negative"
    );
    let small = fault(LennardJones::default(), -1.0);
    assert!(small.contains("a length of the box is too small, too large, or no number"), "{small}");
}

/// Attraction that ends at a length in another unit than places have.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position), adds(force: Force), translation_invariant)]
struct InKilometres<R = f64> {
    /// Where it ends.
    #[law(unit = "km", cutoff)]
    end: R,
}

#[kernel]
impl<R: Real> PairLaw<R> for InKilometres<R> {
    fn pair(&self, i: InKilometresRow<R>, j: InKilometresRow<R>) -> R::Vec3 {
        (j.position - i.position) * self.end
    }
}

#[test]
fn a_cut_off_has_the_unit_of_places() {
    let builder = Engine::<f64>::builder().domain(melt(2)).law(InKilometres { end: 1.0 }).law(Motion).step(STEP);
    assert_eq!(
        builder.build().err().unwrap().to_string(),
        "in_kilometres has no cut-off that neighbours can be found within: end is in km, and position in m: declare it in that unit"
    );
}
