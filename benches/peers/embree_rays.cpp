// Embree's part of the comparison of given rays: nearest hits and occlusion of rays in random order.
//
//   embree_rays SPHERES RAYS THREADS medium|low REPEATS OUT
//
// SPHERES holds x y z r of each sphere in f32, RAYS ox oy oz dx dy dz of each ray, in f32 too. Rays are traced one by one
// and in packets of 8 and 16, in the given order. t and id of the last run of single rays are written to OUT, unless it
// is "". Prints one line of JSON; times are in milliseconds.
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>
#include <thread>
#include <vector>

static double now() {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

static std::vector<float> read(const char* name) {
    FILE* file = std::fopen(name, "rb");
    if (!file) return std::fprintf(stderr, "cannot read %s\n", name), std::exit(8), std::vector<float>();
    std::fseek(file, 0, SEEK_END);
    std::vector<float> values(std::ftell(file) / 4);
    std::fseek(file, 0, SEEK_SET);
    if (std::fread(values.data(), 4, values.size(), file) != values.size()) std::exit(8);
    std::fclose(file);
    return values;
}

// Calls work(first, end) for blocks of rays, on all threads.
template <class F> static double each_block(size_t count, int threads, F work) {
    const size_t block = 1024;
    const double start = now();
    std::atomic<size_t> next{0};
    auto run = [&] {
        for (size_t first; (first = next.fetch_add(block)) < count;) work(first, std::min(count, first + block));
    };
    std::vector<std::thread> others;
    for (int i = 1; i < threads; i++) others.emplace_back(run);
    run();
    for (auto& other : others) other.join();
    return now() - start;
}

static RTCScene scene;
static const float* rays;
static std::vector<float> ts;
static std::vector<int> ids;

static RTCRay ray_of(size_t n) {
    const float* r = rays + 6 * n;
    RTCRay ray{};
    ray.org_x = r[0], ray.org_y = r[1], ray.org_z = r[2], ray.dir_x = r[3], ray.dir_y = r[4], ray.dir_z = r[5];
    ray.tnear = 0, ray.tfar = std::numeric_limits<float>::infinity(), ray.mask = -1, ray.id = unsigned(n);
    return ray;
}

static void single(size_t first, size_t end) {
    for (size_t n = first; n < end; n++) {
        RTCRayHit query;
        query.ray = ray_of(n);
        query.hit.geomID = query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
        rtcIntersect1(scene, &query);
#else
        RTCIntersectContext how;
        rtcInitIntersectContext(&how);
        rtcIntersect1(scene, &how, &query);
#endif
        ts[n] = query.ray.tfar;
        ids[n] = query.hit.geomID == RTC_INVALID_GEOMETRY_ID ? -1 : int(query.hit.primID);
    }
}

static void single_occluded(size_t first, size_t end) {
    for (size_t n = first; n < end; n++) {
        RTCRay ray = ray_of(n);
#if RTC_VERSION_MAJOR >= 4
        rtcOccluded1(scene, &ray);
#else
        RTCIntersectContext how;
        rtcInitIntersectContext(&how);
        rtcOccluded1(scene, &how, &ray);
#endif
        ts[n] = ray.tfar;
    }
}

template <int N, class Rays> static void fill(Rays& ray, int* valid, size_t first, size_t end) {
    for (int i = 0; i < N; i++) {
        const RTCRay own = ray_of(std::min(first + i, end - 1));
        valid[i] = first + i < end ? -1 : 0;
        ray.org_x[i] = own.org_x, ray.org_y[i] = own.org_y, ray.org_z[i] = own.org_z;
        ray.dir_x[i] = own.dir_x, ray.dir_y[i] = own.dir_y, ray.dir_z[i] = own.dir_z;
        ray.tnear[i] = own.tnear, ray.tfar[i] = own.tfar, ray.time[i] = 0;
        ray.mask[i] = own.mask, ray.flags[i] = 0, ray.id[i] = own.id;
    }
}

template <int N> static void packets(size_t first, size_t end) {
    for (size_t n = first; n < end; n += N) {
        RTCRayHitNt<N> query;
        alignas(64) int valid[N];
        fill<N>(query.ray, valid, n, end);
        for (int i = 0; i < N; i++) query.hit.geomID[i] = query.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
        if constexpr (N == 8) rtcIntersect8(valid, scene, reinterpret_cast<RTCRayHit8*>(&query));
        else rtcIntersect16(valid, scene, reinterpret_cast<RTCRayHit16*>(&query));
#else
        RTCIntersectContext how;
        rtcInitIntersectContext(&how);
        if constexpr (N == 8) rtcIntersect8(valid, scene, &how, reinterpret_cast<RTCRayHit8*>(&query));
        else rtcIntersect16(valid, scene, &how, reinterpret_cast<RTCRayHit16*>(&query));
#endif
        for (size_t i = 0; i < N && n + i < end; i++) ts[n + i] = query.ray.tfar[i];
    }
}

template <int N> static void packets_occluded(size_t first, size_t end) {
    for (size_t n = first; n < end; n += N) {
        RTCRayNt<N> ray;
        alignas(64) int valid[N];
        fill<N>(ray, valid, n, end);
#if RTC_VERSION_MAJOR >= 4
        if constexpr (N == 8) rtcOccluded8(valid, scene, reinterpret_cast<RTCRay8*>(&ray));
        else rtcOccluded16(valid, scene, reinterpret_cast<RTCRay16*>(&ray));
#else
        RTCIntersectContext how;
        rtcInitIntersectContext(&how);
        if constexpr (N == 8) rtcOccluded8(valid, scene, &how, reinterpret_cast<RTCRay8*>(&ray));
        else rtcOccluded16(valid, scene, &how, reinterpret_cast<RTCRay16*>(&ray));
#endif
        for (size_t i = 0; i < N && n + i < end; i++) ts[n + i] = ray.tfar[i];
    }
}

int main(int argc, char** argv) {
    if (argc != 7) return std::fprintf(stderr, "embree_rays SPHERES RAYS THREADS medium|low REPEATS OUT\n"), 2;
    std::vector<float> spheres = read(argv[1]);
    const std::vector<float> given = read(argv[2]);
    const int threads = std::atoi(argv[3]), repeats = std::atoi(argv[5]);
    const size_t count = given.size() / 6;
    rays = given.data();
    ts.resize(count), ids.resize(count);

    RTCDevice device = rtcNewDevice(("threads=" + std::to_string(threads)).c_str());
    const double from = now();
    scene = rtcNewScene(device);
    rtcSetSceneBuildQuality(scene, argv[4] == std::string("low") ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, spheres.data(), 0, 16,
                               spheres.size() / 4);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcCommitScene(scene);
    std::printf("{\"version\": \"%s\", \"build_ms\": %.1f", RTC_VERSION_STRING, now() - from);

    const struct {
        const char* name;
        void (*work)(size_t, size_t);
    } forms[] = {{"packets_8", packets<8>},
                 {"packets_16", packets<16>},
                 {"single", single},
                 {"occluded_8", packets_occluded<8>},
                 {"occluded_16", packets_occluded<16>},
                 {"occluded", single_occluded}};
    for (const auto& form : forms) {
        std::printf(", \"%s_ms\": [", form.name);
        for (int i = 0; i < repeats; i++)
            std::printf("%s%.1f", i ? ", " : "", each_block(count, threads, form.work));
        std::printf("]");
        if (form.work == single && *argv[6]) {
            FILE* out = std::fopen(argv[6], "wb");
            if (!out) return 8;
            std::fwrite(ts.data(), 4, count, out), std::fwrite(ids.data(), 4, count, out);
            if (std::fclose(out)) return 8;
        }
    }
    std::puts("}");
    return rtcGetDeviceError(device) != RTC_ERROR_NONE;
}
