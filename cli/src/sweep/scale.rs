//! From numbers to places along an axis, with ticks.
//!
//! In: the numbers that are to be shown. Out: for each a place between 0 and 1, and marks with words. Never: a number that
//! is not finite.

use super::vary::{Spacing, Vary};
use crate::output::picture::{shortened, tick_label, tick_step};
use crate::output::rounded;

/// Numbers of one sign that differ by more than this factor are shown by their logarithms.
const WIDE: f64 = 300.0;
/// Labels along an axis, at most about so many.
const TICKS: usize = 8;

/// A linear or logarithmic scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    low: f64,
    high: f64,
    log: bool,
}

impl Scale {
    /// The scale on which `values` lie, with `room` at both ends as a part of it; none where there are no values.
    pub(super) fn of(values: &[f64], log: bool, room: f64) -> Option<Self> {
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let log = low > 0.0 && (log || high / low > WIDE);
        let (low, high) = if log { (low.log10(), high.log10()) } else { (low, high) };
        if !low.is_finite() || !high.is_finite() {
            return None;
        }
        // Values that are all the same stand in the middle. Halves, so that no difference is beyond all numbers.
        let half = match 0.5 * high - 0.5 * low {
            0.0 if log || low == 0.0 => 0.5,
            0.0 => 0.05 * low.abs(),
            half => half,
        };
        let middle = 0.5 * low + 0.5 * high;
        let half = half * (1.0 + 2.0 * room);
        Some(Self { low: middle - half, high: middle + half, log })
    }

    /// Where a number stands, from 0 to 1.
    pub(super) fn at(&self, value: f64) -> f64 {
        let value = if self.log { value.log10() } else { value };
        ((0.5 * value - 0.5 * self.low) / (0.5 * self.high - 0.5 * self.low)).clamp(0.0, 1.0)
    }

    /// Places of round numbers, with their labels.
    pub(super) fn ticks(&self) -> Vec<(f64, String)> {
        if self.log {
            let factors: &[f64] = if self.high - self.low < 2.0 { &[1.0, 2.0, 5.0] } else { &[1.0] };
            let every = ((self.high - self.low) as usize / TICKS + 1).max(1);
            let powers = (self.low.floor() as i32..=self.high.ceil() as i32).step_by(every);
            let numbers = powers.flat_map(|power| factors.iter().map(move |factor| factor * 10f64.powi(power)));
            let within = numbers.filter(|number| (self.low..=self.high).contains(&number.log10()));
            let ticks: Vec<(f64, String)> =
                within.map(|value| (self.at(value), rounded(value, 3).to_string())).collect();
            if ticks.len() > 1 {
                return ticks;
            }
        }
        let [low, high] =
            if self.log { [self.low, self.high].map(|power| 10f64.powf(power)) } else { [self.low, self.high] };
        let step = tick_step((high - low) / (TICKS - 2) as f64);
        if !step.is_normal() {
            return Vec::new();
        }
        let first = (low / step).ceil();
        // Of numbers that are nearly the same, a step may be less than their last digit: then there are only so many.
        let numbers = (0..2 * TICKS).map(|count| (first + count as f64) * step).take_while(|value| *value <= high);
        numbers.map(|value| (self.at(value), tick_label(value, step))).collect()
    }
}

/// An axis of what varies.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    /// What varies.
    pub(super) name: String,
    /// Where each of its values stands, from 0 to 1.
    pub(super) places: Vec<f64>,
    /// Marks, with words.
    pub(super) ticks: Vec<(f64, String)>,
}

impl Axis {
    /// Numbers by their size; words one after the other.
    pub(super) fn by_size(vary: &Vary) -> Self {
        let numbers = vary.numbers();
        let scale = numbers.as_ref().and_then(|numbers| Scale::of(numbers, vary.spacing == Spacing::Log, 0.02));
        match (numbers, scale) {
            (Some(numbers), Some(scale)) => Self {
                name: vary.path.clone(),
                places: numbers.iter().map(|value| scale.at(*value)).collect(),
                ticks: scale.ticks(),
            },
            _ => Self::in_order(vary),
        }
    }

    /// One after the other, at equal distances.
    pub(super) fn in_order(vary: &Vary) -> Self {
        let count = vary.values.len();
        let places: Vec<f64> = (0..count).map(|index| (index as f64 + 0.5) / count as f64).collect();
        let every = count.div_ceil(TICKS).max(1);
        let ticks =
            places.iter().zip(&vary.values).step_by(every).map(|(place, value)| (*place, label(value))).collect();
        Self { name: vary.path.clone(), places, ticks }
    }
}

/// A value in a few letters.
pub(super) fn label(value: &str) -> String {
    value
        .parse()
        .ok()
        .filter(|number: &f64| number.is_finite())
        .map_or_else(|| shortened(value), |number| rounded(number, 4).to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_find_their_places() {
        let even = Scale::of(&[0.0, 1.0, 4.0], false, 0.0).unwrap();
        assert_eq!([0.0, 1.0, 4.0].map(|value| even.at(value)), [0.0, 0.25, 1.0]);
        let wide = Scale::of(&[1e-3, 1.0, 1e3], false, 0.0).unwrap();
        assert!((wide.at(1.0) - 0.5).abs() < 1e-12);
        let labels: Vec<String> = wide.ticks().into_iter().map(|(_, label)| label).collect();
        assert_eq!(labels, ["0.001", "0.01", "0.1", "1", "10", "100", "1000"]);
        assert_eq!(Scale::of(&[5.0], false, 0.1).unwrap().at(5.0), 0.5);
        assert_eq!(Scale::of(&[], false, 0.1), None);
    }

    #[test]
    fn any_numbers_have_few_ticks() {
        let extremes = [-f64::MAX, f64::MAX, 0.0, f64::MIN_POSITIVE, 5e-324, 1.0, 1.0 + f64::EPSILON, -1e-9, 1e17];
        for a in extremes {
            for b in extremes {
                let scale = Scale::of(&[a, b], false, 0.05).unwrap_or(Scale { low: 0.0, high: 1.0, log: false });
                let ticks = scale.ticks();
                assert!(ticks.len() <= 24 && ticks.iter().all(|(place, _)| (0.0..=1.0).contains(place)), "{a} {b}");
            }
        }
    }
}
