//! Gravitation of all pairs: a law's body of three lines beside the direct sums of `particular`, beside loops written by hand for
//! this law and this processor, and beside the same law in another crate.
//!
//! A Plummer sphere of equal masses, softened. Errors are root mean squares of |a - a_ref| / |a_ref| over a sample of the
//! bodies, whose accelerations are summed in f64 from the same places. Rates count every ordered pair, however often a loop
//! looks at it. Two threads stand beside two engines on a thread each, which is what the machine has for two.
//!
//! `RUSTFLAGS="-C target-cpu=native" cargo bench --bench pairs` builds `particular` for this very processor; it is the study
//! `pairs_native` of the summary. The law's loops are chosen at run time, so that they are the same in both.

use foreign_gravity::Gravity as ForeignGravity;
use particular::ComputeMethod;
use particular::sequential::BruteForceSoftenedSIMD;
use particular::storage::{ParticleSystem, PointMass};
use vesper::prelude::*;
use vesper::real::Isa;
use vesper_benches::hand::direct::{Attracting, Loop, f32_loops, f64_loops};
use vesper_benches::scenes::{Cloud, STEP};
use vesper_benches::{Case, Contender, Race, Run, Summary, Time, criterion};
use vesper_laws::{Gravity, Motion};

const SIZES: [usize; 3] = [1536, 4096, 16_384];
/// From the origin, in scale lengths: numbers of f32 have their last digit at 6e-5 there.
const FAR: f64 = 1000.0;
const SOFTENING: f64 = 1.0 / 128.0;

const STAYS: &str = "the bodies stay finite";

/// The stock law, or that of another crate, moves the bodies.
fn engine<P: Precision>(bodies: &Cloud, foreign: bool, threads: usize, isa: Isa) -> Engine<P> {
    let builder = Engine::builder().domain(bodies.domain()).law(Motion);
    let builder = if foreign {
        builder.law(ForeignGravity { g: 1.0, softening: SOFTENING })
    } else {
        builder.law(Gravity { g: 1.0, softening: SOFTENING })
    };
    let builder = builder.integrator(SemiImplicitEuler).step(STEP).threads(threads).isa(isa).strict();
    builder.build().expect("the scene has all that the laws read")
}

fn step<'a, P: Precision>(name: &'static str, mut engine: Engine<P>) -> Contender<'a> {
    Contender::new(name, move || engine.steps_of(1, STEP).expect(STAYS))
}

/// Loops by hand, each with its error.
fn by_hand<'a, P: Precision>(bodies: &Cloud, loops: Vec<Loop<P>>) -> Vec<(Contender<'a>, f64)> {
    let softening_squared = P::from_f64(SOFTENING * SOFTENING);
    let contender = |(name, run): Loop<P>| {
        let mut columns = Attracting::<P>::new(&bodies.position, bodies.mass());
        // SAFETY: it was found on this processor.
        unsafe { run(&mut columns, softening_squared) };
        let error = bodies.error(SOFTENING, |row| [0, 1, 2].map(|axis| columns.acceleration[axis][row]));
        // SAFETY: as above.
        (Contender::new(name, move || unsafe { run(&mut columns, softening_squared) }), error)
    };
    loops.into_iter().map(contender).collect()
}

/// The best SIMD variant of `particular` in this precision, on one thread; with its error.
macro_rules! particular {
    ($bodies:expr, $real:ty, $vector:ty, $lanes:literal) => {{
        let mass = $bodies.mass() as $real;
        let points: Vec<PointMass<$vector, $real>> = $bodies
            .position
            .iter()
            .map(|place| {
                let [x, y, z] = place.map(|number| number as $real);
                PointMass::new(<$vector>::new(x, y, z), mass)
            })
            .collect();
        let run = move || {
            let system = ParticleSystem { affected: &points[..], massive: &points[..] };
            BruteForceSoftenedSIMD::<$lanes, $real> { softening: SOFTENING as $real }.compute(system)
        };
        let found = run();
        let error = $bodies.error(SOFTENING, |row| [found[row].x, found[row].y, found[row].z].map(f64::from));
        (Contender::new("particular", move || drop(std::hint::black_box(run()))), error)
    }};
}

