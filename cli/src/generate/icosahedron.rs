//! A shell in the form of a regular icosahedron: 12 masses, 30 edge springs, 20 faces; on wish a mass in the centre with
//! 12 spokes, and a floor.
//!
//! Rows of the masses: 0 to 11 the corners, then the centre where there is one, then the three immovable masses of the
//! floor where there is one. Faces run counter-clockwise seen from outside; the floor is the last face, its normal is
//! (sin slope, 0, cos slope). Fills "springs" and "faces" too.

use super::{Bound, GenerateFault, Generated, Kind, OptionInfo, Options, bodies, distance, link, scalar};

const fn option(
    name: &'static str,
    unit: &'static str,
    default: &'static [f64],
    bound: Bound,
    about: &'static str,
) -> OptionInfo {
    OptionInfo { name, unit, default, bound, about }
}

pub(super) const KIND: Kind = Kind {
    name: "icosahedron",
    about: "shell of 12 masses, 30 springs, 20 faces, above a floor if asked for; fills springs and faces",
    options: &[
        option("mass", "kg", &[100.0], Bound::Positive, "of each corner"),
        option("radius", "m", &[5.0], Bound::Positive, "from centre to corner; an edge is 1.0515 of it"),
        option("centre", "m", &[0.0, 0.0, 100.0], Bound::Any, "where the centre is"),
        option("velocity", "m/s", &[0.0; 3], Bound::Any, "of all its masses"),
        option("centre_mass", "kg", &[0.0], Bound::NotNegative, "mass in the centre; 0: none, and no spokes"),
        option("face_down", "", &[0.0], Bound::Whole(0.0, 1.0), "1: face 0 1 2 looks down, before it is turned"),
        option("turn", "rad", &[0.0; 3], Bound::Any, "turned about x, then y, then z"),
        option("stiffness", "N/m", &[5e6], Bound::NotNegative, "of a spring"),
        option("damping", "N s/m", &[1500.0], Bound::NotNegative, "of a spring"),
        option("thickness", "m", &[0.1], Bound::NotNegative, "of a face"),
        option("hardness", "N/m^3", &[1e12], Bound::NotNegative, "of a face; the default is hard beside any floor"),
        option("surface_damping", "N s/m^3", &[500.0], Bound::NotNegative, "of a face"),
        option("friction", "", &[0.5], Bound::NotNegative, "of a face; that of a pair is the product"),
        option("floor", "m", &[0.0], Bound::NotNegative, "side of the floor, a triangle around the origin; 0: none"),
        option("slope", "rad", &[0.0], Bound::Any, "of the floor, falling towards x"),
        option("floor_hardness", "N/m^3", &[1.5e6], Bound::NotNegative, "of the floor"),
        option("floor_friction", "", &[0.5], Bound::NotNegative, "of the floor"),
    ],
    also_fills: &["springs", "faces"],
    make,
};

