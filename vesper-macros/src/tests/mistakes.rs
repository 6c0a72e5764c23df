//! Every mistake: the declaration, the message, and the token at which it stands. One error each.

use quote::ToTokens;

use super::tokens;
use crate::check::check;
use crate::parse::Declaration;

/// Messages of a declaration, each with the text it stands at.
fn faults(text: &str) -> Vec<(String, String)> {
    let input: syn::DeriveInput = syn::parse2(tokens(text)).unwrap_or_else(|error| panic!("{error}: {text}"));
    match Declaration::new(input).and_then(check) {
        Ok(_) => Vec::new(),
        Err(error) => {
            error.into_iter().map(|one| (one.to_string(), one.span().source_text().unwrap_or_default())).collect()
        }
    }
}

/// A law with this inside `#[law(...)]`.
fn law(attribute: &str) -> String {
    format!("#[law({attribute})] struct Drag<R = f64> {{ #[law(unit = \"kg/s\", default = 0.5)] k: R }}")
}

/// A law with this field.
fn field(field: &str) -> String {
    format!("#[law(adds(force: Force))] struct Drag<R = f64> {{ {field} }}")
}

/// Messages of an expansion that holds its errors as `compile_error!`.
fn compile_errors(expansion: &proc_macro2::TokenStream) -> Vec<String> {
    use proc_macro2::TokenTree::{Group, Ident, Literal};
    let mut found = Vec::new();
    let mut after = false;
    for token in expansion.clone() {
        match token {
            Ident(ident) => after = ident == "compile_error",
            Group(group) if after => {
                found.extend(group.stream().into_iter().filter_map(|token| match token {
                    Literal(literal) => {
                        syn::parse2::<syn::LitStr>(literal.into_token_stream()).ok().map(|text| text.value())
                    }
                    _ => None,
                }));
                after = false;
            }
            Group(group) => found.extend(compile_errors(&group.stream())),
            _ => {}
        }
    }
    found
}

