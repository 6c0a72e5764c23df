//! Sums of vectors: what integrators are written in. In: registers. Out: arrays of numbers that are summed. Never: a sum.

use super::sum::{Sum, TERMS};
use super::vectors::{Component, StateProperty, Vectors};
use crate::integrate::{Combination, Register, Terms};
use crate::law::Part;
use crate::real::{Isa, Scalar};
use core::ops::Range;

impl<P: Scalar> Vectors<P> {
    /// Sums vectors.
    ///
    /// # Safety
    /// The state that the vectors were laid out for is held, and `lent` are the addresses of its lent memory.
    pub(crate) unsafe fn linear(&self, combination: &Combination<'_>, lent: &[*mut P], isa: Isa) {
        let Combination { part, terms, momenta, .. } = *combination;
        self.check_momenta(combination);
        // SAFETY: passed on to the caller.
        unsafe {
            if momenta.len() + terms.len() > TERMS {
                return self.in_turns(combination, lent, isa);
            }
            match (self.span(part), self.vector(Register::State), self.image()) {
                (Some(span), Some(_), _) => self.in_one(combination, span, isa),
                (Some(span), None, Some(image)) => self.by_image(combination, (span, image), lent, isa),
                _ => self.by_component(combination, self.part(part), lent, isa),
            }
        }
    }

    /// Sums the vectors of those states that no device has.
    ///
    /// # Safety
    /// As for [`Vectors::linear`].
    #[cfg(feature = "gpu")]
    pub(crate) unsafe fn linear_on_host(&self, combination: &Combination<'_>, lent: &[*mut P], isa: Isa) {
        let (mut left, mut adds) = ((combination.momenta, combination.terms), combination.adds);
        loop {
            let (momenta, momenta_left) = left.0.split_at(TERMS);
            let (terms, terms_left) = left.1.split_at(TERMS - momenta.len());
            let now = Combination { adds, terms, momenta, ..*combination };
            let states = self.part(combination.part).filter(|(_, state)| !state.on_device);
            // SAFETY: passed on to the caller.
            unsafe { self.by_component(&now, states, lent, isa) };
            if momenta_left.len() + terms_left.len() == 0 {
                return;
            }
            (left, adds) = ((momenta_left, terms_left), true);
        }
    }

    /// Anyone may write an integrator: one that asks for what is not there gets a panic, and never other memory.
    pub(super) fn check_momenta(&self, Combination { part, momenta, .. }: &Combination<'_>) {
        let paired = momenta.len() == 0 || *part == Part::Coordinates && self.momentum_behind.is_some();
        assert!(paired, "momenta are summed to the coordinates they move, where coordinates_follow_momenta");
    }

    /// More terms than are summed in one pass.
    ///
    /// # Safety
    /// As for [`Vectors::linear`].
    #[cold]
    unsafe fn in_turns(&self, combination: &Combination<'_>, lent: &[*mut P], isa: Isa) {
        let trial = combination.to == Register::State && !combination.adds && self.compensated;
        assert!(!trial, "a trial of a compensated state has at most {TERMS} terms");
        let (momenta, momenta_left) = combination.momenta.split_at(TERMS);
        let (terms, terms_left) = combination.terms.split_at(TERMS - momenta.len());
        // SAFETY: passed on to the caller.
        unsafe {
            self.linear(&Combination { terms, momenta, ..*combination }, lent, isa);
            self.linear(
                &Combination { adds: true, terms: terms_left, momenta: momenta_left, ..*combination },
                lent,
                isa,
            );
        }
    }

