//! Kepler steps against closed forms: ellipses, parabolas and hyperbolas, short and long, there and back.

use vesper::prelude::*;
use vesper_laws::kepler_step;

/// A place and a velocity at a time.
#[derive(Clone, Copy, Debug)]
struct Moment {
    time: f64,
    position: DVec3,
    velocity: DVec3,
}

/// x - sin x, or sinh x - x with the other sign, without a difference of neighbours.
fn less(sign: f64, x: f64) -> f64 {
    if x.abs() > 1.0 {
        return if sign < 0.0 { x - x.sin() } else { x.sinh() - x };
    }
    (1..12).rev().fold(0.0, |sum, k| (1.0 + sum) * sign * x * x / f64::from(2 * k * (2 * k + 1))) * x * sign
}

/// About a parameter of 1, of semi-major axis 1, by the eccentric anomaly.
fn ellipse(eccentricity: f64, anomaly: f64) -> Moment {
    let (sine, cosine) = anomaly.sin_cos();
    let width = ((1.0 - eccentricity) * (1.0 + eccentricity)).sqrt();
    // 1 - e cos E, without a difference of neighbours.
    let distance = (1.0 - eccentricity) + 2.0 * eccentricity * (0.5 * anomaly).sin().powi(2);
    Moment {
        time: (1.0 - eccentricity) * anomaly + eccentricity * less(-1.0, anomaly),
        position: DVec3::new((1.0 - eccentricity) - 2.0 * (0.5 * anomaly).sin().powi(2), width * sine, 0.0),
        velocity: DVec3::new(-sine, width * cosine, 0.0) / distance,
    }
}

fn hyperbola(eccentricity: f64, anomaly: f64) -> Moment {
    let (sine, cosine) = (anomaly.sinh(), anomaly.cosh());
    let square = 2.0 * (0.5 * anomaly).sinh().powi(2);
    let width = ((eccentricity - 1.0) * (eccentricity + 1.0)).sqrt();
    let distance = (eccentricity - 1.0) + eccentricity * square;
    Moment {
        time: (eccentricity - 1.0) * anomaly + eccentricity * less(1.0, anomaly),
        position: DVec3::new((eccentricity - 1.0) - square, width * sine, 0.0),
        velocity: DVec3::new(-sine, width * cosine, 0.0) / distance,
    }
}

/// By the tangent of half the true anomaly, at a pericentre of 1/2.
fn parabola(tangent: f64) -> Moment {
    Moment {
        time: 0.5 * (tangent + tangent.powi(3) / 3.0),
        position: DVec3::new(0.5 * (1.0 - tangent * tangent), tangent, 0.0),
        velocity: DVec3::new(-tangent, 1.0, 0.0) * (2.0 / (1.0 + tangent * tangent)),
    }
}

fn stepped(from: Moment, time: f64) -> (DVec3, DVec3) {
    let step = kepler_step(1.0, from.position, from.velocity, time);
    (from.position + step.position, from.velocity + step.velocity)
}

/// Distances in place and velocity, the second as a place: by the speed of a circle there.
fn apart(one: (DVec3, DVec3), other: (DVec3, DVec3), at: Moment) -> f64 {
    let distance = at.position.length();
    (one.0 - other.0).length() / distance + (one.1 - other.1).length() * distance.sqrt()
}

/// What the rounding of what is given makes of the result: one unit in the last place of each number, in turn, and the
/// rounding of the result.
fn floor(from: Moment, time: f64, to: Moment) -> f64 {
    let plain = stepped(from, time);
    let up = 1.0 + f64::EPSILON;
    let mut worst = 4.0 * f64::EPSILON;
    for axis in 0..2 {
        for part in 0..2 {
            let mut other = from;
            let vector = if part == 0 { &mut other.position } else { &mut other.velocity };
            vector[axis] *= up;
            worst = f64::max(worst, apart(stepped(other, time), plain, to));
        }
    }
    // The closed form's times are differences too.
    let rounding = f64::EPSILON * (from.time.abs() + to.time.abs());
    worst.max(apart(stepped(from, time + rounding), plain, to)).max(apart(stepped(from, time * up), plain, to))
}

