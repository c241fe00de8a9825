// Makes the volumes beside it, and what OpenVDB's own sampler reads in them.
//
//     c++ -std=c++17 -O1 make.cpp -lopenvdb -ltbb /usr/lib/*/libImath-3_1.so.29 -o make && ./make
//
// Made with OpenVDB 10.0.1. Each line of values.csv: file, grid as the program
// chooses it, a point of the world, the value there.

#include <openvdb/openvdb.h>
#include <openvdb/tools/ValueTransformer.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <iomanip>
#include <string>
#include <vector>

using namespace openvdb;

static std::ofstream table("values.csv");
static uint32_t seed = 1;

static double chance() {
    seed = seed * 1664525u + 1013904223u;
    return seed / 4294967296.0;
}

template <class Grid>
void sample(const std::string& file, const std::string& choice, const Grid& grid, int beyond) {
    CoordBBox box = grid.evalActiveVoxelBoundingBox();
    box.expand(beyond);
    for (int i = 0; i < 24; ++i) {
        Vec3d at;
        for (int axis = 0; axis < 3; ++axis) {
            at[axis] = box.min()[axis] + chance() * (box.max()[axis] - box.min()[axis]);
        }
        const Vec3d world = grid.transform().indexToWorld(at);
        double sum = 0;  // trilinear in f64, so that every type of value is treated alike
        const Coord base(int(std::floor(at[0])), int(std::floor(at[1])), int(std::floor(at[2])));
        for (int corner = 0; corner < 8; ++corner) {
            const Coord step(corner & 1, corner >> 1 & 1, corner >> 2);
            double weight = 1;
            for (int axis = 0; axis < 3; ++axis) {
                const double part = at[axis] - base[axis];
                weight *= step[axis] ? part : 1 - part;
            }
            sum += weight * double(grid.tree().getValue(base + step));
        }
        table << std::setprecision(17) << file << ',' << choice << ',' << world[0] << ','
              << world[1] << ',' << world[2] << ',' << sum << '\n';
    }
}

template <class Grid>
typename Grid::Ptr blobs(typename Grid::ValueType background = zeroVal<typename Grid::ValueType>()) {
    auto grid = Grid::create(background);
    auto access = grid->getAccessor();
    for (int x = -3; x < 12; ++x)
        for (int y = 30; y < 41; ++y)
            for (int z = -9; z < 4; ++z)
                if ((x * 7 + y * 5 + z * 3) % 4 != 0) {
                    const double value = 0.25 + ((x + 2 * y + 3 * z) & 15) / 8.0;
                    access.setValue(Coord(x, y, z), typename Grid::ValueType(value));
                }
    grid->setName("density");
    grid->setGridClass(GRID_FOG_VOLUME);
    return grid;
}

static void save(const std::string& file, const GridPtrVec& grids, uint32_t flags) {
    io::File out(file);
    out.setCompression(flags);
    out.write(grids);
}

