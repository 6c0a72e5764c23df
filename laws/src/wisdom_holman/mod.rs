//! The splitting of Wisdom and Holman: rows go round those before them as Kepler says, and are kicked by what disturbs them.
//!
//! Order 2 in the step times the part that disturbances are of the whole, with a corrector far less; one evaluation per
//! step. Symplectic: no drift of energy. For planets, moons, satellites: any rows that one of them dominates, in whatever
//! further laws there are. A kick asks the laws for their rates and takes the pull off that the drift has accounted for; so the
//! method is right whatever the laws are, and efficient where the pull is the most of them. Two rows alone are exact in one
//! step of any length.
//!
//! The drift is a Kepler step in Jacobi coordinates, in the order of the rows, the heaviest one first: inner ones should stand
//! before outer ones. Rows that pass close by each other, or orbits that cross, want another integrator. The step should be a
//! twentieth of the shortest period, and also resolve the passage of an eccentric orbit through its pericentre.
//!
//! The method knows Newton's law from the laws of the run: `gravity` and its `g`, or `gravity_by_parameter`. For a law of
//! another name, `g` is given. Where it is wrong, or forces are softened, the kicks mend it: order 2 still, but in the step
//! itself.
//!
//! Between steps the state is kept as the method sees it: after the corrector, in the middle of a drift, in relative
//! coordinates with their rounding errors. Before somebody looks at it, it is brought to the end of the step, and undone what the
//! corrector did, on a copy: the steps do not feel it. So many steps in one frame are cheap, and a step in each frame is
//! not, with a corrector of high order.
//!
//! Where a force depends on a velocity a kick is taken by the midpoint rule, two evaluations: order 2 in this force, and
//! symplectic no longer in it.
//!
//! Sources: Wisdom, Holman, AJ 102 (1991) 1528; Rein, Tamayo, MNRAS 452 (2015) 376; for the kernel Wisdom, Holman, Touma, Fields
//! Inst. Commun. 10 (1996) 217, their lazy implementer's method; Rein, Tamayo, Brown, MNRAS 489 (2019) 4632, 2.3.

mod corrector;
mod kepler_step;
mod orbits;
mod side_by_side;

pub use kepler_step::{KeplerStep, kepler_step};

use orbits::{Hierarchy, Orbits, Which};
use side_by_side::Drift;
use vesper::prelude::*;
use vesper::real::Isa;

/// Wisdom and Holman's splitting: order 2 in the step, times the part that disturbances are of the whole.
#[derive(Clone, Debug)]
pub struct WisdomHolman {
    /// Constant of gravitation by which masses pull, in m^3 kg^-1 s^-2; without one, that of the law.
    pub g: Option<f64>,
    /// Order of the symplectic corrector: 3, 5, 7, 11 or 17; 0 for none.
    pub corrector: u32,
    /// Whether a kick is that of places moved by it, which takes away what is of second order in the disturbances: two
    /// evaluations per step, order 4. Only with a corrector.
    pub kernel: bool,
    isa: Isa,
    /// The quantities of this run, once they are found.
    bound: Option<Box<Bound>>,
    /// Rows as the method sees them, where they still hold.
    held: Option<Box<Held>>,
    /// Rows moved, where a kick looks at them.
    trial: Box<Orbits>,
    /// Room for what is read and written.
    rates: Vec<f64>,
    numbers: Vec<f64>,
    disturbances: Vec<f64>,
}

/// What is read and written.
#[derive(Clone, Debug)]
struct Bound {
    position: Quantity,
    velocity: Quantity,
    hierarchy: Hierarchy,
    /// Whether a force depends on a velocity.
    turns: bool,
}

/// Rows between steps.
#[derive(Clone, Debug)]
struct Held {
    orbits: Orbits,
    /// The length of the steps, in s.
    step: f64,
    /// What is left to drift, in s.
    left: f64,
}

const NAME: &str = "wisdom_holman";
const HIGH_NAME: &str = "wisdom_holman_high";

