//! Spheres of influence: which body goes round which.
//!
//! In: places and masses of bodies, heaviest first. Out: for each body the one that it goes round, [`orbits`], and from
//! that its acceleration, [`accelerations`]. Never: a column, a body of mass 0.
//!
//! Bodies are placed one after another, heaviest first, so that all spheres that may hold a body are there before it; of equal
//! masses the one in the earlier place is the heavier. The search goes down the tree: into a sphere that holds the body, then
//! into one within that, until none does. A sphere that sticks out of the one it lies in ends there.
//!
//! What was refused:
//! - *Hill's radius*, a (m / 3 M)^(1/3), for Laplace's, a (m / M)^(2/5). Hill's says how far from m orbits are stable;
//!   Laplace's, where either two-body problem leaves out the same share. For the Earth these are 1.5e9 m and 0.92e9 m, and
//!   between them an ellipse round the Sun leaves out less.
//! - *Laplace's sphere as it is.* It is derived for m far below M; for equal masses it reaches the other body, and takes
//!   what is next to that. So a body counts as within only if its distance from m is below (m / M)^(2/5) times its own
//!   distance from M, too, which is what the derivation compares. It cuts off a share of (m / M)^(2/5) on the side of M,
//!   0.6 % for the Earth.
//! - *The semi-major axis* for the present distance a: it needs velocities, and then forces depend on them, which most
//!   splitting integrators refuse; and on a fly-by it is below 0.
//! - *The attractor alone* for it with all that is further in. Then either the attractor is not pulled back, and momentum is
//!   lost, or its recoil by one body throws the others off. Jupiter moves the Sun by 12 m/s: Neptune's ellipse about the
//!   Sun alone is off by 4 000 000 km in ten years, about the centre of mass of what is further in by 26 000 km. Mars is the
//!   one planet that loses by that much, 1.6 times, and Jupiter loses 1.1 times.
//! - *A switch*, at which steps end. It holds numbers of rows, and a law of whole columns would have to hold the tree; and
//!   of a million rows one crosses a sphere in every step, or a neighbour's distance.

mod accelerations;
mod cells;

pub(crate) use accelerations::{Attraction, accelerations};
use cells::Cells;
use core::cmp::Ordering;
use vesper::prelude::*;

/// How a body goes round its attractor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Orbit<P: Precision> {
    /// The attractor; of the first body itself.
    pub around: u32,
    /// From the attractor to the body.
    pub way: P::Vec3,
    /// The square of that distance.
    pub square: P,
}

/// The orbits of all bodies. The first `attractors` of them have spheres of influence.
pub(crate) fn orbits<P: Precision>(places: &[P::Vec3], masses: &[P], attractors: usize) -> Vec<Orbit<P>> {
    let mut orbits = Vec::with_capacity(places.len());
    let mut spheres = Spheres::new(attractors);
    for (body, &place) in places.iter().enumerate() {
        let (mut around, mut way) = (0, place - places[0]);
        let mut square = way.length_squared();
        while let Some((inner, to_inner)) = spheres.innermost(around, place, (way, square), places, &orbits) {
            (around, way, square) = (inner, to_inner, to_inner.length_squared());
        }
        orbits.push(Orbit { around, way, square });
        if 0 < body && body < attractors {
            spheres.insert(body as u32, &orbits, masses[body] / masses[around as usize]);
        }
    }
    orbits
}

/// By size; what is no number comes last.
pub(crate) fn by_size<P: Precision>(a: P, b: P) -> Ordering {
    let is_none = |number: P| number.partial_cmp(&number).is_none();
    is_none(a).cmp(&is_none(b)).then(a.partial_cmp(&b).unwrap_or(Ordering::Equal))
}

/// No body.
const NONE: u32 = u32::MAX;
/// Up to so many spheres within one are looked at in turn.
const FEW: u32 = 16;

/// The spheres that there are so far. That of body 0 is all space.
struct Spheres<P> {
    /// The square of (m / M)^(2/5).
    share: Vec<P>,
    /// The last body placed within each sphere, and the one placed before each body; how many there are.
    last: Vec<u32>,
    before: Vec<u32>,
    count: Vec<u32>,
    cells: Cells,
}

