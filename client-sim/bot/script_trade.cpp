#include "client-sim/bot/script.h"
#include "proto/sandbox.pb.h"

namespace zoned::bot {

namespace {

constexpr double kOfferReachM = 3.5;    // the rules let players trade within 4 m
constexpr std::size_t kMostNoted = 64;  // players, and props

}  // namespace

void ScriptRunner::note_pick_up(EntityId player, std::uint32_t item) {
    if (holders_.size() < kMostNoted || holders_.contains(player)) {
        holders_[player] = item;
    }
}

void ScriptRunner::trade(const view::View& view, Tick tick, Voice& voice) {
    if (tick < next_turn_) {
        return;
    }
    next_turn_ = tick + kDecideTicks;
    if (voice.items().empty()) {
        collect(view, tick, voice);
        return;
    }
    const Target other = nearest(view, [this](EntityId id, const view::TypeInfo& type) {
        return type.name == "player" && holders_.contains(id);
    });
    if (!other.id) {
        holders_.clear();  // they are gone
        pick_direction(tick);
        return;
    }
    if (other.distance > kOfferReachM) {
        walk_to(view.own().position(), other.position.x(), other.position.z(), false);
        return;
    }
    sandbox::Offer offer;
    offer.set_with(other.id.value);
    offer.set_give(voice.items().back());
    offer.set_want(holders_[other.id]);
    voice.command(sandbox::COMMAND_OFFER, offer.SerializeAsString());
    holders_.erase(other.id);  // whatever the answer is, the next offer goes to another player
    pick_direction(tick);
}

/// Goes to the nearest prop that it has not tried yet, and picks it up.
void ScriptRunner::collect(const view::View& view, Tick tick, Voice& voice) {
    if (tried_.size() >= kMostNoted) {
        tried_.clear();
    }
    const Target prop = nearest(view, [this](EntityId id, const view::TypeInfo& type) {
        return !type.character && type.seats == 0 && !tried_.contains(id);
    });
    if (!prop.id) {
        pick_direction(tick);
        return;
    }
    if (prop.distance > kTouchRangeM) {
        walk_to(view.own().position(), prop.position.x(), prop.position.z(), false);
        return;
    }
    tried_.insert(prop.id);
    sandbox::PickUp pick;
    pick.set_entity(prop.id.value);
    voice.command(sandbox::COMMAND_PICK_UP, pick.SerializeAsString());
}

}  // namespace zoned::bot
