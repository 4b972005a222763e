// MovedSet: the entity columns that matching reads, and their changes since the last tick.
#pragma once

#include "server/interest/incremental_grid.h"
#include "server/world/entities.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::interest {

/// One entity that is not as it was a tick ago, and did more than step.
struct EntityChange {
    EntityId entity;
    world::Row row = world::kNoRow;  ///< none: it is gone
    float old_x = 0.0F;              ///< m; only where it had an aura
    float old_z = 0.0F;
    float old_aura_m = 0.0F;  ///< 0: it was not here, was hidden or nowhere
};

class MovedSet {
  public:
    /// An entity that moves no farther than this within a tick steps. An entity that jumps is
    /// looked at both in the place that it left and in its new place, m.
    static constexpr float kStep_m = 8.0F;

    /// Compares rows with those of the last call and lists the changes. It looks at rows that move
    /// or were touched for Reader::kInterest, which the caller forgets afterwards. The type table
    /// has to be the same in each call.
    void follow(const world::Entities& entities, const world::TypeTable& types);
    /// Forgets where things were.
    void settle();

    [[nodiscard]] std::size_t size() const { return ids_.size(); }

    [[nodiscard]] const std::vector<EntityChange>& changes() const { return changes_; }

    /// Rows of entities that only stepped, ascending.
    [[nodiscard]] const std::vector<world::Row>& steps() const { return steps_; }

    [[nodiscard]] std::size_t changed() const { return changes_.size() + steps_.size(); }

    /// The longest of all steps, m; a rounding more.
    [[nodiscard]] float longest_step_m() const { return longest_step_m_; }

    /// Rows hold other entities than a tick ago, or there are more or fewer of them.
    [[nodiscard]] bool rows_changed() const { return !lost_.empty() || !found_.empty(); }

    /// Rows that were taken from an entity, before their present one took them.
    [[nodiscard]] const std::vector<world::Row>& rows_left() const { return rows_left_; }

    [[nodiscard]] EntityId id(world::Row row) const { return ids_[row]; }

    [[nodiscard]] float x(world::Row row) const { return x_[row]; }

    [[nodiscard]] float z(world::Row row) const { return z_[row]; }

    /// Where one was before it stepped; of all others, where it is.
    [[nodiscard]] float old_x(world::Row row) const { return old_x_[row]; }

    [[nodiscard]] float old_z(world::Row row) const { return old_z_[row]; }

    /// 0 where it is hidden or nowhere: no viewer hears of it.
    [[nodiscard]] float aura_m(world::Row row) const { return aura_[row]; }

    [[nodiscard]] float nimbus_m(world::Row row) const { return nimbus_of_[kind_of(row)]; }

    /// Some type has a cone, in some stance; else nobody needs to ask.
    [[nodiscard]] bool has_cones() const { return !cone_of_.empty(); }

    [[nodiscard]] const world::Cone& cone(world::Row row) const { return cone_of_[kind_of(row)]; }

    /// Asks for the columns of a row that will be read soon; it need not be there.
    void prefetch(world::Row row) const {
        if (row < ids_.size()) {
            __builtin_prefetch(&x_[row]);
            __builtin_prefetch(&z_[row]);
            __builtin_prefetch(&aura_[row]);
            __builtin_prefetch(&ids_[row]);
        }
    }

    /// Likewise for where it is and was; it has to be there.
    void prefetch_step(world::Row row) const {
        __builtin_prefetch(&x_[row]);
        __builtin_prefetch(&z_[row]);
        __builtin_prefetch(&aura_[row]);
        __builtin_prefetch(&old_x_[row]);
        __builtin_prefetch(&old_z_[row]);
    }

    [[nodiscard]] const std::vector<float>& xs() const { return x_; }

    [[nodiscard]] const std::vector<float>& zs() const { return z_; }

    [[nodiscard]] const std::vector<float>& old_xs() const { return old_x_; }

    [[nodiscard]] const std::vector<float>& old_zs() const { return old_z_; }

    [[nodiscard]] GridPoints points() const { return {x_, z_, aura_}; }

    [[nodiscard]] float largest_aura_m() const { return largest_aura_m_; }

    /// Over all that are not hidden; 0 where one reaches nobody or is nowhere.
    [[nodiscard]] float smallest_aura_m() const { return smallest_aura_m_; }

  private:
    struct LostEntity {
        EntityId entity;
        world::Row row = world::kNoRow;
        float x = 0.0F;
        float z = 0.0F;
        float aura_m = 0.0F;
    };

    struct FoundEntity {
        EntityId entity;
        world::Row row = world::kNoRow;
    };

    [[nodiscard]] std::size_t kind_of(world::Row row) const { return kinds_[row] & 0x7FFFFFFFU; }

    void read_types(const world::TypeTable& types);
    void list_touched(const world::Entities& entities);
    void prefetch_all(world::Row row) const;
    void compare_all(const world::Entities& entities, std::size_t common);
    std::uint32_t compare_kinds(const world::Entities& entities,
                                std::size_t first,
                                std::size_t size,
                                std::uint32_t* other) const;
    void follow_steps(const world::Entities& entities);
    void take(const world::Entities& entities, world::Row row);
    void enter(const world::Entities& entities, world::Row row);
    void leave(world::Row row);
    void pair_up();
    void survey();

    std::vector<EntityId> ids_;
    std::vector<std::uint32_t> kinds_;  // type x stances + stance; the top bit: hidden
    std::vector<float> x_;
    std::vector<float> z_;
    std::vector<float> old_x_;
    std::vector<float> old_z_;
    std::vector<float> aura_;
    std::vector<float> aura_of_;                // by kind
    std::vector<float> nimbus_of_;              // by kind
    std::vector<world::Cone> cone_of_;          // by kind; empty where nobody has one
    std::vector<std::uint32_t> heard_of_kind_;  // entities of each kind that are not hidden
    std::uint32_t nowhere_ = 0;                 // not hidden, but at no place
    std::vector<world::Row> touched_;
    std::vector<LostEntity> lost_;
    std::vector<FoundEntity> found_;
    std::vector<world::Row> rows_left_;
    std::vector<EntityChange> changes_;
    std::vector<world::Row> steps_;
    float longest_step_m_ = 0.0F;
    float largest_aura_m_ = 0.0F;
    float smallest_aura_m_ = 0.0F;
};

}  // namespace zoned::interest
