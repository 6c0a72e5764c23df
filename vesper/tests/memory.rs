//! The unsafe parts with few rows, for Miri:
//! `MIRIFLAGS=-Zmiri-ignore-leaks cargo +nightly miri test -p vesper --no-default-features --test memory`
//!
//! Names and declarations made at run time are kept for the life of the program on purpose, hence the flag.

#[path = "core/common.rs"]
mod common;

use common::*;
use vesper::prelude::*;
use vesper::real::Isa;

/// More than the lanes of the baseline, and not a multiple, so that rows are left for the scalar loop.
const ROWS: usize = 5;

fn sets() -> Vec<Isa> {
    // Miri has no instructions beyond the baseline.
    Isa::available().into_iter().take(2).collect()
}

fn bodies() -> Domain<f64> {
    let state = State::new([cloud::<f64>(ROWS, 1)], []).unwrap();
    let of = |property: PropertyInfo| Values::new(property.kind.width(), state.numbers("bodies", property).unwrap());
    let all = [Position.info(), Velocity.info(), Mass.info(), DragCoefficient.info(), ExternalForce.info()];
    let domain = all.into_iter().fold(Domain::new("bodies"), |domain, property| domain.with(property, of(property)));
    domain.subset(Charge, [3, 1, 4], [1.0, 2.0, 3.0])
}

/// Few laws of every shape: whatever is made for a law is made anew for each test, which is slow here.
fn shapes(builder: Builder<f64>) -> Builder<f64> {
    let builder = builder.domain(springs(ROWS)).step(0.01).field(ElectricField, |at: DVec3, time: f64| at * time);
    builder.law(Gravity::default()).law(Electric).law(Spring).law(Herd).law(Motion).isa(Isa::Scalar)
}

#[test]
fn kernels_of_all_shapes_in_all_lanes() {
    let hashes: Vec<u64> = sets()
        .into_iter()
        .map(|isa| {
            let mut engine = shapes(Engine::builder().domain(bodies())).isa(isa).build().unwrap();
            engine.advance(0.01).unwrap();
            engine.energy().unwrap();
            engine.state().hash()
        })
        .collect();
    assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{hashes:?}");
}

#[test]
fn laws_that_are_held_look_back_and_amend() {
    let builder = Engine::<f64>::builder().domain(bodies()).step(0.01).isa(Isa::Scalar).observe("bodies", Trace);
    let builder = builder.law(Weight).law(Drag.every(2)).law(Motion).law(Floor).law(Remember).law(Recorder);
    let mut engine = builder.integrator(RungeKutta4).build().unwrap();
    engine.advance(0.02).unwrap();
}

#[test]
fn lent_memory_vectors_and_raw() {
    let start = State::new([bodies()], []).unwrap();
    let rows = |property: &str| -> Vec<[f64; 3]> {
        let column = start.column("bodies", property).unwrap().components().unwrap();
        (0..ROWS).map(|row| core::array::from_fn(|c| column[c][row])).collect()
    };
    let position = Lent::new(rows("position"));
    let mut velocity = rows("velocity");
    let memory = std::ptr::NonNull::new(velocity.as_mut_ptr()).unwrap();
    // SAFETY: the vector outlives the engine, and is looked at only after it is gone.
    let raw = unsafe { Lent::from_raw(memory, ROWS) };
    let domain = Domain::new("bodies")
        .lend(Position, &position)
        .lend(Velocity, &raw)
        .with(Mass, vec![1.5; ROWS])
        .subset(Charge, [0, 4], [1.0, -1.0]);
    let mut engine = shapes(Engine::builder().domain(domain)).build().unwrap();
    engine.advance(0.01).unwrap();
    position.write()[3][1] += 0.5;
    engine.state_mut();
    engine.advance(0.01).unwrap();
    let saved = engine.checkpoint().unwrap();
    engine.advance(0.01).unwrap();
    engine.restore(&saved).unwrap();
    engine.advance(0.01).unwrap();
    assert_eq!(engine.state().get("bodies", Position, 3).unwrap().to_array(), position.read()[3]);
    assert_ne!(velocity, rows("velocity"));
}

