//! What is left after very many steps: where rounding and drift decide, and not the order of a method.
//!
//! In: problems with known answers. Out: `benches/results/endurance/README.md`. Takes some half an hour; `-- --test` runs a
//! thousandth of each.

mod many_rows;

use std::fmt::Write;
use std::path::Path;
use std::time::Instant;
use vesper::prelude::*;
use vesper::property::PropertyInfo;
use vesper_benches::Run as Mode;
use vesper_cli::assemble::integrators::integrator;
use vesper_cli::study::{Problem as Study, read};
use vesper_laws::Motion;
use vesper_laws::reference::{Cyclotron, Kepler, Problem};

/// A page of tables.
struct Page(String);

impl Page {
    fn line(&mut self, words: &str) {
        println!("{words}");
        // Writing to a string cannot fail.
        _ = writeln!(self.0, "{words}");
    }
}

/// A part of the page: its name, and what writes it.
type Part = (&'static str, fn(&mut Page, f64));

/// The parts of the page.
const PARTS: [Part; 5] = [
    ("endurance/gyrations", gyrations),
    ("endurance/oscillations", oscillations),
    ("endurance/outer_planets", outer_planets),
    ("endurance/brouwer", brouwer),
    ("endurance/many_rows", many_rows::many_rows),
];

fn main() {
    let mode = Mode::from_arguments();
    // What is asked for, and what is enough to see that it works.
    let part = if mode == Mode::Measure { 1.0 } else { 1e-3 };
    let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("results");
    let asked: Vec<_> = PARTS.iter().filter(|(name, _)| mode.wants(name)).collect();
    for (name, run) in &asked {
        let begin = Instant::now();
        let mut page = Page(String::new());
        run(&mut page, part);
        if mode == Mode::Measure {
            let minutes = begin.elapsed().as_secs_f64() / 60.0;
            page.line(&format!("\n({minutes:.0} minutes)\n"));
            let file = results.join(name).with_extension("md");
            std::fs::create_dir_all(file.parent().expect("it is in a folder")).expect("a folder for results");
            std::fs::write(file, &page.0).expect("a part of the page");
        }
    }
    if mode == Mode::Measure && !asked.is_empty() {
        let head = "# After very many steps\n\nMade by `cargo bench -- endurance`; a part alone by its name, `cargo bench -- \
            brouwer`.\n\n";
        let known =
            PARTS.iter().filter_map(|(name, _)| std::fs::read_to_string(results.join(name).with_extension("md")).ok());
        let page: String = core::iter::once(head.to_owned()).chain(known).collect();
        std::fs::write(results.join("endurance/README.md"), page).expect("the page");
    }
}

/// Whole steps of a run, of which there are too many for one call that could not be stopped.
fn steps<P: Precision>(engine: &mut Engine<P>, count: u64, step: f64) {
    engine.steps_of(count, step).expect("the run ends");
}

/// A charge in a uniform magnetic field.
fn gyrations(page: &mut Page, part: f64) {
    let turns = 1e6 * part;
    page.line(&format!("## {turns:.0} gyrations in a uniform magnetic field\n"));
    page.line("The relative change of the energy. A random walk of one rounding, 1.1e-16, per step comes to the last column.\n");
    page.line("| integrator | omega h | compensated | steps | energy | walk | ns per step |");
    page.line("|---|---|---|---|---|---|---|");
    let problem = Cyclotron::default();
    for (name, step, compensated) in [
        ("boris", 0.1, false),
        ("boris", 0.1, true),
        ("boris", 0.5, false),
        ("boris", 0.5, true),
        ("boris_8", 2.0, false),
    ] {
        let count = (turns * core::f64::consts::TAU / step).round() as u64;
        let made = (integrator(name).expect("it is known").make)(&|_, usual| usual);
        let builder = problem.setup(Engine::<f64>::builder()).boxed_integrator(made).step(step);
        let mut engine = if compensated { builder.compensated() } else { builder }.build().expect("it fits");
        let energy = engine.energy().expect("it is known").0;
        let begin = Instant::now();
        steps(&mut engine, count, step);
        let each = begin.elapsed().as_secs_f64() * 1e9 / count as f64;
        let change = (engine.energy().expect("it is known").0 / energy - 1.0).abs();
        let walk = 1.1e-16 * (count as f64).sqrt();
        let kept = if compensated { "yes" } else { "no" };
        page.line(&format!("| {name} | {step} | {kept} | {count} | {change:.0e} | {walk:.0e} | {each:.0} |"));
    }
    page.line("");
}

/// A spring from the origin: F = -k x, k = 1 N/m.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position), adds(force: Force))]
struct Pull;

#[kernel]
impl<R: Real> RowLaw<R> for Pull {
    fn row(&self, body: PullRow<R>) -> R::Vec3 {
        -body.position
    }
}

/// A step of the oscillator, in s: so short that the method itself is off by no more than 2e-5 after a million periods, and no
/// rational part of one, for roundings that come again after some periods hold the phase fast.
const STEP: f64 = 0.2;

/// One mass on a spring.
fn oscillations(page: &mut Page, part: f64) {
    let periods = 1e6 * part;
    page.line(&format!("## {periods:.0} periods of an oscillator\n"));
    page.line(&format!(
        "`symplectic_8`, steps of {STEP} s of 2 pi; errors of place and velocity by their largest values, after the last.\n"
    ));
    page.line("| numbers | compensated | error | s |");
    page.line("|---|---|---|---|");
    for compensated in [false, true] {
        oscillate::<f32>(page, periods, compensated);
    }
    oscillate::<f64>(page, periods, false);
    page.line("");
}

fn oscillate<P: Precision>(page: &mut Page, periods: f64, compensated: bool) {
    let bodies = Domain::new("bodies").with(Position, [[1.0, 0.0, 0.0]]).with(Velocity, [[0.0; 3]]).with(Mass, [1.0]);
    let builder = Engine::<P>::builder().domain(bodies).law(Pull).law(Motion).integrator(Symplectic8::default());
    let builder = builder.step(STEP);
    let mut engine = if compensated { builder.compensated() } else { builder }.build().expect("it fits");
    let begin = Instant::now();
    steps(&mut engine, (periods * core::f64::consts::TAU / STEP).round() as u64, STEP);
    let seconds = begin.elapsed().as_secs_f64();
    let at = |property: PropertyInfo| engine.state().numbers("bodies", property).expect("it is there")[0];
    let (sine, cosine) = engine.time().sin_cos();
    let error = f64::max((at(Position::INFO) - cosine).abs(), (at(Velocity::INFO) + sine).abs());
    let kept = if compensated { "yes" } else { "no" };
    page.line(&format!("| {} | {kept} | {error:.0e} | {seconds:.1} |", P::NAME));
}

/// The straight line through points, by least squares: its slope, and the slope's standard error.
fn line_through(points: &[(f64, f64)]) -> (f64, f64) {
    let count = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let squares: f64 = points.iter().map(|point| (point.0 - x).powi(2)).sum();
    let slope = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum::<f64>() / squares;
    let rest: f64 = points.iter().map(|point| (point.1 - y - slope * (point.0 - x)).powi(2)).sum();
    (slope, (rest / (count - 2.0) / squares).sqrt())
}

/// Runs of the outer planets, from starts beside each other.
const STARTS: usize = 8;

/// Sun and outer planets.
fn outer_planets(page: &mut Page, part: f64) {
    let count = (1e6 * part) as u64;
    page.line(&format!("## {count} steps of the outer solar system\n"));
    page.line(
        "The relative error of the energy of 8 runs, whose starts differ by parts of 1e-6: the largest, and the slope of a line \
         through 1000 of them: its mean over the runs; its standard error in one run, which an oscillation of the error makes; \
         and that of the mean by the spread of the runs, which a random walk of roundings makes. A trend is a mean that is many \
         times both.\n",
    );
    page.line(
        "| integrator | step, days | compensated | largest | trend over a run | error in a run | error by the spread |",
    );
    page.line("|---|---|---|---|---|---|---|");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("../examples/references.json")).expect("the cases can be read");
    let case = read(&text).expect("they are cases").into_iter().find(|case| case.id == "outer_solar_system");
    let problem = Study::of_case(case.expect("it is among them"));
    for (name, days, compensated) in [
        ("leapfrog", 10.0, false),
        ("symplectic_4", 50.0, false),
        ("symplectic_6", 100.0, false),
        ("symplectic_8", 100.0, false),
        ("symplectic_8", 100.0, true),
    ] {
        // The case counts time in days.
        let known = integrator(name).expect("it is known");
        let configure = |builder: Builder<f64>| {
            let builder = builder.boxed_integrator((known.make)(&|_, usual| usual)).step(days);
            if compensated { builder.compensated() } else { builder }
        };
        let (mut slopes, mut noises, mut largest) = (Vec::new(), Vec::new(), 0.0_f64);
        for start in 0..STARTS {
            let mut engine = problem.engine(configure).expect("it fits");
            let sun = engine.state().get("bodies", Position, 0).expect("it is there");
            let moved = sun + DVec3::new(1e-6 * start as f64, 0.0, 0.0);
            engine.state_mut().set("bodies", Position, 0, moved).expect("it is finite");
            let begun = engine.energy().expect("it is known").0;
            let mut points = Vec::new();
            let shown = count.min(1000);
            for number in 0..shown {
                steps(&mut engine, count / shown, days);
                let error = (engine.energy().expect("it is known").0 - begun) / begun.abs();
                largest = largest.max(error.abs());
                points.push((number as f64 / shown as f64, error));
            }
            let (slope, noise) = line_through(&points);
            slopes.push(slope);
            noises.push(noise);
        }
        let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
        let (slope, noise) = (mean(&slopes), mean(&noises));
        let squares: Vec<f64> = slopes.iter().map(|one| (one - slope).powi(2)).collect();
        let spread = (mean(&squares) / (squares.len() as f64 - 1.0)).sqrt();
        let kept = if compensated { "yes" } else { "no" };
        page.line(&format!("| {name} | {days} | {kept} | {largest:.1e} | {slope:.1e} | {noise:.1e} | {spread:.1e} |"));
    }
    page.line("");
}

