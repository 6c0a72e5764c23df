//! Work on its way to a device, in order.
//!
//! In: programs with their buffers, bytes. Out: bytes, when somebody waits for them. Work gathers in one encoder and goes to the device
//! when somebody needs a result, when a buffer that it uses is written from the host, or when it has become much. Never: a copy that
//! nobody asked for.

use super::device::{Device, DeviceFault, Prepared};
use super::wgsl::{ACROSS, GROUP};
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, channel};
use wgpu::{BufferDescriptor, BufferUsages, PollType};

/// Programs that gather before they are sent.
const GATHERED: usize = 32;
/// What is on its way at once: whoever sends more waits for the first. Drivers take a device away that does not answer for seconds.
const ON_THEIR_WAY: usize = 2;

/// One program with its buffers, and what comes with the call.
#[derive(Debug)]
pub(crate) struct Work<'a> {
    pub(crate) prepared: &'a Prepared,
    pub(crate) group: &'a wgpu::BindGroup,
    pub(crate) call: Vec<u8>,
    pub(crate) rows: u32,
}

/// What was moved between a host and a device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Transfers {
    /// Columns that were brought to the device; a vector is one column.
    pub uploads: u64,
    /// Their bytes.
    pub uploaded: u64,
    /// Columns that were brought to the host.
    pub downloads: u64,
    /// Their bytes.
    pub downloaded: u64,
    /// How often work was sent to the device.
    pub submissions: u64,
    /// How often the host waited for a result.
    pub waits: u64,
}

/// The work of one client of a device.
#[derive(Default)]
pub(crate) struct Stream {
    open: Option<Open>,
    sent: VecDeque<wgpu::SubmissionIndex>,
    /// Where bytes come back, so many.
    staging: Option<wgpu::Buffer>,
    moved: Transfers,
}

/// Work that was not sent yet.
struct Open {
    // Ends before the encoder does.
    pass: wgpu::ComputePass<'static>,
    encoder: wgpu::CommandEncoder,
    programs: usize,
}

impl Stream {
    /// What was moved so far.
    pub(crate) fn moved(&self) -> Transfers {
        self.moved
    }

    /// Records a program behind all others.
    pub(crate) fn record(&mut self, device: &Device, work: &Work<'_>) -> Result<(), DeviceFault> {
        if work.rows == 0 {
            return Ok(());
        }
        let open = self.open.get_or_insert_with(|| {
            let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()).forget_lifetime();
            Open { pass, encoder, programs: 0 }
        });
        open.pass.set_pipeline(&work.prepared.pipeline);
        open.pass.set_bind_group(0, work.group, &[]);
        open.pass.set_immediates(0, &work.call);
        let groups = work.rows.div_ceil(GROUP);
        open.pass.dispatch_workgroups(groups.min(ACROSS), groups.div_ceil(ACROSS), 1);
        open.programs += 1;
        if open.programs < GATHERED { Ok(()) } else { self.submit(device) }
    }

    /// Sends what is recorded, and does not wait for it, but where much is on its way for the first of that.
    pub(crate) fn submit(&mut self, device: &Device) -> Result<(), DeviceFault> {
        let Some(Open { pass, encoder, .. }) = self.open.take() else { return Ok(()) };
        drop(pass);
        self.send(device, encoder);
        // The last of those that are too many: those before it have ended then, too.
        let last = self.sent.drain(..self.sent.len().saturating_sub(ON_THEIR_WAY)).next_back();
        last.map_or(Ok(()), |last| wait(device, last))
    }

    fn send(&mut self, device: &Device, encoder: wgpu::CommandEncoder) {
        self.sent.push_back(device.queue.submit([encoder.finish()]));
        self.moved.submissions += 1;
    }

    /// Brings a column to the device, part by part. Bytes overtake work that is recorded: whoever records it sends it first, where it
    /// uses the buffer.
    pub(crate) fn upload<'a>(&mut self, device: &Device, to: &wgpu::Buffer, parts: impl Iterator<Item = &'a [u8]>) {
        let mut at = 0;
        for part in parts {
            device.write(to, at, part);
            at += part.len() as u64;
        }
        self.moved.uploads += 1;
        self.moved.uploaded += at;
    }

    /// Brings so many bytes of each of these buffers to the host, one behind the other, behind all that is recorded.
    pub(crate) fn download(
        &mut self,
        device: &Device,
        from: &[(&wgpu::Buffer, usize)],
        take: impl FnOnce(&[u8]),
    ) -> Result<(), DeviceFault> {
        let size: u64 = from.iter().map(|(_, bytes)| *bytes as u64).sum();
        let staging = match self.staging.take().filter(|staging| staging.size() >= size) {
            Some(staging) => staging,
            None => self::staging(device, size),
        };
        let mut encoder = self.encoder(device);
        let mut at = 0;
        for (buffer, bytes) in from.iter().filter(|(_, bytes)| *bytes > 0) {
            encoder.copy_buffer_to_buffer(buffer, 0, &staging, at, *bytes as u64);
            at += *bytes as u64;
        }
        self.send(device, encoder);
        self.moved.downloads += from.len() as u64;
        self.moved.downloaded += size;
        self.moved.waits += 1;
        let arrived = mapped(&staging, size);
        if let Some(last) = self.sent.pop_back() {
            // All that was sent before has ended, too.
            self.sent.clear();
            wait(device, last)?;
        }
        let lost = || DeviceFault::Lost("its memory cannot be read".to_owned());
        arrived.try_recv().ok().and_then(Result::ok).ok_or_else(lost)?;
        {
            let mapped = staging.get_mapped_range(..size.max(8)).map_err(|_| lost())?;
            take(&mapped[..size as usize]);
        }
        staging.unmap();
        self.staging = Some(staging);
        Ok(())
    }

    /// Sends what is recorded, and behind it a copy of so many bytes of a buffer, which nobody waits for.
    pub(crate) fn copy(&mut self, device: &Device, from: &wgpu::Buffer, bytes: u64) -> Arriving {
        let staging = staging(device, bytes);
        let mut encoder = self.encoder(device);
        encoder.copy_buffer_to_buffer(from, 0, &staging, 0, bytes);
        self.send(device, encoder);
        self.moved.downloads += 1;
        self.moved.downloaded += bytes;
        let arrived = mapped(&staging, bytes);
        Arriving { staging, bytes, arrived }
    }

    /// What is recorded, to go on recording.
    fn encoder(&mut self, device: &Device) -> wgpu::CommandEncoder {
        match self.open.take() {
            Some(Open { pass, encoder, .. }) => {
                drop(pass);
                encoder
            }
            None => device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default()),
        }
    }

    /// Waits until all that was recorded is done.
    pub(crate) fn finish(&mut self, device: &Device) -> Result<(), DeviceFault> {
        self.submit(device)?;
        let last = self.sent.pop_back();
        self.sent.clear();
        last.map_or(Ok(()), |last| wait(device, last))
    }
}

