/* Deep and layered shadow maps: libdeepshadow.
 *
 * Made by `bindings/c/check_header.sh --write` from the library's source.
 *
 * Calls return a ds_status; ds_error_message tells what was wrong, to the thread that called.
 * Handles have one reference when they are handed out; ds_*_retain adds one and ds_*_release
 * takes one off, NULL is let pass. Any number of threads may use a handle. Strings are UTF-8 and
 * end at a zero; arrays have as many entries as their count says; `out` is written on DS_OK alone.
 */

#ifndef DEEPSHADOW_H
#define DEEPSHADOW_H

#include <stddef.h>
#include <stdint.h>

// What became of a call.
typedef enum {
  // It did what it should.
  DS_OK = 0,
  // A map or an image is not what it should be, or cannot be read or written.
  DS_ERROR_FILE = 1,
  // A scene is not sound.
  DS_ERROR_SCENE = 2,
  // A map cannot answer what it is asked.
  DS_ERROR_QUERY = 3,
  // An argument is not what it can be.
  DS_ERROR_SETTING = 4,
  // A hit source failed.
  DS_ERROR_SOURCE = 5,
  // A progress function ended the work; no file was changed.
  DS_ERROR_CANCELLED = 6,
  // A fault of this library.
  DS_ERROR_INTERNAL = 7,
} ds_status;

// The shape of a light.
typedef enum {
  // A point.
  DS_POINT = 0,
  // A rectangle of size[0] by size[1].
  DS_RECTANGLE = 1,
  // A disk of diameter size[0].
  DS_DISK = 2,
  // A sphere of diameter size[0].
  DS_SPHERE = 3,
} ds_light_shape;

// Memory for the tiles of many maps.
typedef struct ds_cache ds_cache;

// The visibility functions of a level, in columns.
typedef struct ds_columns ds_columns;

// A deep image in memory.
typedef struct ds_deep ds_deep;

// The hits of a tile, which a caller fills.
typedef struct ds_hits ds_hits;

// An open map. Any number of threads may use it.
typedef struct ds_map ds_map;

// The shadows of a query, ready for any number of points, from any thread.
typedef struct ds_shadow ds_shadow;

// What a map is baked through, which tells its rays.
typedef struct ds_view ds_view;

// Called with what is done and of how much, from any thread; 0 ends the work.
typedef int32_t (*ds_progress)(void *user, uint64_t done, uint64_t total);

// Settings of a bake; ds_bake_init gives every field its default.
typedef struct {
  // The name of a kind; NULL: "deep".
  const char *kind;
  // Width in pixels; 0: what suits the kind and the scene.
  uint32_t width;
  // Height in pixels; 0: as wide.
  uint32_t height;
  // Samples a pixel; 0: what is usual for the kind.
  uint32_t samples;
  // Bound of the error of every visibility function, in [0, 1); NaN: by the samples.
  float tolerance;
  // 1 or 3 channels; 0: 3 if the scene has colours.
  uint32_t channels;
  // Most layers of a pixel; 0: what is usual for the kind.
  uint32_t layers;
  // Width and height of a tile in pixels; 0: 64.
  uint32_t tile;
  // Not 0: with mip levels.
  int32_t mip;
  // Seed of the samples' places.
  uint64_t seed;
  // NULL, or what is told of the work.
  ds_progress progress;
  // Handed to `progress`.
  void *user;
} ds_bake;

// A light and the camera that sits in it; ds_light_init gives every field its default.
typedef struct {
  // Where it stands, in the world.
  double eye[3];
  // What it looks at, in the world.
  double target[3];
  // Upwards, in the world.
  double up[3];
  // Full angle of the wider side in degrees, in (0, 180).
  double fov;
  // Full width of the wider side in scene units, of parallel rays; 0: perspective.
  double extent;
  // One of ds_light_shape.
  uint32_t shape;
  // Full width and height in scene units; of disks and spheres the diameter, twice.
  double size[2];
} ds_light;

