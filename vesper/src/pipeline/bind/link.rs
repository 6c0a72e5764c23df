//! A link law, tied to the layout of one state: where its numbers are, and which rows each thread has for its own.

use super::{Base, Binder, defaults, threads};
use crate::backend::Strided;
use crate::column::{Aligned, Storage};
use crate::pipeline::operand::Operand;
use crate::pipeline::plan::{Op, Placed};
use crate::real::Scalar;
use core::ops::Range;

/// A link law over the rows of its domain.
pub(crate) struct LinkPass<P: Scalar> {
    pub(crate) law: usize,
    pub(crate) links: usize,
    pub(crate) ends: (*const u32, usize),
    pub(crate) slots: Vec<(Base<P>, usize)>,
    pub(crate) resolved: Vec<Strided<P>>,
    pub(crate) energy: bool,
    /// Threads that the law may have.
    pub(crate) threads: usize,
    /// What threads take at a time; none where one thread takes all.
    pub(crate) portions: Vec<Portion>,
    pub(crate) _defaults: Aligned<P>,
}

/// Neighbouring rows that are linked to, and all links that end at one of them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Portion {
    pub(crate) rows: Range<u32>,
    /// In ascending order, so that each row sums as on one thread.
    pub(crate) links: Vec<u32>,
}

/// Links from which on a link law is worth the threads: twice what waking two of them costs (measured: 15 us, and a tenth of
/// the links computed twice), at 5 ns a link.
const PARALLEL_LINKS: usize = 16_384;
/// Ends of links that a thread takes at a time, at least.
const GRAIN: usize = 1024;

impl<P: Scalar> Binder<'_, P> {
    pub(super) fn link(&self, op: &Placed, energy: bool, arity: usize, splits: bool) -> Option<LinkPass<P>> {
        let Op::Law { seat, .. } = op.op else { return None };
        let seat = &self.pipeline.registry.seats[seat];
        let link = self.pipeline.entries[seat.law].signature.link?;
        let domain = &self.state.domains[op.domain];
        let Storage::Link { rows: ends, .. } = &domain.columns[domain.find(link.name)?].storage else { return None };
        if domain.rows == 0 {
            return None;
        }
        let defaults = defaults::<P>(&op.operands);
        let mut slots = Vec::new();
        for (slot, operand) in op.operands.iter().enumerate() {
            slots.push(match operand {
                Operand::Default(_) => (Base::Owned(defaults.pointer().wrapping_add(slot)), 0),
                Operand::Absent | Operand::Zero | Operand::Field(..) => (Base::Owned(core::ptr::null_mut()), 0),
                _ => {
                    let located = self.locate(*operand)?;
                    (located.base, located.stride)
                }
            });
        }
        let threads = if splits { threads(op.backend, domain.rows, PARALLEL_LINKS, self.machine) } else { 1 };
        let targets = self.state.domains[seat.target?].rows;
        Some(LinkPass {
            law: seat.law,
            links: domain.rows,
            ends: (ends.as_ptr(), ends.len()),
            resolved: Vec::with_capacity(slots.len()),
            slots,
            energy,
            threads,
            portions: if threads > 1 && !energy { portions(ends, arity, targets, threads) } else { Vec::new() },
            _defaults: defaults,
        })
    }
}

/// Portions for so many threads; none where there is too little to divide.
///
/// Several for each thread, so that one that is late does not hold up the others; but where so many links would then be
/// computed twice that it does not pay, one for each.
fn portions(ends: &[u32], arity: usize, rows: usize, threads: usize) -> Vec<Portion> {
    let most = ends.len() / GRAIN;
    let many = cut(ends, arity, rows, (4 * threads).min(most));
    let twice = many.iter().map(|portion| portion.links.len()).sum::<usize>() > ends.len() / arity * 5 / 4;
    if twice { cut(ends, arity, rows, threads.min(most)) } else { many }
}

/// Cuts the rows so that as many links end in each portion.
fn cut(ends: &[u32], arity: usize, rows: usize, count: usize) -> Vec<Portion> {
    if count < 2 {
        return Vec::new();
    }
    let mut ending = vec![0_usize; rows];
    ends.iter().for_each(|&end| ending[end as usize] += 1);
    let mut portions: Vec<Portion> = Vec::with_capacity(count);
    let mut portion_of = vec![0_u32; rows];
    let (mut seen, mut first) = (0, 0);
    for (row, portion_of) in (0_u32..).zip(&mut portion_of) {
        *portion_of = portions.len() as u32;
        seen += ending[row as usize];
        if row as usize + 1 == rows || seen * count >= ends.len() * (portions.len() + 1) {
            portions.push(Portion { rows: first..row + 1, links: Vec::new() });
            first = row + 1;
        }
    }
    for (link, ends) in (0_u32..).zip(ends.chunks_exact(arity)) {
        for &end in ends {
            let links = &mut portions[portion_of[end as usize] as usize].links;
            if links.last() != Some(&link) {
                links.push(link);
            }
        }
    }
    portions
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ends without order, of links of three rows.
    fn ends(links: u32, rows: u32) -> Vec<u32> {
        (0..links * 3).map(|end| end.wrapping_mul(2_654_435_761) % rows).collect()
    }

    #[test]
    fn every_row_is_in_one_portion_with_all_links_that_end_there() {
        let near = (0..5000).flat_map(|link| [link / 2, link / 2 + 1, link / 3]).collect();
        for (ends, rows) in [(ends(5000, 700), 700), (near, 2501), (vec![3; 15_000], 5), (ends(400, 9), 9)] {
            for threads in [2, 3, 7] {
                let portions = portions(&ends, 3, rows, threads);
                if ends.len() < 2 * GRAIN {
                    assert_eq!(portions, []);
                    continue;
                }
                let cut: Vec<u32> =
                    portions.iter().flat_map(|portion| [portion.rows.start, portion.rows.end]).collect();
                assert_eq!((cut.first(), cut.last()), (Some(&0), Some(&(rows as u32))));
                assert!(cut[1..cut.len() - 1].chunks(2).all(|cut| cut[0] == cut[1]), "{cut:?}");
                for portion in &portions {
                    let here = |ends: &[u32]| ends.iter().any(|end| portion.rows.contains(end));
                    let links = (0_u32..).zip(ends.chunks(3)).filter(|(_, ends)| here(ends)).map(|(link, _)| link);
                    assert!(links.eq(portion.links.iter().copied()), "{:?}, {threads} threads", portion.rows);
                }
            }
        }
    }

    #[test]
    fn links_between_neighbours_are_cut_for_balance_and_others_for_little_work() {
        let near: Vec<u32> = (0..50_000).flat_map(|link| [link, link + 1]).collect();
        let far: Vec<u32> = ends(50_000, 5000);
        assert_eq!(portions(&near, 2, 50_001, 2).len(), 8);
        assert_eq!(portions(&far, 2, 5000, 2).len(), 2);
    }
}
