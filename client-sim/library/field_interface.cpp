// The C interface to the declared fields of types and entities, and to the shapes that they tell.
#include "client-sim/library/border.h"
#include "client-sim/library/sized_struct.h"

namespace zoned::library {

namespace {

/// The values of an entity that is there; empty where there are none.
std::span<const std::uint32_t> words_of(const view::View& view, const view::Entity* entity) {
    const wire::FieldSchema* const schema =
        entity != nullptr && entity->present() && entity->typed && !entity->fields.empty()
            ? wire::schema_of(view.world().fields, entity->type)
            : nullptr;
    if (schema == nullptr || entity->fields.back().words.size() != schema->words()) {
        return {};
    }
    return entity->fields.back().words;
}

/// 1, 0 or what is wrong, as the functions return it. `index`: of the field, by its schema.
template <class Index>
int give_field(const zoned_client* client,
               std::uint32_t id,
               zoned_client_field_value* out,
               Index&& index_of) {
    const view::View* const view = view_of(client);
    if (view == nullptr) {
        return no_view(client);
    }
    const view::Entity* const entity = view->store().find(EntityId(id));
    const std::span<const std::uint32_t> words = words_of(*view, entity);
    if (words.empty()) {
        return 0;
    }
    const wire::FieldSchema& schema = *wire::schema_of(view->world().fields, entity->type);
    const std::size_t index = index_of(schema);
    if (index >= schema.fields().size()) {
        return 0;
    }
    const wire::DeclaredField& field = schema.fields()[index];
    const std::span<const std::uint32_t> at = wire::words_of(field, words);
    const wire::FieldValue value = wire::value_of(field, at);
    zoned_client_field_value filled{};
    filled.kind = static_cast<std::uint32_t>(field.kind);
    if (const auto* number = std::get_if<double>(&value)) {
        filled.number = *number;
    } else if (const auto* truth = std::get_if<bool>(&value)) {
        filled.number = *truth ? 1.0 : 0.0;
    } else {
        filled.number = field.kind == wire::DeclaredKind::kEnum ? static_cast<double>(at[0]) : 0.0;
        give_name(filled.text, std::get<std::string_view>(value));
    }
    return give(out, filled) ? 1 : ZONED_CLIENT_BAD_ARGUMENT;
}

}  // namespace

// In a namespace g++ forgets that the header shows them.
#pragma GCC visibility push(default)

extern "C" {

int zoned_client_fields(const zoned_client* client, uint32_t type) {
    const view::View* const view = view_of(client);
    if (view == nullptr) {
        return no_view(client);
    }
    if (type >= view->world().types.size()) {
        return ZONED_CLIENT_BAD_ARGUMENT;
    }
    const wire::FieldSchema* const schema =
        wire::schema_of(view->world().fields, static_cast<TypeIndex>(type));
    return schema != nullptr ? static_cast<int>(schema->fields().size()) : 0;
}

int zoned_client_field(const zoned_client* client,
                       uint32_t type,
                       uint32_t index,
                       zoned_client_field_info* out) {
    const int count = zoned_client_fields(client, type);
    if (count < 0) {
        return count;
    }
    if (index >= static_cast<std::uint32_t>(count)) {
        return ZONED_CLIENT_BAD_ARGUMENT;
    }
    const wire::FieldSchema& schema =
        *wire::schema_of(client->game->view()->world().fields, static_cast<TypeIndex>(type));
    const wire::DeclaredField& field = schema.fields()[index];
    zoned_client_field_info filled{};
    filled.kind = static_cast<std::uint32_t>(field.kind);
    if (field.kind == wire::DeclaredKind::kNumber) {
        filled.minimum = field.minimum;
        filled.maximum = field.minimum + field.quantum * static_cast<double>(field.most);
        filled.quantum = field.quantum;
    }
    filled.values = static_cast<std::uint32_t>(field.values.size());
    give_name(filled.name, field.name);
    return give(out, filled) ? 0 : ZONED_CLIENT_BAD_ARGUMENT;
}

int zoned_client_field_at(const zoned_client* client,
                          uint32_t entity,
                          uint32_t index,
                          zoned_client_field_value* out) {
    return give_field(client, entity, out, [index](const wire::FieldSchema&) { return index; });
}

int zoned_client_field_named(const zoned_client* client,
                             uint32_t entity,
                             const char* name,
                             zoned_client_field_value* out) {
    if (name == nullptr) {
        return ZONED_CLIENT_BAD_ARGUMENT;
    }
    return give_field(client, entity, out, [name](const wire::FieldSchema& schema) {
        const wire::DeclaredField* field = schema.find(wire::field_id(name));
        return field != nullptr && field->name == name ? schema.index_of(*field)
                                                       : schema.fields().size();
    });
}

int zoned_client_deform(const zoned_client* client, uint32_t entity, float* places, size_t count) {
    const view::View* const view = view_of(client);
    if (view == nullptr) {
        return no_view(client);
    }
    if (places == nullptr) {
        return ZONED_CLIENT_BAD_ARGUMENT;
    }
    const view::Entity* const known = view->store().find(EntityId(entity));
    const std::span<const std::uint32_t> words = words_of(*view, known);
    if (words.empty()) {
        return 0;
    }
    const view::TypeInfo& type = view->world().types[known->type];
    if (!type.deformation) {
        return 0;
    }
    const wire::FieldSchema& schema = *wire::schema_of(view->world().fields, known->type);
    const std::span<const std::uint32_t> codes =
        words.subspan(schema.fields()[type.first_control_point].word);
    for (std::size_t i = 0; i < count; ++i) {
        Eigen::Map<Vec3> place(places + 3 * i);
        place += type.deformation->displacement_at(type.deformation->weights_at(place), codes);
    }
    return 1;
}

}  // extern "C"

#pragma GCC visibility pop

}  // namespace zoned::library
