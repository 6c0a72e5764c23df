//! Laws composed at compile time: one loop, intermediate sums in registers, declarations checked by the compiler.
//!
//! In: `pipeline![UniformGravity, Drag::default(), Motion]`. Out: the same laws as if listed one by one, and, where all
//! of them are row laws, one loop for all, used wherever the graph would have run just these laws in one pass. The
//! order is the graph's, so the bits are the same.

mod check;
mod layout;

pub use layout::{Layout, List};

use super::bind::Binder;
use super::merge::NOTHING;
use super::operand::Operand;
use super::plan::{Op, Placed};
use crate::backend::{Compile, Compiled, row_of};
use crate::law::{Law, Mode, Part, Shape, Sink, Source, Stepped};
use crate::real::{Isa, Lanes, MAX_WIDTH, Real, Scalar, WithLanes};
use crate::registry::Tie;
use layout::{Content, REGISTERS};

/// Laws composed at compile time; made by [`pipeline!`](crate::pipeline!).
#[derive(Clone, Debug)]
pub struct Chain<T>(T);

impl<T: Chained> Chain<T> {
    /// Composes laws. Declarations that contradict each other do not compile.
    pub fn new(laws: T) -> Self {
        const { check::check(&T::SIGNATURES) };
        Chain(laws)
    }

    pub(crate) fn compiled<P: Scalar>(&self) -> Vec<Compiled<P>> {
        let mut laws = Vec::new();
        self.0.compile_all(&mut laws);
        laws
    }

    /// The one loop, where all laws are row laws that agree on their constants. `laws`: their numbers in the list, in the order of the chain.
    pub(crate) fn fused<P: Scalar>(&self, laws: Vec<usize>) -> Option<FusedChain<P>> {
        (T::SIGNATURES.all_rows() && T::LAYOUT.agrees).then(|| FusedChain {
            order: (0..T::LEN).map(|k| laws[T::LAYOUT.order[k]]).collect(),
            layout: &T::LAYOUT,
            laws,
            run: Box::new(self.clone()),
        })
    }
}

/// Laws as a list of types: `(A, (B, ()))`.
pub trait Chained: Clone + Send + Sync + 'static {
    /// How many there are.
    const LEN: usize;
    /// Their declarations.
    const SIGNATURES: List;
    /// Which register each of their components has.
    const LAYOUT: Layout = Layout::new(&Self::SIGNATURES);
    /// Their bodies over the numbers `R`.
    type Bodies<R: Real>;
    /// Their bodies over the numbers `R`.
    fn bodies<R: Real>(&self) -> Self::Bodies<R>;
    /// Compiles each.
    fn compile_all<P: Scalar>(&self, into: &mut Vec<Compiled<P>>);
    /// Runs the law of this number among those of `Root`.
    fn step<Root: Chained, R: Real, Rule: ChainPart>(bodies: &Self::Bodies<R>, file: &mut Registers<R>, law: usize);
    /// Runs all laws of `Root`, in order: this list counts.
    fn steps<Root: Chained, R: Real, Rule: ChainPart>(bodies: &Root::Bodies<R>, file: &mut Registers<R>);
}

impl Chained for () {
    const LEN: usize = 0;
    const SIGNATURES: List = List::EMPTY;
    type Bodies<R: Real> = ();
    fn bodies<R: Real>(&self) {}
    fn compile_all<P: Scalar>(&self, _into: &mut Vec<Compiled<P>>) {}
    #[inline(always)]
    fn step<Root: Chained, R: Real, Rule: ChainPart>(_: &(), _: &mut Registers<R>, _: usize) {}
    #[inline(always)]
    fn steps<Root: Chained, R: Real, Rule: ChainPart>(_: &Root::Bodies<R>, _: &mut Registers<R>) {}
}

