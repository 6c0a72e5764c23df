//! Integrators by their names in scenes.

use vesper::prelude::*;

use vesper_laws::WisdomHolman;

use crate::fault::help_for;

/// What a scene says for an option: its name, and what it is where the scene does not say.
pub type Ask<'a> = &'a dyn Fn(&str, f64) -> f64;

/// An integrator that a scene can name.
#[derive(Clone, Copy, Debug)]
pub struct NamedIntegrator {
    /// Its name.
    pub name: &'static str,
    /// What it is, in a line.
    pub about: &'static str,
    /// The options that a scene can give it.
    pub options: &'static [&'static str],
    /// Makes one.
    pub make: fn(Ask<'_>) -> Box<dyn Integrator>,
}

/// All integrators.
pub const INTEGRATORS: &[NamedIntegrator] = &[
    NamedIntegrator {
        name: AUTO,
        about: "what the structure of the laws suggests: gauss_radau_15 mostly, respa or leapfrog with `every`",
        options: &["precision"],
        make: |option| Box::new(Auto::new(option("precision", Auto::default().precision))),
    },
    NamedIntegrator {
        name: "explicit_euler",
        about: "order 1, one evaluation per step; a yardstick",
        options: &[],
        make: |_| Box::new(ExplicitEuler),
    },
    NamedIntegrator {
        name: "semi_implicit_euler",
        about: "order 1, one evaluation per step, symplectic",
        options: &[],
        make: |_| Box::new(SemiImplicitEuler),
    },
    NamedIntegrator {
        name: "midpoint",
        about: "order 2, two evaluations per step",
        options: &[],
        make: |_| Box::new(Midpoint),
    },
    NamedIntegrator {
        name: "leapfrog",
        about: "order 2, one evaluation per step, symplectic (the default)",
        options: &[],
        make: |_| Box::new(Leapfrog::default()),
    },
    NamedIntegrator {
        name: "drift_kick_drift",
        about: "leapfrog, drift first: order 2, one evaluation per step, symplectic",
        options: &[],
        make: |_| Box::new(DriftKickDrift),
    },
    NamedIntegrator {
        name: "runge_kutta_4",
        about: "order 4, four evaluations per step",
        options: &[],
        make: |_| Box::new(RungeKutta4),
    },
    NamedIntegrator {
        name: "symplectic_4",
        about: "order 4, six evaluations per step, symplectic",
        options: &[],
        make: |_| Box::new(Symplectic4::default()),
    },
    NamedIntegrator {
        name: "symplectic_6",
        about: "order 6, ten or eleven evaluations per step, symplectic",
        options: &[],
        make: |_| Box::new(Symplectic6::default()),
    },
    NamedIntegrator {
        name: "symplectic_8",
        about: "order 8, seventeen evaluations per step, symplectic",
        options: &[],
        make: |_| Box::new(Symplectic8::default()),
    },
    NamedIntegrator {
        name: "respa",
        about: "order 2, slow laws kick for all steps of their `every` at once, symplectic",
        options: &[],
        make: |_| Box::new(Respa::default()),
    },
    NamedIntegrator {
        name: "boris",
        about: "order 2, one evaluation per step, turns velocities in magnetic fields",
        options: &[],
        make: |_| Box::new(Boris::default()),
    },
    NamedIntegrator {
        name: "higuera_cary",
        about: "order 2, one evaluation per step, as boris for fast charges",
        options: &[],
        make: |_| Box::new(HigueraCary::default()),
    },
    NamedIntegrator {
        name: "boris_8",
        about: "order 8, seventeen evaluations per step, turns velocities in magnetic fields",
        options: &[],
        make: |_| Box::new(Boris8::default()),
    },
    NamedIntegrator {
        name: "dormand_prince_5",
        about: "order 5, adaptive, six evaluations per step",
        options: &["rtol", "atol"],
        make: |option| Box::new(DormandPrince5::new(tolerance(option, DormandPrince5::default().tolerance))),
    },
    NamedIntegrator {
        name: "dormand_prince_8",
        about: "order 8, adaptive, twelve evaluations per step",
        options: &["rtol", "atol"],
        make: |option| Box::new(DormandPrince8::new(tolerance(option, DormandPrince8::default().tolerance))),
    },
    NamedIntegrator {
        name: "nystrom_12",
        about: "order 12, adaptive, seventeen evaluations per step, for forces that do not depend on velocities",
        options: &["rtol", "atol"],
        make: |option| Box::new(Nystrom12::new(tolerance(option, Nystrom12::default().tolerance))),
    },
    NamedIntegrator {
        name: "gauss_radau_15",
        about: "order 15, adaptive, to rounding, seven evaluations in each round of a step",
        options: &["precision"],
        make: |option| Box::new(GaussRadau15::new(option("precision", GaussRadau15::default().precision))),
    },
    NamedIntegrator {
        name: "wisdom_holman",
        about: "Kepler splitting for a dominant mass: order 2, one evaluation per step, symplectic",
        options: &["g", "corrector"],
        make: |option| Box::new(wisdom_holman(option, WisdomHolman::new())),
    },
    NamedIntegrator {
        name: "wisdom_holman_high",
        about: "Kepler splitting, corrected: order 4, two evaluations per step, symplectic",
        options: &["g", "corrector"],
        make: |option| Box::new(wisdom_holman(option, WisdomHolman::high())),
    },
    NamedIntegrator {
        name: "implicit_euler",
        about: "order 1, implicit, stable at any step; takes fast motion away",
        options: &[],
        make: |_| Box::new(ImplicitEuler::default()),
    },
    NamedIntegrator {
        name: "implicit_midpoint",
        about: "order 2, implicit, stable at any step, symplectic",
        options: &[],
        make: |_| Box::new(ImplicitMidpoint::default()),
    },
];

