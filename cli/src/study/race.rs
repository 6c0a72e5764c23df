//! Times of several methods, taken by turns.
//!
//! In: a problem, methods that come to its end. Out: their times. Never: a time of one method from another minute than that
//! of the others: a shared machine is fast in one and slow in the next.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::measure::{Method, Patience, Went};
use super::problem::Problem;

/// Rounds at least and at most.
const ROUNDS: [usize; 2] = [3, 301];

/// The median time of each method, the shortest and the longest, in s. In each round each runs once, each first in turn;
/// there are rounds for `length` s, but at least three.
///
/// # Errors
/// In words, why one of them does not come to the end.
pub fn race(problem: &Problem, methods: &[Method], patience: &Patience, length: f64) -> Result<Vec<[f64; 3]>, String> {
    let end = Instant::now() + Duration::from_secs_f64(length.clamp(0.0, 1e9));
    let [least, most] = ROUNDS;
    let mut walls = vec![Vec::new(); methods.len()];
    for round in 0..most {
        if round >= least && Instant::now() > end {
            break;
        }
        for turn in 0..methods.len() {
            let at = (round + turn) % methods.len();
            if patience.stop.load(Ordering::Relaxed) {
                return Err("stopped".to_owned());
            }
            let Went { wall, broke, .. } = methods[at].go(problem, patience, false)?;
            match broke {
                Some(reason) => return Err(reason),
                None => walls[at].push(wall),
            }
        }
    }
    let times = walls.into_iter().map(|mut walls: Vec<f64>| {
        walls.sort_by(f64::total_cmp);
        [walls[walls.len() / 2], walls[0], walls[walls.len() - 1]]
    });
    Ok(times.collect())
}
