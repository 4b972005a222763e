#include "server/rules/keeping/item_fields.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <system_error>

namespace zoned::rules {

namespace {

/// The declared fields of an entity's type; null: it has none.
const wire::FieldSchema* schema_of(const zone::RulesContext& context, EntityId entity) {
    const world::Row row = context.entities().find(entity);
    return row != world::kNoRow ? context.types()[context.entities().type[row]].fields.get()
                                : nullptr;
}

std::string text_of(const wire::FieldValue& value) {
    if (const auto* number = std::get_if<double>(&value)) {
        std::array<char, 32> text{};
        const auto end = std::to_chars(text.begin(), text.end(), *number).ptr;
        return {text.begin(), end};
    }
    if (const auto* flag = std::get_if<bool>(&value)) {
        return *flag ? "true" : "false";
    }
    return std::string(std::get<std::string_view>(value));
}

/// None: a number that is none.
std::optional<wire::FieldValue> value_of(const wire::DeclaredField& field,
                                         const std::string& text) {
    switch (field.kind) {
        case wire::DeclaredKind::kNumber: {
            double number = 0.0;
            const char* const end = text.data() + text.size();
            const auto read = std::from_chars(text.data(), end, number);
            if (read.ec != std::errc() || read.ptr != end) {
                return std::nullopt;
            }
            return number;
        }
        case wire::DeclaredKind::kBool:
            return text == "true";
        case wire::DeclaredKind::kEnum:
        case wire::DeclaredKind::kText:
            break;
    }
    return std::string_view(text);
}

}  // namespace

ItemFields item_fields(const zone::RulesContext& context, EntityId entity) {
    ItemFields held;
    const wire::FieldSchema* const schema = schema_of(context, entity);
    if (schema == nullptr) {
        return held;
    }
    const world::Entities& e = context.entities();
    const auto words = e.field_values(e.find(entity));
    for (const wire::DeclaredField& field : schema->fields()) {
        const auto now = wire::words_of(field, words);
        if (!std::ranges::equal(now, wire::words_of(field, schema->initial()))) {
            held.push_back({field.name, text_of(wire::value_of(field, now))});
        }
    }
    return held;
}

void give_fields(zone::RulesContext& context, EntityId entity, const ItemFields& fields) {
    const wire::FieldSchema* const schema = schema_of(context, entity);
    for (const ItemField& held : fields) {
        const wire::FieldId id = wire::field_id(held.name);
        const wire::DeclaredField* const field = schema != nullptr ? schema->find(id) : nullptr;
        const auto value = field != nullptr ? value_of(*field, held.value) : std::nullopt;
        if (value) {
            context.set_field(entity, id, *value);
        }
    }
}

}  // namespace zoned::rules
