// All hits of given rays with Embree, sorted by depth: packets of 16 rays whose
// filter function collects every hit and lets the ray go on.
//
// usage: hits INPUT OUTPUT. INPUT, little endian: u32 segments, corners,
// triangles, rays; f32 eye[3]; segments of two points (x, y, z, radius);
// corners (x, y, z); u32 triangles of three corners; directions of the rays
// (x, y, z), a multiple of 16. OUTPUT: u32 hits and f32 sum of depths a ray.
// Prints the CPU seconds of building and of tracing with sorting.
#include <embree3/rtcore.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <pmmintrin.h>
#include <vector>
#include <xmmintrin.h>

namespace {

struct Collector : RTCIntersectContext {
    std::vector<float> depths[16];
};

void collect(const RTCFilterFunctionNArguments* arguments) {
    auto* collector = static_cast<Collector*>(arguments->context);
    for (unsigned lane = 0; lane < arguments->N; lane++) {
        if (arguments->valid[lane] == 0) continue;
        const unsigned ray = RTCRayN_id(arguments->ray, arguments->N, lane);
        collector->depths[ray].push_back(RTCRayN_tfar(arguments->ray, arguments->N, lane));
        arguments->valid[lane] = 0;
    }
}

double cpu_seconds() {
    timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

template <class T>
std::vector<T> read(FILE* file, size_t count) {
    std::vector<T> values(count);
    if (fread(values.data(), sizeof(T), count, file) != count) {
        fprintf(stderr, "the input is too short\n");
        exit(1);
    }
    return values;
}

void attach(RTCScene scene, RTCGeometry geometry) {
    rtcSetGeometryOccludedFilterFunction(geometry, collect);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
}

}  // namespace

int main(int count, char** arguments) {
    if (count != 3) return 2;
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
    FILE* input = fopen(arguments[1], "rb");
    FILE* output = fopen(arguments[2], "wb");
    if (!input || !output) return 1;
    const auto sizes = read<uint32_t>(input, 4);
    const auto eye = read<float>(input, 3);
    const auto segments = read<float>(input, size_t(sizes[0]) * 8);
    const auto corners = read<float>(input, size_t(sizes[1]) * 3);
    const auto triangles = read<uint32_t>(input, size_t(sizes[2]) * 3);
    const auto directions = read<float>(input, size_t(sizes[3]) * 3);

    const double start = cpu_seconds();
    RTCDevice device = rtcNewDevice("threads=1");
    RTCScene scene = rtcNewScene(device);
    RTCGeometry hair = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_FLAT_LINEAR_CURVE);
    auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(
        hair, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 16, size_t(sizes[0]) * 2));
    std::copy(segments.begin(), segments.end(), points);
    auto* firsts = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(
        hair, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, 4, sizes[0]));
    for (uint32_t segment = 0; segment < sizes[0]; segment++) firsts[segment] = 2 * segment;
    attach(scene, hair);
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
        mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, sizes[1]));
    std::copy(corners.begin(), corners.end(), vertices);
    auto* indices = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(
        mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, sizes[2]));
    std::copy(triangles.begin(), triangles.end(), indices);
    attach(scene, mesh);
    rtcCommitScene(scene);
    const double built = cpu_seconds();

    std::vector<uint32_t> hits(sizes[3]);
    std::vector<float> sums(sizes[3]);
    Collector collector;
    rtcInitIntersectContext(&collector);
    collector.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(64) int valid[16];
    std::fill(valid, valid + 16, -1);
    for (size_t first = 0; first + 16 <= sizes[3]; first += 16) {
        RTCRay16 rays;
        for (unsigned lane = 0; lane < 16; lane++) {
            const float* direction = &directions[3 * (first + lane)];
            rays.org_x[lane] = eye[0];
            rays.org_y[lane] = eye[1];
            rays.org_z[lane] = eye[2];
            rays.dir_x[lane] = direction[0];
            rays.dir_y[lane] = direction[1];
            rays.dir_z[lane] = direction[2];
            rays.tnear[lane] = 0;
            rays.tfar[lane] = std::numeric_limits<float>::infinity();
            rays.time[lane] = 0;
            rays.mask[lane] = ~0u;
            rays.id[lane] = lane;
            rays.flags[lane] = 0;
            collector.depths[lane].clear();
        }
        rtcOccluded16(valid, scene, &collector, &rays);
        for (unsigned lane = 0; lane < 16; lane++) {
            auto& depths = collector.depths[lane];
            std::sort(depths.begin(), depths.end());
            hits[first + lane] = uint32_t(depths.size());
            float sum = 0;
            for (float depth : depths) sum += depth;
            sums[first + lane] = sum;
        }
    }
    const double traced = cpu_seconds();
    fwrite(hits.data(), 4, hits.size(), output);
    fwrite(sums.data(), 4, sums.size(), output);
    if (fclose(output) != 0) return 1;
    printf("%.4f %.4f\n", built - start, traced - built);
    return 0;
}
