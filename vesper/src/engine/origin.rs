//! Whether laws let the origin of a coordinate move.
//!
//! In: an engine whose state has such an origin. Out: nothing, or every law that looks at where rows are, and not only at how far
//! they are apart. Never: a move.

use super::Engine;
use crate::error::{Fault, Faults};
use crate::integrate::{Linearised, Register, System};
use crate::law::{Mode, Part, Place, Shape};
use crate::real::Scalar;
use crate::registry::{Seat, Tie};

/// How far all rows are moved alike, to see whether any rate follows: in no direction that laws could favour.
const ALIKE: [f64; 3] = [1.0, 0.75, -0.625];

impl<P: Scalar> Engine<P> {
    /// Checks that no law sees a move of the origin, where there is one that moves.
    pub(super) fn let_origin_move(&mut self) -> Result<(), Faults> {
        let Some(origin) = self.state.origin else { return Ok(()) };
        let name = origin.property.name;
        let label = |seat: &Seat| self.pipeline.entries[seat.law].label().to_owned();
        let mut faults = Vec::new();
        let mut between = Vec::new();
        for seat in &self.pipeline.registry.seats {
            let entry = &self.pipeline.entries[seat.law];
            let looks = entry.signature.ports.iter().any(|port| {
                port.property.name == name && matches!(port.mode, Mode::Reads | Mode::Previous | Mode::Amends)
            });
            if looks && matches!(entry.shape, Shape::Row | Shape::Column) {
                let reason = format!("it looks at {name} itself, not at differences of it");
                faults.push(Fault::OriginStays { who: label(seat), reason });
            } else if looks {
                between.push(label(seat));
            }
            for (port, tie) in entry.signature.ports.iter().zip(&seat.ties) {
                let Tie::Field(field) = tie else { continue };
                if port.place == Place::Field && self.state.fields[*field].1.uniform().is_none() {
                    let reason = format!("field {} differs from place to place", port.property.name);
                    faults.push(Fault::OriginStays { who: label(seat), reason });
                }
            }
        }
        if faults.is_empty() && !between.is_empty() && !self.pipeline.is_idle() && self.follows_the_origin(name)? {
            let reason = format!("rates change where {name} of all rows changes alike: look at differences of it only");
            faults.push(Fault::OriginStays { who: between.join(", "), reason });
        }
        Faults::unless_empty(faults, ())
    }

    /// Whether any rate changes as all rows move alike.
    fn follows_the_origin(&mut self, name: &str) -> Result<bool, Faults> {
        let [along, change] = [0, 1].map(Register::Work);
        self.with_derivatives(2, |runner| {
            let pipeline = &mut *runner.pipeline;
            let moved = pipeline
                .vectors
                .states
                .iter()
                .filter(|state| pipeline.registry.quantities[state.quantity].info.name == name);
            let places = moved.flat_map(|state| {
                let components = state.components.iter().zip(ALIKE);
                components.map(|(component, by)| (component.at..component.at + state.len, by))
            });
            let places: Vec<_> = places.collect();
            for (rows, by) in places {
                pipeline.vectors.numbers_mut(along)[rows].fill(P::from_f64(by));
            }
            runner.derivative(change, along);
            let mut follows = false;
            runner.magnitudes(&[change], Part::All, &mut |_, row| follows |= row[0] > 0.0);
            follows
        })
    }
}
