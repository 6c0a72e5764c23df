//! One property on one domain: where the numbers are.
//!
//! In: values of the client. Out: [`Column`], read and written row by row from outside, and by pointer from the
//! backends. Owned vectors are split, x, y and z in arrays of their own (measured 2.5 to 5 times faster than arrays of
//! vectors); lent ones stay as the client has them. Never: a law, a unit conversion.

mod aligned;
mod away;
mod lent;
mod values;

pub(crate) use aligned::{Aligned, Block, is_long, staggered, whole};
pub(crate) use away::Away;
#[cfg(feature = "gpu")]
pub(crate) use away::{Elsewhere, Flags};
pub(crate) use lent::LentMemory;
pub use lent::{Lent, Memory, RawRows};
pub use values::Values;

use crate::error::Fault;
use crate::property::PropertyInfo;
use crate::real::Scalar;
use std::sync::Arc;

/// One property on one domain.
pub struct Column<P: Scalar> {
    /// Who has newer numbers elsewhere, where somebody may. First, so that who it is forgets the numbers before they go.
    pub(crate) away: Option<Away>,
    pub(crate) info: PropertyInfo,
    pub(crate) storage: Storage<P>,
    /// The rows that have a value, ascending; `None` where all have.
    pub(crate) subset: Option<Vec<u32>>,
    /// Whether the client gave it; else a law's result made it.
    pub(crate) given: bool,
    /// Whether clients may look: what laws only exchange among themselves is not kept up to date for others.
    pub(crate) shown: bool,
}

/// Where a column's numbers are.
#[derive(Clone)]
pub(crate) enum Storage<P: Scalar> {
    /// One array for each component.
    Split(Vec<Aligned<P>>),
    /// The client's memory, one row after the other.
    Lent(Arc<dyn LentMemory<P>>),
    /// Rows of the domain of this name, `arity` for each row.
    Link { target: String, arity: usize, rows: Vec<u32> },
}

impl<P: Scalar> core::fmt::Debug for Storage<P> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Storage::Split(components) => f.debug_list().entries(components.iter().map(Aligned::as_slice)).finish(),
            Storage::Lent(memory) => memory.fmt(f),
            Storage::Link { target, rows, .. } => {
                f.debug_struct("Link").field("target", target).field("rows", rows).finish()
            }
        }
    }
}

impl<P: Scalar> Clone for Column<P> {
    fn clone(&self) -> Self {
        self.bring();
        let Column { info, given, shown, .. } = *self;
        Column { away: None, info, storage: self.storage.clone(), subset: self.subset.clone(), given, shown }
    }
}

impl<P: Scalar> core::fmt::Debug for Column<P> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.bring();
        let mut column = f.debug_struct("Column");
        column.field("info", &self.info).field("storage", &self.storage).field("subset", &self.subset);
        column.field("given", &self.given).field("shown", &self.shown).finish()
    }
}

impl<P: Scalar> Column<P> {
    /// Its numbers are to be looked at.
    #[inline]
    fn bring(&self) {
        if let Some(away) = &self.away {
            away.bring();
        }
    }

    /// Its numbers are to be changed.
    #[inline]
    fn hand_over(&self) {
        if let Some(away) = &self.away {
            away.hand_over();
        }
    }

    /// Its numbers are here from now on, and nowhere else.
    pub(crate) fn come_back(&mut self) {
        self.hand_over();
        self.away = None;
    }

    /// Whether newer numbers are elsewhere.
    pub(crate) fn is_away(&self) -> bool {
        self.away.as_ref().is_some_and(Away::is_stale)
    }

    /// A column of zeros that the framework makes for a law's results.
    pub(crate) fn computed(info: PropertyInfo, rows: usize, stream: usize) -> Self {
        let components = (0..info.kind.width()).map(|c| Aligned::zeros(rows, stream + c)).collect();
        Column { away: None, info, storage: Storage::Split(components), subset: None, given: false, shown: false }
    }

    /// The property.
    pub fn property(&self) -> &PropertyInfo {
        &self.info
    }

    /// Whether the client gave it; else it holds a law's results.
    pub fn is_given(&self) -> bool {
        self.given
    }

    /// The rows that have a value, ascending; `None` where all rows have.
    pub fn subset(&self) -> Option<&[u32]> {
        self.subset.as_deref()
    }

    /// The rows that have a value, where not all of `rows` have.
    pub(crate) fn part_of(&self, rows: usize) -> Option<&[u32]> {
        self.subset().filter(|subset| subset.len() != rows)
    }

    /// How many values there are.
    pub fn len(&self) -> usize {
        match &self.storage {
            Storage::Split(components) => components[0].as_slice().len(),
            Storage::Lent(memory) => memory.rows(),
            Storage::Link { arity, rows, .. } => rows.len() / arity,
        }
    }

    /// Whether there is no value.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The arrays of the components (x, y, z), where the column is owned and holds numbers.
    pub fn components(&self) -> Option<Vec<&[P]>> {
        self.bring();
        match &self.storage {
            Storage::Split(components) => Some(components.iter().map(Aligned::as_slice).collect()),
            Storage::Lent(_) | Storage::Link { .. } => None,
        }
    }

    /// The domain linked to and the rows, `arity` for each row, where the column is a link.
    pub fn links(&self) -> Option<(&str, usize, &[u32])> {
        match &self.storage {
            Storage::Link { target, arity, rows } => Some((target, *arity, rows)),
            Storage::Split(_) | Storage::Lent(_) => None,
        }
    }

