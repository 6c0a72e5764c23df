use vesper::prelude::*;

/// Hooke's spring between two rows.
///
/// Equation: F_a = k (|d| - L) n, n = d / |d|, d = x_b - x_a, F_b = -F_a; energy k (|d| - L)^2 / 2.
///
/// Source: Hooke, De Potentia Restitutiva (1678).
///
/// Limits: no mass, no bending, no breaking, linear at any strain. No damping: that is the law `damper`. The axis of
/// coincident ends is not defined: they feel no force there, which with a rest length above 0 is a point of unstable rest.
/// The step must resolve sqrt(k / m).
#[derive(Law, Clone, Copy, Debug)]
#[law(
    reads(stiffness: Stiffness, rest_length: RestLength),
    link(ends: Ends, reads(position: Position), adds(force: Force))
)]
pub struct Spring;

#[kernel]
impl<R: Real> LinkLaw<R> for Spring {
    fn link(&self, spring: SpringRow<R>, [a, b]: [SpringEnd<R>; 2]) -> [R::Vec3; 2] {
        let zero = R::lit(0.0);
        let d = b.position - a.position;
        let length = d.length();
        let axis = d * R::select(length.equal(zero), zero, R::lit(1.0) / length);
        let force = axis * (spring.stiffness * (length - spring.rest_length));
        [force, -force]
    }

    fn energy(&self, spring: SpringRow<R>, [a, b]: [SpringEnd<R>; 2]) -> R {
        let strain = (b.position - a.position).length() - spring.rest_length;
        R::lit(0.5) * spring.stiffness * strain * strain
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Motion;

    #[test]
    fn a_stretched_spring_pulls() {
        let spring = SpringRow { stiffness: 100.0, rest_length: 3.0 };
        let [a, b] = [DVec3::ZERO, DVec3::new(0.0, 5.0, 0.0)].map(|position| SpringEnd { position });
        let [on_a, on_b]: [DVec3; 2] = Spring.link(spring, [a, b]);
        assert!((on_a - DVec3::Y * 200.0).length() < 1e-12, "{on_a}");
        assert_eq!(on_b, -on_a);
        assert_eq!(Spring.energy(spring, [a, b]), 200.0);
    }

    #[test]
    fn coincident_ends_feel_nothing() {
        let spring = SpringRow { stiffness: 100.0, rest_length: 3.0 };
        let ends = [SpringEnd { position: DVec3::ONE }; 2];
        assert_eq!(Spring.link(spring, ends), [DVec3::ZERO; 2]);
        assert_eq!(Spring.energy(spring, ends), 450.0);
    }

    #[test]
    fn it_oscillates_for_ever() {
        // One end fixed, k / m = 4, pulled out by 1: x = 3 + cos 2t.
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3], [4.0, 0.0, 0.0]])
            .with(Velocity, [[0.0; 3]; 2])
            .with(Mass, [0.0, 0.5]);
        let springs =
            Domain::new("springs").link(Ends, "bodies", [[0, 1]]).with(Stiffness, [2.0]).with(RestLength, [3.0]);
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .domain(springs)
            .law(Spring)
            .law(Motion)
            .integrator(RungeKutta4)
            .step(1e-3)
            .build()
            .unwrap();
        engine.advance(20.0).unwrap();
        let x = engine.state().get("bodies", Position, 1).unwrap().x;
        assert!((x - (3.0 + 40.0_f64.cos())).abs() < 1e-10, "{x}");
        assert!((engine.energy().unwrap().0 - 1.0).abs() < 1e-10);
    }
}
