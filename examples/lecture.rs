//! The lecture on one page: shaders/lecture.wgsl tests every sphere for every pixel. Its camera has a viewport whose middle lies in
//! front of the eye; lights, sky and materials of the scene are left out. WGPU_ADAPTER_NAME and WGPU_BACKEND choose the adapter.
//!
//! ```sh
//! cargo run --example lecture
//! cargo run --example lecture -- scenes/inside.toml -o inside.png
//! ```

use bytemuck::{Pod, Zeroable, bytes_of, cast_slice, pod_collect_to_vec};
use halfline::camera::{Basis, Viewport};
use halfline::frame::srgb::level;
use halfline::scene::DEFAULT_COLOR;
use halfline::{Lens, Scene, wgpu};
use halfline_files::read::{self, ReadOptions};
use std::borrow::Cow;
use std::path::Path;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// The most spheres: llvmpipe ends a shader's loop after 65,535 rounds.
pub(crate) const MAX_SPHERES: usize = 65_535;

/// The camera as the shader reads it.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Camera {
    eye: [f32; 3],
    d: f32,
    u: [f32; 3],
    pixel_width: f32,
    v: [f32; 3],
    pixel_height: f32,
    w: [f32; 3],
    spheres: u32,
    size: [u32; 2],
    unused: [u32; 2],
}

/// A sphere as the shader reads it.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Sphere {
    center: [f32; 3],
    radius: f32,
    color: [f32; 3],
    unused: f32,
}

fn main() {
    if let Err(error) = run(std::env::args().skip(1).collect()) {
        eprintln!("lecture: {error}");
        std::process::exit(1);
    }
}

fn run(words: Vec<String>) -> Result<()> {
    let (scene, picture) = match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => (concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/weekend.toml"), "lecture.png"),
        [scene] => (scene, "lecture.png"),
        [scene, "-o", picture] => (scene, picture),
        _ => return Err("usage: lecture [SCENE [-o PICTURE.png]]".into()),
    };
    let scene = read::scene(Path::new(scene), &ReadOptions::default())?.scene;
    let adapter = adapter(&std::env::var("WGPU_ADAPTER_NAME").unwrap_or_default())?;
    let levels: Vec<u8> = render(&scene, &adapter)?.iter().flat_map(|[r, g, b, _]| [*r, *g, *b].map(level)).collect();
    let (width, height) = (scene.image.width, scene.image.height);
    image::save_buffer(picture, &levels, width, height, image::ColorType::Rgb8)?;
    println!("{picture}: {width} x {height} pixels by {}", adapter.get_info().name);
    Ok(())
}

/// The first adapter with `name` in its name, hardware before software.
pub(crate) fn adapter(name: &str) -> Result<wgpu::Adapter> {
    let backends = wgpu::Backends::from_env().unwrap_or(wgpu::Backends::PRIMARY);
    let descriptor = wgpu::InstanceDescriptor { backends, ..wgpu::InstanceDescriptor::new_without_display_handle() };
    let adapters = pollster::block_on(wgpu::Instance::new(descriptor).enumerate_adapters(backends));
    let named = adapters.into_iter().filter(|a| a.get_info().name.to_lowercase().contains(&name.to_lowercase()));
    let first = named.min_by_key(|adapter| adapter.get_info().device_type == wgpu::DeviceType::Cpu);
    first.ok_or_else(|| format!("no adapter '{name}' was found: install a driver of Vulkan, Metal or DX12").into())
}

/// Linear RGB and the index of the sphere, or -1, of each pixel in rows from the top.
pub(crate) fn render(scene: &Scene, adapter: &wgpu::Adapter) -> Result<Vec<[f32; 4]>> {
    let (width, height) = (scene.image.width, scene.image.height);
    let bytes = 16 * u64::from(width) * u64::from(height);
    if bytes > adapter.limits().max_storage_buffer_binding_size {
        return Err(format!("{width} x {height} pixels are too many for one buffer of the adapter").into());
    }
    let (camera, spheres) = (camera(scene)?, spheres(scene)?);
    let descriptor = wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))?;
    let filled = |contents, usage| device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage });
    let empty = |usage| {
        device.create_buffer(&wgpu::BufferDescriptor { label: None, size: bytes, usage, mapped_at_creation: false })
    };
    let camera = filled(bytes_of(&camera), wgpu::BufferUsages::UNIFORM);
    let spheres = filled(cast_slice(&spheres), wgpu::BufferUsages::STORAGE);
    let picture = empty(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
    let copy = empty(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ);

    let page = naga::front::wgsl::parse_str(include_str!("../shaders/lecture.wgsl"))?;
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Naga(Cow::Owned(page)),
        }),
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });
    let bound = |binding| wgpu::BindGroupEntry {
        binding,
        resource: [&camera, &spheres, &picture][binding as usize].as_entire_binding(),
    };
    let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[0, 1, 2].map(bound),
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &bindings, &[]);
    pass.dispatch_workgroups(width.div_ceil(8), height.div_ceil(8), 1);
    drop(pass);
    encoder.copy_buffer_to_buffer(&picture, 0, &copy, 0, bytes);
    queue.submit([encoder.finish()]);
    copy.map_async(wgpu::MapMode::Read, .., |_| {});
    device.poll(wgpu::PollType::wait_indefinitely())?;
    Ok(pod_collect_to_vec(&copy.get_mapped_range(..)?))
}

/// The eye, the basis and the viewport, each number rounded once.
fn camera(scene: &Scene) -> Result<Camera> {
    if !matches!(scene.camera.lens, Lens::Viewport { .. } | Lens::Vfov { .. } | Lens::RowCentres { .. }) {
        return Err("the camera is not the lecture's: give it vfov, or a viewport and its distance".into());
    }
    let (width, height) = (scene.image.width, scene.image.height);
    let (Basis { e, u, v, w }, Viewport { vw, vh, d }) = (scene.camera.basis()?, scene.camera.viewport(width, height)?);
    Ok(Camera {
        eye: e.as_vec3().into(),
        d: d as f32,
        u: u.as_vec3().into(),
        pixel_width: (vw / f64::from(width)) as f32,
        v: v.as_vec3().into(),
        pixel_height: (vh / f64::from(height)) as f32,
        w: w.as_vec3().into(),
        spheres: scene.spheres.len() as u32,
        size: [width, height],
        unused: [0; 2],
    })
}

/// The spheres, each number rounded once.
fn spheres(scene: &Scene) -> Result<Vec<Sphere>> {
    let spheres = &scene.spheres;
    if !(1..=MAX_SPHERES).contains(&spheres.len()) {
        return Err(format!("{} spheres, but a ray can test from 1 to {MAX_SPHERES}", spheres.len()).into());
    }
    let sphere = |n: usize| Sphere {
        center: spheres.centers[n].map(|x| x as f32),
        radius: spheres.radii[n] as f32,
        color: spheres.colors.as_ref().map_or(DEFAULT_COLOR, |colors| colors[n]),
        unused: 0.0,
    };
    Ok((0..spheres.len()).map(sphere).collect())
}
