#include "server/config/types/part_overlaps.h"

#include "server/physics/scene/scene.h"
#include "server/zone/simulation/type_body.h"

#include <algorithm>

namespace zoned::config {

namespace {

constexpr float kTolerated = 0.01F;
/// So short that nothing moves; contacts are found all the same, s.
constexpr float kInstant = 1.0e-5F;

bool kept_apart(const zone::AssemblyDef& assembly, std::size_t a, std::size_t b) {
    return std::any_of(
        assembly.joints.begin(), assembly.joints.end(), [&](const zone::AssemblyJoint& joint) {
            return !joint.plan->def.collide &&
                   ((joint.a == a && joint.b == b) || (joint.a == b && joint.b == a));
        });
}

}  // namespace

std::vector<PartOverlap> part_overlaps(const zone::AssemblyDef& assembly,
                                       const world::TypeTable& types,
                                       std::span<const physics::Shape> solids) {
    physics::PhysicsSettings settings;
    settings.gravity.setZero();
    physics::Scene scene(settings);
    for (std::size_t p = 0; p < assembly.parts.size(); ++p) {
        physics::BodyDef def = zone::body_of(types[assembly.parts[p].type], solids);
        def.position = assembly.parts[p].position;
        def.orientation = assembly.parts[p].orientation;
        def.user = static_cast<std::uint32_t>(p + 1);
        if (!scene.add(def)) {
            return {};  // reported with its type
        }
    }
    scene.step(kInstant);
    std::vector<PartOverlap> found;
    for (const physics::ContactEvent& event : scene.contact_events()) {
        const std::size_t a = std::min(event.user_a, event.user_b) - 1;
        const std::size_t b = std::max(event.user_a, event.user_b) - 1;
        if (event.depth > kTolerated && !kept_apart(assembly, a, b)) {
            found.push_back({a, b, event.depth});
        }
    }
    std::sort(found.begin(), found.end(), [](const PartOverlap& one, const PartOverlap& other) {
        return one.a != other.a ? one.a < other.a : one.b < other.b;
    });
    return found;
}

}  // namespace zoned::config
