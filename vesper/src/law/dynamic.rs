//! Laws made at run time: from a closure here, from a compiled library through the same door.
//!
//! In: a name, ports, a closure over one row's numbers, or over those of all rows. Out: a law that nothing else in the system can tell from a
//! derived one. Its declaration is kept for the life of the program, as a derived one's is.

use super::{Mode, Place, Port, Signature};
use crate::domain::AsProperty;
use crate::property::{PropertyInfo, intern};
use std::sync::Arc;

/// The body of a [`DynLaw`]: the inputs' numbers in declared order, then where the outputs' numbers go.
pub type DynRow = dyn Fn(&[f64], &mut [f64]) + Send + Sync;

/// The body of a [`DynLaw`] over whole columns: the numbers of each input in declared order, row after row, then those of each
/// output, which hold 0.
pub type DynWhole = dyn Fn(&[Vec<f64>], &mut [Vec<f64>]) + Send + Sync;

/// A law made at run time: of rows, or of whole columns. Its body computes in f64, whatever the precision of the state.
///
/// ```
/// use vesper::prelude::*;
/// let lift = DynLaw::new("lift").reads(Velocity).adds(Force).body(|velocity, force| force[2] = 0.1 * velocity[0]);
/// ```
#[derive(Clone)]
pub struct DynLaw {
    pub(crate) signature: Signature,
    pub(crate) body: DynBody,
}

/// What a law made at run time does.
#[derive(Clone)]
pub(crate) enum DynBody {
    Row(Arc<DynRow>),
    Whole(Arc<DynWhole>),
}

impl core::fmt::Debug for DynLaw {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("DynLaw").field("signature", &self.signature).finish_non_exhaustive()
    }
}

/// A declaration that is being written.
#[derive(Clone, Debug)]
pub struct DynLawBuilder {
    name: String,
    domain: Option<String>,
    second_order: bool,
    inputs: Vec<Port>,
    outputs: Vec<Port>,
    /// What rates depend on, where not on everything: (output, names of inputs).
    from: Vec<(usize, Vec<&'static str>)>,
}

impl DynLaw {
    /// Begins the declaration of a law of this name.
    #[allow(clippy::new_ret_no_self, reason = "a law begins as its declaration")]
    pub fn new(name: &str) -> DynLawBuilder {
        DynLawBuilder {
            name: name.to_owned(),
            domain: None,
            second_order: false,
            inputs: Vec::new(),
            outputs: Vec::new(),
            from: Vec::new(),
        }
    }

    /// What the law touches.
    pub fn signature(&self) -> &Signature {
        &self.signature
    }
}

impl DynLawBuilder {
    fn port(property: impl AsProperty, mode: Mode, place: Place) -> Port {
        let property = property.info();
        Port { field: property.name, property, mode, place, optional: false, default: None, from: u64::MAX }
    }

    /// The domain the law stands on.
    #[must_use]
    pub fn domain(mut self, domain: &str) -> Self {
        self.domain = Some(domain.to_owned());
        self
    }

    /// A property that the body looks at.
    #[must_use]
    pub fn reads(mut self, property: impl AsProperty) -> Self {
        self.inputs.push(Self::port(property, Mode::Reads, Place::Own));
        self
    }

    /// A constant of the scene that the body looks at.
    #[must_use]
    pub fn scene(mut self, property: impl AsProperty) -> Self {
        self.inputs.push(Self::port(property, Mode::Reads, Place::Scene));
        self
    }

    /// A field that the body looks at, at the place of the row.
    #[must_use]
    pub fn field(mut self, property: impl AsProperty) -> Self {
        self.inputs.push(Self::port(property, Mode::Reads, Place::Field));
        self
    }

    /// A property that the body computes anew.
    #[must_use]
    pub fn sets(mut self, property: impl AsProperty) -> Self {
        self.outputs.push(Self::port(property, Mode::Sets, Place::Own));
        self
    }

    /// A sum that the body adds to; its numbers hold 0 when the body is called.
    #[must_use]
    pub fn adds(mut self, property: impl AsProperty) -> Self {
        self.outputs.push(Self::port(property, Mode::Adds, Place::Own));
        self
    }

    /// A state whose rate the body gives.
    #[must_use]
    pub fn rates(mut self, property: impl AsProperty) -> Self {
        self.outputs.push(Self::port(property, Mode::Rates, Place::Own));
        self
    }

    /// A state whose rate the body gives, and the inputs that this rate depends on: integrators that split a step, as
    /// leapfrog does, take it then without the others, which are 0 in such a call. What the body does not look at is not
    /// counted.
    #[must_use]
    pub fn rates_from(mut self, property: impl AsProperty, inputs: &[PropertyInfo]) -> Self {
        self.from.push((self.outputs.len(), inputs.iter().map(|input| input.name).collect()));
        self.rates(property)
    }

    /// Says that the rate of each coordinate is its momentum, in every row that moves: methods for x'' = f(x) may use it.
    #[must_use]
    pub fn second_order(mut self) -> Self {
        self.second_order = true;
        self
    }

    /// A state that the body corrects after a step.
    #[must_use]
    pub fn amends(mut self, property: impl AsProperty) -> Self {
        self.outputs.push(Self::port(property, Mode::Amends, Place::Own));
        self
    }

    /// The body: gets the numbers of everything it looks at, in declared order (a vector is three), and writes the
    /// numbers of everything it changes.
    #[must_use]
    pub fn body(self, body: impl Fn(&[f64], &mut [f64]) + Send + Sync + 'static) -> DynLaw {
        self.law(DynBody::Row(Arc::new(body)))
    }

    /// A body over whole columns, called once for an evaluation: for languages in which a call costs more than a row. It gets
    /// copies of all numbers of what it looks at, row after row, and fills those of what it changes. Fields are for bodies of rows.
    ///
    /// ```
    /// use vesper::prelude::*;
    /// let drag = DynLaw::new("drag").reads(Velocity).adds(Force).whole(|given, results| {
    ///     results[0].iter_mut().zip(&given[0]).for_each(|(force, velocity)| *force = -0.1 * velocity);
    /// });
    /// ```
    #[must_use]
    pub fn whole(self, body: impl Fn(&[Vec<f64>], &mut [Vec<f64>]) + Send + Sync + 'static) -> DynLaw {
        self.law(DynBody::Whole(Arc::new(body)))
    }

    fn law(self, body: DynBody) -> DynLaw {
        let DynLawBuilder { name, domain, second_order, inputs, mut outputs, from } = self;
        for (output, names) in from {
            let bits = inputs.iter().enumerate().filter(|(_, input)| names.contains(&input.property.name));
            outputs[output].from = bits.filter(|(bit, _)| *bit < 64).map(|(bit, _)| 1 << bit).sum();
        }
        let ports: Vec<Port> = inputs.into_iter().chain(outputs).collect();
        let signature = Signature {
            name: intern(&name),
            doc: "",
            domain: domain.as_deref().map(intern),
            ports: Box::leak(ports.into_boxed_slice()),
            parameters: &[],
            link: None,
            second_order,
            translation_invariant: false,
            antisymmetric: false,
            estimates: false,
            cutoff: None,
            file: "",
            line: 0,
        };
        DynLaw { signature, body }
    }
}
