//! In: the items of `property!`. Out: a type for each, with `vesper::property::Property`. A wrong item gives its error
//! and a type all the same, so that its users have none.

use proc_macro2::{Span, TokenStream, TokenTree};
use quote::{quote, quote_spanned};
use syn::ext::IdentExt;
use syn::parse::{Parse, ParseStream};
use syn::{Attribute, Ident, LitInt, LitStr, Path, Token, Visibility};

use crate::names::{check_unit, doc, fault, is_snake_case, snake_case, unknown};

const KINDS: [&str; 4] = ["Scalar", "Vector", "Quaternion", "Link"];
const ROLES: [&str; 5] = ["coordinate", "momentum", "sum", "turn", "switch"];

/// One property as written.
struct Property {
    attributes: Vec<Attribute>,
    visibility: Visibility,
    ident: Ident,
    name: String,
    /// "Scalar", "Vector", "Quaternion" or "Link".
    kind: String,
    /// Rows of a link.
    arity: Option<usize>,
    unit: String,
    role: TokenStream,
}

pub fn properties(tokens: TokenStream) -> TokenStream {
    items(tokens).into_iter().map(property).collect()
}

/// The tokens of each item, with the `;` that ends it: an error at the end of an item stands there.
fn items(tokens: TokenStream) -> Vec<TokenStream> {
    let mut items = vec![TokenStream::new()];
    for token in tokens {
        let ends = matches!(&token, TokenTree::Punct(punct) if punct.as_char() == ';');
        if let Some(item) = items.last_mut() {
            item.extend([token]);
        }
        if ends {
            items.push(TokenStream::new());
        }
    }
    items.retain(|item| !item.is_empty());
    items
}

