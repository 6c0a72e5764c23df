//! A Gauss-Radau method of order 15, in the manner of IAS15.
//!
//! Order 15, adaptive, to rounding. Rates at eight places of the step (the beginning, and seven spacings of Gauss and Radau)
//! make a polynomial of degree 7, found by iteration: each round evaluates the laws at seven places, and two or three
//! rounds do, since the polynomial of the step before foretells this one's. The state is compensated, so that the error
//! of the energy grows like that of a random walk. For every smooth problem that deserves all digits, close encounters and
//! eccentric orbits among them. Not for stiff laws, where the rounds do not close.
//!
//! Where the rate of every coordinate is its momentum (Motion) only the momenta have polynomials, and coordinates are
//! their second integrals: fewer rounds, since they need not wait for them.
//!
//! In double-double numbers it is what brings a chaotic problem to an answer: the weights of its steps have as many digits, and the
//! places within a step, which are those of f64, are off by 1e-17 of how far a force moves them. The precision is to be 1e-8 or
//! 1e-9 then; with the default the errors of its steps are those of f64.
//!
//! Each round closes what the one before left open by a factor that two of them show; the last round is the one after which
//! nothing is left that could add up, or that is not hidden by the error of the step.
//!
//! The step is chosen so that the highest term of the polynomial, at the end of the step, is a given part of the largest
//! rate on the way, row by row. (The source compares with the rate at one time, which asks for a step of length zero where
//! the only rate passes through zero, as an oscillator's does; ratios of derivatives do the same where a force begins with
//! the third power of the distance.) Rates that are nothing but rounding errors count as little as they do.
//!
//! Sources: Everhart, IAU Colloq. 83 (1985) 185; Rein, Spiegel, MNRAS 446 (2015) 1424, eq. 9 to 11 for the step. The stages
//! are kept as rates, not as their divided differences: the same polynomial, one sum less for each place.

use super::adaptive::{Span, Steps};
use super::gauss_radau_table::{AT, AT_REST, HIGHEST, NODES, ONCE, REST, TWICE};
use super::jump::{Found, Jump};
use super::{Combination, Integrator, Register, Structure, System, Term, Terms};
use crate::error::Fault;
use crate::law::Part;

/// Gauss-Radau of order 15: adaptive, to rounding.
#[derive(Clone, Debug)]
pub struct GaussRadau15 {
    /// What the step is chosen by: the part of the rates that the highest term of their polynomial may be. The default
    /// comes down to rounding on smooth problems.
    pub precision: f64,
    steps: Steps,
    /// Whether the rate of every coordinate is its momentum, where that is known.
    follows: Option<bool>,
    /// The length of the last step, whose rates are kept, in s.
    last: Option<f64>,
    /// Which of the two sets of rates is the last step's.
    bank: usize,
}

impl GaussRadau15 {
    /// With this precision.
    pub fn new(precision: f64) -> Self {
        GaussRadau15 { precision, steps: Steps::default(), follows: None, last: None, bank: 0 }
    }
}

impl Default for GaussRadau15 {
    fn default() -> Self {
        GaussRadau15::new(1e-7)
    }
}

const NAME: &str = "gauss_radau_15";
/// The state at the beginning of the step.
const START: Register = Register::Work(0);
/// What the last round changed, and the highest term.
const SUM: Register = Register::Work(1);
/// Rounds after which a step is given up, and a shorter one tried.
const ROUNDS: usize = 12;
/// What the rounds may leave, in roundings: it has one sign, and adds up over millions of steps.
const CLOSED: f64 = 1e-5;
/// What they may leave where the step itself has a larger error: a part of the state, by the power of the precision that the
/// error of a step goes with.
const COARSE: f64 = 1e-7;
/// Changes, in roundings, that are those of the rates themselves where they no longer fall.
const RATES: f64 = 1.0;
/// Changes, in roundings, that rates may go on making.
const STALLED: f64 = 1e4;
/// Roundings of the state, or times what rounds leave of it, by the length of a step, up to which the highest term of a rate is
/// no reason for a shorter one.
const NOISE: f64 = 1e3;
/// Properties that are told apart by their units; more share the last one's scale.
const PROPERTIES: usize = 8;
/// A step shrinks and grows at most by this factor; one that should have been shorter by more is tried again.
const FACTOR: f64 = 4.0;

const fn rates(bank: usize, place: usize) -> Register {
    Register::Work(2 + bank * NODES + place)
}

