// A ray goes through one sample of its pixel: the centre of a pixel of a finer frame, whose size is the view's. The pixel
// is divided into strata, and a hash chooses one finer pixel in the sample's stratum. With an off-centre lens the finer
// frame is larger than the image.
fn sample_position(at: vec2<u32>) -> vec2<u32> {
    let stratum = vec2<u32>(view.sample % view.strata, view.sample / view.strata);
    let hash = pcg4d(vec4<u32>(at, view.sample, view.seed));
    let place = (at * view.strata + stratum) * view.jitter + ((hash.xy >> vec2<u32>(16u)) & vec2<u32>(view.jitter - 1u));
    return place * view.step + vec2<u32>(view.shift_column, view.shift_row);
}
