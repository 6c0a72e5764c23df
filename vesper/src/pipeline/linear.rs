//! Sums of vectors, in lanes: what integrators are written in.

use super::vectors::{Component, Vectors};
use crate::integrate::{Combination, Register, Term};
use crate::law::Part;
use crate::real::{Isa, Lanes, Scalar, WithLanes};
use core::mem::MaybeUninit;
use core::ops::Range;

/// Terms that are summed in one pass; more are added in further ones.
const TERMS: usize = 24;

/// Numbers that are summed in f64 side by side.
const WIDE: usize = 8;

impl<P: Scalar> Vectors<P> {
    /// Sums vectors.
    ///
    /// # Safety
    /// The state that the vectors were laid out for is held, and `lent` are the addresses of its lent memory.
    pub(crate) unsafe fn linear(&self, combination: &Combination<'_>, lent: &[*mut P], isa: Isa) {
        let Combination { to, mut adds, part, mut terms, mut momenta } = *combination;
        // Anyone may write an integrator: one that asks for what is not there gets a panic, and never other memory.
        let paired = momenta.is_empty() || part == Part::Coordinates && self.momentum_behind.is_some();
        assert!(paired, "momenta are summed to the coordinates they move, where coordinates_follow_momenta");
        if let ([(1.0, from)], [], false, Some(span)) = (terms, momenta, adds, self.span(part)) {
            // SAFETY: passed on to the caller.
            return unsafe { self.copy((to, *from), (part, span), lent) };
        }
        loop {
            let (now, later) = momenta.split_at(momenta.len().min(TERMS));
            let (also, rest) = terms.split_at(terms.len().min(TERMS - now.len()));
            let some = Combination { to, adds, part, terms: also, momenta: now };
            // SAFETY: passed on to the caller.
            unsafe {
                match (self.span(part), self.image()) {
                    (Some(span), Some(image)) => self.in_one(&some, (span, image), lent, isa),
                    _ => self.by_component(&some, lent, isa),
                }
            }
            (terms, momenta, adds) = (rest, later, true);
            if terms.is_empty() && momenta.is_empty() {
                return;
            }
        }
    }

    /// A small state, or a part of it, in the place of another vector's.
    ///
    /// # Safety
    /// As for [`Vectors::linear`].
    unsafe fn copy(&self, (to, from): (Register, Register), (part, span): (Part, Range<usize>), lent: &[*mut P]) {
        // SAFETY: all vectors have a place for every number of the state; passed on to the caller.
        unsafe {
            match (self.vector(to), self.vector(from)) {
                (Some(to), Some(from)) => {
                    to.wrapping_add(span.start).copy_from(from.wrapping_add(span.start), span.len())
                }
                (Some(to), None) => self.each_component(part, lent, to, |state, to| *to = *state),
                (None, Some(from)) => self.each_component(part, lent, from, |state, from| *state = *from),
                (None, None) => {}
            }
        }
    }

    /// A small state: one sum over all components, with an image of the state beside the other vectors where it does not
    /// stand as they do.
    ///
    /// # Safety
    /// As for [`Vectors::linear`].
    unsafe fn in_one(
        &self,
        combination: &Combination<'_>,
        (span, image): (Range<usize>, *mut P),
        lent: &[*mut P],
        isa: Isa,
    ) {
        let Combination { to, adds, part, terms, momenta } = *combination;
        // Where the state stands as a vector does, it needs no image.
        let apart = self.vector(Register::State).is_none();
        let looks_at_state = |terms: &[Term]| apart && terms.iter().any(|(_, from)| *from == Register::State);
        // SAFETY: the image has a place for every number of the state; passed on to the caller.
        unsafe {
            if apart && adds && to == Register::State || looks_at_state(terms) {
                self.each_component(part, lent, image, |state, image| *image = *state);
            }
            if looks_at_state(momenta) {
                self.each_component(Part::Momenta, lent, image, |state, image| *image = *state);
            }
        }
        let start = |register| self.start(register).wrapping_add(span.start);
        let behind = self.momentum_behind.unwrap_or(0);
        // Not filled with anything first: that took as long as three terms.
        let mut places = [const { MaybeUninit::uninit() }; TERMS];
        let (of_momenta, rest) = places.split_at_mut(momenta.len());
        let (own, _) = rest.split_at_mut(terms.len());
        for (place, (factor, from)) in of_momenta.iter_mut().zip(momenta) {
            place.write((*factor, start(*from).wrapping_add(behind).cast_const()));
        }
        for (place, (factor, from)) in own.iter_mut().zip(terms) {
            place.write((*factor, start(*from).cast_const()));
        }
        // SAFETY: so many are written.
        let sources = unsafe { places[..momenta.len() + terms.len()].assume_init_ref() };
        let errors = if to == Register::State && adds { self.carry() } else { None };
        let sum = Sum {
            to: start(to),
            errors: errors.map_or(core::ptr::null_mut(), |errors| errors.wrapping_add(span.start)),
            adds,
            wide: self.sums_in_f64(),
            count: span.len(),
            sources,
        };
        P::with_lanes(isa, sum);
        if apart && to == Register::State {
            // SAFETY: as above.
            unsafe { self.each_component(part, lent, image, |state, image| *state = *image) };
        }
    }

