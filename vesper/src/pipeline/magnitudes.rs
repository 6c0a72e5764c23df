//! Magnitudes of rows, by which integrators judge errors. In: vectors. Out: the length of every row's numbers in each of
//! them, row by row. Never: a sum over rows.

use super::vectors::{StateProperty, Vectors};
use crate::integrate::Register;
use crate::law::Part;
use crate::real::Scalar;

/// Vectors that are looked at together.
const LOOKS: usize = 12;

impl<P: Scalar> Vectors<P> {
    /// Goes through the rows of a part.
    ///
    /// # Safety
    /// The state that the vectors were laid out for is held, and `lent` are the addresses of its lent memory.
    pub(crate) unsafe fn magnitudes(
        &self,
        of: &[Register],
        part: Part,
        lent: &[*mut P],
        each: &mut dyn FnMut(usize, &[f64]),
    ) {
        assert!(of.len() <= LOOKS, "an integrator looks at no more than {LOOKS} vectors at a time");
        let mut starts = [core::ptr::null_mut(); LOOKS];
        let mut apart = false;
        for (start, register) in starts.iter_mut().zip(of) {
            let vector = self.vector(*register);
            apart |= vector.is_none();
            *start = vector.unwrap_or(core::ptr::null_mut());
        }
        let mut magnitudes = [0.0; LOOKS];
        let magnitudes = &mut magnitudes[..of.len()];
        let starts = &starts[..of.len()];
        for (number, state) in self.part(part) {
            // What nearly all are: three numbers, in vectors.
            if let ([x, y, z], false) = (state.components.as_slice(), apart) {
                let at = [x.at, y.at, z.at];
                for row in 0..state.len {
                    for (magnitude, start) in magnitudes.iter_mut().zip(starts) {
                        // SAFETY: every component has `len` numbers there; passed on to the caller.
                        let [x, y, z] = at.map(|at| unsafe { *start.add(at + row) }.to_f64());
                        *magnitude = (x * x + y * y + z * z).sqrt();
                    }
                    each(number, magnitudes);
                }
                continue;
            }
            for row in 0..state.len {
                for (magnitude, register) in magnitudes.iter_mut().zip(of) {
                    // SAFETY: passed on to the caller.
                    *magnitude = unsafe { self.magnitude(state, row, *register, lent) };
                }
                each(number, magnitudes);
            }
        }
    }

    /// # Safety
    /// As for [`Vectors::magnitudes`], and the row exists.
    unsafe fn magnitude(&self, state: &StateProperty<P>, row: usize, of: Register, lent: &[*mut P]) -> f64 {
        let mut squares = 0.0;
        let mut last = 0.0;
        for component in &state.components {
            let (start, stride) = self.place(of, component, lent);
            // SAFETY: the component has `len` numbers there; passed on to the caller.
            last = unsafe { *start.add(row * stride) }.to_f64();
            squares += last * last;
        }
        // The square of a number alone may be out of range.
        if state.components.len() == 1 { last.abs() } else { squares.sqrt() }
    }
}
