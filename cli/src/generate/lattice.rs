//! A simple cubic lattice around the origin.
//!
//! The side is the smallest whole number whose cube holds all rows; where `count` is no cube, the last layer has gaps.

use super::{Bound, GenerateFault, Generated, Kind, OptionInfo, Options, SEED, bodies, count, thermal};

pub(super) const KIND: Kind = Kind {
    name: "lattice",
    about: "simple cubic lattice around the origin, shaken if asked for",
    options: &[
        count(&[1000.0], 1.0, "number of bodies; the side is its cube root, rounded up"),
        SEED,
        OptionInfo { name: "mass", unit: "kg", default: &[1.0], bound: Bound::NotNegative, about: "of each body" },
        OptionInfo { name: "spacing", unit: "m", default: &[1.0], bound: Bound::Positive, about: "between neighbours" },
        OptionInfo {
            name: "jitter",
            unit: "m",
            default: &[0.0],
            bound: Bound::NotNegative,
            about: "largest displacement in each axis",
        },
        OptionInfo {
            name: "speed",
            unit: "m/s",
            default: &[0.0],
            bound: Bound::NotNegative,
            about: "standard deviation of each component of the velocity; momentum is zero",
        },
    ],
    also_fills: &[],
    make,
};

fn make(options: &Options) -> Result<Generated, GenerateFault> {
    let n = options.whole("count");
    let side = (1..).find(|side: &usize| side * side * side >= n).unwrap_or(1);
    let (spacing, jitter, speed) = (options.number("spacing"), options.number("jitter"), options.number("speed"));
    let mut deviates = options.deviates();
    let middle = (side - 1) as f64 / 2.0;
    let position: Vec<[f64; 3]> = (0..n)
        .map(|row| {
            let place = [row % side, row / side % side, row / side / side];
            place.map(|index| (index as f64 - middle) * spacing + jitter * deviates.between(-1.0, 1.0))
        })
        .collect();
    let velocity = thermal(n, speed, &mut deviates);
    let mass = vec![options.number("mass"); n];
    Ok(bodies(options.domain, mass, &position, &velocity))
}
