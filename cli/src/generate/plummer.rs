//! A Plummer sphere in equilibrium: density (1 + r^2/a^2)^(-5/2), isotropic speeds.
//!
//! Drawn as by Aarseth, Henon and Wielen, "A comparison of numerical methods for the study of star cluster dynamics",
//! Astronomy and Astrophysics 37 (1974) 183. The outermost thousandth of the mass (beyond 38.7 a) is left out, as is
//! usual, or a few bodies would be very far away. The defaults have G M = a = 1, so that one time unit is 1 s; for the
//! customary G = M = a = 1 give `g = 1`, here and to the law.

use super::{Bound, GRAVITATION, GenerateFault, Generated, Kind, OptionInfo, Options, SEED, bodies, centre, count};

pub(super) const KIND: Kind = Kind {
    name: "plummer",
    about: "Plummer sphere of equal masses in equilibrium, at rest around the origin",
    options: &[
        count(&[1000.0], 1.0, "number of bodies"),
        SEED,
        GRAVITATION,
        OptionInfo { name: "mass", unit: "kg", default: &[], bound: Bound::Positive, about: "total mass; default 1/g" },
        OptionInfo { name: "radius", unit: "m", default: &[1.0], bound: Bound::Positive, about: "scale length a" },
    ],
    also_fills: &[],
    make,
};

fn make(options: &Options) -> Result<Generated, GenerateFault> {
    let n = options.whole("count");
    let g = options.number("g");
    let total = options.number_or("mass", 1.0 / g);
    let a = options.number("radius");
    let mut deviates = options.deviates();
    let (mut position, mut velocity) = (Vec::with_capacity(n), Vec::with_capacity(n));
    for _ in 0..n {
        // Mass inside r, as a share: u = (r^2 / (r^2 + a^2))^(3/2), solved for r. 1 - uniform is never 0.
        let u = 0.999 * (1.0 - deviates.uniform());
        let r = 1.0 / (u.powf(-2.0 / 3.0) - 1.0).sqrt();
        // Speed q in units of the escape speed has density q^2 (1 - q^2)^(7/2), which is below 0.1 everywhere.
        let q = loop {
            let q = deviates.uniform();
            let square = 1.0 - q * q;
            if 0.1 * deviates.uniform() < q * q * square * square * square * square.sqrt() {
                break q;
            }
        };
        // Escape speed: sqrt(2 G M) / (r^2 + a^2)^(1/4).
        let speed = q * (2.0 * g * total / a / (1.0 + r * r).sqrt()).sqrt();
        position.push(deviates.sphere().map(|x| x * r * a));
        velocity.push(deviates.sphere().map(|x| x * speed));
    }
    let mass = vec![total / n as f64; n];
    centre(&mass, &mut position);
    centre(&mass, &mut velocity);
    Ok(bodies(options.domain, mass, &position, &velocity))
}
