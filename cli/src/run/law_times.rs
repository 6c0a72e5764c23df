//! How long laws take.
//!
//! In: a clock. Out: each law's share of a sample of the run, and so of all of it. Never: more than a few hundredths of
//! the run are watched: two looks at a clock cost as much as a small law does. What the looks take is taken off again,
//! as well as that can be known; the shares of laws that take less than a look are rough.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use vesper::pipeline::Probe;

/// Sums of what laws took while they were watched.
#[derive(Debug)]
pub struct LawTimes {
    origin: Instant,
    nanoseconds: Vec<AtomicU64>,
    calls: AtomicU64,
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
        Self { origin, nanoseconds: (0..laws).map(|_| AtomicU64::new(0)).collect(), calls: AtomicU64::new(0), look }
    }

    /// Seconds of each law in a run of `wall`, of which `watched` was watched.
    pub fn seconds(&self, wall: Duration, watched: Duration) -> Vec<f64> {
        let laws = self.nanoseconds.iter().map(|law| Duration::from_nanos(law.load(Ordering::Relaxed)).as_secs_f64());
        let looking = Duration::from_nanos(self.calls.load(Ordering::Relaxed).saturating_mul(2 * self.look));
        // Laws on several threads may take more than the time that passes; laws in turn never do.
        let watched = watched.saturating_sub(looking).as_secs_f64().max(0.5 * watched.as_secs_f64());
        let scale = if watched > 0.0 { wall.as_secs_f64() / watched } else { 0.0 };
        laws.map(|seconds| seconds * scale).collect()
    }
}

impl Probe for LawTimes {
    fn now(&self) -> u64 {
        self.origin.elapsed().as_nanos() as u64
    }

    fn ran(&self, law: usize, from: u64) {
        self.calls.fetch_add(1, Ordering::Relaxed);
        let took = self.now().saturating_sub(from).saturating_sub(self.look);
        if let Some(sum) = self.nanoseconds.get(law) {
            sum.fetch_add(took, Ordering::Relaxed);
        }
    }
}
