// Sensors: the bodies within them, and the events of coming and leaving.
#include "server/physics/scene/scene_impl.h"

namespace zoned::physics {

void Scene::Impl::look_into_sensor(std::uint32_t index) {
    Pair& pair = graph.pair(index);
    if (pair.several != 0) {
        parts.collide(placed(pair.a), placed(pair.b), {});
        pair.senses = parts.sensed() || !parts.manifolds().empty() ? 1 : 0;
    } else {
        Manifold manifold;
        collide(placed(pair.a), placed(pair.b), 0.0F, manifold);
        pair.senses = manifold.count > 0 ? 1 : 0;
    }
}

/// Reports the bodies that came into or left a sensor since the last look.
void Scene::Impl::note_sensing(std::uint32_t index) {
    Pair& pair = graph.pair(index);
    if (pair.senses != pair.inside) {
        pair.inside = pair.senses;
        sensor_events.push_back(sensor_event(index));
    }
}

SensorEvent Scene::Impl::sensor_event(std::uint32_t index) const {
    const Pair& pair = graph.pair(index);
    return {bodies.id_of(pair.a),
            bodies.id_of(pair.b),
            bodies.user[pair.a],
            bodies.user[pair.b],
            pair.inside != 0};
}

/// The pair is about to be forgotten: a body in a sensor leaves it.
void Scene::Impl::end_sensing(std::uint32_t index, std::vector<SensorEvent>& out) {
    Pair& pair = graph.pair(index);
    if (pair.inside != 0) {
        pair.inside = 0;
        out.push_back(sensor_event(index));
    }
}

}  // namespace zoned::physics
