#include "tests/stability/random/scene_generator.h"

#include "tests/stability/random/scene_families.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace zoned::stability {

namespace {

using physics::ShapeKind;

constexpr float kHeld = 100.0F;  ///< clearances above this: the assembly keeps its height
constexpr int kTries = 6;        ///< places that are looked at for an assembly

/// Lowest point of a part of a body, m.
float lowest_of(const RandomBody& body, const RandomPart& part) {
    const Quat turn = body.turn * part.turn;
    const float at = (body.at + body.turn * part.at).y();
    switch (part.kind) {
        case ShapeKind::kSphere:
            return at - part.radius;
        case ShapeKind::kCapsule:
            return at - part.radius - part.half_segment * std::abs((turn * Vec3::UnitY()).y());
        case ShapeKind::kHull: {
            float low = std::numeric_limits<float>::infinity();
            for (const Vec3& p : part.points) {
                low = std::min(low, at + (turn * p).y());
            }
            return low;
        }
        default:
            return at - turn.toRotationMatrix().row(1).cwiseAbs().dot(part.half.transpose());
    }
}

struct Extent {
    float low = std::numeric_limits<float>::infinity();
    float reach = 0.0F;  ///< from the middle, level, m
    Vec3 middle = Vec3::Zero();
};

float size_of(const RandomBody& body) {
    float size = 0.0F;
    for (const RandomPart& part : body.parts) {
        float own = part.kind == ShapeKind::kBox ? part.half.norm() : part.radius;
        own += part.kind == ShapeKind::kCapsule ? part.half_segment : 0.0F;
        for (const Vec3& p : part.points) {
            own = std::max(own, p.norm());
        }
        size = std::max(size, part.at.norm() + own);
    }
    return size;
}

Extent extent_of(const Assembly& assembly) {
    Extent extent;
    for (const RandomBody& body : assembly.bodies) {
        extent.middle += body.at / static_cast<float>(assembly.bodies.size());
    }
    for (const RandomBody& body : assembly.bodies) {
        const Vec3 out = body.at - extent.middle;
        extent.reach = std::max(extent.reach, Vec2(out.x(), out.z()).norm() + size_of(body));
        if (body.kind != physics::BodyKind::kDynamic) {
            continue;
        }
        for (const RandomPart& part : body.parts) {
            extent.low = std::min(extent.low, lowest_of(body, part));
        }
    }
    return extent;
}

/// Highest ground within the extent about a place, m.
float highest_under(const RandomGround& ground, float x, float z, float reach) {
    double most = 0.0;
    const int steps = 8;
    if (ground.kind == GroundKind::kBox || ground.kind == GroundKind::kNone) {
        return 0.0F;
    }
    most = -static_cast<double>(ground.amplitude);
    for (int i = -steps; i <= steps; ++i) {
        for (int k = -steps; k <= steps; ++k) {
            const double h =
                ground_height(ground,
                              static_cast<double>(x) + static_cast<double>(reach) * i / steps,
                              static_cast<double>(z) + static_cast<double>(reach) * k / steps);
            most = std::max(most, h);
        }
    }
    return static_cast<float>(most) + 0.05F * ground.amplitude;
}

/// The scene with the assembly moved by `shift`.
RandomScene with_assembly(const RandomScene& scene, const Assembly& assembly, const Vec3& shift) {
    RandomScene out = scene;
    const auto first = static_cast<int>(scene.bodies.size());
    for (RandomBody body : assembly.bodies) {
        body.at += shift;
        out.bodies.push_back(std::move(body));
    }
    for (RandomJoint joint : assembly.joints) {
        joint.a += joint.a >= 0 ? first : 0;
        joint.b += first;
        joint.def.anchor += shift;
        joint.def.anchor_b += shift;
        out.joints.push_back(joint);
    }
    return out;
}

/// Movers squeeze what they push against walls: no scene has both.
bool squeezes(const RandomScene& scene) {
    const auto has = [&](physics::BodyKind kind) {
        return std::any_of(scene.bodies.begin(), scene.bodies.end(), [kind](const RandomBody& b) {
            return b.kind == kind;
        });
    };
    return has(physics::BodyKind::kStatic) && has(physics::BodyKind::kKinematic);
}

/// False where no sound place was found.
bool place(SceneDraw& draw, const Assembly& assembly, RandomScene& scene) {
    const Extent extent = extent_of(assembly);
    for (int attempt = 0; attempt < kTries; ++attempt) {
        Vec3 shift = -extent.middle;
        const bool first = attempt == 0 && scene.bodies.empty();
        const float spread = first ? 0.0F : 2.0F + 2.0F * static_cast<float>(attempt);
        shift.x() += draw.range(-spread, spread);
        shift.z() += draw.range(-spread, spread);
        const float ground = highest_under(scene.ground,
                                           shift.x() + extent.middle.x(),
                                           shift.z() + extent.middle.z(),
                                           extent.reach);
        if (draw.setting == SceneSetting::kAdrift) {
            shift.y() += draw.range(-spread, spread);
        } else if (assembly.clearance > kHeld) {
            shift.y() = ground;
        } else if (assembly.at_origin) {
            shift = Vec3::Zero();
        } else {
            shift.y() = ground - extent.low + assembly.clearance;
        }
        RandomScene next = with_assembly(scene, assembly, shift);
        if (!squeezes(next) && why_unsound(next).empty() && build_live(next)) {
            scene = std::move(next);
            return true;
        }
        if (assembly.at_origin) {
            return false;
        }
    }
    return false;
}

float draw_dt(SceneDraw& draw) {
    constexpr std::array kRates{20.0F, 25.0F, 30.0F, 50.0F, 90.0F, 120.0F, 240.0F};
    return 1.0F / (draw.chance(0.5F)
                       ? 60.0F
                       : kRates[static_cast<std::size_t>(draw.count(0, kRates.size() - 1))]);
}

void draw_ground(SceneDraw& draw, RandomGround& ground) {
    const float kind = draw.range(0.0F, 1.0F);
    ground.kind = kind < 0.5F ? GroundKind::kBox
                              : (kind < 0.8F ? GroundKind::kMesh : GroundKind::kHeightfield);
    ground.friction = draw.friction;
    ground.restitution = draw.restitution;
    if (ground.kind != GroundKind::kBox) {
        ground.cell = draw.range(0.4F, 2.0F);
        ground.half = ground.cell * static_cast<float>(draw.count(10, 20));
        ground.amplitude = draw.chance(0.3F) ? 0.0F : draw.range(0.0F, 0.6F);
        ground.wave = draw.range(0.2F, 0.9F);
    }
}

}  // namespace

