//! The columns of a pipeline on a device.
//!
//! In: who touches which columns, on which side. Out: their numbers there, brought if they were not. Two callers move data: passes that
//! run, and clients that look. Never: a law.

use super::ledger::{Ledger, Side, Touch};
use crate::backend::gpu::{Access, Arriving, Buffer, Device, DeviceFault, Stream, Transfers, Work};
use crate::column::{Away, Elsewhere, Flags};
use crate::pipeline::bind::{Base, Located};
use crate::real::Scalar;
use crate::registry::QuantityId;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What a column is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum What {
    Quantity(QuantityId),
    Rate(QuantityId),
    Turned(QuantityId),
    Previous(QuantityId),
    /// The share of a law that is evaluated on some steps only: (seat, slot).
    Held(usize, usize),
    /// One of the integrator's vectors.
    Work(usize, QuantityId),
}

/// One column.
struct Column<P> {
    what: What,
    /// Where its components are on the host; none where its owner has gone.
    components: Vec<Located<P>>,
    /// Room on the device, where something there touches it.
    buffer: Option<Buffer>,
    /// What those know who look from outside.
    flags: Arc<Flags>,
    /// Whether nobody can compute it again from others.
    last: bool,
}

/// The step and the time of numbers, and these, by component.
pub(crate) type Seen<P> = (u64, f64, Vec<Vec<P>>);

/// Numbers that somebody asked for and does not wait for.
struct Late {
    column: usize,
    step: u64,
    time: f64,
    copy: Arriving,
}

/// Bytes that come to the host in one go, but for a column that alone has more: a buffer of all columns may be more than a device makes.
const TOGETHER: usize = 256 << 20;

/// Where the numbers of a pipeline are.
pub(crate) struct Residency<P: Scalar> {
    pub(super) device: Arc<Device>,
    pub(super) ledger: Ledger,
    columns: Vec<Column<P>>,
    stream: Stream,
    arriving: Vec<Late>,
    /// Sums of vectors that were asked for.
    pub(super) sums: HashMap<super::vectors::Key, super::vectors::SumOf>,
    /// Whether the device has refused one of them.
    pub(super) refuses_sums: bool,
    /// Whether the device is gone, and that is in the books.
    failed: bool,
    /// Whether that is news.
    unseen: bool,
    /// Whether passes are running, which cannot be run again.
    running: bool,
    /// Whether numbers have come to the host that nobody has looked through.
    returned: bool,
    /// Whether numbers were lost with the device, and nobody was told.
    lost: Option<String>,
}

/// Shared by a pipeline and the columns that look for their numbers.
pub(crate) type Shared<P> = Arc<Mutex<Residency<P>>>;

// SAFETY: its pointers are into columns of the state and vectors of the pipeline that it was made for. Columns tell it before their memory
// goes or moves (`Away`), and so does the pipeline before its vectors go (`forget_vectors`); all of this happens under one lock.
unsafe impl<P: Scalar> Send for Residency<P> {}

