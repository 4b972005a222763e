#include "server/world/field_columns.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <utility>

namespace zoned::world {

std::uint32_t FieldColumns::take(TypeIndex type) {
    const wire::FieldSchema* own = schema(type);
    if (own == nullptr) {
        return kNone;
    }
    if (free_.size() < schemas_.size()) {
        free_.resize(schemas_.size());
    }
    std::uint32_t block = static_cast<std::uint32_t>(words_.size());
    if (free_[type].empty()) {
        words_.resize(words_.size() + size_of(*own));
    } else {
        block = free_[type].back();
        free_[type].pop_back();
    }
    const auto at = words_.begin() + block;
    std::fill(std::copy(own->initial().begin(), own->initial().end(), at),
              at + static_cast<std::ptrdiff_t>(size_of(*own)),
              0U);
    return block;
}

void FieldColumns::give_back(TypeIndex type, std::uint32_t block) {
    if (block != kNone) {
        free_[type].push_back(block);
    }
}

void FieldColumns::add(TypeIndex type) {
    if (any()) {
        block_.push_back(take(type));
    }
}

void FieldColumns::move_last_into(Row row, TypeIndex type_of_row) {
    if (any()) {
        give_back(type_of_row, block_[row]);
        block_[row] = block_.back();
        block_.pop_back();
    }
}

void FieldColumns::set_type(Row row, TypeIndex from, TypeIndex to) {
    if (any() && from != to) {
        give_back(from, block_[row]);
        block_[row] = take(to);
    }
}

void FieldColumns::put_block(Row row, TypeIndex type, std::span<const std::uint32_t> words) {
    const wire::FieldSchema* own = schema(type);
    if (own != nullptr && words.size() == size_of(*own)) {
        std::copy(words.begin(), words.end(), words_.begin() + block_[row]);
    }
}

bool FieldColumns::put(Row row,
                       TypeIndex type,
                       const wire::DeclaredField& field,
                       std::span<const std::uint32_t> words,
                       Tick now) {
    const wire::FieldSchema& own = *schema(type);
    const auto at = words_.begin() + block_[row] + field.word;
    if (std::equal(words.begin(), words.end(), at)) {
        return false;
    }
    std::copy(words.begin(), words.end(), at);
    words_[block_[row] + own.words() + own.index_of(field)] = static_cast<std::uint32_t>(now);
    return true;
}

bool FieldColumns::fits(std::span<const TypeIndex> types) const {
    if (!any()) {
        return block_.empty();
    }
    if (block_.size() != types.size() || (!free_.empty() && free_.size() != schemas_.size())) {
        return false;
    }
    const auto within = [&](std::uint32_t block, TypeIndex type) {
        const wire::FieldSchema* own = schema(type);
        return own == nullptr ? block == kNone
                              : block <= words_.size() && size_of(*own) <= words_.size() - block;
    };
    for (std::size_t row = 0; row < types.size(); ++row) {
        if (!within(block_[row], types[row])) {
            return false;
        }
    }
    for (std::size_t type = 0; type < free_.size(); ++type) {
        for (const std::uint32_t block : free_[type]) {
            if (block == kNone || !within(block, static_cast<TypeIndex>(type))) {
                return false;
            }
        }
    }
    return true;
}

}  // namespace zoned::world
