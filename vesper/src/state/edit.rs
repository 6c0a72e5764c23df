//! What the client changes of a state's shape between steps: rows added and removed, columns and fields added.

use super::State;
use crate::column::{Column, Storage, Values, renumbering};
use crate::domain::{AsProperty, Domain, Given, GivenValues, SCENE};
use crate::error::{Fault, Faults};
use crate::field::Field;
use crate::property::PropertyInfo;
use crate::real::{Scalar, compiled_here};
use std::sync::Arc;

impl<P: Scalar> State<P> {
    /// Adds rows to a domain. `rows` is a [`Domain`] of the same name with the new rows' values; every given column
    /// that has a value for all rows needs one for the new rows too, a subset takes those it is given. Links of new rows
    /// count the rows of their target as it will be.
    ///
    /// # Errors
    /// The domain does not exist, a column is missing, unknown, or does not fit; nothing is changed then.
    pub fn add_rows(&mut self, rows: Domain<P>) -> Result<(), Faults> {
        compiled_here!(<P> |state: &mut State<P>, rows: Domain<P>| -> Result<(), Faults> { state.grow(rows) })(
            self, rows,
        )
    }

    fn grow(&mut self, mut rows: Domain<P>) -> Result<(), Faults> {
        let place = self.domain_index(&rows.name).ok_or_else(|| self.no_domain(&rows.name))?;
        if place == 0 {
            return Err(Fault::SceneRow { mend: "change a constant by `set_constant`".to_owned() }.into());
        }
        let domain = &self.domains[place];
        let mut faults = Vec::new();
        for column in domain.columns.iter().filter(|column| column.given) {
            faults.extend(column.resizable(&domain.name, "grow").err());
            let given = rows.columns.iter().any(|given| given.info.name == column.info.name);
            if !given && column.subset.is_none() {
                faults.push(Fault::NewRowsLack { domain: domain.name.clone(), property: column.info.described() });
            }
        }
        for given in &mut rows.columns {
            match domain.columns.iter().find(|column| column.given && column.info.name == given.info.name) {
                None => faults.push(Self::no_property(domain, given.info.name)),
                Some(column) => faults.extend(fits(column, given, &domain.name).err()),
            }
        }
        Faults::unless_empty(faults, ())?;
        if let Some(origin) = self.origin {
            origin.measure(core::slice::from_mut(&mut rows))?;
        }
        // Targets of links are checked against the domains as they are; the scene's own row must not be given again.
        let names = self.domains.iter().skip(1).filter(|other| other.name != rows.name);
        let mut around: Vec<Domain<P>> = names.map(|other| Domain::new(&other.name).rows(other.rows)).collect();
        let name = rows.name.clone();
        around.push(rows);
        let parsed = State::checked(around, [], Some((&name, domain.rows)))?;
        let new = parsed.domain(&name)?;
        let old_rows = domain.rows;
        self.changed_layout();
        self.append(place, new, old_rows)?;
        Ok(())
    }

