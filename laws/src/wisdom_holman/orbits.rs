//! Jacobi coordinates: each row relative to the centre of mass of all rows before it, and the centre of mass of all.
//!
//! In: rows in the order of their numbers, but for the heaviest one, which is the first. Out: places, velocities and rates
//! relative to each other, and back. Never: a law, or a force but the pull by which a row goes round those before it.
//!
//! Source: Plummer, An Introductory Treatise on Dynamical Astronomy (1918), 224; Rein, Tamayo, MNRAS 452 (2015) 376, 2.2.

/// The most lanes of f64 that there are; arrays end with as many rows that do not matter.
pub(super) const LANES: usize = 16;

/// Vectors of all rows, component by component, with what rounding lost.
#[derive(Clone, Debug, Default)]
pub(super) struct Numbers {
    pub(super) sums: [Vec<f64>; 3],
    pub(super) errors: [Vec<f64>; 3],
}

/// One number with what rounding lost.
#[derive(Clone, Copy, Debug, Default)]
struct Kept {
    sum: f64,
    error: f64,
}

/// Rows that go round those before them.
#[derive(Clone, Debug, Default)]
pub(super) struct Orbits {
    pub(super) position: Numbers,
    pub(super) velocity: Numbers,
    /// The parameter of the mass that a row goes round, its own included, in m^3/s^2.
    pub(super) parameters: Vec<f64>,
    /// This parameter by the cube of the distance, where disturbances are taken.
    pulls: Vec<f64>,
    /// How many rows there are; arrays are longer.
    pub(super) rows: usize,
    /// Place and velocity of the centre of mass.
    centre: [[Kept; 3]; 2],
}

/// How masses are shared.
#[derive(Clone, Debug, Default)]
pub(super) struct Hierarchy {
    /// The number of each row, the heaviest first.
    order: Vec<usize>,
    /// The part that each row has in the mass of itself and those before it.
    shares: Vec<f64>,
    /// The parameter of this mass, in m^3/s^2.
    parameters: Vec<f64>,
}

/// Which vectors of the rows are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Which {
    Position,
    Velocity,
}

fn add(to: &mut f64, error: &mut f64, change: f64) {
    let change = change - *error;
    let after = *to + change;
    *error = (after - *to) - change;
    *to = after;
}

impl Hierarchy {
    /// Of rows with these gravitational parameters, of which one is above 0.
    pub(super) fn new(parameters: &[f64]) -> Self {
        let heavier = |best: usize, row: usize| if parameters[row] > parameters[best] { row } else { best };
        let first = (0..parameters.len()).reduce(heavier).unwrap_or(0);
        let order: Vec<usize> =
            core::iter::once(first).chain((0..parameters.len()).filter(|row| *row != first)).collect();
        let mut inner = 0.0;
        let sums: Vec<f64> = order
            .iter()
            .map(|row| {
                inner += parameters[*row];
                inner
            })
            .collect();
        let shares = order.iter().zip(&sums).map(|(row, sum)| parameters[*row] / sum).collect();
        Hierarchy { order, shares, parameters: sums }
    }

    pub(super) fn rows(&self) -> usize {
        self.order.len()
    }

    /// Whether the first row is heavier than all others together.
    pub(super) fn is_dominated(&self) -> bool {
        match self.parameters[..] {
            [first, .., all] => first > 0.5 * all,
            _ => true,
        }
    }

    /// Vectors of all rows, component by component, relative to those before them, each to its `give`; the centre's is given
    /// back. The three components go side by side: each is a chain of sums.
    fn relative(&self, of: &[f64], mut give: impl FnMut(usize, [f64; 3])) -> [f64; 3] {
        let [x, y, z] = components(of, self.rows());
        let at = |row: usize| [x[row], y[row], z[row]];
        let mut centre = at(self.order[0]);
        for (k, (row, share)) in self.order.iter().zip(&self.shares).enumerate().skip(1) {
            let of = at(*row);
            let relative = [0, 1, 2].map(|c| of[c] - centre[c]);
            give(k - 1, relative);
            centre = [0, 1, 2].map(|c| centre[c] + share * relative[c]);
        }
        centre
    }
}

