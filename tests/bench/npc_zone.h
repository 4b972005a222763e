// NpcZone: the town of config/town.txtpb with the requested number of people, in one whole zone.
#pragma once

#include "server/app/world/world.h"
#include "server/config/settings.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace zoned::bench {

/// The cost of one person in a tick, ns of thread CPU time: means over the ticks of a run.
struct NpcZoneCost {
    double ns = 0.0;
    std::array<double, zone::kPasses> pass_ns{};
    double rest_ns = 0.0;  ///< the census, inputs and the world's work around its zones
    double active = 0.0;   ///< agents, of all people
    double events_per_tick = 0.0;
};

/// Means over all ticks of a day, and over its busiest stretch.
struct NpcZoneDay {
    NpcZoneCost mean;
    NpcZoneCost busiest;
};

class NpcZone {
  public:
    struct Plan {
        /// Six types in the shares of the town; one each of three types that are never suspended.
        int people = 0;
        bool suspend_offscreen = true;
        bool viewer = false;  ///< one player stands where the people thin out
    };

    /// Throws std::runtime_error where the config cannot be read.
    explicit NpcZone(const Plan& plan);

    /// Steps without measuring.
    void settle(int ticks);

    [[nodiscard]] NpcZoneCost run(int ticks);

    /// `ticks` of which none is left out, and of these the `stretch` on end with the most events.
    /// The choice is the same in every run, whatever else the machine does.
    [[nodiscard]] NpcZoneDay day(int ticks, int stretch);

  private:
    void tick();
    [[nodiscard]] NpcZoneCost measured_tick();
    [[nodiscard]] NpcZoneCost mean(std::span<const NpcZoneCost> ticks) const;

    int people_;
    config::Settings settings_;
    std::unique_ptr<app::World> world_;
    std::vector<mailbox::InboxItem> in_;
    std::vector<mailbox::OutboxItem> out_;
};

}  // namespace zoned::bench
