//! The structures that cross from a module to its host, as C has them in `vesper_law.h`; a test compares the two.
//!
//! In: nothing. Out: plain structures of a fixed layout. Never: anything shaped by Rust; a structure that shrinks or changes its
//! meaning: what breaks gets another symbol, `vesper_module_v2`, what grows does so at the end, which `struct_size` tells.

use core::ffi::{c_char, c_void};

/// The version that this host speaks, of which the module's one symbol is named.
pub const VERSION: u32 = 1;
/// The module's one symbol, a function that returns its table.
pub const SYMBOL: &str = "vesper_module_v1";
/// The layout of [`Native`], of a call of rows as the framework's own loops have it, and of what `create` makes: a module and a host that differ in it do without.
pub const NATIVE: u32 = 2;

/// Numbers of single precision: a bit of [`Law::precisions`].
pub const F32: u32 = 1;
/// Numbers of double precision.
pub const F64: u32 = 2;

/// Levels of [`Host::log`], as those of the crate `log`.
pub const LOG_ERROR: u32 = 1;

/// What a module exports.
#[repr(C)]
#[derive(Debug)]
pub struct Module {
    /// [`VERSION`].
    pub abi: u32,
    /// Bytes of this structure.
    pub struct_size: u32,
    /// Who built it, for messages: may be null.
    pub build: *const c_char,
    /// How many laws there are.
    pub law_count: usize,
    /// A pointer to each.
    pub laws: *const *const Law,
}

/// A property that a law touches.
#[repr(C)]
#[derive(Debug)]
pub struct Port {
    /// The property's name, as in scenes.
    pub property: *const c_char,
    /// What the law calls it; null for the property's name.
    pub field: *const c_char,
    /// The unit as written; null for that of the standard property, or else for `si`.
    pub unit: *const c_char,
    /// Exponents of m, kg, s, A, K, mol, cd.
    pub si: [i8; 7],
    /// 1 for a number, 3 for a vector, 4 for a quaternion.
    pub kind: u8,
    /// 1 reads, 2 reads the previous, 3 sets, 4 adds, 5 rates, 6 amends.
    pub mode: u8,
    /// 0 the law's own rows, 1 the scene, 2 a field, 3 the rows linked to.
    pub place: u8,
    /// 0 as the standard property of the name, or else as the mode asks; 1 plain, 2 coordinate, 3 momentum of `role_of`, 4 a sum (from
    /// `role_of`, unless that is null), 5 a turn of `role_of` by `role_by`, 6 a switch.
    pub role: u8,
    /// Whether the law runs without it.
    pub optional: u8,
    /// Whether there is a default, for a constant of the scene.
    pub has_default: u8,
    /// What the role is of.
    pub role_of: *const c_char,
    /// What a turn is by.
    pub role_by: *const c_char,
    /// The default.
    pub default_value: [f64; 3],
    /// For a rate: the numbers of the ports that it depends on, a bit each; 0 for all.
    pub from: u64,
}

/// A parameter of a law.
#[repr(C)]
#[derive(Debug)]
pub struct Parameter {
    /// Its name.
    pub name: *const c_char,
    /// What it means; may be null.
    pub doc: *const c_char,
    /// Its unit as written; null for none.
    pub unit: *const c_char,
    /// 1 for a number, 3 for a vector.
    pub width: u32,
    /// Whether there is a default.
    pub has_default: u32,
    /// The default.
    pub default_value: [f64; 3],
}

/// A law of a module.
#[repr(C)]
#[derive(Debug)]
pub struct Law {
    /// Bytes of this structure.
    pub struct_size: u32,
    /// Bytes of each port.
    pub port_size: u32,
    /// Bytes of each parameter.
    pub parameter_size: u32,
    /// 1 rows, 2 pairs, 3 links, 4 columns.
    pub shape: u32,
    /// [`F32`], [`F64`] or both: what `apply` takes. The host converts the others.
    pub precisions: u32,
    /// [`NATIVE`] where the law looks at [`Call::native`]; 0 otherwise.
    pub native: u32,
    /// The law's name.
    pub name: *const c_char,
    /// What it is; may be null.
    pub doc: *const c_char,
    /// The domain it stands on; null where the scene says, or where only one fits.
    pub domain: *const c_char,
    /// The property that a law of links follows; else null.
    pub link: *const c_char,
    /// How many rows a link joins.
    pub link_arity: u32,
    /// Bits: 1 where the rate of each coordinate is its momentum (`second_order`), 2 where estimates are allowed.
    pub structure: u32,
    /// How many ports.
    pub port_count: usize,
    /// What the law touches: inputs first.
    pub ports: *const Port,
    /// How many parameters.
    pub parameter_count: usize,
    /// Its parameters.
    pub parameters: *const Parameter,
    /// Makes a law from the components of its parameters; not 0 where it cannot.
    pub create: Option<unsafe extern "C" fn(*const Host, *const f64, usize, *mut *mut c_void) -> i32>,
    /// Computes; not 0 where it failed.
    pub apply: Option<unsafe extern "C" fn(*mut c_void, *const Call) -> i32>,
    /// The law's energy in J; null where it does not know.
    pub energy: Option<unsafe extern "C" fn(*mut c_void, *const Call, *mut f64) -> i32>,
    /// Frees what `create` made; may be null.
    pub destroy: Option<unsafe extern "C" fn(*mut c_void)>,
    /// Bytes of the memory that decides what the law does next; 0 for none.
    pub state_size: usize,
    /// Writes that memory.
    pub save: Option<unsafe extern "C" fn(*mut c_void, *mut c_void) -> i32>,
    /// Reads it.
    pub load: Option<unsafe extern "C" fn(*mut c_void, *const c_void) -> i32>,
}

