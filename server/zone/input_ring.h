// InputRing: commands of one client, stored for their tick and consumed by the tick.
#pragma once

#include "shared/core/ids.h"
#include "shared/core/state_hash.h"
#include "shared/motion/input_command.h"

#include <array>
#include <cstdint>

namespace zoned::zone {

/// Holds up to kSlots ticks ahead. A command for a tick that was already consumed is ignored.
class InputRing {
  public:
    static constexpr std::size_t kSlots = 64;

    void store(const motion::InputCommand& command, Tick now) {
        if (command.tick < now || command.tick >= now + static_cast<Tick>(kSlots)) {
            return;
        }
        slots_[slot(command.tick)] = command;
        if (command.tick > newest_) {
            newest_ = command.tick;
        }
    }

    /// The command for `now`. When it is missing, the last one is repeated (without jumping) for up
    /// to a second, then the character stands; `missing` says so.
    motion::InputCommand consume(Tick now, Tick patience_ticks, bool& missing) {
        const motion::InputCommand& stored = slots_[slot(now)];
        missing = stored.tick != now;
        if (!missing) {
            last_ = stored;
            last_real_ = now;
            return last_;
        }
        motion::InputCommand repeated = last_;
        repeated.tick = now;
        repeated.buttons &= static_cast<std::uint16_t>(~motion::kButtonJump);
        if (now - last_real_ > patience_ticks) {
            repeated.move_x = 0;
            repeated.move_z = 0;
            repeated.buttons = 0;
        }
        last_ = repeated;
        return repeated;
    }

    /// By how many ticks the newest command is ahead of `now`, clamped to the range of the wire.
    [[nodiscard]] std::int8_t lead(Tick now) const {
        const Tick ahead = newest_ - now;
        return static_cast<std::int8_t>(ahead < -127 ? -127 : (ahead > 127 ? 127 : ahead));
    }

    [[nodiscard]] const motion::InputCommand& last() const { return last_; }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(slots_, last_, last_real_, newest_);
    }

  private:
    static std::size_t slot(Tick tick) { return static_cast<std::size_t>(tick) % kSlots; }

    std::array<motion::InputCommand, kSlots> slots_{};
    motion::InputCommand last_;
    Tick last_real_ = 0;
    Tick newest_ = 0;
};

}  // namespace zoned::zone
