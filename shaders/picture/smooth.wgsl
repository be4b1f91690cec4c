// One pass in which the rays of neighbours are put together: the host's open_sky.rs, which has the reasons and the limits.

fn share_at(place: u32, sums: Sums) -> f32 {
    let normal = normal_at(place);
    return open_share(dot3(normal, sums.all), dot3(normal, sums.open));
}

@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) tile: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let at = pixel_at(tile, index);
    if (!in_crop(at)) {
        return;
    }
    let place = pixel_index(at);
    let n = sky_pixels();
    let id = sky_hits[place];
    var mean = NO_SUMS;
    if (id != NONE) {
        let normal = normal_at(place);
        let own = sums_at(place);
        let share = share_at(place, own);
        let column = i32(at.x - view.first_column);
        let row = i32(at.y - view.first_row);
        let step = i32(picture.step);
        var all = 0.0;
        var sums = NO_SUMS;
        for (var k = 0; k < 9; k++) {
            let to = vec2<i32>(k % 3 - 1, k / 3 - 1);
            let x = column + to.x * step;
            let y = row + to.y * step;
            if (x < 0 || x >= i32(view.columns) || y < 0 || y >= i32(view.rows)) {
                continue;
            }
            let other = u32(y) * view.columns + u32(x);
            if (sky_hits[other] != id) {
                continue;
            }
            let near = 4.0 * dot3(normal, normal_at(other)) - 3.0;
            let theirs = sums_at(other);
            var alike = 1.0;
            if (picture.step >= WIDE) {
                let change = (share - share_at(other, theirs)) / ALIKE;
                alike = 1.0 - change * change;
            }
            if (near > 0.0 && alike > 0.0) {
                let weight = f32((2 - abs(to.x)) * (2 - abs(to.y))) * near * alike;
                sums = plus(sums, theirs, weight);
                all += weight;
            }
        }
        if (all > 0.0) {
            mean = plus(NO_SUMS, sums, 1.0 / all);
        }
    }
    write_sums(place, mean);
}
