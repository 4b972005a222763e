// StreamTable: the publications of a zone, one stream per subscribed (entity, level of detail);
// each publication is encoded once for all its subscribers.
#pragma once

#include "server/replication/limit_check.h"
#include "server/replication/motion_estimate.h"
#include "server/replication/replication_settings.h"
#include "server/replication/volatility.h"
#include "server/world/entities.h"
#include "server/world/entity_type.h"
#include "shared/core/state_hash.h"
#include "shared/wire/publication.h"
#include "shared/wire/record/coded_record.h"

#include <array>
#include <optional>
#include <unordered_map>

namespace zoned::replication {

/// Keyframes of a stream that deltas may still refer to. Their serials are consecutive, so their
/// numbers on the wire (serial modulo 16) never clash.
inline constexpr std::uint32_t kKeyframesKept = 4;
static_assert(kKeyframesKept < wire::kKeyframeNumbers);

using StreamIndex = std::uint32_t;
inline constexpr StreamIndex kNoStream = 0xFFFFFFFFu;

/// A publication that was sent absolute; each client that received it holds it under its number.
struct Keyframe {
    std::uint32_t serial = 0;  ///< counted from 1 in the life of a stream; 0 = none
    Tick tick = 0;             ///< of the publication
    wire::QuantizedState state;
    std::vector<std::uint8_t> delta;  ///< the newest publication against this keyframe
    bool delta_ready = false;
};

/// A publication that a client may still predict from.
struct Past {
    motion::KinematicState from;
    motion::PredictorOrder order = motion::PredictorOrder::kStatic;
    Tick tick = 0;
    std::uint32_t version = 0;  ///< 0: none
    /// It was replaced while truth was still within its bound (a heartbeat, an entity that came to
    /// rest or looks different). Subscribers far away follow it a little longer, and truth may
    /// leave it until then. 0: nothing to watch.
    Tick watched_until = 0;
};

inline constexpr std::uint32_t kPastKept = 12;

/// The newest publication of one entity at one level of detail.
struct Stream {
    EntityId entity;
    std::uint8_t lod = 0;
    TypeIndex type = 0;
    bool upright = false;
    bool at_rest = false;
    bool keyframe_due = false;  ///< everybody gets this publication absolute
    bool heartbeat = false;     ///< this publication is one: its bound was not broken
    bool is_keyframe = false;   ///< this publication was sent absolute: it is keyframe last_serial
    float priority = 1.0F;
    std::uint32_t subscribers = 0;
    std::uint32_t version = 0;  ///< counts publications; 0 = nothing published yet
    std::uint32_t last_serial = 0;
    std::uint32_t since_keyframe = 0;
    std::uint64_t sent_records = 0;  ///< copies into packets so far; the simulation never reads it
    std::uint64_t sent_bytes = 0;    ///< of these
    Tick tick = 0;                   ///< of the publication
    Tick alive_tick = 0;   ///< of the publication, or when truth was last seen to rest as published
    Tick breach_tick = 0;  ///< when truth last left the prediction, or a watched one of `past`
    Tick watched_until = 0;  ///< the latest of `past`
    wire::QuantizedState state;
    motion::KinematicState from;         ///< state, dequantised: the base of all predictions
    motion::KinematicState settled;      ///< truth that `state` is known to represent exactly
    std::vector<std::uint8_t> absolute;  ///< encoded when first needed; empty before
    motion::KinematicState truth;        ///< in this tick
    std::array<Past, kPastKept> past;    ///< version v at v modulo kPastKept
    std::array<Keyframe, kKeyframesKept> keyframes;
    Volatility volatility;
};

/// Bytes of the newest publication for one subscriber.
struct Encoded {
    const std::vector<std::uint8_t>* bytes = nullptr;
    std::uint32_t keyframe = 0;  ///< absolute: the serial that the receiver will hold; delta: 0
};

/// The declared fields of one entity as they were published last: the same in all its streams.
struct PublishedFields {
    TypeIndex type = 0;
    Tick newest = 0;                   ///< of `changed`
    std::vector<std::uint32_t> words;  ///< as those of world::FieldColumns
    std::vector<Tick> changed;         ///< by field: when its value was published
};

class StreamTable final : public wire::record::DeclaredSource {
  public:
    explicit StreamTable(const ReplicationSettings& settings);

    /// Finds or creates the stream and counts a subscriber.
    StreamIndex subscribe(EntityId entity, std::uint8_t lod);
    void unsubscribe(StreamIndex index);
    /// Frees streams that have had no subscriber since the last call.
    void collect();

    /// Tests every stream against truth and publishes where the promise asks for it.
    void publish(Tick now,
                 const world::Entities& entities,
                 const world::TypeTable& types,
                 ReplicationReport& report);

    [[nodiscard]] const Stream& operator[](StreamIndex index) const { return streams_[index]; }

    /// Stream::version, without a look at the stream: most have nothing new.
    [[nodiscard]] std::uint32_t version(StreamIndex index) const { return versions_[index]; }

    [[nodiscard]] std::uint32_t size() const { return used_; }

    /// Streams that there are or were: indexes are below it.
    [[nodiscard]] std::size_t rows() const { return streams_.size(); }

    /// The distance of truth, now or within the next ticks, from the prediction of a subscriber
    /// that holds version `version`, as a multiple of the bound; infinity where that is not known
    /// any more.
    [[nodiscard]] float excess(StreamIndex index, std::uint32_t version, Tick now) const;

