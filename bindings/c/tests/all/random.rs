//! Calls at random: null, wrong sizes, freed handles, wrong order. `tests/random.c` makes a million of them under sanitizers.

use super::support::*;
use std::ffi::CString;

/// A generator of numbers (xorshift64*), the same on every run.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 16
    }

    fn one_in(&mut self, count: u64) -> bool {
        self.next().is_multiple_of(count)
    }

    fn of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.next() as usize % all.len()]
    }

    /// A text, or null.
    fn text(&mut self, all: &[&CStr]) -> *const c_char {
        if self.one_in(50) { ptr::null() } else { self.of(all).as_ptr() }
    }
}

const DOMAINS: [&CStr; 6] = [c"bodies", c"bodies", c"springs", c"scene", c"bodis", c"\xff\xfe"];
const PROPERTIES: [&CStr; 14] = [
    c"position",
    c"velocity",
    c"mass",
    c"ends",
    c"stiffness",
    c"rest_length",
    c"force",
    c"gravity",
    c"time",
    c"colour",
    c"velocity [km/s]",
    c"position [s]",
    c"mass [",
    c"",
];
const LAWS: [&CStr; 7] = [c"gravity", c"motion", c"spring", c"uniform_gravity", c"drag", c"nothing", c"\xff"];
const PARAMETERS: [&CStr; 7] = [c"", c"", c"g = 1", c"softening = 'x'", c"every = 2", c"} ] }", c"label = 'a'"];
const SETTINGS: [&CStr; 6] = [
    c"step = 0.001, threads = 1",
    c"integrator = 'runge_kutta_4'",
    c"integrator = 'implicit_midpoint'",
    c"observe = ['bodies.force']",
    c"step = -1",
    c"= =",
];
const SCENES: [&CStr; 3] = [
    c"[domains.bodies]\nposition = [[0,0,1]]\nvelocity = [[0,0,1]]\nmass = [1]\n[[laws]]\nname = 'motion'\n",
    c"[domains.bodies]\nposition = [[0,0]]\n",
    c"[",
];
/// All that are read have room for 64 numbers; the others are refused before anything is read.
const COUNTS: [usize; 12] = [0, 1, 2, 3, 4, 6, 8, 9, 12, 64, usize::MAX / 2, usize::MAX];
const ROWS: [usize; 8] = [0, 1, 2, 2, 3, 4, u32::MAX as usize + 1, usize::MAX];
const TYPES_ASKED: [Type; 8] = [VESPER_F64, VESPER_F64, VESPER_F64, VESPER_F32, VESPER_F32, VESPER_U32, 0, 99];
const TIMES: [f64; 8] = [1e-3, 1e-3, 0.5, 0.0, -1.0, f64::NAN, f64::INFINITY, 1e300];

struct Driver {
    chance: Chance,
    builders: Vec<BuilderId>,
    engines: Vec<EngineId>,
    /// Arrays of 64 numbers: lent, given, and for answers.
    arrays: Vec<[f64; 64]>,
    /// A state that an engine told.
    checkpoint: CString,
    done: [u64; 8],
}

impl Driver {
    fn builder(&mut self) -> BuilderId {
        let random = BuilderId { id: self.chance.next() };
        match self.chance.next() % 60 {
            0 => BuilderId { id: 0 },
            1 => random,
            _ => self.builders.last().copied().filter(|_| !self.chance.one_in(20)).unwrap_or_else(|| {
                let place = self.chance.next() as usize % self.builders.len().max(1);
                self.builders.get(place).copied().unwrap_or(random)
            }),
        }
    }

    fn engine(&mut self) -> EngineId {
        let random = EngineId { id: self.chance.next() };
        let place = self.chance.next() as usize % self.engines.len().max(1);
        if self.chance.one_in(60) { random } else { self.engines.get(place).copied().unwrap_or(random) }
    }

    /// An array, sometimes at an odd address or null.
    fn array(&mut self) -> *mut c_void {
        let place = self.chance.next() as usize % self.arrays.len();
        let start: *mut c_void = self.arrays[place].as_mut_ptr().cast();
        match self.chance.next() % 40 {
            0 => ptr::null_mut(),
            _ => start,
        }
    }

