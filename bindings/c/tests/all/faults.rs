//! What is wrong, in the words of the last error.

use super::support::*;

/// A call on a fresh builder with two bodies, and what it says.
fn said(call: impl FnOnce(BuilderId) -> Status) -> (Status, String) {
    let builder = builder(VESPER_F64);
    ok(domain(builder, c"bodies", 2));
    let status = call(builder);
    let text = last_error();
    assert_eq!(build(builder), Err(VESPER_ERROR_FAULT), "it is told again when the engine is built");
    assert_eq!(last_error(), text);
    (status, text)
}

#[test]
fn each_says_what_to_do() {
    const FAULT: Status = VESPER_ERROR_FAULT;
    const ARGUMENT: Status = VESPER_ERROR_ARGUMENT;
    let cases = [
        (said(|b| domain(b, c"bodies", 3)), FAULT, "domain bodies is given twice: keep one"),
        (
            said(|b| domain(b, c"dust", usize::MAX)),
            FAULT,
            "domain dust has 18446744073709551615 rows: at most 4294967295 can be numbered",
        ),
        (
            said(|b| column(b, c"bodis", c"mass", &[1.0, 1.0])),
            FAULT,
            "domain bodis does not exist; did you mean bodies?",
        ),
        (
            said(|b| column(b, c"bodies", c"position", &[0.0; 5])),
            FAULT,
            "bodies.position has 5 numbers, but 2 rows of a vector are 6: give as many",
        ),
        (
            said(|b| column(b, c"bodies", c"mass [m]", &[0.0; 2])),
            FAULT,
            "bodies.mass is given in m, but it is measured in kg: give it in a unit of that dimension",
        ),
        (said(|b| column(b, c"bodies", c"mass [kg", &[0.0; 2])), FAULT, "property `mass [kg`: close the unit with `]`"),
        (
            said(|b| column(b, c"bodies", c"colour", &[0.0; 5])),
            FAULT,
            "bodies.colour has 5 numbers, which 2 rows cannot share evenly: give as many for each row",
        ),
        (
            said(|b| link(b, c"bodies", c"mass", c"bodies", &[0, 1])),
            FAULT,
            "bodies.mass is a scalar, no link: give it as a column",
        ),
        (
            said(|b| column(b, c"bodies", c"ends", &[0.0; 4])),
            FAULT,
            "bodies.ends is a link to 2 rows: give it as a link, with its target",
        ),
        (
            said(|b| law(b, c"gravty", c"")),
            FAULT,
            "error: no law is named `gravty`\n  --> law gravty:1:18\n  1 | laws = [{ name = \"gravty\" }]\n    |                  \
             ^^^^^^^^\n    = help: did you mean `gravity`?",
        ),
        (
            said(|b| law(b, c"gravity", c"softning = 1, domain = 'bodis'")),
            FAULT,
            "error: law `gravity` has no parameter `softning`\n  --> law gravity:1:29\n  1 | laws = [{ name = \"gravity\", \
             softning = 1, domain = 'bodis' }]\n    |                             ^^^^^^^^\n    = help: did you mean \
             `softening`?\nerror: the scene has no domain `bodis`\n  --> law gravity:1:52\n  1 | laws = [{ name = \"gravity\", \
             softning = 1, domain = 'bodis' }]\n    |                                                    ^^^^^^^\n    = help: did \
             you mean `bodies`?",
        ),
        (
            said(|b| law(b, c"gravity", c"g = 1 }, { name = 'motion'")),
            FAULT,
            "law gravity: the text goes on behind its end, in `laws = [{ name = \"gravity\", g = 1 }, { name = 'motion' }]`: \
             keep to what belongs there",
        ),
        (
            said(|b| settings(b, c"precision = 'f32'")),
            FAULT,
            "error: the precision here is f32, but f64 was asked for\n  --> settings:1:24\n  1 | engine = { precision = 'f32' \
             }\n    |                        ^^^^^\n    = help: ask for the same, or leave it out here",
        ),
        (
            // SAFETY: texts end.
            said(|b| unsafe {
                vesper_builder_column(b, c"bodies".as_ptr(), c"mass".as_ptr(), VESPER_F64, ptr::null(), 2)
            }),
            ARGUMENT,
            "mass is null, and not 2 values: give an array",
        ),
        (
            // SAFETY: null is looked at.
            said(|b| unsafe { vesper_builder_law(b, ptr::null(), ptr::null()) }),
            ARGUMENT,
            "the law is null: give a text",
        ),
        (said(|b| domain(b, c"\xff", 1)), ARGUMENT, "the domain is no UTF-8: see byte 0"),
    ];
    for ((status, text), expected, words) in cases {
        assert_eq!((status, text.as_str()), (expected, words));
    }
}

