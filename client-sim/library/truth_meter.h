// TruthMeter: compares what a client displayed with the server's truth, where it may ask for it.
#pragma once

#include "client-sim/library/recent_values.h"
#include "client-sim/view/player.h"

#include <list>

namespace zoned::library {

/// For a look at the screen. The verdict of client-sim judges by the promised bounds
/// (client-sim/measure).
class TruthMeter {
  public:
    void restart() { waiting_.clear(); }

    /// Asks for the truth now and then, and compares what has come with what was displayed.
    void advance(view::Player& player, double now_s);
    void add(const wire::AuditRecordMessage& record);

    /// Distances between displayed and true places of other entities, m.
    [[nodiscard]] const RecentValues& displayed() const { return displayed_; }

    /// Distances between predicted and true places of the own avatar, m.
    [[nodiscard]] const RecentValues& own() const { return own_; }

  private:
    void compare(const view::View& view, const wire::AuditRecordMessage& record);

    std::list<wire::AuditRecordMessage> waiting_;
    double next_s_ = 0.0;
    RecentValues displayed_;
    RecentValues own_;
};

}  // namespace zoned::library