impl<P: Precision> Spheres<P> {
    fn new(attractors: usize) -> Self {
        Spheres {
            share: vec![P::lit(0.0); attractors],
            last: vec![NONE; attractors],
            before: vec![NONE; attractors],
            count: vec![0; attractors],
            cells: Cells::new(attractors),
        }
    }

    fn insert(&mut self, body: u32, orbits: &[Orbit<P>], ratio: P) {
        let (at, around) = (body as usize, orbits[body as usize].around as usize);
        let share = ratio.powf(P::lit(0.4));
        self.share[at] = share * share;
        self.before[at] = self.last[around];
        self.last[around] = body;
        self.count[around] += 1;
        // Once they are many, all of them get cells.
        let mut next = if self.count[around] > FEW { body } else { NONE };
        while next != NONE {
            let Orbit { around: attractor, way, square } = orbits[next as usize];
            let radius = (self.share[next as usize] * square).to_f64().sqrt();
            self.cells.insert(next, attractor, components::<P>(way), radius);
            next = if self.count[around] == FEW + 1 { self.before[next as usize] } else { NONE };
        }
    }

    /// The smallest sphere directly within that of `around` that holds a place, and the way from its body; of equal ones
    /// that of the heavier body.
    fn innermost(
        &self,
        around: u32,
        place: P::Vec3,
        (way, square): (P::Vec3, P),
        places: &[P::Vec3],
        orbits: &[Orbit<P>],
    ) -> Option<(u32, P::Vec3)> {
        let mut best: Option<(P, u32, P::Vec3)> = None;
        let mut look = |body: u32| {
            let (share, orbit) = (self.share[body as usize], orbits[body as usize]);
            let way = place - places[body as usize];
            // At most as far away as Laplace says, and never nearer to the attractor than equal masses would have it.
            let near = if square < orbit.square { square } else { orbit.square };
            let radius = share * orbit.square;
            let smaller = best.is_none_or(|(least, other, _)| radius < least || radius == least && body < other);
            if orbit.around == around && way.length_squared() < share * near && smaller {
                best = Some((radius, body, way));
            }
            best.is_some()
        };
        if self.count[around as usize] > FEW {
            self.cells.near(around, components::<P>(way), &mut look);
        } else {
            let mut body = self.last[around as usize];
            while body != NONE {
                look(body);
                body = self.before[body as usize];
            }
        }
        best.map(|(_, body, way)| (body, way))
    }
}

