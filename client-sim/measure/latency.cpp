#include "client-sim/measure/latency.h"

#include <algorithm>

namespace zoned::measure {

namespace {

/// After this time the decider knows all that it will ever know of a command's arrival.
constexpr double kKnownAfterS = 1.0;

std::size_t at(Stage stage) {
    return static_cast<std::size_t>(stage);
}

}  // namespace

const char* stage_name(Stage stage) {
    switch (stage) {
        case Stage::kWireUp:
            return "wire_up";
        case Stage::kTickWait:
            return "tick_wait";
        case Stage::kPublish:
            return "publish";
        case Stage::kSend:
            return "send";
        case Stage::kWireDown:
            return "wire_down";
        case Stage::kDisplay:
            return "display";
    }
    return "?";
}

void Latency::add(std::size_t decider,
                  Tick tick,
                  double decided_s,
                  const bot::Bot& observer,
                  Tick publication_tick,
                  Tick from_tick) {
    const double tick_s = observer.view()->world().tick_s;
    const double published_s = static_cast<double>(publication_tick) * tick_s;
    const double sent_s = observer.packet_sent_s();
    const double came_s = observer.client().clock().server_time(observer.now_s());
    const double shown_s = std::max(came_s, static_cast<double>(from_tick) * tick_s);
    PendingAction waiting;
    waiting.decider = decider;
    waiting.tick = tick;
    waiting.decided_s = decided_s;
    waiting.due_s = static_cast<double>(tick) * tick_s;
    waiting.shown_s = shown_s;
    waiting.ms[at(Stage::kPublish)] = 1e3 * (published_s - waiting.due_s);
    waiting.ms[at(Stage::kSend)] = 1e3 * (sent_s - published_s);
    waiting.ms[at(Stage::kWireDown)] = 1e3 * (came_s - sent_s);
    waiting.ms[at(Stage::kDisplay)] = 1e3 * (shown_s - came_s);
    waiting_.push_back(waiting);
}

void Latency::settle(std::span<const std::unique_ptr<bot::Bot>> bots) {
    std::erase_if(waiting_, [&](PendingAction& w) {
        const bot::Bot& decider = *bots[w.decider];
        if (decider.client().clock().server_time(decider.now_s()) < w.shown_s + kKnownAfterS) {
            return false;
        }
        const auto came_s = decider.command_arrival_s(w.tick);
        if (!came_s) {
            ++unknown_;
            return true;
        }
        w.ms[at(Stage::kWireUp)] = 1e3 * (*came_s - w.decided_s);
        w.ms[at(Stage::kTickWait)] = 1e3 * (w.due_s - *came_s);
        for (std::size_t i = 0; i < kStages; ++i) {
            stages_ms_[i].add(w.ms[i]);
        }
        return true;
    });
}

}  // namespace zoned::measure