impl<L: Law + Stepped + Compile, T: Chained> Chained for (L, T) {
    const LEN: usize = 1 + T::LEN;
    const SIGNATURES: List = T::SIGNATURES.with_first(L::SIGNATURE, L::SHAPE);
    type Bodies<R: Real> = (L::Body<R>, T::Bodies<R>);
    fn bodies<R: Real>(&self) -> Self::Bodies<R> {
        (self.0.body(), self.1.bodies())
    }
    fn compile_all<P: Scalar>(&self, into: &mut Vec<Compiled<P>>) {
        into.push(self.0.compile());
        self.1.compile_all(into);
    }
    #[inline(always)]
    fn step<Root: Chained, R: Real, Rule: ChainPart>(bodies: &Self::Bodies<R>, file: &mut Registers<R>, law: usize) {
        if law == Root::LEN - Self::LEN {
            let map = const { &Root::LAYOUT.registers[Root::LEN - Self::LEN] };
            let mask = const { crate::backend::wants(L::SIGNATURE.ports, Rule::PART) };
            let source = Snapshot { file: *file, map, mask };
            L::step(&bodies.0, &source, &mut Into { file, map, part: Rule::PART });
        } else {
            T::step::<Root, R, Rule>(&bodies.1, file, law);
        }
    }
    #[inline(always)]
    fn steps<Root: Chained, R: Real, Rule: ChainPart>(bodies: &Root::Bodies<R>, file: &mut Registers<R>) {
        let law = const { Root::LAYOUT.order[Root::LEN - Self::LEN] };
        Root::step::<Root, R, Rule>(bodies, file, law);
        T::steps::<Root, R, Rule>(bodies, file);
    }
}

/// The part of the state whose rates a stage wants, as a type.
pub trait ChainPart {
    /// The part.
    const PART: Part;
}
/// Stage that kicks.
#[derive(Debug)]
pub struct Kick;
/// Stage that drifts.
#[derive(Debug)]
pub struct Drift;
impl ChainPart for Kick {
    const PART: Part = Part::Momenta;
}
impl ChainPart for Drift {
    const PART: Part = Part::Coordinates;
}

/// The values of all quantities of a chain for some rows.
#[derive(Clone, Copy, Debug)]
pub struct Registers<R> {
    values: [R; REGISTERS],
    rates: [R; REGISTERS],
    present: u64,
}

/// The registers as one law sees them.
struct Snapshot<R> {
    file: Registers<R>,
    map: &'static [u8; crate::backend::MAX_SLOTS],
    mask: u64,
}

impl<R: Real> Source<R> for Snapshot<R> {
    #[inline(always)]
    fn wants(&self, port: usize) -> bool {
        port >= 64 || self.mask >> port & 1 == 1
    }
    #[inline(always)]
    fn has(&self, slot: usize) -> bool {
        self.file.present >> self.map[slot] & 1 == 1
    }
    #[inline(always)]
    fn component(&self, slot: usize) -> R {
        self.file.values[self.map[slot] as usize]
    }
    #[inline(always)]
    fn constant(&self, slot: usize) -> R {
        self.component(slot)
    }
}

/// The registers as one law changes them.
struct Into<'a, R> {
    file: &'a mut Registers<R>,
    map: &'static [u8; crate::backend::MAX_SLOTS],
    part: Part,
}

impl<R: Real> Sink<R> for Into<'_, R> {
    #[inline(always)]
    fn set(&mut self, slot: usize, value: R) {
        self.file.values[self.map[slot] as usize] = value;
    }
    #[inline(always)]
    fn add(&mut self, slot: usize, value: R) {
        self.file.values[self.map[slot] as usize] += value;
    }
    #[inline(always)]
    fn rate(&mut self, coordinate: bool, slot: usize, value: R) {
        if coordinate == matches!(self.part, Part::Coordinates) {
            self.file.rates[self.map[slot] as usize] = value;
        }
    }
}

/// A chain's one loop, and what is needed to tie it to a state.
pub(crate) struct FusedChain<P: Scalar> {
    /// The numbers of the chain's laws in the list, in the order of the chain.
    laws: Vec<usize>,
    /// The same in the order of an evaluation.
    order: Vec<usize>,
    layout: &'static Layout,
    run: Box<dyn ChainRun<P>>,
}

