//! Integrators against known answers.
//!
//! In: a file of cases, each with its laws, its state at the start, and its states at later times to twenty digits and
//! more. Out: [`Case`]s, engines for them, and how far an engine is from the answer. Never: a choice that knows a case.

mod case;
mod setup;

pub use case::{Body, Case, CaseLaw, Region, Sample, Spring, read};
pub use setup::builder;

use vesper::prelude::*;

/// What came of an attempt at a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attempt {
    /// The largest distance from the answer, over all samples and bodies: positions and velocities each by the case's
    /// scale, the larger kept. Infinite where the run broke.
    pub error: f64,
    /// The largest ratio of an error to what the rounding of the input alone may make of it: ten times the growth of an
    /// input error by half a rounding, at least 1e-12.
    pub by_floor: f64,
    /// Evaluations of the laws.
    pub evaluations: u64,
    /// Steps of an adaptive integrator that were given up, and kept.
    pub tried: [u64; 2],
}

/// Takes a case through all its samples: by steps of this length, in s, or a little shorter ones of which a whole number
/// ends at the sample; without one, by what the integrator chooses.
///
/// # Errors
/// The laws do not fit the case, or the integrator refuses them. An integrator that breaks on the way is no fault: its
/// error is infinite.
pub fn attempt<P: Precision>(
    case: &Case,
    step: Option<f64>,
    configure: impl FnOnce(Builder<P>) -> Builder<P>,
) -> Result<Attempt, Faults> {
    let mut engine = configure(builder(case)).build()?;
    let (mut error, mut by_floor) = (0.0, 0.0);
    for sample in &case.samples {
        let way = sample.time - engine.time();
        let went = match step {
            Some(step) if way > 0.0 => {
                let steps = (way / step - 1e-9).ceil().max(1.0);
                engine.steps_of(steps as u64, way / steps)
            }
            _ => engine.advance(way),
        };
        let here = match went {
            Ok(()) => setup::error(case, sample, &engine),
            Err(_) => f64::INFINITY,
        };
        let floor = sample.growth.map_or(1e-12, |growth| f64::max(1e-12, 10.0 * growth * 0.5 * f64::EPSILON));
        error = f64::max(error, here);
        by_floor = f64::max(by_floor, here / floor);
        if here == f64::INFINITY {
            break;
        }
    }
    Ok(Attempt { error, by_floor, evaluations: engine.evaluations(), tried: engine.tried_steps() })
}
