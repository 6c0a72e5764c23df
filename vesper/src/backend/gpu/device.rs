//! A graphics processor, and what is asked of it.
//!
//! In: programs, bytes. Out: prepared programs, buffers, bytes. Never: a panic of the interface beneath: what it finds wrong is an error,
//! a device that is lost is one, too.

use super::wgsl::{Numbers, Program};
use pollster::block_on;
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use wgpu::{
    BindGroupEntry, BindGroupLayoutEntry, BindingType, BufferBindingType, BufferDescriptor, BufferUsages, Features,
};

/// Why there is no device.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoDevice {
    /// The system has none that can compute.
    #[error("there is no graphics processor to run laws on: {0}")]
    Absent(String),
    /// There is one, and it does not do.
    #[error("the graphics processor {name} cannot run laws: {reason}")]
    Refused {
        /// The processor.
        name: String,
        /// What it lacks, or what its driver says.
        reason: String,
    },
}

/// What went wrong on a device.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DeviceFault {
    /// It no longer answers; its numbers are gone.
    #[error("the graphics processor was lost: {0}")]
    Lost(String),
    /// It refused what it was given.
    #[error("the graphics processor refused: {0}")]
    Refused(String),
}

/// Storage buffers for one program, at most: the portable limit is 8; more are asked for where there are more.
const BUFFERS: u32 = 16;
/// Bytes that come with a call, at most: what devices that have any offer.
const CALL: u32 = 128;

/// A graphics processor that laws run on.
#[derive(Debug)]
pub struct Device {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    name: String,
    /// Programs that were built, by their texts.
    known: Mutex<HashMap<String, Arc<Prepared>>>,
    /// What was first heard of a fault that nobody asked about, or of the loss.
    heard: Arc<Mutex<Option<DeviceFault>>>,
}

/// A program, ready to run.
#[derive(Debug)]
pub(crate) struct Prepared {
    pub(crate) program: Program,
    pub(super) pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
}

impl Device {
    /// The processor that the system offers first. The variables of wgpu choose another: `WGPU_BACKEND`, and those of the drivers.
    ///
    /// # Errors
    /// There is none, or none that has what laws need: numbers that come with a call (`IMMEDIATES`).
    pub fn open() -> Result<Self, NoDevice> {
        Self::of(wgpu::InstanceDescriptor::new_without_display_handle_from_env())
    }

    /// One without a driver: what is copied is copied, what runs does nothing.
    #[cfg(test)]
    pub(crate) fn without_driver() -> Self {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::NOOP;
        descriptor.backend_options.noop.enable = true;
        Self::of(descriptor).expect("it is everywhere")
    }

