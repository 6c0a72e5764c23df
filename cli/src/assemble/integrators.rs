//! Integrators by their names in scenes.

use vesper::prelude::*;

use crate::fault::help_for;

/// An integrator that a scene can name.
#[derive(Clone, Copy, Debug)]
pub struct NamedIntegrator {
    /// Its name.
    pub name: &'static str,
    /// What it is, in a line.
    pub about: &'static str,
    /// Makes one.
    pub make: fn() -> Box<dyn Integrator>,
}

/// All integrators.
pub const INTEGRATORS: &[NamedIntegrator] = &[
    NamedIntegrator {
        name: "semi_implicit_euler",
        about: "order 1, one evaluation per step, symplectic",
        make: || Box::new(SemiImplicitEuler),
    },
    NamedIntegrator {
        name: "leapfrog",
        about: "order 2, one evaluation per step, symplectic (the default)",
        make: || Box::new(Leapfrog::default()),
    },
    NamedIntegrator {
        name: "runge_kutta_4",
        about: "order 4, four evaluations per step",
        make: || Box::new(RungeKutta4),
    },
];

/// What people call them elsewhere; hints, not names that a scene could use.
const ELSEWHERE: &[(&str, &str)] = &[
    ("rk4", "runge_kutta_4"),
    ("runge_kutta", "runge_kutta_4"),
    ("rungekutta4", "runge_kutta_4"),
    ("kdk", "leapfrog"),
    ("verlet", "leapfrog"),
    ("velocity_verlet", "leapfrog"),
    ("stormer_verlet", "leapfrog"),
    ("euler", "semi_implicit_euler"),
    ("symplectic_euler", "semi_implicit_euler"),
    ("euler_cromer", "semi_implicit_euler"),
];

/// Help for a name that no integrator has.
pub fn help(name: &str) -> Option<String> {
    let plain = name.to_lowercase().replace(['-', ' '], "_");
    match ELSEWHERE.iter().find(|(elsewhere, _)| *elsewhere == plain) {
        Some((_, known)) => Some(format!("did you mean `{known}`?")),
        None => help_for(name, INTEGRATORS.iter().map(|known| known.name)),
    }
}

/// The one that scenes get which name none.
pub const DEFAULT: &str = "leapfrog";

/// The integrator of this name.
pub fn integrator(name: &str) -> Option<&'static NamedIntegrator> {
    INTEGRATORS.iter().find(|known| known.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_has_its_own_name() {
        for known in INTEGRATORS {
            assert_eq!((known.make)().name(), known.name);
        }
        assert!(integrator(DEFAULT).is_some());
        assert!(
            ELSEWHERE.iter().all(|(elsewhere, known)| integrator(known).is_some() && integrator(elsewhere).is_none())
        );
    }
}
