// The truth for surfaces and strands: all hits of shadow rays, by Embree's filter functions.
//
// A shared library for embree.py. Every hit takes its share of the light and lets the ray go on, as long as any light
// is left. Strands are flat ribbons that face the ray, and dim it once a crossing, though two segments meet there.
#include <embree3/rtcore.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <pmmintrin.h>
#include <thread>
#include <vector>
#include <xmmintrin.h>

namespace {

enum Wrap { REPEAT, MIRROR, CLAMP };

struct Texture {
    int width = 0, height = 0;
    bool nearest = false;
    int wrap[2] = {REPEAT, REPEAT};
    std::vector<float> alpha;

    static int wrapped(long i, long n, int wrap) {
        if (wrap == CLAMP) return int(std::clamp(i, 0L, n - 1));
        const long period = wrap == MIRROR ? 2 * n : n;
        long r = i % period;
        if (r < 0) r += period;
        return int(r < n ? r : period - 1 - r);
    }

    double texel(long i, long j) const {
        return alpha[size_t(wrapped(j, height, wrap[1])) * width + wrapped(i, width, wrap[0])];
    }

    double at(double u, double v) const {
        double x = u * width, y = v * height;
        if (nearest) return texel(long(std::floor(x)), long(std::floor(y)));
        x -= 0.5;
        y -= 0.5;
        const long i = long(std::floor(x)), j = long(std::floor(y));
        const double a = x - i, b = y - j;
        return (1 - b) * ((1 - a) * texel(i, j) + a * texel(i + 1, j)) +
               b * ((1 - a) * texel(i, j + 1) + a * texel(i + 1, j + 1));
    }
};

enum AlphaMode { OPAQUE, MASK, BLEND };

struct Geometry {
    float opacity[3];
    bool strands = false;
    std::vector<uint32_t> indices;  // of triangles, for texture coordinates
    std::vector<float> uvs;
    std::vector<uint32_t> strand;        // of segments: which strand
    std::vector<float> begin, end;       // of segments: where along it
    float radius = 0;
    int mode = OPAQUE;
    float cutoff = 0.5f, factor = 1;
    Texture texture;

