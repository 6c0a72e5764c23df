//! Far fields against sums over all pairs.

use super::*;

/// Numbers from 0 to 1, the same in every run.
pub(super) struct Numbers(u64);

impl Numbers {
    pub(super) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
    fn direction(&mut self) -> [f64; 3] {
        let z = 2.0 * self.next() - 1.0;
        let (s, c) = (core::f64::consts::TAU * self.next()).sin_cos();
        let r = (1.0 - z * z).sqrt();
        [r * c, r * s, z]
    }
}

pub(super) fn plummer(count: usize) -> Vec<[f64; 3]> {
    let mut numbers = Numbers(7);
    let mut rows = Vec::new();
    while rows.len() < count {
        let r = 1.0 / (numbers.next().powf(-2.0 / 3.0) - 1.0).sqrt();
        let d = numbers.direction();
        if r < 10.0 {
            rows.push(d.map(|d| d * r));
        }
    }
    rows
}

fn direct(rows: &[[f64; 3]], s: &[f64], e2: f64, i: usize) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (j, row) in rows.iter().enumerate() {
        let d = [0, 1, 2].map(|k| row[k] - rows[i][k]);
        let r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + e2;
        if j != i && r2 > 0.0 {
            for k in 0..3 {
                sum[k] += s[j] * d[k] / (r2 * r2.sqrt());
            }
        }
    }
    sum
}

#[test]
#[ignore = "timings"]
fn timing() {
    let var = |name: &str, or: f64| std::env::var(name).map_or(or, |v| v.parse().unwrap());
    let n = var("N", 1e5) as usize;
    let rows: Vec<[f32; 3]> = plummer(n).iter().map(|r| r.map(|x| x as f32)).collect();
    let places: [Vec<f32>; 3] = [0, 1, 2].map(|k| rows.iter().map(|r| r[k]).collect());
    let s = vec![1.0 / n as f32; n];
    let exact: Vec<[f64; 3]> = rows.iter().map(|r| r.map(f64::from)).collect();
    let s64 = vec![f64::from(s[0]); n];
    let sample: Vec<usize> = (0..400).map(|k| k * n / 400).collect();
    let truth: Vec<[f64; 3]> = sample.iter().map(|&i| direct(&exact, &s64, 1e-4, i)).collect();
    let orders: Vec<usize> =
        std::env::var("ORDERS").unwrap_or("3,4,5,6".into()).split(',').map(|o| o.parse().unwrap()).collect();
    let openings: Vec<f64> =
        std::env::var("OPENINGS").unwrap_or("0.6,0.8,1.0".into()).split(',').map(|o| o.parse().unwrap()).collect();
    for order in orders {
        for &opening in &openings {
            let mut far = Far::<f32>::new(1e-3);
            far.set_opening((order, opening));
            let mut out: [Vec<f32>; 3] = [0, 1, 2].map(|_| vec![0.0; n]);
            let mut best = f64::MAX;
            let mut build = f64::MAX;
            for _ in 0..var("REPEAT", 4.0) as usize {
                let [x, y, z] = &mut out;
                let p = [&places[0][..], &places[1][..], &places[2][..]];
                let t = std::time::Instant::now();
                far.prepare(p, &s, 1e-4);
                build = build.min(t.elapsed().as_secs_f64());
                let t = std::time::Instant::now();
                far.field(Isa::detect(), p, &s, 1e-4, [x, y, z], &Serial);
                best = best.min(t.elapsed().as_secs_f64());
            }
            let (mut sum, mut most) = (0.0f64, 0.0f64);
            for (&i, t) in sample.iter().zip(&truth) {
                let (mut d, mut l) = (0.0, 0.0);
                for k in 0..3 {
                    d += (f64::from(out[k][i]) - t[k]).powi(2);
                    l += t[k] * t[k];
                }
                sum += d / l;
                most = most.max((d / l).sqrt());
            }
            let rms = (sum / sample.len() as f64).sqrt();
            let call = far.call(&Frame::new([&places[0], &places[1], &places[2]], &s, 1e-4).unwrap(), 1e-4);
            let counts = call.count(Isa::detect());
            println!(
                "n {n} order {order} opening {opening}: {:.1} ms (build {:.1}) rms {rms:.2e} max {most:.1e} counts {counts}",
                best * 1e3, build * 1e3
            );
        }
    }
}
