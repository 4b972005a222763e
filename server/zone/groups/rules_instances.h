// RulesInstances: the instances of the world as rules see them, and what rules ask of them.
#pragma once

#include "server/zone/groups/instance.h"

#include <optional>
#include <string_view>
#include <vector>

namespace zoned::zone {

class InstanceBook;
class RulesContext;

/// Orders take effect behind this tick; Rules::on_instance tells what has become of them. False:
/// refused at once.
class RulesInstances {
  public:
    RulesInstances(ZoneId zone, std::vector<InstanceOrder>& orders)
        : zone_(zone),
          orders_(&orders) {}

    /// From now on rules see this book, which must outlive them.
    void use(const InstanceBook& book) { book_ = &book; }

    [[nodiscard]] const InstanceBook* book() const { return book_; }

    /// The instance that this zone is now; none: it is none, or not open.
    [[nodiscard]] InstanceId here() const;
    /// Null: it is not open. Good during the call.
    [[nodiscard]] const Instance* find(InstanceId instance) const;

    /// Where a player of this zone was before it entered, world coordinates, m; none: this zone is
    /// no copy.
    [[nodiscard]] std::optional<Vec3d> return_place(ClientId client) const;

    /// Asks for a free copy. `asker` comes back with kReady or kRefused; it may be none.
    bool open(std::string_view kind, EntityId asker);
    /// Ends it: its players go back to where they were.
    bool close(InstanceId instance);
    /// An avatar of this zone goes to an instance that is open, to one of its entrances: that of
    /// this number, modulo how many there are.
    bool enter(RulesContext& context, EntityId player, InstanceId instance, std::size_t entrance);
    /// An avatar of this zone, which is a copy, goes back to where it came from.
    bool leave(RulesContext& context, EntityId player);

  private:
    InstanceOrder* give(InstanceAct act, EntityId player, InstanceId instance);

    ZoneId zone_;
    std::vector<InstanceOrder>* orders_;
    const InstanceBook* book_ = nullptr;
};

}  // namespace zoned::zone
