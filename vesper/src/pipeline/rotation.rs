//! Turns momenta. In: momenta, and by what they are turned, as programs left it. Out: momenta of the same magnitude.
//! Never: a law.
//!
//! The magnitude stays the same over any number of turns: what rounding makes of the factors is the same in every step of
//! a uniform field, and would add up. So the increment is taken off by what it changes the square of the magnitude: (2 p +
//! d) . d, summed without rounding, since what a plain sum makes of it is the same again and again, too.

use super::plan::Key;
use super::run::Runner;
use super::turning::Turning;
use super::vectors::{StateProperty, Vectors};
use crate::integrate::{Register, Rotation, System};
use crate::law::Part;
use crate::real::{Isa, Lanes, Real, Scalar, Vector, WithLanes};

/// Rounds of the rotation by the velocity of the mean momentum. Each is nearer by (omega h / 2)^2 beta^2, or better.
const ROUNDS: usize = 60;

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum To {
    /// The momentum after it, with its rounding error.
    End,
    /// The mean of before and after, for laws to look at.
    Mean,
}

impl<P: Scalar> Runner<'_, P> {
    /// As [`System::turn_momenta`].
    pub(super) fn rotate(&mut self, time: f64, rotation: Rotation) {
        if self.pipeline.vectors.rotation.is_empty() {
            return;
        }
        let others = self.pipeline.turners().next().is_some();
        self.copy_momenta();
        if others {
            self.run(Key::Turners);
        }
        if others && rotation == Rotation::TangentOfMean {
            let enough = 8.0 * P::EPSILON;
            for _ in 0..ROUNDS {
                let moved = self.each_rotation(time, rotation, To::Mean);
                self.run(Key::Turners);
                if moved <= enough * enough {
                    break;
                }
            }
        }
        self.each_rotation(time, rotation, To::End);
    }

    /// The largest square of a change, as a part of that of the momentum.
    fn each_rotation(&self, time: f64, rotation: Rotation, to: To) -> f64 {
        self.come_home(true);
        let exact = rotation == Rotation::Exact;
        let turns = self.pipeline.turnings.iter().filter_map(|turning| {
            let turn = self.prepared(turning, P::from_f64(time), exact, to)?;
            Some(turn.run(self.context.isa).to_f64())
        });
        turns.fold(0.0, f64::max)
    }

    /// Keeps the momenta, or what else is in the state.
    fn copy_momenta(&self) {
        let Some(before) = self.pipeline.vectors.rotation.get(1).map(|before| before.pointer()) else { return };
        // SAFETY: `Runner` is only made for a state with the layout that the vectors were made for, held exclusively.
        unsafe {
            self.pipeline.vectors.each_component_of(Part::Momenta, Register::State, self.context.lent, |at, number| {
                *before.add(at) = number;
            });
        }
    }

    fn prepared(&self, turning: &Turning, time: P, exact: bool, to: To) -> Option<Turn<P>> {
        let vectors = &self.pipeline.vectors;
        let state = vectors.states.iter().find(|state| state.quantity == turning.state)?;
        let [rates, before] = [0, 1].map(|number| vectors.rotation.get(number).map(|vector| vector.pointer()));
        let beside = |vector: *mut P| three(state, |component| vector.wrapping_add(component.at));
        let places = three(state, |component| vectors.place(Register::State, component, self.context.lent))?;
        let errors = vectors.carry().filter(|_| to == To::End);
        let by = if turning.by == turning.state { None } else { Some(self.turned_at(turning)?) };
        Some(Turn {
            momentum: places.map(|(start, _)| start),
            strides: [places[0].1, by.map_or(0, |(_, stride)| stride)],
            before: beside(before?)?,
            turn: beside(rates?)?,
            by: by.map(|(starts, _)| starts),
            errors: errors.and_then(beside),
            count: state.len,
            time,
            exact,
            to,
        })
    }

    /// Where the velocity is that is turned, and how far apart its numbers are.
    fn turned_at(&self, turning: &Turning) -> Option<([*mut P; 3], usize)> {
        let starts: Vec<(*mut P, usize)> = self.pipeline.turners_at[..]
            .iter()
            .filter(|(by, _)| *by == turning.by)
            .map(|(_, place)| (place.base.resolve(self.context.lent), place.stride))
            .collect();
        let &[(x, stride), (y, _), (z, _)] = starts.as_slice() else { return None };
        Some(([x, y, z], stride))
    }

    /// As [`System::turns_amiss`].
    pub(super) fn find_amiss(&mut self) -> Option<String> {
        self.evaluate(Part::Momenta);
        self.come_home(true);
        let before = self.pipeline.vectors.rotation.get(1)?.pointer();
        // SAFETY: as above.
        unsafe {
            self.pipeline.vectors.each_component_of(Part::Momenta, Register::Rates, self.context.lent, |at, number| {
                *before.add(at) = number;
            });
        }
        self.evaluate_unturned();
        self.run(Key::Turners);
        self.come_home(true);
        let amiss = |turning: &&Turning| {
            let turn = self.prepared(turning, P::default(), false, To::Mean);
            let state = self.pipeline.vectors.states.iter().find(|state| state.quantity == turning.state);
            let rates = state.and_then(|state| {
                let start = self.pipeline.vectors.vector(Register::Rates)?;
                three(state, |component| start.wrapping_add(component.at))
            });
            let (Some(turn), Some(rates)) = (turn, rates) else { return false };
            // SAFETY: as above.
            (0..turn.count).any(|row| !unsafe { turn.explains(&rates, row) })
        };
        let turning = self.pipeline.turnings.iter().find(amiss)?;
        self.pipeline
            .structure
            .turned
            .iter()
            .zip(&self.pipeline.turnings)
            .find(|(_, of)| *of == turning)
            .map(|(name, _)| name.clone())
    }
}

