// The duties of every kind of store, whichever it is.
#include "server/store/postgres_store.h"
#include "tests/unit/store/postgres_server.h"
#include "tests/unit/store/store_fixture.h"

#include <functional>
#include <limits>

namespace zoned::store::test {
namespace {

/// A database of one kind, which outlives its connections.
class Database {
  public:
    virtual ~Database() = default;
    virtual std::unique_ptr<Store> open() = 0;
};

class SqliteFile final : public Database {
  public:
    std::unique_ptr<Store> open() override { return open_file(folder_.file("store.db")); }

  private:
    ScratchFolder folder_;
};

class PostgresDatabase final : public Database {
  public:
    explicit PostgresDatabase(PostgresServer& server) : url_(server.make_database()) {}

    std::unique_ptr<Store> open() override { return taken(open_postgres_store(url_, true)); }

  private:
    std::string url_;
};

/// Null where PostgreSQL is not installed.
std::unique_ptr<Database> make_postgres() {
    PostgresServer* server = PostgresServer::get();
    return server == nullptr ? nullptr : std::make_unique<PostgresDatabase>(*server);
}

struct Kind {
    const char* name;
    std::function<std::unique_ptr<Database>()> make;
};

class AnyStore : public ::testing::TestWithParam<Kind> {
  protected:
    void SetUp() override {
        database = GetParam().make();
        ASSERT_NE(database, nullptr) << "install postgresql (config/packages.txt)";
        reopen();
    }

    /// As a server does that starts anew.
    void reopen() {
        store = nullptr;
        store = database->open();
        ASSERT_NE(store, nullptr);
    }

    void commit(std::vector<StoreChange> changes) const {
        const auto done = store->commit(changes);
        ASSERT_TRUE(done.ok()) << done.error().text;
    }

