use vesper::prelude::*;

property! {
    /// Energy of a quartic spring by the fourth power of its length.
    pub QuarticStiffness: Scalar, "N/m^3";
}

/// A spring without rest length whose energy grows with the fourth power of its length.
///
/// Equation: F_a = 4 k |d|^2 d, d = x_b - x_a, F_b = -F_a; energy k |d|^4.
///
/// Source: Fermi, Pasta, Ulam, Los Alamos report LA-1940 (1955), their beta model; Hairer, Lubich, Wanner, Geometric
/// Numerical Integration, 2nd ed., I.5.1, eq. 5.1.
///
/// Limits: no rest length, no damping. Soft at small lengths, stiff at large ones: the step must resolve
/// sqrt(12 k |d|^2 / m).
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(stiffness: QuarticStiffness), link(ends: Ends, reads(position: Position), adds(force: Force)))]
pub struct QuarticSpring;

#[kernel]
impl<R: Real> LinkLaw<R> for QuarticSpring {
    fn link(&self, spring: QuarticSpringRow<R>, [a, b]: [QuarticSpringEnd<R>; 2]) -> [R::Vec3; 2] {
        let d = b.position - a.position;
        let force = d * (R::lit(4.0) * spring.stiffness * d.length_squared());
        [force, -force]
    }

    fn energy(&self, spring: QuarticSpringRow<R>, [a, b]: [QuarticSpringEnd<R>; 2]) -> R {
        let square = (b.position - a.position).length_squared();
        spring.stiffness * square * square
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Motion;

    #[test]
    fn it_swings_in_the_time_of_its_elliptic_integral() {
        // m x'' = -4 k x^3 from x = A at rest comes back after 4 A / sqrt(2 k A^4 / m) times the integral of
        // 1 / sqrt(1 - u^4) from 0 to 1, which is 1.3110287771461 (half the lemniscate constant).
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3], [2.0, 0.0, 0.0]])
            .with(Velocity, [[0.0; 3]; 2])
            .with(Mass, [0.0, 0.5]);
        let springs = Domain::new("springs").link(Ends, "bodies", [[0, 1]]).with(QuarticStiffness, [3.0]);
        let builder = Engine::<f64>::builder().domain(bodies).domain(springs).law(QuarticSpring).law(Motion);
        let mut engine = builder.integrator(GaussRadau15::default()).build().unwrap();
        engine.advance(8.0 / 192.0_f64.sqrt() * 1.311_028_777_146_06).unwrap();
        let place = engine.state().get("bodies", Position, 1).unwrap();
        assert!((place.x - 2.0).abs() < 1e-12, "{place}");
        assert!((engine.energy().unwrap().0 - 48.0).abs() < 1e-12);
    }
}
