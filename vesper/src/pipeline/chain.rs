//! Laws composed at compile time: one loop, intermediate sums in registers, declarations checked by the compiler.
//!
//! In: `pipeline![UniformGravity, Drag::default(), Motion]`. Out: the same laws as if listed one by one, and, where all
//! of them are row laws, one loop for all, used wherever the graph would have run just these laws in one pass. The
//! order is the graph's, so the bits are the same.

mod check;
mod layout;

pub use layout::{Layout, List};

use super::bind::Binder;
use super::plan::{Op, Operand, Placed};
use crate::backend::{Compile, Compiled};
use crate::law::{Law, Mode, Part, Shape, Sink, Source, Stepped};
use crate::real::{Isa, Lanes, Real, Scalar, WithLanes};
use crate::registry::Tie;
use layout::{REGISTERS, Register};

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

    /// The one loop, where all laws are row laws. `laws`: their numbers in the list, in the order of the chain.
    pub(crate) fn fused<P: Scalar>(&self, laws: Vec<usize>) -> Option<FusedChain<P>> {
        T::SIGNATURES.all_rows().then(|| FusedChain {
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
                            let computed = matches!(self.layout.kinds[register], Register::Sum | Register::Set);
                            if computed {
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
            *operand == Operand::Absent && matches!(self.layout.kinds[register], Register::Given | Register::Constant)
        };
        (!operands.iter().enumerate().any(missing)).then_some(operands)
    }

    /// # Safety
    /// `slots` are null or point to the block's rows (constants: to one number), and nobody else touches states.
    pub(crate) unsafe fn run(&self, isa: Isa, slots: &[*mut P], rows: usize, kick: Option<P>, drift: Option<P>) {
        // SAFETY: passed on to the caller.
        unsafe { self.run.run(isa, slots, rows, kick, drift) };
    }
}

trait ChainRun<P>: Send + Sync {
    /// # Safety
    /// As for [`FusedChain::run`].
    unsafe fn run(&self, isa: Isa, slots: &[*mut P], rows: usize, kick: Option<P>, drift: Option<P>);
}

impl<P: Scalar, T: Chained> ChainRun<P> for Chain<T> {
    unsafe fn run(&self, isa: Isa, slots: &[*mut P], rows: usize, kick: Option<P>, drift: Option<P>) {
        let mut pointers = [core::ptr::null_mut(); REGISTERS];
        pointers[..slots.len()].copy_from_slice(slots);
        let kick = kick.unwrap_or_default();
        match drift {
            Some(drift) => P::with_lanes(isa, Loop::<P, T, true> { laws: &self.0, pointers, rows, kick, drift }),
            None => P::with_lanes(isa, Loop::<P, T, false> { laws: &self.0, pointers, rows, kick, drift: kick }),
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

struct Loop<'a, P, T, const DRIFT: bool> {
    laws: &'a T,
    pointers: [*mut P; REGISTERS],
    rows: usize,
    kick: P,
    drift: P,
}

impl<P: Scalar, T: Chained, const DRIFT: bool> Loop<'_, P, T, DRIFT> {
    #[inline(always)]
    fn load<R: Lanes<P>>(&self, register: usize, row: usize) -> R {
        let from = self.pointers[register];
        // SAFETY: `FusedChain::run` was promised the rows; the same for all blocks here.
        unsafe {
            match const { &T::LAYOUT }.kinds[register] {
                Register::Given => R::load(from.add(row)),
                Register::Constant => R::splat(*from),
                Register::Optional | Register::OptionalConstant | Register::Sum if from.is_null() => R::lit(0.0),
                Register::Optional | Register::Sum => R::load(from.add(row)),
                Register::OptionalConstant => R::splat(*from),
                Register::Set => R::lit(0.0),
            }
        }
    }

    #[inline(always)]
    fn rows<R: Lanes<P>>(&self, bodies: &T::Bodies<R>, row: usize) {
        let zero = R::lit(0.0);
        let mut file = Registers { values: [zero; REGISTERS], rates: [zero; REGISTERS], present: 0 };
        let layout = const { &T::LAYOUT };
        each_register!(|register| if register < layout.count {
            file.values[register] = self.load(register, row);
            let computed = matches!(layout.kinds[register], Register::Sum | Register::Set);
            file.present |= u64::from(computed || !self.pointers[register].is_null()) << register;
        });
        T::steps::<T, R, Kick>(bodies, &mut file);
        each_register!(|register| if layout.kicked[register] {
            file.values[register] += file.rates[register] * R::splat(self.kick);
            // SAFETY: see above.
            unsafe { file.values[register].store(self.pointers[register].add(row)) };
        });
        if !DRIFT {
            return;
        }
        each_register!(|register| if matches!(layout.kinds[register], Register::Sum) {
            file.values[register] = self.load(register, row);
        });
        T::steps::<T, R, Drift>(bodies, &mut file);
        each_register!(|register| if layout.drifted[register] {
            let value = file.values[register] + file.rates[register] * R::splat(self.drift);
            // SAFETY: see above.
            unsafe { value.store(self.pointers[register].add(row)) };
        });
    }
}

impl<P: Scalar, T: Chained, const DRIFT: bool> WithLanes<P> for Loop<'_, P, T, DRIFT> {
    type Output = ();
    #[inline(always)]
    fn with<R: Lanes<P>>(self) {
        let mut row = 0;
        if R::WIDTH > 1 && self.rows >= R::WIDTH {
            let bodies = self.laws.bodies::<R>();
            while row + R::WIDTH <= self.rows {
                self.rows::<R>(&bodies, row);
                row += R::WIDTH;
            }
        }
        let bodies = self.laws.bodies::<P>();
        while row < self.rows {
            self.rows::<P>(&bodies, row);
            row += 1;
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
