// Given rays instead of viewing rays: one per invocation, the same stages after that.

// A given ray: direction scaled to a largest component in [1, 2), and its origin minus the view's eye in the frame's
// unit, as a sum of two parts so that nothing is lost far away. The fourth numbers are what rounding took from the
// direction's x, y, z.
struct GivenRay {
    direction: vec4<f32>,
    origin: vec4<f32>,
    origin_low: vec4<f32>,
}

@group(0) @binding(BIND_RAYS) var<storage, read> rays: array<GivenRay>;

var<private> given: GivenRay;
var<private> local_index: u32; // of this ray in its workgroup

// The view's width counts the rays of this dispatch and first_row the rays before it.
fn render(group: vec3<u32>, index: u32) {
    let n = group.x * GROUP + index;
    local_index = index;
    given = rays[view.first_row + min(n, view.width - 1u)];
    let d = given.direction;
    let ray = Ray(Number3(
        from_hi_lo(d.x, d.w), from_hi_lo(d.y, given.origin.w), from_hi_lo(d.z, given.origin_low.w),
    ));
    let hit = nearest(ray, group);
    if (n >= view.width) {
        return;
    }
    write_outputs(n, ray, hit);
}