    std::unique_ptr<Database> database;
    std::unique_ptr<Store> store;
};

TEST_P(AnyStore, GivesBackWhatWasPutAfterItWasOpenedAnew) {
    const StoredBytes odd{0, 255, 10, 0, 39, 92};
    commit({PutRecord{world_key("season"), odd},
            PutRecord{account_key("ann", "gold"), {1}},
            PutRecord{character_key("ann", "hero", "bag"), StoredBytes(65536, 7)},
            PutRecord{character_key("ann", "h\xC3\xA4lper", "bag"), {}}});
    reopen();
    EXPECT_EQ(taken(store->get(world_key("season"))), odd);
    EXPECT_EQ(taken(store->get(account_key("ann", "gold"))), StoredBytes{1});
    EXPECT_EQ(taken(store->get(character_key("ann", "hero", "bag"))), StoredBytes(65536, 7));
    EXPECT_EQ(taken(store->get(character_key("ann", "h\xC3\xA4lper", "bag"))), StoredBytes());
}

TEST_P(AnyStore, KeepsScopesAndOwnersApart) {
    commit({PutRecord{account_key("ann", "k"), {1}},
            PutRecord{account_key("bob", "k"), {2}},
            PutRecord{character_key("ann", "x", "k"), {3}},
            PutRecord{world_key("k"), {4}}});
    commit({RemoveRecord{account_key("ann", "k")}});
    EXPECT_EQ(taken(store->get(account_key("ann", "k"))), std::nullopt);
    EXPECT_EQ(taken(store->get(account_key("bob", "k"))), StoredBytes{2});
    EXPECT_EQ(taken(store->get(character_key("ann", "x", "k"))), StoredBytes{3});
    EXPECT_EQ(taken(store->get(world_key("k"))), StoredBytes{4});
    EXPECT_EQ(taken(store->get(account_key("Bob", "k"))), std::nullopt) << "names have cases";
}

TEST_P(AnyStore, ListsAndForgetsTheRecordsOfOneAccountAlone) {
    const std::vector<PutRecord> of_ann{{account_key("ann", "gold"), {1}},
                                        {character_key("ann", "a", "bag"), {2, 0}},
                                        {character_key("ann", "b", "bag"), {}}};
    commit({of_ann[2], of_ann[0], of_ann[1]});
    commit({PutRecord{account_key("anna", "gold"), {4}}, PutRecord{world_key("ann"), {5}}});
    reopen();
    EXPECT_EQ(taken(store->records("ann")), of_ann);
    EXPECT_EQ(taken(store->records("")), std::vector<PutRecord>());
    commit({ForgetRecords{"ann"}, of_ann[0]});
    EXPECT_EQ(taken(store->records("ann")), std::vector<PutRecord>{of_ann[0]});
    EXPECT_EQ(taken(store->records("anna")).size(), 1U);
    EXPECT_EQ(taken(store->get(world_key("ann"))), StoredBytes{5});
}

TEST_P(AnyStore, TheLastOfTwoChangesInACommitCounts) {
    commit({PutRecord{world_key("k"), {1}},
            PutRecord{world_key("k"), {2}},
            PutRecord{world_key("gone"), {1}},
            RemoveRecord{world_key("gone")}});
    EXPECT_EQ(taken(store->get(world_key("k"))), StoredBytes{2});
    EXPECT_EQ(taken(store->get(world_key("gone"))), std::nullopt);
}

TEST_P(AnyStore, KnowsWhereACharacterStoodOnceItLoggedIn) {
    commit({PutStand{"ann", "hero", {{1, 2, 3}, "w1"}}});
    EXPECT_EQ(taken(store->stand("ann", "hero")), std::nullopt) << "nobody of that name logged in";
    commit({NoteLogin{"ann", "hero", 100}, NoteLogin{"ann", "hero", 200}});
    EXPECT_EQ(taken(store->stand("ann", "hero")), std::nullopt);
    commit({PutStand{"ann", "hero", {{-1.5, 2e6, 0.1}, "w2"}}});
    reopen();
    const auto place = taken(store->stand("ann", "hero"));
    ASSERT_TRUE(place);
    EXPECT_EQ(place->position_m, (std::array<double, 3>{-1.5, 2e6, 0.1}));
    EXPECT_EQ(place->world, "w2");
    const StoreCounts counts = taken(store->counts());
    EXPECT_EQ(counts.accounts, 1U);
    EXPECT_EQ(counts.characters, 1U);
}

TEST_P(AnyStore, KeepsBans) {
    commit({PutBan{"bob", 0, "cheats"}, PutBan{"ann", 5, ""}, PutBan{"ann", 77, "spam"}});
    commit({PutBan{"eve", 1, ""}, RemoveBan{"eve"}, RemoveBan{"nobody"}});
    reopen();
    const std::vector<PutBan> bans = taken(store->bans());
    ASSERT_EQ(bans.size(), 2U);
    EXPECT_EQ(bans[0].account, "ann");
    EXPECT_EQ(bans[0].until_unix_s, 77);
    EXPECT_EQ(bans[0].reason, "spam");
    EXPECT_EQ(bans[1].account, "bob");
}

TEST_P(AnyStore, RemembersTicketsUntilTheyExpire) {
    UseTicket early{{1, 0, 255}, 100};
    UseTicket late{{2}, 200};
    commit({early, late, late});
    reopen();
    EXPECT_EQ(taken(store->tickets(0)).size(), 2U);
    const auto left = taken(store->tickets(100));
    ASSERT_EQ(left.size(), 1U);
    EXPECT_EQ(left[0].nonce, late.nonce);
    EXPECT_EQ(left[0].expires_s, 200);
    commit({ForgetTickets{100}});
    EXPECT_EQ(taken(store->counts()).tickets, 1U);
}

TEST_P(AnyStore, ListsEventsInTheOrderOfTheirCommits) {
    for (int i = 0; i < 5; ++i) {
        AddEvent event;
        event.unix_ms = 1000 + i;
        event.tick = 10 * i;
        event.zone = 65535;
        event.kind = static_cast<std::uint16_t>(16 + i);
        event.account = i % 2 == 0 ? "ann" : "";
        event.topic = i % 2 == 0 ? "" : "world";
        event.payload = {static_cast<std::uint8_t>(i), 0};
        commit({event});
    }
    reopen();
    const auto all = taken(store->events("", 3));
    ASSERT_EQ(all.size(), 3U);
    EXPECT_EQ(all[0].tick, 20);
    EXPECT_EQ(all[2].tick, 40);
    EXPECT_LT(all[0].number, all[1].number);
    EXPECT_EQ(all[1].topic, "world");
    EXPECT_EQ(all[2].payload, (StoredBytes{4, 0}));
    EXPECT_EQ(all[2].zone, 65535);
    const auto of_ann = taken(store->events("ann", 10));
    ASSERT_EQ(of_ann.size(), 3U);
    EXPECT_EQ(of_ann[1].kind, 18);
}

TEST_P(AnyStore, CountsAndFindsItselfWhole) {
    commit({PutRecord{world_key("k"), {1}}, PutBan{"a", 0, ""}});
    const StoreCounts counts = taken(store->counts());
    EXPECT_GE(counts.schema, 2U);
    EXPECT_EQ(counts.records, 1U);
    EXPECT_EQ(counts.bans, 1U);
    EXPECT_EQ(taken(store->check()), std::vector<std::string>());
}

TEST_P(AnyStore, TakesAnEmptyCommit) {
    commit({});
    EXPECT_EQ(taken(store->counts()).records, 0U);
}

TEST_P(AnyStore, TextThatIsNoUtf8HoldsNothingUp) {
    AddEvent event;
    event.topic = std::string("a\0b\xFF", 4);
    commit({event, PutBan{"ann", 0, "\x80"}, PutRecord{world_key("k"), {1}}});
    EXPECT_EQ(taken(store->counts()).events, 1U);
    EXPECT_EQ(taken(store->get(world_key("k"))), StoredBytes{1});
}

TEST_P(AnyStore, RefusesNothingOfTheNumbersThatItsFieldsHold) {
    constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
    AddEvent event;
    event.unix_ms = kMost;
    event.kind = 65535;
    event.account = "ann";
    commit({NoteLogin{"ann", "hero", kMost},
            PutStand{"ann", "hero", {{1.0 / 3.0, -1e-300, 1e300}, "w"}},
            PutBan{"ann", kMost, "it's \\ \"quoted\"; -- %"},
            UseTicket{{}, kMost},
            event});
    reopen();
    EXPECT_EQ(taken(store->stand("ann", "hero"))->position_m,
              (std::array<double, 3>{1.0 / 3.0, -1e-300, 1e300}));
    EXPECT_EQ(taken(store->bans()).at(0).until_unix_s, kMost);
    EXPECT_EQ(taken(store->bans()).at(0).reason, "it's \\ \"quoted\"; -- %");
    EXPECT_EQ(taken(store->tickets(kMost - 1)).size(), 1U);
    EXPECT_EQ(taken(store->events("ann", 1)).at(0).unix_ms, kMost);
}

TEST_P(AnyStore, ALaterLoginKeepsWhereTheCharacterStood) {
    commit({NoteLogin{"ann", "hero", 1},
            PutStand{"ann", "hero", {{1, 2, 3}, "w"}},
            NoteLogin{"ann", "other", 2},
            NoteLogin{"ann", "hero", 3}});
    EXPECT_EQ(taken(store->stand("ann", "hero"))->world, "w");
    EXPECT_EQ(taken(store->stand("ann", "other")), std::nullopt);
    EXPECT_EQ(taken(store->counts()).characters, 2U);
}

INSTANTIATE_TEST_SUITE_P(Kinds,
                         AnyStore,
                         ::testing::Values(Kind{"Sqlite",
                                                [] {
                                                    return std::make_unique<SqliteFile>();
                                                }},
                                           Kind{"Postgresql", &make_postgres}),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace zoned::store::test