    /// A vector, or a part of it, in the place of another one.
    ///
    /// # Safety
    /// As for [`Vectors::linear`].
    pub(crate) unsafe fn copy(&self, (to, from): (Register, Register), part: Part, lent: &[*mut P], isa: Isa) {
        let Some(span) = self.span(part) else {
            let whole = [(1.0, from)];
            let copy = Combination { to, adds: false, part, terms: Terms::of(&whole), momenta: Terms::NONE };
            // SAFETY: passed on to the caller.
            return unsafe { self.by_component(&copy, self.part(part), lent, isa) };
        };
        if to == Register::State {
            self.look_at_errors(span.clone());
        }
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

    /// The state is what its rounding errors belong to.
    pub(crate) fn look_at_errors(&self, span: Range<usize>) {
        if let (Some(rests), Some(errors)) = (self.rests, self.carry()) {
            // SAFETY: both are vectors, and different ones.
            unsafe { rests.add(span.start).copy_from_nonoverlapping(errors.add(span.start), span.len()) };
        }
    }

    /// A small state that does not stand as the other vectors do: the same with an image of it that does.
    ///
    /// # Safety
    /// As for [`Vectors::linear`].
    #[inline(never)]
    unsafe fn by_image(
        &self,
        combination: &Combination<'_>,
        (span, image): (Range<usize>, *mut P),
        lent: &[*mut P],
        isa: Isa,
    ) {
        let Combination { to, adds, part, terms, momenta } = *combination;
        let looks_at_state = |terms: Terms<'_>| terms.others.iter().any(|(_, from)| *from == Register::State);
        // SAFETY: the image has a place for every number of the state; passed on to the caller.
        unsafe {
            if adds && to == Register::State || looks_at_state(terms) {
                self.each_component(part, lent, image, |state, image| *image = *state);
            }
            if looks_at_state(momenta) {
                self.each_component(Part::Momenta, lent, image, |state, image| *image = *state);
            }
            self.in_one(combination, span, isa);
            if to == Register::State {
                self.each_component(part, lent, image, |state, image| *state = *image);
            }
        }
    }

    /// A small state: one sum over all components.
    ///
    /// # Safety
    /// As for [`Vectors::linear`]; the state stands as the other vectors do, or its image is what is meant.
    #[inline]
    unsafe fn in_one(&self, combination: &Combination<'_>, span: Range<usize>, isa: Isa) {
        let Combination { to, adds, ref terms, ref momenta, .. } = *combination;
        let trial;
        // A trial that begins at a vector begins at its rounding errors, too, where somebody looks at what the trial leaves out.
        let (terms, base) = match terms.others {
            [others @ .., (1.0, from)] if !adds && to == Register::State && self.rests.is_some() => {
                trial = terms.and(others);
                (&trial, Some(self.start(*from).wrapping_add(span.start)))
            }
            _ => (terms, None),
        };
        let to_start = self.start(to).wrapping_add(span.start);
        let [errors, rests] = [self.carry(), self.rests].map(|start| match start {
            Some(start) if to == Register::State => start.wrapping_add(span.start),
            _ => core::ptr::null_mut(),
        });
        let (base, errors, lost) = if adds {
            (to_start.cast_const(), errors.cast_const(), [errors, rests])
        } else if let Some(base) = base {
            (base.cast_const(), errors.cast_const(), [rests, core::ptr::null_mut()])
        } else {
            if !rests.is_null() {
                // SAFETY: rests have a place for every number of the state.
                unsafe { core::slice::from_raw_parts_mut(rests, span.len()) }.fill(P::default());
            }
            (core::ptr::null(), core::ptr::null(), [core::ptr::null_mut(); 2])
        };
        let sum = Sum {
            to: to_start,
            base,
            errors,
            lost,
            wide: self.sums_in_f64(),
            count: span.len(),
            starts: self.starts(),
            terms: [(momenta, span.start + self.momentum_behind.unwrap_or(0)), (terms, span.start)],
        };
        // Up to four half registers: whole ones overlap, and cross lines of the cache.
        P::with_lanes(isa.for_few::<P>(span.len().div_ceil(4)), &sum);
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
    unsafe fn by_component<'a>(
        &'a self,
        combination: &Combination<'_>,
        states: impl Iterator<Item = (usize, &'a StateProperty<P>)>,
        lent: &[*mut P],
        isa: Isa,
    ) {
        let Combination { to, adds, part: _, terms, momenta } = *combination;
        let errors = if to == Register::State && adds { self.carry() } else { None };
        let behind = self.momentum_behind.unwrap_or(0);
        for (_, state) in states {
            for (number, component) in state.components.iter().enumerate() {
                let of_momenta = |from: Register| match self.vector(from) {
                    Some(start) => (start.wrapping_add(component.at + behind), 1),
                    None => self.momentum(component.at + behind, number, lent),
                };
                let own = |from: Register| self.place(from, component, lent);
                // As if they were the integrator's own vectors, one behind the other.
                let mut starts = [core::ptr::null_mut::<P>(); Register::Work(TERMS).number()];
                let (mut others, mut strides) = ([(0.0, Register::State); TERMS], [1; TERMS]);
                let (mut count, mut apart) = (0, 0);
                let mut put = |(start, stride): (*mut P, usize)| {
                    (starts[Register::Work(count).number()], strides[count]) = (start, stride);
                    count += 1;
                };
                momenta.row().for_each(|from| put(of_momenta(from)));
                terms.row().for_each(|from| put(own(from)));
                let singles = momenta.others.iter().map(|(factor, from)| (*factor, of_momenta(*from)));
                for (factor, place) in singles.chain(terms.others.iter().map(|(factor, from)| (*factor, own(*from)))) {
                    let number = momenta.weights.len() + terms.weights.len() + apart;
                    others[apart] = (factor, Register::Work(number));
                    put(place);
                    apart += 1;
                }
                let rows = [
                    Terms { first: 0, others: &others[..apart], ..momenta },
                    Terms { first: momenta.weights.len(), others: &[], ..terms },
                ];
                let (start, stride) = self.place(to, component, lent);
                let even = stride == 1 && strides.iter().all(|stride| *stride == 1);
                let errors = errors.map_or(core::ptr::null_mut(), |errors| errors.wrapping_add(component.at));
                let (base, lost) = (if adds { start } else { core::ptr::null_mut() }, [errors, core::ptr::null_mut()]);
                let (wide, count, starts) = (self.sums_in_f64(), state.len, &starts);
                let terms = [(&rows[0], 0), (&rows[1], 0)];
                let sum = Sum { to: start, base, errors, lost, wide, count, starts, terms };
                if even {
                    P::with_lanes(isa, &sum);
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
        // Of a domain without rows every component is where the next one begins.
        let states = self.states.iter().filter(|state| state.len > 0);
        let found = states.filter_map(|state| state.components.get(number)).find(|other| other.at == at);
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
