// Replication settings: the settings, the report of a tick, and a client's state for a handoff.
#pragma once

#include "server/replication/codec_plan.h"
#include "shared/core/ids.h"
#include "shared/motion/static_geometry.h"
#include "shared/wire/declared/declared_fields.h"
#include "shared/wire/quantize.h"
#include "shared/wire/widening.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace zoned::replication {

/// The recipients of a record.
enum class Codec : std::uint8_t {
    kShared,     ///< for all subscribers: one encoding is copied
    kPerClient,  ///< for each client alone, against its acknowledged state: fewest bytes
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
    std::uint32_t silence_ticks = 12;  ///< a client gets a datagram at least this often, 1..15
    float tick_s = 1.0F / 30.0F;
    /// -1: the least volatile kind per entity; 0..4: only this PredictorOrder (order 1 where
    /// nothing falls, order 2 where nothing turns)
    int forced_order = -1;
    Codec codec = Codec::kShared;
    std::uint32_t codec_budget_us = 1000;  ///< Codec::kAuto: CPU time of coding per tick at most
    /// Falling entities land on it, zone-local; null: predictions let them fall on.
    std::shared_ptr<const motion::StaticGeometry> ground;
    /// Declared fields by type; empty: no type has any.
    wire::FieldSchemas fields;
    float redundancy_target =
        1e-6F;  ///< an update is repeated until the chance that all copies were lost is below this
    bool meter = false;  ///< count the use of bytes: Replicator::traffic()
    bool resend = true;  ///< off: lost updates are not sent again
};

struct ReplicationReport {
    std::uint32_t streams = 0;           ///< (entity, LOD) with a subscriber
    std::uint32_t publications = 0;      ///< encoded this tick
    std::uint32_t keyframes = 0;         ///< of these
    std::uint32_t records_sent = 0;      ///< copies into packets
    std::uint32_t records_resent = 0;    ///< of these: again, after loss or as redundancy
    std::uint32_t records_repeated = 0;  ///< of these: as redundancy, ahead of any loss
    std::uint32_t packets = 0;
    std::uint32_t packets_given_up = 0;  ///< without an acknowledgement: sent again
    std::uint32_t packets_found = 0;     ///< given up, and acknowledged after all
    std::uint32_t late = 0;              ///< clients whose acknowledgements are late
    std::uint32_t unreached = 0;         ///< clients for which nothing is made (Reach)
    std::uint64_t bytes = 0;             ///< bodies
    std::uint32_t over_budget = 0;  ///< clients with updates still pending when their budget ended
    std::uint32_t widened = 0;      ///< clients that were notified of bounds wider than promised
    EntityId limit_entity;          ///< one of those that exceeded a limit
    /// Entities, ghosts included, whose truth exceeded its declared a_max or dv_max.
    std::uint32_t limit_exceeded = 0;
    std::uint32_t inputs = 0;          ///< commands that were due
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
    std::uint32_t rtt_variation_us = 0;
    bool reached = true;                 ///< mailbox::Reach
    std::uint32_t rate_bytes_per_s = 0;  ///< its path's capacity; 0: no limit known
    wire::Widened widened;               ///< the bounds that it was last notified of
    std::vector<EntityId>
        known;  ///< entities that the client may hold: the new zone sends them anew or removes them
};

}  // namespace zoned::replication
