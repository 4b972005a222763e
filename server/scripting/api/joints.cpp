#include "server/scripting/api/arguments.h"

#include <array>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

namespace zoned::scripting {

namespace {

constexpr float kMaxForce = 1e9F;
constexpr float kMaxTarget = 1e6F;
constexpr std::int64_t kMaxSeats = 1000;
constexpr float kMaxAnchor = 1e5F;
constexpr std::size_t kJoinUnits = 500;

zone::EntityJointId joint_argument(lua_State* lua, int index) {
    return zone::EntityJointId(static_cast<std::uint32_t>(
        integer_argument(lua, index, "joint", 0, std::numeric_limits<std::uint32_t>::max())));
}

/// A rigid prop of this zone that is in the world.
bool is_rigid(lua_State* lua, EntityId entity) {
    const world::Row row = owned_row(lua, entity);
    const world::Entities& entities = reading(lua).entities();
    return row != world::kNoRow && !entities.has(row, world::kHidden) &&
           reading(lua).types()[entities.type[row]].kind == world::EntityKind::kProp &&
           reading(lua).types()[entities.type[row]].shape != world::TypeShape::kSoft;
}

/// parts_of(root)
int parts_of(lua_State* lua) {
    std::vector<EntityId>& parts = Host::of(lua).found;
    reading(lua).parts_of(entity_argument(lua, 1, "root"), parts);
    Interpreter::charge(lua, parts.size());
    lua_createtable(lua, static_cast<int>(parts.size()), 0);
    for (std::size_t i = 0; i < parts.size(); ++i) {
        push_entity(lua, parts[i]);
        lua_rawseti(lua, -2, static_cast<lua_Integer>(i + 1));
    }
    return 1;
}

/// assembly_root(part)
int assembly_root(lua_State* lua) {
    push_entity(lua, reading(lua).assembly_root(entity_argument(lua, 1, "part")));
    return 1;
}

/// joint_named(root, name): nil where there is none, or it is gone. Root nil: placed joints.
int joint_named(lua_State* lua) {
    const zone::EntityJointId joint =
        reading(lua).joint_named(entity_argument(lua, 1, "root"), name_argument(lua, 2, "name"));
    push_entity(lua, EntityId(joint.value));
    return 1;
}

/// joint(joint): position, force_n, a, b, target of its motor or nil; nil where it is gone.
int joint(lua_State* lua) {
    const auto reading_of = reading(lua).joint(joint_argument(lua, 1));
    if (!reading_of) {
        lua_pushnil(lua);
        return 1;
    }
    lua_pushnumber(lua, static_cast<lua_Number>(reading_of->position));
    lua_pushnumber(lua, static_cast<lua_Number>(reading_of->force_n));
    push_entity(lua, reading_of->a);
    push_entity(lua, reading_of->b);
    if (reading_of->motor) {
        lua_pushnumber(lua, static_cast<lua_Number>(reading_of->target));
    } else {
        lua_pushnil(lua);
    }
    return 5;
}

int has_joints(lua_State* lua) {
    return push_done(lua, reading(lua).has_joints(entity_argument(lua, 1)));
}

physics::JointKind kind_argument(lua_State* lua, int index) {
    constexpr std::array<std::string_view, 6> kKinds = {
        "ball", "hinge", "slider", "fixed", "distance", "spring"};
    const std::string_view name = name_argument(lua, index, "kind");
    for (std::size_t i = 0; i < kKinds.size(); ++i) {
        if (kKinds[i] == name) {
            return static_cast<physics::JointKind>(i);
        }
    }
    luaL_argerror(lua, index, "kind: ball, hinge, slider, fixed, distance or spring is wanted");
    __builtin_unreachable();
}

constexpr unsigned bit_of(physics::JointKind kind) {
    return 1U << static_cast<unsigned>(kind);
}

constexpr unsigned kBalls = bit_of(physics::JointKind::kBall);
constexpr unsigned kAxles =
    bit_of(physics::JointKind::kHinge) | bit_of(physics::JointKind::kSlider);
constexpr unsigned kSprings = bit_of(physics::JointKind::kSpring);
constexpr unsigned kRods = bit_of(physics::JointKind::kDistance) | kSprings;
constexpr unsigned kAllJoints = ~0U;

struct JointOption {
    std::string_view name;
    unsigned kinds = 0;  ///< bits of those that have it
};

constexpr std::array<JointOption, 15> kJointOptions = {{{"name", kAllJoints},
                                                        {"anchor", kAllJoints},
                                                        {"break_force_n", kAllJoints},
                                                        {"collide", kAllJoints},
                                                        {"axis", kBalls | kAxles},
                                                        {"lower", kBalls | kAxles},
                                                        {"upper", kBalls | kAxles},
                                                        {"friction", kBalls | kAxles},
                                                        {"cone_axis", kBalls},
                                                        {"cone_rad", kBalls},
                                                        {"motor", kAxles},
                                                        {"anchor_b", kRods},
                                                        {"length_m", kRods},
                                                        {"spring_hz", kSprings},
                                                        {"spring_damping_ratio", kSprings}}};

void check_joint_options(lua_State* lua, int options, physics::JointKind kind) {
    std::array<std::string_view, kJointOptions.size()> names;
    std::size_t count = 0;
    for (const JointOption& option : kJointOptions) {
        if ((option.kinds & bit_of(kind)) != 0) {
            names[count++] = option.name;
        }
    }
    check_fields(lua, options, std::span(names).first(count));
}

/// { x, y, z }
void read_joint_vector(lua_State* lua, int options, const char* name, Vec3& out) {
    read_option(lua, options, name, [&](int at) {
        luaL_checktype(lua, at, LUA_TTABLE);
        for (int axis = 1; axis <= 3; ++axis) {
            lua_geti(lua, at, axis);
        }
        out = vector_argument(lua, at + 1, name, kMaxAnchor);
        lua_pop(lua, 3);
    });
}

/// False where it is not given.
bool read_joint_number(lua_State* lua, int options, const char* name, float most, float& out) {
    bool given = false;
    read_option(lua, options, name, [&](int at) {
        out = number_argument(lua, at, name, most);
        given = true;
    });
    return given;
}

/// { speed = or position =, most =, max_speed = }
void read_joint_motor(lua_State* lua, int motor, zone::JointPlan& plan) {
    check_fields(lua, motor, {"speed", "position", "most", "max_speed"});
    zone::MotorDef& out = plan.motor.emplace();
    const bool turns = read_joint_number(lua, motor, "speed", kMaxTarget, out.target.mean);
    out.holds_position = read_joint_number(lua, motor, "position", kMaxTarget, out.target.mean);
    luaL_argcheck(
        lua, turns != out.holds_position, motor, "motor: either speed or position is wanted");
    read_joint_number(lua, motor, "most", kMaxForce, out.most);
    luaL_argcheck(lua, out.most > 0.0F, motor, "motor: most must be above 0");
    read_joint_number(lua, motor, "max_speed", kMaxTarget, out.max_speed);
    luaL_argcheck(lua,
                  !out.holds_position || out.max_speed > 0.0F,
                  motor,
                  "motor: with position, max_speed must be above 0");
    luaL_argcheck(lua,
                  !out.holds_position || !plan.def.limited ||
                      (out.target.mean >= plan.def.lower && out.target.mean <= plan.def.upper),
                  motor,
                  "motor: its position is outside the limits");
}

void read_joint_options(lua_State* lua, int options, zone::JointPlan& plan) {
    physics::JointDef& def = plan.def;
    check_joint_options(lua, options, def.kind);
    read_option(lua, options, "name", [&](int at) { plan.name = name_argument(lua, at, "name"); });
    read_option(
        lua, options, "collide", [&](int at) { def.collide = truth_argument(lua, at, "collide"); });
    read_joint_vector(lua, options, "anchor", def.anchor);
    read_joint_vector(lua, options, "anchor_b", def.anchor_b);
    read_joint_vector(lua, options, "axis", def.axis);
    read_joint_vector(lua, options, "cone_axis", def.cone_axis);
    read_joint_number(lua, options, "break_force_n", kMaxForce, def.break_force_n);
    read_joint_number(lua, options, "cone_rad", kMaxTarget, def.cone_rad);
    read_joint_number(lua, options, "length_m", kMaxTarget, def.length_m);
    read_joint_number(lua, options, "spring_hz", kMaxTarget, def.spring_hz);
    read_joint_number(lua, options, "spring_damping_ratio", kMaxTarget, def.spring_damping_ratio);
    def.limited = read_joint_number(lua, options, "lower", kMaxTarget, def.lower);
    luaL_argcheck(lua,
                  def.limited == read_joint_number(lua, options, "upper", kMaxTarget, def.upper),
                  options,
                  "lower and upper: give both, or none");
    // Friction is a motor that wants to stand still.
    def.motor = read_joint_number(lua, options, "friction", kMaxForce, def.motor_max);
    read_option(lua, options, "motor", [&](int at) {
        luaL_argcheck(lua, !def.motor, options, "friction: a joint has either friction or a motor");
        read_joint_motor(lua, at, plan);
    });
}

/// add_joint(a, b, kind [, options]): joins two entities as they are, or `b` and the world (`a`
/// nil). Nil where one of them takes no joint; an error where a number is out of range.
int add_joint(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const EntityId a = entity_argument(lua, 1, "a");
    const EntityId b = entity_argument(lua, 2, "b");
    zone::JointPlan plan;
    plan.def.kind = kind_argument(lua, 3);
    if (!lua_isnoneornil(lua, 4)) {
        read_joint_options(lua, 4, plan);
    }
    const std::string unfit = physics::why_unfit(plan.def);
    luaL_argcheck(lua, unfit.empty(), 4, lua_pushstring(lua, unfit.c_str()));
    Interpreter::charge(lua, kJoinUnits);
    push_entity(lua, EntityId(context.add_joint(a, b, plan).value));
    return 1;
}

/// remove_joint(joint): false where it is gone.
int remove_joint(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const zone::EntityJointId id = joint_argument(lua, 1);
    const bool is_there = context.joint(id).has_value();
    if (is_there) {
        context.remove_joint(id);
    }
    return push_done(lua, is_there);
}

/// set_motor_target(joint, target)
int set_motor_target(lua_State* lua) {
    return push_done(lua,
                     changing(lua).set_motor_target(joint_argument(lua, 1),
                                                    number_argument(lua, 2, "target", kMaxTarget)));
}

/// apply_force(entity, fx, fy, fz, x, y, z): N, at a point.
int apply_force(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const EntityId entity = entity_argument(lua, 1);
    const Vec3 force = vector_argument(lua, 2, "force", kMaxForce);
    const Vec3 point = position_argument(lua, 5);
    const bool can = is_rigid(lua, entity);
    if (can) {
        context.apply_force(entity, force, point);
    }
    return push_done(lua, can);
}

/// apply_torque(entity, tx, ty, tz): N m
int apply_torque(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const EntityId entity = entity_argument(lua, 1);
    const Vec3 torque = vector_argument(lua, 2, "torque", kMaxForce);
    const bool can = is_rigid(lua, entity);
    if (can) {
        context.apply_torque(entity, torque);
    }
    return push_done(lua, can);
}

/// apply_impulse(entity, ix, iy, iz, x, y, z): N s, at a point.
int apply_impulse(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const EntityId entity = entity_argument(lua, 1);
    const Vec3 impulse = vector_argument(lua, 2, "impulse", kMaxForce);
    const Vec3 point = position_argument(lua, 5);
    const bool can = is_rigid(lua, entity);
    if (can) {
        context.apply_impulse(entity, impulse, point);
    }
    return push_done(lua, can);
}

/// mount(rider, root, seat): seats count from 1, which drives.
int mount(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const EntityId rider = entity_argument(lua, 1, "rider");
    const EntityId root = entity_argument(lua, 2, "root");
    const std::int64_t seat = integer_argument(lua, 3, "seat", 1, kMaxSeats);
    const bool can = owned_row(lua, rider) != world::kNoRow &&
                     owned_row(lua, root) != world::kNoRow &&
                     static_cast<std::size_t>(seat) <= context.seats_of(root);
    return push_done(lua, can && context.mount(rider, root, static_cast<std::size_t>(seat - 1)));
}

/// dismount(rider, x, y, z): it walks again from there.
int dismount(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const EntityId rider = entity_argument(lua, 1, "rider");
    const Vec3 to = position_argument(lua, 2);
    const bool can =
        owned_row(lua, rider) != world::kNoRow && static_cast<bool>(context.carrier_of(rider));
    if (can) {
        context.dismount(rider, to);
    }
    return push_done(lua, can);
}

int carrier_of(lua_State* lua) {
    push_entity(lua, reading(lua).carrier_of(entity_argument(lua, 1, "rider")));
    return 1;
}

int seats_of(lua_State* lua) {
    lua_pushinteger(
        lua, static_cast<lua_Integer>(reading(lua).seats_of(entity_argument(lua, 1, "root"))));
    return 1;
}

}  // namespace

void open_joints(lua_State* lua) {
    constexpr luaL_Reg kFunctions[] = {{"parts_of", parts_of},
                                       {"assembly_root", assembly_root},
                                       {"joint_named", joint_named},
                                       {"joint", joint},
                                       {"has_joints", has_joints},
                                       {"add_joint", add_joint},
                                       {"remove_joint", remove_joint},
                                       {"set_motor_target", set_motor_target},
                                       {"apply_force", apply_force},
                                       {"apply_torque", apply_torque},
                                       {"apply_impulse", apply_impulse},
                                       {"mount", mount},
                                       {"dismount", dismount},
                                       {"carrier_of", carrier_of},
                                       {"seats_of", seats_of},
                                       {nullptr, nullptr}};
    luaL_setfuncs(lua, kFunctions, 0);
}

}  // namespace zoned::scripting
