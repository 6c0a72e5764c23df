//! Bodies anywhere in a box, evenly.

use super::{Bound, GenerateFault, Generated, Kind, OptionInfo, Options, SEED, bodies, count, thermal};

pub(super) const KIND: Kind = Kind {
    name: "random",
    about: "bodies evenly at random in a box",
    options: &[
        count(&[1000.0], 1.0, "number of bodies"),
        SEED,
        OptionInfo { name: "mass", unit: "kg", default: &[1.0], bound: Bound::NotNegative, about: "of each body" },
        OptionInfo { name: "centre", unit: "m", default: &[0.0; 3], bound: Bound::Any, about: "middle of the box" },
        OptionInfo { name: "size", unit: "m", default: &[1.0; 3], bound: Bound::NotNegative, about: "its edges" },
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
    let (middle, size, speed) = (options.vector("centre"), options.vector("size"), options.number("speed"));
    let mut deviates = options.deviates();
    let position: Vec<[f64; 3]> =
        (0..n).map(|_| [0, 1, 2].map(|axis| middle[axis] + size[axis] * deviates.between(-0.5, 0.5))).collect();
    let velocity = thermal(n, speed, &mut deviates);
    let mass = vec![options.number("mass"); n];
    Ok(bodies(options.domain, mass, &position, &velocity))
}
