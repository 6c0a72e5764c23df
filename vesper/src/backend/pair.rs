//! The loops of a pair law: [`each`] gives every row what all others do to it, [`once`] looks at each pair once.
//!
//! In: a law's body, pointers to columns. Out: sums in columns. Never: threads; which rows a call takes is decided elsewhere.

mod apart;
mod each;
mod near;
mod once;
mod sight;

pub(crate) use apart::coordinate_slots;
pub(crate) use near::{box_slot, distance_slot, images};
pub(crate) use once::{PAYS, Tally, meeting_block, rounds};

#[cfg(feature = "gpu")]
use super::gpu::Trace;
use super::near::Lists;
use super::pointers::{MAX_SLOTS, Rows, SUMS, Slots, first_output, slot_count, slots_at};
use super::tangent::{self, TangentCall};
use super::{Compiled, Kernel};
use crate::law::{PairFamily, PairLaw, Place, Signature};
use crate::real::{Isa, Real, Scalar, WithLanes};
use apart::Apart;
use core::marker::PhantomData;
use core::ops::Range;
use each::Each;
use near::{Listed, Near};
use once::{Give, Meet};
use sight::{Plain, Sight, load};
use std::sync::Arc;

/// One call of a pair kernel.
#[derive(Clone)]
pub(crate) struct PairCall<'a, P> {
    /// A pointer for every component: to the first row, or to the one number of a constant, or null.
    pub(crate) slots: &'a [*mut P],
    /// By slot, what rounding added to each row's coordinate, or null; or none at all.
    pub(crate) rests: &'a [*mut P],
    /// The rows i that this call sums for.
    pub(crate) rows: Range<usize>,
    /// The rows j of its pairs.
    pub(crate) others: Range<usize>,
    /// Whether the sums begin with this law: its shares are stored, whatever is there.
    pub(crate) first: bool,
    /// Whether a law that allows estimates is computed with them.
    pub(crate) estimates: bool,
    /// The square of the distance at which a law with a cut-off ends.
    pub(crate) square: P,
}

