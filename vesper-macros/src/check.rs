//! In: a [`Declaration`], as written. Out: a [`Law`] that means something, its ports in the order of their numbers; or
//! every fault of it, each at its token.

use proc_macro2::Span;
use quote::ToTokens;
use syn::spanned::Spanned;
use syn::{GenericParam, Ident, Path, Type, Visibility};

use crate::names::{check_unit, fault, is_snake_case, listed, snake_case};
use crate::parse::{Declaration, Field, Link, Mode, Number, Place, Port};

/// A law that can be expanded.
pub struct Law {
    pub name: Ident,
    pub visibility: Visibility,
    /// The struct's type parameter.
    pub real: Option<Ident>,
    pub snake: String,
    pub doc: String,
    pub domain: Option<String>,
    /// What it says of its body.
    pub words: Vec<String>,
    /// The component, of all parameters', from which on pairs do nothing to each other.
    pub cutoff: Option<usize>,
    /// In the order of their numbers.
    pub ports: Vec<Port>,
    /// Per port: the ports that a rate depends on, one bit each; all bits where the declaration does not say.
    pub from: Vec<u64>,
    pub link: Option<Link>,
    pub members: Vec<Member>,
}

/// A field of the struct, by its part in the law.
pub enum Member {
    Parameter {
        name: Ident,
        doc: String,
        unit: String,
        vector: bool,
        default: Option<Number>,
    },
    /// Kept by `body` as it is.
    Kept {
        name: Ident,
    },
    /// Made anew by `body`: its type depends on the type of numbers.
    Fresh {
        name: Ident,
    },
}

/// All faults of a declaration.
#[derive(Default)]
struct Faults(Option<syn::Error>);

impl Faults {
    fn add(&mut self, error: syn::Error) {
        match &mut self.0 {
            Some(all) => all.combine(error),
            None => self.0 = Some(error),
        }
    }

    fn at(&mut self, span: Span, text: impl std::fmt::Display) {
        self.add(fault(span, text));
    }
}

pub fn check(declaration: Declaration) -> syn::Result<Law> {
    let Declaration { name, visibility, doc, generics, declared, domain, mut ports, link, fields, .. } = declaration;
    let words = declaration.words;
    let mut faults = Faults::default();
    let real = real(&generics, &mut faults);
    if !declared {
        let text = format!("law `{name}` does not say what it touches: add `#[law(reads(...), adds(...))]`");
        faults.at(name.span(), text);
    } else if !ports.iter().any(is_output) {
        let text = format!("law `{name}` changes nothing: add `sets(...)`, `adds(...)`, `rates(...)` or `amends(...)`");
        faults.at(name.span(), text);
    }
    if let Some(domain) = &domain
        && !is_snake_case(&domain.value())
    {
        faults.at(domain.span(), format!("domain `{}` is no name: write it as `bodies`", domain.value()));
    }
    let has = |mode| ports.iter().any(|port| port.mode == mode);
    for word in &words {
        match word.to_string().as_str() {
            "second_order" if !has(Mode::Rates) => faults.at(
                word.span(),
                "`second_order` without `rates`: it says that the rate of a coordinate is its momentum",
            ),
            "translation_invariant" if !has(Mode::Reads) => faults.at(
                word.span(),
                "`translation_invariant` without `reads`: it says that differences of coordinates are all it looks at",
            ),
            "antisymmetric" if !has(Mode::Adds) => faults.at(
                word.span(),
                "`antisymmetric` without `adds`: it says that what the second row adds to the first is taken from the second",
            ),
            _ => {}
        }
    }
    let cutoff = cutoff(&fields, real.as_ref(), &mut ports, &mut faults);
    ports.sort_by_key(rank);
    if let Some(port) = ports.get(63) {
        faults.at(port.field.span(), "a law has at most 63 ports: split it");
    }
    unique_names(&ports, link.as_ref(), &mut faults);
    unique_properties(&ports, &mut faults);
    for port in &ports {
        if let (Some(span), Some(_)) = (port.optional, &port.default) {
            let text = format!("constant `{}` has a default, so it is always there: drop `optional`", port.field);
            faults.at(span, text);
        }
    }
    let from = ports.iter().map(|port| from(port, &ports, &mut faults)).collect();
    let members = fields.into_iter().filter_map(|field| member(field, &name, real.as_ref(), &mut faults)).collect();
    if let Some(faults) = faults.0 {
        return Err(faults);
    }
    let (snake, domain) = (snake_case(&name.to_string()), domain.map(|domain| domain.value()));
    let words = words.iter().map(Ident::to_string).collect();
    Ok(Law { name, visibility, real, snake, doc, domain, words, cutoff, ports, from, link, members })
}

