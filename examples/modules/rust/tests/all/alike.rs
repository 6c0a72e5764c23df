//! A law does the same whether it was compiled with the program or loaded: the same bits, in every shape and precision.

use super::compiler::{compiled, lift_in_c, opened, wings};
use vesper::module::{LawPath, ModuleLaw};
use vesper::prelude::*;
use vesper::real::Isa;
use vesper_laws::{Drag, Motion, UniformGravity};
use wings::{Cord, Flight, Flock, Level, Lift};

/// Numbers between -1 and 1 without order.
fn number(seed: usize) -> f64 {
    let mixed = (seed as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((mixed ^ mixed >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

fn vector(row: usize, seed: usize) -> [f64; 3] {
    [0, 1, 2].map(|c| number(3 * row + c + 1000 * seed))
}

fn birds(count: usize) -> Domain<f64> {
    typed(count)
}

fn typed<P: Precision>(count: usize) -> Domain<P> {
    Domain::new("birds")
        .with(Position, (0..count).map(|row| vector(row, 1)).collect::<Vec<_>>())
        .with(Velocity, (0..count).map(|row| vector(row, 2)).collect::<Vec<_>>())
        .with(Mass, (0..count).map(|row| 1.5 + number(row)).collect::<Vec<_>>())
        .with(DragCoefficient, vec![0.3; count])
}

fn cords<P: Precision>(birds: usize) -> Domain<P> {
    let ends = (0..birds.saturating_sub(1) as u32).flat_map(|k| [k, k + 1]).collect();
    let count = birds.saturating_sub(1);
    Domain::new("cords").with_link(Ends::INFO, "birds", ends).with(Stiffness, vec![2.0; count])
}

fn law(name: &str) -> ModuleLaw {
    wings().law(name).unwrap()
}

/// All numbers of the birds, as bits.
fn bits<P: Precision>(engine: &Engine<P>) -> Vec<u64> {
    let numbers = |property: PropertyInfo| engine.state().numbers("birds", property).unwrap();
    [Position::INFO, Velocity::INFO].into_iter().flat_map(numbers).map(f64::to_bits).collect()
}

/// Runs both, and compares.
fn alike<P: Precision>(what: &str, make: impl Fn(Builder<P>, bool) -> Builder<P>, count: usize) {
    for (integrator, threads) in
        [("leapfrog", 1), ("runge_kutta", 1), ("leapfrog", 2), ("dormand_prince", 1), ("radau", 1)]
    {
        let made = |loaded: bool| {
            let builder = Engine::<P>::builder().domain(typed::<P>(count)).domain(cords::<P>(count)).threads(threads);
            let builder = match integrator {
                "runge_kutta" => builder.integrator(RungeKutta4),
                "dormand_prince" => builder.integrator(DormandPrince5::default()),
                "radau" => builder.integrator(GaussRadau15::default()),
                _ => builder.integrator(Leapfrog::default()),
            };
            let mut engine =
                make(builder, loaded).step(1e-2).build().unwrap_or_else(|faults| panic!("{what}: {faults}"));
            for _ in 0..3 {
                engine.advance(0.05).unwrap_or_else(|faults| panic!("{what}: {faults}"));
            }
            engine
        };
        let (mut here, mut there) = (made(false), made(true));
        assert_eq!(bits(&here), bits(&there), "{what}, {count} rows, {integrator}, {threads} threads, {}", P::NAME);
        let energies = [&mut here, &mut there].map(|engine| engine.energy().unwrap().0.to_bits());
        assert_eq!(energies[0], energies[1], "{what}, {count} rows: energy");
    }
}

macro_rules! pair {
    ($here:expr, $name:literal) => {
        |builder, loaded| {
            let builder = builder.law(Drag);
            if loaded { builder.law(law($name)).law(Motion) } else { builder.law($here).law(Motion) }
        }
    };
}

#[test]
fn loaded_laws_of_every_shape_give_the_bits_of_those_that_are_here() {
    for count in [1, 2, 3, 7, 8, 17, 130, 700] {
        alike::<f64>("lift", pair!(Lift::default(), "lift"), count);
        alike::<f32>("lift", pair!(Lift::default(), "lift"), count);
        alike::<f64>("flock", pair!(Flock::default(), "flock"), count);
        alike::<f32>("flock", pair!(Flock::default(), "flock"), count);
        alike::<f64>("cord", pair!(Cord, "cord"), count);
        alike::<f32>("cord", pair!(Cord, "cord"), count);
        alike::<f64>("level", pair!(Level::default(), "level"), count);
        alike::<f32>("level", pair!(Level::default(), "level"), count);
    }
}

#[test]
fn a_loaded_law_of_motion_takes_part_in_merged_steps() {
    let flight = |builder: Builder<f64>, loaded| {
        let builder = builder.law(Drag);
        if loaded { builder.law(law("flight")) } else { builder.law(Flight) }
    };
    for count in [1, 2, 9, 1000, 3000] {
        alike::<f64>("flight", flight, count);
    }
}

#[test]
fn many_links_are_shared_among_threads_as_those_of_a_law_that_is_here() {
    alike::<f64>("cord", pair!(Cord, "cord"), 20_000);
}

#[test]
fn double_double_engines_convert() {
    // Numbers of rows that fill no lanes, and some that do.
    for count in [1, 2, 3, 5, 7, 8, 60] {
        for shape in ["lift", "flock", "cord", "level", "flight"] {
            let at = |loaded: bool| {
                let builder = Engine::<DoubleDouble>::builder().domain(typed::<DoubleDouble>(count));
                let builder = builder.domain(cords::<DoubleDouble>(count)).law(Drag);
                let builder = match (loaded, shape) {
                    (true, "flight") => builder.law(law("flight")),
                    (true, shape) => builder.law(law(shape)).law(Motion),
                    (false, "flight") => builder.law(Flight),
                    (false, "lift") => builder.law(Lift::default()).law(Motion),
                    (false, "flock") => builder.law(Flock::default()).law(Motion),
                    (false, "cord") => builder.law(Cord).law(Motion),
                    (false, _) => builder.law(Level::default()).law(Motion),
                };
                let mut engine = builder.step(1e-2).build().unwrap();
                engine.advance(0.1).unwrap();
                positions(&engine)
            };
            near(&at(false), &at(true), 1e-14, &format!("{shape}, {count} rows"));
        }
    }
}

#[test]
fn one_scene_has_laws_from_here_from_rust_and_from_c() {
    let path = compiled("lift", &lift_in_c());
    let folder = path.parent().unwrap();
    // SAFETY: it was compiled just now.
    let in_c = unsafe { LawPath::new([folder]).module("lift") }.unwrap();
    assert_eq!((in_c.name(), in_c.build()), ("lift", "lift.c"));
    let run = |how: &str| {
        let builder = Engine::<f64>::builder().domain(birds(1000)).constant(GravityAcceleration, [0.0, 0.0, -9.81]);
        let builder = builder.law(Motion).law(UniformGravity).law(Drag);
        let builder = match how {
            "rust" => builder.law(law("lift").with("slope", &[0.25]).unwrap()),
            "c" => builder.law(in_c.law("lift").unwrap().with("slope", &[0.25]).unwrap()),
            _ => builder.law(Lift { slope: 0.25 }),
        };
        let mut engine = builder.step(1e-3).strict().build().unwrap();
        (0..10).for_each(|_| engine.advance(1e-2).unwrap());
        bits(&engine)
    };
    assert_eq!(run("here"), run("rust"));
    assert_eq!(run("here"), run("c"));
}

/// Laws of all shapes in C, in the sums of the laws in Rust; with a field, an optional property, a constant and rates.
const SHAPES: &str = r#"
#include "vesper_law.h"
static int32_t create(const vesper_host *host, const double *p, size_t n, void **self) { (void)host, (void)p, (void)n; *self = 0; return 0; }
#define S(k) ((NUMBER *)call->slots[k])
static int32_t flock(void *self, const vesper_call *call) {
    (void)self;
    for (size_t i = call->begin; i < call->end; i++) {
        NUMBER sum[3] = {0, 0, 0};
        for (size_t j = call->others_begin; j < call->others_end; j++) {
            if (i == j) continue;
            NUMBER x = S(0)[i] - S(0)[j], y = S(1)[i] - S(1)[j], z = S(2)[i] - S(2)[j];
            NUMBER f = 1 / (x * x + y * y + z * z + 1);
            sum[0] += x * f, sum[1] += y * f, sum[2] += z * f;
        }
        for (int c = 0; c < 3; c++) S(3 + c)[i] += sum[c];
    }
    return 0;
}
static int32_t flock_energy(void *self, const vesper_call *call, double *energy) {
    (void)self;
    *energy = 0;
    for (size_t i = call->begin; i < call->end; i++)
        for (size_t j = i + 1; j < call->others_end; j++) {
            NUMBER x = S(0)[i] - S(0)[j], y = S(1)[i] - S(1)[j], z = S(2)[i] - S(2)[j];
            *energy += 1 / (x * x + y * y + z * z + 1);
        }
    return 0;
}
static int32_t cord(void *self, const vesper_call *call) {
    (void)self;
    for (size_t k = call->begin; k < call->end; k++) {
        size_t a = call->links[2 * k], b = call->links[2 * k + 1];
        NUMBER stiffness = S(0)[k * call->strides[0]];
        for (int c = 0; c < 3; c++) {
            const NUMBER *x = S(1 + c);
            NUMBER *f = S(4 + c);
            size_t from = call->strides[1 + c], to = call->strides[4 + c];
            NUMBER pull = (x[b * from] - x[a * from]) * stiffness;
            f[a * to] += pull;
            f[b * to] -= pull;
        }
    }
    return 0;
}
static int32_t level(void *self, const vesper_call *call) {
    (void)self;
    NUMBER sum = 0;
    for (size_t i = call->begin; i < call->end; i++) sum += S(2)[i * call->strides[2]];
    NUMBER mean = sum / call->rows[2];
    for (size_t i = call->begin; i < call->end; i++) S(5)[i * call->strides[5]] += (NUMBER)0.5 * (mean - S(2)[i * call->strides[2]]);
    return 0;
}
static int32_t flight(void *self, const vesper_call *call) {
    (void)self;
    for (size_t i = call->begin; i < call->end; i++)
        for (int c = 0; c < 3; c++) S(7 + c)[i] = S(c)[i], S(10 + c)[i] = S(3 + c)[i] / S(6)[i];
    return 0;
}
static int32_t blow(void *self, const vesper_call *call) {
    (void)self;
    for (size_t i = call->begin; i < call->end; i++)
        for (int c = 0; c < 3; c++) {
            NUMBER share = S(c)[i] * S(3)[0];
            if (call->slots[4]) share += S(4)[i];
            S(5 + c)[i] += share;
        }
    return 0;
}
#define PORT(name, k, m, ...) {.property = name, .si = {__VA_ARGS__}, .kind = k, .mode = m}
static const vesper_port position_force[] = {PORT("position", 3, VESPER_READS, 1), PORT("force", 3, VESPER_ADDS, 1, 1, -2)};
static const vesper_port of_cord[] = {PORT("stiffness", 1, VESPER_READS, 0, 1, -2),
    {.property = "position", .si = {1}, .kind = 3, .mode = VESPER_READS, .place = VESPER_END},
    {.property = "force", .si = {1, 1, -2}, .kind = 3, .mode = VESPER_ADDS, .place = VESPER_END}};
static const vesper_port of_flight[] = {PORT("velocity", 3, VESPER_READS, 1, 0, -1), PORT("force", 3, VESPER_READS, 1, 1, -2),
    PORT("mass", 1, VESPER_READS, 0, 1),
    {.property = "position", .si = {1}, .kind = 3, .mode = VESPER_RATES, .from = 1},
    {.property = "velocity", .si = {1, 0, -1}, .kind = 3, .mode = VESPER_RATES, .from = 6}};
static const vesper_port of_blow[] = {
    {.property = "wind", .si = {1, 0, -1}, .kind = 3, .mode = VESPER_READS, .place = VESPER_FIELD},
    {.property = "thickness_of_air", .si = {0, 1, -1}, .kind = 1, .mode = VESPER_READS, .place = VESPER_SCENE, .has_default = 1, .default_value = {0.5}},
    {.property = "wits", .si = {1, 1, -2}, .kind = 1, .mode = VESPER_READS, .optional = 1},
    PORT("force", 3, VESPER_ADDS, 1, 1, -2)};
#define LAW(law, s, p, ...) static const vesper_law law##_law = {.struct_size = sizeof(vesper_law), .port_size = sizeof(vesper_port), \
    .parameter_size = sizeof(vesper_parameter), .shape = s, .precisions = sizeof(NUMBER) == 4 ? VESPER_LAW_F32 : VESPER_LAW_F64, .name = #law, \
    .port_count = sizeof p / sizeof *p, .ports = p, .create = create, .apply = law, __VA_ARGS__}
LAW(flock, VESPER_PAIRS, position_force, .energy = flock_energy);
LAW(cord, VESPER_LINKS, of_cord, .link = "ends", .link_arity = 2);
LAW(level, VESPER_COLUMNS, position_force, .domain = 0);
LAW(flight, VESPER_ROWS, of_flight, .structure = 1);
LAW(blow, VESPER_ROWS, of_blow, .domain = 0);
static const vesper_law *const laws[] = {&flock_law, &cord_law, &level_law, &flight_law, &blow_law};
static const vesper_module module = {VESPER_LAW_ABI, sizeof module, 0, 5, laws};
const vesper_module *vesper_module_v1(void) { return &module; }
"#;

/// The numbers of two runs are as near as what they were computed in.
fn near(here: &[f64], there: &[f64], within: f64, what: &str) {
    for (a, b) in here.iter().zip(there) {
        assert!((a - b).abs() <= within * (1.0 + a.abs()), "{what}: {a} {b}");
    }
}

fn positions<P: Precision>(engine: &Engine<P>) -> Vec<f64> {
    engine.state().numbers("birds", Position).unwrap()
}

fn shapes_in<P: Precision>(number: &str, within: f64) {
    let module = opened(&format!("shapes_{number}"), &SHAPES.replace("NUMBER", number)).unwrap();
    assert_eq!(module.refused(), []);
    for count in [1, 2, 5, 140, 400] {
        // In fewer digits than a step is judged by, noise decides its length, and differences are no derivatives.
        let coarse = P::EPSILON < if number == "float" { 1e-10 } else { 1e-20 };
        let all = ["leapfrog", "adaptive", "implicit"];
        for integrator in &all[..if coarse {
            1
        } else if count > 5 {
            2
        } else {
            3
        }] {
            let run = |in_c: bool, shape: &str| {
                let builder = Engine::<P>::builder().domain(typed::<P>(count)).domain(cords::<P>(count));
                let builder = builder.law(Drag).threads(2);
                let builder = match *integrator {
                    "adaptive" => builder.integrator(DormandPrince8::default()),
                    "implicit" => builder.integrator(ImplicitMidpoint::default()),
                    _ => builder.integrator(Leapfrog::default()),
                };
                let motion = if in_c && shape == "flight" {
                    builder.law(module.law("flight").unwrap())
                } else {
                    builder.law(Motion)
                };
                let builder = match (in_c, shape) {
                    (true, "flight") | (false, "flight") => motion,
                    (true, shape) => motion.law(module.law(shape).unwrap()),
                    (false, "flock") => motion.law(Flock::default()),
                    (false, "cord") => motion.law(Cord),
                    (false, _) => motion.law(Level::default()),
                };
                let mut engine = builder.step(1e-2).build().unwrap_or_else(|faults| panic!("{shape}: {faults}"));
                engine.advance(0.1).unwrap_or_else(|faults| panic!("{shape}, {count} rows, {integrator}: {faults}"));
                (positions(&engine), engine.energy().unwrap().0)
            };
            for shape in ["flock", "cord", "level", "flight"] {
                let ((here, energy), (there, in_c)) = (run(false, shape), run(true, shape));
                let loose = if *integrator == "implicit" { within.max(1e-9) } else { within };
                near(&here, &there, loose, &format!("{shape}, {count} rows, {integrator}, {number} for {}", P::NAME));
                // The law of motion in C does not know its energy.
                if shape != "flight" {
                    near(&[energy], &[in_c], loose * 10.0, shape);
                }
            }
        }
    }
}

#[test]
fn laws_of_every_shape_in_c_do_what_those_in_rust_do_in_all_precisions() {
    shapes_in::<f64>("double", 1e-14);
    shapes_in::<f32>("float", 1e-5);
    shapes_in::<f32>("double", 1e-5);
    shapes_in::<f64>("float", 1e-5);
    shapes_in::<DoubleDouble>("double", 1e-13);
}

#[test]
fn a_law_in_c_gets_fields_constants_and_optional_properties() {
    let module = opened("shapes_of_wind", &SHAPES.replace("NUMBER", "double")).unwrap();
    let wind = PropertyInfo::at_run_time("wind", Kind::Vector, "m/s").unwrap();
    let wits = PropertyInfo::at_run_time("wits", Kind::Scalar, "N").unwrap();
    let air = PropertyInfo::at_run_time("thickness_of_air", Kind::Scalar, "kg/s").unwrap();
    let run = |uniform: bool, air_given: bool, wits_given: bool| {
        let mut birds = typed::<f64>(300);
        if wits_given {
            birds = birds.with(wits, (0..300).map(|row| row as f64).collect::<Vec<_>>());
        }
        let mut builder =
            Engine::builder().domain(birds).law(Motion).law(module.law("blow").unwrap()).observe("birds", Force);
        builder = match uniform {
            true => builder.field(wind, vesper::field::Uniform { value: [1.0, 2.0, 3.0] }),
            false => builder.field(wind, |place: DVec3, _time: f64| 2.0 * place),
        };
        if air_given {
            builder = builder.constant(air, 0.25);
        }
        let engine = builder.step(1e-3).build().unwrap();
        (0..300).map(|row| engine.state().get("birds", Force, row).unwrap()).collect::<Vec<DVec3>>()
    };
    for row in 0..300 {
        let place = DVec3::from(vector(row, 1));
        assert_eq!(run(true, false, false)[row], DVec3::new(0.5, 1.0, 1.5));
        assert_eq!(run(true, true, true)[row], DVec3::new(0.25, 0.5, 0.75) + row as f64);
        assert_eq!(run(false, true, false)[row], 2.0 * place * 0.25);
        if row > 2 {
            break;
        }
    }
    // Of all rows, not of a desk's alone.
    let all = run(false, false, true);
    assert!((0..300).all(|row| all[row] == 2.0 * DVec3::from(vector(row, 1)) * 0.5 + row as f64));
}

#[test]
fn a_link_law_in_c_gets_a_constant_of_the_scene_for_every_link() {
    let own = "PORT(\"stiffness\", 1, VESPER_READS, 0, 1, -2)";
    let constant =
        "{.property = \"stiffness\", .si = {0, 1, -2}, .kind = 1, .mode = VESPER_READS, .place = VESPER_SCENE}";
    assert!(SHAPES.contains(own));
    let module = opened("shapes_of_constants", &SHAPES.replace("NUMBER", "double").replace(own, constant)).unwrap();
    let run = |in_c: bool| {
        let ends = (0..49_u32).flat_map(|k| [k, k + 1]).collect();
        let links = Domain::new("cords").with_link(Ends::INFO, "birds", ends);
        let builder = Engine::<f64>::builder().domain(birds(50)).law(Motion);
        let builder = match in_c {
            true => builder.domain(links).constant(Stiffness, 2.0).law(module.law("cord").unwrap().on("cords")),
            false => builder.domain(links.with(Stiffness, vec![2.0; 49])).law(Cord),
        };
        let mut engine = builder.step(1e-2).build().unwrap_or_else(|faults| panic!("{faults}"));
        engine.advance(0.1).unwrap();
        positions(&engine)
    };
    near(&run(false), &run(true), 1e-14, "a constant");
}

#[test]
fn instructions_do_not_matter() {
    let run = |isa| {
        let builder =
            Engine::<f64>::builder().domain(birds(777)).law(Motion).law(law("lift")).law(law("flock")).isa(isa);
        let mut engine = builder.estimates(false).step(1e-2).build().unwrap();
        engine.advance(0.1).unwrap();
        bits(&engine)
    };
    let all: Vec<_> = Isa::available().into_iter().map(run).collect();
    assert!(all.windows(2).all(|two| two[0] == two[1]));
}
