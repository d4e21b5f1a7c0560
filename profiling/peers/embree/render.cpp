// Renders meshes with Embree 3, in a loop that traces and shades waves of paths.
//
//     g++ -std=c++17 -O3 -march=native render.cpp -o render -lembree3
//     ./render FOLDER WIDTH HEIGHT SPP ALBEDO SKY CORNER RIGHT DOWN EYE    # the last four have 3 numbers each
//
// FOLDER holds the triangles of a ray set that `ptfast rays` wrote. All of them are diffuse, of one albedo, under a
// sky of one radiance. Camera rays run from the eye through CORNER + x RIGHT + y DOWN, where x and y count pixels.
// Paths end in the sky or after 50 segments, and no light is sampled.
//
// Prints one JSON line for each mode and packet size: millions of camera paths per second on one thread, and the mean
// of the image.

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

struct Vec {
    float x, y, z;
};
static Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
static Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
static Vec operator*(Vec a, float s) { return {a.x * s, a.y * s, a.z * s}; }
static float dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static Vec unit(Vec a) { return a * (1.0f / std::sqrt(dot(a, a))); }

// A multiplicative generator (Marsaglia's xorshift64*).
struct Random {
    uint64_t state;
    float operator()() {
        state ^= state >> 12, state ^= state << 25, state ^= state >> 27;
        return float((state * 0x2545f4914f6cdd1dull) >> 40) * 0x1p-24f;
    }
};

struct Ray {
    Vec origin, direction;
    float near;
};
struct Hit {
    float t;
    Vec normal;
    bool found;
};
struct Path {
    Ray ray;
    float weight;
    uint32_t pixel;
};

// Packets of N rays. Embree's structures for each N differ only in their names.
template <int N>
struct Packet;
#define PACKET(N)                                                                           \
    template <>                                                                             \
    struct Packet<N> {                                                                      \
        RTCRayHit##N all;                                                                   \
        void trace(const int *valid, RTCScene scene, RTCIntersectContext *context) {        \
            rtcIntersect##N(valid, scene, context, &all);                                   \
        }                                                                                   \
    };
PACKET(8)
PACKET(16)

template <int N>
static void trace(RTCScene scene, RTCIntersectContext *context, const std::vector<Path> &paths,
                  std::vector<Hit> &hits) {
    alignas(64) Packet<N> packet;
    alignas(64) int valid[N];
    auto &ray = packet.all.ray;
    auto &hit = packet.all.hit;
    for (size_t first = 0; first < paths.size(); first += N) {
        for (int lane = 0; lane < N; lane++) {
            auto [origin, direction, near] = paths[std::min(first + lane, paths.size() - 1)].ray;
            valid[lane] = first + lane < paths.size() ? -1 : 0;
            ray.org_x[lane] = origin.x, ray.org_y[lane] = origin.y, ray.org_z[lane] = origin.z;
            ray.dir_x[lane] = direction.x, ray.dir_y[lane] = direction.y, ray.dir_z[lane] = direction.z;
            ray.tnear[lane] = near, ray.tfar[lane] = INFINITY, ray.time[lane] = 0.0f;
            ray.mask[lane] = ~0u, ray.id[lane] = 0, ray.flags[lane] = 0;
            hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
        }
        packet.trace(valid, scene, context);
        for (int lane = 0; lane < N && first + lane < paths.size(); lane++)
            hits[first + lane] = {ray.tfar[lane], {hit.Ng_x[lane], hit.Ng_y[lane], hit.Ng_z[lane]},
                                  hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID};
    }
}

template <>
void trace<1>(RTCScene scene, RTCIntersectContext *context, const std::vector<Path> &paths, std::vector<Hit> &hits) {
    alignas(16) RTCRayHit one;
    for (size_t i = 0; i < paths.size(); i++) {
        auto [origin, direction, near] = paths[i].ray;
        one.ray = {origin.x,    origin.y,    origin.z, near,     direction.x, direction.y,
                   direction.z, 0.0f,        INFINITY, ~0u,      0,           0};
        one.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, context, &one);
        hits[i] = {one.ray.tfar, {one.hit.Ng_x, one.hit.Ng_y, one.hit.Ng_z}, one.hit.geomID != RTC_INVALID_GEOMETRY_ID};
    }
}

struct View {
    int width, height, spp;
    float albedo, sky, near;
    Vec corner, right, down, eye;
};

