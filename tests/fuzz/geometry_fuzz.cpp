// Fuzzing of geometry files: any bytes are refused with a reason or give a surface that can be
// used.
#include "server/assets/baked_geometry.h"
#include "server/assets/geometry_files.h"
#include "server/assets/geometry_survey.h"
#include "server/physics/scene/scene.h"
#include "tests/fuzz/fuzz.h"
#include "tests/unit/assets/geometry_samples.h"

#include <cstring>

namespace zoned::fuzz {

namespace {

using physics::Shape;

constexpr std::size_t kMaxBytes = 65536;
constexpr std::uint32_t kMaxTriangles = 20000;  // a short image may be a large field

Bytes bytes_of(std::string_view text) {
    return {text.begin(), text.end()};
}

physics::FieldOptions field_options() {
    physics::FieldOptions options;
    options.spacing_x = options.spacing_z = 0.5F;
    return options;
}

/// Whether a file of any kind can be read; false after a reason was given.
bool read(std::string_view bytes, Shape& out) {
    const auto take = [&](auto result, auto shape_of) {
        if (result) {
            out = shape_of(*result);
            return true;
        }
        ZONED_ASSERT(!result.error().empty(), "a refusal has a reason");
        return false;
    };
    switch (assets::content_of(bytes)) {
        case assets::GeometryContent::kBaked:
            return take(assets::read_baked(bytes), [](const Shape& shape) { return shape; });
        case assets::GeometryContent::kPng:
            return take(assets::heightfield_from_png(
                            std::as_bytes(std::span(bytes)), 3.0F, field_options()),
                        Shape::heightfield);
        case assets::GeometryContent::kText:
            return take(assets::mesh_from_obj(bytes, 1.0F, {}),
                        [](const physics::BuiltMesh& built) { return Shape::mesh(built.mesh); });
        case assets::GeometryContent::kUnknown:
            break;
    }
    return false;
}

/// Rays and a falling body: every value that comes out of the surface must be a number.
void use(const Shape& shape) {
    physics::Scene scene{physics::PhysicsSettings{}};
    physics::BodyDef ground;
    ground.kind = physics::BodyKind::kStatic;
    ground.shape = shape;
    ZONED_ASSERT(scene.add(ground).ok(), "a surface that was read is a valid body");
    physics::BodyDef ball;
    ball.position = Vec3(0.1F, 1.0F, 0.2F);
    const auto body = scene.add(ball);
    for (int step = 0; step < 4; ++step) {
        scene.step(1.0F / 60.0F);
    }
    ZONED_ASSERT(scene.state(*body).position.allFinite(), "a body stays where numbers are");
    for (const Vec3& d : {Vec3(0, -1, 0), Vec3(0.6F, -0.8F, 0), Vec3(-0.6F, 0, 0.8F)}) {
        physics::RayHit hit;
        if (scene.ray_cast(Vec3(0.1F, 2.0F, 0.1F) - d, d, 100.0F, 0, hit)) {
            ZONED_ASSERT(hit.distance >= 0.0F && hit.distance <= 100.0F, "a hit lies on the ray");
        }
    }
}

bool is_small(const Shape& shape) {
    if (shape.kind == physics::ShapeKind::kMesh) {
        return physics::mesh_of(shape).triangle_count() <= kMaxTriangles;
    }
    const auto& t = physics::field_of(shape).tables();
    return t.heights.size() <= kMaxTriangles;
}

void run(std::string_view bytes) {
    Shape shape;
    if (!read(bytes, shape) || !is_small(shape)) {
        return;
    }
    use(shape);
    const auto again = assets::read_baked(assets::bake(shape));
    ZONED_ASSERT(again.ok() && assets::difference_of(shape, *again).empty(),
                 "what was read can be baked and read back");
    if (shape.kind == physics::ShapeKind::kMesh) {
        assets::survey(physics::mesh_of(shape), 0.005F);
    } else {
        assets::survey(physics::field_of(shape));
    }
}

}  // namespace

std::vector<Bytes> seeds() {
    const std::string obj = assets::test::waves_obj(3, 4.0);
    const std::string odd =
        "# odd\no a\nv 0 0 0 1\nv 1 0 0\nv 1 0 -1\nv 0 .5 -1e0\nv 0.5 0 -2\nvt 0 0\nvn 0 1 0\n"
        "f 1/1/1 2//1 3 4\nf -5 -4 -3 -2 -1\ng b\nl 1 2\np 3\nf 1 2 2\n";
    std::vector<std::uint16_t> pixels;
    for (std::uint32_t i = 0; i < 9 * 7; ++i) {
        pixels.push_back(static_cast<std::uint16_t>(i * i * 16));
    }
    const auto png = assets::test::png_of(9, 7, PNG_FORMAT_LINEAR_Y, pixels.data());
    const std::string_view image(reinterpret_cast<const char*>(png.data()), png.size());
    std::vector<Bytes> all = {bytes_of(obj), bytes_of(odd), bytes_of(image)};
    for (const std::string_view source : {std::string_view(obj), image}) {
        Shape shape;
        ZONED_ASSERT(read(source, shape), "the seeds are good");
        all.push_back(bytes_of(assets::bake(shape)));
    }
    return all;
}

}  // namespace zoned::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace zoned;
    std::string bytes(reinterpret_cast<const char*>(data), std::min(size, fuzz::kMaxBytes));
    fuzz::run(bytes);
    // Beyond the checksum there is more to find: makes length and checksum fit.
    if (assets::is_baked(bytes) && bytes.size() >= assets::kBakedBodyAt) {
        const std::uint64_t body = bytes.size() - assets::kBakedBodyAt;
        std::memcpy(bytes.data() + 16, &body, sizeof(body));
        assets::seal_baked(bytes);
        fuzz::run(bytes);
    }
    return 0;
}
