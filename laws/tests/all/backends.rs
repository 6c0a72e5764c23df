//! Every stock law gives the same bits on every backend, in lanes of every width, on any number of threads, and for any
//! order of registration; those that allow estimates do so without them, and with them for one instruction set, within some
//! roundings of the others. The laws are taken from the catalog, so that none can be forgotten.

use vesper::backend::Compiled;
use vesper::prelude::*;
use vesper::property::PropertyInfo;
use vesper::real::Isa;
use vesper::registry::Options;
use vesper_laws::catalog::{StockLaw, stock_law, stock_laws};
use vesper_laws::reference::crowd::{Numbers, crowd, parameters, results, surroundings};
use vesper_laws::{Gravity, Motion};

/// More than a block of 512 rows, and no multiple of any width of lanes.
const ROWS: usize = 1043;

#[derive(Clone, Copy, Debug)]
struct Machine {
    isa: Isa,
    backend: Backend,
    threads: usize,
    estimates: bool,
}

/// Runs laws for three steps: the engine, and the properties that they moved or computed, with their domains.
fn run<P: Precision>(
    laws: &[(&StockLaw, &str)],
    order: &[usize],
    machine: Machine,
) -> (Engine<P>, Vec<(String, PropertyInfo)>) {
    let mut builder = surroundings(Engine::<P>::builder())
        .integrator(SemiImplicitEuler)
        .step(1e-3)
        .isa(machine.isa)
        .backend(machine.backend)
        .threads(machine.threads)
        .estimates(machine.estimates);
    if laws.len() > 1 {
        // So many laws at once move rows through contact thousands of times in a step.
        builder = builder.across_jumps();
    }
    for domain in crowd(laws, ROWS) {
        builder = builder.domain(domain);
    }
    for &law in order {
        let (law, domain) = laws[law];
        let compiled: Compiled<P> = law.compile(&parameters(law));
        let label = format!("{}@{domain}", law.signature.name);
        let options = Options { domain: Some(domain.to_owned()), label: Some(label), ..Options::default() };
        builder = builder.listed(compiled, options);
    }
    // In the order of the laws' declaration, whatever the order of registration.
    let looked_at: Vec<_> = laws.iter().flat_map(|(law, domain)| results(law, domain)).collect();
    for (domain, property) in &looked_at {
        builder = builder.observe(domain, *property);
    }
    let mut engine = builder.build().unwrap();
    for law in &engine.report().laws {
        assert!(matches!(law.status, Status::Active { .. }), "{law}");
    }
    engine.steps_of(3, 1e-3).unwrap();
    (engine, looked_at)
}

/// The bits of everything that laws moved or computed.
fn bits<P: Precision>(laws: &[(&StockLaw, &str)], order: &[usize], machine: Machine) -> Vec<u64> {
    let (engine, looked_at) = run::<P>(laws, order, machine);
    let mut bits = vec![engine.state().hash()];
    for (domain, property) in looked_at {
        let numbers = engine.state().numbers(&domain, property).unwrap();
        assert!(numbers.iter().any(|number| *number != 0.0), "{domain}.{} stays 0", property.name);
        assert!(numbers.iter().all(|number| number.is_finite()), "{domain}.{}", property.name);
        bits.extend(numbers.iter().map(|number| number.to_bits()));
    }
    bits
}

/// All backends and some numbers of threads, without estimates.
fn machines(isa: Isa) -> impl Iterator<Item = Machine> {
    let parallel = [1, 2, 3, 7].map(|threads| Machine { isa, backend: Backend::Parallel, threads, estimates: false });
    [Machine { isa, ..REFERENCE }].into_iter().chain(parallel)
}

const REFERENCE: Machine = Machine { isa: Isa::Scalar, backend: Backend::Cpu, threads: 1, estimates: false };

fn every_law_on_every_machine<P: Precision>() {
    for law in stock_laws() {
        let laws = [(law, "rows")];
        let reference = bits::<P>(&laws, &[0], REFERENCE);
        for machine in Isa::available().into_iter().flat_map(machines) {
            // Not `assert_eq`, which would print thousands of numbers.
            assert!(bits::<P>(&laws, &[0], machine) == reference, "{} differs on {machine:?}", law.signature.name);
        }
    }
}

/// The largest difference of two runs, in parts of the largest number of a property.
fn difference<P: Precision, Q: Precision>(
    (a, looked_at): &(Engine<P>, Vec<(String, PropertyInfo)>),
    b: &Engine<Q>,
) -> f64 {
    looked_at.iter().fold(0.0, |most, (domain, property)| {
        let a = a.state().numbers(domain, *property).unwrap();
        let b = b.state().numbers(domain, *property).unwrap();
        let largest = b.iter().fold(0.0, |largest, number| f64::max(largest, number.abs()));
        let off = a.iter().zip(&b).fold(0.0, |off, (a, b)| f64::max(off, (a - b).abs()));
        assert!(off.is_finite(), "{}: {off}", property.name);
        f64::max(most, off / largest)
    })
}

fn with_estimates<P: Precision>() {
    let allow = stock_laws().iter().filter(|law| law.signature.estimates);
    for law in allow {
        let laws = [(law, "rows")];
        let exact = run::<P>(&laws, &[0], REFERENCE).0;
        for isa in Isa::available() {
            let with = |machine| Machine { estimates: true, ..machine };
            let reference = bits::<P>(&laws, &[0], with(Machine { isa, ..REFERENCE }));
            for machine in machines(isa).map(with) {
                assert!(bits::<P>(&laws, &[0], machine) == reference, "{} differs on {machine:?}", law.signature.name);
            }
            let off = difference(&run::<P>(&laws, &[0], with(Machine { isa, ..REFERENCE })), &exact);
            assert!(off < 32.0 * P::EPSILON, "{} in {isa:?}: {off:e}", law.signature.name);
        }
    }
}

