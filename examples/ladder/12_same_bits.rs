//! What is the same on any number of threads, in any build, and on any processor: the bits of the state, by their hash.
//!
//! `cargo run --release --example same_bits`, and without `--release`: the same lines. The last column is the hash itself. What uses
//! estimates of the processor's own, far fields among it, gives the same bits on one kind of processor; the rest on every kind.

use vesper::prelude::*;
use vesper_examples::lennard_jones::{LennardJones, length, melt};
use vesper_laws::{Gravity, Motion, Spring, UniformGravity};

const STEPS: u64 = 10;
const STEP: f64 = 1.0 / 256.0;

/// What needs no more than sums, products, divisions and square roots is known to be this everywhere.
const KNOWN: [(&str, &str, u64); 4] = [
    ("all pairs", "f64", 0x5947_1f4a_0bc4_2e9c),
    ("all pairs", "f32", 0xb8c9_7573_d252_90fc),
    ("springs", "f64", 0xab08_9a1b_3888_7b5d),
    ("springs", "f32", 0xd454_e92f_c94d_39f8),
];

/// Bodies in a ball, the same on every machine: whole numbers decide, and no function that machines round differently.
fn ball<P: Precision>(rows: u64) -> Domain<P> {
    let mut word = 1_u64;
    let mut number = || {
        // Knuth's linear congruential generator (MMIX), its upper bits: -1 to 1.
        word = word.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (word >> 40) as f64 / (1_u64 << 23) as f64 - 1.0
    };
    let mut place = || loop {
        let place = [number(), number(), number()];
        if place.iter().map(|x| x * x).sum::<f64>() < 1.0 {
            return place;
        }
    };
    let domain = Domain::new("bodies").with(Position, (0..rows).map(|_| place()).collect::<Vec<_>>());
    domain.with(Velocity, vec![[0.0; 3]; rows as usize]).with(Mass, vec![1.0 / rows as f64; rows as usize])
}

/// A row of springs that hangs from its first body.
fn chain<P: Precision>(builder: Builder<P>, rows: u32) -> Builder<P> {
    let places: Vec<_> = (0..rows).map(|row| [f64::from(row), 0.0, 0.0]).collect();
    let masses: Vec<_> = (0..rows).map(|row| f64::from(row.min(1))).collect();
    let bodies = Domain::new("bodies").with(Position, places).with(Mass, masses);
    let count = rows as usize - 1;
    let springs = Domain::new("springs").link(Ends, "bodies", (1..rows).map(|row| [row - 1, row]));
    let springs = springs.with(Stiffness, vec![1e3; count]).with(RestLength, vec![0.875; count]);
    let builder = builder.domain(bodies.with(Velocity, vec![[0.0; 3]; rows as usize])).domain(springs);
    builder.constant(GravityAcceleration, [[0.0, 0.0, -9.8125]]).law(Spring).law(UniformGravity)
}

/// The hash after some steps on so many threads.
fn hash<P: Precision>(scene: impl Fn(Builder<P>) -> Builder<P>, threads: usize) -> Result<u64, Faults> {
    let builder = scene(Engine::builder()).law(Motion).integrator(Leapfrog::default()).step(STEP);
    let mut engine = builder.backend(Backend::Parallel).threads(threads).strict().build()?;
    engine.steps_of(STEPS, STEP)?;
    Ok(engine.state().hash())
}

fn show<P: Precision>(words: &str, scene: impl Fn(Builder<P>) -> Builder<P>) -> Result<(), Faults> {
    let one = hash(&scene, 1)?;
    for threads in [2, 3, 7] {
        assert_eq!(hash(&scene, threads)?, one, "{words} in {} on {threads} threads", P::NAME);
    }
    for (.., known) in KNOWN.iter().filter(|(of, precision, _)| *of == words && *precision == P::NAME) {
        assert_eq!(one, *known, "{words} in {}", P::NAME);
    }
    println!("{words:<42} {} {one:016x}", P::NAME);
    Ok(())
}

fn scenes<P: Precision>() -> Result<(), Faults> {
    let gravity = Gravity { g: 1.0, softening: 0.0625 };
    let atoms = |builder: Builder<P>| {
        builder.domain(melt(6)).constant(PeriodicBox, [[length(6); 3]]).law(LennardJones::default())
    };
    show::<P>("all pairs", |builder| builder.domain(ball(1100)).law(gravity).estimates(false))?;
    show::<P>("all pairs, with estimates", |builder| builder.domain(ball(1100)).law(gravity))?;
    show::<P>("far pairs together", |builder| builder.domain(ball(5000)).law(gravity.far_field(1e-3)))?;
    show::<P>("pairs within a distance", |builder| atoms(builder).estimates(false))?;
    show::<P>("pairs within a distance, with estimates", atoms)?;
    show::<P>("springs", |builder| chain(builder, 5000))
}

fn main() -> Result<(), Faults> {
    println!("after {STEPS} steps on 1, 2, 3 and 7 threads");
    scenes::<f64>()?;
    scenes::<f32>()
}
