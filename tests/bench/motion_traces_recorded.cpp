#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/zone/context/zone_context.h"
#include "tests/bench/motion_traces.h"
#include "tests/bench/public_data.h"
#include "shared/core/rng.h"
#include "shared/math/turn_rate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

namespace zoned::bench {

namespace {

/// z is up in the data.
Vec3 cube_place(const CubeRecord& cube) {
    constexpr float kUnit = 1.0F / 512.0F;
    return kUnit * Vec3(static_cast<float>(cube[4]),
                        static_cast<float>(cube[6]),
                        -static_cast<float>(cube[5]));
}

Quat cube_turn(const CubeRecord& cube) {
    // Nine bits for -1 / sqrt 2 .. 1 / sqrt 2; the largest of x, y, z, w is left out.
    std::array<float, 4> q{};
    float rest = 1.0F;
    int slot = 1;
    for (int i = 0; i < 4; ++i) {
        if (i != cube[0]) {
            q[static_cast<std::size_t>(i)] =
                (static_cast<float>(cube[slot++]) / 511.0F * 2.0F - 1.0F) * 0.70710678F;
            rest -= q[static_cast<std::size_t>(i)] * q[static_cast<std::size_t>(i)];
        }
    }
    q[static_cast<std::size_t>(cube[0])] = std::sqrt(std::max(0.0F, rest));
    return Quat(q[3], q[0], q[2], -q[1]).normalized();
}

/// Whether a cube is where and as it was; its other fields do not count.
bool same_pose(const CubeRecord& a, const CubeRecord& b) {
    return std::equal(a.begin(), a.end() - 1, b.begin());
}

TracedState cube_state(const std::vector<CubeRecord>& data, std::size_t frame, std::size_t cube) {
    const auto at = [&](std::size_t f) -> const CubeRecord& {
        return data[f * kCubes + cube];
    };
    constexpr float kSpan = 4.0F / 60.0F;
    const Vec3 here = cube_place(at(frame));
    const Vec3 before = cube_place(at(frame - 2));
    const Vec3 after = cube_place(at(frame + 2));
    TracedState s;
    s.state.position = here;
    s.state.orientation = cube_turn(at(frame));
    s.at_rest = same_pose(at(frame - 2), at(frame + 2)) && same_pose(at(frame - 2), at(frame));
    if (!s.at_rest) {
        s.state.velocity = (after - before) / kSpan;
        s.state.acceleration = (after - 2.0F * here + before) / (0.25F * kSpan * kSpan);
        s.state.angular_velocity =
            turn_rate(cube_turn(at(frame - 2)), cube_turn(at(frame + 2)), kSpan);
    }
    return s;
}

}  // namespace

MotionTrace cubes_trace(const std::string& which, int ticks, std::string& why) {
    MotionTrace trace;
    trace.motion = "cubes901_" + which;
    trace.tick_s = 1.0F / 60.0F;
    trace.type.name = "cube";
    trace.type.shape = world::TypeShape::kBox;
    trace.type.half_extents = Vec3::Constant(0.2F);
    trace.type.max_acceleration_mps2 = 100.0F;  // they bump
    trace.type.max_velocity_jump_mps = 40.0F;
    trace.ground = std::make_shared<const motion::StaticGeometry>();
    const std::vector<CubeRecord> data =
        read_cubes(which, static_cast<std::size_t>(ticks) + 4, why);
    const std::size_t frames = data.size() / kCubes;
    for (std::size_t frame = 2; frame + 2 < frames; ++frame) {
        auto& states = trace.frames.emplace_back();
        for (std::size_t cube = 0; cube < kCubes; ++cube) {
            states.push_back(cube_state(data, frame, cube));
        }
    }
    return trace;
}

// ---------------------------------------------------------------- the valley

namespace {

TracedState state_in(const world::Entities& entities, world::Row row) {
    return {entities.kinematic(row), entities.has(row, world::kAtRest)};
}

/// Sets props off, in turn, so that at any time some of them fly, roll and come to rest.
void throw_prop(zone::ZoneState& state, EntityId entity, core::Rng& rng) {
    const float x = rng.range(-4.0F, 4.0F);
    const float y = rng.range(1.0F, 6.0F);
    zone::ZoneContext context(state);
    context.add_velocity(entity, Vec3(x, y, rng.range(-4.0F, 4.0F)));
}

/// The motion of each chosen entity so far; entities that left the zone are dropped.
using Recordings = std::map<EntityId, std::vector<TracedState>>;

/// Of the first zone, whose ground is the trace's.
Recordings recorded_entities(const zone::ZoneState& state, bool characters, std::size_t most) {
    Recordings out;
    const world::Entities& e = state.entities;
    for (world::Row row = 0; row < e.size() && out.size() < most; ++row) {
        const world::EntityType& type = (*state.settings.types)[e.type[row]];
        const bool is_character = type.kind == world::EntityKind::kCharacter;
        if (is_character == characters && !e.has(row, world::kGhost) && e.body[row]) {
            out[e.id[row]];
        }
    }
    return out;
}

}  // namespace

MotionTrace valley_trace(bool characters, std::size_t most, int ticks) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    if (!config::load_settings(ZONED_SOURCE_DIR "/config/valley.txtpb", {}, settings, errors)) {
        throw std::runtime_error(config::format_errors("valley.txtpb", errors));
    }
    app::World world(settings, 1);
    std::vector<mailbox::OutboxItem> out;
    MotionTrace trace;
    trace.motion = characters ? "valley_characters" : "valley_props";
    trace.tick_s = settings.replication.tick_s;
    trace.gravity_mps2 = settings.replication.quantization.gravity_mps2;
    zone::ZoneState& state = world.zones()[0]->state();
    Recordings recordings = recorded_entities(state, characters, most);
    core::Rng rng(253);
    for (int tick = 0; tick < ticks; ++tick) {
        std::size_t turn = 0;
        for (const auto& [id, states] : recordings) {
            const bool due = (static_cast<std::size_t>(tick) + 13 * turn++) % 150 == 0;
            if (due && !characters && state.entities.find(id) != world::kNoRow) {
                throw_prop(state, id, rng);
            }
        }
        out.clear();
        world.tick({}, out);
        const world::Entities& e = state.entities;
        for (auto it = recordings.begin(); it != recordings.end();) {
            const world::Row row = e.find(it->first);
            if (row == world::kNoRow || e.has(row, world::kGhost)) {
                it = recordings.erase(it);
            } else {
                it++->second.push_back(state_in(e, row));
            }
        }
    }
    // Each type has its own limits; the promise to all of them is the loosest.
    trace.type.kind = characters ? world::EntityKind::kCharacter : world::EntityKind::kProp;
    trace.type.shape = characters ? world::TypeShape::kCapsule : world::TypeShape::kBox;
    trace.type.half_extents = Vec3::Constant(0.3F);
    for (const world::EntityType& type : *state.settings.types) {
        if ((type.kind == world::EntityKind::kCharacter) == characters) {
            trace.type.max_acceleration_mps2 =
                std::max(trace.type.max_acceleration_mps2, type.max_acceleration_mps2);
            trace.type.max_velocity_jump_mps =
                std::max(trace.type.max_velocity_jump_mps, type.max_velocity_jump_mps);
        }
    }
    trace.frames.resize(static_cast<std::size_t>(ticks));
    for (const auto& [id, states] : recordings) {
        for (std::size_t tick = 0; tick < trace.frames.size(); ++tick) {
            trace.frames[tick].push_back(states[tick]);
        }
    }
    trace.ground = state.settings.statics;
    return trace;
}

}  // namespace zoned::bench
