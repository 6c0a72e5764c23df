//! Five row laws and semi-implicit Euler as one loop.

use super::Column;
use crate::scenes::{Bodies, ELECTRIC, GRAVITY, MAGNETIC, STEP};
use vesper::prelude::Precision;

/// Charged bodies in a viscous medium, split by component.
#[derive(Clone, Debug)]
pub struct Charged<P> {
    /// Places.
    pub position: [Column<P>; 3],
    /// Velocities.
    pub velocity: [Column<P>; 3],
    mass: Column<P>,
    charge: Column<P>,
    drag: Column<P>,
    /// The three fields and the step; data, as in an engine, so that the compiler cannot compute with them beforehand.
    constants: Constants<P>,
}

#[derive(Clone, Copy, Debug)]
struct Constants<P> {
    gravity: [P; 3],
    electric: [P; 3],
    magnetic: [P; 3],
    step: P,
}

impl<P: Precision> Charged<P> {
    /// The same bodies as an engine gets.
    pub fn new(bodies: &Bodies) -> Self {
        Charged {
            position: Column::vectors(0, &bodies.position),
            velocity: Column::vectors(3, &bodies.velocity),
            mass: Column::new(6, bodies.mass.iter().copied()),
            charge: Column::new(7, bodies.charge.iter().copied()),
            drag: Column::new(8, bodies.drag.iter().copied()),
            constants: Constants {
                gravity: GRAVITY.map(P::from_f64),
                electric: ELECTRIC.map(P::from_f64),
                magnetic: MAGNETIC.map(P::from_f64),
                step: P::from_f64(STEP),
            },
        }
    }
}

macro_rules! loops {
    ($scalar:ident, $baseline:ident, $avx2:ident) => {
        impl Charged<$scalar> {
            /// One step with the instructions that every processor of the family has.
            pub fn step(&mut self) {
                let [x, y, z] = self.position.each_mut().map(Column::slice);
                let [vx, vy, vz] = self.velocity.each_mut().map(Column::slice);
                let (mass, charge, drag) = (self.mass.numbers(), self.charge.numbers(), self.drag.numbers());
                $baseline(x, y, z, vx, vy, vz, mass, charge, drag, self.constants);
            }

            /// One step with AVX2, where the processor has it.
            pub fn step_wide(&mut self) {
                #[cfg(target_arch = "x86_64")]
                if is_x86_feature_detected!("avx2") {
                    let [x, y, z] = self.position.each_mut().map(Column::slice);
                    let [vx, vy, vz] = self.velocity.each_mut().map(Column::slice);
                    let (mass, charge, drag) = (self.mass.numbers(), self.charge.numbers(), self.drag.numbers());
                    // SAFETY: the processor was asked.
                    unsafe { $avx2(x, y, z, vx, vy, vz, mass, charge, drag, self.constants) };
                    return;
                }
                self.step();
            }
        }

        loops!(@ $scalar, #[inline(never)] fn $baseline);
        #[cfg(target_arch = "x86_64")]
        loops!(@ $scalar, #[target_feature(enable = "avx2")] fn $avx2);
    };
    (@ $scalar:ident, #[$attribute:meta] fn $name:ident) => {
        #[allow(clippy::too_many_arguments, reason = "slices that are arguments of their own do not overlap")]
        #[$attribute]
        fn $name(
            x: &mut [$scalar], y: &mut [$scalar], z: &mut [$scalar],
            vx: &mut [$scalar], vy: &mut [$scalar], vz: &mut [$scalar],
            mass: &[$scalar], charge: &[$scalar], drag: &[$scalar], constants: Constants<$scalar>,
        ) {
            let rows = x.len();
            let (y, z) = (&mut y[..rows], &mut z[..rows]);
            let (vx, vy, vz) = (&mut vx[..rows], &mut vy[..rows], &mut vz[..rows]);
            let (mass, charge, drag) = (&mass[..rows], &charge[..rows], &drag[..rows]);
            let Constants { gravity: [gx, gy, gz], electric: [ex, ey, ez], magnetic: [bx, by, bz], step } = constants;
            for row in 0..rows {
                let (m, q, b) = (mass[row], charge[row], drag[row]);
                let (u, v, w) = (vx[row], vy[row], vz[row]);
                let fx = u * -b + ex * q + gx * m + (v * bz - w * by) * q;
                let fy = v * -b + ey * q + gy * m + (w * bx - u * bz) * q;
                let fz = w * -b + ez * q + gz * m + (u * by - v * bx) * q;
                let immovable = m == 0.0;
                let select = |number: $scalar| if immovable { 0.0 } else { number };
                let u = u + select(fx / m) * step;
                let v = v + select(fy / m) * step;
                let w = w + select(fz / m) * step;
                (vx[row], vy[row], vz[row]) = (u, v, w);
                x[row] += select(u) * step;
                y[row] += select(v) * step;
                z[row] += select(w) * step;
            }
        }
    };
}
loops!(f32, step_f32, step_f32_avx2);
loops!(f64, step_f64, step_f64_avx2);

/// Bodies that loops of both precisions are written for.
pub trait Step: Clone {
    /// One step with the instructions that every processor of the family has.
    fn step(&mut self);
    /// One step with AVX2, where the processor has it.
    fn step_wide(&mut self);
}
impl Step for Charged<f32> {
    fn step(&mut self) {
        Charged::<f32>::step(self);
    }
    fn step_wide(&mut self) {
        Charged::<f32>::step_wide(self);
    }
}
impl Step for Charged<f64> {
    fn step(&mut self) {
        Charged::<f64>::step(self);
    }
    fn step_wide(&mut self) {
        Charged::<f64>::step_wide(self);
    }
}