impl WisdomHolman {
    /// Without a corrector: one evaluation per step.
    pub fn new() -> Self {
        WisdomHolman {
            g: None,
            corrector: 0,
            kernel: false,
            isa: Isa::detect(),
            bound: None,
            held: None,
            trial: Box::default(),
            rates: Vec::new(),
            numbers: Vec::new(),
            disturbances: Vec::new(),
        }
    }

    /// With the corrector of order 17 and the kernel: two evaluations per step, order 4.
    pub fn high() -> Self {
        WisdomHolman { corrector: 17, kernel: true, ..WisdomHolman::new() }
    }

    /// With this constant of gravitation, in m^3 kg^-1 s^-2, whatever the laws say.
    #[must_use]
    pub fn with_g(mut self, g: f64) -> Self {
        self.g = Some(g);
        self
    }

    /// With a symplectic corrector of order 3, 5, 7, 11 or 17; 0 for none.
    #[must_use]
    pub fn with_corrector(mut self, order: u32) -> Self {
        self.corrector = order;
        self
    }
}

impl Default for WisdomHolman {
    fn default() -> Self {
        WisdomHolman::new()
    }
}

/// What rows pull by.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pull {
    /// The constant of gravitation times their mass.
    Mass(f64),
    /// Their parameter.
    Parameter,
}

fn pull(given: Option<f64>, structure: &Structure) -> Option<Pull> {
    let of = |name: &str| structure.parameters.iter().find(|(parameter, _)| parameter == name).map(|(_, value)| *value);
    match (given.or_else(|| of("gravity.g")), of("gravity_by_parameter.softening")) {
        (Some(g), _) => Some(Pull::Mass(g)),
        (None, Some(_)) => Some(Pull::Parameter),
        (None, None) => None,
    }
}

impl WisdomHolman {
    fn refused(&self, need: &str, found: String, mend: &str) -> Fault {
        let (integrator, need, mend) = (self.name().to_owned(), need.to_owned(), mend.to_owned());
        Fault::Integrator { integrator, need, found, mend }
    }

    /// Finds the quantities, and shares the masses.
    fn bind(&self, system: &dyn System) -> Result<Box<Bound>, Fault> {
        let structure = system.structure();
        let domain =
            structure.coordinates.first().and_then(|name| name.rsplit_once('.')).map_or("", |(domain, _)| domain);
        let pull = pull(self.g, structure).unwrap_or(Pull::Mass(0.0));
        let weight = if pull == Pull::Parameter { "standard_gravitational_parameter" } else { "mass" };
        let find = |property: &str| {
            system.find(&format!("{domain}.{property}")).ok_or_else(|| {
                let found = format!("{domain}.{property} is not there for all rows");
                self.refused("places, velocities and masses of all rows", found, "give it to every row")
            })
        };
        let (position, velocity, weights) = (find("position")?, find("velocity")?, find(weight)?);
        let mut parameters = vec![0.0; weights.rows()];
        system.read(weights, Register::State, &mut parameters);
        if let Pull::Mass(g) = pull {
            parameters.iter_mut().for_each(|parameter| *parameter *= g);
        }
        // A mass of 0 is an immovable row; a parameter of 0 is a row that pulls nobody.
        let light = |parameter: f64| match pull {
            Pull::Mass(_) => parameter <= 0.0,
            Pull::Parameter => parameter < 0.0,
        };
        let wrong = parameters.iter().position(|parameter| light(*parameter) || parameter.is_nan());
        if let Some(row) = wrong.or_else(|| parameters.iter().all(|parameter| *parameter == 0.0).then_some(0)) {
            let found = format!("row {row} of {domain} attracts by {:e} m^3/s^2", parameters[row]);
            return Err(self.refused("rows that attract each other", found, "give it a mass, or take leapfrog"));
        }
        let hierarchy = Hierarchy::new(&parameters);
        if !hierarchy.is_dominated() && hierarchy.rows() > 2 {
            log::warn!(
                "{}: no row of {domain} is heavier than all others together, so kicks are not small: compare with another \
                 integrator",
                self.name()
            );
        }
        let turns = structure.momenta_depend_on_momenta.is_some();
        Ok(Box::new(Bound { position, velocity, hierarchy, turns }))
    }

