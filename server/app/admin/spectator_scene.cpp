#include "server/app/admin/spectator_scene.h"

#include "server/admin/spectator/spectator_hub.h"
#include "server/app/admin/shape_triangles.h"
#include "server/physics/soft/soft_bodies.h"
#include "shared/core/json.h"

#include <algorithm>
#include <array>
#include <functional>

namespace zoned::app {

namespace {

using admin::put_bytes;

constexpr std::size_t kBoxBytes = 40;
constexpr std::size_t kVertexBytes = 12;

enum class PieceKind : std::uint32_t {
    kBoxes = 1,
    kTypeTriangles = 2,
    kHeights = 3,
    kVertices = 4,
    kCorners = 5,
};

struct Piece {
    PieceKind kind = PieceKind::kBoxes;
    std::uint32_t owner = 0;
    std::uint32_t first = 0;
    std::uint32_t count = 0;
};

/// Cuts `all` items of so many bytes each into pieces.
void cut(PieceKind kind,
         std::uint32_t owner,
         std::size_t all,
         std::size_t bytes,
         std::vector<Piece>& out) {
    const std::size_t most = std::max<std::size_t>(1, kPieceBytes / bytes);
    for (std::size_t first = 0; first < all; first += most) {
        out.push_back({kind,
                       owner,
                       static_cast<std::uint32_t>(first),
                       static_cast<std::uint32_t>(std::min(most, all - first))});
    }
}

/// Pieces that are small and seen at once come first.
std::vector<Piece> pieces_of(const config::Settings& settings) {
    std::vector<Piece> out;
    cut(PieceKind::kBoxes, 0, settings.boxes.size(), kBoxBytes, out);
    for (std::uint32_t type = 0; type < settings.types.size(); ++type) {
        if (settings.types[type].shape == world::TypeShape::kSolid) {
            out.push_back({PieceKind::kTypeTriangles, type, 0, 0});
        }
    }
    for (std::uint32_t i = 0; i < settings.surfaces.size(); ++i) {
        const motion::Surface& surface = *settings.surfaces[i].surface;
        if (surface.is_grid()) {
            cut(PieceKind::kHeights,
                i,
                surface.grid().rows,
                sizeof(float) * surface.grid().columns,
                out);
        } else {
            cut(PieceKind::kVertices, i, surface.mesh().vertices.size(), kVertexBytes, out);
            cut(PieceKind::kCorners, i, surface.mesh().corners.size(), kVertexBytes, out);
        }
    }
    return out;
}

void put_vector(std::string& out, const Vec3& v) {
    for (int axis = 0; axis < 3; ++axis) {
        put_bytes(out, v[axis]);
    }
}

std::string content_of(const config::Settings& settings, Piece& piece) {
    std::string out;
    const std::size_t end = piece.first + piece.count;
    switch (piece.kind) {
        case PieceKind::kBoxes:
            for (std::size_t i = piece.first; i < end; ++i) {
                put_vector(out, settings.boxes[i].centre);
                put_vector(out, settings.boxes[i].half_extents);
                for (const float part : settings.boxes[i].orientation.coeffs()) {
                    put_bytes(out, part);
                }
            }
            break;
        case PieceKind::kTypeTriangles: {
            const auto corners = triangles_of(settings.solids[settings.types[piece.owner].solid]);
            for (const Vec3& corner : corners) {
                put_vector(out, corner);
            }
            piece.count = static_cast<std::uint32_t>(corners.size() / 3);
            break;
        }
        case PieceKind::kHeights: {
            const motion::HeightGrid& grid = settings.surfaces[piece.owner].surface->grid();
            const auto rows =
                grid.heights.subspan(static_cast<std::size_t>(piece.first) * grid.columns,
                                     static_cast<std::size_t>(piece.count) * grid.columns);
            out.assign(reinterpret_cast<const char*>(rows.data()), rows.size_bytes());
            break;
        }
        case PieceKind::kVertices: {
            const auto& mesh = settings.surfaces[piece.owner].surface->mesh();
            for (std::size_t i = piece.first; i < end; ++i) {
                put_vector(out, mesh.vertices[i]);
            }
            break;
        }
        case PieceKind::kCorners: {
            const auto& mesh = settings.surfaces[piece.owner].surface->mesh();
            for (std::size_t i = piece.first; i < end; ++i) {
                put_bytes(out, mesh.corners[i]);
            }
            break;
        }
    }
    return out;
}

template <class Values>
void numbers(core::JsonWriter& json, const char* name, const Values& values) {
    json.key(name).begin_array();
    for (const auto value : values) {
        json.value(static_cast<double>(value));
    }
    json.end_array();
}

/// Half sizes of a box; of a round shape radius, half of its segment, radius; of others those of
/// their box.
void write_type(core::JsonWriter& json,
                const world::EntityType& type,
                const std::function<void()>& write_more = {}) {
    Vec3 size = type.half_extents;
    const char* shape = "box";
    switch (type.shape) {
        case world::TypeShape::kSphere:
            size = Vec3(type.radius, 0.0F, type.radius);
            shape = "round";
            break;
        case world::TypeShape::kCapsule:
            size = Vec3(type.radius, type.half_segment, type.radius);
            shape = "round";
            break;
        case world::TypeShape::kSolid:
            size = 0.5F * (type.standing.upper - type.standing.lower);
            shape = "solid";
            break;
        case world::TypeShape::kBox:
            break;
        case world::TypeShape::kSoft:
            shape = "soft";
            break;
    }
    json.begin_object()
        .field("name", type.name)
        .field("shape", shape)
        .field("character", type.kind == world::EntityKind::kCharacter);
    numbers(json, "size", size);
    if (write_more) {
        write_more();
    }
    json.end_object();
}

/// The surface of a soft type as it is drawn undeformed, three numbers for each place and each
/// face; a rope's faces are segments whose last two corners are one.
void write_soft_surface(core::JsonWriter& json,
                        const config::Settings& settings,
                        const world::EntityType& type) {
    physics::soft::SoftSettings any;
    any.step_s = static_cast<float>(1.0 / settings.tick_rate_hz);
    physics::soft::SoftBodies bodies(any);
    const auto body = bodies.add(*settings.softs[type.solid]);
    if (!body) {
        return;
    }
    std::vector<Vec3> places(bodies.vertex_count(*body));
    bodies.vertices(*body, places);
    json.key("surface").begin_object().key("places").begin_array();
    for (const Vec3& place : places) {
        for (const float coordinate : place) {
            json.value(static_cast<double>(coordinate));
        }
    }
    json.end_array().key("faces").begin_array();
    for (const physics::soft::SoftFace& face : bodies.drawn_faces(*body)) {
        for (const std::uint32_t corner : face) {
            json.value(corner);
        }
    }
    json.end_array().end_object();
}

void write_box(core::JsonWriter& json, const motion::StaticBox& box) {
    numbers(json, "p", box.centre);
    numbers(json, "size", box.half_extents);
    numbers(json, "q", box.orientation.coeffs());
}

void write_doors(core::JsonWriter& json, const config::Settings& settings) {
    json.key("doors").begin_array();
    for (const config::NamedDoor& named : settings.doors) {
        const motion::Timetable& times = named.door.times;
        json.begin_object().field("name", named.name);
        write_box(json, named.door.box);
        json.field("period_ticks", times.period)
            .field("shift_ticks", times.shift)
            .field("by_rules", named.door.by_rules.has_value());
        json.key("open").begin_array();
        for (const auto& span : times.open) {
            json.begin_array().value(span.from).value(span.to).end_array();
        }
        json.end_array().end_object();
    }
    json.end_array();
}

void write_platforms(core::JsonWriter& json, const config::Settings& settings) {
    json.key("platforms").begin_array();
    for (const config::NamedPlatform& named : settings.platforms) {
        const motion::PlatformPath& path = named.platform.path;
        json.begin_object().field("name", named.name);
        write_box(json, named.platform.box);
        json.field("back_ticks", path.back)
            .field("wait_ticks", path.wait)
            .field("shift_ticks", path.shift)
            .field("by_rules", path.by_rules.has_value())
            .field("start_ticks", path.start);
        json.key("stops").begin_array();
        for (const motion::PlatformStop& stop : path.stops) {
            json.begin_object().field("ticks", stop.at);
            numbers(json, "offset", stop.offset);
            json.end_object();
        }
        json.end_array().end_object();
    }
    json.end_array();
}

void write_surfaces(core::JsonWriter& json, const config::Settings& settings) {
    json.key("surfaces").begin_array();
    for (const config::SurfaceSettings& from : settings.surfaces) {
        json.begin_object();
        numbers(json, "p", from.position);
        numbers(json, "q", from.orientation.coeffs());
        if (from.surface->is_grid()) {
            const motion::HeightGrid& grid = from.surface->grid();
            json.field("columns", grid.columns)
                .field("rows", grid.rows)
                .field("spacing_x_m", static_cast<double>(grid.spacing_x))
                .field("spacing_z_m", static_cast<double>(grid.spacing_z));
        } else {
            json.field("vertices", from.surface->mesh().vertices.size())
                .field("triangles", from.surface->mesh().corners.size());
        }
        json.end_object();
    }
    json.end_array();
}

}  // namespace

std::string play_json(const config::Settings& settings,
                      std::uint16_t websocket_port,
                      bool websocket_tls) {
    core::JsonWriter json;
    json.begin_object()
        .field("world", settings.world_name)
        .field("development", settings.server.session.dev_mode_loopback)
        .field("ground_height_m", static_cast<double>(settings.ground_height_m))
        .field("websocket_port", websocket_port)
        .field("websocket_tls", websocket_tls);
    json.key("types").begin_array();
    for (const world::EntityType& type : settings.types) {
        write_type(json, type, [&] {
            if (type.deformation != nullptr) {
                write_soft_surface(json, settings, type);
            }
        });
    }
    json.end_array().end_object();
    return json.text();
}

std::string scene_json(const config::Settings& settings, Tick recorded) {
    core::JsonWriter json;
    json.begin_object()
        .field("world", settings.world_name)
        .field("digest", settings.digest)
        .field("tick_rate_hz", settings.tick_rate_hz)
        .field("development", settings.server.session.dev_mode_loopback)
        .field("recorded_ticks", recorded)
        .field("ground_height_m", static_cast<double>(settings.ground_height_m))
        .field("pieces", pieces_of(settings).size());
    json.key("types").begin_array();
    for (const world::EntityType& type : settings.types) {
        write_type(json, type);
    }
    json.end_array().key("zones").begin_array();
    for (const config::ZoneRegion& zone : settings.zones) {
        json.begin_object()
            .field("name", zone.name)
            .field("min_x", zone.min_x)
            .field("min_z", zone.min_z)
            .field("max_x", zone.max_x)
            .field("max_z", zone.max_z)
            .end_object();
    }
    json.end_array();
    json.field("ghost_margin_m", static_cast<double>(settings.ghost_margin_m));
    write_doors(json, settings);
    write_platforms(json, settings);
    write_surfaces(json, settings);
    json.end_object();
    return json.text();
}

std::string scene_piece(const config::Settings& settings, std::uint32_t number) {
    std::vector<Piece> pieces = pieces_of(settings);
    if (number == 0 || number > pieces.size()) {
        return {};
    }
    Piece& piece = pieces[number - 1];
    const std::string content = content_of(settings, piece);
    std::string out;
    out.reserve(16 + content.size());
    put_bytes(out, piece.kind);
    put_bytes(out, piece.owner);
    put_bytes(out, piece.first);
    put_bytes(out, piece.count);
    return out + content;
}

}  // namespace zoned::app
