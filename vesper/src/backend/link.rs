//! The loop of a link law: look at the rows of each link, compute, add to them in the order of the links.
//!
//! A call adds to some of the rows only: threads have rows of their own, and each looks at all links that end there. A link
//! between rows of two threads is computed twice; in return nobody waits, and every row sums in the order of the links: the
//! same bits.

mod block;

#[cfg(feature = "gpu")]
use super::gpu::Trace;
use super::pointers::{MAX_SLOTS, first_output, slot_count, slots_at};
use super::tangent::{self, TangentCall};
use super::within::Within;
use super::{Compiled, Kernel};
use crate::law::{Declared, LinkFamily, LinkLaw, Place, Sink, Source};
use crate::real::{Isa, Real, Scalar};
use core::ops::Range;

/// Numbers of a component that are `stride` apart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strided<P> {
    pub(crate) start: *mut P,
    pub(crate) stride: usize,
}

/// One call of a link kernel.
pub(crate) struct LinkCall<'a, P> {
    /// Where every component is: of the link's own rows, of the rows linked to, or one constant.
    pub(crate) slots: &'a [Strided<P>],
    /// The rows linked to, `N` for each link.
    pub(crate) ends: &'a [u32],
    /// The links of this call, in ascending order.
    pub(crate) links: Links<'a>,
    /// The rows that are added to; shares of others are left out.
    pub(crate) rows: Range<u32>,
}

/// Some links.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Links<'a> {
    /// The first so many.
    First(usize),
    /// Those of these numbers.
    Listed(&'a [u32]),
}

impl Links<'_> {
    fn len(self) -> usize {
        match self {
            Links::First(count) => count,
            Links::Listed(list) => list.len(),
        }
    }

    /// The number of the link at a place among them.
    #[inline(always)]
    fn at(self, place: usize) -> usize {
        match self {
            Links::First(_) => place,
            Links::Listed(list) => list[place] as usize,
        }
    }
}

/// A link law with its loop.
pub(crate) trait LinkKernel<P>: Send + Sync {
    /// Rows of one link.
    fn arity(&self) -> usize;
    /// Whether calls may be of some links, and of some rows, so that threads share the work.
    fn splits(&self) -> bool {
        true
    }
    /// # Safety
    /// Every slot is null where its port is absent, or reaches all rows; ends are rows of the target domain; nobody
    /// else touches the numbers that are added to, in `rows`.
    unsafe fn run(&self, isa: Isa, call: &LinkCall<'_, P>);
    /// Whether there is a body over dual numbers.
    fn differentiates(&self) -> bool {
        true
    }
    /// Runs the body over dual numbers.
    ///
    /// # Safety
    /// The call keeps its promises.
    unsafe fn tangent(&self, call: &TangentCall<'_, P>);
    /// The energy of all links, where the law knows it.
    ///
    /// # Safety
    /// As for `run`.
    unsafe fn energy(&self, call: &LinkCall<'_, P>) -> Option<f64>;
    /// The body, recorded, where those components are there whose bits are set; none of a body that is not generic in its numbers.
    #[cfg(feature = "gpu")]
    fn trace(&self, there: u64) -> Option<Trace>;
}

/// Makes the loop of a link law.
pub fn link<P: Scalar, F: LinkFamily<N>, const N: usize>(law: &F) -> Compiled<P> {
    const {
        assert!(slot_count(F::SIGNATURE.ports) <= MAX_SLOTS, "a law touches at most 64 numbers");
        super::says_nothing_of_pairs(&F::SIGNATURE);
        let arity = match F::SIGNATURE.link {
            Some(link) => link.kind.width(),
            None => N,
        };
        assert!(arity == N, "the number in `LinkLaw<R, N>` is not the number of rows that the declared link joins");
    };
    Compiled {
        signature: F::SIGNATURE,
        energy: F::ENERGY,
        parameters: law.parameters(),
        foreign: None,
        kernel: Kernel::Link(Box::new(OfArity::<F, N>(law.clone()))),
    }
}

/// Ties a law to its arity, which its type alone does not.
struct OfArity<F, const N: usize>(F);

/// Fewer links than these are not worth a desk.
const FEW: usize = 8;

impl<P: Scalar, F: LinkFamily<N>, const N: usize> LinkKernel<P> for OfArity<F, N> {
    fn arity(&self) -> usize {
        N
    }
    unsafe fn run(&self, isa: Isa, call: &LinkCall<'_, P>) {
        // SAFETY: the caller promises the same.
        let task = unsafe { Task::<P, F, N>::new(&self.0, call) };
        if call.links.len() < FEW {
            task.one_by_one(0);
        } else {
            P::with_lanes(isa, task);
        }
    }
    unsafe fn tangent(&self, call: &TangentCall<'_, P>) {
        // SAFETY: the caller promises the same.
        unsafe { tangent::links(&self.0, call) }
    }

    unsafe fn energy(&self, call: &LinkCall<'_, P>) -> Option<f64> {
        if !F::ENERGY {
            return None;
        }
        let law = self.0.kernel::<P>();
        // SAFETY: the caller promises the same.
        let task = unsafe { Task::<P, F, N>::new(&self.0, call) };
        let energy = (0..call.links.len()).map(|place| {
            let (row, ends) = task.load(call.links.at(place));
            law.energy(row, ends).to_f64()
        });
        Some(energy.sum())
    }

    #[cfg(feature = "gpu")]
    fn trace(&self, there: u64) -> Option<Trace> {
        Some(super::gpu::link(&self.0, there))
    }
}

struct Task<'a, P, F, const N: usize> {
    law: &'a F,
    call: &'a LinkCall<'a, P>,
}

/// The values of a link, at the link itself and at end `end`.
struct Linked<'a, P, const N: usize> {
    call: &'a LinkCall<'a, P>,
    at_ends: u64,
    link: usize,
    end: usize,
}

impl<P: Scalar, const N: usize> Source<P> for Linked<'_, P, N> {
    #[inline(always)]
    fn wants(&self, _port: usize) -> bool {
        true
    }
    #[inline(always)]
    fn has(&self, slot: usize) -> bool {
        !self.call.slots[slot].start.is_null()
    }
    #[inline(always)]
    fn component(&self, slot: usize) -> P {
        let Strided { start, stride } = self.call.slots[slot];
        let at_end = self.at_ends >> slot & 1 == 1;
        let row = if at_end { self.call.ends[self.link * N + self.end] as usize } else { self.link };
        // SAFETY: `Task::new` was promised that the slot reaches all rows.
        unsafe { *start.add(row * stride) }
    }
    #[inline(always)]
    fn constant(&self, slot: usize) -> P {
        // SAFETY: as above; a constant has one number.
        unsafe { *self.call.slots[slot].start }
    }
}

