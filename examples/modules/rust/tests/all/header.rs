//! The structures of `vesper_law.h` are those of `vesper::module::abi`: names, places, sizes.

use super::compiler::project;
use std::path::Path;
use std::process::Command;
use vesper::module::abi;

/// Fields with their places, of a structure on both sides.
macro_rules! structure {
    ($rust:ident, $c:literal, [$($field:ident),+ $(,)?]) => {
        (
            $c,
            size_of::<abi::$rust>(),
            vec![$((stringify!($field), core::mem::offset_of!(abi::$rust, $field))),+],
        )
    };
}

#[test]
fn c_and_rust_have_the_same_structures() {
    let structures = [
        structure!(Module, "vesper_module", [abi, struct_size, build, law_count, laws]),
        structure!(
            Port,
            "vesper_port",
            [
                property,
                field,
                unit,
                si,
                kind,
                mode,
                place,
                role,
                optional,
                has_default,
                role_of,
                role_by,
                default_value,
                from
            ]
        ),
        structure!(Parameter, "vesper_parameter", [name, doc, unit, width, has_default, default_value]),
        structure!(
            Law,
            "vesper_law",
            [
                struct_size,
                port_size,
                parameter_size,
                shape,
                precisions,
                native,
                name,
                doc,
                domain,
                link,
                link_arity,
                structure,
                port_count,
                ports,
                parameter_count,
                parameters,
                create,
                apply,
                energy,
                destroy,
                state_size,
                save,
                load
            ]
        ),
        structure!(Host, "vesper_host", [struct_size, abi, context, log]),
        structure!(
            Call,
            "vesper_call",
            [struct_size, precision, begin, end, others_begin, others_end, slots, strides, rows, links, native]
        ),
    ];
    let mut code = "#include \"vesper_law.h\"\n#include <stdio.h>\nint main(void) {\n".to_owned();
    let mut expected = String::new();
    for (name, size, fields) in &structures {
        code += &format!("printf(\"{name} %zu\\n\", sizeof({name}));\n");
        expected += &format!("{name} {size}\n");
        for (field, place) in fields {
            code += &format!("printf(\"{name}.{field} %zu\\n\", offsetof({name}, {field}));\n");
            expected += &format!("{name}.{field} {place}\n");
        }
    }
    for (name, value) in [
        ("VESPER_LAW_ABI", abi::VERSION),
        ("VESPER_LAW_F32", abi::F32),
        ("VESPER_LAW_F64", abi::F64),
        ("VESPER_ERROR", abi::LOG_ERROR),
    ] {
        code += &format!("printf(\"{name} %u\\n\", (unsigned){name});\n");
        expected += &format!("{name} {value}\n");
    }
    code += "return 0;\n}\n";
    // Every field of the header is compared: the fields of its structures are as many.
    let header = std::fs::read_to_string(project().join("bindings/c/include/vesper_law.h")).unwrap();
    for (name, _, fields) in &structures {
        let body = header
            .split(&format!("typedef struct {name} {{"))
            .nth(1)
            .unwrap()
            .split(&format!("}} {name};"))
            .next()
            .unwrap();
        let without_comments: String =
            body.split("/*").map(|part| part.split_once("*/").map_or(part, |(_, rest)| rest)).collect();
        let declared: usize = without_comments.split(';').map(fields_of).sum();
        assert_eq!(declared, fields.len(), "{name}: {without_comments}");
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let (file, program) = (folder.join("layout.c"), folder.join("layout"));
    std::fs::write(&file, code).unwrap();
    for (compiler, dialect) in [("cc", "-std=c99"), ("c++", "-std=c++17")] {
        let mut command = Command::new(compiler);
        command.args([
            "-x",
            if compiler == "cc" { "c" } else { "c++" },
            dialect,
            "-pedantic",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-I",
        ]);
        let built = command.arg(project().join("bindings/c/include")).arg("-o").args([&program, &file]).output();
        // Rust links with `cc`; a compiler of C++ need not be there.
        let Ok(built) = built else {
            assert_ne!(compiler, "cc");
            eprintln!("there is no {compiler}: the header was not tried in it");
            continue;
        };
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
        let told = Command::new(&program).output().unwrap();
        assert_eq!(String::from_utf8_lossy(&told.stdout), expected);
    }
}

/// How many fields a line of a structure declares.
fn fields_of(line: &str) -> usize {
    let line = line.trim();
    match (line.is_empty(), line.contains('(')) {
        (true, _) => 0,
        (false, true) => 1,
        (false, false) => line.split(',').count(),
    }
}
