// The server's store: accounts, characters, bans and tickets over crashes, backups and replays.
#include "server/store/sqlite_database.h"
#include "tests/integration/process/admin_fixture.h"
#include "tests/integration/process/player.h"

#include <csignal>
#include <filesystem>

namespace zoned::testing_process {
namespace {

class Stored : public Admin {
  protected:
    void SetUp() override {
        base = scratch_folder() + "/login";
        std::filesystem::remove_all(scratch_folder());
        std::filesystem::create_directories(scratch_folder());
        Child keygen("zoned", {"keygen", base});
        ASSERT_EQ(keygen.wait(kPatience), 0) << keygen.errors();
        world = scratch_folder() + "/world.txtpb";
        // Within reach of each place where players appear.
        std::ofstream out(world);
        out << read(minimal());
        for (const char* at : {"x_m: 1.2 z_m: 0", "x_m: 6.2 z_m: 0", "x_m: 1.2 z_m: 5"}) {
            out << "entity { type: \"crate\" " << at << " }\n";
        }
        out << "rules { name: \"pickup_kg\" value: \"50\" }\n";
    }

    void start(std::vector<std::string> more = {}) {
        more.insert(more.end(),
                    {"--set",
                     "session.dev_mode_loopback=false",
                     "--set",
                     "session.ticket_public_key_file=\"" + base + ".pub\""});
        serve(more, world);
    }

    /// As a power cut takes a process.
    void kill() {
        server->signal(SIGKILL);
        EXPECT_EQ(server->wait(kPatience), 128 + SIGKILL);
    }

    std::string ticket(const std::string& account) {
        const std::string file = base + std::to_string(++tickets) + ".ticket";
        Child made("zoned",
                   {"ticket", "--key", base + ".key", "--account", account, "--out", file});
        EXPECT_EQ(made.wait(kPatience), 0) << made.errors();
        return read(file);
    }

    std::unique_ptr<Player> enter(const std::string& with) const {
        auto player = std::make_unique<Player>(tcp_port, "name", with);
        player->join(kPatience);
        return player;
    }

    /// Tries all that may lie there until something is in the inventory.
    static bool pick_something_up(Player& player) {
        for (std::uint32_t entity = 1; entity < 30; ++entity) {
            player.pick_up(entity);
            if (player.run_until([&] { return player.inventory.items_size() > 0; }, 0.1)) {
                return true;
            }
        }
        return player.run_until([&] { return player.inventory.items_size() > 0; }, 2.0);
    }

    int zoned(const std::vector<std::string>& arguments) {
        Child child("zoned", arguments);
        const int code = child.wait(kPatience);
        said = child.output();
        complained = child.errors();
        return code;
    }

