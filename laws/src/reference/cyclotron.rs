//! A charge in a uniform magnetic field.

use super::{BODIES, Phase, Problem};
use crate::{MagneticForce, Motion};
use vesper::prelude::*;

/// A charge of mass 1 that starts at the origin, in a uniform field along z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cyclotron {
    /// Charge, in C.
    pub charge: f64,
    /// Magnetic flux density along z, in T.
    pub field: f64,
    /// Velocity along x at time 0, in m/s.
    pub across: f64,
    /// Velocity along the field, in m/s.
    pub along: f64,
}

impl Default for Cyclotron {
    /// Angular frequency and radius 1.
    fn default() -> Self {
        Cyclotron { charge: 1.0, field: 1.0, across: 1.0, along: 0.25 }
    }
}

impl Problem for Cyclotron {
    fn name(&self) -> String {
        "cyclotron".to_owned()
    }

    fn setup<P: Precision>(&self, builder: Builder<P>) -> Builder<P> {
        let bodies = Domain::new(BODIES)
            .with(Position, [[0.0; 3]])
            .with(Velocity, [[self.across, 0.0, self.along]])
            .with(Mass, [1.0])
            .with(Charge, [self.charge]);
        let field = Uniform { value: [0.0, 0.0, self.field] };
        builder.domain(bodies).field(MagneticField, field).law(MagneticForce).law(Motion)
    }

    fn exact(&self, time: f64) -> Option<Vec<Phase>> {
        // Jackson, Classical Electrodynamics, 3rd ed., eq. 12.39 and 12.41: a positive charge turns clockwise.
        let omega = self.charge * self.field;
        let (sine, cosine) = (omega * time).sin_cos();
        let radius = self.across / omega;
        Some(vec![Phase {
            position: DVec3::new(radius * sine, radius * (cosine - 1.0), self.along * time),
            velocity: DVec3::new(self.across * cosine, -self.across * sine, self.along),
        }])
    }

    fn times(&self) -> Vec<f64> {
        let period = core::f64::consts::TAU / (self.charge * self.field).abs();
        vec![0.3 * period, period, 10.0 * period]
    }
}
