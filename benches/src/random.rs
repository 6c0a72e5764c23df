//! Numbers that are the same on every machine.

/// SplitMix64 (Steele, Lea, Flood, OOPSLA 2014): one state word, every seed good.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The sequence of this seed.
    pub fn new(seed: u64) -> Self {
        Random(seed)
    }

    /// The next word.
    pub fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut word = self.0;
        word = (word ^ word >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        word = (word ^ word >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        word ^ word >> 31
    }

    /// The next number, `low <= number < high`. Rounded to f32, so that both precisions begin with the same values.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.word() >> 40) as f64 / (1_u64 << 24) as f64;
        f64::from((low + (high - low) * unit) as f32)
    }

    /// The next vector of such numbers.
    pub fn vector(&mut self, low: f64, high: f64) -> [f64; 3] {
        [self.between(low, high), self.between(low, high), self.between(low, high)]
    }

    /// The next vector of length 1, in any direction alike.
    pub fn direction(&mut self) -> [f64; 3] {
        loop {
            let towards = self.vector(-1.0, 1.0);
            let length = towards.iter().map(|x| x * x).sum::<f64>().sqrt();
            if (0.1..1.0).contains(&length) {
                return towards.map(|x| x / length);
            }
        }
    }
}
