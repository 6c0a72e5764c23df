//! Every stock law on a graphics processor, beside the host.

use vesper::backend::Compiled;
use vesper::backend::gpu::{Comparison, Device, NotCompared, compare, wgsl_of};
use vesper::integrate::Integrator;
use vesper::law::Shape;
use vesper::prelude::*;
use vesper::property::PropertyInfo;
use vesper::real::Scalar as Number;
use vesper::registry::Options;
use vesper_laws::catalog::{StockLaw, stock_laws};
use vesper_laws::reference::crowd::{crowd, parameters, results, surroundings};

/// Rows of a comparison: more than one workgroup, and not whole ones.
const ROWS: usize = 1000;

/// The device that the system has; without one the test says so, and with `VESPER_REQUIRE_GPU=1` it fails.
fn device() -> Option<Device> {
    match Device::open() {
        Ok(device) => Some(device),
        Err(error) if std::env::var("VESPER_REQUIRE_GPU").is_ok_and(|required| required == "1") => {
            panic!("a device is required: {error}")
        }
        Err(error) => {
            eprintln!("not run: {error}");
            None
        }
    }
}

/// What a law is made of says how near its results must be.
#[derive(Debug, PartialEq)]
enum Kept {
    /// The same bits: nothing but what rounds in one way.
    Bits,
    /// Sums of many terms in another order, or functions that devices have in another way: parts of the largest number.
    Within(f64),
    /// Not on devices: its reason has these words.
    OnHost(&'static str),
}

/// What is expected of every stock law, by its name. A law that is not here fails the test.
fn kept(law: &StockLaw) -> Option<Kept> {
    Some(match law.signature.name {
        "damper"
        | "drag"
        | "electric_force"
        | "field_gravity"
        | "kinematics"
        | "magnetic_force"
        | "motion"
        | "quadratic_drag"
        | "quartic_spring"
        | "relativistic_mass"
        | "relativistic_motion"
        | "relativistic_velocity"
        | "rotating_frame"
        | "spring"
        | "uniform_gravity" => Kept::Bits,
        // Drivers may draw a factor out of a sum, or fuse a product with it: Mesa does so in these two, and rounds elsewhere.
        "contact_plane" | "henon_heiles" => Kept::Within(3e-7),
        // A cosine of the device's own.
        "driven_force" => Kept::Within(1e-6),
        // All pairs: sums of a thousand terms, in f32.
        "coulomb" | "einstein_infeld_hoffmann" | "gravity" | "gravity_by_parameter" | "newtonian_field" => {
            Kept::Within(1e-6)
        }
        "hierarchical_gravity" | "post_newtonian" => Kept::OnHost("whole columns"),
        _ => return None,
    })
}

/// The law with its parameters, and numbers that do something where those are 0.
fn compiled<P: Number>(law: &StockLaw) -> Compiled<P> {
    let parameters = law.default_parameters().into_iter().zip(1..);
    let parameters = parameters.map(|(value, at)| if value == 0.0 { 0.3 * f64::from(at) } else { value });
    law.compile(&parameters.collect::<Vec<f64>>())
}

fn compared<P: Number>(device: &Device, law: &StockLaw, rows: usize) -> Result<Comparison, NotCompared> {
    compare(device, &compiled::<P>(law), rows)
}

#[test]
fn every_stock_law_has_a_kernel_or_a_reason() {
    for law in stock_laws() {
        let compiled = compiled::<f32>(law);
        let name = law.signature.name;
        match (kept(law).unwrap_or_else(|| panic!("{name} is not in the list of this test")), wgsl_of(&compiled)) {
            (Kept::OnHost(words), Err(error)) => assert!(error.to_string().contains(words), "{error}"),
            (Kept::OnHost(_), Ok(_)) => panic!("{name} has a kernel now: say what is expected of it"),
            (_, Ok(text)) => assert!(text.contains("fn main"), "{text}"),
            (_, Err(error)) => panic!("{error}"),
        }
    }
}

#[test]
fn every_stock_law_gives_on_a_device_what_it_gives_on_the_host() {
    let Some(device) = device() else { return };
    println!("on {}", device.name());
    let mut wrong = Vec::new();
    for law in stock_laws() {
        let (name, kept) = (law.signature.name, kept(law));
        let Some(kept) = kept.filter(|kept| !matches!(kept, Kept::OnHost(_))) else { continue };
        let found = compared::<f32>(&device, law, ROWS).unwrap_or_else(|error| panic!("{error}"));
        let holds = match kept {
            Kept::Bits => found.same == found.numbers,
            Kept::Within(bound) => found.largest < bound,
            Kept::OnHost(_) => true,
        };
        let Comparison { numbers, same, zeros, largest } = found;
        println!("{name}: {same} of {numbers} numbers the same, {zeros} of them 0, largest difference {largest:.1e}");
        if !holds || 3 * zeros > 2 * numbers {
            wrong.push(format!("{name}: {found:?}, expected {kept:?}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn few_rows_are_no_special_case() {
    let Some(device) = device() else { return };
    for law in stock_laws().iter().filter(|law| kept(law) == Some(Kept::Bits)) {
        for rows in [0, 1, 2, 63, 64, 65] {
            let found = compared::<f32>(&device, law, rows).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(found.same, found.numbers, "{} of {rows} rows", law.signature.name);
        }
    }
}

/// Functions that devices do not have in f64 are refused; everything else gives the bits of the host, or nearly.
#[test]
fn f64_is_what_devices_have_of_it() {
    let Some(device) = device() else { return };
    for law in stock_laws().iter().filter(|law| !matches!(kept(law), Some(Kept::OnHost(_)))) {
        let name = law.signature.name;
        match compared::<f64>(&device, law, ROWS) {
            Ok(found) if compiled::<f64>(law).shape() == Shape::Pair => {
                assert!(found.largest < 1e-14, "{name}: {found:?}");
            }
            Ok(found) if matches!(name, "contact_plane" | "henon_heiles") => {
                assert!(found.largest < 6e-16, "{name}: {found:?}")
            }
            Ok(found) => assert_eq!(found.same, found.numbers, "{name}: {found:?}"),
            Err(NotCompared::NoKernel(error)) => {
                assert!(name == "driven_force" && error.to_string().contains("f64 has no `"), "{error}");
            }
            // The device has no f64 at all.
            Err(NotCompared::Device(error)) => assert!(error.to_string().contains("no f64"), "{error}"),
        }
    }
}

/// An engine with these laws of a crowd, each where it is asked to run; what they moved or computed.
fn stepped<P: Precision>(
    laws: &[(&StockLaw, &str, Backend)],
    integrator: impl Integrator + 'static,
) -> (Engine<P>, Vec<(String, PropertyInfo)>) {
    let of_crowd: Vec<(&StockLaw, &str)> = laws.iter().map(|(law, domain, _)| (*law, *domain)).collect();
    let mut builder = surroundings(Engine::<P>::builder()).integrator(integrator).step(1e-3).estimates(false);
    for domain in crowd(&of_crowd, ROWS) {
        builder = builder.domain(domain);
    }
    for (law, domain, backend) in laws {
        let label = format!("{}@{domain}", law.signature.name);
        let options =
            Options { domain: Some((*domain).to_owned()), label: Some(label), backend: *backend, ..Options::default() };
        builder = builder.listed(law.compile::<P>(&parameters(law)), options);
    }
    let looked_at: Vec<_> = of_crowd.iter().flat_map(|(law, domain)| results(law, domain)).collect();
    for (domain, property) in &looked_at {
        builder = builder.observe(domain, *property);
    }
    let mut engine = builder.build().unwrap();
    engine.steps_of(3, 1e-3).unwrap();
    (engine, looked_at)
}

/// The largest difference, in parts of the largest number of a property.
fn apart<P: Precision>((a, looked_at): &(Engine<P>, Vec<(String, PropertyInfo)>), b: &Engine<P>) -> f64 {
    looked_at.iter().fold(0.0, |most, (domain, property)| {
        let [a, b] = [a, b].map(|engine| engine.state().numbers(domain, *property).unwrap());
        let largest = b.iter().fold(0.0, |largest, number| f64::max(largest, number.abs()));
        let off = a.iter().zip(&b).fold(0.0, |off, (a, b)| f64::max(off, (a - b).abs()));
        assert!(off.is_finite() && largest > 0.0, "{domain}.{}: {off} of {largest}", property.name);
        f64::max(most, off / largest)
    })
}

/// Every law alone in an engine, by a method whose loops advance the state at once, and by one that keeps rates.
#[test]
fn an_engine_runs_laws_on_the_device_as_on_the_host() {
    if device().is_none() {
        // Then it runs them on the host, and says so.
        let motion = stock_laws().iter().find(|law| law.signature.name == "motion").unwrap();
        let (engine, _) = stepped::<f32>(&[(motion, "rows", Backend::Gpu)], SemiImplicitEuler);
        let text = engine.explain();
        assert_eq!(engine.backends(), [Some(Backend::Cpu)], "{text}");
        return assert!(text.contains("not on the graphics processor: there is no"), "{text}");
    }
    let mut on_device = 0;
    for law in stock_laws() {
        let on = |backend| [(law, "rows", backend)];
        let pairs = [
            (stepped::<f32>(&on(Backend::Gpu), SemiImplicitEuler), stepped(&on(Backend::Cpu), SemiImplicitEuler)),
            (stepped(&on(Backend::Gpu), RungeKutta4), stepped(&on(Backend::Cpu), RungeKutta4)),
        ];
        for (device, host) in pairs {
            let name = law.signature.name;
            let off = apart(&device, &host.0);
            let bound = if matches!(kept(law), Some(Kept::Bits)) { 0.0 } else { 2e-5 };
            assert!(off <= bound, "{name}: {off:e}");
            let ran = device.0.backends() == [Some(Backend::Gpu)];
            on_device += usize::from(ran);
            let text = device.0.explain();
            if !ran {
                let reason = text.lines().find(|line| line.contains("not on the graphics processor: "));
                println!("{name}: {}", reason.unwrap_or_default().trim());
            }
            assert!(ran || text.contains("not on the graphics processor: "), "{name}: {text}");
            assert!(!ran || text.contains("on the graphics processor: "), "{name}: {text}");
            let foreseen =
                [" bytes to the host: ", "depends on the numbers"].into_iter().any(|words| text.contains(words));
            assert!(!ran || foreseen, "{name}: {text}");
        }
    }
    assert!(on_device >= 2 * 17, "{on_device}");
}

/// Suns that attract each other: force and motion, each here or there.
#[test]
fn laws_of_a_scene_run_here_and_there() {
    if device().is_none() {
        return;
    }
    let suns = |[force, motion]: [Backend; 2]| {
        let named = |name| stock_laws().iter().find(|law| law.signature.name == name).unwrap();
        stepped::<f32>(&[(named("gravity"), "rows", force), (named("motion"), "rows", motion)], Leapfrog::default())
    };
    let host = suns([Backend::Cpu; 2]);
    for places in [[Backend::Gpu, Backend::Cpu], [Backend::Cpu, Backend::Gpu], [Backend::Gpu; 2]] {
        let (engine, looked_at) = suns(places);
        assert_eq!(engine.backends(), places.map(Some));
        let off = apart(&(engine, looked_at), &host.0);
        assert!(off < 1e-6, "{places:?}: {off:e}");
    }
}

/// What stays on the host says why, and runs there.
#[test]
fn a_law_that_cannot_runs_on_the_host_and_says_why() {
    if device().is_none() {
        return;
    }
    let far = Engine::<f32>::builder()
        .domain(
            Domain::new("rows")
                .rows(5000)
                .with(Position, crowd_places(5000))
                .with(Mass, vec![1.0; 5000])
                .with(Velocity, vec![DVec3::ZERO; 5000]),
        )
        .law(vesper_laws::Gravity { g: 1.0, softening: 0.1 }.far_field(1e-3).backend(Backend::Gpu))
        .law(vesper_laws::Motion.backend(Backend::Gpu))
        .step(1e-3)
        .build()
        .unwrap();
    let text = far.explain();
    assert!(text.contains("not on the graphics processor: far fields are the host's"), "{text}");
    assert_eq!(far.backends()[1], Some(Backend::Gpu), "{text}");
}

/// Two laws of one pass, and between them a sum that nobody else looks at.
#[test]
fn what_only_laws_of_a_pass_see_is_on_the_device_too() {
    if device().is_none() {
        return;
    }
    let fallen = |backend: Backend| {
        let rows = Domain::new("rows").rows(100).with(Position, crowd_places(100)).with(Mass, vec![2.0; 100]);
        let builder = Engine::<f32>::builder().domain(rows.with(Velocity, vec![DVec3::Y; 100]));
        let builder = builder.constant(GravityAcceleration, DVec3::new(0.0, 0.0, -9.81));
        let builder = builder.law(vesper_laws::UniformGravity).law(vesper_laws::Motion).backend(backend).step(0.125);
        let mut engine = builder.strict().build().unwrap();
        engine.steps_of(8, 0.125).unwrap();
        engine
    };
    let [here, there] = [Backend::Cpu, Backend::Gpu].map(fallen);
    assert_eq!(there.backends(), [Some(Backend::Gpu); 2], "{}", there.explain());
    let places = |engine: &Engine<f32>| engine.state().numbers("rows", Position::INFO).unwrap();
    assert_eq!(places(&here), places(&there));
}

fn crowd_places(count: usize) -> Vec<DVec3> {
    (0..count).map(|row| DVec3::new((row % 17) as f64, (row % 31) as f64, row as f64 * 0.01)).collect()
}

property! {
    /// A number that grows.
    Count: Scalar, "1";
}

/// A row that counts steps.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(count: Count), amends(counted: Count))]
struct Counting;

#[kernel]
impl<R: Real> RowLaw<R> for Counting {
    fn row(&self, row: CountingRow<R>) -> R {
        row.count + R::lit(1.0)
    }
}

fn counted(rows: usize) -> Engine<f32> {
    let mut engine = Engine::<f32>::builder()
        .domain(Domain::new("rows").rows(rows).with(Count, (0..rows).map(|row| row as f64).collect::<Vec<_>>()))
        .law(Counting.backend(Backend::Gpu))
        .step(1.0)
        .build()
        .unwrap();
    engine.steps_of(2, 1.0).unwrap();
    engine
}

/// No row, one, more than one dimension of workgroups holds, twenty million: beyond 2^24 not every number is one of f32.
#[test]
fn any_number_of_rows_is_counted() {
    if device().is_none() {
        return;
    }
    for rows in [0, 1, 2, 64, 65_535 * 64 + 1, 20_000_000] {
        let engine = counted(rows);
        assert!(rows == 0 || engine.backends() == [Some(Backend::Gpu)], "{}", engine.explain());
        let numbers = engine.state().numbers("rows", Count.info()).unwrap();
        assert!(numbers.iter().enumerate().all(|(row, number)| *number == f64::from(row as f32 + 1.0 + 1.0)), "{rows}");
    }
}

/// A column that no buffer of the device holds stays on the host.
#[test]
fn a_column_beyond_what_the_device_binds_stays_on_the_host() {
    let Some(device) = device() else { return };
    if !device.name().contains("llvmpipe") {
        return println!("not run: {} may bind more than this test wants to hold", device.name());
    }
    let engine = counted((128 << 20) / 4 + 1);
    assert_eq!(engine.backends()[0], Some(Backend::Parallel), "{}", engine.explain());
    let text = engine.explain();
    assert!(text.contains("not on the graphics processor: ") && text.contains("134217732 bytes"), "{text}");
    let numbers = engine.state().column("rows", "count").unwrap().components().unwrap()[0];
    assert!(numbers[..1000].iter().enumerate().all(|(row, number)| *number == row as f32 + 2.0));
}

macro_rules! many {
    ($($name:ident),*) => {
        property! { $(
            /// One of many.
            $name: Scalar, "1";
        )* }
    };
}
many!(
    One, Two, Three, Four, Five, Six, Seven, Eight, Nine, Ten, Eleven, Twelve, Thirteen, Fourteen, Fifteen, Sixteen,
    Seventeen
);

/// A law of nine properties.
#[derive(Law, Clone, Copy, Debug)]
#[law(
    reads(a: One, b: Two, c: Three, d: Four, e: Five, f: Six, g: Seven, h: Eight),
    sets(sum: Nine)
)]
struct Many;

#[kernel]
impl<R: Real> RowLaw<R> for Many {
    fn row(&self, row: ManyRow<R>) -> R {
        row.a + row.b + row.c + row.d + row.e + row.f + row.g + row.h
    }
}

/// A law of seventeen: more than are asked of any device.
#[derive(Law, Clone, Copy, Debug)]
#[law(
    reads(
        a: One, b: Two, c: Three, d: Four, e: Five, f: Six, g: Seven, h: Eight, i: Ten, j: Eleven, k: Twelve, l: Thirteen, m: Fourteen,
        n: Fifteen, o: Sixteen, p: Seventeen
    ),
    sets(sum: Nine)
)]
struct TooMany;

#[kernel]
impl<R: Real> RowLaw<R> for TooMany {
    fn row(&self, row: TooManyRow<R>) -> R {
        let first = row.a + row.b + row.c + row.d + row.e + row.f + row.g + row.h;
        first + row.i + row.j + row.k + row.l + row.m + row.n + row.o + row.p
    }
}

/// Properties beyond the eight that every device has for a program.
#[test]
fn many_properties_run_where_there_are_buffers_for_them() {
    if device().is_none() {
        return;
    }
    let ones = |domain: Domain<f32>| {
        let domain = domain.with(One, [1.0; 5]).with(Two, [1.0; 5]).with(Three, [1.0; 5]).with(Four, [1.0; 5]);
        let domain = domain.with(Five, [1.0; 5]).with(Six, [1.0; 5]).with(Seven, [1.0; 5]).with(Eight, [1.0; 5]);
        let domain = domain.with(Ten, [1.0; 5]).with(Eleven, [1.0; 5]).with(Twelve, [1.0; 5]).with(Thirteen, [1.0; 5]);
        domain.with(Fourteen, [1.0; 5]).with(Fifteen, [1.0; 5]).with(Sixteen, [1.0; 5]).with(Seventeen, [1.0; 5])
    };
    let builder = || Engine::<f32>::builder().domain(ones(Domain::new("rows").rows(5))).backend(Backend::Gpu);
    let sums = |engine: &Engine<f32>| engine.state().numbers("rows", Nine.info()).unwrap();
    let many = builder().law(Many).observe("rows", Nine).build().unwrap();
    assert_eq!(sums(&many), [8.0; 5]);
    let limit = many.explain();
    assert!(many.backends() == [Some(Backend::Gpu)] || limit.contains("the law needs 9 buffers"), "{limit}");
    let too_many = builder().law(TooMany).observe("rows", Nine).build().unwrap();
    assert_eq!(sums(&too_many), [16.0; 5]);
    let text = too_many.explain();
    assert!(text.contains("the law needs 17 buffers"), "{text}");
}

fn suns(backend: Backend) -> Engine<f32> {
    let rows = Domain::new("rows").rows(100).with(Position, crowd_places(100)).with(Mass, vec![2.0; 100]);
    let builder = Engine::<f32>::builder().domain(rows.with(Velocity, vec![DVec3::Y; 100])).backend(backend).step(1e-3);
    let builder = builder.law(vesper_laws::Gravity { g: 1.0, softening: 0.1 }.backend(Backend::Cpu));
    builder.law(vesper_laws::Motion).build().unwrap()
}

/// Who does not wait sees an earlier frame, and the run is the same.
#[test]
fn late_looks_are_of_earlier_frames_and_change_nothing() {
    if device().is_none() {
        return;
    }
    let (mut engine, mut same) = (suns(Backend::Gpu), suns(Backend::Gpu));
    let mut frames: Vec<Vec<f64>> = vec![engine.state().numbers("rows", Position).unwrap()];
    let mut seen = Vec::new();
    for _ in 0..20 {
        same.advance(1e-3).unwrap();
        frames.push(same.state().numbers("rows", Position).unwrap());
        engine.advance(1e-3).unwrap();
        if let Some(late) = engine.observe_late("rows", Position).unwrap() {
            assert!((late.time - 1e-3 * late.step as f64).abs() < 1e-12 && late.step <= engine.steps());
            let numbers = (0..100).flat_map(|row| late.components.iter().map(move |numbers| f64::from(numbers[row])));
            assert!(numbers.eq(frames[late.step as usize].iter().copied()), "{}", late.step);
            seen.push(late.step);
        }
    }
    assert!(seen.len() > 5 && seen.is_sorted(), "{seen:?}");
    assert_eq!(engine.state().hash(), same.state().hash());
    let fault = engine.observe_late("rows", Charge).unwrap_err().to_string();
    assert!(fault.contains("charge"), "{fault}");
}

/// Where steps are timed here and there, the choice is told, and one that was made before stays.
#[test]
fn the_fastest_place_is_found_by_trying() {
    if device().is_none() {
        return;
    }
    let engine = suns(Backend::Fastest);
    let text = engine.explain();
    assert!(text.contains("calibrated: a step takes ") && text.contains("  motion: on the "), "{text}");
    assert!(!text.contains("  gravity: on the "), "{text}");
    assert_eq!(engine.backends()[0], Some(Backend::Cpu));
    let there = engine.backends()[1] == Some(Backend::Gpu);
    assert_eq!(there, text.contains("  motion: on the graphics processor"), "{text}");
    // What was tried has left no trace.
    let (mut engine, mut same) = (engine, suns(if there { Backend::Gpu } else { Backend::Cpu }));
    engine.steps_of(5, 1e-3).unwrap();
    same.steps_of(5, 1e-3).unwrap();
    assert_eq!(engine.state().hash(), same.state().hash());
}

/// As the README shows it.
#[test]
fn a_law_of_ones_own_is_shown_and_compared() {
    use vesper::backend::Compile;
    let law = Counting.compile::<f32>();
    assert!(wgsl_of(&law).unwrap().contains("fn main"));
    let Some(device) = device() else { return };
    let found = compare(&device, &law, 1000).unwrap();
    assert_eq!(found.same, found.numbers, "{found:?}");
}
