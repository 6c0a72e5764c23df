//! The other side: a module made from laws as they are, by [`export_laws!`](crate::export_laws).
//!
//! In: laws with kernels. Out: the table that a host reads, and the functions that it calls, each of which lets no panic out. Never: a
//! host.

use super::abi;
use crate::backend::{Compile, Compiled, Entries, Kernel, LinkCall, Links, PairCall, RowCall, Strided};
use crate::law::{ColumnAccess, Law, MAX_SLOTS, Mode, Part, Place, Port, PortView};
use crate::property::Role;
use crate::real::Scalar;
use core::any::Any;
use core::ffi::{c_char, c_void};
use core::sync::atomic::{AtomicPtr, Ordering};
use std::ffi::CString;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Makes a module of laws: a library that a host finds by name and loads at run time. Stands once in a crate of type `cdylib`, which
/// is built with the feature `modules` of vesper; the laws are as any others, so that the same crate can also be used as it is.
///
/// ```
/// use vesper::prelude::*;
///
/// /// Lift of a wing: a force upwards, by the speed forwards.
/// #[derive(Law, Clone, Copy, Debug)]
/// #[law(reads(velocity: Velocity), adds(force: Force))]
/// pub struct Lift<R = f64> {
///     /// Force per velocity.
///     #[law(unit = "kg/s", default = 0.1)]
///     pub slope: R,
/// }
///
/// #[kernel]
/// impl<R: Real> RowLaw<R> for Lift<R> {
///     fn row(&self, body: LiftRow<R>) -> R::Vec3 {
///         R::Vec3::new(R::lit(0.0), R::lit(0.0), self.slope * body.velocity.x())
///     }
/// }
///
/// vesper::export_laws![Lift];
/// # fn main() {
/// # // SAFETY: the table stays.
/// # assert_eq!(unsafe { (*vesper_module_v1()).law_count }, 1);
/// # }
/// ```
///
/// The symbol is there once in a program: one that is compiled with two such crates has it twice, so that crates which are used in both ways
/// export under a feature of their own. Panics are contained where they unwind, which they do unless a profile says `panic = "abort"`.
///
/// A law with a cut-off cannot be exported, and stops the compiler. Far fields, differences of coordinates in compensated states, pairs that are looked at once, graphics processors and
/// exact derivatives are for laws that a program is compiled with.
#[macro_export]
macro_rules! export_laws {
    [$($law:ty),+ $(,)?] => {
        /// The table of this module's laws, for whoever loads it.
        #[unsafe(no_mangle)]
        pub extern "C" fn vesper_module_v1() -> *const $crate::module::abi::Module {
            static MODULE: ::std::sync::OnceLock<$crate::module::Table> = ::std::sync::OnceLock::new();
            let made = ::std::panic::catch_unwind(|| {
                MODULE.get_or_init(|| {
                    let build = concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION"));
                    $crate::module::Table::new(build, vec![$($crate::module::exported::<$law>()),+])
                })
            });
            made.map_or(::core::ptr::null(), $crate::module::Table::module)
        }
    };
}

