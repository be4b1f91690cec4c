//! The renderers that a test compares: the CPU path, and the adapter that the tests are pinned to.

#[path = "strict.rs"]
mod strict;

use crate::skip::skip;
use halfline::error::Error;
use halfline::intersect::Method;
use halfline::render::Renderer;
use halfline::settings::{Backend, Settings};

/// A renderer on the pinned adapter, or `None` where HALFLINE_NO_GPU is set. A missing adapter fails the test;
/// HALFLINE_TEST_ADAPTER is a part of the required adapter's name.
pub(crate) fn gpu() -> Option<Renderer> {
    if std::env::var_os("HALFLINE_NO_GPU").is_some() {
        println!("on the CPU path alone: HALFLINE_NO_GPU is set");
        return None;
    }
    let settings = Settings { backend: Backend::Gpu, ..Settings::default() };
    let renderer = Renderer::new(&settings).expect("an adapter; tests/run installs and pins one");
    // Each test says so: `tests/run` runs those that do on a second driver.
    println!("adapter: {} ({})", renderer.adapter(), renderer.driver());
    if let Ok(name) = std::env::var("HALFLINE_TEST_ADAPTER") {
        assert!(renderer.adapter().contains(&name), "{} is not {name}", renderer.adapter());
    }
    Some(renderer)
}

/// The same for a test that checks nothing without an adapter.
pub(crate) fn gpu_or_skip() -> Option<Renderer> {
    let renderer = gpu();
    if renderer.is_none() {
        skip("HALFLINE_NO_GPU is set");
    }
    renderer
}

/// The CPU path.
pub(crate) fn cpu() -> Renderer {
    let settings = Settings { backend: Backend::Cpu, ..Settings::default() };
    Renderer::new(&settings).expect("the CPU path needs no adapter")
}

/// Every backend that is present, the CPU path first.
pub(crate) fn renderers() -> Vec<(Backend, Renderer)> {
    [(Backend::Cpu, Some(cpu())), (Backend::Gpu, gpu())].into_iter().filter_map(|(b, r)| Some((b, r?))).collect()
}

/// Whether answers of this adapter and of the CPU path are compared bit for bit.
pub(crate) fn is_strict(renderer: &Renderer) -> bool {
    strict::keeps_bits(renderer.adapter())
}

/// The methods that can run on this renderer's adapter. A method that cannot run must be refused with the reason.
pub(crate) fn admitted(renderer: &mut Renderer) -> Vec<Method> {
    let mut admitted = Method::ALL.to_vec();
    // SwiftShader has no f64 in shaders; llvmpipe runs everything. Others refuse what their self-test finds.
    if !is_strict(renderer) {
        admitted.retain(|method| renderer.check_method(*method).is_ok());
    } else if renderer.adapter().contains("SwiftShader") {
        admitted.retain(|method| *method != Method::Native64);
    }
    for &method in Method::ALL {
        match renderer.check_method(method) {
            Ok(()) => assert!(admitted.contains(&method), "{} runs on {}", method.name(), renderer.adapter()),
            Err(Error::Accuracy { problem, .. }) if !admitted.contains(&method) => println!("refused: {problem}"),
            Err(error) => panic!("{}: {error}", method.name()),
        }
    }
    admitted
}
