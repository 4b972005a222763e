#include "server/replication/replicator.h"

#include "server/replication/client_state.h"
#include "server/replication/delivery/zone_silence.h"
#include "server/replication/packer.h"
#include "server/replication/stream_table.h"
#include "shared/core/archive/field_archive.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace zoned::replication {

struct Replicator::Impl {
    explicit Impl(const ReplicationSettings& s) : settings(s), streams(s), packer(s) {}

    template <class Archive>
    void serialize(Archive& archive) {
        archive.section("publications", [&] { archive(streams); });
        archive.section("packer", [&] { archive(packer, codec_choice, codec_price, silence); });
        std::uint64_t count = clients.size();
        archive(count);
        if constexpr (Archive::kReads) {
            clients.clear();
        }
        for (std::uint64_t i = 0; i < count && archive.good(); ++i) {
            archive.section("client " + std::to_string(i), [&] {
                if constexpr (Archive::kReads) {
                    clients.push_back(std::make_unique<ClientState>(ClientTransfer{}, settings));
                }
                archive(*clients[static_cast<std::size_t>(i)]);
                clients[static_cast<std::size_t>(i)]->serialize_coder(archive, settings);
                if constexpr (Archive::kReads) {
                    if (!clients.back()->is_sound(streams) ||
                        (i > 0 && !(clients[i - 1]->client < clients[i]->client))) {
                        archive.fail("is out of order, or hears of what is not published");
                    }
                }
            });
        }
    }

    auto find(ClientId client) {
        const auto it = std::lower_bound(
            clients.begin(), clients.end(), client, [](const auto& state, ClientId id) {
                return state->client < id;
            });
        return it != clients.end() && (*it)->client == client ? it : clients.end();
    }

    void subscribe_viewers(Tick now,
                           const world::Visibility& visibility,
                           const world::Entities& entities);
    [[nodiscard]] std::optional<world::Visible> own_fields_of(
        ClientId client,
        const world::Entities& entities) const;
    void choose_codecs(Tick now);
    void list_avatars(const world::Entities& entities);
    OwnNow own_state(Tick now,
                     ClientId client,
                     const world::Entities& entities,
                     std::span<const OwnInput> own) const;

    ReplicationSettings settings;
    StreamTable streams;
    Packer packer;
    std::vector<std::unique_ptr<ClientState>> clients;  // ascending by id
    std::vector<Subscription> scratch;
    std::vector<world::Visible> with_own;  // scratch
    ZoneSilence silence;
    CodecPlan codec_plan;
    CodecChoice codec_choice;
    mailbox::CodecPrice codec_price;
    std::vector<CodecWish> codec_wishes;                   // scratch
    std::vector<std::pair<ClientId, world::Row>> avatars;  // ascending by client, this tick
};

Replicator::Replicator(const ReplicationSettings& settings) {
    ZONED_ASSERT(!settings.lods.empty() && settings.lods.size() <= wire::kLods, "1..4 LODs");
    ZONED_ASSERT(settings.tick_s > 0.0F, "a tick has a length");
    impl_ = std::make_unique<Impl>(settings);
}

void Replicator::save(core::FieldWriter& archive) const {
    impl_->serialize(archive);
}

void Replicator::load(core::FieldReader& archive) {
    impl_->serialize(archive);
}

Replicator::Replicator(Replicator&&) noexcept = default;
Replicator& Replicator::operator=(Replicator&&) noexcept = default;
Replicator::~Replicator() = default;

void Replicator::add_client(const ClientTransfer& transfer) {
    auto& clients = impl_->clients;
    const auto at = std::lower_bound(
        clients.begin(), clients.end(), transfer.client, [](const auto& state, ClientId id) {
            return state->client < id;
        });
    ZONED_ASSERT(at == clients.end() || (*at)->client != transfer.client,
                 "a client is in a zone once");
    clients.insert(at, std::make_unique<ClientState>(transfer, impl_->settings));
}

