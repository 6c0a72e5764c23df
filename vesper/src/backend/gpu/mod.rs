//! Laws on graphics processors: the text of a kernel is made from the law's own body.
//!
//! In: the body that all other backends run. Out: a program in WGSL with a loop of the law's shape, and the buffers that it reads and
//! writes. Never: a second text of a law.
//!
//! The way: `trace` runs the body once over numbers that record what is done to them (`traced`); `layout` says from the signature
//! which buffers there are, and what may be done to each; `wgsl` writes the text; `check` has it parsed, validated, and compared with
//! the signature.

mod check;
mod compare;
mod device;
mod layout;
mod links;
mod operations;
mod stream;
mod trace;
mod traced;
mod wgsl;

pub(crate) use check::{Wrong, check};
pub use compare::{Comparison, NotCompared, compare};
pub(crate) use device::Prepared;
pub use device::{Device, DeviceFault, NoDevice};
pub(crate) use layout::{Access, Binding, Layout, Slot, Store};
pub(crate) use links::Ends;
pub use stream::Transfers;
pub(crate) use stream::{Arriving, Stream, Work};
pub(crate) use trace::{Trace, link, pair, row};
pub(crate) use wgpu::{BindGroup, Buffer};
pub(crate) use wgsl::{Loop, Numbers, Program, Refused, Word, write};

use super::{Compiled, Kernel};
use crate::real::{InPrecision, Scalar};

/// Why a law has no program for devices.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("law {law} has no kernel for devices: {reason}")]
pub struct NoKernel {
    law: &'static str,
    reason: Reason,
}