    /// Whether f64 has more digits than the state, and they are wanted: where rounding errors are kept. A step, or a
    /// coefficient of an integrator, that is rounded to f32 is wrong by the same part each time, which no kept error mends.
    fn sums_in_f64(&self) -> bool {
        self.compensated && P::EPSILON > f64::EPSILON
    }

    /// Gives every number of a part of the state, and its place in the image.
    ///
    /// # Safety
    /// As for [`Vectors::linear`].
    unsafe fn each_component(&self, part: Part, lent: &[*mut P], image: *mut P, each: impl Fn(&mut P, &mut P)) {
        for (_, state) in self.part(part) {
            for component in &state.components {
                let (start, stride) = self.place(Register::State, component, lent);
                let image = image.wrapping_add(component.at);
                for row in 0..state.len {
                    // SAFETY: both have `len` numbers, and are different arrays; passed on to the caller.
                    unsafe { each(&mut *start.add(row * stride), &mut *image.add(row)) };
                }
            }
        }
    }

    /// # Safety
    /// As for [`Vectors::linear`].
    #[inline(never)]
    unsafe fn by_component(&self, combination: &Combination<'_>, lent: &[*mut P], isa: Isa) {
        let Combination { to, adds, part, terms, momenta } = *combination;
        let errors = if to == Register::State && adds { self.carry() } else { None };
        let behind = self.momentum_behind.unwrap_or(0);
        let count = momenta.len() + terms.len();
        for (_, state) in self.part(part) {
            for (number, component) in state.components.iter().enumerate() {
                let mut sources = [(0.0, core::ptr::null::<P>()); TERMS];
                let mut strides = [1; TERMS];
                let moving = momenta.iter().map(|(factor, from)| match self.vector(*from) {
                    Some(start) => (*factor, start.wrapping_add(component.at + behind), 1),
                    None => {
                        let (start, stride) = self.momentum(component.at + behind, number, lent);
                        (*factor, start, stride)
                    }
                });
                let own = terms.iter().map(|(factor, from)| {
                    let (start, stride) = self.place(*from, component, lent);
                    (*factor, start, stride)
                });
                let (start, stride) = self.place(to, component, lent);
                let mut even = stride == 1;
                for (index, (factor, from, stride)) in moving.chain(own).enumerate() {
                    sources[index] = (factor, from.cast_const());
                    strides[index] = stride;
                    even &= stride == 1;
                }
                let errors = errors.map_or(core::ptr::null_mut(), |errors| errors.wrapping_add(component.at));
                let wide = self.sums_in_f64();
                let sum = Sum { to: start, errors, adds, wide, count: state.len, sources: &sources[..count] };
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
    pub(super) fn place(&self, register: Register, component: &Component<P>, lent: &[*mut P]) -> (*mut P, usize) {
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
}

/// A sum of arrays of `count` numbers.
struct Sum<'a, P> {
    to: *mut P,
    /// The rounding errors of what is added to, or null.
    errors: *mut P,
    adds: bool,
    /// Whether it is summed in f64, of numbers that are none.
    wide: bool,
    count: usize,
    sources: &'a [(f64, *const P)],
}

impl<P: Scalar> Sum<'_, P> {
    /// The lanes that begin at these numbers. All are read before any is written, so that they may overlap. Plain loops over
    /// the sets: with closures and iterators the sums were kept in memory, and some operations became calls.
    ///
    /// # Safety
    /// All pointers are to `count` numbers, which nobody else touches, and the lanes are within them.
    #[inline(always)]
    unsafe fn lanes<R: Lanes<P>, const SETS: usize>(&self, starts: [usize; SETS]) {
        // SAFETY: the caller promises the lanes.
        unsafe {
            let mut sums = [R::lit(0.0); SETS];
            if let Some(((factor, from), rest)) = self.sources.split_first() {
                let factor = R::splat(P::from_f64(*factor));
                for set in 0..SETS {
                    sums[set] = R::load(from.add(starts[set])) * factor;
                }
                for (factor, from) in rest {
                    let factor = R::splat(P::from_f64(*factor));
                    for set in 0..SETS {
                        sums[set] += R::load(from.add(starts[set])) * factor;
                    }
                }
            }
            if self.adds {
                let mut before = [R::lit(0.0); SETS];
                for set in 0..SETS {
                    before[set] = R::load(self.to.add(starts[set]));
                }
                if self.errors.is_null() {
                    for set in 0..SETS {
                        sums[set] += before[set];
                    }
                } else {
                    let mut errors = [R::lit(0.0); SETS];
                    for set in 0..SETS {
                        errors[set] = R::load(self.errors.add(starts[set]));
                    }
                    for set in 0..SETS {
                        let (before, sum) = (before[set], sums[set] - errors[set]);
                        let after = before + sum;
                        // Knuth's sum: exact whichever of the two is the larger.
                        let change = after - before;
                        let lost = ((after - change) - before) + (change - sum);
                        lost.store(self.errors.add(starts[set]));
                        sums[set] = after;
                    }
                }
            }
            for set in 0..SETS {
                sums[set].store(self.to.add(starts[set]));
            }
        }
    }

    /// Numbers from this one on, summed in f64. What is added to the state has there what f32 left out, as far as another f32
    /// holds it: the state has 48 bits.
    ///
    /// # Safety
    /// All pointers are to `count` numbers, which nobody else touches, and these are among them.
    #[inline(always)]
    unsafe fn in_f64<const COUNT: usize>(&self, at: usize) {
        let mut sums = [0.0; COUNT];
        // SAFETY: the caller promises the numbers.
        unsafe {
            for (factor, from) in self.sources {
                for (number, sum) in sums.iter_mut().enumerate() {
                    *sum += factor * (*from.add(at + number)).to_f64();
                }
            }
            for (number, sum) in sums.into_iter().enumerate() {
                let (to, errors) = (self.to.add(at + number), self.errors.wrapping_add(at + number));
                let keeps = self.adds && !self.errors.is_null();
                let error = if keeps { (*errors).to_f64() } else { 0.0 };
                let exact = if self.adds { (*to).to_f64() + (sum - error) } else { sum };
                *to = P::from_f64(exact);
                if keeps {
                    *errors = P::from_f64((*to).to_f64() - exact);
                }
            }
        }
    }

    /// One number at a time, at their own distances.
    ///
    /// # Safety
    /// All pointers are to `count` numbers, so far apart, which nobody else touches.
    unsafe fn strided(&self, stride: usize, strides: &[usize]) {
        for row in 0..self.count {
            let mut sources = [(0.0, core::ptr::null::<P>()); TERMS];
            for ((source, (factor, from)), stride) in sources.iter_mut().zip(self.sources).zip(strides) {
                *source = (*factor, from.wrapping_add(row * stride));
            }
            let errors = if self.errors.is_null() { self.errors } else { self.errors.wrapping_add(row) };
            let to = self.to.wrapping_add(row * stride);
            let sources = &sources[..self.sources.len()];
            let one = Sum { to, errors, count: 1, sources, ..*self };
            // SAFETY: passed on to the caller.
            unsafe { if one.wide { one.in_f64::<1>(0) } else { one.lanes::<P, 1>([0]) } };
        }
    }
}

impl<P: Scalar> WithLanes<P> for Sum<'_, P> {
    type Output = ();
    #[inline(always)]
    fn with<R: Lanes<P>>(self) {
        let count = self.count;
        let width = R::WIDTH;
        let mut at = 0;
        // SAFETY: whoever makes a sum has pointers to that many numbers, and the runner holds the state; the last lanes end
        // with the last number, and overlap those before them.
        unsafe {
            if self.wide {
                while at + WIDE <= count {
                    self.in_f64::<WIDE>(at);
                    at += WIDE;
                }
                return (at..count).for_each(|number| self.in_f64::<1>(number));
            }
            if count < width {
                return (0..count).for_each(|number| self.lanes::<P, 1>([number]));
            }
            // So that what is left for the last lanes is never less than one set of them.
            while at + 5 * width <= count {
                self.lanes::<R, 4>([at, at + width, at + 2 * width, at + 3 * width]);
                at += 4 * width;
            }
            let last = count - width;
            match (count - at).div_ceil(width) {
                1 => self.lanes::<R, 1>([last]),
                2 => self.lanes::<R, 2>([at, last]),
                3 => self.lanes::<R, 3>([at, at + width, last]),
                4 => self.lanes::<R, 4>([at, at + width, at + 2 * width, last]),
                _ => self.lanes::<R, 5>([at, at + width, at + 2 * width, at + 3 * width, last]),
            }
        }
    }
}