#[test]
fn composed_laws() {
    let run = |composed: bool| {
        let builder = Engine::<f64>::builder().domain(bodies()).step(0.01).integrator(SemiImplicitEuler);
        let builder = match composed {
            true => builder.laws(pipeline![Weight, Drag, Motion]),
            false => builder.law(Weight).law(Drag).law(Motion),
        };
        let mut engine = builder.isa(Isa::Baseline).build().unwrap();
        engine.advance(0.02).unwrap();
        assert_eq!(engine.explain().contains("one loop composed at compile time"), composed);
        engine.state().hash()
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn rows_and_columns_come_and_go() {
    let builder = Engine::<f64>::builder().domain(bodies()).domain(springs(ROWS)).step(0.01).isa(Isa::Scalar);
    let mut engine = builder.law(Coulomb).law(Spring).law(Motion).observe("bodies", Force).build().unwrap();
    engine.advance(0.01).unwrap();
    let more = Domain::new("bodies")
        .with(Position, [[5.0; 3], [6.0; 3]])
        .with(Velocity, [[0.0; 3]; 2])
        .with(Mass, [1.0; 2])
        .with(DragCoefficient, [1.0; 2])
        .with(ExternalForce, [[0.0; 3]; 2])
        .subset(Charge, [1], [4.0]);
    engine.state_mut().add_rows(more).unwrap();
    engine.advance(0.01).unwrap();
    engine.state_mut().remove_rows("bodies", &[0, 4, 6]).unwrap();
    engine.state_mut().remove_column("bodies", ExternalForce).unwrap();
    engine.advance(0.01).unwrap();
    let copy = engine.state().clone();
    *engine.state_mut() = copy;
    let rows = engine.state().domain("bodies").unwrap().rows();
    engine.state_mut().remove_rows("bodies", &(0..rows).collect::<Vec<_>>()).unwrap();
    engine.advance(0.01).unwrap();
    assert_eq!(engine.state().domain("springs").unwrap().rows(), 0);
}

#[test]
fn a_law_made_at_run_time_and_f32() {
    let lift = DynLaw::new("lift").reads(Velocity).scene(GravityAcceleration).field(ElectricField).adds(Force);
    let lift = lift.body(|row, force| force[2] = row[0] + row[5] + row[6]);
    let builder = Engine::<f32>::builder().domain(cloud(3, 2)).step(0.01).law(lift).law(Motion);
    let builder = builder.field(ElectricField, Uniform { value: [1.0; 3] });
    let mut engine = builder.constant(GravityAcceleration, [[0.0, 0.0, -1.0]]).isa(Isa::Scalar).build().unwrap();
    engine.advance(0.01).unwrap();
    assert!(engine.state().get("bodies", Position, 0).unwrap().z.is_finite());
}

#[test]
fn blow_ups_are_traced() {
    let builder = Engine::<f64>::builder().domain(bodies()).law(Motion).law(Weight).step(0.01).isa(Isa::Scalar);
    let mut engine = builder.build().unwrap();
    engine.trace_blow_ups(true);
    engine.state_mut().set("bodies", Mass, 2, 0.0).unwrap();
    assert!(engine.advance(0.03).is_err());
}

/// x'' = -x.
#[derive(Law, Clone, Copy, Debug)]
#[law(
    reads(position: Position, velocity: Velocity),
    rates(position: Position from (velocity), velocity: Velocity from (position)),
    second_order
)]
struct Swing;

#[kernel]
impl<R: Real> RowLaw<R> for Swing {
    fn row(&self, row: SwingRow<R>) -> SwingOutput<R> {
        SwingOutput { position: row.velocity, velocity: -row.position }
    }
}

#[test]
fn sums_of_short_long_and_lent_vectors() {
    // Short ones are one array; 70 numbers are more than 512 bytes, and stand apart.
    for rows in [3, 70] {
        let places: Vec<[f64; 3]> = (0..rows).map(|row| [1.0, f64::from(row), -0.5]).collect();
        let velocities = vec![[0.0, 1.0, 0.5]; places.len()];
        let (lent_places, lent_velocities) = (Lent::new(places.clone()), Lent::new(velocities.clone()));
        for lent in [false, true] {
            let domain = match lent {
                false => Domain::new("bodies").with(Position, places.clone()).with(Velocity, velocities.clone()),
                true => Domain::new("bodies").lend(Position, &lent_places).lend(Velocity, &lent_velocities),
            };
            let builder = Engine::<f64>::builder().domain(domain).law(Swing).isa(Isa::Baseline).step(0.25);
            let mut engine = match rows {
                3 => builder.integrator(GaussRadau15::default()),
                _ => builder.integrator(Symplectic4::default()).compensated(),
            }
            .build()
            .unwrap();
            engine.advance(0.25).unwrap();
            let x = engine.state().get("bodies", Position, 0).unwrap().x;
            assert!((x - 0.25_f64.cos()).abs() < 1e-6, "{x}");
        }
    }
}

property! {
    /// Height above the ground.
    pub Height: Scalar, "m", switch;
    /// Where a row was headed when the step began.
    pub Heading: Vector, "1", switch;
}

