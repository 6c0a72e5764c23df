//! Jumps of laws and fields: steps end at them, so that each integrator keeps its order.

use vesper::prelude::*;
use vesper_laws::reference::{Problem, Spectrograph};
use vesper_laws::{ContactPlane, Motion, UniformGravity};

/// The largest distance of the six ions from their landing points, in m, each at its own time.
fn missed(integrator: impl Integrator + Clone + 'static, step: f64, located: bool) -> f64 {
    let mut worst = 0.0;
    for (row, landing) in Spectrograph.landings().into_iter().enumerate() {
        let mut builder = Spectrograph.setup(Engine::<f64>::builder());
        if !located {
            // The same fields as functions, of which nobody knows where they jump.
            let inside = |at: DVec3| (-50.0..50.0).contains(&at.x) && (-100.0..0.0).contains(&at.y);
            let electric = move |at: DVec3, _: f64| if inside(at) { DVec3::Y * 0.5 } else { DVec3::ZERO };
            let beyond = |at: DVec3| (-1000.0..1000.0).contains(&at.x) && at.y >= 0.0;
            let magnetic = move |at: DVec3, _: f64| if beyond(at) { DVec3::Z * 0.02 } else { DVec3::ZERO };
            let bodies = Domain::new("bodies")
                .with(Position, [[0.0, -100.0, 0.0]; 6])
                .with(Velocity, [[0.0; 3]; 6])
                .with(Mass, Spectrograph::MASSES)
                .with(Charge, Spectrograph::CHARGES);
            builder = Engine::builder()
                .domain(bodies)
                .field(ElectricField, electric)
                .field(MagneticField, magnetic)
                .law(vesper_laws::ElectricForce)
                .law(vesper_laws::MagneticForce)
                .law(Motion);
        }
        let mut engine = builder.integrator(integrator.clone()).build().unwrap();
        let steps = (landing.time / step).ceil();
        match integrator.is_adaptive() {
            true => engine.advance(landing.time).unwrap(),
            false => engine.steps_of(steps as u64, landing.time / steps).unwrap(),
        }
        let place: DVec3 = engine.state().get("bodies", Position, row).unwrap();
        worst = f64::max(worst, (place - DVec3::X * landing.x).length());
    }
    worst
}

#[test]
fn six_ions_land_where_they_should() {
    let adaptive = missed(DormandPrince8::new(Tolerance::relative(1e-13)), 0.0, true);
    let radau = missed(GaussRadau15::default(), 0.0, true);
    let fixed = missed(RungeKutta4, 1e-3, true);
    println!("dormand_prince_8 {adaptive:.1e} m, gauss_radau_15 {radau:.1e} m, runge_kutta_4 {fixed:.1e} m");
    assert!(adaptive < 1e-9 && radau < 1e-9 && fixed < 1e-9);
}

#[test]
fn fixed_steps_keep_their_order_at_a_jump_that_is_known_and_lose_it_at_one_that_is_not() {
    let order = |located: bool| {
        // Over a decade, since what a step across a jump leaves depends on where in the step the jump is.
        let [coarse, fine] = [0.02, 0.002].map(|step| missed(RungeKutta4, step, located));
        println!("located: {located}; {coarse:.1e} m, {fine:.1e} m");
        (coarse / fine).log10()
    };
    let (located, not) = (order(true), order(false));
    assert!(located > 3.7, "{located}");
    assert!((0.5..1.5).contains(&not), "{not}");
}

/// A ball on a floor, and between two walls.
fn ball(builder: Builder<f64>) -> Builder<f64> {
    let plane = |normal: DVec3, offset: f64| ContactPlane {
        normal,
        offset,
        stiffness: 4e4,
        damping: 20.0,
        friction: 0.0,
        resting_speed: 1e-6,
    };
    let ball = Domain::new("balls")
        .with(Position, [[0.0, 0.0, 1.0], [0.3, 0.0, 0.5]])
        .with(Velocity, [[1.0, 0.0, 0.0], [-2.0, 0.0, 0.0]])
        .with(Mass, [1.0, 2.0]);
    builder
        .domain(ball)
        .constant(GravityAcceleration, [[0.0, 0.0, -9.81]])
        .law(UniformGravity)
        .law(plane(DVec3::Z, 0.0).label("floor"))
        .law(plane(DVec3::X, -0.5).label("left"))
        .law(plane(DVec3::NEG_X, -0.5).label("right"))
        .law(Motion)
}

