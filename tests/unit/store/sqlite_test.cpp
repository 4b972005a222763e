// The embedded store and its file: migrations, damage, locks, a full disk, backups.
#include "server/store/sqlite_database.h"
#include "server/store/sqlite_schema.h"
#include "tests/unit/store/store_fixture.h"

#include <sqlite3.h>

#include <fstream>

namespace zoned::store::test {
namespace {

void write_text(const std::string& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
}

std::string text_of(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

StoreError refusal(const std::string& file, StoreUse use = StoreUse::kServe) {
    const auto opened = open_sqlite_store(file, Durability::kProcess, use);
    EXPECT_FALSE(opened.ok()) << file;
    return opened.ok() ? StoreError() : opened.error();
}

TEST(SqliteSchema, EachVersionComesToTheNextWithAllThatItHeld) {
    ASSERT_GE(sqlite_steps().size(), 2U);
    for (std::size_t from = 1; from < sqlite_steps().size(); ++from) {
        const ScratchFolder folder;
        const std::string file = folder.file("store.db");
        {
            SqliteDatabase old;
            taken(old.open(file, SqliteDatabase::Access::kCreate));
            taken(migrate_sqlite(old, from));
            EXPECT_EQ(taken(sqlite_schema(old)), from);
            taken(
                old.run("INSERT INTO record VALUES (0, '', '', 'k', x'0708');"
                        "INSERT INTO ban VALUES ('ann', 5, 'why');"
                        "INSERT INTO account VALUES ('ann', 1, 2);"
                        "INSERT INTO character VALUES ('ann', 'hero', 2, 1.0, 2.0, 3.0, 'w');"
                        "INSERT INTO ticket VALUES (x'00112233445566778899aabbccddeeff', 9);"));
        }
        const auto store = open_file(file);
        ASSERT_NE(store, nullptr);
        const StoreCounts counts = taken(store->counts());
        EXPECT_EQ(counts.schema, sqlite_steps().size());
        EXPECT_EQ(counts.accounts + counts.characters + counts.bans + counts.tickets, 4U);
        EXPECT_EQ(taken(store->get(world_key("k"))), (StoredBytes{7, 8}));
        EXPECT_EQ(taken(store->stand("ann", "hero"))->world, "w");
        const std::vector<StoreChange> event{AddEvent{}};
        EXPECT_TRUE(store->commit(event).ok()) << "the new version's tables are there";
    }
}

TEST(SqliteSchema, AFileOfANewerServerIsRefusedAndStaysAsItIs) {
    const ScratchFolder folder;
    const std::string file = folder.file("store.db");
    {
        SqliteDatabase database;
        taken(database.open(file, SqliteDatabase::Access::kCreate));
        taken(migrate_sqlite(database));
        taken(database.run("PRAGMA user_version = 999"));
    }
    const std::string before = text_of(file);
    const StoreError why = refusal(file);
    EXPECT_EQ(why.fault, StoreFault::kNewerSchema);
    EXPECT_NE(why.text.find("version 999"), std::string::npos) << why.text;
    EXPECT_EQ(text_of(file), before);
}

TEST(SqliteStore, IsForItsOwnerAlone) {
    const ScratchFolder folder;
    const auto store = open_file(folder.file("store.db"));
    taken(store->commit(std::vector<StoreChange>{PutRecord{world_key("k"), {1}}}));
    taken(store->backup(folder.file("copy.db")));
    for (const char* name : {"store.db", "store.db-wal", "copy.db"}) {
        using std::filesystem::perms;
        EXPECT_EQ(std::filesystem::status(folder.file(name)).permissions(),
                  perms::owner_read | perms::owner_write)
            << name;
    }
}

TEST(SqliteStore, RefusesWhatIsNoStore) {
    const ScratchFolder folder;
    const std::string noise = folder.file("noise.db");
    write_text(noise, std::string(4096, 'x'));
    EXPECT_EQ(refusal(noise).fault, StoreFault::kDamaged);
    EXPECT_EQ(text_of(noise), std::string(4096, 'x'));
    const std::string foreign = folder.file("foreign.db");
    {
        SqliteDatabase database;
        taken(database.open(foreign, SqliteDatabase::Access::kCreate));
        taken(database.run("CREATE TABLE songs (title TEXT)"));
    }
    const StoreError why = refusal(foreign);
    EXPECT_EQ(why.fault, StoreFault::kDamaged);
    EXPECT_NE(why.text.find("not a store of zoned"), std::string::npos) << why.text;
    EXPECT_NE(refusal(folder.file("no/such/folder.db")).text.find("unable to open"),
              std::string::npos);
    EXPECT_FALSE(refusal(folder.file("none.db"), StoreUse::kInspect).text.empty());
    EXPECT_FALSE(std::filesystem::exists(folder.file("none.db"))) << "inspecting makes no file";
}

TEST(SqliteStore, ChecksFindADamagedPage) {
    const ScratchFolder folder;
    const std::string file = folder.file("store.db");
    {
        const auto store = open_file(file);
        std::vector<StoreChange> changes;
        for (int i = 0; i < 500; ++i) {
            changes.emplace_back(
                PutRecord{world_key("key" + std::to_string(i)), StoredBytes(200, 9)});
        }
        taken(store->commit(changes));
    }
    std::string bytes = text_of(file);
    ASSERT_GT(bytes.size(), 16U * 4096U);
    for (std::size_t at = 12 * 4096; at < 13 * 4096; ++at) {
        bytes[at] = static_cast<char>(0x5A);
    }
    write_text(file, bytes);
    auto store = open_sqlite_store(file, Durability::kProcess, StoreUse::kInspect);
    ASSERT_TRUE(store.ok()) << store.error().text;
    const auto found = (*store)->check();
    EXPECT_TRUE(!found.ok() || !found->empty());
}

TEST(SqliteStore, ALockedFileIsAnErrorThatPasses) {
    const ScratchFolder folder;
    const std::string file = folder.file("store.db");
    const auto store = open_file(file);
    SqliteDatabase other;
    taken(other.open(file, SqliteDatabase::Access::kReadWrite));
    taken(other.run("BEGIN IMMEDIATE"));
    const std::vector<StoreChange> changes{PutRecord{world_key("k"), {1}}};
    const auto refused = store->commit(changes);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().fault, StoreFault::kBusy) << refused.error().text;
    taken(other.run("ROLLBACK"));
    taken(store->commit(changes));
    EXPECT_EQ(taken(store->get(world_key("k"))), StoredBytes{1});
}

TEST(SqliteStore, AFullDiskUndoesTheWholeCommitAndPasses) {
    const ScratchFolder folder;
    const std::string file = folder.file("store.db");
    const auto store = open_file(file);
    taken(store->commit(std::vector<StoreChange>{PutRecord{world_key("before"), {1}}}));
    const std::vector<StoreChange> large{PutRecord{world_key("small"), {1}},
                                         PutRecord{world_key("large"), StoredBytes(65536, 1)}};
    ASSERT_TRUE(limit_sqlite_pages(*store, 1));
    const auto refused = store->commit(large);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().fault, StoreFault::kFull) << refused.error().text;
    EXPECT_EQ(taken(store->get(world_key("small"))), std::nullopt);
    EXPECT_EQ(taken(store->get(world_key("before"))), StoredBytes{1});
    ASSERT_TRUE(limit_sqlite_pages(*store, 1U << 30U));
    taken(store->commit(large));
    EXPECT_EQ(taken(store->get(world_key("small"))), StoredBytes{1});
}

TEST(SqliteStore, AnErrorInTheMiddleUndoesWhatCameBeforeIt) {
    const ScratchFolder folder;
    const std::string file = folder.file("store.db");
    const auto store = open_file(file);
    SqliteDatabase other;
    taken(other.open(file, SqliteDatabase::Access::kReadWrite));
    taken(other.run("DROP TABLE event"));
    const std::vector<StoreChange> changes{PutRecord{world_key("k"), {1}}, AddEvent{}};
    EXPECT_FALSE(store->commit(changes).ok());
    EXPECT_EQ(taken(store->get(world_key("k"))), std::nullopt);
    taken(store->commit(std::vector<StoreChange>{PutRecord{world_key("k"), {2}}}));
    EXPECT_EQ(taken(store->get(world_key("k"))), StoredBytes{2});
}

TEST(SqliteStore, BacksUpWhileItIsWrittenAndComesBack) {
    const ScratchFolder folder;
    const std::string file = folder.file("store.db");
    const std::string copy = folder.file("copy.db");
    {
        const auto store = open_file(file);
        taken(store->commit(std::vector<StoreChange>{PutRecord{world_key("k"), {1}}}));
        auto reader = open_sqlite_store(file, Durability::kProcess, StoreUse::kInspect);
        ASSERT_TRUE(reader.ok()) << reader.error().text;
        taken((*reader)->backup(copy));
        EXPECT_FALSE(std::filesystem::exists(copy + "-wal"));
        EXPECT_FALSE((*reader)->backup(copy).ok()) << "a backup overwrites nothing";
        taken(store->commit(std::vector<StoreChange>{PutRecord{world_key("k"), {2}}}));
        const auto refused = restore_sqlite(copy, file);
        ASSERT_FALSE(refused.ok()) << "under a running server";
        EXPECT_NE(refused.error().text.find("stop it first"), std::string::npos)
            << refused.error().text;
        EXPECT_EQ(taken(store->get(world_key("k"))), StoredBytes{2});
    }
    const std::string kept = taken(restore_sqlite(copy, file));
    EXPECT_EQ(taken(open_file(file)->get(world_key("k"))), StoredBytes{1});
    EXPECT_EQ(taken(open_file(kept)->get(world_key("k"))), StoredBytes{2});
}

TEST(SqliteStore, RestoresNothingFromWhatIsNoBackup) {
    const ScratchFolder folder;
    const std::string file = folder.file("store.db");
    taken(open_file(file)->commit(std::vector<StoreChange>{PutRecord{world_key("k"), {1}}}));
    const std::string noise = folder.file("noise");
    write_text(noise, std::string(5000, 'x'));
    write_text(folder.file("empty"), "");
    EXPECT_FALSE(restore_sqlite(noise, file).ok());
    EXPECT_FALSE(restore_sqlite(folder.file("empty"), file).ok());
    EXPECT_FALSE(restore_sqlite(folder.file("none"), file).ok());
    EXPECT_EQ(taken(open_file(file)->get(world_key("k"))), StoredBytes{1});
    EXPECT_FALSE(std::filesystem::exists(file + ".restored"));
}

TEST(SqliteCheckpoint, MovesTheLogIntoTheFileBesideItsWriter) {
    const ScratchFolder folder;
    const std::string file = folder.file("store.db");
    const auto store = open_file(file);
    taken(
        store->commit(std::vector<StoreChange>{PutRecord{world_key("k"), StoredBytes(60000, 1)}}));
    const auto before = std::filesystem::file_size(file);
    SqliteCheckpoint checkpoint(file);
    taken(checkpoint.run());
    EXPECT_GT(std::filesystem::file_size(file), before + 50000U);
}

}  // namespace
}  // namespace zoned::store::test