#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
enum Reason {
    #[error("it is of whole columns, with an algorithm of its own")]
    Columns,
    #[error("it is a closure, which only the host can call")]
    Closure,
    #[error("it ends at a distance, and lists of neighbours are the host's")]
    Cutoff,
    #[error("devices have no double-double numbers")]
    DoubleDouble,
    #[error(transparent)]
    Refused(#[from] Refused),
    #[error(transparent)]
    Wrong(#[from] Wrong),
}

/// The precision of a text for each precision of an engine.
struct OnDevice;

impl InPrecision for OnDevice {
    type Of<P: Scalar> = Option<Numbers>;
}

impl<P: Scalar> Compiled<P> {
    /// The law's program, where those optional components are there whose bits are set, with its buffers as the signature has them.
    pub(crate) fn program(&self, there: u64) -> Result<Program, NoKernel> {
        self.program_in(Layout::of(&self.signature, there), there, true)
    }

    /// The same, with its buffers as they are laid out here; with estimated roots, if they are asked for and the law allows them.
    pub(crate) fn program_in(&self, layout: Layout, there: u64, estimates: bool) -> Result<Program, NoKernel> {
        let fail = |reason| NoKernel { law: self.signature.name, reason };
        let precision = P::choose::<OnDevice>(|| Some(Numbers::F32), || Some(Numbers::F64), || None);
        let precision = precision.ok_or(fail(Reason::DoubleDouble))?;
        let (trace, shape) = self.traced(there).map_err(fail)?;
        let program = write(&trace, layout, shape, precision, estimates && self.signature.estimates);
        let program = program.map_err(|refused| fail(refused.into()))?;
        check(&program).map_err(|wrong| fail(wrong.into()))?;
        Ok(program)
    }

    fn traced(&self, there: u64) -> Result<(Trace, Loop), Reason> {
        let (trace, shape) = match &self.kernel {
            Kernel::Row(kernel) => (kernel.trace(there), Loop::Rows),
            Kernel::Pair(_) if self.signature.cutoff.is_some() => return Err(Reason::Cutoff),
            Kernel::Pair(kernel) => (kernel.trace(there), Loop::Pairs),
            Kernel::Link(kernel) => (kernel.trace(there), Loop::Links(kernel.arity())),
            Kernel::Column(_) => return Err(Reason::Columns),
        };
        Ok((trace.ok_or(Reason::Closure)?, shape))
    }
}

/// A program that copies numbers: the first so many slots of the layout get those of the slots behind them.
pub(crate) fn copied<P: Scalar>(width: usize, layout: Layout) -> Result<Program, NoKernel> {
    program_of::<P>("the start of a sum", &trace::copy(width), layout)
}

/// A program that sums so many columns: the first slot gets the sum of the slots behind it, each times a constant of those behind these.
pub(crate) fn summed<P: Scalar>(terms: usize, layout: Layout) -> Result<Program, NoKernel> {
    program_of::<P>("a sum of vectors", &trace::sum(terms), layout)
}

fn program_of<P: Scalar>(law: &'static str, trace: &Trace, layout: Layout) -> Result<Program, NoKernel> {
    let fail = |reason| NoKernel { law, reason };
    let numbers = P::choose::<OnDevice>(|| Some(Numbers::F32), || Some(Numbers::F64), || None);
    let numbers = numbers.ok_or(fail(Reason::DoubleDouble))?;
    let program = write(trace, layout, Loop::Rows, numbers, false);
    let program = program.map_err(|refused| fail(refused.into()))?;
    check(&program).map_err(|wrong| fail(wrong.into()))?;
    Ok(program)
}

/// The bits of all components.
const ALL: u64 = u64::MAX;

/// The kernel of a law, as a text in WGSL: what a device runs, made from the law's own body. All optional values are there.
///
/// # Errors
/// Devices cannot run the law; the error says why.
pub fn wgsl_of<P: Scalar>(law: &Compiled<P>) -> Result<String, NoKernel> {
    Ok(law.program(ALL)?.text)
}

#[cfg(test)]
mod tests {
    use super::compare::compare_program;
    use super::layout::{Access, Binding, Slot, Store};
    use super::wgsl::Word;
    use super::{ALL, Device, Layout, Loop, Numbers, Program, Work, check, compare, wgsl_of};
    use crate::backend::{Compile, Compiled};
    use crate::prelude::*;
    use crate::property::Corners;

    /// The device that the system has; without one the test says so, and with `VESPER_REQUIRE_GPU=1` it fails.
    fn device() -> Option<Device> {
        match Device::open() {
            Ok(device) => Some(device),
            Err(error) if std::env::var("VESPER_REQUIRE_GPU").is_ok_and(|required| required == "1") => {
                panic!("a device is required: {error}")
            }
            Err(error) => {
                eprintln!("not run: {error}");
                None
            }
        }
    }

    /// A helper of the body: any function that is generic in its numbers will do.
    fn twice_the_larger<R: Real>(a: R, b: R) -> R {
        let mut sum = R::lit(0.0);
        for _ in 0..2 {
            sum += a.max(b);
        }
        sum
    }

    /// Everything that a body may do with numbers, and none of it exact but in one way.
    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(position: Position, velocity: Velocity, mass: Mass), reads(charge: Charge, optional), sets(force: Force))]
    struct Everything<R: Real = f64> {
        /// A factor.
        #[law(unit = "1", default = 0.7)]
        factor: R,
    }

    #[kernel]
    impl<R: Real> RowLaw<R> for Everything<R> {
        fn row(&self, row: EverythingRow<R>) -> R::Vec3 {
            let (x, v) = (row.position, row.velocity);
            let far = self.factor.less(x.length()) & !x.x().equal(v.x()) | v.y().less_or_equal(x.y());
            let charge = row.charge.unwrap_or(R::lit(0.25));
            let along = R::select_vector(far, x.cross(v) / row.mass, -x);
            let least = x.y().abs().min(v.y().abs()).min(R::lit(f64::INFINITY));
            R::Vec3::new(
                along.x() - charge.over_root_cubed(row.mass),
                along.y() + twice_the_larger(least, row.mass.rsqrt()),
                R::select(R::lit(f64::NAN).equal(R::lit(f64::NAN)), R::lit(1.0), along.z()),
            )
        }
    }

