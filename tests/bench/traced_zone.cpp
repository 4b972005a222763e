#include "tests/bench/traced_zone.h"

#include "shared/wire/packet.h"

#include <algorithm>
#include <cmath>

namespace zoned::bench {

replication::ReplicationSettings settings_for_bound(const MotionTrace& trace,
                                                    const replication::LodBound& bound,
                                                    double heartbeat_s) {
    replication::ReplicationSettings s;
    s.lods = {bound};
    s.heartbeat_ticks =
        static_cast<std::uint32_t>(std::lround(heartbeat_s / static_cast<double>(trace.tick_s)));
    s.budget_bytes_per_s = 100'000'000;
    s.tick_s = trace.tick_s;
    s.ground = trace.ground;
    const wire::RateSteps steps = wire::rate_steps(
        bound.position_m, bound.orientation_rad, static_cast<float>(0.5 * heartbeat_s));
    s.quantization.position_step_m = std::min(0.01F, 0.2F * bound.position_m);
    s.quantization.velocity_step_mps = steps.velocity_mps;
    s.quantization.acceleration_step_mps2 = steps.acceleration_mps2;
    s.quantization.angular_velocity_step_rps = steps.angular_velocity_rps;
    s.quantization.gravity_mps2 = trace.gravity_mps2;
    return s;
}

std::shared_ptr<const view::WorldInfo> world_of(const MotionTrace& trace,
                                                const replication::ReplicationSettings& settings) {
    view::WorldInfo world;
    world.tick_s = static_cast<double>(trace.tick_s);
    world.quantization = settings.quantization;
    view::TypeInfo type;
    type.name = trace.type.name;
    type.upright = trace.type.upright();
    world.types.push_back(type);
    world.lods.push_back({0.0F, settings.lods[0].position_m, settings.lods[0].orientation_rad});
    view::ZoneInfo zone;
    zone.id = ZoneId(1);
    world.zones.push_back(zone);
    return std::make_shared<const view::WorldInfo>(std::move(world));
}

// ---------------------------------------------------------------- the server's side

TracedZone::TracedZone(const MotionTrace& trace,
                       const replication::ReplicationSettings& settings,
                       const Plan& plan)
    : trace_(trace),
      plan_(plan),
      types_{trace.type},
      replicator_(settings),
      received_(static_cast<std::size_t>(plan.clients)) {
    const auto count = static_cast<std::uint32_t>(trace.frames.front().size());
    for (std::uint32_t id = 1; id <= count; ++id) {
        const world::Row row = entities_.add(EntityId(id), 0);
        if (plan.avatars && id <= static_cast<std::uint32_t>(plan.clients)) {
            entities_.set_client(row, ClientId(id));
        }
    }
    for (std::uint32_t c = 1; c <= static_cast<std::uint32_t>(plan.clients); ++c) {
        replication::ClientTransfer client;
        client.client = ClientId(c);
        replicator_.add_client(client);
        world::VisibleSet& set = visibility_.emplace_back();
        set.client = ClientId(c);
        for (std::uint32_t id = 1; id <= count; ++id) {
            if (!plan.avatars || id != c) {
                set.visible.push_back({EntityId(id), 0});
            }
        }
        if (plan.avatars) {
            own_.emplace_back().client = ClientId(c);
        }
    }
}

void TracedZone::set_rows() {
    const std::vector<TracedState>& now = trace_.frames[static_cast<std::size_t>(tick_ - 1)];
    for (world::Row row = 0; row < now.size(); ++row) {
        const motion::KinematicState& s = now[row].state;
        entities_.position[row] = s.position;
        entities_.orientation[row] = s.orientation;
        entities_.velocity[row] = s.velocity;
        entities_.acceleration[row] = s.acceleration;
        entities_.angular_velocity[row] = s.angular_velocity;
        entities_.set(row, world::kAtRest, now[row].at_rest);
    }
}

const replication::ReplicationReport& TracedZone::step() {
    ++tick_;
    set_rows();
    for (; !acks_.empty() && acks_.front().first <= tick_; acks_.pop_front()) {
        replicator_.on_acks(acks_.front().second);
    }
    for (replication::OwnInput& own : own_) {
        own.input_tick = tick_;
    }
    packets_.clear();
    report_ = replicator_.step(tick_, ZoneId(1), entities_, types_, visibility_, own_, packets_);
    acknowledge();
    return report_;
}

/// Of each client's newest packet that came, naming those that came before it.
void TracedZone::acknowledge() {
    const Tick back = tick_ + std::max<Tick>(1, 2 * plan_.delay);
    const auto rtt_us =
        static_cast<std::uint32_t>(1e6F * static_cast<float>(back - tick_) * trace_.tick_s);
    const auto is_lost = [&] {
        return plan_.loss > 0.0 && static_cast<double>(rng_.unit()) < plan_.loss;
    };
    arrives_.clear();
    for (std::size_t i = 0; i < packets_.size(); ++i) {
        const mailbox::StatePacket& packet = packets_[i];
        arrives_.push_back(!is_lost());
        Received& received = received_[packet.client.value - 1];
        if (arrives_[i]) {
            const std::uint64_t on = packet.sequence - received.newest;
            received.before = on < 64 ? (received.before << on) | 1ULL << (on - 1) : 0;
            received.newest = packet.sequence;
        }
        const bool newest = i + 1 == packets_.size() || packets_[i + 1].client != packet.client;
        if (newest && received.newest != 0 && !is_lost()) {
            mailbox::Acks acks;
            acks.client = packet.client;
            acks.newest = received.newest;
            acks.bits = static_cast<std::uint32_t>(received.before);
            acks.rtt_us = rtt_us;
            acks_.emplace_back(back, acks);
        }
    }
}

// ---------------------------------------------------------------- a client

void TracedClient::display(Tick tick) {
    view_.evaluate(tick - 1);
    for (; !under_way_.empty() && under_way_.front().first <= tick; under_way_.pop_front()) {
        const mailbox::StatePacket& packet = under_way_.front().second;
        const auto parsed = wire::read_down_head(packet.body);
        const auto records =
            std::span<const std::uint8_t>(packet.body).subspan(parsed->records_offset);
        view_.apply({packet.sequence, parsed->head, records}, 0.0);
    }
    view_.evaluate(tick);
}

}  // namespace zoned::bench
