#include "tests/stability/random/random_scene.h"

#include "server/physics/narrowphase/gjk.h"
#include "server/physics/scene/stability_warnings.h"
#include "server/physics/shapes/compound/compound.h"
#include "server/physics/shapes/compound/inertia.h"
#include "server/physics/shapes/convex/hull.h"
#include "server/physics/shapes/heightfield.h"
#include "server/physics/shapes/mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace zoned::stability {

namespace {

using physics::BodyKind;
using physics::Frame;
using physics::JointKind;
using physics::Shape;
using physics::ShapeKind;

bool same(const Quat& a, const Quat& b) {
    return a.coeffs() == b.coeffs();
}

/// Points whose convex hull, grown by `radius`, is a solid.
struct RoundedCore {
    std::vector<Vec3d> points;
    double radius = 0.0;

    [[nodiscard]] Vec3d centre() const {
        Vec3d sum = Vec3d::Zero();
        for (const Vec3d& p : points) {
            sum += p;
        }
        return sum / static_cast<double>(points.size());
    }
};

/// In the body's coordinates.
RoundedCore core_of(const RandomPart& part) {
    RoundedCore core;
    switch (part.kind) {
        case ShapeKind::kSphere:
            core.points = {Vec3d::Zero()};
            core.radius = static_cast<double>(part.radius);
            break;
        case ShapeKind::kCapsule:
            core.points = {Vec3d(0.0, static_cast<double>(part.half_segment), 0.0),
                           Vec3d(0.0, -static_cast<double>(part.half_segment), 0.0)};
            core.radius = static_cast<double>(part.radius);
            break;
        case ShapeKind::kHull:
            for (const Vec3& p : part.points) {
                core.points.push_back(p.cast<double>());
            }
            break;
        default:
            for (int i = 0; i < 8; ++i) {
                const Vec3d sign((i & 1) != 0 ? 1.0 : -1.0,
                                 (i & 2) != 0 ? 1.0 : -1.0,
                                 (i & 4) != 0 ? 1.0 : -1.0);
                core.points.push_back(sign.cwiseProduct(part.half.cast<double>()));
            }
            break;
    }
    const Eigen::Quaterniond turn = part.turn.cast<double>();
    for (Vec3d& p : core.points) {
        p = turn * p + part.at.cast<double>();
    }
    return core;
}

/// The solids of a body where it starts, and a box about them.
struct PlacedCores {
    std::vector<RoundedCore> cores;
    Vec3d lower = Vec3d::Constant(std::numeric_limits<double>::infinity());
    Vec3d upper = Vec3d::Constant(-std::numeric_limits<double>::infinity());
};

PlacedCores place_cores(const RandomBody& body) {
    PlacedCores placed;
    const Eigen::Quaterniond turn = body.turn.cast<double>();
    for (const RandomPart& part : body.parts) {
        RoundedCore core = core_of(part);
        for (Vec3d& p : core.points) {
            p = turn * p + body.at.cast<double>();
            placed.lower = placed.lower.cwiseMin((p.array() - core.radius).matrix());
            placed.upper = placed.upper.cwiseMax((p.array() + core.radius).matrix());
        }
        placed.cores.push_back(std::move(core));
    }
    return placed;
}

/// Padded columns about a centre; `pull` metres nearer to the middle of the points.
struct CoreColumns {
    std::vector<float> x, y, z;

    CoreColumns(const RoundedCore& core, const Vec3d& about, double pull) {
        const Vec3d middle = core.centre();
        const auto size =
            static_cast<std::size_t>(physics::padded(static_cast<int>(core.points.size())));
        for (std::size_t i = 0; i < size; ++i) {
            const Vec3d& p = core.points[std::min(i, core.points.size() - 1)];
            const Vec3d in = middle - p;
            const double far = in.norm();
            const Vec3d q = p - about + (far > pull ? Vec3d(in * (pull / far)) : Vec3d::Zero());
            x.push_back(static_cast<float>(q.x()));
            y.push_back(static_cast<float>(q.y()));
            z.push_back(static_cast<float>(q.z()));
        }
    }