// Counts of a bake.
typedef struct {
  // Samples of all pixels.
  uint64_t samples;
  // Hits of all samples.
  uint64_t hits;
  // Pixels with more layers than the map keeps.
  uint64_t cut_pixels;
  // Length of the file in bytes.
  uint64_t bytes;
  // The bound of the error of every visibility function.
  float tolerance;
  // Numbers a value: 1 or 3.
  uint32_t channels;
} ds_report;

// The sample points of a block of pixels: columns of `count` entries, which live as long as the
// call that they are handed to.
typedef struct {
  // Number of sample points.
  size_t count;
  // Columns in pixels, from the left edge of the map.
  const double *x;
  // Rows in pixels, from the top edge of the map.
  const double *y;
  // Times in [0, 1].
  const float *time;
  // What they are seen through, for ds_view_rays.
  const ds_view *view;
} ds_tile;

// Adds the hits of the sample points of `tile` to `hits`, in any order; called from any thread.
// Anything but 0 ends the bake.
typedef int32_t (*ds_hit_function)(void *user, const ds_tile *tile, ds_hits *hits);

// A deep image in columns: the samples of pixel i, counted row by row, are offsets[i] to
// offsets[i + 1].
typedef struct {
  // Width in pixels.
  uint32_t width;
  // Height in pixels.
  uint32_t height;
  // Opacities a sample: 0, 1 or 3.
  uint32_t channels;
  // Number of samples.
  size_t samples;
  // First sample of each pixel, and the end: width * height + 1.
  const uint32_t *offsets;
  // Front depths.
  const float *z;
  // Back depths; NULL: there are none.
  const float *zback;
  // Opacities; NULL: all samples are opaque.
  const float *a;
} ds_deep_view;

// What a map is.
typedef struct {
  // Width of level 0 in pixels.
  uint32_t width;
  // Height of level 0 in pixels.
  uint32_t height;
  // Numbers a value: 1 or 3.
  uint32_t channels;
  // Number of levels.
  uint32_t levels;
  // Not 0: it has a camera, and answers points of the world.
  int32_t has_camera;
} ds_map_info;

// The columns of a level: the vertices of pixel i, counted row by row, are offsets[i] to
// offsets[i + 1]. They live as long as their handle.
typedef struct {
  // Number of pixels; there is one offset more.
  size_t pixels;
  // Number of vertices.
  size_t vertices;
  // First vertex of each pixel, and the end.
  const uint32_t *offsets;
  // Depths in scene units, ascending in each pixel.
  const float *depths;
  // Values in [0, 1]: one a vertex, of RGB maps three.
  const float *values;
} ds_column_view;

// A query of a map; ds_query_init gives every field its default.
typedef struct {
  // "filter", "trace", "pcf" or "prefilter"; NULL: the map's own.
  const char *method;
  // "point", "box", "tent" or "gaussian"; NULL: point. Method filter.
  const char *filter;
  // Full width of the filter in pixels of level 0; NaN: the minimum. Method filter.
  float width;
  // Mip level, 0 the finest; below 0: the one that fits the filter. Method filter.
  double level;
  // Depth bias, or ray offset of method trace, in scene units; NaN: what is usual.
  float bias;
  // Rays or taps; 0: 256. Methods trace and pcf.
  uint32_t rays;
  // Full width and height of the map's light in scene units; NaN: as the map says.
  float light_size[2];
  // Seed of methods that sample.
  uint64_t seed;
} ds_query;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Gives every field of a bake its default.
//
// # Safety
//
// `settings` can be written to.
void ds_bake_init(ds_bake *settings);

// Bakes a scene: a scene file, a model, or "builtin:NAME". `light` may be NULL: the scene's.
// `settings` and `report` may be NULL. `output` is replaced when the map is whole.
//
// # Safety
//
// `scene` and `output` are strings, `light` and `settings` NULL or such, and `report` NULL or
// can be written to.
ds_status ds_bake_scene(const char *scene,
                        const ds_light *light,
                        const ds_bake *settings,
                        const char *output,
                        ds_report *report);

