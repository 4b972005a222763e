// WorldProbe: runs a world with players in the same process, and adds up what its passes cost and
// how far off its players' views are.
#pragma once

#include "server/app/world/world.h"
#include "server/config/plan/pass_costs.h"
#include "server/physics/scene/scene.h"
#include "shared/core/rng.h"

#include <array>
#include <map>
#include <vector>

namespace zoned::app {

/// Players of a probe. Their acknowledgements come one tick after each packet.
struct ProbeCrowd {
    unsigned viewers = 0;  ///< stand where they appear
    unsigned bots = 0;     ///< walk, and turn once a second
};

/// One pass over several ticks.
struct PassSums {
    double ran = 0.0;
    double ns = 0.0;     ///< thread CPU time
    double count = 0.0;  ///< as the pass itself counts its units
    config::PassUnits units{};
};

struct ZoneSums {
    std::array<PassSums, zone::kPasses> passes;
    double ticks = 0.0;
    double bytes = 0.0;  ///< of packet bodies
    double packets = 0.0;
    double viewer_ticks = 0.0;

    /// Adds the same of other ticks.
    void add(const ZoneSums& other);
};

/// How far the views of one level of detail were off, over all samples.
struct ViewErrors {
    double most_m = 0.0;
    double most_rad = 0.0;
    std::uint64_t samples = 0;
    std::uint64_t moving = 0;  ///< samples of entities that moved
};

/// Measures how fast the machine is just now, by a small pile of boxes that never sleeps.
class SpeedMeter {
  public:
    SpeedMeter();

    /// One step of the pile: CPU time over that of the reference machine.
    double sample();

  private:
    physics::Scene pile_;
};

/// Samples of views are taken of so many players of a zone at most.
inline constexpr std::size_t kSampledPlayers = 64;

class WorldProbe {
  public:
    /// `world` is new and outlives the probe. It is measured where it has a stopwatch.
    WorldProbe(World& world, const config::Settings& settings, const ProbeCrowd& crowd);

    /// An item for the next tick, before those of players.
    void give(mailbox::InboxItem item) { items_.push_back(std::move(item)); }

    void run(unsigned ticks);

    /// Begins all sums anew.
    void clear();

    /// By zone, since the last clear().
    [[nodiscard]] const std::vector<ZoneSums>& zones() const { return zones_; }

    /// By level of detail, since the last clear().
    [[nodiscard]] const std::vector<ViewErrors>& views() const { return views_; }

    /// CPU time of this machine over that of the reference machine, since the last clear().
    [[nodiscard]] double speed() const;

    /// How far a box or ball that lies on the level ground sinks into it, the deepest, m. Negative:
    /// there is none, or none that has moved.
    [[nodiscard]] double give_m() const;

    /// How far props that stood where the config placed them have sunk, the farthest, m. Props that
    /// fell, slid or turned are left out. Negative: there is none.
    [[nodiscard]] double sag_m() const;

  private:
    void make_inputs();
    void take_output();
    void sample_views();

    World& world_;
    SpeedMeter meter_;
    double speed_sum_ = 0.0;
    double speed_samples_ = 0.0;
    const config::Settings& settings_;
    ProbeCrowd crowd_;
    core::Rng rng_{1};
    std::vector<motion::InputCommand> walks_;  // of bots, in order
    std::vector<mailbox::InboxItem> items_;
    std::vector<mailbox::OutboxItem> out_;
    std::vector<ZoneSums> zones_;
    std::vector<ViewErrors> views_;
    std::vector<replication::Replicator::AssumedState> shown_;  // scratch
    std::map<EntityId, std::pair<Vec3d, Quat>> placed_;         // dynamic props at the beginning
};

}  // namespace zoned::app
