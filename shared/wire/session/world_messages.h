// WorldMessages: the constants of a world as the login message describes them, and the payloads of
// the server's own events. proto/session.proto says what each field means.
#pragma once

#include "shared/wire/session/message_codec.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace zoned::wire {

struct LodShiftMessage {
    std::uint32_t place = 0;
    std::uint32_t turn = 0;

    static void fields(auto& m, auto& visit) {
        visit(1, m.place);
        visit(2, m.turn);
    }
};

struct QuantizationMessage {
    float position_step_m = 0.0F;
    float velocity_step_mps = 0.0F;
    float acceleration_step_mps2 = 0.0F;
    float angular_velocity_step_rps = 0.0F;
    std::uint32_t orientation_bits = 0;
    std::uint32_t yaw_bits = 0;
    float horizontal_extent_m = 0.0F;
    float vertical_extent_m = 0.0F;
    float max_speed_mps = 0.0F;
    float gravity_mps2 = 0.0F;
    std::vector<LodShiftMessage> lod_shift;

    static void fields(auto& m, auto& visit) {
        visit(1, m.position_step_m);
        visit(2, m.velocity_step_mps);
        visit(3, m.acceleration_step_mps2);
        visit(4, m.angular_velocity_step_rps);
        visit(5, m.orientation_bits);
        visit(6, m.yaw_bits);
        visit(7, m.horizontal_extent_m);
        visit(8, m.vertical_extent_m);
        visit(9, m.max_speed_mps);
        visit(10, m.gravity_mps2);
        visit(11, m.lod_shift);
    }
};

struct CharacterLimitsMessage {
    float radius = 0.0F;
    float half_segment = 0.0F;
    float speed = 0.0F;
    float sprint_factor = 0.0F;
    float acceleration = 0.0F;
    float air_acceleration = 0.0F;
    float jump_speed = 0.0F;
    float max_slope_cos = 0.0F;
    float step_down = 0.0F;
    float gravity = 0.0F;
    float step_up = 0.0F;

    static void fields(auto& m, auto& visit) {
        visit(1, m.radius);
        visit(2, m.half_segment);
        visit(3, m.speed);
        visit(4, m.sprint_factor);
        visit(5, m.acceleration);
        visit(6, m.air_acceleration);
        visit(7, m.jump_speed);
        visit(8, m.max_slope_cos);
        visit(9, m.step_down);
        visit(10, m.gravity);
        visit(11, m.step_up);
    }
};

struct DeclaredFieldMessage {
    std::string name;
    std::int32_t kind = 0;  ///< of an enum: an unknown one may be below 0
    double minimum = 0.0;
    double quantum = 0.0;
    std::uint32_t steps = 0;
    std::vector<std::string> values;
    std::vector<std::uint32_t> initial;
    std::uint32_t interval_ticks = 0;

    static void fields(auto& m, auto& visit) {
        visit(1, m.name);
        visit(2, m.kind);
        visit(3, m.minimum);
        visit(4, m.quantum);
        visit(5, m.steps);
        visit(6, m.values);
        visit(7, m.initial);
        visit(8, m.interval_ticks);
    }
};

struct DeformationMessage {
    std::uint32_t first_field = 0;
    std::vector<std::uint32_t> points;
    std::vector<float> lower;
    std::vector<float> upper;
    float quantum_m = 0.0F;
    float bound_m = 0.0F;

    static void fields(auto& m, auto& visit) {
        visit(1, m.first_field);
        visit(2, m.points);
        visit(3, m.lower);
        visit(4, m.upper);
        visit(5, m.quantum_m);
        visit(6, m.bound_m);
    }
};

struct EntityTypeMessage {
    std::string name;
    bool upright = false;
    float max_acceleration_mps2 = 0.0F;
    float max_velocity_jump_mps = 0.0F;
    bool character = false;
    std::optional<CharacterLimitsMessage> limits;
    std::uint32_t seats = 0;
    std::vector<DeclaredFieldMessage> declared;
    float max_spin_jump_rps = 0.0F;
    std::optional<DeformationMessage> deformation;

    static void fields(auto& m, auto& visit) {
        visit(1, m.name);
        visit(2, m.upright);
        visit(3, m.max_acceleration_mps2);
        visit(4, m.max_velocity_jump_mps);
        visit(5, m.character);
        visit(6, m.limits);
        visit(7, m.seats);
        visit(8, m.declared);
        visit(9, m.max_spin_jump_rps);
        visit(10, m.deformation);
    }
};

struct LodMessage {
    float radius_m = 0.0F;
    float position_bound_m = 0.0F;
    float orientation_bound_rad = 0.0F;

    static void fields(auto& m, auto& visit) {
        visit(1, m.radius_m);
        visit(2, m.position_bound_m);
        visit(3, m.orientation_bound_rad);
    }
};

