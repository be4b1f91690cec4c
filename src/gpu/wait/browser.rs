//! Waits in a browser.
#![expect(deprecated, reason = "suspension is experimental in wasm-bindgen")]

use halfline_ground::error::Result;
use js_sys::futures::{future_to_promise, jspi_block_on_promise};
use std::cell::Cell;
use std::future::poll_fn;
use std::rc::Rc;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Poll, Waker};
use wasm_bindgen::JsValue;

/// The output of a future.
pub(in crate::gpu) fn block_on<T: 'static>(future: impl Future<Output = T> + 'static) -> T {
    let output = Rc::new(Cell::new(None));
    let to = Rc::clone(&output);
    let promise = future_to_promise(async move {
        to.set(Some(future.await));
        Ok(JsValue::UNDEFINED)
    });
    match (jspi_block_on_promise(&promise), output.take()) {
        (Ok(_), Some(output)) => output,
        // A promise of this function is never rejected.
        _ => unreachable!("a device is opened only where functions may be suspended"),
    }
}

/// The number of submissions and mappings that are not done, and who waits for them.
pub(in crate::gpu) struct Pending(Arc<Mutex<(usize, Option<Waker>)>>);

impl Pending {
    pub(in crate::gpu) fn new() -> Self {
        Self(Arc::default())
    }

    /// A call that says that one more is done.
    fn begin(&self) -> impl FnOnce() + Send + use<> {
        let counted = Arc::clone(&self.0);
        counted.lock().unwrap_or_else(PoisonError::into_inner).0 += 1;
        move || {
            let mut counted = counted.lock().unwrap_or_else(PoisonError::into_inner);
            counted.0 -= 1;
            if counted.0 == 0
                && let Some(waker) = counted.1.take()
            {
                waker.wake();
            }
        }
    }

    /// The callback of a mapping: one that fails is an error where the buffer is read.
    pub(in crate::gpu) fn mapping(
        &self,
    ) -> impl FnOnce(std::result::Result<(), wgpu::BufferAsyncError>) + Send + use<> {
        let done = self.begin();
        move |_| done()
    }

    /// Waits for all submissions and mappings.
    ///
    /// # Errors
    /// None: the promises of a lost device are settled, and its buffers cannot be read.
    pub(in crate::gpu) fn wait(
        &self,
        _: &wgpu::Device,
        queue: &wgpu::Queue,
        _: Option<wgpu::SubmissionIndex>,
    ) -> Result<()> {
        queue.on_submitted_work_done(self.begin());
        let counted = Arc::clone(&self.0);
        block_on(poll_fn(move |context| {
            let mut counted = counted.lock().unwrap_or_else(PoisonError::into_inner);
            if counted.0 == 0 {
                return Poll::Ready(());
            }
            counted.1 = Some(context.waker().clone());
            Poll::Pending
        }));
        Ok(())
    }
}
