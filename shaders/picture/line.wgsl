// The darkness of the line at a pixel: the host's silhouette.rs, which has the reasons and the limits.

// Pairs of opposite neighbours, and the depth of a miss.
const NEIGHBOUR_PAIRS: i32 = i32(NEIGHBOURS) / 2;
const FARTHEST: f32 = 1e20;

// 0 up to the first limit, 1 from the second on, and linear between.
fn ramp(x: f32, limits: vec2<f32>) -> f32 {
    return clamp((x - limits.x) / (limits.y - limits.x), 0.0, 1.0);
}

// The place of a pixel in the window, and its depth.
struct Spot {
    id: u32,
    depth: f32,
}

fn is_inside(at: vec2<i32>) -> bool {
    return at.x >= 0 && at.y >= 0 && at.x < i32(view.columns) && at.y < i32(view.rows);
}

fn id_at(at: vec2<i32>) -> u32 {
    return frame_id[u32(at.y) * view.columns + u32(at.x)];
}

fn depth_at(place: u32) -> f32 {
    return -dot3(starts[2u * place + 1u].xyz, view.back.xyz);
}

fn spot_at(at: vec2<i32>) -> Spot {
    let id = id_at(at);
    var depth = FARTHEST;
    if (id != NONE) {
        depth = depth_at(u32(at.y) * view.columns + u32(at.x));
    }
    return Spot(id, depth);
}

// Half of the neighbours; the others are opposite. Columns and rows, 1 or 2 of either.
fn neighbour(k: i32) -> vec2<i32> {
    let below = k - 2;
    return select(vec2<i32>(below % 5 - 2, below / 5 + 1), vec2<i32>(k + 1, 0), k < 2);
}

// Their distance in pixels.
fn stretched(to: vec2<i32>) -> vec2<i32> {
    let size = abs(to);
    let far = select(select(vec2<i32>(0), vec2<i32>(picture.neighbours.x), size == vec2<i32>(1)),
        vec2<i32>(picture.neighbours.y), size == vec2<i32>(2));
    return select(far, -far, to < vec2<i32>(0));
}

fn is_within(id: u32, at: vec2<i32>) -> bool {
    for (var k = 0; k < NEIGHBOUR_PAIRS; k++) {
        let far = stretched(neighbour(k));
        let one = at + far;
        let other = at - far;
        if (!is_inside(one) || !is_inside(other) || id_at(one) != id || id_at(other) != id) {
            return false;
        }
    }
    return true;
}

// The sums over the neighbours of a pixel.
struct LineSums {
    behind: vec2<f32>,
    behind_or_border: vec2<f32>,
    company: f32,
}

fn with_neighbour(sums: LineSums, own: Spot, size: f32, toward: vec2<f32>, other: Spot, opposite: Spot) -> LineSums {
    if (other.id == own.id) {
        return sums;
    }
    let gap = other.depth - own.depth;
    let before = max(own.depth - opposite.depth, 0.0);
    let farther = ramp((gap - DESCENT * before) / size, GAP);
    let apart = abs(gap) > CLOSE * size;
    let has_line = select((own.id < other.id), (gap > 0.0), apart);
    let border = select(0.0, 1.0, picture.between == 1u && has_line);
    return LineSums(
        sums.behind + farther * toward, sums.behind_or_border + max(farther, border) * toward, sums.company + 1.0 - farther,
    );
}

fn edge(sum: vec2<f32>, straight: vec2<f32>) -> f32 {
    return ramp(sqrt(sum.x * sum.x + sum.y * sum.y) * STRAIGHT / max(straight.x, straight.y), SUM_LENGTH);
}

// For a pixel of the window that shows a sphere of this radius.
fn darkness(at: vec2<i32>, own: Spot) -> f32 {
    if (is_within(own.id, at)) {
        return 0.0;
    }
    let size = picture.pixel_slope * own.depth + picture.pixel_size;
    var sums = LineSums(vec2<f32>(), vec2<f32>(), 0.0);
    var straight = vec2<f32>();
    var count = 0.0;
    for (var k = 0; k < NEIGHBOUR_PAIRS; k++) {
        let to = neighbour(k);
        let far = stretched(to);
        if (!is_inside(at + far) || !is_inside(at - far)) {
            continue;
        }
        let one = spot_at(at + far);
        let other = spot_at(at - far);
        let offset = vec2<f32>(to);
        let toward = offset / sqrt(offset.x * offset.x + offset.y * offset.y);
        count += 2.0;
        straight += abs(toward);
        sums = with_neighbour(sums, own, size, toward, one, other);
        sums = with_neighbour(sums, own, size, -toward, other, one);
    }
    if (count == 0.0) {
        return 0.0;
    }
    let radius = placed_at(places[own.id]).radius * picture.radius;
    let large = ramp(2.0 * radius / (size * picture.stretch), DIAMETER);
    let company = ramp(sums.company * NEIGHBOURS / count, COMPANY);
    return max(edge(sums.behind, straight) * max(large, company), edge(sums.behind_or_border, straight) * large);
}
