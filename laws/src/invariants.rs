//! What an undisturbed system keeps: momentum, angular momentum, and the motion of its centre of mass.
//!
//! In: a state. Out: sums over the rows of one domain, in f64. Never: an energy, which [`Engine::energy`] asks the laws
//! for.

use vesper::prelude::*;

/// What the momentum of a row is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// The property `momentum`, a state of its own.
    Momentum,
    /// Mass times velocity.
    Mass,
    /// Standard gravitational parameter times velocity: all sums are in units of G.
    StandardGravitationalParameter,
}

/// Sums over the rows of a domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Invariants {
    /// What the momenta are made of.
    pub weight: Weight,
    /// Sum of the masses, in kg (or of GM, in m^3/s^2); of rest masses where momentum is a state.
    pub mass: f64,
    /// Centre of mass, in m; NaN where the sum of the masses is 0.
    pub centre: DVec3,
    /// Sum of the momenta, in kg m/s (or of GM times velocity).
    pub momentum: DVec3,
    /// Sum of position times momentum about the origin, in kg m^2/s (or by GM).
    pub angular_momentum: DVec3,
    /// Sum of the magnitudes of the momenta: what a drift of `momentum` is measured by, since that may be 0.
    pub momentum_scale: f64,
    /// Sum of the magnitudes of the angular momenta of the rows.
    pub angular_momentum_scale: f64,
}

/// The invariants of a domain whose rows have a position and a momentum; `None` of any other domain.
///
/// The momentum of a row is its property `momentum`; or else mass times velocity; or else, without masses, its standard
/// gravitational parameter times velocity. Rows without one of these, because a column is a subset, do not count, and
/// immovable rows (mass 0) weigh nothing.
pub fn invariants<P: Precision>(state: &State<P>, domain: &str) -> Option<Invariants> {
    let place = Numbers::of(state, domain, Position)?;
    let numbers = |property: PropertyInfo| Numbers::of(state, domain, property);
    let velocity = numbers(Velocity::INFO);
    let by = |weight: Option<Numbers>| weight.zip(velocity.clone());
    let (weight, mass, moving) = if let Some(momentum) = numbers(Momentum::INFO) {
        (Weight::Momentum, numbers(RestMass::INFO), momentum)
    } else if let Some((mass, velocity)) = by(numbers(Mass::INFO)) {
        (Weight::Mass, Some(mass), velocity)
    } else {
        let (parameter, velocity) = by(numbers(StandardGravitationalParameter::INFO))?;
        (Weight::StandardGravitationalParameter, Some(parameter), velocity)
    };
    let mut sums = Invariants {
        weight,
        mass: 0.0,
        centre: DVec3::ZERO,
        momentum: DVec3::ZERO,
        angular_momentum: DVec3::ZERO,
        momentum_scale: 0.0,
        angular_momentum_scale: 0.0,
    };
    for row in 0..state.domain(domain).ok()?.rows() {
        let (Some(at), Some(moving)) = (place.vector(row), moving.vector(row)) else { continue };
        let mass = mass.as_ref().map_or(Some(0.0), |mass| mass.scalar(row));
        let Some(mass) = mass else { continue };
        let momentum = if weight == Weight::Momentum { moving } else { moving * mass };
        let turning = at.cross(momentum);
        sums.mass += mass;
        sums.centre += at * mass;
        sums.momentum += momentum;
        sums.angular_momentum += turning;
        sums.momentum_scale += momentum.length();
        sums.angular_momentum_scale += turning.length();
    }
    sums.centre /= sums.mass;
    Some(sums)
}

/// The sum of the momenta of a domain, as in [`invariants`].
pub fn momentum<P: Precision>(state: &State<P>, domain: &str) -> Option<DVec3> {
    invariants(state, domain).map(|sums| sums.momentum)
}

/// The sum of the angular momenta of a domain about the origin, as in [`invariants`].
pub fn angular_momentum<P: Precision>(state: &State<P>, domain: &str) -> Option<DVec3> {
    invariants(state, domain).map(|sums| sums.angular_momentum)
}

/// The centre of mass of a domain, as in [`invariants`].
pub fn centre_of_mass<P: Precision>(state: &State<P>, domain: &str) -> Option<DVec3> {
    invariants(state, domain).map(|sums| sums.centre)
}

/// A column's numbers in f64, and the rows they belong to.
#[derive(Clone)]
struct Numbers {
    numbers: Vec<f64>,
    subset: Option<Vec<u32>>,
}

impl Numbers {
    fn of<P: Precision>(state: &State<P>, domain: &str, property: impl AsProperty) -> Option<Self> {
        let column = state.column(domain, property.info().name).ok()?;
        if column.property().kind != property.info().kind {
            return None;
        }
        let numbers = state.numbers(domain, property).ok()?;
        Some(Numbers { numbers, subset: column.subset().map(<[u32]>::to_vec) })
    }

    fn index(&self, row: usize) -> Option<usize> {
        match &self.subset {
            None => Some(row),
            Some(rows) => u32::try_from(row).ok().and_then(|row| rows.binary_search(&row).ok()),
        }
    }

    fn scalar(&self, row: usize) -> Option<f64> {
        self.index(row).and_then(|index| self.numbers.get(index).copied())
    }

    fn vector(&self, row: usize) -> Option<DVec3> {
        let index = self.index(row)?;
        self.numbers.get(3 * index..3 * index + 3).map(DVec3::from_slice)
    }
}
