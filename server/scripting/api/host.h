// Host: what the functions that a script calls work on.
#pragma once

#include "server/scripting/script_settings.h"
#include "server/scripting/state/state_table.h"
#include "server/scripting/vm/interpreter.h"
#include "server/zone/groups/party.h"
#include "server/zone/rules.h"

#include <memory>
#include <vector>

namespace zoned::scripting {

struct Host {
    std::shared_ptr<StateTable> shared;     ///< what scripts know as `state`
    std::shared_ptr<StateTable> entities;   ///< the state of each entity, by its id
    zone::RulesContext* context = nullptr;  ///< null while the file runs
    bool may_change = false;                ///< false while the file runs, in may_hear and on_stop
    zone::StopContext* stop = nullptr;      ///< in on_stop alone
    Tick awake_until = 0;
    ScriptLog log;
    std::vector<EntityId> found;         // scratch
    std::vector<zone::PartyId> parties;  // scratch
    std::vector<zone::SeenEntity> seen;  // scratch

    [[nodiscard]] static Host& of(lua_State* lua) {
        return *static_cast<Host*>(Interpreter::of(lua).owner());
    }
};

/// For functions that read: the context of the running call. An error while the file runs.
zone::RulesContext& reading(lua_State* lua);
/// For functions that change something. An error in may_hear, too.
zone::RulesContext& changing(lua_State* lua);

// The functions by subject, each into the table at the top of the stack.

/// The globals `state` and `entity_state`.
void open_state(lua_State* lua);
/// Functions that read: entities, types, the zone and its time.
void open_queries(lua_State* lua);
/// Functions that read: spawn points, entities by type, properties of types.
void open_places(lua_State* lua);
/// Functions that change entities.
void open_actions(lua_State* lua);
/// Joints, motors, forces and seats.
void open_joints(lua_State* lua);
/// Agents: their state, and commands to them.
void open_agents(lua_State* lua);
/// Parties of players.
void open_parties(lua_State* lua);
/// Instances of parts of the map.
void open_instances(lua_State* lua);
/// Matches and the queue for them.
void open_matches(lua_State* lua);
/// Events, topics, messages, timers, the log and metrics.
void open_events(lua_State* lua);
/// The durable store.
void open_store(lua_State* lua);
/// `encode` and `decode`: protobuf messages as tables.
void open_messages(lua_State* lua);

}  // namespace zoned::scripting
