// FakeZone: a sandbox game on a FakeContext.
#pragma once

#include "server/rules/sandbox.h"
#include "tests/unit/rules/fake_context.h"
#include "proto/sandbox.pb.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace zoned::rules::test {

class FakeZone final : public FakeContext {
  public:
    explicit FakeZone(std::uint16_t zone_number = 1,
                      const Vec3d& zone_origin = Vec3d::Zero(),
                      const zone::RulesSettings& settings = {})
        : FakeContext(zone_number, zone_origin),
          game(settings, types()) {}

    /// One tick of the rules; messages are delivered by deliver().
    void tick(int count = 1) {
        for (int i = 0; i < count; ++i) {
            game.on_tick(*this);
            pass_tick();
        }
    }

    void tick_seconds(float seconds) { tick(static_cast<int>(std::lround(seconds / kDt))); }

    EntityId join(std::uint32_t client,
                  const Vec3& position,
                  const std::string& team = "",
                  const std::string& account = "") {
        return game.on_join(
            *this, {ClientId(client), "name" + std::to_string(client), team, position, account});
    }

    template <class Message>
    void command(std::uint32_t client, EntityId avatar, int kind, const Message& message) {
        const std::string bytes = message.SerializeAsString();
        raw_command(client, avatar, kind, bytes);
    }

    void raw_command(std::uint32_t client, EntityId avatar, int kind, const std::string& bytes) {
        game.on_command(*this,
                        ClientId(client),
                        avatar,
                        static_cast<std::uint16_t>(kind),
                        {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    }

    /// Reason of the newest denial, or nothing.
    [[nodiscard]] std::string denial() const {
        const std::vector<Sent> denials = of_kind(sandbox::EVENT_DENIED);
        return denials.empty() ? "" : parse<sandbox::Denied>(denials.back()).reason();
    }

    [[nodiscard]] std::vector<std::uint32_t> inventory() const {
        const std::vector<Sent> lists = of_kind(sandbox::EVENT_INVENTORY);
        if (lists.empty()) {
            return {};
        }
        const auto message = parse<sandbox::Inventory>(lists.back());
        return {message.items().begin(), message.items().end()};
    }

    [[nodiscard]] std::uint32_t health(EntityId entity) const { return game.find(entity)->health; }

    [[nodiscard]] std::uint64_t hash() const {
        core::StateHash hash;
        game.hash(hash);
        hash_columns(hash);
        return hash.value();
    }

    Sandbox game;
};

/// Carries all messages to the owners of their targets, until none is left.
inline void deliver(FakeZone& a, FakeZone& b) {
    const auto owns = [](const FakeZone& zone, EntityId entity) {
        const world::Row row = zone.entities().find(entity);
        return row != world::kNoRow && !zone.entities().has(row, world::kGhost);
    };
    while (!a.outbox.empty() || !b.outbox.empty()) {
        std::vector<Mail> mail = std::exchange(a.outbox, {});
        mail.insert(mail.end(), b.outbox.begin(), b.outbox.end());
        b.outbox.clear();
        for (const Mail& m : mail) {
            for (FakeZone* zone : {&a, &b}) {
                if (owns(*zone, m.target)) {
                    zone->game.on_message(*zone, m.target, m.payload);
                    break;
                }
            }
        }
    }
}

/// Moves an entity with its state from one zone to the other, as a handoff does.
inline void hand_off(FakeZone& from, FakeZone& to, EntityId entity) {
    const zone::Bytes state = from.game.take_entity(entity);
    const world::Row old = from.entities().find(entity);
    world::Entities& columns = to.columns();
    if (to.exists(entity)) {
        columns.remove(columns.find(entity));  // its ghost
    }
    const world::Row row = columns.add(entity, from.entities().type[old]);
    columns.position[row] =
        from.entities().position[old] + (from.origin() - to.origin()).cast<float>();
    columns.velocity[row] = from.entities().velocity[old];
    columns.appearance[row] = from.entities().appearance[old];
    columns.set_client(row, from.entities().client[old]);
    columns.set_flags(row, from.entities().flags[old]);
    from.columns().remove(old);
    to.game.load_entity(entity, state);
}

inline sandbox::Shoot shot(float dx, float dy, float dz) {
    sandbox::Shoot message;
    message.set_dx(dx);
    message.set_dy(dy);
    message.set_dz(dz);
    return message;
}

}  // namespace zoned::rules::test
