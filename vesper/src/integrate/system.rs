//! What an integrator sees of laws and data: vectors over the whole state, by name, and what can be done with them.

use super::{Linearised, Quantity, Structure};
use crate::law::Part;

/// A vector with a number for every number of the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Register {
    /// The state itself.
    State,
    /// The time derivatives that the last `evaluate` left.
    Rates,
    /// A vector of the integrator's own, zero at first; it asks for as many as it needs.
    Work(usize),
}

impl Register {
    /// Its number among all.
    #[inline(always)]
    pub(crate) const fn number(self) -> usize {
        match self {
            Register::State => 0,
            Register::Rates => 1,
            Register::Work(number) => number.saturating_add(2),
        }
    }
}

/// A vector with its factor.
pub type Term = (f64, Register);

/// Vectors that are summed: those of a table's row, then others.
#[derive(Clone, Copy, Debug, Default)]
pub struct Terms<'a> {
    /// The number of the first work vector that has a weight.
    pub first: usize,
    /// The weights of that one and of those that follow it. Vectors of weight 0 are passed over.
    pub weights: &'a [f64],
    /// What each weight is multiplied by: the length of a step, say.
    pub factor: f64,
    /// Others, behind them.
    pub others: &'a [Term],
}

impl<'a> Terms<'a> {
    /// Nothing.
    pub const NONE: Terms<'static> = Terms::of(&[]);

    /// These vectors.
    pub const fn of(others: &'a [Term]) -> Self {
        Terms { first: 0, weights: &[], factor: 0.0, others }
    }

    /// Work vectors from `first` on, by these weights and a factor.
    pub const fn weighted(first: usize, weights: &'a [f64], factor: f64) -> Self {
        Terms { first, weights, factor, others: &[] }
    }

    /// These, and others behind them.
    pub const fn and(self, others: &'a [Term]) -> Self {
        Terms { others, ..self }
    }

    /// How many there are, those of weight 0 too.
    pub(crate) fn len(&self) -> usize {
        self.weights.len() + self.others.len()
    }

    /// Those of the row, of weight 0 too.
    pub(crate) fn row(&self) -> impl Iterator<Item = Register> {
        (self.first..self.first + self.weights.len()).map(Register::Work)
    }

    /// The first `count`, and the rest.
    pub(crate) fn split_at(self, count: usize) -> (Self, Self) {
        let (now, later) = self.weights.split_at(count.min(self.weights.len()));
        let (also, rest) = self.others.split_at((count - now.len()).min(self.others.len()));
        let first = Terms { weights: now, others: also, ..self };
        (first, Terms { first: self.first + now.len(), weights: later, others: rest, ..self })
    }
}

/// A sum of vectors, and where it goes.
#[derive(Clone, Copy, Debug)]
pub struct Combination<'a> {
    /// What is written.
    pub to: Register,
    /// Whether the sum is added to what is there, or takes its place.
    pub adds: bool,
    /// The part of the state that is meant.
    pub part: Part,
    /// What is summed: rows of weights first, those of momenta before the others, then single vectors in the same order. What
    /// is written may be among them, where there are no more than 24. A trial of a compensated state that begins at what the
    /// state was before ends with that, `(1.0, ..)`: laws that look at differences then get what rounding took from the trial.
    pub terms: Terms<'a>,
    /// For coordinates alone: vectors of which the momenta are summed, each to the coordinate that it
    /// moves. Only where [`System::coordinates_follow_momenta`].
    pub momenta: Terms<'a>,
}

/// Which laws give rates, where some are not evaluated on every step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// On every n-th step what is due, and else what it gave last.
    Held,
    /// Those that are evaluated on every step.
    Fast,
    /// The same, and those that are evaluated on every n-th.
    With(u32),
}

/// How momenta are turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rotation {
    /// By twice the angle whose tangent is half of the exact one (Boris 1970): with two half kicks about it, the drift
    /// across fields at right angles is exact, and the phase has an error of second order.
    Tangent,
    /// By the exact angle.
    Exact,
    /// As by the tangent, at the velocity of the momentum in the middle between before and after (Higuera and Cary 2017);
    /// it differs where the velocity is not proportional to the momentum.
    TangentOfMean,
}

