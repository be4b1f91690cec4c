//! What every test that needs an adapter begins with.

use halfline::error::Error;
use halfline::intersect::Method;
use halfline::render::Renderer;
use halfline::settings::{Backend, Settings};
use std::sync::Once;

/// A renderer on the pinned adapter, or `None` where HALFLINE_NO_GPU says that there shall be none. A missing adapter
/// fails the test; HALFLINE_TEST_ADAPTER names what the adapter must be.
pub(crate) fn gpu() -> Option<Renderer> {
    if std::env::var_os("HALFLINE_NO_GPU").is_some() {
        println!("SKIPPED: HALFLINE_NO_GPU is set");
        return None;
    }
    let settings = Settings { backend: Backend::Gpu, ..Settings::default() };
    let renderer = Renderer::new(&settings).expect("an adapter; tests/run installs and pins one");
    static SAID: Once = Once::new();
    SAID.call_once(|| println!("adapter: {} ({})", renderer.adapter(), renderer.driver()));
    if let Ok(wanted) = std::env::var("HALFLINE_TEST_ADAPTER") {
        assert!(renderer.adapter().contains(&wanted), "{} is not {wanted}", renderer.adapter());
    }
    Some(renderer)
}

/// The methods that can run on this renderer's adapter. One that cannot must be refused with the reason, never run.
pub(crate) fn admitted(renderer: &mut Renderer) -> Vec<Method> {
    let mut admitted = Method::ALL.to_vec();
    // SwiftShader has no f64 in shaders; llvmpipe runs everything.
    if renderer.adapter().contains("SwiftShader") {
        admitted.retain(|method| *method != Method::Native64);
    } else if !renderer.adapter().contains("llvmpipe") {
        admitted.retain(|method| renderer.check_method(*method).is_ok());
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

/// The CPU reference path.
pub(crate) fn cpu() -> Renderer {
    let settings = Settings { backend: Backend::Cpu, ..Settings::default() };
    Renderer::new(&settings).expect("the CPU path is always there")
}
