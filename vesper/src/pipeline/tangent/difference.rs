//! Derivatives of a law that has no body over duals, a column law or one that was compiled elsewhere: the law at the columns as they are, and for each port that
//! moves at two states along the direction.
//!
//! The two are the cube root of rounding apart, times the largest number of the port by the largest of its direction: there the
//! errors of the central difference and of rounding are alike. Each port by itself, since ports have different units. Source:
//! Dennis, Schnabel, Numerical Methods for Unconstrained Optimization and Nonlinear Equations, 5.4.

use super::Place;
use crate::backend::{Kernel, LinkCall, Links, PairCall, Strided};
use crate::column::Aligned;
use crate::law::{self, ColumnAccess, PortView};
use crate::pipeline::run::Context;
use crate::real::{Dual, Scalar};

/// One port of the law: where its numbers are, and arrays that the law is run on.
pub(super) struct PortOf<P: Scalar> {
    places: Vec<Place<P>>,
    rows: usize,
    is_input: bool,
    adds: bool,
    /// What the law reads, or gives: component by component.
    numbers: Vec<Aligned<P>>,
    /// Of what it reads, the numbers as they are, and the direction; of what it gives, values and derivatives.
    kept: Vec<[Aligned<P>; 2]>,
}

impl<P: Scalar> PortOf<P> {
    pub(super) fn new(places: Vec<Place<P>>, rows: usize, is_input: bool, adds: bool) -> Self {
        let zeros = |stream| Aligned::zeros(rows, stream);
        let numbers = (0..places.len()).map(zeros).collect();
        let kept = (0..places.len()).map(|_| [zeros(0), zeros(1)]).collect();
        PortOf { places, rows, is_input, adds, numbers, kept }
    }

    fn view(&self) -> PortView<P> {
        let mut components = [core::ptr::null_mut(); 4];
        if self.rows > 0 {
            for (component, numbers) in components.iter_mut().zip(&self.numbers) {
                *component = numbers.pointer();
            }
        }
        PortView { components, stride: 1, rows: self.rows }
    }

    /// The largest magnitude of its numbers, and of its direction.
    fn most(&self) -> [f64; 2] {
        let most = |half: usize| {
            let numbers = self.kept.iter().flat_map(|kept| kept[half].as_slice());
            numbers.fold(0.0, |most, number| f64::max(most, number.to_f64().abs()))
        };
        [most(0), most(1)]
    }

    /// Moves along its direction.
    fn put(&mut self, by: P) {
        for (numbers, [at, along]) in self.numbers.iter_mut().zip(&self.kept) {
            let moved = at.as_slice().iter().zip(along.as_slice()).map(|(at, along)| *at + *along * by);
            numbers.as_mut_slice().iter_mut().zip(moved).for_each(|(to, number)| *to = number);
        }
    }
}

/// A column law, run some times.
pub(super) struct Difference<P: Scalar> {
    law: usize,
    ports: Vec<PortOf<P>>,
    views: Vec<PortView<P>>,
    link: Option<(*const u32, usize, usize)>,
}

impl<P: Scalar> Difference<P> {
    pub(super) fn new(law: usize, ports: Vec<PortOf<P>>, link: Option<(*const u32, usize, usize)>) -> Self {
        let views = ports.iter().map(PortOf::view).collect();
        Difference { law, ports, views, link }
    }

