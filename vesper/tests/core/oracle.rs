//! Who runs, against an independent count; and the same bits for any order of the list.

use crate::common::*;
use vesper::prelude::*;
use vesper::registry::Status;

const PLAIN: [&str; 5] = ["a", "b", "c", "d", "e"];

fn properties() -> Vec<PropertyInfo> {
    let of = |name: &str| PropertyInfo::at_run_time(name, Kind::Scalar, "m").unwrap();
    let mut all: Vec<PropertyInfo> = PLAIN.into_iter().map(of).collect();
    all.extend([of("s").sum(), of("t").sum(), of("x").coordinate(), of("v").momentum_of("x")]);
    all
}
const SUMS: std::ops::Range<usize> = 5..7;
const STATES: std::ops::Range<usize> = 7..9;
const COUNT: usize = 9;

/// A law as the oracle sees it: sets of properties as bits.
#[derive(Clone, Copy, Debug, Default)]
struct Plan {
    reads: u32,
    sets: u32,
    adds: u32,
    rates: u32,
}

fn plan(random: &mut Random) -> Plan {
    let mut plan = Plan::default();
    for _ in 0..random.below(3) {
        plan.reads |= 1 << random.below(COUNT);
    }
    match random.below(4) {
        0 | 1 => plan.sets |= 1 << random.below(PLAIN.len()),
        2 => plan.adds |= 1 << (SUMS.start + random.below(SUMS.len())),
        _ => plan.rates |= 1 << (STATES.start + random.below(STATES.len())),
    }
    plan
}

fn law(name: &str, plan: Plan, domain: bool) -> DynLaw {
    let of = |bits: u32| properties().into_iter().enumerate().filter(move |(k, _)| bits >> k & 1 == 1).map(|(_, p)| p);
    let mut law = DynLaw::new(name);
    if domain {
        law = law.domain("rows");
    }
    law = of(plan.reads).fold(law, |law, property| law.reads(property));
    law = of(plan.sets).fold(law, |law, property| law.sets(property));
    law = of(plan.adds).fold(law, |law, property| law.adds(property));
    of(plan.rates).fold(law, |law, property| law.rates(property)).body(|_, out| out.fill(0.5))
}

/// The largest set of laws each of which has what it needs, given or set within the set; by trying all sets.
fn largest(laws: &[Plan], given: u32) -> u32 {
    let sums = SUMS.fold(0, |bits, k| bits | 1 << k);
    let supported = |set: u32| {
        let chosen = || laws.iter().enumerate().filter(move |(k, _)| set >> k & 1 == 1).map(|(_, law)| law);
        let made = chosen().fold(given, |bits, law| bits | law.sets);
        chosen().all(|law| law.reads & !(made | sums) == 0 && law.rates & !made == 0)
    };
    (0..1_u32 << laws.len()).filter(|set| supported(*set)).max_by_key(|set| set.count_ones()).unwrap()
}

/// Whether the laws contradict each other.
fn contradict(laws: &[Plan], given: u32) -> bool {
    let pairs = || (0..laws.len()).flat_map(|a| (0..laws.len()).map(move |b| (a, b)));
    let clash = pairs().any(|(a, b)| {
        let (one, other) = (laws[a], laws[b]);
        a < b && (one.sets & other.sets | one.rates & other.rates) != 0 || one.rates & (other.sets | other.adds) != 0
    });
    let overwrites = laws.iter().any(|law| (law.sets | law.adds) & given != 0);
    let mut before = vec![vec![false; laws.len()]; laws.len()];
    for (a, b) in pairs() {
        before[a][b] = laws[a].sets & (laws[b].adds | laws[b].reads) | laws[a].adds & laws[b].reads != 0;
    }
    for via in 0..laws.len() {
        for (a, b) in pairs() {
            before[a][b] |= before[a][via] && before[via][b];
        }
    }
    clash || overwrites || (0..laws.len()).any(|law| before[law][law])
}

