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
    /// A column of numbers, without waiting for a graphics processor. If the newest numbers are there, this starts a copy and gives the latest
    /// earlier copy that has arrived since the last call, most often that of the frame before; `None` if none has, as in the first call: keep
    /// what you have drawn. If they are on the host, they are given as they are now. [`Late::step`] tells which step it is.
    ///
    /// # Errors
    /// There is no such domain or property, nobody observes it, it is a link, or lent memory, which is the client's anyway; or the graphics
    /// processor is gone, and its numbers with it.
    pub fn observe_late(&mut self, domain: &str, property: impl AsProperty) -> Result<Option<Late<P>>, Fault> {
        let info = property.info();
        let column = self.state.column(domain, info.name)?;
        let (step, time) = (self.steps, self.time());
        // Of another layout it is another pipeline's.
        if column.is_away() && self.pipeline.layout == self.state.layout() {
            let id = self.state.domain_index(domain).and_then(|at| self.pipeline.registry.find(at, info.name));
            let late = id.and_then(|id| self.pipeline.late(id, step, time));
            self.pipeline.tell_loss()?;
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
