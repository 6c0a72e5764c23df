//! Mistakes in scene files: text, place, message.

use std::path::Path;

use vesper_cli::scene::*;

fn faults(text: &str) -> Vec<SceneFault> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes");
    Scene::from_text("a.toml", text, &folder, &[]).err().unwrap_or_default()
}

/// Scene, then "line:column: message" with "; help" where there is one.
const TABLE: &[(&str, &str)] = &[
    // Syntax.
    ("[engine]\nstep = ", "2:8: a value is missing here"),
    ("[engine]\nprecision = f64", "2:13: text must stand in quotes"),
    ("[engine]\nstrict = flase", "2:10: expected `false`, or text in quotes"),
    ("[engine\nstep = 1", "1:8: unclosed table, expected `]`"),
    ("title = \"a\n", "1:11: invalid basic string, expected `\"`"),
    ("[engine]\nstep = 1\nstep = 2", "3:1: duplicate key"),
    // Unknown keys.
    ("[engin]\nstep = 1", "1:2: `engin` is not known in a scene; did you mean `engine`?"),
    (
        "[engine]\nstep_size = 1",
        "2:1: `step_size` is not known in [engine]; known here: precision, integrator, step, frame, end, backend, threads, strict, compensated, across_jumps, estimates, moving_origin, observe",
    ),
    ("[engine]\nintergrator = \"rk4\"", "2:1: `intergrator` is not known in [engine]; did you mean `integrator`?"),
    (
        "[domains.a]\nv = { value = [1], units = \"m\" }",
        "2:20: `units` is not known in column `v`; did you mean `unit`?",
    ),
    ("[constants]\ng = { vale = 1 }", "2:7: `vale` is not known in `g`; did you mean `value`?"),
    ("[fields.e]\nunifrom = [0, 0, 1]", "2:1: `unifrom` is not known in [fields.e]; did you mean `uniform`?"),
    // Wrong types.
    ("title = 3", "1:9: expected text, found a number"),
    ("engine = 3", "1:10: expected a table of settings, found a number"),
    ("[engine]\nstep = \"1e-3\"", "2:8: expected a number, found text"),
    ("[engine]\nstep = -1", "2:8: expected a time above 0, found -1"),
    ("[engine]\nend = { value = 3, unit = \"km\" }", "2:27: expected a unit like s, found km"),
    ("[engine]\nend = { value = 3, unit = \"msec\" }", "2:27: unknown unit `msec` in \"msec\": did you mean `ms`?"),
    ("[engine]\nstrict = \"no\"", "2:10: expected true or false, found text"),
    ("[engine]\nthreads = 1.5", "2:11: expected a whole number, 1 or more, found 1.5"),
    (
        "[engine]\nbackend = \"paralel\"",
        "2:11: expected \"auto\" or \"cpu\" or \"parallel\" or \"gpu\" or \"fastest\", found \"paralel\"; did you mean `parallel`?",
    ),
    ("[engine]\nobserve = [\"position\"]", "2:12: expected \"domain.property\", found \"position\""),
    (
        "[engine]\nobserve = [\"bodis.position\"]\n[domains.bodies]\nmass=[1]",
        "2:12: the scene has no domain `bodis`; did you mean `bodies`?",
    ),
    ("[engine]\nintegrator = { rtol = 1 }", "2:1: `integrator` needs `name`"),
    ("[constants]\nc = nan", "2:5: expected a number, found nan"),
    ("[constants]\nc = inf", "2:5: expected a finite number, found inf"),
    ("[constants]\nc = 1e999", "2:5: expected a finite number, found inf"),
    // Far fields.
    (
        "[[laws]]\nname = \"gravity\"\nfar_field = { method = \"multipol\", error = 1e-4 }",
        "3:24: expected \"multipole\", found \"multipol\"; did you mean `multipole`?",
    ),
    ("[[laws]]\nname = \"gravity\"\nfar_field = { method = \"multipole\" }", "3:13: a far field needs `error`"),
    (
        "[[laws]]\nname = \"gravity\"\nfar_field = 1e-4",
        "3:13: expected a table such as `{ method = \"multipole\", error = 1e-4 }`, found a number",
    ),
    // Columns.
    (
        "[domains.a]\nmass = 1",
        "2:8: expected a list with an entry for each row, found a number; one entry for each row: [..]",
    ),
    ("[domains.a]\nv = [[0, \"fast\", 15], [0, 0, 15]]", "2:10: expected a number, found text"),
    ("[domains.a]\nv = [[0, 0, 15], [0, 0]]", "2:18: this item has 2 components, the first has 3"),
    ("[domains.a]\nv = [1, 2]\nx = [1, 2, 3]", "3:1: `x` has 3 rows, `v` has 2"),
    ("[domains.a]\nname = [\"one\"]\nx = [1, 2, 3]", "2:8: `name` has 1 row, `x` has 3"),
    ("[domains.a]\nx = { value = [1], unit = \"kmm\" }", "2:27: "),
    (
        "[domains.a]\nx = [1, 2]\nq = { rows = [2], value = [1] }",
        "3:15: row 2 does not exist: `a` has 2 rows; rows count from 0 to 1",
    ),
    ("[domains.a]\nx = [1, 2]\nq = { rows = [1, 1], value = [1, 2] }", "3:18: row 1 is named twice"),
    ("[domains.a]\nq = { rows = [0, 1], value = [1] }", "2:30: `rows` names 2 rows, `value` has 1 row"),
    (
        "[domains.a]\nx = [1, 2]\n[domains.s]\nends = { domain = \"a\", value = [[0, 1], [0, 2]] }",
        "4:41: row 2 does not exist: `a` has 2 rows; rows count from 0 to 1",
    ),
    (
        "[domains.a]\nx = [1]\n[domains.s]\nends = { domain = \"b\", value = [[0, 1]] }",
        "4:19: the scene has no domain `b`; known here: a, s, scene",
    ),
    ("[domains.s]\nends = { domain = \"s\", value = [[0, -1]] }", "2:37: expected a whole number, 0 or more, found -1"),
    (
        "[domains.p]\nunits = { x = \"m\" }",
        "2:1: `units` belongs to `from`, which is not here; write `{ value = [..], unit = \"..\" }` in the column",
    ),
    (
        "[domains.p]\nfrom = { csv = \"none.csv\", x = \"x_au\" }",
        "2:16: cannot read `none.csv`: No such file or directory (os error 2)",
    ),
    (
        "[domains.p]\nfrom = { csv = \"planets.csv\", x = \"x_ua\" }",
        "2:35: `planets.csv` has no column `x_ua`; did you mean `x_au`?",
    ),
    (
        "[domains.p]\nfrom = { csv = \"planets.csv\", x = \"x_au\" }\nunits = { y = \"m\" }",
        "3:11: `from` fills no column `y`; known here: x",
    ),
    (
        "[domains.p]\nfrom = { csv = \"planets.csv\", x = \"x_au\" }\nx = [1, 2, 3]",
        "3:1: column `x` of `p` has two sources; write it, or read it from a file, or generate it",
    ),
    // Fields.
    ("[fields.e]\nunit = \"V/m\"", "1:9: [fields.e] has no shape; one of boxes, uniform, point, dipole"),
    (
        "[fields.e]\nuniform = 1\npoint = { at = [0,0,0], strength = 1 }",
        "3:1: a field has one shape, and `uniform` is one already",
    ),
    ("[fields.e]\nboxes = [{ min = [0, 0], max = [1, 1, 1], value = 1 }]", "2:18: expected 3 numbers, found 2"),
    (
        "[fields.e]\nboxes = [{ min = [0, 0, 0], max = [1, 0, 1], value = 1 }]",
        "2:10: the box is empty: in y, min 0 is not below max 0",
    ),
    // Generators.
    ("[generate.bodies]\nkind = \"galxy\"", "2:8: no generator is named `galxy`; did you mean `galaxy`?"),
    ("[generate.bodies]\ncount = 3", "1:11: [generate.bodies] needs `kind`"),
    (
        "[generate.bodies]\nkind = \"galaxy\"\ncuont = 3",
        "3:1: generator `galaxy` has no option `cuont`; did you mean `count`?",
    ),
    (
        "[generate.bodies]\nkind = \"galaxy\"\nradius = { value = 3, unit = \"kg\" }",
        "3:30: expected a unit like m, found kg",
    ),
    (
        "[generate.bodies]\nkind = \"web\"\ncount = 21",
        "3:9: a web of 5 spokes has 5 masses in each of 2 or more rings, not 21 in all",
    ),
    // Laws.
    ("[laws]\nname = \"motion\"", "1:1: expected a list of laws, found a table; write [[laws]]"),
    ("laws = [\"motion\"]", "1:9: expected a table with the name of a law, found text; write { name = \"motion\" }"),
    ("[[laws]]\nsoftening = 1", "1:1: a law needs `name`"),
    (
        "[[laws]]\nname = \"g\"\nenabeld = false",
        "3:11: expected a number or a vector for `enabeld`, found true or false; did you mean `enabled`?",
    ),
    (
        "[[laws]]\nname = \"g\"\ndomain = \"bodis\"\n[domains.bodies]\nx = [1]",
        "3:10: the scene has no domain `bodis`; did you mean `bodies`?",
    ),
    (
        "[[laws]]\nname = \"g\"\n[[laws]]\nname = \"g\"",
        "4:8: law `g` is listed twice; give one of them a `label` of its own",
    ),
    (
        "[[laws]]\nname = \"g\"\nsoftening = { value = 1, unit = \"m\", note = 1 }",
        "3:38: `note` is not known in `softening`; known here: value, unit",
    ),
];

