//! The macros of the vesper law-graph framework: `derive(Law)`, `#[kernel]` and `property!`.
//!
//! In: declarations, as tokens. Out: implementations of the traits of `vesper`, by absolute paths, so that nothing
//! needs to be imported; or, for a wrong declaration, one error at its token, with a stub in place of the law so that
//! nothing else errs. Each macro goes the same way: parse (grammar), check (meaning), expand (cannot fail). Never:
//! physics, and no panic, whatever is written.

mod check;
mod columns;
mod expand;
mod kernel;
mod names;
mod parse;
mod property;
mod stub;
#[cfg(test)]
mod tests;

use proc_macro2::TokenStream;

#[doc = include_str!("law.md")]
#[proc_macro_derive(Law, attributes(law))]
pub fn derive_law(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    law(input.into()).into()
}

/// Stands on the body of a law: `impl<R: Real> RowLaw<R> for ...`, or `PairLaw`, `LinkLaw`, `ColumnLaw`.
///
/// Inlines the body and tells the backends how to compile it for every type of numbers.
#[proc_macro_attribute]
pub fn kernel(arguments: proc_macro::TokenStream, item: proc_macro::TokenStream) -> proc_macro::TokenStream {
    kernel::kernel(arguments.into(), item.into()).into()
}

/// Declares properties: quantities that rows can have.
///
/// ```text
/// property! {
///     /// Place of a row.
///     pub Position: Vector, "m", coordinate;
///     /// Rate of change of the position.
///     pub Velocity: Vector, "m/s", momentum of Position;
///     /// Sum of all forces; starts from the external force where there is one.
///     pub Force: Vector, "N", sum from ExternalForce;
///     /// The two rows that a spring joins.
///     pub Ends: Link<2>;
///     /// Uniform acceleration of free fall.
///     pub GravityAcceleration = "gravity": Vector, "m/s^2";
/// }
/// ```
///
/// The name is the type's in snake case, or the one given after `=`. Kinds are `Scalar`, `Vector`, `Quaternion` and
/// `Link<N>`; all but links have a unit (that of a quaternion may be left out). A role may follow: `coordinate`,
/// `momentum of ...`, `sum`, `sum from ...`, `switch`.
#[proc_macro]
pub fn property(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    property::properties(input.into()).into()
}

/// The derive, over the tokens that tests can make too.
fn law(tokens: TokenStream) -> TokenStream {
    let input: syn::DeriveInput = match syn::parse2(tokens) {
        Ok(input) => input,
        Err(error) => return error.to_compile_error(),
    };
    match parse::Declaration::new(input.clone()).and_then(check::check) {
        Ok(law) => expand::expand(&law),
        Err(error) => stub::stub(&input, &error),
    }
}