#[test]
fn laws_of_modules_are_asked_for_as_in_scenes() {
    let (status, text) = said(|b| law(b, c"lift", c"module = 'nowhere'"));
    assert_eq!(status, VESPER_ERROR_FAULT);
    assert!(text.starts_with("error: module `nowhere`: "), "{text}");
    let (_, text) = said(|b| law(b, c"lift", c"module = '../nowhere.so'"));
    assert!(text.contains("a scene may not name a file of code"), "{text}");
}

#[test]
fn lent_memory_is_looked_at() {
    let mut doubles = [0.0_f64; 8];
    let start = doubles.as_mut_ptr();
    let lent = |b: BuilderId, property: &CStr, type_, start: *mut f64, count| {
        // SAFETY: the array has so many numbers, or the call is refused.
        unsafe { vesper_builder_lend(b, c"bodies".as_ptr(), property.as_ptr(), type_, start.cast(), count) }
    };
    let (odd, far) = (start.wrapping_byte_add(4), start.wrapping_add(2));
    let cases = [
        (
            said(|b| lent(b, c"position", VESPER_F64, ptr::null_mut(), 6)),
            "position is null, and not 6 numbers: lend an array",
        ),
        (
            said(|b| lent(b, c"position", VESPER_F32, start, 6)),
            "bodies.position cannot be lent: it is in f32, and the engine in f64; have it copied",
        ),
        (
            said(|b| lent(b, c"position", VESPER_U32, start, 6)),
            "position cannot be lent as rows: give VESPER_F32 (1) or VESPER_F64 (2)",
        ),
        (said(|b| lent(b, c"position", 7, start, 6)), "the type is 7: give VESPER_F32, VESPER_F64 or VESPER_U32"),
        (
            said(|b| lent(b, c"position", VESPER_F64, start, 8)),
            "bodies.position has 8 numbers, but 2 rows of a vector are 6: give as many",
        ),
        (
            said(|b| lent(b, c"position [km]", VESPER_F64, start, 6)),
            "bodies.position cannot be lent: it is used as it is, in m: convert the numbers, or have them copied",
        ),
        (
            said(|b| {
                ok(lent(b, c"position", VESPER_F64, start, 6));
                lent(b, c"mass", VESPER_F64, far, 2)
            }),
            "bodies.mass cannot be lent: bodies.position has some of the same memory: lend each column memory of its own",
        ),
    ];
    for ((_, text), words) in cases {
        assert_eq!(text, words);
    }
    let (status, text) = said(|b| lent(b, c"position", VESPER_F64, odd, 6));
    assert_eq!(status, VESPER_ERROR_ARGUMENT);
    assert!(text.ends_with("is no address of an f64: align the memory"), "{text}");
    let (status, text) = said(|b| lent(b, c"position", VESPER_F64, start, usize::MAX / 8));
    assert_eq!(status, VESPER_ERROR_ARGUMENT);
    assert!(text.contains("no memory has 2305843009213693951 numbers"), "{text}");
}