/// The three components of vectors of so many rows.
fn components(of: &[f64], rows: usize) -> [&[f64]; 3] {
    let (x, rest) = of.split_at(rows);
    let (y, rest) = rest.split_at(rows);
    [x, y, &rest[..rows]]
}

fn components_mut(of: &mut [f64], rows: usize) -> [&mut [f64]; 3] {
    let (x, rest) = of.split_at_mut(rows);
    let (y, rest) = rest.split_at_mut(rows);
    [x, y, &mut rest[..rows]]
}

impl Orbits {
    /// Rows with these places and velocities, each component by component.
    pub(super) fn new(hierarchy: &Hierarchy, position: &[f64], velocity: &[f64]) -> Self {
        let long = (hierarchy.rows() - 1).next_multiple_of(LANES);
        let zeros = || [0, 1, 2].map(|_| vec![0.0; long]);
        let numbers = || Numbers { sums: zeros(), errors: zeros() };
        let mut orbits = Orbits { position: numbers(), velocity: numbers(), ..Orbits::default() };
        // What fills the lanes stays where it is.
        orbits.position.sums[0].fill(1.0);
        orbits.share(hierarchy);
        for (part, (of, numbers)) in
            [(position, &mut orbits.position), (velocity, &mut orbits.velocity)].into_iter().enumerate()
        {
            let centre = hierarchy.relative(of, |k, relative| {
                numbers.sums.iter_mut().zip(relative).for_each(|(sums, relative)| sums[k] = relative);
            });
            orbits.centre[part] = centre.map(|sum| Kept { sum, error: 0.0 });
        }
        orbits
    }

    /// Takes the parameters of a hierarchy; whether it has as many rows.
    pub(super) fn share(&mut self, hierarchy: &Hierarchy) -> bool {
        let (rows, long) = (hierarchy.rows() - 1, self.position.sums[0].len());
        if long != rows.next_multiple_of(LANES) {
            return false;
        }
        self.rows = rows;
        self.parameters = vec![0.0; long];
        self.pulls = vec![0.0; long];
        self.parameters[..rows].copy_from_slice(&hierarchy.parameters[1..]);
        true
    }

    /// The centre of mass goes on.
    pub(super) fn drift_centre(&mut self, time: f64) {
        let [position, velocity] = &mut self.centre;
        for (position, velocity) in position.iter_mut().zip(velocity) {
            add(&mut position.sum, &mut position.error, velocity.sum * time);
        }
    }

    /// Takes the rows of others, with places moved by so much of disturbances, and velocities, where there is a second
    /// factor.
    pub(super) fn follow(&mut self, others: &Orbits, factors: &[f64], disturbances: &[f64]) {
        if self.rows != others.rows {
            *self = others.clone();
        }
        let by = components(disturbances, others.rows + 1);
        let parts = [(&mut self.position, &others.position), (&mut self.velocity, &others.velocity)];
        for (part, ((to, of), factor)) in parts.into_iter().zip(factors).enumerate() {
            for (c, by) in by.into_iter().enumerate() {
                self.centre[part][c].sum = others.centre[part][c].sum + factor * by[0];
                let rows = to.sums[c].iter_mut().zip(&of.sums[c]).zip(&by[1..]);
                rows.for_each(|((to, of), by)| *to = of + factor * by);
            }
        }
    }

