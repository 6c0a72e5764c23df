//! Makes runs of a sweep, some at the same time.
//!
//! In: a plan, numbers of runs, how many threads, for how long. Out: a [`Record`] of each run that came to an end, good or bad, in
//! whatever order they end. Never: a run that somebody stopped, whose numbers are of no moment that was asked for; a record of a
//! run that came to its end which depends on how many are made at the same time.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

use vesper::prelude::DoubleDouble;
use vesper_laws::catalog::CatalogPrecision;

use super::plan::Plan;
use super::record::Record;
use crate::run::patience::{Patience, watched};
use crate::run::{Ready, Request};
use crate::scene::{Precision, Scene};

/// How runs are made.
#[derive(Clone, Debug)]
pub struct How {
    /// So many at the same time.
    pub jobs: usize,
    /// Time that one run may take, in s; one that takes longer has failed.
    pub limit: Option<f64>,
    /// Once it is true, no run begins, and those on their way are given up.
    pub stop: Arc<AtomicBool>,
}

/// A run that came to an end.
#[derive(Clone, Debug)]
pub struct Ended {
    /// What is kept of it.
    pub record: Record,
    /// Whether it was made here; somebody else made it if not.
    pub made: bool,
}

/// Tells the record of a run, if somebody has made it meanwhile; or why nobody can know.
pub type Known<'k> = dyn Fn(usize) -> Result<Option<Record>, String> + Sync + 'k;

/// Makes `runs`, but for those that are `known` when they would begin, and gives each to `ended`, on the calling thread.
pub fn make(plan: &Plan, runs: &[usize], how: &How, known: &Known<'_>, ended: impl FnMut(Result<Ended, String>)) {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    let work = |sender: &mpsc::Sender<Result<Ended, String>>| {
        let begins = |_: &&usize| !how.stop.load(Ordering::Relaxed);
        while let Some(run) = runs.get(next.fetch_add(1, Ordering::Relaxed)).filter(begins) {
            let ended = match known(*run) {
                Ok(Some(record)) => Ok(Ended { record, made: false }),
                Ok(None) => match record(plan, *run, how) {
                    Some(record) => Ok(Ended { record, made: true }),
                    None => break,
                },
                Err(why) => Err(why),
            };
            if sender.send(ended).is_err() {
                break;
            }
        }
    };
    thread::scope(|scope| {
        let threads = (0..how.jobs.min(runs.len())).filter(|_| {
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
fn record(plan: &Plan, run: usize, how: &How) -> Option<Record> {
    let scene = match plan.scene(run) {
        Ok(scene) => scene,
        Err(faults) => return Some(Record::refused(&plan.ensemble, run, &faults)),
    };
    match scene.engine.precision.as_ref().map_or(Precision::default(), |precision| precision.value) {
        Precision::F32 => went::<f32>(plan, run, &scene, how),
        Precision::F64 => went::<f64>(plan, run, &scene, how),
        Precision::DoubleDouble => went::<DoubleDouble>(plan, run, &scene, how),
    }
}

fn went<P: CatalogPrecision>(plan: &Plan, run: usize, scene: &Scene, how: &How) -> Option<Record> {
    let mut ready = match Ready::<P>::new(scene, None) {
        Ok(ready) => ready,
        Err(faults) => return Some(Record::refused(&plan.ensemble, run, &faults)),
    };
    // The flag of all runs where there is no limit, so that nobody need watch this one.
    let stop = if how.limit.is_some() { Arc::default() } else { how.stop.clone() };
    // Also inside of a frame, which may be all of the run.
    ready.engine.stop_on(Some(stop.clone()));
    let request = Request { stop: stop.clone(), ..Request::default() };
    let go = || ready.run(request, &mut |_, _| Ok(()));
    let outcome = match how.limit {
        Some(limit) => watched(&Patience { limit, stop: how.stop.clone() }, &stop, go),
        None => go(),
    };
    let whole = !outcome.interrupted && outcome.faults.is_empty();
    match how.limit {
        // What is wrong may be only that it was stopped.
        _ if !whole && how.stop.load(Ordering::Relaxed) => None,
        Some(limit) if !whole && stop.load(Ordering::Relaxed) => {
            Some(Record::given_up(&plan.ensemble, run, limit, &outcome))
        }
        _ => Some(Record::new(&plan.ensemble, run, scene, &outcome)),
    }
}
