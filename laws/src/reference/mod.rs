//! Problems with known answers: initial state, laws, and where everything is at a later time. Written once, for tests,
//! benches and examples.
//!
//! In: nothing but the laws of this crate. Out: [`Problem`]s, and a [`crowd`] for each law. Never: an integrator or a step, which are the caller's.

pub mod crowd;
mod cyclotron;
mod drag;
mod kepler;
mod oscillator;
mod pairs;
mod spectrograph;
mod throw;

pub use cyclotron::Cyclotron;
pub use drag::{LinearDrag, QuadraticFall};
pub use kepler::Kepler;
pub use oscillator::{Oscillator, damped_oscillation};
pub use pairs::{Pair, pairs};
pub use spectrograph::{Landing, Spectrograph};
pub use throw::Throw;

use vesper::prelude::*;

/// The domain whose rows [`Problem::exact`] speaks of.
pub const BODIES: &str = "bodies";

/// Where one row is, and how it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase {
    /// Position, in m.
    pub position: DVec3,
    /// Velocity, in m/s.
    pub velocity: DVec3,
}

/// A problem with a known answer.
pub trait Problem {
    /// A word for it, in tables.
    fn name(&self) -> String;

    /// Adds the problem's domains, constants, fields and laws to a builder.
    fn setup<P: Precision>(&self, builder: Builder<P>) -> Builder<P>;

    /// Every row of the domain [`BODIES`] at a time, in s; `None` where the answer is not known.
    fn exact(&self, time: f64) -> Option<Vec<Phase>>;

    /// Times at which to compare, in s, ascending.
    fn times(&self) -> Vec<f64>;

    /// An engine for the problem.
    ///
    /// # Errors
    /// The step is no length of time, or the integrator refuses the laws.
    fn engine<P: Precision>(&self, integrator: impl Integrator + 'static, step: f64) -> Result<Engine<P>, Faults> {
        self.setup(Engine::builder()).integrator(integrator).step(step).build()
    }

    /// What errors of positions and of velocities are measured by, in m and m/s: the largest magnitude at time 0 and at
    /// [`Problem::times`].
    fn scale(&self) -> [f64; 2] {
        let mut scale = [0.0_f64; 2];
        for phase in self.times().into_iter().chain([0.0]).filter_map(|time| self.exact(time)).flatten() {
            scale = [scale[0].max(phase.position.length()), scale[1].max(phase.velocity.length())];
        }
        scale
    }

    /// How far an engine is from the answer at its time: the largest |x - x_exact| over the rows, by [`Problem::scale`],
    /// positions and velocities apart, the larger kept. `None` where the answer is not known.
    fn error<P: Precision>(&self, engine: &Engine<P>) -> Option<f64> {
        let exact = self.exact(engine.time())?;
        let [of_positions, of_velocities] = self.scale();
        let positions = engine.state().numbers(BODIES, Position).ok()?;
        let velocities = engine.state().numbers(BODIES, Velocity).ok()?;
        let position = farthest(&positions, exact.iter().map(|row| row.position)) / of_positions;
        let velocity = farthest(&velocities, exact.iter().map(|row| row.velocity)) / of_velocities;
        Some(if position >= velocity { position } else { velocity })
    }
}

/// The largest distance between a row and its answer; NaN if there is one.
fn farthest(numbers: &[f64], exact: impl Iterator<Item = DVec3>) -> f64 {
    // Not `max`, which would lose a NaN.
    numbers.chunks_exact(3).zip(exact).fold(0.0, |worst, (given, exact)| {
        let off = (DVec3::from_slice(given) - exact).length();
        if off <= worst { worst } else { off }
    })
}