    fn append(&mut self, place: usize, new: &super::DomainState<P>, old_rows: usize) -> Result<(), Faults> {
        let domain = &mut self.domains[place];
        domain.rows += new.rows;
        for column in domain.columns.iter_mut().chain(&mut domain.previous) {
            let width = column.info.kind.width();
            let from = new.find(column.info.name).map(|index| &new.columns[index]).filter(|_| column.given);
            let Some(from) = from else {
                if !column.given {
                    column.extend(&domain.name, &vec![P::default(); new.rows * width])?;
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
                // Rows fit 32 bits: the state was checked for it.
                let row = |row: usize| u32::try_from(row).unwrap_or(u32::MAX);
                let rows = from.subset.clone().unwrap_or_else(|| (0..row(new.rows)).collect());
                subset.extend(rows.into_iter().map(|new| row(old_rows) + new));
            }
        }
        Ok(())
    }

    /// Removes rows of a domain. Later rows move up, in order; links follow; a row that links to a removed one is
    /// removed with it.
    ///
    /// # Errors
    /// The domain or a row does not exist, or a column is memory that cannot shrink; nothing is changed then.
    pub fn remove_rows(&mut self, domain: &str, rows: &[usize]) -> Result<(), Fault> {
        compiled_here!(<P> |state: &mut State<P>, domain: &str, rows: &[usize]| -> Result<(), Fault> {
            state.shrink(domain, rows)
        })(self, domain, rows)
    }

    fn shrink(&mut self, domain: &str, rows: &[usize]) -> Result<(), Fault> {
        let place = self.domain_index(domain).ok_or_else(|| self.no_domain(domain))?;
        if place == 0 {
            return Err(Fault::SceneRow { mend: "take a constant away by `remove_column`".to_owned() });
        }
        let count = self.domains[place].rows;
        if let Some(&row) = rows.iter().find(|&&row| row >= count) {
            return Err(Fault::NoRow { domain: domain.to_owned(), row, rows: count });
        }
        let mut keep: Vec<Vec<bool>> = self.domains.iter().map(|domain| vec![true; domain.rows]).collect();
        for &row in rows {
            keep[place][row] = false;
        }
        while self.orphan(&mut keep) {}
        let shrinks = |index: usize| keep[index].contains(&false);
        for (_, domain) in self.domains.iter().enumerate().filter(|(index, _)| shrinks(*index)) {
            for column in &domain.columns {
                column.resizable(&domain.name, "shrink")?;
            }
        }
        self.changed_layout();
        for index in 0..self.domains.len() {
            if shrinks(index) {
                let domain = &mut self.domains[index];
                for column in domain.columns.iter_mut().chain(&mut domain.previous) {
                    column.retain(&domain.name, &keep[index])?;
                }
                domain.rows = keep[index].iter().filter(|keep| **keep).count();
                self.renumber(index, &keep[index]);
            }
        }
        Ok(())
    }

    /// Lets go of the rows that link to rows let go of; whether there were any.
    fn orphan(&self, keep: &mut [Vec<bool>]) -> bool {
        let mut found = false;
        for (index, domain) in self.domains.iter().enumerate() {
            for (target, arity, rows) in domain.columns.iter().filter_map(Column::links) {
                let Some(target) = self.domain_index(target) else { continue };
                for (link, ends) in rows.chunks_exact(arity).enumerate() {
                    if keep[index][link] && ends.iter().any(|&end| !keep[target][end as usize]) {
                        keep[index][link] = false;
                        found = true;
                    }
                }
            }
        }
        found
    }

    /// Lets links to a domain follow its rows.
    fn renumber(&mut self, target: usize, keep: &[bool]) {
        let moved = renumbering(keep);
        let name = self.domains[target].name.clone();
        for column in self.domains.iter_mut().flat_map(|domain| &mut domain.columns) {
            if let Storage::Link { target, rows, .. } = &mut column.storage
                && *target == name
            {
                for end in rows {
                    // A link whose row is gone goes itself, before or after this.
                    *end = moved[*end as usize].unwrap_or_default();
                }
            }
        }
    }

    /// Adds a column to a domain that exists, or a whole domain. Dormant laws that lacked it wake at the next step.
    ///
    /// # Errors
    /// A column exists already, or does not fit; nothing is changed then.
    pub fn add_columns(&mut self, columns: Domain<P>) -> Result<(), Faults> {
        compiled_here!(<P> |state: &mut State<P>, columns: Domain<P>| -> Result<(), Faults> { state.widen(columns) })(
            self, columns,
        )
    }

    fn widen(&mut self, mut columns: Domain<P>) -> Result<(), Faults> {
        if let Some(origin) = self.origin {
            origin.measure(core::slice::from_mut(&mut columns))?;
        }
        let name = columns.name.clone();
        let others: Vec<Domain<P>> = self
            .domains
            .iter()
            .skip(1)
            .filter(|other| other.name != name)
            .map(|other| Domain::new(&other.name).rows(other.rows))
            .collect();
        let place = self.domain_index(&name);
        self.lent_already(&columns)?;
        let with_rows = match place {
            Some(index) => columns.rows(self.domains[index].rows),
            None => columns,
        };
        let time = crate::property::Time.info().name;
        if place == Some(0) && with_rows.columns.iter().any(|column| column.info.name == time) {
            return Err(Fault::SceneRow { mend: "its time is there, set it to another value".to_owned() }.into());
        }
        let mut parsed = State::new(others.into_iter().chain([with_rows]), [])?;
        let at = parsed.domain_index(&name).ok_or_else(|| self.no_domain(&name))?;
        let new = parsed.domains.swap_remove(at);
        match place {
            None => self.domains.push(new),
            Some(index) => {
                let domain = &mut self.domains[index];
                // The new scene domain always has a time, which this one has too.
                let again = |column: &Column<P>| index == 0 && column.info.name == crate::property::Time.info().name;
                let columns: Vec<Column<P>> = new.columns.into_iter().filter(|column| !again(column)).collect();
                let twice = |column: &&Column<P>| {
                    domain.columns.iter().any(|old| old.given && old.info.name == column.info.name)
                };
                let faults = columns
                    .iter()
                    .filter(twice)
                    .map(|column| Fault::ColumnTwice { domain: name.clone(), property: column.info.name.to_owned() });
                Faults::unless_empty(faults.collect(), ())?;
                for column in columns {
                    domain.columns.retain(|old| old.info.name != column.info.name);
                    domain.columns.push(column);
                }
            }
        }
        self.changed_layout();
        Ok(())
    }

    /// A fault for memory that a column has already.
    fn lent_already(&self, columns: &Domain<P>) -> Result<(), Faults> {
        let mut faults = Vec::new();
        for given in &columns.columns {
            let GivenValues::Lent(memory) = &given.values else { continue };
            for (domain, column) in
                self.domains.iter().flat_map(|domain| domain.columns.iter().map(move |c| (domain, c)))
            {
                if matches!(&column.storage, Storage::Lent(other) if other.identity() == memory.identity()) {
                    let first = format!("{}.{}", domain.name, column.info.name);
                    faults.push(Fault::lent_twice(&columns.name, given.info.name, &first));
                }
            }
        }
        Faults::unless_empty(faults, ())
    }

    /// Takes a column away; laws that need it become dormant at the next step.
    ///
    /// # Errors
    /// There is no such domain or property.
    pub fn remove_column(&mut self, domain: &str, property: impl AsProperty) -> Result<(), Fault> {
        let name = property.info().name;
        self.column(domain, name)?;
        if domain == SCENE && name == crate::property::Time.info().name {
            return Err(Fault::SceneRow { mend: "its time stays, set it to another value".to_owned() });
        }
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
        compiled_here!(<P> |state: &mut State<P>, info: PropertyInfo, value: Values| -> Result<(), Faults> {
            state.replace_constant(info, value)
        })(self, property.info(), value.into())
    }

    fn replace_constant(&mut self, info: PropertyInfo, value: Values) -> Result<(), Faults> {
        let values = GivenValues::Numbers(value.as_one(info.kind.width()));
        let column = Given { info, unit: None, subset: None, values };
        let time = crate::property::Time.info();
        if info.name == time.name && info != time {
            return Err(Fault::SceneRow { mend: "its time is in s; name another property otherwise".to_owned() }.into());
        }
        let mut scene = Domain::new(SCENE);
        scene.columns.push(column);
        let parsed = State::new([scene], [])?;
        let new = parsed.column(SCENE, info.name)?;
        match self.domains[0].find(info.name) {
            // What a law computes is no constant: with the client's value beside it, the next step finds two that set it.
            Some(index) if self.domains[0].columns[index].info == info && self.domains[0].columns[index].given => {
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

/// Whether values for new rows can go on a column. They are taken to be of the column's own property.
fn fits<P: Scalar>(column: &Column<P>, given: &mut Given<P>, domain: &str) -> Result<(), Fault> {
    let (domain, property) = (domain.to_owned(), given.info.name.to_owned());
    if given.info.kind == column.info.kind && given.info.size != column.info.size {
        return Err(Fault::Declared {
            property,
            one: column.info.measured(),
            one_by: format!("domain {domain}"),
            other: given.info.measured(),
            other_by: "the new rows".to_owned(),
        });
    }
    given.info = column.info;
    if column.subset.is_none() && given.subset.is_some() {
        return Err(Fault::NewRowsSubset { domain, property });
    }
    match (column.links(), &given.values) {
        (Some((target, ..)), GivenValues::Links { target: other, .. }) if target != other => {
            Err(Fault::NewRowsTarget { domain, property, target: target.to_owned(), given: other.clone() })
        }
        _ => Ok(()),
    }
}
