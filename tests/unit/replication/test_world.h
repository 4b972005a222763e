// TestWorld: moving entities, viewers with a radius and a bad network, in virtual ticks. Walkers
// and tumbling bodies have exactly bounded accelerations. The network loses, delays, doubles and
// reorders.
#pragma once

#include "server/replication/replicator.h"
#include "tests/unit/replication/model_client.h"
#include "shared/core/rng.h"

namespace zoned::replication {

inline constexpr float kTickS = 1.0F / 30.0F;
inline constexpr TypeIndex kWalker = 0;
inline constexpr TypeIndex kBody = 1;
inline constexpr TypeIndex kDasher = 2;  ///< declared slower than it moves

/// kWalker: a_max 20 m/s2; kBody: a_max 20 m/s2, dv_max 12 m/s.
world::TypeTable test_types();

/// Bounds 0.05 m and 0.5 m; a generous budget.
ReplicationSettings test_settings();

class TestWorld {
  public:
    TestWorld(std::uint64_t seed, float extent_m) : rng(seed), extent_(extent_m) {}

    EntityId spawn(TypeIndex type);
    /// Walkers steer to a new heading every 2 s on average, bodies fly, bounce and spin.
    void step();
    /// Everything stands still from now on.
    void freeze();
    /// Sets by distance: entities within `radius_m` of the viewer's avatar; LOD 1 beyond
    /// `near_m`.
    world::Visibility visibility(const std::vector<world::Viewer>& viewers,
                                 float radius_m,
                                 float near_m) const;

    world::Entities entities;
    core::Rng rng;
    Tick now = 0;
    bool frozen = false;

  private:
    void walk(world::Row row);
    void fly(world::Row row);

    float extent_;
    std::uint32_t next_id_ = 1;
    std::map<EntityId, Vec3> wanted_;
};

/// Chances are per datagram; delay and jitter in ticks.
struct NetSettings {
    float loss = 0.0F;
    float duplicate = 0.0F;
    int delay_ticks = 0;
    int jitter_ticks = 0;
};

/// One direction to or from one client. Delivers in order of arrival; with jitter, packets overtake
/// each other.
template <class Packet>
class Network {
  public:
    Network(const NetSettings& settings, std::uint64_t seed) : settings_(settings), rng_(seed) {}

    void send(Tick now, const Packet& packet) {
        const int copies = rng_.unit() < settings_.duplicate ? 2 : 1;
        for (int i = 0; i < copies; ++i) {
            if (rng_.unit() >= settings_.loss) {
                const auto jitter = static_cast<int>(
                    rng_.below(static_cast<std::uint32_t>(settings_.jitter_ticks) + 1));
                queue_.emplace(std::pair(now + settings_.delay_ticks + jitter, rng_.next()),
                               packet);
            }
        }
    }

    template <class Receive>
    void deliver(Tick now, Receive&& receive) {
        while (!queue_.empty() && queue_.begin()->first.first <= now) {
            receive(queue_.begin()->second);
            queue_.erase(queue_.begin());
        }
    }

    NetSettings settings_;

  private:
    core::Rng rng_;
    std::multimap<std::pair<Tick, std::uint32_t>, Packet> queue_;  // random among equal arrivals
};

/// A client at the far end of a lossy network.
struct Remote {
    Remote(ClientId id,
           const world::TypeTable& types,
           const ReplicationSettings& settings,
           const NetSettings& net,
           std::uint64_t seed)
        : client(id),
          model(types, settings.quantization, settings.tick_s),
          down(net, seed),
          up(net, seed + 1) {}

    ClientId client;
    ModelClient model;
    Network<mailbox::StatePacket> down;
    Network<mailbox::Acks> up;
};

}  // namespace zoned::replication
