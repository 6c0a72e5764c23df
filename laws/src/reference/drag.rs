//! Bodies that a medium slows down.

use super::{BODIES, Phase, Problem};
use crate::{Drag, Motion, QuadraticDrag, UniformGravity};
use vesper::prelude::*;

/// A throw with linear drag in a steady wind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearDrag {
    /// Mass, in kg.
    pub mass: f64,
    /// Force per velocity, in kg/s.
    pub coefficient: f64,
    /// Velocity of the medium, in m/s.
    pub wind: [f64; 3],
    /// Acceleration of free fall, in m/s^2.
    pub gravity: [f64; 3],
    /// Velocity at time 0, in m/s; the body starts at the origin.
    pub velocity: [f64; 3],
}

impl Default for LinearDrag {
    /// Relaxation time 2 s, a cross wind, thrown up and forward.
    fn default() -> Self {
        LinearDrag {
            mass: 0.5,
            coefficient: 0.25,
            wind: [0.0, 3.0, 0.0],
            gravity: [0.0, 0.0, -9.81],
            velocity: [20.0, 0.0, 15.0],
        }
    }
}

impl Problem for LinearDrag {
    fn name(&self) -> String {
        "linear_drag".to_owned()
    }

    fn setup<P: Precision>(&self, builder: Builder<P>) -> Builder<P> {
        let bodies = Domain::new(BODIES)
            .with(Position, [[0.0; 3]])
            .with(Velocity, [self.velocity])
            .with(Mass, [self.mass])
            .with(DragCoefficient, [self.coefficient])
            .with(WindVelocity, [self.wind]);
        builder.domain(bodies).constant(GravityAcceleration, [self.gravity]).law(Drag).law(UniformGravity).law(Motion)
    }

    fn exact(&self, time: f64) -> Option<Vec<Phase>> {
        // v = u + (v0 - u) e^(-t / tau), with the final velocity u = w + g tau; and its integral.
        let tau = self.mass / self.coefficient;
        let terminal = DVec3::from_array(self.wind) + DVec3::from_array(self.gravity) * tau;
        let lost = DVec3::from_array(self.velocity) - terminal;
        let velocity = terminal + lost * (-time / tau).exp();
        Some(vec![Phase { position: terminal * time - lost * (tau * (-time / tau).exp_m1()), velocity }])
    }

    fn times(&self) -> Vec<f64> {
        vec![0.5, 2.0, 8.0]
    }
}

/// A fall from rest with quadratic drag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraticFall {
    /// Mass, in kg.
    pub mass: f64,
    /// Force per square of velocity, in kg/m.
    pub coefficient: f64,
    /// Acceleration of free fall, downward along z, in m/s^2.
    pub gravity: f64,
}

impl Default for QuadraticFall {
    /// A skydiver: final speed 56 m/s.
    fn default() -> Self {
        QuadraticFall { mass: 80.0, coefficient: 0.25, gravity: 9.81 }
    }
}

impl Problem for QuadraticFall {
    fn name(&self) -> String {
        "quadratic_fall".to_owned()
    }

    fn setup<P: Precision>(&self, builder: Builder<P>) -> Builder<P> {
        let bodies = Domain::new(BODIES)
            .with(Position, [[0.0; 3]])
            .with(Velocity, [[0.0; 3]])
            .with(Mass, [self.mass])
            .with(QuadraticDragCoefficient, [self.coefficient]);
        let builder = builder.domain(bodies).constant(GravityAcceleration, [[0.0, 0.0, -self.gravity]]);
        builder.law(QuadraticDrag).law(UniformGravity).law(Motion)
    }

    fn exact(&self, time: f64) -> Option<Vec<Phase>> {
        // v = V tanh(g t / V), V = sqrt(m g / c): Taylor, Classical Mechanics, eq. 2.57; its integral (V^2 / g) ln cosh.
        let terminal = (self.mass * self.gravity / self.coefficient).sqrt();
        let phase = self.gravity * time / terminal;
        // ln cosh x without overflow.
        let fallen = terminal * terminal / self.gravity * (phase + ((-2.0 * phase).exp() / 2.0 + 0.5).ln());
        Some(vec![Phase { position: DVec3::NEG_Z * fallen, velocity: DVec3::NEG_Z * (terminal * phase.tanh()) }])
    }

    fn times(&self) -> Vec<f64> {
        vec![2.0, 10.0, 60.0]
    }
}
