#include "server/scripting/state/state_bytes.h"

#include "shared/core/archive/field_archive.h"

#include <utility>

namespace zoned::scripting {

namespace {

/// As StateValue::index(); a table's entries follow.
enum class ValueTag : std::uint8_t {
    kNothing,
    kTruth,
    kInteger,
    kNumber,
    kText,
    kTable,
};

void write_key(core::FieldWriter& archive, const StateKey& key) {
    const bool is_text = std::holds_alternative<std::string>(key);
    archive(is_text);
    std::visit(archive, key);
}

void write_value(core::FieldWriter& archive, const StateValue& value) {
    archive(static_cast<std::uint8_t>(value.index()));
    if (const auto* truth = std::get_if<bool>(&value)) {
        archive(*truth);
    } else if (const auto* integer = std::get_if<std::int64_t>(&value)) {
        archive(*integer);
    } else if (const auto* number = std::get_if<double>(&value)) {
        archive(*number);
    } else if (const auto* text = std::get_if<std::string>(&value)) {
        archive(*text);
    } else if (const auto* table = std::get_if<std::shared_ptr<StateTable>>(&value)) {
        write_table(archive, **table);
    }
}

template <class T>
T read(core::FieldReader& archive) {
    T value{};
    archive(value);
    return value;
}

StateKey read_key(core::FieldReader& archive) {
    if (read<bool>(archive)) {
        return read<std::string>(archive);
    }
    return read<std::int64_t>(archive);
}

void read_entry(core::FieldReader& archive, StateTable& table) {
    const StateKey own_key = read_key(archive);
    const StateKeyView key = StateKeyLess::view(own_key);
    switch (static_cast<ValueTag>(read<std::uint8_t>(archive))) {
        case ValueTag::kTruth:
            table.set(key, read<bool>(archive));
            return;
        case ValueTag::kInteger:
            table.set(key, read<std::int64_t>(archive));
            return;
        case ValueTag::kNumber:
            table.set(key, read<double>(archive));
            return;
        case ValueTag::kText:
            table.set(key, read<std::string>(archive));
            return;
        case ValueTag::kTable:
            if (const auto below = table.add_table(key)) {
                read_table(archive, *below);
                return;
            }
            archive.fail("tables of a script's state lie too deep");
            return;
        case ValueTag::kNothing:
            break;
    }
    archive.fail("a script's state holds an unknown kind of value");
}

}  // namespace

void write_table(core::FieldWriter& archive, const StateTable& table) {
    archive(table.touched(), std::uint64_t{table.entries().size()});
    for (const auto& [key, value] : table.entries()) {
        write_key(archive, key);
        write_value(archive, value);
    }
}

void read_table(core::FieldReader& archive, StateTable& table) {
    const bool touched = read<bool>(archive);
    const auto count = read<std::uint64_t>(archive);
    try {
        for (std::uint64_t i = 0; i < count && archive.good(); ++i) {
            read_entry(archive, table);
        }
    } catch (const StateIsFull&) {
        archive.fail("a script's state is larger than script.state_mb");
    }
    table.set_touched(touched);
}

}  // namespace zoned::scripting
