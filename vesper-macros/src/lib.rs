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

/// Declares a law of physics: what it reads and changes, and its parameters.
///
/// ```text
/// /// Newton's law of universal gravitation between point masses.
/// #[derive(Law, Clone, Copy, Debug)]
/// #[law(domain = "bodies", reads(position: Position, mass: Mass), adds(force: Force))]
/// pub struct Gravity<R = f64> {
///     /// Constant of gravitation.
///     #[law(unit = "m^3 kg^-1 s^-2", default = 6.674_30e-11)]
///     pub g: R,
/// }
/// ```
///
/// Inside the struct's `#[law(...)]`:
///
/// | written | says |
/// |---|---|
/// | `domain = "bodies"` | the domain it stands on where the builder does not say |
/// | `reads(p: P, previous q: Q)` | values of the row, of this or the previous evaluation |
/// | `reads(p: P, optional)` | the whole group may be missing; values are `Option` |
/// | `scene(g: G, c: C = 1.0)` | constants of the domain "scene"; with a default, never missing |
/// | `fields(e: E)` | functions of position and time, sampled at the row's position |
/// | `sets(p: P)` | computes anew |
/// | `adds(p: P)` | adds a share |
/// | `rates(p: P from (q, r))` | gives the rate of change, from these of its reads; without `from`, from all |
/// | `amends(p: P)` | corrects after a step |
/// | `link(ends: Ends, reads(p: P), adds(f: F))` | rows of another domain that each row links to |
///
/// On a field: `#[law(unit = "m", default = 0.0)]` for a parameter (`R`, or `R::Vec3` with a default `[x, y, z]`; for
/// that the struct says `R: Real = f64`), and `#[law(skip)]` for what is no parameter. A skipped field is cloned into
/// each body; where its type depends on `R`, it is made by `Default`. What a list of parameters
/// (`Law::from_parameters`) leaves out has its default; a parameter without one is NaN then, so that it shows.
///
/// For a law `Gravity` this makes `GravityRow` (what a body gets of a row), `GravityEnd` (of a row linked to),
/// `GravityOutput` and `GravityEndOutput` (what it gives, where that is more than one value) and `GravityColumns`
/// (whole columns, for column laws). There an output with the name of an input is called `..._rate` or `..._amended`,
/// a previous value with the name of an output `previous_...`, and a value of an end with the name of one of the row
/// has the link's name before it: `ends_position`.
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
/// `momentum of ...`, `sum`, `sum from ...`.
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
