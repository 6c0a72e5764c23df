use crate::{GravitationalPotential, NewtonianAcceleration};
use vesper::prelude::*;

/// First post-Newtonian correction between any number of point masses, all of them sources.
///
/// Equation: a_i = 1/c^2 sum over j of GM_j / r^3 { d [ v_i^2 + 2 v_j^2 - 4 v_i . v_j - 3/2 (d . v_j)^2 / r^2 - 4 U_i - U_j +
/// 1/2 d . g_j ] - [ d . (4 v_i - 3 v_j) ] (v_i - v_j) } + 7/2 GM_j / r g_j, with d = x_j - x_i, and with U and g from the
/// law `newtonian_field`.
///
/// Source: Einstein, Infeld, Hoffmann, Ann. Math. 39 (1938) 65; in this form: Park, Folkner, Williams, Boggs, The JPL
/// Planetary and Lunar Ephemerides DE440 and DE441, AJ 161 (2021) 105, eq. 27 with beta = gamma = 1.
///
/// Limits: weak fields, speeds far below that of light, terms of first order in 1/c^2 only; positions and velocities are
/// barycentric. Its energy is not told. Add it, and `newtonian_field`, to `gravity_by_parameter`; where one centre
/// dominates, `post_newtonian` is cheaper, and its row for row work grows with n instead of n^2.
#[derive(Law, Clone, Copy, Debug)]
#[law(
    reads(position: Position, velocity: Velocity, parameter: StandardGravitationalParameter),
    reads(potential: GravitationalPotential, newtonian: NewtonianAcceleration),
    scene(speed_of_light: SpeedOfLight = 299_792_458.0),
    adds(acceleration: Acceleration),
    translation_invariant
)]
pub struct EinsteinInfeldHoffmann;

#[kernel]
impl<R: Real> PairLaw<R> for EinsteinInfeldHoffmann {
    fn pair(&self, i: EinsteinInfeldHoffmannRow<R>, j: EinsteinInfeldHoffmannRow<R>) -> R::Vec3 {
        let d = j.position - i.position;
        let inverse = d.length_squared().rsqrt();
        let potential = j.parameter * inverse;
        let along = d.dot(j.velocity) * inverse;
        let bracket = i.velocity.length_squared() + R::lit(2.0) * j.velocity.length_squared()
            - R::lit(4.0) * i.velocity.dot(j.velocity)
            - R::lit(1.5) * along * along
            - R::lit(4.0) * i.potential
            - j.potential
            + R::lit(0.5) * d.dot(j.newtonian);
        let sideways = d.dot(i.velocity * R::lit(4.0) - j.velocity * R::lit(3.0));
        let radial = (d * bracket - (i.velocity - j.velocity) * sideways) * (potential * inverse * inverse);
        // Divided by c twice: its square leaves f32's easy range in units where c is large.
        (radial + j.newtonian * (R::lit(3.5) * potential)) / i.speed_of_light / i.speed_of_light
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GravityByParameter, Kinematics, NewtonianField, PostNewtonian};

    fn acceleration(law: impl Listing, parameters: [f64; 2], velocities: [[f64; 3]; 2]) -> DVec3 {
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3], [2.0, 0.0, 0.0]])
            .with(Velocity, velocities)
            .with(StandardGravitationalParameter, parameters);
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .constant(SpeedOfLight, [100.0])
            .law(NewtonianField)
            .law(law)
            .observe("bodies", Acceleration)
            .step(1.0)
            .build()
            .unwrap();
        engine.advance(1.0).unwrap();
        engine.state().get("bodies", Acceleration, 1).unwrap()
    }

    #[test]
    fn about_a_centre_at_rest_it_is_the_schwarzschild_term() {
        let velocities = [[0.0; 3], [0.3, 1.1, -0.2]];
        let all = acceleration(EinsteinInfeldHoffmann, [4.0, 0.0], velocities);
        let centre = acceleration(PostNewtonian, [4.0, 0.0], velocities);
        assert!((all - centre).length() < 1e-15 * all.length() + 1e-18, "{all} against {centre}");
    }

    #[test]
    fn two_equal_masses_turn_their_orbit_as_robertson_says() {
        // Advance of the pericentre of two bodies per revolution: 6 pi G (m1 + m2) / (c^2 a (1 - e^2)), Robertson 1938.
        let (eccentricity, light, steps) = (0.3_f64, 2000.0, 40_000);
        let speed = ((1.0 + eccentricity) / (1.0 - eccentricity)).sqrt();
        let bodies = Domain::new("bodies")
            .with(Position, [[-0.5 * (1.0 - eccentricity), 0.0, 0.0], [0.5 * (1.0 - eccentricity), 0.0, 0.0]])
            .with(Velocity, [[0.0, -0.5 * speed, 0.0], [0.0, 0.5 * speed, 0.0]])
            .with(StandardGravitationalParameter, [0.5, 0.5]);
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .constant(SpeedOfLight, [light])
            .law(GravityByParameter::default())
            .law(NewtonianField)
            .law(EinsteinInfeldHoffmann)
            .law(Kinematics)
            .integrator(RungeKutta4)
            .build()
            .unwrap();
        engine.steps_of(steps, core::f64::consts::TAU / steps as f64).unwrap();
        let state = engine.state();
        let r = state.get("bodies", Position, 1).unwrap() - state.get("bodies", Position, 0).unwrap();
        let v = state.get("bodies", Velocity, 1).unwrap() - state.get("bodies", Velocity, 0).unwrap();
        let pericentre = v.cross(r.cross(v)) - r / r.length();
        let robertson = 6.0 * core::f64::consts::PI / (light * light * (1.0 - eccentricity * eccentricity));
        let measured = pericentre.y.atan2(pericentre.x);
        assert!((measured / robertson - 1.0).abs() < 1e-3, "{measured} against {robertson}");
    }
}
