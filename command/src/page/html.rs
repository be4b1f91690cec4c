//! The file of a page.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use halfline::error::{Error, Result};
use sha2::{Digest, Sha256};
use std::io::{self, Write};

include!(concat!(env!("OUT_DIR"), "/program.rs"));

/// The program of pages: its JavaScript, and its WebAssembly, compressed.
pub(super) struct Program {
    script: &'static str,
    code: &'static [u8],
}

/// The program, which is a part of the command if it was there when that was compiled.
///
/// # Errors
/// [`Error::Settings`] for a command without it.
pub(super) fn program() -> Result<Program> {
    let (script, code) = PROGRAM.ok_or_else(|| {
        Error::settings(
            "this halfline was compiled without the program of pages",
            "run bash page/build in its source, and compile it again",
        )
    })?;
    Ok(Program { script, code })
}

/// A page, and the bytes of its parts.
pub(super) struct Html {
    pub(super) text: String,
    pub(super) program: usize,
    pub(super) content: usize,
}

/// Text in HTML.
fn escaped(text: &str) -> String {
    let escape = |c: char| match c {
        '&' => "&amp;".into(),
        '<' => "&lt;".into(),
        '>' => "&gt;".into(),
        '"' => "&quot;".into(),
        c => c.to_string(),
    };
    text.chars().map(escape).collect()
}

/// The source of a script or a style in a security policy.
fn hash(text: &str) -> String {
    format!("'sha256-{}'", STANDARD.encode(Sha256::digest(text)))
}

impl Html {
    /// The page of a content, with the picture for browsers that cannot run its program.
    ///
    /// # Errors
    /// [`Error::Io`] where the content cannot be compressed.
    pub(super) fn new(
        (name, caption): (&str, Option<&str>),
        [width, height]: [u32; 2],
        program: &Program,
        content: &[u8],
        png: &[u8],
    ) -> Result<Self> {
        let compress = || -> io::Result<Vec<u8>> {
            let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
            encoder.write_all(content)?;
            encoder.finish()
        };
        let content = STANDARD.encode(compress().map_err(|error| Error::write("the page", error))?);
        let code = STANDARD.encode(program.code);
        let style = halfline_viewer::style().to_owned() + STILL;
        let script = halfline_viewer::figure_script();
        let worker = [program.script, halfline_viewer::worker_script()].join("\n");
        let (style_hash, script_hash) = (hash(&style), hash(&script));
        let (title, png) = (escaped(name), STANDARD.encode(png));
        let caption = caption.map(|text| format!("<p>{}</p>", escaped(text))).unwrap_or_default();
        let version = env!("CARGO_PKG_VERSION");
        let text = format!(
            "<!doctype html>\n<!-- {LICENCES} -->\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src {script_hash} blob: 'wasm-unsafe-eval'; \
             style-src {style_hash}; img-src data: blob:; worker-src blob:; base-uri 'none'; form-action 'none'\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n\
             <meta name=\"generator\" content=\"halfline {version}\">\n\
             <title>{title}</title>\n<style>{style}</style>\n\
             <figure id=\"still\"><img src=\"data:image/png;base64,{png}\" width=\"{width}\" height=\"{height}\" alt=\"{title}\">\
             <figcaption>{caption}<span id=\"why\">A picture only: this browser runs no scripts</span></figcaption></figure>\n\
             <div class=\"halfline-view hl-page\" id=\"view\" hidden></div>\n\
             <script type=\"text/plain\" id=\"program\">{code}</script>\n\
             <script type=\"text/plain\" id=\"content\">{content}</script>\n\
             <script type=\"text/plain\" id=\"worker\">{worker}</script>\n\
             <script type=\"module\">{script}</script>\n"
        );
        Ok(Self { text, program: code.len(), content: content.len() })
    }
}

/// A page has a copy of the program.
const LICENCES: &str = "The program in this page is halfline (MIT OR Apache-2.0). It has crates under MIT, Apache-2.0, BSD, ISC, \
    Zlib, Unicode and bzip2 licences, the DejaVu fonts (LICENSE-DEJAVU), and is based in part on the work of the Independent JPEG \
    Group. Their texts are in the source of halfline.";

/// The style of the picture that a page has anyway.
const STILL: &str = "
#view[hidden] { display: none; }
#still { margin: 0; font: 13px/1.4 system-ui, sans-serif; text-align: center; }
#still img { max-width: 100%; max-height: calc(100vh - 40px); width: auto; height: auto; }
";