#[test]
fn a_build_tells_all_that_went_wrong_before_it() {
    let builder = builder(VESPER_F32);
    assert_eq!(column(builder, c"bodies", c"mass", &[1.0]), VESPER_ERROR_FAULT);
    assert_eq!(law(builder, c"graviti", c""), VESPER_ERROR_FAULT);
    assert_eq!(build(builder), Err(VESPER_ERROR_FAULT));
    let text = last_error();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "domain bodies does not exist: say it first, with its rows");
    assert_eq!(lines[1], "error: no law is named `graviti`");
}

#[test]
fn a_law_that_sleeps_by_a_slip_is_a_fault() {
    let builder = builder(VESPER_F64);
    ok(domain(builder, c"bodies", 1));
    ok(column(builder, c"bodies", c"positon", &[0.0; 3]));
    ok(column(builder, c"bodies", c"velocity", &[0.0; 3]));
    ok(column(builder, c"bodies", c"mass", &[1.0]));
    ok(law(builder, c"motion", c""));
    assert_eq!(build(builder), Err(VESPER_ERROR_FAULT));
    let expected = "motion is dormant: it gives the rate of position [m], which domain bodies does not have; there is positon: \
                    rename it, or add position";
    assert!(last_error().starts_with(expected), "{}", last_error());
}

#[test]
fn the_library_tells_what_does_not_fit_together() {
    let builder = builder(VESPER_F64);
    ok(domain(builder, c"springs", 1));
    ok(link(builder, c"springs", c"ends", c"bodis", &[0, 1]));
    ok(column(builder, c"springs", c"stiffness", &[f64::NAN]));
    assert_eq!(build(builder), Err(VESPER_ERROR_FAULT));
    let expected = "springs.ends links to domain bodis, which does not exist: add the domain\nspringsstiffness";
    let text = last_error();
    assert_eq!(text.lines().next(), expected.lines().next());
    assert_eq!(text.lines().nth(1), Some("springs.stiffness: row 0 is NaN: give a finite number"));
}

#[test]
fn a_scene_is_faulted_with_carets() {
    let builder = builder(VESPER_F64);
    let scene =
        c"[engine]\nintegrator = \"leapfrg\"\n[domains.bodies]\nmass = [1, \"two\"]\n[[laws]]\nname = \"moton\"\n";
    // SAFETY: the text ends.
    let status = unsafe { vesper_builder_scene(builder, scene.as_ptr(), ptr::null()) };
    assert_eq!(status, VESPER_ERROR_FAULT);
    let text = last_error();
    for line in ["  --> scene:2:14", "  --> scene:4:12", "  --> scene:6:8", "    = help: did you mean `leapfrog`?"] {
        assert!(text.lines().any(|found| found == line), "{line} in\n{text}");
    }
    assert_eq!(build(builder), Err(VESPER_ERROR_FAULT));
    assert_eq!(last_error(), text);
}

#[test]
fn steps_that_break_say_so() {
    let engine = falling();
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(step(engine, 1, wrong), VESPER_ERROR_RUN);
    }
    assert_eq!(last_error(), "the step is inf s: give a finite time above 0");
    assert_eq!(advance(engine, -1.0), VESPER_ERROR_RUN);
    assert_eq!(set(engine, c"bodies", c"position", &[0.0, f64::NAN, 0.0]), VESPER_ERROR_FAULT);
    assert_eq!(last_error(), "bodies.position: row 0 is NaN: give a finite number of f64");
    assert_eq!(set(engine, c"bodies", c"position", &[0.0; 2]), VESPER_ERROR_FAULT);
    assert_eq!(last_error(), "bodies.position: 1 values of 3 numbers are 3, and not 2: give as many");
    ok(set(engine, c"bodies", c"velocity", &[1e308; 3]));
    assert_eq!(step(engine, 1, 1e10), VESPER_ERROR_RUN);
    assert!(last_error().contains("bodies.position of row 0 is inf"), "{}", last_error());
    ok(free(engine));
}
