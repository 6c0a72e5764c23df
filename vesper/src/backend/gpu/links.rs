//! Links as a device follows them: from the rows that they end at.
//!
//! In: the rows of each link. Out: for each row its links, in their order, so that every row sums alone and in the order of the host.
//! Never: an atomic sum.

/// Links and the rows that they end at.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ends {
    /// The rows of each link, one after the other.
    pub(crate) rows: Vec<u32>,
    /// Where in `ends` the part of each row begins, and behind the last one where it ends.
    starts: Vec<u32>,
    /// The ends at each row: the number of the link times the ends of a link, and which one of them it is.
    ends: Vec<u32>,
}

impl Ends {
    /// Sorts the ends of links by the row that they are at. Each of `ends` is below `rows`.
    pub(crate) fn of(ends: Vec<u32>, rows: usize) -> Self {
        let mut starts = vec![0; rows + 1];
        for &row in &ends {
            starts[row as usize + 1] += 1;
        }
        for row in 0..rows {
            starts[row + 1] += starts[row];
        }
        let mut next = starts.clone();
        let mut sorted = vec![0; ends.len()];
        for (at, &row) in (0..).zip(&ends) {
            let next = &mut next[row as usize];
            sorted[*next as usize] = at;
            *next += 1;
        }
        Ends { rows: ends, starts, ends: sorted }
    }

    /// The lists, in the order of a program's bindings.
    pub(crate) fn lists(&self) -> [&[u32]; 3] {
        [&self.rows, &self.starts, &self.ends]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_has_its_ends_in_the_order_of_the_links() {
        // Three links of two ends among four rows; no link ends at the last one.
        let ends = Ends::of(vec![2, 0, 1, 2, 2, 1], 4);
        assert_eq!(ends.lists(), [&[2, 0, 1, 2, 2, 1][..], &[0, 1, 3, 6, 6], &[1, 2, 5, 0, 3, 4]]);
    }
}
