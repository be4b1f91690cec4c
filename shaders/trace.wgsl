// Given rays instead of viewing rays: one per invocation, the same stages after that.
const GROUP: u32 = 64u; // rays in a workgroup

// A given ray: direction scaled to a largest component in [1, 2), and its origin minus the view's eye in the frame's
// unit, as a sum of two parts so that nothing is lost far away. The fourth numbers are what rounding took from the
// direction's x, y, z.
struct GivenRay {
    direction: vec4<f32>,
    origin: vec4<f32>,
    origin_low: vec4<f32>,
}

@group(0) @binding(7) var<storage, read> rays: array<GivenRay>;

var<private> given: GivenRay;
var<private> seat: u32; // of this ray in its workgroup

// The view's width counts the rays of this dispatch and first_row the rays before it.
fn render(group: vec3<u32>, index: u32) {
    let n = group.x * GROUP + index;
    seat = index;
    given = rays[view.first_row + min(n, view.width - 1u)];
    let ray = ray_along(given.direction.xyz, vec3<f32>(given.direction.w, given.origin.w, given.origin_low.w));
    let hit = nearest(ray);
    if (n >= view.width) {
        return;
    }
    write_id(n, hit);
    write_t(n, hit);
    write_normal(n, ray, hit);
    write_color(n, ray, hit);
}
