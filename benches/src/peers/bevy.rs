//! The five laws as systems of bevy_ecs, single-threaded, over whole slices of components.

use super::{Charge, Drag, Force, Mass, Place, Speed, components, vector};
use crate::scenes::{Bodies, ELECTRIC, GRAVITY, MAGNETIC, STEP};
use bevy_ecs::prelude::{Query, Res, Resource};
use bevy_ecs::schedule::{IntoScheduleConfigs, Schedule, SingleThreadedExecutor};
use bevy_ecs::world::World;
use vesper::real::{Scalar, Vector};

/// The fields.
#[derive(Resource, Clone, Copy, Debug)]
struct Fields<P: Scalar> {
    gravity: P::Vec3,
    electric: P::Vec3,
    magnetic: P::Vec3,
}

/// A schedule that runs its systems one after the other, in one thread.
pub fn schedule() -> Schedule {
    let mut schedule = Schedule::default();
    schedule.set_executor(SingleThreadedExecutor::new());
    schedule
}

/// A world with these bodies, and the five systems.
pub fn charged<P: Scalar>(bodies: &Bodies) -> (World, Schedule) {
    let mut world = World::new();
    world.insert_resource(Fields::<P> {
        gravity: vector::<P>(GRAVITY),
        electric: vector::<P>(ELECTRIC),
        magnetic: vector::<P>(MAGNETIC),
    });
    world.spawn_batch(components::<P>(bodies));
    let mut schedule = schedule();
    schedule.add_systems((drag::<P>, electric::<P>, weight::<P>, magnetic::<P>, motion::<P>).chain());
    (world, schedule)
}

/// The first system of the step: it sets the sum, the others add to it.
fn drag<P: Scalar>(mut bodies: Query<(&mut Force<P>, &Speed<P>, &Drag<P>)>) {
    for (mut force, speed, drag) in bodies.contiguous_iter_mut().into_iter().flatten() {
        for ((force, speed), drag) in force.bypass_change_detection().iter_mut().zip(speed).zip(drag) {
            force.0 = speed.0 * -drag.0;
        }
    }
}

fn electric<P: Scalar>(mut bodies: Query<(&mut Force<P>, &Charge<P>)>, fields: Res<Fields<P>>) {
    for (mut force, charge) in bodies.contiguous_iter_mut().into_iter().flatten() {
        for (force, charge) in force.bypass_change_detection().iter_mut().zip(charge) {
            force.0 += fields.electric * charge.0;
        }
    }
}

fn weight<P: Scalar>(mut bodies: Query<(&mut Force<P>, &Mass<P>)>, fields: Res<Fields<P>>) {
    for (mut force, mass) in bodies.contiguous_iter_mut().into_iter().flatten() {
        for (force, mass) in force.bypass_change_detection().iter_mut().zip(mass) {
            force.0 += fields.gravity * mass.0;
        }
    }
}

fn magnetic<P: Scalar>(mut bodies: Query<(&mut Force<P>, &Speed<P>, &Charge<P>)>, fields: Res<Fields<P>>) {
    for (mut force, speed, charge) in bodies.contiguous_iter_mut().into_iter().flatten() {
        for ((force, speed), charge) in force.bypass_change_detection().iter_mut().zip(speed).zip(charge) {
            force.0 += speed.0.cross(fields.magnetic) * charge.0;
        }
    }
}

#[allow(clippy::type_complexity, reason = "a system's query is its declaration")]
fn motion<P: Scalar>(mut bodies: Query<(&mut Place<P>, &mut Speed<P>, &Force<P>, &Mass<P>)>) {
    let step = P::from_f64(STEP);
    for (mut place, mut speed, force, mass) in bodies.contiguous_iter_mut().into_iter().flatten() {
        let places = place.bypass_change_detection().iter_mut().zip(speed.bypass_change_detection());
        for (((place, speed), force), mass) in places.zip(force).zip(mass) {
            let immovable = mass.0.equal(P::default());
            speed.0 += P::select_vector(immovable, P::Vec3::zero(), force.0 / mass.0) * step;
            place.0 += P::select_vector(immovable, P::Vec3::zero(), speed.0) * step;
        }
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
    let mut query = world.query::<&Place<P>>();
    let theirs = query.iter(world).flat_map(|place| [place.0.x(), place.0.y(), place.0.z()]).map(P::to_f64);
    Ok(crate::hand::relative_difference(&ours, theirs))
}
