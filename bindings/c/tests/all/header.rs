//! The header against the code: every function, structure and constant, in both directions.

use vesper_c::interface::declare::{Constant, Function, Record};
use vesper_c::interface::*;

const HEADER: &str = include_str!("../../include/vesper.h");
const LAYOUT: &str = include_str!("../layout.c");

fn functions() -> Vec<&'static Function> {
    [GENERAL_FUNCTIONS, LOG_FUNCTIONS, BUILDER_FUNCTIONS, ENGINE_FUNCTIONS].into_iter().flatten().collect()
}

fn records() -> Vec<&'static Record> {
    [BUILDER_RECORDS, ENGINE_RECORDS, COLUMN_RECORDS].into_iter().flatten().collect()
}

fn constants() -> Vec<&'static Constant> {
    [STATUSES, TYPES, ACCESSES, TEXTS, LOG_LEVELS, VERSION].into_iter().flatten().collect()
}

/// The header without comments and directives, with one blank between words.
fn code(header: &str) -> String {
    let mut text = header.to_owned();
    while let Some(start) = text.find("/*") {
        let end = start + text[start..].find("*/").unwrap() + 2;
        text.replace_range(start..end, " ");
    }
    let lines = text.lines().filter(|line| !line.starts_with('#') && !line.contains("extern \"C\"") && *line != "}");
    lines.flat_map(str::split_whitespace).collect::<Vec<_>>().join(" ")
}

/// A type of C in the words of Rust.
fn in_rust(of_c: &str) -> String {
    let of_c = of_c.trim();
    if let Some(inner) = of_c.strip_suffix('*') {
        let inner = inner.trim();
        return match inner.strip_prefix("const ") {
            Some(inner) if !inner.ends_with('*') => format!("*const {}", in_rust(inner)),
            _ => format!("*mut {}", in_rust(inner)),
        };
    }
    let word = match of_c {
        "void" => "c_void",
        "char" => "c_char",
        "double" => "f64",
        "size_t" => "usize",
        "int32_t" => "i32",
        "uint32_t" => "u32",
        "uint64_t" => "u64",
        "vesper_status" => "Status",
        "vesper_type" => "Type",
        "vesper_log_callback" => "LogCallback",
        other => records().iter().find(|record| record.in_c == other).map_or("unknown", |record| record.name),
    };
    word.to_owned()
}

/// `const char *domain` as ("domain", "*const c_char"), `void *component[4]` as an array.
fn declared(text: &str) -> (String, String) {
    let text = text.trim();
    let (text, count) = match text.strip_suffix(']').and_then(|text| text.rsplit_once('[')) {
        Some((text, count)) => (text, Some(count)),
        None => (text, None),
    };
    let start = text.rfind([' ', '*']).unwrap() + 1;
    let type_ = in_rust(&text[..start]);
    (text[start..].to_owned(), count.map_or(type_.clone(), |count| format!("[{type_}; {count}]")))
}

/// The functions of a header, as lines: name, parameters, result.
fn functions_of(header: &str) -> Vec<String> {
    let code = code(header);
    let statements = code.split(';').map(str::trim);
    let prototypes =
        statements.filter(|text| text.ends_with(')') && !text.starts_with("typedef") && text.contains('('));
    let line = |text: &str| {
        let (head, parameters) = text.trim_end_matches(')').split_once('(').unwrap();
        let (name, result) = declared(head);
        let parameters = parameters.split(',').filter(|parameter| *parameter != "void").map(|parameter| {
            let (name, type_) = declared(parameter);
            format!("{name}: {type_}")
        });
        format!("{name}({}) -> {result}", parameters.collect::<Vec<_>>().join(", "))
    };
    prototypes.map(line).collect()
}

fn in_words(function: &Function) -> String {
    let parameter = |(name, type_): &(&str, &str)| format!("{}: {type_}", name.trim_end_matches('_'));
    let parameters: Vec<String> = function.parameters.iter().map(parameter).collect();
    format!("{}({}) -> {}", function.name, parameters.join(", "), function.result)
}

fn sorted(mut lines: Vec<String>) -> Vec<String> {
    lines.sort();
    lines
}

#[test]
fn it_has_every_function_and_no_other() {
    let of_code: Vec<String> = functions().into_iter().map(in_words).collect();
    assert!(of_code.len() < 30, "{} functions", of_code.len());
    assert_eq!(sorted(functions_of(HEADER)), sorted(of_code));
}

