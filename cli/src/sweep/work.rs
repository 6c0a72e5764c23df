//! Makes runs of a sweep, some at the same time.
//!
//! In: a plan, numbers of runs, how many threads. Out: a [`Record`] of each run that came to an end, good or bad, in whatever
//! order they end. Never: a run that somebody stopped, whose numbers are of no moment that was asked for; a record that
//! depends on how many are made at the same time.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

use vesper::prelude::DoubleDouble;
use vesper_laws::catalog::CatalogPrecision;

use super::plan::Plan;
use super::record::Record;
use crate::run::{Ready, Request};
use crate::scene::{Precision, Scene};

/// Makes `runs` on `jobs` threads, and gives each record to `ended`, on the calling thread. Once `stop` is true, no run
/// begins, and those on their way are given up.
pub fn make(plan: &Plan, runs: &[usize], jobs: usize, stop: &Arc<AtomicBool>, ended: impl FnMut(Record)) {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    let work = |sender: &mpsc::Sender<Record>| {
        while let Some(run) = runs.get(next.fetch_add(1, Ordering::Relaxed)).filter(|_| !stop.load(Ordering::Relaxed)) {
            let Some(record) = record(plan, *run, stop) else { break };
            if sender.send(record).is_err() {
                break;
            }
        }
    };
    thread::scope(|scope| {
        let threads = (0..jobs.min(runs.len())).filter(|_| {
            let sender = sender.clone();
            thread::Builder::new().spawn_scoped(scope, move || work(&sender)).is_ok()
        });
        if threads.count() == 0 {
            // A machine that has no thread left has this one.
            work(&sender);
        }
        drop(sender);
        receiver.into_iter().for_each(ended);
    });
}

/// A run of a plan; none where somebody stopped it.
fn record(plan: &Plan, run: usize, stop: &Arc<AtomicBool>) -> Option<Record> {
    let scene = match plan.scene(run) {
        Ok(scene) => scene,
        Err(faults) => return Some(Record::refused(&plan.ensemble, run, &faults)),
    };
    match scene.engine.precision.as_ref().map_or(Precision::default(), |precision| precision.value) {
        Precision::F32 => went::<f32>(plan, run, &scene, stop),
        Precision::F64 => went::<f64>(plan, run, &scene, stop),
        Precision::DoubleDouble => went::<DoubleDouble>(plan, run, &scene, stop),
    }
}

fn went<P: CatalogPrecision>(plan: &Plan, run: usize, scene: &Scene, stop: &Arc<AtomicBool>) -> Option<Record> {
    let ready = match Ready::<P>::new(scene, None) {
        Ok(ready) => ready,
        Err(faults) => return Some(Record::refused(&plan.ensemble, run, &faults)),
    };
    let request = Request { stop: stop.clone(), ..Request::default() };
    let outcome = ready.run(request, &mut |_, _| Ok(()));
    let stopped = outcome.interrupted && outcome.faults.is_empty();
    (!stopped).then(|| Record::new(&plan.ensemble, run, scene, &outcome))
}
