//! Waits for the work of a device. In a browser nothing may block: the stack is suspended instead (JavaScript Promise Integration), which
//! needs a function on it that may be suspended.

#[cfg(target_arch = "wasm32")]
mod browser;

#[cfg(target_arch = "wasm32")]
pub(super) use browser::{Pending, block_on};
#[cfg(not(target_arch = "wasm32"))]
pub(super) use driver::{Pending, block_on};

#[cfg(not(target_arch = "wasm32"))]
mod driver {
    use halfline_ground::error::{Error, Result};

    pub(in crate::gpu) use pollster::block_on;

    /// The work that a device was asked for, which its driver counts.
    pub(in crate::gpu) struct Pending;

    impl Pending {
        pub(in crate::gpu) fn new() -> Self {
            Self
        }

        /// The callback of a mapping: one that fails is an error where the buffer is read.
        pub(in crate::gpu) fn mapping(&self) -> impl FnOnce(Result<(), wgpu::BufferAsyncError>) + Send + use<> {
            |_| {}
        }

        /// Waits for a submission, or for all, and for the mappings that were asked for before.
        ///
        /// # Errors
        /// [`Error::DeviceLost`].
        pub(in crate::gpu) fn wait(
            &self,
            device: &wgpu::Device,
            _: &wgpu::Queue,
            submission_index: Option<wgpu::SubmissionIndex>,
        ) -> Result<()> {
            let wait = wgpu::PollType::Wait { submission_index, timeout: None };
            device.poll(wait).map(drop).map_err(|e| Error::DeviceLost(e.to_string()))
        }
    }
}