// Turns the ray into a cosine-distributed one from the hit point.
static void scatter(Ray &ray, const Hit &hit, float near, Random &random) {
    Vec normal = unit(hit.normal);
    if (dot(normal, ray.direction) > 0.0f) normal = normal * -1.0f;
    float z = 1.0f - 2.0f * random(), angle = 6.2831853f * random(), r = std::sqrt(std::max(0.0f, 1.0f - z * z));
    Vec sum = normal + Vec{r * std::cos(angle), r * std::sin(angle), z};
    float square = dot(sum, sum);
    ray = {ray.origin + ray.direction * hit.t, square > 1e-12f ? sum * (1.0f / std::sqrt(square)) : normal, near};
}

static const size_t WAVE = 4096;

// Renders the view in blocks of 8 x 8 pixels. Returns the mean of the image.
template <int N>
static double render(RTCScene scene, const View &view) {
    Random random{0x9e3779b97f4a7c15ull};
    std::vector<Path> wave;
    std::vector<Hit> hits(WAVE + 64);
    std::vector<float> image(size_t(view.width) * view.height, 0.0f);
    auto finish = [&] {
        for (int segment = 0; segment < 50 && !wave.empty(); segment++) {
            RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            context.flags = segment == 0 ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
            trace<N>(scene, &context, wave, hits);
            size_t left = 0;
            for (size_t i = 0; i < wave.size(); i++) {
                Path path = wave[i];
                if (!hits[i].found) {
                    image[path.pixel] += path.weight * view.sky;
                    continue;
                }
                path.weight *= view.albedo;
                scatter(path.ray, hits[i], view.near, random);
                wave[left++] = path;
            }
            wave.resize(left);
        }
        wave.clear();
    };
    for (int row = 0; row < view.height; row += 8)
        for (int column = 0; column < view.width; column += 8)
            for (int sample = 0; sample < view.spp; sample++) {
                for (int y = row; y < std::min(row + 8, view.height); y++)
                    for (int x = column; x < std::min(column + 8, view.width); x++) {
                        Vec at = view.corner + view.right * (x + random()) + view.down * (y + random());
                        wave.push_back({{view.eye, unit(at - view.eye), 0.0f}, 1.0f, uint32_t(y * view.width + x)});
                    }
                if (wave.size() >= WAVE) finish();
            }
    finish();
    double sum = 0.0;
    for (float value : image) sum += value;
    return sum / (double(view.width) * view.height * view.spp);
}

template <int N>
static void measure(RTCScene scene, const View &view, const char *mode) {
    auto start = std::chrono::steady_clock::now();
    double mean = render<N>(scene, view);
    double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    double paths = double(view.width) * view.height * view.spp * 1e-6;
    std::printf("{\"mode\":\"%s\",\"width\":%d,\"mpaths_per_s\":%.4f,\"mean\":%.5f}\n", mode, N, paths / seconds, mean);
}

int main(int argc, char **argv) {
    if (argc != 19) {
        std::fprintf(stderr, "usage: render FOLDER WIDTH HEIGHT SPP ALBEDO SKY CORNER RIGHT DOWN EYE\n");
        return 2;
    }
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    auto number = [&](int i) { return float(std::atof(argv[i])); };
    auto vector = [&](int i) { return Vec{number(i), number(i + 1), number(i + 2)}; };
    std::ifstream file(std::string(argv[1]) + "/triangles.f32", std::ios::binary | std::ios::ate);
    std::vector<float> corners(file ? size_t(file.tellg()) / sizeof(float) : 0);
    file.seekg(0);
    file.read(reinterpret_cast<char *>(corners.data()), std::streamsize(corners.size() * sizeof(float)));
    if (corners.empty()) {
        std::fprintf(stderr, "render: %s/triangles.f32 has no triangles\n", argv[1]);
        return 1;
    }
    float largest = 0.0f;
    for (float corner : corners) largest = std::max(largest, std::fabs(corner));
    View view{std::atoi(argv[2]), std::atoi(argv[3]), std::atoi(argv[4]), number(5), number(6), 1e-5f * largest,
              vector(7), vector(10), vector(13), vector(16)};
    auto device = rtcNewDevice("threads=1,set_affinity=0");
    for (bool robust : {false, true}) {
        auto scene = rtcNewScene(device);
        rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
        if (robust) rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
        auto mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        size_t count = corners.size() / 9;
        std::memcpy(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * count),
                    corners.data(), corners.size() * sizeof(float));
        auto index = static_cast<uint32_t *>(
            rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count));
        for (uint32_t i = 0; i < 3 * count; i++) index[i] = i;
        rtcCommitGeometry(mesh);
        rtcAttachGeometry(scene, mesh);
        rtcReleaseGeometry(mesh);
        rtcCommitScene(scene);
        const char *mode = robust ? "robust" : "fast";
        measure<1>(scene, view, mode);
        measure<8>(scene, view, mode);
        measure<16>(scene, view, mode);
        rtcReleaseScene(scene);
    }
}
