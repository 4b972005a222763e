// Replicator: turns what viewers hear of into state packets: encode once, promise a bound, owe what
// was lost.
#pragma once

#include "server/mailbox/messages.h"
#include "server/replication/codec_plan.h"
#include "server/world/entities.h"
#include "server/world/visibility.h"
#include "shared/core/ids.h"
#include "shared/core/state_hash.h"
#include "shared/motion/static_geometry.h"
#include "shared/wire/quantize.h"
#include "shared/wire/traffic.h"
#include "shared/wire/widening.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace zoned::replication {

/// Who a record is written for.
enum class Codec : std::uint8_t {
    kShared,     ///< for all subscribers: one encoding is copied
    kPerClient,  ///< for each client alone, against what it has acknowledged: fewest bytes
    kAuto,  ///< for those alone where it gains most, within ReplicationSettings::codec_budget_us
};

/// The promise of one level of detail.
struct LodBound {
    float position_m = 0.05F;      ///< > 0
    float orientation_rad = 0.1F;  ///< > 0
};

struct ReplicationSettings {
    wire::Quantization quantization;
    std::vector<LodBound> lods;  ///< one per LOD, nearest first, 1..4
    std::uint32_t heartbeat_ticks =
        60;                            ///< a moving entity is published at least this often, 1..240
    std::uint32_t keyframe_every = 8;  ///< publications between keyframes of a stream, 1..255
    std::uint32_t budget_bytes_per_s =
        16000;  ///< per client at most, headers counted; bursts of up to a quarter of a second, of
                ///< a second (14600 bytes at most) when it joins
    std::uint32_t own_state_every_ticks =
        6;  ///< own avatar's state at least this often while it moves, 1..60
    std::uint32_t silence_ticks = 12;  ///< a client hears a datagram at least this often, 1..15
    float tick_s = 1.0F / 30.0F;
    /// -1: the least volatile kind per entity; 0..4: only this PredictorOrder (order 1 where
    /// nothing falls, order 2 where nothing turns)
    int forced_order = -1;
    Codec codec = Codec::kShared;
    std::uint32_t codec_budget_us = 1000;  ///< Codec::kAuto: CPU time of coding per tick at most
    /// What falls lands on it, zone-local; null: it falls on for all that is predicted.
    std::shared_ptr<const motion::StaticGeometry> ground;
    float redundancy_target =
        1e-6F;  ///< news is repeated until the chance that all copies were lost is below this
    bool meter = false;  ///< count what bytes are spent on: Replicator::traffic()
    bool resend = true;  ///< off: what was lost is not sent again
};

struct ReplicationReport {
    std::uint32_t streams = 0;         ///< (entity, LOD) that somebody subscribes to
    std::uint32_t publications = 0;    ///< encoded this tick
    std::uint32_t keyframes = 0;       ///< of these
    std::uint32_t records_sent = 0;    ///< copies into packets
    std::uint32_t records_resent = 0;  ///< of these: again, after loss or as redundancy
    std::uint32_t packets = 0;
    std::uint64_t bytes = 0;  ///< bodies
    std::uint32_t over_budget =
        0;                      ///< clients that were still owed something when their budget ended
    std::uint32_t widened = 0;  ///< clients that were told of bounds wider than promised
    std::uint32_t limit_exceeded =
        0;                     ///< entities whose truth exceeded its declared a_max or dv_max
    std::uint32_t inputs = 0;  ///< commands that were due
    std::uint32_t inputs_missing = 0;  ///< of these: not there in time
    CodecChoice codec;                 ///< the newest one of Codec::kAuto
    std::uint32_t coded_packets = 0;   ///< of packets
    std::uint32_t coded_records = 0;   ///< of records_sent
    bool skipped = false;              ///< no viewer: nothing ran, no stream is kept
};

/// Own avatar's input state, as the zone knows it.
struct OwnInput {
    ClientId client;
    Tick input_tick = 0;  ///< newest tick whose command the avatar consumed (= now)
    bool input_missing = false;
    std::int8_t input_lead = 0;
};

/// All that must follow a client to another zone; opaque to others.
struct ClientTransfer {
    ClientId client;
    std::uint8_t codec_epoch = 0;  ///< the next one of its coded records
    bool coded = false;            ///< by the choice of Codec::kAuto
    CodecDemand demand;            ///< for that choice
    std::uint64_t next_sequence = 1;
    double loss_estimate = 0.0;
    double budget_bytes = 0.0;
    std::uint32_t rtt_us = 0;
    std::uint32_t rate_bytes_per_s = 0;  ///< what its path carries; 0: no limit known
    wire::Widened widened;               ///< the bounds that it was told last
    std::vector<EntityId>
        known;  ///< entities that the client may hold: the new zone sends them anew or removes them
};

