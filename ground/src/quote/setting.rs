//! The names of settings as messages have them: in backticks, and marked for [`reworded`](super::reworded), so that each front
//! end writes its own word: the command its option, Python its keyword. Each is the name of the option with underscores.

macro_rules! settings {
    ($($constant:ident $name:literal,)*) => {
        $(
            #[doc = concat!("`", $name, "` in a message.")]
            pub const $constant: &str = concat!("`\u{2060}", $name, "`");
        )*

        /// The names of all.
        pub const ALL: &[&str] = &[$($name),*];
    };
}

settings! {
    ACCURACY "accuracy", ADAPTER "adapter", ADD "add", ALTLOC "altloc", ANY "any", AOV "aov", APERTURE "aperture",
    AS_LISTED "as_listed", ASSEMBLY "assembly", AT "at", ATOM_STYLE "atom_style", BACKEND "backend", BOUNCES "bounces", COLOR "color",
    COLOR_BY "color_by", COLUMNS "columns", CLIP "clip", CROP "crop", CRYPTOMATTE "cryptomatte", CUT "cut", CUT_AT "cut_at", CUT_COLOR "cut_color", CUT_ONLY "cut_only", CUT_SLAB "cut_slab", DEPTH_CUE_STRENGTH "depth_cue_strength", DETAIL "detail", EYE "eye", FIT "fit",
    FOCUS "focus",
    FIRST_ID "first_id", FORMAT "format", FRAMES "frames", GHOST_RIM "ghost_rim", GROUP "group", HIDE "hide", HOLD "hold", IDENTITY "identity", INTRINSICS "intrinsics", LABEL "label",
    LAYERS "layers", LEAST_SIZE "least_size", LEGEND "legend", LEGEND_IN "legend_in", LENS "lens", LENS_COEFFICIENTS "lens_coefficients", LOG "log", LOOK "look", MAP "map", MARK "mark", MARK_ALL "mark_all", MARK_ONE "mark_one", MATERIAL "material",
    METHOD "method", METHODS "methods", MODEL "model", MOVE "move", NAN_COLOR "nan_color", OCCLUSION "occlusion", OPACITY "opacity",
    OPACITY_SHADOWS "opacity_shadows", ORTHO "ortho", OUTLINE_COLOR "outline_color",
    OUTLINE_WIDTH "outline_width", PATIENCE "patience",
    RADIUS "radius", RANGE "range", REACH "reach", SAMPLES "samples", SCALE_BAR "scale_bar", SEARCH "search", SELECT "select",
    SHADOWS "shadows", SHINE "shine", SILHOUETTE "silhouette", SIZE "size", SKIP_INVALID "skip_invalid",
    STREAM "stream", SUN "sun", TILE "tile", TOLERANCE "tolerance",
    TOPOLOGY "topology", UNIT "unit", UNWRAP "unwrap", VFOV "vfov", VIEW "view", WRAP "wrap", ZOOM "zoom",
}