/// Something for each component of a vector.
fn three<P: Scalar, T>(state: &StateProperty<P>, of: impl FnMut(&super::vectors::Component<P>) -> T) -> Option<[T; 3]> {
    state.components.iter().map(of).collect::<Vec<T>>().try_into().ok()
}

/// The work of turning one momentum.
#[derive(Clone, Copy)]
struct Turn<P> {
    momentum: [*mut P; 3],
    /// How far apart the numbers of the momentum are, and those of the velocity.
    strides: [usize; 2],
    /// What is turned: the momentum as it was.
    before: [*mut P; 3],
    /// By what, times momentum over velocity.
    turn: [*mut P; 3],
    /// The velocity at the momentum, where it is another one.
    by: Option<[*mut P; 3]>,
    /// The rounding errors of the momentum, where they are kept.
    errors: Option<[*mut P; 3]>,
    count: usize,
    time: P,
    exact: bool,
    to: To,
}

impl<P: Scalar> Turn<P> {
    fn run(self, isa: Isa) -> P {
        if self.strides[0] == 1 && self.strides[1] <= 1 {
            return P::with_lanes(isa, self);
        }
        // SAFETY: as in `with`.
        (0..self.count).fold(P::default(), |most, row| most.max(unsafe { self.rows::<P>(row) }))
    }

    /// # Safety
    /// There are `R::WIDTH` rows from `row` on, side by side where that is more than one.
    #[inline(always)]
    unsafe fn load<R: Lanes<P>>(starts: [*mut P; 3], row: usize, stride: usize) -> R::Vec3 {
        // SAFETY: passed on to the caller.
        let [x, y, z] = starts.map(|start| unsafe { R::load(start.add(row * stride)) });
        R::Vec3::new(x, y, z)
    }

    /// Turns some rows; the largest square of what the momentum changed by, as a part of its own.
    ///
    /// # Safety
    /// As for [`Turn::load`]; nobody else touches the rows.
    #[inline(always)]
    unsafe fn rows<R: Lanes<P>>(&self, row: usize) -> P {
        let (zero, one, two) = (R::lit(0.0), R::lit(1.0), R::lit(2.0));
        // SAFETY: passed on to the caller.
        let (now, before, turn) = unsafe {
            let now = Self::load::<R>(self.momentum, row, self.strides[0]);
            (now, Self::load::<R>(self.before, row, 1), Self::load::<R>(self.turn, row, 1))
        };
        let scale = match self.by {
            None => one,
            Some(by) => {
                // SAFETY: passed on to the caller.
                let turned = unsafe { Self::load::<R>(by, row, self.strides[1]) };
                let square = now.length_squared();
                R::select(square.equal(zero), zero, turned.dot(now) / square)
            }
        };
        let rate = turn * scale;
        let time = R::splat(self.time);
        let change = if self.exact {
            let square = rate.length_squared();
            let still = square.equal(zero);
            // Without a rate any direction will do: the momentum is turned by no angle.
            let size = R::select(still, one, square.sqrt());
            let half = R::lit(0.5) * size * time;
            let (sine, cosine) = (half.sin(), half.cos());
            let across = before.cross(rate / size);
            across * (two * sine * cosine) + across.cross(rate / size) * (two * sine * sine)
        } else {
            let tangent = rate * (R::lit(0.5) * time);
            let middle = before + before.cross(tangent);
            middle.cross(tangent) * (two / (one + tangent.length_squared()))
        };
        let square = before.length_squared();
        let excess = excess::<P, R>(before, change);
        let part = R::select(square.equal(zero), zero, excess / (square * two));
        // Less than half of the last digit of the increment: kept beside it, or it would be lost.
        let rest = (before + change) * -part;
        let mut most = zero;
        let places = self.momentum.map(|start| start.wrapping_add(row * self.strides[0]));
        let parts = |v: R::Vec3| [v.x(), v.y(), v.z()];
        if self.to == To::Mean {
            let mean = before + change * R::lit(0.5);
            most = R::select(square.equal(zero), zero, (mean - now).length_squared() / square);
            for (to, number) in places.into_iter().zip(parts(mean)) {
                // SAFETY: passed on to the caller.
                unsafe { number.store(to) };
            }
        } else {
            let [before, change, rest] = [before, change, rest].map(parts);
            for (component, to) in places.into_iter().enumerate() {
                let [end, off] = sum_of(before[component], change[component]);
                let error = self.errors.map(|errors| errors[component].wrapping_add(row));
                // SAFETY: passed on to the caller.
                unsafe {
                    let kept = error.map_or(zero, |error| R::load(error));
                    let rest = off + (rest[component] - kept);
                    let after = end + rest;
                    if let Some(error) = error {
                        ((after - end) - rest).store(error);
                    }
                    after.store(to);
                }
            }
        }
        (0..R::WIDTH).fold(P::default(), |least, lane| least.max(most.lane(lane)))
    }

