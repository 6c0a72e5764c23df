//! How long laws take.
//!
//! In: a clock. Out: the time of each law, from a sample of the steps, scaled to all of them. Never: more than a few
//! hundredths of the run: two looks at a clock cost as much as a small law does.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use vesper::pipeline::Probe;

/// Sums of what laws took while they were watched.
#[derive(Debug)]
pub struct LawTimes {
    origin: Instant,
    nanoseconds: Vec<AtomicU64>,
    /// What a look at the clock takes, in ns.
    look: u64,
}

impl LawTimes {
    /// For this many laws.
    pub fn new(laws: usize) -> Self {
        let origin = Instant::now();
        const LOOKS: u32 = 1000;
        for _ in 0..LOOKS {
            std::hint::black_box(origin.elapsed());
        }
        let look = (origin.elapsed() / LOOKS).as_nanos() as u64;
        Self { origin, nanoseconds: (0..laws).map(|_| AtomicU64::new(0)).collect(), look }
    }

    /// Seconds of each law in all `steps`, of which `watched` were watched.
    pub fn seconds(&self, steps: u64, watched: u64) -> Vec<f64> {
        let scale = if watched == 0 { 0.0 } else { steps as f64 / watched as f64 };
        let seconds = |law: &AtomicU64| Duration::from_nanos(law.load(Ordering::Relaxed)).as_secs_f64() * scale;
        self.nanoseconds.iter().map(seconds).collect()
    }
}

impl Probe for LawTimes {
    fn now(&self) -> u64 {
        self.origin.elapsed().as_nanos() as u64
    }

    fn ran(&self, law: usize, from: u64) {
        let took = self.now().saturating_sub(from).saturating_sub(self.look);
        if let Some(sum) = self.nanoseconds.get(law) {
            sum.fetch_add(took, Ordering::Relaxed);
        }
    }
}
