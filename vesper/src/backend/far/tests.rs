//! Far fields against sums over all pairs.

use super::*;

/// Numbers from 0 to 1, the same in every run (Knuth's MMIX generator).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn direction(&mut self) -> [f64; 3] {
        let z = 2.0 * self.next() - 1.0;
        let (sine, cosine) = (core::f64::consts::TAU * self.next()).sin_cos();
        let r = (1.0 - z * z).sqrt();
        [r * cosine, r * sine, z]
    }

    /// A sphere of the density of a Plummer model, no row beyond 10.
    fn plummer(&mut self) -> [f64; 3] {
        loop {
            let r = 1.0 / (self.next().powf(-2.0 / 3.0) - 1.0).sqrt();
            let direction = self.direction();
            if r < 10.0 {
                return direction.map(|d| d * r);
            }
        }
    }
}

pub(super) type Place = [f64; 3];

pub(super) fn scene(name: &str, count: usize) -> Vec<Place> {
    let mut numbers = Numbers(7);
    let mut n = || numbers.next();
    let mut rows = Vec::new();
    for k in 0..count {
        rows.push(match name {
            "cube" => [n(), n(), n()],
            "two clusters" => [n() + 1000.0 * (k % 2) as f64, n(), n()],
            "line" => [n(), 0.25, -0.5],
            "one point" => {
                if k == 0 {
                    [3.0, 4.0, 5.0]
                } else {
                    [1.0, 2.0, 3.0]
                }
            }
            "disc" => {
                let (r, (sine, cosine)) = (-3.0 * (1.0 - 0.999 * n()).ln(), (core::f64::consts::TAU * n()).sin_cos());
                [r * cosine, r * sine, 0.1 * (n() - 0.5)]
            }
            _ => [0.0; 3],
        });
    }
    match name {
        "sphere" => rows.iter_mut().for_each(|row| *row = numbers.plummer()),
        "shell" => rows.iter_mut().for_each(|row| *row = numbers.direction()),
        _ => {}
    }
    rows
}

const SCENES: [&str; 7] = ["cube", "sphere", "two clusters", "line", "shell", "one point", "disc"];

/// Columns of a precision.
pub(super) struct Scene<P> {
    pub(super) places: [Vec<P>; 3],
    pub(super) strength: Vec<P>,
    pub(super) softening_squared: P,
}

impl<P: Scalar> Scene<P> {
    pub(super) fn new(rows: &[Place], strength: impl Fn(usize) -> f64, softening: f64) -> Self {
        Scene {
            places: [0, 1, 2].map(|k| rows.iter().map(|row| P::from_f64(row[k])).collect()),
            strength: (0..rows.len()).map(|row| P::from_f64(strength(row))).collect(),
            softening_squared: P::from_f64(softening * softening),
        }
    }

    pub(super) fn columns(&self) -> [&[P]; 3] {
        [&self.places[0], &self.places[1], &self.places[2]]
    }

    fn field(&self, far: &mut Far<P>, isa: Isa, threads: &impl Parts) -> Vec<[P; 3]> {
        let mut out = [0, 1, 2].map(|_| vec![P::from_f64(7.0); self.strength.len()]);
        let [x, y, z] = &mut out;
        far.field(isa, self.columns(), &self.strength, self.softening_squared, [x, y, z], threads);
        (0..self.strength.len()).map(|row| [out[0][row], out[1][row], out[2][row]]).collect()
    }

    fn potential(&self, far: &mut Far<P>) -> Vec<P> {
        let mut out = vec![P::from_f64(7.0); self.strength.len()];
        far.potential(Isa::detect(), self.columns(), &self.strength, self.softening_squared, &mut out, &OneThread);
        out
    }

    pub(super) fn calibrate(&self, far: &mut Far<P>) -> Accuracy {
        far.calibrate(Isa::detect(), self.columns(), &self.strength, self.softening_squared, &OneThread)
    }

