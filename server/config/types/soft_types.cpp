#include "server/config/types/soft_types.h"

#include "server/config/text/check_name.h"
#include "server/config/text/config_numbers.h"
#include "server/config/types/deformation_config.h"
#include "server/config/types/soft_mesh.h"
#include "server/physics/soft/builders/builders.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <cmath>

namespace zoned::config {

namespace {

namespace soft = physics::soft;

using Soft = proto::config::Soft;
using SoftResult = core::Result<soft::SoftDef>;

static_assert(static_cast<int>(soft::SoftMethod::kXpbd) == Soft::XPBD);
static_assert(static_cast<int>(soft::SoftMethod::kImplicitEuler) == Soft::IMPLICIT_EULER);
static_assert(static_cast<int>(soft::SoftMethod::kSemiImplicitEuler) == Soft::SEMI_IMPLICIT_EULER);

int count_of(std::uint32_t value) {
    return static_cast<int>(value);
}

SoftResult cloth_of(const proto::config::Type& type) {
    const auto& from = type.soft().cloth();
    soft::ClothDef def;
    def.size_x = narrow(from.width_m());
    def.size_z = narrow(from.height_m());
    def.nx = count_of(from.columns());
    def.nz = count_of(from.rows());
    def.density = narrow(type.mass_kg() / (from.width_m() * from.height_m()));
    def.stiffness = narrow(from.stiffness_npm());
    def.shear_stiffness = narrow(from.shear_stiffness_npm());
    def.bend_stiffness = narrow(from.bend_stiffness_npm());
    def.damping_share = narrow(type.soft().damping());
    def.coarsen = count_of(from.coarsen());
    for (int p = 0; p < from.pin_size(); ++p) {
        const auto& pin = from.pin(p);
        if (pin.column() >= from.columns() || pin.row() >= from.rows()) {
            return SoftResult::failure("pin " + std::to_string(p + 1) +
                                       ": the cloth has no node there");
        }
        def.pins.push_back({count_of(pin.column()), count_of(pin.row())});
    }
    SoftResult out = soft::build_cloth(def);
    if (out && !from.level()) {
        for (soft::SoftNode& node : out->nodes) {
            node.position = Vec3(node.position.x(), -node.position.z(), 0.0F);
        }
    }
    return out;
}

SoftResult rope_of(const proto::config::Type& type) {
    const auto& from = type.soft().rope();
    soft::RopeDef def;
    const Vec3 along = from.level() ? Vec3(Vec3::UnitX()) : Vec3(-Vec3::UnitY());
    def.to = narrow(from.length_m()) * along;
    def.nodes = count_of(from.nodes());
    def.mass = narrow(type.mass_kg());
    def.stiffness = narrow(from.stiffness_npm());
    def.bend_stiffness = narrow(from.bend_stiffness_npm());
    def.damping_share = narrow(type.soft().damping());
    def.pin_from = from.pin_first();
    def.pin_to = from.pin_last();
    return soft::build_rope(def);
}

SoftResult jelly_of(const proto::config::Type& type) {
    const auto& from = type.soft().jelly();
    soft::JellyDef def;
    def.size =
        Vec3(narrow(from.size().x_m()), narrow(from.size().y_m()), narrow(from.size().z_m()));
    def.nodes = {count_of(from.nodes_x()), count_of(from.nodes_y()), count_of(from.nodes_z())};
    def.mass = narrow(type.mass_kg());
    def.stiffness = narrow(from.stiffness_npm());
    def.damping_share = narrow(type.soft().damping());
    def.bulk_modulus = narrow(from.bulk_modulus_pa());
    return soft::build_jelly(def);
}

SoftResult balloon_of(const proto::config::Type& type) {
    const auto& from = type.soft().balloon();
    soft::BalloonDef def;
    def.radius = narrow(from.radius_m());
    def.splits = count_of(from.splits());
    def.mass = narrow(type.mass_kg());
    def.stiffness = narrow(from.stiffness_npm());
    def.damping_share = narrow(type.soft().damping());
    def.gas_pressure = narrow(from.gas_pressure_pa());
    return soft::build_balloon(def);
}

SoftResult form_of(const proto::config::Type& type) {
    switch (type.soft().form_case()) {
        case Soft::kCloth:
            return cloth_of(type);
        case Soft::kRope:
            return rope_of(type);
        case Soft::kJelly:
            return jelly_of(type);
        case Soft::kBalloon:
            return balloon_of(type);
        case Soft::kMesh:
            return mesh_body_of(type);
        case Soft::FORM_NOT_SET:
            break;
    }
    return SoftResult::failure("it needs a form: cloth, rope, jelly, balloon or mesh { ... }");
}

void set_material(const proto::config::Type& type, soft::SoftDef& def) {
    const Soft& from = type.soft();
    def.material.drag = narrow(from.drag_ps());
    def.material.tear_strain = narrow(from.tear_strain());
    def.material.tear_force = narrow(from.tear_force_n());
    def.material.yield_strain = narrow(from.yield_strain());
    def.material.creep_rate = narrow(from.creep_ps());
    def.material.thickness = narrow(from.thickness_m());
    def.material.friction = narrow(type.friction());
    def.material.self_collision = from.self_collision();
    def.solver.method = static_cast<soft::SoftMethod>(from.method());
    def.solver.substeps = count_of(from.substeps());
}

/// Moves the nodes' centre of mass to the origin, and returns their largest distance from it.
SoftShape centred(soft::SoftDef def) {
    double mass = 0.0;
    Vec3d centre = Vec3d::Zero();
    for (const soft::SoftNode& node : def.nodes) {
        mass += static_cast<double>(node.mass);
        centre += static_cast<double>(node.mass) * node.position.cast<double>();
    }
    centre /= mass;
    SoftShape out;
    for (soft::SoftNode& node : def.nodes) {
        node.position = (node.position.cast<double>() - centre).cast<float>();
        out.box.lower = out.box.lower.cwiseMin(node.position);
        out.box.upper = out.box.upper.cwiseMax(node.position);
    }
    out.box = out.box.grown(def.material.thickness);
    out.radius = out.box.lower.cwiseAbs().cwiseMax(out.box.upper).norm();
    out.def = std::move(def);
    return out;
}

/// Nodes along a side, at least two, when they lie `coarser` times as far apart.
std::uint32_t fewer(std::uint32_t nodes, std::uint32_t coarser) {
    return std::max<std::uint32_t>(2, (nodes - 1) / coarser + 1);
}

std::uint32_t moved(std::uint32_t place, std::uint32_t nodes, std::uint32_t left) {
    return (2 * place * (left - 1) + nodes - 1) / (2 * (nodes - 1));
}

void coarsen_cloth(proto::config::Cloth& cloth, std::uint32_t coarser) {
    coarser *= cloth.coarsen();
    const std::uint32_t columns = fewer(cloth.columns(), coarser);
    const std::uint32_t rows = fewer(cloth.rows(), coarser);
    for (auto& pin : *cloth.mutable_pin()) {
        pin.set_column(moved(pin.column(), cloth.columns(), columns));
        pin.set_row(moved(pin.row(), cloth.rows(), rows));
    }
    cloth.set_columns(columns);
    cloth.set_rows(rows);
    cloth.set_coarsen(1);
}

double least_distance(const soft::SoftDef& def) {
    float least = INFINITY;
    for (const soft::SoftSpring& spring : def.springs) {
        least = std::min(least, spring.rest);
    }
    return static_cast<double>(least);
}

}  // namespace

core::Result<SoftShape> build_soft(const proto::config::Type& type) {
    SoftResult def = form_of(type);
    if (!def) {
        return core::Result<SoftShape>::failure(def.error());
    }
    set_material(type, *def);
    if (const std::string reason = soft::why_unfit(*def); !reason.empty()) {
        return core::Result<SoftShape>::failure(reason);
    }
    return centred(std::move(*def));
}

proto::config::Type coarsened(const proto::config::Type& type, std::uint32_t coarser) {
    proto::config::Type out = type;
    Soft& soft = *out.mutable_soft();
    // Springs side by side do not change with the lattice, springs in a row grow softer with their
    // length, and what fills a volume has both: stiffer by the width, softer by the length.
    double longer = coarser;  // springs than those whose damping the type gives
    if (soft.has_mesh()) {
        const auto whole = build_soft(type);
        const std::size_t nodes = whole ? whole->def.nodes.size() : 0;
        soft.mutable_mesh()->set_nodes(
            static_cast<std::uint32_t>(std::max<std::size_t>(4, nodes / coarser / coarser)));
        longer = 1.0;  // a mesh damps its springs alike on any of its nodes
    } else if (soft.has_cloth()) {
        longer *= soft.cloth().coarsen();
        coarsen_cloth(*soft.mutable_cloth(), coarser);
    } else if (soft.has_rope()) {
        auto& rope = *soft.mutable_rope();
        const std::uint32_t nodes = fewer(rope.nodes(), coarser);
        const double share = static_cast<double>(nodes - 1) / (rope.nodes() - 1);
        rope.set_stiffness_npm(share * rope.stiffness_npm());
        rope.set_bend_stiffness_npm(share * rope.bend_stiffness_npm());
        rope.set_nodes(nodes);
    } else if (soft.has_jelly()) {
        auto& jelly = *soft.mutable_jelly();
        jelly.set_stiffness_npm(coarser * jelly.stiffness_npm());
        jelly.set_nodes_x(fewer(jelly.nodes_x(), coarser));
        jelly.set_nodes_y(fewer(jelly.nodes_y(), coarser));
        jelly.set_nodes_z(fewer(jelly.nodes_z(), coarser));
    } else if (soft.has_balloon()) {
        auto& balloon = *soft.mutable_balloon();
        std::uint32_t splits = balloon.splits();
        for (std::uint32_t c = 1; c < coarser && splits > 0; c *= 2) {
            --splits;
        }
        balloon.set_splits(splits);
    }
    // A spring's critical damping grows with its length in all of these; its own ought not to.
    soft.set_damping(soft.damping() / longer);
    return out;
}

void check_soft(const proto::config::Config& config,
                const proto::config::Type& type,
                const std::string& path,
                Diagnostics& diagnostics) {
    const Soft& from = type.soft();
    const std::string here = path + ".soft";
    const auto shape = build_soft(type);
    if (!shape) {
        diagnostics.add(here, shape.error());
        return;
    }
    check_deformation(type, *shape, path, diagnostics);
    const auto& nodes = shape->def.nodes;
    if (type.representation().single_beyond_m() > 0.0 &&
        std::any_of(nodes.begin(), nodes.end(), [](const auto& node) { return node.pinned; })) {
        diagnostics.add(path + ".representation.single_beyond_m",
                        "a rigid hull does not hang on pins: one that swings is neither cheaper "
                        "nor true, and what hangs still sleeps by itself");
    }
    const float tick_s = narrow(1.0 / config.world().tick_rate_hz());
    if (const std::string reason = soft::why_unstable(shape->def, tick_s); !reason.empty()) {
        diagnostics.add(here + ".method", reason);
    }
    if (from.tear_strain() > 0.0 && from.yield_strain() >= from.tear_strain()) {
        diagnostics.add(here + ".yield_strain",
                        text_of("%g is not below tear_strain, %g: it tears before it yields",
                                from.yield_strain(),
                                from.tear_strain()));
    }
    const double apart = least_distance(shape->def);
    if (from.self_collision() && 2.0 * from.thickness_m() >= apart) {
        diagnostics.add(here + ".thickness_m",
                        text_of("twice %g m is not below the distance of its nodes, %g m: with "
                                "self_collision they would push each other apart",
                                from.thickness_m(),
                                apart));
    }
    const auto air = static_cast<double>(soft::SoftMaterial().ambient_pressure);
    const double gas =
        from.has_balloon() ? from.balloon().gas_pressure_pa() : from.mesh().gas_pressure_pa();
    if ((from.has_balloon() || gas > 0.0) && gas < air) {
        diagnostics.add(
            here + (from.has_balloon() ? ".balloon" : ".mesh") + ".gas_pressure_pa",
            text_of("%g Pa is less than the %g Pa of the air around it: it collapses", gas, air));
    }
    if (type.restitution() > 0.0) {
        diagnostics.add(path + ".restitution",
                        "a soft body has none: how it bounces follows from stiffness and damping");
    }
}

}  // namespace zoned::config
