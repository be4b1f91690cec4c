//! Drawing, as pictures and plots need it: a page as SVG and as pixels, text, and the legend, the label and the scale bar of a
//! picture. Files are written elsewhere.

pub mod canvas;
pub mod cells;
pub mod inset;
pub mod legend;
mod raster;
