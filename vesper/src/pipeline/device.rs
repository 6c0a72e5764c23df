//! A pass on a graphics processor.
//!
//! In: the operations of a pass, where columns are, a device. Out: the same results in the same columns: what the pass reads is brought to
//! the device, its laws run there one after the other, and what they wrote comes back. Never: a law that the device cannot run; then the
//! pass stays on the host, and says why. A device that is lost on the way changes nothing but where the pass runs: the host's pass stands
//! by, and its columns are whole.

mod build;

use super::bind::{Base, Located, Pass};
use super::run::Context;
use crate::backend::gpu::{BindGroup, Buffer, Device, Prepared, Word, Work};
use crate::real::Scalar;
use crate::registry::QuantityId;
use std::sync::{Arc, Mutex};

/// A pass, ready to run on a device.
pub(crate) struct DevicePass<P: Scalar> {
    /// The same on the host.
    pub(super) host: Box<Pass<P>>,
    device: Arc<Device>,
    columns: Vec<Column<P>>,
    calls: Vec<Call<P>>,
}

/// Numbers that have a place on the device.
struct Column<P> {
    what: What,
    /// Where its components are on the host.
    components: Vec<Located<P>>,
    buffer: Buffer,
    /// Whether a law of the pass looks at what was there before the pass.
    brought: bool,
    /// Whether a law of the pass writes it.
    taken: bool,
}

/// What a column is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum What {
    Quantity(QuantityId),
    Rate(QuantityId),
    Turned(QuantityId),
    Previous(QuantityId),
    Held(usize, usize),
}

/// A program of the pass.
struct Call<P> {
    /// The law, where it is one: sums begin by none.
    law: Option<usize>,
    prepared: Arc<Prepared>,
    group: BindGroup,
    /// By binding.
    columns: Vec<usize>,
    /// Links and the rows that they end at.
    _lists: Vec<Buffer>,
    /// The constants, by slot.
    constants: Vec<(usize, Constant<P>)>,
    rows: u32,
    /// The stage whose step its rates advance states by.
    advance: Option<usize>,
}

/// A number that is the same for all rows.
#[derive(Clone, Copy)]
enum Constant<P> {
    Number(P),
    At(Base<P>),
}

/// Where the columns of a pipeline are on the device, by what they are.
pub(super) type Buffers = Mutex<Vec<(What, Buffer)>>;

impl<P: Scalar> DevicePass<P> {
    /// What each run of the pass moves, for people.
    pub(super) fn moved(&self, name: impl Fn(QuantityId) -> &'static str) -> String {
        let way = |moves: fn(&Column<P>) -> bool, does: &str| {
            let columns: Vec<&Column<P>> = self.columns.iter().filter(|column| moves(column)).collect();
            let names: Vec<String> = columns
                .iter()
                .map(|column| match column.what {
                    What::Quantity(id) => name(id).to_owned(),
                    What::Rate(id) => format!("rate of {}", name(id)),
                    What::Turned(id) => format!("turn of {}", name(id)),
                    What::Previous(id) => format!("previous {}", name(id)),
                    What::Held(..) => "held shares".to_owned(),
                })
                .collect();
            let bytes: usize = columns.iter().map(|column| column.bytes()).sum();
            format!("{does} {}, {bytes} bytes", if names.is_empty() { "nothing".to_owned() } else { names.join(", ") })
        };
        format!("{}; {}", way(|column| column.brought, "brings"), way(|column| column.taken, "takes back"))
    }

    /// Whether the device no longer answers.
    pub(super) fn is_lost(&self) -> bool {
        self.device.is_lost()
    }

