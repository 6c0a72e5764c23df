//! How well a run keeps what an undisturbed system keeps.
//!
//! In: an engine, at moments of its run. Out: energy, momentum and angular momentum at the first and the last moment, and
//! the largest change between. Never: a judgement; where a field or a drag acts, they change as they should.

use vesper::prelude::*;
use vesper_laws::invariants::{Invariants, Weight, invariants};

/// Energy over a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnergyDrift {
    /// At the first moment, in J (times G where rows have a standard gravitational parameter).
    pub first: f64,
    /// At the last moment.
    pub last: f64,
    /// Largest change from the first moment, by the first value; NaN where that is 0 and there is a change.
    pub max_relative_drift: f64,
    /// Laws that run and do not know their energy: the sum is without their part.
    pub silent: Vec<String>,
}

/// A vector over a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VectorDrift {
    /// At the first moment.
    pub first: [f64; 3],
    /// At the last moment.
    pub last: [f64; 3],
    /// Largest change from the first moment, by the largest sum of the magnitudes of the rows' shares.
    pub max_relative_drift: f64,
    change: f64,
    /// That largest sum.
    pub scale: f64,
}

impl VectorDrift {
    fn add(&mut self, value: DVec3, scale: f64, first: bool) {
        if first {
            self.first = value.to_array();
        }
        self.last = value.to_array();
        self.change = largest(self.change, (value - DVec3::from_array(self.first)).length());
        self.scale = largest(self.scale, scale);
        self.max_relative_drift = ratio(self.change, self.scale);
    }
}

/// All of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drift {
    /// Energy.
    pub energy: EnergyDrift,
    /// Momentum and angular momentum about the origin; `None` where no rows have a mass and a velocity.
    pub momenta: Option<(VectorDrift, VectorDrift)>,
    /// Whether masses are standard gravitational parameters: then all is in units of G.
    pub by_parameter: bool,
    moments: u64,
}

impl Drift {
    /// Looks at an engine.
    ///
    /// # Errors
    /// As [`Engine::energy`].
    pub fn look<P: Precision>(&mut self, engine: &mut Engine<P>) -> Result<(), Faults> {
        let (value, silent) = engine.energy()?;
        let first = self.moments == 0;
        self.moments += 1;
        let energy = &mut self.energy;
        if first {
            energy.first = value;
        }
        (energy.last, energy.silent) = (value, silent);
        let change = ratio((value - energy.first).abs(), energy.first.abs());
        energy.max_relative_drift = largest(energy.max_relative_drift, change);

        let state = engine.state();
        let all: Vec<Invariants> =
            state.domains().iter().filter_map(|domain| invariants(state, domain.name())).collect();
        // Masses in kg and parameters in m^3/s^2 have no common sum; where both stand, those of the masses are told.
        let by_parameter = all.iter().all(|sums| sums.weight == Weight::StandardGravitationalParameter);
        let alike = |sums: &&Invariants| by_parameter || sums.weight != Weight::StandardGravitationalParameter;
        if all.is_empty() {
            return Ok(());
        }
        self.by_parameter = by_parameter;
        let (momentum, angular) = self.momenta.get_or_insert_default();
        let sum = |of: fn(&Invariants) -> (DVec3, f64)| {
            all.iter().filter(alike).map(of).fold((DVec3::ZERO, 0.0), |a, b| (a.0 + b.0, a.1 + b.1))
        };
        let (value, scale) = sum(|sums| (sums.momentum, sums.momentum_scale));
        momentum.add(value, scale, first);
        let (value, scale) = sum(|sums| (sums.angular_momentum, sums.angular_momentum_scale));
        angular.add(value, scale, first);
        Ok(())
    }
}

/// The larger one; NaN if one is, so that a run that broke does not look as if it had kept all.
fn largest(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

fn ratio(change: f64, scale: f64) -> f64 {
    if change == 0.0 {
        0.0
    } else if scale == 0.0 {
        f64::NAN
    } else {
        change / scale
    }
}
