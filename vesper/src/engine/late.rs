//! Looks at columns without waiting for a device.
//!
//! In: a column's name. Out: its numbers as they were a frame or two ago, where a device has the newest. Never: a wait.

use super::Engine;
use crate::domain::AsProperty;
use crate::error::Fault;
use crate::real::Scalar;

/// A column as it was.
#[derive(Clone, Debug, PartialEq)]
pub struct Late<P> {
    /// The step after which it was so.
    pub step: u64,
    /// The time then, in s.
    pub time: f64,
    /// The numbers of each component, x of all rows, then y, then z; from [`State::origin`](crate::state::State::origin).
    pub components: Vec<Vec<P>>,
}

impl<P: Scalar> Engine<P> {
    /// A column of numbers without waiting for a graphics processor: where that has the newest ones, a copy of them is asked for, and the
    /// newest that has arrived since the last call is given; called once a frame, that of the frame before, most often. `None` where
    /// none has arrived. Where the newest numbers are on the host, these.
    ///
    /// # Errors
    /// There is no such domain or property, nobody observes it, it is a link, or lent memory, which is the client's anyway; or the graphics
    /// processor is gone, and its numbers with it.
    pub fn observe_late(&mut self, domain: &str, property: impl AsProperty) -> Result<Option<Late<P>>, Fault> {
        let info = property.info();
        let column = self.state.column(domain, info.name)?;
        let (step, time) = (self.steps, self.time());
        if column.is_away() {
            let id = self.state.domain_index(domain).and_then(|at| self.pipeline.registry.find(at, info.name));
            let late = id.and_then(|id| self.pipeline.late(id, step, time));
            if let Some(reason) = self.pipeline.loss() {
                return Err(Fault::DeviceLost { reason });
            }
            return Ok(late.map(|(step, time, components)| Late { step, time, components }));
        }
        let components = column.components().ok_or_else(|| Fault::Kind {
            domain: domain.to_owned(),
            property: info.name.to_owned(),
            expected: column.property().kind.to_string(),
            given: "a link, or memory of the client's".to_owned(),
            mend: "a column of numbers that the state owns".to_owned(),
        })?;
        Ok(Some(Late { step, time, components: components.into_iter().map(<[P]>::to_vec).collect() }))
    }
}
