// The second pass: for each unsure pixel, every sphere that might be its nearest hit.

struct Unsure {
    count: u32,
    entries: array<vec2<u32>>,
}

// Pixel and id; the count goes on where the room ends, so that the host knows how much is needed.
struct Pairs {
    count: atomic<u32>,
    entries: array<vec2<u32>>,
}

struct Kept {
    limit: f32, // the depth that the nearest hit surely does not exceed
    pixel: u32, // NONE for an invocation past the end, which only carries spheres
}

@group(0) @binding(13) var<storage, read> unsure: Unsure;
@group(0) @binding(14) var<storage, read_write> pairs: Pairs;

const NEAR: u32 = 0x80000000u;   // marks a slot in the list of near spheres
const GROUP: u32 = 64u;          // pixels in a workgroup
const GROUPS: u32 = 32768u;      // workgroups in a row of the dispatch

fn keep(k: Kept, low: f32, slot: u32) -> Kept {
    if (low < MISS && low <= k.limit && k.pixel != NONE) {
        var id: u32;
        if ((slot & NEAR) != 0u) {
            id = nears[slot & ~NEAR].id;
        } else {
            id = front_mores[slot].id;
        }
        let place = atomicAdd(&pairs.count, 1u);
        if (place < arrayLength(&pairs.entries)) {
            pairs.entries[place] = vec2<u32>(k.pixel, id);
        }
    }
    return k;
}

fn render(group: vec3<u32>, index: u32) {
    let n = (group.y * GROUPS + group.x) * GROUP + index;
    let entry = unsure.entries[min(n, unsure.count - 1u)];
    let pixel = select(NONE, entry.x, n < unsure.count);
    let s = slopes(entry.x / view.width, entry.x % view.width);
    candidates(s, Kept(bitcast<f32>(entry.y), pixel));
}
