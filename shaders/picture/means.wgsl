// The sums that a pass leaves for the next one.

@group(0) @binding(BIND_SKY_MEANS) var<storage, read_write> sky_means: array<u32>;

fn write_sums(place: u32, sums: Sums) {
    let n = sky_pixels();
    let first = packed(sums.all, sums.open);
    sky_means[place] = first.x;
    sky_means[place + n] = first.y;
    sky_means[place + 2u * n] = first.z;
    if (picture.planes > 3u) {
        let second = packed(sums.zenith, sums.open_zenith);
        sky_means[place + 3u * n] = second.x;
        sky_means[place + 4u * n] = second.y;
        sky_means[place + 5u * n] = second.z;
    }
}