#[test]
fn it_has_every_structure_and_no_other() {
    let code = code(HEADER);
    let mut of_header = Vec::new();
    for text in code.split("typedef struct ").skip(1) {
        let (name, rest) = text.split_once(" {").unwrap();
        let (fields, rest) = rest.split_once('}').unwrap();
        assert_eq!(rest.split(';').next().unwrap().trim(), name, "named twice alike");
        let fields = fields.split(';').filter(|field| !field.trim().is_empty()).map(declared);
        of_header.push(format!("{name} {:?}", fields.collect::<Vec<_>>()));
    }
    let field = |(name, type_): &(&str, &str)| (name.trim_end_matches('_').to_owned(), (*type_).to_owned());
    let of_code = records()
        .into_iter()
        .map(|record| format!("{} {:?}", record.in_c, record.fields.iter().map(field).collect::<Vec<_>>()));
    assert_eq!(sorted(of_header), sorted(of_code.collect()));
}

#[test]
fn it_has_every_constant_and_no_other() {
    let code = code(HEADER);
    let enums = code.split("enum {").skip(1).map(|text| text.split('}').next().unwrap());
    let version = HEADER.lines().filter_map(|line| line.strip_prefix("#define VESPER_ABI_VERSION "));
    let mut of_header: Vec<String> = version.map(|value| format!("VESPER_ABI_VERSION = {value}")).collect();
    of_header.extend(enums.flat_map(|text| text.split(',')).map(|text| text.trim().to_owned()));
    let of_code = constants().into_iter().map(|constant| format!("{} = {}", constant.name, constant.value));
    assert_eq!(sorted(of_header), sorted(of_code.collect()));
}

#[test]
fn it_has_the_types_that_are_named() {
    let code = code(HEADER);
    for text in [
        "typedef int32_t vesper_status;",
        "typedef uint32_t vesper_type;",
        "typedef void (*vesper_log_callback)(uint32_t level, const char *text, void *user);",
    ] {
        assert!(code.contains(text), "{text}");
    }
    let _: fn(i32) -> Status = |status| status;
    let _: fn(u32) -> Type = |type_| type_;
    let callback: unsafe extern "C" fn(u32, *const core::ffi::c_char, *mut core::ffi::c_void) = not_called;
    let _: LogCallback = Some(callback);
}

unsafe extern "C" fn not_called(_: u32, _: *const core::ffi::c_char, _: *mut core::ffi::c_void) {}

#[test]
fn sizes_and_places_are_those_of_the_c_compiler() {
    let mut compared = 0;
    for line in LAYOUT.lines() {
        let inside = |word: &str| Some(line.strip_prefix(word)?.strip_suffix(");")?.split(", ").collect::<Vec<_>>());
        if let Some([name, bytes]) = inside("SIZE(").as_deref() {
            let record = records().into_iter().find(|record| record.in_c == *name).unwrap();
            assert_eq!(record.size.to_string(), *bytes, "{name}");
            compared += 1;
        }
        if let Some([name, field, bytes]) = inside("OFFSET(").as_deref() {
            assert_eq!(offset(name, field).to_string(), *bytes, "{name}.{field}");
            compared += 1;
        }
    }
    let fields: usize = [COLUMN_RECORDS].into_iter().flatten().map(|record| record.fields.len()).sum();
    assert_eq!(compared, records().len() + fields);
}

fn offset(record: &str, field: &str) -> usize {
    match (record, field) {
        ("vesper_column", "component") => core::mem::offset_of!(ColumnView, component),
        ("vesper_column", "subset") => core::mem::offset_of!(ColumnView, subset),
        ("vesper_column", "rows") => core::mem::offset_of!(ColumnView, rows),
        ("vesper_column", "stride") => core::mem::offset_of!(ColumnView, stride),
        ("vesper_column", "width") => core::mem::offset_of!(ColumnView, width),
        ("vesper_column", "type") => core::mem::offset_of!(ColumnView, type_),
        ("vesper_values", "property") => core::mem::offset_of!(Values, property),
        ("vesper_values", "numbers") => core::mem::offset_of!(Values, numbers),
        ("vesper_values", "count") => core::mem::offset_of!(Values, count),
        ("vesper_values", "type") => core::mem::offset_of!(Values, type_),
        _ => panic!("{record}.{field}"),
    }
}

#[test]
fn the_comparison_sees_what_differs() {
    let changed = |from: &str, to: &str| {
        assert!(HEADER.contains(from), "{from}");
        functions_of(&HEADER.replace(from, to))
    };
    let right = functions_of(HEADER);
    for (from, to) in [
        ("uint64_t count, double step", "uint32_t count, double step"),
        ("uint64_t count, double step", "double step, uint64_t count"),
        ("const vesper_values *columns", "vesper_values *columns"),
        ("const char **text", "char **text"),
        ("vesper_status vesper_engine_free(vesper_engine engine);", ""),
        ("uint32_t vesper_abi_version(void)", "int32_t vesper_abi_version(void)"),
    ] {
        assert_ne!(changed(from, to), right, "{from}");
    }
}
