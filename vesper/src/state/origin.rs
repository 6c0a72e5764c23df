//! Places relative to an origin that moves with them: digits then go to what rows are apart, and not to how far all of them are
//! from where coordinates begin.
//!
//! In: the property that is measured from the origin. Out: where the origin is, to twice the digits of f64, and columns moved so
//! that it is amid their rows. Never: a look at laws, which have to see differences only.

use super::State;
use crate::column::{Column, Values};
use crate::domain::{Domain, GivenValues};
use crate::error::Fault;
use crate::property::{PropertyInfo, Role};
use crate::real::Scalar;

/// Where rows are measured from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Origin {
    pub(crate) property: PropertyInfo,
    place: [f64; 3],
    /// What the place is further, beyond its last digit.
    rest: [f64; 3],
}

/// Extents between the origin and the middle of all rows at which it moves there: three bits of a number.
const FAR: f64 = 8.0;

impl Origin {
    /// Amid what domains give, which is measured from it then, before anything is rounded to the precision of a state.
    ///
    /// # Errors
    /// No domain gives the property, it is no coordinate, or its memory is lent.
    pub(crate) fn amid<P: Scalar>(property: PropertyInfo, domains: &mut [Domain<P>]) -> Result<Self, Fault> {
        let mut origin = Origin { property, place: [0.0; 3], rest: [0.0; 3] };
        let width = property.kind.width();
        if property.role != Role::Coordinate || width > 3 {
            return Err(origin.stays("it is no coordinate"));
        }
        let Some(given) = origin.given(domains)? else { return Ok(origin) };
        if given.is_empty() {
            return Err(origin.stays("no domain has it"));
        }
        let rows = given.iter().flat_map(|values| values.numbers.chunks_exact(width));
        origin.place = middle(rows.map(|row| core::array::from_fn(|c| row.get(c).copied().unwrap_or(0.0))));
        origin.measure(domains)?;
        Ok(origin)
    }

    /// Measures what domains give, from where coordinates begin, from here. Values that cannot be read stay as they are, for
    /// the state to say what is wrong with them.
    ///
    /// # Errors
    /// Memory is lent.
    pub(crate) fn measure<P: Scalar>(&self, domains: &mut [Domain<P>]) -> Result<(), Fault> {
        let width = self.property.kind.width();
        for values in self.given(domains)?.into_iter().flatten() {
            for (k, number) in values.numbers.iter_mut().enumerate() {
                *number = (*number - self.place[k % width]) - self.rest[k % width];
            }
        }
        Ok(())
    }

    /// What domains give of the property, in its own unit; `None` where some of it cannot be read.
    fn given<'a, P: Scalar>(&self, domains: &'a mut [Domain<P>]) -> Result<Option<Vec<&'a mut Values>>, Fault> {
        let columns = domains.iter_mut().flat_map(|domain| &mut domain.columns);
        let mut given = Vec::new();
        for column in columns.filter(|column| column.info.name == self.property.name) {
            let factor = column.factor();
            let GivenValues::Numbers(values) = &mut column.values else {
                return Err(self.stays("its numbers are the client's memory: give values, `.with(..)`"));
            };
            let readable =
                values.width == self.property.kind.width() && values.numbers.iter().all(|number| number.is_finite());
            let Some(factor) = factor.filter(|_| readable) else { return Ok(None) };
            values.numbers.iter_mut().for_each(|number| *number *= factor);
            column.unit = None;
            given.push(values);
        }
        Ok(Some(given))
    }

    fn stays(&self, reason: &str) -> Fault {
        Fault::OriginStays { who: self.property.name.to_owned(), reason: reason.to_owned() }
    }

    /// Where it is.
    pub(crate) fn place(&self) -> [f64; 3] {
        core::array::from_fn(|c| self.place[c] + self.rest[c])
    }

    /// A component of a row, from where coordinates begin.
    pub(crate) fn whole(&self, component: usize, number: f64) -> f64 {
        self.place[component] + (self.rest[component] + number)
    }

    /// Goes on by this much; what rounding takes is kept.
    fn shift(&mut self, by: [f64; 3]) {
        for c in 0..3 {
            let (before, by) = (self.place[c], by[c] + self.rest[c]);
            let after = before + by;
            // Knuth's exact remainder.
            let part = after - before;
            self.rest[c] = (before - (after - part)) + (by - part);
            self.place[c] = after;
        }
    }

    /// All of it, as numbers.
    pub(crate) fn numbers(&self) -> Vec<f64> {
        [self.place, self.rest].concat()
    }

    /// The same origin, where these numbers have it; `None` where they are not six.
    pub(crate) fn at(self, numbers: &[f64]) -> Option<Self> {
        let [x, y, z, rest @ ..] = *<&[f64; 6]>::try_from(numbers).ok()?;
        Some(Origin { place: [x, y, z], rest, ..self })
    }
}