    /// Runs the pass on the device; false where the host has to, and nothing has changed.
    pub(super) fn run(&mut self, context: &Context<'_, P>) -> bool {
        // Whoever looks for the first law that gives no number looks after each of them, and so does the host.
        if self.device.is_lost() || context.is_watched() {
            return false;
        }
        let DevicePass { device, columns, calls, .. } = self;
        for column in columns.iter().filter(|column| column.brought) {
            column.bring(device, context.lent);
        }
        let works = calls.iter().map(|call| Work {
            prepared: &call.prepared,
            group: &call.group,
            call: call.words(columns, context),
            rows: call.rows,
        });
        let back: Vec<(&Buffer, usize)> =
            columns.iter().filter(|column| column.taken).map(|column| (&column.buffer, column.bytes())).collect();
        let first = calls.iter().find_map(|call| call.law).unwrap_or_default();
        let mut done = Ok(());
        context.timed(first, || {
            done = device.run(works, &back, |mut bytes| {
                for column in columns.iter().filter(|column| column.taken) {
                    let (own, rest) = bytes.split_at(column.bytes());
                    column.take(own, context.lent);
                    bytes = rest;
                }
            });
        });
        if let Err(fault) = &done {
            log::warn!("{fault}: its laws go on on the host");
            device.give_up(fault.clone());
            return false;
        }
        true
    }
}

impl<P: Scalar> Column<P> {
    fn bytes(&self) -> usize {
        self.components.iter().map(|located| located.len * size_of::<P>()).sum()
    }

    /// Brings the numbers to the device.
    fn bring(&self, device: &Device, lent: &[*mut P]) {
        let mut at = 0;
        let mut packed = Vec::new();
        for located in &self.components {
            let start = located.base.resolve(lent);
            let numbers = if located.stride == 1 {
                // SAFETY: the runner holds the state, where the component has so many numbers.
                unsafe { core::slice::from_raw_parts(start, located.len) }
            } else {
                packed.clear();
                // SAFETY: as above, so far apart.
                packed.extend((0..located.len).map(|row| unsafe { *start.add(row * located.stride) }));
                &packed
            };
            // SAFETY: programs are of f32 and f64 only, in which every byte is there and is a number's.
            let bytes = unsafe { core::slice::from_raw_parts(numbers.as_ptr().cast::<u8>(), size_of_val(numbers)) };
            device.write(&self.buffer, at, bytes);
            at += bytes.len() as u64;
        }
    }

    /// Takes the numbers from bytes that came from the device.
    fn take(&self, mut bytes: &[u8], lent: &[*mut P]) {
        for located in &self.components {
            let start = located.base.resolve(lent);
            let (own, rest) = bytes.split_at(located.len * size_of::<P>());
            bytes = rest;
            if located.stride == 1 {
                // SAFETY: the runner holds the state, where the component has so many numbers, of f32 or f64: any bytes are some.
                unsafe { start.cast::<u8>().copy_from_nonoverlapping(own.as_ptr(), own.len()) };
            } else {
                for (row, own) in own.chunks_exact(size_of::<P>()).enumerate() {
                    // SAFETY: as above, so far apart.
                    unsafe {
                        start.add(row * located.stride).cast::<u8>().copy_from_nonoverlapping(own.as_ptr(), own.len())
                    };
                }
            }
        }
    }
}

impl<P: Scalar> Call<P> {
    /// What comes with the call.
    fn words(&self, columns: &[Column<P>], context: &Context<'_, P>) -> Vec<u8> {
        let mut bytes = Vec::new();
        let number = |bytes: &mut Vec<u8>, number: P| match size_of::<P>() {
            4 => bytes.extend((number.to_f64() as f32).to_le_bytes()),
            _ => bytes.extend(number.to_f64().to_le_bytes()),
        };
        for word in &self.prepared.program.call {
            match *word {
                Word::Constant(slot) => {
                    let constant = self.constants.iter().find(|(own, _)| *own == slot);
                    number(
                        &mut bytes,
                        match constant {
                            Some((_, Constant::Number(number))) => *number,
                            // SAFETY: the runner holds the state, where a constant has one number.
                            Some((_, Constant::At(base))) => unsafe { *base.resolve(context.lent) },
                            None => P::from_f64(f64::NAN),
                        },
                    );
                }
                Word::Step => number(&mut bytes, self.advance.map_or(P::default(), |stage| context.steps[stage])),
                Word::Rows => bytes.extend(self.rows.to_le_bytes()),
                Word::Stride(binding) => {
                    let rows = columns[self.columns[binding]].components[0].len as u32;
                    bytes.extend(rows.to_le_bytes());
                }
            }
        }
        bytes.resize(self.prepared.program.call_bytes() as usize, 0);
        bytes
    }
}
