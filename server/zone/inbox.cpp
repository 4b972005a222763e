#include "server/zone/inbox.h"

#include "server/ai/agent/hot_reload_migration.h"
#include "server/zone/context/levers.h"
#include "server/zone/context/zone_context.h"
#include "server/zone/groups/group_changes.h"
#include "server/zone/simulation/zone_agents.h"
#include "server/zone/simulation/zone_soft_bodies.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <utility>

namespace zoned::zone {

namespace {

ZoneClient* client_of(ZoneState& state, ClientId client) {
    const int index = find_client(state, client);
    if (index < 0) {
        ++state.report.refused_items;
        return nullptr;
    }
    return &state.clients[static_cast<std::size_t>(index)];
}

void freeze(ZoneState& state, bool on) {
    state.frozen = on;
    if (on) {
        return;  // apply_inbox() brings all to rest
    }
    // Characters are looked at once and come to rest again by themselves.
    world::Entities& e = state.entities;
    for (world::Row row = 0; row < e.size(); ++row) {
        const physics::soft::SoftId soft = soft_of(state, e.id[row]);
        const bool sleeps = soft && !e.body[row] ? state.soft->bodies.asleep(soft)
                                                 : e.body[row] && !e.has(row, world::kGhost) &&
                                                       state.scene.state(e.body[row]).asleep;
        e.set(row, world::kAtRest, sleeps || e.has(row, world::kHidden));
    }
}

/// Applies one item; one overload per kind.
struct Apply {
    ZoneState& state;

    void operator()(const mailbox::Join& join) const {
        ZoneContext context(state);
        JoinRequest request;
        request.client = join.client;
        request.name = join.name;
        request.team = join.team;
        request.account = join.account;
        const Vec3d spawn(join.spawn[0], join.spawn[1], join.spawn[2]);
        request.spawn_position = (spawn - state.settings.region().origin()).cast<float>();

        ZoneClient client;
        client.client = join.client;
        client.rights = join.rights;
        client.account = join.account;
        client.name = join.name;
        client.avatar = state.rules->on_join(context, request);
        ZONED_ASSERT(state.entities.find(client.avatar) != world::kNoRow,
                     "rules spawn an avatar for who joins");
        client.own.client = join.client;
        const auto at = std::lower_bound(
            state.clients.begin(),
            state.clients.end(),
            join.client,
            [](const ZoneClient& c, ClientId wanted) { return c.client < wanted; });
        state.clients.insert(at, client);
        replication::ClientTransfer transfer;
        transfer.client = join.client;
        state.replicator.add_client(transfer);
        state.out.messages.emplace_back(
            mailbox::Joined{join.client, client.avatar, state.settings.id, state.now});
    }

    void operator()(const mailbox::Leave& leave) const {
        const ZoneClient* client = client_of(state, leave.client);
        if (client == nullptr) {
            return;
        }
        ZoneContext context(state);
        const EntityId avatar = client->avatar;
        context.store_stand(*client);
        state.replicator.remove_client(leave.client);
        state.clients.erase(state.clients.begin() + find_client(state, leave.client));
        const world::Row row = state.entities.find(avatar);
        if (row != world::kNoRow) {
            state.entities.set_client(row, ClientId());
        }
        state.rules->on_leave(context, leave.client, avatar);
        state.out.departed.push_back(leave.client);
    }

    void operator()(const mailbox::Input& input) const {
        if (ZoneClient* client = client_of(state, input.client)) {
            for (const motion::InputCommand& command : input.commands) {
                client->inputs.store(command, state.now);
            }
            state.replicator.on_heard(input.client);
        }
    }

    void operator()(const mailbox::Acks& acks) const {
        if (client_of(state, acks.client) != nullptr) {
            state.replicator.on_acks(acks);
        }
    }

    void operator()(const mailbox::Command& command) const {
        if (const ZoneClient* client = client_of(state, command.client)) {
            ZoneContext context(state);
            state.rules->on_command(
                context, command.client, client->avatar, command.kind, command.payload);
        }
    }

    void operator()(const mailbox::Confirm& confirm) const {
        if (client_of(state, confirm.client) != nullptr) {
            ZoneContext context(state);
            state.rules->on_confirm(context, confirm.client, confirm.event);
        }
    }

    void operator()(const mailbox::ViewReset& reset) const {
        if (client_of(state, reset.client) != nullptr) {
            state.replicator.reset_view(reset.client);
        }
    }

    void operator()(const mailbox::Reach& reach) const {
        state.replicator.set_reach(reach.client, reach.on);
    }

