use vesper::prelude::*;

/// Drag proportional to the square of the velocity relative to the medium.
///
/// Equation: F = -c |v - w| (v - w); it stores no energy.
///
/// Source: c = C rho S / 2 with the drag coefficient C of the shape: Landau, Lifshitz, Fluid Mechanics, 2nd ed., eq. 45.1;
/// Taylor, Classical Mechanics, eq. 2.2.
///
/// Limits: Reynolds numbers between about 1e3 and the drag crisis (3e5 for a sphere), speeds far below that of sound.
/// Without wind the medium is at rest.
#[derive(Law, Clone, Copy, Debug)]
#[law(
    reads(velocity: Velocity, coefficient: QuadraticDragCoefficient),
    reads(wind: WindVelocity, optional),
    adds(force: Force)
)]
pub struct QuadraticDrag;

#[kernel]
impl<R: Real> RowLaw<R> for QuadraticDrag {
    fn row(&self, body: QuadraticDragRow<R>) -> R::Vec3 {
        let relative = match body.wind {
            Some(wind) => body.velocity - wind,
            None => body.velocity,
        };
        relative * (-body.coefficient * relative.length())
    }

    fn energy(&self, _body: QuadraticDragRow<R>) -> R {
        R::lit(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Motion, UniformGravity};

    #[test]
    fn the_velocity_falls_as_one_over_time_towards_that_of_the_wind() {
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3]])
            .with(Velocity, [[5.0, 0.0, 0.0]])
            .with(Mass, [2.0])
            .with(QuadraticDragCoefficient, [0.5])
            .with(WindVelocity, [[1.0, 0.0, 0.0]]);
        let engine = Engine::<f64>::builder().domain(bodies).law(QuadraticDrag).law(Motion);
        let mut engine = engine.integrator(RungeKutta4).step(1e-2).build().unwrap();
        engine.advance(3.0).unwrap();
        // u = u0 / (1 + c u0 t / m) for u = v - w, and its integral (m / c) ln(1 + c u0 t / m); here c u0 t / m = 3.
        let velocity = engine.state().get("bodies", Velocity, 0).unwrap().x;
        let place = engine.state().get("bodies", Position, 0).unwrap().x;
        assert!((velocity - 2.0).abs() < 1e-9, "{velocity}");
        assert!((place - (3.0 + 4.0 * 4.0_f64.ln())).abs() < 1e-9, "{place}");
    }

    #[test]
    fn a_fall_reaches_its_terminal_speed() {
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3]])
            .with(Velocity, [[0.0; 3]])
            .with(Mass, [2.0])
            .with(QuadraticDragCoefficient, [0.5]);
        let engine = Engine::<f64>::builder()
            .domain(bodies)
            .constant(GravityAcceleration, [[0.0, 0.0, -9.0]])
            .law(QuadraticDrag)
            .law(UniformGravity)
            .law(Motion);
        let mut engine = engine.integrator(RungeKutta4).step(1e-3).build().unwrap();
        engine.advance(0.5).unwrap();
        // v = -V tanh(g t / V), V = sqrt(m g / c) = 6.
        let speed = engine.state().get("bodies", Velocity, 0).unwrap().z;
        assert!((speed + 6.0 * 0.75_f64.tanh()).abs() < 1e-11, "{speed}");
    }
}