impl<P: Scalar> FusedChain<P> {
    pub(crate) fn laws_in_order(&self) -> &[usize] {
        &self.order
    }

    /// How many registers there are.
    pub(crate) fn slots(&self) -> usize {
        self.layout.count
    }

    /// What is known of the registers before the loop runs. `uniform`: those of uniform fields.
    pub(super) fn fixed(&self, operands: &[(Operand, bool)], uniform: u64) -> Fixed {
        let mask = |holds: &dyn Fn(usize) -> bool| (0..self.slots()).map(|k| u64::from(holds(k)) << k).sum::<u64>();
        let present = mask(&|k| operands[k].0 != Operand::Absent);
        let plain = self.layout.is_plain(present, uniform);
        let uniform = uniform | mask(&|k| operands[k].0 == Operand::Absent);
        Fixed { present, uniform, plain }
    }

    /// The law that times of the loop are noted for: the last one.
    pub(crate) fn last_law(&self) -> usize {
        self.order.last().copied().unwrap_or_default()
    }

    /// The operand of each register and whether it is written; `None` where a quantity of the chain outlives the pass.
    pub(super) fn operands(&self, binder: &Binder<'_, P>, ops: &[Placed]) -> Option<Vec<(Operand, bool)>> {
        let mut operands = vec![(Operand::Absent, false); self.slots()];
        for op in ops {
            match op.op {
                Op::Law { seat, .. } => {
                    let seat = &binder.pipeline.registry.seats[seat];
                    let law = self.laws.iter().position(|law| *law == seat.law)?;
                    let ports = binder.pipeline.entries[seat.law].signature.ports;
                    let mut slot = 0;
                    for (port, tie) in ports.iter().zip(&seat.ties) {
                        for _ in 0..port.property.kind.width() {
                            let register = self.layout.registers[law][slot] as usize;
                            let operand = op.operands[slot];
                            slot += 1;
                            let computed = matches!(self.layout.kinds[register], Content::Sum | Content::Set);
                            if computed && operand != Operand::Absent {
                                let Tie::Quantity(id) = tie else { return None };
                                if !binder.plan.is_transient(*id, binder.pipeline) {
                                    return None;
                                }
                            } else if operand != Operand::Absent {
                                operands[register].0 = operand;
                                operands[register].1 |= port.mode == Mode::Rates;
                            }
                        }
                    }
                }
                Op::Start { sum, from: Some(from) } => {
                    let name = binder.pipeline.registry.quantities[sum].info.name;
                    for component in 0..binder.pipeline.registry.quantities[sum].info.kind.width() {
                        let register = self.layout.first_of(name)? + component;
                        operands[register] = (Operand::Quantity(from, component), false);
                    }
                }
                _ => {}
            }
        }
        // A value that no stage wants has no place to be loaded from.
        let missing = |(register, (operand, _)): (usize, &(Operand, bool))| {
            *operand == Operand::Absent && matches!(self.layout.kinds[register], Content::Given | Content::Constant)
        };
        (!operands.iter().enumerate().any(missing)).then_some(operands)
    }

    /// # Safety
    /// As [`ChainRun::run`].
    pub(crate) unsafe fn run(&self, call: &ChainCall<'_, P>) {
        // SAFETY: passed on to the caller.
        unsafe { self.run.run(call) };
    }
}

/// What does not change from call to call; one bit for each register.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fixed {
    /// Those that are there.
    present: u64,
    /// Those that are the same in all rows: uniform fields, and what is absent.
    uniform: u64,
    /// As [`Layout::is_plain`] says.
    plain: bool,
}

/// One call of a chain's loop.
pub(crate) struct ChainCall<'a, P> {
    pub(crate) isa: Isa,
    /// A pointer for every register: to the first row, or to the one number of a constant or a uniform field, or null.
    pub(crate) slots: &'a [*mut P],
    pub(crate) fixed: Fixed,
    pub(crate) rows: usize,
    /// The steps by which momenta and coordinates advance.
    pub(crate) kick: Option<P>,
    pub(crate) drift: Option<P>,
}