fn components<P: Precision>(vector: P::Vec3) -> [f64; 3] {
    [vector.x().to_f64(), vector.y().to_f64(), vector.z().to_f64()]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What each body goes round.
    fn around(places: &[DVec3], masses: &[f64]) -> Vec<u32> {
        orbits::<f64>(places, masses, masses.len()).iter().map(|orbit| orbit.around).collect()
    }

    /// The same, by looking at all spheres.
    fn by_all(places: &[DVec3], masses: &[f64]) -> Vec<u32> {
        let (mut around, mut radius) = (vec![0], vec![f64::INFINITY]);
        for body in 1..places.len() {
            let distance = |other: usize| (places[body] - places[other]).length();
            let mut at = 0;
            loop {
                let from = distance(at);
                let holds = |&c: &usize| {
                    let own = (places[c] - places[at]).length();
                    around[c] == at as u32 && distance(c) < radius[c] * (from / own).min(1.0)
                };
                let smallest = (1..body).filter(holds).min_by(|&a, &b| radius[a].total_cmp(&radius[b]));
                let Some(inner) = smallest else { break };
                at = inner;
            }
            around.push(at as u32);
            radius.push(distance(at) * (masses[body] / masses[at]).powf(0.4));
        }
        around
    }

    #[test]
    fn a_moon_goes_round_its_planet_and_a_ship_leaves_it() {
        let (earth, moon) = (DVec3::X * 1.496e11, DVec3::X * 1.496e11 + DVec3::Y * 3.844e8);
        let ship = |place: DVec3| around(&[DVec3::ZERO, earth, moon, place], &[1.988e30, 5.972e24, 7.346e22, 1e5]);
        assert_eq!(ship(earth + DVec3::X * 7e6), [0, 0, 1, 1]);
        // Laplace: 66 200 km about the Moon, 924 600 km about the Earth.
        assert_eq!(ship(moon + DVec3::Y * 66.1e6), [0, 0, 1, 2]);
        assert_eq!(ship(moon + DVec3::Y * 66.3e6), [0, 0, 1, 1]);
        assert_eq!(ship(earth + DVec3::X * 924e6), [0, 0, 1, 1]);
        assert_eq!(ship(earth + DVec3::X * 926e6), [0, 0, 1, 0]);
        // Towards the attractor by a share of (m / M)^(2/5) less.
        assert_eq!(ship(earth - DVec3::X * 918e6), [0, 0, 1, 1]);
        assert_eq!(ship(earth - DVec3::X * 920e6), [0, 0, 1, 0]);
        // Beyond the Sun.
        assert_eq!(ship(-earth), [0, 0, 1, 0]);
    }

    #[test]
    fn of_equal_stars_each_has_its_planet() {
        let places = [DVec3::ZERO, DVec3::X, DVec3::X * 0.3, DVec3::X * 0.7, DVec3::Y * 9.0, DVec3::new(9.0, 9.0, 0.0)];
        // The last two go round both stars: round the first, further out than the second one.
        assert_eq!(around(&places, &[1.0, 1.0, 1e-6, 1e-6, 1e-9, 1e-9]), [0, 0, 0, 1, 0, 0]);
    }

    #[test]
    fn of_overlapping_spheres_the_smaller_one_holds() {
        let places = [DVec3::ZERO, DVec3::X, DVec3::X * 1.1, DVec3::X * 1.05];
        // Spheres of 0.063 and 0.027 about 1 and 1.1; the smaller one does not reach 1.05, but 1.08.
        assert_eq!(around(&places, &[1.0, 1e-3, 1e-4, 1e-9]), [0, 0, 0, 1]);
        let places = [places[0], places[1], places[2], DVec3::X * 1.08];
        assert_eq!(around(&places, &[1.0, 1e-3, 1e-4, 1e-9]), [0, 0, 0, 2]);
        let places = [places[0], places[1], DVec3::X * 1.065, DVec3::X * 1.058];
        assert_eq!(around(&places, &[1.0, 1e-3, 1e-4, 1e-9]), [0, 0, 0, 2]);
    }

    #[test]
    fn cells_find_what_a_look_at_all_finds() {
        let mut number = 7_u64;
        let mut next = move || {
            number = number.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (number >> 11) as f64 / (1_u64 << 53) as f64
        };
        // Masses of three powers of ten and of twelve, in a cube and in a disc; all on one circle.
        for (powers, height, ring) in [(3.0, 1.0, false), (12.0, 1.0, false), (12.0, 1e-3, false), (9.0, 0.0, true)] {
            let mut bodies: Vec<(f64, DVec3)> = vec![(1.0, DVec3::ZERO)];
            for _ in 0..1500 {
                let cube = DVec3::new(next() - 0.5, next() - 0.5, height * (next() - 0.5));
                let place = if ring { DVec3::new(cube.x, cube.y, 0.0).normalize() } else { cube };
                bodies.push((10_f64.powf(-powers * next()), place));
            }
            bodies.sort_by(|a, b| b.0.total_cmp(&a.0));
            let (masses, places): (Vec<f64>, Vec<DVec3>) = bodies.into_iter().unzip();
            let (found, expected) = (around(&places, &masses), by_all(&places, &masses));
            let deep = found.iter().filter(|&&body| body != 0).count();
            println!("{powers} powers of ten: {deep} of 1500 within spheres");
            assert!(deep > 10 && found == expected);
        }
    }

    #[test]
    fn what_is_no_number_goes_round_the_heaviest() {
        let places = [DVec3::ZERO, DVec3::X, DVec3::NAN, DVec3::X * 1.01, DVec3::X * f64::INFINITY];
        assert_eq!(around(&places, &[1.0, 1e-3, 1e-4, 1e-6, 1e-7]), [0, 0, 0, 1, 0]);
        assert_eq!(around(&[DVec3::X; 3], &[1.0, 1e-3, 1e-6]), [0, 0, 0], "at their attractor spheres hold nothing");
        assert_eq!(around(&[], &[]), [0_u32; 0]);
        let many = vec![DVec3::NAN; 100];
        assert_eq!(around(&many, &[1.0; 100]), vec![0; 100]);
    }
}
