//! The loop of a link law: gather the rows of each link, compute in lanes, add to them in the order of the links.
//!
//! With threads the shares are stored first, and every row gathers its own in that same order: the same bits.

use super::pointers::{MAX_SLOTS, first_output, slot_count, slots_at};
use super::tangent::{self, TangentCall};
use super::within::Within;
use super::{Compiled, Kernel};
use crate::law::{Declared, LinkFamily, LinkLaw, Place, Signature, Sink, Source};
use crate::real::{Isa, Lanes, Real, Scalar, WithLanes};

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
    /// The links of this call.
    pub(crate) from: usize,
    pub(crate) to: usize,
    /// Where the shares go: `outputs()` numbers for each end of each link; null adds them to the rows at once.
    pub(crate) shares: *mut P,
}

/// A link law with its loop.
pub(crate) trait LinkKernel<P>: Send + Sync {
    /// Rows of one link.
    fn arity(&self) -> usize;
    /// Numbers that each end gets.
    fn outputs(&self) -> usize;
    /// # Safety
    /// Every slot is null where its port is absent, or reaches all rows; ends are rows of the target domain; nobody
    /// else touches what is added to, or the shares of links `from..to`.
    unsafe fn run(&self, isa: Isa, call: &LinkCall<'_, P>);
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
        kernel: Kernel::Link(Box::new(OfArity::<F, N>(law.clone()))),
    }
}

/// Ties a law to its arity, which its type alone does not.
struct OfArity<F, const N: usize>(F);

/// Numbers that the law gives to each end.
const fn outputs(signature: &Signature) -> usize {
    slot_count(signature.ports) - first_output(signature.ports)
}

impl<P: Scalar, F: LinkFamily<N>, const N: usize> LinkKernel<P> for OfArity<F, N> {
    fn arity(&self) -> usize {
        N
    }
    fn outputs(&self) -> usize {
        outputs(&F::SIGNATURE)
    }
    unsafe fn run(&self, isa: Isa, call: &LinkCall<'_, P>) {
        // SAFETY: the caller promises the same.
        P::with_lanes(isa, unsafe { Task::<P, F, N>::new(&self.0, call) });
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
        let energy = (call.from..call.to).map(|link| {
            let (row, ends) = task.load::<P>(link);
            law.energy(row, ends).to_f64()
        });
        Some(energy.sum())
    }
}

struct Task<'a, P, F, const N: usize> {
    law: &'a F,
    call: &'a LinkCall<'a, P>,
}

/// The values of `R::WIDTH` links from `link` on, at the links themselves and at end `end` of each.
struct Gathered<'a, P, const N: usize> {
    call: &'a LinkCall<'a, P>,
    ends: u64,
    link: usize,
    end: usize,
}

impl<P: Scalar, R: Lanes<P>, const N: usize> Source<R> for Gathered<'_, P, N> {
    #[inline(always)]
    fn wants(&self, _port: usize) -> bool {
        true
    }
    #[inline(always)]
    fn has(&self, slot: usize) -> bool {
        !self.call.slots[slot].start.is_null()
    }
    #[inline(always)]
    fn component(&self, slot: usize) -> R {
        let Strided { start, stride } = self.call.slots[slot];
        R::from_lanes(|lane| {
            let link = self.link + lane;
            let row = if self.ends >> slot & 1 == 1 { self.call.ends[link * N + self.end] as usize } else { link };
            // SAFETY: `Task::new` was promised that the slot reaches all rows.
            unsafe { *start.add(row * stride) }
        })
    }
    #[inline(always)]
    fn constant(&self, slot: usize) -> R {
        // SAFETY: as above; a constant has one number.
        R::splat(unsafe { *self.call.slots[slot].start })
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
    const FIRST: usize = first_output(F::SIGNATURE.ports);
    const OUTPUTS: usize = outputs(&F::SIGNATURE);

    /// # Safety
    /// As for [`LinkKernel::run`], as long as it lives. Links that its functions are given are links of the call.
    unsafe fn new<'a>(law: &'a F, call: &'a LinkCall<'a, P>) -> Task<'a, P, F, N> {
        Task { law, call }
    }

    #[inline(always)]
    fn load<R: Lanes<P>>(&self, link: usize) -> (RowOf<F, R, N>, [EndOf<F, R, N>; N]) {
        let at = |end| {
            Within::<_, F>::new(Gathered::<P, N> {
                call: self.call,
                ends: const { slots_at(F::SIGNATURE.ports, Place::End) },
                link,
                end,
            })
        };
        let row = <F::Kernel<R> as Declared<R>>::load(&at(0));
        let ends = core::array::from_fn(|end| <F::Kernel<R> as Declared<R>>::load_end(&at(end)));
        (row, ends)
    }

    #[inline(always)]
    fn step<R: Lanes<P>>(&self, law: &F::Kernel<R>, link: usize) {
        let (row, ends) = self.load::<R>(link);
        let mut shares = Shares::<R, N> { values: [[R::lit(0.0); MAX_OUTPUTS]; N], end: 0, first: Self::FIRST };
        for (end, output) in law.link(row, ends).into_iter().enumerate() {
            shares.end = end;
            <F::Kernel<R> as Declared<R>>::store_end(output, &mut shares);
        }
        for lane in 0..R::WIDTH {
            for end in 0..N {
                for output in 0..Self::OUTPUTS {
                    self.give(link + lane, end, output, shares.values[end][output].lane(lane));
                }
            }
        }
    }

    #[inline(always)]
    fn give(&self, link: usize, end: usize, output: usize, share: P) {
        // SAFETY: `Task::new` was promised both places.
        unsafe {
            if self.call.shares.is_null() {
                let Strided { start, stride } = self.call.slots[Self::FIRST + output];
                *start.add(self.call.ends[link * N + end] as usize * stride) += share;
            } else {
                *self.call.shares.add((link * N + end) * Self::OUTPUTS + output) = share;
            }
        }
    }
}

impl<P: Scalar, F: LinkFamily<N>, const N: usize> WithLanes<P> for Task<'_, P, F, N> {
    type Output = ();
    #[inline(always)]
    fn with<R: Lanes<P>>(self) {
        const { assert!(outputs(&F::SIGNATURE) <= MAX_OUTPUTS, "too many outputs") };
        let mut link = self.call.from;
        if R::WIDTH > 1 && link + R::WIDTH <= self.call.to {
            let law = self.law.kernel::<R>();
            while link + R::WIDTH <= self.call.to {
                self.step::<R>(&law, link);
                link += R::WIDTH;
            }
        }
        let law = self.law.kernel::<P>();
        while link < self.call.to {
            self.step::<P>(&law, link);
            link += 1;
        }
    }
}