    [[nodiscard]] physics::PointsView view() const {
        return {x.data(), y.data(), z.data(), static_cast<int>(x.size())};
    }
};

/// Whether two solids overlap by more than kSoundAtStart.
bool overlap(const RoundedCore& a, const RoundedCore& b) {
    const Vec3d about = a.centre();
    const double pull_a = a.radius > 0.0 ? 0.0 : 0.5 * kSoundAtStart;
    const double pull_b = b.radius > 0.0 ? 0.0 : 0.5 * kSoundAtStart;
    const CoreColumns at(a, about, pull_a);
    const CoreColumns bt(b, about, pull_b);
    const Vec3 guess = (b.centre() - about).cast<float>();
    const physics::Closest closest = physics::closest_points(
        at.view(), bt.view(), guess.isZero(0.0F) ? Vec3(Vec3::UnitY()) : guess);
    const double allowed = kSoundAtStart - pull_a - pull_b;
    return closest.overlap || closest.distance < a.radius + b.radius - allowed;
}

bool overlap(const PlacedCores& a, const PlacedCores& b) {
    if ((a.upper.array() < b.lower.array()).any() || (b.upper.array() < a.lower.array()).any()) {
        return false;
    }
    for (const RoundedCore& x : a.cores) {
        for (const RoundedCore& y : b.cores) {
            if (overlap(x, y)) {
                return true;
            }
        }
    }
    return false;
}

int cells_of(const RandomGround& ground) {
    return static_cast<int>(std::lround(2.0F * ground.half / ground.cell));
}

/// The place of a corner of the ground's cells.
Vec3d ground_corner(const RandomGround& ground, int i, int k) {
    const int cells = cells_of(ground);
    const double x = (i - 0.5 * cells) * static_cast<double>(ground.cell);
    const double z = (k - 0.5 * cells) * static_cast<double>(ground.cell);
    const auto wave = static_cast<double>(ground.wave);
    return {x, static_cast<double>(ground.amplitude) * std::sin(wave * x) * std::sin(wave * z), z};
}

/// The two triangles of a cell, cut from its lowest x and z to its highest.
std::array<std::array<Vec3d, 3>, 2> ground_cell(const RandomGround& ground, int i, int k) {
    const Vec3d a = ground_corner(ground, i, k);
    const Vec3d b = ground_corner(ground, i + 1, k);
    const Vec3d c = ground_corner(ground, i + 1, k + 1);
    const Vec3d d = ground_corner(ground, i, k + 1);
    return {{{a, c, b}, {a, d, c}}};
}

std::string why_in_ground(const RandomGround& ground, const PlacedCores& body) {
    if (ground.kind == GroundKind::kNone) {
        return {};
    }
    const auto half = static_cast<double>(ground.half);
    if (body.lower.x() > half || body.upper.x() < -half || body.lower.z() > half ||
        body.upper.z() < -half) {
        return body.lower.y() < 0.0 ? "starts below the ground beside it" : "";
    }
    if (ground.kind == GroundKind::kBox) {
        return body.lower.y() < -kSoundAtStart ? "starts in the ground" : "";
    }
    if (body.lower.y() > static_cast<double>(std::abs(ground.amplitude))) {
        return {};
    }
    const int cells = cells_of(ground);
    const auto cell_at = [&](double x) {
        const double at = x / static_cast<double>(ground.cell) + 0.5 * cells;
        return static_cast<int>(std::floor(std::clamp(at, 0.0, cells - 1.0)));
    };
    for (const RoundedCore& core : body.cores) {
        const Vec3d middle = core.centre();
        if (middle.y() < ground_height(ground, middle.x(), middle.z())) {
            return "starts below the ground";
        }
    }
    for (int k = cell_at(body.lower.z()); k <= cell_at(body.upper.z()); ++k) {
        for (int i = cell_at(body.lower.x()); i <= cell_at(body.upper.x()); ++i) {
            for (const auto& triangle : ground_cell(ground, i, k)) {
                // A flat core is not pulled inwards: it has no depth to lose.
                RoundedCore flat;
                flat.points.assign(triangle.begin(), triangle.end());
                for (const RoundedCore& core : body.cores) {
                    if (overlap(core, flat)) {
                        return "starts in the ground";
                    }
                }
            }
        }
    }
    return {};
}

Frame frame_of(const RandomBody& body) {
    return {body.at, body.turn};
}

core::Result<Shape> build_part(const RandomPart& part, Frame& inner) {
    inner = {part.at, part.turn};
    switch (part.kind) {
        case ShapeKind::kSphere:
            return Shape::sphere(part.radius);
        case ShapeKind::kCapsule:
            return Shape::capsule(part.radius, part.half_segment);
        case ShapeKind::kBox:
            return Shape::box(part.half);
        case ShapeKind::kHull: {
            auto built = physics::build_hull(part.points);
            if (!built) {
                return core::Result<Shape>::failure(built.error());
            }
            inner = inner * built->frame;
            return Shape::hull(built->hull);
        }
        default:
            return core::Result<Shape>::failure("a part is a sphere, box, capsule or hull");
    }
}

/// The body's shape, and where its own frame lies in the coordinates of the parts.
core::Result<Shape> build_shape(const RandomBody& body, Frame& inner) {
    if (body.parts.size() == 1) {
        return build_part(body.parts.front(), inner);
    }
    std::vector<physics::CompoundPart> parts;
    for (const RandomPart& part : body.parts) {
        physics::CompoundPart one;
        auto shape = build_part(part, one.frame);
        if (!shape) {
            return shape;
        }
        one.shape = *shape;
        one.material.friction = body.friction;
        one.material.restitution = body.restitution;
        parts.push_back(one);
    }
    auto built = physics::build_compound(parts);
    if (!built) {
        return core::Result<Shape>::failure(built.error());
    }
    inner = built->frame;
    return Shape::compound(built->compound);
}

core::Result<Shape> build_ground(const RandomGround& ground) {
    const int cells = cells_of(ground);
    if (ground.kind == GroundKind::kBox) {
        return Shape::box(Vec3(ground.half, 1.0F, ground.half));
    }
    const int side = cells + 1;
    std::vector<Vec3> corners;
    std::vector<float> heights;
    for (int k = 0; k < side; ++k) {
        for (int i = 0; i < side; ++i) {
            corners.push_back(ground_corner(ground, i, k).cast<float>());
            heights.push_back(corners.back().y());
        }
    }
    if (ground.kind == GroundKind::kHeightfield) {
        physics::FieldOptions options;
        options.columns = options.rows = static_cast<std::uint32_t>(side);
        options.spacing_x = options.spacing_z = ground.cell;
        auto field = physics::build_heightfield(heights, options);
        return field ? core::Result<Shape>(Shape::heightfield(*field))
                     : core::Result<Shape>::failure(field.error());
    }
    std::vector<std::uint32_t> indices;
    for (int k = 0; k < cells; ++k) {
        for (int i = 0; i < cells; ++i) {
            const auto at = [side](int column, int row) {
                return static_cast<std::uint32_t>(row * side + column);
            };
            for (const std::uint32_t corner : {at(i, k),
                                               at(i + 1, k + 1),
                                               at(i + 1, k),
                                               at(i, k),
                                               at(i, k + 1),
                                               at(i + 1, k + 1)}) {
                indices.push_back(corner);
            }
        }
    }
    auto mesh = physics::build_mesh(corners, indices);
    return mesh ? core::Result<Shape>(Shape::mesh(mesh->mesh))
                : core::Result<Shape>::failure(mesh.error());
}

std::string why_joint_unsound(const RandomScene& scene, const RandomJoint& joint) {
    const auto count = static_cast<int>(scene.bodies.size());
    if (joint.a < -1 || joint.a >= count || joint.b < 0 || joint.b >= count) {
        return "names no body";
    }
    if (joint.a == joint.b) {
        return "joins a body to itself";
    }
    const auto free = [&](int i) {
        return i >= 0 && scene.bodies[static_cast<std::size_t>(i)].kind == BodyKind::kDynamic;
    };
    if (!free(joint.a) && !free(joint.b)) {
        return "joins no dynamic body";
    }
    const physics::JointDef& def = joint.def;
    std::string reason = physics::why_unfit(def);
    if (!reason.empty()) {
        return reason;
    }
    if (def.limited && !(static_cast<double>(def.lower) <= kSoundAtStart &&
                         static_cast<double>(def.upper) >= -kSoundAtStart)) {
        return "starts beyond its limits";
    }
    if (def.kind == JointKind::kDistance && def.length_m >= 0.0F &&
        std::abs(static_cast<double>((def.anchor_b - def.anchor).norm() - def.length_m)) >
            kSoundAtStart) {
        return "starts with another length";
    }
    return {};
}

bool parted(const RandomScene& scene, std::size_t a, std::size_t b) {
    return std::any_of(scene.joints.begin(), scene.joints.end(), [&](const RandomJoint& joint) {
        const std::pair<int, int> ends(joint.a, joint.b);
        const auto i = static_cast<int>(a);
        const auto k = static_cast<int>(b);
        return !joint.def.collide && (ends == std::pair(i, k) || ends == std::pair(k, i));
    });
}

/// The first number that is out of range, without looking at places.
std::string why_numbers_unsound(const RandomScene& scene) {
    if (!(scene.dt >= 1.0e-3F && scene.dt <= 0.1F)) {
        return "dt out of range [0.001, 0.1] s";
    }
    if (!(scene.seconds > 0.0F && scene.seconds / scene.dt <= kMostSceneSteps)) {
        return "seconds out of range: 1 to 100000 steps";
    }
    if (!scene.gravity.allFinite() || scene.gravity.norm() > 1000.0F) {
        return "gravity out of range, at most 1000 m/s2";
    }
    if (!scene.offset.allFinite() || scene.offset.norm() > 1.0e5F) {
        return "offset out of range, at most 100 km";
    }
    const RandomGround& ground = scene.ground;
    if (!(ground.half >= 0.1F && ground.half <= 1.0e4F && ground.cell >= 0.01F &&
          ground.cell <= 2.0F * ground.half && std::abs(ground.amplitude) <= 100.0F &&
          std::abs(ground.wave) <= 100.0F)) {
        return "ground: size out of range";
    }
    if (ground.kind != GroundKind::kBox && 2.0F * ground.half / ground.cell > kMostGroundCells) {
        return "ground: more than 256 cells along a side";
    }
    if (scene.bodies.size() > kMostSceneBodies || scene.joints.size() > kMostSceneJoints) {
        return "more than 4096 bodies or joints";
    }
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const RandomBody& body = scene.bodies[i];
        const std::string name = "body " + std::to_string(i) + ": ";
        if (body.parts.empty() || body.parts.size() > kMostSceneParts) {
            return name + "needs 1 to 64 parts";
        }
        if (body.kind == BodyKind::kParticle) {
            return name + "is static, kinematic or dynamic";
        }
        for (const RandomPart& part : body.parts) {
            if (part.kind == ShapeKind::kHull &&
                (part.points.size() < 4 || part.points.size() > physics::kMaxHullVertices)) {
                return name + "a hull has 4 to 64 points";
            }
            if (!part.at.allFinite() || part.at.norm() > 1000.0F ||
                std::abs(part.turn.norm() - 1.0F) > 1.0e-3F) {
                return name + "a part's place is out of range";
            }
        }
        if (!body.at.allFinite() || body.at.norm() > 1.0e5F ||
            std::abs(body.turn.norm() - 1.0F) > 1.0e-3F) {
            return name + "place out of range";
        }
    }
    return {};
}

}  // namespace