/// A pair law with its loops.
pub(crate) trait PairKernel<P: Scalar>: Send + Sync {
    /// Numbers that it adds to.
    fn added(&self) -> usize;
    /// # Safety
    /// Every slot is null where its port is absent, or points to a number for each row (one for a constant) that is valid, with
    /// room behind the last ([`crate::column::whole`]), and so do rests, as many as slots or none; nobody else touches the rows of
    /// the call of what the law adds to, or that room. Only the last call ends between multiples of the lanes.
    unsafe fn run(&self, isa: Isa, call: &PairCall<'_, P>);
    /// Rows of some clusters get what those of their lists do: slots of what the law reads have a number for each entry of the
    /// lists, those of what it adds to one for each row.
    ///
    /// # Safety
    /// As for `run`; nobody else touches the rows of the clusters of what the law adds to.
    unsafe fn run_listed(&self, isa: Isa, call: &PairCall<'_, P>, lists: &Lists<P>, clusters: Range<usize>);
    /// The energy of all pairs within the cut-off, where the law knows it.
    ///
    /// # Safety
    /// As for `run_listed`.
    unsafe fn energy_listed(&self, call: &PairCall<'_, P>, lists: &Lists<P>) -> Option<f64>;
    /// Two blocks of the call's rows meet, or one is alone: each pair is looked at once, and the shares go to the tally.
    ///
    /// # Safety
    /// As for `run`, of all rows, which are a multiple of 64; the tally has numbers for all of them; nobody else touches those of
    /// the blocks. For each number that the law adds to there is scratch for two blocks, which nobody else touches.
    unsafe fn meet(&self, isa: Isa, call: &PairCall<'_, P>, to: (&Tally<P>, &[*mut P]), blocks: [usize; 2]);
    /// The rows of the call get what the tally has for them, and it is emptied.
    ///
    /// # Safety
    /// As for `run`; the call begins and ends at multiples of 64; the tally has numbers for its rows, which nobody else touches.
    unsafe fn give(&self, isa: Isa, call: &PairCall<'_, P>, tally: &Tally<P>);
    /// Whether the law says that it has the form of inverse squares.
    fn is_inverse_square(&self) -> bool;
    /// That form, of all rows of the call: sources and responses; the softening of the first row.
    ///
    /// # Safety
    /// As for `run`; there is a place for a source and a response of each row.
    unsafe fn inverse_square(&self, call: &PairCall<'_, P>, source: *mut P, response: *mut P) -> P;
    /// Whether pairs of the first rows give what that form says.
    ///
    /// # Safety
    /// As for `run`.
    unsafe fn is_as_inverse_square(&self, call: &PairCall<'_, P>) -> bool;
    /// Whether the law gives the same where it is told differences of coordinates only, as it says.
    ///
    /// # Safety
    /// As for `run`.
    unsafe fn is_invariant(&self, call: &PairCall<'_, P>) -> bool;
    /// Whether row j loses what row i gets, as the law says.
    ///
    /// # Safety
    /// As for `run`.
    unsafe fn is_antisymmetric(&self, call: &PairCall<'_, P>) -> bool;
    /// Whether there is a body over dual numbers.
    fn differentiates(&self) -> bool {
        true
    }
    /// Runs the body over dual numbers.
    ///
    /// # Safety
    /// The call keeps its promises.
    unsafe fn tangent(&self, call: &TangentCall<'_, P>);
    /// The energy of all pairs, where the law knows it.
    ///
    /// # Safety
    /// As for `run`.
    unsafe fn energy(&self, call: &PairCall<'_, P>) -> Option<f64>;
    /// The body, recorded, where those components are there whose bits are set; none of a body that is not generic in its numbers.
    #[cfg(feature = "gpu")]
    fn trace(&self, there: u64) -> Option<Trace>;
}

/// Makes the loops of a pair law.
pub fn pair<P: Scalar, F: PairFamily>(law: &F) -> Compiled<P> {
    const {
        assert!(added(&F::SIGNATURE) <= SUMS, "a pair law adds to at most 12 numbers");
        let ends = F::SIGNATURE.cutoff.is_some();
        let one = distance_slot(F::SIGNATURE.ports).is_some();
        assert!(
            !ends || one,
            "a law with a `cutoff` reads one coordinate, a vector that is not optional, which distances are taken of"
        );
        let differences = F::SIGNATURE.translation_invariant;
        assert!(
            !ends || differences,
            "a law with a `cutoff` sees images of rows: it looks at differences of coordinates only, and says `translation_invariant`"
        );
    };
    Compiled {
        signature: F::SIGNATURE,
        energy: F::ENERGY,
        parameters: law.parameters(),
        foreign: None,
        kernel: Kernel::Pair(Arc::new(law.clone())),
    }
}

const fn added(signature: &Signature) -> usize {
    let slots = slot_count(signature.ports);
    assert!(slots <= MAX_SLOTS, "a law touches at most 64 numbers");
    slots - first_output(signature.ports)
}

/// What all loops of a law know of its slots.
struct Pairs<P, F>(PhantomData<(P, F)>);

impl<P: Scalar, F: PairFamily> Pairs<P, F> {
    const FIRST: usize = first_output(F::SIGNATURE.ports);
    const ADDED: usize = added(&F::SIGNATURE);
    const COUNT: usize = slot_count(F::SIGNATURE.ports);
    const CONSTANTS: u64 = slots_at(F::SIGNATURE.ports, Place::Scene);

    /// # Safety
    /// There is a pointer for each slot; those of constants are null, or point to a number.
    #[inline(always)]
    unsafe fn slots(slots: &[*mut P]) -> Slots<P> {
        // SAFETY: passed on to the caller.
        unsafe { Slots::copied(slots, Self::COUNT, Self::CONSTANTS, 0) }
    }
}

/// The rounded sum of two numbers, and what rounding left of it (Knuth, The Art of Computer Programming 2, 4.2.2, theorem B).
#[inline(always)]
fn two_sum<R: Real>(a: R, b: R) -> (R, R) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

/// Whether two shares are the same, but for this part of the largest number.
fn agree(found: &[f64], expected: &[f64], allowed: f64) -> bool {
    let most = found.iter().chain(expected).fold(0.0, |most, number| f64::max(most, number.abs()));
    let same = |(a, b): (&f64, &f64)| {
        a == b || most.is_finite() && (a - b).abs() <= allowed * most || a.is_nan() && b.is_nan()
    };
    found.iter().zip(expected).all(same)
}

/// An expression with the `N` that has room for what law `F` adds to.
macro_rules! sized {
    ($law:ident, $n:ident => $expression:expr) => {
        if const { added(&$law::SIGNATURE) <= 3 } {
            const $n: usize = 3;
            $expression
        } else {
            const $n: usize = SUMS;
            $expression
        }
    };
}

/// Gives each row what all others do to it, with estimates where the call says so.
///
/// # Safety
/// As for [`PairKernel::run`].
unsafe fn run<P: Scalar, F: PairFamily, S: Sight<P, F>>(law: &F, isa: Isa, call: &PairCall<'_, P>, sight: S) {
    if const { F::SIGNATURE.estimates } && call.estimates {
        let mut call = call.clone();
        macro_rules! each {
            ($n:ident) => {{
                // SAFETY: passed on to the caller.
                unsafe { Each::<_, _, _, $n>::new(law, &call, sight) }
            }};
        }
        while let Some(rows) = sized!(F, N => P::with_estimates(isa, each!(N))) {
            // What estimates have no number for, too small or too large a square, the body itself may have.
            let exact = PairCall { rows: rows.clone(), estimates: false, ..call.clone() };
            // SAFETY: as above.
            unsafe { run::<P, F, S>(law, isa, &exact, sight) };
            call.rows.start = rows.end;
        }
        return;
    }
    // SAFETY: as above.
    sized!(F, N => P::with_lanes(isa, unsafe { Each::<_, _, _, N>::new(law, call, sight) }));
}

impl<P: Scalar, F: PairFamily> PairKernel<P> for F {
    fn added(&self) -> usize {
        Pairs::<P, F>::ADDED
    }

    unsafe fn run(&self, isa: Isa, call: &PairCall<'_, P>) {
        if const { F::SIGNATURE.cutoff.is_some() } {
            // SAFETY: the caller promises the same.
            return unsafe { run::<P, F, _>(self, isa, call, Near::new(call)) };
        }
        let apart = const { F::SIGNATURE.translation_invariant && coordinate_slots(F::SIGNATURE.ports) != 0 };
        if apart && !call.rests.is_empty() {
            // SAFETY: as above.
            sized!(F, N => P::with_lanes(isa, unsafe { Each::<_, _, _, N>::new(self, call, Apart::<P, F>::new(call.rests)) }));
            return;
        }
        // SAFETY: as above.
        unsafe { run::<P, F, _>(self, isa, call, Plain) };
    }

    unsafe fn run_listed(&self, isa: Isa, call: &PairCall<'_, P>, lists: &Lists<P>, mut clusters: Range<usize>) {
        if const { F::SIGNATURE.cutoff.is_none() } {
            return;
        }
        macro_rules! listed {
            ($n:ident, $clusters:expr) => {{
                // SAFETY: the caller promises the same.
                unsafe { Listed::<P, F, $n>::new(self, call, lists, $clusters) }
            }};
        }
        if const { F::SIGNATURE.estimates } && call.estimates {
            let mut first = 0;
            while let Some((cluster, row)) =
                sized!(F, N => P::with_estimates(isa, listed!(N, (clusters.clone(), first))))
            {
                // The rest of the cluster without; what was given before stays.
                sized!(F, N => P::with_lanes(isa, listed!(N, (cluster..cluster + 1, row))));
                (clusters.start, first) = (cluster + 1, 0);
            }
            return;
        }
        sized!(F, N => P::with_lanes(isa, listed!(N, (clusters, 0))));
    }

    unsafe fn energy_listed(&self, call: &PairCall<'_, P>, lists: &Lists<P>) -> Option<f64> {
        // SAFETY: the caller promises the same.
        (F::ENERGY && F::SIGNATURE.cutoff.is_some()).then(|| unsafe { near::energy(self, call, lists) })
    }

    unsafe fn meet(&self, isa: Isa, call: &PairCall<'_, P>, to: (&Tally<P>, &[*mut P]), blocks: [usize; 2]) {
        if const { F::SIGNATURE.estimates && F::SIGNATURE.antisymmetric } {
            sized!(F, N => {
                // SAFETY: the caller promises the same.
                if !P::with_estimates(isa, unsafe { Meet::<_, _, N>::new(self, call, to, blocks) }) {
                    // Seldom, so that it need not be fast.
                    // SAFETY: as above.
                    WithLanes::<P>::with::<P>(unsafe { Meet::<_, _, N>::new(self, call, to, blocks) });
                }
            });
        }
    }

    unsafe fn give(&self, isa: Isa, call: &PairCall<'_, P>, tally: &Tally<P>) {
        if const { F::SIGNATURE.estimates && F::SIGNATURE.antisymmetric } {
            P::with_lanes(isa, Give::<P, F> { call, tally, law: PhantomData });
        }
    }

    fn is_inverse_square(&self) -> bool {
        const { F::INVERSE_SQUARE && added(&F::SIGNATURE) == 3 && distance_slot(F::SIGNATURE.ports).is_some() }
    }

    unsafe fn inverse_square(&self, call: &PairCall<'_, P>, source: *mut P, response: *mut P) -> P {
        // SAFETY: the caller promises the slots.
        let slots = unsafe { Pairs::<P, F>::slots(call.slots) };
        let law = self.kernel::<P>();
        let mut softening = P::default();
        for row in call.rows.clone() {
            // SAFETY: the caller promises the rows.
            let form = law.inverse_square(load::<F, P>(unsafe { Rows::<P>::new(&slots, row) }));
            // SAFETY: the caller promises the places.
            unsafe { (*source.add(row), *response.add(row)) = (form.source, form.response) };
            if row == call.rows.start {
                softening = form.softening;
            }
        }
        softening
    }

    unsafe fn is_as_inverse_square(&self, call: &PairCall<'_, P>) -> bool {
        // SAFETY: the caller promises the same.
        unsafe { near::is_as_inverse_square(self, call) }
    }

    unsafe fn is_invariant(&self, call: &PairCall<'_, P>) -> bool {
        if const { !F::SIGNATURE.translation_invariant } || call.rests.is_empty() {
            return true;
        }
        // SAFETY: the caller promises the same.
        unsafe { apart::is_invariant(self, call) }
    }

    unsafe fn is_antisymmetric(&self, call: &PairCall<'_, P>) -> bool {
        if const { !F::SIGNATURE.antisymmetric } {
            return true;
        }
        // SAFETY: the caller promises the same.
        unsafe { once::is_antisymmetric(self, call) }
    }

    unsafe fn tangent(&self, call: &TangentCall<'_, P>) {
        // SAFETY: the caller promises the same.
        unsafe { tangent::pairs(self, call) }
    }

    unsafe fn energy(&self, call: &PairCall<'_, P>) -> Option<f64> {
        if !F::ENERGY {
            return None;
        }
        if const { F::SIGNATURE.cutoff.is_some() } {
            // SAFETY: the caller promises the same.
            return Some(unsafe { near::energy_of_all(self, call) });
        }
        // SAFETY: the caller promises the slots.
        let slots = unsafe { Pairs::<P, F>::slots(call.slots) };
        let law = self.kernel::<P>();
        // SAFETY: the caller promises the rows.
        let row = |row| load::<F, P>(unsafe { Rows::<P>::new(&slots, row) });
        let mut energy = 0.0;
        for i in call.rows.clone() {
            let row_i = row(i);
            for j in i + 1..call.others.end {
                energy += law.energy(row_i, row(j)).to_f64();
            }
        }
        Some(energy)
    }

    #[cfg(feature = "gpu")]
    fn trace(&self, there: u64) -> Option<Trace> {
        Some(super::gpu::pair(self, there))
    }
}