/// A copy that is on its way to the host.
pub(crate) struct Arriving {
    staging: wgpu::Buffer,
    bytes: u64,
    arrived: Arrived,
}

type Arrived = Receiver<Result<(), wgpu::BufferAsyncError>>;

impl Arriving {
    /// The bytes, if they have arrived; nothing where the device is gone.
    pub(crate) fn bytes(&self) -> Option<Vec<u8>> {
        self.arrived.try_recv().ok()?.ok()?;
        let mapped = self.staging.get_mapped_range(..self.bytes.max(8)).ok()?;
        Some(mapped[..self.bytes as usize].to_vec())
    }
}

/// A buffer for so many bytes that come back.
fn staging(device: &Device, bytes: u64) -> wgpu::Buffer {
    device.device.create_buffer(&BufferDescriptor {
        label: None,
        size: bytes.next_multiple_of(8).max(8),
        usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// Asks for a buffer to be readable once what was sent is done.
fn mapped(staging: &wgpu::Buffer, bytes: u64) -> Arrived {
    let (sender, receiver) = channel();
    // Who asked may have gone.
    staging.map_async(wgpu::MapMode::Read, ..bytes.max(8), move |mapped| drop(sender.send(mapped)));
    receiver
}

/// Waits until a device has done what was sent.
fn wait(device: &Device, sent: wgpu::SubmissionIndex) -> Result<(), DeviceFault> {
    // The interface beneath panics where a driver says that the device is lost while somebody waits for it.
    let wait = || device.device.poll(PollType::Wait { submission_index: Some(sent), timeout: None });
    let waited = catch_unwind(AssertUnwindSafe(wait));
    let waited = waited.map_err(|_| DeviceFault::Lost("its driver gave it up".to_owned()))?;
    if let Some(fault) = device.fault() {
        return Err(fault);
    }
    waited.map_err(|error| DeviceFault::Lost(error.to_string())).map(|_| ())
}

impl Device {
    /// Runs programs one after the other, and brings back so many bytes of each of these buffers, one behind the other.
    pub(crate) fn run<'a>(
        &self,
        works: impl Iterator<Item = Work<'a>>,
        back: &[(&wgpu::Buffer, usize)],
        read: impl FnOnce(&[u8]),
    ) -> Result<(), DeviceFault> {
        let mut stream = Stream::default();
        for work in works {
            stream.record(self, &work)?;
        }
        stream.download(self, back, read)
    }
}