    /// A builder from which an engine can come.
    fn right_builder(&mut self) {
        let precision = self.chance.of(&[VESPER_F64, VESPER_F32]);
        let made = builder(precision);
        self.builders.push(made);
        ok(domain(made, c"bodies", 2));
        ok(column(made, c"bodies", c"position", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]));
        ok(column(made, c"bodies", c"velocity", &[0.0; 6]));
        ok(column(made, c"bodies", c"mass", &[1.0, 2.0]));
        ok(law(made, c"motion", c""));
        if self.chance.one_in(2) {
            ok(law(made, c"gravity", c"g = 1"));
        }
        if self.chance.one_in(2) {
            ok(settings(made, c"step = 0.001, threads = 1"));
        }
    }

    /// One call of any function; arguments are mostly right.
    fn call(&mut self) -> Status {
        let (domain, property) = (self.chance.text(&DOMAINS), self.chance.text(&PROPERTIES));
        let (type_, count, rows) = (self.chance.of(&TYPES_ASKED), self.chance.of(&COUNTS), self.chance.of(&ROWS));
        let (array, time) = (self.array(), self.chance.of(&TIMES));
        let (law, parameters) = (self.chance.text(&LAWS), self.chance.text(&PARAMETERS));
        let (builder, engine) = (self.builder(), self.engine());
        let mut new_builder = BuilderId { id: 0 };
        let mut new_engine = EngineId { id: 0 };
        let mut view = core::mem::MaybeUninit::<ColumnView>::uninit();
        let mut text = ptr::null();
        let null = self.chance.one_in(50);
        // SAFETY: texts end; arrays have 64 numbers, and counts above are refused; places are variables, or null.
        let status = unsafe {
            match self.chance.next() % 27 {
                0 => vesper_builder_new(type_, if null { ptr::null_mut() } else { &raw mut new_builder }),
                1 => vesper_builder_domain(builder, domain, rows),
                2 | 3 => vesper_builder_column(builder, domain, property, type_, array, count),
                4 => vesper_builder_lend(builder, domain, property, type_, array.wrapping_byte_add(rows % 2), count),
                5 => vesper_builder_link(builder, domain, property, domain, array.cast(), count),
                6 => vesper_builder_law(builder, law, parameters),
                7 => vesper_builder_settings(builder, self.chance.text(&SETTINGS)),
                8 => vesper_builder_scene(builder, self.chance.text(&SCENES), ptr::null()),
                9 | 10 => vesper_builder_build(builder, if null { ptr::null_mut() } else { &raw mut new_engine }),
                11 => vesper_builder_free(builder),
                12 | 13 => vesper_engine_step(engine, self.chance.next() % 4, time),
                14 => vesper_engine_advance(engine, time),
                15 => vesper_engine_time(engine, array.cast(), ptr::null_mut()),
                16 => vesper_engine_column(engine, domain, property, count as u32 % 3, view.as_mut_ptr()),
                17 => vesper_engine_get(engine, domain, property, type_, array, count),
                18 => vesper_engine_set(engine, domain, property, type_, array, count),
                19 => {
                    let values = [c"position", c"velocity", c"mass"].map(|name| Values {
                        property: name.as_ptr(),
                        numbers: array,
                        count: if name == c"mass" { rows } else { rows.wrapping_mul(3) },
                        type_,
                    });
                    let columns = if null { ptr::null() } else { values.as_ptr() };
                    vesper_engine_add_rows(engine, domain, rows, columns, if null { count } else { 3 })
                }
                20 => vesper_engine_remove_rows(engine, domain, array.cast(), count.min(64)),
                21 => vesper_engine_enable(engine, law, rows as i32 % 2),
                22 => vesper_engine_observe(engine, domain, property),
                23 => vesper_engine_text(engine, count as u32 % 5, if null { ptr::null_mut() } else { &raw mut text }),
                24 => vesper_engine_restore(engine, if null { parameters } else { self.checkpoint.as_ptr() }),
                25 => vesper_engine_let_go(engine),
                _ => vesper_engine_free(engine),
            }
        };
        self.builders.extend((new_builder.id != 0).then_some(new_builder));
        self.engines.extend((new_engine.id != 0).then_some(new_engine));
        if status == VESPER_OK && !text.is_null() {
            // SAFETY: the text ends, and is there until the next call.
            let said = unsafe { CStr::from_ptr(text) }.to_str().unwrap();
            if count as u32 % 5 == VESPER_CHECKPOINT {
                self.checkpoint = CString::new(said).unwrap();
            }
        }
        status
    }

    /// Frees what is old, so that not everything fails by its handle; some stale handles stay among the others.
    fn tidy(&mut self) {
        while self.engines.len() > 12 {
            free(self.engines.remove(0));
        }
        while self.builders.len() > 12 {
            let old = self.builders.remove(0);
            // SAFETY: no pointer is given.
            unsafe { vesper_builder_free(old) };
        }
    }
}

#[test]
fn no_call_does_harm() {
    let numbers = |k: usize| [0.0, 1.0, 2.0, -0.5, 1e300, f64::NAN, 3.0, 1e-300][k % 8];
    let arrays = (0..16).map(|k| core::array::from_fn(|j| if k < 8 { 0.5 } else { numbers(k + j) })).collect();
    let mut driver = Driver {
        chance: Chance(42),
        builders: Vec::new(),
        engines: Vec::new(),
        arrays,
        checkpoint: CString::default(),
        done: [0; 8],
    };
    for turn in 0..100_000 {
        if turn % 25 == 0 {
            driver.right_builder();
            let engine = built(driver.builders[driver.builders.len() - 1]);
            driver.engines.push(engine);
            driver.right_builder();
        }
        let status = driver.call();
        let count = usize::try_from(status).ok().and_then(|status| driver.done.get_mut(status));
        *count.unwrap_or_else(|| panic!("{status} is no status")) += 1;
        assert_ne!(status, VESPER_ERROR_PANIC, "{}", last_error());
        assert!(status == VESPER_OK || !last_error().is_empty());
        driver.tidy();
    }
    let [done, argument, handle, _, fault, run, panic, limit] = driver.done;
    println!("{:?}", driver.done);
    assert!([done, argument, handle, fault, run].iter().all(|&count| count > 1000), "{:?}", driver.done);
    assert_eq!((panic, limit), (0, 0));
    for engine in driver.engines {
        free(engine);
    }
    for builder in driver.builders {
        // SAFETY: no pointer is given.
        unsafe { vesper_builder_free(builder) };
    }
}
