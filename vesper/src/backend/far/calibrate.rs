//! The error of a far field, measured, and brought to what is requested.
//!
//! In: a scene. Out: an effort whose error is the requested one or less, and that error. Never: a random choice; a sum over all pairs for
//! more than a sample of rows.

use super::accuracy::{ALLOWED, Accuracy, Effort};
use super::fast::fused;
use super::frame::Frame;
use super::kernel::least_square;
use super::rows::{GROUP, store};
use super::{Far, PART, Parts};
use crate::real::{Isa, Lanes, Scalar, WithLanes};
use std::sync::{Mutex, PoisonError};

/// Rows that errors are measured for, fewest and most: some rows stand out, where their fields nearly cancel, and with 128 of them the
/// root of the mean square may be off by a factor of 1.5.
const SAMPLE: [usize; 2] = [384, 512];
/// Pairs of the sample and all rows, if that makes it neither smaller nor larger.
const PAIRS: usize = 20_000_000;
/// The error aimed at, in parts of the requested one, and how far below it may be.
const AIM: f64 = 0.75;
const ENOUGH: f64 = 0.62;
/// Measurements at most.
const TRIALS: usize = 8;
/// The error goes about with this power of what is allowed.
const POWER: f64 = 0.68;
/// The part of the sum of all magnitudes that an error is compared with, where the shares cancel to less.
const CANCELLED: f64 = 1e-3;

impl<P: Scalar> Far<P> {
    /// Measures the error of this scene, and chooses the effort so that it is the requested one; or less, where no effort has one so large;
    /// or what rounding leaves.
    pub(crate) fn calibrate(
        &mut self,
        isa: Isa,
        places: [&[P]; 3],
        strength: &[P],
        softening_squared: P,
        threads: &impl Parts,
    ) -> Accuracy {
        let requested = self.error;
        self.effort = Effort::first(requested);
        let nothing = Accuracy { measured: 0.0, largest: 0.0 };
        if strength.len() < 2 {
            return nothing;
        }
        let Some(frame) = self.prepare(places, strength, softening_squared, threads) else {
            return Accuracy { measured: f64::NAN, largest: f64::NAN };
        };
        let count = strength.len();
        let size = (PAIRS / count).clamp(SAMPLE[0], SAMPLE[1]).min(count);
        let sample: Vec<usize> = (0..size).map(|k| (2 * k + 1) * count / (2 * size)).collect();
        let exact = self.exact(isa, &frame, softening_squared, &sample, threads);
        // The most effort so far whose error was too large, and the least whose error was not.
        let mut below: Option<(f64, Accuracy)> = None;
        let mut above: Option<(f64, Accuracy)> = None;
        for _ in 0..TRIALS {
            let found = self.measure(isa, &frame, softening_squared, &sample, &exact, threads);
            let allowed = self.effort.allowed;
            if !found.measured.is_finite() {
                return found;
            }
            if found.measured <= requested {
                below = Some((allowed, found));
                if found.measured >= ENOUGH * requested || allowed >= ALLOWED[1] {
                    break;
                }
            } else {
                if below.is_none()
                    && let Some((larger, before)) = above
                    && larger > 3.0 * allowed
                    && before.measured < 1.3 * found.measured
                {
                    // More effort did not help: this is rounding.
                    self.effort.allowed = larger;
                    return before;
                }
                above = Some((allowed, found));
                if allowed <= ALLOWED[0] {
                    break;
                }
            }
            let ratio = AIM * requested / found.measured.max(1e-3 * requested);
            let mut next = allowed * ratio.powf(1.0 / POWER).clamp(1e-3, 1e3);
            // Between the two, on the way that the two suggest.
            if let (Some((low, of_low)), Some((high, of_high))) = (below, above) {
                let slope = (of_high.measured / of_low.measured).ln() / (high / low).ln();
                let guess = low * (AIM * requested / of_low.measured).powf(1.0 / slope.max(0.1));
                next = guess.clamp(low * (high / low).powf(0.2), low * (high / low).powf(0.8));
            }
            self.effort.allowed = next.clamp(ALLOWED[0], ALLOWED[1]);
        }
        let (allowed, found) = below.or(above).unwrap_or((self.effort.allowed, nothing));
        self.effort.allowed = allowed;
        found
    }

