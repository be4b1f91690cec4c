//! The share of the machine's f32 peak that the kernel reaches when it tests all spheres: pure multiply-adds on the
//! adapter and in the processor's vectors, compared with ray-sphere tests per second.
//!
//! ```sh
//! cargo run --release --example peak
//! ```

mod cloud;

use cloud::cloud;
use halfline::wgpu::{self, util::DeviceExt};
use halfline::{Aov, Backend, Method, Renderer, Settings};
use pulp::{Arch, Simd, WithSimd};
use std::hint::black_box;
use std::time::Instant;

type Result<T = ()> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Every figure is the best of this many, because other work on a shared machine only slows it down.
const TRIALS: usize = 9;

/// Independent chains.
const CHAINS: usize = 8;

/// Multiply-adds of every chain per turn of the loop, and turns.
const STEPS: usize = 32;
const TURNS: usize = 2048;

/// Invocations of the adapter's kernel.
const LANES: u32 = 1 << 14;

/// Operations of one ray and one sphere that it misses, in shaders/form/stable.wgsl: p x d takes 6 products and 3
/// differences, g.g 3 and 2, r r, a r r and their difference one each. d.d is the ray's; comparisons are not counted.
const MISSED: f64 = 17.0;

/// The same for a possible hit, which software adapters compute for every ray: p.d takes 3 and 2; a root, two sums with
/// it, three quotients, t times the sphere's scale.
const MET: f64 = 12.0;

/// Gflop/s of multiply-adds written as `step` on the adapter with this name.
fn adapter_peak(name: &str, step: &str) -> Result<f64> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let adapter = adapters.into_iter().find(|adapter| adapter.get_info().name == name).ok_or("the adapter is gone")?;
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()))?;
    let chains = |words: &dyn Fn(usize) -> String| (0..CHAINS).map(words).collect::<String>();
    let begin = chains(&|k| format!("var x{k} = data[n] + f32({k});\n"));
    let turn = chains(&|k| step.replace('x', &format!("x{k}"))).repeat(STEPS);
    let sum = chains(&|k| format!(" + x{k}"));
    let text = format!(
        "@group(0) @binding(0) var<storage, read_write> data: array<f32>;
        @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
            let n = id.x + 2u; // the elements that are read are not written
            let a = data[0];
            let b = data[1];
            {begin}
            for (var i = 0; i < {TURNS}; i++) {{ {turn} }}
            data[n] = 0.0{sum};
        }}"
    );
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(
            naga::front::wgsl::parse_str(&text).expect("valid WGSL"),
        )),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: None,
        compilation_options: Default::default(),
        cache: None,
    });
    let mut best = f64::INFINITY;
    for _ in 0..=TRIALS {
        // Factors below 1: chains stay finite and normal.
        let data: Vec<u8> = (0..LANES + 2).flat_map(|n| (0.5 + n as f32 * 1e-6).to_le_bytes()).collect();
        let data = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents: &data,
            usage: wgpu::BufferUsages::STORAGE,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: data.as_entire_binding() }],
        });
        queue.submit([]);
        device.poll(wgpu::PollType::wait_indefinitely())?;
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(LANES / 64, 1, 1);
        drop(pass);
        let began = Instant::now();
        queue.submit([encoder.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely())?;
        best = best.min(began.elapsed().as_secs_f64());
    }
    Ok(f64::from(LANES) * (CHAINS * STEPS * TURNS) as f64 * 2.0 / best * 1e-9)
}

/// Multiply-adds in the widest vectors; returns the number of operations.
struct Chains([f32; 2]);

impl WithSimd for Chains {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let [a, b] = self.0.map(|x| simd.splat_f32s(x));
        let mut x = [simd.splat_f32s(self.0[0]); CHAINS];
        for _ in 0..STEPS * TURNS * 32 {
            for x in &mut x {
                *x = simd.mul_add_f32s(*x, a, b);
            }
        }
        black_box(x.map(|x| simd.reduce_sum_f32s(x)));
        (size_of::<S::f32s>() / size_of::<f32>() * CHAINS * STEPS * TURNS * 32 * 2) as f64
    }
}

/// Gflop/s of the processor, all threads.
fn processor_peak(threads: usize) -> f64 {
    let one = || Arch::new().dispatch(Chains(black_box([0.5, 0.25])));
    let trial = || {
        let began = Instant::now();
        let operations: f64 = std::thread::scope(|scope| {
            let jobs: Vec<_> = (0..threads).map(|_| scope.spawn(one)).collect();
            jobs.into_iter().filter_map(|job| job.join().ok()).sum()
        });
        operations / began.elapsed().as_secs_f64() * 1e-9
    };
    (0..TRIALS).map(|_| trial()).fold(0.0, f64::max)
}

/// Ray-sphere tests per second of `stable` with 512 spheres, 1024 x 1024 rays, only ids.
fn tests(renderer: &mut Renderer, settings: &Settings) -> Result<f64> {
    let mut scene = cloud(512);
    (scene.image.width, scene.image.height) = (1024, 1024);
    let mut best = f64::INFINITY;
    for _ in 0..=TRIALS {
        let report = renderer.render(&scene, settings)?.report;
        best = best.min(report.kernel_ms.last().copied().unwrap_or_else(|| report.stages_ms["trace"]));
    }
    Ok(512.0 * 1024.0 * 1024.0 / best * 1e3)
}

fn main() -> Result {
    let threads = std::thread::available_parallelism()?.get();
    let processor = processor_peak(threads);
    println!("processor, {threads} threads: {processor:.1} Gflop/s of multiply-adds in vectors");
    println!("Gflop/s at {MISSED} a test; with what a hit takes, at {}", MISSED + MET);
    println!(
        "| `stable`, all spheres | 1e9 tests/s | Gflop/s | of the kernel's peak | of the processor's | with a hit |"
    );
    println!("|---|---|---|---|---|---|");
    for backend in [Backend::Gpu, Backend::Cpu] {
        let settings = Settings { backend, method: Some(Method::Stable), aovs: vec![Aov::Id], ..Settings::default() };
        let mut renderer = Renderer::new(&settings)?;
        let mut peak = processor;
        if backend == Backend::Gpu {
            let fused = adapter_peak(renderer.adapter(), "x = fma(x, a, b);\n")?;
            let apart = adapter_peak(renderer.adapter(), "x = x * a + b;\n")?;
            println!("{}: {fused:.1} Gflop/s by fma(), {apart:.1} by x * a + b", renderer.adapter());
            peak = fused.max(apart);
        }
        let tests = tests(&mut renderer, &settings)?;
        let flops = tests * MISSED * 1e-9;
        println!(
            "| {} | {:.2} | {flops:.1} | {:.0} % | {:.0} % | {:.0} % |",
            renderer.adapter(),
            tests * 1e-9,
            100.0 * flops / peak,
            100.0 * flops / processor,
            100.0 * flops * (MISSED + MET) / MISSED / peak
        );
    }
    Ok(())
}
