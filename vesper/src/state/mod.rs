//! All data of a run: domains of rows, columns of properties, constants, fields.
//!
//! In: [`Domain`](crate::domain::Domain)s as the client gives them. Out: [`State`], checked, in one precision, in the properties' units; read
//! and changed by the client between steps. Never: a law; a name that only a physicist knows.

mod build;
mod edit;
mod origin;

pub(crate) use origin::Origin;

use crate::column::{Column, ColumnMut, Storage};
use crate::domain::AsProperty;
use crate::error::{Fault, nearest};
use crate::field::Field;
use crate::property::{Numeric, Property, PropertyInfo, Time, ValueOf};
use crate::real::{Scalar, compiled_here};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// One domain of a state.
#[derive(Clone, Debug)]
pub struct DomainState<P: Scalar> {
    pub(crate) name: String,
    pub(crate) rows: usize,
    pub(crate) columns: Vec<Column<P>>,
    /// What the last evaluation left of computed properties that laws look back at.
    pub(crate) previous: Vec<Column<P>>,
}

impl<P: Scalar> DomainState<P> {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How many rows it has.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Its columns, given ones and computed ones; of the latter only those that are observed are up to date.
    pub fn columns(&self) -> &[Column<P>] {
        &self.columns
    }

    pub(crate) fn find(&self, property: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.info.name == property)
    }

    fn shown(&self, property: &str) -> Option<usize> {
        self.find(property).filter(|&index| self.columns[index].shown)
    }
}

/// All data of a run.
///
/// The domain "scene" has one row and holds the constants and the time.
///
/// A clone copies all that the state owns. Lent memory stays the client's: the clone looks at the same.
pub struct State<P: Scalar> {
    pub(crate) domains: Vec<DomainState<P>>,
    pub(crate) fields: Vec<(PropertyInfo, Arc<dyn Field<P>>)>,
    /// What one property is measured from, where that moves.
    pub(crate) origin: Option<Origin>,
    identity: u64,
    version: u64,
}

impl<P: Scalar> core::fmt::Debug for State<P> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let fields: Vec<_> = self.fields.iter().map(|(property, _)| property.name).collect();
        f.debug_struct("State").field("domains", &self.domains).field("fields", &fields).finish()
    }
}

impl<P: Scalar> Clone for State<P> {
    fn clone(&self) -> Self {
        State {
            domains: self.domains.clone(),
            fields: self.fields.clone(),
            origin: self.origin,
            identity: fresh_identity(),
            version: self.version,
        }
    }
}

fn fresh_identity() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

impl<P: Scalar> State<P> {
    /// Tells states and their layouts apart: whoever keeps pointers into columns keeps this beside them.
    pub(crate) fn layout(&self) -> (u64, u64) {
        (self.identity, self.version)
    }

    /// To be called by everything that moves, adds or removes a column or a row.
    pub(crate) fn changed_layout(&mut self) {
        self.version += 1;
    }

    /// All domains; the first one is "scene".
    pub fn domains(&self) -> &[DomainState<P>] {
        &self.domains
    }

    pub(crate) fn domain_index(&self, name: &str) -> Option<usize> {
        self.domains.iter().position(|domain| domain.name == name)
    }

    /// A domain.
    ///
    /// # Errors
    /// There is none of this name.
    pub fn domain(&self, name: &str) -> Result<&DomainState<P>, Fault> {
        self.domain_index(name).map(|index| &self.domains[index]).ok_or_else(|| self.no_domain(name))
    }

    pub(crate) fn no_domain(&self, name: &str) -> Fault {
        Fault::NoDomain {
            domain: name.to_owned(),
            nearest: nearest(name, self.domains.iter().map(|domain| domain.name.as_str())),
        }
    }

