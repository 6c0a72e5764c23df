//! What a client may do between steps.

use super::support::*;

/// Bodies in a row along x, and springs between neighbours.
fn chain(bodies: usize) -> EngineId {
    let builder = builder(VESPER_F64);
    let positions: Vec<f64> = (0..bodies).flat_map(|k| [k as f64, 0.0, 0.0]).collect();
    let ends: Vec<u32> = (1..bodies as u32).flat_map(|k| [k - 1, k]).collect();
    ok(domain(builder, c"bodies", bodies));
    ok(column(builder, c"bodies", c"position", &positions));
    ok(column(builder, c"bodies", c"velocity", &vec![0.0; bodies * 3]));
    ok(column(builder, c"bodies", c"mass", &vec![1.0; bodies]));
    ok(column(builder, c"bodies", c"colour", &vec![0.5; bodies * 3]));
    ok(domain(builder, c"springs", bodies - 1));
    ok(link(builder, c"springs", c"ends", c"bodies", &ends));
    ok(column(builder, c"springs", c"stiffness", &vec![10.0; bodies - 1]));
    ok(column(builder, c"springs", c"rest_length [mm]", &vec![1000.0; bodies - 1]));
    ok(law(builder, c"spring", c""));
    ok(law(builder, c"motion", c""));
    built(builder)
}

/// A number of a column in place.
fn number(view: &ColumnView, row: usize, component: usize) -> f64 {
    assert_eq!(view.type_, VESPER_F64);
    // SAFETY: the view is of a column that lives, and of so many rows.
    unsafe { *view.component[component].cast::<f64>().add(row * view.stride) }
}

#[test]
fn columns_are_seen_in_place() {
    let engine = chain(3);
    let view = view(engine, c"bodies", c"position", VESPER_READ).unwrap();
    assert_eq!((view.rows, view.stride, view.width), (3, 1, 3));
    assert!(view.subset.is_null() && view.component[3].is_null());
    assert_eq!([number(&view, 2, 0), number(&view, 2, 1)], [2.0, 0.0]);
    ok(set(engine, c"bodies", c"position", &[0.0, 0.0, 0.0, 1.5, 0.0, 0.0, 2.0, 0.0, 0.0]));
    assert_eq!(number(&view, 1, 0), 1.5, "the same memory");
    let links = super::support::view(engine, c"springs", c"ends", VESPER_READ).unwrap();
    assert_eq!((links.type_, links.rows, links.stride, links.width), (VESPER_U32, 2, 2, 2));
    // SAFETY: two springs of two ends each.
    let ends = unsafe { core::slice::from_raw_parts(links.component[0].cast::<u32>(), 4) };
    assert_eq!(ends, [0, 1, 1, 2]);
    assert_eq!(super::support::view(engine, c"springs", c"ends", VESPER_WRITE), Err(VESPER_ERROR_FAULT));
    ok(free(engine));
}

#[test]
fn what_is_written_in_place_is_seen_by_laws() {
    let engine = chain(2);
    ok(step(engine, 1, 0.01));
    assert_eq!(get(engine, c"bodies", c"velocity", 6), [0.0; 6], "at rest");
    let view = view(engine, c"bodies", c"position", VESPER_WRITE).unwrap();
    // SAFETY: the second row's x.
    unsafe { *view.component[0].cast::<f64>().add(1) = 2.0 };
    ok(step(engine, 1, 0.01));
    let velocity = get(engine, c"bodies", c"velocity", 6);
    assert!((velocity[3] + 0.1).abs() < 1e-3 && velocity[0] == -velocity[3], "pulled together: {velocity:?}");
    ok(free(engine));
}