    /// Field and potential over all pairs, and the potential if all strengths were positive.
    fn exact(&self, i: usize) -> [f64; 5] {
        let place = |row: usize| [0, 1, 2].map(|k| self.places[k][row].to_f64());
        let mut sum = [0.0; 5];
        let own = place(i);
        for j in 0..self.strength.len() {
            let other = place(j);
            let d = [0, 1, 2].map(|k| other[k] - own[k]);
            let r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + self.softening_squared.to_f64();
            if j != i && r2 > 0.0 {
                let strength = self.strength[j].to_f64();
                for k in 0..3 {
                    sum[k] += strength * d[k] / (r2 * r2.sqrt());
                }
                sum[3] += strength / r2.sqrt();
                sum[4] += strength.abs() / r2.sqrt();
            }
        }
        sum
    }

    /// The root of the mean square of the relative error, of about 500 rows without the worst 5: in a few rows the shares of all others
    /// nearly cancel, and relative errors are what one likes.
    pub(super) fn error(&self, found: &[[P; 3]]) -> f64 {
        let step = found.len().div_ceil(500);
        let mut squares = Vec::new();
        for row in (0..found.len()).step_by(step) {
            let exact = self.exact(row);
            let (mut error, mut length) = (0.0, 0.0);
            for k in 0..3 {
                error += (found[row][k].to_f64() - exact[k]).powi(2);
                length += exact[k] * exact[k];
            }
            squares.push(if error > 0.0 { error / length } else { 0.0 });
        }
        squares.sort_by(f64::total_cmp);
        squares.truncate(squares.len() - squares.len() / 100);
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    }
}

fn alike(_: usize) -> f64 {
    1.0
}

/// Both signs, their sum 0.
fn signed(row: usize) -> f64 {
    if row.is_multiple_of(2) { 1.0 } else { -1.0 }
}

#[test]
fn the_error_is_the_requested_one() {
    for name in SCENES {
        for (error, softening) in [(1e-2, 0.01), (1e-3, 0.01), (1e-3, 0.0), (1e-5, 0.01)] {
            let scene = Scene::<f32>::new(&scene(name, 6000), alike, softening);
            let mut far = Far::new(error);
            let accuracy = scene.calibrate(&mut far);
            let found = scene.error(&scene.field(&mut far, Isa::detect(), &OneThread));
            // On a line, the shares of rows next to each other cancel to less than f32 tells apart.
            if name != "line" || error > 1e-4 {
                assert!(found < 1.5 * error, "{name}: {found:e}, requested {error:e}, measured {accuracy:?}");
                assert!(accuracy.measured <= error, "{name}: {accuracy:?}");
            }
            let is_exact = ["line", "one point"].contains(&name);
            assert!(is_exact || accuracy.measured > 0.3 * error, "{name}: {accuracy:?} {:?}", far.effort());
        }
    }
}

#[test]
fn f64_has_errors_that_f32_has_not() {
    let scene = Scene::<f64>::new(&scene("sphere", 4000), alike, 0.01);
    for error in [1e-4, 1e-8] {
        let mut far = Far::new(error);
        let accuracy = scene.calibrate(&mut far);
        let found = scene.error(&scene.field(&mut far, Isa::detect(), &OneThread));
        assert!(found < 1.5 * error && found > error / 3.0, "{found:e} {accuracy:?}");
    }
}

#[test]
fn strengths_have_any_sign() {
    for name in SCENES {
        let scene = Scene::<f64>::new(&scene(name, 3000), signed, 0.001);
        let mut far = Far::new(1e-3);
        let accuracy = scene.calibrate(&mut far);
        assert!(accuracy.measured <= 1e-3, "{name}: {accuracy:?}");
    }
}

#[test]
fn potentials_are_those_of_all_pairs() {
    for name in SCENES {
        for (softening, strength) in [(0.01, alike as fn(usize) -> f64), (0.0, alike), (0.01, signed)] {
            let scene = Scene::<f64>::new(&scene(name, 2500), strength, softening);
            let mut far = Far::new(1e-4);
            scene.calibrate(&mut far);
            let found = scene.potential(&mut far);
            for row in (0..2500).step_by(17) {
                let [.., exact, all] = scene.exact(row);
                let off = (found[row] - exact).abs();
                assert!(off <= 5e-4 * all, "{name} {softening}: {off:e} of {exact:e} and {all:e}");
            }
        }
    }
}

