//! Lennard-Jones: a law that ends at a distance, and the fluid that it is usually measured with.

use vesper::prelude::*;

/// Lennard-Jones' law between the atoms of a noble gas, truncated at a distance.
///
/// Equation: F_i = sum over j of 24 e (2 (s/r)^12 - (s/r)^6) / r^2 (x_i - x_j) for r = |x_i - x_j| less than the cut-off; energy of a
/// pair 4 e ((s/r)^12 - (s/r)^6), not shifted.
///
/// Source: Lennard-Jones, Proc. R. Soc. Lond. A 106 (1924) 463; Allen, Tildesley, Computer Simulation of Liquids, 2nd ed., 1.3.
///
/// Limits: no attraction beyond the cut-off, so that energy and pressure of a fluid have a tail to be added; the energy jumps there.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position), adds(force: Force), translation_invariant, estimates)]
pub struct LennardJones<R = f64> {
    /// Depth of the well.
    #[law(unit = "J", default = 1.0)]
    pub epsilon: R,
    /// Distance at which the energy is zero.
    #[law(unit = "m", default = 1.0)]
    pub sigma: R,
    /// Distance from which on two atoms do nothing to each other.
    #[law(unit = "m", default = 2.5, cutoff)]
    pub cutoff: R,
}

#[kernel]
impl<R: Real> PairLaw<R> for LennardJones<R> {
    fn pair(&self, i: LennardJonesRow<R>, j: LennardJonesRow<R>) -> R::Vec3 {
        let d = i.position - j.position;
        let inverse = R::lit(1.0) / d.length_squared();
        let square = self.sigma * self.sigma * inverse;
        let sixth = square * square * square;
        d * (R::lit(24.0) * self.epsilon * inverse * sixth * (sixth + sixth - R::lit(1.0)))
    }

    fn energy(&self, i: LennardJonesRow<R>, j: LennardJonesRow<R>) -> R {
        let square = self.sigma * self.sigma / (i.position - j.position).length_squared();
        let sixth = square * square * square;
        R::lit(4.0) * self.epsilon * sixth * (sixth - R::lit(1.0))
    }
}

/// Density of the usual melt, in atoms per sigma^3.
pub const DENSITY: f64 = 0.8442;
/// Its temperature at the start, in epsilon per Boltzmann's constant.
pub const TEMPERATURE: f64 = 1.44;
/// Energy per atom of the face-centred cubic lattice that it starts from, with a cut-off of 2.5 sigma.
pub const LATTICE_ENERGY: f64 = -6.773_368_053_2;

/// The length of a cubic box of `4 cells^3` atoms.
pub fn length(cells: usize) -> f64 {
    ((4 * cells.pow(3)) as f64 / DENSITY).cbrt()
}

/// Atoms of mass 1 on a face-centred cubic lattice, at random velocities of the melt's temperature without a mean.
pub fn melt<P: Precision>(cells: usize) -> Domain<P> {
    let (atoms, side) = (4 * cells.pow(3), length(cells) / cells as f64);
    let corners = [[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]];
    let place = |atom: usize| {
        let cell = [atom / 4 % cells, atom / 4 / cells % cells, atom / 4 / cells / cells];
        [0, 1, 2].map(|axis| (cell[axis] as f64 + corners[atom % 4][axis]) * side)
    };
    // SplitMix64 (Steele, Lea, Flood, OOPSLA 2014); the sum of twelve uniform numbers is close to a normal one.
    let mut state = 7_u64;
    let mut uniform = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut word = state;
        word = (word ^ word >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        word = (word ^ word >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        (word ^ word >> 31) as f64 / u64::MAX as f64
    };
    let mut velocity: Vec<[f64; 3]> =
        (0..atoms).map(|_| [0; 3].map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0)).collect();
    for axis in 0..3 {
        let mean = velocity.iter().map(|velocity| velocity[axis]).sum::<f64>() / atoms as f64;
        velocity.iter_mut().for_each(|velocity| velocity[axis] -= mean);
    }
    let squares: f64 = velocity.iter().flatten().map(|v| v * v).sum();
    let scale = (3.0 * TEMPERATURE * atoms as f64 / squares).sqrt();
    velocity.iter_mut().flatten().for_each(|v| *v *= scale);
    let domain = Domain::new("atoms").with(Position, (0..atoms).map(place).collect::<Vec<_>>());
    domain.with(Velocity, velocity).with(Mass, vec![1.0; atoms])
}