    /// What devices compute in their own way.
    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(position: Position, mass: Mass), sets(force: Force))]
    struct Functions;

    #[kernel]
    impl<R: Real> RowLaw<R> for Functions {
        fn row(&self, row: FunctionsRow<R>) -> R::Vec3 {
            let [x, y, z] = [row.position.x(), row.position.y(), row.position.z()];
            R::Vec3::new(
                // Negative numbers to whole powers.
                x.powf(R::lit(3.0)) + y.powf(R::lit(-2.0)) + z.abs().powf(row.mass) + x.powf(R::lit(0.0)),
                y.sin() * z.cos(),
                x.exp() + row.mass.ln(),
            )
        }
    }

    /// A row that is corrected: what is read and amended is one buffer.
    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(position: Position), amends(corrected: Position))]
    struct Fold;

    #[kernel]
    impl<R: Real> RowLaw<R> for Fold {
        fn row(&self, row: FoldRow<R>) -> R::Vec3 {
            R::Vec3::new(row.position.y(), row.position.x(), -row.position.z())
        }
    }

    /// A pair law whose share depends on both rows.
    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(position: Position, charge: Charge), adds(force: Force))]
    struct Attraction;

    #[kernel]
    impl<R: Real> PairLaw<R> for Attraction {
        fn pair(&self, i: AttractionRow<R>, j: AttractionRow<R>) -> R::Vec3 {
            let apart = j.position - i.position;
            apart * ((i.charge * j.charge) / (apart.length_squared() + R::lit(0.1)))
        }
    }

    property! {
        /// A weight of a triangle.
        Weight: Scalar, "1";
    }

    /// A link of three ends, each of which gets something else.
    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(weight: Weight), link(corners: Corners, reads(position: Position), adds(force: Force)))]
    struct Triangle;

    #[kernel]
    impl<R: Real> LinkLaw<R, 3> for Triangle {
        fn link(&self, row: TriangleRow<R>, ends: [TriangleEnd<R>; 3]) -> [R::Vec3; 3] {
            let [a, b, c] = ends.map(|end| end.position);
            [(b - a) * row.weight, (c - b) / row.weight, a.cross(c)]
        }
    }

    fn same_bits<P: crate::real::Scalar>(device: &Device, law: &impl Compile, rows: usize) {
        let found = compare(device, &law.compile::<P>(), rows).unwrap();
        assert!(found.same == found.numbers && found.zeros * 2 < found.numbers, "{found:?}");
    }

    #[test]
    fn bodies_give_the_bits_of_the_host() {
        let Some(device) = device() else { return };
        let law = Everything { factor: 0.7 };
        same_bits::<f32>(&device, &law, 500);
        same_bits::<f32>(&device, &Fold, 500);
        same_bits::<f32>(&device, &Triangle, 500);
        if device.has(Numbers::F64) {
            same_bits::<f64>(&device, &law, 500);
            same_bits::<f64>(&device, &Triangle, 500);
        }
    }

    #[test]
    fn sums_and_functions_are_near_those_of_the_host() {
        let Some(device) = device() else { return };
        let functions = compare(&device, &Functions.compile::<f32>(), 500).unwrap();
        assert!(functions.largest < 1e-6, "{functions:?}");
        for rows in [2, 63, 64, 65, 1000] {
            let pairs = compare(&device, &Attraction.compile::<f32>(), rows).unwrap();
            assert!(pairs.largest < 1e-6 && pairs.zeros == 0, "{rows}: {pairs:?}");
        }
    }

    #[test]
    fn f64_refuses_functions_that_devices_lack() {
        let error = wgsl_of(&Functions.compile::<f64>()).unwrap_err().to_string();
        assert!(error.contains("functions") && error.contains("f64 has no `") && error.contains("in f32"), "{error}");
    }

    #[test]
    fn an_absent_value_is_no_buffer() {
        let program = |there| Everything { factor: 0.7 }.compile::<f32>().program(there).unwrap();
        let buffers = |there| program(there).layout.bindings.len();
        assert_eq!(buffers(0) + 1, buffers(u64::MAX));
    }

    /// Who finds a wrong declaration.
    #[derive(Debug, PartialEq)]
    enum Found {
        /// Who reads the text: naga, when the program is made.
        Reading(&'static str),
        /// Who runs it beside the host: columns that are not written whole are written all the same.
        Running,
    }
    use Found::{Reading, Running};

    /// Twelve programs that do something else than is declared.
    #[test]
    fn a_program_that_does_other_than_declared_is_found() {
        let (row, fold, link) =
            (Everything { factor: 0.7 }.compile::<f32>(), Fold.compile::<f32>(), Triangle.compile::<f32>());
        let access = |law: &Compiled<f32>, name: &str, access| {
            let mut wrong = law.program(ALL).unwrap();
            check(&wrong).unwrap();
            let names: Vec<String> = wrong.layout.bindings.iter().map(|binding| binding.name.clone()).collect();
            let binding = wrong.layout.bindings.iter_mut().find(|binding| binding.name.starts_with(name));
            binding.unwrap_or_else(|| panic!("{name} is none of {names:?}")).access = access;
            wrong
        };
        let text = |law: &Compiled<f32>, from: &str, to: &str| {
            let mut wrong = law.program(ALL).unwrap();
            assert!(wrong.text.contains(from), "{}", wrong.text);
            wrong.text = wrong.text.replace(from, to);
            wrong
        };
        let mutants = [
            ("a read declared a write", &row, access(&row, "position_in", Access::Write), Reading("reads")),
            ("a read declared both", &row, access(&row, "position_in", Access::Update), Reading("does not write")),
            ("a write declared a read", &row, access(&row, "force_out", Access::Read), Reading("writes")),
            ("an amended column declared a read", &fold, access(&fold, "position_in", Access::Read), Reading("writes")),
            (
                "an amended column declared a write",
                &fold,
                access(&fold, "position_in", Access::Write),
                Reading("reads"),
            ),
            ("a sum declared a read", &link, access(&link, "force_end_sum", Access::Read), Reading("writes")),
            ("a sum declared a write", &link, access(&link, "force_end_sum", Access::Write), Reading("reads")),
            ("a link's value declared a write", &link, access(&link, "weight_in", Access::Write), Reading("reads")),
            ("a read not declared", &row, text(&row, "mass_in_2[row]", "mess_in[row]"), Reading("mess_in")),
            ("a component not written", &row, text(&row, "force_out_4[row] =", "let nothing ="), Running),
            ("the last row not written", &fold, text(&fold, "row >= call.rows", "row + 1u >= call.rows"), Running),
            ("an end without its share", &link, text(&link, "end == 2u", "end == 3u"), Running),
        ];
        let device = device();
        for (name, law, wrong, found) in mutants {
            match found {
                Reading(words) => {
                    let error = check(&wrong).unwrap_err().to_string();
                    assert!(error.contains(words), "{name}: {error}");
                }
                Running => {
                    check(&wrong).unwrap_or_else(|error| panic!("{name}: {error}"));
                    let Some(device) = &device else { continue };
                    let ran = compare_program(device, law, wrong, 500).unwrap();
                    assert!(ran.largest > 1e-3, "{name}: {ran:?}");
                }
            }
        }
    }

    /// Drivers that cut loops short give wrong sums without a word: Mesa before 25 ends them after 65 535 passes.
    #[test]
    fn the_device_counts_to_100_000() {
        let Some(device) = device() else { return };
        let text = "struct Call { rows: u32, }
            var<immediate> call: Call;
            @group(0) @binding(0) var<storage, read_write> counted: array<f32>;
            @compute @workgroup_size(64)
            fn main(@builtin(global_invocation_id) id: vec3<u32>) {
                var count = 0u;
                for (var outer = 0u; outer < 2000u; outer = outer + call.rows) {
                    for (var inner = 0u; inner < 50u; inner = inner + call.rows) {
                        count = count + 1u;
                    }
                }
                if id.x < call.rows { counted[id.x] = f32(count); }
            }";
        let layout = Layout {
            bindings: vec![Binding { name: "counted".to_owned(), access: Access::Write }],
            slots: vec![Slot::Output { binding: 0, component: 0, store: Store::Set }],
        };
        let program = Program {
            text: text.to_owned(),
            layout,
            precision: Numbers::F32,
            shape: Loop::Rows,
            call: vec![Word::Rows],
        };
        check(&program).unwrap();
        let prepared = device.prepare(program).unwrap();
        let buffer = device.buffer(4);
        let group = device.bind(&prepared, &[&buffer]);
        let work = Work { prepared: &prepared, group: &group, call: 1u32.to_le_bytes().to_vec(), rows: 1 };
        let mut counted = 0.0;
        device
            .run([work].into_iter(), &[(&buffer, 4)], |bytes| counted = f32::from_le_bytes(bytes.try_into().unwrap()))
            .unwrap();
        assert_eq!(counted, 100_000.0, "{} ends loops early: sums over many rows would be wrong", device.name());
    }
}
