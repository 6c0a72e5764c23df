//! C7 a to g: two bodies on a damped spring, and two without one.

use super::{BODIES, Phase, Problem, damped_oscillation};
use crate::{Damper, Motion, Spring, UniformGravity};
use vesper::prelude::*;

/// Two bodies that start at (-10, 5, 0) and (10, 5, 0), joined by a spring of rest length 10 and damping 10, or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// "a" to "g".
    pub case: &'static str,
    /// Masses, in kg.
    pub masses: [f64; 2],
    /// Velocities at time 0, in m/s.
    pub velocities: [[f64; 3]; 2],
    /// Stiffness of the spring, in N/m, where there is one.
    pub stiffness: Option<f64>,
    /// Whether (0, 0, -9.81) m/s^2 acts.
    pub gravity: bool,
}

const START: [[f64; 3]; 2] = [[-10.0, 5.0, 0.0], [10.0, 5.0, 0.0]];
const GRAVITY: DVec3 = DVec3::new(0.0, 0.0, -9.81);
const DAMPING: f64 = 10.0;
const REST_LENGTH: f64 = 10.0;
const REFERENCES: &str = include_str!("pairs.csv");

/// The seven cases.
pub const fn pairs() -> [Pair; 7] {
    const REST: [f64; 3] = [0.0; 3];
    const UP: [f64; 3] = [0.0, 0.0, 15.0];
    const fn pair(case: &'static str, velocities: [[f64; 3]; 2]) -> Pair {
        Pair { case, masses: [1.0, 1.0], velocities, stiffness: Some(100.0), gravity: false }
    }
    [
        pair("a", [REST, REST]),
        pair("b", [[0.0, -10.0, 0.0], [0.0, 10.0, 0.0]]),
        pair("c", [REST, [0.0, 10.0, 0.0]]),
        Pair { masses: [10.0, 1.0], ..pair("d", [[0.0, 3.0, 0.0], REST]) },
        Pair { stiffness: None, gravity: true, ..pair("e", [[10.0, 0.0, 30.0], [-20.0, 0.0, 20.0]]) },
        Pair { gravity: true, ..pair("f", [UP, UP]) },
        Pair { stiffness: Some(30.0), gravity: true, ..pair("g", [UP, UP]) },
    ]
}

impl Pair {
    /// Where everything is by a closed form: there is one where the spring does not turn.
    pub fn closed_form(&self, time: f64) -> Option<Vec<Phase>> {
        let [a, b] = self.velocities.map(DVec3::from_array);
        let turns = (b - a).cross(DVec3::X) != DVec3::ZERO;
        if self.stiffness.is_some() && turns {
            return None;
        }
        let gravity = if self.gravity { GRAVITY } else { DVec3::ZERO };
        let fall = |place: [f64; 3], velocity: DVec3| Phase {
            position: DVec3::from_array(place) + velocity * time + gravity * (0.5 * time * time),
            velocity: velocity + gravity * time,
        };
        let mut phases = vec![fall(START[0], a), fall(START[1], b)];
        if let Some(stiffness) = self.stiffness {
            // The distance oscillates as a mass of m_0 m_1 / (m_0 + m_1) on the spring does; the rows share what it changes.
            let shares = [-self.masses[1], self.masses[0]].map(|mass| mass / (self.masses[0] + self.masses[1]));
            let per_mass = 1.0 / self.masses[0] + 1.0 / self.masses[1];
            let start = (START[1][0] - START[0][0] - REST_LENGTH, (b - a).x);
            let decay = 0.5 * DAMPING * per_mass;
            let (out, speed) = damped_oscillation(stiffness * per_mass, decay, start, time);
            for (phase, share) in phases.iter_mut().zip(shares) {
                phase.position.x += share * (out - start.0 - start.1 * time);
                phase.velocity.x += share * (speed - start.1);
            }
        }
        Some(phases)
    }

    /// Where everything is at a reference time, in s.
    pub fn reference(&self, time: f64) -> Option<Vec<Phase>> {
        let rows: Vec<Phase> = self.samples().filter(|(at, _)| (at - time).abs() < 1e-9).map(|(_, row)| row).collect();
        (rows.len() == 2).then_some(rows)
    }

    /// Times and rows of the reference solution.
    fn samples(&self) -> impl Iterator<Item = (f64, Phase)> {
        let case = self.case;
        REFERENCES.lines().filter_map(move |line| {
            let numbers = line.strip_prefix(case)?.strip_prefix(',')?;
            let numbers: Vec<f64> = numbers.split(',').map_while(|number| number.parse().ok()).collect();
            let [time, _row, rest @ ..] = numbers.as_slice() else { return None };
            let phase =
                Phase { position: DVec3::from_slice(rest.get(0..3)?), velocity: DVec3::from_slice(rest.get(3..6)?) };
            Some((*time, phase))
        })
    }
}

impl Problem for Pair {
    fn name(&self) -> String {
        format!("pair_{}", self.case)
    }

    fn setup<P: Precision>(&self, mut builder: Builder<P>) -> Builder<P> {
        let bodies = Domain::new(BODIES).with(Position, START).with(Velocity, self.velocities).with(Mass, self.masses);
        builder = builder.domain(bodies).law(Motion);
        if let Some(stiffness) = self.stiffness {
            let springs = Domain::new("springs")
                .link(Ends, BODIES, [[0, 1]])
                .with(Stiffness, [stiffness])
                .with(Damping, [DAMPING])
                .with(RestLength, [REST_LENGTH]);
            builder = builder.domain(springs).law(Spring).law(Damper);
        }
        if self.gravity {
            builder = builder.constant(GravityAcceleration, [GRAVITY]).law(UniformGravity);
        }
        builder
    }

    fn exact(&self, time: f64) -> Option<Vec<Phase>> {
        self.closed_form(time).or_else(|| self.reference(time))
    }

    fn times(&self) -> Vec<f64> {
        let mut times: Vec<f64> = self.samples().map(|(time, _)| time).collect();
        times.dedup();
        times
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_forms_and_references_agree() {
        let mut compared = 0;
        for pair in pairs() {
            assert!(pair.times().len() >= 3, "{}", pair.case);
            for time in pair.times() {
                let reference = pair.reference(time).unwrap();
                let Some(exact) = pair.closed_form(time) else { continue };
                for (exact, reference) in exact.iter().zip(&reference) {
                    assert!((exact.position - reference.position).length() < 2e-14 * 130.0, "{} at {time}", pair.case);
                    assert!((exact.velocity - reference.velocity).length() < 2e-14 * 50.0, "{} at {time}", pair.case);
                    compared += 1;
                }
            }
        }
        // Four times of a, three each of e, f and g, two rows.
        assert_eq!(compared, 2 * (4 + 3 + 3 + 3));
    }
}