/// How the energy error of the method that comes to rounding grows.
fn brouwer(page: &mut Page, part: f64) {
    let (count, group) = (64, 8);
    let orbits = 8192.0 * part;
    page.line(&format!("## {count} times {orbits:.0} orbits with `gauss_radau_15`\n"));
    page.line(&format!(
        "The root of the mean square of the relative energy error of {count} orbits of eccentricities 0.1 to 0.45, and their \
         mean with its standard error, at times that double. A random walk grows as the root of the time (Brouwer 1937), a \
         systematic error, whose mean is not 0, as the time.\n"
    ));
    page.line("| orbits | energy | mean |");
    page.line("|---|---|---|");
    let mut engines: Vec<(Engine<f64>, f64)> = (0..count)
        .map(|number| {
            let problem = Kepler { eccentricity: 0.1 + 0.35 * f64::from(number) / f64::from(count) };
            let builder = problem.setup(Engine::<f64>::builder()).integrator(GaussRadau15::default());
            let mut engine = builder.build().expect("it fits");
            let energy = engine.energy().expect("it is known").0;
            (engine, energy)
        })
        .collect();
    let root = |errors: &[f64]| (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt();
    // Of all, and of each group: how far the power of one path is from that of another is known by these alone.
    let mut points = vec![Vec::new(); 1 + count as usize / group];
    let (mut done, mut next) = (0.0, orbits / 64.0);
    while next <= orbits {
        let errors: Vec<f64> = engines
            .iter_mut()
            .map(|(engine, begun)| {
                engine.advance((next - done) * core::f64::consts::TAU).expect("the run ends");
                engine.energy().expect("it is known").0 / *begun - 1.0
            })
            .collect();
        let all = root(&errors);
        let mean = errors.iter().sum::<f64>() / f64::from(count);
        for (points, errors) in points.iter_mut().zip(core::iter::once(&errors[..]).chain(errors.chunks(group))) {
            points.push((next.ln(), root(errors).max(1e-17).ln()));
        }
        page.line(&format!("| {next:.0} | {all:.1e} | {mean:+.1e} +- {:.1e} |", all / f64::from(count).sqrt()));
        (done, next) = (next, 2.0 * next);
    }
    let powers: Vec<f64> = points.iter().map(|points| line_through(points).0).collect();
    let spread =
        powers[1..].iter().map(|power| (power - powers[0]).powi(2)).sum::<f64>().sqrt() / (powers.len() - 1) as f64;
    page.line(&format!("\nThe power of the time by which it grows: {:.2} +- {spread:.2}.", powers[0]));
}