struct ZoneMessage {
    std::uint32_t id = 0;
    std::vector<double> origin;
    std::vector<double> lower;
    std::vector<double> upper;

    static void fields(auto& m, auto& visit) {
        visit(1, m.id);
        visit(2, m.origin);
        visit(3, m.lower);
        visit(4, m.upper);
    }
};

struct StaticBoxMessage {
    std::vector<float> centre;
    std::vector<float> half_extents;
    std::vector<float> orientation;

    static void fields(auto& m, auto& visit) {
        visit(1, m.centre);
        visit(2, m.half_extents);
        visit(3, m.orientation);
    }
};

struct DoorMessage {
    std::string name;
    std::optional<StaticBoxMessage> box;
    std::int64_t period = 0;
    std::int64_t shift = 0;
    std::vector<std::int64_t> open;
    bool by_rules = false;

    static void fields(auto& m, auto& visit) {
        visit(1, m.name);
        visit(2, m.box);
        visit(3, m.period);
        visit(4, m.shift);
        visit(5, m.open);
        visit(6, m.by_rules);
    }
};

struct PlatformMessage {
    std::string name;
    std::optional<StaticBoxMessage> box;
    std::vector<float> offsets;
    std::vector<std::int64_t> ticks;
    std::int64_t back = 0;
    std::int64_t wait = 0;
    std::int64_t shift = 0;
    bool by_rules = false;
    std::int64_t start = 0;

    static void fields(auto& m, auto& visit) {
        visit(1, m.name);
        visit(2, m.box);
        visit(3, m.offsets);
        visit(4, m.ticks);
        visit(5, m.back);
        visit(6, m.wait);
        visit(7, m.shift);
        visit(8, m.by_rules);
        visit(9, m.start);
    }
};

struct HeightsMessage {
    std::uint32_t columns = 0;
    std::uint32_t rows = 0;
    float spacing_x = 0.0F;
    float spacing_z = 0.0F;
    float thickness = 0.0F;
    std::vector<float> height;

    static void fields(auto& m, auto& visit) {
        visit(1, m.columns);
        visit(2, m.rows);
        visit(3, m.spacing_x);
        visit(4, m.spacing_z);
        visit(5, m.thickness);
        visit(6, m.height);
    }
};

struct TrianglesMessage {
    std::vector<float> vertex;
    std::vector<std::uint32_t> corner;

    static void fields(auto& m, auto& visit) {
        visit(1, m.vertex);
        visit(2, m.corner);
    }
};

struct StaticSurfaceMessage {
    std::string content;
    std::vector<double> position;
    std::vector<float> orientation;
    std::optional<HeightsMessage> heights;
    std::optional<TrianglesMessage> triangles;
    bool replicated = false;

    static void fields(auto& m, auto& visit) {
        visit(1, m.content);
        visit(2, m.position);
        visit(3, m.orientation);
        visit(4, m.heights);
        visit(5, m.triangles);
        visit(6, m.replicated);
    }
};

struct EmitterMessage {
    std::uint64_t seed = 0;
    std::int64_t start_tick = 0;
    double rate_hz = 0.0;
    std::uint64_t most = 0;
    std::vector<float> position;
    float spread = 0.0F;
    std::vector<float> direction;
    float cone_cosine = 0.0F;
    float speed_min = 0.0F;
    float speed_max = 0.0F;
    float lifetime_min_s = 0.0F;
    float lifetime_max_s = 0.0F;

    static void fields(auto& m, auto& visit) {
        visit(1, fixed(m.seed));
        visit(2, m.start_tick);
        visit(3, m.rate_hz);
        visit(4, m.most);
        visit(5, m.position);
        visit(6, m.spread);
        visit(7, m.direction);
        visit(8, m.cone_cosine);
        visit(9, m.speed_min);
        visit(10, m.speed_max);
        visit(11, m.lifetime_min_s);
        visit(12, m.lifetime_max_s);
    }
};

struct BurstKindMessage {
    float cone_cosine = 0.0F;
    float slowest = 0.0F;
    float spread = 0.0F;
    float lifetime_min_s = 0.0F;
    float lifetime_max_s = 0.0F;

    static void fields(auto& m, auto& visit) {
        visit(1, m.cone_cosine);
        visit(2, m.slowest);
        visit(3, m.spread);
        visit(4, m.lifetime_min_s);
        visit(5, m.lifetime_max_s);
    }
};

struct CosmeticSystemMessage {
    std::string name;
    std::vector<float> gravity;
    float drag = 0.0F;
    std::vector<float> wind;
    std::vector<EmitterMessage> emitters;
    std::optional<BurstKindMessage> burst;

    static void fields(auto& m, auto& visit) {
        visit(1, m.name);
        visit(2, m.gravity);
        visit(3, m.drag);
        visit(4, m.wind);
        visit(5, m.emitters);
        visit(6, m.burst);
    }
};

