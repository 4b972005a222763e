// Callbacks: the functions that a script may define, by the names that they have there.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace zoned::scripting {

enum class Callback : std::uint8_t {
    kStart,
    kStop,
    kJoin,
    kLeave,
    kCommand,
    kInput,
    kContact,
    kJointBroken,
    kTrigger,
    kUse,
    kTimer,
    kParty,
    kMatch,
    kInstance,
    kTick,
    kConfirm,
    kMessage,
    kStore,
    kMayHear,
};

inline constexpr std::array<std::string_view, 19> kCallbackNames{
    "on_start",  // ()                     in the first tick of a zone's life
    "on_stop",  // ()                     after the last tick; reads, store_put, store_remove, print
    "on_join",  // (client, avatar, name, team, account)
    "on_leave",         // (client, avatar)       it still stands there; nobody despawns it
    "on_command",       // (client, avatar, kind, payload)
    "on_input",         // (avatar, move_x, move_z, buttons, pressed, yaw, pitch)
    "on_contact",       // (a, b, speed, impulse, x, y, z, began, ended)
    "on_joint_broken",  // (joint, a, b, root, name, force)
    "on_trigger",       // (trigger, entity, entered)
    "on_use",           // (lever, avatar, on)
    "on_timer",         // (timer, entity, kind, payload)
    "on_party",         // (event, party, player, other, name, client, refusal)
    "on_match",         // (event, match, kind, player, team, refusal)
    "on_instance",      // (event, instance, kind, player)
    "on_tick",          // ()
    "on_confirm",       // (client, event)
    "on_message",       // (target, payload)
    "on_store",         // (request, status, value, key, account, character)
    "may_hear",         // (viewer, entity) -> true or false
};
inline constexpr std::size_t kCallbacks = kCallbackNames.size();

constexpr std::string_view name_of(Callback callback) {
    return kCallbackNames[static_cast<std::size_t>(callback)];
}

}  // namespace zoned::scripting
