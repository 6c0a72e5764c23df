//! A block of links: numbers of their ends brought side by side, the body in lanes, shares added link by link.
//!
//! Three loops one behind the other, not a gather and a scatter around each body: each of them keeps the processor at its
//! limit, and nothing is taken apart lane by lane in registers.

use super::{Links, Shares, Strided, Task};
use crate::backend::pointers::{MAX_SLOTS, slots_at};
use crate::backend::within::Within;
use crate::law::{Declared, LinkFamily, LinkLaw, Place, Source};
use crate::real::{Lanes, MAX_WIDTH, Scalar, WithLanes};
use core::mem::MaybeUninit;

/// Numbers on the desk.
const ROOM: usize = 4096;
/// The most links of a block: enough that its three loops come up to speed, and few enough that the first cache still has
/// the rows of their ends when the shares are added (measured with a million springs: 64 cost 8 % more, 16 cost 5 to 14 %).
const MOST: usize = 32;

/// What the body reads of `R::WIDTH` links from `at` of the block on, at the links themselves and at one end of each.
struct Gathered<'a, P> {
    slots: &'a [Strided<P>],
    /// The numbers of the links themselves, by slot.
    own: &'a [*const P; MAX_SLOTS],
    /// The numbers of the end: those of a slot `each` behind those of the one before.
    end: *const P,
    each: usize,
    at_ends: u64,
    at: usize,
}

impl<P: Scalar, R: Lanes<P>> Source<R> for Gathered<'_, P> {
    #[inline(always)]
    fn wants(&self, _port: usize) -> bool {
        true
    }
    #[inline(always)]
    fn has(&self, slot: usize) -> bool {
        !self.slots[slot].start.is_null()
    }
    #[inline(always)]
    fn component(&self, slot: usize) -> R {
        // SAFETY: `Task::block` has brought the numbers of `R::WIDTH` links from `at` on there, for every slot that is there.
        unsafe {
            let start = if self.at_ends >> slot & 1 == 1 { self.end.add(slot * self.each) } else { self.own[slot] };
            R::load(start.add(self.at))
        }
    }
    #[inline(always)]
    fn constant(&self, slot: usize) -> R {
        // SAFETY: a constant that is there has one number.
        R::splat(unsafe { *self.slots[slot].start })
    }
}

/// Some neighbouring links, or links of these numbers.
#[derive(Clone, Copy)]
enum Which<'a> {
    From(usize),
    Listed(&'a [u32]),
}

