//! Bodies thrown in a uniform field of gravity, or in none.

use super::{BODIES, Phase, Problem};
use crate::{Motion, UniformGravity};
use vesper::prelude::*;

/// Bodies of mass 1 that start at the origin and do not touch each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Throw {
    /// A word for it.
    pub name: &'static str,
    /// Acceleration of free fall, in m/s^2.
    pub gravity: [f64; 3],
    /// Velocities at time 0, in m/s.
    pub velocities: Vec<[f64; 3]>,
    /// Times at which to compare, in s.
    pub times: Vec<f64>,
}

impl Throw {
    /// C2: no gravity; straight up at 1 m/s for 10 s.
    pub fn uniform_motion() -> Self {
        let velocities = vec![[0.0, 0.0, 1.0]];
        Throw { name: "uniform_motion", gravity: [0.0; 3], velocities, times: vec![10.0] }
    }

    /// C3: up at 10 m/s; highest after 10 / 9.81 s, back after twice that.
    pub fn vertical() -> Self {
        let (velocities, top) = (vec![[0.0, 0.0, 10.0]], 10.0 / 9.81);
        Throw { name: "vertical_throw", gravity: [0.0, 0.0, -9.81], velocities, times: vec![top, 2.0 * top] }
    }

    /// C4: three bodies up at 30 m/s, forward at 5, 10 and 15 m/s.
    pub fn oblique() -> Self {
        let velocities = [5.0, 10.0, 15.0].map(|forward| [forward, 0.0, 30.0]).to_vec();
        let times = vec![1.0, 30.0 / 9.81, 60.0 / 9.81];
        Throw { name: "oblique_throw", gravity: [0.0, 0.0, -9.81], velocities, times }
    }
}

impl Problem for Throw {
    fn name(&self) -> String {
        self.name.to_owned()
    }

    fn setup<P: Precision>(&self, builder: Builder<P>) -> Builder<P> {
        let bodies = Domain::new(BODIES)
            .with(Position, vec![[0.0; 3]; self.velocities.len()])
            .with(Velocity, self.velocities.as_slice())
            .with(Mass, vec![1.0; self.velocities.len()]);
        builder.domain(bodies).constant(GravityAcceleration, [self.gravity]).law(UniformGravity).law(Motion)
    }

    fn exact(&self, time: f64) -> Option<Vec<Phase>> {
        let gravity = DVec3::from_array(self.gravity);
        let thrown = self.velocities.iter().map(|&velocity| {
            let velocity = DVec3::from_array(velocity);
            Phase { position: (velocity + gravity * (0.5 * time)) * time, velocity: velocity + gravity * time }
        });
        Some(thrown.collect())
    }

    fn times(&self) -> Vec<f64> {
        self.times.clone()
    }
}
