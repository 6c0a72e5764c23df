//! A law written without the derive, by somebody who counts slots wrong.

use super::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use vesper::backend::{Compile, Compiled, row};
use vesper::law::{Declared, Law, Mode, Place, Port, RowFamily, RowLaw, Signature, Sink, Source};

/// Reads the slot `READ`, and adds to the slot `WRITTEN`; declares 0 and 1.
#[derive(Clone, Copy, Debug)]
struct Counted<const READ: usize, const WRITTEN: usize>;

const fn port(property: PropertyInfo, mode: Mode) -> Port {
    Port { field: property.name, property, mode, place: Place::Own, optional: false, default: None, from: u64::MAX }
}

impl<const READ: usize, const WRITTEN: usize> Law for Counted<READ, WRITTEN> {
    const SIGNATURE: Signature = Signature {
        name: "counted",
        doc: "",
        domain: None,
        ports: &[port(Mass::INFO, Mode::Reads), port(Heat::INFO, Mode::Adds)],
        parameters: &[],
        link: None,
        second_order: false,
        translation_invariant: false,
        antisymmetric: false,
        estimates: false,
        cutoff: None,
        file: "",
        line: 0,
    };
    type Body<R: Real> = Self;
    fn body<R: Real>(&self) -> Self {
        *self
    }
    fn from_parameters(_: &[f64]) -> Self {
        Counted
    }
    fn parameters(&self) -> Vec<f64> {
        Vec::new()
    }
}

property! {
    /// A sum to add to.
    Heat: Scalar, "J", sum;
}

impl<R: Real, const READ: usize, const WRITTEN: usize> Declared<R> for Counted<READ, WRITTEN> {
    type Row = R;
    type End = ();
    type Output = R;
    type EndOutput = ();
    fn load<S: Source<R>>(source: &S) -> R {
        source.component(READ)
    }
    fn load_end<S: Source<R>>(_: &S) {}
    fn store<K: Sink<R>>(output: R, sink: &mut K) {
        sink.add(WRITTEN, output);
    }
    fn store_end<K: Sink<R>>((): (), _: &mut K) {}
}

impl<R: Real, const READ: usize, const WRITTEN: usize> RowLaw<R> for Counted<READ, WRITTEN> {
    fn row(&self, mass: R) -> R {
        mass
    }
}

impl<const READ: usize, const WRITTEN: usize> RowFamily for Counted<READ, WRITTEN> {
    type Kernel<R: Real> = Self;
    const ENERGY: bool = false;
    fn kernel<R: Real>(&self) -> Self {
        *self
    }
}

impl<const READ: usize, const WRITTEN: usize> Compile for Counted<READ, WRITTEN> {
    fn compile_f32(&self) -> Compiled<f32> {
        row(self)
    }
    fn compile_f64(&self) -> Compiled<f64> {
        row(self)
    }
    fn compile_double_double(&self) -> Compiled<DoubleDouble> {
        row(self)
    }
}

fn heat(law: impl Compile) -> Result<Vec<f64>, ()> {
    let build = || Engine::<f64>::builder().domain(one()).law(law).observe("bodies", Heat).build().unwrap();
    let engine = catch_unwind(AssertUnwindSafe(build)).map_err(|_| ())?;
    Ok(engine.state().values("bodies", Heat).unwrap())
}

#[test]
fn a_slot_that_is_not_declared_is_a_panic_and_never_anothers_memory() {
    assert_eq!(heat(Counted::<0, 1>), Ok(vec![2.0]));
    assert_eq!(heat(Counted::<1, 1>), Err(()), "an output is not read");
    assert_eq!(heat(Counted::<0, 0>), Err(()), "an input is not written");
    assert_eq!(heat(Counted::<63, 1>), Err(()));
    assert_eq!(heat(Counted::<0, 64>), Err(()));
}

/// An integrator that asks for what is not there.
#[derive(Debug)]
struct Greedy(fn(&mut dyn System));

impl Integrator for Greedy {
    fn name(&self) -> &'static str {
        "greedy"
    }
    fn order(&self) -> u32 {
        1
    }
    fn work_vectors(&self) -> usize {
        1
    }
    fn step(&mut self, system: &mut dyn System, _step: f64) -> Result<(), Fault> {
        (self.0)(system);
        Ok(())
    }
}

#[test]
fn an_integrator_that_asks_for_what_is_not_there_gets_a_panic_and_no_memory() {
    type Ask = fn(&mut dyn System);
    let asks: [(Ask, &str); 3] = [
        (
            |system| system.copy(Register::Work(1), Register::Rates, Part::All),
            "as many vectors as its work_vectors says: 1",
        ),
        (
            |system| {
                let (to, momenta) = (Register::Work(0), Terms::of(&[(1.0, Register::Rates)]));
                system.linear(Combination { to, adds: false, part: Part::All, terms: Terms::NONE, momenta });
            },
            "momenta are summed to the coordinates",
        ),
        (|system| system.magnitudes(&[Register::State; 13], Part::All, &mut |_, _| {}), "no more than 12 vectors"),
    ];
    for (ask, expected) in asks {
        let mut engine = Engine::<f64>::builder()
            .domain(one())
            .law(Motion)
            .integrator(Greedy(ask))
            .step(0.1)
            .compensated()
            .build()
            .unwrap();
        let panic = catch_unwind(AssertUnwindSafe(|| engine.advance(0.1))).unwrap_err();
        let text =
            panic.downcast_ref::<String>().cloned().or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
        assert!(text.as_ref().is_some_and(|text| text.contains(expected)), "{text:?}");
    }
}
