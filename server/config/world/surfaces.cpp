#include "server/config/world/surfaces.h"

#include "server/assets/baked_geometry.h"
#include "server/assets/geometry_files.h"
#include "server/config/settings.h"
#include "server/config/text/config_numbers.h"
#include "server/config/text/sha256.h"
#include "server/config/world/world_description.h"
#include "server/physics/shapes/compound/body_checks.h"
#include "proto/config/config.pb.h"

#include <cmath>
#include <map>
#include <span>
#include <tuple>
#include <utility>

namespace zoned::config {

namespace {

using SurfaceConfig = proto::config::Surface;

/// The content of a file with its options, shared by all its placements.
struct LoadedSurface {
    std::string sha256;
    std::string content;
    physics::Shape shape;
    std::shared_ptr<const motion::Surface> surface;
    float level_m = 0.0F;
    std::size_t replicated_bytes = 0;
};

/// A mistake, and the field of the surface that it is about.
struct SurfaceMistake {
    std::string field;
    std::string text;
};

using SurfaceMistakes = std::vector<SurfaceMistake>;

/// Options that the content of the file does not use, or that are missing.
SurfaceMistakes misplaced(const SurfaceConfig& s, assets::GeometryContent content) {
    const bool text = content == assets::GeometryContent::kText;
    const bool png = content == assets::GeometryContent::kPng;
    const std::tuple<bool, const char*, const char*> options[] = {
        {s.has_scale() && !text, "scale", "belongs to OBJ files"},
        {s.has_weld_m() && !text, "weld_m", "belongs to OBJ files"},
        {s.has_height_m() && !png, "height_m", "belongs to PNG images"},
        {s.has_spacing_m() && !png, "spacing_m", "belongs to PNG images"},
        {s.has_offset_m() && !png, "offset_m", "belongs to PNG images"},
        {s.has_thickness_m() && !png, "thickness_m", "belongs to PNG images"},
        {!s.has_height_m() && png, "", "an image does not say how high white is: set height_m"},
    };
    SurfaceMistakes out;
    for (const auto& [wrong, field, why] : options) {
        if (wrong) {
            const char* is = content == assets::GeometryContent::kBaked
                                 ? ", and this is a baked file"
                             : png ? ", and this is a PNG"
                                   : ", and this is text";
            out.push_back({field, why + std::string(*field != '\0' ? is : "")});
        }
    }
    return out;
}

core::Result<physics::Shape> shape_of_obj(const SurfaceConfig& s, const std::string& bytes) {
    using Made = core::Result<physics::Shape>;
    const auto scan = assets::good_obj(bytes);
    if (!scan) {
        return Made::failure(scan.error());
    }
    const auto built = assets::mesh_from_scanned(*scan, narrow(s.scale()), {narrow(s.weld_m())});
    return built ? Made(physics::Shape::mesh(built->mesh)) : Made::failure(built.error());
}

core::Result<physics::Shape> shape_of_png(const SurfaceConfig& s, const std::string& bytes) {
    using Made = core::Result<physics::Shape>;
    physics::FieldOptions options;
    options.spacing_x = options.spacing_z = narrow(s.spacing_m());
    options.offset = narrow(s.offset_m());
    options.thickness = narrow(s.thickness_m());
    auto field = assets::heightfield_from_png(
        std::as_bytes(std::span(bytes)), narrow(s.height_m()), options);
    return field ? Made(physics::Shape::heightfield(std::move(*field)))
                 : Made::failure(field.error());
}

core::Result<physics::Shape> shape_of(const SurfaceConfig& s,
                                      assets::GeometryContent content,
                                      const std::string& bytes) {
    switch (content) {
        case assets::GeometryContent::kPng:
            return shape_of_png(s, bytes);
        case assets::GeometryContent::kBaked:
            return assets::read_baked(bytes);
        case assets::GeometryContent::kText:
            return shape_of_obj(s, bytes);
        case assets::GeometryContent::kUnknown:
            break;
    }
    return core::Result<physics::Shape>::failure("is no PNG image, no OBJ text and no baked file");
}

/// The surface for characters: it refers to the same tables with which bodies collide.
std::shared_ptr<const motion::Surface> surface_over(const physics::Shape& shape) {
    if (shape.kind == physics::ShapeKind::kHeightfield) {
        const physics::Heightfield::HeightfieldTables& t = physics::field_of(shape).tables();
        const motion::HeightGrid grid{
            t.columns, t.rows, t.spacing_x, t.spacing_z, t.thickness, t.heights};
        return std::make_shared<const motion::Surface>(grid, shape.geometry);
    }
    const physics::TriangleMesh::MeshTables& t = physics::mesh_of(shape).tables();
    return std::make_shared<const motion::Surface>(motion::TriangleList{t.vertices, t.corners},
                                                   shape.geometry);
}

LoadedSurface load(const SurfaceConfig& s, SurfaceMistakes& mistakes) {
    LoadedSurface out;
    const auto bytes = assets::read_geometry_file(s.file());
    if (!bytes) {
        mistakes.push_back({"file", bytes.error()});
        return out;
    }
    out.sha256 = sha256_hex(*bytes);
    const assets::GeometryContent content = assets::content_of(*bytes);
    if (content != assets::GeometryContent::kUnknown) {
        mistakes = misplaced(s, content);
    }
    auto shape = shape_of(s, content, *bytes);
    if (!shape) {
        mistakes.push_back({"file", s.file() + ": " + shape.error()});
    }
    if (!mistakes.empty()) {
        return out;
    }
    out.shape = std::move(*shape);
    out.content = sha256_hex(assets::bake(out.shape));
    out.surface = surface_over(out.shape);
    if (content == assets::GeometryContent::kPng) {
        out.level_m = narrow(std::abs(s.height_m())) /
                      static_cast<float>((1U << assets::png_bits(*bytes)) - 1U);
    }
    proto::StaticSurface message;
    describe_geometry(*out.surface, message);
    out.replicated_bytes = message.ByteSizeLong();
    return out;
}

SurfaceSettings place(const SurfaceConfig& s,
                      const LoadedSurface& loaded,
                      const std::string& path) {
    SurfaceSettings out;
    out.path = path;
    out.file = s.file();
    out.content = loaded.content;
    out.shape = loaded.shape;
    out.surface = loaded.surface;
    out.level_m = loaded.level_m;
    out.position = Vec3d(s.x_m(), s.y_m(), s.z_m());
    out.orientation = narrow(turn(s.yaw_deg(), Vec3d::UnitY()));
    out.friction = narrow(s.friction());
    out.restitution = narrow(s.restitution());
    out.replicated = s.replicated();
    return out;
}

/// Checks the position of a surface.
void check_place(const SurfaceSettings& surface,
                 const proto::config::Config& config,
                 Diagnostics& diagnostics) {
    const motion::PlacedSurface placed(surface.around(Vec3d::Zero()));
    const Vec3d lower = placed.bounds().lower.cast<double>();
    const Vec3d upper = placed.bounds().upper.cast<double>();
    const auto& world = config.world();
    if (upper.x() < world.min_x_m() || lower.x() > world.max_x_m() || upper.z() < world.min_z_m() ||
        lower.z() > world.max_z_m()) {
        diagnostics.add(surface.path, "lies outside the world");
    }
    const double most = config.replication().quantization().vertical_extent_m();
    if (upper.y() > most) {
        diagnostics.add(surface.path,
                        "reaches " + std::to_string(static_cast<long>(upper.y())) +
                            " m up, higher than states can tell: "
                            "replication.quantization.vertical_extent_m is " +
                            std::to_string(static_cast<long>(most)));
    }
    physics::BodyDef def;
    def.kind = physics::BodyKind::kStatic;
    def.shape = surface.shape;
    def.position = surface.position.cast<float>();
    def.orientation = surface.orientation;
    if (const std::string why = physics::why_unfit(def); !why.empty()) {
        diagnostics.add(surface.path, why);
    }
}

/// Loads each file with the same options once.
class SurfaceLoader {
  public:
    explicit SurfaceLoader(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

    /// Null after it has reported a mistake.
    const LoadedSurface* get(SurfaceConfig& s, const std::string& path) {
        if (s.file().empty()) {
            diagnostics_.add(path, "a surface needs a file");
            return nullptr;
        }
        SurfaceConfig key;  // what the geometry depends on
        key.CopyFrom(s);
        for (const char* place :
             {"x_m", "y_m", "z_m", "yaw_deg", "friction", "restitution", "replicated", "sha256"}) {
            key.GetReflection()->ClearField(&key, key.GetDescriptor()->FindFieldByName(place));
        }
        const auto [at, is_new] = loaded_.try_emplace(key.ShortDebugString());
        if (is_new) {
            at->second.first = load(s, at->second.second);
        }
        const auto& [loaded, mistakes] = at->second;
        for (const SurfaceMistake& mistake : mistakes) {
            diagnostics_.add(mistake.field.empty() ? path : path + "." + mistake.field,
                             mistake.text);
        }
        const bool same = loaded.sha256.empty() || !s.has_sha256() || s.sha256() == loaded.sha256;
        if (!same) {
            diagnostics_.add(path + ".sha256",
                             s.file() + " has another content than is asked for: its SHA-256 is " +
                                 loaded.sha256 + ", not " + s.sha256());
        }
        if (!mistakes.empty() || !same) {
            return nullptr;
        }
        s.set_sha256(loaded.sha256);
        return &loaded;
    }

  private:
    std::map<std::string, std::pair<LoadedSurface, SurfaceMistakes>> loaded_;
    Diagnostics& diagnostics_;
};

}  // namespace

std::vector<SurfaceSettings> load_surfaces(proto::config::Config& config,
                                           Diagnostics& diagnostics) {
    std::vector<SurfaceSettings> out;
    SurfaceLoader loader(diagnostics);
    std::size_t replicated = 0;
    for (int i = 0; i < config.statics().surface_size(); ++i) {
        const std::string path = join_path("statics", "surface", i);
        SurfaceConfig& s = *config.mutable_statics()->mutable_surface(i);
        const LoadedSurface* loaded = loader.get(s, path);
        if (loaded == nullptr) {
            continue;
        }
        out.push_back(place(s, *loaded, path));
        check_place(out.back(), config, diagnostics);
        const std::size_t before = replicated;
        replicated += s.replicated() ? loaded->replicated_bytes : 0;
        if (replicated > kMaxReplicatedBytes && before <= kMaxReplicatedBytes) {
            diagnostics.add(path,
                            "with this, each client would be told " + std::to_string(replicated) +
                                " bytes of surfaces at login, more than " +
                                std::to_string(kMaxReplicatedBytes) +
                                ": make it coarser, or set replicated: false");
        }
    }
    return out;
}

}  // namespace zoned::config