/// What an integrator sees of laws and data.
pub trait System: Linearised {
    /// The time of the state, in s.
    fn time(&self) -> f64;
    /// Sets the time at which laws are evaluated, in s.
    fn set_time(&mut self, time: f64);
    /// Runs the laws once, so that [`Register::Rates`] holds the rates of this part at the state and time as they are.
    fn evaluate(&mut self, part: Part);
    /// For each stage in turn: evaluates, and adds the step, in s, times the rates to the state. The same as `evaluate`
    /// and `axpy`, but the rates need not be kept, so a stage of row laws is one pass over memory, and so are
    /// neighbouring stages.
    fn advance(&mut self, stages: &[(Part, f64)]);
    /// Sums vectors. What is added to the state is added with the rounding error of the last addition, where the state is
    /// compensated (Kahan, Comm. ACM 8 (1965) 40); what takes its place is a trial, and leaves that error as it is.
    fn linear(&mut self, combination: Combination<'_>);
    /// Goes through the rows of this part. `each` gets the number of the property among the states, and the magnitudes of
    /// the row in every one of the vectors, up to 12; the magnitude of a vector property is its length.
    fn magnitudes(&mut self, of: &[Register], part: Part, each: &mut dyn FnMut(usize, &[f64]));
    /// What the laws of the run are.
    fn structure(&self) -> &Structure;
    /// A property of a domain, "bodies.position"; `None` where there is none, or only some rows have it. Found once,
    /// not in every step.
    fn find(&self, name: &str) -> Option<Quantity>;
    /// Reads the numbers of a quantity component by component: all x, then all y, then all z. From a vector, where it is a
    /// state; what is none stands only in [`Register::State`], and is not read from another one.
    fn read(&self, quantity: Quantity, from: Register, to: &mut [f64]);
    /// Writes the numbers of a state, in the order of [`System::read`]. They are a trial, as in [`System::linear`]: rounding
    /// errors that are kept stay as they are. What is no state is not written.
    fn write(&mut self, quantity: Quantity, from: &[f64]);
    /// Whether the rates of momenta depend on momenta: a force that depends on a velocity.
    fn momenta_depend_on_momenta(&self) -> bool;
    /// Whether the rates of coordinates depend on more than momenta: on coordinates, or on the time.
    fn coordinates_depend_on_others(&self) -> bool;
    /// Whether the rate of every coordinate is its momentum: the laws say so (`second_order`), and it holds in every row
    /// as it is now. May leave other rates of the coordinates behind.
    fn coordinates_follow_momenta(&mut self) -> bool;
    /// Runs some of the laws once, so that [`Register::Rates`] holds the rates of the momenta by these alone.
    fn evaluate_at_pace(&mut self, _pace: Pace) {
        self.evaluate(Part::Momenta);
    }
    /// The numbers of steps of laws that are not evaluated on every one, each once.
    fn paces(&self) -> Vec<u32> {
        Vec::new()
    }
    /// How many steps the engine has taken.
    fn steps_done(&self) -> u64 {
        0
    }
    /// How many steps are left of the frame, with the one that is taken now.
    fn steps_ahead(&self) -> u64 {
        1
    }
    /// Runs the laws once, so that [`Register::Rates`] holds the rates of the momenta without what turns them, and what
    /// turns them is known to [`System::turn`]. For integrators that say that they rotate.
    fn evaluate_unturned(&mut self) {
        self.evaluate(Part::Momenta);
    }
    /// Turns momenta for a time, in s, by what the last [`System::evaluate_unturned`] found.
    fn turn_momenta(&mut self, _time: f64, _rotation: Rotation) {}
    /// Whether the rates of momenta, as they are now, are those without turning and what turns them, together: what laws
    /// that turn promise. The first state for which that is not so, by its name.
    fn turns_amiss(&mut self) -> Option<String> {
        None
    }
    /// The distance from 1 to the next number of the state's precision.
    fn epsilon(&self) -> f64;
    /// Evaluates the laws, and holds the switches of laws and the regions of fields as they are at this state: from now on
    /// laws are evaluated in these cases, wherever the state goes. Whether there are any. An integrator that chooses its
    /// steps asks this at the beginning, and ends a step where something has [`System::turned`]; for others the engine does.
    fn hold(&mut self) -> bool {
        false
    }
    /// Evaluates the laws, and says whether a switch has turned, or a row has left its region, since they are held.
    fn turned(&mut self) -> bool {
        false
    }
    /// Where the first one turns, between the last state at which nothing had and the last one at which something had, from
    /// 0 to 1: by straight lines between both, of which each end can be weighed (the Illinois method).
    fn share(&self, _weights: [f64; 2]) -> f64 {
        0.5
    }
    /// After a step that ends where something turned: what has turned is held as it is now.
    fn turn(&mut self) {}
    /// Whether somebody asks an integrator that may take long to come back.
    fn is_stopped(&self) -> bool {
        false
    }
    /// Notes a step that an adaptive integrator has tried, for the report.
    fn count_step(&mut self, accepted: bool);

    /// `to = a x + b y + ...`, for this part.
    fn combine(&mut self, to: Register, terms: &[Term], part: Part) {
        self.linear(Combination { to, adds: false, part, terms: Terms::of(terms), momenta: Terms::NONE });
    }
    /// `to += a x + b y + ...`, for this part.
    fn add(&mut self, to: Register, terms: &[Term], part: Part) {
        self.linear(Combination { to, adds: true, part, terms: Terms::of(terms), momenta: Terms::NONE });
    }
    /// Evaluates, and leaves the rates of this part in `to`; what [`Register::Rates`] holds then is anybody's guess.
    fn evaluate_to(&mut self, to: Register, part: Part) {
        self.evaluate(part);
        self.copy(to, Register::Rates, part);
    }
    /// `to = a x + b y + ...` for the coordinates, of the momenta of the vectors; or the same with `+=`. Only where
    /// [`System::coordinates_follow_momenta`].
    fn follow(&mut self, to: Register, momenta: &[Term], adds: bool) {
        let momenta = Terms::of(momenta);
        self.linear(Combination { to, adds, part: Part::Coordinates, terms: Terms::NONE, momenta });
    }
    /// `to += a x`, for this part.
    fn axpy(&mut self, to: Register, a: f64, x: Register, part: Part) {
        self.add(to, &[(a, x)], part);
    }
    /// `to = from`, for this part.
    fn copy(&mut self, to: Register, from: Register, part: Part) {
        self.combine(to, &[(1.0, from)], part);
    }
    /// `to = 0`, for this part.
    fn zero(&mut self, to: Register, part: Part) {
        self.combine(to, &[], part);
    }
}
