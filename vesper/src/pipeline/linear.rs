//! Sums of vectors, in lanes, and magnitudes of rows: what integrators are written in.

use super::vectors::{Component, Vectors};
use crate::integrate::{Combination, Register, Term};
use crate::law::Part;
use crate::real::{Isa, Lanes, Scalar, WithLanes};

/// Terms that are summed in one pass; more are added in further ones.
const TERMS: usize = 24;

/// Vectors that are looked at together.
const LOOKS: usize = 12;

impl<P: Scalar> Vectors<P> {
    /// Sums vectors.
    ///
    /// # Safety
    /// The state that the vectors were laid out for is held, and `lent` are the addresses of its lent memory.
    pub(crate) unsafe fn linear(&self, combination: &Combination<'_>, lent: &[*mut P], isa: Isa) {
        let Combination { to, mut adds, part, terms, momenta } = *combination;
        let behind = self.momentum_behind.unwrap_or(0);
        let mut all = momenta.iter().map(|term| (*term, behind)).chain(terms.iter().map(|term| (*term, 0))).peekable();
        loop {
            let mut some = [((0.0, Register::Rates), 0); TERMS];
            let mut count = 0;
            for place in &mut some {
                let Some(term) = all.next() else { break };
                *place = term;
                count += 1;
            }
            // SAFETY: passed on to the caller.
            unsafe { self.pass(to, adds, part, &some[..count], lent, isa) };
            if all.peek().is_none() {
                return;
            }
            adds = true;
        }
    }

    /// # Safety
    /// As for [`Vectors::linear`].
    unsafe fn pass(&self, to: Register, adds: bool, part: Part, terms: &[(Term, usize)], lent: &[*mut P], isa: Isa) {
        let errors = if to == Register::State && adds { self.carry() } else { None };
        let in_one = to != Register::State && terms.iter().all(|((_, from), _)| *from != Register::State);
        let mut sources = [(P::default(), core::ptr::null::<P>()); TERMS];
        if let (true, Some(span), Some(start)) = (in_one, self.span(part), self.vector(to)) {
            for (source, ((factor, from), behind)) in sources.iter_mut().zip(terms) {
                let from = self.vector(*from).unwrap_or(start).wrapping_add(span.start + behind);
                *source = (P::from_f64(*factor), from);
            }
            let to = start.wrapping_add(span.start);
            let errors = core::ptr::null_mut();
            let sum = Sum { to, errors, adds, count: span.len(), sources: &sources[..terms.len()] };
            return P::with_lanes(isa, sum);
        }
        for (_, state) in self.part(part) {
            for (number, component) in state.components.iter().enumerate() {
                let (start, stride) = self.place(to, component, lent);
                let mut strides = [1; TERMS];
                let mut even = stride == 1;
                for (index, ((factor, from), behind)) in terms.iter().enumerate() {
                    let (from, stride) = match self.vector(*from) {
                        Some(start) => (start.wrapping_add(component.at + behind), 1),
                        None if *behind > 0 => self.momentum(component.at + behind, number, lent),
                        None => self.place(Register::State, component, lent),
                    };
                    sources[index] = (P::from_f64(*factor), from);
                    strides[index] = stride;
                    even &= stride == 1;
                }
                let errors = errors.map_or(core::ptr::null_mut(), |errors| errors.wrapping_add(component.at));
                let sum = Sum { to: start, errors, adds, count: state.len, sources: &sources[..terms.len()] };
                if even {
                    P::with_lanes(isa, sum);
                } else {
                    // SAFETY: all places have `len` numbers, their strides apart; passed on to the caller.
                    unsafe { sum.strided(stride, &strides) };
                }
            }
        }
    }

    /// Where a component is in a register, and how far apart its numbers are.
    fn place(&self, register: Register, component: &Component<P>, lent: &[*mut P]) -> (*mut P, usize) {
        match self.vector(register) {
            Some(start) => (start.wrapping_add(component.at), 1),
            None => (component.place.base.resolve(lent), component.place.stride),
        }
    }

    /// The state's component that is at this place of every vector.
    fn momentum(&self, at: usize, number: usize, lent: &[*mut P]) -> (*mut P, usize) {
        let found = self.states.iter().filter_map(|state| state.components.get(number)).find(|other| other.at == at);
        found.map_or((core::ptr::null_mut(), 0), |component| self.place(Register::State, component, lent))
    }

