#include "server/config/types/soft_mesh.h"

#include "server/assets/geometry_files.h"
#include "server/config/text/config_numbers.h"
#include "server/config/text/sha256.h"
#include "server/physics/soft/builders/mesh_builder.h"
#include "proto/config/config.pb.h"

#include <utility>

namespace zoned::config {

namespace {

physics::soft::MeshBodyDef mesh_def(const proto::config::Type& type) {
    const auto& from = type.soft().mesh();
    physics::soft::MeshBodyDef def;
    def.weld = narrow(from.weld_m());
    def.mass = narrow(type.mass_kg());
    def.stiffness = narrow(from.stiffness_npm());
    def.bend_stiffness = narrow(from.bend_stiffness_npm());
    def.damping_share = narrow(type.soft().damping());
    def.gas_pressure = narrow(from.gas_pressure_pa());
    def.nodes = static_cast<int>(from.nodes());
    for (const auto& pin : from.pin()) {
        def.pins.push_back({Vec3(narrow(pin.x_m()), narrow(pin.y_m()), narrow(pin.z_m())),
                            narrow(pin.radius_m())});
    }
    return def;
}

}  // namespace

core::Result<physics::soft::SoftDef> mesh_body_of(const proto::config::Type& type) {
    using Made = core::Result<physics::soft::SoftDef>;
    const auto& from = type.soft().mesh();
    if (from.file().empty()) {
        return Made::failure("a mesh needs a file");
    }
    const auto bytes = assets::read_geometry_file(from.file());
    if (!bytes) {
        return Made::failure(bytes.error());
    }
    if (from.has_sha256() && sha256_hex(*bytes) != from.sha256()) {
        return Made::failure(from.file() +
                             " has another content than is asked for: its SHA-256 is " +
                             sha256_hex(*bytes) + ", not " + from.sha256());
    }
    if (assets::content_of(*bytes) != assets::GeometryContent::kText) {
        return Made::failure(from.file() + ": is no OBJ text");
    }
    auto scan = assets::good_obj(*bytes);
    if (!scan) {
        return Made::failure(from.file() + ": " + scan.error());
    }
    auto vertices = assets::scaled_vertices(*scan, narrow(from.scale()));
    if (!vertices) {
        return Made::failure(from.file() + ": " + vertices.error());
    }
    physics::soft::MeshBodyDef def = mesh_def(type);
    def.vertices = std::move(*vertices);
    def.indices = std::move(scan->indices);
    def.lines = std::move(scan->triangle_lines);
    auto built = physics::soft::build_mesh_body(def);
    return built ? std::move(built) : Made::failure(from.file() + ": " + built.error());
}

void note_soft_meshes(proto::config::Config& config) {
    for (auto& type : *config.mutable_type()) {
        if (type.soft().mesh().file().empty() || type.soft().mesh().has_sha256()) {
            continue;
        }
        if (const auto bytes = assets::read_geometry_file(type.soft().mesh().file())) {
            type.mutable_soft()->mutable_mesh()->set_sha256(sha256_hex(*bytes));
        }
    }
}

}  // namespace zoned::config
