// A renderer's own hits, and deep images in and out, in C++17.

#include <deepshadow.h>

#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

namespace {

void check(ds_status status)
{
    if (status != DS_OK) {
        std::fprintf(stderr, "error %d: %s\n", int(status), ds_error_message());
        std::exit(1);
    }
}

template <auto Release> struct Releaser {
    template <typename T> void operator()(T *handle) const { Release(handle); }
};
using Map = std::unique_ptr<const ds_map, Releaser<ds_map_release>>;
using Shadow = std::unique_ptr<const ds_shadow, Releaser<ds_shadow_release>>;
using Columns = std::unique_ptr<const ds_columns, Releaser<ds_columns_release>>;
using Deep = std::unique_ptr<const ds_deep, Releaser<ds_deep_release>>;

struct Pane {
    double height;
    float opacity;
    std::atomic<int> tiles{0};
};

// A pane over x < 0, parallel to the ground.
std::int32_t hits(void *user, const ds_tile *tile, ds_hits *hits)
{
    auto &pane = *static_cast<Pane *>(user);
    ++pane.tiles;
    std::vector<double> origins(3 * tile->count), directions(3 * tile->count);
    if (ds_view_rays(tile->view, tile->count, tile->x, tile->y, origins.data(), directions.data()) != DS_OK)
        return 1;
    std::vector<std::uint32_t> samples;
    std::vector<float> depths;
    for (std::size_t i = 0; i < tile->count; ++i) {
        const double depth = (pane.height - origins[3 * i + 1]) / directions[3 * i + 1];
        if (depth > 0 && origins[3 * i] + depth * directions[3 * i] < 0) {
            samples.push_back(std::uint32_t(i));
            depths.push_back(float(depth));
        }
    }
    const std::vector<float> opacities(samples.size(), pane.opacity);
    return ds_hits_add(hits, samples.size(), samples.data(), depths.data(), opacities.data()) == DS_OK ? 0 : 1;
}

std::int32_t bad_hits(void *, const ds_tile *tile, ds_hits *hits)
{
    const auto sample = std::uint32_t(tile->count);
    const float depth = 1, opacity = 1;
    ds_hits_add(hits, 1, &sample, &depth, &opacity);
    return 0;
}

std::int32_t at_once(void *, std::uint64_t, std::uint64_t) { return 0; }

} // namespace

int main(int count, char **words)
{
    const std::string folder = count > 1 ? words[1] : ".";
    const std::string path = folder + "/pane.dsm", image = folder + "/pane.exr", again = folder + "/again.exr";

    ds_light light;
    ds_light_init(&light);
    light.eye[1] = 4;
    light.fov = 60;
    ds_bake settings;
    ds_bake_init(&settings);
    settings.width = 128;
    Pane pane{1.0, 0.6f};
    ds_report report;
    check(ds_bake_hits(hits, &pane, 0, &light, &settings, path.c_str(), &report));
    std::printf("%llu hits in %d tiles\n", (unsigned long long)report.hits, pane.tiles.load());

    const ds_map *opened;
    check(ds_map_open(path.c_str(), nullptr, &opened));
    const Map map(opened);
    const ds_shadow *made;
    check(ds_map_shadow(map.get(), nullptr, &made));
    const Shadow shadow(made);
    const double points[] = {-0.5, 0, 0.2, 0.5, 0, 0.2, -0.5, 2, 0.2};
    float values[3];
    check(ds_shadow_world(shadow.get(), points, 3, 0, values));
    std::printf("below the pane %.3f, beside it %.3f, above it %.3f\n", values[0], values[1], values[2]);
    if (std::abs(values[0] - 0.4f) > 1e-3f || values[1] != 1 || values[2] != 1)
        return 1;

    const ds_columns *read;
    check(ds_map_columns(map.get(), 0, &read));
    const Columns columns(read);
    ds_column_view view;
    check(ds_columns_view(columns.get(), &view));
    if (view.pixels != 128 * 128 || view.offsets[view.pixels] != view.vertices)
        return 1;

    // A map as a deep image, the image read, and written again.
    check(ds_convert(path.c_str(), image.c_str(), NAN));
    const ds_deep *deep;
    check(ds_deep_read(image.c_str(), &deep));
    const Deep held(deep);
    ds_deep_view samples;
    check(ds_deep_describe(deep, &samples));
    std::printf("%zu samples, %u opacities each\n", samples.samples, samples.channels);
    check(ds_deep_write(again.c_str(), &samples));

    // What is wrong is told, and nothing is left behind.
    std::size_t errors;
    check(ds_map_verify(map.get(), &errors));
    if (errors != 0)
        return 1;
    const std::string none = folder + "/none.dsm";
    if (ds_bake_hits(bad_hits, nullptr, 0, &light, &settings, none.c_str(), nullptr) != DS_ERROR_SOURCE)
        return 1;
    settings.progress = at_once;
    if (ds_bake_hits(hits, &pane, 0, &light, &settings, none.c_str(), nullptr) != DS_ERROR_CANCELLED)
        return 1;
    settings.kind = "shiny";
    if (ds_bake_hits(hits, &pane, 0, &light, &settings, none.c_str(), nullptr) != DS_ERROR_SETTING)
        return 1;
    if (ds_map_shadow(nullptr, nullptr, &made) != DS_ERROR_SETTING)
        return 1;
    std::puts("ok");
    return 0;
}