// Bakes the hits of a function. `light` says from where; `media` is not 0 if it adds slabs.
// `user` is handed to the function, which is called from any thread.
//
// # Safety
//
// `function` may be called from any thread with `user`; `light` is a light, `settings` NULL or
// settings, `output` a string, and `report` NULL or can be written to.
ds_status ds_bake_hits(ds_hit_function function,
                       void *user,
                       int32_t media,
                       const ds_light *light,
                       const ds_bake *settings,
                       const char *output,
                       ds_report *report);

// Numbers an opacity of these hits: 1 or 3.
//
// # Safety
//
// `hits` are those that a hit function was called with, during that call.
uint32_t ds_hits_channels(const ds_hits *hits);

// Adds `count` surfaces: the number of a sample point of the tile each, a depth above 0 in scene
// units along the camera's axis, and an opacity in [0, 1], or three of RGB maps.
//
// # Safety
//
// `hits` are those that a hit function was called with, during that call; the arrays are as
// long as said.
ds_status ds_hits_add(ds_hits *hits,
                      size_t count,
                      const uint32_t *samples,
                      const float *depths,
                      const float *opacities);

// Adds `count` slabs of even density, which take `opacities` of the light between `near` and
// `far` depths.
//
// # Safety
//
// As of ds_hits_add.
ds_status ds_hits_add_slabs(ds_hits *hits,
                            size_t count,
                            const uint32_t *samples,
                            const float *near,
                            const float *far,
                            const float *opacities);

// The rays through `count` raster positions: an origin and a direction of three numbers each. A
// direction goes one unit deep: origin + depth * direction is the point of the world.
//
// # Safety
//
// `view` is that of a tile, during the call that has it; the arrays are as long as said.
ds_status ds_view_rays(const ds_view *view,
                       size_t count,
                       const double *x,
                       const double *y,
                       double *origins,
                       double *directions);

// Makes a cache of at most so many bytes, for any number of maps.
//
// # Safety
//
// `out` can be written to.
ds_status ds_cache_new(uint64_t bytes, const ds_cache **out);

// Adds a reference, and returns the cache.
//
// # Safety
//
// `cache` is NULL or a cache that was not released.
const ds_cache *ds_cache_retain(const ds_cache *cache);

// Takes a reference off; the last one ends the cache. Maps keep the one that they were opened
// with.
//
// # Safety
//
// `cache` is NULL or a cache that was not released.
void ds_cache_release(const ds_cache *cache);

// Reads a deep image, or a flat one with a depth as one sample a pixel.
//
// # Safety
//
// `file` is a string, and `out` can be written to.
ds_status ds_deep_read(const char *file, const ds_deep **out);

// The columns of an image, which live as long as it.
//
// # Safety
//
// `deep` is an image that was not released, and `out` can be written to.
ds_status ds_deep_describe(const ds_deep *deep, ds_deep_view *out);

// Adds a reference, and returns the image.
//
// # Safety
//
// `deep` is NULL or an image that was not released.
const ds_deep *ds_deep_retain(const ds_deep *deep);

// Takes a reference off; the last one frees the image.
//
// # Safety
//
// `deep` is NULL or an image that was not released.
void ds_deep_release(const ds_deep *deep);

// Writes columns as a deep image in scan lines, which replaces `file` when it is whole.
//
// # Safety
//
// `file` is a string, and the columns of `view` are as long as it says.
ds_status ds_deep_write(const char *file, const ds_deep_view *view);

// The message of the last failure of a call of this thread; empty if none failed. It stays
// until the next.
const char *ds_error_message(void);

// The version of this interface: the library's major and minor version, as 100 * major + minor.
// A program runs with libraries of the same number.
uint32_t ds_abi_version(void);

// Opens a map of any kind. `cache` may be NULL: then it has one of its own.
//
// # Safety
//
// `file` is a string, `cache` NULL or a cache, and `out` can be written to.
ds_status ds_map_open(const char *file, const ds_cache *cache, const ds_map **out);

