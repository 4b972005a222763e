// build: hot loops
#include "server/interest/moved_set.h"

#include "server/interest/compress_lanes.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace zoned::interest {

namespace {

constexpr std::size_t kStances = world::kStances;
constexpr std::uint32_t kHiddenBit = 0x80000000U;

std::uint32_t kind_of_parts(TypeIndex type, std::uint8_t stance, std::uint8_t flags) {
    return type * static_cast<std::uint32_t>(kStances) + stance +
           ((flags & world::kUnheard) != 0 ? kHiddenBit : 0U);
}

std::uint32_t kind_in(const world::Entities& e, world::Row row) {
    return kind_of_parts(e.type[row], e.stance[row], e.flags[row]);
}

std::uint32_t bits(float value) {
    return std::bit_cast<std::uint32_t>(value);
}

}  // namespace

void MovedSet::follow(const world::Entities& entities, const world::TypeTable& types) {
    read_types(types);
    changes_.clear();
    lost_.clear();
    found_.clear();
    rows_left_.clear();
    const std::size_t before = ids_.size();
    const std::size_t now = entities.size();
    list_touched(entities);
    follow_steps(entities);
    for (const world::Row row : touched_) {
        take(entities, row);
    }
    for (std::size_t row = now; row < before; ++row) {
        lost_.push_back({ids_[row], static_cast<world::Row>(row), x_[row], z_[row], aura_[row]});
        leave(static_cast<world::Row>(row));
    }
    ids_.resize(now);
    kinds_.resize(now, kHiddenBit);
    for (auto* column : {&x_, &z_, &old_x_, &old_z_, &aura_}) {
        column->resize(now, 0.0F);
    }
    for (std::size_t row = before; row < now; ++row) {
        const auto fresh = static_cast<world::Row>(row);
        enter(entities, fresh);
        found_.push_back({entities.id[row], fresh});
    }
    if (rows_changed()) {
        pair_up();
    }
    for (const EntityChange& change : changes_) {
        if (change.row != world::kNoRow) {
            old_x_[change.row] = x_[change.row];
            old_z_[change.row] = z_[change.row];
        }
    }
    survey();
}

/// Radii by kind in one flat table: a look at the types themselves costs a line of cache each.
void MovedSet::read_types(const world::TypeTable& types) {
    const std::size_t kinds = types.size() * kStances;
    if (aura_of_.size() == kinds) {
        return;
    }
    ZONED_ASSERT(aura_of_.empty(), "the type table is fixed while a world lives");
    aura_of_.resize(kinds);
    nimbus_of_.resize(kinds);
    heard_of_kind_.assign(kinds, 0);
    for (std::size_t type = 0; type < types.size(); ++type) {
        for (std::size_t stance = 0; stance < kStances; ++stance) {
            const std::size_t kind = type * kStances + stance;
            aura_of_[kind] = std::max(0.0F, types[type].aura_m[stance]);
            nimbus_of_[kind] = std::max(0.0F, types[type].nimbus_m[stance]);
            const world::Cone& cone = types[type].nimbus_cone[stance];
            if (cone.length_m > 0.0F) {
                cone_of_.resize(kinds);
                cone_of_[kind] = cone;
            }
        }
    }
}

/// Rows whose entity is another one or of another kind, and rows that moved. Where few may have
/// changed, those alone are compared.
void MovedSet::list_touched(const world::Entities& e) {
    constexpr std::size_t kFew = 8;
    const std::size_t common = std::min(ids_.size(), e.size());
    const world::RowSet& stirring = e.stirring();
    const world::RowSet& said = e.touched(world::Reader::kInterest);
    touched_.clear();
    if (stirring.count() + said.count() > e.size() / kFew) {
        compare_all(e, common);
        return;
    }
    steps_.clear();
    world::for_each_row(stirring, said, [&](world::Row row) {
        if (row < common) {
            prefetch_all(row);
            steps_.push_back(row);
        }
    });
    // Their former rows are anywhere in memory; the prefetch has asked for them.
    std::size_t kept = 0;
    for (const world::Row row : steps_) {
        if (e.id[row] != ids_[row] || kind_in(e, row) != kinds_[row]) {
            touched_.push_back(row);
        } else if (bits(e.position[row].x()) != bits(x_[row]) ||
                   bits(e.position[row].z()) != bits(z_[row])) {
            steps_[kept++] = row;
        }
    }
    steps_.resize(kept);
}

