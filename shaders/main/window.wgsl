// The pixels of a dispatch: a band of a window, by the tiles of the full frame, so that a pixel shares its tile with the
// same pixels in every window.
const TILE: u32 = 8u; // pixels along a side of a workgroup's tile

// Column and row of an invocation in the full frame.
fn pixel_at(tile: vec3<u32>, index: u32) -> vec2<u32> {
    let corner = vec2<u32>(view.first_column / TILE + tile.x, view.first_row / TILE + tile.y) * TILE;
    return corner + vec2<u32>(index % TILE, index / TILE);
}

// Whether the pixel is in the window. Columns and rows before the first wrap around to large numbers.
fn in_crop(at: vec2<u32>) -> bool {
    return at.x - view.first_column < view.columns && at.y - view.first_row < view.rows;
}

// The pixel's index in the buffers.
fn pixel_index(at: vec2<u32>) -> u32 {
    return (at.y - view.first_row) * view.columns + (at.x - view.first_column);
}

// The numbers of tiles that the window overlaps in a row, and the band in a column.
fn tile_columns() -> u32 {
    return (view.first_column + view.columns - 1u) / TILE - view.first_column / TILE + 1u;
}

fn tile_rows() -> u32 {
    return (view.first_row + view.rows - 1u) / TILE - view.first_row / TILE + 1u;
}
