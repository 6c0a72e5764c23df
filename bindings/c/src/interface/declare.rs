//! Declares what C sees, once, and lists it for the test that compares the header with the code.
//!
//! In: functions, structures and constants as they are written. Out: the same, exported, and lists of their words. Never: code of
//! a function; that stands where it is declared.

/// A function that is exported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Function {
    /// Its name.
    pub name: &'static str,
    /// Names and types of its parameters, in the words of Rust.
    pub parameters: &'static [(&'static str, &'static str)],
    /// The type of its result.
    pub result: &'static str,
}

/// A structure that C and Rust share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// Its name in Rust.
    pub name: &'static str,
    /// Its name in C.
    pub in_c: &'static str,
    /// Names and types of its fields, in the words of Rust.
    pub fields: &'static [(&'static str, &'static str)],
    /// Its size, in bytes.
    pub size: usize,
}

/// A number that C and Rust share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Constant {
    /// Its name, in both.
    pub name: &'static str,
    /// Its value.
    pub value: i64,
}

/// Exports functions under their names and lists them.
macro_rules! functions {
    ($(#[$list_meta:meta])* $list:ident; $(
        $(#[$meta:meta])*
        fn $name:ident($($parameter:ident: $type:ty),* $(,)?) -> $result:ty $body:block
    )*) => {
        $(
            $(#[$meta])*
            ///
            /// # Safety
            /// Pointers are null, or point to what `vesper.h` says of them.
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name($($parameter: $type),*) -> $result $body
        )*
        $(#[$list_meta])*
        pub const $list: &[$crate::interface::declare::Function] = &[$(
            $crate::interface::declare::Function {
                name: stringify!($name),
                parameters: &[$((stringify!($parameter), stringify!($type))),*],
                result: stringify!($result),
            }
        ),*];
    };
}

/// Declares structures as C has them and lists them.
macro_rules! records {
    ($(#[$list_meta:meta])* $list:ident; $(
        $(#[$meta:meta])*
        struct $name:ident = $in_c:ident { $($(#[$field_meta:meta])* $field:ident: $type:ty),* $(,)? }
    )*) => {
        $(
            $(#[$meta])*
            #[repr(C)]
            #[derive(Clone, Copy, Debug, PartialEq, Eq)]
            pub struct $name { $($(#[$field_meta])* pub $field: $type),* }
        )*
        $(#[$list_meta])*
        pub const $list: &[$crate::interface::declare::Record] = &[$(
            $crate::interface::declare::Record {
                name: stringify!($name),
                in_c: stringify!($in_c),
                fields: &[$((stringify!($field), stringify!($type))),*],
                size: size_of::<$name>(),
            }
        ),*];
    };
}

/// Declares constants of one type and lists them.
macro_rules! constants {
    ($(#[$list_meta:meta])* $list:ident: $type:ty; $($(#[$meta:meta])* $name:ident = $value:literal;)*) => {
        $($(#[$meta])* pub const $name: $type = $value;)*
        $(#[$list_meta])*
        pub const $list: &[$crate::interface::declare::Constant] = &[$(
            $crate::interface::declare::Constant { name: stringify!($name), value: $value }
        ),*];
    };
}

pub(crate) use {constants, functions, records};
