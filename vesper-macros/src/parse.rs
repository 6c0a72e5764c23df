//! In: the tokens of a struct under `#[derive(Law)]`. Out: a [`Declaration`], as written. Only the grammar is judged
//! here, and the first fault ends it; what a declaration means is judged in `check`.

use proc_macro2::Span;
use syn::ext::IdentExt;
use syn::parse::{Parse, ParseStream};
use syn::{Attribute, Data, DeriveInput, Fields, Ident, LitFloat, LitInt, LitStr, Path, Token, Type, Visibility};
use syn::{bracketed, parenthesized, token};

use crate::names::{doc, fault, unknown};

/// A law as written.
pub struct Declaration {
    pub name: Ident,
    pub visibility: Visibility,
    pub doc: String,
    pub generics: syn::Generics,
    /// Whether there was a `#[law(...)]` at all.
    pub declared: bool,
    pub domain: Option<LitStr>,
    /// Those of [`WORDS`] that it says.
    pub words: Vec<Ident>,
    pub ports: Vec<Port>,
    pub link: Option<Link>,
    pub fields: Vec<Field>,
}

/// What a law promises about a property; as `vesper::law::Mode`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Mode {
    Reads,
    Previous,
    Sets,
    Adds,
    Rates,
    Amends,
}

/// Where a law meets a property; as `vesper::law::Place`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Place {
    Own,
    Scene,
    Field,
    End,
}

/// One property that a law touches.
#[derive(Clone)]
pub struct Port {
    pub field: Ident,
    pub property: Path,
    pub mode: Mode,
    pub place: Place,
    /// The word `optional` of its group.
    pub optional: Option<Span>,
    pub default: Option<Number>,
    /// The names after `from`.
    pub from: Option<Vec<Ident>>,
    /// Whether it is for the loop around the body, which does not get it.
    pub hidden: bool,
}

/// `ends: Ends` of a link group.
#[derive(Clone)]
pub struct Link {
    pub field: Ident,
    pub property: Path,
}

/// A default: a number, or a vector of three.
#[derive(Clone)]
pub struct Number {
    pub span: Span,
    pub vector: bool,
    pub value: [f64; 3],
}

/// A field of the struct.
pub struct Field {
    pub name: Ident,
    pub doc: String,
    pub ty: Type,
    /// Whether there was a `#[law(...)]` at all.
    pub declared: bool,
    pub skip: bool,
    pub unit: Option<LitStr>,
    pub default: Option<Number>,
    /// The word `cutoff`.
    pub cutoff: Option<Span>,
}

/// What a law may say of its body; each is a field of `vesper::law::Signature`.
pub const WORDS: [&str; 4] = ["second_order", "translation_invariant", "antisymmetric", "estimates"];

/// The groups outside a link.
const GROUPS: [(&str, Mode, Place); 7] = [
    ("reads", Mode::Reads, Place::Own),
    ("sets", Mode::Sets, Place::Own),
    ("adds", Mode::Adds, Place::Own),
    ("rates", Mode::Rates, Place::Own),
    ("amends", Mode::Amends, Place::Own),
    ("scene", Mode::Reads, Place::Scene),
    ("fields", Mode::Reads, Place::Field),
];

/// The groups inside a link.
const LINK_GROUPS: [(&str, Mode, Place); 2] = [("reads", Mode::Reads, Place::End), ("adds", Mode::Adds, Place::End)];

impl Declaration {
    pub fn new(input: DeriveInput) -> syn::Result<Self> {
        let fields = match input.data {
            Data::Struct(data) => data.fields,
            Data::Enum(data) => return Err(not_a_struct(data.enum_token.span)),
            Data::Union(data) => return Err(not_a_struct(data.union_token.span)),
        };
        let mut declaration = Declaration {
            name: input.ident,
            visibility: input.vis,
            doc: doc(&input.attrs),
            generics: input.generics,
            declared: false,
            domain: None,
            words: Vec::new(),
            ports: Vec::new(),
            link: None,
            fields: Vec::new(),
        };
        for attribute in laws(&input.attrs) {
            declaration.declared = true;
            attribute.parse_args_with(|input: ParseStream| declaration.entries(input))?;
        }
        match fields {
            Fields::Unit => {}
            Fields::Unnamed(fields) => {
                return Err(fault(fields.paren_token.span.join(), "a law's parameters have names: write `{ g: R }`"));
            }
            Fields::Named(fields) => {
                for field in fields.named {
                    declaration.fields.push(Field::new(field)?);
                }
            }
        }
        Ok(declaration)
    }