/// The rates at all places by their weights.
const fn by(weights: &[f64; NODES], factor: f64, bank: usize) -> Terms<'_> {
    Terms::weighted(2 + bank * NODES, weights, factor)
}

fn sum(system: &mut dyn System, to: Register, terms: Terms<'_>, part: Part) {
    system.linear(Combination { to, adds: false, part, terms, momenta: Terms::NONE });
}

impl Integrator for GaussRadau15 {
    fn name(&self) -> &'static str {
        NAME
    }

    fn order(&self) -> u32 {
        15
    }

    fn work_vectors(&self) -> usize {
        2 + 2 * NODES
    }

    fn is_adaptive(&self) -> bool {
        true
    }

    fn set_first_step(&mut self, step: f64) {
        self.steps.first = Some(step);
    }

    fn compensates(&self, _epsilon: f64) -> bool {
        true
    }

    fn is_beyond_f64(&self) -> bool {
        true
    }

    fn accept(&self, structure: &Structure) -> Result<(), Fault> {
        structure.without_every(NAME)
    }

    fn step(&mut self, system: &mut dyn System, step: f64) -> Result<(), Fault> {
        let follows = *self.follows.get_or_insert_with(|| system.coordinates_follow_momenta());
        let of = Form { part: if follows { Part::Momenta } else { Part::All }, follows };
        let mut span = Span::new(system, step);
        let holds = system.hold();
        while span.rest() > 0.0 {
            system.evaluate(of.part);
            let next = self.steps.begin(system, Register::Rates, (15, self.precision), step);
            let (mut length, mut last) = span.cut(system, NAME, next)?;
            let before = self.last.take();
            if let Some(before) = before {
                self.foretell(system, of, [1.0, length / before]);
            }
            system.copy(rates(self.bank, 0), Register::Rates, of.part);
            if before.is_none() {
                self.hold(system, of);
            }
            system.copy(START, Register::State, Part::All);
            let time = system.time();
            let (mut jump, mut landed, mut known) = (Jump::default(), false, None);
            let best = loop {
                let closed = self.close(system, of, time, length);
                let best = if closed { self.best_step(system, of, length) } else { length / FACTOR };
                // Where a jump is near, a longer step was good enough already.
                let accepted = closed && (jump.is_near() || best * FACTOR > length);
                let mut closer = None;
                if accepted && holds {
                    of.look(system, length, NODES - 1, self.bank);
                    system.set_time(time + length);
                    known = known.or(Some(best));
                    match jump.look(system, length) {
                        Found::Nothing => {}
                        Found::Closer(next) => closer = Some(next),
                        Found::Here => landed = true,
                    }
                }
                system.count_step(accepted && closer.is_none());
                system.copy(Register::State, START, Part::All);
                let tried = length;
                if let Some(next) = closer {
                    system.set_time(time);
                    (length, last) = span.part(next);
                    self.foretell(system, of, [0.0, length / tried]);
                    continue;
                }
                if accepted {
                    break known.unwrap_or(best).min(length * FACTOR);
                }
                system.set_time(time);
                self.steps.next = Some(best);
                jump = Jump::default();
                (length, last) = span.cut(system, NAME, best)?;
                if closed {
                    self.foretell(system, of, [0.0, length / tried]);
                } else {
                    self.hold(system, of);
                }
            };
            of.finish(system, length, self.bank);
            system.set_time(span.add(length, last));
            // A step that was cut to end the span says nothing against a longer one.
            self.steps.next = Some(if last && length < next { best.max(next) } else { best });
            self.last = Some(length);
            if landed {
                // The polynomial of one case foretells nothing of the next one.
                self.last = None;
                self.steps.next = Some(known.unwrap_or(best));
                system.turn();
            } else if holds {
                system.hold();
            }
        }
        Ok(())
    }

    fn restart(&mut self) {
        self.steps.restart();
        *self = GaussRadau15 { steps: self.steps, ..Self::new(self.precision) };
    }

    fn memory(&self) -> Vec<f64> {
        let Some(last) = self.last else { return Vec::new() };
        let follows = f64::from(u8::from(self.follows == Some(true)));
        [&[last, follows, self.bank as f64][..], &self.steps.memory()].concat()
    }

    fn set_memory(&mut self, memory: &[f64]) {
        self.restart();
        if let [last, follows, bank, steps @ ..] = memory {
            (self.last, self.follows) = (Some(*last), Some(*follows == 1.0));
            self.bank = usize::from(*bank == 1.0);
            self.steps.set_memory(steps);
        }
    }
}