/// The corners of the unit form: all (0, ±1, ±phi) and their cyclic permutations, on a sphere of radius 1.
fn corners() -> [[f64; 3]; 12] {
    let phi = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let length = (1.0 + phi * phi).sqrt();
    let (a, b) = (1.0 / length, phi / length);
    let mut corners = [[0.0; 3]; 12];
    for (group, (s, t)) in [(a, b), (a, -b), (-a, b), (-a, -b)].into_iter().enumerate() {
        corners[3 * group] = [0.0, s, t];
        corners[3 * group + 1] = [s, t, 0.0];
        corners[3 * group + 2] = [t, 0.0, s];
    }
    corners
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Turns the direction (1, 1, 1), the normal of face 0 1 2, to (0, 0, -1): v + k x v + k x (k x v) / (1 + c), where k is
/// the cross product of the two directions and c their cosine (Rodrigues' formula for the shortest turn).
fn face_down(v: [f64; 3]) -> [f64; 3] {
    let third = 1.0 / 3.0_f64.sqrt();
    let k = cross([third; 3], [0.0, 0.0, -1.0]);
    let (once, scale) = (cross(k, v), 1.0 / (1.0 - third));
    let twice = cross(k, once);
    [0, 1, 2].map(|axis| v[axis] + once[axis] + twice[axis] * scale)
}

/// Turned about one axis.
fn turned(mut v: [f64; 3], axis: usize, angle: f64) -> [f64; 3] {
    let (sin, cos) = angle.sin_cos();
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    (v[i], v[j]) = (cos * v[i] - sin * v[j], sin * v[i] + cos * v[j]);
    v
}

fn make(options: &Options) -> Result<Generated, GenerateFault> {
    let unit = corners();
    // Neighbours are 1.05 apart, all others 1.70 or more.
    let near = |i: usize, j: usize| distance(unit[i], unit[j]) < 1.4;
    let (mut ends, mut faces) = (Vec::new(), Vec::new());
    for i in 0..12 {
        for j in (i + 1..12).filter(|&j| near(i, j)) {
            ends.push([i, j]);
            for k in (j + 1..12).filter(|&k| near(i, k) && near(j, k)) {
                let outward = dot(cross(unit[i], unit[j]), unit[k]) > 0.0;
                faces.push(if outward { [i, j, k] } else { [i, k, j] });
            }
        }
    }
    let (radius, centre) = (options.number("radius"), options.vector("centre"));
    let turn = options.vector("turn");
    let mut position: Vec<[f64; 3]> = unit
        .iter()
        .map(|&corner| {
            let mut place = if options.whole("face_down") == 1 { face_down(corner) } else { corner };
            (0..3).for_each(|axis| place = turned(place, axis, turn[axis]));
            [0, 1, 2].map(|axis| centre[axis] + radius * place[axis])
        })
        .collect();
    // One number for all edges, so that the form at rest has no stress from rounding.
    let mut rest = vec![radius * distance(unit[0], unit[1]); ends.len()];
    let mut mass = vec![options.number("mass"); 12];
    let centre_mass = options.number("centre_mass");
    if centre_mass > 0.0 {
        ends.extend((0..12).map(|corner| [corner, 12]));
        rest.resize(ends.len(), radius);
        position.push(centre);
        mass.push(centre_mass);
    }
    let mut velocity = vec![options.vector("velocity"); mass.len()];
    let each = |name: &str| vec![options.number(name); 20];
    let (mut thickness, mut hardness) = (each("thickness"), each("hardness"));
    let (mut damping, mut friction) = (each("surface_damping"), each("friction"));
    let side = options.number("floor");
    if side > 0.0 {
        let first = mass.len();
        faces.push([first, first + 1, first + 2]);
        let (out, half) = (side / 3.0_f64.sqrt(), side / 2.0);
        for corner in [[out, 0.0, 0.0], [-out / 2.0, half, 0.0], [-out / 2.0, -half, 0.0]] {
            position.push(turned(corner, 1, options.number("slope")));
            velocity.push([0.0; 3]);
            mass.push(0.0);
        }
        thickness.push(options.number("thickness"));
        hardness.push(options.number("floor_hardness"));
        damping.push(options.number("surface_damping"));
        friction.push(options.number("floor_friction"));
    }
    let mut generated = bodies(options.domain, mass, &position, &velocity);
    let springs = vec![
        link("ends", options.domain, &ends),
        scalar("stiffness", vec![options.number("stiffness"); ends.len()]),
        scalar("damping", vec![options.number("damping"); ends.len()]),
        scalar("rest_length", rest),
    ];
    let faces = vec![
        link("vertices", options.domain, &faces),
        scalar("thickness", thickness),
        scalar("hardness", hardness),
        scalar("surface_damping", damping),
        scalar("friction", friction),
    ];
    generated.domains.extend([("springs".to_owned(), springs), ("faces".to_owned(), faces)]);
    Ok(generated)
}
