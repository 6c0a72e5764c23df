//! Lists against all pairs, bit by bit: whatever the age of the lists, the lanes, the clusters, the threads and the box.

use super::period::Period;
use super::{InParts, Lists, Reach};
use crate::real::{DoubleDouble, Isa, Scalar};
use std::ops::Range;

/// One after the other.
pub(super) const SERIAL: InParts<'static> = &|count, work| work(0..count);

/// Numbers from 0 to 1, the same in every run.
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

pub(super) type Places<P> = [Vec<P>; 3];

pub(super) fn slices<P>(places: &Places<P>) -> [&[P]; 3] {
    places.each_ref().map(Vec::as_slice)
}

pub(super) fn places<P: Scalar>(rows: usize, mut place: impl FnMut(usize) -> [f64; 3]) -> Places<P> {
    let mut places: Places<P> = Default::default();
    for row in 0..rows {
        for (numbers, number) in places.iter_mut().zip(place(row)) {
            numbers.push(P::from_f64(number));
        }
    }
    places
}

/// A body: what a partner that is so far away adds, a number in each direction, and one that is not 0 at distance 0.
fn share<P: Scalar>([x, y, z]: [P; 3], cutoff: P, sum: &mut [P; 4]) {
    let square = x * x + y * y + z * z;
    if square < cutoff * cutoff {
        let part = P::lit(1.0) / (square + cutoff);
        for (sum, share) in sum.iter_mut().zip([x * part, y * part, z * part, part]) {
            *sum += share;
        }
    } else {
        // What `select` does.
        sum.iter_mut().for_each(|sum| *sum += P::lit(0.0));
    }
}

pub(super) fn bits<P: Scalar>(sums: &[[P; 4]]) -> Vec<[u64; 4]> {
    sums.iter().map(|sums| sums.map(Scalar::bits)).collect()
}

/// The sums of all rows by lists.
pub(super) fn by_lists<P: Scalar>(lists: &Lists<P>, places: &Places<P>, cutoff: f64) -> Vec<[P; 4]> {
    let mut spread: Places<P> = [const { Vec::new() }; 3].map(|_: Vec<P>| vec![P::default(); lists.entries()]);
    if lists.is_plain() {
        (0..3).for_each(|side| lists.spread(0..places[side].len(), &places[side], &mut spread[side]));
    } else {
        // In two parts, as two threads would.
        let rows = places[0].len();
        let [x, y, z] = spread.each_mut().map(|numbers| numbers.split_at_mut(lists.entries_of(0..rows / 2).len()));
        lists.place(0..rows / 2, [x.0, y.0, z.0]);
        lists.place(rows / 2..rows, [x.1, y.1, z.1]);
    }
    let mut sums = vec![None; places[0].len()];
    for number in 0..lists.clusters() {
        let cluster = lists.cluster(number);
        assert!(cluster.rows.is_sorted_by(|a, b| a < b) && cluster.list.is_sorted_by(|a, b| a < b));
        assert!(!cluster.rows.is_empty() && cluster.rows.len() <= lists.width());
        for (lane, row) in cluster.rows.iter().enumerate() {
            let mut sum = [P::lit(0.0); 4];
            if let Some(own) = cluster.own.get(lane) {
                let i = cluster.list[*own as usize] as usize;
                for (at, j) in cluster.list.iter().enumerate() {
                    if at != *own as usize {
                        let apart = core::array::from_fn(|side| spread[side][*j as usize] - spread[side][i]);
                        share(apart, P::from_f64(cutoff), &mut sum);
                    }
                }
            }
            assert!(sums[*row as usize].replace(sum).is_none(), "row {row} is in two clusters");
        }
    }
    sums.into_iter().map(|sum| sum.expect("every row is in a cluster")).collect()
}

