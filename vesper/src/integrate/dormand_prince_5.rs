//! The method of Dormand and Prince of order 5, with an error of order 4.
//!
//! Order 5, six evaluations per step (the seventh is the first of the next step); the step follows the tolerance, and
//! the solution of order 5 is kept. Frames within a step get a dense output of order 4. For moderate errors. Not symplectic, and not for stiff
//! laws, as `dormand_prince_8`, which is cheaper for small errors
//! (`cargo test -p vesper-laws adaptive -- --nocapture`).
//!
//! Source: Dormand, Prince, J. Comput. Appl. Math. 6 (1980) 19; Hairer, Norsett, Wanner, Solving Ordinary Differential
//! Equations I, 2nd ed. (1993), II.5, table 5.2.

use super::adaptive::Control;
use super::dense::Dense;
use super::embedded::Progress;
use super::runge_kutta::{Embedded, adaptive_runge_kutta};
use super::{Integrator, System, Tolerance};
use crate::error::Fault;

/// Dormand and Prince of order 5: adaptive, six evaluations per step.
#[derive(Clone, Copy, Debug)]
pub struct DormandPrince5 {
    /// What error a step may have.
    pub tolerance: Tolerance,
    progress: Progress,
}

impl DormandPrince5 {
    /// With this tolerance.
    pub fn new(tolerance: Tolerance) -> Self {
        DormandPrince5 { tolerance, progress: Progress::default() }
    }
}

impl Default for DormandPrince5 {
    fn default() -> Self {
        DormandPrince5::new(Tolerance::relative(1e-6))
    }
}

adaptive_runge_kutta!(DormandPrince5, METHOD, 5);

const METHOD: Embedded<1> = Embedded {
    name: "dormand_prince_5",
    stages: &[
        (0.2, &[0.2]),
        (0.3, &[3.0 / 40.0, 9.0 / 40.0]),
        (0.8, &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0]),
        (8.0 / 9.0, &[19_372.0 / 6561.0, -25_360.0 / 2187.0, 64_448.0 / 6561.0, -212.0 / 729.0]),
        (1.0, &[9017.0 / 3168.0, -355.0 / 33.0, 46_732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18_656.0]),
        (1.0, WEIGHTS),
    ],
    weights: WEIGHTS,
    errors: [&[
        71.0 / 57_600.0,
        0.0,
        -71.0 / 16_695.0,
        71.0 / 1920.0,
        -17_253.0 / 339_200.0,
        22.0 / 525.0,
        -1.0 / 40.0,
    ]],
    error: |[error]| error,
    last_is_first: true,
    control: Control { order: 5, beta: 0.04, limits: [0.2, 10.0], foresees: false },
    dense: Dense { further: &[], terms: &[FOURTH] },
};

const WEIGHTS: &[f64] = &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0];

/// The last term of the dense output, of order 4.
const FOURTH: &[f64] = &[
    -12_715_105_075.0 / 11_282_082_432.0,
    0.0,
    87_487_479_700.0 / 32_700_410_799.0,
    -10_690_763_975.0 / 1_880_347_072.0,
    701_980_252_875.0 / 199_316_789_632.0,
    -1_453_857_185.0 / 822_651_844.0,
    69_997_945.0 / 29_380_423.0,
];
