//! How a body's values get in and out, without the body knowing where from: a backend implements [`Source`] and
//! [`Sink`], the derive calls the functions here.
//!
//! A *slot* is the number of a component among all components of all ports of a law.

use crate::property::{Numeric, Property, Role, ValueOf};
use crate::real::Real;

/// The values and results of a law over the numbers `R`. Made by `#[derive(Law)]`.
pub trait Declared<R: Real> {
    /// What the body gets of a row.
    type Row: Copy;
    /// What the body of a link law gets of each row linked to; `()` for other laws.
    type End: Copy;
    /// What the body gives to a row: the value alone where there is one, a struct of them where there are more.
    type Output;
    /// What the body of a link law gives to each row linked to.
    type EndOutput;
    /// Loads a row.
    fn load<S: Source<R>>(source: &S) -> Self::Row;
    /// Loads a row linked to.
    fn load_end<S: Source<R>>(source: &S) -> Self::End;
    /// Stores the body's results for a row.
    fn store<K: Sink<R>>(output: Self::Output, sink: &mut K);
    /// Stores the body's results for a row linked to.
    fn store_end<K: Sink<R>>(output: Self::EndOutput, sink: &mut K);
}

/// Where values come from: one row, or one row per lane.
pub trait Source<R> {
    /// Whether the port is wanted. A port that is not gives NaN, so that a dependency which was not declared shows.
    fn wants(&self, port: usize) -> bool;
    /// Whether an optional port is there.
    fn has(&self, slot: usize) -> bool;
    /// A component of the row.
    fn component(&self, slot: usize) -> R;
    /// A component of a constant of the scene.
    fn constant(&self, slot: usize) -> R;
}

/// Where results go: one row, or one row per lane.
pub trait Sink<R> {
    /// Computes the component anew.
    fn set(&mut self, slot: usize, value: R);
    /// Adds to the component.
    fn add(&mut self, slot: usize, value: R);
    /// Gives the rate of a component of a state; `coordinate` where the state is drifted, not kicked.
    fn rate(&mut self, coordinate: bool, slot: usize, value: R);
}

/// First slots of the ports of these widths, and after the last one the number of slots.
pub const fn slots<const N: usize, const M: usize>(widths: &[usize; N]) -> [usize; M] {
    assert!(M == N + 1, "one slot more than ports");
    let mut slots = [0; M];
    let mut port = 0;
    while port < N {
        slots[port + 1] = slots[port] + widths[port];
        port += 1;
    }
    slots
}

/// Loads a value of property `Q`.
#[inline(always)]
pub fn read<Q: Property<Kind: Numeric>, R: Real, S: Source<R>>(source: &S, port: usize, slot: usize) -> ValueOf<Q, R> {
    <Q::Kind as Numeric>::from_components(|component| {
        if source.wants(port) { source.component(slot + component) } else { R::lit(f64::NAN) }
    })
}

/// Loads a constant of the scene.
#[inline(always)]
pub fn read_constant<Q: Property<Kind: Numeric>, R: Real, S: Source<R>>(
    source: &S,
    port: usize,
    slot: usize,
) -> ValueOf<Q, R> {
    <Q::Kind as Numeric>::from_components(|component| {
        if source.wants(port) { source.constant(slot + component) } else { R::lit(f64::NAN) }
    })
}

/// Loads a value of property `Q` where there is one.
#[inline(always)]
pub fn read_optional<Q: Property<Kind: Numeric>, R: Real, S: Source<R>>(
    source: &S,
    port: usize,
    slot: usize,
) -> Option<ValueOf<Q, R>> {
    source.has(slot).then(|| read::<Q, R, S>(source, port, slot))
}

/// Loads a constant of the scene where there is one.
#[inline(always)]
pub fn read_optional_constant<Q: Property<Kind: Numeric>, R: Real, S: Source<R>>(
    source: &S,
    port: usize,
    slot: usize,
) -> Option<ValueOf<Q, R>> {
    source.has(slot).then(|| read_constant::<Q, R, S>(source, port, slot))
}

/// Stores a value computed anew.
#[inline(always)]
pub fn write_set<Q: Property<Kind: Numeric>, R: Real, K: Sink<R>>(
    sink: &mut K,
    _port: usize,
    slot: usize,
    value: ValueOf<Q, R>,
) {
    <Q::Kind as Numeric>::each_component(value, |component, number| sink.set(slot + component, number));
}

/// Adds a value to a sum.
#[inline(always)]
pub fn write_add<Q: Property<Kind: Numeric>, R: Real, K: Sink<R>>(
    sink: &mut K,
    _port: usize,
    slot: usize,
    value: ValueOf<Q, R>,
) {
    <Q::Kind as Numeric>::each_component(value, |component, number| sink.add(slot + component, number));
}

/// Gives the rate of a state.
#[inline(always)]
pub fn write_rate<Q: Property<Kind: Numeric>, R: Real, K: Sink<R>>(
    sink: &mut K,
    _port: usize,
    slot: usize,
    value: ValueOf<Q, R>,
) {
    <Q::Kind as Numeric>::each_component(value, |component, number| {
        sink.rate(const { matches!(Q::INFO.role, Role::Coordinate) }, slot + component, number);
    });
}

/// Stores a corrected state.
#[inline(always)]
pub fn write_amend<Q: Property<Kind: Numeric>, R: Real, K: Sink<R>>(
    sink: &mut K,
    port: usize,
    slot: usize,
    value: ValueOf<Q, R>,
) {
    write_set::<Q, R, K>(sink, port, slot, value);
}
