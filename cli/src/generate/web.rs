//! A spider's web in the plane z = 0: rings of masses, joined along the rings and along the radii, the rim held fast.
//!
//! Rows run ring by ring from the middle; the last ring is the rim, whose mass 0 means immovable. Fills "springs" too.
//! Threads between two masses of the rim would do nothing and are left out.

use std::f64::consts::TAU;

use super::{Bound, GenerateFault, Generated, Kind, OptionInfo, Options, SEED, bodies, count, distance, link, scalar};

pub(super) const KIND: Kind = Kind {
    name: "web",
    about: "spider's web with a fixed rim, its free masses displaced at random; fills springs",
    options: &[
        count(&[20.0], 6.0, "number of masses, the rim among them: spokes times rings"),
        SEED,
        OptionInfo {
            name: "spokes",
            unit: "",
            default: &[5.0],
            bound: Bound::Whole(3.0, 1e6),
            about: "radial threads",
        },
        OptionInfo { name: "radius", unit: "m", default: &[10.0], bound: Bound::Positive, about: "of the rim" },
        OptionInfo { name: "mass", unit: "kg", default: &[1.0], bound: Bound::Positive, about: "of each free mass" },
        OptionInfo {
            name: "displacement",
            unit: "m",
            default: &[0.5],
            bound: Bound::NotNegative,
            about: "standard deviation of each component of the displacement of the free masses",
        },
        OptionInfo {
            name: "stiffness",
            unit: "N/m",
            default: &[100.0],
            bound: Bound::NotNegative,
            about: "of a thread",
        },
        OptionInfo { name: "damping", unit: "N s/m", default: &[1.0], bound: Bound::NotNegative, about: "of a thread" },
        OptionInfo {
            name: "tension",
            unit: "",
            default: &[0.1],
            bound: Bound::Within(0.0, 1.0),
            about: "rest length is the distance in the undisplaced web times one minus this",
        },
    ],
    also_fills: &["springs"],
    make,
};

fn make(options: &Options) -> Result<Generated, GenerateFault> {
    let (n, spokes) = (options.whole("count"), options.whole("spokes"));
    if !n.is_multiple_of(spokes) || n / spokes < 2 {
        let text = format!("a web of {spokes} spokes has {spokes} masses in each of 2 or more rings, not {n} in all");
        return Err(GenerateFault::of_value("count", text));
    }
    let rings = n / spokes;
    let radius = options.number("radius");
    let undisplaced: Vec<[f64; 3]> = (0..n)
        .map(|row| {
            let angle = TAU * (row % spokes) as f64 / spokes as f64;
            let out = radius * (row / spokes + 1) as f64 / rings as f64;
            [out * angle.cos(), out * angle.sin(), 0.0]
        })
        .collect();
    let mut ends = Vec::new();
    for ring in 0..rings - 1 {
        for spoke in 0..spokes {
            ends.push([ring * spokes + spoke, ring * spokes + (spoke + 1) % spokes]);
            ends.push([ring * spokes + spoke, (ring + 1) * spokes + spoke]);
        }
    }
    let free = n - spokes;
    let mut deviates = options.deviates();
    let displacement = options.number("displacement");
    let mut position = undisplaced.clone();
    for place in &mut position[..free] {
        let by = deviates.normal_vector();
        (0..3).for_each(|axis| place[axis] += displacement * by[axis]);
    }
    let mut mass = vec![options.number("mass"); n];
    mass[free..].fill(0.0);
    let shorter = 1.0 - options.number("tension");
    let rest = ends.iter().map(|&[a, b]| shorter * distance(undisplaced[a], undisplaced[b])).collect();
    let mut generated = bodies(options.domain, mass, &position, &vec![[0.0; 3]; n]);
    let springs = vec![
        link("ends", options.domain, &ends),
        scalar("stiffness", vec![options.number("stiffness"); ends.len()]),
        scalar("damping", vec![options.number("damping"); ends.len()]),
        scalar("rest_length", rest),
    ];
    generated.domains.push(("springs".to_owned(), springs));
    Ok(generated)
}
