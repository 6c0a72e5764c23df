//! Times of several methods, taken by turns.
//!
//! In: a problem, methods that come to its end. Out: their times. Never: a time of one method from another minute than that
//! of the others: a shared machine is fast in one and slow in the next.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::measure::{Method, Patience, Went};
use super::problem::Problem;

/// Rounds at most.
const ROUNDS: usize = 301;

/// The median time of each method, the shortest and the longest, in s. In each round each runs once, each first in turn;
/// no round begins after `length` s, but for the first.
///
/// # Errors
/// In words, why one of them does not come to the end.
pub fn race(problem: &Problem, methods: &[Method], patience: &Patience, length: f64) -> Result<Vec<[f64; 3]>, String> {
    // A length that is no number is none.
    let end = Instant::now() + Duration::try_from_secs_f64(length.clamp(0.0, 1e9)).unwrap_or_default();
    let mut walls = vec![Vec::new(); methods.len()];
    for round in 0..ROUNDS {
        if round > 0 && Instant::now() > end {
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use vesper::prelude::Backend;

    use super::*;
    use crate::assemble::integrators::integrator;
    use crate::scene::Precision as Numbers;
    use crate::study::Setting;
    use crate::study::problem::tests::a_case;

    fn method(name: &str, setting: Setting) -> Method {
        let integrator = integrator(name).unwrap();
        Method { integrator, setting, numbers: Numbers::F64, compensated: false, backend: Backend::Auto }
    }

    #[test]
    fn each_of_a_race_has_times_of_its_own() {
        let problem = a_case("kepler_e0.9");
        let [few, many] = [1e3, 4.0].map(|parts| problem.length() / parts).map(Setting::Step);
        let methods = [method("runge_kutta_4", few), method("runge_kutta_4", many)];
        let patience = Patience { limit: 10.0, ..Patience::default() };
        let [slow, fast] = race(&problem, &methods, &patience, 0.05).unwrap()[..] else { panic!("two of two") };
        for [median, shortest, longest] in [slow, fast] {
            assert!(0.0 < shortest && shortest <= median && median <= longest, "{shortest} {median} {longest}");
        }
        // One round is made where there is no time.
        for length in [0.0, f64::NAN] {
            let [only] = race(&problem, &methods[..1], &patience, length).unwrap()[..] else { panic!("one of one") };
            assert!(only[0] == only[1] && only[1] == only[2], "{only:?}");
        }
    }

    #[test]
    fn a_race_without_all_of_its_methods_has_no_times() {
        let problem = a_case("kepler_e0.9");
        let good = method("dormand_prince_8", Setting::Tolerance(1e-3));
        let stopped = Patience { limit: 10.0, stop: Arc::new(AtomicBool::new(true)) };
        assert_eq!(race(&problem, &[good], &stopped, 0.0), Err("stopped".to_owned()));
        let patience = Patience { limit: 10.0, ..Patience::default() };
        let never = method("dormand_prince_8", Setting::Tolerance(f64::NAN));
        assert!(race(&problem, &[good, never], &patience, 0.0).is_err());
    }
}