ClientTransfer Replicator::remove_client(ClientId client) {
    const auto it = impl_->find(client);
    ZONED_ASSERT(it != impl_->clients.end(), "only a client that is here can be removed");
    ClientTransfer transfer = (*it)->transfer();
    for (const Subscription& s : (*it)->subscriptions) {
        impl_->streams.unsubscribe(s.stream);
    }
    impl_->clients.erase(it);
    return transfer;
}

void Replicator::on_acks(const mailbox::Acks& acks) {
    // Acks of a client that has just moved away are no mistake: they are nothing to us any more.
    const auto it = impl_->find(acks.client);
    if (it != impl_->clients.end() && (*it)->on_acks(acks)) {
        impl_->silence.on_acknowledged();
    }
}

void Replicator::set_codec_price(const mailbox::CodecPrice& price) {
    impl_->codec_price = price;
}

const mailbox::CodecPrice& Replicator::codec_price() const {
    return impl_->codec_price;
}

void Replicator::on_heard(ClientId client) {
    const auto it = impl_->find(client);
    if (it != impl_->clients.end()) {
        (*it)->on_heard();
    }
}

void Replicator::set_reach(ClientId client, bool on) {
    const auto it = impl_->find(client);
    if (it != impl_->clients.end()) {
        (*it)->set_reach(on);
    }
}

bool Replicator::reaches(ClientId client) const {
    const auto it = impl_->find(client);
    return it == impl_->clients.end() || (*it)->reached();
}

void Replicator::reset_view(ClientId client) {
    const auto it = impl_->find(client);
    if (it != impl_->clients.end()) {
        (*it)->reset_view();
    }
}

ReplicationReport Replicator::step(Tick now,
                                   ZoneId zone,
                                   const world::Entities& entities,
                                   const world::TypeTable& types,
                                   const world::Visibility& visibility,
                                   std::span<const OwnInput> own,
                                   std::vector<mailbox::StatePacket>& out) {
    ReplicationReport report;
    Impl& z = *impl_;
    if (!visibility.empty()) {
        z.list_avatars(entities);
    }
    z.subscribe_viewers(now, visibility, entities);
    z.streams.collect();
    report.skipped = visibility.empty();
    report.inputs = static_cast<std::uint32_t>(own.size());
    for (const OwnInput& input : own) {
        report.inputs_missing += input.input_missing ? 1 : 0;
    }
    if (!report.skipped) {
        z.streams.publish(now, entities, types, report);
    }
    z.choose_codecs(now);
    z.silence.begin_tick();
    for (const auto& client : z.clients) {
        if (!client->reached()) {
            ++report.unreached;
            continue;
        }
        client->expire(now, z.settings.tick_s, z.silence);
        const OwnNow own_now =
            report.skipped ? OwnNow{} : z.own_state(now, client->client, entities, own);
        const std::uint32_t records_before = report.records_sent;
        const std::uint32_t packets_before = report.packets;
        z.packer.pack(now, zone, own_now, *client, z.streams, report, out);
        const std::uint32_t records = report.records_sent - records_before;
        client->demand.add(records,
                           records > 0 ? report.packets - packets_before : 0,
                           client->allowed_bytes(z.settings));
        const ClientState::Fates fates = client->take_fates();
        report.packets_given_up += fates.given_up;
        report.packets_found += fates.found;
        report.late += client->acks_are_late() ? 1 : 0;
    }
    report.codec = z.codec_choice;
    return report;
}

/// By the recent output to each client, in counted units. Every machine that was given the same
/// price decides the same.
void Replicator::Impl::choose_codecs(Tick now) {
    if (settings.codec != Codec::kAuto) {
        return;
    }
    packer.allow_coding(codec_price);
    if (now % CodecPlan::kEvery != 0) {
        return;
    }
    codec_wishes.clear();
    for (const auto& client : clients) {
        codec_wishes.push_back({client->demand, client->coder != nullptr});
    }
    codec_choice = codec_plan.choose(
        codec_wishes, codec_price, 1e3 * static_cast<double>(settings.codec_budget_us));
    for (std::size_t i = 0; i < clients.size(); ++i) {
        clients[i]->code(codec_wishes[i].coded, settings);
    }
}