    /// Where each row is, or how fast: to every row by its number, component by component.
    pub(super) fn absolute(&self, hierarchy: &Hierarchy, which: Which, to: &mut [f64]) {
        let rows = hierarchy.rows();
        let (numbers, centre) = match which {
            Which::Position => (&self.position, &self.centre[0]),
            Which::Velocity => (&self.velocity, &self.centre[1]),
        };
        let [x, y, z] = &numbers.sums;
        let [to_x, to_y, to_z] = components_mut(to, rows);
        let mut put = |row: usize, vector: [f64; 3]| [to_x[row], to_y[row], to_z[row]] = vector;
        let mut middle = centre.map(|kept| kept.sum);
        for k in (1..rows).rev() {
            let relative = [x[k - 1], y[k - 1], z[k - 1]];
            let share = hierarchy.shares[k];
            middle = [0, 1, 2].map(|c| middle[c] - share * relative[c]);
            put(hierarchy.order[k], [0, 1, 2].map(|c| middle[c] + relative[c]));
        }
        put(hierarchy.order[0], middle);
    }

    /// What is left of the rates of all rows' velocities when their pull to those before them is taken off, the centre's first,
    /// component by component.
    pub(super) fn disturbances(&mut self, hierarchy: &Hierarchy, rates: &[f64], to: &mut [f64]) {
        let rows = hierarchy.rows();
        let [x, y, z] = self.position.sums.each_ref().map(|sums| &sums[..rows - 1]);
        let (pulls, parameters) = (&mut self.pulls[..rows - 1], &self.parameters[..rows - 1]);
        // A loop of its own, so that roots and quotients of several rows are taken side by side.
        for k in 0..rows - 1 {
            let square = x[k] * x[k] + y[k] * y[k] + z[k] * z[k];
            pulls[k] = parameters[k] / (square * square.sqrt());
        }
        let [to_x, to_y, to_z] = components_mut(to, rows);
        let [centre_x, centre_y, centre_z] = hierarchy.relative(rates, |k, rate| {
            to_x[k + 1] = rate[0] + pulls[k] * x[k];
            to_y[k + 1] = rate[1] + pulls[k] * y[k];
            to_z[k + 1] = rate[2] + pulls[k] * z[k];
        });
        (to_x[0], to_y[0], to_z[0]) = (centre_x, centre_y, centre_z);
    }

    /// Changes velocities by this time of disturbances.
    pub(super) fn kick(&mut self, time: f64, disturbances: &[f64]) {
        let rows = disturbances.len() / 3;
        for (component, of) in disturbances.chunks_exact(rows).enumerate() {
            let centre = &mut self.centre[1][component];
            add(&mut centre.sum, &mut centre.error, time * of[0]);
            let (sums, errors) = (&mut self.velocity.sums[component], &mut self.velocity.errors[component]);
            for ((sum, error), of) in sums.iter_mut().zip(errors).zip(&of[1..]) {
                add(sum, error, time * of);
            }
        }
    }

    /// All numbers, for a checkpoint.
    pub(super) fn memory(&self) -> Vec<f64> {
        let centre = self.centre.iter().flatten().flat_map(|kept| [kept.sum, kept.error]);
        let numbers = [&self.position, &self.velocity].into_iter();
        let rows = numbers.flat_map(|numbers| numbers.sums.iter().chain(&numbers.errors).flatten().copied());
        centre.chain(rows).collect()
    }

    /// What [`Orbits::memory`] gave; `None` if it is none.
    pub(super) fn of_memory(memory: &[f64]) -> Option<Self> {
        let (centre, rows) = memory.split_at_checked(12)?;
        let long = rows.len() / 12;
        if long == 0 || !rows.len().is_multiple_of(12 * LANES) {
            return None;
        }
        let mut orbits = Orbits::default();
        for (kept, number) in orbits.centre.iter_mut().flatten().zip(centre.chunks_exact(2)) {
            *kept = Kept { sum: number[0], error: number[1] };
        }
        let mut columns = rows.chunks_exact(long).map(<[f64]>::to_vec);
        for numbers in [&mut orbits.position, &mut orbits.velocity] {
            for column in numbers.sums.iter_mut().chain(&mut numbers.errors) {
                *column = columns.next()?;
            }
        }
        Some(orbits)
    }
}