/// The threads of a caller: the parts in another order, on several of them.
struct Backwards(usize);

impl Parts for Backwards {
    fn run(&self, count: usize, work: &(dyn Fn(usize) + Sync)) {
        std::thread::scope(|scope| {
            for thread in 0..self.0 {
                scope.spawn(move || (0..count).rev().filter(|part| part % self.0 == thread).for_each(work));
            }
        });
    }
}

#[test]
fn bits_do_not_depend_on_threads_or_on_what_was_before() {
    let one = Scene::<f32>::new(&scene("sphere", 5000), alike, 0.01);
    let other = Scene::<f32>::new(&scene("disc", 3000), alike, 0.01);
    let mut far = Far::new(1e-3);
    let found = one.field(&mut far, Isa::detect(), &OneThread);
    other.field(&mut far, Isa::detect(), &OneThread);
    for threads in [1, 2, 3] {
        assert_eq!(found, one.field(&mut far, Isa::detect(), &Backwards(threads)));
    }
}

#[test]
fn rows_that_keys_do_not_tell_apart_stand_by_their_number() {
    // Several at each place and in each cell of the curve, and all of different strength: another order, other bits.
    let on_grid = |name| {
        let rows = scene(name, 20_000).into_iter();
        let rows: Vec<Place> = rows.map(|place| place.map(|number| (number * 16.0).round() / 16.0)).collect();
        Scene::<f32>::new(&rows, |row| (row as f64 * 0.37).sin(), 0.01)
    };
    let [one, other] = ["cube", "disc"].map(on_grid);
    let mut far = Far::new(1e-3);
    let found = one.field(&mut far, Isa::detect(), &OneThread);
    other.field(&mut far, Isa::detect(), &OneThread);
    for threads in [1, 3] {
        assert_eq!(found, one.field(&mut far, Isa::detect(), &Backwards(threads)));
    }
}

#[test]
fn lanes_of_any_width_agree() {
    let scene = Scene::<f64>::new(&scene("sphere", 2000), alike, 0.01);
    let mut all = Isa::available().into_iter().map(|isa| scene.field(&mut Far::new(1e-3), isa, &OneThread));
    let scalar = all.next().unwrap();
    for found in all {
        for (a, b) in scalar.iter().zip(&found) {
            for k in 0..3 {
                assert!((a[k] - b[k]).abs() < 1e-11 * a[k].abs().max(1.0), "{a:?} {b:?}");
            }
        }
    }
}

#[test]
fn few_rows_are_no_special_case() {
    for count in [0, 1, 2, 3, 47, 49, 65] {
        let scene = Scene::<f32>::new(&scene("cube", count), alike, 0.0);
        let mut far = Far::new(1e-3);
        let accuracy = scene.calibrate(&mut far);
        let found = scene.field(&mut far, Isa::detect(), &OneThread);
        assert_eq!(found.len(), count);
        assert_eq!(scene.potential(&mut far).len(), count);
        if count > 0 {
            let error = scene.error(&found);
            assert!(error < 1.5e-3, "{count} rows: {error:e}, {accuracy:?} {:?}", far.effort());
        }
    }
    assert!(!pays(100, 1e-3) && pays(100_000, 1e-3) && !pays(10_000, 1e-6));
}

#[test]
fn rows_at_one_point_do_nothing_to_each_other() {
    for count in [2, 40, 3000] {
        for softening in [0.0, 0.1] {
            let scene = Scene::<f32>::new(&vec![[5.0, -1.0, 2.0]; count], alike, softening);
            let found = scene.field(&mut Far::new(1e-3), Isa::detect(), &OneThread);
            assert!(found.iter().all(|field| *field == [0.0; 3]), "{count} {softening}");
            let potential = scene.potential(&mut Far::new(1e-3));
            let expected = if softening > 0.0 { (count - 1) as f32 / 0.1 } else { 0.0 };
            assert!(potential.iter().all(|found| (found - expected).abs() <= 1e-4 * expected), "{count}");
        }
    }
}

