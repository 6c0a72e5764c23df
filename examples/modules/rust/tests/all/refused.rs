//! What can be wrong with a module, and what is said of it.

use super::compiler::{compiled, opened, wings};
use super::failures::ONE;
use std::path::Path;
use vesper::module::{LawPath, Module};
use vesper::prelude::*;
use vesper_laws::Motion;

fn bodies() -> Domain<f64> {
    Domain::new("bodies").with(Position, [[0.0; 3]; 3]).with(Velocity, [[1.0, 0.0, 0.0]; 3]).with(Mass, [1.0, 2.0, 3.0])
}

/// What is said of a file that is no module at all.
fn said_of(path: &Path) -> String {
    // SAFETY: nothing of it is run.
    unsafe { Module::open(path) }.unwrap_err().to_string()
}

#[test]
fn files_that_are_no_modules() {
    let folder = compiled("some", "int some(void) { return 0; }").parent().unwrap().to_owned();
    assert!(
        said_of(&folder.join("libnone.so")).starts_with("module none: "),
        "{}",
        said_of(&folder.join("libnone.so"))
    );
    std::fs::write(folder.join("libtext.so"), "This is no library.").unwrap();
    let text = said_of(&folder.join("libtext.so"));
    assert!(
        text.starts_with("module text: it is no library that can be loaded: ") && text.contains("libtext.so"),
        "{text}"
    );
    let some = said_of(&folder.join("libsome.so"));
    assert!(
        some.starts_with("module some: it is a library, but no module: it exports no vesper_module_v1 ("),
        "{some}"
    );
    let next = compiled("next", "int vesper_module_v2(void) { return 0; }");
    assert_eq!(
        said_of(&next),
        "module next: it speaks version 2 of the interface, and this host version 1: build it again"
    );
}

#[test]
fn names_that_are_not_there() {
    let folder = compiled("lift", &super::compiler::lift_in_c()).parent().unwrap().to_owned();
    let said = |path: &LawPath, name: &str| {
        // SAFETY: these are of this project.
        unsafe { path.module(name) }.unwrap_err().to_string()
    };
    let path = LawPath::new([&folder]);
    let missing = said(&path, "lfit");
    assert!(
        missing.starts_with("module lfit: there is no liblfit.so in ") && missing.ends_with("; did you mean lift?"),
        "{missing}"
    );
    for name in ["../lift", "a/b", "", "lib lift"] {
        assert!(said(&path, name).contains("a module is called by its name, without folder"), "{name}");
    }
    let nowhere = said(&LawPath::default(), "lift");
    assert_eq!(nowhere, "module lift: there is no folder to look for liblift.so in: give one, or set VESPER_LAW_PATH");
    let law = wings().law("lfit").unwrap_err().to_string();
    assert_eq!(law, "module wings: it has no law lfit; did you mean lift?");
    let lift = || wings().law("lift").unwrap();
    assert_eq!(
        lift().with("slop", &[1.0]).unwrap_err().to_string(),
        "lift: it has no parameter slop; did you mean slope?"
    );
    let wide = lift().with("slope", &[1.0, 2.0, 3.0]).unwrap_err().to_string();
    assert_eq!(wide, "lift: parameter slope has 1 components, and 3 are given");
    assert!(lift().with_all(&[]).unwrap_err().to_string().ends_with("1 components, and 0 are given"));
}

/// The table of [`ONE`] changed in one place, and what is said of it.
const TABLES: &[(&str, &str, &str, &str)] = &[
    ("old", "{VESPER_LAW_ABI, sizeof module", "{9, sizeof module", "its table is of version 9, and this host speaks 1"),
    ("cut", "{VESPER_LAW_ABI, sizeof module", "{VESPER_LAW_ABI, 8", "its table is cut off: 8 bytes, and 32 are needed"),
    ("many", "0, 2, laws}", "0, 5000000, laws}", "it says that it has 5000000 laws"),
    ("nothing", "return &module", "return 0", "vesper_module_v1 returned no table"),
];

#[test]
fn tables_that_cannot_be_read() {
    for (name, from, to, expected) in TABLES {
        assert!(ONE.contains(from), "{from}");
        let said = opened(name, &ONE.replace("BODY", "").replace(from, to)).unwrap_err().to_string();
        assert!(said.contains(expected), "{name}: {said}");
    }
}

