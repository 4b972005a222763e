#include "server/session/input_gate.h"

namespace zoned::session {

namespace {

bool in_range(const motion::InputCommand& c) {
    return c.move_x >= -127 && c.move_z >= -127 && c.pitch >= -16384 && c.pitch <= 16384;
}

}  // namespace

bool InputGate::seen(Tick tick) const {
    if (!any_ || tick > newest_) {
        return false;
    }
    const Tick age = newest_ - tick;
    return age < 64 && ((passed_ >> age) & 1u) != 0;
}

void InputGate::mark(Tick tick) {
    if (!any_) {
        any_ = true;
        newest_ = tick;
        passed_ = 1;
    } else if (tick > newest_) {
        const Tick shift = tick - newest_;
        passed_ = shift >= 64 ? 1 : (passed_ << shift) | 1u;
        newest_ = tick;
    } else {
        passed_ |= std::uint64_t{1} << (newest_ - tick);
    }
}

void InputGate::filter(std::span<const motion::InputCommand> commands,
                       Tick current_tick,
                       Tick window_ticks,
                       RejectCounters& rejects,
                       PassedCommands& passed) {
    for (const motion::InputCommand& command : commands) {
        // The window comes first: differences of ticks from outside must not overflow.
        if (command.tick < 0 || command.tick > current_tick + window_ticks) {
            rejects.count(Reject::kInputAhead);
        } else if (seen(command.tick)) {
            continue;
        } else if (command.tick < current_tick - kInputLateTicks) {
            rejects.count(Reject::kInputLate);
        } else if (!in_range(command)) {
            rejects.count(Reject::kInputRange);
        } else {
            if (command.tick <= current_tick) {
                rejects.count(Reject::kInputMissed);
            }
            mark(command.tick);
            passed.push_back(command);
        }
    }
}

}  // namespace zoned::session
