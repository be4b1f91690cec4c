// Embree's part of the comparison: one primary ray per pixel in coherent packets of 16, depth, normal and id out.
//
//   embree SCENE SIDE THREADS points|user medium|low FRAMES OUT
//
// SCENE is written by benches/peers/run: eye, at, up and vfov as 10 f32, 6 of padding, then x y z r of each sphere.
// The raw depth, normal and id of the last frame are written to OUT, unless it is "". Prints one line of JSON.
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

struct alignas(16) Sphere {
    float x, y, z, r;
};
struct V {
    float x, y, z;
};
static V operator-(V a, V b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
static V operator*(float s, V a) { return {s * a.x, s * a.y, s * a.z}; }
static float dot(V a, V b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static V cross(V a, V b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
static V unit(V a) { return 1 / std::sqrt(dot(a, a)) * a; }

static double now() {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

static void bounds(const RTCBoundsFunctionArguments* a) {
    const Sphere& s = static_cast<const Sphere*>(a->geometryUserPtr)[a->primID];
    *a->bounds_o = {s.x - s.r, s.y - s.r, s.z - s.r, 0, s.x + s.r, s.y + s.r, s.z + s.r, 0};
}

// Intersects a packet with one sphere: Embree's fastest form for coherent rays, because the compiler makes the loop 16
// wide. Directions have unit length, so the quadratic's a is 1; the radial part keeps the discriminant accurate.
template <int N> static void test(const RTCIntersectFunctionNArguments* a) {
    const Sphere s = static_cast<const Sphere*>(a->geometryUserPtr)[a->primID];
    auto& rays = *reinterpret_cast<RTCRayHitNt<N>*>(a->rayhit);
    auto &ray = rays.ray;
    auto &hit = rays.hit;
    const float rr = s.r * s.r;
    for (int i = 0; i < N; i++) {
        const float dx = ray.dir_x[i], dy = ray.dir_y[i], dz = ray.dir_z[i];
        const float cx = s.x - ray.org_x[i], cy = s.y - ray.org_y[i], cz = s.z - ray.org_z[i];
        const float b = cx * dx + cy * dy + cz * dz;
        const float px = cx - b * dx, py = cy - b * dy, pz = cz - b * dz;
        const float d = rr - (px * px + py * py + pz * pz);
        const float root = std::sqrt(d > 0 ? d : 0);
        const float near = b - root, far = b + root;
        const float t = near > ray.tnear[i] ? near : far;
        const bool yes = (a->valid[i] != 0) & (d >= 0) & (t > ray.tnear[i]) & (t < ray.tfar[i]);
        ray.tfar[i] = yes ? t : ray.tfar[i];
        hit.Ng_x[i] = yes ? t * dx - cx : hit.Ng_x[i];
        hit.Ng_y[i] = yes ? t * dy - cy : hit.Ng_y[i];
        hit.Ng_z[i] = yes ? t * dz - cz : hit.Ng_z[i];
        hit.primID[i] = yes ? a->primID : hit.primID[i];
        hit.geomID[i] = yes ? a->geomID : hit.geomID[i];
    }
}
static void intersect(const RTCIntersectFunctionNArguments* a) {
    switch (a->N) {
    case 16: return test<16>(a);
    case 8: return test<8>(a);
    case 4: return test<4>(a);
    default: return test<1>(a);
    }
}

int main(int argc, char** argv) {
    if (argc != 8) return std::fprintf(stderr, "embree SCENE SIDE THREADS points|user medium|low FRAMES OUT\n"), 2;
    const int side = std::atoi(argv[2]), threads = std::atoi(argv[3]), frames = std::atoi(argv[6]);
    const bool user = argv[4] == std::string("user"), low = argv[5] == std::string("low");
    float head[16];
    FILE* file = std::fopen(argv[1], "rb");
    if (!file || std::fread(head, 4, 16, file) != 16) return std::fprintf(stderr, "cannot read %s\n", argv[1]), 8;
    std::fseek(file, 0, SEEK_END);
    const size_t count = (std::ftell(file) - 64) / sizeof(Sphere);
    std::fseek(file, 64, SEEK_SET);
    std::vector<Sphere> spheres(count);
    if (std::fread(spheres.data(), sizeof(Sphere), count, file) != count) return 8;
    std::fclose(file);
    const V eye{head[0], head[1], head[2]}, w = unit(eye - V{head[3], head[4], head[5]});
    const V u = unit(cross({head[6], head[7], head[8]}, w)), v = cross(w, u);
    const float step = 2 * std::tan(head[9] * float(M_PI / 360)) / side;

    RTCDevice device = rtcNewDevice(("threads=" + std::to_string(threads)).c_str());
    const double from = now();
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneBuildQuality(scene, low ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM);
    RTCGeometry geometry = rtcNewGeometry(device, user ? RTC_GEOMETRY_TYPE_USER : RTC_GEOMETRY_TYPE_SPHERE_POINT);
    if (user) {
        rtcSetGeometryUserPrimitiveCount(geometry, count);
        rtcSetGeometryUserData(geometry, spheres.data());
        rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
        rtcSetGeometryIntersectFunction(geometry, intersect);
    } else {
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, spheres.data(), 0, 16, count);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcCommitScene(scene);
    const double built = now() - from;

    std::vector<float> depth(side * side), normal(3 * side * side);
    std::vector<int> id(side * side);
    const int tile = 32, tiles = (side + tile - 1) / tile;
    // A tile is traced in packets of 4 x 4 pixels.
    auto packet = [&](int column, int row) {
        RTCRayHit16 rays;
        alignas(64) int valid[16];
        for (int i = 0; i < 16; i++) {
            const int x = column + i % 4, y = row + i / 4;
            const float a = (x + 0.5f - 0.5f * side) * step, b = (0.5f * side - y - 0.5f) * step;
            const V d = unit({a * u.x + b * v.x - w.x, a * u.y + b * v.y - w.y, a * u.z + b * v.z - w.z});
            valid[i] = x < side && y < side ? -1 : 0;
            rays.ray.org_x[i] = eye.x, rays.ray.org_y[i] = eye.y, rays.ray.org_z[i] = eye.z;
            rays.ray.dir_x[i] = d.x, rays.ray.dir_y[i] = d.y, rays.ray.dir_z[i] = d.z;
            rays.ray.tnear[i] = 0, rays.ray.tfar[i] = INFINITY, rays.ray.time[i] = 0;
            rays.ray.mask[i] = -1, rays.ray.flags[i] = 0, rays.ray.id[i] = i;
            rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID, rays.hit.primID[i] = -1;
            rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        }
#if RTC_VERSION_MAJOR >= 4
        RTCIntersectArguments how;
        rtcInitIntersectArguments(&how);
        how.flags = RTC_RAY_QUERY_FLAG_COHERENT;
        rtcIntersect16(valid, scene, &rays, &how);
#else
        RTCIntersectContext how;
        rtcInitIntersectContext(&how);
        how.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        rtcIntersect16(valid, scene, &how, &rays);
#endif
        for (int i = 0; i < 16; i++) {
            if (!valid[i]) continue;
            const int pixel = (row + i / 4) * side + column + i % 4;
            const bool yes = rays.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
            const V n = yes ? unit({rays.hit.Ng_x[i], rays.hit.Ng_y[i], rays.hit.Ng_z[i]}) : V{0, 0, 0};
            depth[pixel] = rays.ray.tfar[i];
            normal[3 * pixel] = n.x, normal[3 * pixel + 1] = n.y, normal[3 * pixel + 2] = n.z;
            id[pixel] = yes ? int(rays.hit.primID[i]) : -1;
        }
    };
    std::printf("{\"version\": \"%s\", \"native_packets_of_16\": %s, \"build_ms\": %.3f, \"trace_ms\": [", RTC_VERSION_STRING,
                rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) ? "true" : "false", built);
    for (int frame = 0; frame < frames; frame++) {
        const double start = now();
        std::atomic<int> next{0};
        auto work = [&] {
            for (int t; (t = next++) < tiles * tiles;)
                for (int y = t / tiles * tile; y < std::min(side, (t / tiles + 1) * tile); y += 4)
                    for (int x = t % tiles * tile; x < std::min(side, (t % tiles + 1) * tile); x += 4) packet(x, y);
        };
        std::vector<std::thread> others;
        for (int i = 1; i < threads; i++) others.emplace_back(work);
        work();
        for (auto& other : others) other.join();
        std::printf("%s%.3f", frame ? ", " : "", now() - start);
    }
    std::puts("]}");
    if (*argv[7]) {
        FILE* out = std::fopen(argv[7], "wb");
        if (!out) return 8;
        std::fwrite(depth.data(), 4, depth.size(), out);
        std::fwrite(normal.data(), 4, normal.size(), out);
        std::fwrite(id.data(), 4, id.size(), out);
        if (std::fclose(out)) return 8;
    }
    return rtcGetDeviceError(device) != RTC_ERROR_NONE;
}