/// Who asks now; who panicked while asking has left no column half moved: numbers count as moved when they are.
pub(crate) fn lock<P: Scalar>(shared: &Mutex<Residency<P>>) -> MutexGuard<'_, Residency<P>> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<P: Scalar> Residency<P> {
    /// All is on the host.
    pub(crate) fn new(device: Arc<Device>) -> Self {
        let (ledger, stream) = (Ledger::default(), Stream::default());
        // Of a device that is gone already nothing is asked.
        let failed = device.look().is_some();
        Residency {
            device,
            ledger,
            columns: Vec::new(),
            stream,
            arriving: Vec::new(),
            sums: HashMap::new(),
            refuses_sums: false,
            failed,
            unseen: false,
            running: false,
            returned: false,
            lost: None,
        }
    }

    /// The number of a column, which is added if it is not known.
    pub(super) fn column(&mut self, what: What, components: impl FnOnce() -> Vec<Located<P>>) -> usize {
        if let Some(known) = self.find(what) {
            return known;
        }
        let (components, flags) = (components(), Arc::default());
        self.columns.push(Column { what, components, buffer: None, flags, last: false });
        self.ledger.add()
    }

    /// The number of a column that is known.
    pub(super) fn find(&self, what: What) -> Option<usize> {
        self.columns.iter().position(|column| column.what == what)
    }

    pub(super) fn what(&self, column: usize) -> What {
        self.columns[column].what
    }

    /// Rows of a column.
    pub(super) fn rows(&self, column: usize) -> usize {
        self.columns[column].components.first().map_or(0, |located| located.len)
    }

    pub(super) fn bytes(&self, column: usize) -> usize {
        self.columns[column].bytes()
    }

    /// Room for a column on the device.
    pub(super) fn buffer(&mut self, column: usize) -> Result<&Buffer, DeviceFault> {
        let column = &mut self.columns[column];
        let room = match column.buffer.take() {
            Some(room) => room,
            None => self.device.room(column.bytes() as u64)?,
        };
        Ok(column.buffer.insert(room))
    }

    /// Nobody can compute a column again: it is state, or what laws remember.
    pub(super) fn cannot_be_made_again(&mut self, what: What) {
        if let Some(column) = self.find(what) {
            self.columns[column].last = true;
        }
    }

    /// The room that a column has on the device.
    pub(super) fn room(&self, column: usize) -> Option<&Buffer> {
        self.columns[column].buffer.as_ref()
    }

    /// Lets a column of the state know where to ask for its numbers.
    pub(crate) fn away(shared: &Shared<P>, what: What) -> Option<Away> {
        let known = lock(shared);
        let column = known.find(what).filter(|column| known.columns[*column].buffer.is_some())?;
        Some(Away::new(Arc::clone(shared) as Arc<dyn Elsewhere>, column, Arc::clone(&known.columns[column].flags)))
    }

    /// What was moved so far.
    pub(crate) fn moved(&self) -> Transfers {
        self.stream.moved()
    }

    /// Whether the device no longer answers.
    pub(crate) fn is_lost(&self) -> bool {
        self.failed
    }

    /// The newest numbers of a column that have arrived of those that were asked for, with the step and the time that they are of; and asks
    /// for those of now.
    pub(crate) fn late(&mut self, what: What, step: u64, time: f64) -> Option<Seen<P>> {
        let column = self.find(what)?;
        if let Some(fault) = self.device.look() {
            self.fail(&fault);
            return None;
        }
        let mut newest = None;
        self.arriving.retain(|late| {
            let bytes = if late.column == column { late.copy.bytes() } else { None };
            let stays = bytes.is_none();
            newest = bytes.map(|bytes| (late.step, late.time, bytes)).or_else(|| newest.take());
            stays
        });
        let of_column = || self.arriving.iter().filter(|late| late.column == column);
        let (count, asked) = (of_column().count(), of_column().any(|late| late.step == step));
        if let Some(buffer) = self.columns[column].buffer.as_ref().filter(|_| count < 2 && !asked) {
            let copy = self.stream.copy(&self.device, buffer, self.columns[column].bytes() as u64);
            self.arriving.push(Late { column, step, time, copy });
        }
        let (step, time, bytes) = newest?;
        let mut rest = bytes.as_slice();
        let components = self.columns[column].components.iter().map(|located| {
            let mut numbers = vec![P::default(); located.len];
            let (own, later) = rest.split_at(size_of_val(numbers.as_slice()));
            rest = later;
            // SAFETY: there are as many numbers, of f32 or f64: any bytes are some.
            unsafe { numbers.as_mut_ptr().cast::<u8>().copy_from_nonoverlapping(own.as_ptr(), own.len()) };
            numbers
        });
        Some((step, time, components.collect()))
    }

    /// Whether the device was lost, and nobody has asked yet.
    pub(crate) fn has_unseen_loss(&self) -> bool {
        self.unseen
    }

    /// Finds a loss that nobody has noticed yet, before more is lost; whether there was one since this was last asked.
    pub(crate) fn look_for_loss(&mut self) -> bool {
        if let Some(fault) = self.device.look().filter(|_| !self.failed) {
            self.fail(&fault);
        }
        core::mem::take(&mut self.unseen)
    }

    /// Why numbers were lost, where that is so and nobody was told.
    pub(crate) fn loss(&mut self) -> Option<String> {
        self.lost.take()
    }

    /// A pass on the device touches these.
    pub(super) fn on_device(&mut self, touches: &[Touch], lent: &[*mut P]) {
        for &touch in touches {
            if self.ledger.is_missing(Side::Device, touch) {
                self.bring_to_device(touch.column, lent);
            }
            if self.failed {
                return;
            }
            self.touched(Side::Device, touch);
        }
    }

    /// A pass on the host touches these; the device works beside it.
    pub(crate) fn on_host(&mut self, touches: &[Touch], lent: &[*mut P]) {
        self.bring(touches, lent);
        if let Err(fault) = self.stream.submit(&self.device) {
            self.fail(&fault);
        }
    }

    /// Somebody on the host touches these.
    pub(super) fn bring(&mut self, touches: &[Touch], lent: &[*mut P]) {
        let missing = touches.iter().filter(|touch| self.ledger.is_missing(Side::Host, **touch));
        let missing: Vec<usize> = missing.map(|touch| touch.column).collect();
        self.bring_to_host(&missing, lent);
        for &touch in touches {
            self.touched(Side::Host, touch);
        }
    }

    fn touched(&mut self, side: Side, touch: Touch) {
        if side == Side::Host {
            // What is still on its way is older than what is here.
            self.arriving.retain(|late| late.column != touch.column);
        }
        self.ledger.touch(side, touch);
        let [here, there] = [Side::Host, Side::Device].map(|side| self.ledger.is_valid(side, touch.column));
        self.columns[touch.column].flags.set(!here, there);
    }

    /// Everything is looked at on the host, or changed there.
    pub(crate) fn all_on_host(&mut self, changes: bool, lent: &[*mut P]) {
        let access = if changes { Access::Update } else { Access::Read };
        let all: Vec<Touch> = (0..self.ledger.len()).map(|column| Touch { column, access }).collect();
        self.on_host(&all, lent);
    }

    /// Whether numbers have come to the host since this was last asked.
    pub(crate) fn have_returned(&mut self) -> bool {
        core::mem::take(&mut self.returned)
    }

    /// Passes run from now on.
    pub(crate) fn begin(&mut self) {
        self.running = true;
    }

    /// They have run. The client's memory comes home before the client gets it back, and may be another when it is lent again.
    pub(crate) fn end(&mut self, lent: &[*mut P]) {
        let touches = self.lent();
        if !touches.is_empty() {
            self.on_host(&touches, lent);
        }
        self.running = false;
    }

    /// What the client does to its own memory between runs.
    pub(super) fn lent(&self) -> Vec<Touch> {
        let lent = self.columns.iter().enumerate().filter(|(_, column)| column.is_lent());
        lent.map(|(column, _)| Touch { column, access: Access::Update }).collect()
    }

    /// Records a program whose columns are there.
    pub(super) fn record(&mut self, work: &Work<'_>) {
        if let Err(fault) = self.stream.record(&self.device, work) {
            self.fail(&fault);
        }
    }

    /// Waits for all that was recorded.
    pub(super) fn finish(&mut self) {
        if let Err(fault) = self.stream.finish(&self.device) {
            self.fail(&fault);
        }
    }

    fn bring_to_device(&mut self, column: usize, lent: &[*mut P]) {
        // What is written from here overtakes what is only recorded.
        if let Err(fault) = self.stream.submit(&self.device) {
            return self.fail(&fault);
        }
        let Column { components, buffer: Some(buffer), .. } = &self.columns[column] else { return };
        if self.columns[column].bytes() == 0 {
            return;
        }
        if components.iter().all(|located| located.stride == 1) {
            let parts = components.iter().map(|located| {
                // SAFETY: the runner holds the state, where the component has so many numbers, one behind the other.
                bytes_of(unsafe { core::slice::from_raw_parts(located.base.resolve(lent), located.len) })
            });
            return self.stream.upload(&self.device, buffer, parts);
        }
        let mut packed = Vec::new();
        for located in components {
            let start = located.base.resolve(lent);
            // SAFETY: the runner holds the state, where the component has so many numbers, so far apart.
            packed.extend((0..located.len).map(|row| unsafe { *start.add(row * located.stride) }));
        }
        self.stream.upload(&self.device, buffer, [bytes_of(&packed)].into_iter());
    }

    /// Brings the numbers of columns to the host, in one go, or in as many as they have room in.
    fn bring_to_host(&mut self, columns: &[usize], lent: &[*mut P]) {
        // Who asks without the client's memory asks for none of it.
        let there = |column: &Column<P>| column.bytes() > 0 && !(lent.is_empty() && column.is_lent());
        let mut left: Vec<usize> = columns.iter().copied().filter(|column| there(&self.columns[*column])).collect();
        while !left.is_empty() && !self.failed {
            let mut bytes = 0;
            let fits = |column: &&usize| {
                bytes += self.columns[**column].bytes();
                bytes <= TOGETHER
            };
            let count = left.iter().take_while(fits).count().max(1);
            let later = left.split_off(count);
            self.bring_together(&left, lent);
            left = later;
        }
    }

    fn bring_together(&mut self, columns: &[usize], lent: &[*mut P]) {
        let all: Vec<&Column<P>> = columns.iter().map(|column| &self.columns[*column]).collect();
        let from: Vec<(&Buffer, usize)> =
            all.iter().filter_map(|column| Some((column.buffer.as_ref()?, column.bytes()))).collect();
        self.returned = true;
        let done = self.stream.download(&self.device, &from, |mut bytes| {
            for column in &all {
                let (own, rest) = bytes.split_at(column.bytes());
                column.take(own, lent);
                bytes = rest;
            }
        });
        if let Err(fault) = done {
            self.fail(&fault);
        }
    }

    /// The device is gone: what only it had is no number any more.
    fn fail(&mut self, fault: &DeviceFault) {
        if !self.failed {
            log::warn!("{fault}: its laws go on on the host");
            self.device.give_up(fault.clone());
            (self.failed, self.unseen, self.returned) = (true, true, true);
        }
        for number in 0..self.columns.len() {
            let column = &self.columns[number];
            if !self.ledger.is_valid(Side::Host, number) && column.bytes() > 0 {
                column.spoil();
                if column.last || self.running {
                    self.lost = Some(fault.to_string());
                }
            }
            self.touched(Side::Host, Touch { column: number, access: Access::Write });
        }
    }

    /// The pipeline goes, and its vectors with it: nobody asks for them any more.
    pub(crate) fn forget_vectors(&mut self) {
        for number in 0..self.columns.len() {
            match self.columns[number].what {
                What::Quantity(_) | What::Previous(_) => {}
                What::Rate(_) | What::Turned(_) | What::Held(..) | What::Work(..) => self.forget(number),
            }
        }
    }

    fn forget(&mut self, column: usize) {
        self.columns[column].components.clear();
        self.touched(Side::Host, Touch { column, access: Access::Write });
    }
}

