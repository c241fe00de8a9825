/* Bakes a scene, opens the map, and asks for points, in C99. */

#include <deepshadow.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void check(ds_status status)
{
    if (status != DS_OK) {
        fprintf(stderr, "error %d: %s\n", (int)status, ds_error_message());
        exit(1);
    }
}

int main(int count, char **words)
{
    const char *path = count > 1 ? words[1] : "sphere.dsm";
    ds_bake settings;
    ds_report report;
    ds_bake_init(&settings);
    settings.width = 64;
    settings.samples = 4;
    check(ds_bake_scene("builtin:spinning-sphere", NULL, &settings, path, &report));
    printf("%llu hits, %llu bytes\n", (unsigned long long)report.hits, (unsigned long long)report.bytes);

    /* One cache for any number of files. */
    const ds_cache *cache;
    const ds_map *map;
    const ds_shadow *shadow;
    check(ds_cache_new(64u << 20, &cache));
    check(ds_map_open(path, cache, &map));
    ds_map_info info;
    check(ds_map_describe(map, &info));
    printf("%s, %u x %u, %u channel(s)\n", ds_map_kind(map), info.width, info.height, info.channels);

    ds_query query;
    ds_query_init(&query);
    query.filter = "tent";
    query.width = 4;
    check(ds_map_shadow(map, &query, &shadow));
    /* The shadows keep what they need. */
    ds_map_release(map);
    ds_cache_release(cache);

    const double points[][3] = {{0, 0, 0}, {0, 100, 0}};
    float values[2];
    check(ds_shadow_world(shadow, points[0], 2, 0, values));
    printf("in the middle %.3f, far away %.3f\n", values[0], values[1]);
    ds_shadow_release(shadow);
    if (values[0] > 0.5f || values[1] != 1.0f) {
        fprintf(stderr, "the middle of the sphere is not dark\n");
        return 1;
    }

    /* An error has a code and a message. */
    if (ds_map_open("no/such.dsm", NULL, &map) != DS_ERROR_FILE || strstr(ds_error_message(), "no/such.dsm") == NULL)
        return 1;
    printf("as it should be: %s\n", ds_error_message());
    return 0;
}
