#include "server/replication/packer.h"

#include <algorithm>
#include <limits>

namespace zoned::replication {

namespace {

// Under pressure: never sent before anything else, as if that were so many bounds off; a bound's
// worth of urgency for every second of waiting; an error that is not known is this large.
constexpr float kUnseenScore = 16.0F;
constexpr float kWaitingScore = 1.0F / 30.0F;
constexpr float kWorstExcess = 1e4F;
// A few bytes that end a wrong picture, of which no bound says how wrong it is, come before all.
constexpr float kRemovalScore = 1e9F;
// Bounds are announced with so much to spare, and narrowed by half in so many ticks.
constexpr float kMargin = 1.2F;
constexpr Tick kNarrowEvery = 8;
constexpr Tick kSwitchTicks = 3;

/// The client's possible error about an entity, in bounds that hold for it now; infinity where the
/// base of its prediction is unknown.
float excess_of(Tick now,
                const Subscription& s,
                const ClientState& client,
                const StreamTable& streams) {
    if (const std::uint32_t version = held_version(s); version != 0) {
        return streams.excess(s.stream, version, now);
    }
    const Followed* f = client.followed(s.entity);
    // Where another zone's stream leads is a guess, which is good for so long.
    const bool known =
        f != nullptr && (f->publication.version != 0 || now - f->publication.tick <= kSwitchTicks);
    return known ? streams.excess(s.stream, f->publication, f->off_m, f->off_rad, now)
                 : std::numeric_limits<float>::infinity();
}

/// Whether the client lacks the entity, for all that it has confirmed: nothing was sent, or nothing
/// of that has arrived.
bool is_unseen(const Subscription& s, const ClientState& client) {
    return held_version(s) == 0 && client.followed(s.entity) == nullptr;
}

/// Whether the client lacks a declared field as it was published last.
bool owes_fields(const Subscription& s, const StreamTable& streams) {
    const Tick newest = streams.fields_tick(s.entity);
    const Past* held = newest > 0 ? streams.past(s.stream, held_version(s)) : nullptr;
    return newest > 0 && (held == nullptr || held->tick < newest);
}

}  // namespace

/// Where not everything fits, the entities go first whose error is largest beside the bound that
/// holds for them, by the weight of their type. One that waits for another reason (rest, looks)
/// gains by waiting.
void Packer::order_by_error(Tick now, const ClientState& client, const StreamTable& streams) {
    for (PacketCandidate& c : candidates_) {
        if (c.removal) {
            c.score += kRemovalScore;
            continue;
        }
        const Subscription& s = client.subscriptions[c.index];
        const Stream& stream = streams[s.stream];
        const auto waited = static_cast<float>(now - s.delivery.pending_tick);
        if (s.sent_version == 0) {
            // Nearest first; an entity never shown comes before one shown a little wrong.
            c.score = kUnseenScore * stream.priority * (1.0F + waited) /
                      static_cast<float>(1 + s.lod * s.lod);
            continue;
        }
        const float excess = std::min(excess_of(now, s, client, streams), kWorstExcess);
        const auto wider = static_cast<float>(wire::widening(
            std::min(client.widened.step, wire::kMostWidening), s.lod, settings_.lods.size()));
        c.score = stream.priority * (excess / wider + kWaitingScore * waited);
    }
    sort_candidates();
}

/// Entities that were never shown come nearest first within a level of detail, by exact distance
/// (less the more its type matters). They keep the places in the order that they have together.
void Packer::order_unseen_by_distance(const OwnNow& own,
                                      const ClientState& client,
                                      const StreamTable& streams) {
    if (!own.present) {
        return;
    }
    for (std::uint8_t lod = 0; lod < settings_.lods.size(); ++lod) {
        unseen_.clear();
        places_.clear();
        for (std::uint32_t place = 0; place < candidates_.size(); ++place) {
            const PacketCandidate& c = candidates_[place];
            if (c.removal || client.subscriptions[c.index].sent_version != 0 ||
                client.subscriptions[c.index].lod != lod) {
                continue;
            }
            const Stream& stream = streams[client.subscriptions[c.index].stream];
            const float distance_m = (stream.truth.position - own.state.state.position).norm();
            unseen_.emplace_back(distance_m / stream.priority, c);
            places_.push_back(place);
        }
        std::sort(unseen_.begin(), unseen_.end(), [](const auto& a, const auto& b) {
            return a.first != b.first ? a.first < b.first : a.second.index < b.second.index;
        });
        for (std::size_t i = 0; i < places_.size(); ++i) {
            candidates_[places_[i]] = unseen_[i].second;
        }
    }
}

/// The last publication of another zone is not known here. A tick ago the truth was within the
/// bounds promised there. Where it goes on as this zone has told others, it is now at most a bound
/// farther off. Where the truth has turned just now, or nobody was notified before, nothing is
/// known.
void Packer::follow_from_elsewhere(Tick now,
                                   const Subscription& s,
                                   ClientState& client,
                                   const StreamTable& streams) const {
    if (held_version(s) != 0 || s.switched_tick != now || client.followed(s.entity) != nullptr) {
        return;
    }
    const Stream& stream = streams[s.stream];
    if (stream.version <= 1 || stream.breach_tick == now) {
        return;
    }
    const LodBound& bound = settings_.lods[s.lod];
    const auto wider = static_cast<float>(wire::widening(
        std::min(client.widened.step, wire::kMostWidening), s.lod, settings_.lods.size()));
    const float bounds_off = wider + 1.0F;
    const Past as_truth{stream.truth, motion::PredictorOrder::kLinear, now, 0};
    client.follow(
        {s.entity, as_truth, bounds_off * bound.position_m, bounds_off * bound.orientation_rad});
}

/// The updates that could not be sent, which candidates_ holds, decide how wide the bounds are now:
/// never silently late.
void Packer::widen(Tick now, ClientState& client, const StreamTable& streams) {
    if (client.away()) {
        client.widened.step = wire::kNoBound;
        client.widened.incomplete = true;
        client.widened_tick = now;
        postpone_all(now, client);
        return;
    }
    wire::Widened needed;
    for (const PacketCandidate& c : candidates_) {
        if (c.reason == Reason::kRepeat) {
            continue;
        }
        if (c.removal) {
            client.removals[c.index].postponed_tick = now;
            needed.incomplete = true;
            continue;
        }
        Subscription& s = client.subscriptions[c.index];
        if (is_unseen(s, client) || owes_fields(s, streams)) {
            needed.incomplete = true;
            s.postponed_tick = now;
        }
        if (s.sent_version == 0 && !s.known) {
            continue;  // no picture that could be wrong
        }
        follow_from_elsewhere(now, s, client, streams);
        const float excess = excess_of(now, s, client, streams);
        needed.step =
            std::max(needed.step,
                     wire::widening_for(
                         static_cast<double>(kMargin * excess), s.lod, settings_.lods.size()));
    }
    wire::Widened& notified = client.widened;
    notified.incomplete = needed.incomplete;
    if (needed.step >= notified.step) {
        client.widened_tick = needed.step > 0 ? now : client.widened_tick;
        notified.step = needed.step;
    } else if (now - client.widened_tick >= kNarrowEvery) {
        client.widened_tick = now;
        notified.step = static_cast<std::uint8_t>((needed.step + notified.step) / 2);
        if (notified.step > wire::kMostWidening) {
            notified.step = std::max(needed.step, wire::kMostWidening);
        }
    }
}

/// A client that is away gets no updates.
void Packer::postpone_all(Tick now, ClientState& client) {
    for (Removal& r : client.removals) {
        r.postponed_tick = now;
    }
    for (Subscription& s : client.subscriptions) {
        if (is_unseen(s, client)) {
            s.postponed_tick = now;
        }
    }
}

void Packer::notify(ClientState& client,
                    std::span<mailbox::StatePacket> packets,
                    ReplicationReport& report) const {
    if (client.widened == wire::Widened{}) {
        return;
    }
    ++report.widened;
    for (mailbox::StatePacket& packet : packets) {
        wire::rewrite_widened(client.widened, packet.body);
    }
}

}  // namespace zoned::replication
