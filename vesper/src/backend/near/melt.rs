//! How long lists take: a dense fluid in a periodic box, with the loop that a pair law would have.
//!
//! In: nothing. Out: times on the terminal, and the energy of the first step, which is known. Never: a part of the library.

use super::{Cluster, InParts, Lists, Reach};
use crate::real::{Isa, Lanes, Scalar, WithLanes};
use std::sync::LazyLock;
use std::time::Instant;

const SERIAL: InParts<'static> = &|count, work| work(0..count);

/// Seconds on the clock.
fn now() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed().as_secs_f64()
}

/// What partners do to all rows: 24 (2 / r^14 - 1 / r^8) along their difference, within the cut-off.
struct Loop<'a, P> {
    lists: &'a Lists<P>,
    places: [&'a [P]; 3],
    square: P,
    sums: [&'a mut [P]; 3],
}

impl<P: Scalar> WithLanes<P> for Loop<'_, P> {
    type Output = ();
    #[inline(always)]
    fn with<R: Lanes<P>>(mut self) {
        for number in 0..self.lists.clusters() {
            let cluster = self.lists.cluster(number);
            for first in (0..cluster.own.len()).step_by(R::WIDTH) {
                self.lanes::<R>(&cluster, first);
            }
        }
    }
}

impl<P: Scalar> Loop<'_, P> {
    #[inline(always)]
    fn lanes<R: Lanes<P>>(&mut self, cluster: &Cluster<'_>, first: usize) {
        let count = R::WIDTH.min(cluster.own.len() - first);
        let own = &cluster.own[first..first + count];
        let entry = |lane: usize| cluster.list[own[lane.min(count - 1)] as usize] as usize;
        let i = [
            R::from_lanes(|lane| self.places[0][entry(lane)]),
            R::from_lanes(|lane| self.places[1][entry(lane)]),
            R::from_lanes(|lane| self.places[2][entry(lane)]),
        ];
        let mut sums = [R::lit(0.0); 3];
        let mut behind = R::from_lanes(|lane| P::from_f64(lane as f64));
        let mut at = 0;
        for own in own {
            self.others(&cluster.list[at..*own as usize], &i, &mut sums);
            at = *own as usize + 1;
            let itself = behind.equal(R::lit(0.0));
            behind -= R::lit(1.0);
            let (near, share) = self.share(cluster.list[at - 1], &i);
            for side in 0..3 {
                sums[side] += R::select(itself, R::lit(0.0), R::select(near, share[side], R::lit(0.0)));
            }
        }
        self.others(&cluster.list[at..], &i, &mut sums);
        for side in 0..3 {
            for lane in 0..count {
                self.sums[side][cluster.rows[first + lane] as usize] = sums[side].lane(lane);
            }
        }
    }

    #[inline(always)]
    fn others<R: Lanes<P>>(&self, list: &[u32], i: &[R; 3], sums: &mut [R; 3]) {
        for entry in list {
            let (near, share) = self.share(*entry, i);
            for side in 0..3 {
                sums[side] += R::select(near, share[side], R::lit(0.0));
            }
        }
    }

    #[inline(always)]
    fn share<R: Lanes<P>>(&self, entry: u32, i: &[R; 3]) -> (R::Mask, [R; 3]) {
        // SAFETY: lists have entries only, and `places` a number for each.
        let j = unsafe {
            [
                R::splat(*self.places[0].get_unchecked(entry as usize)),
                R::splat(*self.places[1].get_unchecked(entry as usize)),
                R::splat(*self.places[2].get_unchecked(entry as usize)),
            ]
        };
        let (x, y, z) = (i[0] - j[0], i[1] - j[1], i[2] - j[2]);
        let square = x * x + y * y + z * z;
        let inverse = R::lit(1.0) / square;
        let sixth = inverse * inverse * inverse;
        let part = inverse * sixth * (R::lit(48.0) * sixth - R::lit(24.0));
        (square.less(R::splat(self.square)), [x * part, y * part, z * part])
    }
}

/// Half the energy of all pairs, by the lists.
fn energy<P: Scalar>(lists: &Lists<P>, places: &[Vec<P>; 3], cutoff: f64) -> f64 {
    let mut energy = 0.0;
    for cluster in (0..lists.clusters()).map(|number| lists.cluster(number)) {
        for own in cluster.own {
            let i = cluster.list[*own as usize] as usize;
            for j in cluster.list.iter().map(|j| *j as usize).filter(|j| *j != i) {
                let apart = places.each_ref().map(|numbers| numbers[j].to_f64() - numbers[i].to_f64());
                let square: f64 = apart.iter().map(|apart| apart * apart).sum();
                if square < cutoff * cutoff {
                    energy += 2.0 * (square.powi(-6) - square.powi(-3));
                }
            }
        }
    }
    energy
}

/// What took how long, in seconds: all of it, and the least that it took once.
#[derive(Clone, Copy)]
struct Time {
    all: f64,
    least: f64,
}

impl Time {
    fn take(&mut self, start: f64) {
        let time = now() - start;
        self.all += time;
        self.least = self.least.min(time);
    }
}

