//! Spheres of influence beside all pairs: what an evaluation costs, and how far the accelerations are off.
//!
//! The Sun, the planets and the Moon in 1969, and test particles of 1 kg on all sides, from 0.3 to 40 au; both laws give forces
//! from the same places. Once the particles have spheres of their own, once not. The error is the root mean square of
//! |a - a_ref| / |a_ref| over the particles, for accelerations of all pairs in f64, which the table calls an error of the peer.

use vesper::prelude::*;
use vesper_benches::{Case, Contender, Race, Random, Run, Summary, criterion};
use vesper_laws::{Gravity, HierarchicalGravity};

const SIZES: [usize; 5] = [10, 100, 1000, 10_000, 100_000];
/// Without the peer, whose evaluation takes minutes.
const MOST: usize = 1_000_000;
const G: f64 = 6.674_30e-11;
const AU: f64 = 1.495_978_707e11;
const STAYS: &str = "forces are numbers";

/// Mass in kg and place in au of Sun, planets and Moon on 1969-07-30 (JPL DE441), rounded.
const ATTRACTORS: [(f64, [f64; 3]); 11] = [
    (1.988_41e30, [0.004_487, 0.000_931, 0.000_337]),
    (3.301e23, [-0.328_767, 0.102_646, 0.089_256]),
    (4.867e24, [0.694_812, 0.216_911, 0.053_776]),
    (5.972e24, [0.616_611, -0.742_057, -0.321_842]),
    (7.346e22, [0.618_443, -0.743_442, -0.322_571]),
    (6.417e23, [0.351_145, -1.254_745, -0.584_985]),
    (1.898_52e27, [-5.339_744, -1.038_220, -0.314_856]),
    (5.684_6e26, [7.789_929, 4.734_338, 1.620_111]),
    (8.682e25, [-18.257_874, -1.282_326, -0.302_931]),
    (1.024_31e26, [-15.970_382, -23.990_008, -9.421_835]),
    (1.462e22, [-30.472_859, -0.972_999, 8.877_035]),
];

/// The first bodies, and particles; of ten bodies Pluto is missing.
struct Bodies {
    position: Vec<[f64; 3]>,
    mass: Vec<f64>,
}

impl Bodies {
    fn new(count: usize) -> Self {
        let mut random = Random::new(4);
        let attractors = ATTRACTORS.iter().take(count);
        let (mut mass, mut position): (Vec<f64>, Vec<[f64; 3]>) =
            attractors.map(|(mass, at)| (*mass, at.map(|along| along * AU))).unzip();
        while position.len() < count {
            let towards = random.direction();
            // As many at each order of distance.
            let distance = AU * random.between(0.3_f64.ln(), 40.0_f64.ln()).exp();
            position.push(towards.map(|x| x * distance));
            mass.push(1.0);
        }
        Bodies { position, mass }
    }

    fn engine<P: Precision>(&self, law: impl Listing) -> Engine<P> {
        let domain = Domain::new("bodies").with(Position, &self.position).with(Mass, &self.mass);
        let builder = Engine::builder().domain(domain).law(law).observe("bodies", Force);
        let builder = builder.integrator(SemiImplicitEuler).step(1.0).backend(Backend::Cpu);
        builder.strict().build().expect("the scene has all that the laws read")
    }

    /// The error of the forces of one engine by those of another one, at most so many rows of particles.
    fn error<P: Precision>(&self, found: &mut Engine<P>) -> f64 {
        found.steps_of(1, 1.0).expect(STAYS);
        let found = found.state().numbers("bodies", Force).expect("the law gives forces");
        let (mut squares, mut sample) = (0.0, 0.0);
        let particles = if self.mass.len() > ATTRACTORS.len() { ATTRACTORS.len() } else { 1 };
        for i in (particles..self.mass.len()).step_by(self.mass.len().div_ceil(1000)) {
            let mut exact = [0.0; 3];
            for (place, mass) in self.position.iter().zip(&self.mass) {
                let d = [0, 1, 2].map(|axis| place[axis] - self.position[i][axis]);
                let r2 = d.iter().map(|d| d * d).sum::<f64>();
                if r2 > 0.0 {
                    (0..3).for_each(|axis| exact[axis] += G * mass * d[axis] / (r2 * r2.sqrt()));
                }
            }
            let off: f64 = (0..3).map(|axis| (found[3 * i + axis] / self.mass[i] - exact[axis]).powi(2)).sum();
            squares += off / exact.iter().map(|a| a * a).sum::<f64>();
            sample += 1.0;
        }
        (squares / sample).sqrt()
    }
}

fn evaluation<'a, P: Precision>(name: &'static str, mut engine: Engine<P>) -> Contender<'a> {
    Contender::new(name, move || engine.steps_of(1, 1.0).expect(STAYS))
}

fn main() -> std::io::Result<()> {
    let run = Run::from_arguments();
    let (mut summary, mut lines) = (Summary::new("hierarchy", run), criterion());
    let hierarchical = |lightest| HierarchicalGravity { g: G, softening: 0.0, lightest };
    for n in if run == Run::Test { &SIZES[..3] } else { &SIZES } {
        let n = *n;
        if !run.wants(&format!("hierarchy/f64/{n}")) {
            continue;
        }
        let bodies = Bodies::new(n);
        let error = bodies.error::<f64>(&mut bodies.engine(hierarchical(1e10)));
        let every = bodies.error::<f64>(&mut bodies.engine(hierarchical(0.0)));
        let peer = bodies.error::<f64>(&mut bodies.engine(Gravity { g: G, softening: 0.0 }));
        assert!(peer < 1e-14 && error < 0.1 && every < 0.1, "{n}: {error:e}, {every:e}, of all pairs {peer:e}");
        let mut contenders = [
            evaluation::<f64>("spheres", bodies.engine(hierarchical(1e10))),
            evaluation::<f64>("spheres of particles too", bodies.engine(hierarchical(0.0))),
            evaluation::<f64>("gravity of all pairs", bodies.engine(Gravity { g: G, softening: 0.0 })),
        ];
        // Rounds of seconds are long enough.
        let race = if n > 10_000 { Race { rounds: 3, ..Race::default() } } else { Race::default() };
        let times = race.run(run, n as f64, &mut contenders);
        let [spheres, all_spheres, pairs] = times[..] else { continue };
        let case = |name, error| Case { name, n, threads: 1, precision: "f64", unit: "ns/row", error: Some(error) };
        summary.add(case("spheres of influence", error), spheres, &[(pairs, Some(peer))]);
        summary.add(case("spheres of particles too", every), all_spheres, &[(pairs, Some(peer))]);
    }
    if run == Run::Measure && run.wants(&format!("hierarchy/f64/{MOST}")) {
        let bodies = Bodies::new(MOST);
        let mut contenders = [
            evaluation::<f64>("spheres", bodies.engine(hierarchical(1e10))),
            evaluation::<f64>("spheres of particles too", bodies.engine(hierarchical(0.0))),
        ];
        for time in (Race { rounds: 5, ..Race::default() }).run(run, MOST as f64, &mut contenders) {
            println!("hierarchy n={MOST} {:<26} {:>9.3} ns/row", time.name, time.median);
        }
    }
    let bodies = Bodies::new(1000);
    let mut line = [evaluation::<f64>("spheres", bodies.engine(hierarchical(1e10)))];
    Race::lines(&mut lines, "hierarchy/f64/1000", 1000.0, &mut line);
    lines.final_summary();
    summary.write()
}