    /// Fields of the sample with the effort as it is, against exact ones.
    fn measure(
        &self,
        isa: Isa,
        frame: &Frame<P>,
        softening_squared: P,
        sample: &[usize],
        exact: &[[f64; 4]],
        threads: &impl Parts,
    ) -> Accuracy {
        let mut groups: Vec<u32> = sample.iter().map(|row| (row / GROUP) as u32).collect();
        groups.dedup();
        let call = self.call(frame, softening_squared);
        let lists: Vec<&[u32]> = groups.chunks(PART).collect();
        let found: Vec<_> = lists.iter().map(|_| Mutex::new(Vec::new())).collect();
        threads.run(lists.len(), &|part| {
            let size = lists[part].len() * GROUP;
            let mut all = vec![P::from_f64(0.0); 4 * size];
            let (fields, potential) = all.split_at_mut(3 * size);
            let (x, rest) = fields.split_at_mut(size);
            let (y, z) = rest.split_at_mut(size);
            call.sum::<false>(self.effort.degree, isa, lists[part], &mut [x, y, z, potential]);
            *found[part].lock().unwrap_or_else(PoisonError::into_inner) = all;
        });
        let found: Vec<Vec<P>> = found.into_iter().map(|part| part.into_inner().unwrap_or_default()).collect();
        let (mut sum, mut largest) = (0.0, 0f64);
        let mut at = 0;
        for (&row, exact) in sample.iter().zip(exact) {
            while groups[at] as usize != row / GROUP {
                at += 1;
            }
            let part = &found[at / PART];
            let size = part.len() / 4;
            let own = at % PART * GROUP + row % GROUP;
            let (mut error, mut length) = (0.0, 0.0);
            for axis in 0..3 {
                error += (part[axis * size + own].to_f64() - exact[axis]).powi(2);
                length += exact[axis] * exact[axis];
            }
            if error > 0.0 {
                let square = error / length.max((CANCELLED * exact[3]).powi(2));
                sum += square;
                largest = largest.max(square.sqrt());
            }
        }
        Accuracy { measured: (sum / sample.len() as f64).sqrt(), largest }
    }

    /// Fields of the sample, summed over all pairs in f64, and the sums of the magnitudes.
    fn exact(
        &self,
        isa: Isa,
        frame: &Frame<P>,
        softening_squared: P,
        sample: &[usize],
        threads: &impl Parts,
    ) -> Vec<[f64; 4]> {
        let rows = &self.tree.rows;
        let wide = |column: &[P]| column[..rows.count()].iter().map(|number| number.to_f64()).collect::<Vec<f64>>();
        let columns = [wide(&rows.places[0]), wide(&rows.places[1]), wide(&rows.places[2]), wide(&rows.strength)];
        let softening_squared = frame.square.times(softening_squared).to_f64();
        let parts: Vec<&[usize]> = sample.chunks(EXACT).collect();
        let sums: Vec<_> = parts.iter().map(|_| Mutex::new([[0.0; EXACT]; 4])).collect();
        threads.run(parts.len(), &|part| {
            let found = f64::with_lanes(isa, Exact { columns: &columns, softening_squared, rows: parts[part] });
            *sums[part].lock().unwrap_or_else(PoisonError::into_inner) = found;
        });
        let mut exact = Vec::new();
        for (part, sums) in parts.iter().zip(sums) {
            let [x, y, z, magnitude] = sums.into_inner().unwrap_or([[f64::NAN; EXACT]; 4]);
            exact.extend((0..part.len()).map(|k| [x[k], y[k], z[k], magnitude[k]]));
        }
        exact
    }
}

/// Rows that exact sums are made for at once: as many as the widest lanes hold, whatever the lanes.
const EXACT: usize = 8;

struct Exact<'a> {
    columns: &'a [Vec<f64>; 4],
    softening_squared: f64,
    /// At most [`EXACT`].
    rows: &'a [usize],
}

impl WithLanes<f64> for Exact<'_> {
    type Output = [[f64; EXACT]; 4];
    #[inline(always)]
    fn with<R: Lanes<f64>>(self) -> Self::Output {
        let [xs, ys, zs, strengths] = self.columns;
        let mut all = [[0.0; EXACT]; 4];
        let softening_squared = R::splat(self.softening_squared.max(least_square::<f64>()));
        let last = self.rows.len() - 1;
        for block in (0..EXACT).step_by(R::WIDTH) {
            let row = |lane: usize| self.rows[(block + lane).min(last)];
            let [x, y, z] = [
                R::from_lanes(|lane| xs[row(lane)]),
                R::from_lanes(|lane| ys[row(lane)]),
                R::from_lanes(|lane| zs[row(lane)]),
            ];
            let mut sums = [R::lit(0.0); 4];
            for (((&xj, &yj), &zj), &strength) in xs.iter().zip(ys).zip(zs).zip(strengths) {
                let strength = R::splat(strength);
                let d = [R::splat(xj) - x, R::splat(yj) - y, R::splat(zj) - z];
                let length2 = fused(d[0], d[0], fused(d[1], d[1], d[2] * d[2]));
                let u = super::fast::rsqrt::<f64, R>(length2 + softening_squared);
                let share = strength * u * (u * u);
                for axis in 0..3 {
                    sums[axis] = fused(share, d[axis], sums[axis]);
                }
                // The length of a share: 0 of a row's own.
                sums[3] = fused(share.abs(), length2.sqrt(), sums[3]);
            }
            for (sum, to) in sums.into_iter().zip(&mut all) {
                store(sum, to, block);
            }
        }
        all
    }
}
