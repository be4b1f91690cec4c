// The colour of a sample of every pixel under a sky and lights without shadows, with depth cue and lines, added to the sums of
// the picture: the host's cpu/light/colors.rs, depth_cue.rs and samples.rs.

@group(0) @binding(BIND_FRAME_ID) var<storage, read> frame_id: array<u32>;
@group(0) @binding(BIND_STARTS) var<storage, read> starts: array<vec4<f32>>;
@group(0) @binding(BIND_PLACES) var<storage, read> places: array<u32>;
// Linear RGB and coverage.
@group(0) @binding(BIND_PICTURE_SUMS) var<storage, read_write> picture_sums: array<vec4<f32>>;

fn backdrop(at: vec2<u32>) -> vec3<f32> {
    if (picture.gradient < 2u) {
        return view.background.rgb;
    }
    let to = sample_position(at);
    let d = select(viewing_ray(to.y, to.x).d, vec3<f32>(0.0, 0.0, -1.0), picture.parallel == 1u);
    return picture.horizon + picture.change * zenith(unit3(to_world(d)));
}

// Of a place in the window of the sums.
fn sums_around(at: vec2<i32>, id: u32) -> Sums {
    let size = vec2<i32>(picture.sky_size);
    if (all(at >= vec2<i32>(0)) && all(at < size)) {
        let place = u32(at.y * size.x + at.x);
        if (sky_hits[place] == id) {
            return sums_at(place);
        }
    }
    var same = NO_SUMS;
    var any = NO_SUMS;
    var found = false;
    for (var k = 0; k < 9; k++) {
        let near = at + vec2<i32>(k % 3 - 1, k / 3 - 1);
        if (near.x < 0 || near.y < 0 || near.x >= size.x || near.y >= size.y) {
            continue;
        }
        let place = u32(near.y * size.x + near.x);
        let other = sky_hits[place];
        if (other != NONE) {
            let sums = sums_at(place);
            any = plus(any, sums, 1.0);
            if (other == id) {
                same = plus(same, sums, 1.0);
                found = true;
            }
        }
    }
    if (found) {
        return same;
    }
    return any;
}

// The light that an open sky with colours gives to a surface.
fn open_light(normal: vec3<f32>) -> vec3<f32> {
    let place = (clamp(dot3(normal, picture.up), -1.0, 1.0) + 1.0) * 16.0;
    let cell = min(u32(place), 31u);
    let one = picture.shares[cell / 4u][cell % 4u];
    let next = picture.shares[(cell + 1u) / 4u][(cell + 1u) % 4u];
    return picture.horizon + picture.change * (one + (next - one) * (place - f32(cell)));
}

fn sky_light(normal: vec3<f32>, sums: Sums) -> vec3<f32> {
    let all = dot3(normal, sums.all);
    let open = dot3(normal, sums.open);
    if (picture.gradient == 0u) {
        return vec3<f32>(open_share(all, open));
    }
    let of_all = picture.horizon * all + picture.change * dot3(normal, sums.zenith);
    let of_open = picture.horizon * open + picture.change * dot3(normal, sums.open_zenith);
    let share = vec3<f32>(
        open_share(of_all.r, of_open.r), open_share(of_all.g, of_open.g), open_share(of_all.b, of_open.b),
    );
    return open_light(normal) * share;
}

@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) tile: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let at = pixel_at(tile, index);
    if (!in_crop(at)) {
        return;
    }
    let pixel = pixel_index(at);
    let id = frame_id[pixel];
    let behind = backdrop(at);
    var color = behind;
    if (id != NONE) {
        let normal = starts[2u * pixel].xyz;
        let sums = sums_around(vec2<i32>(at) - vec2<i32>(picture.sky_corner), id);
        var light = picture.share * sky_light(normal, sums);
        for (var k = 0u; k < picture.lights; k++) {
            light += picture.sources[2u * k + 1u].rgb * positive(dot3(normal, picture.sources[2u * k].xyz));
        }
        color = sphere_color(id) * light;
        let own = Spot(id, depth_at(pixel));
        let share = picture.cue_share * clamp((own.depth - picture.cue_near) * picture.cue_slope, 0.0, 1.0);
        color += share * (behind - color);
        if (picture.strength > 0.0) {
            let place = vec2<i32>(vec2<u32>(at.x - view.first_column, at.y - view.first_row));
            color = mix(color, picture.ink, picture.strength * darkness(place, own));
        }
    }
    let sample_sum = vec4<f32>(color, select(0.0, 1.0, id != NONE));
    picture_sums[pixel] = sample_sum + select(picture_sums[pixel], vec4<f32>(), view.sample == 0u);
}
