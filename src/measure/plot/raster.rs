//! PNG from SVG, with a font of our own: no machine's fonts change a picture.

use super::canvas::Drawn;
use crate::frame::png;
use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb::Database};
use std::sync::{Arc, LazyLock};

static FONTS: LazyLock<Arc<Database>> = LazyLock::new(|| {
    let mut fonts = Database::new();
    fonts.load_font_data(dejavu::sans::regular().to_vec());
    fonts.load_font_data(dejavu::sans::bold().to_vec());
    Arc::new(fonts)
});

/// Pixels of the PNG to one of the SVG: sharp on fine screens, and in print.
const SCALE: f32 = 2.0;

/// The SVG as a PNG file.
pub(super) fn png(svg: &str) -> Drawn<Vec<u8>> {
    let options = Options { fontdb: FONTS.clone(), ..Options::default() };
    let tree = Tree::from_str(svg, &options)?;
    let size = tree.size().to_int_size().scale_by(SCALE).ok_or("the plot has no size")?;
    let mut pixels = Pixmap::new(size.width(), size.height()).ok_or("the plot is too large")?;
    pixels.fill(Color::WHITE);
    resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut pixels.as_mut());
    // On white nothing is translucent any longer.
    let levels: Vec<u8> = pixels.pixels().iter().flat_map(|p| [p.red(), p.green(), p.blue()]).collect();
    let software = [("Software".to_owned(), concat!("halfline ", env!("CARGO_PKG_VERSION")).to_owned())];
    let mut file = Vec::new();
    let size = [size.width() as usize, size.height() as usize];
    png::write_levels(size, &software, &mut file, |out| out.write_all(&levels))?;
    Ok(file)
}
