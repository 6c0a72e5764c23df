//! Symplectic correctors: what the start of a run is changed by, and the end back, so that the steps between keep an energy
//! that is nearer to the true one.
//!
//! In: the order that is asked for. Out: drifts and kicks, in parts of a step. Never: a change that adds up; what a corrector
//! does at the start is undone at the end.
//!
//! To first order in the disturbances, a step drift(1/2) kick(1) drift(1/2) is that of a disturbance changed by (z/2) /
//! sinh(z/2), with z = step times the derivative along the orbit. A pair drift(a) kick(b) drift(-2a) kick(-2b) drift(2a)
//! kick(b) drift(-a) changes variables by 4 b sinh(a z). The sum of pairs with a = k sqrt(7/40), k = 1, 2, ..., of which the b
//! below solve for ((z/2) / sinh(z/2) - 1) / z up to the power that the order says, takes the change away.
//!
//! Sources: Wisdom, Holman, Touma, Fields Inst. Commun. 10 (1996) 217; Wisdom, AJ 131 (2006) 2294, for a and orders to 17.

/// sqrt(7/40)
const SPACING: f64 = 0.418_330_013_267_037_8;

const THIRD: &[f64] = &[-0.024_900_596_027_799_868];
const FIFTH: &[f64] = &[-0.041_500_993_379_666_446, 0.008_300_198_675_933_289];
const SEVENTH: &[f64] = &[-0.053_964_399_093_127_5, 0.018_270_923_246_702_13, -0.002_492_681_142_692_210_6];
const ELEVENTH: &[f64] = &[
    -0.072_593_394_748_842_74,
    0.038_121_613_681_288_65,
    -0.012_309_078_592_019_946,
    0.002_348_721_529_229_535_4,
    -0.000_203_615_796_478_546_5,
];
const SEVENTEENTH: &[f64] = &[
    -0.093_056_103_771_425_96,
    0.065_192_863_576_377_9,
    -0.032_422_198_864_713_58,
    0.012_071_760_822_342_29,
    -0.003_313_257_706_938_065_6,
    0.000_635_999_830_758_176_6,
    -7.643_635_522_793_574e-5,
    4.334_741_547_337_358e-6,
];

/// The orders that there are; 0 is none.
pub(super) const ORDERS: [u32; 6] = [0, 3, 5, 7, 11, 17];

/// A drift and the kick after it, in parts of a step.
pub(super) type Stage = [f64; 2];

/// The drifts and kicks of the corrector of this order, or of what undoes it; the last kick is 0.
pub(super) fn stages(order: u32, undoes: bool) -> Vec<Stage> {
    let kicks = match order {
        0..=2 => return Vec::new(),
        3..=4 => THIRD,
        5..=6 => FIFTH,
        7..=10 => SEVENTH,
        11..=16 => ELEVENTH,
        _ => SEVENTEENTH,
    };
    let mut stages = Vec::new();
    // What is left to drift from the pair before.
    let mut left = 0.0;
    for (number, b) in kicks.iter().enumerate().rev() {
        let a = SPACING * (number + 1) as f64;
        stages.extend([[left + a, *b], [-2.0 * a, -2.0 * b], [2.0 * a, *b]]);
        left = -a;
    }
    stages.push([left, 0.0]);
    if undoes {
        let drifts: Vec<f64> = stages.iter().rev().map(|[drift, _]| -drift).collect();
        let kicks = stages.iter().rev().skip(1).map(|[_, kick]| -kick).chain([0.0]);
        return drifts.into_iter().zip(kicks).map(|(drift, kick)| [drift, kick]).collect();
    }
    stages
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_order_takes_away_what_it_says() {
        // Coefficients of z, z^3, ... in ((z/2) / sinh(z/2) - 1) / z, by Bernoulli's numbers.
        let wanted = [-1.0 / 24.0, 7.0 / 5760.0, -31.0 / 967_680.0, 127.0 / 154_828_800.0];
        for order in [3, 5, 7, 11, 17] {
            let stages = stages(order, false);
            let mut moments = [0.0; 4];
            let mut at = 0.0;
            for [drift, kick] in &stages {
                at += drift;
                let mut power = at;
                let mut factorial = 1.0;
                for (k, moment) in moments.iter_mut().enumerate() {
                    *moment += kick * power / factorial;
                    power *= at * at;
                    factorial *= ((2 * k + 2) * (2 * k + 3)) as f64;
                }
            }
            assert!(at.abs() < 1e-15, "{order}: nothing is left to drift");
            let pairs = (order as usize - 1) / 2;
            for (k, (moment, wanted)) in moments.iter().zip(wanted).take(pairs).enumerate() {
                // A pair is 4 b sinh(a z) as its kicks are counted here: twice, and twice again for -2b.
                assert!((moment / wanted - 1.0).abs() < 1e-12, "{order}: power {}: {moment} of {wanted}", 2 * k + 1);
            }
        }
    }

    #[test]
    fn what_undoes_a_corrector_is_its_mirror() {
        let (there, back) = (stages(7, false), stages(7, true));
        assert_eq!(there.len(), back.len());
        let all: Vec<f64> = there.iter().chain(&back).flatten().copied().collect();
        let sum: f64 = all.iter().sum();
        assert!(sum.abs() < 1e-15 && ORDERS.contains(&7));
    }
}