bool RandomPart::operator==(const RandomPart& o) const {
    return kind == o.kind && half == o.half && radius == o.radius &&
           half_segment == o.half_segment && points == o.points && at == o.at && same(turn, o.turn);
}

bool RandomBody::operator==(const RandomBody& o) const {
    return kind == o.kind && parts == o.parts && mass == o.mass && friction == o.friction &&
           restitution == o.restitution && at == o.at && same(turn, o.turn) &&
           velocity == o.velocity && spin == o.spin;
}

bool RandomJoint::operator==(const RandomJoint& o) const {
    const physics::JointDef& d = def;
    const physics::JointDef& e = o.def;
    return a == o.a && b == o.b && d.kind == e.kind && d.anchor == e.anchor &&
           d.anchor_b == e.anchor_b && d.axis == e.axis && d.length_m == e.length_m &&
           d.spring_hz == e.spring_hz && d.spring_damping_ratio == e.spring_damping_ratio &&
           d.limited == e.limited && d.lower == e.lower && d.upper == e.upper &&
           d.motor == e.motor && d.motor_speed == e.motor_speed && d.motor_max == e.motor_max &&
           d.break_force_n == e.break_force_n && d.collide == e.collide;
}

bool RandomScene::operator==(const RandomScene& o) const {
    return seed == o.seed && index == o.index && families == o.families && gravity == o.gravity &&
           dt == o.dt && seconds == o.seconds && offset == o.offset && ground == o.ground &&
           bodies == o.bodies && joints == o.joints;
}