/// The table of a module.
#[derive(Debug)]
pub struct Table(&'static abi::Module);

// SAFETY: nobody writes to it, nor to what it points to.
unsafe impl Send for Table {}
// SAFETY: as above.
unsafe impl Sync for Table {}

impl Table {
    /// A table of these laws, kept for the life of the program.
    pub fn new(build: &str, laws: Vec<abi::Law>) -> Self {
        let laws: Vec<*const abi::Law> = laws.into_iter().map(|law| &raw const *Box::leak(Box::new(law))).collect();
        let laws: &'static [*const abi::Law] = Box::leak(laws.into_boxed_slice());
        Table(Box::leak(Box::new(abi::Module {
            abi: abi::VERSION,
            struct_size: size_of::<abi::Module>() as u32,
            build: kept(&format!("{build}, with vesper {}", env!("CARGO_PKG_VERSION"))),
            law_count: laws.len(),
            laws: laws.as_ptr(),
        })))
    }

    /// What the module's one symbol returns.
    pub fn module(&self) -> *const abi::Module {
        self.0
    }
}

/// A text as C has it, kept.
fn kept(text: &str) -> *const c_char {
    let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
    text.into_raw().cast_const()
}

/// A text, or null where it is empty.
fn kept_if_any(text: &str) -> *const c_char {
    if text.is_empty() { core::ptr::null() } else { kept(text) }
}

/// The table of one law.
pub fn exported<L: Law + Compile>() -> abi::Law {
    const {
        assert!(
            L::SIGNATURE.cutoff.is_none(),
            "a law with a `cutoff` cannot be in a module: programs that want it are compiled with its crate"
        );
    };
    let signature = L::SIGNATURE;
    let compiled = L::from_parameters(&[]).compile_f64();
    let shape = match compiled.kernel {
        Kernel::Row(_) => 1,
        Kernel::Pair(_) => 2,
        Kernel::Link(_) => 3,
        Kernel::Column(_) => 4,
    };
    let ports: Vec<abi::Port> = signature.ports.iter().map(port).collect();
    let parameter = |of: &crate::law::Parameter| abi::Parameter {
        name: kept(of.name),
        doc: kept_if_any(of.doc.trim()),
        unit: kept_if_any(of.unit),
        width: of.width as u32,
        has_default: u32::from(of.default.is_some()),
        default_value: of.default.unwrap_or_default(),
    };
    let parameters: Vec<abi::Parameter> = signature.parameters.iter().map(parameter).collect();
    let structure = u32::from(signature.second_order) | u32::from(signature.estimates) << 1;
    abi::Law {
        struct_size: size_of::<abi::Law>() as u32,
        port_size: size_of::<abi::Port>() as u32,
        parameter_size: size_of::<abi::Parameter>() as u32,
        shape,
        precisions: abi::F32 | abi::F64,
        native: abi::NATIVE,
        name: kept(signature.name),
        doc: kept_if_any(signature.doc),
        domain: signature.domain.map_or(core::ptr::null(), kept),
        link: signature.link.map_or(core::ptr::null(), |link| kept(link.name)),
        link_arity: signature.link.map_or(0, |link| link.kind.width() as u32),
        structure,
        port_count: ports.len(),
        ports: Box::leak(ports.into_boxed_slice()).as_ptr(),
        parameter_count: parameters.len(),
        parameters: Box::leak(parameters.into_boxed_slice()).as_ptr(),
        create: Some(create::<L>),
        apply: Some(apply),
        energy: compiled.energy.then_some(energy as unsafe extern "C" fn(_, _, _) -> _),
        destroy: Some(destroy),
        state_size: 0,
        save: None,
        load: None,
    }
}

fn port(of: &Port) -> abi::Port {
    let (role, role_of, role_by) = match of.property.role {
        Role::Plain => (1, None, None),
        Role::Coordinate => (2, None, None),
        Role::Momentum(coordinate) => (3, Some(coordinate), None),
        Role::Sum { start } => (4, start, None),
        Role::Turn { of, by } => (5, Some(of), Some(by)),
        Role::Switch => (6, None, None),
    };
    abi::Port {
        property: kept(of.property.name),
        field: kept(of.field),
        unit: kept_if_any(of.property.unit),
        si: of.property.size.dimension.exponents(),
        kind: of.property.kind.width() as u8,
        mode: match of.mode {
            Mode::Reads => 1,
            Mode::Previous => 2,
            Mode::Sets => 3,
            Mode::Adds => 4,
            Mode::Rates => 5,
            Mode::Amends => 6,
        },
        place: match of.place {
            Place::Own => 0,
            Place::Scene => 1,
            Place::Field => 2,
            Place::End => 3,
        },
        role,
        optional: u8::from(of.optional),
        has_default: u8::from(of.default.is_some()),
        role_of: role_of.map_or(core::ptr::null(), kept),
        role_by: role_by.map_or(core::ptr::null(), kept),
        default_value: of.default.unwrap_or_default(),
        from: of.from,
    }
}

/// A law that a host made.
#[repr(C)]
struct Made {
    /// What the host looks at itself: it comes first.
    entries: Entries,
    single: Compiled<f32>,
    double: Compiled<f64>,
    /// Numbers that it touches.
    slots: usize,
    host: Host,
}

/// A kernel of rows panicked.
///
/// # Safety
/// `create` made `this`.
unsafe fn rows_panicked(this: *mut c_void, panic: &(dyn Any + Send)) -> i32 {
    // SAFETY: passed on to the caller.
    panicked(unsafe { (*this.cast::<Made>()).host }, panic)
}

/// Whom to tell.
#[derive(Clone, Copy)]
struct Host(*const abi::Host);

// SAFETY: a host may be spoken to from any thread.
unsafe impl Send for Host {}
// SAFETY: as above.
unsafe impl Sync for Host {}

impl Host {
    fn say(self, level: u32, text: &str) {
        // SAFETY: a host lives as long as its laws.
        let Some(host) = (unsafe { self.0.as_ref() }) else { return };
        if let (Some(log), Ok(text)) = (host.log, CString::new(text.replace('\0', " "))) {
            // SAFETY: the text ends with a zero.
            unsafe { log(host.context, level, text.as_ptr()) };
        }
    }
}

/// What the module's own crates log goes to the host of its first law: a library has a logger of its own, and nobody listens to it.
struct Forward(AtomicPtr<abi::Host>);
static FORWARD: Forward = Forward(AtomicPtr::new(core::ptr::null_mut()));

impl log::Log for Forward {
    fn enabled(&self, _metadata: &log::Metadata<'_>) -> bool {
        true
    }
    fn log(&self, record: &log::Record<'_>) {
        // An error that is only told is no failure: nobody takes it for the reason of one.
        let level = (record.level() as u32).max(abi::LOG_ERROR + 1);
        Host(self.0.load(Ordering::Acquire)).say(level, &record.args().to_string());
    }
    fn flush(&self) {}
}

/// Runs `work`, and tells the host of a panic.
fn contained(host: Host, work: impl FnOnce() -> Result<(), String>) -> i32 {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => 0,
        Ok(Err(text)) => {
            host.say(abi::LOG_ERROR, &text);
            -1
        }
        Err(panic) => panicked(host, &*panic),
    }
}

