//! The runs of a sweep: every combination of the values that vary, with a number and a key.
//!
//! In: what varies, what is measured, a shard. Out: numbers of runs, the values of each, its key. Never: a scene or a file.
//!
//! Runs count from 1. The last `--vary` changes from run to run, the one before it when the last has come to its end, and so
//! on, as the digits of a counter do.

use super::measure::Measure;
use super::vary::Vary;
use crate::fault::SceneFault;

/// More runs than this are more files than folders bear, and more likely a slip of the finger.
pub const MOST_RUNS: usize = 100_000;

/// All runs of a sweep.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ensemble {
    /// What the scene is.
    pub title: String,
    /// What varies.
    pub varies: Vec<Vary>,
    /// What is told of each run.
    pub measures: Vec<Measure>,
}

impl Ensemble {
    /// Number of runs, where it is not beyond all numbers.
    pub fn checked_runs(&self) -> Option<usize> {
        self.varies.iter().try_fold(1_usize, |runs, vary| runs.checked_mul(vary.values.len()))
    }

    /// Number of runs.
    pub fn runs(&self) -> usize {
        self.checked_runs().unwrap_or(usize::MAX)
    }

    /// Which value of each [`Vary`] a run has.
    pub fn indices(&self, run: usize) -> Vec<usize> {
        let mut rest = run.saturating_sub(1);
        let mut indices: Vec<usize> = Vec::with_capacity(self.varies.len());
        for vary in self.varies.iter().rev() {
            let many = vary.values.len().max(1);
            indices.push(rest % many);
            rest /= many;
        }
        indices.reverse();
        indices
    }

    /// The run that has these values, one for each [`Vary`].
    pub fn run(&self, indices: &[usize]) -> usize {
        let both = self.varies.iter().zip(indices);
        1 + both.fold(0, |number, (vary, index)| number * vary.values.len() + index)
    }

    /// Paths and values of a run.
    pub fn parameters(&self, run: usize) -> Vec<(&str, &str)> {
        self.varies
            .iter()
            .zip(self.indices(run))
            .filter_map(|(vary, index)| Some((vary.path.as_str(), vary.values.get(index)?.as_str())))
            .collect()
    }

    /// What tells a run from all others: its paths and values.
    pub fn key(&self, run: usize) -> String {
        let parts: Vec<String> = self.parameters(run).iter().map(|(path, value)| format!("{path}={value}")).collect();
        parts.join(" ")
    }
}

/// A share of the runs: of every so many one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which of them, from 1.
    pub number: usize,
    /// How many there are.
    pub of: usize,
}

/// All runs.
pub const WHOLE: Shard = Shard { number: 1, of: 1 };

impl Shard {
    /// Reads `K/N`.
    ///
    /// # Errors
    /// It is something else, or there is no such shard.
    pub fn read(argument: &str) -> Result<Self, SceneFault> {
        let wrong = |piece: &str, text: String, help: &str| {
            SceneFault::of_argument("--shard", argument, piece, text, Some(help.to_owned()))
        };
        let usual = "as in --shard 2/16, the second of sixteen";
        let Some((number, of)) = argument.split_once('/') else {
            return Err(wrong(argument, format!("expected K/N, found `{argument}`"), usual));
        };
        let count = |piece: &str| {
            let text = || format!("expected a whole number, found `{}`", piece.trim());
            piece.trim().parse::<usize>().map_err(|_| wrong(piece, text(), usual))
        };
        match (count(number)?, count(of)?) {
            (_, 0) => Err(wrong(of, "expected at least 1 shard".to_owned(), usual)),
            (0, of) => {
                let help = format!("the first is 1/{of}; of a Slurm array, --array=1-{of}");
                Err(wrong(number, "shards count from 1".to_owned(), &help))
            }
            (number, of) if number > of => {
                let text = format!("there is no shard {number} of {of}");
                Err(wrong(argument, text, &format!("shards count from 1 to {of}")))
            }
            (number, of) => Ok(Self { number, of }),
        }
    }

    /// The shard of `of` that makes `run`.
    pub fn making(run: usize, of: usize) -> usize {
        (run.max(1) - 1) % of.max(1) + 1
    }

    /// Its runs, of so many.
    pub fn runs(self, runs: usize) -> impl Iterator<Item = usize> {
        (self.number..=runs).step_by(self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn three_by_two() -> Ensemble {
        let varies = ["a=[1, 2, 3]", "b=[x, y]"].map(|argument| Vary::read(argument).unwrap());
        Ensemble { varies: varies.to_vec(), ..Ensemble::default() }
    }

    #[test]
    fn the_last_one_varies_fastest() {
        let all = three_by_two();
        let keys: Vec<String> = (1..=all.runs()).map(|run| all.key(run)).collect();
        assert_eq!(keys, ["a=1 b=x", "a=1 b=y", "a=2 b=x", "a=2 b=y", "a=3 b=x", "a=3 b=y"]);
        assert!((1..=all.runs()).all(|run| all.run(&all.indices(run)) == run));
    }

    #[test]
    fn shards_share_all_runs_out() {
        let of = |number| Shard { number, of: 4 }.runs(10).collect::<Vec<_>>();
        assert_eq!([of(1), of(2), of(3), of(4)], [vec![1, 5, 9], vec![2, 6, 10], vec![3, 7], vec![4, 8]]);
        assert!((1..=10).all(|run| of(Shard::making(run, 4)).contains(&run)));
        assert_eq!(Shard { number: 12, of: 16 }.runs(10).count(), 0);
    }

    #[test]
    fn wrong_shards_are_refused() {
        let told = |argument: &str| Shard::read(argument).expect_err(argument).text;
        assert_eq!(told("3"), "expected K/N, found `3`");
        assert_eq!(told("a/3"), "expected a whole number, found `a`");
        assert_eq!(told("1/0"), "expected at least 1 shard");
        assert_eq!(told("0/3"), "shards count from 1");
        assert_eq!(told("4/3"), "there is no shard 4 of 3");
        assert_eq!(Shard::read("3/3"), Ok(Shard { number: 3, of: 3 }));
    }
}
