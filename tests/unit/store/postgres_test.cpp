// The store in a real PostgreSQL server: migrations, newer schemas, lost connections.
#include "server/store/postgres_store.h"
#include "server/store/store_service.h"
#include "tests/unit/store/cutting_proxy.h"
#include "tests/unit/store/postgres_server.h"
#include "tests/unit/store/store_fixture.h"

#include <pqxx/pqxx>

#include <future>

namespace zoned::store::test {
namespace {

class Postgres : public ::testing::Test {
  protected:
    void SetUp() override {
        server = PostgresServer::get();
        ASSERT_NE(server, nullptr) << "install postgresql (config/packages.txt)";
        url = server->make_database();
    }

    void run(const std::string& sql) const {
        pqxx::connection connection(url);
        pqxx::work work(connection);
        work.exec(sql);
        work.commit();
    }

    static std::unique_ptr<Store> open(const std::string& url) {
        return taken(open_postgres_store(url, true));
    }

    PostgresServer* server = nullptr;
    std::string url;
};

const std::vector<StoreChange> kNext{PutRecord{world_key("after"), {2}}, AddEvent{}};

TEST_F(Postgres, EachVersionComesToTheNextWithAllThatItHeld) {
    ASSERT_GE(postgres_schema(), 2U);
    for (std::uint32_t from = 1; from < postgres_schema(); ++from) {
        url = server->make_database();
        taken(migrate_postgres(url, from));
        run("INSERT INTO record VALUES (0, '', '', 'k', '\\x0708');"
            "INSERT INTO ban VALUES ('ann', 5, 'why');"
            "INSERT INTO account VALUES ('ann', 1, 2);"
            "INSERT INTO character VALUES ('ann', 'hero', 2, 1.0, 2.0, 3.0, 'w');"
            "INSERT INTO ticket VALUES ('\\x00112233445566778899aabbccddeeff', 9);");
        EXPECT_FALSE(open_postgres_store(url, false).ok()) << "who inspects migrates nothing";
        const auto store = open(url);
        ASSERT_NE(store, nullptr);
        const StoreCounts counts = taken(store->counts());
        EXPECT_EQ(counts.schema, postgres_schema());
        EXPECT_EQ(counts.accounts + counts.characters + counts.bans + counts.tickets, 4U);
        EXPECT_EQ(taken(store->get(world_key("k"))), (StoredBytes{7, 8}));
        EXPECT_EQ(taken(store->stand("ann", "hero"))->world, "w");
        const std::vector<StoreChange> event{AddEvent{}};
        EXPECT_TRUE(store->commit(event).ok()) << "the new version's tables are there";
    }
}

TEST_F(Postgres, ServersThatStartAtOnceMigrateOnce) {
    std::vector<std::future<bool>> starts;
    for (int i = 0; i < 4; ++i) {
        starts.push_back(
            std::async(std::launch::async, [this] { return open_postgres_store(url, true).ok(); }));
    }
    for (auto& start : starts) {
        EXPECT_TRUE(start.get());
    }
}

TEST_F(Postgres, ADatabaseOfANewerServerIsRefused) {
    open(url);
    run("INSERT INTO zoned_schema VALUES (999)");
    for (const bool migrates : {true, false}) {
        const auto refused = open_postgres_store(url, migrates);
        ASSERT_FALSE(refused.ok());
        EXPECT_EQ(refused.error().fault, StoreFault::kNewerSchema);
        EXPECT_NE(refused.error().text.find("version 999"), std::string::npos)
            << refused.error().text;
    }
}

TEST_F(Postgres, ADatabaseOfAnotherProgramStaysAsItIs) {
    run("CREATE TABLE record (song TEXT)");
    EXPECT_FALSE(open_postgres_store(url, true).ok());
    pqxx::connection connection(url);
    pqxx::work work(connection);
    EXPECT_EQ(work.exec1("SELECT count(*) FROM pg_tables WHERE schemaname = 'public'")[0].as<int>(),
              1);
}

TEST_F(Postgres, ADatabaseThatHoldsNoUtf8IsRefused) {
    const auto refused =
        open_postgres_store(server->make_database("ENCODING 'LATIN1' TEMPLATE template0"), true);
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().text.find("ENCODING 'UTF8'"), std::string::npos)
        << refused.error().text;
}

TEST_F(Postgres, CommitsAreDurableWhateverTheRolesSettingSays) {
    run("ALTER ROLE tests SET synchronous_commit = off");
    const auto store = open(url);
    run("CREATE FUNCTION note() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN"
        "  NEW.reason := current_setting('synchronous_commit'); RETURN NEW; END $$;"
        "CREATE TRIGGER note BEFORE INSERT ON ban FOR EACH ROW EXECUTE FUNCTION note()");
    taken(store->commit(std::vector<StoreChange>{PutBan{"ann", 0, ""}}));
    run("ALTER ROLE tests RESET synchronous_commit");
    EXPECT_EQ(taken(store->bans()).at(0).reason, "on");
}

TEST_F(Postgres, SaysWhenThereIsNoServer) {
    const auto refused = open_postgres_store("postgresql://tests@/x?host=/nonexistent", true);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().fault, StoreFault::kLost) << refused.error().text;
    EXPECT_NE(refused.error().text.find("store.url"), std::string::npos);
}

TEST_F(Postgres, ALockedTableIsAnErrorThatPasses) {
    const auto store = open(url);
    {
        pqxx::connection other(url);
        pqxx::work work(other);
        work.exec("LOCK TABLE record");
        const auto refused = store->commit(kNext);
        ASSERT_FALSE(refused.ok());
        EXPECT_EQ(refused.error().fault, StoreFault::kBusy) << refused.error().text;
    }
    taken(store->commit(kNext));
    EXPECT_EQ(taken(store->counts()).events, 1U);
}

