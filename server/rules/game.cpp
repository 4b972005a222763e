#include "server/rules/game.h"

#include <algorithm>
#include <cmath>

namespace zoned::rules {

namespace {

constexpr float kDenialsPerSecond = 10.0F;
constexpr Tick kDenialBurst = 20;

}  // namespace

world::Row owned_row(const RulesContext& context, EntityId entity) {
    const world::Row row = context.entities().find(entity);
    return row != world::kNoRow && context.entities().has(row, world::kGhost) ? world::kNoRow : row;
}

bool is_character(const RulesContext& context, world::Row row) {
    return context.types()[context.entities().type[row]].kind == world::EntityKind::kCharacter;
}

Tick ticks(const RulesContext& context, float seconds) {
    // Rounded up: nothing is sooner than promised. A thousandth absorbs the rounding of whole
    // numbers of ticks.
    return std::max<Tick>(1, static_cast<Tick>(std::ceil(seconds / context.dt() - 1e-3F)));
}

Vec3d to_world(const RulesContext& context, const Vec3& local) {
    return context.origin() + local.cast<double>();
}

Vec3 to_local(const RulesContext& context, const Vec3d& world) {
    return (world - context.origin()).cast<float>();
}

Vec3 eye(const RulesContext& context, world::Row row) {
    const motion::CharacterLimits& limits = context.types()[context.entities().type[row]].character;
    return context.entities().position[row] +
           Vec3(0.0F, limits.half_segment + 0.5F * limits.radius, 0.0F);
}

std::optional<Vec3> direction(float x, float y, float z) {
    // In double the square of the largest float is still finite.
    const Vec3d wide(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
    const double length = wide.norm();
    if (!std::isfinite(length) || length < 1e-6) {
        return std::nullopt;
    }
    return Vec3((wide / length).cast<float>());
}

CharacterRecord& record_of(Game& game, const RulesContext& context, world::Row row) {
    const auto [it, is_new] = game.characters.try_emplace(context.entities().id[row]);
    if (is_new) {
        it->second.health = static_cast<std::uint32_t>(game.settings.health);
        it->second.spawn = to_world(context, context.entities().position[row]);
    }
    return it->second;
}

void update_pending(Game& game, EntityId entity) {
    const auto character = game.characters.find(entity);
    const bool pending = (character != game.characters.end() && character->second.pending()) ||
                         game.props.contains(entity) || game.ragdolls.contains(entity);
    if (pending) {
        game.pending.insert(entity);
    } else {
        game.pending.erase(entity);
    }
}

void forget(Game& game, EntityId entity) {
    const auto character = game.characters.find(entity);
    if (character != game.characters.end()) {
        game.avatars.erase(character->second.client);
        game.characters.erase(character);
    }
    game.props.erase(entity);
    game.ragdolls.erase(entity);
    game.pending.erase(entity);
}

zone::RulesEvent event(sandbox::EventKind kind,
                       const google::protobuf::MessageLite& message,
                       bool confirm) {
    zone::RulesEvent result;
    result.kind = static_cast<std::uint16_t>(kind);
    result.payload.resize(message.ByteSizeLong());
    message.SerializeToArray(result.payload.data(), static_cast<int>(result.payload.size()));
    result.confirm = confirm;
    return result;
}

void deny(Game& game, RulesContext& context, const Actor& actor, const std::string& reason) {
    ++game.stats.denied;
    if (actor.record != nullptr && !within_rate(actor.record->denial_due,
                                                context.now(),
                                                ticks(context, 1.0F / kDenialsPerSecond),
                                                kDenialBurst)) {
        ++game.stats.denials_muted;
        return;
    }
    sandbox::Denied denied;
    denied.set_command_kind(actor.kind);
    denied.set_reason(reason);
    context.send(actor.client, event(sandbox::EVENT_DENIED, denied));
}

void deny_malformed(Game& game, RulesContext& context, const Actor& actor) {
    ++game.stats.malformed;
    deny(game, context, actor, "malformed");
}

bool within_rate(Tick& due, Tick now, Tick interval, Tick burst) {
    const Tick arrival = std::max(due, now);
    if (arrival - now > (burst - 1) * interval) {
        return false;
    }
    due = arrival + interval;
    return true;
}

void throw_debris(const Game& game, RulesContext& context, const Vec3& point, const Vec3& normal) {
    constexpr float kDebrisSpeed_mps = 4.0F;
    const auto count = static_cast<std::uint32_t>(game.settings.debris_count);
    if (count > 0 && !game.settings.debris_system.empty()) {
        context.emit(game.settings.debris_system, point, normal * kDebrisSpeed_mps, count);
    }
}

}  // namespace zoned::rules
