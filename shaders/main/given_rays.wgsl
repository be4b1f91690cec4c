// Given rays instead of viewing rays: one per invocation, then the same stages.

// A given ray: the direction, scaled so that its largest component is in [1, 2), and the origin minus the view's eye in
// the frame's unit, as a sum of two f32 so that no precision is lost far from the eye. The w components are the rounding
// errors of the direction's x, y, z.
struct GivenRay {
    direction: vec4<f32>,
    origin: vec4<f32>,
    origin_low: vec4<f32>,
}

@group(0) @binding(BIND_RAYS) var<storage, read> rays: array<GivenRay>;

var<private> given: GivenRay;

// Here view.width is the number of rays of this dispatch, and view.first_row the number of rays before it.
@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let n = group.x * GROUP + index;
    if (n >= view.width) {
        return;
    }
    given = rays[view.first_row + n];
    let d = given.direction;
    let ray = Ray(Number3(
        from_hi_lo(d.x, d.w), from_hi_lo(d.y, given.origin.w), from_hi_lo(d.z, given.origin_low.w),
    ));
    write_outputs(n, ray, nearest(ray));
}