/// One law of [`ONE`] changed in one place, and what is said of it. The other law of the module stays.
const LAWS: &[(&str, &str, &str, &str)] = &[
    ("small", ".struct_size = sizeof(vesper_law)", ".struct_size = 40", "the table of a law has 40 bytes"),
    ("ports", ".port_size = sizeof *ports", ".port_size = 4", "a port has 4 bytes, and 88 are needed"),
    ("no_name", ".name = #law", ".name = \"No Name\"", "names have small letters, digits and _"),
    ("no_precision", "VESPER_LAW_F64", "4", "takes numbers of no precision"),
    ("no_shape", "VESPER_ROWS", "7", "has the shape 7: 1 rows, 2 pairs, 3 links, 4 columns"),
    ("no_create", ".create = create", ".create = 0", "has no function `create`"),
    (
        "no_memory",
        ".apply = f",
        ".apply = f, .state_size = 8",
        "has a memory of 8 bytes, but not both of `save` and `load`",
    ),
    ("other_kind", ".kind = 1, .mode", ".kind = 3, .mode", "reads mass as a vector [kg], but it is a scalar [kg]"),
    (
        "no_kind",
        ".kind = 1, .mode",
        ".kind = 2, .mode",
        "mass is of kind 2: 1 for a number, 3 for a vector, 4 for a quaternion",
    ),
    ("other_unit", ".si = {0, 1}", ".si = {1}", "reads mass as a scalar [m], but it is a scalar [kg]"),
    (
        "two_units",
        ".si = {0, 1}",
        ".unit = \"m\", .si = {0, 1}",
        "mass is in m, but its exponents `si` (of m, kg, s, A, K, mol, cd) say kg",
    ),
    ("no_unit", ".si = {0, 1}", ".unit = \"stone\", .si = {0, 1}", "the unit of mass: "),
    ("no_mode", ".mode = VESPER_ADDS", ".mode = 12", "force has the mode 12"),
    ("changes_nothing", ".mode = VESPER_ADDS", ".mode = VESPER_READS", "changes nothing"),
    (
        "order",
        "{.property = \"mass\", .si = {0, 1}, .kind = 1, .mode = VESPER_READS}",
        "{.property = \"strain\", .kind = 1, .mode = VESPER_SETS}",
        "is read, and stands behind what is written: inputs come first",
    ),
    (
        "default",
        ".kind = 1, .mode",
        ".has_default = 1, .kind = 1, .mode",
        "mass has a default, which only a constant of the scene can have",
    ),
    (
        "ends",
        ".kind = 1, .mode",
        ".place = VESPER_END, .kind = 1, .mode",
        "mass is of rows linked to, and only a law of links has those",
    ),
    (
        "odd_size",
        ".port_size = sizeof *ports",
        ".port_size = sizeof *ports + 4",
        "a port has 92 bytes, and 88 are needed",
    ),
    (
        "turn",
        ".kind = 3, .mode = VESPER_ADDS",
        ".role = VESPER_TURN, .role_of = \"force\", .kind = 3, .mode = VESPER_ADDS",
        "force is a turn by nothing: set `role_by`",
    ),
    (
        "constant",
        ".mode = VESPER_ADDS",
        ".mode = VESPER_ADDS, .place = VESPER_SCENE",
        "adds to force, which is a constant of the scene: it may be read",
    ),
];

#[test]
fn laws_that_say_what_cannot_be() {
    for (name, from, to, expected) in LAWS {
        assert!(ONE.contains(from), "{from}");
        let module = opened(name, &ONE.replace("BODY", "").replace(from, to)).unwrap();
        let said: Vec<String> = module.refused().iter().map(ToString::to_string).collect();
        assert!(said.iter().any(|said| said.contains(expected)), "{name}: {said:?}");
    }
}

#[test]
fn a_wrong_law_takes_no_other_with_it() {
    let source = ONE.replace("BODY", "").replace("LAW(fine, right);", "#define sizeof_port 4\nLAW(fine, right);\n");
    let source = source.replace("{&wrong, &fine}", "{&fine, 0, &fine}").replace("0, 2, laws}", "0, 3, laws}");
    let source = source.replace("LAW(wrong, apply);", "LAW(wrong, apply);\nconst void *used = &wrong;");
    let module = opened("two", &source).unwrap();
    let said: Vec<String> = module.refused().iter().map(ToString::to_string).collect();
    assert_eq!(said.len(), 2, "{said:?}");
    assert!(said[0].contains("its table has an empty place") && said[1].contains("it has two laws fine"), "{said:?}");
    let builder = Engine::builder().domain(bodies()).law(Motion).law(module.law("fine").unwrap());
    builder.step(0.1).build().unwrap().advance(0.1).unwrap();
}

/// Bodies that write what they should not, and what is said of them.
const BODIES: &[(&str, &str, &str)] = &[
    (
        "before",
        "force[(ptrdiff_t)call->begin - 5] = 1;",
        "writes outside of force: to row -3, where 8 rows are from 0 on",
    ),
    ("behind", "force[call->end + 4] = 1;", "writes outside of force: to row 10, where 8 rows are from 0 on"),
    (
        "others",
        "force[call->end] += 1;",
        "writes to row 6 of force, and was called for the rows from `begin` 2 to before `end` 6",
    ),
    (
        "input",
        "mass[call->begin] = 2;",
        "writes to row 2 of mass, which it says it reads: declare it as written, or leave it",
    ),
];