void MovedSet::prefetch_all(world::Row row) const {
    __builtin_prefetch(&ids_[row]);
    __builtin_prefetch(&kinds_[row]);
    __builtin_prefetch(&x_[row], 1);
    __builtin_prefetch(&z_[row], 1);
    __builtin_prefetch(&old_x_[row], 1);
    __builtin_prefetch(&old_z_[row], 1);
    __builtin_prefetch(&aura_[row], 1);
}

/// Piece by piece in loops that each compare many rows at once, and without a branch per row.
void MovedSet::compare_all(const world::Entities& e, std::size_t common) {
    constexpr std::size_t kPiece = 512;
    steps_.resize(common + kPiece);
    std::size_t found = 0;
    std::array<float, kPiece> x;
    std::array<float, kPiece> z;
    std::array<std::uint32_t, kPiece> other;
    std::array<std::uint32_t, kPiece> stepped;
    std::array<std::uint32_t, kPiece> rows;
    for (std::size_t first = 0; first < common; first += kPiece) {
        const std::size_t size = std::min(kPiece, common - first);
        const Vec3* const position = e.position.data() + first;
        for (std::size_t i = 0; i < size; ++i) {
            x[i] = position[i].x();
            z[i] = position[i].z();
        }
        if (compare_kinds(e, first, size, other.data()) != 0) {
            for (std::size_t i = 0; i < size; ++i) {
                if (other[i] != 0) {
                    touched_.push_back(static_cast<world::Row>(first + i));
                }
            }
        }
        const float* const old_x = x_.data() + first;
        const float* const old_z = z_.data() + first;
        for (std::size_t i = 0; i < size; ++i) {
            const std::uint32_t moved =
                (bits(x[i]) ^ bits(old_x[i])) | (bits(z[i]) ^ bits(old_z[i]));
            stepped[i] =
                static_cast<std::uint32_t>(moved != 0) & static_cast<std::uint32_t>(other[i] == 0);
        }
        for (std::size_t i = 0; i < kPiece; ++i) {
            rows[i] = static_cast<world::Row>(first + i);
        }
        std::fill(stepped.begin() + static_cast<std::ptrdiff_t>(size), stepped.end(), 0);
        for (std::size_t i = 0; i < size; i += spatial::kLanes) {
            const std::uint32_t mask = lanes_equal(stepped.data() + i, 1);
            compress_store(rows.data() + i, mask, steps_.data() + found);
            found += static_cast<std::size_t>(std::popcount(mask));
        }
    }
    steps_.resize(found);
}

/// Writes for each row from `first` on a number other than zero where it holds another entity or
/// one of another kind than a tick ago; returns all of these together.
std::uint32_t MovedSet::compare_kinds(const world::Entities& e,
                                      std::size_t first,
                                      std::size_t size,
                                      std::uint32_t* other) const {
    const EntityId* const id = e.id.data() + first;
    const TypeIndex* const type = e.type.data() + first;
    const std::uint8_t* const stance = e.stance.data() + first;
    const std::uint8_t* const flags = e.flags.data() + first;
    const EntityId* const old_id = ids_.data() + first;
    const std::uint32_t* const old_kind = kinds_.data() + first;
    std::uint32_t all = 0;
    for (std::size_t i = 0; i < size; ++i) {
        const std::uint32_t kind = kind_of_parts(type[i], stance[i], flags[i]);
        other[i] = (id[i].value ^ old_id[i].value) | (kind ^ old_kind[i]);
        all |= other[i];
    }
    return all;
}