trait ChainRun<P>: Send + Sync {
    /// # Safety
    /// The pointers are as [`ChainCall`] says and valid for its rows; nobody else touches the states.
    unsafe fn run(&self, call: &ChainCall<'_, P>);
}

impl<P: Scalar, T: Chained> ChainRun<P> for Chain<T> {
    unsafe fn run(&self, call: &ChainCall<'_, P>) {
        let (laws, drifts) = (&self.0, call.drift.is_some());
        match (drifts, call.fixed.plain) {
            (true, true) => P::with_lanes(call.isa, Loop::<P, T, true, true> { laws, call }),
            (true, false) => P::with_lanes(call.isa, Loop::<P, T, true, false> { laws, call }),
            (false, true) => P::with_lanes(call.isa, Loop::<P, T, false, true> { laws, call }),
            (false, false) => P::with_lanes(call.isa, Loop::<P, T, false, false> { laws, call }),
        }
    }
}

/// Writes a body out once for each register, so that every index is a constant and the registers are registers: a loop
/// of this many turns is left as a loop, with the values in memory.
macro_rules! each_register {
    (|$register:ident| $body:expr) => {
        each_register!(@ $register $body;
            0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23
            24 25 26 27 28 29 30 31 32 33 34 35 36 37 38 39 40 41 42 43 44 45 46 47)
    };
    (@ $register:ident $body:expr; $($number:literal)*) => {
        $({ let $register = const { $number as usize }; $body })*
    };
}

/// A chain's loop. `DRIFT`: coordinates advance, too. `PLAIN`: as [`Layout::is_plain`] says.
struct Loop<'a, P, T, const DRIFT: bool, const PLAIN: bool> {
    laws: &'a T,
    call: &'a ChainCall<'a, P>,
}

/// What the loop works on, copied where no store of the loop can be thought to change it.
struct Work<P, R> {
    pointers: [*mut P; REGISTERS],
    /// Constants and uniform fields.
    numbers: [R; REGISTERS],
    present: u64,
    uniform: u64,
    kick: R,
    drift: R,
}

impl<P: Scalar, R: Lanes<P>> Work<P, R> {
    /// `absent` stands for what is absent, so that the loop need not ask: first what sums begin from, then zeros.
    ///
    /// # Safety
    /// The pointers are as [`ChainCall`] says.
    #[inline(always)]
    unsafe fn new<T: Chained, const PLAIN: bool>(call: &ChainCall<'_, P>, absent: &mut [[P; MAX_WIDTH]; 2]) -> Self {
        let layout = const { &T::LAYOUT };
        let slots = &call.slots[..layout.count];
        let [nothing, zeros] = absent;
        nothing.fill(P::from_f64(NOTHING));
        // Once each: another borrow would take the pointers' right to look.
        let (nothing, zeros) = (nothing.as_mut_ptr(), zeros.as_mut_ptr());
        let mut work = Work {
            pointers: [zeros; REGISTERS],
            numbers: [R::lit(0.0); REGISTERS],
            present: call.fixed.present,
            uniform: call.fixed.uniform,
            kick: R::splat(call.kick.unwrap_or_default()),
            drift: R::splat(call.drift.unwrap_or_default()),
        };
        each_register!(|register| if register < layout.count {
            let kind = layout.kinds[register];
            work.pointers[register] = match kind {
                _ if !slots[register].is_null() => slots[register],
                Content::Sum => nothing,
                _ => zeros,
            };
            let is_number = matches!(kind, Content::Constant | Content::OptionalConstant);
            if is_number || PLAIN && kind == Content::Field {
                // SAFETY: it points to a number, as the caller promises, or to zeros.
                work.numbers[register] = R::splat(unsafe { *work.pointers[register] });
            }
        });
        work
    }
}