TEST_F(Postgres, AnErrorInTheMiddleUndoesWhatCameBeforeIt) {
    const auto store = open(url);
    run("ALTER TABLE event RENAME TO away");
    EXPECT_FALSE(store->commit(kNext).ok());
    EXPECT_EQ(taken(store->get(world_key("after"))), std::nullopt);
    run("ALTER TABLE away RENAME TO event");
    taken(store->commit(kNext));
    EXPECT_EQ(taken(store->get(world_key("after"))), StoredBytes{2});
    EXPECT_EQ(taken(store->counts()).events, 1U);
}

TEST_F(Postgres, GoesOnAfterTheServerCameBackAndLosesNothingThatWasCommitted) {
    const auto store = open(url);
    taken(store->commit(std::vector<StoreChange>{PutRecord{world_key("before"), {1}}, AddEvent{}}));
    server->stop();
    for (int i = 0; i < 2; ++i) {
        const auto refused = store->commit(kNext);
        ASSERT_FALSE(refused.ok());
        EXPECT_EQ(refused.error().fault, StoreFault::kLost) << refused.error().text;
    }
    server->start();
    taken(store->commit(kNext));
    EXPECT_EQ(taken(store->get(world_key("before"))), StoredBytes{1});
    EXPECT_EQ(taken(store->get(world_key("after"))), StoredBytes{2});
    EXPECT_EQ(taken(store->counts()).events, 2U) << "no event twice";
}

TEST_F(Postgres, AReadOutlivesALostConnection) {
    const auto store = open(url);
    taken(store->commit(kNext));
    run("SELECT pg_terminate_backend(pid) FROM pg_stat_activity"
        " WHERE datname = current_database() AND pid <> pg_backend_pid()");
    EXPECT_EQ(taken(store->get(world_key("after"))), StoredBytes{2});
}

TEST_F(Postgres, ALineThatBreaksAtACommitNeitherLosesNorDoubles) {
    CuttingProxy proxy(server->folder());
    const auto store = open(url + "&port=5433");
    ASSERT_NE(store, nullptr);
    // As the writer does: the server may need a moment to see that the line is gone.
    const auto cut_off = [&](const std::vector<StoreChange>& changes, Cut how) {
        proxy.cut = how;
        for (int i = 0; i < 1000 && proxy.cut != Cut::kNone; ++i) {
            const auto refused = store->commit(changes);
            ASSERT_FALSE(refused.ok());
            EXPECT_TRUE(refused.error().fault == StoreFault::kLost ||
                        refused.error().fault == StoreFault::kBusy)
                << refused.error().text;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        ASSERT_EQ(proxy.cut, Cut::kNone);
    };
    const auto in_the_end = [&](const std::vector<StoreChange>& changes) {
        auto done = store->commit(changes);
        for (int i = 0; i < 1000 && !done.ok(); ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
            done = store->commit(changes);
        }
        taken(done);
    };
    std::uint64_t events = 0;
    for (const Cut first : {Cut::kBeforeCommit, Cut::kAfterCommit}) {
        std::vector<StoreChange> changes = kNext;
        cut_off(changes, first);
        // The writer tries again with what came since; that breaks too, in both ways.
        for (const Cut again : {Cut::kBeforeCommit, Cut::kAfterCommit, Cut::kBeforeCommit}) {
            changes.emplace_back(AddEvent{});
            cut_off(changes, again);
        }
        changes.emplace_back(AddEvent{});
        in_the_end(changes);
        events += 5;
        EXPECT_EQ(taken(store->counts()).events, events);
        EXPECT_EQ(taken(store->get(world_key("after"))), StoredBytes{2});
    }
    // An error after a lost answer does not forget what is there.
    cut_off(kNext, Cut::kAfterCommit);
    run("ALTER TABLE ban RENAME TO away");
    std::vector<StoreChange> more = kNext;
    more.emplace_back(PutBan{"ann", 0, ""});
    EXPECT_FALSE(store->commit(more).ok());
    run("ALTER TABLE away RENAME TO ban");
    in_the_end(more);
    events += 1;
    EXPECT_EQ(taken(store->counts()).events, events);
    // Changes that are not those of before are changes of their own.
    cut_off(kNext, Cut::kAfterCommit);
    in_the_end({AddEvent{}});
    events += 2;
    EXPECT_EQ(taken(store->counts()).events, events);
}

TEST_F(Postgres, TheWriterKeepsItsPromisesOverARestartOfTheServer) {
    std::promise<void> failing;
    bool said = false;
    StoreServiceSettings settings;
    settings.retry_s = 0.01;
    StoreService service(open(url),
                         settings,
                         {[](mailbox::StoreAnswer) {},
                          {},
                          [&](auto& text) {
                              if (!text.empty() && !std::exchange(said, true)) {
                                  failing.set_value();
                              }
                          }});
    server->stop();
    std::promise<bool> stored;
    service.submit(kNext, [&](bool done) { stored.set_value(done); });
    failing.get_future().wait();
    EXPECT_GE(service.figures().failures, 1U);
    EXPECT_NE(service.figures().failing.find("no connection"), std::string::npos)
        << service.figures().failing;
    server->start();
    EXPECT_TRUE(stored.get_future().get());
    service.stop();
    EXPECT_EQ(service.figures().lost, 0U);
    const auto store = open(url);
    EXPECT_EQ(taken(store->get(world_key("after"))), StoredBytes{2});
    EXPECT_EQ(taken(store->counts()).events, 1U);
}

}  // namespace
}  // namespace zoned::store::test
