//! The same work written by hand, over split columns as vesper has them: what a framework is to be measured against.
//!
//! Every loop has the arithmetic of the laws, in the same order, so that results can be compared bit by bit. Slices are
//! arguments of their own, because only then does the compiler know that they do not overlap.

mod coloured;
#[cfg_attr(not(target_arch = "x86_64"), path = "direct_elsewhere.rs")]
pub mod direct;
#[cfg(feature = "gpu")]
pub mod gpu;
mod rows;
mod springs;

pub use coloured::Coloured;
pub use rows::{Charged, Step};
pub use springs::Sprung;

use vesper::prelude::*;

/// Numbers at an aligned address, `stream` cache lines further: columns that all begin at the same place of a page
/// would meet in the same sets of the cache.
#[derive(Clone, Debug)]
pub struct Column<P> {
    numbers: Vec<P>,
    lead: usize,
}

const CACHE_LINE: usize = 64;

impl<P: Precision> Column<P> {
    /// The numbers, as the column of this number among those that are read together.
    pub fn new(stream: usize, numbers: impl ExactSizeIterator<Item = f64>) -> Self {
        let len = numbers.len();
        let line = CACHE_LINE / size_of::<P>();
        let mut column = Column { numbers: vec![P::default(); len + line * (stream % 16 + 2)], lead: 0 };
        column.lead = column.numbers.as_ptr().align_offset(CACHE_LINE) + line * (stream % 16);
        column.numbers.truncate(column.lead + len);
        for (to, number) in column.slice().iter_mut().zip(numbers) {
            *to = P::from_f64(number);
        }
        column
    }

    /// Three columns, from vectors.
    pub fn vectors(stream: usize, vectors: &[[f64; 3]]) -> [Self; 3] {
        [0, 1, 2].map(|axis| Column::new(stream + axis, vectors.iter().map(move |vector| vector[axis])))
    }

    /// The numbers.
    pub fn slice(&mut self) -> &mut [P] {
        &mut self.numbers[self.lead..]
    }

    /// The numbers, to look at.
    pub fn numbers(&self) -> &[P] {
        &self.numbers[self.lead..]
    }
}

/// The largest difference of vectors of an engine's domain "bodies" from columns, in parts of the largest number.
///
/// # Errors
/// There is no such column.
pub fn difference<P: Precision>(
    engine: &Engine<P>,
    property: impl AsProperty,
    columns: &[Column<P>; 3],
) -> Result<f64, Fault> {
    let ours = engine.state().numbers("bodies", property)?;
    let theirs = (0..ours.len()).map(|k| columns[k % 3].numbers()[k / 3].to_f64());
    Ok(relative_difference(&ours, theirs))
}

/// The largest difference, in parts of the largest number.
pub(crate) fn relative_difference(ours: &[f64], theirs: impl Iterator<Item = f64>) -> f64 {
    let (mut largest, mut difference) = (f64::MIN_POSITIVE, 0.0_f64);
    for (ours, theirs) in ours.iter().zip(theirs) {
        largest = largest.max(theirs.abs());
        difference = difference.max((ours - theirs).abs());
    }
    difference / largest
}
