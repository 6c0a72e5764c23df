//! Laws that reach further than to their own row: constants that laws compute, columns, links, held shares.

use super::*;

property! {
    /// Shares of a spring's ends, counted on the spring.
    Tension: Scalar, "N", sum;
}

#[test]
fn a_constant_of_the_scene_may_be_computed_by_a_law_of_the_scene() {
    let season = DynLaw::new("season").domain("scene").reads(Time).sets(GravityAcceleration);
    let season = season.body(|time, gravity| gravity.copy_from_slice(&[0.0, 1.0 + time[0], 0.0]));
    let builder = Engine::<f64>::builder().domain(one()).law(season).law(Weight).law(Motion).step(1.0);
    let mut engine = builder.integrator(SemiImplicitEuler).build().unwrap();
    engine.advance(3.0).unwrap();
    assert_eq!(speed(&engine, 0), DVec3::new(0.0, 6.0, 0.0));
}

/// Motion as a law over whole columns.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(velocity: Velocity, force: Force, mass: Mass),
      rates(position: Position from (velocity), velocity: Velocity from (force, mass)))]
struct ColumnMotion;

#[kernel]
impl<P: Precision> ColumnLaw<P> for ColumnMotion {
    fn columns(&self, mut columns: ColumnMotionColumns<'_, P>) {
        for row in 0..columns.mass.len() {
            columns.position.set(row, columns.velocity.get(row));
            columns.velocity_rate.set(row, columns.force.get(row) / columns.mass.get(row));
        }
    }
}

#[test]
fn a_law_over_columns_may_give_rates_under_any_integrator() {
    let start = || Engine::<f64>::builder().domain(cloud(5, 6)).law(Gravity::default()).step(0.01);
    for integrator in 0..3 {
        let run = |builder: Builder<f64>| {
            let builder = match integrator {
                0 => builder,
                1 => builder.integrator(RungeKutta4),
                _ => builder.integrator(SemiImplicitEuler),
            };
            let mut engine = builder.build().unwrap();
            engine.advance(0.2).unwrap();
            engine.state().hash()
        };
        assert_eq!(run(start().law(ColumnMotion)), run(start().law(Motion)), "integrator {integrator}");
    }
}

/// Counts the ends of springs, on the springs.
#[derive(Law, Clone, Copy, Debug)]
#[law(domain = "springs", reads(stiffness: Stiffness), link(ends: Ends), adds(tension: Tension))]
struct Strain;

#[kernel]
impl<P: Precision> ColumnLaw<P> for Strain {
    fn columns(&self, mut columns: StrainColumns<'_, P>) {
        for row in 0..columns.stiffness.len() {
            columns.tension.add(row, columns.stiffness.get(row));
        }
    }
}

#[test]
fn held_shares_of_a_law_that_follows_links_are_as_long_as_what_it_adds_to() {
    let links: Vec<[u32; 2]> = (0..50).map(|k| [k % 3, (k + 1) % 3]).collect();
    let springs = Domain::new("springs").link(Ends, "bodies", links).with(Stiffness, vec![2.0; 50]);
    let springs = springs.with(RestLength, vec![0.5; 50]);
    let builder = Engine::<f64>::builder().domain(cloud(3, 4)).domain(springs).law(Spring).law(Motion).step(0.001);
    let mut engine = builder.law(Strain.every(2)).observe("springs", Tension).build().unwrap();
    engine.advance(0.005).unwrap();
    assert_eq!(engine.state().values("springs", Tension).unwrap(), vec![2.0; 50]);
}

/// A drift against the place, which leapfrog's plain drift would take by Euler's rule.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(angle: Angle, spin: Spin), rates(angle: Angle from (angle, spin), spin: Spin from (spin)))]
struct Creep;

#[kernel]
impl<R: Real> RowLaw<R> for Creep {
    fn row(&self, row: CreepRow<R>) -> CreepOutput<R> {
        CreepOutput { angle: row.spin - row.angle, spin: R::lit(0.0) }
    }
}

#[test]
fn leapfrog_keeps_its_order_where_coordinates_depend_on_coordinates() {
    let error = |step: f64| {
        let domain = Domain::new("wheels").with(Angle, [1.0]).with(Spin, [0.5]);
        let mut engine = Engine::<f64>::builder().domain(domain).law(Creep).step(step).build().unwrap();
        assert!(engine.explain().contains("the drift is a midpoint step"));
        engine.advance(1.0).unwrap();
        (engine.state().get("wheels", Angle, 0).unwrap() - (0.5 + 0.5 * (-1.0_f64).exp())).abs()
    };
    let order = (error(0.02) / error(0.01)).log2();
    assert!((order - 2.0).abs() < 0.1, "{order}");
}

#[test]
fn a_chain_whose_laws_differ_in_a_constants_default_runs_them_one_by_one() {
    /// Weight on another planet, unless the scene says where.
    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(mass: Mass), scene(gravity: GravityAcceleration = [0.0, 3.0, 0.0]), adds(force: Force))]
    struct Elsewhere;

    #[kernel]
    impl<R: Real> RowLaw<R> for Elsewhere {
        fn row(&self, row: ElsewhereRow<R>) -> R::Vec3 {
            row.gravity * row.mass
        }
    }

    let run = |builder: Builder<f64>| {
        let mut engine = builder.build().unwrap();
        engine.advance(0.1).unwrap();
        engine.state().hash()
    };
    let start = || Engine::<f64>::builder().domain(cloud(9, 6)).integrator(SemiImplicitEuler).step(0.01);
    let listed = run(start().law(Elsewhere).law(Weight).law(Motion));
    assert_eq!(run(start().laws(pipeline![Elsewhere, Weight, Motion])), listed);
}

#[test]
fn a_constant_that_a_law_computes_is_not_the_clients_to_set() {
    let season = DynLaw::new("season").domain("scene").reads(Time).sets(GravityAcceleration);
    let season = season.body(|_, gravity| gravity.fill(1.0));
    let builder = Engine::<f64>::builder().domain(one()).law(season).law(Weight).law(Motion).step(1.0);
    let mut engine = builder.observe("scene", GravityAcceleration).build().unwrap();
    engine.state_mut().set_constant(GravityAcceleration, [[0.0, 0.0, 2.0]]).unwrap();
    assert_eq!(
        engine.advance(1.0).unwrap_err().to_string(),
        "season sets scene.gravity, which the client gives: take the column away, or switch season off"
    );
}