    std::string base;
    std::string world;
    int tickets = 0;
};

TEST_F(Stored, AKilledServerKeepsWhatItAcknowledged) {
    start({"--set", "recording.file=\"" + scratch_folder() + "/first.zrec\""});
    {
        const auto ann = enter(ticket("ann"));
        ASSERT_NE(ann->avatar, 0U) << ann->trouble() << server->errors();
        ASSERT_TRUE(pick_something_up(*ann)) << ann->trouble() << server->errors();
        kill();
    }
    start({"--set", "recording.file=\"" + scratch_folder() + "/second.zrec\""});
    {
        const auto ann = enter(ticket("ann"));
        EXPECT_TRUE(ann->run_until([&] { return ann->inventory.items_size() == 1; }, kPatience))
            << "the item is gone";
        const auto bob = enter(ticket("bob"));
        EXPECT_FALSE(bob->run_until([&] { return bob->inventory.items_size() > 0; }, 1.0))
            << "it is not his";
        // Leaving and coming back in the same run is the same.
        ann->quit();
        ann->run_until([] { return false; }, 0.5);
        const auto again = enter(ticket("ann"));
        EXPECT_TRUE(
            again->run_until([&] { return again->inventory.items_size() == 1; }, kPatience));
    }
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0) << server->errors();
    // The answers of the store are in the recording: a replay has the same hashes without one.
    std::filesystem::rename(scratch_folder() + "/store.db", scratch_folder() + "/away.db");
    EXPECT_EQ(zoned({"replay", scratch_folder() + "/second.zrec"}), 0) << said << complained;
    // The killed server's recording has no end mark, which is told; it agrees all the same.
    EXPECT_EQ(zoned({"replay", scratch_folder() + "/first.zrec"}), 1);
    expect_said({"every hash agrees"});
    EXPECT_FALSE(std::filesystem::exists(scratch_folder() + "/store.db"));
}

TEST_F(Stored, ATicketOpensOneSessionAcrossACrash) {
    start();
    const std::string used = ticket("ann");
    ASSERT_NE(enter(used)->avatar, 0U);
    kill();
    start();
    const auto again = enter(used);
    EXPECT_EQ(again->avatar, 0U);
    EXPECT_NE(again->trouble().find("used before"), std::string::npos) << again->trouble();
    EXPECT_NE(enter(ticket("ann"))->avatar, 0U) << "a new one does";
}

TEST_F(Stored, ABanOutlivesACrash) {
    start();
    EXPECT_EQ(ctl({"ban", "ann", "--reason", "no bots"}), 0) << complained;
    EXPECT_EQ(ctl({"ban", "eve"}), 0) << complained;
    EXPECT_EQ(ctl({"unban", "eve"}), 0) << complained;
    kill();
    start();
    const auto ann = enter(ticket("ann"));
    EXPECT_EQ(ann->avatar, 0U);
    EXPECT_NE(ann->trouble().find("banned: no bots"), std::string::npos) << ann->trouble();
    EXPECT_NE(enter(ticket("eve"))->avatar, 0U);
}

TEST_F(Stored, ACharacterIsInTheWorldOnce) {
    start();
    const auto first = enter(ticket("ann"));
    ASSERT_NE(first->avatar, 0U);
    const auto second = enter(ticket("ann"));
    EXPECT_NE(second->avatar, 0U);
    EXPECT_FALSE(first->run_until([] { return false; }, 5.0));
    EXPECT_NE(first->trouble().find("logged in elsewhere"), std::string::npos) << first->trouble();
}

TEST_F(Stored, BacksUpWhileItRunsChecksAndRestores) {
    const std::string copy = scratch_folder() + "/copy.db";
    start();
    EXPECT_EQ(ctl({"ban", "ann"}), 0) << complained;
    EXPECT_EQ(zoned({"backup", "--state", scratch_folder(), copy}), 0) << complained;
    EXPECT_EQ(zoned({"backup", "--state", scratch_folder(), copy}), 3) << "overwrites nothing";
    EXPECT_EQ(ctl({"ban", "bob"}), 0) << complained;
    EXPECT_EQ(zoned({"restore", "--state", scratch_folder(), copy}), 3);
    EXPECT_NE(complained.find("stop it first"), std::string::npos) << complained;
    EXPECT_EQ(zoned({"store", "check", "--state", scratch_folder()}), 0) << complained;
    expect_said({"bans        2", "schema      2", "whole"});
    kill();
    EXPECT_EQ(zoned({"restore", "--state", scratch_folder(), copy}), 0) << complained;
    EXPECT_EQ(zoned({"store", "check", "--state", scratch_folder()}), 0) << complained;
    expect_said({"bans        1"});
    start();
    EXPECT_EQ(enter(ticket("ann"))->avatar, 0U);
    EXPECT_NE(enter(ticket("bob"))->avatar, 0U);
    EXPECT_EQ(zoned({"store", "check", "--file", scratch_folder() + "/none.db"}), 3);
    EXPECT_NE(complained.find("there is no store"), std::string::npos) << complained;
}

TEST_F(Stored, KeepsItsDurableEventsAndSaysHowTheStoreFares) {
    start();
    const auto ann = enter(ticket("ann"));
    ASSERT_TRUE(pick_something_up(*ann)) << ann->trouble() << server->errors();
    EXPECT_EQ(zoned({"store", "events", "--state", scratch_folder(), "--account", "ann"}), 0)
        << complained;
    expect_said({"ann", "zone 1"});
    const std::string metrics = ask("/metrics");
    EXPECT_GT(number_after(metrics, "\nzoned_store_commits_total "), 0) << metrics;
    EXPECT_EQ(number_after(metrics, "\nzoned_store_failing "), 0);
    EXPECT_EQ(number_after(metrics, "\nzoned_store_events_waiting "), 0);
}

TEST_F(Stored, GoesOnWhileTheStoreIsLockedAndAcknowledgesNothingMeanwhile) {
    start();
    const auto ann = enter(ticket("ann"));
    ASSERT_NE(ann->avatar, 0U) << ann->trouble();
    store::SqliteDatabase other;
    ASSERT_TRUE(
        other.open(scratch_folder() + "/store.db", store::SqliteDatabase::Access::kReadWrite).ok());
    ASSERT_TRUE(other.run("BEGIN IMMEDIATE").ok());
    EXPECT_FALSE(pick_something_up(*ann)) << "its acknowledgement must wait";
    const int before = number_after(ask("/metrics"), "\nzoned_ticks_total ");
    EXPECT_TRUE(ann->run_until(
        [&] { return number_after(ask("/metrics"), "\nzoned_store_failing ") == 1; }, kPatience));
    EXPECT_GT(number_after(ask("/metrics"), "\nzoned_store_events_waiting "), 0);
    EXPECT_TRUE(ann->run_until(
        [&] { return number_after(ask("/metrics"), "\nzoned_ticks_total ") > before; }, kPatience));
    EXPECT_NE(server->errors().find("the store fails, the server goes on"), std::string::npos)
        << server->errors();
    EXPECT_EQ(ctl({"ban", "bob"}), 3) << "an operator need not wait for it";
    EXPECT_NE(complained.find("a restart may forget it"), std::string::npos) << complained;
    ASSERT_TRUE(other.run("ROLLBACK").ok());
    other.close();
    EXPECT_TRUE(ann->run_until([&] { return ann->inventory.items_size() > 0; }, kPatience));
    kill();
    start();
    const auto again = enter(ticket("ann"));
    EXPECT_TRUE(again->run_until([&] { return again->inventory.items_size() > 0; }, kPatience));
    EXPECT_EQ(enter(ticket("bob"))->avatar, 0U) << "the ban was stored as well";
}

TEST_F(Stored, DoesNotStartOnAFileThatIsNoStore) {
    std::ofstream(scratch_folder() + "/store.db") << std::string(5000, 'x');
    Child server_on_noise("zoned", {"serve", "--config", minimal(), "--set", state_set()});
    EXPECT_EQ(server_on_noise.wait(kPatience), 3);
    EXPECT_NE(server_on_noise.errors().find("zoned restore"), std::string::npos)
        << server_on_noise.errors();
}

TEST_F(Stored, WithoutAStoreItServesAndSaysWhatIsForgotten) {
    start({"--set", "store.kind=STORE_NONE"});
    EXPECT_NE(server->errors().find("a restart forgets"), std::string::npos) << server->errors();
    const auto ann = enter(ticket("ann"));
    EXPECT_TRUE(pick_something_up(*ann)) << ann->trouble();
    EXPECT_EQ(ctl({"ban", "bob"}), 3) << "an operator must hear that it does not last";
    EXPECT_NE(complained.find("STORE_NONE"), std::string::npos) << complained;
    EXPECT_FALSE(std::filesystem::exists(scratch_folder() + "/store.db"));
}

}  // namespace
}  // namespace zoned::testing_process