    // How opaque the material is at a hit, before the geometry's own opacity.
    double alpha(unsigned primitive, double u, double v) const {
        if (mode == OPAQUE) return 1;
        double value = factor;
        if (texture.width) {
            const uint32_t* corner = &indices[3 * size_t(primitive)];
            double at[2];
            for (int k = 0; k < 2; k++) {
                at[k] = (1 - u - v) * uvs[2 * corner[0] + k] + u * uvs[2 * corner[1] + k] + v * uvs[2 * corner[2] + k];
            }
            value *= texture.at(at[0], at[1]);
        }
        if (mode == MASK) return value >= cutoff ? 1 : 0;
        return std::clamp(value, 0.0, 1.0);
    }
};

struct Scene {
    RTCDevice device;
    RTCScene scene;
    std::vector<std::unique_ptr<Geometry>> geometries;
    // Embree drops hits of any ribbon within twice its radius of a ray's origin: so far back rays begin.
    double back = 0;
};

struct Crossing {
    unsigned geometry, primitive;
    float t;
};

struct Hit {
    float t;
    unsigned geometry, primitive;
    double opacity;
    float normal[3];
};

// What one ray carries through the filter.
struct RayContext : RTCIntersectContext {
    double left[3];
    // Segments of its own strand, or -1: what the receiver lies on.
    int own_geometry, own_first, own_last;
    float start;  // what lies before does not count
    std::vector<Crossing> crossings;
    std::vector<Hit>* hits;  // of camera rays: all of them, instead of the light
};

// True if a segment beside this one was counted for the same crossing: no more than two widths away along the strand
// and along the ray. Ends of segments are round, so that several may reach over one place.
bool counted(RayContext& context, const Geometry& geometry, unsigned id, unsigned primitive, float t) {
    const float near = 4 * geometry.radius;
    for (const Crossing& other : context.crossings) {
        if (other.geometry != id || geometry.strand[other.primitive] != geometry.strand[primitive]) continue;
        const unsigned first = std::min(primitive, other.primitive), last = std::max(primitive, other.primitive);
        if (geometry.begin[last] - geometry.end[first] < near && std::fabs(other.t - t) < near) {
            return true;
        }
    }
    context.crossings.push_back({id, primitive, t});
    return false;
}

void filter(const RTCFilterFunctionNArguments* arguments) {
    if (arguments->valid[0] != -1) return;
    arguments->valid[0] = 0;
    auto& context = *static_cast<RayContext*>(arguments->context);
    const auto& geometry = *static_cast<const Geometry*>(arguments->geometryUserPtr);
    const unsigned id = RTCHitN_geomID(arguments->hit, 1, 0), primitive = RTCHitN_primID(arguments->hit, 1, 0);
    if (int(id) == context.own_geometry && int(primitive) >= context.own_first && int(primitive) <= context.own_last) {
        return;
    }
    const float t = RTCRayN_tfar(arguments->ray, 1, 0);
    if (t <= context.start) return;
    if (geometry.strands && counted(context, geometry, id, primitive, t)) return;
    const double alpha =
        geometry.alpha(primitive, RTCHitN_u(arguments->hit, 1, 0), RTCHitN_v(arguments->hit, 1, 0));
    if (context.hits) {
        const double mean = (double(geometry.opacity[0]) + geometry.opacity[1] + geometry.opacity[2]) / 3;
        context.hits->push_back({t, id, primitive, mean * alpha,
                                 {RTCHitN_Ng_x(arguments->hit, 1, 0), RTCHitN_Ng_y(arguments->hit, 1, 0),
                                  RTCHitN_Ng_z(arguments->hit, 1, 0)}});
        return;
    }
    double most = 0;
    for (int k = 0; k < 3; k++) {
        context.left[k] *= 1 - geometry.opacity[k] * alpha;
        most = std::max(most, context.left[k]);
    }
    // Nothing left: the hit ends the ray.
    if (most <= 0) arguments->valid[0] = -1;
}

struct Random {
    uint64_t state;
    double next() {
        uint64_t z = (state += 0x9e3779b97f4a7c15ull);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return double((z ^ (z >> 31)) >> 11) * 0x1p-53;
    }
};

struct V3 {
    double x, y, z;
    V3 operator+(V3 o) const { return {x + o.x, y + o.y, z + o.z}; }
    V3 operator-(V3 o) const { return {x - o.x, y - o.y, z - o.z}; }
    V3 operator*(double s) const { return {x * s, y * s, z * s}; }
    double dot(V3 o) const { return x * o.x + y * o.y + z * o.z; }
    V3 cross(V3 o) const { return {y * o.z - z * o.y, z * o.x - x * o.z, x * o.y - y * o.x}; }
    V3 unit() const { return *this * (1 / std::sqrt(dot(*this))); }
};

enum Shape { POINT, RECTANGLE, DISK, SPHERE };

struct Light {
    int shape;
    V3 centre, right, up;  // half axes

    V3 at(V3 receiver, double u, double v) const {
        if (shape == POINT) return centre;
        if (shape == RECTANGLE) return centre + right * (2 * u - 1) + up * (2 * v - 1);
        const double r = std::sqrt(u), angle = 2 * M_PI * v;
        if (shape == DISK) return centre + right * (r * std::cos(angle)) + up * (r * std::sin(angle));
        // The great circle that the receiver sees.
        const V3 axis = (receiver - centre).unit();
        const V3 side = std::fabs(axis.x) < 0.5 ? V3{1, 0, 0} : V3{0, 1, 0};
        const V3 a = axis.cross(side).unit(), b = axis.cross(a);
        const double radius = std::sqrt(right.dot(right));
        return centre + a * (radius * r * std::cos(angle)) + b * (radius * r * std::sin(angle));
    }
};

void transmittance(const Scene& scene, RayContext& context, V3 from, V3 to) {
    const V3 d = (to - from).unit();
    const V3 origin = from - d * scene.back;
    RTCRay ray{};
    ray.org_x = float(origin.x), ray.org_y = float(origin.y), ray.org_z = float(origin.z);
    ray.dir_x = float(d.x), ray.dir_y = float(d.y), ray.dir_z = float(d.z);
    ray.tnear = 0, ray.tfar = float((to - origin).dot(d)), ray.mask = ~0u;
    context.left[0] = context.left[1] = context.left[2] = 1;
    context.start = float(scene.back);
    context.crossings.clear();
    context.hits = nullptr;
    rtcOccluded1(scene.scene, &context, &ray);
    if (ray.tfar < 0) context.left[0] = context.left[1] = context.left[2] = 0;
}

void no_denormals() {
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
}

template <class F>
void in_parallel(uint64_t count, int threads, F work) {
    std::atomic<uint64_t> next{0};
    auto run = [&] {
        no_denormals();
        for (uint64_t i; (i = next.fetch_add(1)) < count;) work(i);
    };
    std::vector<std::thread> others;
    for (int k = 1; k < threads; k++) others.emplace_back(run);
    run();
    for (auto& thread : others) thread.join();
}

Light light_of(int shape, const double* numbers) {
    const double* n = numbers;
    return {shape, {n[0], n[1], n[2]}, {n[3], n[4], n[5]}, {n[6], n[7], n[8]}};
}

void add(Scene& scene, RTCGeometry geometry, Geometry* own) {
    rtcSetGeometryUserData(geometry, own);
    rtcSetGeometryOccludedFilterFunction(geometry, filter);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene.scene, geometry);
    rtcReleaseGeometry(geometry);
    scene.geometries.emplace_back(own);
}

}  // namespace

