// FieldColumns: the declared fields of all entities of a zone, in one column of words.
#pragma once

#include "server/world/row_set.h"
#include "shared/wire/declared/declared_fields.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::world {

/// Each row of a type with declared fields has a block of words: the values of its fields, then the
/// tick of each field's last change. Blocks are used again, by rows of the same type, so that
/// nothing is allocated once as many entities have lived at a time. Nothing is kept where no type
/// declares a field.
class FieldColumns {
  public:
    /// Before the first row.
    void declare(wire::FieldSchemas schemas) { schemas_ = std::move(schemas); }

    [[nodiscard]] bool any() const { return !schemas_.empty(); }

    /// nullptr: the type has no fields.
    [[nodiscard]] const wire::FieldSchema* schema(TypeIndex type) const {
        return wire::schema_of(schemas_, type);
    }

    /// The values of a row; empty where its type has none.
    [[nodiscard]] std::span<const std::uint32_t> values(Row row, TypeIndex type) const {
        const wire::FieldSchema* own = schema(type);
        return own != nullptr ? std::span(words_).subspan(block_[row], own->words())
                              : std::span<const std::uint32_t>();
    }

    /// The tick (its low 32 bits) of the last change of each field of a row.
    [[nodiscard]] std::span<const std::uint32_t> changed(Row row, TypeIndex type) const {
        const wire::FieldSchema* own = schema(type);
        return own != nullptr
                   ? std::span(words_).subspan(block_[row] + own->words(), own->fields().size())
                   : std::span<const std::uint32_t>();
    }

    /// Both: what an entity takes along to another zone.
    [[nodiscard]] std::span<const std::uint32_t> block(Row row, TypeIndex type) const {
        const wire::FieldSchema* own = schema(type);
        return own != nullptr ? std::span(words_).subspan(block_[row], size_of(*own))
                              : std::span<const std::uint32_t>();
    }

    void put_block(Row row, TypeIndex type, std::span<const std::uint32_t> words);

    /// True when the value was another one.
    bool put(Row row,
             TypeIndex type,
             const wire::DeclaredField& field,
             std::span<const std::uint32_t> words,
             Tick now);

    // Rows as Entities adds and removes them.

    void add(TypeIndex type);
    void move_last_into(Row row, TypeIndex type_of_row);
    void set_type(Row row, TypeIndex from, TypeIndex to);

    template <class Archive>
    void serialize(Archive& archive) {
        archive(block_, words_, free_);
    }

    /// Whether each row has a block of its type within the words.
    [[nodiscard]] bool fits(std::span<const TypeIndex> types) const;

  private:
    static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

    [[nodiscard]] static std::size_t size_of(const wire::FieldSchema& schema) {
        return schema.words() + schema.fields().size();
    }

    std::uint32_t take(TypeIndex type);
    void give_back(TypeIndex type, std::uint32_t block);

    wire::FieldSchemas schemas_;
    std::vector<std::uint32_t> block_;              // by row; kNone: its type has no fields
    std::vector<std::uint32_t> words_;              // of all blocks
    std::vector<std::vector<std::uint32_t>> free_;  // by type
};

}  // namespace zoned::world