/// Clients without a set (not viewers at the moment) hear of nothing.
void Replicator::Impl::subscribe_viewers(Tick now,
                                         const world::Visibility& visibility,
                                         const world::Entities& entities) {
    auto set = visibility.begin();
    for (const auto& client : clients) {
        while (set != visibility.end() && set->client < client->client) {
            ++set;
        }
        const bool was_viewer = client->is_viewer;
        client->is_viewer = set != visibility.end() && set->client == client->client;
        const std::optional<world::Visible> own =
            client->is_viewer ? own_fields_of(client->client, entities) : std::nullopt;
        if (client->is_viewer && was_viewer && !set->changed &&
            (!own || client->subscription(own->entity) != nullptr)) {
            continue;  // as it was synchronised before
        }
        if (own) {
            with_own.assign(set->visible.begin(), set->visible.end());
            const auto at = lower_bound_entity(with_own, own->entity);
            if (at == with_own.end() || at->entity != own->entity) {
                with_own.insert(at, *own);
            }
            client->update_subscriptions(with_own, now, streams, scratch);
        } else if (client->is_viewer) {
            client->update_subscriptions(set->visible, now, streams, scratch);
        } else {
            client->detach(now, streams, scratch);
        }
    }
}

/// A client hears of its own avatar's motion apart, but of its declared fields as others do.
std::optional<world::Visible> Replicator::Impl::own_fields_of(
    ClientId client,
    const world::Entities& entities) const {
    if (settings.fields.empty()) {
        return std::nullopt;
    }
    const auto avatar = std::lower_bound(
        avatars.begin(), avatars.end(), client, [](const auto& entry, ClientId id) {
            return entry.first < id;
        });
    if (avatar == avatars.end() || avatar->first != client ||
        wire::schema_of(settings.fields, entities.type[avatar->second]) == nullptr) {
        return std::nullopt;
    }
    return world::Visible{entities.id[avatar->second], 0};
}

void Replicator::Impl::list_avatars(const world::Entities& entities) {
    avatars.clear();
    world::for_each_row(entities.avatars(), [&](world::Row row) {
        if (!entities.has(row, world::kGhost)) {
            avatars.emplace_back(entities.client[row], row);
        }
    });
    std::sort(avatars.begin(), avatars.end());
}

OwnNow Replicator::Impl::own_state(Tick now,
                                   ClientId client,
                                   const world::Entities& entities,
                                   std::span<const OwnInput> own) const {
    OwnNow result;
    const auto avatar = std::lower_bound(
        avatars.begin(), avatars.end(), client, [](const auto& entry, ClientId id) {
            return entry.first < id;
        });
    if (avatar == avatars.end() || avatar->first != client) {
        return result;
    }
    const world::Row row = avatar->second;
    result.present = true;
    result.discontinuity_tick = entities.discontinuity_tick[row];
    result.state.avatar = entities.id[row];
    result.state.input_tick = now;
    result.state.state = {entities.position[row],
                          entities.velocity[row],
                          entities.yaw[row],
                          entities.has(row, world::kGrounded),
                          entities.has(row, world::kCarried) || entities.has(row, world::kHidden)};
    const auto input =
        std::lower_bound(own.begin(), own.end(), client, [](const OwnInput& i, ClientId id) {
            return i.client < id;
        });
    if (input != own.end() && input->client == client) {
        result.state.input_tick = input->input_tick;
        result.state.input_missing = input->input_missing;
        result.state.input_lead = input->input_lead;
    }
    return result;
}

Tick Replicator::breach_tick(EntityId entity, std::uint8_t lod) const {
    const StreamIndex index = impl_->streams.find(entity, lod);
    return index == kNoStream ? 0 : impl_->streams[index].breach_tick;
}

