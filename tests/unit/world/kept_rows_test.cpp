// Sets of rows and counts that Entities keeps where rows, flags and types change.
#include "server/world/entities.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace zoned::world {
namespace {

TEST(RowSet, WalksItsMembersInAscendingOrder) {
    RowSet set;
    for (Row row = 0; row < 200; ++row) {
        set.push_back(row % 7 == 0 || row == 64 || row == 199);
    }
    std::vector<Row> walked;
    for_each_row(set, [&](Row row) { walked.push_back(row); });
    std::vector<Row> asked;
    for (Row row = set.next(0); row != kNoRow; row = set.next(row + 1)) {
        asked.push_back(row);
    }
    std::vector<Row> members;
    for (Row row = 0; row < 200; ++row) {
        if (set.has(row)) {
            members.push_back(row);
        }
    }
    EXPECT_EQ(walked, members);
    EXPECT_EQ(asked, members);
    EXPECT_EQ(set.count(), members.size());
    EXPECT_EQ(set.next(200), kNoRow);
}

/// A set of 20,000 rows, so that the summaries of words have words of their own, against a list of
/// members.
TEST(RowSet, IsTheSameAsAListAfterAnyChanges) {
    core::Rng rng(11);
    RowSet set;
    std::vector<bool> list;
    const auto check = [&](int step) {
        std::vector<Row> members;
        for (Row row = 0; row < list.size(); ++row) {
            if (list[row]) {
                members.push_back(row);
            }
        }
        std::vector<Row> walked;
        for_each_row(set, [&](Row row) { walked.push_back(row); });
        std::vector<Row> united;
        RowSet none;
        for (std::size_t row = 0; row < list.size(); ++row) {
            none.push_back(false);
        }
        for_each_row(none, set, [&](Row row) { united.push_back(row); });
        std::vector<Row> asked;
        for (Row row = set.next(0); row != kNoRow; row = set.next(row + 1)) {
            asked.push_back(row);
        }
        ASSERT_EQ(walked, members) << "after step " << step;
        ASSERT_EQ(united, members) << "after step " << step;
        ASSERT_EQ(asked, members) << "after step " << step;
        ASSERT_EQ(set.count(), members.size()) << "after step " << step;
        ASSERT_EQ(set.size(), list.size()) << "after step " << step;
    };
    // Grows beyond 64 * 64 rows, and shrinks to nothing, with few members and with many.
    for (int step = 0; step < 120'000; ++step) {
        const bool grows = (step / 20'000) % 2 == 0;
        const std::uint32_t what = rng.below(10);
        if (list.empty() || (what < 6 && grows) || (what < 1 && !grows)) {
            const bool in = rng.below(40) == 0;
            set.push_back(in);
            list.push_back(in);
        } else if (what < 7) {
            const Row row = rng.below(static_cast<std::uint32_t>(list.size()));
            set.move_last_into(row);
            list[row] = list.back();
            list.pop_back();
        } else {
            const Row row = rng.below(static_cast<std::uint32_t>(list.size()));
            const bool in = rng.below(3) == 0;
            set.put(row, in);
            list[row] = in;
        }
        if (step % 30'011 == 30'010) {
            set.clear();
            list.assign(list.size(), false);
        }
        if (step % 997 == 0) {
            check(step);
        }
    }
    check(-1);
}

TEST(RowSet, VisitsARowThatIsPutInAheadOfTheWalk) {
    RowSet set;
    for (Row row = 0; row < 10'000; ++row) {
        set.push_back(row == 3);
    }
    std::vector<Row> walked;
    for_each_row(set, [&](Row row) {
        walked.push_back(row);
        if (row == 3) {
            set.put(70, true);     // another word of the same summary
            set.put(9'000, true);  // another summary
            set.put(5, true);      // the same word: as it was
        }
    });
    EXPECT_EQ(walked, (std::vector<Row>{3, 70, 9'000}));
}

/// Props, agents and players, rewindable or not.
TypeTable some_types() {
    TypeTable types(6);
    for (std::size_t k = 0; k < types.size(); ++k) {
        types[k].kind = k < 2 ? EntityKind::kProp : EntityKind::kCharacter;
        types[k].brain = k == 2 || k == 3 ? 1 : 0;
        types[k].rewindable = k % 2 == 1;
    }
    return types;
}

/// The errors of the sets and counts, found by a pass over all rows; empty: none. `types`: as they
/// were declared.
std::string wrong_sets(const Entities& e, const TypeTable& types = {}) {
    std::map<TypeIndex, Entities::Count> counts;
    for (Row row = 0; row < e.size(); ++row) {
        const EntityType* const type = types.empty() ? nullptr : &types[e.type[row]];
        const bool prop = type != nullptr && type->kind == EntityKind::kProp;
        const bool still = e.has(row, kAtRest) && (prop || e.has(row, kDozing));
        if (e.characters().has(row) != (type != nullptr && !prop)) {
            return "characters " + std::to_string(row);
        }
        if (e.players().has(row) != (type != nullptr && !prop && type->brain == 0)) {
            return "players " + std::to_string(row);
        }
        if (e.rewindable().has(row) != (type != nullptr && type->rewindable)) {
            return "rewindable " + std::to_string(row);
        }
        if (e.reduced().has(row) != (e.representation[row] != 0)) {
            return "reduced " + std::to_string(row);
        }
        if (e.moving().has(row) == e.has(row, kAtRest)) {
            return "moving " + std::to_string(row);
        }
        if (e.stirring().has(row) == still) {
            return "stirring " + std::to_string(row);
        }
        if (e.avatars().has(row) != static_cast<bool>(e.client[row])) {
            return "avatars " + std::to_string(row);
        }
        Entities::Count& count = counts[e.type[row]];
        count.ghosts += e.has(row, kGhost) ? 1U : 0U;
        count.owned += e.has(row, kGhost) ? 0U : 1U;
        count.shown += e.has(row, kGhost) || e.has(row, kHidden) ? 0U : 1U;
    }
    for (TypeIndex type = 0; type < e.counts().size(); ++type) {
        const Entities::Count& kept = e.counts()[type];
        const Entities::Count& found = counts[type];
        if (kept.ghosts != found.ghosts || kept.owned != found.owned || kept.shown != found.shown) {
            return "counts of type " + std::to_string(type);
        }
    }
    for (const RowSet* set : {&e.moving(),
                              &e.stirring(),
                              &e.avatars(),
                              &e.characters(),
                              &e.players(),
                              &e.rewindable(),
                              &e.reduced(),
                              &e.touched(Reader::kHash),
                              &e.touched(Reader::kExport),
                              &e.touched(Reader::kInterest),
                              &e.touched(Reader::kGrid)}) {
        if (set->size() != e.size() || (set->next(0) != kNoRow && set->next(0) >= e.size())) {
            return "a set of another size";
        }
    }
    return {};
}

/// Columns of one row as a reader saw them.
struct Seen {
    EntityId id;
    std::uint8_t flags;
    TypeIndex type;

    friend bool operator==(const Seen&, const Seen&) = default;
};

std::vector<Seen> look(const Entities& e) {
    std::vector<Seen> all;
    for (Row row = 0; row < e.size(); ++row) {
        all.push_back({e.id[row], e.flags[row], e.type[row]});
    }
    return all;
}

/// A row that is not as the reader saw it and was not touched since, or kNoRow.
Row missed(const Entities& e, const std::vector<Seen>& before, Reader reader) {
    const std::vector<Seen> now = look(e);
    for (Row row = 0; row < now.size(); ++row) {
        if ((row >= before.size() || before[row] != now[row]) && !e.touched(reader).has(row)) {
            return row;
        }
    }
    return kNoRow;
}

/// One of the changes that rows go through.
void change(Entities& e, core::Rng& rng, std::uint32_t& next_id) {
    const std::uint32_t what = rng.below(11);
    if (e.size() == 0 || what == 0) {
        e.add(EntityId(next_id++), static_cast<TypeIndex>(rng.below(5)));
        return;
    }
    const Row row = rng.below(static_cast<std::uint32_t>(e.size()));
    if (what == 1) {
        e.remove(row);
    } else if (what == 2) {
        e.set_client(row, ClientId(rng.below(2)));
    } else if (what == 3) {
        e.set_type(row, static_cast<TypeIndex>(rng.below(6)));
    } else if (what == 10) {
        e.set_representation(row, static_cast<std::uint8_t>(rng.below(3)));
    } else if (what == 4) {
        e.set_flags(row, static_cast<std::uint8_t>(rng.below(32)));
    } else {
        const EntityFlag flags[] = {kGhost, kAtRest, kGrounded, kHidden, kDozing};
        e.set(row, flags[rng.below(5)], rng.below(2) != 0);
    }
}

TEST(KeptRows, AreThoseThatALookAtAllRowsFinds) {
    core::Rng rng(3);
    const TypeTable types = some_types();
    Entities e;
    e.declare_types(types);
    std::uint32_t next_id = 1;
    // Across words of 64 rows, up and down.
    while (e.size() < 300) {
        e.add(EntityId(next_id++), static_cast<TypeIndex>(rng.below(5)));
    }
    std::vector<Seen> seen[kReaders];
    for (int i = 0; i < 20'000; ++i) {
        change(e, rng, next_id);
        if (i % 5'000 == 0) {
            while (e.size() > 3) {
                e.remove(rng.below(static_cast<std::uint32_t>(e.size())));
            }
        }
        ASSERT_EQ(wrong_sets(e, types), "") << "after change " << i;
        for (std::size_t r = 0; r < kReaders; ++r) {
            const auto reader = static_cast<Reader>(r);
            ASSERT_EQ(missed(e, seen[r], reader), kNoRow) << "after change " << i;
            // Each reader reads at its own times.
            if (rng.below(static_cast<std::uint32_t>(3 + 4 * r)) == 0) {
                seen[r] = look(e);
                e.forget_touched(reader);
            }
        }
    }
}

TEST(KeptRows, TheCheckFindsARowThatWasForgotten) {
    Entities e;
    for (std::uint32_t id = 1; id <= 70; ++id) {
        e.add(EntityId(id), 0);
    }
    const std::vector<Seen> before = look(e);
    e.set(65, kHidden, true);
    EXPECT_EQ(missed(e, before, Reader::kHash), kNoRow);
    e.forget_touched(Reader::kHash);
    EXPECT_EQ(missed(e, before, Reader::kHash), 65U);
    // Of two columns of different lengths the sets of one cannot be right for the other.
    Entities other = e;
    other.remove(0);
    EXPECT_EQ(wrong_sets(other), "");
    const_cast<RowSet&>(other.moving()).put(3, false);
    EXPECT_EQ(wrong_sets(other), "moving 3");
}

}  // namespace
}  // namespace zoned::world
