#include "server/scripting/api/arguments.h"
#include "server/zone/groups/rules_instances.h"

#include <cstdint>
#include <limits>

namespace zoned::scripting {

namespace {

// About what these cost, in instructions.
constexpr std::size_t kInstanceReadUnits = 20;
constexpr std::size_t kInstanceOrderUnits = 200;
constexpr std::int64_t kMostEntrances = 10'000;

zone::InstanceId instance_argument(lua_State* lua, int index) {
    return zone::InstanceId(static_cast<std::uint32_t>(
        integer_argument(lua, index, "instance", 0, std::numeric_limits<std::uint32_t>::max())));
}

/// open_instance(kind [, asker]): on_instance tells `ready` or `refused`, with the asker. False
/// where there is no such kind.
int open_instance(lua_State* lua) {
    zone::RulesInstances* const instances = changing(lua).instances();
    const std::string_view kind = name_argument(lua, 1, "kind");
    const EntityId asker = lua_isnoneornil(lua, 2) ? EntityId() : entity_argument(lua, 2, "asker");
    Interpreter::charge(lua, kInstanceOrderUnits);
    return push_done(lua, instances != nullptr && instances->open(kind, asker));
}

/// close_instance(instance): its players go back to where they were.
int close_instance(lua_State* lua) {
    zone::RulesInstances* const instances = changing(lua).instances();
    const zone::InstanceId instance = instance_argument(lua, 1);
    Interpreter::charge(lua, kInstanceOrderUnits);
    return push_done(lua, instances != nullptr && instances->close(instance));
}

/// instance_here(): the instance that this zone is; nil where it is none.
int instance_here(lua_State* lua) {
    const zone::RulesInstances* const instances = reading(lua).instances();
    Interpreter::charge(lua, kInstanceReadUnits);
    const zone::InstanceId here = instances != nullptr ? instances->here() : zone::InstanceId();
    if (here) {
        lua_pushinteger(lua, here.value);
    } else {
        lua_pushnil(lua);
    }
    return 1;
}

/// enter_instance(entity, instance [, entrance]): entrances count from 1.
int enter_instance(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    zone::RulesInstances* const instances = context.instances();
    const EntityId player = entity_argument(lua, 1);
    const zone::InstanceId instance = instance_argument(lua, 2);
    const std::int64_t entrance =
        lua_isnoneornil(lua, 3) ? 1 : integer_argument(lua, 3, "entrance", 1, kMostEntrances);
    Interpreter::charge(lua, kInstanceOrderUnits);
    return push_done(
        lua,
        instances != nullptr &&
            instances->enter(context, player, instance, static_cast<std::size_t>(entrance - 1)));
}

/// leave_instance(entity): back to where it came from.
int leave_instance(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    zone::RulesInstances* const instances = context.instances();
    const EntityId player = entity_argument(lua, 1);
    Interpreter::charge(lua, kInstanceOrderUnits);
    return push_done(lua, instances != nullptr && instances->leave(context, player));
}

}  // namespace

void open_instances(lua_State* lua) {
    constexpr luaL_Reg kFunctions[] = {{"open_instance", open_instance},
                                       {"close_instance", close_instance},
                                       {"instance_here", instance_here},
                                       {"enter_instance", enter_instance},
                                       {"leave_instance", leave_instance},
                                       {nullptr, nullptr}};
    luaL_setfuncs(lua, kFunctions, 0);
}

}  // namespace zoned::scripting
