#include "server/rules/shooting.h"

#include "server/rules/combat.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace zoned::rules {

namespace {

constexpr int kMostSightings = 8;
constexpr std::size_t kMostWaiting = 8;
constexpr Tick kMostAheadTicks = 30;  ///< a client's commands are not farther off than this
constexpr std::int64_t kMostUnits = std::int64_t{1} << 32;  ///< 1000 km
constexpr double kUnitM = 1.0 / 4096.0;
constexpr float kFractions = 65536.0F;

/// False when the numbers are none that a view displays.
bool read_sightings(const sandbox::Seen& seen, FiredShot& shot) {
    if (seen.sighting_size() > kMostSightings || seen.fraction() > 0xFFFFU || seen.tick() < 0) {
        return false;
    }
    shot.seen_tick = seen.tick();
    shot.fraction = seen.fraction();
    shot.past = seen.past() ? 1 : 0;
    shot.aimed = EntityId(seen.aimed());
    for (const sandbox::Sighting& s : seen.sighting()) {
        const std::array<std::int64_t, 3> units = {s.x(), s.y(), s.z()};
        if (std::any_of(units.begin(), units.end(), [](std::int64_t u) {
                return u < -kMostUnits || u > kMostUnits;
            })) {
            return false;
        }
        shot.sightings.push_back({EntityId(s.entity()),
                                  Vec3d(static_cast<double>(s.x()),
                                        static_cast<double>(s.y()),
                                        static_cast<double>(s.z())) *
                                      kUnitM,
                                  s.publication()});
    }
    return true;
}

/// The effect of a hit on its target.
void land(Game& game,
          RulesContext& context,
          EntityId shooter,
          const zone::RayResult& hit,
          const Vec3& along) {
    const world::Row target =
        hit.hit && hit.entity ? context.entities().find(hit.entity) : world::kNoRow;
    if (hit.hit && (target == world::kNoRow || !is_character(context, target))) {
        throw_debris(game, context, hit.point, hit.normal);
    }
    if (target == world::kNoRow) {
        return;
    }
    if (is_character(context, target)) {
        hurt(game, context, hit.entity, shooter, static_cast<std::uint32_t>(game.settings.damage));
    } else {
        const float mass = context.types()[context.entities().type[target]].mass;
        knock(context, hit.entity, along * (game.settings.shot_impulse_ns / mass));
    }
}

void tell(RulesContext& context,
          const Actor& actor,
          const FiredShot& shot,
          const zone::SeenHit& hit) {
    sandbox::Shot decision;
    decision.set_shooter(actor.avatar.value);
    decision.set_tick(shot.tick);
    decision.set_hit(hit.hit ? hit.entity.value : 0);
    decision.set_aimed(shot.aimed.value);
    decision.set_rewound_ms(static_cast<std::uint32_t>(std::lround(1e3F * hit.rewound_s)));
    decision.set_cut(hit.cut);
    decision.set_doubted(hit.doubted);
    const zone::RulesEvent notice = event(sandbox::EVENT_SHOT, decision);
    context.send(actor.client, notice);
    // A client that was merely named is not notified: a client could name anybody.
    const EntityId other = hit.hit && hit.entity ? hit.entity
                           : hit.aimed_near      ? shot.aimed
                                                 : EntityId();
    const world::Row row = other ? context.entities().find(other) : world::kNoRow;
    if (row != world::kNoRow && context.entities().client[row] &&
        context.entities().client[row] != actor.client) {
        context.send(context.entities().client[row], notice);
    }
}

void fire(Game& game, RulesContext& context, const Actor& actor, const FiredShot& shot) {
    std::vector<zone::SeenEntity> claims;
    for (const SeenRecord& s : shot.sightings) {
        claims.push_back({s.entity, to_local(context, s.position), s.publication});
    }
    zone::Seen seen;
    seen.view =
        shot.past != 0 ? zone::Seen::DisplayedTime::kPast : zone::Seen::DisplayedTime::kPresent;
    seen.tick = shot.seen_tick;
    seen.fraction = static_cast<float>(shot.fraction) / kFractions;
    seen.aimed = shot.aimed;
    seen.entities = claims;
    const Vec3 here = context.entities().position[actor.row];
    const std::optional<Vec3> then = context.position_after(actor.avatar, shot.tick);
    const Vec3 from = eye(context, actor.row) + (then.value_or(here) - here);
    zone::SeenHit hit = context.ray_cast_as_seen(
        actor.client, seen, from, shot.along, game.settings.shot_range_m, actor.avatar);
    hit.cut = hit.cut || !then;
    ++game.stats.shots;
    ++game.stats.shots_as_seen;
    game.stats.shots_cut += hit.cut ? 1 : 0;
    game.stats.shots_doubted += hit.doubted ? 1 : 0;
    tell(context, actor, shot, hit);
    land(game, context, actor.avatar, hit, shot.along);
}

}  // namespace

void shoot(Game& game, RulesContext& context, const Actor& actor, Payload payload) {
    sandbox::Shoot command;
    if (!command.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
        deny_malformed(game, context, actor);
        return;
    }
    const std::optional<Vec3> along = direction(command.dx(), command.dy(), command.dz());
    FiredShot shot;
    if (!along || (command.has_seen() && !read_sightings(command.seen(), shot))) {
        deny_malformed(game, context, actor);
        return;
    }
    // The cooldown is of the time in which it was fired, not in which it came.
    const Tick now = context.now();
    const Tick fired = std::clamp(command.tick(), now - kMostAheadTicks, now + kMostAheadTicks);
    const Tick at = command.has_seen() ? fired + 1 : now;
    if (at < actor.record->next_shot || actor.record->shots.size() >= kMostWaiting) {
        deny(game, context, actor, "too fast");
        return;
    }
    actor.record->next_shot = at + ticks(context, game.settings.shot_cooldown_s);
    if (!command.has_seen()) {
        ++game.stats.shots;
        const zone::RayResult hit = context.ray_cast(
            eye(context, actor.row), *along, game.settings.shot_range_m, actor.avatar);
        land(game, context, actor.avatar, hit, *along);
        return;
    }
    shot.tick = at - 1;
    shot.along = *along;
    if (at <= now) {
        fire(game, context, actor, shot);
        return;
    }
    actor.record->shots.push_back(std::move(shot));
    update_pending(game, actor.avatar);
}

void run_shots(Game& game, RulesContext& context, EntityId avatar, CharacterRecord& record) {
    if (record.shots.empty()) {
        return;
    }
    const world::Row row = owned_row(context, avatar);
    Actor actor{record.client, avatar, row, &record, sandbox::COMMAND_SHOOT};
    std::vector<FiredShot> waiting = std::exchange(record.shots, {});
    for (FiredShot& shot : waiting) {
        if (row == world::kNoRow || !record.can_act()) {
            deny(game, context, actor, "dead");
        } else if (shot.tick < context.now()) {
            fire(game, context, actor, shot);
        } else {
            record.shots.push_back(std::move(shot));
        }
    }
}

}  // namespace zoned::rules