/// Replication state of one zone. Deterministic; no wall clock: round trips and losses come in with
/// the acks.
///
/// What it relies on in clients: records are ordered by the packets that carried them (tick or
/// sequence), whatever zone or level of detail they belong to; within a stream the publication tick
/// says the same. A remove ends the entity and its keyframes for all older packets, and is itself
/// void when a newer packet has named the entity. A keyframe is stored even when its state is old
/// news, unless a newer one with its number is there. Acknowledged means stored.
///
/// A stream's numbering starts anew when it is created again; that is safe because deltas refer
/// only to keyframes that were acknowledged within the present subscription.
class Replicator {
  public:
    explicit Replicator(const ReplicationSettings& settings);
    Replicator(Replicator&&) noexcept;
    Replicator& operator=(Replicator&&) noexcept;
    ~Replicator();

    void add_client(const ClientTransfer& transfer);
    ClientTransfer remove_client(ClientId client);
    void on_acks(const mailbox::Acks& acks);
    /// Holds from the next choice on.
    void set_codec_price(const mailbox::CodecPrice& price);
    [[nodiscard]] const mailbox::CodecPrice& codec_price() const;
    /// Something else came from the client: after an outage it is asked sooner what it holds.
    void on_heard(ClientId client);
    /// Everything is owed to this client again, absolute.
    void reset_view(ClientId client);

    /// One tick. `visibility` and `own` ascend by client id. Packets are appended to `out`,
    /// ascending by client. A removed entity is announced by its absence from VisibleSet::visible.
    /// A client without a set hears only that the connection lives. Orientation is taken from
    /// Entities::orientation, also of upright entities. Accelerations above a type's a_max are
    /// impacts and are not extrapolated.
    ReplicationReport step(Tick now,
                           ZoneId zone,
                           const world::Entities& entities,
                           const world::TypeTable& types,
                           const world::Visibility& visibility,
                           std::span<const OwnInput> own,
                           std::vector<mailbox::StatePacket>& out);

    /// When truth last left the prediction of the stream (entity, lod): in position or orientation
    /// by more than the bound, or in velocity by more than dv_max; within a second after a
    /// publication that replaced a good one (rest, heartbeat) also when truth left that one. 0 =
    /// never or no such stream. For audits.
    [[nodiscard]] Tick breach_tick(EntityId entity, std::uint8_t lod) const;

    /// When this client passed from one stream of the entity to another (level of detail, zone), 0
    /// = never. Until news of the new stream has come it still predicts from the old one, whose
    /// breaches nobody watches any more: for an audit that is a breach of its own.
    [[nodiscard]] Tick switch_tick(ClientId client, EntityId entity) const;

    /// What a client that has a publication predicts from it.
    struct SentState {
        Vec3 position = Vec3::Zero();  ///< at the tick asked for, zone-local, m
        /// Blending from the publications before may show it this far off, m: the sum of the jumps
        /// between their predictions for that tick, over those of the last half second.
        float blend_m = 0.0F;
    };

    /// The publication of that tick, if it was sent to this client and no newer one of its stream
    /// had replaced it by `since`; evaluated at `at`.
    [[nodiscard]] std::optional<SentState> sent_state(ClientId client,
                                                      EntityId entity,
                                                      Tick publication,
                                                      Tick at,
                                                      Tick since) const;

    /// What this client is promised of the entity's position, m; 0: it does not hear of it.
    [[nodiscard]] float bound_m(ClientId client, EntityId entity) const;

    /// How long news takes to this client, ticks, rounded up: half of its round trip; 0: not
    /// measured yet.
    [[nodiscard]] Tick path_ticks(ClientId client) const;

    /// What was done to tell this client of entities and has not been acknowledged: for each, the
    /// packets that carried news or its removal since the newest one of them that was. Ascending by
    /// entity. For audits; packets of other zones are not known here: returns from which tick on
    /// all are, 0 if none.
    Tick unacknowledged(ClientId client, std::vector<mailbox::AuditUpdate>& out) const;

    /// Whether anybody hears of the entity.
    [[nodiscard]] bool heard(EntityId entity) const;

    void hash(core::StateHash& hash) const;

    /// What the bodies of all packets so far were spent on; nullptr without
    /// ReplicationSettings::meter.
    [[nodiscard]] const wire::TrafficTable* traffic() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace zoned::replication
