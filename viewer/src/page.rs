//! The files of the page, which are part of the program.

use crate::reply::Reply;

const CAMERA: &str = include_str!("../page/camera.js");
const VIEW: &str = include_str!("../page/view.js");
const WIDGET: &str = include_str!("../page/widget.js");
const FIGURE: &str = include_str!("../page/figure.js");
const STYLE: &str = include_str!("../page/view.css");
const SCRIPT: &str = "text/javascript; charset=utf-8";

/// The file of a path, if there is one. Paths are compared, not opened.
pub(crate) fn file(path: &str) -> Option<Reply> {
    let (content_type, text) = match path {
        "/" | "/index.html" => ("text/html; charset=utf-8", include_str!("../page/index.html")),
        "/view.css" => ("text/css; charset=utf-8", STYLE),
        "/view.js" => (SCRIPT, VIEW),
        "/camera.js" => (SCRIPT, CAMERA),
        "/http.js" => (SCRIPT, include_str!("../page/http.js")),
        "/favicon.ico" => return Some(Reply::EMPTY),
        _ => return None,
    };
    Some(Reply::new(content_type, text.as_bytes()))
}

/// The page as one module for a notebook's widget, which cannot import others: `widget.js` exports what the notebook calls.
pub fn widget_module() -> String {
    [without_modules(CAMERA, false), without_modules(VIEW, false), without_modules(WIDGET, true)].join("\n")
}

/// The page as one script of a page without a server, whose program answers in a worker.
pub fn figure_script() -> String {
    [CAMERA, VIEW, FIGURE].map(|text| without_modules(text, false)).join("\n")
}

/// The script of that worker, which follows the program's own.
pub fn worker_script() -> &'static str {
    include_str!("../page/worker.js")
}

/// The style of the page, for all but the server.
pub fn style() -> &'static str {
    STYLE
}

/// A module's text without its imports, and without the word `export` unless it exports.
fn without_modules(text: &str, exports: bool) -> String {
    let (mut all, mut lines) = (String::new(), text.lines());
    while let Some(line) = lines.next() {
        if line.starts_with("import ") {
            // An import ends with the name of the other module, perhaps on a later line.
            let ends = |line: &str| line.contains(['"', '\'']);
            if !ends(line) {
                lines.find(|line| ends(line));
            }
            continue;
        }
        all += if exports { line } else { line.strip_prefix("export ").unwrap_or(line) };
        all.push('\n');
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modules_become_one() {
        let text = "// a\nimport {\n  b,\n} from \"./b.js\";\nimport c from './c.js';\nexport const d = 1;\n  export_ = important;\n";
        assert_eq!(without_modules(text, false), "// a\nconst d = 1;\n  export_ = important;\n");
        assert_eq!(without_modules(text, true), "// a\nexport const d = 1;\n  export_ = important;\n");
        for module in [widget_module(), figure_script()] {
            assert!(!module.lines().any(|line| line.starts_with("import ")), "no imports");
        }
    }

    #[test]
    fn the_page_is_small_and_takes_nothing_from_elsewhere() {
        let names = ["/", "/view.css", "/view.js", "/camera.js", "/http.js"];
        let files = names.map(|name| String::from_utf8(file(name).expect(name).body.into_owned()).expect("text"));
        let bytes: usize = files.iter().map(String::len).sum();
        println!("the page has {bytes} bytes");
        assert!(bytes < 46_000, "{bytes} bytes");
        for (name, text) in names.iter().zip(&files) {
            for words in ["src=\"http:", "src=\"https:", "=\"//", "url(http", "@import", "from \"http"] {
                assert!(!text.contains(words), "{name} has {words}");
            }
        }
    }
}