/// The sums of all rows by all pairs of all images, ascending, each row brought into the box anew.
pub(super) fn by_all_pairs<P: Scalar>(places: &Places<P>, reach: Reach, images: i32) -> Vec<[P; 4]> {
    let beyond = 1.01 * (reach.cutoff + 2.0 * reach.skin);
    let periods = reach.lengths.map(|length| (length != 0.0).then(|| Period::<P>::new(length, beyond).unwrap()));
    let place = |row: usize| -> [P; 3] {
        core::array::from_fn(|side| {
            let place = places[side][row];
            periods[side].map_or(place, |period| period.turns(place).map_or(place, |turns| period.moved(place, turns)))
        })
    };
    let range = |side: usize| if periods[side].is_some() { -images..=images } else { 0..=0 };
    let moved = |place: [P; 3], by: [i32; 3]| -> [P; 3] {
        core::array::from_fn(|side| periods[side].map_or(place[side], |period| place[side] + period.times(by[side])))
    };
    let inside: Vec<_> = (0..places[0].len()).map(place).collect();
    let mut sums = vec![[P::lit(0.0); 4]; inside.len()];
    for (i, sum) in sums.iter_mut().enumerate() {
        for (j, place) in inside.iter().enumerate() {
            for x in range(0) {
                for y in range(1) {
                    for z in range(2) {
                        if i == j && [x, y, z] == [0; 3] {
                            continue;
                        }
                        let j = moved(*place, [x, y, z]);
                        let apart = core::array::from_fn(|side| j[side] - inside[i][side]);
                        share(apart, P::from_f64(reach.cutoff), sum);
                    }
                }
            }
        }
    }
    sums
}

/// Places of different kinds.
fn crowds<P: Scalar>(rows: usize) -> Vec<(&'static str, Places<P>)> {
    let mut random = Random(rows as u64);
    let mut any = |size: f64| -> [f64; 3] { core::array::from_fn(|_| size * (random.next() - 0.3)) };
    vec![
        ("a crowd", places(rows, |_| any(6.0))),
        ("thin air", places(rows, |_| any(1e9))),
        ("two crowds far apart", places(rows, |row| any(3.0).map(|number| number + 1e6 * (row % 2) as f64))),
        ("crowds in crowds", places(rows, |row| any(10_f64.powi((row % 9) as i32 - 4)))),
        ("one place", places(rows, |_| [1.5, -2.5, 1e3])),
        ("a line", places(rows, |row| [0.25 * row as f64, 0.0, 0.0])),
        ("a lattice", places(rows, |row| [(row % 5) as f64, (row / 5 % 5) as f64, (row / 25) as f64])),
    ]
}

fn without_periods<P: Scalar>(all: &[usize]) {
    for &rows in all {
        for (name, places) in crowds::<P>(rows) {
            for (number, isa) in Isa::available().into_iter().enumerate() {
                let reach = Reach { skin: [0.0, 0.3, 0.05, 2.0][number % 4], ..Reach::new(1.0, [0.0; 3]) };
                let mut lists = Lists::<P>::with_width(reach, [8, 1, 16, 5][number % 4]).unwrap();
                assert!(rows == 0 || !lists.follow(isa, slices(&places)));
                lists.build(isa, slices(&places), SERIAL).unwrap();
                assert!(lists.follow(isa, slices(&places)));
                let (found, expected) = (by_lists(&lists, &places, 1.0), by_all_pairs(&places, reach, 0));
                assert!(bits(&found) == bits(&expected), "{} {isa:?}: {rows} rows, {name}", P::NAME);
            }
        }
    }
}

#[test]
fn sums_are_those_of_all_pairs() {
    let rows = [0, 1, 2, 3, 7, 8, 9, 17, 100, 130, 400];
    without_periods::<f64>(&rows);
    without_periods::<f32>(&rows);
    without_periods::<DoubleDouble>(&[0, 1, 9, 100]);
}