/// Errors of the steps between all these moments, in what rounding of the input makes of them.
fn worst(name: &str, moments: &[Moment]) -> f64 {
    let mut worst = 0.0;
    for from in moments {
        for to in moments {
            let time = to.time - from.time;
            let floor = floor(*from, time, *to);
            let error = apart(stepped(*from, time), (to.position, to.velocity), *to);
            assert!(error.is_finite(), "{name}: {from:?} to {to:?}");
            worst = f64::max(worst, error / floor);
        }
    }
    println!("{name}: {worst:.1} roundings of the input");
    worst
}

const ANOMALIES: [f64; 15] =
    [-3.1, -2.0, -1.0, -0.3, -0.1, -0.01, -1e-4, 0.0, 1e-3, 0.05, 0.2, 0.7, 1.5, 2.6, core::f64::consts::PI];

#[test]
fn ellipses_are_closed_forms() {
    for eccentricity in [0.0, 0.01, 0.3, 0.9, 0.99, 0.9999] {
        let moments = ANOMALIES.map(|anomaly| ellipse(eccentricity, anomaly));
        let worst = worst(&format!("ellipse {eccentricity}"), &moments);
        assert!(worst < 8.0, "{eccentricity}: {worst}");
    }
}

#[test]
fn parabolas_and_hyperbolas_are_closed_forms() {
    let tangents = [-30.0, -3.0, -1.0, -0.2, -1e-3, 0.0, 1e-4, 0.1, 0.6, 2.0, 10.0, 100.0];
    assert!(worst("parabola", &tangents.map(parabola)) < 8.0);
    for eccentricity in [1.0001, 1.01, 1.5, 3.0, 100.0] {
        let anomalies = [-9.0, -4.0, -1.0, -0.1, -1e-3, 0.0, 1e-3, 0.1, 1.0, 3.0, 8.0];
        let moments = anomalies.map(|anomaly| hyperbola(eccentricity, anomaly));
        let worst = worst(&format!("hyperbola {eccentricity}"), &moments);
        assert!(worst < 8.0, "{eccentricity}: {worst}");
    }
}

#[test]
fn many_revolutions_are_those_of_the_closed_form() {
    for eccentricity in [0.0, 0.3, 0.9, 0.9999] {
        for revolutions in [1.0, 7.0, -7.0, 1000.0, -1e6] {
            for anomaly in [0.0, 0.4, 3.0] {
                let (from, mut to) = (ellipse(eccentricity, 0.2), ellipse(eccentricity, anomaly));
                to.time += revolutions * core::f64::consts::TAU;
                let time = to.time - from.time;
                let error = apart(stepped(from, time), (to.position, to.velocity), to);
                let floor = floor(from, time, to);
                assert!(error < 8.0 * floor, "{eccentricity} {revolutions} {anomaly}: {error:e} of {floor:e}");
            }
        }
    }
}

#[test]
fn there_and_back_is_where_it_was() {
    let starts = [ellipse(0.05, 0.3), ellipse(0.9, 3.0), ellipse(0.9999, 3.1), hyperbola(1.5, -2.0), parabola(-3.0)];
    for from in starts {
        for time in [1e-6, 0.01, 0.3, 2.0, 11.0, 500.0] {
            let (position, velocity) = stepped(from, time);
            let there = Moment { time: from.time + time, position, velocity };
            let back = stepped(there, -time);
            let error = apart(back, (from.position, from.velocity), from);
            let floor = floor(there, -time, from).max(floor(from, time, there));
            assert!(error < 8.0 * floor, "{from:?} {time}: {error:e} of {floor:e}");
        }
    }
}

#[test]
fn without_a_pull_it_is_a_straight_line_and_at_the_centre_no_orbit() {
    let step = kepler_step(0.0, DVec3::X, DVec3::Y, 4.0);
    assert_eq!((step.position, step.velocity), (DVec3::Y * 4.0, DVec3::ZERO));
    assert_eq!(kepler_step(1.0, DVec3::X, DVec3::Y, 0.0).position, DVec3::ZERO);
    assert!(kepler_step(1.0, DVec3::ZERO, DVec3::Y, 1.0).position.is_nan());
    // Straight down: through no point of the centre, back to where it fell from.
    let step = kepler_step(1.0, DVec3::X, DVec3::ZERO, 0.5);
    let fallen = 1.0 + step.position.x;
    // t = sqrt(1/2) (sqrt(r (1 - r)) + arccos sqrt(r)).
    let time = 0.5f64.sqrt() * ((fallen * (1.0 - fallen)).sqrt() + fallen.sqrt().acos());
    assert!((time - 0.5).abs() < 1e-14, "{time}");
}