/// The component of the parameter that says `cutoff`. The law's loop then looks at the lengths of a periodic box, too.
fn cutoff(fields: &[Field], real: Option<&Ident>, ports: &mut Vec<Port>, faults: &mut Faults) -> Option<usize> {
    let mut said = fields.iter().filter_map(|field| Some((field, field.cutoff?)));
    let (cutoff, span) = said.next()?;
    if let Some((second, again)) = said.next() {
        faults.at(again, format!("`{}` is a second `cutoff`, after `{}`: a law has one", second.name, cutoff.name));
    }
    let is_vector = |field: &Field| real.and_then(|real| is_vector(&field.ty, real)).unwrap_or_default();
    if cutoff.skip || is_vector(cutoff) {
        faults.at(span, format!("`cutoff` is a number, a distance: `{}` is none", cutoff.name));
    }
    let before = fields.iter().take_while(|field| field.name != cutoff.name).filter(|field| !field.skip);
    let component = before.map(|field| if is_vector(field) { 3 } else { 1 }).sum();
    let number = Number { span, vector: true, value: [0.0; 3] };
    ports.push(Port {
        field: Ident::new("periodic_box", span),
        property: syn::parse_quote_spanned!(span=> ::vesper::property::PeriodicBox),
        mode: Mode::Reads,
        place: Place::Scene,
        optional: None,
        default: Some(number),
        from: None,
        hidden: true,
    });
    Some(component)
}

pub fn is_output(port: &Port) -> bool {
    !matches!(port.mode, Mode::Reads | Mode::Previous)
}

/// Inputs first, then outputs; the sort is stable, so within a rank they keep the order of the declaration.
fn rank(port: &Port) -> u8 {
    match (port.mode, port.place) {
        (Mode::Reads | Mode::Previous, Place::Own) => 0,
        (Mode::Reads | Mode::Previous, Place::Scene) => 1,
        (Mode::Reads | Mode::Previous, Place::Field) => 2,
        (Mode::Reads | Mode::Previous, Place::End) => 3,
        (_, Place::End) => 8,
        (Mode::Sets, _) => 4,
        (Mode::Adds, _) => 5,
        (Mode::Rates, _) => 6,
        (Mode::Amends, _) => 7,
    }
}

/// The one type parameter.
fn real(generics: &syn::Generics, faults: &mut Faults) -> Option<Ident> {
    let mut real = None;
    for parameter in &generics.params {
        match parameter {
            GenericParam::Lifetime(lifetime) => {
                let text = "a law has no lifetimes: it owns what it needs, as it outlives the scene";
                faults.at(lifetime.lifetime.span(), text);
            }
            GenericParam::Const(constant) => {
                faults.at(constant.ident.span(), "a law has no const parameters: make it a parameter field");
            }
            GenericParam::Type(parameter) if real.is_some() => {
                let text = "a law has one type parameter, its type of numbers: drop this one";
                faults.at(parameter.ident.span(), text);
            }
            GenericParam::Type(parameter) => real = Some(parameter.ident.clone()),
        }
    }
    real
}

/// One name means one value in a row, and one in an output. A rate or a correction may have the name of what it
/// changes, and a previous value that of the present one.
fn unique_names(ports: &[Port], link: Option<&Link>, faults: &mut Faults) {
    for (i, port) in ports.iter().enumerate() {
        let clash = ports[..i].iter().any(|earlier| {
            let same_side = (earlier.place == Place::End) == (port.place == Place::End);
            let same_value = same(&earlier.property, &port.property) && earlier.place == port.place;
            same_side && earlier.field == port.field && (is_output(earlier) == is_output(port) || !same_value)
        });
        let with_link = link.is_some_and(|link| link.field == port.field) && port.place != Place::End;
        if clash || with_link {
            let text = format!("field `{}` is declared twice: give one of them another name", port.field);
            faults.at(port.field.span(), text);
        }
    }
}

/// What a law may do with one property at one place: read it and rate or amend it, and read its previous value.
fn unique_properties(ports: &[Port], faults: &mut Faults) {
    for (i, port) in ports.iter().enumerate() {
        let mut earlier = ports[..i].iter().filter(|earlier| {
            earlier.place == port.place && same(&earlier.property, &port.property) && !may_join(earlier.mode, port.mode)
        });
        if let Some(earlier) = earlier.next() {
            let property = text(&port.property);
            let text = match (word(earlier), word(port)) {
                (one, other) if one == other => format!("`{property}` stands twice in `{one}`: once is enough"),
                ("reads", mode @ ("sets" | "adds")) => format!(
                    "`{property}` is in `reads` and in `{mode}`, but {mode} happen before reads: \
                     split the law, or write `reads(previous {}: {property})`",
                    earlier.field,
                ),
                (one, other) => {
                    format!("`{property}` is in `{one}` and in `{other}`: a law changes a property in one way")
                }
            };
            faults.at(port.property.span(), text);
        }
    }
}

