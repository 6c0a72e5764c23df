//! The acceleration of every body in a tree of two-body problems.
//!
//! In: places and masses of bodies, heaviest first, and which of them have spheres. Out: their accelerations. Never: work that
//! grows with the square of their number.
//!
//! What goes round one body stands in order of distance from it, and each thing goes round all that is further in, which
//! is pulled back by it as a whole. A thing is a body with all that goes round it, at its centre of mass. Bodies without
//! spheres are not put in order: those between the same two neighbours go round the same, and do not know of each other.
//! They stand in one slot; a body has one more slot than it has bodies with spheres around it.
//!
//! Masses are taken in parts of that of the body in the middle, since their products with distances leave f32.

use super::{Orbit, by_size, orbits};
use vesper::prelude::*;

/// What all in one slot go round, and what they add to it.
#[derive(Clone, Copy)]
struct Slot<P: Precision> {
    /// Mass of what is further in, and the way to its centre of mass from the body in the middle.
    inner: P,
    centre: P::Vec3,
    /// Mass of what is in the slot, and the sum of ways, each by its part of the mass of the body in the middle.
    mass: P,
    moment: P::Vec3,
    /// How what is in the slot accelerates what is further in.
    recoil: P::Vec3,
    /// How what is further out, and the body in the middle, accelerate what is in the slot.
    follows: P::Vec3,
}

/// Newton's law of gravitation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Attraction<P> {
    /// Constant of gravitation.
    pub g: P,
    /// Softening length.
    pub softening: P,
}

impl<P: Precision> Attraction<P> {
    /// How two things that are so far apart accelerate each other: the first towards the second one, and the other way.
    fn between(self, way: P::Vec3, first: P, second: P) -> [P::Vec3; 2] {
        let inverse = (way.length_squared() + self.softening * self.softening).rsqrt();
        // The cube of the distance leaves f32, and so does the product of the masses.
        let by = |mass: P| way * (self.g * mass * inverse * inverse * inverse);
        [by(second), -by(first)]
    }
}

/// The accelerations of bodies with these masses, of which the first `attractors` have spheres.
pub(crate) fn accelerations<P: Precision>(
    places: &[P::Vec3],
    masses: &[P],
    attractors: usize,
    attraction: Attraction<P>,
) -> Vec<P::Vec3> {
    let (zero, none) = (P::lit(0.0), P::Vec3::zero());
    let mut accelerations = vec![none; places.len()];
    // Without a sphere that is all space nothing goes round anything.
    if attractors == 0 {
        return accelerations;
    }
    let orbits = orbits(places, masses, attractors);
    let (systems, centres) = systems(&orbits, masses, attractors);

    // The bodies around each, by distance; the slots of a body begin after those of the bodies before it.
    let mut ordered: Vec<u32> = (1..attractors as u32).collect();
    ordered.sort_by(|&a, &b| {
        let [a, b] = [a, b].map(|body| orbits[body as usize]);
        a.around.cmp(&b.around).then(by_size(a.square, b.square))
    });
    let mut first = vec![0; attractors + 1];
    orbits[1..attractors].iter().for_each(|orbit| first[orbit.around as usize + 1] += 1);
    (0..attractors).for_each(|body| first[body + 1] += first[body]);
    let around = |body: usize| &ordered[first[body]..first[body + 1]];
    let empty = Slot { inner: zero, centre: none, mass: zero, moment: none, recoil: none, follows: none };
    let mut slots = vec![empty; 2 * attractors - 1];
    let light = &orbits[attractors..];
    let places_of_light = light.iter().zip(&masses[attractors..]).map(|(orbit, &mass)| {
        let middle = orbit.around as usize;
        let further_in = |&body: &u32| orbits[body as usize].square <= orbit.square;
        let slot = first[middle] + middle + around(middle).partition_point(further_in);
        slots[slot].mass += mass;
        slots[slot].moment += orbit.way * (mass / masses[middle]);
        slot
    });
    let places_of_light: Vec<usize> = places_of_light.collect();

    // Outwards: what each thing goes round.
    let mut recoils = vec![none; attractors];
    for middle in 0..attractors {
        let part = |mass: P| mass / masses[middle];
        let (mut inner, mut centre) = (masses[middle], none);
        for (at, slot) in slots[first[middle] + middle..=first[middle + 1] + middle].iter_mut().enumerate() {
            (slot.inner, slot.centre) = (inner, centre);
            if slot.mass > zero {
                let sum = centre * part(inner) + slot.moment;
                inner += slot.mass;
                centre = sum / part(inner);
            }
            let Some(&body) = around(middle).get(at) else { continue };
            let body = body as usize;
            let place = orbits[body].way + centres[body];
            [recoils[body], accelerations[body]] = attraction.between(place - centre, inner, systems[body]);
            let sum = centre * part(inner) + place * part(systems[body]);
            inner += systems[body];
            centre = sum / part(inner);
        }
    }
    for (body, (orbit, &slot)) in (attractors..).zip(light.iter().zip(&places_of_light)) {
        let slot = &mut slots[slot];
        let [recoil, acceleration] = attraction.between(orbit.way - slot.centre, slot.inner, masses[body]);
        accelerations[body] = acceleration;
        slot.recoil += recoil;
    }

    // Inwards, and down the tree: all that is further in is pulled back, and what goes round a body moves with it.
    for middle in 0..attractors {
        let mut all = accelerations[middle];
        for (at, slot) in slots[first[middle] + middle..=first[middle + 1] + middle].iter_mut().enumerate().rev() {
            if let Some(&body) = around(middle).get(at) {
                accelerations[body as usize] += all;
                all += recoils[body as usize];
            }
            slot.follows = all;
            all += slot.recoil;
        }
        accelerations[middle] = all;
    }
    for (body, &slot) in (attractors..).zip(&places_of_light) {
        accelerations[body] += slots[slot].follows;
    }
    accelerations
}

/// Mass of each body with all that goes round it, and the way from it to their centre of mass.
fn systems<P: Precision>(orbits: &[Orbit<P>], masses: &[P], attractors: usize) -> (Vec<P>, Vec<P::Vec3>) {
    let none = P::Vec3::zero();
    let (mut systems, mut centres) = (masses[..attractors].to_vec(), vec![none; attractors]);
    // Lightest first: what goes round a body comes before it.
    for body in (1..orbits.len()).rev() {
        let (system, centre) = if body < attractors {
            centres[body] = centres[body] / (systems[body] / masses[body]);
            (systems[body], centres[body])
        } else {
            (masses[body], none)
        };
        let middle = orbits[body].around as usize;
        systems[middle] += system;
        centres[middle] += (orbits[body].way + centre) * (system / masses[middle]);
    }
    (systems, centres)
}