impl<P: Scalar> Elsewhere for Mutex<Residency<P>> {
    fn bring(&self, column: usize) {
        lock(self).bring(&[Touch { column, access: Access::Read }], &[]);
    }

    fn hand_over(&self, column: usize) {
        lock(self).bring(&[Touch { column, access: Access::Update }], &[]);
    }

    fn forget(&self, column: usize) {
        lock(self).forget(column);
    }
}

/// Numbers as bytes.
fn bytes_of<P: Scalar>(numbers: &[P]) -> &[u8] {
    // SAFETY: programs are of f32 and f64 only, in which every byte is there and is a number's.
    unsafe { core::slice::from_raw_parts(numbers.as_ptr().cast::<u8>(), size_of_val(numbers)) }
}

impl<P: Scalar> Column<P> {
    /// Whether it is the client's memory.
    fn is_lent(&self) -> bool {
        self.components.iter().any(|located| matches!(located.base, Base::Lent { .. }))
    }

    fn bytes(&self) -> usize {
        self.components.iter().map(|located| located.len * size_of::<P>()).sum()
    }

    /// Takes the numbers from bytes that came from the device.
    fn take(&self, mut bytes: &[u8], lent: &[*mut P]) {
        for located in &self.components {
            let start = located.base.resolve(lent);
            let (own, rest) = bytes.split_at(located.len * size_of::<P>());
            bytes = rest;
            if located.stride == 1 {
                // SAFETY: whoever asks holds the state, where the component has so many numbers, of f32 or f64: any bytes are some.
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

    /// Puts in the place of numbers that were lost what nobody takes for some.
    fn spoil(&self) {
        for located in &self.components {
            let Base::Owned(start) = located.base else { continue };
            for row in 0..located.len {
                // SAFETY: as above.
                unsafe { *start.add(row * located.stride) = P::from_f64(f64::NAN) };
            }
        }
    }
}
