use vesper::prelude::*;

/// Viscous damper between two rows, along its axis.
///
/// Equation: F_a = c [(v_b - v_a) . n] n, n = d / |d|, d = x_b - x_a, F_b = -F_a; it stores no energy.
///
/// Source: Witkin, Baraff, Physically Based Modeling (SIGGRAPH course notes, 2001), Particle System Dynamics, eq. 1, the
/// term of the velocities; what it does to a mass on a spring: Landau, Lifshitz, Mechanics, 3rd ed., par. 25.
///
/// Limits: nothing brakes motion across the axis, so rows on dampers alone still turn. The axis of coincident ends is not
/// defined: they feel no force there. A force that depends on velocities: leapfrog takes a second evaluation per step.
/// The step must resolve m / c: explicit methods are unstable for steps beyond 2 m / c (Runge-Kutta 4: 2.78), with m the
/// reduced mass of the ends.
#[derive(Law, Clone, Copy, Debug)]
#[law(
    reads(damping: Damping),
    link(ends: Ends, reads(position: Position, velocity: Velocity), adds(force: Force))
)]
pub struct Damper;

#[kernel]
impl<R: Real> LinkLaw<R> for Damper {
    fn link(&self, damper: DamperRow<R>, [a, b]: [DamperEnd<R>; 2]) -> [R::Vec3; 2] {
        let zero = R::lit(0.0);
        let d = b.position - a.position;
        let length = d.length();
        let axis = d * R::select(length.equal(zero), zero, R::lit(1.0) / length);
        let force = axis * (damper.damping * (b.velocity - a.velocity).dot(axis));
        [force, -force]
    }

    fn energy(&self, _damper: DamperRow<R>, _ends: [DamperEnd<R>; 2]) -> R {
        R::lit(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Motion;

    fn end(position: DVec3, velocity: DVec3) -> DamperEnd<f64> {
        DamperEnd { position, velocity }
    }

    #[test]
    fn it_brakes_along_its_axis_only() {
        let a = end(DVec3::ZERO, DVec3::ZERO);
        let b = end(DVec3::new(0.0, 5.0, 0.0), DVec3::new(7.0, -2.0, 1.0));
        let [on_a, on_b] = Damper.link(DamperRow { damping: 10.0 }, [a, b]);
        assert!((on_a + DVec3::Y * 20.0).length() < 1e-12, "{on_a}");
        assert_eq!(on_b, -on_a);
    }

    #[test]
    fn coincident_ends_feel_nothing() {
        let ends = [end(DVec3::ONE, DVec3::X), end(DVec3::ONE, DVec3::Y)];
        assert_eq!(Damper.link(DamperRow { damping: 10.0 }, ends), [DVec3::ZERO; 2]);
    }

    #[test]
    fn the_relative_velocity_decays_and_the_common_one_stays() {
        // Masses 1 and 3: a reduced mass of 3/4, which a damping of 3/4 brakes at a rate of 1 per s.
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3], [5.0, 0.0, 0.0]])
            .with(Velocity, [[4.0, 0.0, 0.0], [0.0; 3]])
            .with(Mass, [1.0, 3.0]);
        let dampers = Domain::new("dampers").link(Ends, "bodies", [[0, 1]]).with(Damping, [0.75]);
        let builder = Engine::<f64>::builder().domain(bodies).domain(dampers).law(Damper).law(Motion);
        let mut engine = builder.integrator(RungeKutta4).step(5e-3).build().unwrap();
        engine.advance(2.0).unwrap();
        let along = |property: PropertyInfo| {
            let numbers = engine.state().numbers("bodies", property).unwrap();
            [numbers[0], numbers[3]]
        };
        // The velocity of the centre is 1, the distance 5 - 4 (1 - e^-t).
        let (fade, speeds, places) = ((-2.0_f64).exp(), along(Velocity::INFO), along(Position::INFO));
        assert!((speeds[0] - (1.0 + 3.0 * fade)).abs() < 1e-11 && (speeds[1] - (1.0 - fade)).abs() < 1e-11, "{speeds:?}");
        assert!((places[1] - places[0] - (5.0 - 4.0 * (1.0 - fade))).abs() < 1e-11, "{places:?}");
        assert!(engine.energy().unwrap().1.is_empty(), "every law tells its energy");
    }
}
