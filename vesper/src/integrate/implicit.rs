//! The equation of an implicit step, `z = c f(y + z)`, solved to the rounding of the state: what implicit methods share.
//!
//! In: a system at the beginning of a step, at the time at which the rates are wanted. Out: the increment `z`, or a fault that
//! says how near it came. Never: a matrix: GMRES asks for derivatives of the rates along directions only.
//!
//! *Unknowns.* Where the rate of every coordinate is its momentum, coordinates are eliminated: `z_q = c (p + z_p)` holds in
//! every trial, and momenta are the only unknowns, half as many, and of one kind. Vectors are measured by the sum of squares
//! over the scale of their state, the largest magnitude of a row or of its rate times `c`, so that units do not matter.
//!
//! *Newton.* Inexact, forced by choice 2 of Eisenstat and Walker; a step that does not make the residual smaller is halved.
//!
//! *End.* Below the residual that rounding of the state itself makes, no solution is better than another. That is measured:
//! it is what the linear equation makes of numbers that are as large as the rounding errors of the state.
//!
//! Sources: Knoll, Keyes, J. Comput. Phys. 193 (2004) 357; Kelley, Iterative Methods for Linear and Nonlinear Equations, SIAM
//! 1995, chapters 3 (GMRES) and 8; Eisenstat, Walker, SIAM J. Sci. Comput. 17 (1996) 16; Saad, Schultz, SIAM J. Sci. Stat.
//! Comput. 7 (1986) 856.

use super::krylov::{Arnoldi, BASIS, givens};
use super::{Register, System};
use crate::error::Fault;
use crate::law::Part;

/// The state at the beginning of the step.
pub(super) const START: Register = Register::Work(0);
/// What the state moves by; the solution.
pub(super) const INCREMENT: Register = Register::Work(1);
/// What is left of the equation, `z - c f`.
const RESIDUAL: Register = Register::Work(2);
/// What Newton's method adds to the increment.
const CORRECTION: Register = Register::Work(3);
/// Directions in the space of all states, and the derivative along them.
const DIRECTION: Register = Register::Work(4);
const CHANGE: Register = Register::Work(5);
/// The increment before a correction, to be halved.
const BEFORE: Register = Register::Work(6);
/// The first vector of the Krylov space.
const FIRST: usize = 7;

/// How many vectors the solver needs.
pub(super) const VECTORS: usize = FIRST + BASIS + 1;

/// Corrections, halvings of one, and restarts of the linear solver, after which a step is given up.
const CORRECTIONS: u32 = 60;
const HALVINGS: u32 = 12;
const RESTARTS: u32 = 40;
/// The largest and the first part of the residual that a correction may leave, and the factor of Eisenstat and Walker.
const MOST_FORCING: f64 = 0.1;
const FIRST_FORCING: f64 = 1e-2;
const FORCING: f64 = 0.9;
/// Residuals, in those that rounding makes: one that is small enough, and one that is where no correction makes it smaller.
const ENOUGH: f64 = 0.5;
const ROUNDED: f64 = 16.0;

/// Of one step.
pub(super) struct Solver<'s> {
    pub(super) system: &'s mut dyn System,
    /// The name of the method, for faults.
    pub(super) integrator: &'static str,
    /// The factor of the rates, in s.
    pub(super) factor: f64,
    /// Whether coordinates are eliminated.
    pub(super) follows: bool,
    /// For each state, one over the square of its scale.
    weights: Vec<f64>,
}