fn property(tokens: TokenStream) -> TokenStream {
    match syn::parse2::<Property>(tokens.clone()) {
        Ok(property) => expand(&property),
        Err(error) => {
            let (error, stub) = (error.to_compile_error(), stub(tokens));
            quote!(#error #stub)
        }
    }
}

impl Parse for Property {
    fn parse(input: ParseStream) -> syn::Result<Self> {
        let attributes = input.call(Attribute::parse_outer)?;
        let visibility: Visibility = input.parse()?;
        let ident: Ident = input.parse()?;
        let mut name = snake_case(&ident.to_string());
        if input.peek(Token![=]) {
            input.parse::<Token![=]>()?;
            let given: LitStr = input.parse()?;
            name = given.value();
            if !is_snake_case(&name) {
                return Err(fault(
                    given.span(),
                    format!("\"{name}\" is no name of a property: write it as \"rest_length\""),
                ));
            }
        }
        input.parse::<Token![:]>()?;
        let kind = input.call(Ident::parse_any)?;
        let arity = if kind == "Link" { Some(arity(input)?) } else { None };
        let kind = match KINDS.iter().find(|known| kind == **known) {
            Some(_) => kind.to_string(),
            None => return Err(fault(kind.span(), unknown("kind", &kind.to_string(), &KINDS))),
        };
        let unit = unit(input, &ident, &kind)?;
        let mut role = TokenStream::new();
        while comma(input)? {
            if kind == "Link" {
                return Err(fault(input.span(), format!("property `{ident}` is a link: it has no role")));
            }
            if !role.is_empty() {
                return Err(fault(input.span(), format!("property `{ident}` has a role already: it has one at most")));
            }
            role = self::role(input)?;
        }
        if !end(input) {
            return Err(input.error("expected `,` or `;`"));
        }
        input.parse::<Option<Token![;]>>()?;
        if doc(&attributes).is_empty() {
            return Err(fault(ident.span(), format!("property `{ident}` has no doc comment: say what it is")));
        }
        Ok(Property { attributes, visibility, ident, name, kind, arity, unit, role })
    }
}

fn end(input: ParseStream) -> bool {
    input.is_empty() || input.peek(Token![;])
}

/// Takes a comma; false at the end of the item.
fn comma(input: ParseStream) -> syn::Result<bool> {
    if end(input) || !input.peek(Token![,]) {
        return Ok(false);
    }
    input.parse::<Token![,]>()?;
    Ok(!end(input))
}

/// `<2>`
fn arity(input: ParseStream) -> syn::Result<usize> {
    let text = "a link says how many rows it holds: `Link<2>`";
    if !input.peek(Token![<]) {
        return Err(fault(input.span(), text));
    }
    input.parse::<Token![<]>()?;
    let span = input.span();
    let arity = input.parse::<LitInt>().and_then(|literal| literal.base10_parse::<usize>());
    input.parse::<Token![>]>().map_err(|_| fault(span, text))?;
    match arity {
        Ok(arity @ 1..=255) => Ok(arity),
        Ok(_) => Err(fault(span, "a link holds 1 to 255 rows")),
        Err(_) => Err(fault(span, text)),
    }
}

/// The unit of a property of this kind: text, or nothing for links.
fn unit(input: ParseStream, ident: &Ident, kind: &str) -> syn::Result<String> {
    let given = input.peek(Token![,]) && input.peek2(LitStr);
    match (kind, given) {
        ("Link", false) => Ok(String::new()),
        ("Quaternion", false) => Ok("1".into()),
        (_, false) => {
            let text = format!(
                "property `{ident}` has no unit: add one, as in `{kind}, \"m\"`; that of a pure number is \"1\""
            );
            Err(fault(ident.span(), text))
        }
        (_, true) => {
            input.parse::<Token![,]>()?;
            let unit: LitStr = input.parse()?;
            if kind == "Link" {
                return Err(fault(unit.span(), format!("property `{ident}` is a link: it has no unit")));
            }
            check_unit(&unit)?;
            Ok(unit.value())
        }
    }
}

/// `coordinate`, `momentum of Position`, `sum`, `sum from ExternalForce`, `turn of Force by Velocity` or `switch`, as calls
/// on `PropertyInfo`.
fn role(input: ParseStream) -> syn::Result<TokenStream> {
    let word = input.call(Ident::parse_any)?;
    let link = |input: ParseStream, join: &str| -> syn::Result<TokenStream> {
        let found = input.call(Ident::parse_any)?;
        if found != join {
            return Err(fault(found.span(), unknown("word", &found.to_string(), &[join])));
        }
        let path: Path = input.parse()?;
        Ok(quote!(<#path as ::vesper::property::Property>::NAME))
    };
    match word.to_string().as_str() {
        "coordinate" => Ok(quote!(.coordinate())),
        "momentum" if !input.peek(Ident::peek_any) => {
            Err(fault(word.span(), "a momentum moves a coordinate: write `momentum of Position`"))
        }
        "momentum" => {
            let name = link(input, "of")?;
            Ok(quote!(.momentum_of(#name)))
        }
        "sum" if input.peek(Ident::peek_any) => {
            let name = link(input, "from")?;
            Ok(quote!(.sum_from(#name)))
        }
        "sum" => Ok(quote!(.sum())),
        "turn" if !input.peek(Ident::peek_any) => {
            Err(fault(word.span(), "a turn is of a sum by what is turned: write `turn of Force by Velocity`"))
        }
        "turn" => {
            let (of, by) = (link(input, "of")?, link(input, "by")?);
            Ok(quote!(.turn_of(#of, #by)))
        }
        "switch" => Ok(quote!(.switch())),
        text => Err(fault(word.span(), unknown("role", text, &ROLES))),
    }
}

fn expand(property: &Property) -> TokenStream {
    let Property { attributes, visibility, ident, name, kind, arity, unit, role } = property;
    let kind = Ident::new(kind, Span::call_site());
    let argument = arity.map(|arity| {
        let arity = proc_macro2::Literal::usize_unsuffixed(arity);
        quote!(<#arity>)
    });
    let configured = attributes.iter().filter(|attribute| attribute.path().is_ident("cfg"));
    quote! {
        #(#attributes)*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
        #visibility struct #ident;
        #(#configured)*
        #[automatically_derived]
        impl ::vesper::property::Property for #ident {
            type Kind = ::vesper::property::#kind #argument;
            const INFO: ::vesper::property::PropertyInfo = ::vesper::property::PropertyInfo::new(
                #name,
                <<Self as ::vesper::property::Property>::Kind as ::vesper::property::KindOf>::KIND,
                #unit,
            ) #role;
        }
    }
}

/// After a fault: a property of no special kind, so that the fault is the only error.
fn stub(tokens: TokenStream) -> Option<TokenStream> {
    let start = |input: ParseStream| -> syn::Result<(Visibility, Ident)> {
        input.call(Attribute::parse_outer)?;
        let found = (input.parse()?, input.parse()?);
        input.parse::<TokenStream>()?;
        Ok(found)
    };
    let (visibility, ident) = syn::parse::Parser::parse2(start, tokens).ok()?;
    let name = snake_case(&ident.to_string());
    Some(quote_spanned! {ident.span()=>
        #[allow(missing_docs)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
        #visibility struct #ident;
        #[automatically_derived]
        impl ::vesper::property::Property for #ident {
            type Kind = ::vesper::property::Scalar;
            const INFO: ::vesper::property::PropertyInfo = ::vesper::property::PropertyInfo::new(
                #name,
                <<Self as ::vesper::property::Property>::Kind as ::vesper::property::KindOf>::KIND,
                "1",
            );
        }
    })
}
