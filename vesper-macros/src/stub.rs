//! In: a struct that is no law, and why. Out: the error, once, and as much of a law as keeps its users free of more.
//!
//! The row struct becomes an alias of an array whose length is the error itself: the compiler asks nothing of a type
//! that is already wrong, so a body may use any field of it. (An error in the place of the whole type counts as `()`.)

use proc_macro2::{Literal, TokenStream, TokenTree};
use quote::{format_ident, quote, quote_spanned};
use syn::{DeriveInput, GenericParam};

pub fn stub(input: &DeriveInput, error: &syn::Error) -> TokenStream {
    let name = &input.ident;
    let made: Vec<_> =
        ["Row", "End", "Output", "EndOutput"].iter().map(|suffix| format_ident!("{name}{suffix}")).collect();
    let columns = format_ident!("{name}Columns");
    let (visibility, row) = (&input.vis, &made[0]);
    let mut errors = error.clone().into_iter();
    // The first error is the type; the others stand beside it.
    let first = errors.next().map(|error| length_error(&error));
    let others = errors.map(|error| error.to_compile_error());
    let (_, arguments, clause) = input.generics.split_for_impl();
    let mut bound = input.generics.clone();
    bound.params.push(syn::parse_quote!(VesperNumber: ::vesper::real::Real));
    let (bound, ..) = bound.split_for_impl();
    let (own, ..) = input.generics.split_for_impl();
    let concrete = input.generics.params.iter().map(|parameter| match parameter {
        GenericParam::Lifetime(_) => quote!('static),
        GenericParam::Type(_) => quote!(f64),
        GenericParam::Const(_) => quote!({ 0 }),
    });
    let concrete = quote!(#name<#(#concrete),*>);
    let wrong = quote!(#row<f64>);
    let default = has_defaults(input).then(|| {
        quote! {
            #[automatically_derived]
            impl ::core::default::Default for #concrete {
                fn default() -> Self { loop {} }
            }
        }
    });
    let others_made = made[1..]
        .iter()
        .map(|made| quote!(#[allow(dead_code, missing_docs, type_alias_bounds)] #visibility type #made<R> = #row<R>;));
    quote! {
        #(#others)*
        #[allow(dead_code, missing_docs)]
        #visibility type #row<R> = [R; #first];
        #(#others_made)*
        #[allow(dead_code, missing_docs)]
        #visibility type #columns<'a, P> = #row<P>;
        const _: () = {
            #[automatically_derived]
            impl #bound ::vesper::law::Declared<VesperNumber> for #name #arguments #clause {
                type Row = #wrong;
                type End = #wrong;
                type Output = #wrong;
                type EndOutput = #wrong;
                fn load<VesperSource: ::vesper::law::Source<VesperNumber>>(_: &VesperSource) -> #wrong { loop {} }
                fn load_end<VesperSource: ::vesper::law::Source<VesperNumber>>(_: &VesperSource) -> #wrong { loop {} }
                fn store<VesperSink: ::vesper::law::Sink<VesperNumber>>(_: #wrong, _: &mut VesperSink) {}
                fn store_end<VesperSink: ::vesper::law::Sink<VesperNumber>>(_: #wrong, _: &mut VesperSink) {}
            }
            #[automatically_derived]
            impl #own ::vesper::law::DeclaredColumns for #name #arguments #clause {
                type Columns<'vesper, VesperScalar: ::vesper::real::Scalar> = #wrong;
                unsafe fn columns<'vesper, VesperScalar: ::vesper::real::Scalar>(
                    _: &::vesper::law::ColumnAccess<'vesper, VesperScalar>,
                ) -> #wrong {
                    loop {}
                }
            }
            #[automatically_derived]
            impl ::vesper::law::Law for #concrete {
                const SIGNATURE: ::vesper::law::Signature = { fn wrong() -> #wrong { loop {} } wrong() };
                type Body<VesperNumber: ::vesper::real::Real> = #wrong;
                fn body<VesperNumber: ::vesper::real::Real>(&self) -> #wrong { loop {} }
                fn from_parameters(_: &[f64]) -> Self { loop {} }
            }
            #default
        };
    }
}

/// The error in the place of a length.
fn length_error(error: &syn::Error) -> TokenStream {
    // `to_compile_error` is an item; as an expression it is the macro call alone.
    let span = error.span();
    let mut message = Literal::string(&error.to_string());
    message.set_span(span);
    quote_spanned!(span=> ::core::compile_error!{#message})
}

/// Whether the law would have a default, as far as words tell: no parameter is declared without one.
fn has_defaults(input: &DeriveInput) -> bool {
    let syn::Data::Struct(data) = &input.data else { return true };
    data.fields.iter().flat_map(|field| &field.attrs).filter(|attribute| attribute.path().is_ident("law")).all(
        |attribute| {
            let tokens = attribute.meta.require_list().map(|list| list.tokens.clone()).unwrap_or_default();
            tokens
                .into_iter()
                .any(|token| matches!(&token, TokenTree::Ident(word) if word == "default" || word == "skip"))
        },
    )
}