#[test]
fn a_number_that_is_not_finite_reaches_every_row() {
    for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for column in 0..3 {
            let mut rows = scene("cube", 500);
            rows[123][column] = wrong;
            let scene = Scene::<f64>::new(&rows, alike, 0.0);
            let found = scene.field(&mut Far::new(1e-3), Isa::detect(), &OneThread);
            assert!(found.iter().flatten().all(|number| number.is_nan()));
            assert!(scene.calibrate(&mut Far::new(1e-3)).measured.is_nan());
        }
    }
}

#[test]
fn strengths_of_0_give_nothing() {
    let scene = Scene::<f32>::new(&scene("cube", 3000), |_| 0.0, 0.0);
    let mut far = Far::new(1e-3);
    assert_eq!(scene.calibrate(&mut far).measured, 0.0);
    assert!(scene.field(&mut far, Isa::detect(), &OneThread).iter().all(|field| *field == [0.0; 3]));
}

#[test]
fn units_of_a_scene_do_not_matter() {
    fn check<P: Scalar>(size: f64, offset: f64, strength: f64, softening: f64, within: f64) {
        let rows: Vec<Place> =
            scene("sphere", 1500).into_iter().map(|row| row.map(|place| place * size + offset)).collect();
        let scene = Scene::<P>::new(&rows, |_| strength, softening * size);
        let mut far = Far::new(1e-3);
        let accuracy = scene.calibrate(&mut far);
        assert!(accuracy.measured <= 1e-3, "{accuracy:?}");
        let found = scene.field(&mut far, Isa::detect(), &OneThread);
        let error = scene.error(&found);
        assert!(error < within, "size {size:e}, offset {offset:e}: {error:e}");
    }
    check::<f32>(1.0, 1000.0, 1.0, 0.01, 2e-3);
    check::<f32>(1e20, 0.0, 1e24, 0.0, 2e-3);
    check::<f64>(1e20, 0.0, 6.67e-11 * 2e30, 0.0, 2e-3);
    check::<f64>(1e-150, 0.0, 1e-290, 0.0, 2e-3);
    check::<f64>(1e-3, 1e3, 1.0, 0.0, 2e-3);
}

/// Places a few subnormal numbers apart have no finite inverse squares of distance, and are found to be apart all the same.
#[test]
fn subnormal_extents_do_no_harm() {
    let rows: Vec<Place> = scene("sphere", 400).into_iter().map(|row| row.map(|place| place * 1e-42)).collect();
    let scene = Scene::<f32>::new(&rows, |_| 1e-38, 0.0);
    let found = scene.field(&mut Far::new(1e-3), Isa::detect(), &OneThread);
    assert!(found.iter().flatten().all(|number| !number.is_nan()));
    let scene =
        Scene::<f64>::new(&rows.iter().map(|row| row.map(|place| place * 1e-270)).collect::<Vec<_>>(), |_| 1e-310, 0.0);
    let found = scene.field(&mut Far::new(1e-3), Isa::detect(), &OneThread);
    assert!(found.iter().flatten().all(|number| !number.is_nan()));
}

#[test]
fn a_cluster_much_smaller_than_the_scene_is_divided() {
    // Every two rows are ten times nearer to the origin than the two before: 600 levels of an octree.
    let rows: Vec<Place> =
        (0..300).map(|k| scene("cube", 2)[k % 2].map(|place| place * 10f64.powi(-(k as i32) / 2))).collect();
    let scene = Scene::<f64>::new(&rows, alike, 1e-60);
    let mut far = Far::new(1e-3);
    let found = scene.field(&mut far, Isa::detect(), &OneThread);
    assert!(scene.error(&found) < 1e-3);
    assert!(far.tree.cells.len() > 10);
}