/// Rows that wander, in a box or out of it, and lists that are made when they do not hold.
fn wander<P: Scalar>(reach: Reach, rows: usize, images: i32, width: usize, far: f64) {
    let mut random = Random(far.to_bits() ^ rows as u64);
    let size = reach.lengths.map(|length| if length == 0.0 { 7.0 } else { length });
    let mut places: Places<P> =
        places(rows, |_| size.map(|size| size * (random.next() + (far * (random.next() - 0.5)).round())));
    let isas = Isa::available();
    let mut lists = Lists::<P>::with_width(reach, width).unwrap();
    let mut made = 0;
    let steps = 24;
    for step in 0..steps {
        let isa = isas[step % isas.len()];
        if !lists.follow(isa, slices(&places)) {
            lists.build(isa, slices(&places), SERIAL).unwrap();
            made += 1;
        }
        let found = bits(&by_lists(&lists, &places, reach.cutoff));
        let mut fresh = Lists::<P>::with_width(Reach { skin: reach.skin, ..reach }, 2 * width).unwrap();
        fresh.build(isa, slices(&places), SERIAL).unwrap();
        assert!(found == bits(&by_lists(&fresh, &places, reach.cutoff)), "{reach:?}, step {step}: fresh lists");
        if step % 6 == 5 || step == 1 {
            let expected = bits(&by_all_pairs(&places, reach, images));
            assert!(found == expected, "{} {reach:?} step {step}: all pairs", P::NAME);
        }
        for place in places.iter_mut().flatten() {
            *place += P::from_f64(0.2 * reach.skin * (random.next() - 0.45));
        }
    }
    assert!((3..steps - 3).contains(&made), "lists were made {made} times");
}

#[test]
fn sums_do_not_depend_on_the_age_of_lists() {
    let reach = Reach { skin: 0.4, ..Reach::new(1.2, [0.0; 3]) };
    wander::<f64>(reach, 250, 0, 8, 0.0);
    wander::<f32>(reach, 250, 0, 4, 0.0);
}

#[test]
fn sums_do_not_depend_on_the_box_that_a_row_is_counted_in() {
    for far in [0.0, 9.0] {
        for lengths in [[5.3, 6.1, 4.7], [5.3, 0.0, 0.0], [0.0, 4.0, 4.9], [3.3, 3.3, 3.3]] {
            let reach = Reach { skin: 0.4, ..Reach::new(1.2, lengths) };
            wander::<f64>(reach, 150, 1, 8, far);
            wander::<f32>(reach, 150, 1, 8, far);
        }
    }
}

#[test]
fn a_row_sees_all_images_in_a_small_box_and_its_own_too() {
    for lengths in [[0.9, 1.1, 0.7], [0.5, 0.0, 8.0]] {
        let reach = Reach { skin: 0.2, ..Reach::new(1.3, lengths) };
        wander::<f64>(reach, 12, 5, 4, 5.0);
        wander::<f32>(reach, 12, 5, 8, 5.0);
    }
    // One row alone in a box of length 1 sees itself at distance 1 six times, at the square root of 2 twelve times.
    let reach = Reach::new(1.5, [1.0; 3]);
    let place = places::<f64>(1, |_| [123.4, -0.5, 0.5]);
    let mut lists = Lists::new(reach).unwrap();
    lists.build(Isa::detect(), slices(&place), SERIAL).unwrap();
    let sum = by_lists(&lists, &place, 1.5)[0];
    assert!((sum[3] - (6.0 / 2.5 + 12.0 / 3.5)).abs() < 1e-12 && sum[0].abs() < 1e-12, "{sum:?}");
}

#[test]
fn lists_have_all_within_reach_and_nobody_else() {
    let mut random = Random(5);
    let places = places::<f64>(700, |_| core::array::from_fn(|_| 9.0 * random.next()));
    let reach = Reach { skin: 0.5, ..Reach::new(1.5, [0.0; 3]) };
    let mut lists = Lists::new(reach).unwrap();
    lists.build(Isa::detect(), slices(&places), SERIAL).unwrap();
    let square = |i: u32, j: u32| -> f64 {
        places.iter().map(|numbers| (numbers[i as usize] - numbers[j as usize]).powi(2)).sum()
    };
    let mut total = 0;
    for cluster in (0..lists.clusters()).map(|number| lists.cluster(number)) {
        let near: Vec<u32> = (0..700).filter(|j| cluster.rows.iter().any(|i| square(*i, *j) <= 4.0)).collect();
        assert_eq!(cluster.list, near);
        total += near.len();
    }
    assert!((lists.average() - total as f64 / 88.0).abs() < 1e-9);
}

