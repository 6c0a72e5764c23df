//! Accelerations of all pairs by hand, each written for this one law and one processor, with its instructions by name: what a
//! kernel can reach.
//!
//! In: split columns of a multiple of 512 bodies, softened, so that none does anything to itself. Out: accelerations, for G = 1.
//! The estimate of a reciprocal root is corrected in its cube, whose constant factor waits for the end; sums of f32 over 256
//! bodies go to sums of f64.

use core::arch::x86_64::*;

/// Bodies as columns of their own.
#[derive(Clone, Debug, Default)]
pub struct Attracting<P> {
    /// Places.
    pub position: [Vec<P>; 3],
    /// Masses.
    pub mass: Vec<P>,
    /// Accelerations of the last call.
    pub acceleration: [Vec<f64>; 3],
}

/// A loop with its name.
///
/// # Safety
/// To be called on the processor that [`f32_loops`] and [`f64_loops`] were asked on.
pub type Loop<P> = (&'static str, unsafe fn(&mut Attracting<P>, P));

/// The loops in f32 that this processor has instructions for.
pub fn f32_loops() -> Vec<Loop<f32>> {
    let mut loops: Vec<Loop<f32>> = Vec::new();
    if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
        loops.push(("hand AVX-512", avx512_f32));
        loops.push(("hand AVX-512 once", avx512_f32_once));
    }
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        loops.push(("hand AVX2", avx2_f32));
    }
    loops
}

/// The loops in f64 that this processor has instructions for.
pub fn f64_loops() -> Vec<Loop<f64>> {
    let mut loops: Vec<Loop<f64>> = Vec::new();
    if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
        loops.push(("hand AVX-512", avx512_f64));
    }
    loops
}

/// Bodies whose sums stay in f32.
const TILE: usize = 256;
/// Bodies that meet at a time.
const BLOCK: usize = 512;

impl<P: vesper::real::Scalar> Attracting<P> {
    /// The bodies of these places and one mass.
    pub fn new(position: &[[f64; 3]], mass: f64) -> Self {
        assert!(position.len().is_multiple_of(BLOCK), "a multiple of {BLOCK} bodies");
        Attracting {
            position: [0, 1, 2].map(|axis| position.iter().map(|place| P::from_f64(place[axis])).collect()),
            mass: vec![P::from_f64(mass); position.len()],
            acceleration: [0, 1, 2].map(|_| vec![0.0; position.len()]),
        }
    }

    fn pointers(&self) -> ([*const P; 3], *const P, usize) {
        (self.position.each_ref().map(|column| column.as_ptr()), self.mass.as_ptr(), self.mass.len())
    }
}