#[cold]
fn panicked(host: Host, panic: &(dyn Any + Send)) -> i32 {
    host.say(abi::LOG_ERROR, &format!("it panicked: {}", words(panic)));
    -2
}

fn words(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("without a word")
}

unsafe extern "C" fn create<L: Law + Compile>(
    host: *const abi::Host,
    parameters: *const f64,
    count: usize,
    to: *mut *mut c_void,
) -> i32 {
    contained(Host(host), || {
        if FORWARD
            .0
            .compare_exchange(core::ptr::null_mut(), host.cast_mut(), Ordering::AcqRel, Ordering::Relaxed)
            .is_ok()
        {
            // Where the module is a part of its host, that has a logger already.
            if log::set_logger(&FORWARD).is_ok() {
                log::set_max_level(log::LevelFilter::Trace);
            }
        }
        // SAFETY: the host gives so many numbers.
        let given = if count == 0 { &[] } else { unsafe { core::slice::from_raw_parts(parameters, count) } };
        let law = L::from_parameters(given);
        let slots = L::SIGNATURE.ports.iter().map(|port| port.property.kind.width()).sum();
        let (single, double) = (law.compile_f32(), law.compile_f64());
        let entries = Entries::new(&single.kernel, &double.kernel, rows_panicked);
        let made = Made { entries, single, double, slots, host: Host(host) };
        // SAFETY: the host has a place for it.
        unsafe { *to = Box::into_raw(Box::new(made)).cast() };
        Ok(())
    })
}

unsafe extern "C" fn destroy(this: *mut c_void) {
    // SAFETY: `create` made it, and the host has no other.
    let made = unsafe { Box::from_raw(this.cast::<Made>()) };
    _ = contained(made.host, || {
        drop(made);
        Ok(())
    });
}

unsafe extern "C" fn apply(this: *mut c_void, call: *const abi::Call) -> i32 {
    // SAFETY: `create` made it, and the host gives a call.
    let (made, call) = unsafe { (&*this.cast_const().cast::<Made>(), &*call) };
    // SAFETY: the host promises the slots.
    let went = catch_unwind(AssertUnwindSafe(|| unsafe {
        match call.precision {
            abi::F32 => run(&made.single, made, call),
            abi::F64 => run(&made.double, made, call),
            _ => return false,
        }
        true
    }));
    match went {
        Ok(true) => 0,
        Ok(false) => {
            let precision = call.precision;
            contained(made.host, || Err(format!("it was called with numbers of precision {precision}")))
        }
        Err(panic) => panicked(made.host, &*panic),
    }
}

unsafe extern "C" fn energy(this: *mut c_void, call: *const abi::Call, to: *mut f64) -> i32 {
    // SAFETY: as in `apply`.
    let (made, call) = unsafe { (&*this.cast_const().cast::<Made>(), &*call) };
    contained(made.host, || {
        // SAFETY: as above; there is a place for the energy.
        unsafe {
            *to = match call.precision {
                abi::F32 => energy_of(&made.single, made, call),
                _ => energy_of(&made.double, made, call),
            };
        }
        Ok(())
    })
}

/// A call, taken apart.
struct Taken<'a, P> {
    slots: &'a [*mut P],
    strides: &'a [usize],
    native: Option<&'a abi::Native>,
}

impl<P> Taken<'_, P> {
    /// # Safety
    /// The call is of this law.
    #[inline(always)]
    unsafe fn new<'a>(made: &Made, call: &'a abi::Call) -> Taken<'a, P> {
        // SAFETY: passed on to the caller; a pointer to anything has the layout of a pointer to numbers.
        unsafe {
            Taken {
                slots: core::slice::from_raw_parts(call.slots.cast(), made.slots),
                strides: core::slice::from_raw_parts(call.strides, made.slots),
                native: call.native.as_ref(),
            }
        }
    }
}