    /// Makes sure that the quantities are found.
    fn bound(&mut self, system: &dyn System) -> Result<Box<Bound>, Fault> {
        let bound = match self.bound.take() {
            Some(bound) => bound,
            None => self.bind(system)?,
        };
        let numbers = 3 * bound.hierarchy.rows();
        if self.rates.len() != numbers {
            for room in [&mut self.rates, &mut self.numbers, &mut self.disturbances] {
                *room = vec![0.0; numbers];
            }
        }
        // What a checkpoint holds knows no masses.
        let fits = |held: &mut Box<Held>| held.orbits.rows > 0 || held.orbits.share(&bound.hierarchy);
        if !self.held.as_mut().is_none_or(fits) {
            self.held = None;
        }
        Ok(bound)
    }

    fn drift(&self, orbits: &mut Orbits, time: f64) {
        orbits.drift_centre(time);
        f64::with_lanes(self.isa, Drift { orbits, time });
    }

    /// Evaluates what disturbs the rows.
    fn disturb(&mut self, system: &mut dyn System, bound: &Bound, orbits: &mut Orbits) {
        let Bound { hierarchy, position, velocity, turns } = bound;
        orbits.absolute(hierarchy, Which::Position, &mut self.numbers);
        system.write(*position, &self.numbers);
        if *turns {
            orbits.absolute(hierarchy, Which::Velocity, &mut self.numbers);
            system.write(*velocity, &self.numbers);
        }
        system.evaluate(Part::Momenta);
        system.read(*velocity, Register::Rates, &mut self.rates);
        orbits.disturbances(hierarchy, &self.rates, &mut self.disturbances);
    }

    fn kick(&mut self, system: &mut dyn System, bound: &Bound, orbits: &mut Orbits, step: f64, kernel: bool) {
        self.disturb(system, bound, orbits);
        if kernel || bound.turns {
            // a(x + h^2/12 a) is a + h^2/12 (a . grad) a.
            let factors = [if kernel { step * step / 12.0 } else { 0.0 }, 0.5 * step];
            let mut trial = core::mem::take(&mut self.trial);
            trial.follow(orbits, if bound.turns { &factors } else { &factors[..1] }, &self.disturbances);
            self.disturb(system, bound, &mut trial);
            self.trial = trial;
        }
        orbits.kick(step, &self.disturbances);
    }

    /// Takes a corrector's drifts and kicks, which leave the time as it is.
    fn correct(&mut self, system: &mut dyn System, bound: &Bound, orbits: &mut Orbits, step: f64, undoes: bool) {
        let (time, mut passed) = (system.time(), 0.0);
        for [drift, kick] in corrector::stages(self.corrector, undoes) {
            self.drift(orbits, drift * step);
            passed += drift;
            if kick != 0.0 {
                system.set_time(time + passed * step);
                self.kick(system, bound, orbits, kick * step, false);
            }
        }
        system.set_time(time);
    }

    /// The rows at the end of the last step, as the world sees them.
    fn finished(&mut self, system: &mut dyn System, bound: &Bound, held: &Held) -> Orbits {
        let mut orbits = held.orbits.clone();
        self.drift(&mut orbits, held.left);
        self.correct(system, bound, &mut orbits, held.step, true);
        orbits
    }

    /// The rows as the state has them, as the method sees them.
    fn begin(&mut self, system: &mut dyn System, bound: &Bound, step: f64) -> Box<Held> {
        let mut orbits = match self.held.take() {
            // Another step, which has another corrector.
            Some(held) => self.finished(system, bound, &held),
            None => {
                let mut velocity = vec![0.0; self.numbers.len()];
                system.read(bound.position, Register::State, &mut self.numbers);
                system.read(bound.velocity, Register::State, &mut velocity);
                Orbits::new(&bound.hierarchy, &self.numbers, &velocity)
            }
        };
        self.correct(system, bound, &mut orbits, step, false);
        Box::new(Held { orbits, step, left: 0.0 })
    }
}