/// What a law may ask of its host. It lives as long as the law.
#[repr(C)]
#[derive(Debug)]
pub struct Host {
    /// Bytes of this structure.
    pub struct_size: u32,
    /// [`VERSION`].
    pub abi: u32,
    /// For `log`.
    pub context: *mut c_void,
    /// Says something: 1 error, 2 warning, 3 information, 4 debugging, 5 traces. The last error is told as the reason of a failure.
    pub log: Option<unsafe extern "C" fn(*mut c_void, u32, *const c_char)>,
}

/// One call of a law.
#[repr(C)]
#[derive(Debug)]
pub struct Call {
    /// Bytes of this structure.
    pub struct_size: u32,
    /// [`F32`] or [`F64`]: what slots point to.
    pub precision: u32,
    /// The rows, links or rows i of pairs to compute: from here,
    pub begin: usize,
    /// to before here.
    pub end: usize,
    /// The rows j of pairs, or all links that there are: from here,
    pub others_begin: usize,
    /// to before here.
    pub others_end: usize,
    /// A pointer for each component of each port, in their order: to row 0, or null where an optional property is absent.
    pub slots: *const *mut c_void,
    /// By slot, numbers from one row to the next: 0 for a constant.
    pub strides: *const usize,
    /// By slot, how many rows there are; null but for column laws.
    pub rows: *const usize,
    /// The rows that links lead to, `link_arity` for each; null for others.
    pub links: *const u32,
    /// For laws that say [`Law::native`]; null for others.
    pub native: *const Native,
}

/// What else Vesper's own loops over pairs and links are told: what [`export_laws!`](crate::export_laws) makes looks at it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Native {
    /// Instructions: 0 scalar, 1 baseline, 2 AVX2, 3 AVX-512.
    pub isa: u32,
    /// [`FIRST`] and [`ESTIMATES`].
    pub flags: u32,
    /// The links to compute, where not those of the range; else null.
    pub list: *const u32,
    /// How many.
    pub list_length: usize,
    /// The rows that shares of links are added to: from here,
    pub own_begin: u32,
    /// to before here.
    pub own_end: u32,
}

/// The sums begin with this law: it stores its shares.
pub const FIRST: u32 = 1;
/// Estimates are allowed.
pub const ESTIMATES: u32 = 2;

/// What crosses as it is, where module and host agree on [`NATIVE`]: whoever changes one of these counts it up.
const _: () = {
    use crate::backend::{AHEAD, RowCall};
    use crate::law::Part;
    use crate::real::{Isa, MAX_WIDTH};
    use core::mem::offset_of;
    assert!(NATIVE == 2 && AHEAD == 2 && MAX_WIDTH == 16);
    assert!(Part::All as u32 == 0 && Part::Coordinates as u32 == 1 && Part::Momenta as u32 == 2);
    assert!(Isa::Scalar.number() == 0 && Isa::Baseline.number() == 1);
    if usize::BITS == 64 {
        type Call = RowCall<'static, f64>;
        let places =
            [offset_of!(Call, slots), offset_of!(Call, uniform), offset_of!(Call, rows), offset_of!(Call, part)];
        assert!(places[0] == 0 && places[1] == 16 && places[2] == 24 && places[3] == 32);
        let places =
            [offset_of!(Call, advance), offset_of!(Call, drift), offset_of!(Call, first), offset_of!(Call, ahead)];
        assert!(places[0] == 40 && places[1] == 56 && places[2] == 72 && places[3] == 80 && size_of::<Call>() == 96);
        assert!(size_of::<RowCall<'static, f32>>() == 72);
    }
};
