//! A law's body as a record of its operations.
//!
//! In: a law, and which of its optional values are there. Out: what each of its results is computed from. Never: rows, buffers, text.

use super::traced::{At, Of, Record, Traced, record};
use crate::backend::within::Within;
use crate::law::{Declared, LinkFamily, LinkLaw, PairFamily, PairLaw, RowFamily, RowLaw, Sink, Source};
use crate::real::Real;

/// A body, recorded.
#[derive(Debug)]
pub(crate) struct Trace {
    pub(super) record: Record,
    pub(super) results: Vec<ResultOf>,
}

/// A number that a body gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ResultOf {
    /// The row or the end that gets it.
    pub(super) of: Of,
    pub(super) slot: usize,
    pub(super) value: At,
}

/// Values of a row; `there` has a bit for each slot.
struct Values {
    of: Of,
    there: u64,
}

impl Source<Traced> for Values {
    fn wants(&self, _port: usize) -> bool {
        true
    }
    fn has(&self, slot: usize) -> bool {
        self.there >> slot & 1 == 1
    }
    fn component(&self, slot: usize) -> Traced {
        Traced::input(self.of, slot)
    }
    fn constant(&self, slot: usize) -> Traced {
        Traced::input(Of::Scene, slot)
    }
}

/// Results, in the order in which they are given.
struct Results<'a> {
    of: Of,
    all: &'a mut Vec<ResultOf>,
}

impl Sink<Traced> for Results<'_> {
    fn set(&mut self, slot: usize, value: Traced) {
        self.all.push(ResultOf { of: self.of, slot, value: value.0 });
    }
    fn add(&mut self, slot: usize, value: Traced) {
        self.set(slot, value);
    }
    fn rate(&mut self, _coordinate: bool, slot: usize, value: Traced) {
        self.set(slot, value);
    }
}

/// Records one row of a law.
pub(crate) fn row<F: RowFamily>(law: &F, there: u64) -> Trace {
    let (results, record) = record(|| {
        let row = <F::Kernel<Traced> as Declared<Traced>>::load(&Within::<_, F>::new(Values { of: Of::Row, there }));
        let output = law.kernel::<Traced>().row(row);
        let mut all = Vec::new();
        let mut results = Within::<_, F>::new(Results { of: Of::Row, all: &mut all });
        <F::Kernel<Traced> as Declared<Traced>>::store(output, &mut results);
        all
    });
    Trace { record, results }
}

/// Records one pair of a law.
pub(crate) fn pair<F: PairFamily>(law: &F, there: u64) -> Trace {
    let (results, record) = record(|| {
        let [i, j] = [Of::Row, Of::Other]
            .map(|of| <F::Kernel<Traced> as Declared<Traced>>::load(&Within::<_, F>::new(Values { of, there })));
        let output = law.kernel::<Traced>().pair(i, j);
        let mut all = Vec::new();
        let mut results = Within::<_, F>::new(Results { of: Of::Row, all: &mut all });
        <F::Kernel<Traced> as Declared<Traced>>::store(output, &mut results);
        all
    });
    Trace { record, results }
}

/// Records one link of a law.
pub(crate) fn link<F: LinkFamily<N>, const N: usize>(law: &F, there: u64) -> Trace {
    let (results, record) = record(|| {
        let at = |of| Within::<_, F>::new(Values { of, there });
        let row = <F::Kernel<Traced> as Declared<Traced>>::load(&at(Of::Row));
        let ends = core::array::from_fn(|end| <F::Kernel<Traced> as Declared<Traced>>::load_end(&at(Of::End(end))));
        let mut all = Vec::new();
        for (end, output) in law.kernel::<Traced>().link(row, ends).into_iter().enumerate() {
            let mut results = Within::<_, F>::new(Results { of: Of::End(end), all: &mut all });
            <F::Kernel<Traced> as Declared<Traced>>::store_end(output, &mut results);
        }
        all
    });
    Trace { record, results }
}

/// Records numbers that are copied: the first so many slots get those of the slots behind them.
pub(crate) fn copy(width: usize) -> Trace {
    let of = Of::Row;
    let result = |slot| ResultOf { of, slot, value: Traced::input(of, width + slot).0 };
    let (results, record) = record(|| (0..width).map(result).collect());
    Trace { record, results }
}

/// Records a sum of so many numbers, each times a constant, in their order.
pub(crate) fn sum(terms: usize) -> Trace {
    let of = Of::Row;
    let (results, record) = record(|| {
        let term = |k: usize| Traced::input(of, 1 + k) * Traced::input(Of::Scene, 1 + terms + k);
        let sum = (0..terms).map(term).reduce(|sum, term| sum + term).unwrap_or(Traced::lit(0.0));
        vec![ResultOf { of, slot: 0, value: sum.0 }]
    });
    Trace { record, results }
}