    /// What stands inside the struct's `#[law(...)]`.
    fn entries(&mut self, input: ParseStream) -> syn::Result<()> {
        while !input.is_empty() {
            let word = input.call(Ident::parse_any)?;
            let text = word.to_string();
            if text == "domain" {
                input.parse::<Token![=]>()?;
                let domain: LitStr = input.parse()?;
                if self.domain.replace(domain).is_some() {
                    return Err(fault(word.span(), "a second `domain`: a law stands on one domain"));
                }
            } else if WORDS.contains(&text.as_str()) {
                self.words.push(word);
            } else if text == "link" {
                if self.link.is_some() {
                    return Err(fault(word.span(), "a second `link`: a law follows one link; split it into two laws"));
                }
                self.link(input)?;
            } else if let Some(&(_, mode, place)) = GROUPS.iter().find(|group| group.0 == text) {
                self.ports.extend(group(input, mode, place)?);
            } else {
                let what = if input.peek(token::Paren) { "mode" } else { "key" };
                let mut known: Vec<&str> = GROUPS.iter().map(|group| group.0).collect();
                known.extend(["link", "domain"]);
                known.extend(WORDS);
                return Err(fault(word.span(), unknown(what, &text, &known)));
            }
            comma(input)?;
        }
        Ok(())
    }

    /// `(ends: Ends, reads(..), adds(..))`
    fn link(&mut self, input: ParseStream) -> syn::Result<()> {
        let content;
        let parentheses = parenthesized!(content in input);
        if !(content.peek(Ident::peek_any) && content.peek2(Token![:])) {
            let text = "a link begins with the property that holds it: `link(ends: Ends, reads(..), adds(..))`";
            return Err(fault(if content.is_empty() { parentheses.span.join() } else { content.span() }, text));
        }
        let field = content.call(Ident::parse_any)?;
        content.parse::<Token![:]>()?;
        self.link = Some(Link { field, property: property(&content)? });
        comma(&content)?;
        while !content.is_empty() {
            let word = content.call(Ident::parse_any)?;
            let text = word.to_string();
            let Some(&(_, mode, place)) = LINK_GROUPS.iter().find(|group| group.0 == text) else {
                let text = if GROUPS.iter().any(|group| group.0 == text) {
                    format!("`{text}` inside `link`: only `reads` and `adds` stand there")
                } else {
                    unknown("mode", &text, &["reads", "adds"])
                };
                return Err(fault(word.span(), text));
            };
            self.ports.extend(group(&content, mode, place)?);
            comma(&content)?;
        }
        Ok(())
    }
}

/// `(position: Position, previous force: Force, optional)`
fn group(input: ParseStream, mode: Mode, place: Place) -> syn::Result<Vec<Port>> {
    let content;
    parenthesized!(content in input);
    let mut ports = Vec::new();
    let mut optional = None;
    while !content.is_empty() {
        let word = content.call(Ident::parse_any)?;
        if word == "optional" && !content.peek(Token![:]) {
            if !matches!(mode, Mode::Reads) {
                return Err(fault(word.span(), "`optional` on an output: only what a law reads can be optional"));
            }
            optional = Some(word.span());
        } else {
            ports.push(port(&content, word, mode, place)?);
        }
        comma(&content)?;
    }
    ports.iter_mut().for_each(|port| port.optional = optional);
    Ok(ports)
}

