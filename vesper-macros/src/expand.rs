//! In: a checked [`Law`]. Out: its row, end and output structs, and its implementations of `vesper::law::Declared`,
//! `vesper::law::Law` and `Default`. Nothing here can fail.

use proc_macro2::{Literal, Span, TokenStream};
use quote::{format_ident, quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{Ident, Path};

use crate::check::{Law, Member, is_output, text};
use crate::columns;
use crate::parse::{Mode, Number, Place, Port, WORDS};

/// A port with its number.
pub type Numbered<'a> = (usize, &'a Port);

impl Law {
    /// The name of the type of numbers in what is made.
    pub fn number(&self) -> Ident {
        self.real.clone().unwrap_or_else(|| Ident::new("R", Span::call_site()))
    }

    /// The law over `number`, or the law as it is where it has no type parameter.
    pub fn over(&self, number: impl quote::ToTokens) -> TokenStream {
        let name = &self.name;
        if self.real.is_some() { quote!(#name<#number>) } else { quote!(#name) }
    }

    /// Inputs or outputs, of the row or of its ends.
    pub fn side(&self, output: bool, end: bool) -> Vec<Numbered<'_>> {
        let ports = self.ports.iter().enumerate().filter(|(_, port)| !port.hidden);
        ports.filter(|(_, port)| is_output(port) == output && (port.place == Place::End) == end).collect()
    }

    /// The type of what the body gives, to the row or to an end.
    fn output(&self, end: bool) -> TokenStream {
        let number = self.number();
        match self.side(true, end).as_slice() {
            [] => quote!(()),
            [(_, port)] => value(&port.property, &number),
            _ => {
                let name = self.made(if end { "EndOutput" } else { "Output" });
                quote!(#name<#number>)
            }
        }
    }

    /// `GravityRow` and the like.
    pub fn made(&self, suffix: &str) -> Ident {
        format_ident!("{}{}", self.name, suffix)
    }
}

/// Everything that the derive makes of a law.
pub fn expand(law: &Law) -> TokenStream {
    let (row, declared, columns) = (structs(law), declared(law), columns::expand(law));
    let (signature, default) = (implementation(law), default(law));
    let slots = slots(law);
    // All tokens at the law's name, so that the error of a law without a kernel stands there.
    let name = &law.name;
    let number = law.real.as_ref().map(|_| quote_spanned!(name.span()=> <f64>));
    let kernel = quote_spanned! {name.span()=>
        const _: fn() = || {
            fn needs_kernel<L: ::vesper::backend::Compile>() {}
            needs_kernel::<#name #number>();
        };
    };
    quote! {
        #row
        #columns
        const _: () = {
            #slots
            #declared
            #signature
            #default
        };
        #kernel
    }
}

/// The type of a property's value. Its tokens stand at the property, as the errors of what is no property shall.
pub fn value(property: &Path, number: &Ident) -> TokenStream {
    quote_spanned!(property.span()=> ::vesper::property::ValueOf<#property, #number>)
}

fn info(property: &Path) -> TokenStream {
    quote_spanned!(property.span()=> <#property as ::vesper::property::Property>::INFO)
}

/// The structs that a body gets and gives.
fn structs(law: &Law) -> TokenStream {
    let mut made = TokenStream::new();
    let name = &law.name;
    let sides = [
        ("Row", format!("What a body of [`{name}`] gets of a row."), false, false, true),
        (
            "End",
            format!("What a body of [`{name}`] gets of a row that its link leads to."),
            false,
            true,
            law.link.is_some(),
        ),
        ("Output", format!("What a body of [`{name}`] gives to a row."), true, false, false),
        ("EndOutput", format!("What a body of [`{name}`] gives to a row that its link leads to."), true, true, false),
    ];
    for (suffix, doc, output, end, always) in sides {
        let ports = law.side(output, end);
        if !always && (!output || ports.len() < 2) {
            continue;
        }
        let (visibility, number, name) = (&law.visibility, law.number(), law.made(suffix));
        let fields = ports.iter().map(|(_, port)| {
            let (field, value, doc) = (&port.field, value(&port.property, &number), port_doc(port));
            let value = if is_optional(port) { quote!(::core::option::Option<#value>) } else { value };
            quote!(#[doc = #doc] pub #field: #value,)
        });
        let marker = ports.is_empty().then(|| quote!(#[doc(hidden)] pub marker: ::core::marker::PhantomData<#number>,));
        made.extend(quote! {
            #[doc = #doc]
            #[derive(Clone, Copy, Debug)]
            #visibility struct #name<#number: ::vesper::real::Real> { #(#fields)* #marker }
        });
    }
    made
}

/// What a field that stands for a port says of itself.
pub fn port_doc(port: &Port) -> String {
    let property = text(&port.property);
    let what = match port.mode {
        Mode::Reads => "Value of",
        Mode::Previous => "Value in the previous evaluation of",
        Mode::Sets => "New value of",
        Mode::Adds => "Share added to",
        Mode::Rates => "Rate of change of",
        Mode::Amends => "Corrected value of",
    };
    let place = match port.place {
        Place::Own => "",
        Place::Scene => ", a constant of the scene",
        Place::Field => ", sampled at the row's position",
        Place::End => ", of the row linked to",
    };
    let optional = if is_optional(port) { "; optional" } else { "" };
    format!("{what} `{property}`{place}{optional}.")
}

/// Whether the body gets an `Option`.
pub fn is_optional(port: &Port) -> bool {
    port.optional.is_some()
}

/// The first component of every port, and the checks of what only the properties know.
fn slots(law: &Law) -> TokenStream {
    let ends = law.ports.len() + 1;
    let widths = law.ports.iter().map(|port| {
        let info = info(&port.property);
        quote!(#info.kind.width())
    });
    let defaults = law.ports.iter().filter_map(|port| {
        let Number { span, vector, .. } = port.default.as_ref()?;
        let (info, width) = (info(&port.property), if *vector { 3_usize } else { 1 });
        let text = format!("the default of constant `{}` has {width} components, its property has not", port.field);
        Some(quote_spanned!(*span=> const _: () = ::core::assert!(#info.kind.width() == #width, #text);))
    });
    quote! {
        const SLOTS: [usize; #ends] = ::vesper::law::slots(&[#(#widths),*]);
        #(#defaults)*
    }
}

/// How the values of a row are loaded and the results stored.
fn declared(law: &Law) -> TokenStream {
    let number = law.number();
    let (name, row) = (law.over(&number), law.made("Row"));
    let end = if law.link.is_some() {
        let end = law.made("End");
        quote!(#end<#number>)
    } else {
        quote!(())
    };
    let (output, end_output) = (law.output(false), law.output(true));
    let ends = law.side(false, true);
    let load_row = load(law, false);
    let load_end = law.link.as_ref().map(|_| load(law, true));
    let end_source = used("source", &ends);
    let source = used("source", &law.side(false, false));
    let (store_row, store_end) = (store(law, false), store(law, true));
    quote! {
        #[automatically_derived]
        impl<#number: ::vesper::real::Real> ::vesper::law::Declared<#number> for #name {
            type Row = #row<#number>;
            type End = #end;
            type Output = #output;
            type EndOutput = #end_output;
            #[inline(always)]
            fn load<VesperSource: ::vesper::law::Source<#number>>(#source: &VesperSource) -> Self::Row { #load_row }
            #[inline(always)]
            fn load_end<VesperSource: ::vesper::law::Source<#number>>(#end_source: &VesperSource) -> Self::End { #load_end }
            #store_row
            #store_end
        }
    }
}

/// The name of a function's argument, with `_` before it where no port uses it.
fn used(name: &str, ports: &[Numbered]) -> Ident {
    let underscore = if ports.is_empty() { "_" } else { "" };
    local(&format!("{underscore}{name}"))
}

/// The name of a value within an expansion. Its span is no token's of the declaration: in a law that a `macro_rules!`
/// makes, such tokens come from several places, and a name from one of them is unknown in another.
pub fn local(name: &str) -> Ident {
    Ident::new(name, Span::mixed_site())
}

/// The expression that loads a row or an end.
fn load(law: &Law, end: bool) -> TokenStream {
    let (number, ports, name) = (law.number(), law.side(false, end), law.made(if end { "End" } else { "Row" }));
    let source = used("source", &ports);
    let fields = ports.iter().map(|&(i, port)| {
        let (field, property) = (&port.field, &port.property);
        let read = Ident::new(if is_optional(port) { "read_optional" } else { "read" }, property.span());
        let place = format_ident!("{}", format!("{:?}", port.place));
        quote_spanned! {property.span()=>
            #field: ::vesper::law::#read::<#property, #number, VesperSource>(
                #source, ::vesper::law::Place::#place, #i, SLOTS[#i]
            ),
        }
    });
    let marker = ports.is_empty().then(|| quote!(marker: ::core::marker::PhantomData));
    quote!(#name { #(#fields)* #marker })
}

/// The function that stores the results for a row or an end.
fn store(law: &Law, end: bool) -> TokenStream {
    let (number, ports) = (law.number(), law.side(true, end));
    let (function, output) = if end { (quote!(store_end), quote!(EndOutput)) } else { (quote!(store), quote!(Output)) };
    let (argument, sink) = (used("output", &ports), used("sink", &ports));
    let writes = ports.iter().map(|&(i, port)| {
        let (property, field) = (&port.property, &port.field);
        let mode = format_ident!("{}", format!("{:?}", port.mode));
        let result = if ports.len() == 1 { quote!(#argument) } else { quote!(#argument.#field) };
        quote_spanned! {property.span()=>
            ::vesper::law::write::<#property, #number, VesperSink>(#sink, ::vesper::law::Mode::#mode, SLOTS[#i], #result);
        }
    });
    quote! {
        #[inline(always)]
        fn #function<VesperSink: ::vesper::law::Sink<#number>>(#argument: Self::#output, #sink: &mut VesperSink) {
            #(#writes)*
        }
    }
}

/// The signature, the body and the law from its parameters.
fn implementation(law: &Law) -> TokenStream {
    let (number, concrete) = (law.number(), law.over(quote!(f64)));
    let (name, body) = (&law.name, law.over(law.number()));
    let ports = law.ports.iter().zip(&law.from).map(|(port, &from)| signature_port(port, from));
    let parameters = law.members.iter().filter_map(signature_parameter);
    let (snake, doc) = (&law.snake, &law.doc);
    let words = WORDS.iter().map(|word| {
        let (field, said) = (format_ident!("{word}"), law.words.iter().any(|said| said == word));
        quote!(#field: #said,)
    });
    let cutoff = option(law.cutoff.map(|component| quote!(#component)));
    let domain = option(law.domain.as_ref().map(|domain| quote!(#domain)));
    let link = option(law.link.as_ref().map(|link| info(&link.property)));
    let bodies = law.members.iter().map(|member| match member {
        Member::Parameter { name, vector: false, .. } => {
            quote!(#name: <#number as ::vesper::real::Real>::lit(self.#name),)
        }
        Member::Parameter { name, .. } => quote! {
            #name: <<#number as ::vesper::real::Real>::Vec3 as ::vesper::real::Vector<#number>>::lit(self.#name),
        },
        Member::Kept { name } => quote!(#name: ::core::clone::Clone::clone(&self.#name),),
        Member::Fresh { name } => quote!(#name: ::core::default::Default::default(),),
    });
    let mut component = 0;
    let values: Vec<TokenStream> = law.members.iter().map(|member| from_values(member, &mut component)).collect();
    let own = law.members.iter().flat_map(|member| match member {
        Member::Parameter { name, vector: false, .. } => vec![quote!(self.#name)],
        Member::Parameter { name, .. } => {
            let component = |axis: TokenStream| quote!(::vesper::real::Vector::<f64>::#axis(self.#name));
            vec![component(quote!(x)), component(quote!(y)), component(quote!(z))]
        }
        Member::Kept { .. } | Member::Fresh { .. } => Vec::new(),
    });
    let argument = if component == 0 { quote!(_values) } else { quote!(values) };
    quote! {
        const PORTS: &[::vesper::law::Port] = &[#(#ports),*];
        const PARAMETERS: &[::vesper::law::Parameter] = &[#(#parameters),*];
        #[automatically_derived]
        impl ::vesper::law::Law for #concrete {
            const SIGNATURE: ::vesper::law::Signature = ::vesper::law::Signature {
                name: #snake,
                doc: #doc,
                domain: #domain,
                ports: PORTS,
                parameters: PARAMETERS,
                link: #link,
                #(#words)*
                cutoff: #cutoff,
                file: ::core::file!(),
                line: ::core::line!(),
            };
            type Body<#number: ::vesper::real::Real> = #body;
            fn body<#number: ::vesper::real::Real>(&self) -> #body { #name { #(#bodies)* } }
            fn from_parameters(#argument: &[f64]) -> Self { Self { #(#values)* } }
            fn parameters(&self) -> ::std::vec::Vec<f64> { ::std::vec::Vec::from([#(#own),*]) }
        }
    }
}

fn signature_port(port: &Port, from: u64) -> TokenStream {
    let (field, info) = (port.field.to_string(), info(&port.property));
    let mode = format_ident!("{}", format!("{:?}", port.mode));
    let place = format_ident!("{}", format!("{:?}", port.place));
    let optional = is_optional(port);
    let default = option(port.default.as_ref().map(components));
    let from = if from == u64::MAX { quote!(u64::MAX) } else { quote!(#from) };
    quote! {
        ::vesper::law::Port {
            field: #field,
            property: #info,
            mode: ::vesper::law::Mode::#mode,
            place: ::vesper::law::Place::#place,
            optional: #optional,
            default: #default,
            from: #from,
        }
    }
}

fn signature_parameter(member: &Member) -> Option<TokenStream> {
    let Member::Parameter { name, doc, unit, vector, default } = member else { return None };
    let (name, width) = (name.to_string(), if *vector { 3_usize } else { 1 });
    let default = option(default.as_ref().map(components));
    Some(quote! {
        ::vesper::law::Parameter { name: #name, doc: #doc, unit: #unit, width: #width, default: #default }
    })
}

/// A field from the next of the flattened values; where they end, from its default, or NaN: a number that shows.
fn from_values(member: &Member, component: &mut usize) -> TokenStream {
    match member {
        Member::Parameter { name, vector, default, .. } => {
            let width = if *vector { 3 } else { 1 };
            let values = (0..width).map(|offset| {
                let number = *component + offset;
                let missing = default.as_ref().map_or(quote!(f64::NAN), |default| literal(default.value[offset]));
                quote!(values.get(#number).copied().unwrap_or(#missing))
            });
            let new = new_vector();
            let value = if *vector { quote!(#new(#(#values),*)) } else { quote!(#(#values)*) };
            *component += width;
            quote!(#name: #value,)
        }
        Member::Kept { name } | Member::Fresh { name } => quote!(#name: ::core::default::Default::default(),),
    }
}

/// `Default`, where every parameter has one.
fn default(law: &Law) -> Option<TokenStream> {
    let mut fields = Vec::new();
    for member in &law.members {
        fields.push(match member {
            Member::Parameter { name, vector, default, .. } => {
                let [x, y, z] = default.as_ref()?.value.map(literal);
                let new = new_vector();
                if *vector { quote!(#name: #new(#x, #y, #z),) } else { quote!(#name: #x,) }
            }
            Member::Kept { name } | Member::Fresh { name } => quote!(#name: ::core::default::Default::default(),),
        });
    }
    let concrete = law.over(quote!(f64));
    Some(quote! {
        #[automatically_derived]
        impl ::core::default::Default for #concrete {
            fn default() -> Self { Self { #(#fields)* } }
        }
    })
}

fn new_vector() -> TokenStream {
    quote!(<<f64 as ::vesper::real::Real>::Vec3 as ::vesper::real::Vector<f64>>::new)
}

fn components(number: &Number) -> TokenStream {
    let [x, y, z] = number.value.map(literal);
    quote!([#x, #y, #z])
}

/// A number with its sign as a token of its own: a negative literal does not survive every way of tokens.
fn literal(value: f64) -> TokenStream {
    let size = Literal::f64_suffixed(value.abs());
    if value.is_sign_negative() { quote!(-#size) } else { quote!(#size) }
}

fn option(value: Option<TokenStream>) -> TokenStream {
    match value {
        Some(value) => quote!(::core::option::Option::Some(#value)),
        None => quote!(::core::option::Option::None),
    }
}
