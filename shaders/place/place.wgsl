// Places one sphere per invocation in the image: writes its record, or leaves the sphere to the host.

// Centre and radius in f64, eight words a sphere.
@group(0) @binding(BIND_RESIDENT) var<storage, read> resident: array<vec4<u32>>;
// The records of a block, then the details that only winners need, then the depths of the centres in f64.
@group(0) @binding(BIND_PROJECTED) var<storage, read_write> projected: array<vec4<i32>>;

fn widen(at: u32, depth: f32) {
    let bits = bitcast<u32>(depth);
    if (bits < atomicLoad(&summary[at])) {
        atomicMin(&summary[at], bits);
    }
    if (bits > atomicLoad(&summary[at + 1u])) {
        atomicMax(&summary[at + 1u], bits);
    }
}

fn dot64(p: array<Float, 3>, axis: u32) -> Float {
    let x = times64(p[0], float_of_words(placing.axes[axis]));
    let y = times64(p[1], float_of_words(placing.axes[axis + 1u]));
    let z = times64(p[2], float_of_words(placing.axes[axis + 2u]));
    return plus64(plus64(x, y), z);
}

// Whether a sphere is aside: beyond the plane of one side of the image by more than a 16th of its distance and radius, so that every
// kernel proves for every ray that it misses the sphere, and the sphere is not projected onto the image (docs/certificate.md,
// section 11). f32 demands 0.07 in place of 1/16. The difference is 0.0075 (far + r) (1 + edge). The left side is off by 2^-20 (far + r)
// (1 + edge), since c is off by that much along each axis, and all roundings by less than 2^-18 of the same, in any order.
fn is_missed(c: vec3<f32>, r: f32, far: f32) -> bool {
    let edge = placing.edge;
    let wide = vec2<f32>(1.0) + 0.5 * edge * edge;
    let apart = 1.07 * r * wide + 0.07 * (far + r) * (vec2<f32>(1.0) + edge);
    return placing.narrow == 1u && any(abs(c.xy) - edge * c.z > apart);
}

// Leaves a sphere to the host. It is left out if it is aside; the host learns of the first such sphere, which may be general.
fn leave(slot: u32, missed: bool) {
    if (missed) {
        if (slot < atomicLoad(&summary[SUMMARY_MISSED])) {
            atomicMin(&summary[SUMMARY_MISSED], slot);
        }
        return;
    }
    let at = atomicAdd(&summary[SUMMARY_HOST], 1u);
    if (at < HOST_SPHERES) {
        atomicStore(&summary[SUMMARY_LIST + at], slot);
    }
}