#[test]
fn wrong_laws() {
    let all = "known are `reads`, `sets`, `adds`, `rates`, `amends`, `scene`, `fields`, `link`, `domain`, `second_order`, `translation_invariant`, `antisymmetric`, `estimates`";
    let table: Vec<(String, String, &str)> = [
        (law("read(v: Velocity), adds(force: Force)"), "unknown mode `read`: did you mean `reads`?", "read"),
        (law("domian = \"bodies\", adds(force: Force)"), "unknown key `domian`: did you mean `domain`?", "domian"),
        (law("computes(force: Force)"), &format!("unknown mode `computes`: {all}"), "computes"),
        (law("domain = \"Two Bodies\", adds(force: Force)"), "domain `Two Bodies` is no name: write it as `bodies`", "\"Two Bodies\""),
        (law("translation_invariant, adds(force: Force)"), "`translation_invariant` without `reads`: it says that differences of coordinates are all it looks at", "translation_invariant"),
        (law("antisymmetric, reads(v: Velocity), sets(force: Force)"), "`antisymmetric` without `adds`: it says that what the second row adds to the first is taken from the second", "antisymmetric"),
        (law("second_order, adds(force: Force)"), "`second_order` without `rates`: it says that the rate of a coordinate is its momentum", "second_order"),
        (law("domain = \"a\", domain = \"b\", adds(force: Force)"), "a second `domain`: a law stands on one domain", "domain"),
        (law("reads(v: Velocity, v: Mass), adds(force: Force)"), "field `v` is declared twice: give one of them another name", "v"),
        (law("reads(v: Velocity), scene(v: Wind), adds(force: Force)"), "field `v` is declared twice: give one of them another name", "v"),
        (law("reads(v: Velocity), adds(v: Force)"), "field `v` is declared twice: give one of them another name", "v"),
        (law("reads(v: Velocity), reads(w: Velocity), adds(force: Force)"), "`Velocity` stands twice in `reads`: once is enough", "Velocity"),
        (
            law("reads(force: Force), adds(share: Force)"),
            "`Force` is in `reads` and in `adds`, but adds happen before reads: split the law, or write `reads(previous force: Force)`",
            "Force",
        ),
        (
            law("reads(wind: Wind), sets(new: Wind)"),
            "`Wind` is in `reads` and in `sets`, but sets happen before reads: split the law, or write `reads(previous wind: Wind)`",
            "Wind",
        ),
        (law("sets(a: Force), adds(b: Force)"), "`Force` is in `sets` and in `adds`: a law changes a property in one way", "Force"),
        (
            law("reads(v: Velocity)"),
            "law `Drag` changes nothing: add `sets(...)`, `adds(...)`, `rates(...)` or `amends(...)`",
            "Drag",
        ),
        (
            "struct Drag;".into(),
            "law `Drag` does not say what it touches: add `#[law(reads(...), adds(...))]`",
            "Drag",
        ),
        ("#[law(adds(f: Force))] enum Drag { A }".into(), "a law is a struct: its fields are its parameters", "enum"),
        ("#[law(adds(f: Force))] struct Drag<R = f64>(R);".into(), "a law's parameters have names: write `{ g: R }`", "(R)"),
        (
            "#[law(adds(f: Force))] struct Drag<R, S>;".into(),
            "a law has one type parameter, its type of numbers: drop this one",
            "S",
        ),
        (
            "#[law(adds(f: Force))] struct Drag<'a, R>;".into(),
            "a law has no lifetimes: it owns what it needs, as it outlives the scene",
            "'a",
        ),
        (
            "#[law(adds(f: Force))] struct Drag<const N: usize>;".into(),
            "a law has no const parameters: make it a parameter field",
            "N",
        ),
        (law("reads(v: \"m/s\"), adds(force: Force)"), "expected a property: a type such as `Position`", "\"m/s\""),
        (law("reads(v: [f64; 3]), adds(force: Force)"), "expected a property: a type such as `Position`", "["),
        (law("reads(velocity), adds(force: Force)"), "`velocity` has no property: write `velocity: Property`", "velocity"),
        (law("adds(previous force: Force)"), "`previous` outside `reads`: only rows have a value of the previous evaluation", "previous"),
        (
            law("scene(previous g: Gravity), adds(force: Force)"),
            "`previous` outside `reads`: only rows have a value of the previous evaluation",
            "previous",
        ),
        (law("adds(force: Force, optional)"), "`optional` on an output: only what a law reads can be optional", "optional"),
        (
            law("scene(g: Gravity = 1.0, optional), adds(force: Force)"),
            "constant `g` has a default, so it is always there: drop `optional`",
            "optional",
        ),
        (
            law("reads(m: Mass), rates(v: Velocity from (mas))"),
            "`from` names `mas`, which the law does not read: it reads `m`",
            "mas",
        ),
        (law("rates(v: Velocity from (m))"), "`from` names `m`, which the law does not read: it reads nothing", "m"),
        (law("adds(v: Force from (m))"), "`from` outside `rates`: it says what a rate depends on", "from"),
        (law("reads(m: Mass = 1.0), adds(f: Force)"), "only constants of `scene` and parameters have defaults", "="),
        (
            law("link(a: Ends, adds(f: Force)), link(b: Ends, adds(f: Force))"),
            "a second `link`: a law follows one link; split it into two laws",
            "link",
        ),
        (law("link(a: Ends, sets(f: Force))"), "`sets` inside `link`: only `reads` and `adds` stand there", "sets"),
        (law("link(a: Ends, add(f: Force))"), "unknown mode `add`: did you mean `adds`?", "add"),
        (
            law("link(reads(p: Position), adds(f: Force))"),
            "a link begins with the property that holds it: `link(ends: Ends, reads(..), adds(..))`",
            "reads",
        ),
        (
            field("k: R"),
            "parameter `k` has no unit: add `#[law(unit = \"m\")]`, or `#[law(skip)]` to a field that is no parameter",
            "k",
        ),
        (
            field("#[law(default = 1.0)] k: R"),
            "parameter `k` has no unit: add `unit = \"m\"`, or `#[law(skip)]` to a field that is no parameter",
            "k",
        ),
        (field("#[law(unit = \"kg/sec\")] k: R"), "unknown unit `sec` in \"kg/sec\": did you mean `s`?", "\"kg/sec\""),
        (field("#[law(units = \"kg/s\")] k: R"), "unknown key `units`: did you mean `unit`?", "units"),
        (
            field("#[law(unit = \"m\", default = [0.0, 0.0, 1.0])] k: R"),
            "parameter `k` is a number: write its default as `0.0`",
            "[",
        ),
        (
            field("#[law(unit = \"m\", default = 0.0)] k: R::Vec3"),
            "parameter `k` is a vector: write its default as `[0.0, 0.0, 0.0]`",
            "0.0",
        ),
        (
            field("#[law(unit = \"m\", default = [0.0, 0.0])] k: R::Vec3"),
            "a vector has three numbers, as in `[0.0, 0.0, -9.81]`",
            "[",
        ),
        (
            field("#[law(unit = \"m\", default = \"1\")] k: R"),
            "a default is a number, such as `0.5`, or a vector, such as `[0.0, 0.0, -9.81]`",
            "\"1\"",
        ),
        (field("#[law(unit = \"m\", default = 1e999)] k: R"), "a default is a finite number", "1e999"),
        (
            field("#[law(unit = \"m\")] k: f64"),
            "parameter `k` is a number `R` or a vector `R::Vec3`; `#[law(skip)]` is for others",
            "f64",
        ),
        (
            "#[law(adds(f: Force))] struct Drag { #[law(unit = \"m\")] k: f64 }".into(),
            "parameter `k` needs the law's type of numbers: write `Drag<R = f64>` and `k: R`",
            "f64",
        ),
        (field("#[law(skip, unit = \"m\")] k: R"), "field `k` is skipped, so it has no unit and no default", "k"),
    ]
    .map(|(text, message, token): (String, &str, &'static str)| (text, message.to_string(), token))
    .into();
    for (text, message, token) in table {
        assert_eq!(faults(&text), [(message, token.to_string())], "{text}");
    }
}

#[test]
fn several_faults_of_one_law_come_together() {
    let text = "#[law(reads(v: Velocity from (x)))] struct Drag<R, S> { k: R }";
    assert_eq!(faults(text).len(), 1, "the grammar ends at its first fault");
    let text = "#[law(reads(v: Velocity), rates(x: Position from (y)))] struct Drag<R, S> { k: R, l: R }";
    let messages: Vec<String> = faults(text).into_iter().map(|fault| fault.1).collect();
    assert_eq!(messages, ["S", "y", "k", "l"]);
}

#[test]
fn what_may_stand_together() {
    for attribute in [
        "reads(v: Velocity), rates(v: Velocity)",
        "reads(v: Velocity), rates(v: Velocity from (v)), amends(corrected: Velocity)",
        "reads(x: Position), amends(x: Position)",
        "reads(previous force: Force), adds(force: Force)",
        "reads(force: Force, previous before: Force), rates(v: Velocity)",
        "reads(x: Position), link(ends: Ends, reads(x: Position), adds(force: Force))",
        "scene(m: Mass), reads(own: Mass), adds(force: Force)",
        "reads(optional: Mass, previous: Charge), adds(force: Force)",
    ] {
        assert_eq!(faults(&law(attribute)), [], "{attribute}");
    }
}

#[test]
fn a_wrong_law_expands_to_its_error_once_and_a_stub() {
    for text in [law("read(v: Velocity)"), law("reads(v: Velocity)"), "enum Drag<'a, R, const N: usize> {}".into()] {
        let expansion = crate::law(tokens(&text));
        assert_eq!(compile_errors(&expansion).len(), 1, "{text}");
        assert!(syn::parse2::<syn::File>(expansion).is_ok(), "{text}");
    }
}

/// The traits that an expansion implements for `Drag`.
fn traits_of_drag(text: &str) -> Vec<String> {
    fn of_items(items: Vec<syn::Item>, found: &mut Vec<String>) {
        for item in items {
            match item {
                syn::Item::Impl(item) if item.self_ty.to_token_stream().to_string().starts_with("Drag ") => {
                    let last = item.trait_.and_then(|(path, _)| Some(path.segments.last()?.ident.to_string()));
                    found.extend(last);
                }
                syn::Item::Const(item) => {
                    let syn::Expr::Block(block) = *item.expr else { continue };
                    let items = block.block.stmts.into_iter();
                    let items =
                        items.filter_map(|stmt| if let syn::Stmt::Item(item) = stmt { Some(item) } else { None });
                    of_items(items.collect(), found);
                }
                _ => {}
            }
        }
    }
    let file: syn::File = syn::parse2(crate::law(tokens(text))).unwrap_or_else(|error| panic!("{error}: {text}"));
    let mut found = Vec::new();
    of_items(file.items, &mut found);
    found.sort();
    found
}

#[test]
fn the_stub_of_a_wrong_law_implements_what_a_right_one_does() {
    let right = traits_of_drag(&law("reads(v: Velocity), adds(force: Force)"));
    assert_eq!(right, ["Declared", "DeclaredColumns", "Default", "Law"]);
    assert_eq!(traits_of_drag(&law("read(v: Velocity), adds(force: Force)")), right);
}

#[test]
fn wrong_properties() {
    let table = [
        ("pub Mass: Scalar, \"kg\";", "property `Mass` has no doc comment: say what it is"),
        ("/** d */ pub Mass: Scaler, \"kg\";", "unknown kind `Scaler`: did you mean `Scalar`?"),
        (
            "/** d */ pub Mass: Tensor, \"kg\";",
            "unknown kind `Tensor`: known are `Scalar`, `Vector`, `Quaternion`, `Link`",
        ),
        ("/** d */ pub Mass: Scalar, \"kgg\";", "unknown unit `kgg` in \"kgg\": did you mean `kg`?"),
        (
            "/** d */ pub Mass: Scalar;",
            "property `Mass` has no unit: add one, as in `Scalar, \"m\"`; that of a pure number is \"1\"",
        ),
        ("/** d */ pub Ends: Link<0>;", "a link holds 1 to 255 rows"),
        ("/** d */ pub Ends: Link;", "a link says how many rows it holds: `Link<2>`"),
        ("/** d */ pub Ends: Link<N>;", "a link says how many rows it holds: `Link<2>`"),
        ("/** d */ pub Ends: Link<2>, \"m\";", "property `Ends` is a link: it has no unit"),
        ("/** d */ pub Ends: Link<2>, sum;", "property `Ends` is a link: it has no role"),
        ("/** d */ pub Mass: Scalar, \"kg\", sums;", "unknown role `sums`: did you mean `sum`?"),
        (
            "/** d */ pub Mass: Scalar, \"kg\", sum, coordinate;",
            "property `Mass` has a role already: it has one at most",
        ),
        ("/** d */ pub Mass: Scalar, \"kg\", momentum;", "a momentum moves a coordinate: write `momentum of Position`"),
        ("/** d */ pub Mass: Scalar, \"kg\", sum of Force;", "unknown word `of`: known are `from`"),
        (
            "/** d */ pub Mass = \"My mass\": Scalar, \"kg\";",
            "\"My mass\" is no name of a property: write it as \"rest_length\"",
        ),
        (
            "/** d */ pub Mass: Scalar \"kg\";",
            "property `Mass` has no unit: add one, as in `Scalar, \"m\"`; that of a pure number is \"1\"",
        ),
    ];
    for (text, message) in table {
        let expansion = crate::property::properties(tokens(text));
        assert_eq!(compile_errors(&expansion), [message], "{text}");
        let file: syn::File = syn::parse2(expansion).unwrap_or_else(|error| panic!("{error}: {text}"));
        assert!(file.items.iter().any(|item| matches!(item, syn::Item::Struct(_))), "the type is there: {text}");
    }
    let all: String = table.iter().map(|row| row.0).collect();
    assert_eq!(compile_errors(&crate::property::properties(tokens(&all))).len(), table.len(), "all faults at once");
}

#[test]
fn wrong_kernels() {
    let place = "`#[kernel]` stands on `impl RowLaw<R> for ...` (or PairLaw, LinkLaw, ColumnLaw)";
    let once = "a kernel is written once for every type of numbers: `impl<R: Real> RowLaw<R> for ...`";
    let named = "the law of a kernel is `Name<R>`, or `Name` where it has no parameters";
    let table = [
        ("", "fn row() {}", place),
        ("", "struct Drag;", place),
        ("", "impl Drag {}", place),
        ("", "impl<R: Real> RowLow<R> for Drag<R> {}", place),
        ("", "impl RowLaw<f64> for Drag<f64> {}", once),
        ("", "impl<R: Real> RowLaw<f64> for Drag<R> {}", once),
        ("", "impl<R: Real, S> RowLaw<R> for Drag<R> {}", once),
        ("", "impl<'a> RowLaw<R> for Drag<R> {}", once),
        (
            "",
            "impl<P> ColumnLaw for Drag<P> {}",
            &once.replace("R: Real", "P: Precision").replace("RowLaw<R>", "ColumnLaw<P>"),
        ),
        ("", "impl<R: Real> RowLaw<R> for Drag<f64> {}", named),
        ("", "impl<R: Real> RowLaw<R> for [R; 3] {}", named),
        (
            "gpu",
            "impl<R: Real> RowLaw<R> for Drag<R> {}",
            "`#[kernel]` takes no arguments: the trait says which shape it is",
        ),
    ];
    for (arguments, item, message) in table {
        let expansion = crate::kernel::kernel(tokens(arguments), tokens(item));
        assert_eq!(compile_errors(&expansion), [message], "{item}");
        assert!(super::plain(&expansion).starts_with(&super::plain(&tokens(item))), "the item stays: {item}");
    }
}

/// Every single token left out, doubled, or swapped with the next one, at every depth: an answer, never a panic.
#[test]
fn no_tokens_panic() {
    let law = "/// Doc.\n #[law(domain = \"bodies\", reads(v: Velocity, previous f: Force, optional), scene(g: G = [0, 0, -9.81]), \
               rates(x: Position from (v)), link(ends: Ends, reads(p: Position), adds(f: Force)))] \
               pub struct Drag<R = f64> { #[law(unit = \"m/s\", default = [1, 2, 3])] k: R::Vec3, #[law(skip)] m: Vec<f64> }";
    let property =
        "/// Doc.\n pub Force = \"force\": Vector, \"N\", sum from ExternalForce; /// Doc.\n pub Ends: Link<2>;";
    let kernel = "impl<R: Real> LinkLaw<R, 2> for Spring<R> { fn link(&self) {} }";
    let mut tried = 0;
    for mutated in mutations(&tokens(law)) {
        crate::law(mutated);
        tried += 1;
    }
    for mutated in mutations(&tokens(property)) {
        crate::property::properties(mutated);
        tried += 1;
    }
    for mutated in mutations(&tokens(kernel)) {
        crate::kernel::kernel(proc_macro2::TokenStream::new(), mutated);
        tried += 1;
    }
    assert!(tried > 400, "{tried}");
}

fn mutations(stream: &proc_macro2::TokenStream) -> Vec<proc_macro2::TokenStream> {
    let tokens: Vec<proc_macro2::TokenTree> = stream.clone().into_iter().collect();
    let mut made = Vec::new();
    for i in 0..tokens.len() {
        let (before, after) = (&tokens[..i], &tokens[i + 1..]);
        let join = |middle: &[proc_macro2::TokenTree]| [before, middle, after].concat().into_iter().collect();
        made.push(join(&[]));
        made.push(join(&[tokens[i].clone(), tokens[i].clone()]));
        let mut swapped = tokens.clone();
        swapped.swap(i, (i + 1) % tokens.len());
        made.push(swapped.into_iter().collect());
        if let proc_macro2::TokenTree::Group(group) = &tokens[i] {
            for inner in mutations(&group.stream()) {
                made.push(join(&[proc_macro2::Group::new(group.delimiter(), inner).into()]));
            }
        }
    }
    made
}