    /// # Safety
    /// As for [`super::Tangent::run`].
    pub(super) unsafe fn run(&mut self, context: &Context<'_, P>) {
        for port in self.ports.iter_mut().filter(|port| port.is_input) {
            for (place, [at, along]) in port.places.iter().zip(&mut port.kept) {
                let place = place.resolve(context.lent);
                for row in 0..port.rows {
                    // SAFETY: the column has a number for each of its rows.
                    let number = unsafe { place.load(row) };
                    (at.as_mut_slice()[row], along.as_mut_slice()[row]) = (number.value, number.derivative);
                }
            }
            port.put(P::default());
        }
        self.evaluate(context);
        for port in self.ports.iter_mut().filter(|port| !port.is_input) {
            for (numbers, [values, derivatives]) in port.numbers.iter().zip(&mut port.kept) {
                values.as_mut_slice().copy_from_slice(numbers.as_slice());
                derivatives.as_mut_slice().fill(P::default());
            }
        }
        for moving in 0..self.ports.len() {
            let [size, speed] = self.ports[moving].most();
            if !self.ports[moving].is_input || speed == 0.0 {
                continue;
            }
            let by = P::EPSILON.cbrt() * if size > 0.0 { size } else { 1.0 } / speed;
            for sign in [1.0, -1.0] {
                self.ports[moving].put(P::from_f64(sign * by));
                self.evaluate(context);
                let share = P::from_f64(sign * 0.5 / by);
                for port in self.ports.iter_mut().filter(|port| !port.is_input) {
                    for (numbers, [_, derivatives]) in port.numbers.iter().zip(&mut port.kept) {
                        let numbers = numbers.as_slice().iter();
                        derivatives.as_mut_slice().iter_mut().zip(numbers).for_each(|(sum, n)| *sum += *n * share);
                    }
                }
            }
            self.ports[moving].put(P::default());
        }
        for port in self.ports.iter().filter(|port| !port.is_input) {
            for (place, [values, derivatives]) in port.places.iter().zip(&port.kept) {
                let place = place.resolve(context.lent);
                for row in 0..port.rows {
                    let share = Dual::new(values.as_slice()[row], derivatives.as_slice()[row]);
                    // SAFETY: as above, and it is this program's own.
                    unsafe { place.store(row, if port.adds { place.load(row) + share } else { share }) };
                }
            }
        }
    }

    /// Runs the law on the arrays; what it gives begins from zero.
    fn evaluate(&mut self, context: &Context<'_, P>) {
        for numbers in self.ports.iter_mut().filter(|port| !port.is_input).flat_map(|port| &mut port.numbers) {
            numbers.as_mut_slice().fill(P::default());
        }
        let link = self.link.map(|(start, count, arity)| {
            // SAFETY: the links of the layout that the program was tied to.
            (unsafe { core::slice::from_raw_parts(start, count) }, arity)
        });
        let signature = &context.laws[self.law].compiled.signature;
        let components = signature.ports.iter().zip(&self.views).flat_map(|(port, view)| {
            view.components[..port.property.kind.width()].iter().map(|start| (*start, port.place))
        });
        // SAFETY: the views are of this law's own arrays, one for each port, with as many numbers as they say; ends are those of the
        // layout that the program was tied to.
        unsafe {
            match &context.laws[self.law].compiled.kernel {
                Kernel::Column(kernel) => kernel.run(&ColumnAccess::new(&self.views, link)),
                Kernel::Pair(kernel) => {
                    let rows = self.ports.iter().filter(|port| !port.is_input).map(|port| port.rows).max();
                    let slots: Vec<*mut P> = components.map(|(start, _)| start).collect();
                    let call = PairCall {
                        slots: &slots,
                        rests: &[],
                        rows: 0..rows.unwrap_or(0),
                        others: 0..rows.unwrap_or(0),
                        first: true,
                        estimates: false,
                        square: P::default(),
                    };
                    kernel.run(context.isa, &call);
                }
                Kernel::Link(kernel) => {
                    let strided = |(start, place)| Strided { start, stride: usize::from(place != law::Place::Scene) };
                    let slots: Vec<Strided<P>> = components.map(strided).collect();
                    let (ends, arity) = link.unwrap_or((&[], 1));
                    let links = Links::First(ends.len() / arity);
                    kernel.run(context.isa, &LinkCall { slots: &slots, ends, links, rows: 0..u32::MAX });
                }
                Kernel::Row(_) => {}
            }
        }
    }
}