/// The shares of the ends of some links, by component.
struct Shares<R, const N: usize> {
    values: [[R; MAX_OUTPUTS]; N],
    end: usize,
    first: usize,
}

/// Numbers that a link law may add to each end.
const MAX_OUTPUTS: usize = 12;

impl<R: Real, const N: usize> Shares<R, N> {
    #[inline(always)]
    fn new(first: usize) -> Self {
        Shares { values: [[R::lit(0.0); MAX_OUTPUTS]; N], end: 0, first }
    }
}

impl<R: Real, const N: usize> Sink<R> for Shares<R, N> {
    #[inline(always)]
    fn set(&mut self, slot: usize, value: R) {
        self.values[self.end][slot - self.first] = value;
    }
    #[inline(always)]
    fn add(&mut self, slot: usize, value: R) {
        self.set(slot, value);
    }
    #[inline(always)]
    fn rate(&mut self, _coordinate: bool, slot: usize, value: R) {
        self.set(slot, value);
    }
}

type RowOf<F, R, const N: usize> = <<F as LinkFamily<N>>::Kernel<R> as Declared<R>>::Row;
type EndOf<F, R, const N: usize> = <<F as LinkFamily<N>>::Kernel<R> as Declared<R>>::End;

impl<P: Scalar, F: LinkFamily<N>, const N: usize> Task<'_, P, F, N> {
    /// Numbers that the law touches: those that it reads, and behind them those that it gives.
    const SLOTS: usize = slot_count(F::SIGNATURE.ports);
    const INPUTS: usize = first_output(F::SIGNATURE.ports);
    const OUTPUTS: usize = Self::SLOTS - Self::INPUTS;
    const AT_ENDS: u64 = slots_at(F::SIGNATURE.ports, Place::End);

    /// # Safety
    /// As for [`LinkKernel::run`], as long as it lives. Links that its functions are given are links of the call.
    unsafe fn new<'a>(law: &'a F, call: &'a LinkCall<'a, P>) -> Task<'a, P, F, N> {
        const { assert!(Self::OUTPUTS <= MAX_OUTPUTS, "too many outputs") };
        Task { law, call }
    }

    /// Whether shares of the row are added.
    #[inline(always)]
    fn owns(&self, row: u32) -> bool {
        let Range { start, end } = self.call.rows;
        row.wrapping_sub(start) < end.wrapping_sub(start)
    }

    #[inline(always)]
    fn load(&self, link: usize) -> (RowOf<F, P, N>, [EndOf<F, P, N>; N]) {
        let at = |end| Within::<_, F>::new(Linked::<P, N> { call: self.call, at_ends: Self::AT_ENDS, link, end });
        let row = <F::Kernel<P> as Declared<P>>::load(&at(0));
        let ends = core::array::from_fn(|end| <F::Kernel<P> as Declared<P>>::load_end(&at(end)));
        (row, ends)
    }

    /// Runs the links of the call from this place on: the reference that blocks are compared with.
    #[inline(always)]
    fn one_by_one(&self, from: usize) {
        let law = self.law.kernel::<P>();
        for link in (from..self.call.links.len()).map(|place| self.call.links.at(place)) {
            let (row, ends) = self.load(link);
            let mut shares = Shares::<P, N>::new(Self::INPUTS);
            for (end, output) in law.link(row, ends).into_iter().enumerate() {
                shares.end = end;
                <F::Kernel<P> as Declared<P>>::store_end(output, &mut shares);
            }
            for (end, shares) in shares.values.iter().enumerate() {
                let row = self.call.ends[link * N + end];
                if !self.owns(row) {
                    continue;
                }
                for (Strided { start, stride }, share) in self.call.slots[Self::INPUTS..Self::SLOTS].iter().zip(shares)
                {
                    if !start.is_null() {
                        // SAFETY: `Task::new` was promised the place, and that it is this call's alone.
                        unsafe { *start.add(row as usize * stride) += *share };
                    }
                }
            }
        }
    }
}
