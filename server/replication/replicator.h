// Replicator: turns the visible sets of viewers into state packets: it encodes once, promises a
// bound, and keeps lost updates pending.
#pragma once

#include "server/mailbox/messages.h"
#include "server/replication/replication_settings.h"
#include "server/world/entities.h"
#include "server/world/entity_type.h"
#include "server/world/visibility.h"
#include "shared/core/ids.h"
#include "shared/core/state_hash.h"
#include "shared/wire/traffic.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace zoned::core {
class FieldReader;
class FieldWriter;
}  // namespace zoned::core

namespace zoned::replication {

/// Replication state of one zone. Deterministic; no wall clock: round trips and losses come in with
/// the acks.
///
/// It relies on these properties of clients. Records are ordered by the packets that carried them
/// (tick or sequence), whatever zone or level of detail they belong to. Within a stream the
/// publication tick gives the same order. A remove ends the entity and its keyframes for all older
/// packets. It is itself void when a newer packet has named the entity. A keyframe is stored even
/// when its state is out of date, unless a newer one with its number is there. Acknowledged means
/// stored.
///
/// A stream's numbering starts anew when it is created again. That is safe because deltas refer
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
    /// Something else came from the client: after an outage it is asked sooner for its state.
    void on_heard(ClientId client);
    /// Whether packets to the client have anywhere to go; until they have, none is made.
    void set_reach(ClientId client, bool on);
    [[nodiscard]] bool reaches(ClientId client) const;
    /// Everything becomes pending for this client again, absolute.
    void reset_view(ClientId client);

    /// One tick. `visibility` and `own` ascend by client id. Packets are appended to `out`,
    /// ascending by client. A removed entity is announced by its absence from VisibleSet::visible.
    /// A client without a set gets only signs of life. Orientation is taken from
    /// Entities::orientation, also of upright entities. Accelerations above a type's a_max are
    /// impacts and are not extrapolated.
    ReplicationReport step(Tick now,
                           ZoneId zone,
                           const world::Entities& entities,
                           const world::TypeTable& types,
                           const world::Visibility& visibility,
                           std::span<const OwnInput> own,
                           std::vector<mailbox::StatePacket>& out);

    /// The tick when truth last left the prediction of the stream (entity, lod): in position or
    /// orientation by more than the bound, or in velocity by more than dv_max. Within a second
    /// after a publication that replaced a good one (rest, heartbeat), it also counts when truth
    /// left that one. 0 = never or no such stream. For audits.
    [[nodiscard]] Tick breach_tick(EntityId entity, std::uint8_t lod) const;

    /// The tick when this client passed from one stream of the entity to another (level of detail,
    /// zone), 0 = never. Until an update of the new stream has come it still predicts from the old
    /// one. Nobody watches the breaches of the old stream any more: for an audit that is a breach
    /// of its own.
    [[nodiscard]] Tick switch_tick(ClientId client, EntityId entity) const;

    /// The prediction of a client that has a publication.
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

    /// The promised error of the entity's position for this client, m; 0: it is not subscribed to
    /// it.
    [[nodiscard]] float bound_m(ClientId client, EntityId entity) const;

    /// An entity as a client is assumed to show it.
    struct AssumedState {
        EntityId entity;
        Vec3 position = Vec3::Zero();  ///< predicted for the tick asked for, zone-local, m
        float bound_m = 0.0F;          ///< the promised error
        std::uint8_t lod = 0;
        Quat orientation = Quat::Identity();  ///< predicted likewise; of upright entities no figure
    };

    /// The states that a client was sent, without its own avatar, ascending by entity, at `now`.
    /// Entities of which it has nothing yet are left out.
    void shown_to(ClientId client, Tick now, std::vector<AssumedState>& out) const;

    /// The use of the network by one entity, for as long as some client is subscribed to it.
    struct NetworkUse {
        std::uint64_t publications = 0;
        std::uint64_t records = 0;  ///< copies into packets
        std::uint64_t bytes = 0;    ///< of these; of records coded for one client their mean size
    };

    [[nodiscard]] NetworkUse spent_on(EntityId entity) const;

    /// The time that an update takes to this client, ticks, rounded up: half of its round trip; 0:
    /// not measured yet.
    [[nodiscard]] Tick one_way_ticks(ClientId client) const;

    /// The unacknowledged packets about entities to this client. For each entity: the packets that
    /// carried an update or its removal since the newest acknowledged one. Ascending by entity. For
    /// audits. Packets of other zones are not known here: returns the tick from which on all are, 0
    /// if none.
    Tick unacknowledged(ClientId client, std::vector<mailbox::AuditUpdate>& out) const;

    /// Whether any client is subscribed to the entity.
    [[nodiscard]] bool heard(EntityId entity) const;
    /// Entities that any client is subscribed to.
    [[nodiscard]] std::size_t heard_count() const;
    /// Calls `visit` for each of them, in no order.
    void for_each_heard(const std::function<void(EntityId)>& visit) const;

    void hash(core::StateHash& hash) const;

    /// All clients and publications, between two ticks, with what the coder of each client has
    /// learned. Figures of traffic are no state.
    void save(core::FieldWriter& archive) const;
    /// Takes the place of everything here; the settings are those of the replicator that was saved.
    void load(core::FieldReader& archive);

    /// The use of the bytes in the bodies of all packets so far; nullptr without
    /// ReplicationSettings::meter.
    [[nodiscard]] const wire::TrafficTable* traffic() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace zoned::replication
