//! `halfline adapters`.

use super::messages::note;
use super::process::ExitCode;
use super::standard::print;
use halfline::error::{Error, Result};
use halfline::{Renderer, adapters, verdicts};
use std::fmt::Write as _;

/// Says that a renderer uses the CPU path for want of an adapter.
pub(super) fn note_fallback(renderer: &Renderer) {
    if renderer.has_no_adapter() {
        note(format_args!("no Vulkan, Metal or DX12 adapter was found: falling back to the CPU path"));
    }
}

/// Lists every adapter: driver, limits, subgroups, f64, and the measured properties of its arithmetic.
///
/// Examples:
///   halfline adapters
///   halfline adapters --json --retest
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Adapters {
    /// Prints one JSON object.
    #[arg(long)]
    json: bool,
    /// Measures the arithmetic again and ignores stored results.
    #[arg(long)]
    retest: bool,
}

impl Adapters {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        let found = adapters()?;
        let measured = verdicts(self.retest)?;
        let text = if self.json {
            let mut adapters = Vec::new();
            for (adapter, verdict) in found.iter().zip(&measured) {
                let mut object = serde_json::to_value(adapter).map_err(|e| Error::write("-", e.into()))?;
                let text = |e: &Error| Some(e.to_string());
                object["verdict"] = serde_json::json!(verdict.as_ref().ok());
                object["verdict_error"] = serde_json::json!(verdict.as_ref().map_or_else(text, |_| None));
                adapters.push(object);
            }
            let object = serde_json::json!({ "schema": "halfline-adapters", "version": 1, "adapters": adapters });
            format!("{object}\n")
        } else if found.is_empty() {
            "no Vulkan, Metal or DX12 adapter was found; rendering falls back to the CPU path\n\
             to install software Vulkan on Debian or Ubuntu: apt-get install mesa-vulkan-drivers libvulkan1\n"
                .to_owned()
        } else {
            let mut text = String::new();
            for (a, measured) in found.iter().zip(&measured) {
                let subgroup = a.subgroup.map_or("none".into(), |[least, most]| match least == most {
                    true => format!("{least}"),
                    false => format!("{least} to {most}"),
                });
                let f64 = if a.f64 { "yes" } else { "no" };
                let mib = |bytes: u64| bytes >> 20;
                // Writing to a String does not fail.
                let _ = writeln!(
                    text,
                    "{}: {} ({}, {})\n   driver {}\n   subgroup {subgroup}, f64 {f64}, {} MiB per binding, {} MiB per buffer\n{}",
                    a.index,
                    a.name,
                    a.kind,
                    a.backend,
                    a.driver,
                    mib(a.max_binding),
                    mib(a.max_buffer),
                    match measured {
                        Ok(verdict) => format!("   {}", verdict.lines().join("\n   ")),
                        Err(error) => format!("   arithmetic not measured: {error}"),
                    },
                );
            }
            text
        };
        print(&text)?;
        Ok(ExitCode::SUCCESS)
    }
}
