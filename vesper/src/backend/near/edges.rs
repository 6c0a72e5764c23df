//! Lists where there is little to list, too much, or nothing that has a place.

use super::tests::{Places, Random, SERIAL, bits, by_all_pairs, by_lists, on_threads, places, slices};
use super::{Lists, Reach, Unfit};
use crate::real::{DoubleDouble, Isa, Scalar};

fn nowhere<P: Scalar>(lengths: [f64; 3]) {
    let mut random = Random(7);
    let mut crowd = places::<P>(40, |_| core::array::from_fn(|_| 3.0 * random.next()));
    let reach = Reach::new(1.0, lengths);
    let mut lists = Lists::with_width(reach, 8).unwrap();
    for isa in Isa::available() {
        for (row, number) in [(3, f64::NAN), (17, f64::INFINITY), (39, f64::NEG_INFINITY), (0, 1e300)] {
            let far = number.abs() < f64::INFINITY;
            if far && P::from_f64(number).is_finite() && lengths == [0.0; 3] {
                continue;
            }
            let before = core::mem::replace(&mut crowd[row % 3][row], P::from_f64(number));
            lists.build(isa, slices(&crowd), SERIAL).unwrap();
            assert!(!lists.follow(isa, slices(&crowd)), "lists with a row that has no place never hold");
            let sums = by_lists(&lists, &crowd, 1.0);
            assert_eq!(sums[row].map(Scalar::to_f64), [0.0; 4], "nobody is near {number}");
            // The others see each other.
            let rest: Places<P> = crowd.each_ref().map(|numbers| {
                let others = numbers.iter().enumerate().filter(|(other, _)| *other != row);
                others.map(|(_, number)| *number).collect()
            });
            let mut others = by_all_pairs(&rest, reach, 1);
            others.insert(row, [P::default(); 4]);
            assert!(bits(&sums) == bits(&others), "{number} in {lengths:?}");
            crowd[row % 3][row] = before;
        }
        lists.build(isa, slices(&crowd), SERIAL).unwrap();
        assert!(lists.follow(isa, slices(&crowd)));
        crowd[2][5] = P::from_f64(f64::NAN);
        assert!(!lists.follow(isa, slices(&crowd)));
        crowd[2][5] = P::from_f64(0.5);
    }
    for numbers in &mut crowd {
        numbers.fill(P::from_f64(f64::NAN));
    }
    lists.build(Isa::detect(), slices(&crowd), SERIAL).unwrap();
    assert_eq!((lists.clusters(), lists.average()), (5, 0.0));
    assert!(by_lists(&lists, &crowd, 1.0).iter().flatten().all(|sum| *sum == P::default()));
}

#[test]
fn rows_without_a_place_are_on_nobodys_list() {
    nowhere::<f64>([0.0; 3]);
    nowhere::<f32>([0.0; 3]);
    nowhere::<f64>([3.0; 3]);
    nowhere::<f32>([0.0, 3.0, 3.0]);
    nowhere::<DoubleDouble>([3.0, 0.0, 3.0]);
}

#[test]
fn what_cannot_be_listed_is_refused() {
    let refused = |reach| Lists::<f64>::new(reach).err();
    for cutoff in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(refused(Reach::new(cutoff, [0.0; 3])), Some(Unfit::Reach));
    }
    assert_eq!(refused(Reach { skin: -0.1, ..Reach::new(1.0, [0.0; 3]) }), Some(Unfit::Reach));
    for length in [-1.0, f64::NAN, f64::NEG_INFINITY] {
        assert_eq!(refused(Reach::new(1.0, [3.0, length, 0.0])), Some(Unfit::Length));
    }
    assert_eq!(refused(Reach::new(1.0, [f64::INFINITY; 3])), None);
    // More images than can be numbered.
    let places = places::<f64>(100, |row| [row as f64, 0.0, 0.0]);
    for lengths in [[1e-9, 0.0, 0.0], [1e-3; 3], [1e-2, 1e-3, 1e-3]] {
        let mut lists = Lists::<f64>::new(Reach::new(1.0, lengths)).unwrap();
        let refused = lists.build(Isa::detect(), slices(&places), SERIAL);
        assert_eq!((refused, lists.clusters()), (Err(Unfit::TooMany), 0), "{lengths:?}");
    }
    // More neighbours than are allowed; the lists can be made afterwards, where rows are somewhere else.
    let mut lists = Lists::<f64>::new(Reach { most: 5000, ..Reach::new(1.0, [0.0; 3]) }).unwrap();
    let crowd = super::tests::places::<f64>(1000, |_| [1.0; 3]);
    for in_parts in [SERIAL, &on_threads] {
        assert_eq!(lists.build(Isa::detect(), slices(&crowd), in_parts), Err(Unfit::TooMany));
        assert!(!lists.follow(Isa::detect(), slices(&crowd)));
        assert_eq!(lists.build(Isa::detect(), slices(&places), in_parts), Ok(()));
        assert!(bits(&by_lists(&lists, &places, 1.0)) == bits(&by_all_pairs(&places, lists.reach, 0)));
    }
}

