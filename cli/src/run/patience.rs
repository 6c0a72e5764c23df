//! How long somebody waits for a run.
//!
//! In: a limit, a flag, work that looks at a flag of its own. Out: that flag set once either is reached. Never: work that is cut off:
//! it comes back by itself.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// When to give up.
#[derive(Clone, Debug, Default)]
pub struct Patience {
    /// Time that a run may take, in s.
    pub limit: f64,
    /// Once it is true, runs end.
    pub stop: Arc<AtomicBool>,
}

/// Does the work while somebody looks at the clock, and sets the flag once it is time to come back.
pub fn watched<T>(patience: &Patience, stop: &AtomicBool, work: impl FnOnce() -> T) -> T {
    std::thread::scope(|scope| {
        let (done, waits) = channel::<()>();
        scope.spawn(move || {
            let end = Instant::now() + Duration::from_secs_f64(patience.limit.clamp(1e-3, 1e9));
            while waits.recv_timeout(Duration::from_millis(20)) == Err(RecvTimeoutError::Timeout) {
                if Instant::now() > end || patience.stop.load(Ordering::Relaxed) {
                    stop.store(true, Ordering::Relaxed);
                }
            }
        });
        let result = work();
        drop(done);
        result
    })
}
