//! Gravitation of all pairs, one pair at a time.

use super::Column;
use crate::scenes::{Bodies, STEP};
use vesper::prelude::Precision;

/// Bodies that attract each other, split by component.
#[derive(Clone, Debug)]
pub struct Attracted<P> {
    /// Places.
    pub position: [Column<P>; 3],
    /// Velocities.
    pub velocity: [Column<P>; 3],
    mass: Column<P>,
}

impl<P: Precision> Attracted<P> {
    /// The same bodies as an engine gets.
    pub fn new(bodies: &Bodies) -> Self {
        Attracted {
            position: Column::vectors(0, &bodies.position),
            velocity: Column::vectors(3, &bodies.velocity),
            mass: Column::new(6, bodies.mass.iter().copied()),
        }
    }

    /// One step of semi-implicit Euler under gravitation.
    pub fn step(&mut self, g: f64, softening: f64) {
        let (g, softening, step) = (P::from_f64(g), P::from_f64(softening), P::from_f64(STEP));
        let [x, y, z] = self.position.each_mut().map(Column::slice);
        let [vx, vy, vz] = self.velocity.each_mut().map(Column::slice);
        let (mass, rows) = (self.mass.numbers(), x.len());
        for i in 0..rows {
            let (mut fx, mut fy, mut fz) = (P::default(), P::default(), P::default());
            for j in (0..i).chain(i + 1..rows) {
                let (dx, dy, dz) = (x[j] - x[i], y[j] - y[i], z[j] - z[i]);
                let r2 = dx * dx + dy * dy + dz * dz + softening * softening;
                let weight = g * mass[i] * mass[j] / (r2 * r2.sqrt());
                fx += dx * weight;
                fy += dy * weight;
                fz += dz * weight;
            }
            if mass[i] != P::default() {
                vx[i] += fx / mass[i] * step;
                vy[i] += fy / mass[i] * step;
                vz[i] += fz / mass[i] * step;
            }
        }
        for i in (0..rows).filter(|&i| mass[i] != P::default()) {
            x[i] += vx[i] * step;
            y[i] += vy[i] * step;
            z[i] += vz[i] * step;
        }
    }
}