#[test]
fn rows_that_come_and_go_are_seen() {
    let mut lists = Lists::<f64>::new(Reach::new(1.0, [4.0, 0.0, 4.0])).unwrap();
    for rows in [30, 31, 1, 0, 64, 63] {
        let places = places::<f64>(rows, |row| [0.37 * row as f64, (row % 3) as f64, 0.91 * row as f64]);
        assert!(!lists.follow(Isa::detect(), slices(&places)), "{rows}");
        lists.build(Isa::detect(), slices(&places), SERIAL).unwrap();
        assert!(lists.follow(Isa::detect(), slices(&places)));
        assert!(bits(&by_lists(&lists, &places, 1.0)) == bits(&by_all_pairs(&places, lists.reach, 1)));
    }
}

#[test]
fn numbers_of_rows_are_copied_to_all_their_entries() {
    let places = places::<f64>(50, |row| [0.1 * row as f64, 0.2 * row as f64, 0.0]);
    let mut lists = Lists::<f64>::new(Reach::new(1.0, [3.0, 2.5, 0.0])).unwrap();
    lists.build(Isa::detect(), slices(&places), SERIAL).unwrap();
    assert!(lists.entries() > 50 && lists.entries_of(0..50) == (0..lists.entries()));
    let numbers: Vec<f64> = (0..50).map(f64::from).collect();
    let mut copied = vec![-1.0; lists.entries()];
    for rows in [0..20, 20..20, 20..50, 50..50] {
        lists.spread(rows.clone(), &numbers[rows.clone()], &mut copied[lists.entries_of(rows)]);
    }
    for row in 0..50 {
        assert!(copied[lists.entries_of(row..row + 1)].iter().all(|number| *number == row as f64), "{row}");
    }
    assert!(copied.is_sorted());
}

#[test]
fn lists_pay_where_most_rows_are_out_of_reach() {
    assert!(super::pays(32_000, 180.0, 10.0) && super::pays(1100, 180.0, 1.0));
    assert!(!super::pays(180, 180.0, 1e9) && !super::pays(500, 180.0, 1.0) && !super::pays(0, 0.0, 1.0));
}

#[test]
fn the_unit_of_length_does_not_matter() {
    for unit in [1e-150, 1e-30, 1e30, 1e150] {
        let mut random = Random(8);
        let places = places::<f64>(300, |_| core::array::from_fn(|_| 5.0 * unit * random.next()));
        for lengths in [[0.0; 3], [5.0 * unit; 3]] {
            let mut lists = Lists::<f64>::new(Reach::new(unit, lengths)).unwrap();
            lists.build(Isa::detect(), slices(&places), SERIAL).unwrap();
            let (found, expected) = (by_lists(&lists, &places, unit), by_all_pairs(&places, lists.reach, 1));
            assert!(bits(&found) == bits(&expected) && lists.average() < 100.0, "{unit:e}: {}", lists.average());
        }
    }
}

#[test]
fn a_small_move_in_a_small_unit_is_noticed() {
    for (unit, skin) in [(1e-20, 1e-6), (1.0, 0.0), (1e10, 1e-3)] {
        let reach = Reach { skin: skin * unit, ..Reach::new(unit, [0.0; 3]) };
        let mut lists = Lists::<f32>::new(reach).unwrap();
        let mut places = places::<f32>(40, |row| [0.0, 0.0, unit * row as f64]);
        places[0][7] = (1e-3 * unit) as f32;
        lists.build(Isa::detect(), slices(&places), SERIAL).unwrap();
        assert!(lists.follow(Isa::detect(), slices(&places)), "{unit}");
        places[0][7] *= 2.0;
        assert!(!lists.follow(Isa::detect(), slices(&places)), "{unit}");
    }
}
