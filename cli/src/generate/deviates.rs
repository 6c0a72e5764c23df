//! Random numbers of our own, so that a seed means the same scene with every version of every crate.
//!
//! In: a seed. Out: deviates, uniform, on the sphere, normal. Never: fit for secrets.

/// The generator SplitMix64 of Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014,
/// doi:10.1145/2660193.2660195. It has 64 bits of state and a period of 2^64, and passes BigCrush: enough for starting
/// data. Uniform numbers, directions and points are made of + * / and square roots, which are the same bits on every
/// machine; normal numbers and powers also need logarithms, whose last bit may differ between mathematical libraries.
#[derive(Clone, Debug)]
pub struct SplitMix64 {
    state: u64,
    spare: Option<f64>,
}

impl SplitMix64 {
    /// A generator with `seed`; neighbouring seeds give unrelated numbers.
    pub const fn new(seed: u64) -> Self {
        Self { state: seed, spare: None }
    }

    /// 64 random bits.
    pub const fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform, 0 <= u < 1, in steps of 2^-53.
    pub const fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// Uniform, low <= u < high.
    pub const fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// A point inside the unit circle, not its centre, and its distance from the centre squared.
    fn disc(&mut self) -> (f64, f64, f64) {
        loop {
            let (x, y) = (self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            let square = x * x + y * y;
            if square > 0.0 && square < 1.0 {
                return (x, y, square);
            }
        }
    }

    /// A point on the unit circle.
    pub fn circle(&mut self) -> [f64; 2] {
        let (x, y, square) = self.disc();
        let length = square.sqrt();
        [x / length, y / length]
    }

    /// A point on the unit sphere: Marsaglia, "Choosing a point from the surface of a sphere", 1972,
    /// doi:10.1214/aoms/1177692644.
    pub fn sphere(&mut self) -> [f64; 3] {
        let (x, y, square) = self.disc();
        let scale = 2.0 * (1.0 - square).sqrt();
        [x * scale, y * scale, 1.0 - 2.0 * square]
    }

    /// Normal, mean 0, standard deviation 1: the polar method of Marsaglia and Bray, 1964, doi:10.1137/1006063.
    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let (x, y, square) = self.disc();
        let scale = (-2.0 * square.ln() / square).sqrt();
        self.spare = Some(y * scale);
        x * scale
    }

    /// Three normal numbers.
    pub fn normal_vector(&mut self) -> [f64; 3] {
        [self.normal(), self.normal(), self.normal()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_sequence() {
        let mut deviates = SplitMix64::new(1_234_567);
        let drawn: Vec<u64> = (0..3).map(|_| deviates.bits()).collect();
        assert_eq!(drawn, [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]);
    }

    #[test]
    fn moments() {
        let mut deviates = SplitMix64::new(1);
        let n = 100_000;
        let (mut mean, mut square, mut fourth, mut z) = (0.0, 0.0, 0.0, 0.0);
        for _ in 0..n {
            let x = deviates.normal();
            mean += x / n as f64;
            square += x * x / n as f64;
            fourth += x * x * x * x / n as f64;
            let direction = deviates.sphere();
            assert!((direction.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12);
            z += direction[2] * direction[2] / n as f64;
        }
        // Four standard errors of each.
        assert!(mean.abs() < 0.013 && (square - 1.0).abs() < 0.018 && (fourth - 3.0).abs() < 0.13);
        assert!((z - 1.0 / 3.0).abs() < 0.004);
    }
}