    fn of(descriptor: wgpu::InstanceDescriptor) -> Result<Self, NoDevice> {
        let instance = wgpu::Instance::new(descriptor);
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..wgpu::RequestAdapterOptions::default()
        };
        let adapter = block_on(instance.request_adapter(&options));
        let adapter = adapter.map_err(|error| NoDevice::Absent(error.to_string()))?;
        let info = adapter.get_info();
        let name = format!("{} ({}, {})", info.name, info.backend, info.driver_info);
        let refused = |reason: String| NoDevice::Refused { name: name.clone(), reason };
        if !adapter.features().contains(Features::IMMEDIATES) {
            return Err(refused("it has no immediates, by which the numbers of a call come".to_owned()));
        }
        let has = adapter.limits();
        let limits = wgpu::Limits {
            max_storage_buffers_per_shader_stage: has.max_storage_buffers_per_shader_stage.min(BUFFERS),
            max_storage_buffer_binding_size: has.max_storage_buffer_binding_size,
            max_buffer_size: has.max_buffer_size,
            max_immediate_size: has.max_immediate_size.min(CALL),
            ..wgpu::Limits::default()
        };
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("vesper"),
            required_features: Features::IMMEDIATES | adapter.features() & Features::SHADER_F64,
            required_limits: limits,
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) =
            block_on(adapter.request_device(&descriptor)).map_err(|error| refused(error.to_string()))?;
        let heard = Arc::new(Mutex::new(None));
        let hear = |heard: &Arc<Mutex<Option<DeviceFault>>>, fault| {
            // The first one stays: those after it are often only its consequences.
            heard.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(fault);
        };
        let to = heard.clone();
        device.set_device_lost_callback(move |_, reason| hear(&to, DeviceFault::Lost(reason)));
        let to = heard.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            hear(&to, DeviceFault::Refused(error.to_string()));
        }));
        Ok(Device { device, queue, name, known: Mutex::default(), heard })
    }

    /// The processor and its driver.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether it has numbers of this precision.
    pub(crate) fn has(&self, precision: Numbers) -> bool {
        precision == Numbers::F32 || self.device.features().contains(Features::SHADER_F64)
    }

    /// Whether something is wrong with it, without waiting for it: losses are told to those who ask.
    pub(crate) fn look(&self) -> Option<DeviceFault> {
        let _ = catch_unwind(AssertUnwindSafe(|| self.device.poll(wgpu::PollType::Poll)));
        self.fault()
    }

    /// A program, built if it is not known.
    pub(crate) fn prepare(&self, program: Program) -> Result<Arc<Prepared>, DeviceFault> {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner).get(&program.text).cloned();
        match known {
            Some(prepared) => Ok(prepared),
            None => {
                let (text, prepared) = (program.text.clone(), Arc::new(self.built(program)?));
                let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
                Ok(known.entry(text).or_insert(prepared).clone())
            }
        }
    }

    fn built(&self, program: Program) -> Result<Prepared, DeviceFault> {
        let limits = self.device.limits();
        let lists = program.shape.lists().len();
        let buffers = program.layout.bindings.len() + lists;
        if buffers > limits.max_storage_buffers_per_shader_stage as usize {
            let most = limits.max_storage_buffers_per_shader_stage;
            return Err(DeviceFault::Refused(format!("the law needs {buffers} buffers, and it has {most} for each")));
        }
        if program.call_bytes() > limits.max_immediate_size {
            let (bytes, most) = (program.call_bytes(), limits.max_immediate_size);
            return Err(DeviceFault::Refused(format!("a call of the law takes {bytes} bytes, and it takes {most}")));
        }
        if !self.has(program.precision) {
            return Err(DeviceFault::Refused("it has no f64".to_owned()));
        }
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let entries: Vec<BindGroupLayoutEntry> = (0..buffers)
            .map(|binding| BindGroupLayoutEntry {
                binding: binding as u32,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: BindingType::Buffer {
                    ty: BufferBindingType::Storage { read_only: program.is_read_only(binding) },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            })
            .collect();
        let layout =
            self.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries });
        let pipeline_layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&layout)],
            immediate_size: program.call_bytes(),
        });
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(program.text.as_str().into()),
        });
        let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        match block_on(scope.pop()) {
            Some(error) => Err(DeviceFault::Refused(error.to_string())),
            None => Ok(Prepared { program, pipeline, layout }),
        }
    }

    /// A buffer of so many bytes at least, which can be copied to and from.
    pub(crate) fn buffer(&self, bytes: u64) -> wgpu::Buffer {
        self.device.create_buffer(&BufferDescriptor {
            label: None,
            // Nothing can be bound that has no size.
            size: bytes.next_multiple_of(8).max(8),
            usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    /// How many buffers a program may have.
    pub(crate) fn buffers(&self) -> usize {
        self.device.limits().max_storage_buffers_per_shader_stage as usize
    }

    /// The same, where the device can bind as much.
    pub(crate) fn room(&self, bytes: u64) -> Result<wgpu::Buffer, DeviceFault> {
        let limits = self.device.limits();
        let most = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        if bytes > most {
            let text = format!("a column takes {bytes} bytes, and it takes {most} for each");
            return Err(DeviceFault::Refused(text));
        }
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let buffer = self.buffer(bytes);
        match block_on(scope.pop()) {
            Some(error) => Err(DeviceFault::Refused(error.to_string())),
            None => Ok(buffer),
        }
    }

    /// As if it had been unplugged.
    #[cfg(test)]
    pub(crate) fn destroy(&self) {
        self.device.destroy();
    }

    /// What was heard of a fault.
    pub(super) fn fault(&self) -> Option<DeviceFault> {
        self.heard.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Asks it for nothing any more.
    pub(crate) fn give_up(&self, fault: DeviceFault) {
        *self.heard.lock().unwrap_or_else(PoisonError::into_inner) = Some(DeviceFault::Lost(fault.to_string()));
    }

    /// Writes to a buffer, so many bytes behind its beginning.
    pub(crate) fn write(&self, to: &wgpu::Buffer, offset: u64, bytes: &[u8]) {
        self.queue.write_buffer(to, offset, bytes);
    }

    /// Ties buffers to a program, in the order of its bindings.
    pub(crate) fn bind(&self, prepared: &Prepared, buffers: &[&wgpu::Buffer]) -> wgpu::BindGroup {
        let entries: Vec<BindGroupEntry<'_>> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let layout = &prepared.layout;
        self.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
    }
}
