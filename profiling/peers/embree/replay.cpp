// Uses Embree 3 to trace the rays of a set that `ptfast rays` wrote, against the same primitives.
//
//     g++ -std=c++17 -O3 -march=native replay.cpp -o replay -lembree3
//     ./replay FOLDER [REPETITIONS] [robust]
//
// Prints one JSON line per set: millions of rays per second on one thread (the best of packets of 1, 4, 8 and 16
// rays, each a median over the repetitions), and the number of rays whose hit differs in its primitive from that
// in the set. The measured time includes copying the rays from plain arrays into Embree's packets and writing the
// hits.

#include <embree3/rtcore.h>
#include <immintrin.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

template <typename T>
static std::vector<T> load(const std::string &path) {
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    if (!file) return {};
    std::vector<T> values(size_t(file.tellg()) / sizeof(T));
    file.seekg(0);
    file.read(reinterpret_cast<char *>(values.data()), std::streamsize(values.size() * sizeof(T)));
    return values;
}

struct Found {
    float t;
    uint32_t primitive;
};
static const uint32_t MISS = 0xffffffffu;

struct RaySet {
    std::vector<float> rays, range, time;
    std::vector<Found> hits;
    bool occluded;
    size_t size() const { return hits.size(); }
};

// An Embree scene, with the index of the first primitive of each geometry: spheres, quads, triangles.
struct Scene {
    RTCScene scene;
    uint32_t first[3];
};

static void *buffer(RTCGeometry geometry, RTCBufferType type, unsigned slot, RTCFormat format,
                    size_t stride, size_t count) {
    return rtcSetNewGeometryBuffer(geometry, type, slot, format, stride, count);
}

static Scene build(RTCDevice device, const std::string &folder, bool robust) {
    auto spheres = load<float>(folder + "/spheres.f32");
    auto quads = load<float>(folder + "/quads.f32");
    auto triangles = load<float>(folder + "/triangles.f32");
    Scene made{rtcNewScene(device), {0, uint32_t(spheres.size() / 8), 0}};
    made.first[2] = made.first[1] + uint32_t(quads.size() / 9);
    rtcSetSceneBuildQuality(made.scene, RTC_BUILD_QUALITY_HIGH);
    if (robust) rtcSetSceneFlags(made.scene, RTC_SCENE_FLAG_ROBUST);
    auto attach = [&](RTCGeometry geometry, unsigned id) {
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(made.scene, geometry, id);
        rtcReleaseGeometry(geometry);
    };
    if (size_t count = spheres.size() / 8) {
        auto geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
        bool moving = false;
        for (size_t i = 0; i < count; i++)
            moving |= std::memcmp(&spheres[8 * i], &spheres[8 * i + 4], 12) != 0;
        rtcSetGeometryTimeStepCount(geometry, moving ? 2 : 1);
        for (unsigned step = 0; step <= unsigned(moving); step++) {
            auto to = (float *)buffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT4, 16, count);
            for (size_t i = 0; i < count; i++) {
                std::memcpy(to + 4 * i, &spheres[8 * i + 4 * step], 12);
                to[4 * i + 3] = spheres[8 * i + 3];
            }
        }
        attach(geometry, 0);
    }
    if (size_t count = quads.size() / 9) {
        auto geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
        auto to = (float *)buffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 4 * count);
        auto index = (uint32_t *)buffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 16, count);
        for (size_t i = 0; i < count; i++) {
            const float *q = &quads[9 * i];
            for (int axis = 0; axis < 3; axis++) {
                float *corner = to + 12 * i + axis;
                corner[0] = q[axis];
                corner[3] = q[axis] + q[3 + axis];
                corner[6] = q[axis] + q[3 + axis] + q[6 + axis];
                corner[9] = q[axis] + q[6 + axis];
            }
            for (uint32_t c = 0; c < 4; c++) index[4 * i + c] = uint32_t(4 * i) + c;
        }
        attach(geometry, 1);
    }
    if (size_t count = triangles.size() / 9) {
        auto geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto to = buffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * count);
        std::memcpy(to, triangles.data(), triangles.size() * 4);
        auto index = (uint32_t *)buffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count);
        for (uint32_t i = 0; i < 3 * count; i++) index[i] = i;
        attach(geometry, 2);
    }
    rtcCommitScene(made.scene);
    return made;
}

// Packets of N rays. Embree's structures for each N differ only in their names.
template <int N>
struct Width;
#define WIDTH(N)                                                                                            \
    template <>                                                                                             \
    struct Width<N> {                                                                                       \
        using Ray = RTCRay##N;                                                                              \
        using RayHit = RTCRayHit##N;                                                                        \
        static void closest(const int *valid, RTCScene scene, RTCIntersectContext *context, RayHit *rays) { \
            rtcIntersect##N(valid, scene, context, rays);                                                   \
        }                                                                                                   \
        static void occluded(const int *valid, RTCScene scene, RTCIntersectContext *context, Ray *rays) {   \
            rtcOccluded##N(valid, scene, context, rays);                                                    \
        }                                                                                                   \
    };