    void operator()(const mailbox::NewBrains& fresh) const {
        ZONED_ASSERT(fresh.settings != nullptr, "new brains were read before they are sent");
        for (std::size_t n = 0; n < state.agents.size(); ++n) {
            const world::Row row = state.entities.find(state.agents.at(state.agents.nth(n)).entity);
            if (row != world::kNoRow) {
                wake_agent(state, row);
            }
        }
        const ai::AiSettings before = std::move(state.settings.ai);
        state.settings.ai = *fresh.settings;
        const std::string wrong = ai::bind_code(state.settings.ai, state.rules->coded_machines());
        ZONED_ASSERT(wrong.empty(), "new brains were tried with these rules before they are sent");
        state.brains_replaced = true;
        ai::go_on_with(
            state.ai_update.difficulty(), before.difficulty, state.settings.ai, state.now);
        const std::vector<std::uint16_t>& of_type = state.settings.ai.brain_of_type;
        ai::migrate(
            state.agents,
            before,
            state.settings.ai,
            [&](const ai::Agent& agent) {
                const world::Row row = state.entities.find(agent.entity);
                ZONED_ASSERT(row != world::kNoRow, "an agent belongs to an entity that is here");
                return static_cast<std::uint16_t>(of_type[state.entities.type[row]] - 1);
            },
            state.now,
            state.settings.dt);
    }

    void operator()(const mailbox::CodecPrice& price) const {
        state.replicator.set_codec_price(price);
    }

    void operator()(const mailbox::Freeze& item) const { freeze(state, item.on); }

    void operator()(const mailbox::SpawnOrder& order) const {
        const world::TypeTable& types = *state.settings.types;
        const Vec3d at(order.position[0], order.position[1], order.position[2]);
        if (order.type >= types.size() ||
            (types[order.type].assembly != 0 && types[order.type].part != 0) || !at.allFinite()) {
            answer(order.number, EntityId(), "no such entity can be spawned there");
            return;
        }
        SpawnDef def;
        def.type = order.type;
        def.position = (at - state.settings.region().origin()).cast<float>();
        def.yaw = order.yaw;
        answer(order.number, ZoneContext(state).spawn(def), "");
    }

    void operator()(const mailbox::MoveOrder& order) const {
        const world::Row row = state.entities.find(order.entity);
        const Vec3d at(order.position[0], order.position[1], order.position[2]);
        if (row == world::kNoRow || state.entities.has(row, world::kGhost) ||
            state.entities.has(row, world::kHidden) || !at.allFinite()) {
            answer(order.number, order.entity, "the entity is not in the world, or hidden");
            return;
        }
        ZoneContext(state).teleport(order.entity,
                                    (at - state.settings.region().origin()).cast<float>());
        answer(order.number, order.entity, "");
    }

    void answer(std::uint64_t number, EntityId entity, const char* refused) const {
        state.report.refused_items += *refused != '\0' ? 1 : 0;
        state.out.messages.emplace_back(mailbox::OrderDone{number, entity, refused});
    }

    void operator()(const mailbox::StoreAnswer& answer) const {
        ZoneContext context(state);
        state.rules->on_store(context, answer);
    }

    void operator()(const mailbox::AuditRequest& request) const {
        if (ZoneClient* client = client_of(state, request.client)) {
            client->audit_due = true;
        }
    }

    // The world keeps these to itself.
    void operator()(const mailbox::Notice& /*notice*/) const {}

    void operator()(const mailbox::SessionBegun& /*begun*/) const {}

    void operator()(const mailbox::SessionProgress& /*progress*/) const {}

    void operator()(const mailbox::StoreKept& /*kept*/) const {}
};

}  // namespace

void rest_all(ZoneState& state) {
    world::Entities& e = state.entities;
    for (world::Row row = 0; row < e.size(); ++row) {
        e.velocity[row].setZero();
        e.angular_velocity[row].setZero();
        e.acceleration[row].setZero();
        e.set(row, world::kAtRest, true);
    }
}

std::uint32_t apply_inbox(ZoneState& state, std::span<const mailbox::InboxItem> inbox) {
    for (const mailbox::InboxItem& item : inbox) {
        std::visit(Apply{state}, item);
    }
    ZoneContext context(state);
    for (const RulesMessage& message : state.messages_in) {
        if (message.user) {
            turn_lever(state, context, message.target, message.user);
        } else {
            state.rules->on_message(context, message.target, message.payload);
        }
    }
    const auto count = static_cast<std::uint32_t>(inbox.size() + state.messages_in.size()) +
                       tell_group_changes(state, context);
    state.messages_in.clear();
    if (state.frozen) {
        // Bodies that the rules spawn or throw at a client's word rest like all others: a kill that
        // is confirmed now makes a ragdoll.
        rest_all(state);
    }
    return count;
}

}  // namespace zoned::zone
