//! The native module `halfline._halfline`. It converts arrays, options and errors, and calls the library; it computes
//! nothing. The package around it, `python/halfline/`, has the documented and typed interface.

mod arrays;
mod atoms;
mod camera;
mod color;
mod columns;
mod command;
mod errors;
mod fit;
mod frame;
mod many;
mod measure;
mod particles;
mod parts;
mod png;
mod read;
mod renderer;
mod reports;
mod scan;
mod scene;
mod shared;
mod trace;
mod vector;
mod view;
mod words;
mod work;

use pyo3::prelude::*;

/// The native module.
#[pymodule]
mod _halfline {
    #[pymodule_export]
    use super::atoms::{elements, infer};
    #[pymodule_export]
    use super::camera::{Camera, check_pose, read_cameras};
    #[pymodule_export]
    use super::command::command;
    #[pymodule_export]
    use super::errors::{AccuracyError, AdapterError};
    #[pymodule_export]
    use super::fit::fit_camera;
    #[pymodule_export]
    use super::frame::Frame;
    #[pymodule_export]
    use super::many::Frames;
    #[pymodule_export]
    use super::measure::measure;
    #[pymodule_export]
    use super::particles::{ParticleFrames, Particles};
    #[pymodule_export]
    use super::parts::{Part, Sieve};
    #[pymodule_export]
    use super::png::png;
    #[pymodule_export]
    use super::read::{Sequence, color};
    #[pymodule_export]
    use super::renderer::Renderer;
    #[pymodule_export]
    use super::reports::{adapters, info};
    #[pymodule_export]
    use super::scan::Pattern;
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::trace::trace;
    #[pymodule_export]
    use super::vector::Figure;
    #[pymodule_export]
    use super::view::{Desk, Question, page, pose, save_page, widget_module, widget_style};
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