/// An order of a corrector is a whole number; what is none, no method has.
fn wisdom_holman(option: Ask<'_>, usual: WisdomHolman) -> WisdomHolman {
    // 0 is no constant of gravitation: then it is that of the law.
    let g = option("g", 0.0);
    let corrector = option("corrector", f64::from(usual.corrector));
    let corrector = if corrector.fract() == 0.0 { corrector as u32 } else { u32::MAX };
    let integrator = usual.with_corrector(corrector);
    if g == 0.0 { integrator } else { integrator.with_g(g) }
}

fn tolerance(option: Ask<'_>, usual: Tolerance) -> Tolerance {
    Tolerance { relative: option("rtol", usual.relative), absolute: option("atol", usual.absolute) }
}

/// What people call them elsewhere; hints, not names that a scene could use.
const ELSEWHERE: &[(&str, &str)] = &[
    ("rk4", "runge_kutta_4"),
    ("runge_kutta", "runge_kutta_4"),
    ("rungekutta4", "runge_kutta_4"),
    ("kdk", "leapfrog"),
    ("verlet", "leapfrog"),
    ("velocity_verlet", "leapfrog"),
    ("stormer_verlet", "leapfrog"),
    ("position_verlet", "drift_kick_drift"),
    ("dkd", "drift_kick_drift"),
    ("euler", "semi_implicit_euler"),
    ("forward_euler", "explicit_euler"),
    ("rk2", "midpoint"),
    ("r_respa", "respa"),
    ("multiple_time_step", "respa"),
    ("boris_pusher", "boris"),
    ("hc", "higuera_cary"),
    ("yoshida", "symplectic_4"),
    ("forest_ruth", "symplectic_4"),
    ("rk45", "dormand_prince_5"),
    ("dopri5", "dormand_prince_5"),
    ("ode45", "dormand_prince_5"),
    ("dop853", "dormand_prince_8"),
    ("dprkn12", "nystrom_12"),
    ("rkn12", "nystrom_12"),
    ("rkn1210", "nystrom_12"),
    ("whfast", "wisdom_holman"),
    ("wh", "wisdom_holman"),
    ("mvs", "wisdom_holman"),
    ("whckl", "wisdom_holman_high"),
    ("ias15", "gauss_radau_15"),
    ("radau", "gauss_radau_15"),
    ("symplectic_euler", "semi_implicit_euler"),
    ("euler_cromer", "semi_implicit_euler"),
    ("backward_euler", "implicit_euler"),
    ("gauss_legendre_2", "implicit_midpoint"),
    ("sdirk2", "implicit_midpoint"),
];

/// Help for a name that no integrator has.
pub fn help(name: &str) -> Option<String> {
    let plain = name.to_lowercase().replace(['-', ' '], "_");
    match ELSEWHERE.iter().find(|(elsewhere, _)| *elsewhere == plain) {
        Some((_, known)) => Some(format!("did you mean `{known}`?")),
        None => help_for(name, INTEGRATORS.iter().map(|known| known.name)),
    }
}

/// The one that is another one.
pub const AUTO: &str = "auto";

/// All but the one that is another one.
pub fn methods() -> impl Iterator<Item = &'static NamedIntegrator> {
    INTEGRATORS.iter().filter(|known| known.name != AUTO)
}

/// The one that scenes get which name none.
pub const DEFAULT: &str = "leapfrog";

/// Whether the integrator of this name chooses its own steps.
pub fn is_adaptive(name: &str) -> bool {
    integrator(name).is_some_and(|known| (known.make)(&|_, usual| usual).is_adaptive())
}

/// The integrator of this name.
pub fn integrator(name: &str) -> Option<&'static NamedIntegrator> {
    INTEGRATORS.iter().find(|known| known.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_has_its_own_name() {
        for known in methods() {
            assert_eq!((known.make)(&|_, usual| usual).name(), known.name);
        }
        assert!(integrator(DEFAULT).is_some());
        assert!(
            ELSEWHERE.iter().all(|(elsewhere, known)| integrator(known).is_some() && integrator(elsewhere).is_none())
        );
    }
}
