//! The part of the page on many rows: energy and momentum after very many steps, by the way in which pairs are found.

use super::{Page, steps};
use std::path::Path;
use std::time::Instant;
use vesper::column::Values;
use vesper::prelude::*;
use vesper::property::PropertyInfo;
use vesper_cli::assemble;
use vesper_cli::scene::Scene;
use vesper_examples::lennard_jones::{LennardJones, length, melt};
use vesper_laws::{Gravity, Motion};

/// How pairs are found.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Way {
    /// All of them, one by one.
    All,
    /// Far ones together, to this error.
    Far,
    /// Those within a distance, from lists.
    CutOff,
}

/// The error that is asked of far fields.
const ERROR: f64 = 1e-3;
/// Steps of velocity Verlet: of spheres with G = M = a = 1, and of the melt, in Lennard-Jones units.
const STEPS: [f64; 2] = [1.0 / 128.0, 1.0 / 256.0];
/// Cells along an edge of the melt.
const CELLS: usize = 8;

impl Way {
    fn law<P: Precision>(self, builder: Builder<P>) -> Builder<P> {
        let gravity = Gravity { g: 1.0, softening: 1.0 / 16.0 };
        match self {
            Way::All => builder.law(gravity),
            Way::Far => builder.law(gravity.far_field(ERROR)),
            Way::CutOff => builder.law(LennardJones::default()).constant(PeriodicBox, [[length(CELLS); 3]]),
        }
    }

    fn step(self) -> f64 {
        STEPS[usize::from(self == Way::CutOff)]
    }
}

const DOMAIN: &str = "rows";
const THERE: &str = "the rows have it";

/// Places, velocities and masses.
struct Rows([Vec<f64>; 3]);

impl Rows {
    fn of<P: Precision>(engine: &Engine<P>, domain: &str) -> Self {
        let column = |property: PropertyInfo| engine.state().numbers(domain, property).expect(THERE);
        Rows([column(Position::INFO), column(Velocity::INFO), column(Mass::INFO)])
    }

    /// A Plummer sphere in equilibrium.
    fn sphere(count: usize) -> Self {
        let text = format!(
            "[engine]\nstep = 1\nend = 1\n[generate.bodies]\nkind = \"plummer\"\ncount = {count}\nseed = 3\ng = 1\n\
             [[laws]]\nname = \"motion\"\n"
        );
        let scene = Scene::from_text("sphere", &text, Path::new(""), &[]).expect("it is a scene");
        Rows::of(&assemble::engine::<f64>(&scene).expect("it has all that motion reads"), "bodies")
    }

    /// The melt of Lennard-Jones atoms.
    fn melt() -> Self {
        let builder = Engine::<f64>::builder().domain(melt(CELLS)).law(Motion).step(1.0);
        Rows::of(&builder.build().expect("it has all that motion reads"), "atoms")
    }

    fn engine<P: Precision>(&self, way: Way, compensated: bool) -> Engine<P> {
        let [position, velocity, mass] = self.0.clone();
        let domain = Domain::new(DOMAIN).with(Position, Values::new(3, position));
        let domain = domain.with(Velocity, Values::new(3, velocity)).with(Mass, mass);
        let builder = way.law(Engine::builder().domain(domain).law(Motion));
        let builder = builder.integrator(Leapfrog::default()).step(way.step()).threads(1);
        let builder = if compensated { builder.compensated() } else { builder };
        builder.build().expect("the rows have all that the laws read")
    }

    /// The energy of all pairs, in f64.
    fn energy(&self, way: Way) -> f64 {
        let way = if way == Way::Far { Way::All } else { way };
        self.engine::<f64>(way, false).energy().expect("the laws know it").0
    }

    /// The sum of all momenta, by the sum of their sizes.
    fn momentum(&self) -> f64 {
        let [_, velocity, mass] = &self.0;
        let along = |axis: usize| mass.iter().zip(velocity.iter().skip(axis).step_by(3)).map(|(m, v)| m * v);
        let total: f64 = (0..3).map(|axis| along(axis).sum::<f64>().powi(2)).sum::<f64>().sqrt();
        total / (0..3).map(|axis| along(axis).map(f64::abs).sum::<f64>()).sum::<f64>()
    }
}

/// A run, and its line of the table.
fn run<P: Precision>(page: &mut Page, count: u64, (words, way, compensated): (&str, Way, bool), rows: &Rows) {
    let mut engine = rows.engine::<P>(way, compensated);
    // As this precision holds them.
    let before = Rows::of(&engine, DOMAIN);
    let begin = Instant::now();
    steps(&mut engine, count, way.step());
    let each = begin.elapsed().as_secs_f64() * 1e9 / (count as f64 * rows.0[2].len() as f64);
    let after = Rows::of(&engine, DOMAIN);
    let change = after.energy(way) / before.energy(way) - 1.0;
    let kept = if compensated { "yes" } else { "no" };
    page.line(&format!(
        "| {words} | {} | {} | {kept} | {change:+.1e} | {:.1e} | {:.1e} | {each:.0} |",
        rows.0[2].len(),
        P::NAME,
        before.momentum(),
        after.momentum()
    ));
}

/// Spheres and a melt.
pub fn many_rows(page: &mut Page, part: f64) {
    let count = (1e5 * part) as u64;
    page.line(&format!("## {count} steps of many rows\n"));
    page.line(&format!(
        "Velocity Verlet, one thread. Plummer spheres in equilibrium (G = M = a = 1, softening 1/16, step 1/128), and the usual melt of \
         Lennard-Jones atoms (cut-off 2.5, step 1/256), whose energy jumps where pairs come and go at the cut-off. The change of the \
         energy, by all pairs in f64, in parts of it; the sum of all momenta by the sum of their sizes, before and after; \
         far fields are asked for an error of {ERROR:e}.\n"
    ));
    page.line("| pairs | rows | numbers | compensated | energy | momentum before | after | ns per row and step |");
    page.line("|---|---|---|---|---|---|---|---|");
    let (few, many, melt) = (Rows::sphere(1024), Rows::sphere(4096), Rows::melt());
    run::<f64>(page, count, ("all", Way::All, false), &few);
    run::<f64>(page, count, ("all", Way::All, true), &few);
    run::<f32>(page, count, ("all", Way::All, false), &few);
    run::<f32>(page, count, ("all", Way::All, true), &few);
    run::<f64>(page, count, ("far ones together", Way::Far, false), &many);
    run::<f32>(page, count, ("far ones together", Way::Far, false), &many);
    run::<f64>(page, count, ("within a distance", Way::CutOff, false), &melt);
    run::<f32>(page, count, ("within a distance", Way::CutOff, false), &melt);
    page.line("");
}