    /// The same for one that predicts from `held`, of whatever stream of the entity, or from a
    /// state that differs by up to `off_m` and `off_rad`.
    [[nodiscard]] float excess(StreamIndex index,
                               const Past& held,
                               float off_m,
                               float off_rad,
                               Tick now) const;

    /// A publication that is still kept; else nullptr.
    [[nodiscard]] const Past* past(StreamIndex index, std::uint32_t version) const {
        const Past& past = streams_[index].past[version % kPastKept];
        return version != 0 && past.version == version ? &past : nullptr;
    }

    /// A publication as it predicts a moment.
    struct Predicted {
        Vec3 position = Vec3::Zero();
        float blend_m = 0.0F;  ///< see Replicator::SentState
    };

    /// The publication of tick `publication`, no newer than version `newest`, that was not replaced
    /// before `since`; evaluated at `at`. None when it is not known (any more).
    [[nodiscard]] std::optional<Predicted> past_at(StreamIndex index,
                                                   Tick publication,
                                                   std::uint32_t newest,
                                                   Tick at,
                                                   Tick since) const;

    /// Whether the entity has a stream.
    [[nodiscard]] bool has(EntityId entity) const { return slot_index_.contains(entity); }

    /// Entities with a stream.
    [[nodiscard]] std::size_t entities() const { return slot_index_.size(); }

    /// Calls visit(entity) for each of them.
    template <class Visit>
    void for_each_entity(Visit&& visit) const {
        for (const EntityStreams& slot : slots_) {
            if (slot.entity) {
                visit(slot.entity);
            }
        }
    }

    /// The newest publication for a subscriber that holds keyframe `held` (0: none) of this stream:
    /// a delta where that keyframe is still kept and the delta is smaller, else absolute. Version
    /// must not be 0. The bytes stay valid until the next publish().
    Encoded encode(StreamIndex index, std::uint32_t held);
    /// The declared fields of a subscribed entity whose type has some.
    [[nodiscard]] wire::record::DeclaredValues declared_of(EntityId entity) const override;

    /// When a declared field of an entity was last published; 0: its type has none.
    [[nodiscard]] Tick fields_tick(EntityId entity) const;

    /// Bytes of the declared fields that a client lacks which holds this version of the stream (0:
    /// none of it).
    [[nodiscard]] std::uint32_t declared_bytes(StreamIndex index, std::uint32_t held) const;

    /// Must follow an encode() whose absolute bytes are really sent. True when that made the
    /// publication a keyframe.
    bool sent_absolute(StreamIndex index);

    /// A record of the stream went into a packet.
    void count_sent(StreamIndex index, std::size_t bytes) {
        ++streams_[index].sent_records;
        streams_[index].sent_bytes += bytes;
    }

    /// kNoStream when nobody subscribes.
    [[nodiscard]] StreamIndex find(EntityId entity, std::uint8_t lod) const;

    void hash(core::StateHash& hash) const;

    template <class Archive>
    void serialize(Archive& archive) {
        archive(streams_, free_streams_, abandoned_, slots_, free_slots_, used_);
        archive(published_, free_published_);
        if constexpr (Archive::kReads) {
            if (!find_slots()) {
                archive.fail("publications name others that there are not");
            }
        }
    }

  private:
    /// Makes `slot_index_` anew; false where numbers name what there is not.
    [[nodiscard]] bool find_slots();

    /// One entity with its streams by level of detail.
    struct EntityStreams {
        EntityId entity;  // none: free
        std::array<StreamIndex, wire::kLods> stream{};
        LimitCheck limits;
        MotionEstimate estimate;
        std::uint32_t fields = 0;  // 1 + index of what is published of them; 0: nothing
    };

    EntityStreams& slot_of(EntityId entity);
    void step_stream(Stream& stream,
                     Tick now,
                     const world::Entities& entities,
                     world::Row row,
                     const Truth& truth,
                     const world::EntityType& type,
                     Tick fields_tick,
                     ReplicationReport& report);
    Tick follow_fields(EntityStreams& slot,
                       Tick now,
                       const world::Entities& entities,
                       world::Row row);
    [[nodiscard]] wire::DeclaredPart part_of(const Stream& stream, Tick since) const;
    [[nodiscard]] Truth truth_of(Tick now,
                                 const world::Entities& entities,
                                 world::Row row,
                                 const world::EntityType& type,
                                 MotionEstimate& estimate) const;
    /// Whether truth leaves the newest prediction now; notes the breach, also of watched ones
    /// before.
    bool note_breach(Stream& stream,
                     Tick now,
                     const motion::KinematicState& truth,
                     const world::EntityType& type);
    bool leaves_watched(Stream& stream,
                        Tick now,
                        const motion::KinematicState& truth,
                        const LodBound& bound) const;
    void publish_state(Stream& stream,
                       Tick now,
                       const Truth& truth,
                       bool at_rest,
                       std::uint16_t appearance,
                       ReplicationReport& report);
    void free_stream(StreamIndex index);

    ReplicationSettings settings_;
    std::array<wire::Quantization, wire::kLods> quantization_;  // by level of detail
    std::vector<Stream> streams_;
    std::vector<std::uint32_t> versions_;  // of each
    std::vector<StreamIndex> free_streams_;
    std::vector<StreamIndex> abandoned_;  // reached zero subscribers since the last collect()
    std::vector<EntityStreams> slots_;
    std::vector<std::uint32_t> free_slots_;
    std::unordered_map<EntityId, std::uint32_t> slot_index_;  // looked up, never iterated
    std::uint32_t used_ = 0;
    std::vector<PublishedFields> published_;  // of entities with declared fields
    std::vector<std::uint32_t> free_published_;
};

}  // namespace zoned::replication