fn study<'a, P: Precision>(
    (run, n): (Run, usize),
    bodies: &Cloud,
    summary: &mut Summary,
    peers: Vec<(Contender<'a>, f64)>,
) {
    let widest = Isa::detect();
    let error = bodies.error_of_step(SOFTENING, &mut engine::<P>(bodies, false, 1, widest));
    assert!(error < 16.0 * P::EPSILON, "{n} in {}: an error of {error}", P::NAME);
    let narrow = Isa::available().into_iter().rev().nth(1).unwrap_or(widest);
    let (mut contenders, errors): (Vec<_>, Vec<_>) = peers.into_iter().unzip();
    let peers = contenders.len();
    // Beside the thread that calls.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let mut both = [(); 2].map(|()| engine::<P>(bodies, false, 1, widest));
    contenders.push(step("stock law", engine::<P>(bodies, false, 1, widest)));
    contenders.push(step("foreign law", engine::<P>(bodies, true, 1, widest)));
    contenders.push(step("stock law on 2 threads", engine::<P>(bodies, false, 2, widest)));
    contenders.push(step("stock law in narrower lanes", engine::<P>(bodies, false, 1, narrow)));
    contenders.push(Contender::new("two engines at once", move || {
        let [a, b] = &mut both;
        pool.in_place_scope(|scope| {
            scope.spawn(|_| a.steps_of(1, STEP).expect(STAYS));
            b.steps_of(1, STEP).expect(STAYS);
        });
    }));
    let pairs = (n * (n - 1)) as f64;
    let times = Race::default().run(run, pairs, &mut contenders);
    let (peer_times, ours) = times.split_at(peers);
    let [stock, foreign, two, narrower, at_once] = ours[..] else { return };
    let beside: Vec<(Time, Option<f64>)> = peer_times.iter().copied().zip(errors.iter().copied().map(Some)).collect();
    let case = |name, threads| Case { name, n, threads, precision: P::NAME, unit: "ns/pair", error: Some(error) };
    summary.add(case("gravity of all pairs", 1), stock, &beside);
    summary.add(case("foreign law", 1), foreign, &[(stock, Some(error))]);
    // What two threads could do at best: each has an engine of its own, so that one piece of work is two.
    let half = |time: f64| time / 2.0;
    let Time { name, median, low, high } = at_once;
    let limit = Time { name, median: half(median), low: half(low), high: half(high) };
    summary.add(case("gravity of all pairs", 2), two, &[(stock, Some(error)), (limit, Some(error))]);
    summary.add(case("gravity in narrower lanes", 1), narrower, &beside);
    if run == Run::Measure {
        for (time, error) in peer_times.iter().zip(&errors).chain([(&stock, &error), (&two, &error)]) {
            println!("    {:<26} {:.2e} ordered pairs per second, rms error {error:.1e}", time.name, 1e9 / time.median);
        }
    }
}

fn main() -> std::io::Result<()> {
    let run = Run::from_arguments();
    let (mut summary, mut lines) = (Summary::new("pairs", run), criterion());
    for n in if run == Run::Test { &SIZES[..1] } else { &SIZES } {
        let bodies = Cloud::plummer(*n, 0.0);
        let far = Cloud::plummer(*n, FAR);
        let far = far.error_of_step(SOFTENING, &mut engine::<f32>(&far, false, 1, Isa::detect()));
        println!("pairs     {n} bodies, {FAR} scale lengths off, in f32: rms error {far:.1e}");
        assert!(far < 3e-7, "the error is that of places in f32, wherever they are");
        if run.wants(&format!("pairs/f32/{n}")) {
            let mut peers = by_hand(&bodies, f32_loops());
            peers.push(particular!(bodies, f32, ultraviolet::Vec3, 8));
            study::<f32>((run, *n), &bodies, &mut summary, peers);
        }
        if run.wants(&format!("pairs/f64/{n}")) {
            let mut peers = by_hand(&bodies, f64_loops());
            peers.push(particular!(bodies, f64, ultraviolet::DVec3, 4));
            study::<f64>((run, *n), &bodies, &mut summary, peers);
        }
    }
    let bodies = Cloud::plummer(SIZES[0], 0.0);
    let mut line = [step("stock law", engine::<f32>(&bodies, false, 1, Isa::detect()))];
    Race::lines(&mut lines, "pairs/f32/1536", (SIZES[0] * (SIZES[0] - 1)) as f64, &mut line);
    lines.final_summary();
    summary.write()
}
