//! A property that only some rows have costs only those rows.

use std::sync::atomic::{AtomicU64, Ordering};
use vesper::prelude::*;
use vesper::real::Isa;
use vesper_laws::{Coulomb, Motion};

property! {
    /// Two to the power of the row's number among the charged ones.
    pub Bit: Scalar, "1";
    /// How many rows a row was paired with.
    pub Visits: Scalar, "1", sum;
    /// The sum of the bits of the rows that a row was paired with.
    pub Partners: Scalar, "1", sum;
}

static CALLS: AtomicU64 = AtomicU64::new(0);

/// Counts pairs of charged rows.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(charge: Charge, bit: Bit), adds(visits: Visits, partners: Partners))]
struct Count;

#[kernel]
impl<R: Real> PairLaw<R> for Count {
    fn pair(&self, _i: CountRow<R>, j: CountRow<R>) -> CountOutput<R> {
        CALLS.fetch_add(1, Ordering::Relaxed);
        CountOutput { visits: R::lit(1.0), partners: j.bit }
    }
}

const BODIES: usize = 1000;
const CHARGES: usize = 40;

/// Every 25th row, given backwards.
fn charged() -> Vec<u32> {
    (0..CHARGES as u32).rev().map(|index| 25 * index + 3).collect()
}

fn bodies() -> Domain<f64> {
    let place = |row: usize| [(row % 10) as f64, (row / 10 % 10) as f64, (row / 100) as f64];
    Domain::new("bodies")
        .with(Position, (0..BODIES).map(place).collect::<Vec<_>>())
        .with(Velocity, vec![[0.0; 3]; BODIES])
        .with(Mass, vec![1.0; BODIES])
        .subset(Charge, charged(), vec![1e-6; CHARGES])
        .with(Bit, (0..BODIES).map(|row| 2.0_f64.powi((row / 25) as i32)).collect::<Vec<_>>())
}

/// Runs the counting law once and gives how often each row was visited, and by whom.
fn counted(isa: Isa, backend: Backend) -> (Vec<f64>, Vec<f64>) {
    let mut engine = Engine::<f64>::builder()
        .domain(bodies())
        .law(Count)
        .observe("bodies", Visits)
        .observe("bodies", Partners)
        .isa(isa)
        .backend(backend)
        .threads(3)
        .integrator(SemiImplicitEuler)
        .step(1.0)
        .build()
        .unwrap();
    // Building looks already.
    CALLS.store(0, Ordering::Relaxed);
    engine.advance(1.0).unwrap();
    (engine.state().numbers("bodies", Visits).unwrap(), engine.state().numbers("bodies", Partners).unwrap())
}

#[test]
fn forty_charges_among_a_thousand_bodies_are_forty_times_thirty_nine_halves_pairs() {
    // One row at a time, so that every call of the body is one pair, seen from one of its rows.
    let (visits, _) = counted(Isa::Scalar, Backend::Cpu);
    assert_eq!(CALLS.load(Ordering::Relaxed), 2 * (40 * 39 / 2));
    assert_eq!(visits.iter().sum::<f64>() / 2.0, 40.0 * 39.0 / 2.0);

    for isa in Isa::available() {
        for backend in [Backend::Cpu, Backend::Parallel] {
            let (visits, partners) = counted(isa, backend);
            for row in 0..BODIES {
                // 39 powers of two that sum to all 40 without the row's own are each of the others, once.
                let of_all = 2.0_f64.powi(CHARGES as i32) - 1.0;
                let own = 2.0_f64.powi((row / 25) as i32);
                let expected = if row % 25 == 3 { (39.0, of_all - own) } else { (0.0, 0.0) };
                assert_eq!((visits[row], partners[row]), expected, "row {row}, {isa:?}, {backend:?}");
            }
        }
    }
}

#[test]
fn the_charged_rows_move_as_if_they_were_alone() {
    let run = |domain: Domain<f64>| {
        let builder = Engine::<f64>::builder().domain(domain).law(Coulomb::default()).law(Motion);
        let mut engine = builder.step(1e-2).build().unwrap();
        engine.advance(1.0).unwrap();
        engine.state().numbers("bodies", Position).unwrap()
    };
    let all = run(bodies());
    let mut rows = charged();
    rows.reverse();
    let of_charged = |numbers: &[f64]| -> Vec<f64> {
        rows.iter().flat_map(|&row| numbers[3 * row as usize..][..3].to_vec()).collect()
    };
    let start = State::new([bodies()], []).unwrap().numbers("bodies", Position).unwrap();
    let places: Vec<[f64; 3]> = of_charged(&start).as_chunks::<3>().0.to_vec();
    let alone = run(Domain::new("bodies")
        .with(Position, places)
        .with(Velocity, vec![[0.0; 3]; CHARGES])
        .with(Mass, vec![1.0; CHARGES])
        .with(Charge, vec![1e-6; CHARGES]));
    assert_eq!(of_charged(&all), alone, "bit for bit");
    assert_ne!(of_charged(&all), of_charged(&start));
    assert_eq!(all[..3], start[..3], "an uncharged row stays");
}
