#include "client-sim/view/own_avatar.h"

#include <algorithm>

namespace zoned::view {

motion::CharacterLimits OwnAvatar::limits() const {
    // A player's avatar is of the type named so, or of the first character type.
    const TypeInfo* character = nullptr;
    for (const TypeInfo& type : world_->types) {
        if (type.character && type.name == "player") {
            return type.limits;
        }
        if (type.character && character == nullptr) {
            character = &type;
        }
    }
    return character != nullptr ? character->limits : motion::CharacterLimits{};
}

Vec3d OwnAvatar::world_position(const CommandSlot& slot) const {
    const ZoneInfo* zone = world_->zone(slot.zone);
    const Vec3d local = slot.state.position.cast<double>();
    return zone != nullptr ? Vec3d(zone->origin + local) : local;
}

void OwnAvatar::put_state(Tick tick, ZoneId zone, const motion::CharacterState& state) {
    CommandSlot& s = slot(tick);
    s.state_tick = tick;
    s.zone = zone;
    s.state = state;
}

void OwnAvatar::advance_to(Tick tick) {
    const ZoneInfo* zone = world_->zone(zone_);
    if (zone == nullptr || state_tick_ < 0) {
        return;
    }
    const motion::CharacterLimits body = limits();
    const auto dt = static_cast<float>(world_->tick_s);
    motion::InputCommand command = slot(state_tick_).command;
    for (Tick t = state_tick_ + 1; t <= tick; ++t) {
        if (slot(t).command_tick == t) {
            command = slot(t).command;
        }
        command.tick = t;
        const motion::CharacterState next =
            motion::apply_input(slot(t - 1).state, command, body, zone->geometry, dt, t);
        put_state(t, zone_, next);
    }
    state_tick_ = std::max(state_tick_, tick);
}

void OwnAvatar::push(const motion::InputCommand& command) {
    if (command.tick <= newest_tick_ || command.tick < 0) {
        return;
    }
    CommandSlot& s = slot(command.tick);
    s.command = command;
    s.command_tick = command.tick;
    newest_tick_ = command.tick;
    if (known() && command.tick > state_tick_) {
        // A jump longer than the ring leaves nothing to replay from: the next state of the server
        // begins anew.
        if (command.tick - state_tick_ < static_cast<Tick>(kRing) - 1) {
            advance_to(command.tick);
        } else {
            base_tick_ = -1;
            state_tick_ = -1;
        }
    }
}

Correction OwnAvatar::reconcile(const wire::OwnState& own, ZoneId zone) {
    Correction result;
    const bool other = own.avatar != id_;
    if ((!other && own.input_tick <= base_tick_) || world_->zone(zone) == nullptr ||
        own.input_tick < 0) {
        return result;
    }
    result.applied = true;
    result.tick = own.input_tick;
    CommandSlot& s = slot(own.input_tick);
    if (!other && known() && s.state_tick == own.input_tick && own.input_tick <= state_tick_) {
        const Vec3d truth = world_->zone(zone)->origin + own.state.position.cast<double>();
        result.compared = true;
        result.distance_m = (world_position(s) - truth).norm();
        const bool same = s.zone == zone && s.state.position == own.state.position &&
                          s.state.velocity == own.state.velocity &&
                          s.state.grounded == own.state.grounded &&
                          s.state.carried == own.state.carried;
        if (same) {
            base_tick_ = own.input_tick;
            return result;
        }
    }
    id_ = own.avatar;
    zone_ = zone;
    base_tick_ = own.input_tick;
    put_state(own.input_tick, zone, own.state);
    if (s.command_tick != own.input_tick) {
        // The command of a tick that was never sent: standing still is what the server began with.
        // The ring may hold the command of another tick here, which must not pass for this one.
        s.command_tick = -1;
        s.command = {};
        s.command.yaw = own.state.yaw;
    }
    state_tick_ = own.input_tick;
    if (newest_tick_ > own.input_tick &&
        newest_tick_ - own.input_tick < static_cast<Tick>(kRing) - 1) {
        advance_to(newest_tick_);
    }
    return result;
}

std::span<const motion::InputCommand> OwnAvatar::newest_commands(std::size_t count) {
    count = std::min(count, recent_.size());
    std::size_t have = 0;
    while (have < count && newest_tick_ - static_cast<Tick>(have) >= 0 &&
           slot(newest_tick_ - static_cast<Tick>(have)).command_tick ==
               newest_tick_ - static_cast<Tick>(have)) {
        ++have;
    }
    for (std::size_t i = 0; i < have; ++i) {
        recent_[i] = slot(newest_tick_ - static_cast<Tick>(have - 1 - i)).command;
    }
    return {recent_.data(), have};
}

std::optional<Vec3d> OwnAvatar::position_at(Tick tick) const {
    if (tick < 0 || slot(tick).state_tick != tick) {
        return std::nullopt;
    }
    return world_position(slot(tick));
}

Vec3d OwnAvatar::position_between(double fraction) const {
    const Vec3d newest = position();
    const Vec3d before = position_at(state_tick_ - 1).value_or(newest);
    // A longer step is a teleport.
    return (newest - before).norm() < kSnapM ? Vec3d(before + fraction * (newest - before))
                                             : newest;
}

Vec3d OwnAvatar::position() const {
    return state_tick_ >= 0 ? world_position(slot(state_tick_)) : Vec3d::Zero();
}

}  // namespace zoned::view