fn places(engine: &Engine<f64>) -> Vec<f64> {
    engine.state().numbers("balls", Position).unwrap()
}

#[test]
fn several_planes_have_a_switch_each() {
    let run = |integrator: Box<dyn Integrator>, step: f64| {
        let mut engine = ball(Engine::builder()).boxed_integrator(integrator).step(step).build().unwrap();
        engine.advance(1.5).unwrap();
        places(&engine)
    };
    let exact = run(Box::<GaussRadau15>::default(), 1e-3);
    let errors = [4e-4, 2e-4].map(|step| {
        let found = run(Box::new(RungeKutta4), step);
        found.iter().zip(&exact).map(|(found, exact)| (found - exact).abs()).fold(0.0, f64::max)
    });
    let order = (errors[0] / errors[1]).log2();
    println!("{errors:?} {order}");
    assert!(errors[1] < 1e-7 && order > 3.5, "{errors:?}");
}

#[test]
fn steps_that_go_across_jumps_say_so_and_are_not_cut() {
    let engine = |builder: Builder<f64>| ball(builder).integrator(Leapfrog::default()).step(1e-3).build().unwrap();
    let (mut cut, mut across) = (engine(Engine::builder()), engine(Engine::builder().across_jumps()));
    let planes = "jumps of balls.floor_gap, balls.floor_sliding, balls.left_gap";
    assert!(cut.explain().contains(&format!("steps end at {planes}")), "{}", cut.explain());
    assert!(across.explain().contains(&format!("steps go across {planes}")), "{}", across.explain());
    cut.steps_of(900, 1e-3).unwrap();
    across.steps_of(900, 1e-3).unwrap();
    // Two in each step, since damping depends on velocities; a look at the end of each where steps are cut.
    assert!(across.evaluations() <= 1802 && cut.evaluations() > 2700);
    // The balls have bounced all the same.
    let far = places(&across).iter().zip(places(&cut)).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
    assert!(far > 1e-9 && far < 0.05, "{far}");
}

#[test]
fn a_run_with_switches_goes_on_from_a_checkpoint_as_if_it_had_not_stopped() {
    let engine = || ball(Engine::builder()).integrator(Leapfrog::default()).step(1e-3).build().unwrap();
    let (mut whole, mut half, mut rest) = (engine(), engine(), engine());
    whole.steps_of(900, 1e-3).unwrap();
    // In the middle of a touch of the floor.
    half.steps_of(455, 1e-3).unwrap();
    assert!(places(&half)[2] < 0.0, "{:?}", places(&half));
    rest.restore(&half.checkpoint().unwrap()).unwrap();
    rest.steps_of(445, 1e-3).unwrap();
    assert_eq!(places(&whole), places(&rest));
}

#[test]
fn many_rows_on_many_threads_turn_alike() {
    let rows = 5000;
    let run = |backend: Backend, threads: usize| {
        let place = |row: usize| [0.0, 0.0, 0.5 + 1e-4 * row as f64];
        let bodies = Domain::new("balls")
            .with(Position, (0..rows).map(place).collect::<Vec<_>>())
            .with(Velocity, vec![[1.0, 0.0, 0.0]; rows])
            .with(Mass, vec![1.0; rows]);
        let floor = ContactPlane {
            normal: DVec3::Z,
            offset: 0.0,
            stiffness: 1e4,
            damping: 0.0,
            friction: 0.3,
            resting_speed: 1e-6,
        };
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .constant(GravityAcceleration, [[0.0, 0.0, -9.81]])
            .law(UniformGravity)
            .law(floor)
            .law(Motion)
            .backend(backend)
            .threads(threads)
            .step(5e-3)
            .build()
            .unwrap();
        engine.steps_of(70, 5e-3).unwrap();
        places(&engine)
    };
    assert_eq!(run(Backend::Cpu, 1), run(Backend::Parallel, 2));
}