impl<P: Scalar, F: LinkFamily<N>, const N: usize> Task<'_, P, F, N> {
    const OWN: u64 = slots_at(F::SIGNATURE.ports, Place::Own);
    /// Links of a block: a multiple of every width of lanes, 0 where the numbers of a link do not fit on the desk.
    const BLOCK: usize = {
        let fit = ROOM / (N * Self::SLOTS) / MAX_WIDTH * MAX_WIDTH;
        if fit < MOST { fit } else { MOST }
    };

    /// Where the numbers of a slot at an end are on the desk; of a link itself, as at its first end.
    #[inline(always)]
    const fn place(end: usize, slot: usize) -> usize {
        (end * Self::SLOTS + slot) * Self::BLOCK
    }

    /// Runs links whose ends these are: a multiple of the width of the lanes, at most a block.
    ///
    /// `reach` are the slots of the call, but for those at ends that are absent, which are at one spare number; with `UNIT` all
    /// at ends have neighbouring numbers in neighbouring rows.
    #[inline(always)]
    fn block<R: Lanes<P>, const UNIT: bool>(
        &self,
        law: &F::Kernel<R>,
        reach: &[Strided<P>; MAX_SLOTS],
        desk: *mut P,
        which: Which<'_>,
        ends: &[[u32; N]],
    ) {
        let own = self.bring_own(desk, which, ends.len());
        for end in 0..N {
            for (at, rows) in ends.iter().enumerate() {
                let row = rows[end] as usize;
                for (slot, &Strided { start, stride }) in reach[..Self::INPUTS].iter().enumerate() {
                    if Self::AT_ENDS >> slot & 1 == 1 {
                        let number = if UNIT { row } else { row * stride };
                        // SAFETY: ends are rows of the target domain, all of which the slot reaches; the desk has room.
                        unsafe { *desk.add(Self::place(end, slot) + at) = *start.add(number) };
                    }
                }
            }
        }
        let mut at = 0;
        while at < ends.len() {
            let source = |end: usize| {
                // SAFETY: the desk has room for all ends.
                let end = unsafe { desk.add(Self::place(end, 0)) };
                let (slots, each) = (self.call.slots, Self::BLOCK);
                Within::<_, F>::new(Gathered { slots, own: &own, end, each, at_ends: Self::AT_ENDS, at })
            };
            let row = <F::Kernel<R> as Declared<R>>::load(&source(0));
            // Not `array::from_fn`, which is not always inlined.
            let mut loaded = [<F::Kernel<R> as Declared<R>>::load_end(&source(0)); N];
            for (end, loaded) in loaded.iter_mut().enumerate().skip(1) {
                *loaded = <F::Kernel<R> as Declared<R>>::load_end(&source(end));
            }
            let mut shares = Shares::<R, N>::new(Self::INPUTS);
            for (end, output) in law.link(row, loaded).into_iter().enumerate() {
                shares.end = end;
                <F::Kernel<R> as Declared<R>>::store_end(output, &mut shares);
            }
            for end in 0..N {
                for output in 0..Self::OUTPUTS {
                    // SAFETY: the desk has room for all ends and slots.
                    unsafe { shares.values[end][output].store(desk.add(Self::place(end, Self::INPUTS + output) + at)) };
                }
            }
            at += R::WIDTH;
        }
        for (at, rows) in ends.iter().enumerate() {
            for (end, &row) in rows.iter().enumerate() {
                if !self.owns(row) {
                    continue;
                }
                let row = row as usize;
                for (output, &Strided { start, stride }) in reach[Self::INPUTS..Self::SLOTS].iter().enumerate() {
                    let number = if UNIT { row } else { row * stride };
                    // SAFETY: as above; the row is this call's own.
                    unsafe { *start.add(number) += *desk.add(Self::place(end, Self::INPUTS + output) + at) };
                }
            }
        }
    }

    /// Where the numbers of links themselves are, one behind the other: in their columns, or brought to the desk.
    #[inline(always)]
    fn bring_own(&self, desk: *mut P, which: Which<'_>, count: usize) -> [*const P; MAX_SLOTS] {
        let mut own = [core::ptr::null(); MAX_SLOTS];
        for (slot, own) in own[..Self::INPUTS].iter_mut().enumerate() {
            let Strided { start, stride } = self.call.slots[slot];
            if Self::OWN >> slot & 1 == 0 || start.is_null() {
                continue;
            }
            // SAFETY: the slot reaches all links; the desk has room for a block.
            unsafe {
                let to = desk.add(Self::place(0, slot));
                *own = to;
                match which {
                    Which::From(link) if stride == 1 => *own = start.add(link),
                    Which::From(link) => (0..count).for_each(|at| *to.add(at) = *start.add((link + at) * stride)),
                    Which::Listed(list) => {
                        (0..count).for_each(|at| *to.add(at) = *start.add(list[at] as usize * stride));
                    }
                }
            }
        }
        own
    }

    /// Runs whole lanes of links, and gives the place of the first link that is left.
    #[inline(always)]
    fn blocks<R: Lanes<P>, const UNIT: bool>(&self, reach: &[Strided<P>; MAX_SLOTS]) -> usize {
        let law = self.law.kernel::<R>();
        let mut desk = [const { MaybeUninit::<P>::uninit() }; ROOM];
        let desk = desk.as_mut_ptr().cast();
        let mut gathered = [[0; N]; MOST];
        let (all, _) = self.call.ends.as_chunks::<N>();
        let whole = self.call.links.len() / R::WIDTH * R::WIDTH;
        let mut place = 0;
        while place < whole {
            let count = (whole - place).min(Self::BLOCK);
            let (first, last) = (self.call.links.at(place), self.call.links.at(place + count - 1));
            match self.call.links {
                Links::Listed(list) if last - first >= count => {
                    let list = &list[place..place + count];
                    for (to, &link) in gathered.iter_mut().zip(list) {
                        *to = all[link as usize];
                    }
                    self.block::<R, UNIT>(&law, reach, desk, Which::Listed(list), &gathered[..count]);
                }
                _ => self.block::<R, UNIT>(&law, reach, desk, Which::From(first), &all[first..=last]),
            }
            place += count;
        }
        whole
    }
}

impl<P: Scalar, F: LinkFamily<N>, const N: usize> WithLanes<P> for Task<'_, P, F, N> {
    type Output = ();
    #[inline(always)]
    fn with<R: Lanes<P>>(self) {
        let mut done = 0;
        if R::WIDTH > 1 && Self::BLOCK > 0 {
            let mut spare = P::default();
            let mut reach = [Strided { start: &raw mut spare, stride: 0 }; MAX_SLOTS];
            let mut unit = true;
            for (slot, to) in reach[..Self::SLOTS].iter_mut().enumerate() {
                let from = self.call.slots[slot];
                if Self::AT_ENDS >> slot & 1 == 1 || slot >= Self::INPUTS {
                    if !from.start.is_null() {
                        *to = from;
                    }
                    unit &= to.stride == 1;
                }
            }
            done = if unit { self.blocks::<R, true>(&reach) } else { self.blocks::<R, false>(&reach) };
        }
        self.one_by_one(done);
    }
}
