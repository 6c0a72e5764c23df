//! Every stock law gives the same bits on every backend, in lanes of every width, on any number of threads, and for any
//! order of registration; those that allow estimates do so without them, and with them for one instruction set, within some
//! roundings of the others. The laws are taken from the catalog, so that none can be forgotten.

use vesper::backend::Compiled;
use vesper::law::{Mode, Place, Port};
use vesper::prelude::*;
use vesper::property::Role;
use vesper::real::Isa;
use vesper::registry::Options;
use vesper_laws::catalog::{StockLaw, stock_law, stock_laws};
use vesper_laws::{Gravity, Motion};

/// More than a block of 512 rows, and no multiple of any width of lanes.
const ROWS: usize = 1043;

/// Numbers without order in 0.5 to 1.5, the same every time.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        // Knuth's linear congruential generator (MMIX), its upper bits.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64 + 0.5
    }

    /// A column of a property: vectors in all directions, numbers above 0.
    fn column<P: Precision>(&mut self, domain: Domain<P>, property: PropertyInfo, rows: usize) -> Domain<P> {
        let width = property.kind.width();
        let shift = if width == 1 { 0.0 } else { 1.0 };
        let numbers = (0..rows * width).map(|_| self.next() - shift).collect();
        domain.with(property, vesper::column::Values::new(width, numbers))
    }
}

/// The columns that a client gives so that a law runs: what it reads and rates, but not sums, which laws make.
fn given(port: &Port) -> bool {
    let computed = matches!(port.property.role, Role::Sum { .. }) || matches!(port.mode, Mode::Sets | Mode::Adds);
    matches!(port.place, Place::Own | Place::End) && !computed
}

/// Gives every domain what the laws that stand on it touch.
fn domains<P: Precision>(laws: &[(&StockLaw, &str)]) -> Vec<Domain<P>> {
    let mut numbers = Numbers(1);
    let mut names: Vec<&str> = laws.iter().map(|(_, domain)| *domain).collect();
    names.dedup();
    let mut made = Vec::new();
    for name in names {
        let mut properties: Vec<PropertyInfo> = vec![Position::INFO];
        let mut ends: Vec<PropertyInfo> = vec![Position::INFO];
        let mut link = None;
        for (law, _) in laws.iter().filter(|(_, domain)| *domain == name) {
            for port in law.signature.ports.iter().filter(|port| given(port)) {
                let to = if port.place == Place::End { &mut ends } else { &mut properties };
                if !to.iter().any(|known| known.name == port.property.name) {
                    to.push(port.property);
                }
            }
            link = link.or(law.signature.link);
        }
        // What a law of the same domain sets is not given.
        let on_domain = laws.iter().filter(|(_, domain)| *domain == name);
        let set: Vec<&str> = on_domain
            .flat_map(|(law, _)| law.signature.ports.iter())
            .filter(|port| port.mode == Mode::Sets)
            .map(|port| port.property.name)
            .collect();
        properties.retain(|property| !set.contains(&property.name));
        if let Some(link) = link {
            // Every row is linked to several times, out of order.
            let rows = (0..2 * ROWS as u32).map(|row| [row * 7 % ROWS as u32, (row * 13 + 5) % ROWS as u32]);
            let linked = format!("{name}_ends");
            made.push(ends.iter().fold(Domain::new(&linked), |domain, info| numbers.column(domain, *info, ROWS)));
            let domain = Domain::new(name).link(link, &linked, rows);
            properties.retain(|property| property.name != Position::NAME);
            made.push(properties.iter().fold(domain, |domain, info| numbers.column(domain, *info, 2 * ROWS)));
        } else {
            made.push(properties.iter().fold(Domain::new(name), |domain, info| numbers.column(domain, *info, ROWS)));
        }
    }
    made
}

#[derive(Clone, Copy, Debug)]
struct Machine {
    isa: Isa,
    backend: Backend,
    threads: usize,
    estimates: bool,
}

/// A number for every parameter that has no default.
fn parameters(law: &StockLaw) -> Vec<f64> {
    let declared = law.signature.parameters.iter();
    declared.flat_map(|parameter| parameter.default.unwrap_or([0.7; 3]).into_iter().take(parameter.width)).collect()
}

/// Runs laws for three steps: the engine, and the properties that they moved or computed, with their domains.
fn run<P: Precision>(
    laws: &[(&StockLaw, &str)],
    order: &[usize],
    machine: Machine,
) -> (Engine<P>, Vec<(String, PropertyInfo)>) {
    let mut builder = Engine::<P>::builder()
        .integrator(SemiImplicitEuler)
        .step(1e-3)
        .isa(machine.isa)
        .backend(machine.backend)
        .threads(machine.threads)
        .estimates(machine.estimates)
        .constant(GravityAcceleration, [[0.1, 0.2, -9.81]])
        .constant(SpeedOfLight, [20.0])
        .field(GravityField, |place: P::Vec3, time: P| place * time)
        .field(ElectricField, Point { at: [0.1, 0.2, 0.3], strength: 2.0 })
        .field(MagneticField, Uniform { value: [0.3, -0.2, 1.5] });
    if laws.len() > 1 {
        // So many laws at once move rows through contact thousands of times in a step.
        builder = builder.across_jumps();
    }
    let domains = domains::<P>(laws);
    let names: Vec<String> = laws.iter().map(|(_, domain)| (*domain).to_owned()).collect();
    for domain in domains {
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
    let mut looked_at = Vec::new();
    for ((law, _), domain) in laws.iter().zip(&names) {
        for port in law.signature.ports.iter().filter(|port| !port.mode.is_input()) {
            if port.property.role == Role::Switch {
                // It is a law's own: nobody else knows its name.
                continue;
            }
            let on = if port.place == Place::End { format!("{domain}_ends") } else { domain.clone() };
            builder = builder.observe(&on, port.property);
            looked_at.push((on, port.property));
        }
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
    let mut numbers = Numbers(5);
    for _ in 0..8 {
        let mut keys: Vec<(f64, usize)> = forward.iter().map(|&law| (numbers.next(), law)).collect();
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
        let mut numbers = Numbers(rows as u64);
        let mut triple = || [0; 3].map(|_| numbers.next());
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