extern "C" {

Scene* truth_new(int threads) {
    no_denormals();
    char settings[32];
    snprintf(settings, sizeof settings, "threads=%d", threads);
    auto* scene = new Scene;
    scene->device = rtcNewDevice(settings);
    scene->scene = rtcNewScene(scene->device);
    rtcSetSceneFlags(scene->scene, RTC_SCENE_FLAG_ROBUST);
    return scene;
}

void truth_free(Scene* scene) {
    rtcReleaseScene(scene->scene);
    rtcReleaseDevice(scene->device);
    delete scene;
}

// Triangles; `uvs` may be null. The alpha texture has `width` × `height` values, none if `width` is 0.
void truth_add_triangles(Scene* scene, uint32_t vertices, const float* positions, uint32_t triangles,
                         const uint32_t* indices, const float* opacity, const float* uvs, int mode, float cutoff,
                         float factor, int width, int height, const float* texture, int nearest, int wrap_u,
                         int wrap_v) {
    RTCGeometry geometry = rtcNewGeometry(scene->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, vertices), positions,
           size_t(vertices) * 12);
    memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, triangles), indices,
           size_t(triangles) * 12);
    auto* own = new Geometry;
    memcpy(own->opacity, opacity, 12);
    own->mode = mode, own->cutoff = cutoff, own->factor = factor;
    if (uvs && width) {
        own->indices.assign(indices, indices + 3 * size_t(triangles));
        own->uvs.assign(uvs, uvs + 2 * size_t(vertices));
        own->texture.width = width, own->texture.height = height, own->texture.nearest = nearest;
        own->texture.wrap[0] = wrap_u, own->texture.wrap[1] = wrap_v;
        own->texture.alpha.assign(texture, texture + size_t(width) * height);
    }
    add(*scene, geometry, own);
}

// Strands: points (x, y, z, radius), and the first point of each segment.
void truth_add_strands(Scene* scene, uint32_t points, const float* positions, uint32_t segments,
                       const uint32_t* first, const uint32_t* strand, const float* opacity, float radius) {
    RTCGeometry geometry = rtcNewGeometry(scene->device, RTC_GEOMETRY_TYPE_FLAT_LINEAR_CURVE);
    memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 16, points), positions,
           size_t(points) * 16);
    memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, 4, segments), first,
           size_t(segments) * 4);
    auto* own = new Geometry;
    memcpy(own->opacity, opacity, 12);
    own->strands = true;
    own->radius = radius;
    own->strand.assign(strand, strand + segments);
    scene->back = std::max(scene->back, 4.0 * radius);
    float along = 0;
    for (uint32_t i = 0; i < segments; i++) {
        const float *a = positions + 4 * size_t(first[i]), *b = a + 4;
        own->begin.push_back(along);
        along += std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
        own->end.push_back(along);
    }
    add(*scene, geometry, own);
}

void truth_commit(Scene* scene) { rtcCommitScene(scene->scene); }