#[test]
fn the_laws_that_run_are_those_of_an_independent_count() {
    let mut random = Random(7);
    let pool: Vec<Plan> = (0..120).map(|_| plan(&mut random)).collect();
    let compiled: Vec<DynLaw> = pool.iter().enumerate().map(|(k, p)| law(&format!("l{k}"), *p, k % 2 == 0)).collect();
    let (mut ran, mut refused, mut dormant) = (0, 0, 0);
    for scene in 0..10_000 {
        let given = random.next() as u32 & ((1 << COUNT) - 1) & if scene % 2 == 0 { u32::MAX } else { !0b111_1111 };
        let mut chosen: Vec<usize> = (0..1 + random.below(6)).map(|_| random.below(pool.len())).collect();
        chosen.sort_unstable();
        chosen.dedup();
        random.shuffle(&mut chosen);
        let mut rows = Domain::<f64>::new("rows").rows(2);
        for (_, property) in properties().into_iter().enumerate().filter(|(k, _)| given >> k & 1 == 1) {
            rows = rows.with(property, [1.0, 2.0]);
        }
        let mut builder = Engine::builder().domain(rows).integrator(RungeKutta4).step(0.1);
        for &law in &chosen {
            builder = builder.law(compiled[law].clone());
        }
        let plans: Vec<Plan> = chosen.iter().map(|&law| pool[law]).collect();
        let awake = largest(&plans, given);
        let active: Vec<Plan> =
            plans.iter().enumerate().filter(|(k, _)| awake >> k & 1 == 1).map(|(_, plan)| *plan).collect();
        match builder.build() {
            Err(faults) => {
                assert!(contradict(&active, given), "scene {scene} {plans:?} given {given:b}: {faults}");
                refused += 1;
            }
            Ok(mut engine) => {
                assert!(!contradict(&active, given), "scene {scene} {plans:?} given {given:b}\n{}", engine.report());
                for (k, law) in engine.report().laws.iter().enumerate() {
                    let runs = matches!(law.status, Status::Active { .. } | Status::Pruned { .. });
                    assert_eq!(runs, awake >> k & 1 == 1, "scene {scene} {plans:?} given {given:b}: {law}");
                    dormant += usize::from(!runs);
                }
                engine.advance(0.2).unwrap();
                ran += 1;
            }
        }
    }
    // The scenes are a mixture: none of the answers is rare.
    assert!(ran > 2000 && refused > 500 && dormant > 2000, "{ran} ran, {refused} refused, {dormant} dormant");
}

fn listed<P: Precision>(builder: Builder<P>, law: usize) -> Builder<P> {
    match law {
        0 => builder.law(Gravity::default()),
        1 => builder.law(Motion),
        2 => builder.law(Drag),
        3 => builder.law(Weight),
        4 => builder.law(Spring),
        5 => builder.law(Coulomb),
        6 => builder.law(Electric),
        7 => builder.law(Herd),
        8 => builder.law(Echo).law(Remember),
        9 => builder.law(Drag.label("more drag")),
        10 => builder.law(Recorder),
        _ => builder.law(Floor),
    }
}

fn hash<P: Precision>(laws: &[usize], rows: usize, seed: u64) -> u64 {
    let mut builder = Engine::<P>::builder()
        .domain(cloud(rows, seed))
        .domain(springs(rows))
        .field(ElectricField, |at: P::Vec3, time: P| at * time)
        .observe("bodies", Force)
        .step(0.01);
    builder = match seed % 3 {
        0 => builder.integrator(Leapfrog::default()),
        1 => builder.integrator(RungeKutta4),
        _ => builder.integrator(SemiImplicitEuler),
    };
    let mut engine = laws.iter().fold(builder, |builder, &law| listed(builder, law)).build().unwrap();
    engine.advance(0.05).unwrap();
    engine.state().hash()
}

#[test]
fn the_order_of_the_list_does_not_change_a_bit() {
    let mut random = Random(11);
    for scene in 0..300 {
        let mut laws: Vec<usize> = (0..12).filter(|law| *law == 1 || random.coin()).collect();
        let rows = 1 + random.below(40);
        let same = |laws: &[usize]| {
            if scene % 2 == 0 { hash::<f64>(laws, rows, scene) } else { hash::<f32>(laws, rows, scene) }
        };
        let first = same(&laws);
        for _ in 0..3 {
            random.shuffle(&mut laws);
            assert_eq!(same(&laws), first, "scene {scene}, laws {laws:?}");
        }
    }
}
