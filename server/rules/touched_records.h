// TouchedRecords: records by entity, with a list of those that may have changed since the last
// hash.
#pragma once

#include "shared/core/ids.h"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

namespace zoned::rules {

/// A map whose records count as touched when they are found for writing, come or go. Ascending by
/// entity.
template <class Record>
class TouchedRecords {
  public:
    using Map = std::map<EntityId, Record>;

    [[nodiscard]] auto find(EntityId entity) const { return map_.find(entity); }

    [[nodiscard]] auto find(EntityId entity) {
        const auto it = map_.find(entity);
        if (it != map_.end()) {
            touched_.push_back(entity);
        }
        return it;
    }

    [[nodiscard]] const Record& at(EntityId entity) const { return map_.at(entity); }

    [[nodiscard]] Record& at(EntityId entity) {
        touched_.push_back(entity);
        return map_.at(entity);
    }

    Record& operator[](EntityId entity) {
        touched_.push_back(entity);
        return map_[entity];
    }

    auto try_emplace(EntityId entity) {
        touched_.push_back(entity);
        return map_.try_emplace(entity);
    }

    void erase(typename Map::iterator record) {
        touched_.push_back(record->first);
        map_.erase(record);
    }

    [[nodiscard]] auto end() { return map_.end(); }

    [[nodiscard]] auto end() const { return map_.end(); }

    [[nodiscard]] std::size_t size() const { return map_.size(); }

    /// Calls visit(entity, record), ascending, for those that were touched since the last call;
    /// the record is null where it is gone.
    template <class Visit>
    void take_touched(Visit&& visit) const {
        std::sort(touched_.begin(), touched_.end());
        touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
        for (const EntityId entity : touched_) {
            const auto it = map_.find(entity);
            visit(entity, it != map_.end() ? &it->second : nullptr);
        }
        touched_.clear();
    }

    /// All records, and those touched since the last hash.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(map_, touched_);
    }

  private:
    Map map_;
    mutable std::vector<EntityId>
        touched_;  // bookkeeping for the hash; no part of the records' value
};

}  // namespace zoned::rules