impl GaussRadau15 {
    /// Without a polynomial to go on from: the rates are those at the beginning.
    fn hold(&mut self, system: &mut dyn System, of: Form) {
        for place in 1..NODES {
            system.copy(rates(self.bank, place), rates(self.bank, 0), of.part);
        }
    }

    /// Rounds of evaluations until the rates no longer change. Whether that was reached.
    fn close(&mut self, system: &mut dyn System, of: Form, time: f64, length: f64) -> bool {
        let closed = CLOSED.max(self.hidden() / system.epsilon());
        let (mut best, mut before, mut stalled) = (f64::INFINITY, f64::INFINITY, 0);
        for _ in 0..ROUNDS {
            for (row, at) in AT.iter().skip(1).enumerate() {
                let kept = rates(self.bank, row + 1);
                of.look(system, length, row, self.bank);
                system.set_time(time + at * length);
                system.evaluate(of.part);
                if row + 2 == NODES {
                    system.combine(SUM, &[(1.0, Register::Rates), (-1.0, kept)], of.part);
                }
                system.copy(kept, Register::Rates, of.part);
            }
            let change = of.change(system, length);
            // What a further round would change, if it closed as much as this one.
            let left = if before.is_finite() { change * (change / before) } else { change };
            if left < closed {
                return true;
            }
            before = change;
            let stays = change >= 0.5 * best;
            stalled += u32::from(stays);
            best = best.min(change);
            // Rates that are differences of large terms never come to rest; those of too long a step neither.
            if stays && best < RATES || stalled > 2 || change.is_nan() {
                break;
            }
        }
        best < STALLED
    }

    /// What rounds may leave, in parts of the state, since the error of the step is larger.
    fn hidden(&self) -> f64 {
        // A precision that is none leaves the step as it is given, and nothing to hide behind.
        if self.precision < 1.0 { COARSE * self.precision.powf(16.0 / 7.0) } else { 0.0 }
    }

    /// The step that the rates of this one ask for.
    fn best_step(&self, system: &mut dyn System, of: Form, length: f64) -> f64 {
        sum(system, SUM, by(&HIGHEST, 1.0, self.bank), of.part);
        let mut vectors = [Register::State; NODES + 2];
        vectors[0] = SUM;
        for (place, vector) in vectors[2..].iter_mut().enumerate() {
            *vector = rates(self.bank, place);
        }
        let floor = NOISE * system.epsilon().max(self.hidden()) / self.precision;
        let place = of.farthest(system);
        let mut worst = 0.0;
        system.magnitudes(&vectors, of.part, &mut |_, row| {
            let largest = row[2..].iter().copied().fold(0.0, f64::max);
            let of_state = floor * (row[1] / length).max(place / (length * length));
            if row[0] > 0.0 {
                worst = f64::max(worst, row[0] / largest.max(of_state));
            }
        });
        length * (self.precision / worst).powf(1.0 / 7.0).min(2.0 * FACTOR)
    }

    /// Extends the polynomial to the places of another step: one that begins at `from`, in parts of this one, and is so many
    /// times as long.
    fn foretell(&mut self, system: &mut dyn System, of: Form, [from, ratio]: [f64; 2]) {
        let other = 1 - self.bank;
        for (place, at) in AT.iter().enumerate() {
            let at = from + at * ratio;
            sum(system, rates(other, place), by(&basis(at), 1.0, self.bank), of.part);
        }
        self.bank = other;
    }
}

/// At this place of the step, each of the polynomials that is 1 at one of the places of the rates and 0 at the others.
fn basis(at: f64) -> [f64; NODES] {
    let mut values = [1.0; NODES];
    for (other, apart) in APART.iter().enumerate() {
        let far = at - AT[other];
        for (k, value) in values.iter_mut().enumerate() {
            *value *= if k == other { 1.0 } else { far / apart[k] };
        }
    }
    values
}

/// How far each place is from this one.
const APART: [[f64; NODES]; NODES] = {
    let mut apart = [[0.0; NODES]; NODES];
    let mut other = 0;
    while other < NODES {
        let mut k = 0;
        while k < NODES {
            apart[other][k] = AT[k] - AT[other];
            k += 1;
        }
        other += 1;
    }
    apart
};

/// How coordinates follow from the rates.
#[derive(Clone, Copy, Debug)]
struct Form {
    /// What has polynomials.
    part: Part,
    /// Whether coordinates are second integrals.
    follows: bool,
}

