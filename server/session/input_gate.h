// InputGate: lets each tick's command of a client through once, if it is within ranges and window.
#pragma once

#include "server/session/reject.h"
#include "shared/core/containers/inline_vector.h"
#include "shared/core/ids.h"
#include "shared/motion/input_command.h"
#include "shared/wire/packet.h"

#include <cstdint>
#include <span>

namespace zoned::session {

/// Ticks behind the current one for which a command is still passed on.
inline constexpr Tick kInputLateTicks = 8;
/// Widest window ahead for which the gate's memory of 64 ticks is enough.
inline constexpr Tick kMaxInputWindowTicks = 63 - kInputLateTicks;

/// Clients repeat their last commands in every packet, so most arrivals were let through before:
/// they are dropped without a count. The rate needs no limit of its own: a tick passes once, and
/// only ticks of a window that moves with the server's clock pass at all.
class InputGate {
  public:
    using PassedCommands = core::InlineVector<motion::InputCommand, wire::kMaxCommandsPerPacket>;

    /// Appends to `passed` the commands that may go on to the zones, ascending by tick; counts the
    /// others, and those for ticks that were stepped already: no zone will use them. `commands`
    /// ascend by tick (the codec sees to it).
    void filter(std::span<const motion::InputCommand> commands,
                Tick current_tick,
                Tick window_ticks,
                RejectCounters& rejects,
                PassedCommands& passed);

  private:
    /// Whether the command of `tick` passed before. Ticks older than the mask are late anyway, as
    /// long as the window is at most kMaxInputWindowTicks.
    [[nodiscard]] bool seen(Tick tick) const;
    void mark(Tick tick);

    Tick newest_ = 0;           ///< newest tick that passed; meaningless before any_
    std::uint64_t passed_ = 0;  ///< bit i: tick newest_ - i passed
    bool any_ = false;
};

}  // namespace zoned::session