impl<P: Scalar, T: Chained, const DRIFT: bool, const PLAIN: bool> Loop<'_, P, T, DRIFT, PLAIN> {
    #[inline(always)]
    fn load<R: Lanes<P>>(work: &Work<P, R>, register: usize, row: usize) -> R {
        let from = work.pointers[register];
        // SAFETY: `FusedChain::run` was promised the rows; the same for all blocks here.
        unsafe {
            match const { &T::LAYOUT }.kinds[register] {
                Content::Given => R::load(from.add(row)),
                Content::Field if PLAIN => work.numbers[register],
                Content::Sum if PLAIN => R::lit(NOTHING),
                Content::Optional | Content::OptionalConstant if PLAIN => R::lit(0.0),
                Content::Constant | Content::OptionalConstant => work.numbers[register],
                Content::Optional | Content::Field | Content::Sum => {
                    R::load(from.add(row_of(row, work.uniform, register)))
                }
                Content::Set => R::lit(0.0),
            }
        }
    }

    #[inline(always)]
    fn rows<R: Lanes<P>>(work: &Work<P, R>, bodies: &T::Bodies<R>, row: usize) {
        let zero = R::lit(0.0);
        let layout = const { &T::LAYOUT };
        let always = if PLAIN { const { T::LAYOUT.present(true) } } else { work.present };
        let present = always | const { T::LAYOUT.present(false) };
        let mut file = Registers { values: [zero; REGISTERS], rates: [zero; REGISTERS], present };
        each_register!(|register| if register < layout.count {
            file.values[register] = Self::load(work, register, row);
        });
        T::steps::<T, R, Kick>(bodies, &mut file);
        each_register!(|register| if layout.kicked[register] {
            file.values[register] += file.rates[register] * work.kick;
            // SAFETY: see above.
            unsafe { file.values[register].store(work.pointers[register].add(row)) };
        });
        if !DRIFT {
            return;
        }
        each_register!(|register| if matches!(layout.kinds[register], Content::Sum) {
            file.values[register] = Self::load(work, register, row);
        });
        T::steps::<T, R, Drift>(bodies, &mut file);
        each_register!(|register| if layout.drifted[register] {
            let value = file.values[register] + file.rates[register] * work.drift;
            // SAFETY: see above.
            unsafe { value.store(work.pointers[register].add(row)) };
        });
    }
}

impl<P: Scalar, T: Chained, const DRIFT: bool, const PLAIN: bool> WithLanes<P> for Loop<'_, P, T, DRIFT, PLAIN> {
    type Output = ();
    #[inline(always)]
    fn with<R: Lanes<P>>(self) {
        let mut absent = [[P::default(); MAX_WIDTH]; 2];
        let rows = self.call.rows;
        let mut row = 0;
        let wide = rows - rows % R::WIDTH;
        if R::WIDTH > 1 && wide > 0 {
            let bodies = self.laws.bodies::<R>();
            // SAFETY: `ChainRun::run` was promised the pointers.
            let work = unsafe { Work::<P, R>::new::<T, PLAIN>(self.call, &mut absent) };
            while row != wide {
                Self::rows::<R>(&work, &bodies, row);
                row += R::WIDTH;
            }
        }
        if row < rows {
            let bodies = self.laws.bodies::<P>();
            // SAFETY: as above.
            let work = unsafe { Work::<P, P>::new::<T, PLAIN>(self.call, &mut absent) };
            for row in row..rows {
                Self::rows::<P>(&work, &bodies, row);
            }
        }
    }
}

/// Whether a shape is a row law's, for lists.
pub(super) const fn is_row(shape: Shape) -> bool {
    matches!(shape, Shape::Row)
}

/// Composes laws at compile time: `pipeline![UniformGravity, Drag::default(), Motion]`.
///
/// Contradicting declarations (two laws that set one property, a circle, one name with two units) stop the compiler.
/// Give the result to [`Builder::laws`](crate::engine::Builder::laws).
#[macro_export]
macro_rules! pipeline {
    ($($law:expr),+ $(,)?) => { $crate::pipeline::Chain::new($crate::pipeline!(@list $($law,)+)) };
    (@list) => { () };
    (@list $law:expr, $($rest:expr,)*) => { ($law, $crate::pipeline!(@list $($rest,)*)) };
}