/// Takes over where rows moved to; those that jumped are changes, the others stay in the list.
void MovedSet::follow_steps(const world::Entities& e) {
    float longest = 0.0F;
    std::size_t kept = 0;
    for (const world::Row row : steps_) {
        const float x = e.position[row].x();
        const float z = e.position[row].z();
        const float dx = x - x_[row];
        const float dz = z - z_[row];
        const float squared = dx * dx + dz * dz;
        if (!(squared <= kStep_m * kStep_m)) {  // also rows that were or are nowhere
            take(e, row);
            continue;
        }
        x_[row] = x;
        z_[row] = z;
        longest = std::max(longest, squared);
        steps_[kept++] = row;
    }
    steps_.resize(kept);
    longest_step_m_ = std::sqrt(longest) * 1.0001F;
}

/// A row whose entity is another one, or did more than step.
void MovedSet::take(const world::Entities& e, world::Row row) {
    if (e.id[row] != ids_[row]) {
        lost_.push_back({ids_[row], row, x_[row], z_[row], aura_[row]});
        found_.push_back({e.id[row], row});
        leave(row);
        enter(e, row);
        return;
    }
    changes_.push_back({ids_[row], row, x_[row], z_[row], aura_[row]});
    leave(row);
    enter(e, row);
}

/// Writes a row's columns but for where it was a tick ago.
void MovedSet::enter(const world::Entities& e, world::Row row) {
    ids_[row] = e.id[row];
    kinds_[row] = kind_in(e, row);
    ZONED_ASSERT(e.stance[row] < kStances && kind_of(row) < aura_of_.size(),
                 "a type and a stance have radii");
    x_[row] = e.position[row].x();
    z_[row] = e.position[row].z();
    const bool somewhere = std::isfinite(x_[row]) && std::isfinite(z_[row]);
    const bool hidden = (kinds_[row] & kHiddenBit) != 0;
    aura_[row] = hidden || !somewhere ? 0.0F : aura_of_[kind_of(row)];
    if (!hidden) {
        ++heard_of_kind_[kind_of(row)];
        nowhere_ += somewhere ? 0U : 1U;
    }
}

void MovedSet::leave(world::Row row) {
    if ((kinds_[row] & kHiddenBit) == 0) {
        --heard_of_kind_[kind_of(row)];
        nowhere_ -= std::isfinite(x_[row]) && std::isfinite(z_[row]) ? 0U : 1U;
    }
}

/// Entities that lost a row and found another have moved house; the others came or are gone.
void MovedSet::pair_up() {
    const auto by_entity = [](const auto& a, const auto& b) {
        return a.entity < b.entity;
    };
    std::sort(lost_.begin(), lost_.end(), by_entity);
    std::sort(found_.begin(), found_.end(), by_entity);
    auto found = found_.cbegin();
    const auto came = [&](const FoundEntity& f) {
        changes_.push_back({f.entity, f.row, x_[f.row], z_[f.row], 0.0F});
    };
    for (const LostEntity& lost : lost_) {
        rows_left_.push_back(lost.row);
        while (found != found_.cend() && found->entity < lost.entity) {
            came(*found++);
        }
        EntityChange change{lost.entity, world::kNoRow, lost.x, lost.z, lost.aura_m};
        if (found != found_.cend() && found->entity == lost.entity) {
            change.row = (found++)->row;
        }
        changes_.push_back(change);
    }
    for (; found != found_.cend(); ++found) {
        came(*found);
    }
}

void MovedSet::survey() {
    largest_aura_m_ = 0.0F;
    smallest_aura_m_ = nowhere_ > 0 ? 0.0F : std::numeric_limits<float>::infinity();
    for (std::size_t kind = 0; kind < aura_of_.size(); ++kind) {
        if (heard_of_kind_[kind] > 0) {
            largest_aura_m_ = std::max(largest_aura_m_, aura_of_[kind]);
            smallest_aura_m_ = std::min(smallest_aura_m_, aura_of_[kind]);
        }
    }
}

void MovedSet::settle() {
    if (steps_.size() > size() / 4) {
        std::copy(x_.begin(), x_.end(), old_x_.begin());
        std::copy(z_.begin(), z_.end(), old_z_.begin());
        return;
    }
    for (const world::Row row : steps_) {
        old_x_[row] = x_[row];
        old_z_[row] = z_[row];
    }
}

}  // namespace zoned::interest
