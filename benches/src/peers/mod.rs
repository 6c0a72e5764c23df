//! The same five laws as others would have them: systems over the components of entities.

pub mod bevy;
pub mod hecs;

use crate::scenes::Bodies;
use bevy_ecs::prelude::Component;
use vesper::real::{Scalar, Vector};

macro_rules! kinds {
    ($($(#[$doc:meta])* $name:ident: $value:ty,)*) => {$(
        $(#[$doc])*
        #[derive(Component, Clone, Copy, Debug)]
        pub struct $name<P: Scalar>(pub $value);
    )*};
}
kinds! {
    /// Place.
    Place: P::Vec3,
    /// Velocity.
    Speed: P::Vec3,
    /// Mass.
    Mass: P,
    /// Charge.
    Charge: P,
    /// Coefficient of drag.
    Drag: P,
    /// Sum of all forces.
    Force: P::Vec3,
}

/// The components of a body.
type Body<P> = (Place<P>, Speed<P>, Mass<P>, Charge<P>, Drag<P>, Force<P>);

fn vector<P: Scalar>([x, y, z]: [f64; 3]) -> P::Vec3 {
    P::Vec3::new(P::from_f64(x), P::from_f64(y), P::from_f64(z))
}

/// The components of these bodies.
fn components<P: Scalar>(bodies: &Bodies) -> Vec<Body<P>> {
    let body = |row: usize| {
        (
            Place(vector::<P>(bodies.position[row])),
            Speed(vector::<P>(bodies.velocity[row])),
            Mass(P::from_f64(bodies.mass[row])),
            Charge(P::from_f64(bodies.charge[row])),
            Drag(P::from_f64(bodies.drag[row])),
            Force(P::Vec3::zero()),
        )
    };
    (0..bodies.len()).map(body).collect()
}
