//! In: an implementation of `RowLaw`, `PairLaw`, `LinkLaw` or `ColumnLaw` under `#[kernel]`. Out: the same, inlined,
//! with the family of its instances and the way a backend compiles it.

use proc_macro2::{Span, TokenStream};
use quote::{ToTokens, quote, quote_spanned};
use syn::{AngleBracketedGenericArguments, GenericArgument, GenericParam, Ident, ImplItem, Item, ItemImpl, Path};
use syn::{PathArguments, PathSegment, Type, parse_quote};

use crate::names::fault;

const PLACE: &str = "`#[kernel]` stands on `impl RowLaw<R> for ...` (or PairLaw, LinkLaw, ColumnLaw)";

/// The four shapes.
#[derive(Clone, Copy, PartialEq)]
enum Shape {
    Row,
    Pair,
    Link,
    Column,
}

/// The expansion; what stood under the attribute stays, whatever is wrong with it.
pub fn kernel(arguments: TokenStream, item: TokenStream) -> TokenStream {
    let (mut item_impl, made) = match syn::parse2::<Item>(item.clone()) {
        Ok(Item::Impl(item_impl)) => (item_impl, None),
        Ok(other) => (parse_quote!(impl Nothing {}), Some(fault(first_span(&other), PLACE))),
        Err(error) => (parse_quote!(impl Nothing {}), Some(error)),
    };
    if let Some(error) = made {
        let error = error.to_compile_error();
        return quote!(#item #error);
    }
    let family = match arguments.into_iter().next() {
        Some(token) => Err(fault(token.span(), "`#[kernel]` takes no arguments: the trait says which shape it is")),
        None => expand(&mut item_impl),
    };
    match family {
        Ok(family) => quote!(#item_impl #family),
        Err(error) => {
            let (error, stub) = (error.to_compile_error(), stub(&item_impl));
            quote!(#item #error #stub)
        }
    }
}

fn first_span(tokens: &impl ToTokens) -> Span {
    tokens.to_token_stream().into_iter().next().map_or_else(Span::call_site, |token| token.span())
}

/// Inlines the methods and makes the family.
fn expand(item: &mut ItemImpl) -> syn::Result<TokenStream> {
    let Some((trait_path, _)) = &item.trait_ else { return Err(fault(item.impl_token.span, PLACE)) };
    let Some(trait_segment) = trait_path.segments.last().cloned() else {
        return Err(fault(item.impl_token.span, PLACE));
    };
    let shape = match trait_segment.ident.to_string().as_str() {
        "RowLaw" => Shape::Row,
        "PairLaw" => Shape::Pair,
        "LinkLaw" => Shape::Link,
        "ColumnLaw" => Shape::Column,
        _ => return Err(fault(trait_segment.ident.span(), PLACE)),
    };
    let number = number(item, &trait_segment, shape)?;
    let kernel = (*item.self_ty).clone();
    let concrete = concrete(&kernel, &number)?;
    let (mut energy, mut inverse_square) = (false, false);
    for member in &mut item.items {
        if let ImplItem::Fn(function) = member {
            energy |= function.sig.ident == "energy";
            inverse_square |= function.sig.ident == "inverse_square";
            if shape != Shape::Column && !function.attrs.iter().any(|attribute| attribute.path().is_ident("inline")) {
                function.attrs.push(parse_quote!(#[inline(always)]));
            }
        }
    }
    let ends = ends(&trait_segment);
    let (family, bound) = match shape {
        Shape::Row => (quote!(RowFamily), quote!(Real)),
        Shape::Pair => (quote!(PairFamily), quote!(Real)),
        Shape::Link => (quote!(LinkFamily<#ends>), quote!(Real)),
        Shape::Column => (quote!(ColumnFamily), quote!(Scalar)),
    };
    let compile = |precision: TokenStream| match shape {
        Shape::Row => quote!(row::<#precision, Self>),
        Shape::Pair => quote!(pair::<#precision, Self>),
        Shape::Link => quote!(link::<#precision, Self, #ends>),
        Shape::Column => quote!(column::<#precision, Self>),
    };
    let (compile_f32, compile_f64) = (compile(quote!(f32)), compile(quote!(f64)));
    let compile_double_double = compile(quote!(::vesper::real::DoubleDouble));
    let stepped = stepped(shape, &trait_segment, &concrete);
    let energy = (shape != Shape::Column).then(|| quote!(const ENERGY: bool = #energy;));
    let inverse_square = (shape == Shape::Pair).then(|| quote!(const INVERSE_SQUARE: bool = #inverse_square;));
    let checks = [unnamed_number(&concrete, &number), link_of(&trait_segment, &concrete, &number, &ends)];
    Ok(quote! {
        #[automatically_derived]
        impl ::vesper::law::#family for #concrete {
            type Kernel<#number: ::vesper::real::#bound> = #kernel;
            #energy
            #inverse_square
            fn kernel<#number: ::vesper::real::#bound>(&self) -> #kernel {
                <Self as ::vesper::law::Law>::body::<#number>(self)
            }
        }
        #[automatically_derived]
        impl ::vesper::backend::Compile for #concrete {
            #[inline(never)]
            fn compile_f32(&self) -> ::vesper::backend::Compiled<f32> {
                ::vesper::backend::#compile_f32(self)
            }
            #[inline(never)]
            fn compile_f64(&self) -> ::vesper::backend::Compiled<f64> {
                ::vesper::backend::#compile_f64(self)
            }
            #[inline(never)]
            fn compile_double_double(&self) -> ::vesper::backend::Compiled<::vesper::real::DoubleDouble> {
                ::vesper::backend::#compile_double_double(self)
            }
        }
        #stepped
        #(#checks)*
    })
}

/// For a law that is written without its type of numbers: that it has none. Here `Name` may stand for `Name<f64>`, and
/// only the declaration knows; a law that has parameters has a type of numbers.
fn unnamed_number(concrete: &Path, number: &Ident) -> Option<TokenStream> {
    let name = &concrete.segments.last().filter(|last| last.arguments.is_none())?.ident;
    let text = format!("law `{name}` has parameters, so it has a type of numbers: write `for {name}<{number}>`");
    Some(quote_spanned! {name.span()=>
        const _: () =
            ::core::assert!(<#concrete as ::vesper::law::Law>::SIGNATURE.parameters.is_empty(), #text);
    })
}

/// For a link law: that it gets as many rows as its link holds. As an item, it errs where the code is only checked.
fn link_of(trait_segment: &PathSegment, concrete: &Path, number: &Ident, ends: &TokenStream) -> Option<TokenStream> {
    let name = &concrete.segments.last().filter(|_| trait_segment.ident == "LinkLaw")?.ident;
    let text = format!(
        "law `{name}` does not get as many rows as its link holds: write that number in `LinkLaw<{number}, N>`"
    );
    Some(quote_spanned! {trait_segment.ident.span()=>
        const _: () = ::core::assert!(
            match <#concrete as ::vesper::law::Law>::SIGNATURE.link {
                ::core::option::Option::Some(link) => link.kind.width() == #ends,
                ::core::option::Option::None => true,
            },
            #text
        );
    })
}

/// The law as one of several in a loop that was composed at compile time: a row law's body, nothing for others.
fn stepped(shape: Shape, trait_segment: &PathSegment, concrete: &Path) -> TokenStream {
    let shape_name = Ident::new(["Row", "Pair", "Link", "Column"][shape as usize], trait_segment.ident.span());
    let body = (shape == Shape::Row).then(|| {
        quote! {
            let row = <Self::Body<R> as ::vesper::law::Declared<R>>::load(source);
            let output = <Self::Body<R> as ::vesper::law::RowLaw<R>>::row(body, row);
            <Self::Body<R> as ::vesper::law::Declared<R>>::store(output, sink);
        }
    });
    let none = (shape != Shape::Row).then(|| quote!(let _ = (body, source, sink);));
    quote! {
        #[automatically_derived]
        impl ::vesper::law::Stepped for #concrete {
            const SHAPE: ::vesper::law::Shape = ::vesper::law::Shape::#shape_name;
            #[inline(always)]
            fn step<R: ::vesper::real::Real, S: ::vesper::law::Source<R>, K: ::vesper::law::Sink<R>>(
                body: &<Self as ::vesper::law::Law>::Body<R>,
                source: &S,
                sink: &mut K,
            ) {
                #body
                #none
            }
        }
    }
}

/// The one type parameter of the implementation, which is the trait's type of numbers.
fn number(item: &ItemImpl, trait_segment: &PathSegment, shape: Shape) -> syn::Result<Ident> {
    let (name, bound) = (&trait_segment.ident, if shape == Shape::Column { "P: Precision" } else { "R: Real" });
    let letter = &bound[..1];
    let text = format!("a kernel is written once for every type of numbers: `impl<{bound}> {name}<{letter}> for ...`");
    let mut parameters = item.generics.params.iter();
    let number = match (parameters.next(), parameters.next()) {
        (Some(GenericParam::Type(parameter)), None) => parameter.ident.clone(),
        (Some(_), Some(second)) => return Err(fault(first_span(second), text)),
        (Some(other), None) => return Err(fault(first_span(other), text)),
        (None, _) => return Err(fault(name.span(), text)),
    };
    match arguments(trait_segment).and_then(|arguments| arguments.args.first()) {
        Some(GenericArgument::Type(Type::Path(ty))) if ty.path.is_ident(&number) => Ok(number),
        _ => Err(fault(name.span(), text)),
    }
}

fn arguments(segment: &PathSegment) -> Option<&AngleBracketedGenericArguments> {
    match &segment.arguments {
        PathArguments::AngleBracketed(arguments) => Some(arguments),
        _ => None,
    }
}

/// The number of ends of a link body; two where the trait does not say.
fn ends(trait_segment: &PathSegment) -> TokenStream {
    match arguments(trait_segment).and_then(|arguments| arguments.args.iter().nth(1)) {
        Some(ends) => ends.to_token_stream(),
        None => quote!(2),
    }
}

/// The law over `f64`: `Gravity<f64>` for `Gravity<R>`, `Gravity` for `Gravity`.
fn concrete(kernel: &Type, number: &Ident) -> syn::Result<Path> {
    let text = format!("the law of a kernel is `Name<{number}>`, or `Name` where it has no parameters");
    let Type::Path(ty) = kernel else { return Err(fault(first_span(kernel), text)) };
    let mut path = ty.path.clone();
    let Some(last) = path.segments.last_mut() else { return Err(fault(first_span(kernel), text)) };
    match &last.arguments {
        PathArguments::None => return Ok(path),
        PathArguments::AngleBracketed(arguments) if arguments.args.len() == 1 => match arguments.args.first() {
            Some(GenericArgument::Type(Type::Path(ty))) if ty.path.is_ident(number) => {}
            _ => return Err(fault(last.ident.span(), text)),
        },
        _ => return Err(fault(last.ident.span(), text)),
    }
    last.arguments = PathArguments::AngleBracketed(parse_quote!(<f64>));
    Ok(path)
}

/// After a fault: the law counts as compiled, so that the fault is the only error.
fn stub(item: &ItemImpl) -> Option<TokenStream> {
    let (Some(_), Type::Path(ty)) = (&item.trait_, &*item.self_ty) else { return None };
    let mut path = ty.path.clone();
    let last = path.segments.last_mut()?;
    if !last.arguments.is_none() {
        last.arguments = PathArguments::AngleBracketed(parse_quote!(<f64>));
    }
    Some(quote! {
        #[automatically_derived]
        impl ::vesper::backend::Compile for #path {
            fn compile_f32(&self) -> ::vesper::backend::Compiled<f32> { loop {} }
            fn compile_f64(&self) -> ::vesper::backend::Compiled<f64> { loop {} }
            fn compile_double_double(&self) -> ::vesper::backend::Compiled<::vesper::real::DoubleDouble> { loop {} }
        }
    })
}