impl Integrator for WisdomHolman {
    fn name(&self) -> &'static str {
        if self.kernel { HIGH_NAME } else { NAME }
    }

    fn order(&self) -> u32 {
        if self.kernel { 4 } else { 2 }
    }

    fn accept(&self, structure: &Structure) -> Result<(), Fault> {
        structure.without_others(self.name())?;
        structure.without_every(self.name())?;
        let need = "rows with position and velocity, of one domain";
        let wrong = |found: String| self.refused(need, found, "take gauss_radau_15");
        let one = |states: &[String], property: &str| match states {
            [state] => {
                state.rsplit_once('.').filter(|(_, name)| *name == property).map(|(domain, _)| domain.to_owned())
            }
            _ => None,
        };
        let all = structure.coordinates.iter().chain(&structure.momenta);
        let all = || all.clone().cloned().collect::<Vec<_>>().join(", ");
        let (place, moves) = (one(&structure.coordinates, "position"), one(&structure.momenta, "velocity"));
        if place.is_none() || place != moves {
            return Err(wrong(format!("laws move {}", all())));
        }
        if !structure.second_order {
            return Err(wrong(format!("the rate of {} is not its velocity", structure.coordinates[0])));
        }
        if structure.rows.iter().any(|rows| *rows < 2) {
            return Err(wrong(format!("{} is that of {} row", structure.coordinates[0], structure.rows[0])));
        }
        if pull(self.g, structure).is_none() {
            let (found, mend) =
                ("gravity and gravity_by_parameter do not run", "add one of them, or give `g` for another law");
            return Err(self.refused("a law by which rows attract each other", found.to_owned(), mend));
        }
        if self.g.is_some_and(|g| !(g > 0.0 && g.is_finite())) {
            let found = format!("g is {:?}", self.g.unwrap_or_default());
            return Err(self.refused(
                "a constant of gravitation above 0",
                found,
                "give that of the law, or leave it out",
            ));
        }
        if !corrector::ORDERS.contains(&self.corrector) {
            let found = format!("{} is asked for", self.corrector);
            return Err(self.refused(
                "a corrector of order 3, 5, 7, 11 or 17",
                found,
                "give one of them, or 0 for none",
            ));
        }
        if self.kernel && self.corrector == 0 {
            let found = "there is none".to_owned();
            return Err(self.refused("a corrector with its kernel", found, "give `corrector`, 17 for one"));
        }
        Ok(())
    }

    fn remark(&self, structure: &Structure) -> Option<String> {
        structure.momenta_depend_on_momenta.as_ref().map(|momentum| {
            format!("a rate of a momentum depends on {momentum}: kicks are midpoint steps, two evaluations each")
        })
    }

    fn step(&mut self, system: &mut dyn System, step: f64) -> Result<(), Fault> {
        let bound = self.bound(system)?;
        let mut held = match self.held.take_if(|held| held.step == step) {
            Some(held) => held,
            None => self.begin(system, &bound, step),
        };
        let time = system.time();
        self.drift(&mut held.orbits, held.left + 0.5 * step);
        system.set_time(time + 0.5 * step);
        self.kick(system, &bound, &mut held.orbits, step, self.kernel);
        held.left = 0.5 * step;
        system.set_time(time + step);
        self.held = Some(held);
        self.bound = Some(bound);
        Ok(())
    }

    fn finish(&mut self, system: &mut dyn System) -> Result<(), Fault> {
        let Some(held) = self.held.take() else { return Ok(()) };
        let bound = self.bound(system)?;
        let orbits = self.finished(system, &bound, &held);
        for (which, quantity) in [(Which::Position, bound.position), (Which::Velocity, bound.velocity)] {
            orbits.absolute(&bound.hierarchy, which, &mut self.numbers);
            system.write(quantity, &self.numbers);
        }
        (self.held, self.bound) = (Some(held), Some(bound));
        Ok(())
    }

    fn restart(&mut self) {
        (self.bound, self.held, *self.trial) = (None, None, Orbits::default());
    }

    fn memory(&self) -> Vec<f64> {
        let Some(held) = &self.held else { return Vec::new() };
        [vec![held.step, held.left], held.orbits.memory()].concat()
    }

    fn set_memory(&mut self, memory: &[f64]) {
        self.restart();
        if let [step, left, rest @ ..] = memory {
            self.held = Orbits::of_memory(rest).map(|orbits| Box::new(Held { orbits, step: *step, left: *left }));
        }
    }
}