impl Form {
    /// Puts the state at a place of the step, of which `row` has the integrals; the last row has those of the end.
    fn look(self, system: &mut dyn System, length: f64, row: usize, bank: usize) {
        let part = if self.follows { Part::Momenta } else { Part::All };
        if !self.follows || system.momenta_depend_on_momenta() {
            // What sums of more digits than f64 take is not rounded.
            let exact = system.epsilon() < f64::EPSILON;
            // Most of what the weights leave out is what they would leave out of a rate that stays.
            let rest = ONCE[row].iter().fold(Pair::place(row, length), |left, weight| {
                let product = weight * length;
                let left = left.less(product);
                if exact { left.less(weight.mul_add(length, -product)) } else { left }
            });
            let others = [(rest.sum + rest.rest, rates(bank, 0)), (1.0, START)];
            sum(system, Register::State, by(&ONCE[row], length, bank).and(&others), part);
        }
        if !self.follows {
            return;
        }
        let place = Pair::place(row, length);
        let others = [(place.sum, START), (place.rest, START)];
        let momenta = by(&TWICE[row], length * length, bank).and(&others);
        let (to, part) = (Register::State, Part::Coordinates);
        system.linear(Combination { to, adds: false, part, terms: Terms::of(&[(1.0, START)]), momenta });
    }

    /// How much the last round changed the rates at the last place, in roundings of the state: of its momenta, or of the
    /// coordinates behind them, whichever is less.
    fn change(self, system: &mut dyn System, length: f64) -> f64 {
        // The change, the rate and the value of a property, each the largest of its rows.
        let mut largest: [[f64; 3]; PROPERTIES] = [[0.0; 3]; PROPERTIES];
        let mut whole = true;
        system.magnitudes(&[SUM, Register::Rates, Register::State], self.part, &mut |property, row| {
            whole &= row.iter().all(|number| number.is_finite());
            for (largest, number) in largest[property.min(PROPERTIES - 1)].iter_mut().zip(row) {
                *largest = largest.max(*number);
            }
        });
        if !whole {
            return f64::NAN;
        }
        let place = self.farthest(system);
        let epsilon = system.epsilon();
        let roundings = largest.into_iter().filter(|[change, ..]| *change > 0.0).map(|[change, rate, value]| {
            let of_momenta = length * change / (epsilon * value.max(length * rate));
            let of_places = length * length * change / (epsilon * place);
            of_momenta.min(of_places)
        });
        roundings.fold(0.0, f64::max)
    }

    /// The largest magnitude of the coordinates, where momenta are their rates.
    fn farthest(self, system: &mut dyn System) -> f64 {
        let mut place = 0.0;
        if self.follows {
            system.magnitudes(&[Register::State], Part::Coordinates, &mut |_, row| place = f64::max(place, row[0]));
        }
        place
    }

    /// Adds the whole step to the state. Means first, and then once the step: its square would be rounded the same way in
    /// every step of one length, and such errors add up.
    fn finish(self, system: &mut dyn System, length: f64, bank: usize) {
        let row = NODES - 1;
        let mean = |weights: &[f64; NODES], rest: &[f64; NODES]| -> [Term; 2 * NODES] {
            core::array::from_fn(|k| match k.checked_sub(NODES) {
                Some(place) => (weights[place], rates(bank, place)),
                None => (rest[k], rates(bank, k)),
            })
        };
        let [rest_once, rest_twice] = &REST;
        if self.follows {
            system.combine(SUM, &mean(&TWICE[row], rest_twice), Part::Momenta);
            system.combine(SUM, &[(length, SUM), (1.0, START)], Part::Momenta);
            system.follow(Register::State, &[(length, SUM)], true);
        }
        system.combine(SUM, &mean(&ONCE[row], rest_once), self.part);
        system.add(Register::State, &[(length, SUM)], self.part);
    }
}

/// A number, and what rounding left out of it.
#[derive(Clone, Copy, Debug)]
struct Pair {
    sum: f64,
    rest: f64,
}

impl Pair {
    /// The place that a row of the tables is for, in a step of this length.
    fn place(row: usize, length: f64) -> Self {
        let [at, rest] = if row + 1 < NODES { [AT[row + 1], AT_REST[row + 1]] } else { [1.0, 0.0] };
        let sum = at * length;
        Pair { sum, rest: at.mul_add(length, -sum) + rest * length }
    }

    /// Without this number.
    fn less(self, number: f64) -> Self {
        let sum = self.sum - number;
        let back = sum - self.sum;
        // Knuth's sum without an error.
        let error = (self.sum - (sum - back)) - (number + back);
        Pair { sum, rest: self.rest + error }
    }
}
