//! Rows side by side in space: an order in which neighbours follow each other, and boxes around each stretch of it.
//!
//! In: where the rows are. Out: clusters of so many rows each, and levels of boxes, each around sixteen of the level below.
//! Never: a distance between two rows, a list.
//!
//! Halves of halves, each cut across the longest side of what it holds (Bentley 1975, <https://doi.org/10.1145/361002.361007>).
//! Not a grid of cells: its memory or its crowding goes with the extent of the whole, while halves follow the rows, two
//! crowds far apart as well as one, and clusters of an even fluid are as compact.

use crate::real::{MAX_WIDTH, Scalar};

/// Boxes in one box of the level above: whole registers of every width.
pub(super) const FAN: usize = MAX_WIDTH;

/// A row and where it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point<P> {
    pub(super) at: [P; 3],
    pub(super) row: u32,
}

/// Puts points in an order where each `width` of them are a cluster.
pub(super) fn arrange<P: Scalar>(points: &mut [Point<P>], width: usize) {
    let clusters = points.len().div_ceil(width);
    if clusters <= 1 {
        // Ascending, so that a cluster's rows come in this order in its list, too.
        points.sort_unstable_by_key(|point| point.row);
        return;
    }
    let left = half(clusters) * width;
    let [x, y, z] = sides(points);
    let side = if x >= y && x >= z { 0 } else { 1 + usize::from(z > y) };
    points
        .select_nth_unstable_by(left, |a, b| a.at[side].partial_cmp(&b.at[side]).unwrap_or(core::cmp::Ordering::Equal));
    let (left, right) = points.split_at_mut(left);
    arrange(left, width);
    arrange(right, width);
}

/// About half of them, so that boxes of the levels end where halves do.
fn half(clusters: usize) -> usize {
    let mut whole = 1;
    while whole * FAN <= clusters / 2 {
        whole *= FAN;
    }
    (clusters / 2 + whole / 2) / whole * whole
}

/// The sides of the box around points. Comparisons, not the minimum of the numbers: this takes each as it comes.
fn sides<P: Scalar>(points: &[Point<P>]) -> [P; 3] {
    let mut around = Around::nothing();
    for point in points {
        around.take(point.at);
    }
    core::array::from_fn(|side| around.high[side] - around.low[side])
}

/// A box around points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Around<P> {
    pub(super) low: [P; 3],
    pub(super) high: [P; 3],
}

impl<P: Scalar> Around<P> {
    pub(super) fn nothing() -> Self {
        Around { low: [P::from_f64(f64::INFINITY); 3], high: [P::from_f64(f64::NEG_INFINITY); 3] }
    }

    fn with(mut self, other: &Self) -> Self {
        self.take(other.low);
        self.take(other.high);
        self
    }

    #[inline(always)]
    pub(super) fn take(&mut self, at: [P; 3]) {
        for side in 0..3 {
            self.low[side] = at[side].min(self.low[side]);
            self.high[side] = at[side].max(self.high[side]);
        }
    }
}

/// Boxes side by side, each of six numbers that lie with those of the others; room for whole registers.
#[derive(Debug)]
pub(super) struct Level<P> {
    pub(super) low: [Vec<P>; 3],
    pub(super) high: [Vec<P>; 3],
    /// How many boxes there are.
    pub(super) count: usize,
}

impl<P: Scalar> Level<P> {
    fn around(boxes: impl ExactSizeIterator<Item = Around<P>>) -> Self {
        let count = boxes.len();
        let room = count.next_multiple_of(FAN);
        let mut level = Level {
            low: [const { Vec::new() }; 3].map(|_: Vec<P>| vec![P::default(); room]),
            high: [const { Vec::new() }; 3].map(|_: Vec<P>| vec![P::default(); room]),
            count,
        };
        for (number, around) in boxes.enumerate() {
            for side in 0..3 {
                level.low[side][number] = around.low[side];
                level.high[side][number] = around.high[side];
            }
        }
        level
    }

    /// The box around all boxes.
    pub(super) fn around_all(&self) -> Around<P> {
        (0..self.count).fold(Around::nothing(), |around, number| around.with(&self.get(number)))
    }

    pub(super) fn get(&self, number: usize) -> Around<P> {
        Around {
            low: core::array::from_fn(|side| self.low[side][number]),
            high: core::array::from_fn(|side| self.high[side][number]),
        }
    }
}

/// Boxes around clusters, around sixteen of those, and so on to at most sixteen.
pub(super) fn levels<P: Scalar>(points: &[Point<P>], width: usize) -> Vec<Level<P>> {
    let mut levels = vec![Level::around(points.chunks(width).map(|cluster| {
        let mut around = Around::nothing();
        cluster.iter().for_each(|point| around.take(point.at));
        around
    }))];
    loop {
        let below = &levels[levels.len() - 1];
        if below.count <= FAN {
            return levels;
        }
        let above = Level::around((0..below.count.div_ceil(FAN)).map(|number| {
            let children = number * FAN..((number + 1) * FAN).min(below.count);
            children.fold(Around::nothing(), |around, child| around.with(&below.get(child)))
        }));
        levels.push(above);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_about_half_and_none_is_empty() {
        for clusters in 2..5000 {
            let half = half(clusters);
            assert!(half >= 1 && 3 * half >= clusters - 1 && half <= 3 * clusters / 4, "{half} of {clusters}");
        }
    }

    #[test]
    fn every_row_is_in_one_cluster_and_in_all_boxes_above_it() {
        let mut number = 1_u32;
        let mut next = || {
            number = number.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(number) / 4e9
        };
        let mut points: Vec<_> = (0..4321).map(|row| Point { at: [next(), next(), next()], row }).collect();
        arrange(&mut points, 8);
        let mut rows: Vec<u32> = points.iter().map(|point| point.row).collect();
        assert!(rows.chunks(8).all(|cluster| cluster.is_sorted()));
        rows.sort_unstable();
        assert!(rows.into_iter().eq(0..4321));
        let levels = levels(&points, 8);
        assert_eq!(levels.iter().map(|level| level.count).collect::<Vec<_>>(), [541, 34, 3]);
        for (number, point) in points.iter().enumerate() {
            let mut number = number / 8;
            for level in &levels {
                let around = level.get(number);
                assert!((0..3).all(|side| around.low[side] <= point.at[side] && point.at[side] <= around.high[side]));
                number /= FAN;
            }
        }
    }
}
