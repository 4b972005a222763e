// StateTable: what a script keeps between calls, owned by the host: numbers, texts, truth values
// and tables of these.
#pragma once

#include "shared/core/state_hash.h"

#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace zoned::scripting {

class StateTable;

/// Numbers come before texts.
using StateKey = std::variant<std::int64_t, std::string>;
/// A key to look for: no text is copied.
using StateKeyView = std::variant<std::int64_t, std::string_view>;

/// Nothing, a truth value, an integer, a number, a text or a table.
using StateValue = std::
    variant<std::monostate, bool, std::int64_t, double, std::string, std::shared_ptr<StateTable>>;

/// Tables in tables, counted from the outermost.
inline constexpr int kMaxStateDepth = 16;

/// The bytes that all tables of a script take together, by a formula that is the same everywhere.
struct StateBudget {
    std::size_t used = 0;
    std::size_t most = 0;
    /// Tables that were taken out: a script may still read them until its call ends.
    std::vector<std::shared_ptr<StateTable>> removed;
};

/// Thrown where state would take more than its budget; nothing has changed then.
struct StateIsFull {};

struct StateKeyLess {
    using is_transparent = void;

    static StateKeyView view(const StateKey& key) {
        if (const auto* text = std::get_if<std::string>(&key)) {
            return std::string_view(*text);
        }
        return std::get<std::int64_t>(key);
    }

    static const StateKeyView& view(const StateKeyView& key) { return key; }

    template <class A, class B>
    bool operator()(const A& a, const B& b) const {
        return view(a) < view(b);
    }
};

/// A table with its entries in order of their keys. It has one place: in one other table.
class StateTable {
  public:
    using Entries = std::map<StateKey, StateValue, StateKeyLess>;

    /// The outermost table, which nothing holds.
    explicit StateTable(StateBudget& budget);
    ~StateTable();
    StateTable(const StateTable&) = delete;
    StateTable& operator=(const StateTable&) = delete;

    [[nodiscard]] const Entries& entries() const { return entries_; }

    /// Null where there is no such entry.
    [[nodiscard]] const StateValue* find(const StateKeyView& key) const;

    /// A truth value, number or text; nothing removes the entry. Throws StateIsFull.
    void set(const StateKeyView& key, StateValue value);
    /// An empty table in place of what was there. Throws StateIsFull; null where it would lie too
    /// deep.
    std::shared_ptr<StateTable> add_table(const StateKeyView& key);

    /// The entries 1, 2, ... up to the first that is missing.
    [[nodiscard]] std::int64_t length() const { return length_; }

    /// False once the table, or one around it, was removed: it takes no more entries.
    [[nodiscard]] bool attached() const { return budget_ != nullptr; }

    /// Chains what has changed since the last call, here and below.
    void hash_changes(core::StateHash& hash) const;

    /// Bookkeeping of the hash, which snapshots keep.
    [[nodiscard]] bool touched() const { return touched_; }

    void set_touched(bool on) { touched_ = on; }

  private:
    StateTable(StateTable& parent, StateBudget& budget);

    void touch();
    void detach();
    /// Takes the bytes of a new entry, or throws.
    void take(std::size_t bytes);
    void put(const StateKeyView& key, StateValue value, std::size_t bytes);
    /// Where no table was and none will be.
    void replace(StateValue& old, StateValue value);
    void remove(Entries::iterator at);
    void count_from(std::int64_t key);

    Entries entries_;
    StateTable* parent_ = nullptr;  // null: outermost or detached
    StateBudget* budget_ = nullptr;
    std::int64_t length_ = 0;
    int depth_ = 0;
    mutable bool touched_ = true;  // an entry here or below has changed since the last hash
};

}  // namespace zoned::scripting
