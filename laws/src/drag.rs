use vesper::prelude::*;

/// Drag proportional to the velocity relative to the medium.
///
/// Equation: F = -b (v - w); it stores no energy.
///
/// Source: Stokes (1851), b = 6 pi eta R for a sphere: Landau, Lifshitz, Fluid Mechanics, 2nd ed., eq. 20.14; Taylor,
/// Classical Mechanics, eq. 2.2.
///
/// Limits: Reynolds numbers far below 1: dust, droplets, slow bodies in oil. Without wind the medium is at rest. The step
/// must resolve m / b: explicit methods are unstable for steps beyond 2 m / b (Runge-Kutta 4: 2.78).
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(velocity: Velocity, coefficient: DragCoefficient), reads(wind: WindVelocity, optional), adds(force: Force))]
pub struct Drag;

#[kernel]
impl<R: Real> RowLaw<R> for Drag {
    fn row(&self, body: DragRow<R>) -> R::Vec3 {
        let relative = match body.wind {
            Some(wind) => body.velocity - wind,
            None => body.velocity,
        };
        relative * -body.coefficient
    }

    fn energy(&self, _body: DragRow<R>) -> R {
        R::lit(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Motion;

    #[test]
    fn the_velocity_decays_towards_that_of_the_wind() {
        for wind in [None, Some(DVec3::new(0.0, 3.0, 0.0))] {
            let mut bodies = Domain::new("bodies")
                .with(Position, [[0.0; 3]])
                .with(Velocity, [[2.0, 0.0, 0.0]])
                .with(Mass, [0.5])
                .with(DragCoefficient, [0.25]);
            if let Some(wind) = wind {
                bodies = bodies.with(WindVelocity, [wind]);
            }
            let engine = Engine::<f64>::builder().domain(bodies).law(Drag).law(Motion);
            let mut engine = engine.integrator(RungeKutta4).step(5e-3).build().unwrap();
            engine.advance(4.0).unwrap();
            // v = w + (v0 - w) exp(-b t / m), and its integral; b / m = 1/2.
            let (wind, start) = (wind.unwrap_or_default(), DVec3::new(2.0, 0.0, 0.0));
            let velocity = wind + (start - wind) * (-2.0_f64).exp();
            let place = wind * 4.0 + (start - wind) * 2.0 * (1.0 - (-2.0_f64).exp());
            assert!((engine.state().get("bodies", Velocity, 0).unwrap() - velocity).length() < 1e-11);
            assert!((engine.state().get("bodies", Position, 0).unwrap() - place).length() < 1e-11);
        }
    }
}