double ground_height(const RandomGround& ground, double x, double z) {
    constexpr double kBeside = -std::numeric_limits<double>::infinity();
    const auto half = static_cast<double>(ground.half);
    if (ground.kind == GroundKind::kNone || !(std::abs(x) <= half && std::abs(z) <= half)) {
        return kBeside;
    }
    if (ground.kind == GroundKind::kBox) {
        return 0.0;
    }
    const int cells = cells_of(ground);
    const double u = x / static_cast<double>(ground.cell) + 0.5 * cells;
    const double v = z / static_cast<double>(ground.cell) + 0.5 * cells;
    if (u < 0.0 || v < 0.0 || u > cells || v > cells) {
        return kBeside;
    }
    const int i = std::min(static_cast<int>(u), cells - 1);
    const int k = std::min(static_cast<int>(v), cells - 1);
    const double a = ground_corner(ground, i, k).y();
    const double c = ground_corner(ground, i + 1, k + 1).y();
    const double s = u - i;
    const double t = v - k;
    const double other =
        s > t ? ground_corner(ground, i + 1, k).y() : ground_corner(ground, i, k + 1).y();
    return a + std::max(s, t) * (other - a) + std::min(s, t) * (c - other);
}

double lowest_ground(const RandomGround& ground) {
    switch (ground.kind) {
        case GroundKind::kNone:
            return std::numeric_limits<double>::infinity();
        case GroundKind::kBox:
            return 0.0;
        default:
            return -static_cast<double>(std::abs(ground.amplitude));
    }
}

