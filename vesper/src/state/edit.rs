//! What the client changes of a state's shape between steps: rows added and removed, columns and fields added.

use super::State;
use crate::column::{Storage, Values, renumbering};
use crate::domain::{AsProperty, Domain, Given, GivenValues};
use crate::error::{Fault, Faults, nearest};
use crate::field::Field;
use crate::real::Scalar;
use std::sync::Arc;

impl<P: Scalar> State<P> {
    /// Adds rows to a domain. `rows` is a [`Domain`] of the same name with the new rows' values; every given column
    /// that has a value for all rows needs one for the new rows too, a subset takes those it is given.
    ///
    /// # Errors
    /// The domain does not exist, a column is missing, unknown, or does not fit; nothing is changed then.
    pub fn add_rows(&mut self, rows: Domain<P>) -> Result<(), Faults> {
        let place = self.domain_index(&rows.name).ok_or_else(|| self.no_domain(&rows.name))?;
        let domain = &self.domains[place];
        let mut faults = Vec::new();
        for column in domain.columns.iter().filter(|column| column.given && column.subset.is_none()) {
            if !rows.columns.iter().any(|given| given.info.name == column.info.name) {
                faults.push(Fault::NoProperty {
                    domain: format!("the new rows of {}", domain.name),
                    property: column.info.described(),
                    nearest: None,
                });
            }
        }
        for given in &rows.columns {
            if domain.find(given.info.name).is_none() {
                faults.push(Fault::NoProperty {
                    domain: domain.name.clone(),
                    property: given.info.name.to_owned(),
                    nearest: nearest(given.info.name, domain.columns.iter().map(|column| column.info.name)),
                });
            }
        }
        Faults::unless_empty(faults, ())?;
        // Targets of links are checked against the domains as they are; the scene's own row must not be given again.
        let names = self.domains.iter().skip(1).filter(|other| other.name != rows.name);
        let mut around: Vec<Domain<P>> = names.map(|other| Domain::new(&other.name).rows(other.rows)).collect();
        let name = rows.name.clone();
        around.push(rows);
        let parsed = State::new(around, [])?;
        let new = parsed.domain(&name)?;
        let (old_rows, added) = (domain.rows, new.rows);
        self.append(place, new, old_rows, added)?;
        self.changed_layout();
        Ok(())
    }

    fn append(
        &mut self,
        place: usize,
        new: &super::DomainState<P>,
        old_rows: usize,
        added: usize,
    ) -> Result<(), Faults> {
        let domain = &mut self.domains[place];
        domain.rows += added;
        for column in &mut domain.columns {
            let width = column.info.kind.width();
            let Some(from) = new.find(column.info.name).map(|index| &new.columns[index]) else {
                if !column.given {
                    column.extend(&domain.name, &vec![P::default(); added * width])?;
                }
                continue;
            };
            if let (Storage::Link { rows, .. }, Storage::Link { rows: more, .. }) = (&mut column.storage, &from.storage)
            {
                rows.extend(more);
                continue;
            }
            let numbers: Vec<P> = (0..from.len() * width).map(|k| from.number(k / width, k % width)).collect();
            column.extend(&domain.name, &numbers)?;
            if let Some(subset) = &mut column.subset {
                let old = u32::try_from(old_rows).unwrap_or(u32::MAX);
                let all = 0..u32::try_from(added).unwrap_or(u32::MAX);
                let rows = from.subset.clone().unwrap_or_else(|| all.collect());
                subset.extend(rows.into_iter().map(|row| old + row));
            }
        }
        Ok(())
    }

    /// Removes rows of a domain. Later rows move up, in order; links follow; a row that links to a removed one is
    /// removed with it.
    ///
    /// # Errors
    /// The domain or a row does not exist, or a column is memory that cannot shrink.
    pub fn remove_rows(&mut self, domain: &str, rows: &[usize]) -> Result<(), Fault> {
        let place = self.domain_index(domain).ok_or_else(|| self.no_domain(domain))?;
        let count = self.domains[place].rows;
        if let Some(&row) = rows.iter().find(|&&row| row >= count) {
            return Err(Fault::NoRow { domain: domain.to_owned(), row, rows: count });
        }
        let mut keep = vec![true; count];
        for &row in rows {
            keep[row] = false;
        }
        self.remove(place, &keep)
    }

