use vesper::prelude::*;

/// Universal gravitation by standard gravitational parameters, GM, which are known to more digits than G and M are.
///
/// Equation: a_i = sum over j of GM_j d / (|d|^2 + s^2)^(3/2), d = x_j - x_i; energy of a pair
/// -GM_i GM_j / (|d|^2 + s^2)^(1/2), which is the potential energy times G.
///
/// Source: Park, Folkner, Williams, Boggs, The JPL Planetary and Lunar Ephemerides DE440 and DE441, AJ 161 (2021) 105,
/// eq. 27, its Newtonian terms; the softened potential: Binney, Tremaine, Galactic Dynamics, 2nd ed., eq. 2.44a.
///
/// Limits: every pair is visited, n^2 work; a row of parameter 0 is attracted, but attracts nothing. Singular where two
/// rows meet without softening. Point masses: no tides, no oblateness. The energy is in units of G, as in `kinematics`.
/// In f32 distances stay below 1e19 m, and for the energy GM_i GM_j below 3e38 m^6/s^4: two suns are beyond.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position, parameter: StandardGravitationalParameter), adds(acceleration: Acceleration), translation_invariant)]
pub struct GravityByParameter<R = f64> {
    /// Softening length.
    #[law(unit = "m", default = 0.0)]
    pub softening: R,
}

#[kernel]
impl<R: Real> PairLaw<R> for GravityByParameter<R> {
    fn pair(&self, i: GravityByParameterRow<R>, j: GravityByParameterRow<R>) -> R::Vec3 {
        let d = j.position - i.position;
        let r2 = d.length_squared() + self.softening * self.softening;
        // One division less than by the cube of the distance, and that cube leaves f32 beyond 7e12 m: Pluto from Neptune.
        let inverse = r2.rsqrt();
        d * (j.parameter * inverse * inverse * inverse)
    }

    fn energy(&self, i: GravityByParameterRow<R>, j: GravityByParameterRow<R>) -> R {
        let r2 = (j.position - i.position).length_squared() + self.softening * self.softening;
        -i.parameter * j.parameter * r2.rsqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Kinematics;

    #[test]
    fn an_orbit_closes_and_keeps_its_energy() {
        // A row of parameter 0 on a circle of radius 2 about GM = 8: angular velocity 1.
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3], [2.0, 0.0, 0.0]])
            .with(Velocity, [[0.0; 3], [0.0, 2.0, 0.0]])
            .with(StandardGravitationalParameter, [8.0, 0.0]);
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .law(GravityByParameter::default())
            .law(Kinematics)
            .integrator(RungeKutta4)
            .step(1e-3)
            .build()
            .unwrap();
        engine.advance(4.0).unwrap();
        assert_eq!(engine.state().get("bodies", Position, 0).unwrap(), DVec3::ZERO);
        let place = engine.state().get("bodies", Position, 1).unwrap();
        assert!((place - DVec3::new(4.0_f64.cos(), 4.0_f64.sin(), 0.0) * 2.0).length() < 1e-11, "{place}");
    }

    #[test]
    fn energy_is_that_by_mass_times_g() {
        let row = |x: f64, parameter| GravityByParameterRow { position: DVec3::new(x, 0.0, 0.0), parameter };
        let law = GravityByParameter { softening: 3.0 };
        assert!((law.energy(row(0.0, 5.0), row(4.0, 7.0)) + 7.0).abs() < 1e-15);
        let pull: DVec3 = law.pair(row(0.0, 5.0), row(4.0, 7.0));
        assert!((pull - DVec3::X * (4.0 * 7.0 / 125.0)).length() < 1e-15);
    }

    #[test]
    fn the_outer_planets_fit_into_f32() {
        let row = |x: f32, parameter: f32| GravityByParameterRow::<f32> { position: Vec3::new(x, 0.0, 0.0), parameter };
        let law = GravityByParameter::<f32> { softening: 0.0 };
        // Neptune's parameter at 1e13 m; the cube of the distance is beyond f32.
        let pull: Vec3 = law.pair(row(0.0, 0.0), row(1e13, 6.8365e15));
        assert!((pull.x / 6.8365e-11 - 1.0).abs() < 1e-6, "{pull}");
    }
}