// Adds a reference, and returns the map.
//
// # Safety
//
// `map` is NULL or a map that was not released.
const ds_map *ds_map_retain(const ds_map *map);

// Takes a reference off; the last one closes the map.
//
// # Safety
//
// `map` is NULL or a map that was not released.
void ds_map_release(const ds_map *map);

// The name of the map's kind, which lives as long as the map; NULL for NULL.
//
// # Safety
//
// `map` is NULL or a map that was not released.
const char *ds_map_kind(const ds_map *map);

// What a map is.
//
// # Safety
//
// `map` is a map that was not released, and `out` can be written to.
ds_status ds_map_describe(const ds_map *map, ds_map_info *out);

// Everything that is wrong with a map's file: how many errors there are. The first one is the
// message of ds_error_message.
//
// # Safety
//
// `map` is a map that was not released, and `errors` can be written to.
ds_status ds_map_verify(const ds_map *map, size_t *errors);

// Reads the visibility functions of a level.
//
// # Safety
//
// `map` is a map that was not released, and `out` can be written to.
ds_status ds_map_columns(const ds_map *map, uint32_t level, const ds_columns **out);

// The columns of a level. They live as long as `columns`.
//
// # Safety
//
// `columns` are columns that were not released, and `out` can be written to.
ds_status ds_columns_view(const ds_columns *columns, ds_column_view *out);

// Adds a reference, and returns the columns.
//
// # Safety
//
// `columns` is NULL or columns that were not released.
const ds_columns *ds_columns_retain(const ds_columns *columns);

// Takes a reference off; the last one frees the columns.
//
// # Safety
//
// `columns` is NULL or columns that were not released.
void ds_columns_release(const ds_columns *columns);

// Makes a map of a deep image or another map, or if `output` ends in .exr a deep image of a
// map. `tolerance`: the bound of the error that this may add, NaN: what is usual.
//
// # Safety
//
// `source` and `output` are strings.
ds_status ds_convert(const char *source, const char *output, float tolerance);

// Gives every field of a query its default.
//
// # Safety
//
// `query` can be written to.
void ds_query_init(ds_query *query);

// Gives every field of a light its default: a point one unit above the origin, of 45 degrees.
//
// # Safety
//
// `light` can be written to.
void ds_light_init(ds_light *light);

// Makes the shadows of a query ready. `query` may be NULL: all defaults.
//
// # Safety
//
// `map` is a map that was not released, `query` NULL or a query whose pointers are NULL or
// strings, and `out` can be written to.
ds_status ds_map_shadow(const ds_map *map, const ds_query *query, const ds_shadow **out);

// Adds a reference, and returns the shadows.
//
// # Safety
//
// `shadow` is NULL or shadows that were not released.
const ds_shadow *ds_shadow_retain(const ds_shadow *shadow);

// Takes a reference off; the last one frees the shadows.
//
// # Safety
//
// `shadow` is NULL or shadows that were not released.
void ds_shadow_release(const ds_shadow *shadow);

// Numbers a point: 1 or 3; 0 for NULL.
//
// # Safety
//
// `shadow` is NULL or shadows that were not released.
uint32_t ds_shadow_channels(const ds_shadow *shadow);

// The shadow factors of points of the world, 1 lit and 0 dark, on all cores: `points` has x, y
// and z of each, `values` room for as many numbers as ds_shadow_channels says of each. `first`
// is the number of the first point where these are part of a longer list, else 0.
//
// # Safety
//
// `shadow` are shadows that were not released; the arrays are as long as said.
ds_status ds_shadow_world(const ds_shadow *shadow,
                          const double *points,
                          size_t count,
                          uint64_t first,
                          float *values);

// The same of raster positions: column and row in pixels of level 0, and the depth.
//
// # Safety
//
// As of ds_shadow_world.
ds_status ds_shadow_raster(const ds_shadow *shadow,
                           const double *points,
                           size_t count,
                           uint64_t first,
                           float *values);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* DEEPSHADOW_H */
