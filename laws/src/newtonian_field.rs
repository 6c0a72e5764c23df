use vesper::prelude::*;

property! {
    /// Gravitational potential of all other rows, with the sign of GM: it is positive.
    pub GravitationalPotential: Scalar, "m^2/s^2", sum;
    /// Newtonian acceleration by all other rows, apart from other accelerations.
    pub NewtonianAcceleration: Vector, "m/s^2", sum;
}

/// Newtonian potential and acceleration at the place of every row, for laws that start from them.
///
/// Equation: U_i = sum over j of GM_j / |d|, g_i = sum over j of GM_j d / |d|^3, d = x_j - x_i.
///
/// Source: Will, Theory and Experiment in Gravitational Physics, 2nd ed., sec. 4.1: U in the Newtonian limit; g is its
/// gradient.
///
/// Limits: as `gravity_by_parameter`, without softening. It moves nothing by itself: the acceleration that moves rows is
/// another property. `einstein_infeld_hoffmann` needs it.
#[derive(Law, Clone, Copy, Debug)]
#[law(
    reads(position: Position, parameter: StandardGravitationalParameter),
    adds(potential: GravitationalPotential, acceleration: NewtonianAcceleration),
    translation_invariant
)]
pub struct NewtonianField;

#[kernel]
impl<R: Real> PairLaw<R> for NewtonianField {
    fn pair(&self, i: NewtonianFieldRow<R>, j: NewtonianFieldRow<R>) -> NewtonianFieldOutput<R> {
        let d = j.position - i.position;
        let inverse = d.length_squared().rsqrt();
        let potential = j.parameter * inverse;
        NewtonianFieldOutput { potential, acceleration: d * (potential * inverse * inverse) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn potential_and_acceleration_of_two_centres() {
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3], [4.0, 0.0, 0.0], [0.0, -2.0, 0.0]])
            .with(StandardGravitationalParameter, [1.0, 8.0, 4.0]);
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .law(NewtonianField)
            .observe("bodies", GravitationalPotential)
            .observe("bodies", NewtonianAcceleration)
            .step(1.0)
            .build()
            .unwrap();
        engine.advance(1.0).unwrap();
        // 8 / 4 + 4 / 2 and 8 / 16 along x, 4 / 4 along -y: exact in binary.
        assert_eq!(engine.state().get("bodies", GravitationalPotential, 0).unwrap(), 4.0);
        assert_eq!(engine.state().get("bodies", NewtonianAcceleration, 0).unwrap(), DVec3::new(0.5, -1.0, 0.0));
    }
}