int main() {
    initialize();
    const uint32_t usual = io::COMPRESS_BLOSC | io::COMPRESS_ACTIVE_MASK;
    const uint32_t zip = io::COMPRESS_ZIP | io::COMPRESS_ACTIVE_MASK;
    const std::vector<std::pair<std::string, uint32_t>> ways = {
        {"none", 0}, {"mask", io::COMPRESS_ACTIVE_MASK}, {"zip", zip}, {"blosc", usual}};
    for (const auto& way : ways) {
        for (bool half : {false, true}) {
            if (way.second == 0 && !half) continue;  // large, and nothing new
            auto grid = blobs<FloatGrid>();
            grid->setTransform(math::Transform::createLinearTransform(0.5));
            grid->setSaveFloatAsHalf(half);
            const std::string file = way.first + (half ? "_half.vdb" : "_float.vdb");
            save(file, {grid}, way.second);
            sample(file, "", *grid, 1);
        }
    }
    {
        auto grid = blobs<DoubleGrid>();
        save("double.vdb", {grid}, usual);
        sample("double.vdb", "", *grid, 1);
        auto half = blobs<DoubleGrid>();
        half->setSaveFloatAsHalf(true);
        save("double_half.vdb", {half}, usual);
        sample("double_half.vdb", "", *half, 1);
        auto whole = blobs<Int32Grid>();
        save("int32.vdb", {whole}, usual);
        sample("int32.vdb", "", *whole, 1);
        auto yes = blobs<BoolGrid>();
        save("bool.vdb", {yes}, usual);
        sample("bool.vdb", "", *yes, 1);
        auto mask = MaskGrid::create();
        mask->topologyUnion(*blobs<FloatGrid>());
        mask->setName("density");
        save("mask.vdb", {mask}, usual);
        sample("mask.vdb", "", *mask, 1);
    }
    // Places: every affine map.
    const auto placed = [&](const std::string& file, const math::Transform::Ptr& transform) {
        auto grid = blobs<FloatGrid>();
        grid->setTransform(transform);
        save(file, {grid}, usual);
        sample(file, "", *grid, 1);
    };
    placed("scale.vdb", math::Transform::Ptr(new math::Transform(
                            math::MapBase::Ptr(new math::ScaleMap(Vec3d(0.5, -2.0, 0.25))))));
    placed("translate.vdb", math::Transform::Ptr(new math::Transform(
                                math::MapBase::Ptr(new math::TranslationMap(Vec3d(10, 20, -30))))));
    placed("scale_translate.vdb",
           math::Transform::Ptr(new math::Transform(math::MapBase::Ptr(
               new math::ScaleTranslateMap(Vec3d(0.5, 2.0, 0.25), Vec3d(1, -2, 3))))));
    {
        auto turned = math::Transform::createLinearTransform(0.1);
        turned->postRotate(0.7, math::X_AXIS);
        turned->postRotate(-0.4, math::Z_AXIS);
        turned->postTranslate(Vec3d(5, 6, 7));
        placed("rotated.vdb", turned);
        auto sheared = math::Transform::createLinearTransform(0.1);
        sheared->postShear(0.5, math::X_AXIS, math::Y_AXIS);
        sheared->postRotate(0.3, math::Y_AXIS);
        placed("sheared.vdb", sheared);
        placed("unitary.vdb", math::Transform::Ptr(new math::Transform(
                                  math::MapBase::Ptr(new math::UnitaryMap(math::X_AXIS, 0.9)))));
    }
    // What isn't active, and what is in tiles.
    {
        auto grid = blobs<FloatGrid>();
        auto access = grid->getAccessor();
        for (int z = -8; z < 3; ++z) {
            access.setValueOff(Coord(2, 33, z), 0.75f);
            access.setValueOff(Coord(3, 33, z), z & 1 ? 0.75f : 1.25f);
        }
        grid->tree().addTile(1, Coord(16, 40, 0), 1.5f, true);
        grid->tree().addTile(1, Coord(0, 40, 0), 0.5f, false);
        save("inactive.vdb", {grid}, usual);
        sample("inactive.vdb", "", *grid, 0);
        auto fog = blobs<FloatGrid>(0.125f);
        save("background.vdb", {fog}, usual);
        sample("background.vdb", "", *fog, 1);
        auto raw = blobs<FloatGrid>(0.125f);
        raw->setSaveFloatAsHalf(true);
        save("background_half.vdb", {raw}, zip);
        sample("background_half.vdb", "", *raw, 1);
        auto negative = blobs<FloatGrid>(-0.5f);
        auto edit = negative->getAccessor();
        for (int z = -8; z < 3; ++z) edit.setValueOff(Coord(2, 33, z), 0.5f);
        save("negative_background.vdb", {negative}, io::COMPRESS_ACTIVE_MASK);
    }
    // Several grids.
    {
        auto first = blobs<FloatGrid>(), second = blobs<FloatGrid>(), flame = blobs<FloatGrid>();
        tools::foreach (second->beginValueOn(), [](const FloatGrid::ValueOnIter& it) {
            it.setValue(*it * 2);
        });
        flame->setName("flame");
        auto instance = FloatGrid::create(flame->treePtr());  // the same tree, elsewhere
        instance->setName("again");
        instance->setTransform(math::Transform::createLinearTransform(2.0));
        auto surface = blobs<FloatGrid>();
        surface->setName("surface");
        surface->setGridClass(GRID_LEVEL_SET);
        auto velocity = Vec3SGrid::create();
        velocity->setName("velocity");
        save("several.vdb", {first, flame, second, instance, surface, velocity}, usual);
        sample("several.vdb", "density:0", *first, 1);
        sample("several.vdb", "density:1", *second, 1);
        sample("several.vdb", "flame", *flame, 1);
        sample("several.vdb", "again", *instance, 1);
        auto frustum = blobs<FloatGrid>();
        frustum->setTransform(math::Transform::createFrustumTransform(
            BBoxd(Vec3d(0), Vec3d(100)), 0.5, 10.0, 0.1));
        save("frustum.vdb", {frustum}, usual);
    }
    return 0;
}
