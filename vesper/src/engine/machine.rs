//! What laws run on: instruction set, threads, a graphics processor.
//!
//! In: what a builder was told. Out: a [`Machine`], or faults. Never: a law that runs.

use crate::error::Fault;
use crate::pipeline::{Machine, Opened};
use crate::real::Isa;
use std::sync::Arc;

/// Threads that a pool may have: to start more takes seconds, and no machine has as many cores.
const MOST_THREADS: usize = 1024;

pub(super) fn machine(threads: Option<usize>, isa: Option<Isa>, faults: &mut Vec<Fault>) -> Machine {
    let isa = isa.unwrap_or_else(Isa::detect);
    if let Some(given) = threads.filter(|given| !(1..=MOST_THREADS).contains(given)) {
        faults.push(Fault::Threads { given, most: MOST_THREADS });
    }
    #[cfg(feature = "parallel")]
    {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        // The thread that calls is one of them.
        let pool = threads.filter(|count| (2..=MOST_THREADS).contains(count)).and_then(|count| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(count - 1).build();
            pool.map_err(|error| faults.push(Fault::ThreadPool { reason: error.to_string() })).ok()
        });
        let (threads, pool) = (threads.unwrap_or_else(cores), pool.map(Arc::new));
        Machine {
            isa,
            estimates: true,
            fits: Arc::default(),
            device: Opened::default(),
            threads,
            pool,
            probe: None,
            stop: None,
        }
    }
    #[cfg(not(feature = "parallel"))]
    Machine {
        isa,
        estimates: true,
        fits: Arc::default(),
        device: Opened::default(),
        threads: 1,
        probe: None,
        stop: None,
    }
}
