/* Embree 3 as the hit source of a map of fragments, beside Embree's own shadow rays. */

#include <deepshadow.h>
#include <embree3/rtcore.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void check(ds_status status)
{
    if (status != DS_OK) {
        fprintf(stderr, "error %d: %s\n", (int)status, ds_error_message());
        exit(1);
    }
}

static float coordinate(unsigned *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) / 16777216.0f * 2.0f - 1.0f;
}

/* Triangles within [-1, 1]^3. */
static RTCScene soup(RTCDevice device, int triangles)
{
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *corner = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, (size_t)triangles * 3);
    unsigned *index = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, (size_t)triangles);
    unsigned state = 7;
    for (int triangle = 0; triangle < triangles; ++triangle) {
        float middle[3] = {coordinate(&state), coordinate(&state), coordinate(&state)};
        for (int i = 0; i < 9; ++i)
            corner[9 * triangle + i] = middle[i % 3] + 0.5f * coordinate(&state);
        for (int i = 0; i < 3; ++i)
            index[3 * triangle + i] = (unsigned)(3 * triangle + i);
    }
    rtcCommitGeometry(mesh);
    RTCScene scene = rtcNewScene(device);
    rtcAttachGeometry(scene, mesh);
    rtcReleaseGeometry(mesh);
    rtcCommitScene(scene);
    return scene;
}

/* The nearest hit of each ray: what lies behind is dark already. */
static int32_t hits(void *user, const ds_tile *tile, ds_hits *hits)
{
    RTCScene scene = user;
    size_t count = tile->count, found = 0;
    double *origins = malloc(count * 3 * sizeof *origins), *directions = malloc(count * 3 * sizeof *directions);
    uint32_t *samples = malloc(count * sizeof *samples);
    float *depths = malloc(count * sizeof *depths), *opacities = malloc(count * sizeof *opacities);
    int32_t status = 1;
    if (!origins || !directions || !samples || !depths || !opacities)
        goto done;
    if (ds_view_rays(tile->view, count, tile->x, tile->y, origins, directions) != DS_OK)
        goto done;
    for (size_t i = 0; i < count; ++i) {
        struct RTCIntersectContext context;
        struct RTCRayHit ray = {0};
        rtcInitIntersectContext(&context);
        ray.ray.org_x = (float)origins[3 * i];
        ray.ray.org_y = (float)origins[3 * i + 1];
        ray.ray.org_z = (float)origins[3 * i + 2];
        ray.ray.dir_x = (float)directions[3 * i];
        ray.ray.dir_y = (float)directions[3 * i + 1];
        ray.ray.dir_z = (float)directions[3 * i + 2];
        ray.ray.tfar = INFINITY;
        ray.ray.mask = (unsigned)-1;
        ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, &context, &ray);
        if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID)
            continue;
        samples[found] = (uint32_t)i;
        /* The ray's parameter is the depth. */
        depths[found] = ray.ray.tfar;
        opacities[found++] = 1;
    }
    status = ds_hits_add(hits, found, samples, depths, opacities) == DS_OK ? 0 : 1;
done:
    free(origins), free(directions), free(samples), free(depths), free(opacities);
    return status;
}

int main(int count, char **words)
{
    const char *path = count > 1 ? words[1] : "soup.dsm";
    RTCDevice device = rtcNewDevice("threads=1");
    RTCScene scene = soup(device, 40);
    ds_light light;
    ds_bake settings;
    ds_report report;
    ds_light_init(&light);
    light.eye[1] = 5;
    light.fov = 50;
    ds_bake_init(&settings);
    settings.width = 1024;
    settings.samples = 4;
    check(ds_bake_hits(hits, scene, 0, &light, &settings, path, &report));

    const ds_map *map;
    const ds_shadow *shadow;
    check(ds_map_open(path, NULL, &map));
    check(ds_map_shadow(map, NULL, &shadow));
    enum { POINTS = 2000 };
    static double points[POINTS][3];
    static float values[POINTS];
    unsigned state = 3;
    for (int i = 0; i < POINTS; ++i) {
        points[i][0] = 1.2 * coordinate(&state);
        points[i][1] = -1.5;
        points[i][2] = 1.2 * coordinate(&state);
    }
    check(ds_shadow_world(shadow, points[0], POINTS, 0, values));
    double off = 0, lit = 0;
    for (int i = 0; i < POINTS; ++i) {
        struct RTCIntersectContext context;
        struct RTCRay ray = {0};
        rtcInitIntersectContext(&context);
        ray.org_x = (float)points[i][0], ray.org_y = (float)points[i][1], ray.org_z = (float)points[i][2];
        ray.dir_x = -ray.org_x, ray.dir_y = 5 - ray.org_y, ray.dir_z = -ray.org_z;
        ray.tfar = 1;
        ray.mask = (unsigned)-1;
        rtcOccluded1(scene, &context, &ray);
        double truth = ray.tfar < 0 ? 0 : 1;
        off += fabs(truth - values[i]) / POINTS;
        lit += truth / POINTS;
    }
    printf("%llu hits; %.1f %% of the points are lit, the map is off by %.4f\n", (unsigned long long)report.hits, 100 * lit, off);
    ds_shadow_release(shadow);
    ds_map_release(map);
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
    /* Pixels at edges are half lit, and random points seldom lie there. */
    return lit > 0.2 && lit < 0.8 && off < 0.03 ? 0 : 1;
}