Tick Replicator::switch_tick(ClientId client, EntityId entity) const {
    const auto it = impl_->find(client);
    return it == impl_->clients.end() ? 0 : (*it)->switch_tick(entity);
}

std::optional<Replicator::SentState> Replicator::sent_state(ClientId client,
                                                            EntityId entity,
                                                            Tick publication,
                                                            Tick at,
                                                            Tick since) const {
    const auto it = impl_->find(client);
    const Subscription* s = it != impl_->clients.end() ? (*it)->subscription(entity) : nullptr;
    if (s == nullptr) {
        return std::nullopt;
    }
    for (std::uint8_t lod = 0; lod < impl_->settings.lods.size(); ++lod) {
        const StreamIndex index = impl_->streams.find(entity, lod);
        if (index == kNoStream) {
            continue;
        }
        // A level that the client has left sends nothing more, and all that it sent was sent
        // before.
        const std::uint32_t newest =
            index == s->stream ? s->sent_version : impl_->streams[index].version;
        if (const auto found = impl_->streams.past_at(index, publication, newest, at, since)) {
            return SentState{found->position, found->blend_m};
        }
    }
    return std::nullopt;
}

float Replicator::bound_m(ClientId client, EntityId entity) const {
    const auto it = impl_->find(client);
    const Subscription* s = it != impl_->clients.end() ? (*it)->subscription(entity) : nullptr;
    return s != nullptr ? impl_->settings.lods[s->lod].position_m : 0.0F;
}

void Replicator::shown_to(ClientId client, Tick now, std::vector<AssumedState>& out) const {
    out.clear();
    const auto it = impl_->find(client);
    if (it == impl_->clients.end()) {
        return;
    }
    for (const Subscription& s : (*it)->subscriptions) {
        if (const Past* held = impl_->streams.past(s.stream, held_version(s))) {
            const float elapsed = elapsed_seconds(held->tick, now, impl_->settings.tick_s);
            out.push_back({s.entity,
                           motion::predict_position(held->from, held->order, elapsed),
                           impl_->settings.lods[s.lod].position_m,
                           s.lod,
                           motion::predict_orientation(held->from, held->order, elapsed)});
        }
    }
}

Replicator::NetworkUse Replicator::spent_on(EntityId entity) const {
    NetworkUse out;
    for (std::uint8_t lod = 0; lod < impl_->settings.lods.size(); ++lod) {
        const StreamIndex index = impl_->streams.find(entity, lod);
        if (index != kNoStream) {
            const Stream& stream = impl_->streams[index];
            out.publications += stream.version;
            out.records += stream.sent_records;
            out.bytes += stream.sent_bytes;
        }
    }
    return out;
}

Tick Replicator::one_way_ticks(ClientId client) const {
    const auto it = impl_->find(client);
    if (it == impl_->clients.end()) {
        return 0;
    }
    const double half_s = 0.5e-6 * static_cast<double>((*it)->rtt_us());
    return static_cast<Tick>(std::ceil(half_s / static_cast<double>(impl_->settings.tick_s)));
}

Tick Replicator::unacknowledged(ClientId client, std::vector<mailbox::AuditUpdate>& out) const {
    out.clear();
    const auto it = impl_->find(client);
    return it != impl_->clients.end() ? (*it)->unacknowledged(out) : 0;
}

bool Replicator::heard(EntityId entity) const {
    return impl_->streams.has(entity);
}

std::size_t Replicator::heard_count() const {
    return impl_->streams.entities();
}

void Replicator::for_each_heard(const std::function<void(EntityId)>& visit) const {
    impl_->streams.for_each_entity(visit);
}

const wire::TrafficTable* Replicator::traffic() const {
    return impl_->packer.traffic();
}

void Replicator::hash(core::StateHash& hash) const {
    impl_->streams.hash(hash);
    for (const auto& client : impl_->clients) {
        client->hash(hash);
    }
}

}  // namespace zoned::replication
