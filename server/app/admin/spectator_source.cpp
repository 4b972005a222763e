#include "server/app/admin/spectator_source.h"

#include "server/ai/agent/whereabouts.h"
#include "server/app/admin/spectator_scene.h"

#include <algorithm>
#include <utility>

namespace zoned::app {

namespace {

using admin::SpectatorSample;

void copy_columns(const zone::ZoneState& state, admin::SpectatorZone& to) {
    const world::Entities& from = state.entities;
    to.number = state.settings.id.value;
    to.origin = state.settings.region().origin();
    to.id.assign(from.id.begin(), from.id.end());
    to.type.assign(from.type.begin(), from.type.end());
    to.flags.assign(from.flags.begin(), from.flags.end());
    to.client.assign(from.client.begin(), from.client.end());
    to.position.assign(from.position.begin(), from.position.end());
    to.orientation.assign(from.orientation.begin(), from.orientation.end());
    to.velocity.assign(from.velocity.begin(), from.velocity.end());
}

void add_walker(const zone::ZoneState& state,
                const ai::Agent& agent,
                std::uint16_t zone,
                SpectatorSample& out) {
    const world::Row row = state.entities.find(agent.entity);
    if (row == world::kNoRow) {
        return;
    }
    const Vec3& at = state.entities.position[row];
    const float dt = state.settings.dt;
    admin::SpectatorWalker& walker = out.walkers.emplace_back();
    walker.zone = zone;
    walker.row = row;
    walker.position = ai::whereabouts(agent, Vec2(at.x(), at.z()), state.now + 1, dt);
    walker.velocity = ai::velocity_at(agent.segment, state.now, dt);
}

/// Goes round over the agents of all zones, some of them in each sample.
void add_walkers(const World& world, SpectatorSample& out) {
    std::size_t all = 0;
    for (const auto& zone : world.zones()) {
        all += std::as_const(*zone).state().agents.slots();
    }
    out.walkers.clear();
    std::size_t at = all > 0 ? out.next_walker % all : 0;
    std::size_t left = std::min<std::size_t>(all, kWalkersPerSample);
    out.next_walker = static_cast<std::uint32_t>(at + left);
    for (int round = 0; round < 2 && left > 0; ++round) {
        for (std::size_t z = 0; z < world.zones().size() && left > 0; ++z) {
            const zone::ZoneState& state = std::as_const(*world.zones()[z]).state();
            const std::size_t slots = state.agents.slots();
            for (; at < slots && left > 0; ++at, --left) {
                const ai::Agent& agent = state.agents.at(static_cast<ai::Slot>(at));
                if (agent.entity && agent.tier == ai::Tier::kSuspended) {
                    add_walker(state, agent, static_cast<std::uint16_t>(z), out);
                }
            }
            at -= std::min(at, slots);
        }
    }
}

void add_joints(const zone::ZoneState& state, SpectatorSample& out) {
    const Vec3d origin = state.settings.region().origin();
    const world::Entities& entities = state.entities;
    for (const zone::EntityJoint& joint : state.assemblies.joints) {
        const world::Row b = entities.find(joint.b);
        const world::Row a = joint.a ? entities.find(joint.a) : world::kNoRow;
        if (b == world::kNoRow) {
            continue;
        }
        const physics::JointDef& def = joint.plan->def;
        const bool two_points =
            def.kind == physics::JointKind::kDistance || def.kind == physics::JointKind::kSpring;
        const Vec3 at_b = entities.position[b];
        const Vec3 held = at_b + entities.orientation[b] * (two_points ? def.anchor_b : def.anchor);
        Vec3 end = held;
        if (a != world::kNoRow) {
            end = entities.position[a];
            if (two_points) {
                end += entities.orientation[a] * def.anchor;
            }
        }
        out.joints.push_back({origin + at_b.cast<double>(),
                              origin + held.cast<double>(),
                              origin + end.cast<double>()});
    }
}

void add_softs(const zone::ZoneState& state, std::size_t& used, SpectatorSample& out) {
    if (!state.soft) {
        return;
    }
    const physics::soft::SoftBodies& bodies = state.soft->bodies;
    for (const zone::SoftLink& link : state.soft->links) {
        if (bodies.rigid(link.body)) {
            continue;  // drawn as the rigid hull that it has become
        }
        if (used == out.softs.size()) {
            out.softs.emplace_back();
        }
        admin::SpectatorSoft& soft = out.softs[used++];
        soft.entity = link.entity;
        soft.origin = state.settings.region().origin();
        soft.nodes.resize(bodies.node_count(link.body));
        for (std::size_t node = 0; node < soft.nodes.size(); ++node) {
            soft.nodes[node] = bodies.position(link.body, node);
        }
        const auto faces = bodies.drawn_faces(link.body);
        soft.faces.assign(faces.begin(), faces.end());
        const auto hung = bodies.hung_vertices(link.body);
        soft.hung.assign(hung.begin(), hung.end());
    }
}

void add_particles(const zone::ZoneState& state, std::size_t every, SpectatorSample& out) {
    const Vec3d origin = state.settings.region().origin();
    for (const auto& listed : state.particles.systems) {
        const physics::ParticleSystem* system = state.particles.simulated.find(listed.id);
        for (std::size_t i = 0; system != nullptr && i < system->size(); i += every) {
            const Vec3d at = origin + system->position(i).cast<double>();
            out.particles.push_back({static_cast<float>(at.x()),
                                     static_cast<float>(at.y()),
                                     static_cast<float>(at.z())});
        }
    }
}

std::size_t particles_in(const World& world) {
    std::size_t all = 0;
    for (const auto& zone : world.zones()) {
        all += zone->report().particles.particles;
    }
    return all;
}

}  // namespace

void fill_sample(const World& world, SpectatorSample& out) {
    out.tick = world.now();
    out.zones.resize(world.zones().size());
    out.joints.clear();
    out.particles.clear();
    std::size_t softs = 0;
    const std::size_t every = 1 + particles_in(world) / kMostParticlesShown;
    for (std::size_t z = 0; z < world.zones().size(); ++z) {
        const zone::ZoneState& state = std::as_const(*world.zones()[z]).state();
        out.tick_s = state.settings.dt;
        copy_columns(state, out.zones[z]);
        if ((out.layers & admin::kLayerJoints) != 0) {
            add_joints(state, out);
        }
        if ((out.layers & admin::kLayerSofts) != 0) {
            add_softs(state, softs, out);
        }
        if ((out.layers & admin::kLayerParticles) != 0) {
            add_particles(state, every, out);
        }
    }
    out.softs.resize(softs);
    out.moved_doors.clear();
    out.moved_platforms.clear();
    if ((out.layers & admin::kLayerMoved) != 0) {
        world.add_moved_by_rules(out.tick, out.moved_doors, out.moved_platforms);
    }
    add_walkers(world, out);
}

admin::SpectatorSource spectator_source(const config::Settings& settings, VisitedWorld& loop) {
    admin::SpectatorSource source;
    source.rate_hz = std::min(30.0, settings.tick_rate_hz);
    source.scene = [&settings] {
        return scene_json(settings);
    };
    source.sample = [&loop](std::shared_ptr<admin::SpectatorSample> into,
                            std::function<void()> taken) {
        return loop.visit([into = std::move(into), taken = std::move(taken)](const World& world) {
            fill_sample(world, *into);
            taken();
        });
    };
    return source;
}

}  // namespace zoned::app