/// Ground at z = 0, and a field that pushes.
#[derive(Law, Clone, Copy, Debug)]
#[law(
    reads(position: Position, velocity: Velocity, previous held: Height, previous heading: Heading),
    fields(push: ElectricField),
    sets(height: Height, now: Heading),
    adds(force: Force)
)]
struct Ground;

#[kernel]
impl<R: Real> RowLaw<R> for Ground {
    fn row(&self, row: GroundRow<R>) -> GroundOutput<R> {
        let height = row.position.z();
        let up = R::Vec3::new(R::lit(0.0), R::lit(0.0), R::lit(-400.0) * height);
        let force = R::select_vector(row.held.less(R::lit(0.0)), up, R::Vec3::zero());
        GroundOutput { height, now: row.velocity, force: force + row.push + row.heading * R::lit(0.0) }
    }
}

#[test]
fn steps_that_are_taken_again_to_a_jump() {
    let domain =
        Domain::new("bodies").with(Position, [[0.24, 0.0, 0.5]]).with(Velocity, [[1.0, 0.0, -0.5]]).with(Mass, [1.0]);
    let part = FieldBox { min: [0.0; 3], max: [0.25, 1.0, 1.0], value: [0.5, 0.0, 0.0] };
    let builder = Engine::<f64>::builder().domain(domain).field(ElectricField, Boxes { boxes: vec![part] });
    let builder = builder.law(Ground).law(Motion).isa(Isa::Scalar).step(0.015).compensated();
    let mut engine = builder.integrator(SemiImplicitEuler).build().unwrap();
    engine.advance(0.015).unwrap();
    // It leaves the box after 0.01 s.
    assert!(engine.state().get("bodies", Position, 0).unwrap().x > 0.25);
    assert!(engine.evaluations() > 6, "{}", engine.evaluations());
}

/// Attraction whose pairs may be estimated, looked at once, and summed from far away.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position, mass: Mass), adds(force: Force), antisymmetric, estimates)]
struct Attraction<R = f64> {
    /// Constant of gravitation.
    #[law(unit = "m^3 kg^-1 s^-2", default = 1.0)]
    g: R,
    /// Softening length.
    #[law(unit = "m", default = 0.125)]
    softening: R,
}

#[kernel]
impl<R: Real> PairLaw<R> for Attraction<R> {
    fn pair(&self, i: AttractionRow<R>, j: AttractionRow<R>) -> R::Vec3 {
        let d = j.position - i.position;
        d * (self.g * i.mass * j.mass).over_root_cubed(d.length_squared() + self.softening * self.softening)
    }

    fn inverse_square(&self, row: AttractionRow<R>) -> InverseSquare<R> {
        InverseSquare { source: row.mass, response: self.g * row.mass, softening: self.softening }
    }
}

/// Repulsion that ends at a distance.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position), adds(force: Force), translation_invariant, estimates)]
struct Repulsion<R = f64> {
    /// Strength.
    #[law(unit = "N/m", default = 1.0)]
    strength: R,
    /// Distance at which it ends.
    #[law(unit = "m", default = 0.5, cutoff)]
    cutoff: R,
}

#[kernel]
impl<R: Real> PairLaw<R> for Repulsion<R> {
    fn pair(&self, i: RepulsionRow<R>, j: RepulsionRow<R>) -> R::Vec3 {
        (i.position - j.position) * self.strength
    }
}

/// One step of a law on so many rows in a cube of edge 2, whose pairs are found in this way.
fn one_step<P: Precision>(rows: usize, way: &str, law: impl Fn(Builder<P>) -> Builder<P>) {
    let builder = Engine::<P>::builder().domain(cloud::<P>(rows, 1)).law(Motion).integrator(SemiImplicitEuler);
    let mut engine = law(builder).step(0.01).isa(Isa::Scalar).build().unwrap();
    assert!(engine.explain().contains(way), "{}", engine.explain());
    engine.advance(0.01).unwrap();
}

#[test]
fn pairs_that_are_looked_at_once() {
    // Blocks that meet, and rows that fill no strip; with more, Miri would take half an hour.
    one_step::<f32>(if cfg!(miri) { 197 } else { 581 }, "each pair once", |builder| builder.law(Attraction::default()));
}

#[test]
fn pairs_from_lists_of_a_periodic_box() {
    one_step::<f64>(70, "lists of neighbours", |builder| {
        builder.law(Repulsion::default()).constant(PeriodicBox, [[2.0; 3]])
    });
}

#[test]
#[cfg_attr(miri, ignore = "as many rows as far fields pay for take Miri half an hour")]
fn pairs_of_far_rows() {
    one_step::<f32>(520, "far ones together", |builder| builder.law(Attraction::default().far_field(0.5)));
}
