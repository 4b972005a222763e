#include "client-sim/bot/script.h"

#include "client-sim/view/aim.h"
#include "proto/sandbox.pb.h"
#include "shared/core/elementary/elementary.h"
#include "shared/math/heading.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::bot {

namespace {

constexpr double kBorderReachM = 15.0;  // how far behind the border a bot turns round
constexpr double kShootRangeM = 40.0;
constexpr float kFullSpeed = 127.0F;
constexpr std::uint16_t kSprint = motion::kButtonSprint;

template <class Message>
std::string bytes_of(const Message& message) {
    return message.SerializeAsString();
}

std::int64_t units_of(double metres) {
    return std::llround(metres * 4096.0);
}

}  // namespace

EntityId shoot_as_seen(const view::View& view, const Vec3& direction, std::string& payload) {
    constexpr double kAimM = 100.0;
    const Vec3d unit = direction.cast<double>().normalized();
    const view::Aim aim = view::aim(view, view::own_eye(view), unit, kAimM);
    sandbox::Shoot shoot;
    shoot.set_tick(view.own().newest_tick());
    shoot.set_dx(direction.x());
    shoot.set_dy(direction.y());
    shoot.set_dz(direction.z());
    sandbox::Seen& seen = *shoot.mutable_seen();
    seen.set_past(aim.past);
    seen.set_tick(std::max<Tick>(0, aim.tick));
    seen.set_fraction(static_cast<std::uint32_t>(std::min(65535.0, aim.fraction * 65536.0)));
    seen.set_aimed(aim.hit.value);
    for (const view::AimSight& sight : aim.near) {
        sandbox::Sighting& sighting = *seen.add_sighting();
        sighting.set_entity(sight.entity.value);
        sighting.set_x(units_of(sight.position.x()));
        sighting.set_y(units_of(sight.position.y()));
        sighting.set_z(units_of(sight.position.z()));
        sighting.set_publication(sight.publication);
    }
    payload = bytes_of(shoot);
    return aim.hit;
}

bool changes_course(const motion::InputCommand& before, const motion::InputCommand& after) {
    return std::abs(before.move_x - after.move_x) + std::abs(before.move_z - after.move_z) > 64;
}

motion::InputCommand walk_towards(double x, double z) {
    motion::InputCommand command;
    const double length = elementary::hypot(x, z);
    if (length > 0.0) {
        const double scale = static_cast<double>(kFullSpeed) / length;
        command.move_x = static_cast<std::int8_t>(std::lround(x * scale));
        command.move_z = static_cast<std::int8_t>(std::lround(z * scale));
        command.yaw = yaw_of({static_cast<float>(x), static_cast<float>(z)});
    }
    return command;
}

ScriptRunner::ScriptRunner(Script script, std::uint64_t seed, std::uint64_t index, std::string team)
    : script_(script),
      rng_(seed, index),
      seed_(seed),
      team_(std::move(team)) {
    border_side_ = rng_.below(2) == 0 ? 1 : -1;
}

motion::InputCommand ScriptRunner::decide(const view::View& view,
                                          Tick tick,
                                          Voice& voice,
                                          bool& changed) {
    const motion::InputCommand before = wish_;
    wish_.tick = tick;
    wish_.buttons &= static_cast<std::uint16_t>(~motion::kButtonJump);
    switch (script_) {
        case Script::kWander:
            wander(view, tick, voice);
            break;
        case Script::kCrowd:
            crowd(view);
            break;
        case Script::kBorder:
            border(view);
            break;
        case Script::kFight:
            fight(view, Prey::kPlayer, tick, voice);
            break;
        case Script::kHunt:
            fight(view, Prey::kNpc, tick, voice);
            break;
        case Script::kChat:
            chat(view, tick, voice);
            break;
        case Script::kIdle:
            break;
        case Script::kDrive:
            drive(view, tick, voice);
            break;
        case Script::kSneak:
            sneak(view, tick);
            break;
        case Script::kLook:
            look(tick);
            break;
        case Script::kTrade:
            trade(view, tick, voice);
            break;
    }
    changed = changes_course(before, wish_);
    return wish_;
}

void ScriptRunner::pick_direction(Tick tick) {
    const float angle = rng_.range(0.0F, 2.0F * std::numbers::pi_v<float>);
    const bool stand = rng_.below(10) == 0;
    const float x = elementary::sin(angle);
    const float z = elementary::cos(angle);
    wish_.move_x = static_cast<std::int8_t>(stand ? 0.0F : x * kFullSpeed);
    wish_.move_z = static_cast<std::int8_t>(stand ? 0.0F : z * kFullSpeed);
    wish_.yaw = yaw_of({x, z});
    wish_.buttons = rng_.below(5) == 0 ? kSprint : std::uint16_t{0};
    if (rng_.below(12) == 0) {
        wish_.buttons |= motion::kButtonJump;
    }
    // Directions hold for one to three seconds at 30 ticks.
    next_turn_ = tick + 30 + static_cast<Tick>(rng_.below(61));
}