std::vector<std::string> family_names() {
    std::vector<std::string> names;
    for (const SceneFamily& family : scene_families()) {
        names.emplace_back(family.name);
    }
    return names;
}

RandomScene generate_scene(std::uint64_t seed,
                           std::uint64_t index,
                           const std::vector<std::string>& only) {
    SceneDraw draw(seed, index);
    RandomScene scene;
    scene.seed = seed;
    scene.index = index;
    draw.setting = draw.chance(0.2F) ? SceneSetting::kAdrift : SceneSetting::kGround;
    draw.friction = draw.chance(0.4F) ? 0.5F : draw.range(0.0F, 1.0F);
    draw.restitution =
        draw.chance(0.6F) ? 0.0F : (draw.chance(0.3F) ? 1.0F : draw.range(0.0F, 1.0F));
    draw.density = draw.decades(100.0F, 3000.0F);
    draw.decades_of_mass = draw.chance(0.4F) ? 0.0F : draw.range(0.0F, 2.0F);
    scene.dt = draw_dt(draw);
    scene.seconds = draw.chance(0.2F) ? 16.0F : draw.range(1.0F, 5.0F);
    if (draw.chance(0.4F)) {
        const float far = draw.decades(10.0F, 1000.0F);
        scene.offset = far * draw.direction();
        scene.offset.y() *= 0.1F;
    }
    if (draw.setting == SceneSetting::kAdrift) {
        scene.gravity = Vec3::Zero();
    } else {
        draw_ground(draw, scene.ground);
    }
    const bool level = scene.ground.kind == GroundKind::kNone || scene.ground.amplitude == 0.0F;
    std::vector<const SceneFamily*> fit;
    for (const SceneFamily& family : scene_families()) {
        const bool chosen =
            only.empty() || std::find(only.begin(), only.end(), family.name) != only.end();
        if (chosen && (family.adrift || draw.setting == SceneSetting::kGround) &&
            (level || !family.level)) {
            fit.push_back(&family);
        }
    }
    for (int left = draw.count(1, 3); left > 0 && !fit.empty(); --left) {
        const SceneFamily& family =
            *fit[static_cast<std::size_t>(draw.count(0, static_cast<int>(fit.size()) - 1))];
        Assembly assembly;
        family.make(draw, assembly);
        if (place(draw, assembly, scene)) {
            scene.families += (scene.families.empty() ? "" : " ") + std::string(family.name);
        }
    }
    return scene;
}

}  // namespace zoned::stability
