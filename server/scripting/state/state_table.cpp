#include "server/scripting/state/state_table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

namespace zoned::scripting {

namespace {

// Of a node of the map and of a table, about as they are on 64 bits.
constexpr std::size_t kEntryBytes = 128;
constexpr std::size_t kTableBytes = 160;

std::size_t text_bytes(const StateValue& value) {
    const auto* text = std::get_if<std::string>(&value);
    return text != nullptr ? text->size() : 0;
}

std::size_t text_bytes(const StateKeyView& key) {
    const auto* text = std::get_if<std::string_view>(&key);
    return text != nullptr ? text->size() : 0;
}

bool holds_table(const StateValue& value) {
    return std::holds_alternative<std::shared_ptr<StateTable>>(value);
}

std::size_t entry_bytes(const StateKeyView& key, const StateValue& value) {
    return kEntryBytes + text_bytes(key) + text_bytes(value);
}

StateKey own(const StateKeyView& key) {
    if (const auto* text = std::get_if<std::string_view>(&key)) {
        return std::string(*text);
    }
    return std::get<std::int64_t>(key);
}

void add_text(core::StateHash& hash, std::string_view text) {
    hash.add_bytes({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

void add_key(core::StateHash& hash, const StateKey& key) {
    hash.add(key.index());
    if (const auto* text = std::get_if<std::string>(&key)) {
        add_text(hash, *text);
    } else {
        hash.add(std::get<std::int64_t>(key));
    }
}

/// Tables chain themselves.
void add_value(core::StateHash& hash, const StateValue& value) {
    hash.add(value.index());
    if (const auto* truth = std::get_if<bool>(&value)) {
        hash.add(*truth);
    } else if (const auto* integer = std::get_if<std::int64_t>(&value)) {
        hash.add(*integer);
    } else if (const auto* number = std::get_if<double>(&value)) {
        hash.add(*number);
    } else if (const auto* text = std::get_if<std::string>(&value)) {
        add_text(hash, *text);
    }
}

}  // namespace

StateTable::StateTable(StateBudget& budget) : budget_(&budget) {
}

StateTable::StateTable(StateTable& parent, StateBudget& budget)
    : parent_(&parent),
      budget_(&budget),
      depth_(parent.depth_ + 1) {
}

StateTable::~StateTable() {
    // Handles may hold tables of this one for longer.
    detach();
}

const StateValue* StateTable::find(const StateKeyView& key) const {
    const auto at = entries_.find(key);
    return at != entries_.end() ? &at->second : nullptr;
}

void StateTable::take(std::size_t bytes) {
    if (bytes > budget_->most - std::min(budget_->used, budget_->most)) {
        throw StateIsFull();
    }
    budget_->used += bytes;
}

void StateTable::touch() {
    for (StateTable* table = this; table != nullptr && !table->touched_; table = table->parent_) {
        table->touched_ = true;
    }
}

void StateTable::put(const StateKeyView& key, StateValue value, std::size_t bytes) {
    take(bytes);
    const auto at = entries_.find(key);
    if (at != entries_.end()) {
        remove(at);
    }
    entries_.emplace(own(key), std::move(value));
    if (const auto* number = std::get_if<std::int64_t>(&key)) {
        count_from(*number);
    }
    touch();
}

void StateTable::set(const StateKeyView& key, StateValue value) {
    if (!std::holds_alternative<std::monostate>(value)) {
        if (auto* number = std::get_if<double>(&value); number != nullptr && std::isnan(*number)) {
            *number =
                std::numeric_limits<double>::quiet_NaN();  // one of many: all processors alike
        }
        if (const auto at = entries_.find(key); at != entries_.end() && !holds_table(at->second)) {
            replace(at->second, std::move(value));
        } else {
            const std::size_t bytes = entry_bytes(key, value);
            put(key, std::move(value), bytes);
        }
        return;
    }
    const auto at = entries_.find(key);
    if (at != entries_.end()) {
        remove(at);
        touch();
    }
}

void StateTable::replace(StateValue& old, StateValue value) {
    take(text_bytes(value));
    budget_->used -= text_bytes(old);
    old = std::move(value);
    touch();
}

std::shared_ptr<StateTable> StateTable::add_table(const StateKeyView& key) {
    if (depth_ + 1 >= kMaxStateDepth) {
        return nullptr;
    }
    std::shared_ptr<StateTable> table(new StateTable(*this, *budget_));
    put(key, table, entry_bytes(key, {}) + kTableBytes);
    return table;
}

void StateTable::remove(Entries::iterator at) {
    std::size_t bytes = entry_bytes(StateKeyLess::view(at->first), at->second);
    if (auto* table = std::get_if<std::shared_ptr<StateTable>>(&at->second)) {
        (*table)->detach();
        budget_->removed.push_back(std::move(*table));
        bytes += kTableBytes;
    }
    budget_->used -= bytes;
    if (const auto* number = std::get_if<std::int64_t>(&at->first);
        number != nullptr && *number >= 1 && *number <= length_) {
        length_ = *number - 1;
    }
    entries_.erase(at);
}

void StateTable::count_from(std::int64_t key) {
    if (key != length_ + 1) {
        return;
    }
    for (auto at = entries_.find(StateKeyView(key));
         at != entries_.end() && at->first == StateKey(length_ + 1);
         ++at) {
        ++length_;
    }
}

void StateTable::detach() {
    if (budget_ == nullptr) {
        return;
    }
    for (auto& [key, value] : entries_) {
        budget_->used -= entry_bytes(StateKeyLess::view(key), value);
        if (auto* table = std::get_if<std::shared_ptr<StateTable>>(&value)) {
            budget_->used -= kTableBytes;
            (*table)->detach();
        }
    }
    parent_ = nullptr;
    budget_ = nullptr;
}

void StateTable::hash_changes(core::StateHash& hash) const {
    if (!touched_) {
        return;
    }
    touched_ = false;
    hash.add(entries_.size());
    for (const auto& [key, value] : entries_) {
        add_key(hash, key);
        add_value(hash, value);
        if (const auto* table = std::get_if<std::shared_ptr<StateTable>>(&value)) {
            (*table)->hash_changes(hash);
        }
    }
}

}  // namespace zoned::scripting
