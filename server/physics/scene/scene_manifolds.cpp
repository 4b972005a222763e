// Pairs of several manifolds: meshes, heightfields and compounds.
#include "server/physics/contacts/contact_persistence.h"
#include "server/physics/scene/scene_impl.h"

#include <algorithm>

namespace zoned::physics {

void Scene::Impl::classify(std::uint32_t index) {
    Pair& pair = graph.pair(index);
    const bool convex =
        is_convex(bodies.shape[pair.a].kind) && is_convex(bodies.shape[pair.b].kind);
    pair.several = convex ? 0 : 1;
    pair.sensor = bodies.sensor[pair.a] != 0 || bodies.sensor[pair.b] != 0 ? 1 : 0;
}

/// The pair's own record sums up those of its chain.
void Scene::Impl::update_chain(std::uint32_t index, const PairMotion& motion) {
    if (!reuse_manifold(index, motion)) {
        find_chain(index, motion);
    }
    float speed = 0.0F;
    bool closing = false;
    for (std::uint32_t at = graph[index].chain; at != kNoIndex; at = graph[at].chain) {
        approach(at, motion);
        closing |= graph.pair(at).closing;
        speed = std::max(speed, graph[at].approach_speed);
    }
    graph.pair(index).closing = closing;
    graph[index].approach_speed = speed;
}

void Scene::Impl::find_chain(std::uint32_t index, const PairMotion& motion) {
    const std::uint32_t a = graph.pair(index).a;
    const std::uint32_t b = graph.pair(index).b;
    const Impact impact = collide_ahead(placed(a), placed(b), motion, parts);
    const ChainRecords chain = match_chain(graph, index, parts.manifolds());
    for (std::size_t i = 0; i < chain.count; ++i) {
        const PartManifold& from = parts.manifolds()[i];
        const Material& of_a = from.material_a != nullptr ? *from.material_a : bodies.material[a];
        const Material& of_b = from.material_b != nullptr ? *from.material_b : bodies.material[b];
        Pair& record = graph.pair(chain.records[i]);
        Contact& contact = graph[chain.records[i]];
        contact.normal = from.manifold.normal;
        contact.lead = -impact.time * (motion.velocity_b - motion.velocity_a);
        contact.grip = combine(of_a, of_b);
        adopt_points(from.manifold,
                     bodies.position[a] + impact.time * motion.velocity_a,
                     bodies.position[b] + impact.time * motion.velocity_b,
                     record.points(),
                     contact);
        record.count = static_cast<std::uint8_t>(from.manifold.count);
    }
    Pair& pair = graph.pair(index);
    pair.senses = parts.sensed() ? 1 : 0;
    pair.found.reach = impact.time > 0.0F ? -1.0F : impact.margin;
    pair.found.between = bodies.position[b] - bodies.position[a];
    pair.found.orientation_a = bodies.orientation[a];
    pair.found.orientation_b = bodies.orientation[b];
}

}  // namespace zoned::physics
