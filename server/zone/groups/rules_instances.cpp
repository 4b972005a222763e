#include "server/zone/groups/rules_instances.h"

#include "server/zone/groups/instance_book.h"
#include "server/zone/rules_context.h"

namespace zoned::zone {

namespace {

/// Whether the avatar of a player is here and can go; hidden ones stay where they are.
bool can_go(const RulesContext& context, EntityId player) {
    const world::Entities& e = context.entities();
    const world::Row row = e.find(player);
    return row != world::kNoRow && !e.has(row, world::kGhost) && !e.has(row, world::kHidden) &&
           e.client[row];
}

}  // namespace

InstanceId RulesInstances::here() const {
    const Instance* const instance = book_->in(zone_);
    return instance != nullptr && !instance->ends ? instance->id : InstanceId();
}

const Instance* RulesInstances::find(InstanceId instance) const {
    return book_->find(instance);
}

std::optional<Vec3d> RulesInstances::return_place(ClientId client) const {
    if (book_ == nullptr || !book_->is_copy(zone_)) {
        return std::nullopt;
    }
    return book_->return_of(client);
}

InstanceOrder* RulesInstances::give(InstanceAct act, EntityId player, InstanceId instance) {
    if (orders_->size() >= kMostInstanceOrders) {
        return nullptr;
    }
    InstanceOrder& order = orders_->emplace_back();
    order.act = act;
    order.zone = zone_;
    order.player = player;
    order.instance = instance;
    return &order;
}

bool RulesInstances::open(std::string_view kind, EntityId asker) {
    if (!book_->has_kind(kind)) {
        return false;
    }
    InstanceOrder* const order = give(InstanceAct::kOpen, asker, InstanceId());
    if (order != nullptr) {
        order->kind = kind;
    }
    return order != nullptr;
}

bool RulesInstances::close(InstanceId instance) {
    return give(InstanceAct::kClose, EntityId(), instance) != nullptr;
}

bool RulesInstances::enter(RulesContext& context,
                           EntityId player,
                           InstanceId instance,
                           std::size_t entrance) {
    const Instance* const open = find(instance);
    if (open == nullptr || open->ends || open->zone == zone_ || !can_go(context, player)) {
        return false;
    }
    InstanceOrder* const order = give(InstanceAct::kEnter, player, instance);
    if (order == nullptr) {
        return false;
    }
    const world::Entities& e = context.entities();
    // From one instance to another: back to where the first was entered.
    const world::Row row = e.find(player);
    order->from =
        return_place(e.client[row]).value_or(context.origin() + e.position[row].cast<double>());
    const InstanceKind& kind = book_->kind_of(*open);
    const Vec3d to =
        kind.copy_in(open->zone)->origin + kind.entrances[entrance % kind.entrances.size()];
    context.teleport(player, (to - context.origin()).cast<float>());
    return true;
}

bool RulesInstances::leave(RulesContext& context, EntityId player) {
    const world::Entities& e = context.entities();
    const auto to = can_go(context, player) ? return_place(e.client[e.find(player)]) : std::nullopt;
    if (to) {
        context.teleport(player, (*to - context.origin()).cast<float>());
    }
    return to.has_value();
}

}  // namespace zoned::zone