    fn no_property(domain: &DomainState<P>, property: &str) -> Fault {
        Fault::NoProperty {
            domain: domain.name.clone(),
            property: property.to_owned(),
            nearest: nearest(
                property,
                domain.columns.iter().filter(|column| column.shown).map(|column| column.info.name),
            ),
        }
    }

    /// A column, by name; of the computed ones those that are observed, as they were at the end of the last frame.
    ///
    /// # Errors
    /// There is no such domain or property, nobody observes it, or it is lent memory that the client is changing.
    pub fn column(&self, domain: &str, property: &str) -> Result<&Column<P>, Fault> {
        let (domain, column) = self.look_up(domain, property, false)?;
        Ok(&self.domains[domain].columns[column])
    }

    /// Domain and number of a column that clients may look at, or change.
    fn look_up(&self, domain: &str, property: &str, change: bool) -> Result<(usize, usize), Fault> {
        compiled_here!(<P> |state: &State<P>, domain: &str, property: &str, change: bool| -> Result<(usize, usize), Fault> {
            state.find(domain, property, change)
        })(self, domain, property, change)
    }

    fn find(&self, domain: &str, property: &str, change: bool) -> Result<(usize, usize), Fault> {
        let place = self.domain_index(domain).ok_or_else(|| self.no_domain(domain))?;
        let domain = &self.domains[place];
        let index = domain.shown(property).ok_or_else(|| Self::no_property(domain, property))?;
        domain.columns[index].free(&domain.name, change)?;
        Ok((place, index))
    }