#[test]
fn rows_come_and_go() {
    let engine = chain(3);
    let (place, rest, mass) = ([3.0_f64, 0.0, 0.0], [0.0_f32; 3], [1.0_f64]);
    let values = |property: &'static CStr, numbers: *const c_void, count, type_| Values {
        property: property.as_ptr(),
        numbers,
        count,
        type_,
    };
    let mut columns = vec![
        values(c"position", place.as_ptr().cast(), 3, VESPER_F64),
        values(c"velocity", rest.as_ptr().cast(), 3, VESPER_F32),
        values(c"mass", mass.as_ptr().cast(), 1, VESPER_F64),
    ];
    let add = |domain: &CStr, columns: &[Values]| {
        // SAFETY: texts end, and arrays have so many numbers.
        unsafe { vesper_engine_add_rows(engine, domain.as_ptr(), 1, columns.as_ptr(), columns.len()) }
    };
    assert_eq!(add(c"bodies", &columns), VESPER_ERROR_FAULT);
    assert_eq!(last_error(), "the new rows of bodies lack colour, which all rows have: give it for them too");
    columns.push(values(c"colour", rest.as_ptr().cast(), 3, VESPER_F32));
    ok(add(c"bodies", &columns));
    let (ends, stiffness, length) = ([2_u32, 3], [10.0_f64], [1.0_f64]);
    let mut spring = vec![
        values(c"ends", ends.as_ptr().cast(), 2, VESPER_U32),
        values(c"stiffness [N/mm]", stiffness.as_ptr().cast(), 1, VESPER_F64),
        values(c"rest_length", length.as_ptr().cast(), 1, VESPER_F64),
    ];
    ok(add(c"springs", &spring));
    assert_eq!(get(engine, c"springs", c"stiffness", 3), [10.0, 10.0, 10_000.0], "the unit was looked at");
    spring[0].type_ = VESPER_F64;
    spring[0].numbers = place.as_ptr().cast();
    assert_eq!(add(c"springs", &spring), VESPER_ERROR_ARGUMENT);
    assert_eq!(last_error(), "springs.ends is a link: give u32");
    ok(step(engine, 10, 0.01));
    assert_eq!(view(engine, c"bodies", c"position", VESPER_READ).unwrap().rows, 4);
    // SAFETY: the text ends, and the array has one row.
    ok(unsafe { vesper_engine_remove_rows(engine, c"bodies".as_ptr(), [1].as_ptr(), 1) });
    let links = view(engine, c"springs", c"ends", VESPER_READ).unwrap();
    assert_eq!(links.rows, 1, "two springs went with their body");
    // SAFETY: the text ends, and the array has one row.
    assert_eq!(unsafe { vesper_engine_remove_rows(engine, c"bodies".as_ptr(), [7].as_ptr(), 1) }, VESPER_ERROR_FAULT);
    assert_eq!(last_error(), "bodies has no row 7: it has 3 rows, counted from 0");
    ok(step(engine, 10, 0.01));
    ok(free(engine));
}

#[test]
fn laws_are_switched_and_computed_columns_looked_at() {
    let engine = falling();
    assert_eq!(view(engine, c"bodies", c"force", VESPER_READ), Err(VESPER_ERROR_FAULT));
    // SAFETY: texts end.
    unsafe {
        ok(vesper_engine_observe(engine, c"bodies".as_ptr(), c"force".as_ptr()));
        assert_eq!(get(engine, c"bodies", c"force", 3), [0.0, 0.0, -16.0], "at once");
        assert_eq!(vesper_engine_observe(engine, c"bodies".as_ptr(), c"forc".as_ptr()), VESPER_ERROR_FAULT);
        assert_eq!(last_error(), "bodies has no property forc; did you mean force?");
        ok(vesper_engine_enable(engine, c"uniform_gravity".as_ptr(), 0));
        ok(step(engine, 16, 0.0625));
        assert_eq!(get(engine, c"bodies", c"position", 3), [0.0, 0.0, 10.0], "nothing pulls");
        ok(vesper_engine_enable(engine, c"uniform_gravity".as_ptr(), 1));
        assert_eq!(vesper_engine_enable(engine, c"gravity".as_ptr(), 1), VESPER_ERROR_FAULT);
    }
    ok(step(engine, 16, 0.0625));
    assert_eq!(get(engine, c"bodies", c"position", 3), [0.0, 0.0, 6.0], "one second of free fall");
    ok(set(engine, c"scene", c"gravity", &[0.0, 0.0, 8.0]));
    ok(advance(engine, 1.0));
    assert_eq!(get(engine, c"bodies", c"position", 3), [0.0, 0.0, 2.0], "and one of braking");
    assert_eq!(get(engine, c"bodies", c"velocity", 3), [0.0; 3]);
    let (mut time, mut steps) = (0.0, 0);
    // SAFETY: places are variables, or null.
    unsafe {
        ok(vesper_engine_time(engine, &raw mut time, &raw mut steps));
        ok(vesper_engine_time(engine, ptr::null_mut(), ptr::null_mut()));
    }
    assert_eq!((time, steps), (3.0, 48));
    ok(free(engine));
}

