//! Suns around a heavy core, each on a circular course.
//!
//! Row 0 is the core. The suns fill a ring evenly by area between a tenth of the radius and the radius; each has the
//! speed sqrt(G (core + suns nearer to it) / r), at right angles to its place, seen from the core. That counts the mass
//! inside as if it were a sphere, which is right to a few hundredths for suns that weigh little beside the core. Then
//! the centre of mass is put to rest at the origin.

use super::{
    Bound, GRAVITATION, GenerateFault, Generated, Kind, OptionInfo, Options, SEED, bodies, centre, count, distance,
};

pub(super) const KIND: Kind = Kind {
    name: "galaxy",
    about: "suns on circular courses around a heavy core (row 0), turning about z",
    options: &[
        count(&[1536.0], 1.0, "number of bodies, the core among them"),
        SEED,
        GRAVITATION,
        OptionInfo {
            name: "core_mass",
            unit: "kg",
            default: &[],
            bound: Bound::Positive,
            about: "mass of the core; default 1e4/g, which makes 10 m/s at 100 m",
        },
        OptionInfo {
            name: "sun_mass",
            unit: "kg",
            default: &[],
            bound: Bound::NotNegative,
            about: "mass of each sun; default: all together a tenth of the core",
        },
        OptionInfo { name: "radius", unit: "m", default: &[100.0], bound: Bound::Positive, about: "outer radius" },
        OptionInfo {
            name: "thickness",
            unit: "m",
            default: &[5.0],
            bound: Bound::NotNegative,
            about: "standard deviation of the height z",
        },
    ],
    also_fills: &[],
    make,
};

/// Inner radius of the ring by the outer one.
const INNER: f64 = 0.1;

fn make(options: &Options) -> Result<Generated, GenerateFault> {
    let n = options.whole("count");
    let g = options.number("g");
    let core = options.number_or("core_mass", 1e4 / g);
    let sun = options.number_or("sun_mass", 0.1 * core / (n - 1).max(1) as f64);
    let radius = options.number("radius");
    let thickness = options.number("thickness");
    let mut deviates = options.deviates();
    let mut position = vec![[0.0; 3]];
    for _ in 1..n {
        // Even by area: the square of the distance from the axis is uniform.
        let across = radius * deviates.between(INNER * INNER, 1.0).sqrt();
        let [x, y] = deviates.circle();
        position.push([across * x, across * y, thickness * deviates.normal()]);
    }
    let from_core: Vec<f64> = position.iter().map(|&place| distance(place, position[0])).collect();
    let mut nearer = from_core[1..].to_vec();
    nearer.sort_by(f64::total_cmp);
    let mut velocity = vec![[0.0; 3]];
    for (place, r) in position.iter().zip(&from_core).skip(1) {
        let inside = core + sun * nearer.partition_point(|other| other < r) as f64;
        let speed = (g * inside / r).sqrt();
        let across = (place[0] * place[0] + place[1] * place[1]).sqrt();
        velocity.push([-speed * place[1] / across, speed * place[0] / across, 0.0]);
    }
    let mut mass = vec![sun; n];
    mass[0] = core;
    centre(&mass, &mut position);
    centre(&mass, &mut velocity);
    Ok(bodies(options.domain, mass, &position, &velocity))
}