void ScriptRunner::wander(const view::View& view, Tick tick, Voice& voice) {
    if (tick < next_turn_) {
        return;
    }
    pick_direction(tick);
    if (rng_.below(8) == 0) {
        touch_a_prop(view, voice);
    }
}

void ScriptRunner::walk_to(const Vec3d& from, double x, double z, bool sprint) {
    const auto dx = static_cast<float>(x - from.x());
    const auto dz = static_cast<float>(z - from.z());
    const float length = std::sqrt(dx * dx + dz * dz);
    if (length < 0.5F) {
        wish_.move_x = 0;
        wish_.move_z = 0;
        wish_.buttons = 0;
        return;
    }
    // Sixteen directions: a straight walk does not change its command every tick.
    const float step = std::numbers::pi_v<float> / 8.0F;
    const float angle = std::round(elementary::atan2(dx, dz) / step) * step;
    wish_.move_x = static_cast<std::int8_t>(std::lround(elementary::sin(angle) * kFullSpeed));
    wish_.move_z = static_cast<std::int8_t>(std::lround(elementary::cos(angle) * kFullSpeed));
    wish_.yaw = yaw_of({dx, dz});
    wish_.buttons = sprint ? kSprint : std::uint16_t{0};
}

void ScriptRunner::crowd(const view::View& view) {
    // The spot is the same for all bots of one seed: a quarter into the first zone's region.
    const view::ZoneInfo& zone = view.world().zones[seed_ % view.world().zones.size()];
    const double x = zone.lower_x + 0.55 * (zone.upper_x - zone.lower_x);
    const double z = zone.lower_z + 0.55 * (zone.upper_z - zone.lower_z);
    const Vec3d here = view.own().position();
    if (elementary::hypot(x - here.x(), z - here.z()) < 3.0) {
        // There: shuffle on the spot.
        if (view.own().newest_tick() >= next_turn_) {
            pick_direction(view.own().newest_tick());
        }
        return;
    }
    walk_to(here, x, z, true);
}

void ScriptRunner::border(const view::View& view) {
    const Vec3d here = view.own().position();
    const view::ZoneInfo* zone = view.world().zone_at(here.x(), here.z());
    if (!border_found_ && zone != nullptr) {
        // The nearest side of this zone that has another zone behind it.
        double best = 1e300;
        const auto consider = [&](bool along_x, double at, double away) {
            const double px = along_x ? at + away : here.x();
            const double pz = along_x ? here.z() : at + away;
            const double distance = std::abs(at - (along_x ? here.x() : here.z()));
            if (view.world().zone_at(px, pz) != nullptr && distance < best) {
                best = distance;
                border_along_x_ = along_x;
                border_at_ = at;
                border_found_ = true;
                border_side_ = away > 0.0 ? 1 : -1;
            }
        };
        consider(true, zone->lower_x, -1.0);
        consider(true, zone->upper_x, 1.0);
        consider(false, zone->lower_z, -1.0);
        consider(false, zone->upper_z, 1.0);
    }
    if (!border_found_) {
        // A world of one zone: this is a walk like any other.
        if (view.own().newest_tick() >= next_turn_) {
            pick_direction(view.own().newest_tick());
        }
        return;
    }
    const double across = (border_along_x_ ? here.x() : here.z()) - border_at_;
    if (across * border_side_ > kBorderReachM) {
        border_side_ = -border_side_;
    }
    const double target = border_at_ + border_side_ * (kBorderReachM + 2.0);
    walk_to(here, border_along_x_ ? target : here.x(), border_along_x_ ? here.z() : target, true);
}

ScriptRunner::Target ScriptRunner::nearest(const view::View& view, Prey prey) {
    return nearest(view, [prey](EntityId, const view::TypeInfo& type) {
        const Prey thing = type.seats > 0 && prey == Prey::kSeat ? Prey::kSeat : Prey::kProp;
        const Prey person = type.name == "player" ? Prey::kPlayer : Prey::kNpc;
        return prey == (type.character ? person : thing);
    });
}

