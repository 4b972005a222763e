// The rules of @GAME@: tag. One player is "it"; coming near another passes it on.
#include "server/zone/rules.h"
#include "shared/core/archive/field_archive.h"

#include <stdexcept>

using namespace zoned;

namespace {

constexpr std::uint16_t kTagged = 100;  // our kind of event; kinds below 16 are the server's
constexpr std::uint16_t kPlain = 0;     // appearances, which clients draw
constexpr std::uint16_t kIt = 1;
constexpr float kReachM = 1.5F;
constexpr float kPauseS = 1.0F;

class Tag final : public zone::Rules {
  public:
    EntityId on_join(zone::RulesContext& context, const zone::JoinRequest& request) override {
        zone::SpawnDef def;
        def.type = context.type_named("player");
        def.position = request.spawn_position;
        def.client = request.client;
        return context.spawn(def);
    }

    void on_leave(zone::RulesContext& context, ClientId, EntityId avatar) override {
        context.despawn(avatar);
    }

    void on_tick(zone::RulesContext& context) override {
        const world::Entities& entities = context.entities();
        if (!it_ || entities.find(it_) == world::kNoRow) {
            choose_first(context);
            return;
        }
        if (context.now() < safe_until_) {
            return;
        }
        context.near(entities.position[entities.find(it_)], kReachM, near_);
        for (const EntityId other : near_) {
            if (other != it_ && entities.client[entities.find(other)]) {
                tag(context, other);
                return;
            }
        }
    }

    // Clients send these. Payloads of commands are written by strangers.
    void on_command(zone::RulesContext&,
                    ClientId,
                    EntityId,
                    std::uint16_t,
                    std::span<const std::uint8_t>) override {}

    void on_input(zone::RulesContext&,
                  EntityId,
                  const motion::InputCommand&,
                  std::uint16_t) override {}

    // The world reports these.
    void on_contact(zone::RulesContext&, const zone::EntityContact&) override {}

    void on_confirm(zone::RulesContext&, ClientId, EventId) override {}

    void on_message(zone::RulesContext&, EntityId, std::span<const std::uint8_t>) override {}

    bool busy() const override { return false; }  // nothing happens where nobody is

    // All that these rules remember: hashed each tick, saved in snapshots, and taken along by an
    // entity that goes to another zone.
    void hash(core::StateHash& hash) const override {
        hash.add(it_.value);
        hash.add(safe_until_);
    }

    bool save(zone::Bytes& out) const override {
        core::FieldWriter write(out);
        write(it_, safe_until_);
        return true;
    }

    std::string load(std::span<const std::uint8_t> bytes) override {
        core::FieldReader read(bytes);
        read(it_, safe_until_);
        return read.left() == 0 ? read.wrong() : "bytes are left over";
    }

    zone::Bytes take_entity(EntityId entity) override {
        const bool is_it = entity == it_;
        it_ = is_it ? EntityId{} : it_;
        return {static_cast<std::uint8_t>(is_it ? 1 : 0)};
    }

    void load_entity(EntityId entity, std::span<const std::uint8_t> state) override {
        it_ = !state.empty() && state[0] == 1 ? entity : it_;
    }

  private:
    void choose_first(zone::RulesContext& context) {
        const world::Entities& entities = context.entities();
        for (world::Row row = 0; row < entities.size(); ++row) {
            if (entities.client[row] && !entities.has(row, world::kGhost)) {
                tag(context, entities.id[row]);
                return;
            }
        }
    }

    void tag(zone::RulesContext& context, EntityId next) {
        if (it_ && context.entities().find(it_) != world::kNoRow) {
            context.set_appearance(it_, kPlain);
        }
        it_ = next;
        safe_until_ = context.now() + static_cast<Tick>(kPauseS / context.dt());
        context.set_appearance(it_, kIt);
        count_tag(context);
        zone::RulesEvent event;
        event.kind = kTagged;
        context.announce(it_, event);  // to all who hear of that player, exactly once
    }

    // A field that world.txtpb declares: clients that hear of the player know its value.
    void count_tag(zone::RulesContext& context) const {
        const auto tags = context.field_named("tags");
        if (const auto count = tags ? context.field(it_, *tags) : std::nullopt) {
            context.set_field(it_, *tags, std::get<double>(*count) + 1.0);
        }
    }

    EntityId it_;
    Tick safe_until_ = 0;
    std::vector<EntityId> near_;  // of on_tick alone
};

}  // namespace

std::unique_ptr<zone::Rules> zone::make_rules(const RulesSettings& settings,
                                              const world::TypeTable&) {
    if (!settings.empty()) {
        throw std::runtime_error("@GAME@ has no settings");
    }
    return std::make_unique<Tag>();
}
