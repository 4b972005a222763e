// OwnAvatar: prediction of the client's own character from its inputs, reconciled with the server's
// states.
#pragma once

#include "client-sim/view/world_info.h"
#include "shared/motion/apply_input.h"
#include "shared/wire/packet.h"

#include <array>
#include <cstddef>
#include <optional>
#include <span>

namespace zoned::view {

/// Result of one reconciliation.
struct Correction {
    bool applied = false;     ///< the own state was new
    bool compared = false;    ///< there was a prediction for that tick
    double distance_m = 0.0;  ///< between prediction and truth at that tick
    Tick tick = 0;            ///< the tick of that state
};

class OwnAvatar {
  public:
    static constexpr std::size_t kRing = 256;
    /// Longer steps within a tick are shown at once, m.
    static constexpr double kSnapM = 4.0;

    explicit OwnAvatar(const WorldInfo& world) : world_(&world) {}

    /// Remembers the command for its tick and predicts the state after it. Ticks ascend; a gap is
    /// bridged with the last command, as the server does.
    void push(const motion::InputCommand& command);

    /// The server's state after `own.input_tick`: replays the newer commands from there. States
    /// that are older than the newest one known are ignored.
    Correction reconcile(const wire::OwnState& own, ZoneId zone);

    /// The newest `count` commands (fewer in the beginning), oldest first, consecutive ticks.
    [[nodiscard]] std::span<const motion::InputCommand> newest_commands(std::size_t count);

    /// True once the server has sent a state.
    [[nodiscard]] bool known() const { return base_tick_ >= 0; }

    [[nodiscard]] EntityId id() const { return id_; }

    [[nodiscard]] ZoneId zone() const { return zone_; }

    /// World position after a tick's command; nullopt for a tick that was not predicted.
    [[nodiscard]] std::optional<Vec3d> position_at(Tick tick) const;
    /// World position after the newest command; the origin before known().
    [[nodiscard]] Vec3d position() const;

    /// Its state after the newest command in coordinates of its zone; nullptr before known().
    [[nodiscard]] const motion::CharacterState* state() const {
        return state_tick_ >= 0 ? &slot(state_tick_).state : nullptr;
    }

    /// World position on the way from the state before the newest one to it, 0..1.
    [[nodiscard]] Vec3d position_between(double fraction) const;

    /// Whether it moves straight on whatever its commands (CharacterState), after the newest one.
    [[nodiscard]] bool carried() const {
        return state_tick_ >= 0 && slot(state_tick_).state.carried;
    }

    /// Limits of the own body.
    [[nodiscard]] motion::CharacterLimits limits() const;

    [[nodiscard]] Tick newest_tick() const { return newest_tick_; }

  private:
    struct CommandSlot {
        Tick command_tick = -1;
        motion::InputCommand command;
        Tick state_tick = -1;
        ZoneId zone;
        motion::CharacterState state;
    };

    [[nodiscard]] CommandSlot& slot(Tick tick) {
        return ring_[static_cast<std::size_t>(tick) % kRing];
    }

    [[nodiscard]] const CommandSlot& slot(Tick tick) const {
        return ring_[static_cast<std::size_t>(tick) % kRing];
    }

    void advance_to(Tick tick);
    void put_state(Tick tick, ZoneId zone, const motion::CharacterState& state);
    [[nodiscard]] Vec3d world_position(const CommandSlot& slot) const;

    const WorldInfo* world_;
    EntityId id_;
    ZoneId zone_;
    Tick base_tick_ = -1;    // of the newest state from the server
    Tick state_tick_ = -1;   // newest predicted tick
    Tick newest_tick_ = -1;  // newest command
    std::array<CommandSlot, kRing> ring_{};
    std::array<motion::InputCommand, wire::kMaxCommandsPerPacket> recent_{};
};

}  // namespace zoned::view