#[test]
fn each_mistake_has_its_message() {
    let mut wrong = Vec::new();
    for (text, expected) in TABLE {
        let found: Vec<String> = faults(text)
            .iter()
            .map(|fault| {
                let help = fault.help.as_ref().map_or(String::new(), |help| format!("; {help}"));
                format!("{}:{}: {}{help}", fault.line, fault.column, fault.text)
            })
            .collect();
        // Where the words are another crate's, only the place is held here.
        let right = match &found[..] {
            [one] => one == expected || (expected.ends_with(": ") && one.starts_with(expected)),
            _ => false,
        };
        if !right {
            wrong.push(format!("{text}\n  expected {expected}\n  found    {}", found.join("\n           ")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn several_at_once_in_the_order_of_the_file() {
    let text = "[engine]\nstep = \"slow\"\nthreds = 2\n\n[domains.bodies]\nmass = [1, \"two\", true]\nvelocity = [[0, 0, 0], [1, 1]]\n\
                [[laws]]\nname = 3\n[[laws]]\nname = \"g\"\nbackend = \"cpus\"\n";
    let found: Vec<String> = faults(text).iter().map(|f| format!("{}:{}", f.line, f.column)).collect();
    assert_eq!(found, ["2:8", "3:1", "6:12", "6:19", "7:24", "9:8", "12:11"]);
}

#[test]
fn a_gap_in_the_syntax_does_not_hide_other_mistakes_nor_make_new_ones() {
    let text = "[engine]\nstep = \nthreds = 2\n[domains.bodies\nmass = [1]\n[domains.s]\nends = { domain = \"bodies\", value = [[0, 1]] }\n";
    let found: Vec<String> = faults(text).iter().map(|f| format!("{}:{}: {}", f.line, f.column, f.text)).collect();
    assert_eq!(
        found,
        [
            "2:8: a value is missing here",
            "3:1: `threds` is not known in [engine]",
            "4:16: unclosed table, expected `]`",
        ]
    );
}

#[test]
fn an_open_bracket_does_not_swallow_the_lines_behind_it() {
    let text = "[domains.bodies]\nposition = [\n  [0, 0, 0],\n  [1, 1, 1]\nmass = [1, 2,\n[engine]\nstep = \"fast\"\nintegrator = { name = \"x\"\n\
                threads = \"many\"\nend = true\n[[laws]]\nnmae = \"gravity\"\n[domains.x]\nv = [[1, 2], 3]\n";
    let found: Vec<String> = faults(text).iter().map(|f| format!("{}:{}: {}", f.line, f.column, f.text)).collect();
    assert_eq!(
        found,
        [
            "2:12: this list is not closed: `]` is missing before line 5",
            "5:8: this list is not closed: `]` is missing before line 6",
            "7:8: expected a number, found text",
            "8:14: this table is not closed: `}` is missing before line 9",
            "9:11: expected a whole number, 1 or more, found text",
            "10:7: expected a number, found true or false",
            "11:1: a law needs `name`",
            "12:8: expected a number or a vector for `nmae`, found text",
            "14:14: this item has 1 component, the first has 2",
        ]
    );
}

#[test]
fn a_fault_in_a_table_file_names_that_file() {
    let folder = std::env::temp_dir().join(format!("vesper-scene-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("t.csv"), "# made up\nx,y\n1,2\n1,oops\n").unwrap();
    let text = "[domains.p]\nfrom = { csv = \"t.csv\", a = [\"x\", \"y\"] }\n[engine]\nstep = 0\n";
    let faults = Scene::from_text("a.toml", text, &folder, &[]).unwrap_err();
    std::fs::remove_dir_all(&folder).unwrap();
    let found: Vec<String> = faults.iter().map(|f| format!("{}:{}:{}: {}", f.file, f.line, f.column, f.text)).collect();
    assert_eq!(
        found,
        ["t.csv:4:3: expected a number in column `y`, found `oops`", "a.toml:4:8: expected a time above 0, found 0"]
    );
}

#[test]
fn a_file_that_is_not_there_is_one_fault() {
    let faults = Scene::read(Path::new("no-such-scene.toml"), &[]).unwrap_err();
    assert_eq!(faults.len(), 1);
    assert!(faults[0].to_string().starts_with("error: cannot be read: "));
}
