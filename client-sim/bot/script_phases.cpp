#include "client-sim/bot/script.h"
#include "proto/sandbox.pb.h"

namespace zoned::bot {

namespace {

constexpr Tick kPhaseTicks = 150;        // of sneaking or looking, and half as long of strolling
constexpr double kKeepAwayM = 5.0;       // a sneaking bot stops here
constexpr std::uint32_t kGlance = 1820;  // the spyglass turns by up to 10 degrees to either side

}  // namespace

bool ScriptRunner::in_phase(Tick tick) {
    if (tick >= next_act_) {
        phase_ = !phase_;
        next_act_ = tick + kPhaseTicks / (phase_ ? 1 : 2);
    }
    return phase_;
}

void ScriptRunner::sneak(const view::View& view, Tick tick) {
    if (tick < next_turn_) {
        return;
    }
    const bool sneaking = in_phase(tick);
    const Target player = nearest(view, Prey::kPlayer);
    const Target victim = player.id ? player : nearest(view, Prey::kNpc);
    if (!sneaking || !victim.id) {
        pick_direction(tick);
        return;
    }
    next_turn_ = tick + kDecideTicks;
    walk_to(view.own().position(), victim.position.x(), victim.position.z(), false);
    const bool near = victim.distance < kKeepAwayM;
    wish_.move_x = static_cast<std::int8_t>(near ? 0 : wish_.move_x / 2);
    wish_.move_z = static_cast<std::int8_t>(near ? 0 : wish_.move_z / 2);
    wish_.buttons = sandbox::BUTTON_SNEAK;
}

void ScriptRunner::look(Tick tick) {
    if (tick < next_turn_) {
        return;
    }
    if (!in_phase(tick)) {
        pick_direction(tick);
        return;
    }
    next_turn_ = tick + kDecideTicks;
    wish_.move_x = 0;
    wish_.move_z = 0;
    wish_.buttons = sandbox::BUTTON_SPYGLASS;
    wish_.yaw = static_cast<std::uint16_t>(wish_.yaw + rng_.below(2 * kGlance + 1) - kGlance);
}

}  // namespace zoned::bot