    /// Number `component` of value `index` (of the subset, where there is one). 0 for a link.
    pub(crate) fn number(&self, index: usize, component: usize) -> P {
        self.bring();
        match &self.storage {
            Storage::Split(components) => components[component].as_slice()[index],
            Storage::Lent(memory) => memory.get(index, component),
            Storage::Link { .. } => P::default(),
        }
    }

    #[inline]
    pub(crate) fn set_number(&mut self, index: usize, component: usize, value: P) {
        self.hand_over();
        match &mut self.storage {
            Storage::Split(components) => components[component].as_mut_slice()[index] = value,
            Storage::Lent(memory) => memory.set(index, component, value),
            Storage::Link { .. } => {}
        }
    }

    /// A fault where the client has a guard out that keeps others from looking, or from changing.
    pub(crate) fn free(&self, domain: &str, change: bool) -> Result<(), Fault> {
        match &self.storage {
            Storage::Lent(memory) if memory.busy(change) => {
                Err(Fault::Borrowed { domain: domain.to_owned(), property: self.info.name.to_owned() })
            }
            _ => Ok(()),
        }
    }

    /// A fault where rows cannot be added or removed: `cannot` is "grow" or "shrink".
    pub(crate) fn resizable(&self, domain: &str, cannot: &str) -> Result<(), Fault> {
        let Storage::Lent(memory) = &self.storage else { return Ok(()) };
        memory.fixed().map_err(|why| match why {
            Some(why) => Fault::client_memory(domain, self.info.name, cannot, why),
            None => Fault::Borrowed { domain: domain.to_owned(), property: self.info.name.to_owned() },
        })
    }

    /// Where the value of `row` is, if the row has one.
    pub(crate) fn index_of(&self, row: usize) -> Option<usize> {
        match &self.subset {
            None => (row < self.len()).then_some(row),
            Some(rows) => u32::try_from(row).ok().and_then(|row| rows.binary_search(&row).ok()),
        }
    }

    /// Adds values: `width` numbers each.
    pub(crate) fn extend(&mut self, domain: &str, numbers: &[P]) -> Result<(), Fault> {
        self.hand_over();
        match &mut self.storage {
            Storage::Split(components) => {
                let width = components.len();
                let old = components[0].as_slice().len();
                for (c, component) in components.iter_mut().enumerate() {
                    component.resize(old + numbers.len() / width);
                    for (slot, value) in component.as_mut_slice()[old..].iter_mut().zip(numbers.chunks_exact(width)) {
                        *slot = value[c];
                    }
                }
                Ok(())
            }
            Storage::Lent(memory) => {
                memory.extend(numbers).map_err(|why| Fault::client_memory(domain, self.info.name, "grow", why))
            }
            Storage::Link { .. } => Ok(()),
        }
    }

    /// Keeps the rows that `keep` says, and numbers the subset's rows anew.
    pub(crate) fn retain(&mut self, domain: &str, keep: &[bool]) -> Result<(), Fault> {
        let of_values: Vec<bool> = match &self.subset {
            None => keep.to_vec(),
            Some(rows) => rows.iter().map(|&row| keep[row as usize]).collect(),
        };
        self.hand_over();
        match &mut self.storage {
            Storage::Split(components) => {
                for component in components {
                    let numbers = component.as_mut_slice();
                    let mut to = 0;
                    for from in 0..numbers.len() {
                        if of_values[from] {
                            numbers[to] = numbers[from];
                            to += 1;
                        }
                    }
                    component.resize(to);
                }
            }
            Storage::Lent(memory) => {
                memory.retain(&of_values).map_err(|why| Fault::client_memory(domain, self.info.name, "shrink", why))?
            }
            Storage::Link { arity, rows, .. } => {
                *rows = rows
                    .chunks_exact(*arity)
                    .zip(&of_values)
                    .filter(|(_, keep)| **keep)
                    .flat_map(|(rows, _)| rows.iter().copied())
                    .collect();
            }
        }
        if let Some(subset) = &mut self.subset {
            let moved = renumbering(keep);
            *subset = subset.iter().filter_map(|&row| moved[row as usize]).collect();
        }
        Ok(())
    }
}

/// A column of a state, to change in place: its numbers, not its rows.
#[derive(Debug)]
pub struct ColumnMut<'a, P: Scalar>(pub(crate) &'a mut Column<P>);

impl<P: Scalar> core::ops::Deref for ColumnMut<'_, P> {
    type Target = Column<P>;
    fn deref(&self) -> &Column<P> {
        self.0
    }
}

impl<'a, P: Scalar> ColumnMut<'a, P> {
    /// The arrays of the components (x, y, z), where the column is owned and holds numbers.
    pub fn components_mut(self) -> Option<Vec<&'a mut [P]>> {
        self.0.hand_over();
        match &mut self.0.storage {
            Storage::Split(components) => Some(components.iter_mut().map(Aligned::as_mut_slice).collect()),
            Storage::Lent(_) | Storage::Link { .. } => None,
        }
    }
}

/// The new number of each row, where it is kept.
pub(crate) fn renumbering(keep: &[bool]) -> Vec<Option<u32>> {
    let mut next = 0;
    keep.iter()
        .map(|&keep| {
            keep.then(|| {
                next += 1;
                next - 1
            })
        })
        .collect()
}
