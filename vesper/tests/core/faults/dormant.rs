//! Why laws sleep, and when that is a mistake.

use super::*;

#[test]
fn what_a_law_sleeps_for() {
    let report = |builder: Builder<f64>, law: &str| builder.build().unwrap().report().law(law).unwrap().to_string();
    let few = || Domain::new("bodies").with(Position, [[0.0; 3]]).with(Velocity, [[0.0; 3]]);
    let misspelt = PropertyInfo::new("mas", Kind::Scalar, "kg");
    let thread = || Domain::new("springs").with(Stiffness, [1.0]).with(RestLength, [1.0]);
    check(&[
        (
            report(engine().domain(few()).law(Gravity::default()), "gravity"),
            "gravity is dormant: it reads mass [kg], which domain bodies does not have: add mass",
        ),
        (
            report(engine().domain(few().with(misspelt, [1.0])).law(Motion), "motion"),
            "motion is dormant: it reads mass [kg], which domain bodies does not have; there is mas: rename it, or add mass",
        ),
        (
            report(engine().domain(few()).law(Motion).law(Inertia), "motion"),
            "motion is dormant: it reads mass [kg], which domain bodies does not have: add mass, or what inertia lacks, which would set it",
        ),
        (
            report(engine().domain(few()).law(Motion).law(Inertia), "inertia"),
            "inertia is dormant: it reads rest_mass [kg], which domain bodies does not have: add rest_mass",
        ),
        (
            report(engine().domain(thread()).law(Spring), "spring"),
            "spring is dormant: it follows ends, which domain springs does not have: add ends",
        ),
        (
            report(engine().domain(few()).law(Spring), "spring"),
            "spring is dormant: it stands on domain springs, which the state does not have: add domain springs",
        ),
        (
            report(engine().domain(few()).domain(Domain::new("spring").rows(1)).law(Spring), "spring"),
            "spring is dormant: it stands on domain springs, which the state does not have; there is spring: rename it, or add domain springs",
        ),
        (
            report(engine().law(Motion), "motion"),
            "motion is dormant: it stands on a domain of rows, which the state does not have: add a domain of rows",
        ),
        (
            report(engine().domain(few().with(Charge, [1.0])).law(Electric), "electric"),
            "electric is dormant: it reads electric_field [V/m], which the list of fields does not have: add electric_field",
        ),
        (
            report(
                engine().domain(few().with(Charge, [1.0])).field(MagneticField, Boxes::default()).law(Electric),
                "electric",
            ),
            "electric is dormant: it reads electric_field [V/m], which the list of fields does not have: add electric_field",
        ),
        (
            report(
                engine()
                    .domain(Domain::new("b").with(Charge, [1.0]))
                    .field(ElectricField, Boxes::default())
                    .law(Electric),
                "electric",
            ),
            "electric is dormant: it samples fields at position [m], which domain b does not have: add position",
        ),
        (
            report(
                engine().domain(few()).law(DynLaw::new("fall").scene(GravityAcceleration).adds(Force).body(|_, _| {})),
                "fall",
            ),
            "fall is dormant: it reads gravity [m/s^2], which the scene does not have: add gravity",
        ),
        (
            report(engine().domain(Domain::new("bodies").with(Cooling, [1.0])).law(Cool), "cool"),
            "cool is dormant: it reads temperature [K], which domain bodies does not have: add temperature",
        ),
        (report(moving().law(Weight.off()), "weight"), "weight is off"),
        (
            report(engine().domain(bodies()).law(Weight), "weight"),
            "weight is pruned: neither the integrator nor an observer needs bodies.force; 3 rows saved per evaluation",
        ),
        (report(moving(), "motion"), "motion is active on 3 rows of bodies"),
        (
            built(engine().domain(few()).law(Motion).strict()),
            "motion must run, but is dormant: it reads mass [kg], which domain bodies does not have: add mass",
        ),
        (
            built(engine().domain(few()).law(Motion.required())),
            "motion must run, but is dormant: it reads mass [kg], which domain bodies does not have: add mass",
        ),
        (
            built(engine().domain(few()).require("motion").law(Motion)),
            "motion must run, but is dormant: it reads mass [kg], which domain bodies does not have: add mass",
        ),
        (
            built(
                engine()
                    .domain(
                        Domain::new("bodies")
                            .with(Position, Vec::<[f64; 3]>::new())
                            .with(Velocity, Vec::<[f64; 3]>::new())
                            .with(Mass, Vec::<f64>::new()),
                    )
                    .law(Motion)
                    .strict(),
            ),
            "motion stands on domain bodies, which has no rows: add rows, or take the law away",
        ),
    ]);
}
