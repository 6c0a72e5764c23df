//! The five laws as loops over queries of hecs.

use super::{Charge, Drag, Force, Mass, Place, Speed, components, vector};
use crate::scenes::{Bodies, ELECTRIC, GRAVITY, MAGNETIC, STEP};
use hecs::World;
use vesper::real::{Scalar, Vector};

/// A world with these bodies.
pub fn charged<P: Scalar>(bodies: &Bodies) -> World {
    let mut world = World::new();
    world.spawn_batch(components::<P>(bodies)).for_each(drop);
    world
}

/// One step: the first loop sets the sum, the others add to it.
pub fn step<P: Scalar>(world: &mut World) {
    for (force, speed, drag) in world.query_mut::<(&mut Force<P>, &Speed<P>, &Drag<P>)>() {
        force.0 = speed.0 * -drag.0;
    }
    let electric = vector::<P>(ELECTRIC);
    for (force, charge) in world.query_mut::<(&mut Force<P>, &Charge<P>)>() {
        force.0 += electric * charge.0;
    }
    let gravity = vector::<P>(GRAVITY);
    for (force, mass) in world.query_mut::<(&mut Force<P>, &Mass<P>)>() {
        force.0 += gravity * mass.0;
    }
    let magnetic = vector::<P>(MAGNETIC);
    for (force, speed, charge) in world.query_mut::<(&mut Force<P>, &Speed<P>, &Charge<P>)>() {
        force.0 += speed.0.cross(magnetic) * charge.0;
    }
    let step = P::from_f64(STEP);
    for (place, speed, force, mass) in world.query_mut::<(&mut Place<P>, &mut Speed<P>, &Force<P>, &Mass<P>)>() {
        let immovable = mass.0.equal(P::default());
        speed.0 += P::select_vector(immovable, P::Vec3::zero(), force.0 / mass.0) * step;
        place.0 += P::select_vector(immovable, P::Vec3::zero(), speed.0) * step;
    }
}

/// The largest difference of an engine's places from the world's, in parts of the largest number.
///
/// # Errors
/// The engine has no such column.
pub fn difference<P: Scalar>(
    engine: &vesper::engine::Engine<P>,
    world: &mut World,
) -> Result<f64, vesper::error::Fault> {
    let ours = engine.state().numbers("bodies", vesper::prelude::Position)?;
    let theirs = world.query_mut::<&Place<P>>().into_iter().flat_map(|place| [place.0.x(), place.0.y(), place.0.z()]);
    Ok(crate::hand::relative_difference(&ours, theirs.map(P::to_f64)))
}