WIDTH(4)
WIDTH(8)
WIDTH(16)

template <int N>
static void trace(const Scene &scene, const RaySet &set, RTCIntersectContext *context, std::vector<Found> &hits) {
    alignas(64) typename Width<N>::RayHit packet;
    alignas(64) int valid[N];
    auto &ray = packet.ray;
    for (size_t first = 0; first < set.size(); first += N) {
        for (int lane = 0; lane < N; lane++) {
            size_t i = std::min(first + lane, set.size() - 1);
            valid[lane] = first + lane < set.size() ? -1 : 0;
            const float *from = &set.rays[6 * i];
            ray.org_x[lane] = from[0], ray.org_y[lane] = from[1], ray.org_z[lane] = from[2];
            ray.dir_x[lane] = from[3], ray.dir_y[lane] = from[4], ray.dir_z[lane] = from[5];
            ray.tnear[lane] = set.range[2 * i], ray.tfar[lane] = set.range[2 * i + 1];
            ray.time[lane] = set.time.empty() ? 0.0f : set.time[i];
            ray.mask[lane] = ~0u, ray.id[lane] = 0, ray.flags[lane] = 0;
            packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
        }
        if (set.occluded)
            Width<N>::occluded(valid, scene.scene, context, &ray);
        else
            Width<N>::closest(valid, scene.scene, context, &packet);
        for (int lane = 0; lane < N && first + lane < set.size(); lane++) {
            uint32_t geometry = packet.hit.geomID[lane];
            Found &to = hits[first + lane];
            if (set.occluded)
                to = {0.0f, ray.tfar[lane] < 0.0f ? 0 : MISS};
            else if (geometry == RTC_INVALID_GEOMETRY_ID)
                to = {INFINITY, MISS};
            else
                to = {ray.tfar[lane], scene.first[geometry] + packet.hit.primID[lane]};
        }
    }
}

template <>
void trace<1>(const Scene &scene, const RaySet &set, RTCIntersectContext *context, std::vector<Found> &hits) {
    alignas(16) RTCRayHit one;
    for (size_t i = 0; i < set.size(); i++) {
        const float *from = &set.rays[6 * i];
        one.ray = {from[0], from[1], from[2], set.range[2 * i], from[3], from[4], from[5],
                   set.time.empty() ? 0.0f : set.time[i], set.range[2 * i + 1], ~0u, 0, 0};
        one.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        if (set.occluded) {
            rtcOccluded1(scene.scene, context, &one.ray);
            hits[i] = {0.0f, one.ray.tfar < 0.0f ? 0 : MISS};
        } else {
            rtcIntersect1(scene.scene, context, &one);
            bool hit = one.hit.geomID != RTC_INVALID_GEOMETRY_ID;
            hits[i] = hit ? Found{one.ray.tfar, scene.first[one.hit.geomID] + one.hit.primID}
                          : Found{INFINITY, MISS};
        }
    }
}

int main(int argc, char **argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: replay FOLDER [REPETITIONS] [robust]\n");
        return 2;
    }
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    std::string folder = argv[1];
    int repetitions = argc > 2 ? std::max(1, std::atoi(argv[2])) : 5;
    auto device = rtcNewDevice("threads=1,set_affinity=0");
    auto scene = build(device, folder, argc > 3 && std::string(argv[3]) == "robust");
    for (std::string name : {"primary", "bounce", "shadow"}) {
        RaySet set{load<float>(folder + "/" + name + ".rays"), load<float>(folder + "/" + name + ".range"),
                   load<float>(folder + "/" + name + ".time"), load<Found>(folder + "/" + name + ".hits"),
                   name == "shadow"};
        if (set.hits.empty()) continue;
        double best = 0.0;
        int width = 0;
        size_t different = 0;
        auto measure = [&](int n, auto run) {
            std::vector<double> seconds;
            std::vector<Found> hits(set.size());
            for (int i = 0; i < repetitions; i++) {
                RTCIntersectContext context;
                rtcInitIntersectContext(&context);
                context.flags = name == "primary" ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT
                                                  : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
                auto start = std::chrono::steady_clock::now();
                run(&context, hits);
                seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
            }
            std::sort(seconds.begin(), seconds.end());
            double speed = double(set.size()) / seconds[seconds.size() / 2] * 1e-6;
            if (speed > best) {
                best = speed, width = n, different = 0;
                for (size_t i = 0; i < set.size(); i++) different += hits[i].primitive != set.hits[i].primitive;
            }
        };
        measure(1, [&](auto *context, auto &hits) { trace<1>(scene, set, context, hits); });
        measure(4, [&](auto *context, auto &hits) { trace<4>(scene, set, context, hits); });
        measure(8, [&](auto *context, auto &hits) { trace<8>(scene, set, context, hits); });
        measure(16, [&](auto *context, auto &hits) { trace<16>(scene, set, context, hits); });
        std::printf("{\"set\":\"%s\",\"rays\":%zu,\"width\":%d,\"mrays_per_s\":%.3f,\"different\":%zu}\n",
                    name.c_str(), set.size(), width, best, different);
    }
}
