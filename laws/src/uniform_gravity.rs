use vesper::prelude::*;

/// Weight in a field of gravity that is the same everywhere.
///
/// Equation: F = m g; energy -m g . x.
///
/// Source: Landau, Lifshitz, Mechanics, 3rd ed., eq. 5.8.
///
/// Limits: heights far below the radius of the attracting body: at h above the Earth the error is 2 h / 6371 km.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position, mass: Mass), scene(gravity: GravityAcceleration), adds(force: Force))]
pub struct UniformGravity;

#[kernel]
impl<R: Real> RowLaw<R> for UniformGravity {
    fn row(&self, body: UniformGravityRow<R>) -> R::Vec3 {
        body.gravity * body.mass
    }

    fn energy(&self, body: UniformGravityRow<R>) -> R {
        -body.mass * body.gravity.dot(body.position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Motion;

    #[test]
    fn a_throw_rises_and_falls_with_constant_energy() {
        let bodies =
            Domain::new("bodies").with(Position, [[0.0; 3]]).with(Velocity, [[2.0, 0.0, 8.0]]).with(Mass, [0.5]);
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .constant(GravityAcceleration, [[0.0, 0.0, -8.0]])
            .law(UniformGravity)
            .law(Motion)
            .step(0.25)
            .build()
            .unwrap();
        let start = engine.energy().unwrap();
        assert_eq!(start, (17.0, vec![]));
        engine.advance(1.5).unwrap();
        assert_eq!(engine.state().get("bodies", Position, 0).unwrap(), DVec3::new(3.0, 0.0, 3.0));
        assert_eq!(engine.energy().unwrap(), start);
    }
}