#[test]
fn a_law_that_allows_estimates_gives_the_same_bits_on_any_number_of_threads() {
    assert!(stock_laws().iter().filter(|law| law.signature.estimates).count() >= 2);
    with_estimates::<f64>();
    with_estimates::<f32>();
}

#[test]
fn every_stock_law_gives_the_same_bits_everywhere_in_f64() {
    every_law_on_every_machine::<f64>();
}

#[test]
fn every_stock_law_gives_the_same_bits_everywhere_in_f32() {
    every_law_on_every_machine::<f32>();
}

#[test]
fn every_stock_law_gives_the_same_in_double_double_as_in_f64() {
    for law in stock_laws() {
        let laws = [(law, "rows")];
        let twice = run::<DoubleDouble>(&laws, &[0], REFERENCE).0;
        // Sums over a thousand rows, of terms of any sign.
        let off = difference(&run::<f64>(&laws, &[0], REFERENCE), &twice);
        assert!(off <= 1e-11, "{}: {off:e}", law.signature.name);
    }
}

/// One scene in which every stock law runs.
fn everything() -> Vec<(&'static StockLaw, &'static str)> {
    let scene = [
        ("contact_plane", "bodies"),
        ("coulomb", "bodies"),
        ("drag", "bodies"),
        ("driven_force", "bodies"),
        ("electric_force", "bodies"),
        ("field_gravity", "bodies"),
        ("gravity", "bodies"),
        ("henon_heiles", "bodies"),
        ("hierarchical_gravity", "bodies"),
        ("magnetic_force", "bodies"),
        ("motion", "bodies"),
        ("quadratic_drag", "bodies"),
        ("rotating_frame", "bodies"),
        ("uniform_gravity", "bodies"),
        ("electric_force", "fast"),
        ("magnetic_force", "fast"),
        ("relativistic_motion", "fast"),
        ("relativistic_velocity", "fast"),
        ("magnetic_force", "ions"),
        ("motion", "ions"),
        ("relativistic_mass", "ions"),
        ("einstein_infeld_hoffmann", "planets"),
        ("gravity_by_parameter", "planets"),
        ("kinematics", "planets"),
        ("newtonian_field", "planets"),
        ("post_newtonian", "planets"),
        ("damper", "springs"),
        ("quartic_spring", "springs"),
        ("spring", "springs"),
    ];
    scene.map(|(name, domain)| (stock_law(name).unwrap(), domain)).to_vec()
}

#[test]
fn any_order_of_registration_gives_the_same_bits() {
    let laws = everything();
    for law in stock_laws() {
        let name = law.signature.name;
        assert!(laws.iter().any(|(listed, _)| listed.signature.name == name), "{name} is not in the scene");
    }
    let forward: Vec<usize> = (0..laws.len()).collect();
    let reference = bits::<f64>(&laws, &forward, REFERENCE);
    let mut orders = vec![forward.iter().rev().copied().collect::<Vec<_>>()];
    let mut numbers = Numbers::new(5);
    for _ in 0..8 {
        let mut keys: Vec<(f64, usize)> = forward.iter().map(|&law| (numbers.next_number(), law)).collect();
        keys.sort_by(|a, b| a.0.total_cmp(&b.0));
        orders.push(keys.into_iter().map(|(_, law)| law).collect());
    }
    let widest = *Isa::available().last().unwrap();
    let parallel = Machine { isa: widest, backend: Backend::Parallel, threads: 3, estimates: false };
    for (index, order) in orders.iter().enumerate() {
        let machine = if index % 2 == 0 { REFERENCE } else { parallel };
        assert!(bits::<f64>(&laws, order, machine) == reference, "{order:?} on {machine:?}");
    }
}

/// Loops take the last rows in whole registers, and leave anything behind them: nothing that counts may stand there.
fn any_number_of_rows<P: Precision>() {
    let run = |rows: usize, isa: Isa, compensated: bool| {
        let mut numbers = Numbers::new(rows as u64);
        let mut triple = || [0; 3].map(|_| numbers.next_number());
        let bodies = Domain::new("bodies")
            .with(Position, (0..rows).map(|_| triple()).collect::<Vec<_>>())
            .with(Velocity, (0..rows).map(|_| triple()).collect::<Vec<_>>())
            .with(Mass, (0..rows).map(|row| 1.0 + row as f64).collect::<Vec<_>>());
        let builder = Engine::<P>::builder().domain(bodies).law(Gravity { g: 1.0, softening: 0.1 }).law(Motion);
        let builder = if compensated { builder.compensated() } else { builder };
        let mut engine = builder.integrator(RungeKutta4).isa(isa).step(1e-3).build().unwrap();
        engine.steps_of(3, 1e-3).unwrap();
        engine.state().hash()
    };
    for rows in 1..=20 {
        for compensated in [false, true] {
            let reference = run(rows, Isa::Scalar, compensated);
            for isa in Isa::available() {
                assert_eq!(run(rows, isa, compensated), reference, "{rows} rows, {isa:?}, compensated: {compensated}");
            }
        }
    }
}

#[test]
fn any_number_of_rows_gives_the_same_bits_in_all_lanes() {
    any_number_of_rows::<f64>();
    any_number_of_rows::<f32>();
}