/// One loop over all pairs: rows i in `$sets` registers of `$lanes` numbers, row j the same in all lanes.
macro_rules! each {
    (
        $(#[$doc:meta])* $name:ident, $features:literal, $real:ty, $lanes:literal, $sets:literal, $factor:literal, $set1:ident, $load:ident,
        $store:ident, $sub:ident, $fmadd:ident, |$square:ident, $mass:ident| $weight:expr
    ) => {
        $(#[$doc])*
        ///
        /// # Safety
        /// The processor has the instructions.
        #[target_feature(enable = $features)]
        unsafe fn $name(bodies: &mut Attracting<$real>, softening_squared: $real) {
            let ([x, y, z], m, n) = bodies.pointers();
            let softening = $set1(softening_squared);
            for i in (0..n).step_by($sets * $lanes) {
                let zero = [$set1(0.0); $sets];
                let (mut xi, mut yi, mut zi) = (zero, zero, zero);
                for set in 0..$sets {
                    // SAFETY: there are as many bodies; the same for all blocks here.
                    unsafe {
                        xi[set] = $load(x.add(i + set * $lanes));
                        yi[set] = $load(y.add(i + set * $lanes));
                        zi[set] = $load(z.add(i + set * $lanes));
                    }
                }
                let mut sums = [[[0.0_f64; $lanes]; $sets]; 3];
                for tile in (0..n).step_by(TILE) {
                    let (mut ax, mut ay, mut az) = (zero, zero, zero);
                    for j in tile..tile + TILE {
                        // SAFETY: see above.
                        let [xj, yj, zj, $mass] = unsafe { [$set1(*x.add(j)), $set1(*y.add(j)), $set1(*z.add(j)), $set1(*m.add(j))] };
                        for set in 0..$sets {
                            let (dx, dy, dz) = ($sub(xj, xi[set]), $sub(yj, yi[set]), $sub(zj, zi[set]));
                            let $square = $fmadd(dz, dz, $fmadd(dy, dy, $fmadd(dx, dx, softening)));
                            let weight = $weight;
                            ax[set] = $fmadd(dx, weight, ax[set]);
                            ay[set] = $fmadd(dy, weight, ay[set]);
                            az[set] = $fmadd(dz, weight, az[set]);
                        }
                    }
                    for (sums, of_tile) in sums.iter_mut().zip([ax, ay, az]) {
                        for (sums, of_set) in sums.iter_mut().zip(of_tile) {
                            let mut numbers = [0.0; $lanes];
                            // SAFETY: the array has a number for each lane.
                            unsafe { $store(numbers.as_mut_ptr(), of_set) };
                            for (sum, number) in sums.iter_mut().zip(numbers) {
                                *sum += f64::from(number);
                            }
                        }
                    }
                }
                for (acceleration, sums) in bodies.acceleration.iter_mut().zip(sums) {
                    for (to, sum) in acceleration[i..].iter_mut().zip(sums.as_flattened()) {
                        *to = $factor * sum;
                    }
                }
            }
        }
    };
}

each!(
    /// In AVX-512 and f32.
    avx512_f32, "avx512f,avx512dq", f32, 16, 4, 1.5, _mm512_set1_ps, _mm512_loadu_ps, _mm512_storeu_ps, _mm512_sub_ps,
    _mm512_fmadd_ps, |square, mass| {
        let root = _mm512_rsqrt14_ps(square);
        let inverse = _mm512_mul_ps(root, root);
        let correction = _mm512_fnmadd_ps(square, inverse, _mm512_set1_ps(5.0 / 3.0));
        _mm512_mul_ps(_mm512_mul_ps(_mm512_mul_ps(mass, root), inverse), correction)
    }
);
each!(
    /// In AVX2 with FMA, and f32: corrected once, which leaves 3e-7.
    avx2_f32, "avx2,fma", f32, 8, 1, 1.5, _mm256_set1_ps, _mm256_loadu_ps, _mm256_storeu_ps, _mm256_sub_ps, _mm256_fmadd_ps,
    |square, mass| {
        let root = _mm256_rsqrt_ps(square);
        let inverse = _mm256_mul_ps(root, root);
        let correction = _mm256_fnmadd_ps(square, inverse, _mm256_set1_ps(5.0 / 3.0));
        _mm256_mul_ps(_mm256_mul_ps(_mm256_mul_ps(mass, root), inverse), correction)
    }
);
each!(
    /// In AVX-512 and f64: three terms of the series.
    avx512_f64, "avx512f,avx512dq", f64, 8, 4, 1.0, _mm512_set1_pd, _mm512_loadu_pd, _mm512_storeu_pd, _mm512_sub_pd,
    _mm512_fmadd_pd, |square, mass| {
        let root = _mm512_rsqrt14_pd(square);
        let inverse = _mm512_mul_pd(root, root);
        let h = _mm512_fnmadd_pd(square, inverse, _mm512_set1_pd(1.0));
        let series = _mm512_fmadd_pd(h, _mm512_set1_pd(35.0 / 16.0), _mm512_set1_pd(15.0 / 8.0));
        let series = _mm512_fmadd_pd(h, series, _mm512_set1_pd(1.5));
        let cube = _mm512_mul_pd(_mm512_mul_pd(mass, root), inverse);
        _mm512_fmadd_pd(_mm512_mul_pd(cube, h), series, cube)
    }
);

/// Each pair once, in AVX-512 and f32: four rows i the same in all lanes, rows j in lanes.
///
/// # Safety
/// The processor has the instructions.
#[target_feature(enable = "avx512f,avx512dq")]
unsafe fn avx512_f32_once(bodies: &mut Attracting<f32>, softening_squared: f32) {
    const ROWS: usize = 4;
    let ([x, y, z], m, n) = bodies.pointers();
    let (softening, zero) = (_mm512_set1_ps(softening_squared), _mm512_setzero_ps());
    bodies.acceleration.iter_mut().for_each(|column| column.fill(0.0));
    for first in (0..n).step_by(BLOCK) {
        for second in (first..n).step_by(BLOCK) {
            let mut sums = [[0.0_f32; BLOCK]; 3];
            for i in (first..first + BLOCK).step_by(ROWS) {
                let nothing = [zero; ROWS];
                let (mut xi, mut yi, mut zi, mut mi) = (nothing, nothing, nothing, nothing);
                let (mut ax, mut ay, mut az) = (nothing, nothing, nothing);
                for k in 0..ROWS {
                    // SAFETY: there are as many bodies; the same for all blocks here.
                    unsafe {
                        xi[k] = _mm512_set1_ps(*x.add(i + k));
                        yi[k] = _mm512_set1_ps(*y.add(i + k));
                        zi[k] = _mm512_set1_ps(*z.add(i + k));
                        mi[k] = _mm512_set1_ps(*m.add(i + k));
                    }
                }
                // Pairs within a block of its own are looked at from both sides.
                let once = first != second;
                for j in (0..BLOCK).step_by(16) {
                    // SAFETY: see above; sums have a number for each body of a block.
                    unsafe {
                        let xj = _mm512_loadu_ps(x.add(second + j));
                        let yj = _mm512_loadu_ps(y.add(second + j));
                        let zj = _mm512_loadu_ps(z.add(second + j));
                        let mj = _mm512_loadu_ps(m.add(second + j));
                        let mut sx = _mm512_loadu_ps(sums[0].as_ptr().add(j));
                        let mut sy = _mm512_loadu_ps(sums[1].as_ptr().add(j));
                        let mut sz = _mm512_loadu_ps(sums[2].as_ptr().add(j));
                        for k in 0..ROWS {
                            let dx = _mm512_sub_ps(xj, xi[k]);
                            let dy = _mm512_sub_ps(yj, yi[k]);
                            let dz = _mm512_sub_ps(zj, zi[k]);
                            let square =
                                _mm512_fmadd_ps(dz, dz, _mm512_fmadd_ps(dy, dy, _mm512_fmadd_ps(dx, dx, softening)));
                            let root = _mm512_rsqrt14_ps(square);
                            let inverse = _mm512_mul_ps(root, root);
                            let correction = _mm512_fnmadd_ps(square, inverse, _mm512_set1_ps(5.0 / 3.0));
                            let weight = _mm512_mul_ps(_mm512_mul_ps(root, inverse), correction);
                            let (of_i, of_j) = (_mm512_mul_ps(weight, mj), _mm512_mul_ps(weight, mi[k]));
                            ax[k] = _mm512_fmadd_ps(dx, of_i, ax[k]);
                            ay[k] = _mm512_fmadd_ps(dy, of_i, ay[k]);
                            az[k] = _mm512_fmadd_ps(dz, of_i, az[k]);
                            sx = _mm512_fnmadd_ps(dx, of_j, sx);
                            sy = _mm512_fnmadd_ps(dy, of_j, sy);
                            sz = _mm512_fnmadd_ps(dz, of_j, sz);
                        }
                        _mm512_storeu_ps(sums[0].as_mut_ptr().add(j), sx);
                        _mm512_storeu_ps(sums[1].as_mut_ptr().add(j), sy);
                        _mm512_storeu_ps(sums[2].as_mut_ptr().add(j), sz);
                    }
                }
                if once {
                    for k in 0..ROWS {
                        bodies.acceleration[0][i + k] += 1.5 * f64::from(_mm512_reduce_add_ps(ax[k]));
                        bodies.acceleration[1][i + k] += 1.5 * f64::from(_mm512_reduce_add_ps(ay[k]));
                        bodies.acceleration[2][i + k] += 1.5 * f64::from(_mm512_reduce_add_ps(az[k]));
                    }
                }
            }
            for (acceleration, sums) in bodies.acceleration.iter_mut().zip(&sums) {
                for (to, sum) in acceleration[second..].iter_mut().zip(sums) {
                    *to += 1.5 * f64::from(*sum);
                }
            }
        }
    }
}
