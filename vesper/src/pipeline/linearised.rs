//! Answers to integrators that ask for derivatives. In: registers. Out: products and directions. Never: a law by itself.

use super::run::Runner;
use super::vectors::Vectors;
use crate::integrate::{Linearised, Register};
use crate::law::Part;
use crate::real::Scalar;
use core::ops::Range;

impl<P: Scalar> Vectors<P> {
    /// The numbers of a vector.
    ///
    /// # Panics
    /// It is the state, or one that the integrator did not ask for.
    fn numbers(&self, register: Register) -> &[P] {
        &self.registers[self.number(register)].as_slice()[..self.len()]
    }

    pub(crate) fn numbers_mut(&mut self, register: Register) -> &mut [P] {
        let (number, len) = (self.number(register), self.len());
        &mut self.registers[number].as_mut_slice()[..len]
    }

    fn number(&self, register: Register) -> usize {
        let pointer = self.vector(register);
        let number = self.registers.iter().position(|numbers| Some(numbers.pointer()) == pointer);
        number.expect("derivatives, products and directions are of vectors, not of the state")
    }

    /// Where the numbers of each state of a part are, with the number of the state.
    pub(super) fn ranges(&self, part: Part) -> impl Iterator<Item = (usize, Range<usize>)> {
        self.part(part).flat_map(|(number, state)| {
            state.components.iter().map(move |component| (number, component.at..component.at + state.len))
        })
    }
}

/// A sum of products in f64, several at a time, so that one addition need not wait for the one before.
fn product<P: Scalar>(a: &[P], b: &[P]) -> f64 {
    const SUMS: usize = 8;
    let mut sums = [0.0; SUMS];
    let (a, b) = (a.chunks_exact(SUMS), b.chunks_exact(SUMS));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a.to_f64() * b.to_f64()).sum();
    for (a, b) in a.zip(b) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a.to_f64() * b.to_f64();
        }
    }
    sums.iter().sum::<f64>() + rest
}

impl<P: Scalar> Linearised for Runner<'_, P> {
    fn derivative(&mut self, to: Register, along: Register) {
        self.derivatives += 1;
        self.come_home(true);
        let super::Pipeline { tangent, vectors, .. } = &mut *self.pipeline;
        let tangent = tangent.as_mut().expect("an integrator that asks for derivatives says needs_derivatives");
        tangent.along().copy_from_slice(vectors.numbers(along));
        // SAFETY: `Runner` is only made for a state with the layout that the program was tied to, held exclusively.
        unsafe { tangent.run(&self.context) };
        vectors.numbers_mut(to).copy_from_slice(tangent.rates());
    }

    fn dot(&self, a: Register, b: Register, part: Part, weights: &[f64]) -> f64 {
        self.come_home(false);
        let vectors = &self.pipeline.vectors;
        let (a, b) = (vectors.numbers(a), vectors.numbers(b));
        vectors.ranges(part).map(|(state, range)| weights[state] * product(&a[range.clone()], &b[range])).sum()
    }

    fn scatter(&mut self, to: Register, scales: &[f64]) {
        self.come_home(true);
        let vectors = &mut self.pipeline.vectors;
        let ranges: Vec<(usize, Range<usize>)> = vectors.ranges(Part::All).collect();
        let numbers = vectors.numbers_mut(to);
        // Knuth's linear congruential generator (MMIX), its upper bits.
        let mut seed = 1_u64;
        for (state, range) in ranges {
            for number in &mut numbers[range] {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let part = 0.5 + 0.5 * (seed >> 11) as f64 / (1_u64 << 53) as f64;
                // Another bit for the sign: from the lower half, but none of the lowest, which take turns.
                let random = if seed >> 40 & 1 == 1 { part } else { -part };
                *number = P::from_f64(random * scales[state]);
            }
        }
    }
}
