//! Numbers of columns and whole rows, in and out, by copying.

use super::run::Run;
use super::view::Met;
use super::{NumberType, Numbers, NumbersMut, Trouble, names};
use vesper::prelude::*;

impl<P: Precision> Run<P> {
    /// A fault where the client has room for, or gives, another number of numbers.
    fn as_many(what: &str, count: usize, (rows, width): (usize, usize)) -> Result<(), Trouble> {
        let expected = rows.saturating_mul(width);
        if count == expected {
            return Ok(());
        }
        let text = format!("{what}: {rows} values of {width} numbers are {expected}, and not {count}: give as many");
        Err(Trouble::fault(text))
    }

    /// Name and column of a property with a unit behind it, or without, and what its numbers are multiplied by to be in its own.
    fn named<'a>(&self, domain: &str, property: &'a str) -> Result<(&'a str, f64), Trouble> {
        let (name, unit) = names::apart(property)?;
        let info = self.engine.state().column(domain, name)?.property();
        Ok((name, names::factor(domain, info, unit)?))
    }

    /// Whether the client's numbers are the column itself, so that nothing is to be copied.
    fn is_itself(what: &str, met: Met, as_it_is: bool) -> Result<bool, Trouble> {
        match met {
            Met::Apart => Ok(false),
            Met::Itself if as_it_is => Ok(true),
            Met::Itself | Met::Partly => {
                Err(Trouble::Argument(format!("{what} has some of this memory itself: give memory of its own")))
            }
        }
    }

    pub(super) fn get(&self, domain: &str, property: &str, numbers: NumbersMut<'_>) -> Result<(), Trouble> {
        let place = numbers.place();
        let (property, factor) = self.named(domain, property)?;
        let column = self.engine.state().column(domain, property)?;
        let (rows, width) = (column.len(), column.property().kind.width());
        let what = format!("{domain}.{property}");
        Self::as_many(&what, numbers.len(), (rows, width))?;
        let moves = self.engine.state().origin(*column.property()) != [0.0; 3];
        let met = self.column(domain, property)?.meets(&place);
        if Self::is_itself(&what, met, !moves && factor == 1.0)? {
            return Ok(());
        }
        let numbers = match (column.links(), numbers) {
            (Some((_, _, links)), NumbersMut::Rows(to)) => {
                to.copy_from_slice(links);
                return Ok(());
            }
            (None, numbers @ (NumbersMut::F32(_) | NumbersMut::F64(_))) => numbers,
            (Some(_), _) => return Err(Trouble::Argument(format!("{what} is a link: ask for u32"))),
            (None, _) => return Err(Trouble::Argument(format!("{what} holds no rows: ask for f32 or f64"))),
        };
        if moves {
            let all = self.engine.state().numbers(domain, *column.property())?;
            put(numbers, |k| all[k] / factor);
        } else if let Some(lent) = self.lent(domain, property) {
            lent.memory.look(|all| put(numbers, |k| all[k].to_f64() / factor));
        } else {
            let components = column.components().unwrap_or_default();
            put(numbers, |k| components[k % width][k / width].to_f64() / factor);
        }
        Ok(())
    }

    pub(super) fn set(&mut self, domain: &str, property: &str, numbers: Numbers<'_>) -> Result<(), Trouble> {
        let (property, factor) = self.named(domain, property)?;
        let view = self.column(domain, property)?;
        let what = format!("{domain}.{property}");
        Self::as_many(&what, numbers.len(), (view.rows, view.width))?;
        if let (NumberType::Rows, _) | (_, Numbers::Rows(_)) = (view.numbers, numbers) {
            let text = format!("{what}: numbers are changed by f32 or f64, and links by removing and adding rows");
            return Err(Trouble::Argument(text));
        }
        let state = self.engine.state();
        let origin = state.origin(*state.column(domain, property)?.property());
        let itself = Self::is_itself(&what, view.meets(&numbers.place()), origin == [0.0; 3] && factor == 1.0)?;
        let width = view.width;
        let own = |k: usize, number: f64| P::from_f64(number * factor - origin.get(k % width).unwrap_or(&0.0));
        if let Some((k, number)) = numbers.each().enumerate().find(|&(k, number)| !own(k, number).is_finite()) {
            let text = format!("{what}: row {} is {number}: give a finite number of {}", k / width, P::NAME);
            return Err(Trouble::fault(text));
        }
        // Marks the state as changed, whoever owns the memory.
        let column = self.engine.state_mut().column_mut(domain, property)?;
        if itself {
            return Ok(());
        }
        if let Some(mut components) = column.components_mut() {
            for (k, number) in numbers.each().enumerate() {
                components[k % width][k / width] = own(k, number);
            }
        } else if let Some(lent) = self.lent(domain, property) {
            lent.memory.change(|all| {
                for (k, (to, number)) in all.iter_mut().zip(numbers.each()).enumerate() {
                    *to = own(k, number);
                }
            });
        }
        Ok(())
    }

    pub(super) fn add_rows(
        &mut self,
        domain: &str,
        rows: usize,
        columns: &[(&str, Numbers<'_>)],
    ) -> Result<(), Trouble> {
        if u32::try_from(rows).is_err() {
            return Err(Trouble::fault(format!("{rows} new rows of {domain}: at most {} can be numbered", u32::MAX)));
        }
        let state = self.engine.state();
        state.domain(domain)?;
        let mut new = Domain::<P>::new(domain).rows(rows);
        for (text, numbers) in columns {
            let (name, unit) = names::apart(text)?;
            let column = state.column(domain, name)?;
            let info = *column.property();
            // Before anything is read of what may not be there.
            Self::as_many(&format!("{domain}.{name}"), numbers.len(), (rows, info.kind.width()))?;
            new = match (column.links(), numbers) {
                (Some((target, ..)), Numbers::Rows(rows)) => new.with_link(info, target, rows.to_vec()),
                (None, Numbers::F32(_) | Numbers::F64(_)) => {
                    new.with_column(info, unit, None, Values::new(info.kind.width(), numbers.each().collect()))
                }
                (Some(_), _) => return Err(Trouble::Argument(format!("{domain}.{name} is a link: give u32"))),
                (None, _) => return Err(Trouble::Argument(format!("{domain}.{name} holds no rows: give f32 or f64"))),
            };
        }
        Ok(self.engine.state_mut().add_rows(new)?)
    }

    pub(super) fn remove_rows(&mut self, domain: &str, rows: &[u32]) -> Result<(), Trouble> {
        let rows: Vec<usize> = rows.iter().map(|&row| row as usize).collect();
        Ok(self.engine.state_mut().remove_rows(domain, &rows)?)
    }
}

/// Fills the client's room.
fn put(numbers: NumbersMut<'_>, number: impl Fn(usize) -> f64) {
    match numbers {
        NumbersMut::F32(to) => to.iter_mut().enumerate().for_each(|(k, to)| *to = number(k) as f32),
        NumbersMut::F64(to) => to.iter_mut().enumerate().for_each(|(k, to)| *to = number(k)),
        NumbersMut::Rows(_) => {}
    }
}
