//! A galaxy on a graphics processor, written by hand: three kernels, one encoder for many steps, positions read when they are wanted.
//!
//! The kernel of the force does what vesper's does, in the same order: one invocation for each sun, tiles of 64 others in shared memory, a
//! sum for each tile. Buffers are split as vesper's are, x, then y, then z.

use pollster::block_on;
use std::fmt;
use wgpu::{BufferUsages, PollType};

/// What comes with each call of a kernel.
const CALL: &str = "
struct Call { g: f32, square: f32, half: f32, step: f32, rows: u32 }
var<immediate> call: Call;
";

const ATTRACTION: &str = "
@group(0) @binding(0) var<storage, read> position: array<f32>;
@group(0) @binding(1) var<storage, read> mass: array<f32>;
@group(0) @binding(2) var<storage, read_write> force: array<f32>;
var<workgroup> tile: array<f32, 256>;

@compute @workgroup_size(64)
fn attract(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let n = call.rows;
    let row = id.x;
    let own = min(row, n - 1u);
    let x = position[own];
    let y = position[own + n];
    let z = position[own + 2u * n];
    let weight = call.g * mass[own];
    var sum = vec3<f32>();
    for (var first = 0u; first < n; first = first + 64u) {
        let other = min(first + lane, n - 1u);
        workgroupBarrier();
        tile[lane] = position[other];
        tile[lane + 64u] = position[other + n];
        tile[lane + 128u] = position[other + 2u * n];
        tile[lane + 192u] = mass[other];
        workgroupBarrier();
        var part = vec3<f32>();
        let count = min(64u, n - first);
        for (var k = 0u; k < count; k = k + 1u) {
            if first + k != row {
                let dx = tile[k] - x;
                let dy = tile[k + 64u] - y;
                let dz = tile[k + 128u] - z;
                let r2 = dx * dx + dy * dy + dz * dz + call.square;
                let w = weight * tile[k + 192u] * inverseSqrt(r2) * inverseSqrt(r2) * inverseSqrt(r2);
                part = part + vec3<f32>(dx * w, dy * w, dz * w);
            }
        }
        sum = sum + part;
    }
    if row < n {
        force[row] = sum.x;
        force[row + n] = sum.y;
        force[row + 2u * n] = sum.z;
    }
}
";

const MOTION: &str = "
@group(0) @binding(0) var<storage, read> force: array<f32>;
@group(0) @binding(1) var<storage, read> mass: array<f32>;
@group(0) @binding(2) var<storage, read_write> velocity: array<f32>;
@group(0) @binding(3) var<storage, read_write> position: array<f32>;

@compute @workgroup_size(64)
fn kick_and_drift(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= 3u * call.rows { return; }
    let kicked = velocity[id.x] + force[id.x] / mass[id.x % call.rows] * call.half;
    velocity[id.x] = kicked;
    position[id.x] = position[id.x] + kicked * call.step;
}

@compute @workgroup_size(64)
fn kick(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= 3u * call.rows { return; }
    velocity[id.x] = velocity[id.x] + force[id.x] / mass[id.x % call.rows] * call.half;
}
";

/// Suns on a device.
pub struct Suns {
    device: wgpu::Device,
    queue: wgpu::Queue,
    /// Attraction, kick and drift, kick: each with its buffers.
    kernels: [(wgpu::ComputePipeline, wgpu::BindGroup); 3],
    position: wgpu::Buffer,
    staging: wgpu::Buffer,
    rows: u32,
    /// Constant of gravitation, square of the softening.
    constants: [f32; 2],
}

impl fmt::Debug for Suns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Suns").field("rows", &self.rows).finish_non_exhaustive()
    }
}

