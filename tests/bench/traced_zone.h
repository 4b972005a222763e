// TracedZone: plays a motion trace through a replicator to clients that see all of it.
#pragma once

#include "client-sim/view/view.h"
#include "server/replication/replicator.h"
#include "tests/bench/motion_traces.h"
#include "shared/core/rng.h"

#include <deque>
#include <memory>
#include <vector>

namespace zoned::bench {

/// Quantisation steps as a world with one level of detail of that bound has them.
replication::ReplicationSettings settings_for_bound(const MotionTrace& trace,
                                                    const replication::LodBound& bound,
                                                    double heartbeat_s);

/// The world as a client of such a replicator knows it.
std::shared_ptr<const view::WorldInfo> world_of(const MotionTrace& trace,
                                                const replication::ReplicationSettings& settings);

/// Entity i + 1 follows the trace's entity i. Every client sees all entities. Where clients have
/// avatars, client c's avatar is entity c, and c receives it as its own state.
class TracedZone {
  public:
    struct Plan {
        int clients = 1;
        bool avatars = false;
        Tick delay = 0;     ///< ticks from sending to arrival, of packets and of acknowledgements
        double loss = 0.0;  ///< share of packets, and of acknowledgements, that never come
    };

    TracedZone(const MotionTrace& trace,
               const replication::ReplicationSettings& settings,
               const Plan& plan);

    /// The next tick of the trace: all clients' packets. Acknowledgements that are due have been
    /// applied before.
    const replication::ReplicationReport& step();

    [[nodiscard]] const std::vector<mailbox::StatePacket>& packets() const { return packets_; }

    /// Whether a packet of this tick, by its place in packets(), comes to its client.
    [[nodiscard]] bool arrives(std::size_t packet) const { return arrives_[packet]; }

    [[nodiscard]] Tick tick() const { return tick_; }

  private:
    void set_rows();
    void acknowledge();

    const MotionTrace& trace_;
    Plan plan_;
    world::TypeTable types_;
    replication::Replicator replicator_;
    world::Entities entities_;
    world::Visibility visibility_;
    std::vector<replication::OwnInput> own_;
    std::vector<mailbox::StatePacket> packets_;

    /// The packets that a client says to have received.
    struct Received {
        std::uint64_t newest = 0;
        std::uint64_t before = 0;  // bit i: newest - 1 - i
    };

    core::Rng rng_{7, 901};
    std::vector<bool> arrives_;                        // of packets_
    std::vector<Received> received_;                   // by client
    std::deque<std::pair<Tick, mailbox::Acks>> acks_;  // when they come back
    replication::ReplicationReport report_;
    Tick tick_ = 0;
};

/// A client of a traced zone.
class TracedClient {
  public:
    TracedClient(const MotionTrace& trace,
                 const replication::ReplicationSettings& settings,
                 const view::ViewSettings& view,
                 Tick delay)
        : delay_(delay),
          view_(world_of(trace, settings), view, nullptr) {}

    /// A packet sent at `tick`.
    void take(Tick tick, mailbox::StatePacket packet) {
        under_way_.emplace_back(tick + delay_, std::move(packet));
    }

    /// Applies the packets that have come by `tick` and displays the view.
    void display(Tick tick);

    [[nodiscard]] view::View& view() { return view_; }

    [[nodiscard]] const view::View& view() const { return view_; }

  private:
    Tick delay_;
    view::View view_;
    std::deque<std::pair<Tick, mailbox::StatePacket>> under_way_;  // when it comes
};

}  // namespace zoned::bench
