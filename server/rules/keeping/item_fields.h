// ItemFields: what the declared fields of a prop hold while somebody carries it, by name and in
// text, as worlds with other fields must be able to read it.
#pragma once

#include "server/zone/rules_context.h"

#include <string>
#include <vector>

namespace zoned::rules {

struct ItemField {
    std::string name;
    std::string value;  ///< a number to its last bit, "true" or "false", a choice, a text

    template <class Archive, class Self>
    static void fields(Archive& archive, Self& self) {
        archive(self.name);
        archive(self.value);
    }

    friend bool operator==(const ItemField&, const ItemField&) = default;
};

using ItemFields = std::vector<ItemField>;

/// Of an entity that the zone knows; those that hold what they begin with are left out.
ItemFields item_fields(const zone::RulesContext& context, EntityId entity);

/// Gives a prop that was just spawned what it held. A field that its type has no longer, or that
/// cannot hold the value, stays as it begins.
void give_fields(zone::RulesContext& context, EntityId entity, const ItemFields& fields);

}  // namespace zoned::rules