impl Suns {
    /// Suns at these places, with these velocities, all x first, and masses; the forces of the places.
    ///
    /// # Panics
    /// There is no device.
    pub fn new(places: &[f32], velocities: &[f32], masses: &[f32], g: f32, softening: f32) -> Self {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..wgpu::RequestAdapterOptions::default()
        };
        let adapter = block_on(instance.request_adapter(&options)).expect("there is a graphics processor");
        let (device, queue) = block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            required_features: wgpu::Features::IMMEDIATES,
            required_limits: wgpu::Limits { max_immediate_size: 32, ..wgpu::Limits::default() },
            ..wgpu::DeviceDescriptor::default()
        }))
        .expect("it has immediates");
        let buffer = |size: usize, usage| {
            let size = size as u64;
            device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
        };
        let both = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let vector = size_of_val(places);
        let buffers = [vector, vector, vector, size_of_val(masses)].map(|size| buffer(size, both));
        let staging = buffer(vector, BufferUsages::MAP_READ | BufferUsages::COPY_DST);
        for (buffer, numbers) in [(&buffers[0], places), (&buffers[1], velocities), (&buffers[3], masses)] {
            let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
            queue.write_buffer(buffer, 0, &bytes);
        }
        let [position, velocity, force, mass] = &buffers;
        let kernel = |text: &str, name: &str, buffers: &[(&wgpu::Buffer, bool)]| {
            let entry = |(binding, (_, read_only)): (u32, &(&wgpu::Buffer, bool))| wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only: *read_only },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            };
            let entries: Vec<_> = (0..).zip(buffers).map(entry).collect();
            let layout =
                device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries });
            let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 20,
            });
            let source = wgpu::ShaderSource::Wgsl(format!("{CALL}{text}").into());
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
            let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: None,
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(name),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
            let entries: Vec<wgpu::BindGroupEntry<'_>> = (0..)
                .zip(buffers)
                .map(|(binding, (buffer, _))| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
                .collect();
            let descriptor = wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries };
            (pipeline, device.create_bind_group(&descriptor))
        };
        let attraction = [(position, true), (mass, true), (force, false)];
        let motion = [(force, true), (mass, true), (velocity, false), (position, false)];
        let kernels = [
            kernel(ATTRACTION, "attract", &attraction),
            kernel(MOTION, "kick_and_drift", &motion),
            kernel(MOTION, "kick", &motion),
        ];
        let [position, ..] = buffers;
        let (rows, constants) = (masses.len() as u32, [g, softening * softening]);
        let suns = Suns { device, queue, kernels, position, staging, rows, constants };
        suns.go(0, 0.0, false);
        suns
    }

    /// Takes so many steps; before the first one ever, none, for the forces. Behind them, if somebody looks, a copy of the places.
    fn go(&self, steps: u32, step: f32, look: bool) {
        let mut call: Vec<u8> = Vec::new();
        let numbers = [self.constants[0], self.constants[1], 0.5 * step, step];
        numbers.iter().for_each(|number| call.extend(number.to_le_bytes()));
        call.extend(self.rows.to_le_bytes());
        // As many as vesper sends at once, about.
        let mut left = steps.max(1);
        while left > 0 {
            let now = left.min(11);
            left -= now;
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            let mut dispatch = |kernel: usize, numbers: u32| {
                let (pipeline, group) = &self.kernels[kernel];
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, group, &[]);
                pass.set_immediates(0, &call);
                pass.dispatch_workgroups(numbers.div_ceil(64), 1, 1);
            };
            for _ in 0..now {
                if steps > 0 {
                    dispatch(1, 3 * self.rows);
                }
                dispatch(0, self.rows);
                if steps > 0 {
                    dispatch(2, 3 * self.rows);
                }
            }
            drop(pass);
            if left == 0 && look {
                encoder.copy_buffer_to_buffer(&self.position, 0, &self.staging, 0, self.position.size());
            }
            self.queue.submit([encoder.finish()]);
        }
    }

    /// Where the suns are so many steps on, all x first.
    ///
    /// # Panics
    /// The device is gone.
    pub fn places_after(&self, steps: u32, step: f32) -> Vec<f32> {
        self.go(steps, step, true);
        self.staging.map_async(wgpu::MapMode::Read, .., |mapped| mapped.expect("it can be read"));
        self.device.poll(PollType::wait_indefinitely()).expect("it answers");
        let places = {
            let bytes = self.staging.get_mapped_range(..).expect("it is mapped");
            bytes.chunks_exact(4).map(|bytes| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])).collect()
        };
        self.staging.unmap();
        places
    }
}
