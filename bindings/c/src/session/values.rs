//! Numbers of columns and whole rows, in and out, by copying.

use super::run::Run;
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

    pub(super) fn get(&self, domain: &str, property: &str, numbers: NumbersMut<'_>) -> Result<(), Trouble> {
        let column = self.engine.state().column(domain, property)?;
        let (rows, width) = (column.len(), column.property().kind.width());
        let what = format!("{domain}.{property}");
        Self::as_many(&what, numbers.len(), (rows, width))?;
        let numbers = match (column.links(), numbers) {
            (Some((_, _, links)), NumbersMut::Rows(to)) => {
                to.copy_from_slice(links);
                return Ok(());
            }
            (None, numbers @ (NumbersMut::F32(_) | NumbersMut::F64(_))) => numbers,
            (Some(_), _) => return Err(Trouble::Argument(format!("{what} is a link: ask for u32"))),
            (None, _) => return Err(Trouble::Argument(format!("{what} holds no rows: ask for f32 or f64"))),
        };
        if self.engine.state().origin(*column.property()) != [0.0; 3] {
            let all = self.engine.state().numbers(domain, *column.property())?;
            put(numbers, |k| all[k]);
        } else if let Some(lent) = self.lent(domain, property) {
            lent.memory.look(|all| put(numbers, |k| all[k].to_f64()));
        } else {
            let components = column.components().unwrap_or_default();
            put(numbers, |k| components[k % width][k / width].to_f64());
        }
        Ok(())
    }

    pub(super) fn set(&mut self, domain: &str, property: &str, numbers: Numbers<'_>) -> Result<(), Trouble> {
        let view = self.column(domain, property)?;
        let what = format!("{domain}.{property}");
        Self::as_many(&what, numbers.len(), (view.rows, view.width))?;
        if let (NumberType::Rows, _) | (_, Numbers::Rows(_)) = (view.numbers, numbers) {
            let text = format!("{what}: numbers are changed by f32 or f64, and links by removing and adding rows");
            return Err(Trouble::Argument(text));
        }
        let state = self.engine.state();
        let origin = state.origin(*state.column(domain, property)?.property());
        let width = view.width;
        let from_origin = |k: usize, number: f64| P::from_f64(number - origin.get(k % width).unwrap_or(&0.0));
        if let Some((k, number)) = numbers.each().enumerate().find(|&(k, number)| !from_origin(k, number).is_finite()) {
            let text = format!("{what}: row {} is {number}: give a finite number of {}", k / width, P::NAME);
            return Err(Trouble::fault(text));
        }
        // Marks the state as changed, whoever owns the memory.
        let column = self.engine.state_mut().column_mut(domain, property)?;
        if let Some(mut components) = column.components_mut() {
            for (k, number) in numbers.each().enumerate() {
                components[k % width][k / width] = from_origin(k, number);
            }
        } else if let Some(lent) = self.lent(domain, property) {
            lent.memory.change(|all| {
                for (k, (to, number)) in all.iter_mut().zip(numbers.each()).enumerate() {
                    *to = from_origin(k, number);
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
