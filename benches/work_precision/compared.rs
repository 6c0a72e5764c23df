//! Times and errors of one method by its settings. In: runs. Out: the time to an error, between the settings that were run.

/// A method's settings, and what came of them.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Its name.
    pub name: String,
    /// For each setting: the error, and the time of every run, in s.
    pub points: Vec<(f64, Vec<f64>)>,
}

impl Curve {
    /// The times of another round.
    pub fn add(&mut self, other: Curve) {
        for (known, new) in self.points.iter_mut().zip(other.points) {
            known.1.extend(new.1);
        }
    }

    /// How often every setting was run.
    fn turns(&self) -> usize {
        self.points.iter().map(|(_, times)| times.len()).min().unwrap_or(0)
    }

    /// The time to an error in one turn, in s: between the cheapest setting that meets it and the one before, on a straight line
    /// of logarithms. `None` where no setting meets it, or the coarsest one does by far.
    fn time_to(&self, error: f64, turn: usize) -> Option<f64> {
        let mut points: Vec<(f64, f64)> = self.points.iter().map(|(error, times)| (*error, times[turn])).collect();
        points.retain(|point| point.0.is_finite());
        points.sort_by(|one, other| one.1.total_cmp(&other.1));
        // What costs more and is no nearer is no choice.
        let mut best = f64::INFINITY;
        points.retain(|point| {
            let better = point.0 < best;
            best = best.min(point.0);
            better
        });
        let at = points.iter().position(|point| point.0 <= error)?;
        if at == 0 {
            return (points[0].0 > 0.1 * error).then_some(points[0].1);
        }
        let (coarse, fine) = (points[at - 1], points[at]);
        let share = (coarse.0 / error).ln() / (coarse.0 / fine.0).ln();
        Some(coarse.1 * (fine.1 / coarse.1).powf(share))
    }
}

fn median(times: &[f64]) -> f64 {
    let mut times = times.to_vec();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Times to an error.
#[derive(Clone, Copy, Debug)]
pub struct Ratio {
    /// Ours, the median of all turns, in s.
    pub ours: f64,
    /// Theirs.
    pub theirs: f64,
    /// Ours by theirs, turn by turn: the least, the median, the largest.
    pub by: [f64; 3],
}

/// The times to an error, and their ratio, turn by turn: what slows the machine slows both. Turns in which noise made one of them
/// skip it do not count. `None` where one of them does not come to it.
pub fn ratio(ours: &Curve, theirs: &Curve, error: f64) -> Option<Ratio> {
    let turns = 0..ours.turns().min(theirs.turns());
    let pairs: Vec<[f64; 2]> =
        turns.filter_map(|turn| Some([ours.time_to(error, turn)?, theirs.time_to(error, turn)?])).collect();
    if pairs.is_empty() {
        return None;
    }
    let all = |of: fn(&[f64; 2]) -> f64| pairs.iter().map(of).collect::<Vec<f64>>();
    let by = all(|[own, peer]| own / peer);
    let [least, most] = [f64::min, f64::max].map(|pick| by.iter().copied().reduce(pick).unwrap_or(f64::NAN));
    let [ours, theirs] = [all(|pair| pair[0]), all(|pair| pair[1])].map(|times| median(&times));
    Some(Ratio { ours, theirs, by: [least, median(&by), most] })
}