#[test]
fn texts_and_checkpoints() {
    let engine = falling();
    assert_eq!(
        text(engine, VESPER_REPORT),
        "uniform_gravity is active on 1 row of bodies\nmotion is active on 1 row of bodies"
    );
    assert!(text(engine, VESPER_EXPLAIN).contains("uniform_gravity"));
    assert!(text(engine, VESPER_DOT).starts_with("digraph"));
    ok(step(engine, 5, 0.0625));
    let checkpoint = std::ffi::CString::new(text(engine, VESPER_CHECKPOINT)).unwrap();
    ok(step(engine, 5, 0.0625));
    let there = get(engine, c"bodies", c"position", 3);
    ok(step(engine, 50, 0.0625));
    // SAFETY: texts end.
    unsafe {
        ok(vesper_engine_restore(engine, checkpoint.as_ptr()));
        ok(step(engine, 5, 0.0625));
        assert_eq!(get(engine, c"bodies", c"position", 3), there);
        assert_eq!(vesper_engine_restore(engine, c"{}".as_ptr()), VESPER_ERROR_FAULT);
        assert!(
            last_error().starts_with("the checkpoint cannot be read: it is no checkpoint of version"),
            "{}",
            last_error()
        );
        let mut text = ptr::null();
        assert_eq!(vesper_engine_text(engine, 9, &raw mut text), VESPER_ERROR_ARGUMENT);
    }
    ok(free(engine));
}

#[test]
fn numbers_are_copied_in_the_unit_behind_the_name() {
    let engine = chain(2);
    ok(set(engine, c"bodies", c"velocity [km/s]", &[0.0, 0.001, 0.0, 0.0, 0.0, 0.0]));
    assert_eq!(get(engine, c"bodies", c"velocity", 6)[1], 1.0);
    assert_eq!(get(engine, c"bodies", c"velocity [mm/s]", 6)[1], 1000.0);
    assert_eq!(set(engine, c"bodies", c"velocity [kg]", &[0.0; 6]), VESPER_ERROR_FAULT);
    assert!(last_error().contains("measured in m/s"), "{}", last_error());
    assert_eq!(view(engine, c"bodies", c"velocity [km/s]", VESPER_READ).unwrap_err(), VESPER_ERROR_FAULT);
    assert!(last_error().contains("ask without a unit"), "{}", last_error());
    ok(view(engine, c"bodies", c"velocity [m/s]", VESPER_READ).map_or_else(|status| status, |_| VESPER_OK));
    // SAFETY: texts end.
    let observed = unsafe { vesper_engine_observe(engine, c"bodies".as_ptr(), c"force [km]".as_ptr()) };
    assert_eq!(observed, VESPER_ERROR_FAULT);
    ok(free(engine));
}

#[test]
fn memory_that_is_the_column_itself_stays_and_part_of_it_is_refused() {
    let mut position = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 9.0];
    let made = || {
        let builder = builder(VESPER_F64);
        ok(domain(builder, c"bodies", 2));
        ok(column(builder, c"bodies", c"velocity", &[1.0; 6]));
        ok(column(builder, c"bodies", c"mass", &[1.0, 2.0]));
        ok(law(builder, c"motion", c""));
        builder
    };
    let first = made();
    ok(lend(first, c"bodies", c"position", &mut position[..6]));
    let engine = built(first);
    let start = position.as_mut_ptr();
    let copy = |from: *mut f64, in_: bool| {
        let (domain, property) = (c"bodies".as_ptr(), c"position".as_ptr());
        // SAFETY: texts end, and the array has so many numbers.
        unsafe {
            match in_ {
                true => vesper_engine_set(engine, domain, property, VESPER_F64, from.cast(), 6),
                false => vesper_engine_get(engine, domain, property, VESPER_F64, from.cast(), 6),
            }
        }
    };
    ok(copy(start, true));
    ok(copy(start, false));
    for in_ in [true, false] {
        assert_eq!(copy(start.wrapping_add(1), in_), VESPER_ERROR_ARGUMENT);
        assert!(last_error().contains("give memory of its own"), "{}", last_error());
    }
    let mass = view(engine, c"bodies", c"mass", VESPER_WRITE).unwrap();
    // SAFETY: texts end; the column has so many numbers.
    ok(unsafe { vesper_engine_set(engine, c"bodies".as_ptr(), c"mass".as_ptr(), VESPER_F64, mass.component[0], 2) });
    assert_eq!(get(engine, c"bodies", c"mass", 2), [1.0, 2.0]);
    let second = made();
    assert_eq!(lend(second, c"bodies", c"position", &mut position[..6]), VESPER_ERROR_FAULT);
    assert!(last_error().contains("another engine has some of this memory"), "{}", last_error());
    assert_eq!(build(second), Err(VESPER_ERROR_FAULT));
    ok(free(engine));
    let third = made();
    ok(lend(third, c"bodies", c"position", &mut position[..6]));
    ok(free(built(third)));
}

#[test]
fn more_rows_than_there_are_cannot_be_removed() {
    let engine = chain(3);
    // SAFETY: texts end; so many rows are refused before any is read.
    let status = unsafe { vesper_engine_remove_rows(engine, c"bodies".as_ptr(), [0_u32].as_ptr(), 1 << 40) };
    assert_eq!(status, VESPER_ERROR_FAULT);
    assert!(last_error().contains("there are 3"), "{}", last_error());
    ok(free(engine));
}