    fn remove(&mut self, place: usize, keep: &[bool]) -> Result<(), Fault> {
        if keep.iter().all(|keep| *keep) {
            return Ok(());
        }
        let name = self.domains[place].name.clone();
        for column in &mut self.domains[place].columns {
            column.retain(&name, keep)?;
        }
        self.domains[place].rows = keep.iter().filter(|keep| **keep).count();
        self.changed_layout();
        let moved = renumbering(keep);
        let mut orphans: Vec<(usize, Vec<bool>)> = Vec::new();
        for (index, domain) in self.domains.iter_mut().enumerate() {
            let mut alive = vec![true; domain.rows];
            for column in &mut domain.columns {
                let Storage::Link { target, arity, rows } = &mut column.storage else { continue };
                if *target != name {
                    continue;
                }
                for (link, ends) in rows.chunks_exact_mut(*arity).enumerate() {
                    for end in ends {
                        match moved[*end as usize] {
                            Some(row) => *end = row,
                            None => alive[link] = false,
                        }
                    }
                }
            }
            orphans.push((index, alive));
        }
        for (index, alive) in orphans {
            self.remove(index, &alive)?;
        }
        Ok(())
    }

    /// Adds a column to a domain that exists, or a whole domain. Dormant laws that lacked it wake at the next step.
    ///
    /// # Errors
    /// A column exists already, or does not fit.
    pub fn add_columns(&mut self, columns: Domain<P>) -> Result<(), Faults> {
        let name = columns.name.clone();
        let others: Vec<Domain<P>> = self
            .domains
            .iter()
            .skip(1)
            .filter(|other| other.name != name)
            .map(|other| Domain::new(&other.name).rows(other.rows))
            .collect();
        let place = self.domain_index(&name);
        let with_rows = match place {
            Some(index) => columns.rows(self.domains[index].rows),
            None => columns,
        };
        let mut parsed = State::new(others.into_iter().chain([with_rows]), [])?;
        let at = parsed.domain_index(&name).ok_or_else(|| self.no_domain(&name))?;
        let new = parsed.domains.swap_remove(at);
        match place {
            None => self.domains.push(new),
            Some(index) => {
                let domain = &mut self.domains[index];
                let mut faults = Vec::new();
                for column in new.columns {
                    match domain.find(column.info.name) {
                        // The new scene domain always has a time, which this one has too.
                        Some(_) if index == 0 && column.info.name == crate::property::Time.info().name => {}
                        Some(old) if !domain.columns[old].given => domain.columns[old] = column,
                        Some(_) => faults
                            .push(Fault::ColumnTwice { domain: name.clone(), property: column.info.name.to_owned() }),
                        None => domain.columns.push(column),
                    }
                }
                self.changed_layout();
                return Faults::unless_empty(faults, ());
            }
        }
        self.changed_layout();
        Ok(())
    }

    /// Takes a column away; laws that need it become dormant at the next step.
    ///
    /// # Errors
    /// There is no such domain or property.
    pub fn remove_column(&mut self, domain: &str, property: impl AsProperty) -> Result<(), Fault> {
        let name = property.info().name;
        self.column(domain, name)?;
        if let Some(index) = self.domain_index(domain) {
            self.domains[index].columns.retain(|column| column.info.name != name);
        }
        self.changed_layout();
        Ok(())
    }

    /// Gives or replaces a field.
    pub fn set_field(&mut self, property: impl AsProperty, field: impl Field<P>) {
        let info = property.info();
        self.fields.retain(|(other, _)| other.name != info.name);
        self.fields.push((info, Arc::new(field)));
        self.changed_layout();
    }

    /// Gives or replaces a constant of the scene.
    ///
    /// # Errors
    /// The value does not fit the property.
    pub fn set_constant(&mut self, property: impl AsProperty, value: impl Into<Values>) -> Result<(), Faults> {
        let info = property.info();
        let column = Given {
            info,
            unit: None,
            subset: None,
            values: GivenValues::Numbers(value.into().as_one(info.kind.width())),
        };
        let mut scene = Domain::new(Self::scene_name());
        scene.columns.push(column);
        let parsed = State::new([scene], [])?;
        let new = parsed.column(Self::scene_name(), info.name)?;
        match self.domains[0].find(info.name) {
            Some(index) if self.domains[0].columns[index].info.kind == info.kind => {
                for component in 0..info.kind.width() {
                    self.domains[0].columns[index].set_number(0, component, new.number(0, component));
                }
            }
            _ => {
                self.domains[0].columns.retain(|column| column.info.name != info.name);
                self.domains[0].columns.push(new.clone());
                self.changed_layout();
            }
        }
        Ok(())
    }
}