/// Takes a step of a method that moves the state by `times` the solution of its equation at `at` parts of the step.
///
/// # Errors
/// The equation was not solved, or somebody stopped it; the state is that at the beginning.
pub(super) fn step(
    (integrator, follows): (&'static str, bool),
    system: &mut dyn System,
    step: f64,
    (at, times): (f64, f64),
) -> Result<(), Fault> {
    let time = system.time();
    system.copy(START, Register::State, Part::All);
    system.set_time(time + at * step);
    let mut solver = Solver { system, integrator, factor: at * step, follows, weights: Vec::new() };
    let solved = solver.solve(time, step);
    system.copy(Register::State, START, Part::All);
    if solved.is_err() {
        system.set_time(time);
        return solved;
    }
    system.add(Register::State, &[(times, INCREMENT)], Part::All);
    system.set_time(time + step);
    Ok(())
}

impl Solver<'_> {
    /// The part of the state that is unknown.
    fn unknown(&self) -> Part {
        if self.follows { Part::Momenta } else { Part::All }
    }

    fn norm(&self, of: Register) -> f64 {
        self.system.dot(of, of, self.unknown(), &self.weights).sqrt()
    }

    /// Lets coordinates follow the increments of the momenta.
    fn follow(&mut self) {
        if self.follows {
            self.system.follow(INCREMENT, &[(self.factor, START), (self.factor, INCREMENT)], false);
        }
    }

    /// The residual of the increment as it is, and its norm.
    fn residual(&mut self) -> f64 {
        let part = self.unknown();
        self.system.combine(Register::State, &[(1.0, INCREMENT), (1.0, START)], Part::All);
        self.system.evaluate(part);
        self.system.combine(RESIDUAL, &[(-self.factor, Register::Rates), (1.0, INCREMENT)], part);
        if self.weights.is_empty() { f64::NAN } else { self.norm(RESIDUAL) }
    }

    /// Measures the states by the first trial: sets their weights; gives the largest numbers that are rounded in a step.
    fn measure(&mut self) -> Vec<f64> {
        let factor = self.factor.abs();
        let mut largest: Vec<f64> = Vec::new();
        let mut note = |state: usize, size: f64| {
            largest.resize(largest.len().max(state + 1), 0.0);
            largest[state] = largest[state].max(size);
        };
        self.system.magnitudes(&[START, INCREMENT], Part::All, &mut |state, of| note(state, of[0].max(of[1])));
        // Rates of coordinates that follow are not evaluated: their increments are those rates already.
        self.system.magnitudes(&[Register::Rates], self.unknown(), &mut |state, of| note(state, factor * of[0]));
        let weight = |scale: f64| if scale > 0.0 && scale.is_finite() { 1.0 / (scale * scale) } else { 1.0 };
        self.weights = largest.iter().map(|scale| weight(*scale)).collect();
        largest
    }

    /// `to = (1 - c J) of`, where `of` is of the unknown part, and coordinates follow.
    fn apply(&mut self, to: Register, of: Register) {
        let (part, factor) = (self.unknown(), self.factor);
        let mut along = of;
        if self.follows {
            self.system.copy(DIRECTION, of, Part::Momenta);
            self.system.follow(DIRECTION, &[(factor, of)], false);
            along = DIRECTION;
        }
        self.system.derivative(CHANGE, along);
        self.system.combine(to, &[(-factor, CHANGE), (1.0, of)], part);
    }

    /// The residual that rounding of the state makes.
    fn rounding(&mut self, largest: &[f64]) -> f64 {
        let epsilon = self.system.epsilon();
        let errors: Vec<f64> = largest.iter().map(|number| number * epsilon).collect();
        self.system.scatter(DIRECTION, &errors);
        self.system.derivative(CHANGE, DIRECTION);
        let part = self.unknown();
        self.system.combine(CHANGE, &[(-self.factor, CHANGE), (1.0, DIRECTION)], part);
        self.norm(CHANGE)
    }

    /// Leaves the increment that solves the equation.
    fn solve(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        self.system.zero(INCREMENT, Part::All);
        self.follow();
        self.residual();
        let largest = self.measure();
        let mut norm = self.norm(RESIDUAL);
        let first = norm;
        let rounding = self.rounding(&largest).max(f64::MIN_POSITIVE);
        let (mut forcing, mut before) = (FIRST_FORCING, f64::INFINITY);
        for correction in 0..CORRECTIONS {
            if norm <= ENOUGH * rounding {
                return Ok(());
            }
            if !norm.is_finite() {
                break;
            }
            if self.system.is_stopped() {
                return Err(Fault::Stopped { integrator: self.integrator.to_owned(), time });
            }
            if correction > 0 {
                let last = forcing;
                forcing = FORCING * (norm / before) * (norm / before);
                // One that was loose does not become tight at once.
                let kept = FORCING * last * last;
                forcing = if kept > 0.1 { forcing.max(kept) } else { forcing };
            }
            // Nothing is gained below the rounding of the whole.
            forcing = forcing.max(0.5 * ENOUGH * rounding / norm).min(MOST_FORCING);
            self.correct(norm, forcing);
            before = norm;
            norm = self.take(norm, rounding);
            if norm >= before {
                // No correction is a better one.
                if norm <= ROUNDED * rounding {
                    return Ok(());
                }
                break;
            }
        }
        if norm <= ROUNDED * rounding {
            return Ok(());
        }
        let residual = norm / if first > 0.0 { first } else { 1.0 };
        Err(Fault::NotSolved { integrator: self.integrator.to_owned(), time, step, residual })
    }

    /// Adds the correction, or so much of it that the residual is smaller; its norm.
    fn take(&mut self, norm: f64, rounding: f64) -> f64 {
        let part = self.unknown();
        self.system.copy(BEFORE, INCREMENT, part);
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            self.system.combine(INCREMENT, &[(share, CORRECTION), (1.0, BEFORE)], part);
            self.follow();
            let now = self.residual();
            // A false decrease of one part in ten thousand is asked for (Kelley, 8.1).
            if now <= (1.0 - 1e-4 * share) * norm {
                return now;
            }
            if norm <= ROUNDED * rounding {
                break;
            }
            share *= 0.5;
        }
        self.system.copy(INCREMENT, BEFORE, part);
        self.follow();
        self.residual()
    }

    /// GMRES, restarted: the correction that leaves no more than this part of the residual, or as little as it can.
    fn correct(&mut self, norm: f64, forcing: f64) {
        let part = self.unknown();
        self.system.zero(CORRECTION, Part::All);
        let mut left = norm;
        for restart in 0..RESTARTS {
            // The residual of the linear equation: minus that of the whole, less what the correction makes of it.
            let begin = Register::Work(FIRST);
            if restart == 0 {
                self.system.combine(begin, &[(-1.0, RESIDUAL)], part);
            } else {
                self.apply(begin, CORRECTION);
                self.system.combine(begin, &[(-1.0, begin), (-1.0, RESIDUAL)], part);
                let now = self.norm(begin);
                // It stands still: Newton's method goes on from here.
                if now <= forcing * norm || now > 0.99 * left {
                    return;
                }
                left = now;
            }
            if self.cycle(left, forcing * norm) <= forcing * norm || self.system.is_stopped() {
                return;
            }
        }
    }

    /// One cycle of GMRES from a residual of norm `left`; the norm of what it leaves.
    fn cycle(&mut self, left: f64, enough: f64) -> f64 {
        let part = self.unknown();
        let weights = core::mem::take(&mut self.weights);
        let arnoldi = Arnoldi::new(FIRST, part, weights);
        arnoldi.begin(self.system, left);
        // The least squares problem, turned into a triangle as it grows.
        let mut triangle: Vec<Vec<f64>> = Vec::new();
        let (mut rotations, mut right) = (Vec::new(), vec![left]);
        while triangle.len() < BASIS {
            let number = triangle.len();
            self.apply(Register::Work(FIRST + number + 1), Register::Work(FIRST + number));
            let mut column = arnoldi.extend(self.system, number);
            for (row, &(cosine, sine)) in rotations.iter().enumerate() {
                let (above, below): (f64, f64) = (column[row], column[row + 1]);
                (column[row], column[row + 1]) = (cosine * above + sine * below, cosine * below - sine * above);
            }
            let (cosine, sine) = givens(column[number], column[number + 1]);
            let ended = column[number + 1] == 0.0;
            column[number] = cosine * column[number] + sine * column[number + 1];
            rotations.push((cosine, sine));
            let last = right[number];
            right[number] = cosine * last;
            right.push(-sine * last);
            triangle.push(column);
            if right[number + 1].abs() <= enough || ended {
                break;
            }
        }
        self.weights = arnoldi.weights;
        let count = triangle.len();
        let mut share = right[..count].to_vec();
        for row in (0..count).rev() {
            for after in row + 1..count {
                share[row] -= triangle[after][row] * share[after];
            }
            // A singular equation has no share of this direction.
            share[row] = if triangle[row][row] == 0.0 { 0.0 } else { share[row] / triangle[row][row] };
        }
        let terms: Vec<_> = share.iter().enumerate().map(|(k, share)| (*share, Register::Work(FIRST + k))).collect();
        self.system.add(CORRECTION, &terms, part);
        right[count].abs()
    }
}