    /// Whether a row's full rate, which is in `before`, is that without turning and velocity x turn, to half the digits.
    ///
    /// # Safety
    /// The row exists; `rates` are vectors as `before` is.
    unsafe fn explains(&self, rates: &[*mut P; 3], row: usize) -> bool {
        // SAFETY: passed on to the caller.
        let [full, kick, turn, turned] = unsafe {
            [
                Self::load::<P>(self.before, row, 1),
                Self::load::<P>(*rates, row, 1),
                Self::load::<P>(self.turn, row, 1),
                match self.by {
                    Some(by) => Self::load::<P>(by, row, self.strides[1]),
                    None => Self::load::<P>(self.momentum, row, self.strides[0]),
                },
            ]
        };
        let across = turned.cross(turn);
        let error = (full - kick - across).length();
        let size = full.length() + kick.length() + turned.length() * turn.length();
        error <= size * P::from_f64(P::EPSILON.sqrt()) || !size.is_finite()
    }
}

/// a + b, and what its rounding takes off (Knuth, The Art of Computer Programming, vol. 2, 4.2.2, theorem B).
#[inline(always)]
fn sum_of<R: Real>(a: R, b: R) -> [R; 2] {
    let sum = a + b;
    let part = sum - a;
    [sum, (a - (sum - part)) + (b - part)]
}

/// a b, and what its rounding takes off (Dekker, Numer. Math. 18 (1971) 224).
#[inline(always)]
fn product_of<P: Scalar, R: Real>(a: R, b: R) -> [R; 2] {
    // 1 + 2^ceil(digits / 2); of double-double numbers this leaves an error of their last digits.
    let splitter = R::lit(if P::EPSILON < 1e-10 { 134_217_729.0 } else { 4097.0 });
    let halves = |number: R| {
        let scaled = number * splitter;
        let high = scaled - (scaled - number);
        [high, number - high]
    };
    let (product, [a, b]) = (a * b, [halves(a), halves(b)]);
    [product, ((a[0] * b[0] - product) + a[0] * b[1] + a[1] * b[0]) + a[1] * b[1]]
}

/// (2 p + d) . d, to its own last digit.
#[inline(always)]
fn excess<P: Scalar, R: Real>(before: R::Vec3, change: R::Vec3) -> R {
    let pairs = [(before.x(), change.x()), (before.y(), change.y()), (before.z(), change.z())];
    let mut total = [R::lit(0.0); 2];
    for (before, change) in pairs {
        let [both, rest] = sum_of(before + before, change);
        let [product, low] = product_of::<P, R>(both, change);
        let [sum, off] = sum_of(total[0], product);
        total = [sum, total[1] + (off + low + rest * change)];
    }
    total[0] + total[1]
}

impl<P: Scalar> WithLanes<P> for Turn<P> {
    type Output = P;
    #[inline(always)]
    fn with<R: Lanes<P>>(self) -> P {
        let mut most = P::default();
        let wide = self.count - self.count % R::WIDTH;
        let mut row = 0;
        while row < wide {
            // SAFETY: whoever makes a turn has `count` numbers everywhere; the runner holds the state.
            most = most.max(unsafe { self.rows::<R>(row) });
            row += R::WIDTH;
        }
        while row < self.count {
            // SAFETY: as above.
            most = most.max(unsafe { self.rows::<P>(row) });
            row += 1;
        }
        most
    }
}

impl<P: Scalar> Vectors<P> {
    /// Gives every number of a part of a vector, and where it is in others.
    ///
    /// # Safety
    /// As for [`Vectors::linear`].
    unsafe fn each_component_of(&self, part: Part, of: Register, lent: &[*mut P], mut each: impl FnMut(usize, P)) {
        for (_, state) in self.part(part) {
            for component in &state.components {
                let (start, stride) = self.place(of, component, lent);
                for row in 0..state.len {
                    // SAFETY: the component has `len` numbers; passed on to the caller.
                    each(component.at + row, unsafe { *start.add(row * stride) });
                }
            }
        }
    }
}