/// Whether a law may have both, the first ranked before the second.
fn may_join(first: Mode, second: Mode) -> bool {
    match (first, second) {
        (Mode::Previous, second) => second != Mode::Previous,
        (Mode::Reads, second) => matches!(second, Mode::Previous | Mode::Rates | Mode::Amends),
        (first, second) => first == Mode::Rates && second == Mode::Amends,
    }
}

/// The group that a port stands in.
fn word(port: &Port) -> &'static str {
    match port.mode {
        Mode::Reads if port.place == Place::Scene => "scene",
        Mode::Reads if port.place == Place::Field => "fields",
        Mode::Reads => "reads",
        Mode::Previous => "reads previous",
        Mode::Sets => "sets",
        Mode::Adds => "adds",
        Mode::Rates => "rates",
        Mode::Amends => "amends",
    }
}

/// The bits of the ports that a rate depends on.
fn from(port: &Port, ports: &[Port], faults: &mut Faults) -> u64 {
    let Some(names) = &port.from else { return u64::MAX };
    let inputs = || ports.iter().take(64).enumerate().filter(|(_, port)| !is_output(port));
    let mut bits = 0;
    for name in names {
        let mut found = false;
        for (number, _) in inputs().filter(|(_, port)| port.field == *name) {
            bits |= 1 << number;
            found = true;
        }
        if !found {
            let known: Vec<String> = inputs().map(|(_, port)| port.field.to_string()).collect();
            let known =
                if known.is_empty() { "it reads nothing".into() } else { format!("it reads {}", listed(&known)) };
            faults.at(name.span(), format!("`from` names `{name}`, which the law does not read: {known}"));
        }
    }
    bits
}

/// The part of a field, or `None` after a fault.
fn member(field: Field, law: &Ident, real: Option<&Ident>, faults: &mut Faults) -> Option<Member> {
    let Field { name, doc, ty, declared, skip, unit, default, .. } = field;
    if skip {
        if unit.is_some() || default.is_some() {
            faults.at(name.span(), format!("field `{name}` is skipped, so it has no unit and no default"));
        }
        let depends = real.is_some_and(|real| mentions(&ty, real));
        return Some(if depends { Member::Fresh { name } } else { Member::Kept { name } });
    }
    let Some(unit) = unit else {
        let add = if declared { "`unit = \"m\"`" } else { "`#[law(unit = \"m\")]`" };
        let text =
            format!("parameter `{name}` has no unit: add {add}, or `#[law(skip)]` to a field that is no parameter");
        faults.at(name.span(), text);
        return None;
    };
    if let Err(error) = check_unit(&unit) {
        faults.add(error);
    }
    let Some(real) = real else {
        let text =
            format!("parameter `{name}` needs the law's type of numbers: write `{law}<R = f64>` and `{name}: R`");
        faults.at(ty.span(), text);
        return None;
    };
    let Some(vector) = is_vector(&ty, real) else {
        let text =
            format!("parameter `{name}` is a number `{real}` or a vector `{real}::Vec3`; `#[law(skip)]` is for others");
        faults.at(ty.span(), text);
        return None;
    };
    if let Some(default) = &default
        && default.vector != vector
    {
        let (is, write) = if vector { ("vector", "[0.0, 0.0, 0.0]") } else { ("number", "0.0") };
        faults.at(default.span, format!("parameter `{name}` is a {is}: write its default as `{write}`"));
    }
    Some(Member::Parameter { name, doc, unit: unit.value(), vector, default })
}

/// `R` is a number; `R::Vec3` and `<R as Real>::Vec3` are vectors.
fn is_vector(ty: &Type, real: &Ident) -> Option<bool> {
    let Type::Path(ty) = ty else { return None };
    let last = ty.path.segments.last()?;
    match &ty.qself {
        None if ty.path.is_ident(real) => Some(false),
        None if ty.path.segments.len() == 2 && ty.path.segments[0].ident == *real && last.ident == "Vec3" => Some(true),
        Some(of) if *real == of.ty.to_token_stream().to_string() && last.ident == "Vec3" => Some(true),
        _ => None,
    }
}

/// Whether the type's tokens contain the name.
fn mentions(ty: &Type, name: &Ident) -> bool {
    fn within(tokens: proc_macro2::TokenStream, name: &Ident) -> bool {
        tokens.into_iter().any(|token| match token {
            proc_macro2::TokenTree::Ident(ident) => ident == *name,
            proc_macro2::TokenTree::Group(group) => within(group.stream(), name),
            _ => false,
        })
    }
    within(ty.to_token_stream(), name)
}

/// Whether two paths are written alike. Two ways to write one property are told apart by the core, not here.
fn same(a: &Path, b: &Path) -> bool {
    text(a) == text(b)
}

/// A path as people write it.
pub fn text(path: &Path) -> String {
    path.to_token_stream().to_string().replace(' ', "")
}