#[test]
fn laws_that_write_what_they_do_not_say_are_not_made() {
    for (name, body, expected) in BODIES {
        let module = opened(name, &ONE.replace("BODY", body)).unwrap();
        let builder = Engine::builder().domain(bodies()).law(Motion).law(module.law("wrong").unwrap());
        let said = builder.step(0.1).build().unwrap_err().to_string();
        assert_eq!(said, format!("wrong cannot be made: it {expected}"), "{name}");
    }
    let sets = ONE.replace(
        "{.property = \"force\", .si = {1, 1, -2}, .kind = 3, .mode = VESPER_ADDS}",
        "{.property = \"strain\", .kind = 3, .mode = VESPER_SETS}",
    );
    let module =
        opened("leaves", &sets.replace("BODY", "for (size_t i = call->begin + 1; i < call->end; i++) force[i] = 1;"))
            .unwrap();
    let builder = Engine::builder().domain(bodies()).law(Motion).law(module.law("wrong").unwrap());
    let said = builder.step(0.1).build().unwrap_err().to_string();
    assert_eq!(
        said,
        "wrong cannot be made: it sets strain, and leaves out row 2 of those from `begin` 2 to before `end` 6"
    );
}

#[test]
fn laws_that_do_not_fit_a_scene_are_told_as_any_other() {
    let wrong = |change: &dyn Fn(&str) -> String, name: &str, bodies: Domain<f64>| {
        let module = opened(name, &change(&ONE.replace("BODY", ""))).unwrap();
        assert_eq!(module.refused(), [], "{name}");
        let builder = Engine::builder().domain(bodies).law(Motion).law(module.law("wrong").unwrap());
        builder.step(0.1).strict().build().unwrap_err().to_string()
    };
    let sets_mass =
        |source: &str| source.replace(".kind = 1, .mode = VESPER_READS},", ".kind = 1, .mode = VESPER_READS}, /**/");
    let charged = |source: &str| sets_mass(source).replace("\"mass\", .si = {0, 1}", "\"charge\", .si = {0, 0, 1, 1}");
    let said = wrong(&charged, "charged", bodies());
    assert!(
        said.contains("wrong must run, but is dormant: it reads charge [C], which domain bodies does not have"),
        "{said}"
    );
    let own = PropertyInfo::at_run_time("load", Kind::Vector, "N").unwrap();
    let loaded = |source: &str| source.replace("\"mass\", .si = {0, 1}", "\"load\", .si = {1, 1, -2}");
    let said = wrong(&loaded, "loaded", bodies().with(own, [[0.0; 3]; 3]));
    assert!(
        said.contains(
            "property load is declared as scalar [m kg s^-2] by law wrong and as vector [N] by domain bodies"
        ),
        "{said}"
    );
    let sets = |source: &str| {
        source
            .replace(
                "\"force\", .si = {1, 1, -2}, .kind = 3, .mode = VESPER_ADDS",
                "\"mass\", .si = {0, 1}, .kind = 1, .mode = VESPER_SETS",
            )
            .replace(
                "\"mass\", .si = {0, 1}, .kind = 1, .mode = VESPER_READS",
                "\"rest_mass\", .si = {0, 1}, .kind = 1, .mode = VESPER_READS",
            )
            .replace(
                "return 0;\n}\nstatic int32_t right",
                "for (size_t i = call->begin; i < call->end; i++) force[i] = 1;\n return 0;\n}\nstatic int32_t right",
            )
    };
    let said = wrong(&sets, "sets", bodies().with(RestMass, [1.0; 3]));
    assert!(said.contains("wrong sets bodies.mass, which the client gives"), "{said}");
}

#[test]
fn a_law_that_cannot_be_made_says_why() {
    let source = ONE.replace("BODY", "").replace(
        "*self = (void *)host; return 0;",
        "host->log(host->context, VESPER_ERROR, \"no feathers\"); *self = 0; return 3;",
    );
    let module = opened("featherless", &source).unwrap();
    let builder = Engine::builder().domain(bodies()).law(Motion).law(module.law("wrong").unwrap());
    let said = builder.step(0.1).build().unwrap_err().to_string();
    assert_eq!(said, "wrong cannot be made: `create` returned 3: no feathers");
}

#[test]
fn a_parameter_without_a_default_has_to_be_given() {
    let source = super::compiler::lift_in_c().replace(".has_default = 1, ", "");
    let module = opened("bare", &source).unwrap();
    let build = |law| Engine::<f64>::builder().domain(bodies()).law(Motion).law(law).step(0.1).build();
    let said = build(module.law("lift").unwrap()).unwrap_err().to_string();
    assert_eq!(said, "lift: parameter slope is NaN: give a finite number");
    build(module.law("lift").unwrap().with("slope", &[1.0]).unwrap()).unwrap();
}