    /// Whether the rates of the coordinates are the momenta of the state, number by number.
    ///
    /// # Safety
    /// As for [`Vectors::linear`].
    pub(crate) unsafe fn rates_are_momenta(&self, lent: &[*mut P]) -> bool {
        let Some(behind) = self.momentum_behind else { return false };
        self.part(Part::Coordinates).all(|(_, state)| {
            state.components.iter().enumerate().all(|(number, component)| {
                let (rates, _) = self.place(Register::Rates, component, lent);
                let (momenta, stride) = self.momentum(component.at + behind, number, lent);
                // SAFETY: both have `len` numbers; passed on to the caller.
                (0..state.len).all(|row| unsafe { *rates.add(row) == *momenta.add(row * stride) })
            })
        })
    }

    /// Goes through the rows of a part.
    ///
    /// # Safety
    /// As for [`Vectors::linear`].
    pub(crate) unsafe fn magnitudes(
        &self,
        of: &[Register],
        part: Part,
        lent: &[*mut P],
        each: &mut dyn FnMut(usize, &[f64]),
    ) {
        let of = &of[..of.len().min(LOOKS)];
        let mut row_of = [0.0; LOOKS];
        for (number, state) in self.part(part) {
            for row in 0..state.len {
                for (magnitude, register) in row_of.iter_mut().zip(of) {
                    let mut squares = 0.0;
                    let mut last = 0.0;
                    for component in &state.components {
                        let (start, stride) = self.place(*register, component, lent);
                        // SAFETY: the component has `len` numbers there; passed on to the caller.
                        last = unsafe { *start.add(row * stride) }.to_f64();
                        squares += last * last;
                    }
                    *magnitude = if state.components.len() == 1 { last.abs() } else { squares.sqrt() };
                }
                each(number, &row_of[..of.len()]);
            }
        }
    }
}

/// A sum of arrays of `count` numbers.
struct Sum<'a, P> {
    to: *mut P,
    /// The rounding errors of what is added to, or null.
    errors: *mut P,
    adds: bool,
    count: usize,
    sources: &'a [(P, *const P)],
}

impl<P: Scalar> Sum<'_, P> {
    /// From number `at` on, as many whole sets of `SETS` lanes as there are; where they end.
    ///
    /// # Safety
    /// All pointers are to `count` numbers, which nobody else touches.
    #[inline(always)]
    unsafe fn lanes<R: Lanes<P>, const SETS: usize>(&self, mut at: usize) -> usize {
        while at + SETS * R::WIDTH <= self.count {
            // SAFETY: the lanes are within the `count` numbers.
            unsafe {
                let mut sums = [R::lit(0.0); SETS];
                for (number, (factor, from)) in self.sources.iter().enumerate() {
                    let factor = R::splat(*factor);
                    for (set, sum) in sums.iter_mut().enumerate() {
                        let term = R::load(from.add(at + set * R::WIDTH)) * factor;
                        *sum = if number == 0 { term } else { *sum + term };
                    }
                }
                for (set, sum) in sums.into_iter().enumerate() {
                    let to = self.to.add(at + set * R::WIDTH);
                    if !self.adds {
                        sum.store(to);
                    } else if self.errors.is_null() {
                        (R::load(to) + sum).store(to);
                    } else {
                        let errors = self.errors.add(at + set * R::WIDTH);
                        let (before, sum) = (R::load(to), sum - R::load(errors));
                        let after = before + sum;
                        ((after - before) - sum).store(errors);
                        after.store(to);
                    }
                }
            }
            at += SETS * R::WIDTH;
        }
        at
    }

    /// One number at a time, at their own distances.
    ///
    /// # Safety
    /// All pointers are to `count` numbers, so far apart, which nobody else touches.
    unsafe fn strided(&self, stride: usize, strides: &[usize]) {
        for row in 0..self.count {
            let mut sources = [(P::default(), core::ptr::null::<P>()); TERMS];
            for ((source, (factor, from)), stride) in sources.iter_mut().zip(self.sources).zip(strides) {
                *source = (*factor, from.wrapping_add(row * stride));
            }
            let errors = if self.errors.is_null() { self.errors } else { self.errors.wrapping_add(row) };
            let to = self.to.wrapping_add(row * stride);
            let sources = &sources[..self.sources.len()];
            let one = Sum { to, errors, adds: self.adds, count: 1, sources };
            // SAFETY: passed on to the caller.
            unsafe { one.lanes::<P, 1>(0) };
        }
    }
}

impl<P: Scalar> WithLanes<P> for Sum<'_, P> {
    type Output = ();
    #[inline(always)]
    fn with<R: Lanes<P>>(self) {
        // SAFETY: whoever makes a sum has pointers to that many numbers; the runner holds the state.
        unsafe {
            let at = self.lanes::<R, 4>(0);
            let at = self.lanes::<R, 1>(at);
            self.lanes::<P, 1>(at);
        }
    }
}