/// What all lists have in them.
fn contents<P: Scalar>(lists: &Lists<P>) -> Vec<[Vec<u32>; 3]> {
    let clusters = (0..lists.clusters()).map(|number| lists.cluster(number));
    clusters.map(|cluster| [cluster.rows, cluster.list, cluster.own].map(<[u32]>::to_vec)).collect()
}

/// One thread for each part.
pub(super) fn on_threads(count: usize, work: &(dyn Fn(Range<usize>) + Sync)) {
    std::thread::scope(|scope| {
        for part in 0..count {
            scope.spawn(move || work(part..part + 1));
        }
    });
}

#[test]
fn lists_do_not_depend_on_threads_or_lanes() {
    let mut random = Random(6);
    let places = places::<f32>(2000, |_| core::array::from_fn(|_| 12.0 * random.next()));
    let reach = Reach::new(1.5, [12.0; 3]);
    let mut expected = None;
    for isa in Isa::available() {
        for in_parts in [SERIAL, &on_threads] {
            let mut lists = Lists::with_width(reach, 16).unwrap();
            lists.build(isa, slices(&places), in_parts).unwrap();
            let found = contents(&lists);
            assert!(expected.get_or_insert_with(|| found.clone()) == &found, "{isa:?}");
        }
    }
}

/// Pairs all over the place, each just within the cut-off and the skin, that then close in as far as lists allow.
fn close_in<P: Scalar>(lengths: [f64; 3], within: f64) {
    let mut random = Random(10);
    let reach = Reach { skin: 0.5, ..Reach::new(1.0, lengths) };
    let apart: Vec<[f64; 3]> = (0..200)
        .map(|_| {
            let towards: [f64; 3] = core::array::from_fn(|_| random.next() - 0.5);
            let length = towards.iter().map(|side| side * side).sum::<f64>().sqrt();
            towards.map(|side| side / length)
        })
        .collect();
    // The middle of a pair, none near another's, and one half of a distance from there.
    let pairs = |distance: f64| {
        places::<P>(400, |row| {
            let (pair, sign) = (row / 2, [-0.5, 0.5][row % 2]);
            let middle = [(pair % 6) as f64 * 4.0 + 0.1, (pair / 6 % 6) as f64 * 4.0 + 0.3, (pair / 36) as f64 * 4.0];
            core::array::from_fn(|side| middle[side] + sign * distance * apart[pair][side])
        })
    };
    let mut lists = Lists::<P>::with_width(reach, 1).unwrap();
    lists.build(Isa::detect(), slices(&pairs(1.5 - within)), SERIAL).unwrap();
    let listed = (0..400).filter(|number| lists.cluster(*number).list.len() == 2).count();
    assert_eq!(listed, 400, "{}: everybody's partner is listed", P::NAME);
    let closer = pairs(1.0 - within / 2.0);
    assert!(lists.follow(Isa::detect(), slices(&closer)), "{}", P::NAME);
    assert!(by_lists(&lists, &closer, 1.0).iter().all(|sum| sum[3] > P::default()));
    assert!(!lists.follow(Isa::detect(), slices(&pairs(1.0 - 4.0 * within))), "{}", P::NAME);
}

#[test]
fn pairs_that_close_in_are_seen_as_long_as_lists_hold() {
    for lengths in [[0.0; 3], [24.0; 3]] {
        close_in::<f64>(lengths, 1e-12);
        close_in::<f32>(lengths, 3e-5);
    }
}
