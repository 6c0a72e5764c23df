use vesper::prelude::*;

/// First post-Newtonian correction to gravitation in the field of one dominant centre.
///
/// Equation: a_i = GM / (c^2 r^3) [ (4 GM / r - v^2) r + 4 (r . v) v ], with r and v relative to the centre, which is the
/// row of the largest GM; the centre gets the reaction, so that the sum of GM_i a_i is 0.
///
/// Source: IERS Conventions (2010), Technical Note 36, eq. 10.12, its Schwarzschild terms with beta = gamma = 1.
///
/// Limits: one centre, far heavier than all else, and speeds far below that of light. Left out are the other bodies'
/// own terms (of order GM_j / GM), the rotation of the centre, and everything of second order. Its energy is not told:
/// with it the Newtonian energy oscillates by v^2 / c^2 of itself. Add it to `gravity_by_parameter`. In f32 it fades out
/// where GM / (c^2 r^3) falls below 1e-38 1/m^2: 5e13 m from the Sun.
#[derive(Law, Clone, Copy, Debug)]
#[law(
    reads(position: Position, velocity: Velocity, parameter: StandardGravitationalParameter),
    scene(speed_of_light: SpeedOfLight = 299_792_458.0),
    adds(acceleration: Acceleration)
)]
pub struct PostNewtonian;

#[kernel]
impl<P: Precision> ColumnLaw<P> for PostNewtonian {
    fn columns(&self, mut bodies: PostNewtonianColumns<'_, P>) {
        let rows = bodies.parameter.len();
        // The first of the largest.
        let heavier = |best: usize, row: usize| {
            if bodies.parameter.get(row) > bodies.parameter.get(best) { row } else { best }
        };
        let Some(centre) = (0..rows).reduce(heavier) else { return };
        let parameter = bodies.parameter.get(centre);
        if parameter <= P::lit(0.0) {
            return;
        }
        let c2 = bodies.speed_of_light * bodies.speed_of_light;
        let mut reaction = P::Vec3::zero();
        for row in (0..rows).filter(|&row| row != centre) {
            let r = bodies.position.get(row) - bodies.position.get(centre);
            let v = bodies.velocity.get(row) - bodies.velocity.get(centre);
            let inverse = r.length_squared().rsqrt();
            let potential = parameter * inverse;
            let bracket = r * (P::lit(4.0) * potential - v.length_squared()) + v * (P::lit(4.0) * r.dot(v));
            let share = bracket * (potential * inverse * inverse / c2);
            bodies.acceleration.add(row, share);
            reaction -= share * (bodies.parameter.get(row) / parameter);
        }
        bodies.acceleration.add(centre, reaction);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GravityByParameter, Kinematics};

    /// Advance of the pericentre over one revolution, in rad, of an orbit of semi-major axis 1 about a parameter of 1.
    fn advance(eccentricity: f64, light: f64) -> f64 {
        let speed = ((1.0 + eccentricity) / (1.0 - eccentricity)).sqrt();
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3], [1.0 - eccentricity, 0.0, 0.0]])
            .with(Velocity, [[0.0; 3], [0.0, speed, 0.0]])
            .with(StandardGravitationalParameter, [1.0, 0.0]);
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .constant(SpeedOfLight, [light])
            .law(GravityByParameter::default())
            .law(PostNewtonian)
            .law(Kinematics)
            .integrator(RungeKutta4)
            .build()
            .unwrap();
        // By the eccentricity vector, which swings to and fro within a revolution too: it is looked at after one Newtonian
        // period, when the orbit is at its pericentre again but for terms of the next order.
        engine.steps_of(30_000, core::f64::consts::TAU / 30_000.0).unwrap();
        let r = engine.state().get("bodies", Position, 1).unwrap();
        let v = engine.state().get("bodies", Velocity, 1).unwrap();
        let pericentre = v.cross(r.cross(v)) - r / r.length();
        pericentre.y.atan2(pericentre.x)
    }

    #[test]
    fn the_perihelion_advances_as_einstein_says() {
        // 6 pi GM / (c^2 a (1 - e^2)) per revolution (Einstein 1915).
        let (eccentricity, light) = (0.3, 3000.0);
        let einstein = 6.0 * core::f64::consts::PI / (light * light * (1.0 - eccentricity * eccentricity));
        let measured = advance(eccentricity, light);
        assert!((measured / einstein - 1.0).abs() < 1e-4, "{measured} against {einstein}");
    }

    #[test]
    fn the_centre_gets_the_reaction() {
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3], [1.0, 0.5, 0.0], [-3.0, 1.0, 2.0]])
            .with(Velocity, [[0.1, 0.0, 0.0], [0.3, 0.8, 0.0], [0.0, 0.2, 0.4]])
            .with(StandardGravitationalParameter, [4.0, 1.5, 0.5]);
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .constant(SpeedOfLight, [10.0])
            .law(PostNewtonian)
            .law(Kinematics)
            .observe("bodies", Acceleration)
            .step(1e-3)
            .build()
            .unwrap();
        engine.advance(1e-3).unwrap();
        let a = engine.state().values("bodies", Acceleration).unwrap();
        assert!(a[1].length() > 1e-3, "{a:?}");
        assert!((a[0] * 4.0 + a[1] * 1.5 + a[2] * 0.5).length() < 1e-16, "{a:?}");
    }
}
