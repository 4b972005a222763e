// Field: an open plain with agents, players and the simplest movement, for tests of AI.
#pragma once

#include "server/ai/agent/decision.h"
#include "server/ai/ai_update.h"
#include "shared/motion/apply_input.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace zoned::ai::test {

inline constexpr float kDt = 1.0F / 30.0F;
inline constexpr TypeIndex kPlayer = 0;
inline constexpr TypeIndex kGuard = 1;
inline constexpr TypeIndex kSheep = 2;

class Field {
  public:
    Field() {
        for (const char* name : {"player", "guard", "sheep"}) {
            world::EntityType type;
            type.name = name;
            type.kind = world::EntityKind::kCharacter;
            type.character.acceleration = 0.0F;  // at once
            types.push_back(type);
        }
        types[kPlayer].character.speed = 5.0F;
        types[kGuard].character.speed = 4.0F;
        types[kSheep].character.speed = 2.0F;
    }

    world::Row add_player(std::uint32_t id, const Vec3& position) {
        const world::Row row = entities.add(EntityId(id), kPlayer);
        entities.position[row] = position;
        entities.set_client(row, ClientId(id));
        return row;
    }

    /// A character with an agent whose home is where it stands.
    void add_npc(std::uint32_t id, TypeIndex type, std::uint16_t brain, const Vec3& position) {
        const world::Row row = entities.add(EntityId(id), type);
        entities.position[row] = position;
        Agent agent;
        agent.entity = EntityId(id);
        agent.brain = brain;
        agent.state_machine = state_machine::ActiveState(now);
        agent.home = position;
        agent.rng = core::Rng(7, id);
        agents.add(agent);
    }

    [[nodiscard]] Vec3& position(std::uint32_t id) {
        return entities.position[entities.find(EntityId(id))];
    }

    [[nodiscard]] const motion::InputCommand& command(std::uint32_t id) const {
        return entities.command[entities.find(EntityId(id))];
    }

    [[nodiscard]] std::uint16_t state(std::uint32_t id) const {
        return agents.find(EntityId(id))->state_machine.leaf;
    }

    [[nodiscard]] float distance(std::uint32_t a, std::uint32_t b) {
        return (position(a) - position(b)).norm();
    }

    /// One tick: agents, then position += wanted velocity * dt. `wall` may undo a move.
    AiReport step() {
        grid.build(entities.position, 8.0F);
        if (settings.compiled.size() != settings.brains.size()) {
            compile(settings, kDt);
        }
        paths.follow_doors(now);
        const AiReport report = steps.run(context());
        for (world::Row row = 0; row < entities.size(); ++row) {
            const motion::InputCommand& c = entities.command[row];
            const motion::CharacterLimits& limits = types[entities.type[row]].character;
            if (solid) {
                walk(row, limits);
                continue;
            }
            const float speed =
                limits.speed *
                ((c.buttons & motion::kButtonSprint) != 0 ? limits.sprint_factor : 1.0F);
            const Vec3 velocity =
                Vec3(static_cast<float>(c.move_x), 0.0F, static_cast<float>(c.move_z)) *
                (speed / 127.0F);
            const Vec3 next = entities.position[row] + velocity * kDt;
            if (!wall || !wall(next)) {
                entities.position[row] = next;
                entities.velocity[row] = velocity;
            } else {
                entities.velocity[row] = Vec3::Zero();
            }
            entities.yaw[row] = c.yaw;
        }
        ++now;
        return report;
    }

    /// The context of this tick's update: all that it reads and moves.
    [[nodiscard]] AiContext context() {
        AiContext ai{agents,
                     settings,
                     entities,
                     types,
                     points_of_interest,
                     statics,
                     team,
                     Vec2(1e6F, 1e6F),
                     now,
                     kDt,
                     [this]() -> const spatial::PointGrid& {
                         return grid;
                     }};
        ai.paths = paths.empty() ? nullptr : &paths;
        ai.near = &grid;
        ai.world = world;
        return ai;
    }

    void run(float seconds) {
        const Tick end = now + static_cast<Tick>(seconds / kDt);
        while (now < end) {
            step();
        }
    }

    world::Entities entities;
    world::TypeTable types;
    spatial::PointGrid grid;
    AgentStore agents;
    AiUpdate steps;
    PointsOfInterest points_of_interest;
    PathService paths;
    motion::StaticGeometry statics;
    bool solid = false;  ///< moves as characters move, past statics and doors
    compute::Team team;
    AiSettings settings;
    Tick now = 0;
    WorldBox world;
    std::function<bool(const Vec3&)> wall;

  private:
    void walk(world::Row row, const motion::CharacterLimits& limits) {
        const motion::CharacterState from{entities.position[row],
                                          entities.velocity[row],
                                          entities.yaw[row],
                                          entities.has(row, world::kGrounded)};
        const motion::CharacterState to =
            motion::apply_input(from, entities.command[row], limits, statics, kDt, now);
        entities.position[row] = to.position;
        entities.velocity[row] = to.velocity;
        entities.yaw[row] = to.yaw;
        entities.set(row, world::kGrounded, to.grounded);
    }
};

/// A box that leans by `lean` (rad) about the z axis.
inline motion::StaticBox slab(const Vec3& centre, const Vec3& half, float lean = 0.0F) {
    motion::StaticBox box;
    box.centre = centre;
    box.half_extents = half;
    box.orientation = Quat(Eigen::AngleAxisf(lean, Vec3::UnitZ()));
    return box;
}

/// A decision by a brain as written.
inline bool decide(Agent& agent,
                   const Brain& brain,
                   const Percept& percept,
                   const Vec3& position,
                   Tick now,
                   float dt) {
    DecisionScratch scratch;
    const Vec2 here(position.x(), position.z());
    return ai::decide(agent, compile(brain, dt), percept, here, PointsOfInterest(), now, scratch);
}

/// One state, no transitions.
inline Brain single(ActionKind action, float radius = 20.0F) {
    Brain brain;
    brain.name = "single";
    brain.states.emplace_back();
    brain.states[0].action = action;
    brain.states[0].radius_m = radius;
    return brain;
}

enum GuardState : std::uint16_t {
    kOnPatrol = 0,
    kOnChase = 1,
    kOnReturn = 2
};

/// Patrols; chases a player nearer than 15 m; gives up beyond 20 m (both held for 0.4 s); walks
/// home; patrols.
inline Brain guard_brain() {
    Brain brain;
    brain.name = "guard";
    brain.perception_m = 40.0F;
    brain.states.resize(3);
    BrainState& patrol = brain.states[kOnPatrol];
    patrol.action = ActionKind::kPatrol;
    patrol.radius_m = 8.0F;
    patrol.speed_factor = 0.5F;
    patrol.transitions = {{kOnChase, Sensor::kPlayerDistance, Compare::kBelow, 15.0F, 0.4F}};
    BrainState& chase = brain.states[kOnChase];
    chase.action = ActionKind::kChase;
    chase.sprint = true;
    chase.stance = 2;
    chase.transitions = {{kOnReturn, Sensor::kPlayerDistance, Compare::kAbove, 20.0F, 0.4F}};
    BrainState& back = brain.states[kOnReturn];
    back.action = ActionKind::kReturn;
    back.transitions = {{kOnChase, Sensor::kPlayerDistance, Compare::kBelow, 15.0F, 0.4F},
                        {kOnPatrol, Sensor::kHomeDistance, Compare::kBelow, 2.0F, 0.0F}};
    return brain;
}

}  // namespace zoned::ai::test
