//! Runs a pair law of inverse squares with far rows summed together. In: a pass that is tied to a state. Out: sums in their columns,
//! or an energy. Never: the method itself.

use super::bind::PairPass;
use super::neighbours::places;
use super::run::Context;
use super::threads::in_parts;
use crate::backend::{Accuracy, Effort, Far, Parts, distance_slot, far_pays};
use crate::column::Aligned;
use crate::law::Signature;
use crate::real::Scalar;
use std::sync::PoisonError;

/// What a pass keeps for a law with a far field.
pub(crate) struct FarField<P: Scalar> {
    far: Far<P>,
    /// The first slot of the coordinate.
    place: usize,
    source: Aligned<P>,
    response: Aligned<P>,
    /// The field, or the potential, of each row.
    found: [Aligned<P>; 3],
    /// As measured in the first evaluation.
    pub(crate) accuracy: Option<Accuracy>,
}

/// The errors that can be asked for.
const ERRORS: core::ops::RangeInclusive<f64> = 1e-15..=0.5;

/// What is wrong with an error that is asked for, or with the law that is asked.
pub(super) fn fault(error: f64, is_inverse_square: bool, has_cutoff: bool) -> Option<String> {
    if !is_inverse_square {
        let text = "it does not say that its body is one of inverse squares: write `fn inverse_square` beside `pair`, or leave it out";
        return Some(text.to_owned());
    }
    if has_cutoff {
        return Some("it ends at a distance, beyond which there is nothing to sum".to_owned());
    }
    let is_error = ERRORS.contains(&error);
    (!is_error)
        .then(|| format!("its error is {error}: give a relative one from {:e} to {}", ERRORS.start(), ERRORS.end()))
}

impl<P: Scalar> FarField<P> {
    /// The error that is asked for.
    pub(super) fn requested(&self) -> f64 {
        self.far.requested()
    }

    /// For a law that asks for this error, where that pays.
    pub(super) fn new(signature: &Signature, rows: usize, error: f64) -> Option<Self> {
        let place = distance_slot(signature.ports)?;
        let zeros = |stream| Aligned::zeros(rows, stream);
        far_pays(rows, error).then(|| FarField {
            far: Far::new(error),
            place,
            source: zeros(0),
            response: zeros(1),
            found: [zeros(2), zeros(3), zeros(4)],
            accuracy: None,
        })
    }
}

/// Threads for the method's parts.
struct OnThreads<'a, 'b, P: Scalar> {
    context: &'a Context<'b, P>,
    threads: usize,
}

impl<P: Scalar> Parts for OnThreads<'_, '_, P> {
    fn run(&self, count: usize, work: &(dyn Fn(usize) + Sync)) {
        // SAFETY: the work may be shared, as its type says.
        unsafe { in_parts(self.context, self.threads, count, 1, |parts| parts.for_each(work)) };
    }
}

/// The rows' sources, responses and softening, as they are now; the softening's square.
fn form<P: Scalar>(pass: &PairPass<P>, far: &FarField<P>) -> P {
    // SAFETY: a pass has a number for each row of what its law reads, and these arrays have, too.
    let softening = unsafe { pass.kernel.inverse_square(&pass.all(), far.source.pointer(), far.response.pointer()) };
    softening * softening
}

/// What a calibration has found.
pub(crate) type Fit = (Effort, Accuracy);

/// Has the effort fit the error that is asked for, once in an engine's life: for the rows as they are now, or as it was found before.
fn fit<P: Scalar>(far: &mut FarField<P>, pass: &PairPass<P>, square: P, context: &Context<'_, P>) {
    if far.accuracy.is_some() {
        return;
    }
    let entry = &context.laws[pass.law].entry;
    let law = format!("{}@{}", entry.label(), entry.options.domain.as_deref().unwrap_or_default());
    let mut fits = context.machine.fits.lock().unwrap_or_else(PoisonError::into_inner);
    let (effort, accuracy) = match fits.iter().find(|(known, _)| *known == law) {
        Some((_, fit)) => *fit,
        None => {
            let first = far.far.effort();
            let threads = OnThreads { context, threads: pass.threads };
            let places = places(&pass.slots, far.place, pass.rows);
            let found = far.far.calibrate(context.isa, places, far.source.as_slice(), square, &threads);
            if found.measured.is_nan() || found.measured == 0.0 {
                // There is no field yet, or none that is a number: another evaluation tells.
                return far.far.set_effort(first);
            }
            fits.push((law, (far.far.effort(), found)));
            (far.far.effort(), found)
        }
    };
    far.far.set_effort(effort);
    far.accuracy = Some(accuracy);
}

/// Adds to each row what all others do to it.
pub(super) fn run<P: Scalar>(pass: &mut PairPass<P>, context: &Context<'_, P>) {
    let Some(mut far) = pass.far.take() else { return };
    let square = form(pass, &far);
    fit(&mut far, pass, square, context);
    let threads = OnThreads { context, threads: pass.threads };
    let places = places(&pass.slots, far.place, pass.rows);
    let FarField { far: method, source, response, found, .. } = &mut *far;
    let out = found.each_mut().map(Aligned::as_mut_slice);
    method.field(context.isa, places, source.as_slice(), square, out, &threads);
    let first = pass.slots.len() - pass.kernel.added();
    for (field, to) in found.iter().zip(&pass.slots[first..]) {
        // SAFETY: a pass has a number for each row of what its law adds to, which nobody else touches now.
        let to = unsafe { core::slice::from_raw_parts_mut(*to, pass.rows) };
        for ((to, field), response) in to.iter_mut().zip(field.as_slice()).zip(response.as_slice()) {
            let share = *response * *field;
            *to = if pass.first { share } else { *to + share };
        }
    }
    pass.far = Some(far);
}

/// The energy of all pairs.
pub(super) fn energy<P: Scalar>(pass: &mut PairPass<P>, context: &Context<'_, P>) -> Option<f64> {
    let mut far = pass.far.take()?;
    let square = form(pass, &far);
    fit(&mut far, pass, square, context);
    let threads = OnThreads { context, threads: pass.threads };
    let places = places(&pass.slots, far.place, pass.rows);
    let FarField { far: method, source, response, found: [potential, ..], .. } = &mut *far;
    method.potential(context.isa, places, source.as_slice(), square, potential.as_mut_slice(), &threads);
    let each = potential.as_slice().iter().zip(response.as_slice());
    // Each pair is met from both sides.
    let energy = each.map(|(potential, response)| -0.5 * response.to_f64() * potential.to_f64()).sum();
    pass.far = Some(far);
    Some(energy)
}
