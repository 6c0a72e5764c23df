//! Springs between bodies, one after the other.

use super::Column;
use crate::scenes::{Lattice, STEP};
use vesper::prelude::Precision;

/// Bodies and the springs between them.
#[derive(Clone, Debug)]
pub struct Sprung<P> {
    /// Places.
    pub position: [Column<P>; 3],
    /// Velocities.
    pub velocity: [Column<P>; 3],
    pub(super) force: [Column<P>; 3],
    pub(super) mass: Column<P>,
    pub(super) ends: Vec<[u32; 2]>,
    pub(super) stiffness: Column<P>,
    pub(super) rest_length: Column<P>,
}

impl<P: Precision> Sprung<P> {
    /// The same bodies and springs as an engine gets.
    pub fn new(lattice: &Lattice) -> Self {
        let bodies = &lattice.bodies;
        Sprung {
            position: Column::vectors(0, &bodies.position),
            velocity: Column::vectors(3, &bodies.velocity),
            mass: Column::new(6, bodies.mass.iter().copied()),
            force: Column::vectors(7, &bodies.velocity),
            ends: lattice.ends.clone(),
            stiffness: Column::new(10, lattice.stiffness.iter().copied()),
            rest_length: Column::new(12, lattice.rest_length.iter().copied()),
        }
    }

    /// One step of semi-implicit Euler under gravity and springs.
    pub fn step(&mut self, gravity: [f64; 3]) {
        let step = P::from_f64(STEP);
        let [x, y, z] = self.position.each_mut().map(Column::slice);
        let [vx, vy, vz] = self.velocity.each_mut().map(Column::slice);
        let [fx, fy, fz] = self.force.each_mut().map(Column::slice);
        let (mass, rows) = (self.mass.numbers(), x.len());
        let [gx, gy, gz] = gravity.map(P::from_f64);
        for row in 0..rows {
            (fx[row], fy[row], fz[row]) = (gx * mass[row], gy * mass[row], gz * mass[row]);
        }
        let (stiffness, rest_length) = (self.stiffness.numbers(), self.rest_length.numbers());
        for (spring, [a, b]) in self.ends.iter().map(|ends| ends.map(|end| end as usize)).enumerate() {
            let (dx, dy, dz) = (x[b] - x[a], y[b] - y[a], z[b] - z[a]);
            let length = (dx * dx + dy * dy + dz * dz).sqrt();
            let inverse = if length == P::default() { P::default() } else { P::lit(1.0) / length };
            let (nx, ny, nz) = (dx * inverse, dy * inverse, dz * inverse);
            let pull = stiffness[spring] * (length - rest_length[spring]);
            let (px, py, pz) = (nx * pull, ny * pull, nz * pull);
            fx[a] += px;
            fy[a] += py;
            fz[a] += pz;
            fx[b] += -px;
            fy[b] += -py;
            fz[b] += -pz;
        }
        for i in (0..rows).filter(|&i| mass[i] != P::default()) {
            vx[i] += fx[i] / mass[i] * step;
            vy[i] += fy[i] / mass[i] * step;
            vz[i] += fz[i] / mass[i] * step;
            x[i] += vx[i] * step;
            y[i] += vy[i] * step;
            z[i] += vz[i] * step;
        }
    }
}