/// Rows at the corners and in the middles of the faces of cubes, and speeds that are about normal.
fn lattice<P: Scalar>(cells: usize, side: f64) -> [[Vec<P>; 3]; 2] {
    let (mut places, mut speeds): ([Vec<P>; 3], [Vec<P>; 3]) = Default::default();
    let mut number = 88_172_645_463_325_252_u64;
    for row in 0..4 * cells.pow(3) {
        let cell = [row / 4 % cells, row / 4 / cells % cells, row / 4 / cells / cells];
        let corner = [[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]][row % 4];
        for k in 0..3 {
            places[k].push(P::from_f64((cell[k] as f64 + corner[k]) * side));
            let mut speed = 0.0;
            for _ in 0..12 {
                number ^= number << 13;
                number ^= number >> 7;
                number ^= number << 17;
                speed += number as f64 / u64::MAX as f64 - 0.5;
            }
            speeds[k].push(P::from_f64(speed * 1.2));
        }
    }
    for speeds in &mut speeds {
        let mean = speeds.iter().map(|speed| speed.to_f64()).sum::<f64>() / speeds.len() as f64;
        speeds.iter_mut().for_each(|speed| *speed -= P::from_f64(mean));
    }
    [places, speeds]
}

/// Steps of a fluid of density 0.8442 that begins at temperature 1.44, with a cut-off of 2.5, as its usual benchmark does. Where
/// the rows are at the end, and what took how long.
fn melt<P: Scalar>(isa: Isa, width: usize, skin: f64, cells: usize, steps: usize) -> ([Vec<P>; 3], String) {
    let (cutoff, step) = (2.5, P::from_f64(0.005));
    let rows = 4 * cells.pow(3);
    let length = (rows as f64 / 0.8442).cbrt();
    let [mut places, mut speeds] = lattice::<P>(cells, length / cells as f64);
    let mut lists = Lists::<P>::with_width(Reach { skin, ..Reach::new(cutoff, [length; 3]) }, width).unwrap();
    let mut entries: [Vec<P>; 3] = Default::default();
    let mut sums = [const { Vec::new() }; 3].map(|_: Vec<P>| vec![P::default(); rows]);
    let [mut making, mut following, mut placing, mut summing, mut moving] =
        [Time { all: 0.0, least: f64::INFINITY }; 5];
    let (mut made, mut first) = (0, 0.0);
    for round in 0..=steps {
        let slices = places.each_ref().map(Vec::as_slice);
        let start = now();
        let holds = lists.follow(isa, slices);
        if round > 0 {
            following.take(start);
        }
        if !holds {
            let start = now();
            lists.build(isa, slices, SERIAL).unwrap();
            if round > 0 {
                making.take(start);
                made += 1;
            } else {
                // What memory costs once.
                first = now() - start;
            }
        }
        let start = now();
        entries.iter_mut().for_each(|numbers| numbers.resize(lists.entries(), P::default()));
        let [x, y, z] = &mut entries;
        lists.place(0..rows, [x, y, z]);
        placing.take(start);
        if round == 0 {
            let energy = energy(&lists, &entries, cutoff) / rows as f64;
            assert!((energy + 6.773_368_053_2).abs() < 1e-10 + 10.0 * P::EPSILON, "{energy}");
        }
        let start = now();
        let [x, y, z] = &mut sums;
        let square = P::from_f64(cutoff * cutoff);
        let of_entries = entries.each_ref().map(Vec::as_slice);
        P::with_lanes(isa, Loop { lists: &lists, places: of_entries, square, sums: [x, y, z] });
        summing.take(start);
        let start = now();
        let kick = if round == 0 { P::from_f64(0.5) * step } else { step };
        for side in 0..3 {
            for ((place, speed), sum) in places[side].iter_mut().zip(&mut speeds[side]).zip(&sums[side]) {
                *speed += *sum * kick;
                *place += *speed * step;
            }
        }
        moving.take(start);
    }
    let all = making.all + following.all + placing.all + summing.all + moving.all;
    let done = (rows * (steps + 1)) as f64;
    let one = |time: Time| format!("{:.1} ns (least {:.2} ms)", time.all * 1e9 / done, time.least * 1e3);
    let report = format!(
        "{} {isa:?}, {width} rows a cluster, skin {skin}: {:.2e} rows and steps a second. Lists {}, made {made} times and \
         first in {:.1} ms, of {:.0} entries; follow {}, place {}, sum {}, move {}",
        P::NAME,
        done / all,
        one(making),
        first * 1e3,
        lists.average(),
        one(following),
        one(placing),
        one(summing),
        one(moving),
    );
    (places, report)
}

#[test]
#[ignore = "times, for a release build: `cargo test --release -p vesper --lib how_long_it_takes -- --ignored --nocapture`"]
fn how_long_it_takes() {
    for isa in Isa::available().into_iter().rev().take(2) {
        for width in [4, 8, 16] {
            println!("{}", melt::<f64>(isa, width, 0.4, 20, 60).1);
        }
        for width in [8, 16] {
            println!("{}", melt::<f32>(isa, width, 0.4, 20, 60).1);
        }
    }
    for skin in [0.2, 0.3, 0.5] {
        println!("{}", melt::<f64>(Isa::detect(), 8, skin, 20, 60).1);
    }
}

/// Where rows are after some steps, by lists of all kinds: 30 steps, of which every few make new lists.
fn one_end<P: Scalar>() {
    let mut expected = None;
    for (number, isa) in Isa::available().into_iter().enumerate() {
        for (width, skin) in [(8, 0.3), (16, 0.05), (3, 0.7)] {
            let (places, _) = melt::<P>(isa, width + number, skin, 5, 30);
            let found: Vec<u64> = places.iter().flatten().map(|place| place.bits()).collect();
            assert!(*expected.get_or_insert_with(|| found.clone()) == found, "{} {isa:?} {width} {skin}", P::NAME);
        }
    }
}

#[test]
fn a_fluid_ends_at_the_same_bits_with_all_lists_and_lanes() {
    one_end::<f64>();
    one_end::<f32>();
}