ScriptRunner::Target ScriptRunner::nearest(const view::View& view, const Wanted& wanted) {
    Target best;
    const Vec3d here = view.own().position();
    for (const auto& [id, entity] : view.store().entities()) {
        if (!entity.present() || !entity.typed || id == view.own().id() ||
            !wanted(id, view.world().types[entity.type])) {
            continue;
        }
        const Vec3d at = view.store().predicted(entity.versions.back(), view.tick()).position;
        const double distance = (at - here).norm();
        // Ascending ids: the first of equally near ones wins.
        if (distance < best.distance) {
            best = {id, at, distance};
        }
    }
    return best;
}

void ScriptRunner::fight(const view::View& view, Prey prey, Tick tick, Voice& voice) {
    if (tick < next_act_) {
        return;
    }
    next_act_ = tick + 12 + static_cast<Tick>(rng_.below(8));
    const Target target = nearest(view, prey);
    if (!target.id) {
        if (tick >= next_turn_) {
            pick_direction(tick);
        }
        return;
    }
    const Vec3d here = view.own().position();
    if (target.distance > 4.0) {
        walk_to(here, target.position.x(), target.position.z(), target.distance > 15.0);
    } else {
        pick_direction(tick);
    }
    if (target.distance < kShootRangeM) {
        const Vec3 aim = (target.position - here).cast<float>();
        std::string shot;
        shoot_as_seen(view, aim, shot);
        voice.command(sandbox::COMMAND_SHOOT, std::move(shot));
    }
}

void ScriptRunner::chat(const view::View& view, Tick tick, Voice& voice) {
    if (tick >= next_turn_) {
        pick_direction(tick);
    }
    if (tick < next_act_) {
        return;
    }
    if (next_act_ != 0) {
        // One line in ten to everybody, the others to the zone or the team.
        sandbox::Chat line;
        const std::uint32_t dice = rng_.below(10);
        if (dice == 0) {
            line.set_topic("world");
        } else if (dice < 6 || team_.empty()) {
            line.set_topic("zone/" + std::to_string(view.zone().value));
        } else {
            line.set_topic("team/" + team_);
        }
        line.set_text("line " + std::to_string(++spoken_));
        voice.command(sandbox::COMMAND_CHAT, bytes_of(line));
    }
    next_act_ = tick + 60 + static_cast<Tick>(rng_.below(90));
}

void ScriptRunner::drive(const view::View& view, Tick tick, Voice& voice) {
    // Directions hold for some seconds: a vehicle takes time to follow.
    constexpr Tick kLegTicks = 60;
    constexpr std::uint32_t kLegs = 12;
    constexpr double kReachM = 2.5;
    if (view.own().carried()) {
        if (tick < next_turn_) {
            return;
        }
        if (next_act_ != 0 && rng_.below(kLegs) == 0) {
            voice.command(sandbox::COMMAND_RIDE, bytes_of(sandbox::Ride()));
            next_act_ = 0;
            next_turn_ = tick + kLegTicks;
            return;
        }
        pick_direction(tick);
        wish_.buttons = 0;
        next_act_ = tick;
        next_turn_ = tick + kLegTicks + static_cast<Tick>(rng_.below(kLegTicks));
        return;
    }
    const Target seat = nearest(view, Prey::kSeat);
    if (!seat.id || tick < next_turn_) {
        wander(view, tick, voice);
        return;
    }
    const Vec3d here = view.own().position();
    if (seat.distance > kReachM) {
        walk_to(here, seat.position.x(), seat.position.z(), true);
        return;
    }
    sandbox::Ride command;
    command.set_entity(seat.id.value);
    voice.command(sandbox::COMMAND_RIDE, bytes_of(command));
    // A second for the answer, then it tries again from elsewhere.
    pick_direction(tick);
}

void ScriptRunner::touch_a_prop(const view::View& view, Voice& voice) {
    const Target prop = nearest(view, Prey::kProp);
    if (!prop.id || prop.distance > kTouchRangeM) {
        return;
    }
    const std::uint32_t dice = rng_.below(3);
    if (dice == 0) {
        sandbox::PickUp pick;
        pick.set_entity(prop.id.value);
        voice.command(sandbox::COMMAND_PICK_UP, bytes_of(pick));
    } else if (dice == 1 && !voice.items().empty()) {
        sandbox::Throw thrown;
        thrown.set_item(voice.items().back());
        thrown.set_dx(rng_.range(-1.0F, 1.0F));
        thrown.set_dy(0.5F);
        thrown.set_dz(rng_.range(-1.0F, 1.0F));
        voice.command(sandbox::COMMAND_THROW, bytes_of(thrown));
    } else {
        sandbox::Push push;
        push.set_entity(prop.id.value);
        voice.command(sandbox::COMMAND_PUSH, bytes_of(push));
    }
}

}  // namespace zoned::bot
