//! In: a checked [`Law`]. Out: the struct of whole columns that a column law gets, and how it is filled.
//!
//! A column that the law both reads and amends is two fields, one to look and one to write; the core's slices allow it.

use std::collections::BTreeSet;

use proc_macro2::TokenStream;
use quote::{format_ident, quote, quote_spanned};
use syn::Ident;
use syn::spanned::Spanned;

use crate::check::{Law, is_output};
use crate::expand::{is_optional, local, port_doc, value};
use crate::parse::{Mode, Place, Port};

/// The struct `...Columns` and `vesper::law::DeclaredColumns`.
pub fn expand(law: &Law) -> TokenStream {
    let (visibility, name, number) = (&law.visibility, law.made("Columns"), law.number());
    let (law_name, owner) = (law.name.to_string(), law.over(&number));
    let doc = format!("Columns of [`{law_name}`] for a column law.");
    let access = local("access");
    let (mut fields, mut values) = (Vec::new(), Vec::new());
    for (field, column) in columns(law) {
        let (doc, ty, value) = match column {
            Column::Link => {
                let ty = quote!(::vesper::law::LinkSlice<'a>);
                ("Rows that each row links to.".to_string(), ty, quote!(#access.link()))
            }
            Column::Port(number, port) => {
                let (ty, value) = port_column(&access, number, port);
                (port_doc(port), ty, value)
            }
        };
        fields.push(quote!(#[doc = #doc] pub #field: #ty,));
        values.push(quote!(#field: #value,));
    }
    let name_text = name.to_string();
    // For every type of numbers: a column body is one for each precision.
    let generics = law.real.as_ref().map(|number| quote!(<#number: ::vesper::real::Real>));
    quote! {
        #[doc = #doc]
        #visibility struct #name<'a, P: ::vesper::real::Scalar> { #(#fields)* }

        #[automatically_derived]
        impl<P: ::vesper::real::Scalar> ::core::fmt::Debug for #name<'_, P> {
            fn fmt(&self, f: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                f.debug_struct(#name_text).finish_non_exhaustive()
            }
        }

        #[automatically_derived]
        impl #generics ::vesper::law::DeclaredColumns for #owner {
            type Columns<'a, P: ::vesper::real::Scalar> = #name<'a, P>;
            unsafe fn columns<'a, P: ::vesper::real::Scalar>(
                #access: &::vesper::law::ColumnAccess<'a, P>,
            ) -> #name<'a, P> {
                #[allow(unused_unsafe, clippy::undocumented_unsafe_blocks)]
                // SAFETY: the caller promises that `access` was made for this law's signature.
                unsafe { #name { #(#values)* } }
            }
        }
    }
}

/// What a field of the struct is.
enum Column<'a> {
    Port(usize, &'a Port),
    Link,
}

/// The type of a port's field, and the expression that fills it.
fn port_column(access: &Ident, number: usize, port: &Port) -> (TokenStream, TokenStream) {
    let property = &port.property;
    let span = property.span();
    let (ty, take) = if is_output(port) {
        (quote_spanned!(span=> ::vesper::law::SliceMut<'a, #property, P>), "slice_mut")
    } else if port.place == Place::Scene {
        (value(property, &Ident::new("P", span)), "constant")
    } else {
        (quote_spanned!(span=> ::vesper::law::Slice<'a, #property, P>), "slice")
    };
    let (ty, optional) = if is_optional(port) { (quote!(::core::option::Option<#ty>), "optional_") } else { (ty, "") };
    let take = Ident::new(&format!("{optional}{take}"), span);
    (ty, quote_spanned!(span=> #access.#take::<#property>(#number)))
}

/// The fields, each with a name of its own.
fn columns(law: &Law) -> Vec<(Ident, Column<'_>)> {
    let mut taken = BTreeSet::new();
    let mut made = Vec::new();
    let mut add = |wanted: Ident, column| {
        let mut name = wanted;
        while !taken.insert(name.to_string()) {
            name = format_ident!("{}_", name);
        }
        made.push((name, column));
    };
    for (number, port) in law.side(false, false) {
        add(previous(law, port), Column::Port(number, port));
    }
    for (number, port) in law.side(true, false) {
        let read =
            law.side(false, false).iter().any(|(_, other)| other.mode == Mode::Reads && other.field == port.field);
        let name = match port.mode {
            Mode::Rates if read => format_ident!("{}_rate", port.field),
            Mode::Amends if read => format_ident!("{}_amended", port.field),
            _ => port.field.clone(),
        };
        add(name, Column::Port(number, port));
    }
    let Some(link) = &law.link else { return made };
    add(link.field.clone(), Column::Link);
    for output in [false, true] {
        for (number, port) in law.side(output, true) {
            let own = law.ports.iter().any(|other| other.place != Place::End && other.field == port.field);
            let name = previous(law, port);
            let name = if own || port.field == link.field { format_ident!("{}_{}", link.field, name) } else { name };
            add(name, Column::Port(number, port));
        }
    }
    made
}

/// The name of an input; that of a previous value says so where an output has the plain name.
fn previous(law: &Law, port: &Port) -> Ident {
    let output = |other: &Port| {
        is_output(other) && (other.place == Place::End) == (port.place == Place::End) && other.field == port.field
    };
    if port.mode == Mode::Previous && law.ports.iter().any(output) {
        format_ident!("previous_{}", port.field)
    } else {
        port.field.clone()
    }
}