/// # Safety
/// The call is of this law, and the host keeps its promises.
unsafe fn row_call<P: Scalar, T>(taken: &Taken<'_, P>, call: &abi::Call, then: impl FnOnce(&RowCall<'_, P>) -> T) -> T {
    let mut slots = [core::ptr::null_mut(); MAX_SLOTS];
    for (slot, (start, stride)) in taken.slots.iter().zip(taken.strides).enumerate() {
        slots[slot] = start.wrapping_add(if start.is_null() { 0 } else { call.begin * stride });
    }
    then(&RowCall {
        slots: slots[..taken.slots.len()].into(),
        uniform: 0,
        rows: call.end - call.begin,
        part: Part::All,
        advance: None.into(),
        drift: None.into(),
        first: false,
        ahead: [core::ptr::null(); 2],
    })
}

fn pair_call<'a, P: Scalar>(taken: &Taken<'a, P>, call: &abi::Call) -> PairCall<'a, P> {
    let flags = taken.native.map_or(0, |native| native.flags);
    PairCall {
        slots: taken.slots,
        rests: &[],
        rows: call.begin..call.end,
        others: call.others_begin..call.others_end,
        first: flags & abi::FIRST != 0,
        estimates: flags & abi::ESTIMATES != 0,
        square: P::default(),
    }
}

/// # Safety
/// As for `row_call`.
unsafe fn link_call<P: Scalar, T>(
    taken: &Taken<'_, P>,
    call: &abi::Call,
    arity: usize,
    then: impl FnOnce(&LinkCall<'_, P>) -> T,
) -> T {
    let mut slots = [Strided { start: core::ptr::null_mut(), stride: 0 }; MAX_SLOTS];
    for (slot, (start, stride)) in taken.slots.iter().zip(taken.strides).enumerate() {
        slots[slot] = Strided { start: *start, stride: *stride };
    }
    // SAFETY: passed on to the caller.
    unsafe {
        let ends =
            if call.links.is_null() { &[] } else { core::slice::from_raw_parts(call.links, call.others_end * arity) };
        let list = taken.native.filter(|native| !native.list.is_null());
        let links = list.map_or(Links::First(call.end), |native| {
            Links::Listed(core::slice::from_raw_parts(native.list, native.list_length))
        });
        let rows = taken.native.map_or(0..u32::MAX, |native| native.own_begin..native.own_end);
        then(&LinkCall { slots: &slots[..taken.slots.len()], ends, links, rows })
    }
}

/// # Safety
/// As for `row_call`.
unsafe fn run<P: Scalar>(compiled: &Compiled<P>, made: &Made, call: &abi::Call) {
    // SAFETY: passed on to the caller.
    unsafe {
        let taken = Taken::new(made, call);
        let isa = made.entries.isa(taken.native.map_or(0, |native| native.isa));
        match &compiled.kernel {
            Kernel::Row(kernel) => row_call(&taken, call, |call| kernel.run(isa, call)),
            Kernel::Pair(kernel) => kernel.run(isa, &pair_call(&taken, call)),
            Kernel::Link(kernel) => link_call(&taken, call, kernel.arity(), |call| kernel.run(isa, call)),
            Kernel::Column(kernel) => {
                let rows = core::slice::from_raw_parts(call.rows, taken.slots.len());
                let mut from = 0;
                let view = |port: &Port| {
                    let mut components = [core::ptr::null_mut(); 4];
                    let width = port.property.kind.width();
                    components[..width].copy_from_slice(&taken.slots[from..from + width]);
                    let view = PortView { components, stride: taken.strides[from].max(1), rows: rows[from] };
                    from += width;
                    view
                };
                let views: Vec<PortView<P>> = compiled.signature.ports.iter().map(view).collect();
                let arity = compiled.signature.link.map_or(1, |link| link.kind.width());
                let link = (!call.links.is_null())
                    .then(|| (core::slice::from_raw_parts(call.links, call.others_end * arity), arity));
                kernel.run(&ColumnAccess::new(&views, link));
            }
        }
    }
}

/// # Safety
/// As for `row_call`.
unsafe fn energy_of<P: Scalar>(compiled: &Compiled<P>, made: &Made, call: &abi::Call) -> f64 {
    // SAFETY: passed on to the caller.
    let energy = unsafe {
        let taken = Taken::new(made, call);
        match &compiled.kernel {
            Kernel::Row(kernel) => row_call(&taken, call, |call| kernel.energy(call)),
            Kernel::Pair(kernel) => kernel.energy(&pair_call(&taken, call)),
            Kernel::Link(kernel) => link_call(&taken, call, kernel.arity(), |call| kernel.energy(call)),
            Kernel::Column(_) => None,
        }
    };
    energy.unwrap_or(0.0)
}