std::string why_unsound(const RandomScene& scene) {
    std::string reason = why_numbers_unsound(scene);
    if (!reason.empty()) {
        return reason;
    }
    for (std::size_t i = 0; i < scene.joints.size(); ++i) {
        reason = why_joint_unsound(scene, scene.joints[i]);
        if (!reason.empty()) {
            return "joint " + std::to_string(i) + ": " + reason;
        }
    }
    std::vector<PlacedCores> placed;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        placed.push_back(place_cores(scene.bodies[i]));
        if (scene.bodies[i].kind == BodyKind::kDynamic) {
            reason = why_in_ground(scene.ground, placed.back());
        }
        if (!reason.empty()) {
            return "body " + std::to_string(i) + ": " + reason;
        }
        for (std::size_t k = 0; k < i; ++k) {
            const bool meet = scene.bodies[i].kind == BodyKind::kDynamic ||
                              scene.bodies[k].kind == BodyKind::kDynamic;
            if (meet && overlap(placed[i], placed[k]) && !parted(scene, i, k)) {
                return "bodies " + std::to_string(k) + " and " + std::to_string(i) +
                       " overlap by more than 1 mm";
            }
        }
    }
    return {};
}

core::Result<LiveScene> build_live(const RandomScene& scene) {
    using Refused = core::Result<LiveScene>;
    physics::PhysicsSettings settings;
    settings.gravity = scene.gravity;
    LiveScene live{physics::Scene(settings), {}, {}, {}, {}, {}, {}};
    if (scene.ground.kind != GroundKind::kNone) {
        auto shape = build_ground(scene.ground);
        if (!shape) {
            return Refused::failure("ground: " + shape.error());
        }
        physics::BodyDef def;
        def.kind = BodyKind::kStatic;
        def.shape = *shape;
        def.material.friction = scene.ground.friction;
        def.material.restitution = scene.ground.restitution;
        def.position = scene.offset;
        def.position.y() -= scene.ground.kind == GroundKind::kBox ? 1.0F : 0.0F;
        const auto id = live.scene.add(def);
        if (!id) {
            return Refused::failure("ground: " + id.error());
        }
    }
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const RandomBody& body = scene.bodies[i];
        Frame inner;
        auto shape = build_shape(body, inner);
        if (!shape) {
            return Refused::failure("body " + std::to_string(i) + ": " + shape.error());
        }
        physics::BodyDef def;
        def.kind = body.kind;
        def.shape = *shape;
        def.material.friction = body.friction;
        def.material.restitution = body.restitution;
        def.mass = body.mass;
        const Frame pose = frame_of(body) * inner;
        def.position = scene.offset + pose.position;
        def.orientation = pose.rotation.normalized();
        def.velocity = body.velocity;
        def.angular_velocity = body.spin;
        // The work of a mover is read off its contacts.
        def.events = body.kind == BodyKind::kKinematic ? physics::kTellBegin | physics::kTellPersist
                                                       : std::uint8_t{0};
        def.user = static_cast<std::uint32_t>(i + 1);
        const auto id = live.scene.add(def);
        if (!id) {
            return Refused::failure("body " + std::to_string(i) + ": " + id.error());
        }
        live.bodies.push_back(*id);
        live.moments.push_back(physics::principal_inertia(def.shape, def.mass).cast<double>());
        live.radii.push_back(static_cast<double>(physics::bounding_radius(def.shape)));
        std::vector<Vec3d> centres;
        const Eigen::Quaterniond back = inner.rotation.cast<double>().conjugate();
        for (const RandomPart& part : body.parts) {
            centres.emplace_back(back * (core_of(part).centre() - inner.position.cast<double>()));
        }
        live.centres.push_back(std::move(centres));
    }
    for (std::size_t i = 0; i < scene.joints.size(); ++i) {
        const RandomJoint& joint = scene.joints[i];
        physics::JointDef def = joint.def;
        const auto id_of = [&](int body) {
            return body < 0 ? BodyId() : live.bodies[static_cast<std::size_t>(body)];
        };
        const auto mass_of = [&](int body) {
            return body < 0 ||
                           scene.bodies[static_cast<std::size_t>(body)].kind != BodyKind::kDynamic
                       ? 0.0F
                       : scene.bodies[static_cast<std::size_t>(body)].mass;
        };
        def.a = id_of(joint.a);
        def.b = id_of(joint.b);
        def.anchor += scene.offset;
        def.anchor_b += scene.offset;
        const auto id = live.scene.add_joint(def);
        if (!id) {
            return Refused::failure("joint " + std::to_string(i) + ": " + id.error());
        }
        live.joints.push_back(*id);
        live.warnings.push_back(physics::stability_warnings_of(
            def, mass_of(joint.a), mass_of(joint.b), settings, scene.dt));
    }
    return live;
}

}  // namespace zoned::stability
