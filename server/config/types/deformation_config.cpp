#include "server/config/types/deformation_config.h"

#include "server/config/text/check_name.h"
#include "server/config/text/config_numbers.h"
#include "server/config/types/field_config.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <string_view>

namespace zoned::config {

namespace {

constexpr const char* kTorn = "torn";

/// Steps of a displacement reach two radii to either side: a body that keeps its size is never
/// displaced by more.
constexpr double kReach_radii = 2.0;

/// Where the type says nothing, of the radius.
constexpr double kUsualBound_radii = 0.05;

bool tears(const proto::config::Type& type) {
    return type.soft().tear_strain() > 0.0 || type.soft().tear_force_n() > 0.0;
}

/// Control points that the type has fields for.
std::size_t most_points(const proto::config::Type& type, const SoftShape& shape) {
    const std::size_t torn = tears(type) ? 1 : 0;
    const std::size_t fields = static_cast<std::size_t>(type.field_size()) + torn;
    const std::size_t words = words_of_fields(type) + torn;
    const std::size_t wanted = type.soft().deformation().points();
    return std::min({wanted,
                     wire::kMostDeclared - std::min(fields, wire::kMostDeclared),
                     wire::kMostFieldWords - std::min(words, wire::kMostFieldWords),
                     shape.def.nodes.size()});
}

/// The box of the nodes, and how many different coordinates they have along each axis: more control
/// points than that would have no nodes.
std::array<std::size_t, 3> rows_of(const SoftShape& shape, Vec3& lower, Vec3& upper) {
    std::array<std::size_t, 3> rows{};
    std::vector<float> at(shape.def.nodes.size());
    for (int axis = 0; axis < 3; ++axis) {
        std::transform(
            shape.def.nodes.begin(), shape.def.nodes.end(), at.begin(), [axis](const auto& node) {
                return node.position[axis];
            });
        std::sort(at.begin(), at.end());
        lower[axis] = at.front();
        upper[axis] = at.back();
        const float same = 1.0e-4F * shape.radius;
        const auto end =
            std::unique(at.begin(), at.end(), [same](float a, float b) { return b - a < same; });
        rows[static_cast<std::size_t>(axis)] = static_cast<std::size_t>(end - at.begin());
        at.resize(shape.def.nodes.size());
    }
    return rows;
}

double quantum_m(const SoftShape& shape) {
    return kReach_radii * static_cast<double>(shape.radius) / wire::DeformationLattice::kMostSteps;
}

/// Rounding puts a place up to half the diagonal of a step off; as much again is left for bends.
double least_bound_m(const SoftShape& shape) {
    return std::numbers::sqrt3 * quantum_m(shape);
}

}  // namespace

std::shared_ptr<const wire::DeformationLattice> expand_deformation(const proto::config::Type& type,
                                                                   const SoftShape& shape) {
    const auto& from = type.soft().deformation();
    const std::size_t most = most_points(type, shape);
    if (!from.sent() || most < 2) {
        return nullptr;
    }
    wire::DeformationLattice out;
    const std::array<std::size_t, 3> rows = rows_of(shape, out.lower, out.upper);
    const Vec3 extent = out.upper - out.lower;
    for (;;) {
        std::size_t widest = 3;
        auto width = narrow(quantum_m(shape));  // what is thinner is flat
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const float cells = std::max(static_cast<float>(out.points[axis]) - 1.0F, 0.5F);
            const float apart = extent[static_cast<Eigen::Index>(axis)] / cells;
            if (out.points[axis] < rows[axis] && apart > width) {
                widest = axis;
                width = apart;
            }
        }
        if (widest == 3 || out.size() / out.points[widest] * (out.points[widest] + 1) > most) {
            break;
        }
        ++out.points[widest];
    }
    out.quantum_m = narrow(quantum_m(shape));
    out.bound_m =
        narrow(from.bound_m() > 0.0 ? from.bound_m()
                                    : kUsualBound_radii * static_cast<double>(shape.radius));
    return std::make_shared<const wire::DeformationLattice>(out);
}

void add_deformation_fields(const proto::config::Type& type,
                            world::EntityType& out,
                            std::vector<wire::DeclaredField>& fields) {
    if (!type.has_soft()) {
        return;
    }
    if (tears(type) && fields.size() < wire::kMostDeclared) {
        fields.push_back(wire::number_field(kTorn, 0.0, wire::kMostFieldSteps, 1.0, 0.0));
        out.torn_field = static_cast<std::uint16_t>(fields.size());
    }
    out.first_control_point = static_cast<std::uint16_t>(fields.size());
    const std::size_t points = out.deformation != nullptr ? out.deformation->size() : 0;
    for (std::size_t point = 0; point < points; ++point) {
        fields.push_back(wire::number_field(wire::kControlPointName + std::to_string(point),
                                            0.0,
                                            wire::kMostFieldSteps,
                                            1.0,
                                            wire::DeformationLattice::kUndisplaced));
    }
}

void check_deformation(const proto::config::Type& type,
                       const SoftShape& shape,
                       const std::string& path,
                       Diagnostics& diagnostics) {
    for (int f = 0; f < type.field_size(); ++f) {
        const std::string_view name = type.field(f).name();
        if (name == kTorn || name.starts_with(wire::kControlPointName)) {
            diagnostics.add(join_path(path, "field", f) + ".name",
                            "'" + std::string(name) +
                                "' is a field that soft bodies have by "
                                "themselves");
        }
    }
    const auto& from = type.soft().deformation();
    if (!from.sent()) {
        return;
    }
    const std::string here = path + ".soft.deformation";
    if (most_points(type, shape) < 2) {
        diagnostics.add(here + ".points",
                        "the fields of the type leave no room for control points: a type has at "
                        "most 64 fields of 128 words");
    }
    if (from.bound_m() > 0.0 && from.bound_m() < least_bound_m(shape)) {
        diagnostics.add(here + ".bound_m",
                        text_of("%g m is finer than the steps of a displacement allow for a body "
                                "of this size: at least %.3g m",
                                from.bound_m(),
                                least_bound_m(shape)));
    }
}

}  // namespace zoned::config