    /// A column to change in place, by name.
    ///
    /// # Errors
    /// There is no such domain or property, or it is lent memory that the client looks at or changes.
    pub fn column_mut(&mut self, domain: &str, property: &str) -> Result<ColumnMut<'_, P>, Fault> {
        let (domain, column) = self.look_up(domain, property, true)?;
        Ok(ColumnMut(&mut self.domains[domain].columns[column]))
    }

    /// The column, if it is of the kind that the caller takes it for.
    fn of_kind(&self, domain: &str, property: &PropertyInfo) -> Result<&Column<P>, Fault> {
        let column = self.column(domain, property.name)?;
        if column.info.kind == property.kind {
            return Ok(column);
        }
        Err(Fault::Kind {
            domain: domain.to_owned(),
            property: property.name.to_owned(),
            expected: column.info.kind.to_string(),
            given: format!("asked for as a {}", property.kind),
            mend: "the property that the column was made with".to_owned(),
        })
    }

    fn place(&self, domain: &str, property: &PropertyInfo, row: usize) -> Result<usize, Fault> {
        let column = self.of_kind(domain, property)?;
        let rows = self.domain(domain)?.rows;
        column.index_of(row).ok_or_else(|| match column.subset {
            Some(_) if row < rows => Fault::NoValue {
                domain: domain.to_owned(),
                property: property.name.to_owned(),
                row,
                given: column.len(),
                rows,
            },
            _ => Fault::NoRow { domain: domain.to_owned(), row, rows },
        })
    }

    /// What rows of a property are measured from, in its unit: zeros, but with
    /// [`moving_origin`](crate::engine::Builder::moving_origin).
    pub fn origin(&self, property: impl AsProperty) -> [f64; 3] {
        let origin = self.origin.filter(|origin| origin.property.name == property.info().name);
        origin.map_or([0.0; 3], |origin| origin.place())
    }

    /// The value of one row, from its [`State::origin`].
    ///
    /// # Errors
    /// There is no such domain, property or row.
    pub fn get<Q: Property<Kind: Numeric>>(&self, domain: &str, _: Q, row: usize) -> Result<ValueOf<Q, P>, Fault> {
        let index = self.place(domain, &Q::INFO, row)?;
        let column = self.column(domain, Q::NAME)?;
        Ok(<Q::Kind as Numeric>::from_components(|component| column.number(index, component)))
    }

    /// Changes the value of one row, from its [`State::origin`].
    ///
    /// # Errors
    /// There is no such domain, property or row, or the value is infinite or NaN.
    pub fn set<Q: Property<Kind: Numeric>>(
        &mut self,
        domain: &str,
        _: Q,
        row: usize,
        value: ValueOf<Q, P>,
    ) -> Result<(), Fault> {
        let index = self.place(domain, &Q::INFO, row)?;
        let column = self.column_mut(domain, Q::NAME)?.0;
        let mut bad = None;
        <Q::Kind as Numeric>::each_component(value, |_, number: P| {
            bad = bad.or((!number.is_finite()).then_some(number))
        });
        if let Some(number) = bad {
            let (domain, property) = (domain.to_owned(), Q::NAME.to_owned());
            return Err(Fault::NotFinite { domain, property, row, value: number.to_f64() });
        }
        <Q::Kind as Numeric>::each_component(value, |component, number| column.set_number(index, component, number));
        Ok(())
    }

    /// The values of all rows (of the subset, where there is one), from their [`State::origin`].
    ///
    /// # Errors
    /// There is no such domain or property, or it is of another kind.
    pub fn values<Q: Property<Kind: Numeric>>(&self, domain: &str, _: Q) -> Result<Vec<ValueOf<Q, P>>, Fault> {
        let column = self.of_kind(domain, &Q::INFO)?;
        Ok((0..column.len())
            .map(|index| <Q::Kind as Numeric>::from_components(|component| column.number(index, component)))
            .collect())
    }

    /// The numbers of a column in f64, one value after the other, from where coordinates begin, also where the
    /// [origin](State::origin) of rows moves; of a link the rows that it leads to.
    ///
    /// # Errors
    /// There is no such domain or property.
    pub fn numbers(&self, domain: &str, property: impl AsProperty) -> Result<Vec<f64>, Fault> {
        let column = self.column(domain, property.info().name)?;
        if let Some((_, _, rows)) = column.links() {
            return Ok(rows.iter().map(|&row| f64::from(row)).collect());
        }
        let width = column.info.kind.width();
        let numbers = (0..column.len() * width).map(|k| (k % width, column.number(k / width, k % width).to_f64()));
        Ok(match self.origin.filter(|origin| origin.property.name == column.info.name) {
            Some(origin) => numbers.map(|(component, number)| origin.whole(component, number)).collect(),
            None => numbers.map(|(_, number)| number).collect(),
        })
    }

    /// The time of the state, in s.
    pub fn time(&self) -> P {
        self.scene_number(Time::NAME)
    }

    #[inline]
    pub(crate) fn set_time(&mut self, time: P) {
        // The first column of the scene, since the state was built.
        self.domains[0].columns[0].set_number(0, 0, time);
    }

    fn scene_number(&self, property: &str) -> P {
        self.domains
            .first()
            .and_then(|scene| scene.find(property).map(|index| scene.columns[index].number(0, 0)))
            .unwrap_or_default()
    }

    /// A hash of every given number and link, and of where an origin that moves is, for determinism tests: equal states have
    /// equal hashes, bit for bit. Lent memory counts as zeros while the client changes it.
    pub fn hash(&self) -> u64 {
        // FNV-1a, 64 bits (Fowler, Noll, Vo): the order of the bytes is the order of domains, columns and rows.
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut add = |word: u64| {
            for byte in word.to_le_bytes() {
                hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
            }
        };
        self.origin.iter().flat_map(Origin::numbers).for_each(|number| add(number.to_bits()));
        for domain in &self.domains {
            for column in domain.columns.iter().filter(|column| column.given) {
                match &column.storage {
                    Storage::Link { rows, .. } => rows.iter().for_each(|&row| add(row.into())),
                    Storage::Split(_) | Storage::Lent(_) => {
                        for index in 0..column.len() {
                            for component in 0..column.info.kind.width() {
                                add(column.number(index, component).bits());
                            }
                        }
                    }
                }
            }
        }
        hash
    }
}