@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let n = place_in_block(group, index);
    if (n >= block_pass.count) {
        return;
    }
    let slot = block_pass.first + n;
    projected[n] = vec4<i32>(NOWHERE, NOWHERE, 0, 0);
    let a = resident[2u * n];
    let b = resident[2u * n + 1u];
    let p = array<Float, 3>(
        minus64(float_of_bits(a.x, a.y), float_of_words(placing.eye[0])),
        minus64(float_of_bits(a.z, a.w), float_of_words(placing.eye[1])),
        minus64(float_of_bits(b.x, b.y), float_of_words(placing.eye[2])),
    );
    let radius = times_power(float_of_bits(b.z, b.w), placing.to_frame);
    let x = dot64(p, 0u);
    let y = dot64(p, 3u);
    let z = dot64(p, 6u);
    let c = vec3<f32>(f32_of_float(x), f32_of_float(y), f32_of_float(z));
    let r = f32_of_float(radius);
    let far = abs(f32_of_float(times_power(p[0], placing.to_frame))) + abs(f32_of_float(times_power(p[1], placing.to_frame)))
        + abs(f32_of_float(times_power(p[2], placing.to_frame)));
    // The error of these numbers in f32 is below 2^-20 of far + r. The conditions hold with that to spare, or the host
    // decides.
    let spare = (far + r) * 1e-6;
    if (c.z + r < -spare) {
        return;
    }
    let parallel = placing.parallel == 1u;
    let error = placing.rotated * far * 1.001;
    let length2 = dot(c, c);
    var clear = c.z > 1.0011 * r && length2 > 4.001 * r * r && length2 < 4090.0 * c.z * c.z;
    if (parallel) {
        clear = c.z - r > 4.0 * error + spare && error * 2e13 < c.z;
    }
    // For parallel rays every sphere has a rectangle, which is compared with the image first.
    if (!clear && !parallel) {
        leave(slot, is_missed(c, r, far));
        return;
    }
    var inverse = float_of_int(1);
    if (!parallel) {
        inverse = inverse64(z);
    }
    let rho = f32_of_float(times_power(times64(radius, inverse), placing.per_unit));
    let near = 1.0 / select(c.z, 1.0, parallel);
    let q = c.xy * near;
    let size = c.z * placing.low_scale.x + placing.low_scale.y;
    let total = placing.low_total.x + rho * placing.low_total.y + low_blurred(rho);
    let per = placing.per_slope_f32;
    let tilt = select(1.0, 0.0, parallel);
    let blur = (error * near * (vec2<f32>(1.0) + tilt * abs(q)) + abs(q) * 5e-16) * per;
    let from_middle = vec2<f32>(q.x, -q.y) * per;
    let out = abs(placing.middle_f32 + from_middle);
    let in_range = rho > 1e-18 && rho < 1e18 && size > 1e-24 && size < 1e24 && total * placing.low_scale.x < 0.7499
        && max(blur.x, blur.y) < 7.4e-9;
    if (!in_range) {
        leave(slot, is_missed(c, r, far));
        return;
    }
    // The pixels that it may reach, surely and perhaps.
    let half = half_sides(rho, from_middle);
    let doubt = vec2<f32>(0.01) + (abs(from_middle) + half) * 1e-5;
    let low = placing.middle_f32 + from_middle - half;
    let high = placing.middle_f32 + from_middle + half;
    if (any(high + doubt < placing.corner) || any(low - doubt > placing.end - vec2<f32>(1.0))) {
        return;
    }
    if (!clear || max(out.x, out.y) > placing.farthest - 1.0) {
        leave(slot, false);
        return;
    }
    let inside = ceil(max(low + doubt, placing.corner)) <= floor(min(high - doubt, placing.end - vec2<f32>(1.0)));
    widen(select(SUMMARY_PERHAPS, SUMMARY_DEPTHS, all(inside)), c.z);
    var fixed: array<i32, 2>;
    var offset: array<f32, 2>;
    for (var k = 0u; k < 2u; k++) {
        var slope = x;
        if (k == 1u) {
            slope = minus_of(y);
        }
        if (!parallel) {
            slope = times64(slope, inverse);
        }
        let place = plus64(float_of_words(placing.middle[k]), times64(slope, float_of_words(placing.per_slope[k])));
        fixed[k] = integer_of_float(place, i32(placing.shift));
        let pixel = (fixed[k] + (1i << (placing.shift - 1u))) >> placing.shift;
        let rest = f32_of_float(minus64(place, float_of_int(pixel)));
        offset[k] = select(rest, -rest, k == 1u);
    }
    let center = f32_of_float(minus64(z, float_of_words(placing.reference)));
    let bound = center - low_error(rho, c.z, abs(center), abs(c.x) + abs(c.y) + abs(c.z));
    projected[n] = vec4<i32>(fixed[0], fixed[1], bitcast<i32>(rho), bitcast<i32>(bound));
    let bits = bitcast<vec2<i32>>(bits_of_float(z));
    let pair = 2u * block_pass.count + n / 2u;
    if (n % 2u == 0u) {
        projected[pair].x = bits.x;
        projected[pair].y = bits.y;
    } else {
        projected[pair].z = bits.x;
        projected[pair].w = bits.y;
    }
    projected[block_pass.count + n] = vec4<i32>(bitcast<i32>(offset[0]), bitcast<i32>(offset[1]), bitcast<i32>(center), i32(slot));
    if (cut(slot, rectangle(fixed[0], fixed[1], rho))) {
        projected[n].z = bitcast<i32>(-rho);
    }
}
