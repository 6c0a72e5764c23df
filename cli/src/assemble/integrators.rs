//! Integrators by their names in scenes.

use vesper::prelude::*;

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
    }
}