// The light that reaches each receiver: `side`² jittered rays, twice, with numbers of their own; `out` has the two means
// of three channels. `own` has for each receiver the geometry it lies on and the first and last segment that does not
// count, -1 for none.
void truth_visibility(const Scene* scene, int shape, const double* light_numbers, uint64_t receivers,
                      const double* points, const int32_t* own, int side, uint64_t seed, double* out, int threads) {
    const Light light = light_of(shape, light_numbers);
    in_parallel(receivers, threads, [&](uint64_t i) {
        RayContext context;
        rtcInitIntersectContext(&context);
        context.own_geometry = own[3 * i], context.own_first = own[3 * i + 1], context.own_last = own[3 * i + 2];
        const V3 from{points[3 * i], points[3 * i + 1], points[3 * i + 2]};
        for (int half = 0; half < 2; half++) {
            Random random{seed + (2 * i + half) * 0xd1342543de82ef95ull};
            double sum[3] = {0, 0, 0};
            for (int sample = 0; sample < side * side; sample++) {
                const double u = (sample % side + random.next()) / side, v = (sample / side + random.next()) / side;
                transmittance(*scene, context, from, light.at(from, u, v));
                for (int k = 0; k < 3; k++) sum[k] += context.left[k];
            }
            for (int k = 0; k < 3; k++) out[6 * i + 3 * half + k] = sum[k] / (side * side);
        }
    });
}

// A picture's shadow factors: of every pixel two means over `samples` camera rays each, which end at one hit, taken as
// often as its share, and are lit from there by one ray to the light; 1 where nothing is. The camera: eye, and
// the vectors to the middle, the right and the upper edge of the picture. Surfaces are left by `lift` on the side seen.
void truth_picture(const Scene* scene, int shape, const double* light_numbers, const double* camera, int width,
                   int height, int samples, double lift, uint64_t seed, double* out, int threads) {
    const Light light = light_of(shape, light_numbers);
    const double* c = camera;
    const V3 eye{c[0], c[1], c[2]}, ahead{c[3], c[4], c[5]}, right{c[6], c[7], c[8]}, up{c[9], c[10], c[11]};
    in_parallel(uint64_t(width) * height, threads, [&](uint64_t pixel) {
        RayContext context;
        rtcInitIntersectContext(&context);
        std::vector<Hit> hits;
        for (int half = 0; half < 2; half++) {
            Random random{seed + (2 * pixel + half) * 0xd1342543de82ef95ull};
            double sum[3] = {0, 0, 0};
            for (int sample = 0; sample < samples; sample++) {
                const double x = 2 * (pixel % width + random.next()) / width - 1;
                const double y = 1 - 2 * (pixel / width + random.next()) / height;
                const V3 direction = (ahead + right * x + up * y).unit();
                RTCRay ray{};
                ray.org_x = float(eye.x), ray.org_y = float(eye.y), ray.org_z = float(eye.z);
                ray.dir_x = float(direction.x), ray.dir_y = float(direction.y), ray.dir_z = float(direction.z);
                ray.tnear = 0, ray.tfar = INFINITY, ray.mask = ~0u;
                hits.clear();
                context.hits = &hits;
                context.own_geometry = -1;
                context.start = 0;
                context.crossings.clear();
                rtcOccluded1(scene->scene, &context, &ray);
                std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return a.t < b.t; });
                const double chosen = random.next(), u = random.next(), v = random.next();
                double left = 1;
                const Hit* end = nullptr;
                for (const Hit& hit : hits) {
                    left *= 1 - hit.opacity;
                    if (chosen >= left) {
                        end = &hit;
                        break;
                    }
                }
                if (!end) {
                    for (double& channel : sum) channel += 1;
                    continue;
                }
                V3 from = eye + direction * double(end->t);
                const Geometry& seen = *scene->geometries[end->geometry];
                if (seen.strands) {
                    const int segment = int(end->primitive), last = int(seen.strand.size()) - 1;
                    const auto same = [&](int other) { return seen.strand[other] == seen.strand[segment]; };
                    context.own_geometry = int(end->geometry);
                    context.own_first = segment > 0 && same(segment - 1) ? segment - 1 : segment;
                    context.own_last = segment < last && same(segment + 1) ? segment + 1 : segment;
                } else {
                    const V3 normal = V3{end->normal[0], end->normal[1], end->normal[2]}.unit();
                    from = from + normal * (normal.dot(direction) < 0 ? lift : -lift);
                }
                transmittance(*scene, context, from, light.at(from, u, v));
                for (int k = 0; k < 3; k++) sum[k] += context.left[k];
            }
            for (int k = 0; k < 3; k++) out[6 * pixel + 3 * half + k] = sum[k] / samples;
        }
    });
}
}