struct SharedClockMessage {
    std::string name;
    double period = 0.0;

    static void fields(auto& m, auto& visit) {
        visit(1, m.name);
        visit(2, m.period);
    }
};

struct PhaseMessage {
    std::string name;
    double value = 0.0;
    double weight = 0.0;
    double min_s = 0.0;
    double max_s = 0.0;

    static void fields(auto& m, auto& visit) {
        visit(1, m.name);
        visit(2, m.value);
        visit(3, m.weight);
        visit(4, m.min_s);
        visit(5, m.max_s);
    }
};

struct SharedVariableMessage {
    std::string name;
    std::uint64_t seed = 0;
    double blend_s = 0.0;
    std::vector<PhaseMessage> phases;

    static void fields(auto& m, auto& visit) {
        visit(1, m.name);
        visit(2, fixed(m.seed));
        visit(3, m.blend_s);
        visit(4, m.phases);
    }
};

struct WorldDescriptionMessage {
    double tick_rate_hz = 0.0;
    std::optional<QuantizationMessage> quantization;
    std::vector<EntityTypeMessage> types;
    std::vector<LodMessage> lods;
    std::vector<ZoneMessage> zones;
    std::vector<StaticBoxMessage> boxes;
    float ground_height_m = 0.0F;
    float interest_hysteresis = 0.0F;
    std::vector<StaticSurfaceMessage> surfaces;
    std::vector<CosmeticSystemMessage> cosmetics;
    std::vector<SharedClockMessage> shared_clocks;
    std::vector<SharedVariableMessage> shared_variables;
    std::vector<DoorMessage> doors;
    std::vector<PlatformMessage> platforms;

    static void fields(auto& m, auto& visit) {
        visit(1, m.tick_rate_hz);
        visit(2, m.quantization);
        visit(3, m.types);
        visit(4, m.lods);
        visit(5, m.zones);
        visit(6, m.boxes);
        visit(7, m.ground_height_m);
        visit(8, m.interest_hysteresis);
        visit(9, m.surfaces);
        visit(10, m.cosmetics);
        visit(60, m.shared_clocks);
        visit(61, m.shared_variables);
        visit(150, m.doors);
        visit(151, m.platforms);
    }
};

// ---------------------------------------------------------------- the server's own events

/// Kinds of the server's own events; kinds from 16 on belong to the rules.
enum CoreEventKind : std::uint32_t {
    kEventZoneEntered = 1,
    kEventParticleBurst = 2,
    kEventSharedEnvironment = 9,
    kEventNotice = 10,
};

struct CourseMessage {
    std::uint32_t clock = 0;
    std::int64_t from = 0;
    double value = 0.0;
    double rate_per_s = 0.0;

    static void fields(auto& m, auto& visit) {
        visit(1, m.clock);
        visit(2, m.from);
        visit(3, m.value);
        visit(4, m.rate_per_s);
    }
};

struct CursorMessage {
    std::uint32_t variable = 0;
    std::uint64_t number = 0;
    std::int64_t since = 0;
    std::uint32_t phase = 0;
    double before = 0.0;

    static void fields(auto& m, auto& visit) {
        visit(1, m.variable);
        visit(2, m.number);
        visit(3, m.since);
        visit(4, m.phase);
        visit(5, m.before);
    }
};

struct DoorCourseMessage {
    std::uint32_t door = 0;
    std::int64_t from = 0;
    bool open = false;

    static void fields(auto& m, auto& visit) {
        visit(1, m.door);
        visit(2, m.from);
        visit(3, m.open);
    }
};

struct PlatformCourseMessage {
    std::uint32_t platform = 0;
    std::int64_t from = 0;
    std::int64_t along = 0;
    std::int64_t to = 0;

    static void fields(auto& m, auto& visit) {
        visit(1, m.platform);
        visit(2, m.from);
        visit(3, m.along);
        visit(4, m.to);
    }
};

struct SharedEnvironmentMessage {
    std::vector<CourseMessage> courses;
    std::vector<CursorMessage> cursors;
    std::vector<DoorCourseMessage> doors;
    std::vector<PlatformCourseMessage> platforms;

    static void fields(auto& m, auto& visit) {
        visit(1, m.courses);
        visit(2, m.cursors);
        visit(3, m.doors);
        visit(4, m.platforms);
    }
};

struct ParticleBurstMessage {
    std::uint32_t system = 0;
    std::uint64_t seed = 0;
    std::vector<float> position;
    std::vector<float> velocity;
    std::uint32_t count = 0;

    static void fields(auto& m, auto& visit) {
        visit(1, m.system);
        visit(2, fixed(m.seed));
        visit(3, m.position);
        visit(4, m.velocity);
        visit(5, m.count);
    }
};

}  // namespace zoned::wire