impl<P: Scalar> State<P> {
    /// Moves the origin amid the rows, where it is far from them; whether it did. Rows at one place have no extent to measure
    /// by: it stays.
    pub(crate) fn recentre(&mut self) -> bool {
        let Some(mut origin) = self.origin else { return false };
        let width = origin.property.kind.width();
        let middle = middle(self.places(&origin.property));
        let far = largest(middle);
        let apart = |row: [f64; 3]| largest(core::array::from_fn(|c| row[c] - middle[c]));
        let extent = self.places(&origin.property).map(apart).fold(0.0, f64::max);
        if !(extent > 0.0 && far > FAR * extent && far.is_finite()) {
            return false;
        }
        let by = middle.map(P::from_f64);
        for domain in &mut self.domains {
            let Some(column) = domain.find(origin.property.name) else { continue };
            let column = &mut domain.columns[column];
            for row in 0..column.len() {
                for (c, by) in by.iter().enumerate().take(width) {
                    // Exact but for rows that are nearer to the old origin than half of what it moves by.
                    column.set_number(row, c, column.number(row, c) - *by);
                }
            }
        }
        origin.shift(by.map(Scalar::to_f64));
        self.origin = Some(origin);
        true
    }

    /// All rows that have the property, as they are kept.
    fn places(&self, property: &PropertyInfo) -> impl Iterator<Item = [f64; 3]> {
        let (name, width) = (property.name, property.kind.width());
        let columns = self.domains.iter().filter_map(move |domain| Some(&domain.columns[domain.find(name)?]));
        let number = move |column: &Column<P>, row, c| if c < width { column.number(row, c).to_f64() } else { 0.0 };
        columns
            .flat_map(move |column| (0..column.len()).map(move |row| core::array::from_fn(|c| number(column, row, c))))
    }
}

fn largest(of: [f64; 3]) -> f64 {
    of.into_iter().fold(0.0, |largest, number| largest.max(number.abs()))
}

/// The mean of places.
fn middle(rows: impl Iterator<Item = [f64; 3]>) -> [f64; 3] {
    let add = |(sums, count): ([f64; 3], f64), row: [f64; 3]| (core::array::from_fn(|c| sums[c] + row[c]), count + 1.0);
    let (sums, count) = rows.fold(([0.0; 3], 0.0), add);
    sums.map(|sum| if count > 0.0 { sum / count } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::Origin;
    use crate::property::{Position, Property};

    #[test]
    fn small_moves_of_a_far_origin_are_not_lost() {
        let mut origin = Origin { property: Position::INFO, place: [1e15, 0.0, -3.0], rest: [0.0; 3] };
        (0..1000).for_each(|_| origin.shift([1e-3, 0.5, -1e-3]));
        assert!((origin.whole(0, -1e15) - 1.0).abs() < 1e-9 && origin.whole(1, 0.0) == 500.0);
        let again = origin.at(&origin.numbers()).unwrap();
        assert_eq!((again.place, again.rest, origin.at(&[0.0; 5]).is_none()), (origin.place, origin.rest, true));
    }
}