/// The port that begins with `word`.
fn port(input: ParseStream, word: Ident, mode: Mode, place: Place) -> syn::Result<Port> {
    let previous = word == "previous" && !input.peek(Token![:]);
    if previous && !(matches!(mode, Mode::Reads) && matches!(place, Place::Own | Place::End)) {
        return Err(fault(
            word.span(),
            "`previous` outside `reads`: only rows have a value of the previous evaluation",
        ));
    }
    let field = if previous { input.call(Ident::parse_any)? } else { word };
    if !input.peek(Token![:]) {
        let text = format!("`{field}` has no property: write `{field}: Property`");
        return Err(fault(field.span(), text));
    }
    input.parse::<Token![:]>()?;
    let property = property(input)?;
    let mut port = Port {
        field,
        property,
        mode: if previous { Mode::Previous } else { mode },
        place,
        optional: None,
        default: None,
        from: None,
        hidden: false,
    };
    if input.peek(Token![=]) {
        let equals: Token![=] = input.parse()?;
        if place != Place::Scene {
            return Err(fault(equals.span, "only constants of `scene` and parameters have defaults"));
        }
        port.default = Some(Number::parse(input)?);
    }
    if input.peek(Ident::peek_any) {
        let word = input.call(Ident::parse_any)?;
        if word != "from" {
            return Err(fault(word.span(), format!("unexpected `{word}`: expected `,`")));
        }
        if mode != Mode::Rates {
            return Err(fault(word.span(), "`from` outside `rates`: it says what a rate depends on"));
        }
        let names;
        parenthesized!(names in input);
        let names = names.parse_terminated(Ident::parse_any, Token![,])?;
        port.from = Some(names.into_iter().collect());
    }
    Ok(port)
}

/// The type of a property.
fn property(input: ParseStream) -> syn::Result<Path> {
    let span = input.span();
    input.parse::<Path>().map_err(|_| fault(span, "expected a property: a type such as `Position`"))
}

/// A comma, or the end.
fn comma(input: ParseStream) -> syn::Result<()> {
    if !input.is_empty() {
        input.parse::<Token![,]>()?;
    }
    Ok(())
}

impl Parse for Number {
    fn parse(input: ParseStream) -> syn::Result<Self> {
        let span = input.span();
        if !input.peek(token::Bracket) {
            return Ok(Number { span, vector: false, value: [number(input)?, 0.0, 0.0] });
        }
        let content;
        bracketed!(content in input);
        let numbers: Vec<f64> = content.parse_terminated(number, Token![,])?.into_iter().collect();
        match <[f64; 3]>::try_from(numbers) {
            Ok(value) => Ok(Number { span, vector: true, value }),
            Err(_) => Err(fault(span, "a vector has three numbers, as in `[0.0, 0.0, -9.81]`")),
        }
    }
}

/// A finite number with an optional sign.
fn number(input: ParseStream) -> syn::Result<f64> {
    let span = input.span();
    let negative = input.parse::<Option<Token![-]>>()?.is_some();
    let value = if input.peek(LitFloat) {
        input.parse::<LitFloat>()?.base10_parse::<f64>()
    } else if input.peek(LitInt) {
        input.parse::<LitInt>()?.base10_parse::<f64>()
    } else {
        Err(fault(span, "a default is a number, such as `0.5`, or a vector, such as `[0.0, 0.0, -9.81]`"))
    }?;
    if !value.is_finite() {
        return Err(fault(span, "a default is a finite number"));
    }
    Ok(if negative { -value } else { value })
}

impl Field {
    fn new(field: syn::Field) -> syn::Result<Self> {
        let Some(name) = field.ident else {
            return Err(fault(Span::call_site(), "a law's parameters have names: write `{ g: R }`"));
        };
        let mut found = Field {
            name,
            doc: doc(&field.attrs),
            ty: field.ty,
            declared: false,
            skip: false,
            unit: None,
            default: None,
            cutoff: None,
        };
        for attribute in laws(&field.attrs) {
            found.declared = true;
            attribute.parse_args_with(|input: ParseStream| found.entries(input))?;
        }
        Ok(found)
    }

    /// What stands inside the field's `#[law(...)]`.
    fn entries(&mut self, input: ParseStream) -> syn::Result<()> {
        while !input.is_empty() {
            let word = input.call(Ident::parse_any)?;
            match word.to_string().as_str() {
                "skip" => self.skip = true,
                "cutoff" => self.cutoff = Some(word.span()),
                "unit" => {
                    input.parse::<Token![=]>()?;
                    self.unit = Some(input.parse()?);
                }
                "default" => {
                    input.parse::<Token![=]>()?;
                    self.default = Some(input.parse()?);
                }
                text => return Err(fault(word.span(), unknown("key", text, &["unit", "default", "cutoff", "skip"]))),
            }
            comma(input)?;
        }
        Ok(())
    }
}

fn laws(attributes: &[Attribute]) -> impl Iterator<Item = &Attribute> {
    attributes.iter().filter(|attribute| attribute.path().is_ident("law"))
}

fn not_a_struct(span: Span) -> syn::Error {
    fault(span, "a law is a struct: its fields are its parameters")
}
