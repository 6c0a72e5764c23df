//! What laws run on: instruction set, threads, a graphics processor.
//!
//! In: what a builder was told. Out: a [`Machine`], or faults. Never: a law that runs.

use crate::error::Fault;
use crate::pipeline::Machine;
use crate::real::Isa;
use std::sync::Arc;
#[cfg(feature = "gpu")]
use {crate::backend::gpu::Device, crate::pipeline::Listed, crate::real::Scalar, crate::registry::Backend};

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
            #[cfg(feature = "gpu")]
            device: None,
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
        #[cfg(feature = "gpu")]
        device: None,
        threads: 1,
        probe: None,
        stop: None,
    }
}

/// The graphics processor, where a law asks for one.
#[cfg(feature = "gpu")]
pub(super) fn device<P: Scalar>(laws: &[Listed<P>]) -> Option<Result<Arc<Device>, String>> {
    let asks = laws.iter().any(|law| law.entry.options.backend == Backend::Gpu);
    asks.then(|| {
        Device::open().map(Arc::new).map_err(|error| {
            log::warn!("{error}: its laws run on the host");
            error.to_string()
        })
    })
}

#[cfg(test)]
mod tests {
    #![cfg(feature = "gpu")]

    use crate::prelude::*;

    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(position: Position, velocity: Velocity), rates(velocity: Velocity, moves: Position))]
    struct Oscillation;

    #[kernel]
    impl<R: Real> RowLaw<R> for Oscillation {
        fn row(&self, row: OscillationRow<R>) -> OscillationOutput<R> {
            OscillationOutput { velocity: -row.position, moves: row.velocity }
        }
    }

    fn engine(backend: Backend) -> Engine<f32> {
        let places: Vec<DVec3> = (0..300).map(|row| DVec3::new(f64::from(row), 1.0, -0.25)).collect();
        let rows = Domain::new("rows").rows(300).with(Position, places).with(Velocity, vec![DVec3::Z; 300]);
        let builder = Engine::<f32>::builder().domain(rows).law(Oscillation.backend(backend));
        builder.integrator(SemiImplicitEuler).step(0.125).build().unwrap()
    }

    #[test]
    fn a_device_that_is_lost_changes_no_result() {
        let mut here = engine(Backend::Cpu);
        let mut there = engine(Backend::Gpu);
        if there.backends() != [Some(Backend::Gpu)] {
            let required = std::env::var("VESPER_REQUIRE_GPU").is_ok_and(|required| required == "1");
            assert!(!required, "{}", there.explain());
            return eprintln!("not run: {}", there.explain());
        }
        here.steps_of(4, 0.125).unwrap();
        there.steps_of(4, 0.125).unwrap();
        assert_eq!(here.state().hash(), there.state().hash());
        there.machine.device.as_ref().unwrap().as_ref().unwrap().destroy();
        here.steps_of(4, 0.125).unwrap();
        there.steps_of(4, 0.125).unwrap();
        assert_eq!(here.state().hash(), there.state().hash());
    }
}
