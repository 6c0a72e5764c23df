//! How a body's values get in and out, without the body knowing where from: a backend implements [`Source`] and
//! [`Sink`], the derive calls the functions here.
//!
//! A *slot* is the number of a component among all components of all ports of a law.

use super::{Mode, Place};
use crate::property::{Give, Numeric, Property, Role, Take, ValueOf};
use crate::real::Real;

/// The values and results of a law over the numbers `R`. Made by `#[derive(Law)]`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a law over the numbers `{R}`",
    note = "a law that is declared as `Name<R = f64>` is `Name<R>` there"
)]
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
    /// A component of a field at the row.
    #[inline(always)]
    fn field(&self, slot: usize) -> R {
        self.component(slot)
    }
}

/// Where results go: one row, or one row per lane.
pub trait Sink<R> {
    /// Computes the component anew.
    fn set(&mut self, slot: usize, value: R);
    /// Adds to the component.
    fn add(&mut self, slot: usize, value: R);
    /// Adds to the component of a turn, where somebody wants it.
    #[inline(always)]
    fn turn(&mut self, slot: usize, value: R) {
        self.add(slot, value);
    }
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

/// The components of one port.
struct Reader<'a, S> {
    source: &'a S,
    wanted: bool,
    place: Place,
    slot: usize,
}

impl<R: Real, S: Source<R>> Give<R> for Reader<'_, S> {
    #[inline(always)]
    fn give(&mut self, component: usize) -> R {
        let slot = self.slot + component;
        match self.place {
            _ if !self.wanted => R::lit(f64::NAN),
            Place::Own | Place::End => self.source.component(slot),
            Place::Scene => self.source.constant(slot),
            Place::Field => self.source.field(slot),
        }
    }
}

/// Loads a value of property `Q`.
#[inline(always)]
pub fn read<Q: Property<Kind: Numeric>, R: Real, S: Source<R>>(
    source: &S,
    place: Place,
    port: usize,
    slot: usize,
) -> ValueOf<Q, R> {
    let wanted = source.wants(port);
    <Q::Kind as Numeric>::from_components(Reader { source, wanted, place, slot })
}

/// Loads a value of property `Q` where there is one.
#[inline(always)]
pub fn read_optional<Q: Property<Kind: Numeric>, R: Real, S: Source<R>>(
    source: &S,
    place: Place,
    port: usize,
    slot: usize,
) -> Option<ValueOf<Q, R>> {
    if source.has(slot) { Some(read::<Q, R, S>(source, place, port, slot)) } else { None }
}

/// What becomes of the components of one port.
struct Writer<'a, K> {
    sink: &'a mut K,
    mode: Mode,
    coordinate: bool,
    turns: bool,
    slot: usize,
}

impl<R: Real, K: Sink<R>> Take<R> for Writer<'_, K> {
    #[inline(always)]
    fn take(&mut self, component: usize, number: R) {
        let slot = self.slot + component;
        match self.mode {
            Mode::Adds if self.turns => self.sink.turn(slot, number),
            Mode::Adds => self.sink.add(slot, number),
            Mode::Rates => self.sink.rate(self.coordinate, slot, number),
            _ => self.sink.set(slot, number),
        }
    }
}

/// Stores a result: adds it, sets it, or gives it as the rate of a state.
#[inline(always)]
pub fn write<Q: Property<Kind: Numeric>, R: Real, K: Sink<R>>(
    sink: &mut K,
    mode: Mode,
    slot: usize,
    value: ValueOf<Q, R>,
) {
    let coordinate = const { matches!(Q::INFO.role, Role::Coordinate) };
    let turns = const { matches!(Q::INFO.role, Role::Turn { .. }) };
    <Q::Kind as Numeric>::each_component(value, Writer { sink, mode, coordinate, turns, slot });
}
