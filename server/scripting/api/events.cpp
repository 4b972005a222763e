#include "server/scripting/api/arguments.h"
#include "server/scripting/vm/libraries.h"

#include <algorithm>
#include <string>

namespace zoned::scripting {

namespace {

constexpr std::size_t kMaxPayloadBytes = 16U << 10U;
constexpr std::size_t kMaxLogBytes = 1024;
constexpr std::size_t kEventUnits = 50;
constexpr std::size_t kPayloadBytesPerUnit = 16;

zone::Bytes payload_argument(lua_State* lua, int index) {
    if (lua_isnoneornil(lua, index)) {
        return {};
    }
    const std::string_view text = text_argument(lua, index, "payload", kMaxPayloadBytes);
    Interpreter::charge(lua, text.size() / kPayloadBytesPerUnit);
    return {text.begin(), text.end()};
}

/// kind, payload, { confirm =, durable = } from an index on.
zone::RulesEvent event_argument(lua_State* lua, int index) {
    zone::RulesEvent event;
    event.kind = static_cast<std::uint16_t>(
        integer_argument(lua, index, "kind", zone::kFirstRulesEvent, 0xFFFF));
    event.payload = payload_argument(lua, index + 1);
    if (!lua_isnoneornil(lua, index + 2)) {
        check_fields(lua, index + 2, {"confirm", "durable"});
        lua_getfield(lua, index + 2, "confirm");
        event.confirm = lua_toboolean(lua, -1) != 0;
        lua_getfield(lua, index + 2, "durable");
        event.durable = lua_toboolean(lua, -1) != 0;
    }
    Interpreter::charge(lua, kEventUnits);
    return event;
}

int push_event(lua_State* lua, EventId event) {
    lua_pushinteger(lua, static_cast<lua_Integer>(event.value));
    return 1;
}

/// send(client, kind [, payload [, { confirm =, durable = }]]): the event's number.
int send(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const ClientId client = client_argument(lua, 1);
    luaL_argcheck(lua, static_cast<bool>(client), 1, "client: nobody");
    return push_event(lua, context.send(client, event_argument(lua, 2)));
}

/// publish(topic, kind [, payload [, options]]): to all subscribers.
int publish(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const std::string_view topic = name_argument(lua, 1, "topic");
    return push_event(lua, context.publish(topic, event_argument(lua, 2)));
}

/// announce(entity, kind [, payload [, options]]): to all clients that hear of an entity of this
/// zone; nil where it is not.
int announce(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const EntityId source = entity_argument(lua, 1);
    const zone::RulesEvent event = event_argument(lua, 2);
    if (owned_row(lua, source) == world::kNoRow) {
        lua_pushnil(lua);
        return 1;
    }
    return push_event(lua, context.announce(source, event));
}

/// subscribe(client, topic)
int subscribe(lua_State* lua) {
    changing(lua).subscribe(client_argument(lua, 1), name_argument(lua, 2, "topic"));
    return 0;
}

int unsubscribe(lua_State* lua) {
    changing(lua).unsubscribe(client_argument(lua, 1), name_argument(lua, 2, "topic"));
    return 0;
}

/// message(target, payload): to on_message of the zone that owns the target, next tick.
int message(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const EntityId target = entity_argument(lua, 1, "target");
    Interpreter::charge(lua, kEventUnits);
    context.message(target, payload_argument(lua, 2));
    return 0;
}

/// message_zone(zone, payload): to on_message of that zone's rules, of all for nil; no target.
int message_zone(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const bool all = lua_isnoneornil(lua, 1);
    const ZoneId zone(
        static_cast<std::uint16_t>(all ? 0 : integer_argument(lua, 1, "zone", 1, 0xFFFF)));
    Interpreter::charge(lua, kEventUnits);
    context.message_zone(zone, payload_argument(lua, 2));
    return 0;
}

/// start_timer(entity or nil, seconds, kind [, payload]): the timer's number; nil where none is
/// started.
int start_timer(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const EntityId entity = lua_isnoneornil(lua, 1) ? EntityId() : entity_argument(lua, 1);
    const lua_Number seconds = luaL_checknumber(lua, 2);
    const auto kind = static_cast<std::uint16_t>(integer_argument(lua, 3, "kind", 0, 0xFFFF));
    Interpreter::charge(lua, kEventUnits);
    const zone::TimerId timer =
        context.start_timer(entity, seconds, kind, payload_argument(lua, 4));
    if (timer) {
        lua_pushinteger(lua, static_cast<lua_Integer>(timer.value));
    } else {
        lua_pushnil(lua);
    }
    return 1;
}

/// stop_timer(timer)
int stop_timer(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    Interpreter::charge(lua, kEventUnits);
    context.stop_timer(zone::TimerId(static_cast<std::uint64_t>(luaL_checkinteger(lua, 1))));
    return 0;
}

/// count(name [, amount]): adds to a metric.
int count(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    Interpreter::charge(lua, kEventUnits);
    context.count(name_argument(lua, 1, "name"), luaL_optnumber(lua, 2, 1.0));
    return 0;
}

/// gauge(name, value): sets a metric.
int gauge(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    Interpreter::charge(lua, kEventUnits);
    context.gauge(name_argument(lua, 1, "name"), luaL_checknumber(lua, 2));
    return 0;
}

int reset_view(lua_State* lua) {
    changing(lua).reset_view(client_argument(lua, 1));
    return 0;
}

/// kick(client, reason)
int kick(lua_State* lua) {
    changing(lua).kick(client_argument(lua, 1), name_argument(lua, 2, "reason"));
    return 0;
}

/// travel(client, world [, arrival]): false where the client does not play in this zone, or the
/// server is in no cluster.
int travel(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const ClientId client = client_argument(lua, 1);
    const std::string world(name_argument(lua, 2, "world"));
    const bool arrives = !lua_isnoneornil(lua, 3);
    const std::string arrival(arrives ? name_argument(lua, 3, "arrival") : "");
    lua_pushboolean(lua, context.travel(client, world, arrival) ? 1 : 0);
    return 1;
}

/// print_line(...): a line of the log.
int print_line(lua_State* lua) {
    std::string line;
    for (int i = 1; i <= lua_gettop(lua) && line.size() < kMaxLogBytes; ++i) {
        push_readable(lua, i);
        std::size_t length = 0;
        const char* text = lua_tolstring(lua, -1, &length);
        line.append(i == 1 ? "" : " ").append(text, length);
        lua_pop(lua, 1);
    }
    line.resize(std::min(line.size(), kMaxLogBytes));
    Interpreter::charge(lua, kEventUnits);
    Host::of(lua).log(ScriptLine::kPrinted, line);
    return 0;
}

}  // namespace

void open_events(lua_State* lua) {
    constexpr luaL_Reg kFunctions[] = {{"send", send},
                                       {"publish", publish},
                                       {"announce", announce},
                                       {"subscribe", subscribe},
                                       {"unsubscribe", unsubscribe},
                                       {"message", message},
                                       {"message_zone", message_zone},
                                       {"start_timer", start_timer},
                                       {"stop_timer", stop_timer},
                                       {"count", count},
                                       {"gauge", gauge},
                                       {"reset_view", reset_view},
                                       {"kick", kick},
                                       {"travel", travel},
                                       {"print", print_line},
                                       {nullptr, nullptr}};
    luaL_setfuncs(lua, kFunctions, 0);
}

}  // namespace zoned::scripting
