//! Several ways to do the same work, timed in turns.
//!
//! Turns, because a shared machine is slow for seconds at a time: each round times every contender once, each first in
//! turn, and a contender's time is the median of its rounds. Short ones, because a turn that another process interrupts
//! counts for nothing: most must fit into the time that a process is given at once.

use criterion::{Criterion, Throughput};
use std::time::{Duration, Instant};

/// How this process was started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Run {
    /// Everything once, no times.
    Test,
    /// Times.
    Measure,
    /// Nothing but the names of what would run.
    List,
}

/// Words of the command line that no value follows.
const FLAGS: [&str; 12] = [
    "--bench",
    "--test",
    "--list",
    "--exact",
    "--verbose",
    "--quiet",
    "--quick",
    "--noplot",
    "--ignored",
    "--nocapture",
    "--show-output",
    "--discard-baseline",
];

impl Run {
    /// Reads the command line as criterion does: without `--bench`, or with `--test`, nothing is timed.
    pub fn from_arguments() -> Run {
        let arguments: Vec<String> = std::env::args().collect();
        let has = |word: &str| arguments.iter().any(|argument| argument == word);
        match (has("--list"), has("--bench") && !has("--test")) {
            (true, _) => Run::List,
            (false, true) => Run::Measure,
            (false, false) => Run::Test,
        }
    }

    /// Whether a piece of work of this name is to run: the free words of the command line are parts of names.
    pub fn wants(self, name: &str) -> bool {
        let words = words();
        self != Run::List && (words.is_empty() || words.iter().any(|word| name.contains(word.as_str())))
    }

    /// Whether all work is to run: the command line has no free words.
    pub fn is_whole() -> bool {
        words().is_empty()
    }
}

/// The free words of the command line.
fn words() -> Vec<String> {
    let mut words = Vec::new();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        if !argument.starts_with('-') {
            words.push(argument);
        } else if argument.starts_with("--") && !argument.contains('=') && !FLAGS.contains(&argument.as_str()) {
            arguments.next();
        }
    }
    words
}

/// Criterion with short times: its lines are for comparing runs, the summary's for comparing peers.
pub fn criterion() -> Criterion {
    Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_millis(400))
        .configure_from_args()
}

/// One way to do the work.
pub struct Contender<'a> {
    name: &'static str,
    work: Box<dyn FnMut() + 'a>,
}

impl<'a> Contender<'a> {
    /// `work` does one piece of work when it is called.
    pub fn new(name: &'static str, work: impl FnMut() + 'a) -> Self {
        Contender { name, work: Box::new(work) }
    }
}

impl core::fmt::Debug for Contender<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_tuple("Contender").field(&self.name).finish()
    }
}

/// Time of a contender, in ns per unit of work.
#[derive(Clone, Copy, Debug)]
pub struct Time {
    /// Of whom.
    pub name: &'static str,
    /// Half of the rounds were faster.
    pub median: f64,
    /// A quarter of the rounds were faster.
    pub low: f64,
    /// A quarter of the rounds were slower.
    pub high: f64,
}

/// How long and how often.
#[derive(Clone, Copy, Debug)]
pub struct Race {
    /// Rounds: each times every contender once. Long ones end after 10 s.
    pub rounds: usize,
    /// Length of one timed turn.
    pub turn: Duration,
}

impl Default for Race {
    fn default() -> Self {
        Race { rounds: 301, turn: Duration::from_micros(250) }
    }
}

impl Race {
    /// Runs the race. One call of a contender's work is `units` units.
    pub fn run(self, run: Run, units: f64, contenders: &mut [Contender<'_>]) -> Vec<Time> {
        let repeats: Vec<u32> = contenders.iter_mut().map(|contender| self.calibrate(run, contender)).collect();
        let short: Vec<bool> =
            contenders.iter_mut().map(|contender| run == Run::Measure && self.is_short(contender)).collect();
        let rounds = if run == Run::Test { 1 } else { self.rounds };
        let (limit, begin_all) = (Duration::from_secs(10), Instant::now());
        let mut times = vec![Vec::with_capacity(rounds); contenders.len()];
        for round in 0..rounds {
            if round >= 21 && begin_all.elapsed() > limit {
                break;
            }
            for turn in 0..contenders.len() {
                let at = (round + turn) % contenders.len();
                if short[at] {
                    (contenders[at].work)();
                }
                let begin = Instant::now();
                for _ in 0..repeats[at] {
                    (contenders[at].work)();
                }
                times[at].push(begin.elapsed().as_nanos() as f64 / f64::from(repeats[at]) / units);
            }
        }
        let quartiles = contenders.iter().zip(times).map(|(contender, mut times)| {
            times.sort_by(f64::total_cmp);
            let at = |quarters: usize| times[(times.len() - 1) * quarters / 4];
            Time { name: contender.name, median: at(2), low: at(1), high: at(3) }
        });
        quartiles.collect()
    }

    /// The standard lines of the same contenders.
    pub fn lines(criterion: &mut Criterion, group: &str, units: f64, contenders: &mut [Contender<'_>]) {
        let mut group = criterion.benchmark_group(group);
        group.throughput(Throughput::Elements(units as u64));
        for contender in contenders {
            group.bench_function(contender.name, |bencher| bencher.iter(|| (contender.work)()));
        }
        group.finish();
    }

    /// Whether who had the turn before, with what it leaves in caches and of the processor's frequency, counts for the time of
    /// one piece of work: then one that is not timed comes first.
    fn is_short(self, contender: &mut Contender<'_>) -> bool {
        let begin = Instant::now();
        (contender.work)();
        begin.elapsed() < 10 * self.turn
    }

    /// How often the work fits into a turn.
    fn calibrate(self, run: Run, contender: &mut Contender<'_>) -> u32 {
        let mut repeats = 1_u32;
        loop {
            let begin = Instant::now();
            for _ in 0..repeats {
                (contender.work)();
            }
            let took = begin.elapsed();
            if run == Run::Test || took >= self.turn || repeats >= 1 << 28 {
                return repeats;
            }
            let fits = self.turn.as_secs_f64() / took.as_secs_f64().max(1e-9);
            // Short trials are unsure: go on by at most ten times.
            repeats = (f64::from(repeats) * fits.clamp(1.0, 10.0)).ceil() as u32;
            if fits < 1.5 {
                return repeats;
            }
        }
    }
}
